"""The materials, as the tool that built the extension has described them."""

import json
import tomllib
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).parent
DATA = FOLDER / "data"


class ProblemError(Exception):
    """Something that the user can be told in a sentence; operators report it."""


@cache
def materials():
    """All materials: dictionaries with `name`, `label`, `doc`, `by_day` (linear RGB) and `sockets`."""
    return tuple(json.loads((DATA / "materials.json").read_text(encoding="utf-8")))


def find(name):
    """The material of a name."""
    for described in materials():
        if described["name"] == name:
            return described
    raise ProblemError(f"There is no material '{name}' in this extension")


@cache
def version():
    """The version of the extension."""
    return tomllib.loads((FOLDER / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]


def script(name):
    """The OSL of a material."""
    return (DATA / "scripts" / f"{name}.osl").read_text(encoding="utf-8")


def network(name):
    """The file with the USD network of a material."""
    return DATA / "networks" / f"{name}.usda"


def preview(name):
    """The file with the picture of a material."""
    return FOLDER / "previews" / f"{name}.png"
