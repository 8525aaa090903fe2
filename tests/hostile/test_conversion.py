"""Documents that broke `mrm convert` and `mrm generate`."""

from __future__ import annotations

from pathlib import Path

import pytest

PATTERN = '<constant name="n" type="color3"/><output name="o" type="color3" nodename="n"/>'


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usdz"])
def test_an_output_that_is_no_shader_became_a_material(in_process, place, suffix: str) -> None:
    path = place.write("pattern.mtlx", f'<materialx version="1.39">{PATTERN}</materialx>')
    done = in_process("convert", path, f"out{suffix}")
    assert done.exit_code in (1, 2)
    assert "it has no material and no shader" in " ".join(done.stderr.replace("│", " ").split())
    assert not Path(f"out{suffix}").exists()


def test_an_output_that_is_no_shader_stays_behind_where_there_is_a_material(in_process, place, document_text) -> None:
    path = place.write("both.mtlx", document_text(PATTERN))
    done = in_process("convert", path, "out.usda")
    assert done.exit_code == 0, done.stderr
    assert "INTERCHANGE_LOST /n" in done.stderr
    assert Path("out.usda").read_text().count("def Material ") == 1


def test_an_output_of_type_material_was_taken_for_a_node(in_process, place, document_text) -> None:
    output = '<output name="o" type="material" nodename="n"/>'
    empty = f'<materialx version="1.39"><surfacematerial name="n" type="material"/>{output}</materialx>'
    done = in_process("convert", place.write("empty.mtlx", empty), "empty.usda")
    assert done.exit_code == 0, done.stderr
    assert Path("empty.usda").read_text().count('def Material "n"') == 1
    shown = document_text('<output name="o" type="material" nodename="m"/>')
    assert in_process("convert", place.write("shown.mtlx", shown), "shown.usda").exit_code == 0
    assert Path("shown.usda").read_text().count("def Material ") == 1


def test_a_graph_that_is_fed_by_a_node_of_its_own_had_no_source(in_process, place) -> None:
    graph = (
        '<nodegraph name="g"><input name="in" type="BSDF" nodename="b"/>'
        '<oren_nayar_diffuse_bsdf name="b" type="BSDF"/><output name="out" type="BSDF" nodename="b"/></nodegraph>'
        '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodegraph="g" output="out"/></surface>'
        '<surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
    )
    path = place.write("fed.mtlx", f'<materialx version="1.39">{graph}</materialx>')
    assert in_process("convert", path, "fed.usda").exit_code in (0, 1)


def test_a_picture_as_the_source_of_a_node_gave_code_that_is_no_text(in_process, place) -> None:
    coded = (
        '<nodedef name="ND_own" node="own"><output name="out" type="float"/></nodedef>'
        '<implementation name="IM_own" nodedef="ND_own" target="genglsl" file="i.png" function="mx_own"/>'
        '<own name="o" type="float"/><conductor_bsdf name="b" type="BSDF">'
        '<input name="weight" type="float" nodename="o"/></conductor_bsdf>'
        '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="b"/></surface>'
        '<surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
    )
    place.picture("i.png")
    path = place.write("coded.mtlx", f'<materialx version="1.39">{coded}</materialx>')
    done = in_process("generate", path)
    assert done.exit_code == 1
    assert "SHADER_GENERATE" in done.stderr
    assert "not UTF-8" in done.stderr
