"""The rule that reports a target ignoring the flag: for OSL it fires with MaterialX's library, and not with ours."""

from __future__ import annotations

import json

import pytest

from mrm_mtlx.shadergen import OslMode, generate, renderable_elements
from mrm_mtlx.validation.document import ignores_flag

RETRO = """
<{node} name="bsdf" type="BSDF"><input name="retroreflective" type="boolean" value="true"/></{node}>
"""
NODES = ("conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf")


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("mode", OslMode)
def test_our_osl_depends_on_the_flag_in_every_mode_and_the_standard_one_does_not(
    surface_document, library, upstream_library, node, mode
):
    for data, ignored in ((library, False), (upstream_library, True)):
        document = surface_document(RETRO.format(node=node), data=data)
        shader = generate(renderable_elements(document)[0], "osl", data, mode)
        assert ignores_flag(shader, "bsdf") is ignored


@pytest.mark.parametrize(("library", "codes"), [("mrm", []), ("upstream", ["SHADER_IGNORES_RETRO"])])
def test_validate_says_so(mrm, repository, library, codes):
    document = repository / "tests" / "documents" / "SHADER_IGNORES_RETRO" / "triggers.mtlx"
    done = mrm("validate", document, "--target", "osl", "--library", library, "--format", "json")
    (found,) = json.loads(done.stdout)["documents"]
    assert [finding["code"] for finding in found["findings"]] == codes
