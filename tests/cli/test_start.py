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


def test_several_paths_are_one_placeholder(in_process):
    assert in_process("validate").stderr.splitlines()[0] == "Usage: mrm validate [OPTIONS] {PATH}..."
    assert in_process("photometry").stderr.splitlines()[-1] == (
        "Error: Invalid value for DOC: name a document, or --list for the standards"
    )


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
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == mrm("--help").stdout


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


# Completion -----------------------------------------------------------------------------------------------------------


def completed(environment, *words: str) -> tuple[list[str], list[str]]:
    """What a shell is told for the last of the words of a command line, and the heavy modules that this loads."""
    code = "import sys\nfrom mrm_mtlx.cli import main, supervision\n"
    code += "supervision.supervised = None  # nobody waits for a completion\n"
    code += f"try:\n    main.run()\nfinally:\n    print([m for m in {HEAVY!r} if m in sys.modules], file=sys.stderr)"
    asked = {"_MRM_COMPLETE": "complete_bash", "COMP_WORDS": " ".join(words), "COMP_CWORD": str(len(words) - 1)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={**environment, **asked}, check=True
    )
    return done.stdout.split(), done.stderr.splitlines()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("mrm", "ph"), ["photometry"]),
        (("mrm", "validate", "--s"), ["--select", "--strict", "--samples", "--seed"]),
        (("mrm", "photometry", "--co"), ["--color"]),
        (("mrm", "validate", "--format", ""), ["text", "json", "junit", "github"]),
    ],
    ids=lambda value: " ".join(value),
)
def test_a_shell_is_told_what_can_follow_and_nothing_heavy_is_loaded(environment, words, expected):
    assert completed(environment, *words) == (expected, ["[]"])


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_for_a_shell_is_printed(mrm, shell):
    done = mrm("--show-completion", shell)
    assert (done.returncode, done.stderr) == (0, "")
    assert "_MRM_COMPLETE=complete_" in done.stdout


# What typer and its libraries say -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("validate", "a", "--format", "xml"), "for --format: 'xml': expected one of text, json, junit, github"),
        (("validate", "a", "--samples", "1"), "for --samples: '1': expected a whole number, 16 to 4194304"),
        (("validate", "a", "--samples", "many"), "for --samples: 'many': expected a whole number, 16 to 4194304"),
        (("validate", "a", "--jobs", "-1"), "for --jobs: '-1': expected a whole number, 0 or more"),
        (("validate", "a", "--timeout", "0"), "for --timeout: '0': expected a number, 0.1 or more"),
        (("validate", "a", "--root", "no"), "for --root: no: expected a folder that exists"),
        (("validate", "a", "-o", "no/x"), "for --output: no/x cannot be written: the folder no does not exist"),
        (("render", "a", "-o", "a.png", "--exposure", "x"), "for --exposure: 'x': expected a number"),
        (("render", "a", "-o", "a.png", "--paths", "3"), "for --paths: only with an engine that traces paths"),
        (("render", "a", "-o", "a.png", "--seed", "3"), "for --seed: only with an engine that traces paths"),
        (("render", "a", "-o", "a.png", "--osl-mode", "aligned"), "for --osl-mode: only with an engine that traces"),
        (("generate", "a", "--osl-mode", "cycles"), "for --osl-mode: only with --target osl"),
        (("generate", "a", "--self-contained"), "for --self-contained: only with --target osl"),
        (("generate", "a", "--script-node"), "for --script-node: only with --target osl"),
        (("rules", "READ", "--markdown"), "for CODE: not with --markdown, which has all rules"),
        (("plot", "-o", "a.svg", "--light", "up"), "for --light: 'up': expected a number"),
        (("fit", "--ra", "1:1:1", "-o", "a.json"), "for --output: a.json: a MaterialX document is written; expected"),
        (("convert", "a", "b.json", "--observation", "x"), "for --observation: 'x': expected a number"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_a_wrong_value_is_told_in_our_words(in_process, arguments, message):
    done = in_process(*arguments)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1].startswith(f"Error: Invalid value {message}")


def test_what_is_said_fits_the_terminals_that_everybody_has(mrm):
    for arguments in (("doctor",), ("doctor", "--coverage"), ("rules",)):
        lines = mrm(*arguments).stdout.splitlines()
        table = [line for line in lines if not line.startswith(("not covered: ", "       "))]  # details and commands
        assert max(map(len, table)) <= 80, arguments
