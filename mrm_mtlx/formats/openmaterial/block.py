"""The block `retroreflectivityData` of ASAM OpenMATERIAL 3D 1.0.0 in a file of JSON.

The block has one number for all of a material's retroreflection, "in the visible light spectrum":

    coefficientOfRetroreflection    number, cd/(lx m^2), 0 to 5000
    sources                         string, separated by commas

It has no angles, while R_A depends on two. So the angles stand in `sources`, with the illuminant and the tool, and are
read back from there. A file is looked through for the block; a new one holds nothing else.
"""

from __future__ import annotations

import json
import re
from copy import deepcopy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from mrm_mtlx.formats import json_text
from mrm_mtlx.formats.json_text import kind
from mrm_mtlx.system.text import printable, shown

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


BLOCK = "retroreflectivityData"
COEFFICIENT, SOURCES = "coefficientOfRetroreflection", "sources"
# Range of the coefficient, by the standard [cd/(lx m^2)].
SMALLEST, LARGEST = 0.0, 5000.0
# Largest file that is read: descriptions of materials have some kilobytes, with tables a few megabytes.
MAXIMUM_BYTES = 16 * 2**20
# Objects within objects that are read; those of a material are a handful.
MAXIMUM_DEPTH = 100

_NUMBER = r"([-+]?\d+(?:\.\d+)?)"
_OBSERVATION = re.compile(rf"\bobservation angle {_NUMBER} deg\b")
_ENTRANCE = re.compile(rf"\bentrance angle {_NUMBER} deg\b")


class Geometry(NamedTuple):
    """Angles in one plane: of l and v, and of l and n, positive toward v [degrees].

    The default is the first row of sheeting standards.
    """

    observation_deg: float = 0.2
    entrance_deg: float = -4.0


@dataclass(frozen=True)
class RetroreflectivityData:
    """The block.

    Attributes
    ----------
    coefficient
        R_A [cd/(lx m^2)], 0 to 5000.
    sources
        Where it comes from, parts separated by commas.
    """

    coefficient: float
    sources: str

    @property
    def geometry(self) -> Geometry | None:
        """Angles as the sources state them, None if they state none or more than one."""
        observation, entrance = _OBSERVATION.findall(self.sources), _ENTRANCE.findall(self.sources)
        if len(observation) != 1 or len(entrance) != 1:
            return None
        return Geometry(float(observation[0]), float(entrance[0]))


class OpenMaterialFile(NamedTuple):
    """A file: all of its data, the JSON pointer of the block, and the block; None for none."""

    data: dict[str, Any]
    pointer: str | None
    block: RetroreflectivityData | None


def load(path: Path) -> OpenMaterialFile:
    """Read an untrusted file.

    Raises
    ------
    ValueError
        With the name of the file and the place, if it is no regular file or larger than `MAXIMUM_BYTES`, no JSON object
        of finite numbers, nested too deeply, says a name twice, or if its block is not as the standard has it.
    OSError
        If it cannot be opened.
    """
    try:
        data = _parse(path)
        pointers = list(_pointers(data))
        if len(pointers) > 1:
            msg = f"{BLOCK} stands there twice, at {shown(pointers[0][0])} and {shown(pointers[1][0])}; expected one"
            raise ValueError(msg)
        if not pointers:
            return OpenMaterialFile(data, None, None)
        ((pointer, block),) = pointers
        return OpenMaterialFile(data, pointer, _checked(block, pointer))
    except (ValueError, RecursionError) as error:
        what = _TOO_DEEP if isinstance(error, RecursionError) else str(error)
        msg = f"{path.name}: {printable(what)}"
        raise ValueError(msg) from None


def merged(file: OpenMaterialFile | None, block: RetroreflectivityData, at: str = "") -> dict[str, Any]:
    """The data of a file with the block put in, a new object.

    A block that is there gets the new values where it stands, and keeps what else it holds; else the block is put into
    the object `at`, a JSON pointer, "" being the whole file. Everything else stays as it was.

    Raises
    ------
    ValueError
        If there is no object `at`.
    """
    data: dict[str, Any] = {} if file is None else deepcopy(file.data)
    if file is not None and file.pointer is not None:
        target = _object_at(data, file.pointer)
    else:
        target = _object_at(data, at).setdefault(BLOCK, {})
    target |= {COEFFICIENT: block.coefficient, SOURCES: block.sources}
    return data


def as_json(data: dict[str, Any]) -> bytes:
    """The content of a file, as UTF-8."""
    try:
        text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False).encode()
    except UnicodeEncodeError:  # half of a surrogate pair has an escape in JSON, and nothing in UTF-8
        text = json.dumps(data, indent=2, allow_nan=False).encode()
    return text + b"\n"


def _parse(path: Path) -> dict[str, Any]:
    if not path.is_file():  # a pipe or a device would never end
        msg = "it does not exist, or is not a regular file"
        raise ValueError(msg)
    with path.open("rb") as stream:
        content = stream.read(MAXIMUM_BYTES + 1)
    if len(content) > MAXIMUM_BYTES:
        msg = f"larger than the {MAXIMUM_BYTES // 2**20} MiB that are read"
        raise ValueError(msg)
    return json_text.parse(content)


def _pointers(data: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Pointers to all blocks and what stands there."""
    waiting: list[tuple[str, Any, int]] = [("", data, 1)]
    while waiting:  # not by recursion, so that the bound is ours and the same everywhere
        pointer, parent, depth = waiting.pop()
        if depth > MAXIMUM_DEPTH:
            raise ValueError(_TOO_DEEP)
        named = parent.items() if isinstance(parent, dict) else enumerate(parent)
        for key, child in named:
            place = pointer + json_text.pointer(key)
            if key == BLOCK:
                yield place, child
            if isinstance(child, dict | list):
                waiting.append((place, child, depth + 1))


_TOO_DEEP = f"nested more than {MAXIMUM_DEPTH} deep, which is not read"


def _checked(block: Any, pointer: str) -> RetroreflectivityData:
    place = shown(pointer, "")
    if not isinstance(block, dict):
        msg = f"{place}: expected an object, got {kind(block)}"
        raise ValueError(msg)
    for name in (COEFFICIENT, SOURCES):
        if name not in block:
            msg = f"{place}: '{name}' is missing"
            raise ValueError(msg)
    value, sources = block[COEFFICIENT], block[SOURCES]
    if isinstance(value, bool) or not isinstance(value, int | float):
        msg = f"{place}/{COEFFICIENT}: expected a number, got {kind(value)}"
        raise ValueError(msg)
    if not SMALLEST <= value <= LARGEST:
        msg = f"{place}/{COEFFICIENT}: expected {SMALLEST:g} to {LARGEST:g} cd/(lx m^2), got {shown(str(value), '')}"
        raise ValueError(msg)
    if not isinstance(sources, str):
        msg = f"{place}/{SOURCES}: expected a string, got {kind(sources)}"
        raise ValueError(msg)
    return RetroreflectivityData(float(value), sources)


def _object_at(data: dict[str, Any], pointer: str) -> dict[str, Any]:
    """The object that a JSON pointer leads to (RFC 6901)."""
    value: Any = data
    for part in pointer.split("/")[1:] if pointer.startswith("/") else [pointer] if pointer else []:
        key = part.replace("~1", "/").replace("~0", "~")
        if isinstance(value, list):
            value = dict(zip(map(str, range(len(value))), value, strict=True)).get(key)
        else:
            value = value.get(key) if isinstance(value, dict) and pointer.startswith("/") else None
    if not isinstance(value, dict):
        msg = f"there is no object at {shown(pointer)}; expected a JSON pointer to one, as /parent"
        raise ValueError(msg)
    return value
