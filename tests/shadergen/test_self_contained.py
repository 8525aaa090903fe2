"""OSL with its headers in it: no `#include` is left, and the compiler makes the same of it."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from mrm_mtlx.engines.osl import process
from mrm_mtlx.shadergen import GenerationError, OslMode, Shader, generate, header_folder, self_contained

if TYPE_CHECKING:
    from pathlib import Path

# A lobe whose colour comes from an image and noise: functions of all headers.
TEXTURED = """
    <image name="picture" type="color4"><input name="file" type="filename" value="a.png"/></image>
    <convert name="rgb" type="color3"><input name="in" type="color4" nodename="picture"/></convert>
    <noise3d name="grain" type="float"/>
    <rotate2d name="turned" type="vector2"><input name="in" type="vector2" value="1, 0"/>
        <input name="amount" type="float" nodename="grain"/></rotate2d>
    <multiply name="scaled" type="vector2"><input name="in1" type="vector2" nodename="turned"/>
        <input name="in2" type="vector2" value="0.5, 0.5"/></multiply>
    <generalized_schlick_bsdf name="bsdf" type="BSDF">
        <input name="color0" type="color3" nodename="rgb"/>
        <input name="roughness" type="vector2" nodename="scaled"/>
        <input name="retroreflective" type="boolean" value="true"/>
    </generalized_schlick_bsdf>
"""

by_mode = pytest.mark.parametrize("mode", OslMode)


@pytest.fixture(scope="module")
def textured(surface_document, library):
    """Function from a mode to generated OSL that needs its headers."""
    document = surface_document(TEXTURED)
    return lambda mode=OslMode.ALIGNED: generate(document.getNode("m"), "osl", library, mode)


def with_source(shader: Shader, source: str) -> Shader:
    """The shader with another source."""
    return replace(shader, sources={"pixel": source})


def compiled(source: str, folder: Path) -> str:
    """What the compiler makes of a source that lies alone in a folder, without names of files and lines; "" if refused.

    With it, equal code is an equal response.
    """
    folder.mkdir(exist_ok=True)
    (folder / "a.osl").write_text(source, encoding="utf-8")
    files = {"source": str(folder / "a.osl"), "target": str(folder / "a.oso")}
    answer, _ = process.runtime().request("compile", **files)
    if not answer["ok"]:
        return ""
    lines = (folder / "a.oso").read_text(encoding="utf-8").splitlines()
    code = (re.sub(r"%(filename|line)\{.*?\}", "", line).split() for line in lines if not line.startswith("#"))
    return "\n".join(" ".join(words) for words in code)


@by_mode
def test_no_include_is_left_and_each_header_is_there_once(textured, mode):
    ordinary, found = textured(mode), self_contained(textured(mode))
    assert '#include "mx_funcs.h"' in ordinary.sources["pixel"]
    source = found.sources["pixel"]
    assert not re.search(r"^\s*#\s*(include|pragma)", source, re.MULTILINE)
    headers = sorted(header_folder().glob("*.h"))
    assert len(headers) == 5
    for header in headers:
        functions = re.findall(r"^\w+ \w+\(.*\)$", header.read_text(encoding="utf-8"), re.MULTILINE)
        assert functions, header.name
        assert {source.count(f"{declared}\n") for declared in functions} == {1}, header.name
    assert replace(found, sources=ordinary.sources) == ordinary
    assert source.startswith(mode.definition)


@by_mode
def test_it_compiles_without_headers_to_the_very_code_of_the_ordinary_form(cycles, textured, tmp_path, mode):
    ordinary, found = textured(mode), self_contained(textured(mode))
    assert compiled(ordinary.sources["pixel"], tmp_path / "alone") == ""
    for header in header_folder().glob("*.h"):
        (tmp_path / header.name).write_bytes(header.read_bytes())
    code = compiled(ordinary.sources["pixel"], tmp_path)
    assert "mrm_generalized_schlick_bsdf" in code
    assert compiled(found.sources["pixel"], tmp_path / "alone") == code


@pytest.mark.parametrize("new", ["vector2(a.x * b.x, a.y + b.y)", "vector2(a.x * b.x, lost)"])
def test_a_slip_in_what_was_inlined_changes_the_code(cycles, textured, tmp_path, new):
    source = self_contained(textured()).sources["pixel"]
    damaged = source.replace("vector2(a.x * b.x, a.y * b.y)", new)
    assert damaged != source
    assert compiled(damaged, tmp_path) != compiled(source, tmp_path) != ""


def test_a_source_without_includes_stays_as_it_is(textured):
    once = self_contained(textured())
    assert self_contained(once) == once


@pytest.mark.parametrize(
    "line",
    ['#include "secret.h"', "  #  include <secret.h>", '#include "../secret.h"', '#include "{folder}/secret.h"'],
)
def test_nothing_but_headers_of_materialx_is_read(textured, tmp_path, monkeypatch, line):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    for folder in (tmp_path, tmp_path / "here"):
        (folder / "secret.h").write_text("// secret\n", encoding="utf-8")
    shader = textured()
    source = f"{line.format(folder=tmp_path)}\n{shader.sources['pixel']}"
    with pytest.raises(GenerationError, match=r"secret\.h', which is no header of MaterialX"):
        self_contained(with_source(shader, source))


def test_what_the_compiler_adds_by_itself_is_left_to_it(textured):
    shader = textured()
    twice = with_source(shader, f'#include "stdosl.h"\n#include <mx_funcs.h>\n{shader.sources["pixel"]}')
    assert self_contained(twice).sources["pixel"].split() == self_contained(shader).sources["pixel"].split()
