"""Outputs compared, file by file, and reports item by item."""

from __future__ import annotations

import difflib
import json
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

# Added to findings on purpose: where in its file an element stands. Before, a finding had only the element's path.
PLACES = frozenset({"file", "line", "column", "pointer", "layer", "prim"})
_PLACE = re.compile(rb"^[^\n]+: (?=(?:error|warning) [A-Z]+_[A-Z_]+\b)", re.MULTILINE)
# The project's own version, in headers and in the notes of files that it writes.
_VERSION = re.compile(rb'(\bmrm(?:-mtlx)?"{0,2}:? "{0,2})\d+\.\d+\.\d+[.\w]*')
# The lists of reports whose items are compared one by one, and the keys that name an item.
_ITEMS = {"validate": ("documents", ("path",)), "conformance": ("cases", ("name", "target", "engine"))}
# Lines of a difference that are printed at most, and characters of a line.
_LINES, _COLUMNS = 30, 200


def records(files: Mapping[str, bytes], allowed: Sequence[str]) -> dict[str, bytes]:
    """Contents by file, of reports also by item, without what may differ; `allowed` names such entries of headers."""
    found: dict[str, bytes] = {}
    for name, data in files.items():
        told = _PLACE.sub(b"", data) if name.endswith(".stderr") else data
        found |= _parts(name, _VERSION.sub(rb"\1VERSION", told), allowed)
    return found


def _parts(name: str, data: bytes, allowed: Sequence[str]) -> dict[str, bytes]:
    """A file's contents under its name; of a report the header, and each item under the names of both."""
    items, keys = _ITEMS.get(name.split("/")[0], ("", ()))
    try:
        report = _without_places(json.loads(data)) if items and name.endswith(".stdout") else None
    except ValueError:  # the command did not come to print one
        report = None
    if report is None:
        return {name: data}
    for entry in allowed:
        section, _, key = entry.partition(".")
        report.get(section, {}).pop(key, None)
    found: dict[str, bytes] = {}
    for item in report[items]:
        label = f"{name} {' '.join(str(item[key]) for key in keys)}"
        found[label] = found.get(label, b"") + _pretty(item)
    report[items] = list(found)
    return {name: _pretty(report), **found}


def _pretty(value: object) -> bytes:
    return json.dumps(value, indent=1, ensure_ascii=False).encode() + b"\n"


def _without_places(value: Any) -> Any:
    """JSON without the keys that say where the element of a finding stands."""
    if isinstance(value, list):
        return [_without_places(each) for each in value]
    if not isinstance(value, dict):
        return value
    dropped = PLACES if {"code", "severity", "message"} <= value.keys() else frozenset()
    return {key: _without_places(each) for key, each in value.items() if key not in dropped}


@dataclass
class Comparison:
    """Numbers of what is equal and not, and the differences."""

    equal: int = 0
    differences: list[str] = field(default_factory=list)

    @property
    def failed(self) -> bool:
        """Whether anything differs; nothing compared proves nothing."""
        return bool(self.differences) or not self.equal

    def __str__(self) -> str:
        compared = self.equal + len(self.differences)
        return f"{compared:6} compared, {self.equal:6} equal, {len(self.differences):4} different"

    def add(self, old: Mapping[str, bytes], new: Mapping[str, bytes]) -> None:
        """Compare the records of a run."""
        for name in dict.fromkeys((*old, *new)):
            if name in old and name in new and old[name] == new[name]:
                self.equal += 1
            else:
                self.differences.append(_difference(name, old.get(name), new.get(name)))

    def extend(self, other: Comparison) -> None:
        """Add another comparison's."""
        self.equal += other.equal
        self.differences += other.differences


def _difference(name: str, old: bytes | None, new: bytes | None) -> str:
    """A unified diff, cut where it gets long."""
    if old is None or new is None:
        return f"{name}: only in the {'old' if new is None else 'new'} checkout's output"
    try:
        before, after = (data.decode().splitlines() for data in (old, new))
    except UnicodeDecodeError:
        return f"{name}: {len(old)} and {len(new)} bytes differ"
    lines = [
        line[:_COLUMNS] for line in difflib.unified_diff(before, after, f"old/{name}", f"new/{name}", n=2, lineterm="")
    ]
    cut = [f"... {len(lines) - _LINES} more lines"] if len(lines) > _LINES else []
    return "\n".join(lines[:_LINES] + cut) or f"{name}: the ends of lines differ"
