"""Versions: this package's, which stands here alone, and those of what a verdict depends on."""

from __future__ import annotations

__version__ = "0.2.0"

_NAMES = {
    "materialx": "MaterialX",
    "numpy": "numpy",
    "openimageio": "OpenImageIO",
    "moderngl": "moderngl",
    "usd": "usd-core",
}


def versions() -> dict[str, str]:
    """Versions of what a verdict depends on, this package first, by the keys of reports."""
    from importlib import metadata

    return {"mrm": __version__, **{key: metadata.version(name) for key, name in _NAMES.items()}}
