"""What the engine says of itself, and what the tests do with it."""

from __future__ import annotations

import os
import sys

import pytest

from mrm_mtlx.engines.gl import availability

# GLVND then finds no driver at all.
WITHOUT_DRIVER = {"__EGL_VENDOR_LIBRARY_FILENAMES": os.devnull}


def test_a_working_engine_names_its_renderer_and_needs_no_remedy(gl):
    assert gl is availability()
    assert "OpenGL " in gl.detail
    assert gl.remedy == ""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only the loader of Linux is told to find no driver")
def test_without_a_driver_the_engine_says_why_and_what_to_do(python):
    code = "from mrm_mtlx.engines.gl import availability as a; print(a().available, a().detail, a().remedy, sep='\\n')"
    run = python("-c", code, **WITHOUT_DRIVER)
    assert run.returncode == 0, run.stderr
    available, detail, *remedy = run.stdout.strip().split("\n")
    assert available == "False"
    assert detail.startswith("no OpenGL 4.3 context could be made: ")
    assert "apt-get install" in remedy[-1]


@pytest.fixture
def outcome_of_a_gl_test(python, repository):
    """Function from variables to what pytest says of the one test above that asks for the engine."""
    options = ["-q", "-n", "0", "-p", "no:cacheprovider", "-rfEs", "--rootdir", str(repository)]
    one = f"{__file__}::test_a_working_engine_names_its_renderer_and_needs_no_remedy"
    return lambda **variables: python("-m", "pytest", *options, one, **variables).stdout


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only the loader of Linux is told to find no driver")
def test_an_absent_engine_is_skipped_with_its_reason_unless_it_is_expected(outcome_of_a_gl_test):
    skipped = outcome_of_a_gl_test(MRM_EXPECT_GL="", **WITHOUT_DRIVER)
    assert "1 skipped" in skipped
    assert "OpenGL engine not available: no OpenGL 4.3 context" in skipped
    failed = outcome_of_a_gl_test(MRM_EXPECT_GL="llvmpipe", **WITHOUT_DRIVER)
    assert "1 error" in failed
    assert "MRM_EXPECT_GL asks for 'llvmpipe'" in failed


def test_another_engine_than_the_expected_one_fails(gl, outcome_of_a_gl_test):
    failed = outcome_of_a_gl_test(MRM_EXPECT_GL="a driver that does not exist")
    assert "1 error" in failed
    assert "MRM_EXPECT_GL asks for 'a driver that does not exist', found: " in failed
