"""The command itself: what it prints and imports before it does anything, and how it takes wrong calls."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from mrm_mtlx import __version__

COMMANDS = (
    "validate", "conformance", "generate", "render", "plot", "photometry", "fit", "convert", "vectors", "rules",
    "doctor", "library",
)  # fmt: skip

# Packages that take a tenth of a second and more to import, or need a driver.
HEAVY = ("MaterialX", "numpy", "rich", "moderngl", "OpenImageIO", "pebble", "slangpy", "scipy", "matplotlib", "pxr")


def test_the_version_is_that_of_the_package(mrm_here, repository):
    done = mrm_here("--version")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"mrm {__version__}\n", "")
    project = tomllib.loads((repository / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["dynamic"] == ["version"]  # read from the package: tests/test_wheel.py builds it


def test_the_installed_script_is_the_same_command(environment):
    script = shutil.which("mrm", path=str(Path(sys.executable).parent))
    if script is None:
        pytest.skip("the package is not installed with its script beside this interpreter")
    done = subprocess.run([script, "--version"], capture_output=True, text=True, env=environment, check=True)
    assert done.stdout == f"mrm {__version__}\n"


@pytest.mark.parametrize("option", ["--help", "-h"])
@pytest.mark.parametrize("arguments", [(), *((name,) for name in COMMANDS), ("library", "install")])
def test_help_goes_to_stdout(mrm_here, arguments, option):
    done = mrm_here(*arguments, option)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("Usage: ")
    assert "\x1b" not in done.stdout


def test_help_lists_every_command(mrm):
    listed = re.findall(r"^  (\w+)  ", mrm("--help").stdout.partition("Commands:")[2], re.MULTILINE)
    assert tuple(listed) == COMMANDS


def modules_after(environment, *arguments: str) -> set[str]:
    """Top-level modules that are loaded once the command has run with these arguments."""
    code = (
        "import sys\n"
        "from mrm_mtlx.cli.main import run\n"
        f"sys.argv = ['mrm', *{arguments!r}]\n"
        "try:\n    run()\n"
        "finally:\n    print('\\n'.join(sorted({name.partition('.')[0] for name in sys.modules})), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    return set(done.stderr.split())


@pytest.mark.parametrize("arguments", [("--help",), ("--version",), ("validate", "--help"), ("rules",)])
def test_what_needs_no_heavy_package_imports_none(environment, arguments):
    assert modules_after(environment, *arguments) & set(HEAVY) == set()


def test_a_heavy_package_would_be_noticed(environment, metal):
    assert modules_after(environment, "generate", str(metal), "--target", "osl") & set(HEAVY) >= {"MaterialX"}


@pytest.mark.parametrize(
    "arguments",
    [
        ("frobnicate",),
        ("--frobnicate",),
        ("validate",),
        ("validate", "a.mtlx", "--format", "xml"),
        ("validate", "a.mtlx", "--target", "cobol"),
        ("validate", "a.mtlx", "--select", "NOPE"),
        ("validate", "a.mtlx", "--ignore", "NOPE"),
        ("validate", "a.mtlx", "--samples", "1"),
        ("validate", "a.mtlx", "--samples", "many"),
        ("validate", "a.mtlx", "--seed", "-1"),
        ("validate", "a.mtlx", "--jobs", "-1"),
        ("validate", "a.mtlx", "--timeout", "0"),
        ("validate", "a.mtlx", "--library", "theirs"),
        ("conformance", "--target", "msl"),
        ("conformance", "--samples", "0"),
        ("generate",),
        ("generate", "a.mtlx", "--target", "cobol"),
        ("render", "a.mtlx"),
        ("render", "a.mtlx", "-o", "a.png", "--shape", "cube"),
        ("render", "a.mtlx", "-o", "a.png", "--size", "0"),
        ("rules", "NOPE"),
        ("doctor", "--format", "junit"),
        ("library", "install"),
        ("library", "remove"),
    ],
    ids=" ".join,
)
def test_a_wrong_call_is_a_usage_message_of_one_line(mrm_here, arguments):
    done = mrm_here(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    usage, hint, empty, error = done.stderr.strip().split("\n")
    assert usage.startswith("Usage: ")
    assert hint.startswith("Try '")
    assert empty == ""
    assert error.startswith("Error: ")


def test_without_arguments_the_help_is_shown_and_the_status_is_that_of_a_wrong_call(mrm):
    done = mrm()
    assert done.returncode == 2
    assert "Usage: " in done.stdout + done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        pytest.param(("rules", "--markdown"), id="plain text"),
        pytest.param(("generate", "{metal}"), id="source"),
    ],
)
@pytest.mark.skipif(os.name != "posix", reason="pipes are broken in other ways elsewhere")
def test_a_reader_that_goes_away_is_no_error(command, environment, metal, arguments):
    arguments = [argument.format(metal=metal) for argument in arguments]
    process = subprocess.Popen([*command, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
    process.stdout.close()
    errors = process.stderr.read()
    process.stderr.close()
    assert (process.wait(), errors) == (0, b"")
