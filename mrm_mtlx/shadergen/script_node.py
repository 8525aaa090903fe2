"""OSL for the Script node of Blender: self-contained, and its sockets are what an artist may change of the material.

What the document does not set is a constant of the source. What Cycles does not have where OSL looks for it comes as
inputs: `u` and `v` are barycentric there, and `dPdu` lies along an edge of a triangle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from mrm_mtlx.shadergen.generate import GenerationError
from mrm_mtlx.shadergen.osl_parameters import Parameter, joined, split
from mrm_mtlx.shadergen.self_contained import self_contained
from mrm_mtlx.shadergen.sockets import Exposed, Socket, exposed

if TYPE_CHECKING:
    from mrm_mtlx.shadergen.generate import Shader

# Vector inputs that stand for what the renderer does not give, and what they are called.
UV, TANGENT = "mrm_uv", "mrm_tangent"

# The frame of the surface at the head of the body, and the names of it for what MaterialX writes.
_FRAME = f"""\
    vector mrm_along = normalize(dot({TANGENT}, {TANGENT}) > 0.0 ? {TANGENT} : vector(dPdu));
    vector mrm_across = normalize(cross(N, mrm_along));
"""
_AXES = {"normalize(dPdu)": "mrm_along", "normalize(dPdv)": "mrm_across"}


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
    head, parameters, body = split(with_texture_coordinates(self_contained(shader).sources["pixel"]))
    if UV in head:
        msg = "a definition of the document looks up texture coordinates itself; give them to it as an input"
        raise GenerationError(msg)
    own = {each.parameter.name for each in found}
    constants = [p.local for p in parameters if not p.output and p.name not in own and p.name != UV]
    inputs = [parameter for each in found for parameter in _inputs(each)]
    uv = UV if any(parameter.name == UV for parameter in parameters) else ""
    tangent = TANGENT if any(axis in body for axis in _AXES) else ""
    inputs += [_unset(name, label) for name, label in ((uv, "UV"), (tangent, "Tangent")) if name]
    for axis, name in _AXES.items():
        body = body.replace(axis, name)
    output = [replace(p, metadata='string label = "Surface"') for p in parameters if p.output]
    locals_ = "".join([*constants, *(_assembled(each) for each in found), _FRAME if tangent else ""])
    source = joined(head, inputs + output, locals_ + body)
    sockets = tuple(socket for each in found for socket in each.sockets)
    return ScriptNode(replace(shader, sources={"pixel": source}), sockets, uv, tangent)


def with_texture_coordinates(source: str) -> str:
    """Generated OSL whose texture coordinates are the input `UV`, and whose images are upside down.

    MaterialX has v grow upward, the texture lookup of Cycles downward.
    """
    source = source.replace("    return texcoord;", "    return vector2(texcoord.x, 1.0 - texcoord.y);")
    looked_up = {"vector2(u,v)": f"vector2({UV}[0],{UV}[1])", "vector(u,v,0)": f"vector({UV}[0],{UV}[1],0)"}
    if not any(old in source for old in looked_up):
        return source
    for old, new in looked_up.items():
        source = source.replace(old, new)
    head, parameters, body = split(source)
    return joined(head, [*parameters[:-1], _unset(UV, "UV"), parameters[-1]], body)


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


def _unset(name: str, label: str) -> Parameter:
    """A vector that a link gives, and that has no value to be shown."""
    return Parameter(name, "vector", "vector(0.0)", metadata=f'string label = "{label}", string widget = "null"')


def _quoted(text: str) -> str:
    """A text as a string of OSL."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
