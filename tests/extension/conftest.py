"""The extension as it is built here, and Blenders of their own configuration to do with it what a user does."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from mrm_mtlx.engines.osl import process
from tools.blender_extension.archive import archive
from tools.blender_extension.contents import contents

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

PROGRAM = Path(__file__).with_name("in_blender.py")
# Interpreters that have other versions of bpy, separated as paths are.
VARIABLE = "MRM_BLENDER_PYTHONS"
# Seconds, on a machine that does something else as well; Storm compiles a surface model for half a minute.
TIME_LIMIT_S = 400

Step = tuple[str, dict[str, Any]]


@dataclass(frozen=True)
class Session:
    """What the steps of a session returned, in their order, and what Blender printed."""

    answers: list[Any]
    log: str


@pytest.fixture(scope="session")
def files() -> Mapping[str, bytes]:
    """The extension's files by their names in the zip."""
    return contents()


@pytest.fixture(scope="session")
def zipped(files: Mapping[str, bytes], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The extension as a zip."""
    path = tmp_path_factory.mktemp("extension") / "mrm-blender.zip"
    path.write_bytes(archive(files))
    return path


@pytest.fixture(scope="session")
def session(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Session]:
    """Function from an interpreter and steps to what they return, in a Blender that nobody has used before."""

    def run(interpreter: str, steps: list[Step], **variables: str) -> Session:
        folder = tmp_path_factory.mktemp("blender")
        done = subprocess.run(
            [interpreter, "-I", str(PROGRAM), json.dumps(steps)],
            capture_output=True, text=True, check=False, timeout=TIME_LIMIT_S, cwd=folder,
            env={**os.environ, "HOME": str(folder), "BLENDER_USER_RESOURCES": str(folder / "user"), **variables},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr[-4000:]
        return Session(json.loads(done.stdout), done.stderr)

    return run


@pytest.fixture(scope="session")
def blender(cycles, gl) -> str:
    """The interpreter of the Blender that is at hand, where it finds an OpenGL driver."""
    found = process.RUNTIME.interpreter()
    assert found is not None
    return found


@pytest.fixture(scope="session")
def other_blenders(gl) -> list[str]:
    """Interpreters of other Blenders, as MRM_BLENDER_PYTHONS names them."""
    named = [path for path in os.environ.get(VARIABLE, "").split(os.pathsep) if path]
    if not named:
        pytest.skip(f"{VARIABLE} names no interpreters with other versions of bpy")
    return named
