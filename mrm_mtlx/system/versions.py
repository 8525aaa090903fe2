"""Versions of what a verdict depends on."""

from __future__ import annotations

from importlib import metadata

from mrm_mtlx import __version__


def versions() -> dict[str, str]:
    """Versions of what a verdict depends on."""
    names = {
        "materialx": "MaterialX",
        "numpy": "numpy",
        "openimageio": "OpenImageIO",
        "moderngl": "moderngl",
        "usd": "usd-core",
    }
    return {"mrm": __version__, **{key: metadata.version(name) for key, name in names.items()}}
