"""Where values of a JSON text begin: each is found where a search of the text finds its own name."""

from __future__ import annotations

import json
import random
from itertools import count

import pytest

from mrm_mtlx.formats import json_text
from mrm_mtlx.formats.json_positions import JsonPositions, Place
from mrm_mtlx.formats.json_text import JsonError, pointer


def anything(rng: random.Random, numbers: count, depth: int = 0) -> object:
    """A value all of whose names, and values of arrays, occur once in it."""
    kinds = ["text", "number", "word"] + ["object", "array"] * (3 - depth)
    match rng.choice(kinds) if depth else "object":
        case "object":
            names = (
                f"{rng.choice(['', '~', '/', 'ä', '🚧', chr(92), chr(34)])}k{next(numbers)}."
                for _ in range(rng.randrange(4))
            )
            return {name: anything(rng, numbers, depth + 1) for name in names}
        case "array":
            return [f"v{next(numbers)}. ]}}," for _ in range(rng.randrange(4))]
        case "text":
            return '[{"\\ä" :,]}' * rng.randrange(3)
        case "number":
            return rng.choice([0, -1.5e300, 123456789])
    return rng.choice([None, True, False])


def marks(value: object, *keys: str | int) -> dict[str, str]:
    """By the pointers of all that have one: what the text has only there."""
    found = {}
    if isinstance(value, dict):
        for name, child in value.items():
            found[pointer(*keys, name)] = name
            found |= marks(child, *keys, name)
    if isinstance(value, list):
        found |= {pointer(*keys, index): child for index, child in enumerate(value)}
    return found


def stands(text: str, mark: str, *, ascii_only: bool) -> tuple[int, int]:
    written = json.dumps(mark, ensure_ascii=ascii_only)
    assert text.count(written) == 1
    lines = text[: text.index(written)].split("\n")
    return len(lines), len(lines[-1]) + 1


@pytest.mark.parametrize("ascii_only", [True, False])
@pytest.mark.parametrize("indent", [None, 0, 2, "\t"])
@pytest.mark.parametrize("seed", range(10))
def test_every_value_is_found_where_its_name_is(seed, indent, ascii_only):
    value = anything(random.Random(seed), count())
    text = json.dumps(value, indent=indent, ensure_ascii=ascii_only)
    positions = JsonPositions(text.encode())
    for at, mark in marks(value).items():
        assert positions.nearest(at) == Place(at, stands(text, mark, ascii_only=ascii_only))
        # Of what is not there, its nearest parent.
        assert positions.nearest(f"{at}/absent/0") == positions.nearest(at)


def test_line_ends_and_space_around_everything():
    text = '\r\n\t{\r\n "a"\r\n:\r\n[ 1 ,\r\n"x"\r\n] ,"b" : { } }\r\n'
    positions = JsonPositions(text.encode())
    found = {at: positions.nearest(at) for at in ("", "/a", "/a/0", "/a/1", "/b")}
    expected = {"": (2, 2), "/a": (3, 2), "/a/0": (5, 3), "/a/1": (6, 1), "/b": (7, 4)}
    assert found == {at: Place(at, position) for at, position in expected.items()}


@pytest.mark.parametrize("wanted", ["/a/1", "/a/01", "/a/-1", "/a/x", "/a/0/0", "/b", "x", "/", "//", "/A"])
def test_a_pointer_that_leads_nowhere_leads_to_what_is_around(wanted):
    found = JsonPositions(b'{\n "a": [\n  7]}').nearest(wanted)
    assert found.pointer in ("", "/a", "/a/0")
    assert wanted.startswith(found.pointer)


def test_what_is_deep_or_large_is_passed_over(monkeypatch):
    deep = '{"a": ' + "[" * 400 + "]" * 400 + ', "b": [' + "1," * 200_000 + "2]}"
    json_text.parse(deep.encode())
    positions = JsonPositions(deep.encode())
    assert positions.nearest("/b/200000") == Place("/b/200000", (1, deep.rindex("2") + 1))
    decoded = []
    monkeypatch.setattr("mrm_mtlx.formats.json_positions.JSONDecoder", lambda: decoded.append(1) or json.JSONDecoder())
    assert positions.nearest("/b/7").position == (1, deep.index("1,") + 15)
    assert not decoded  # what was looked into once is known


@pytest.mark.parametrize(
    ("content", "position"),
    [
        (b'{"a": 1,\n "b" 2}', (2, 6)),
        ('{"ä":\n "ä" x}'.encode(), (2, 6)),
        (b'{"a":\n\xff}', (2, 1)),
        ("\ufeff{,}".encode(), (1, 2)),
        (b'{"a": 1, "a": 2}', None),
        (b"[]", None),
    ],
)
def test_what_is_no_json_is_named_with_its_place(content, position):
    with pytest.raises(JsonError) as raised:
        json_text.parse(content)
    assert raised.value.position == position
