"""Ways to check documents: in a process of its own with bounds, and with a changed node library."""

from __future__ import annotations

import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

import MaterialX as mx
import pytest

from mrm_mtlx.library import DataLibrary, Origin, node_library_folder

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

# Address space of a bounded check [bytes]. The interpreter with its libraries and a graphics driver maps 1.5 GiB; a
# document that is expanded without bound passes any limit.
MEMORY_LIMIT = 4 * 2**30
# Seconds after which a bounded check counts as endless; it takes two or three.
TIME_LIMIT_S = 120

_LIMITED = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[1]),) * 2)
except ImportError:  # not POSIX: the time limit remains
    pass
from mrm_mtlx.cli.main import run
sys.argv[:2] = ["mrm"]
run()
"""


@pytest.fixture(scope="session")
def bounded() -> Callable[..., subprocess.CompletedProcess[str]]:
    """Function from arguments of `mrm` to the finished process, whose memory and time are bounded."""

    def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", _LIMITED, str(MEMORY_LIMIT), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT_S, check=False)

    return run


@pytest.fixture
def changed_library(tmp_path: Path) -> Callable[[str, str, str], tuple[DataLibrary, Path]]:
    """Function from a change to a file below pbrlib to a copy of the node library that has it, and the copy's folder.

    It is loaded as ours is: before the standard one.
    """

    def change(file: str, old: str, new: str) -> tuple[DataLibrary, Path]:
        folder = tmp_path / "libraries"
        shutil.copytree(node_library_folder(), folder)
        path = folder / "pbrlib" / file
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")
        document, search_path = mx.createDocument(), mx.getDefaultDataSearchPath()
        ours = mx.FileSearchPath(str(folder))
        mx.loadLibraries(["pbrlib"], ours, document)
        search_path.append(ours)
        mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
        return DataLibrary(Origin.MRM, document, search_path), folder

    return change
