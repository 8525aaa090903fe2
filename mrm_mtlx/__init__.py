"""Retroreflective materials in MaterialX: node library, reference evaluator and validator.

The layers, from top to bottom; imports run downward only:

    cli -> validation, render -> engines, reference, shadergen -> library, bsdf

`bsdf` is the optics in plain NumPy and imports nothing else; it is the place to start reading.
"""

__version__ = "0.1.0"
