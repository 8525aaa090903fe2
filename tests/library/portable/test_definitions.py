"""The portable form of the library: definitions by graphs, beside the standard ones."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.conformance.cases import NODES, Case, case_document, case_points
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.library import Origin, load_library
from mrm_mtlx.library.portable.definitions import load_portable_library, portable_library_files
from mrm_mtlx.shadergen import TARGETS, generate, renderable_elements
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.samples import draw

if TYPE_CHECKING:
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.reference import ShadingPoints

VERSIONS = ("1.39.0", "1.39.2", "1.39.4", "1.39.5")


def test_the_files_are_definitions_and_graphs_alone():
    files = portable_library_files("1.39.2")
    assert list(files) == sorted(files)
    document = mx.createDocument()
    for name, content in files.items():
        assert name.endswith(".mtlx")
        part = mx.createDocument()
        mx.readFromXmlString(part, content.decode())
        document.importLibrary(part)
    assert document.getImplementations() == []
    defined = {d.getName() for d in document.getNodeDefs()}
    # Names of the standard library would be taken for its definitions.
    assert all(name.startswith("ND_mrm_") for name in defined)
    assert {g.getNodeDefString() for g in document.getNodeGraphs()} == defined
    assert all(files == portable_library_files(version) for version in VERSIONS)


def test_a_version_that_the_library_does_not_serve_is_refused():
    with pytest.raises(LookupError, match=r"serves MaterialX 1\.39\.0 and later"):
        portable_library_files("1.38.10")


def test_graphs_and_definitions_are_valid_and_use_nothing_that_has_a_source_of_ours():
    library = load_portable_library().document
    ours = [g for g in library.getNodeGraphs() if g.getNodeDefString().startswith("ND_mrm_")]
    standard = load_library(Origin.UPSTREAM).document
    assert len(ours) == 8
    for graph in ours:
        assert graph.validate() == (True, "")
        for node in graph.getNodes():
            definition = node.getNodeDef()
            is_ours = definition.getName().startswith("ND_mrm_")
            assert is_ours or standard.getNodeDef(definition.getName()) is not None


def drawn(case: Case, library: DataLibrary, points: ShadingPoints) -> np.ndarray:
    """What the generated code of a case gives at samples."""
    document = case_document(case, library.document)
    with SurfaceProgram(generate(renderable_elements(document)[0], "glsl", library)) as program:
        return draw(program, points).colors


@pytest.mark.parametrize("node", NODES)
def test_without_the_flag_it_is_the_standard_node_to_the_bit(gl, node):
    case = Case(node, retroreflective=False, anisotropic=True, film=True)
    points = case_points(case, 512, sampling.generator(0, case.name))
    exact = drawn(case, load_library(Origin.UPSTREAM), points)
    np.testing.assert_array_equal(drawn(case, load_portable_library(), points), exact)
    # With it, another.
    assert np.mean(drawn(replace(case, retroreflective=True), load_portable_library(), points) != exact) > 0.5


def test_loaded_after_the_standard_library_it_serves_the_flag_where_that_has_none():
    """As a MaterialX before 1.39.5 has it: its definitions without the flag."""
    document = mx.createDocument()
    document.importLibrary(load_library(Origin.UPSTREAM).document)
    for node in NODES:
        document.getNodeDef(f"ND_{node}").removeInput("retroreflective")
    document.importLibrary(load_portable_library().document)
    for node in NODES:
        lobe = document.addNode(node, f"{node}_lobe", "BSDF")
        assert lobe.getNodeDef().getName() == f"ND_{node}"
        lobe.setInputValue("retroreflective", True)
        assert lobe.getNodeDef().getName() == f"ND_mrm_portable_{node}"


@pytest.mark.parametrize("target", [t for t in TARGETS if t != "mdl"])
def test_every_target_has_code_for_it(target):
    library = load_portable_library()
    for node in NODES:
        document = case_document(Case(node, True, False, False), library.document)
        source = generate(renderable_elements(document)[0], target, library).sources["pixel"]
        assert f"NG_mrm_portable_{node}" in source
