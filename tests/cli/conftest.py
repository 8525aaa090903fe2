"""The real command, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest
from typer.testing import CliRunner

from mrm_mtlx.cli.main import app

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from typer.testing import Result

# Seconds after which a command counts as hung; the longest here takes about ten.
TIME_LIMIT_S = 180


@pytest.fixture(scope="session")
def documents(repository: Path) -> Path:
    """Folder with a pair of documents per rule."""
    return repository / "tests" / "documents"


@pytest.fixture(scope="session")
def command() -> list[str]:
    """What starts `mrm` here, whether or not its script is on the PATH."""
    return [sys.executable, "-m", "mrm_mtlx.cli.main"]


@pytest.fixture(scope="session")
def environment() -> dict[str, str]:
    """This process's environment without what would change how the command prints."""
    plain = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "FORCE_COLOR", "COLUMNS")}
    return {**plain, "PYTHONUTF8": "1"}


@pytest.fixture
def mrm(
    command: list[str], environment: dict[str, str], tmp_path: Path
) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Function from arguments to the finished command, run in the test's folder; no traceback ever reaches a user."""

    def run(*arguments: object, cwd: Path | None = None, **variables: str) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            [*command, *map(str, arguments)],
            capture_output=True,
            text=True,
            encoding="utf-8",
            cwd=cwd or tmp_path,
            env={**environment, **variables},
            timeout=TIME_LIMIT_S,
            check=False,
        )
        assert "Traceback" not in done.stderr, done.stderr
        assert "internal error" not in done.stderr, done.stderr
        return done

    return run


@pytest.fixture
def metal(documents: Path, tmp_path: Path) -> Path:
    """A document without fault in the test's folder, by its name there."""
    path = tmp_path / "metal.mtlx"
    path.write_bytes((documents / "READ_XML" / "passes.mtlx").read_bytes())
    return path


@pytest.fixture
def in_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """Function from a command and its arguments to the finished command, run in this process and the test's folder.

    It saves a second per call; what a process of its own adds is tested with one call of each command through `mrm`.
    """
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> Result:
        done = CliRunner().invoke(app, [str(a) for a in arguments], prog_name="mrm")
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
        return done

    return run
