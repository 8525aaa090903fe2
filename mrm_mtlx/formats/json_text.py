"""Untrusted JSON: parsed strictly, and named in messages."""

from __future__ import annotations

import codecs
import json
import math
from collections import Counter
from typing import Any

from mrm_mtlx.documents.text_positions import Position, TextPositions
from mrm_mtlx.system.text import shown

# Digits of a whole number: any with as many is one that a double can hold, and so becomes no error later.
_LONGEST_NUMBER = 308


class JsonError(ValueError):
    """A text is not the JSON that is expected; `position` says where, or is None."""

    def __init__(self, message: str, position: Position | None = None) -> None:
        super().__init__(message)
        self.position = position


def parse(content: bytes) -> dict[str, Any]:
    """The object that a file holds.

    Raises
    ------
    JsonError
        With the place, if it is no UTF-8, no JSON object of finite numbers, or says a name of an object twice.
    RecursionError
        If it is nested more deeply than Python follows, some hundred levels.
    """
    content = content.removeprefix(codecs.BOM_UTF8)
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        msg = f"byte {error.start} is not UTF-8; expected a JSON file"
        raise JsonError(msg, TextPositions(content).at(error.start)) from None
    try:
        data = json.loads(
            text, object_pairs_hook=_object, parse_constant=_constant, parse_float=_finite, parse_int=_whole
        )
    except json.JSONDecodeError as error:
        msg = f"line {error.lineno}, column {error.colno}: no JSON: {error.msg}"
        raise JsonError(msg, Position(error.lineno, error.colno)) from None
    if not isinstance(data, dict):
        msg = f"it holds {kind(data)}; expected a JSON object"
        raise JsonError(msg)
    return data


def pointer(*keys: str | int) -> str:
    """JSON pointer to what these keys lead to (RFC 6901)."""
    return "".join(f"/{str(key).replace('~', '~0').replace('/', '~1')}" for key in keys)


def kind(value: Any) -> str:
    """The kind of a value in the words of JSON, with an article."""
    names = {type(None): "null", bool: "a boolean", str: "a string", list: "an array", dict: "an object"}
    return names.get(type(value), "a number")


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = next(name for name, times in Counter(name for name, _ in pairs).items() if times > 1)
        msg = f"the name {shown(twice)} stands twice in one object"
        raise JsonError(msg)
    return found


def _constant(word: str) -> float:
    msg = f"{word} is no JSON number"
    raise JsonError(msg)


def _whole(word: str) -> int:
    if len(word.removeprefix("-")) > _LONGEST_NUMBER:
        msg = f"a number has more than {_LONGEST_NUMBER} digits"
        raise JsonError(msg)
    return int(word)


def _finite(word: str) -> float:
    if math.isinf(number := float(word)):
        msg = f"the number {shown(word)} is too large"
        raise JsonError(msg)
    return number
