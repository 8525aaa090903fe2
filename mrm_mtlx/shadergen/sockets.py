"""What an artist may change of a material: the inputs that its document sets, by their names there."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from mrm_mtlx.shadergen.osl_parameters import Parameter, split
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from mrm_mtlx.shadergen.generate import Shader

# Types of the document, and of sockets. Text, files, matrices and colours with alpha have none: they stay as they are.
_TYPES = {
    "float": "float",
    "integer": "integer",
    "boolean": "boolean",
    "color3": "color",
    "vector3": "vector",
    "vector2": "float",
}
# Minimum, maximum, soft minimum and soft maximum of a socket.
Limits: TypeAlias = tuple[float | None, float | None, float | None, float | None]
_NO_LIMITS: Limits = (None, None, None, None)

# Groups of definitions whose nodes are the working of a pattern: their inputs mean something to who has made it.
_WORKING = {"math", "adjustment", "channel", "conditional"}


@dataclass(frozen=True)
class Socket:
    """An input of a material that an artist may change.

    Attributes
    ----------
    name
        The parameter of the OSL shader, which is the identifier of a Script node's socket; unique.
    label
        What it is called within its group; unique there. The input's own `uiname`, its definition's, or its name.
    title
        What it is called where there are no groups; unique.
    group
        The panel that it belongs to: its `uifolder`, or the name of its node. The sockets of a group follow each other.
    type
        "float", "integer", "boolean", "color" (linear RGB) or "vector".
    default
        The document's value, as the shader has it: a number, a bool, or three numbers.
    minimum, maximum
        Hard limits of a "float" or "integer", or None; of the others None.
    soft_minimum, soft_maximum
        The ends of a slider; the hard limits where the definition has no others.
    doc
        A sentence about it, for a tooltip; "" if there is none.
    """

    name: str
    label: str
    title: str
    group: str
    type: str
    default: float | bool | tuple[float, ...]
    minimum: float | None = None
    maximum: float | None = None
    soft_minimum: float | None = None
    soft_maximum: float | None = None
    doc: str = ""

    def to_json(self) -> dict[str, Any]:
        """The socket as plain data, with the keys of its attributes."""
        return asdict(self)


@dataclass(frozen=True)
class Exposed:
    """A parameter of a shader and the sockets that it is made of.

    One, of its own type; two for the components of a vector2; or one for both of them: the widths of a lobe that is the
    same in all directions.
    """

    parameter: Parameter
    sockets: tuple[Socket, ...]


def exposed(element: Any, shader: Shader) -> list[Exposed]:
    """The parameters of generated OSL whose values the element's document sets, with their sockets, group by group.

    Inputs that the document leaves to their definitions are none, nor are text, files and matrices. Those of arithmetic
    are if the document gives them a `uiname`.
    """
    document = element.getDocument()
    own = {str(child.getName()) for child in document.getChildren()}
    parameters = {parameter.name: parameter for parameter in split(shader.sources["pixel"])[1]}
    found = []
    for port in shader.uniforms:
        given = document.getDescendant(port.path) if port.path.split("/")[0] in own else None
        if given is not None and given.getCategory() == "input" and _has_meaning(given) and port.type in _TYPES:
            parameter = parameters[port.variable]
            found.append(Exposed(parameter, tuple(_sockets(parameter, port.type, given))))
    groups = list(dict.fromkeys(each.sockets[0].group for each in found))
    return _named(sorted(found, key=lambda each: groups.index(each.sockets[0].group)))


def _sockets(parameter: Parameter, kind: str, given: Any) -> Iterator[Socket]:
    """The sockets of an input; labels and titles may be those of others too."""
    declared = _declared(given)
    label = _text(given, declared, "uiname") or _spelt(str(given.getName()))
    folder = _text(given, declared, "uifolder")
    group = folder or _spelt(str(given.getParent().getName()))
    title = label if folder else f"{group}: {label}"
    doc = _text(given, declared, "doc")
    numbers = _numbers(parameter.value)

    def number(suffix: str, called: str, component: int) -> Socket:
        names = (f"{parameter.name}{suffix}", f"{label}{called}", f"{title}{called}")
        return Socket(*names, group, "float", numbers[component], *_limits(given, declared, component), doc)

    if kind == "vector2":
        if str(given.getParent().getType()) == "BSDF" and numbers[0] == numbers[1]:
            yield number("_xy", "", 0)
        else:
            yield from (number(f"_{axis}", f" {axis.upper()}", component) for component, axis in enumerate("xy"))
    elif kind == "float":
        yield number("", "", 0)
    else:
        values = {"boolean": bool(numbers[0]), "integer": int(numbers[0])}
        limits = _limits(given, declared, 0) if kind == "integer" else _NO_LIMITS
        yield Socket(parameter.name, label, title, group, _TYPES[kind], values.get(kind, numbers), *limits, doc)


def _numbers(value: str) -> tuple[float, ...]:
    """The numbers of a parameter's value, such as `color(0.1, 0.2, 0.3)`, `{0.1, 0.2}` or `1`."""
    return tuple(float(word) for word in re.sub(r"^\w+\(|[(){}]", "", value).split(","))


def _has_meaning(given: Any) -> bool:
    """True for an input whose name says what it is for: it has one of its own, or is none of arithmetic."""
    definition = _definition(given.getParent())
    return given.hasAttribute("uiname") or definition is None or definition.getNodeGroup() not in _WORKING


def _definition(owner: Any) -> Any:
    """The definition of a node or a graph, or None."""
    return owner.getNodeDef() if hasattr(owner, "getNodeDef") else None


def _declared(given: Any) -> Any:
    """The definition's input of a node's; None where there is none."""
    definition = _definition(given.getParent())
    return None if definition is None else definition.getActiveInput(given.getName())


def _text(given: Any, declared: Any, attribute: str) -> str:
    """An attribute of an input, or of its definition's."""
    said = given.getAttribute(attribute) or ("" if declared is None else declared.getAttribute(attribute))
    return " ".join(printable(str(said)).split())


def _spelt(name: str) -> str:
    """A name of an element as words: "bead_core" is "Bead core"."""
    words = name.replace("_", " ").strip()
    return words[:1].upper() + words[1:]


def _limits(given: Any, declared: Any, component: int) -> Limits:
    """Limits of a component of an input."""

    def limit(attribute: str) -> float | None:
        words = _text(given, declared, attribute).split(",")
        try:
            return float(words[component if component < len(words) else 0])
        except ValueError:
            return None

    minimum, maximum, low, high = (limit(name) for name in ("uimin", "uimax", "uisoftmin", "uisoftmax"))
    return minimum, maximum, minimum if low is None else low, maximum if high is None else high


def _named(found: Sequence[Exposed]) -> list[Exposed]:
    """The same with titles that are unique, and labels that are unique in their groups."""
    titles: Counter[str] = Counter()
    labels: Counter[tuple[str, str]] = Counter()

    def named(socket: Socket) -> Socket:
        titles[socket.title] += 1
        labels[socket.group, socket.label] += 1
        title = _numbered(socket.title, titles[socket.title])
        return replace(socket, title=title, label=_numbered(socket.label, labels[socket.group, socket.label]))

    return [replace(each, sockets=tuple(named(socket) for socket in each.sockets)) for each in found]


def _numbered(name: str, number: int) -> str:
    """A name, with a number from the second time on."""
    return name if number == 1 else f"{name} ({number})"
