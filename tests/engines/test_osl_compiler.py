"""The OSL compiler: takes what is right, and places what is wrong; oslc where it is there, else the one in Cycles."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.engines import commands, osl
from mrm_mtlx.engines.base import CompileError, CompileMessage, EngineFailure
from mrm_mtlx.engines.osl import process
from mrm_mtlx.engines.osl.compiler import parse_log
from mrm_mtlx.shadergen import generate, renderable_elements

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

# Needs a header of MaterialX's, as all generated OSL.
GOOD = """#include "mx_funcs.h"
shader good(float a = 0.5, output closure color out = 0)
{
    vector2 pair = {a, a};
    out = pair.x * diffuse(N);
}
"""

posix = pytest.mark.skipif(os.name != "posix", reason="the stand-in for oslc is a script")


@pytest.fixture
def no_oslc(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Nothing on the path: an installed oslc is out of the way."""
    (tmp_path / "empty").mkdir()
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))


def shader(*lines: str) -> str:
    """A shader with these lines in its body, of which the first is line 3."""
    return "\n".join(["shader wrong(float a = 0.5, output closure color out = 0)", "{", *lines, "}", ""])


def complaints(source: str, name: str = "wrong") -> list[CompileMessage]:
    """What the compiler has against a source."""
    with pytest.raises(CompileError) as raised:
        osl.check(source, name)
    assert str(raised.value) == "; ".join(message.message for message in raised.value.messages)
    return raised.value.messages


# The compiler in Cycles -----------------------------------------------------------------------------------------------


def test_a_good_shader_compiles_and_nothing_of_it_stays(cycles, no_oslc):
    folder = process.runtime().folder
    osl.check(GOOD, "good")
    assert list(folder.glob("good*.oso")) == []


def test_a_compiled_shader_stays_as_it_is_when_another_of_its_name_is_compiled(cycles):
    emitting = "shader same(output closure color out = 0)\n{{\n    out = {} * emission();\n}}\n"
    first = osl.compile_for_cycles(emitting.format(1.0), "same")
    kept = first.read_bytes()
    assert kept.startswith(b"OpenShadingLanguage")
    second = osl.compile_for_cycles(emitting.format(2.0), "same")
    assert first != second
    assert first.read_bytes() == kept != second.read_bytes()


@pytest.mark.parametrize("name", ["float", "varying", "displacementshader"])
def test_a_generated_shader_of_an_element_that_is_named_as_a_word_of_osl_compiles(cycles, make_document, library, name):
    document = make_document(f'<dot name="d" type="float"/><output name="{name}" type="float" nodename="d"/>')
    (element,) = renderable_elements(document)
    made = generate(element, "osl", library)
    osl.check(made.sources["pixel"], made.name)


# Lines of a body, and what is said of the one that names `missing`.
BROKEN = {
    "an unknown name": (["float b = 2.0 * missing;", "out = b * diffuse(N);"], "'missing' was not declared"),
    "a function that is not there": (["out = missing(a);"], "function 'missing' was not declared"),
    "between empty lines": (["", "float b = missing;", "", "", "out = b * diffuse(N);"], "'missing' was not declared"),
    "a wrong type": (["point missing = 0;", "matrix b = missing;", "out = diffuse(N);"], "Cannot assign matrix b"),
    "Windows' line ends": (["float b = missing;\r", "out = diffuse(N);\r"], "'missing' was not declared"),
    "not ASCII": (["// µ, °", "float b = missing; // é", "out = diffuse(N);"], "'missing' was not declared"),
}


def line_at_fault(source: str) -> int:
    """Number, from 1, of the last line that names `missing`."""
    return max(number for number, line in enumerate(source.split("\n"), 1) if "missing" in line)


@pytest.mark.parametrize("what", BROKEN)
def test_an_error_is_given_with_file_line_and_statement(cycles, no_oslc, what):
    body, words = BROKEN[what]
    source = shader(*body)
    (message,) = complaints(source)
    assert message.message.startswith(f"wrong.osl:{message.line}: ")
    assert words in message.message
    assert source.split("\n")[line_at_fault(source) - 1].strip() in message.source
    assert "\n" not in str(message)


@pytest.mark.parametrize("what", BROKEN)
def test_the_line_of_an_error_is_the_one_that_the_statement_is_on(cycles, no_oslc, what):
    source = shader(*BROKEN[what][0])
    assert complaints(source)[0].line == line_at_fault(source)


def test_all_errors_are_given_in_the_order_of_the_source(cycles, no_oslc):
    found = complaints(shader("float b = first;", "float c = second;", "out = third * diffuse(N);"))
    assert len(found) == 3
    assert [message.line for message in found] == [found[0].line + k for k in range(3)]
    for message, name in zip(found, ("first", "second", "third"), strict=True):
        assert f"'{name}'" in message.message
        assert name in message.source


def test_a_missing_semicolon_is_a_syntax_error(cycles, no_oslc):
    (message,) = complaints(shader("out = diffuse(N)"))
    assert "syntax error" in message.message


@pytest.mark.parametrize("source", ["", "\n \n", "// nothing but a comment\n", "float f(float a) { return a; }\n"])
def test_a_source_without_a_shader_is_refused(cycles, no_oslc, source):
    (message,) = complaints(source)
    assert message.message == "No shader function defined"
    assert (message.line, message.source) == (0, "")


@pytest.fixture
def header(cycles) -> Iterator[Path]:
    """A header with an error in its third line, beside the sources."""
    path = process.runtime().folder / "mistaken.h"
    path.write_text("float mistaken(float x)\n{\n    return missing + x;\n}\n", encoding="utf-8")
    yield path
    path.unlink()


def test_an_error_in_a_header_names_the_header_and_quotes_nothing_of_the_source(header, no_oslc):
    # The source has a line of the number that is named, which is not to blame.
    found = complaints('#include "mistaken.h"\n' + shader("out = mistaken(a) * diffuse(N);"))
    assert "'missing' was not declared" in found[0].message
    for message in found:
        assert message.message.startswith("mistaken.h:")
        assert (message.line, message.source) == (0, "")


def test_a_header_that_is_not_there_is_named(cycles, no_oslc):
    (message,) = complaints('#include "nowhere.h"\n' + shader("out = diffuse(N);"))
    assert "'nowhere.h' file not found" in message.message


def test_no_message_depends_on_where_the_runtime_has_its_folder(cycles, no_oslc):
    (message,) = complaints('#include "nowhere.h"\n' + shader("out = diffuse(N);"))
    assert process.runtime().folder.name not in str(message)


def test_an_error_after_one_that_was_taken_care_of_is_told_apart_from_it(cycles, no_oslc):
    assert "first" in complaints(shader("out = first * diffuse(N);"))[0].message
    assert "second" in complaints(shader("out = second * diffuse(N);"))[0].message
    osl.check(GOOD, "wrong")


# What it says, taken apart --------------------------------------------------------------------------------------------

SOURCE = "shader s()\n{\n    float a = b;\n\n}\n"
# What OSL says of its third line, one too far, see above.
SAID = "s.osl:4: error: 'b' was not declared in this scope\n"


def test_cycles_and_oslc_say_the_same_but_for_a_word():
    assert parse_log(f"ERROR: {SAID}", SOURCE, "s") == parse_log(SAID, SOURCE, "s")
    (message,) = parse_log(SAID, SOURCE, "s")
    assert message.message.endswith(": 'b' was not declared in this scope")
    assert "float a = b;" in message.source


def test_the_folder_is_left_out_of_a_message():
    assert parse_log(f"ERROR: /tmp/x/{SAID}", SOURCE, "s") == parse_log(SAID, SOURCE, "s")


def test_warnings_beside_an_error_are_no_errors():
    log = f"WARNING: s.osl:3: warning: narrow\nERROR: {SAID}FAILED s.osl\n"
    assert parse_log(log, SOURCE, "s") == parse_log(SAID, SOURCE, "s")


def test_a_line_beyond_the_source_is_not_quoted():
    (message,) = parse_log("ERROR: s.osl:500: error: no\n", SOURCE, "s")
    assert (message.line, message.source) == (0, "")


@pytest.mark.parametrize(
    ("log", "words"),
    [("", "the compiler gave no reason"), ("\n \n", "the compiler gave no reason"), ("a\n b\n", "a b")],
)
def test_there_is_always_a_message(log, words):
    assert parse_log(log, SOURCE, "s") == [CompileMessage(0, "", words)]


# oslc -----------------------------------------------------------------------------------------------------------------

# Stands in for oslc, which no package index has. Like it, it takes -q, -o and a file, finds headers beside the file,
# says `file:line: error: ...` on stderr, the line one too far, and FAILED on stdout, and ends with status 1.
OSLC = """#!{python}
import sys
from pathlib import Path
quiet, minus_o, target, source = sys.argv[1:]
Path({calls!r}).open("a").write(source + chr(10))
assert (quiet, minus_o) == ("-q", "-o")
lines = Path(source).read_text(encoding="utf-8").split(chr(10))
for line in lines:
    if line.startswith("#include"):
        Path(line.split(chr(34))[1]).read_text()
wrong = [number for number, line in enumerate(lines, 1) if "missing" in line]
for number in wrong:
    print(source + ":" + str(number + 1) + ": error: 'missing' was not declared in this scope", file=sys.stderr)
if wrong:
    print("FAILED", source)
    sys.exit(1)
Path(target).write_text("OpenShadingLanguage 1.00")
"""


@pytest.fixture
def oslc(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The file that a stand-in for oslc, on the path before all else, notes its calls in."""
    calls = tmp_path / "calls"
    calls.touch()
    put_on_path(monkeypatch, tmp_path, OSLC.format(python=sys.executable, calls=str(calls)))
    return calls


def put_on_path(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, script: str) -> None:
    """An executable `oslc` with this text."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "oslc").write_text(script, encoding="utf-8")
    (tmp_path / "bin" / "oslc").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}")


@posix
def test_oslc_is_used_where_it_is_on_the_path(monkeypatch, oslc):
    monkeypatch.setattr(process.RUNTIME, "_running", [])
    assert osl.compiler_availability() == osl.compiler_availability().__class__(True, "oslc")
    osl.check(GOOD, "good")
    assert oslc.read_text() == "good.osl\n"
    assert process.RUNTIME._running == []  # no Cycles was started for it


@posix
def test_without_oslc_the_compiler_is_that_of_cycles(cycles, no_oslc):
    assert osl.compiler_availability() == cycles


@posix
def test_errors_of_oslc_are_placed_as_those_of_cycles(cycles, oslc, monkeypatch, tmp_path):
    source = shader("float b = missing;", "out = b * diffuse(N);")
    found = complaints(source)
    assert oslc.read_text() == "wrong.osl\n"
    monkeypatch.setenv("PATH", str(tmp_path))
    assert complaints(source) == found


@posix
def test_nothing_is_left_of_what_oslc_was_given(oslc, monkeypatch, tmp_path):
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    osl.check(GOOD, "good")
    complaints(shader("out = missing;"))
    assert list((tmp_path / "temporary").iterdir()) == []


@posix
def test_an_oslc_that_hangs_is_ended(monkeypatch, tmp_path):
    put_on_path(monkeypatch, tmp_path, "#!/bin/sh\nexec sleep 3600\n")
    monkeypatch.setattr(commands, "TIMEOUT_S", 0.2)
    with pytest.raises(EngineFailure, match=r"oslc did not finish within 0\.2 s"):
        osl.check(GOOD, "good")


@posix
def test_an_oslc_that_gives_no_reason_still_refuses(monkeypatch, tmp_path):
    put_on_path(monkeypatch, tmp_path, "#!/bin/sh\nexit 1\n")
    (message,) = complaints(GOOD, "good")
    assert message.message == "the compiler gave no reason"


@posix
def test_an_oslc_that_crashes_is_not_the_fault_of_the_source(monkeypatch, tmp_path):
    put_on_path(monkeypatch, tmp_path, "#!/bin/sh\nkill -SEGV $$\n")
    with pytest.raises(EngineFailure, match="SIGSEGV"):
        osl.check(GOOD, "good")


@posix
def test_an_oslc_that_cannot_run_is_not_available(monkeypatch, tmp_path):
    put_on_path(monkeypatch, tmp_path, "\x7fELF, but not of this machine")
    assert osl.compiler_availability().detail != "oslc"


# Nobody ---------------------------------------------------------------------------------------------------------------


def test_with_no_compiler_at_all_the_remedy_is_given(no_oslc, monkeypatch):
    monkeypatch.setattr(process.RUNTIME, "_running", [])
    monkeypatch.delenv(process.VARIABLE, raising=False)
    monkeypatch.setitem(sys.modules, "bpy", None)  # the import system's own mark of a module that is not there
    with pytest.raises(EngineFailure, match=r"bpy is not installed.*; .*pip install"):
        osl.check(GOOD, "good")


def test_the_stand_in_for_oslc_and_the_compiler_in_cycles_agree_on_what_is_wrong(cycles, oslc, tmp_path):
    # Else the tests above would hold for the stand-in alone.
    for source, status in ((GOOD, 0), (shader("out = missing;"), 1)):
        (tmp_path / "one.osl").write_text(source, encoding="utf-8")
        (tmp_path / "mx_funcs.h").touch()
        command = ["oslc", "-q", "-o", "one.oso", "one.osl"]
        assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode == status
        if status:
            with pytest.raises(CompileError):
                osl.compile_for_cycles(source, "one")
        else:
            lit = osl.direct_light(osl.compile_for_cycles(source, "one"), np.array([[0.0, 0.0, 1.0]]), {}, [[0, 0, 1]])
            assert lit.shape == (1, 1, 3)
