"""What commands open on hostile documents, seen by the system; `python -m tools.trace_files` is the whole of it."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

# Every so many-th document: some twelve.
SHARE = 30


@pytest.fixture
def strace() -> None:
    from tools.trace_files import unavailable

    if unavailable():
        pytest.skip(unavailable())


@pytest.fixture
def laid_out(tmp_path: Path):
    from tools import hostile_documents

    (tmp_path / "scratch").mkdir()
    return hostile_documents.lay_out(tmp_path)


@pytest.mark.large
def test_no_command_opens_what_is_not_its_own(strace: None) -> None:
    from tools.trace_files import run

    documents, found = run(SHARE, ["glsl"])
    assert documents >= 10
    assert found.outside == []
    # Each command did open documents, and the trace of those that ran before validate is not empty.
    for command in ("generate", "convert", "render", "plot", "photometry", "validate"):
        assert found.counts[command, "documents"] > 0, found.table()


def test_there_are_documents_of_every_format_by_the_hundred(laid_out) -> None:
    from tools import hostile_documents

    written = hostile_documents.write_all(laid_out)
    assert {path.suffix for path in written} >= {".mtlx", ".usda", ".usdz", ".gltf", ".csv", ".alta", ".json"}
    assert len([path for path in written if path.suffix != ".glsl"]) >= 200
    assert len({path.name for path in written}) == len(written)


@pytest.mark.parametrize("name", ["../outside/secret.png", "link.png", "linked/secret.png", "{outside}/secret.png"])
def test_a_file_that_is_opened_outside_is_seen(strace: None, laid_out, tmp_path: Path, name: str) -> None:
    from tools.trace_files import Allowed, openings, traced

    path = laid_out.documents / name.format(outside=laid_out.outside)
    command = [sys.executable, "-c", f"open({str(path)!r}).close()"]
    lines = traced(command, tmp_path / "trace", tmp_path / "scratch")
    found = openings(lines, Allowed(laid_out.documents, tmp_path / "scratch"))
    assert {path for _, _, path in found.outside} == {str(laid_out.outside / "secret.png")}


def test_a_pipe_inside_and_a_file_that_was_only_not_there_are_seen(strace: None, laid_out, tmp_path: Path) -> None:
    from tools.trace_files import Allowed, openings, traced

    pipe, nowhere = laid_out.documents / "pipe.png", laid_out.outside / "nowhere.png"
    peek = f"import os; os.open({str(pipe)!r}, os.O_RDONLY | os.O_NONBLOCK)"
    command = [sys.executable, "-c", f"{peek}\ntry:\n    open({str(nowhere)!r})\nexcept OSError:\n    pass"]
    lines = traced(command, tmp_path / "trace", tmp_path / "scratch")
    found = openings(lines, Allowed(laid_out.documents, tmp_path / "scratch"))
    assert {path for _, _, path in found.outside} == {str(pipe), str(nowhere)}


def test_lines_of_a_trace_are_understood(laid_out, tmp_path: Path) -> None:
    from tools.trace_files import Allowed, openings

    inside = laid_out.documents
    lines = [
        '7 openat(AT_FDCWD</x>, "/mrm-next-command/plot/a.mtlx", O_RDONLY|O_CLOEXEC) = -1 ENOENT (No such file)',
        f'7 openat(AT_FDCWD<{inside}>, "own.png", O_RDONLY) = 3<{inside}/own.png>',
        f'8 openat(AT_FDCWD<{inside}>, "../secret\\303\\251.png", O_RDONLY <unfinished ...>',
        '7 open("/usr/lib/x.so", O_RDONLY) = 4</usr/lib/x.so>',
        "8 <... openat resumed>) = -1 ENOENT (No such file or directory)",
        f'7 openat(5<{inside}/parts>, "own.png", O_RDONLY) = 6<{inside}/parts/own.png>',
    ]
    found = openings(lines, Allowed(inside, tmp_path / "scratch"))
    assert found.outside == [("plot", "a.mtlx", os.path.normpath(inside / "../secret\u00e9.png"))]
    assert (found.counts["plot", "documents"], found.counts["plot", "system"]) == (2, 1)
