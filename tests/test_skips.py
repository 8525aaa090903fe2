"""Skips name what the machine lacks: the suite itself fails on any other."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.fixtures.skips import names_what_is_lacking

TESTS = """
import pytest

def test_of_a_driver():
    pytest.skip("OpenGL engine not available: no driver; apt-get install one")

def test_of_nothing():
    pytest.skip("not today")

@pytest.mark.skipif(True, reason="signals to processes are a matter of POSIX")
def test_of_a_system():
    pass

@pytest.mark.xfail(reason="known")
def test_of_a_known_error():
    raise ValueError
"""


def test_a_skip_that_names_nothing_is_a_failure(repository, written):
    path = written(TESTS, "test_planted.py")
    # Not the checkout's configuration: these tests have no part in the suite.
    options = [
        "-q",
        "-p",
        "tests.fixtures.skips",
        "-p",
        "no:cacheprovider",
        "-c",
        "/dev/null",
        "--rootdir",
        path.parent,
    ]
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *map(str, options), str(path)],
        cwd=repository, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert "1 failed, 2 skipped, 1 xfailed" in run.stdout
    assert "says nothing that this machine lacks: Skipped: not today" in run.stdout


@pytest.mark.parametrize(
    "reason",
    [
        "the folder 'shared' is not beside the repository",
        "not written yet",
        "takes too long",
        "PIP_CONSTRAINT is not set",
    ],
)
def test_what_is_no_matter_of_the_machine_is_no_reason(reason):
    assert not names_what_is_lacking(reason)


@pytest.mark.parametrize("engine", ["OpenGL engine", "OSL runtime", "Storm"])
def test_an_engine_that_is_not_there_is_a_reason(engine):
    assert names_what_is_lacking(f"Skipped: {engine} not available: nothing answers; install it")
