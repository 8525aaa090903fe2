"""OSL for the Script node of Blender: self-contained, and its sockets are what an artist may change of the material.

What the document does not set is a constant of the source. What Cycles does not have where OSL looks for it comes as
inputs: `u` and `v` are barycentric there, and `dPdu` lies along an edge of a triangle.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from mrm_mtlx.shadergen.generate import GenerationError
from mrm_mtlx.shadergen.osl_parameters import Parameter, joined, split
from mrm_mtlx.shadergen.self_contained import self_contained
from mrm_mtlx.shadergen.sockets import Exposed, Socket, exposed

if TYPE_CHECKING:
    from mrm_mtlx.shadergen.generate import Shader

# Vector inputs for what the renderer does not give, and what they are called.
UV, TANGENT = "mrm_uv", "mrm_tangent"
_LABELS = {UV: "UV", TANGENT: "Tangent"}

# What MaterialX writes for texture coordinates and for the axes of the surface, and what stands for it.
_COORDINATES = {"vector2(u,v)": f"vector2({UV}[0],{UV}[1])", "vector(u,v,0)": f"vector({UV}[0],{UV}[1],0)"}
_AXIS = re.compile(r"\bdPd([uv])\b")
_FRAME = f"""\
    vector mrm_along_u = dot({TANGENT}, {TANGENT}) > 0.0 ? {TANGENT} : vector(dPdu);
    vector mrm_along_v = cross(N, mrm_along_u);
"""


@dataclass(frozen=True)
class ScriptNode:
    """A shader for a Script node.

    Attributes
    ----------
    shader
        The shader with its source; the rest of it is that of the generated one.
    sockets
        What an artist may change, group by group, in the order of the node's sockets. After them come:
    uv
        the name of the vector input for texture coordinates, as Blender's node UV Map gives them, or "" if there is
        none;
    tangent
        the name of the vector input for the tangent along u in world space, as Blender's node Tangent gives it, or "".
        Where it is zero, as without a link, an edge of the triangle takes its place.
    """

    shader: Shader
    sockets: tuple[Socket, ...]
    uv: str
    tangent: str

    def to_json(self) -> dict[str, Any]:
        """The node as plain data: "source", "uv", "tangent" and "sockets", a list of objects."""
        sockets = [socket.to_json() for socket in self.sockets]
        return {"source": self.shader.sources["pixel"], "uv": self.uv, "tangent": self.tangent, "sockets": sockets}


def script_node(element: Any, shader: Shader) -> ScriptNode:
    """The Script node of an element, made from the OSL that was generated of it.

    Raises
    ------
    GenerationError
        If the source includes what is none of MaterialX's, or a function of it needs texture coordinates that it is not
        given.
    """
    found = exposed(element, shader)
    head, parameters, body = split(with_mesh_inputs(self_contained(shader).sources["pixel"]))
    if UV in head:
        msg = "a definition of the document looks up texture coordinates itself; give them to it as an input"
        raise GenerationError(msg)
    own = {each.parameter.name for each in found}
    mesh = [replace(p, metadata=_of_the_mesh(p.name)) for p in parameters if p.name in _LABELS]
    output = [replace(p, metadata='string label = "Surface"') for p in parameters if p.output]
    constants = [p.local for p in parameters if not p.output and p.name not in own and p.name not in _LABELS]
    inputs = [parameter for each in found for parameter in _inputs(each)]
    variables = "".join([*constants, *(_assembled(each) for each in found)])
    source = joined(head, inputs + mesh + output, variables + body)
    sockets = tuple(socket for each in found for socket in each.sockets)
    uv, tangent = (name if any(p.name == name for p in mesh) else "" for name in (UV, TANGENT))
    return ScriptNode(replace(shader, sources={"pixel": source}), sockets, uv, tangent)


def with_mesh_inputs(source: str) -> str:
    """Generated OSL with inputs for what Cycles has of a mesh elsewhere: `UV` and `TANGENT`, where it needs them.

    Images are turned upside down: MaterialX has v grow upward, the texture lookup of Cycles downward.
    """
    source = source.replace("    return texcoord;", "    return vector2(texcoord.x, 1.0 - texcoord.y);")
    wanted = [UV] if any(old in source for old in _COORDINATES) else []
    if not wanted and not _AXIS.search(source):
        return source
    for old, new in _COORDINATES.items():
        source = source.replace(old, new)
    head, parameters, body = split(source)
    if _AXIS.search(body):
        wanted.append(TANGENT)
        body = _FRAME + _AXIS.sub(r"mrm_along_\1", body)
    inputs = [Parameter(name, "vector", "vector(0.0)") for name in wanted]
    return joined(head, [*parameters[:-1], *inputs, parameters[-1]], body)


def _inputs(each: Exposed) -> list[Parameter]:
    """The parameters of an input's sockets, in the place of its own."""
    whole = each.parameter
    return [
        replace(
            whole if socket.name == whole.name else Parameter(socket.name, "float", repr(socket.default)),
            metadata=_metadata(socket),
        )
        for socket in each.sockets
    ]


def _assembled(each: Exposed) -> str:
    """The variable that has the place of an input's own parameter, where its sockets are parts of it."""
    names = [socket.name for socket in each.sockets]
    if names == [each.parameter.name]:
        return ""
    return replace(each.parameter, value=f"{{{names[0]}, {names[-1]}}}").local


def _metadata(socket: Socket) -> str:
    """What a host is to know of a socket, in the words of the OSL specification, of which Blender takes the label.

    A boolean is a number: Blender 5.0 dies of a Script node's check box that is linked to an input of its group.
    """
    texts = {"label": socket.title, "page": socket.group, "help": socket.doc}
    numbers = {"min": socket.minimum, "max": socket.maximum}
    number = "int" if socket.type == "integer" else "float"
    said = [f"string {name} = {_quoted(text)}" for name, text in texts.items() if text]
    said += [f"{number} {name} = {limit:.9g}" for name, limit in numbers.items() if limit is not None]
    return ", ".join(said)


def _of_the_mesh(name: str) -> str:
    """Metadata of a vector that a link gives, and that has no value to be shown."""
    return f'string label = "{_LABELS[name]}", string widget = "null"'


def _quoted(text: str) -> str:
    """A text as a string of OSL."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
