"""Compilers that are commands: what they say is told, and also that they do not run, do not end or say nothing."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest

from mrm_mtlx.engines import commands, glslang
from mrm_mtlx.engines.base import CompileError, EngineFailure

if TYPE_CHECKING:
    from collections.abc import Callable

SOURCE = "first\nsecond\n"


@pytest.fixture
def command(tmp_path, monkeypatch) -> Callable[[str, str], None]:
    """Function that puts a shell script on the path under a name."""
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")

    def write(name: str, script: str) -> None:
        (tmp_path / name).write_text(script, encoding="utf-8")
        (tmp_path / name).chmod(0o755)

    return write


def refused(name: str) -> str:
    with pytest.raises(CompileError) as error:
        commands.compile_file([name], SOURCE, "a.txt")
    (message,) = error.value.messages
    return str(message)


def test_the_first_error_is_told_with_its_line_and_without_the_folder(command):
    command("compiler", '#!/bin/sh\ncat "$1" > /dev/null || exit 0\necho "ERROR: $PWD/$1:2: not good"\nexit 1\n')
    assert refused("compiler") == "not good at line 2: second"


def test_a_line_that_the_source_has_not_is_no_place(command):
    command("compiler", '#!/bin/sh\necho "error: $1:7: beyond"\nexit 1\n')
    assert refused("compiler") == "error: a.txt:7: beyond"


def test_a_compiler_that_takes_the_source_is_silent(command):
    command("compiler", "#!/bin/sh\necho a warning\n")
    commands.compile_file(["compiler"], SOURCE, "a.txt")


def test_one_that_fails_and_says_nothing_has_a_message_all_the_same(command):
    command("compiler", "#!/bin/sh\nexit 3\n")
    assert refused("compiler") == "compiler failed with exit status 3 and said nothing"


def test_one_that_does_not_end_has_failed_itself(command, monkeypatch):
    command("compiler", "#!/bin/sh\nexec sleep 60\n")
    monkeypatch.setattr(commands, "TIMEOUT_S", 0.2)
    with pytest.raises(EngineFailure, match=r"compiler did not finish within 0\.2 s"):
        commands.compile_file(["compiler"], SOURCE, "a.txt")


def test_one_that_is_found_and_does_not_run_is_not_available(command):
    for name in ("glslangValidator", "compiler"):
        command(name, "#!/nowhere/sh\n")
    assert not commands.works("glslangValidator", "--version")
    assert not glslang.ENGINE.availability().available
    with pytest.raises(EngineFailure, match="does not run"):
        commands.compile_file(["compiler"], SOURCE, "a.txt")
