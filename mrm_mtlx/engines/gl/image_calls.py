"""The image lookups of generated code: address modes, filter and default of each file.

The functions of image nodes take all of these as arguments and use none: setting up the sampler is left to the host.
MaterialX's own hosts guess by the names of uniforms, which misses what a graph decides (latlongimage mirrors at the
poles) or names otherwise (wrapS of UsdUVTexture). Here the calls are followed instead, from `main` down.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.images import ADDRESS_MODES, FILTER_TYPES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from mrm_mtlx.shadergen import Shader


@dataclass(frozen=True)
class Sampling:
    """The lookup of an image.

    Attributes
    ----------
    u, v
        One of `ADDRESS_MODES` each.
    filter
        One of `FILTER_TYPES`.
    default
        What lies beyond the border in mode "constant" and stands for a missing image; as many numbers as `components`,
        before the transform of the file's colour space.
    components
        Of the node that reads the image.
    read
        The most components of all nodes that read it.
    """

    u: str = "periodic"
    v: str = "periodic"
    filter: str = "linear"
    default: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    components: int = 4
    read: int = 4


# The host's images of the environment, as generated code names them.
ENVIRONMENT = ("u_envRadiance", "u_envIrradiance")

# Components of the types that image functions give.
_COMPONENTS = {"float": 1, "vec2": 2, "vec3": 3, "vec4": 4}

_FUNCTION = re.compile(r"^void (\w+)\(([^)]*)\)\s*\{(.*?)^\}", re.MULTILINE | re.DOTALL)
_NUMBER = r"[-+]?[\d.]+(?:e[-+]?\d+)?"
_NUMBERS = re.compile(rf"(?:vec\d)?\(?({_NUMBER}(?:, {_NUMBER})*)\)?")

# What the generator calls the number that it was given, and the same after the transform to linear colour.
_GIVEN, _TRANSFORMED = "_cm_in", "_cm_out"


def samplings(shader: Shader) -> dict[str, Sampling]:
    """The lookup of each file uniform of a GLSL shader, by variable name; of several, the first.

    The host's images of the environment are not among them; some versions of MaterialX have them in unlit shaders too.
    """
    functions = {m[1]: _Function(*_parameters(m[2]), m[3]) for m in _FUNCTION.finditer(shader.sources["pixel"])}
    files = [port.variable for port in shader.uniforms if port.type == "filename" and port.variable not in ENVIRONMENT]
    known = {port.variable: port.value for port in shader.uniforms if port.type != "filename"}
    found: dict[str, Sampling] = {}
    for file, sampling in _lookups("main", functions, known | {name: _File(name) for name in files}, set()):
        first = found.setdefault(file, sampling)
        found[file] = replace(first, read=max(first.read, sampling.read))
    return {name: found.get(name, Sampling()) for name in files}


@dataclass(frozen=True)
class _Function:
    """A function of the source: types and names of its parameters, and its text."""

    types: tuple[str, ...]
    names: tuple[str, ...]
    body: str


@dataclass(frozen=True)
class _File:
    """The value of a sampler variable: the uniform that it is."""

    variable: str


def _lookups(
    name: str, functions: Mapping[str, _Function], known: Mapping[str, Any], seen: set[tuple[Any, ...]]
) -> Iterator[tuple[str, Sampling]]:
    """Files that a function looks up, itself or through others, given the values of its parameters that are known.

    Calls in `seen`, the called function with the values, are passed over: graphs in graphs may make very many.
    """
    body = functions[name].body
    for call in re.finditer(r"^\s*(\w+)\(", body, re.MULTILINE):
        called = functions.get(call[1])
        if called is None:
            continue
        values = [_value(text, known) for text in _arguments(body, call.end())]
        file = next((value for value in values if isinstance(value, _File)), None)
        if file is None or (call[1], *values) in seen:
            continue
        seen.add((call[1], *values))
        given = dict(zip(called.names, values, strict=False))
        if "defaultval" in given or "default_value" in given:
            yield file.variable, _sampling(called, given)
        else:
            yield from _lookups(call[1], functions, given, seen)


def _sampling(image: _Function, given: Mapping[str, Any]) -> Sampling:
    """The arguments of an image function; hex-tiled images have a default alone."""
    components = _COMPONENTS.get(image.types[-1], 4)
    default = given.get("defaultval", given.get("default_value"))
    numbers = default if isinstance(default, tuple) else (default,) * components
    return Sampling(
        _choice(ADDRESS_MODES, given.get("uaddressmode"), "periodic"),
        _choice(ADDRESS_MODES, given.get("vaddressmode"), "periodic"),
        _choice(FILTER_TYPES, given.get("filtertype"), "linear"),
        # A default that a node computes is known to the shader alone.
        tuple(0.0 if x is None else float(x) for x in numbers),
        components,
        components,
    )


def _choice(names: tuple[str, ...], given: Any, otherwise: str) -> str:
    """The choice that is given by its index or, where the generator met no enumeration, by its name."""
    if isinstance(given, str):
        return given if given in names else otherwise
    return names[int(given)] if given is not None and 0 <= given < len(names) else otherwise


def _parameters(text: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Types and names of a list of parameters."""
    words = [part.split() for part in text.split(",") if part.strip()]
    return tuple(w[-2] for w in words), tuple(w[-1] for w in words)


def _arguments(text: str, start: int) -> list[str]:
    """The arguments of the call whose bracket opens before `start`."""
    depth, parts = 1, [""]
    for letter in text[start:]:
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            break
        if letter == "," and depth == 1:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def _value(text: str, known: Mapping[str, Any]) -> Any:
    """The known value of an expression: that of a variable, or numbers written out; else None."""
    if text in known:
        return known[text]
    if text.endswith(_TRANSFORMED):
        return known.get(text.removesuffix(_TRANSFORMED) + _GIVEN)
    written = _NUMBERS.fullmatch(text)
    if written is None:
        return None
    numbers = tuple(float(part) for part in written[1].split(","))
    return numbers if len(numbers) > 1 else numbers[0]
