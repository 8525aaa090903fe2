"""Values of inputs: their form, and the range and unit that a definition wants."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

from mrm_mtlx.validation.checks.elements import is_connected, location
from mrm_mtlx.validation.findings import Finding, finding

if TYPE_CHECKING:
    from collections.abc import Iterator

_COMPONENTS = {"float": 1, "vector2": 2, "vector3": 3, "vector4": 4, "color3": 3, "color4": 4}
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def check_value(given: Any, declared: Any) -> Iterator[Finding]:
    """Whether a value that is given has an effect, the form of its type, and the range and unit of the definition."""
    text = given.getValueString()
    if not text or is_connected(given):
        return
    if declared.getDefaultGeomPropString():
        message = f"'{given.getName()}' is given as {text}, but taken from the geometry"
        yield finding("DOC_VALUE_IGNORED", location(given), message)
        return
    value = _parsed(given)
    if value is None:
        message = f"'{text}' is not a {given.getType()}{_form(given.getType())}"
        yield finding("DOC_INPUT_VALUE", location(given), message)
        return
    allowed = [item.strip() for item in declared.getAttribute("enum").split(",") if item.strip()]
    if given.getType() == "string" and allowed and text not in allowed and not declared.getAttribute("enumvalues"):
        message = f"'{text}' is not one of {', '.join(allowed)}"
        yield finding("DOC_INPUT_VALUE", location(given), message)
    yield from _check_range(given, declared, value)
    yield from _check_unit(given, declared)


def _check_unit(given: Any, declared: Any) -> Iterator[Finding]:
    """A unit of another type than the definition's; one that does not exist is MaterialX's own finding."""
    wanted, kind = declared.getUnitType(), given.getUnitType()
    if wanted and kind not in ("", wanted):
        message = f"'{given.getUnit()}' is a unit of {kind}, expected one of {wanted}"
        yield finding("DOC_INPUT_VALUE", location(given), message)


def _check_range(given: Any, declared: Any, value: Any) -> Iterator[Finding]:
    numbers = _numbers(value)
    for attribute, beyond, word in (("uimin", min, "below"), ("uimax", max, "above")):
        bound = _bound(declared, attribute)
        if bound is None or len(bound) != len(numbers):
            continue
        if any(beyond(number, limit) != limit for number, limit in zip(numbers, bound, strict=True)):
            limit = declared.getAttribute(attribute)
            message = f"{given.getName()} = {given.getValueString()} is {word} the definition's {attribute} of {limit}"
            yield finding("DOC_VALUE_RANGE", location(given), message)


def _parsed(given: Any) -> Any:
    """Parsed value, or None if it is not of its type; numbers that are not finite are none."""
    kind = given.getType()
    if kind in ("string", "filename", "geomname"):
        return given.getValueString()
    if kind in _COMPONENTS:
        # MaterialX takes what it understands of a number and passes over the rest: "0,5" would be 0.
        parts = given.getValueString().split(",")
        if len(parts) != _COMPONENTS[kind] or not all(_NUMBER.fullmatch(part.strip()) for part in parts):
            return None
    try:
        value = given.getValue()
    except Exception:  # MaterialX throws several unrelated types
        return None
    return value if value is None or all(math.isfinite(x) for x in _numbers(value)) else None


def _numbers(value: Any) -> list[float]:
    if isinstance(value, bool | str):
        return []
    if isinstance(value, int | float):
        return [float(value)]
    return [float(x) for x in value.asTuple()] if hasattr(value, "asTuple") else []


def _bound(declared: Any, attribute: str) -> list[float] | None:
    text = declared.getAttribute(attribute)
    try:
        bound = [float(part) for part in text.split(",")] if text else []
    except ValueError:
        return None
    return bound if bound and all(math.isfinite(x) for x in bound) else None


def _form(kind: str) -> str:
    if _COMPONENTS.get(kind, 1) > 1:
        return f" ({_COMPONENTS[kind]} numbers, separated by commas)"
    return {"boolean": " (exactly true or false)", "integer": " (a whole number)", "float": " (a finite number)"}.get(
        kind, ""
    )
