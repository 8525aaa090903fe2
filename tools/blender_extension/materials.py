"""A ready material as the Blender extension wants it: what may be changed of it, its colour by day, and its OSL."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.reference.points import ShadingPoints
from mrm_mtlx.shadergen import ScriptNode, Shader, generate, script_node
from mrm_mtlx.shadergen.sockets import exposed

if TYPE_CHECKING:
    from mrm_mtlx.api.opening import OpenDocument

_LIGHT_BY_DAY_DEG = 45.0
# Texture coordinates over which a pattern is averaged.
_PLACES = 64


def describe(opened: OpenDocument) -> dict[str, Any]:
    """A material's name, sockets, and colour by day, for `data/materials.json`.

    A socket has, beside what it is for a Script node, the attribute of the USD network that it sets, and which of the
    attribute's components (`attribute`, `components`).
    """
    element, shader, node = _generated(opened)
    paths = {port.variable: port.path for port in shader.uniforms}
    sockets = []
    for each in exposed(opened.element(element), shader):
        owner, _, name = paths[each.parameter.name].rpartition("/")
        every = list(range(2 if each.parameter.type == "vector2" else 1))
        parts = [every] if len(each.sockets) == 1 else [[component] for component in every]
        sockets += [
            {**socket.to_json(), "attribute": f"{owner}.inputs:{name}", "components": components}
            for socket, components in zip(each.sockets, parts, strict=True)
        ]
    return {
        "name": opened.path.stem,
        "label": opened.path.stem.replace("_", " ").capitalize(),
        "doc": opened.element(element).getDocString(),
        "by_day": by_day(opened),
        "uv": node.uv,
        "tangent": node.tangent,
        "sockets": sockets,
    }


def script(opened: OpenDocument) -> str:
    """The OSL of a material for a Script node."""
    return _generated(opened)[2].shader.sources["pixel"]


@cache
def _generated(opened: OpenDocument) -> tuple[str, Shader, ScriptNode]:
    """The only element of a document, its OSL, and that for a Script node."""
    (element,) = opened.elements
    shader = generate(opened.element(element), "osl", opened.library)
    return element, shader, script_node(opened.element(element), shader)


def by_day(opened: OpenDocument) -> list[float]:
    """What a material reflects of light at 45 degrees to a viewer along the normal, beside a white diffuser: RGB.

    The mean over the texture, linear Rec.709, no more than 1.
    """
    (found,) = opened.surfaces()
    angle = np.deg2rad(_LIGHT_BY_DAY_DEG)
    steps = (np.arange(_PLACES) + 0.5) / _PLACES
    texcoord = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)

    def everywhere(*vector: float) -> Any:
        return np.tile(vector, (len(texcoord), 1))

    points = ShadingPoints(
        view=everywhere(0.0, 0.0, 1.0),
        light=everywhere(np.sin(angle), 0.0, np.cos(angle)),
        normal=everywhere(0.0, 0.0, 1.0),
        tangent=everywhere(1.0, 0.0, 0.0),
        position=np.zeros((len(texcoord), 3)),
        texcoord=texcoord,
    )
    reflected = np.pi * found.surface.response(points).mean(axis=0) / np.cos(angle)
    return [round(float(value), 4) for value in np.clip(reflected, 0.0, 1.0)]
