"""Values: the form of each type, and the choices, the range and the unit that a definition wants."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.elements import is_connected, location
from mrm_mtlx.findings import rules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.findings.finding import Finding

# How many numbers a value of a type has; an array has a multiple of them.
_NUMBERS = {
    "integer": 1,
    "float": 1,
    "vector2": 2,
    "vector3": 3,
    "vector4": 4,
    "color3": 3,
    "color4": 4,
    "matrix33": 9,
    "matrix44": 16,
}
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_WHOLE = re.compile(r"[+-]?\d+")
# The least and the greatest number that shaders can hold.
_WHOLES = (-(2.0**31), 2.0**31 - 1.0)
_FLOATS = (-(2.0**128) + 2.0**104, 2.0**128 - 2.0**104)
_CLOSURES = ("BSDF", "EDF", "VDF")


def check_form(element: Any) -> Iterator[Finding]:
    """Findings on a value (of an input, an interface, a default, a token) whose form is not that of its type."""
    text = element.getAttribute("value")
    if not text or (element.isA(mx.PortElement) and is_connected(element)):
        return
    kind = element.getType()
    fault = _fault(kind, text, element.getDocument(), ())
    if fault:
        yield rules.DOC_INPUT_VALUE.at(location(element), fault)
    elif text.count(",") + 1 < _NUMBERS.get(kind, 1):
        message = f"'{text}' has spaces between its numbers, expected commas"
        yield rules.DOC_VALUE_FORM.at(location(element), message)


def check_value(given: Any, declared: Any) -> Iterator[Finding]:
    """Findings on a value of an input that has no effect, or is not what its definition wants."""
    text = given.getValueString()
    if not text or is_connected(given):
        return
    if declared.getDefaultGeomPropString():
        message = f"'{given.getName()}' is given as {text}, but taken from the geometry"
        yield rules.DOC_VALUE_IGNORED.at(location(given), message)
        return
    yield from _check_choice(given, declared)
    yield from _check_range(given, declared)
    yield from _check_unit(given, declared)


def _check_choice(given: Any, declared: Any) -> Iterator[Finding]:
    """A text that is not one of those that the definition enumerates; labels of other values are not meant."""
    allowed = _listed(declared.getAttribute("enum"))
    if given.getType() not in ("string", "stringarray") or not allowed or declared.getAttribute("enumvalues"):
        return
    text = given.getValueString()
    for choice in [text] if given.getType() == "string" else _listed(text):
        if choice not in allowed:
            yield rules.DOC_INPUT_VALUE.at(location(given), f"'{choice}' is not one of {', '.join(allowed)}")


def _listed(text: str) -> list[str]:
    return [item.strip() for item in text.split(",") if item.strip()]


def _check_unit(given: Any, declared: Any) -> Iterator[Finding]:
    """A unit of another type than the definition's; one that does not exist is MaterialX's own finding."""
    wanted, kind = declared.getUnitType(), given.getUnitType()
    if wanted and kind not in ("", wanted):
        message = f"'{given.getUnit()}' is a unit of {kind}, expected one of {wanted}"
        yield rules.DOC_INPUT_VALUE.at(location(given), message)


def _check_range(given: Any, declared: Any) -> Iterator[Finding]:
    kind = given.getType()
    if kind not in _NUMBERS:
        return
    found = _numbers(kind, given.getValueString())
    for attribute, beyond, word in (("uimin", min, "below"), ("uimax", max, "above")):
        bound = _numbers(kind, declared.getAttribute(attribute))
        if any(beyond(number, limit) != limit for number, limit in zip(found, bound, strict=False)):
            limit = declared.getAttribute(attribute)
            message = f"{given.getName()} = {given.getValueString()} is {word} the definition's {attribute} of {limit}"
            yield rules.DOC_VALUE_RANGE.at(location(given), message)


def _fault(kind: str, text: str, document: Any, inside: tuple[str, ...]) -> str:
    """The fault of a value of a type, "" if there is none; `inside` are the types that it is a member of."""
    definition = document.getTypeDef(kind)
    if kind in _CLOSURES or (definition is not None and definition.getSemantic() in ("shader", "material")):
        return f"'{text}' is given as a value, but what is of type {kind} has none and can only be connected"
    if definition is not None and definition.getMembers():
        return _fault_of_struct(definition, text, document, inside)
    base = kind.removesuffix("array")
    is_right = text in ("true", "false") if kind == "boolean" else base not in _NUMBERS or bool(_numbers(kind, text))
    article = "an" if kind.startswith("i") else "a"
    return "" if is_right else f"'{text}' is not {article} {kind}{_form(kind)}"


def _fault_of_struct(definition: Any, text: str, document: Any, inside: tuple[str, ...]) -> str:
    """As `_fault`, of a type with members: "{0.5;{1, 0, 0}}"."""
    kind, members = definition.getName(), definition.getMembers()
    if kind in inside:
        return ""  # a type that contains itself is no fault of the value
    parts = _members(text)
    if len(parts) != len(members):
        names = ";".join(member.getName() for member in members)
        return f"'{text}' is not a {kind} ({len(members)} values in braces, separated by semicolons: {{{names}}})"
    found = zip(members, parts, strict=True)
    return next((f for m, part in found if (f := _fault(m.getType(), part, document, (*inside, kind)))), "")


def _members(text: str) -> list[str]:
    """The values between the braces of a text, those in braces of their own as they are; none if it has no braces."""
    if not (text.startswith("{") and text.endswith("}") and len(text) > 1):
        return []
    parts, depth = [""], 0
    for character in text[1:-1]:
        depth += {"{": 1, "}": -1}.get(character, 0)
        if character == ";" and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts if parts[-1] else parts[:-1]


def _numbers(kind: str, text: str) -> list[float]:
    """The numbers of a value, if all are finite and there are as many as the type has; none otherwise.

    MaterialX takes what it understands of a number and passes over the rest: "0,5" would be 0. Beside commas it takes
    spaces between numbers, but in arrays.
    """
    base = kind.removesuffix("array")
    is_array = base != kind
    parts = re.split(r"\s*,\s*" if is_array else r"\s*,\s*|\s+", text.strip())
    fits = len(parts) % _NUMBERS[base] == 0 if is_array else len(parts) == _NUMBERS[base]
    form = _WHOLE if base == "integer" else _NUMBER
    if not fits or not all(form.fullmatch(part) for part in parts):
        return []
    found = [float(part) for part in parts]
    least, most = _WHOLES if base == "integer" else _FLOATS
    return found if all(least <= number <= most for number in found) else []


def _form(kind: str) -> str:
    if _NUMBERS.get(kind, 1) > 1:
        return f" ({_NUMBERS[kind]} numbers, separated by commas)"
    return {"boolean": " (exactly true or false)", "integer": " (a whole number)", "float": " (a finite number)"}.get(
        kind, ""
    )
