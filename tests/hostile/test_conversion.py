"""Documents that broke `mrm convert`."""

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
