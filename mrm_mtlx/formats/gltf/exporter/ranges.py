"""A material as glTF allows it: numbers in their ranges, and no extension that says nothing."""

from __future__ import annotations

import re
from typing import Any

from mrm_mtlx.formats.gltf import properties as gltf
from mrm_mtlx.formats.gltf.schema import problems
from mrm_mtlx.formats.pbr.placement import InexpressibleError

# What extensions do nothing without.
_WEIGHTS = {
    "KHR_materials_clearcoat": ("clearcoatFactor", "clearcoatTexture"),
    "KHR_materials_sheen": ("sheenColorFactor", "sheenColorTexture"),
    "KHR_materials_iridescence": ("iridescenceFactor", "iridescenceTexture"),
}

_LIMIT = re.compile(r"at (?:least|most) ([\d.e+-]+)")


def leave_out_idle(material: dict[str, Any]) -> None:
    """Leave out the extensions of a material that do nothing, for want of a weight."""
    extensions = material.get("extensions", {})
    for name, weights in _WEIGHTS.items():
        if name in extensions and not set(weights) & extensions[name].keys():
            del extensions[name]
    if not extensions:
        material.pop("extensions", None)


def bring_into_range(material: dict[str, Any]) -> list[tuple[str, str]]:
    """Bring the numbers of a material into glTF's ranges; return what that loses: "/input", and why.

    Raises
    ------
    InexpressibleError
        If it is not as glTF has it for another reason.
    """
    return [_limited(material, problem.location, problem.message) for problem in problems("material", material, "")]


def _limited(material: dict[str, Any], place: str, message: str) -> tuple[str, str]:
    """Set a number to the limit that a message names."""
    limit = _LIMIT.search(message)
    if limit is None:
        msg = f"{place} is not as glTF has it: {message}"
        raise InexpressibleError(msg)
    keys = place.split("/")[1:]
    parent: Any = material
    for key in keys[:-1]:
        parent = parent[int(key)] if isinstance(parent, list) else parent[key]
    last: Any = int(keys[-1]) if isinstance(parent, list) else keys[-1]
    parent[last] = float(limit[1].rstrip(","))
    return f"/{_input_at(keys, last) or place[1:]}", f"glTF: {message}; the limit is written"


def _input_at(keys: list[str], last: Any) -> str:
    """The input of gltf_pbr that the number at a place is, of a factor or of one of its components; "" for none."""
    props = [prop for prop in gltf.PROPERTIES if list(prop.factor) == keys[: len(prop.factor)]]
    of_component = [prop for prop in props if prop.components and last in prop.components]
    return next((prop.input for prop in of_component or props), "")
