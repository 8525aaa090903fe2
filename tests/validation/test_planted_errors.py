"""Single errors in a copy of the standard library, each seen by comparing a whole document: ours, and one of others."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.engines.gl import ENGINE
from mrm_mtlx.findings.finding import Severity
from mrm_mtlx.library import DataLibrary, Origin, dialects, materialx_version, node_library_folder
from mrm_mtlx.library.load import add_node_library
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison.drawing import check_draws
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.sampling import generator
from tests.fixtures.versions import planted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

SAMPLES = 2048


@dataclass(frozen=True)
class Planted:
    """A change to one file of the standard library, and the document of each corpus that has to show it.

    `opacity` is given to the surfaces of the shared document: those of that corpus are all opaque.
    """

    own: str
    shared: str
    file: str
    old: str
    new: str
    opacity: str = ""


ERRORS = {
    "a wrong coefficient in sheen": Planted(
        "sheen",
        "bsdf/sheen_bsdf",
        "pbrlib/genglsl/lib/mx_microfacet_sheen.glsl",
        "vec2(13.67300",
        "vec2(13.97300",
    ),
    "a swapped layer": Planted(
        "layer_stack",
        "bsdf/vertical_layering",
        "pbrlib/genglsl/mx_layer_bsdf.glsl",
        "top.response + base.response * top.throughput",
        "base.response + top.response * base.throughput",
    ),
    "a dropped throughput": Planted(
        "standard_surface_enamel",
        "standard_surface/standard_surface_plastic",
        "pbrlib/genglsl/mx_layer_bsdf.glsl",
        "base.response * top.throughput",
        "base.response",
    ),
    "a missing opacity": Planted(
        "standard_surface_tinted_glass",
        "standard_surface/standard_surface_glass",
        "bxdf/standard_surface.mtlx",
        '<input name="opacity" type="float" nodename="opacity_luminance_float" />',
        "",
        opacity="0.5, 0.4, 0.3",
    ),
    "an exchanged pair of roughnesses": Planted(
        "open_pbr_brushed_steel",
        "open_pbr/open_pbr_aluminum_brushed",
        "pbrlib/genglsl/lib/mx_microfacet_specular.glsl",
        "vec2 He = H.xy / alpha;",
        "vec2 He = H.xy / alpha.yx;",
    ),
}


@pytest.fixture(scope="module")
def changed_standard_library(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str, str], DataLibrary]:
    """Function from a change to a file of the standard library to a copy of it with the change, below ours."""

    def change(file: str, old: str, new: str) -> DataLibrary:
        root = tmp_path_factory.mktemp("changed")
        standard = Path(mx.getDefaultDataSearchPath().asString()) / "libraries"
        shutil.copytree(standard, root / "libraries")
        path = root / "libraries" / file
        if not path.exists() and not dialects.installed().has_retroreflective:
            pytest.skip(f"MaterialX {materialx_version()} has no file {file}")
        text = path.read_text(encoding="utf-8")
        path.write_text(planted(text, old, new), encoding="utf-8")
        search_path, ours = mx.FileSearchPath(str(root)), mx.FileSearchPath(str(node_library_folder()))
        document = mx.createDocument()
        add_node_library(document)
        mx.loadLibraries(mx.getDefaultDataLibraryFolders(), search_path, document)
        search_path.append(ours)
        return DataLibrary(Origin.MRM, document, search_path)

    return change


def passing(
    path: Path, true_library: DataLibrary, drawn_library: DataLibrary, opacity: str = "", target: str = "glsl"
) -> Iterator[bool]:
    """Whether each of a document's surfaces passes: the reference with one library, the shader with another."""
    documents = []
    for library in (true_library, drawn_library):
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(path))
        document.setDataLibrary(library.document)
        for node in document.getNodes() if opacity else ():
            if node.getType() == "surfaceshader":
                node.setInputValue("opacity", opacity, "color3")
        documents.append(document)
    for true, drawn in zip(*map(renderable_elements, documents), strict=True):
        images = CheckedImages(Reach.beside(path), "")
        expectation = Expectation(true, generator(0, true.getName()), SAMPLES, images)
        assert not expectation.reason
        shader = generate(drawn, target, drawn_library)
        yield check_draws(ENGINE, shader, images, {"": (expectation, {})}, "")[""][0].status == "pass"


@pytest.mark.parametrize("name", ERRORS)
def test_an_error_in_one_node_is_seen_in_a_document_of_the_corpus(gl, library, changed_standard_library, corpus, name):
    planted = ERRORS[name]
    document, opacity = (planted.own, "") if corpus.parent.name == "tests" else (planted.shared, planted.opacity)
    path = corpus / f"{document}.mtlx"
    wrong = changed_standard_library(planted.file, planted.old, planted.new)
    assert not all(passing(path, library, wrong, opacity))
    assert all(passing(path, library, library, opacity))


@pytest.mark.large
def test_every_surface_of_the_corpus_is_as_the_reference_has_it(gl, corpus, check):
    documents = check(corpus)
    outcomes = {(d.path, r.name): r.targets["glsl"] for d in documents for r in d.renderables}
    assert len(outcomes) > len(documents) > 20
    assert {name: (o.stage, o.status, o.reason) for name, o in outcomes.items() if o.status != "pass"} == {}
    assert [finding for d in documents for finding in d.findings if finding.rule.severity is Severity.ERROR] == []


TEXTURED = """<?xml version="1.0"?>
<materialx version="1.39">
  <image name="i" type="color3">
    <input name="file" type="filename" value="steps.exr"/>
    <input name="uaddressmode" type="string" value="mirror"/>
  </image>
  <surface_unlit name="s" type="surfaceshader">
    <input name="emission_color" type="color3" nodename="i"/>
  </surface_unlit>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
</materialx>
"""


@pytest.mark.parametrize("target", ["glsl", "essl"])
def test_an_address_mode_off_by_one_is_seen(
    gl, library, changed_standard_library, written, write_image, tmp_path, target
):
    write_image(tmp_path / "steps.exr", np.arange(5 * 3 * 3).reshape(3, 5, 3) / 45.0)
    path = written(TEXTURED, "textured.mtlx")
    # Generators number the modes in the order of the definition.
    order = 'enum="constant,clamp,periodic,mirror"'
    wrong = changed_standard_library("stdlib/stdlib_defs.mtlx", order, 'enum="mirror,constant,clamp,periodic"')
    assert not all(passing(path, library, wrong, target=target))
    assert all(passing(path, library, library, target=target))
