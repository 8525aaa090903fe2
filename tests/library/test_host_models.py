"""Surface models of a host: who gets them, in whatever order a host loads, and how it chooses a definition."""

from __future__ import annotations

import subprocess
from pathlib import Path

import MaterialX as mx
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.library import host_models
from mrm_mtlx.library.assembly import node_library_files
from mrm_mtlx.library.dialects import dialect
from mrm_mtlx.library.host_check import checks
from mrm_mtlx.library.host_models import FLAG_FILE, MODELS_FILE, flagged_definitions, models_version
from mrm_mtlx.library.hosts import HOSTS
from mrm_mtlx.library.standard_library import FIRST_DEFINED
from mrm_mtlx.library.surface_models import MICROFACET_NODES, SURFACE_MODELS
from mrm_mtlx.shadergen import generate, renderable_elements
from tests.library.test_surface_models import written

MODELS = pytest.mark.parametrize("model", SURFACE_MODELS, ids=lambda model: model.node)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Folder of a library for hosts that choose a definition by a node's inputs."""
    return mrm.install_library(tmp_path_factory.mktemp("plain")).folder


@pytest.fixture(scope="module")
def usd(tmp_path_factory):
    """Folder of a library for hosts that choose a definition by its name."""
    return mrm.install_library(tmp_path_factory.mktemp("usd"), host="usd-26.08").folder


def loaded(folder: Path, order: str) -> mx.Document:
    """What a host without Python loads: o ours, s the standard library, in this order."""
    document = mx.createDocument()
    for step in order:
        if step == "s":
            mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
        else:
            mx.loadLibraries(["mrm"], mx.FileSearchPath(str(folder)), document)
    return document


def definition_of(library: mx.Document, category: str, *inputs: str) -> str:
    """The definition that a node gets that has these inputs."""
    document = mx.createDocument()
    document.setDataLibrary(library)
    node = document.addNode(category, "s", "surfaceshader")
    for name in inputs:
        node.setInputValue(name, 0.5)
    definition = node.getNodeDef()
    return definition.getName() if definition is not None else ""


@pytest.mark.parametrize("order", ["os", "so"])
@pytest.mark.parametrize("form", ["plain", "usd"])
def test_the_library_is_valid_and_the_standard_models_stay_as_they_are_in_any_order(
    request, upstream_library, form, order
):
    data = loaded(request.getfixturevalue(form), order)
    valid, message = data.validate()
    assert valid, message
    for model in SURFACE_MODELS:
        stock = f"ND_{model.node}_surfaceshader"
        assert definition_of(data, model.node) == stock
        assert definition_of(data, model.node, model.roughness) == stock
        ours, theirs = (library.getNodeDef(stock) for library in (data, upstream_library.document))
        assert ours == theirs
        assert ours.getImplementation("").getName() == theirs.getImplementation("").getName()


@pytest.mark.parametrize("order", ["os", "so"])
@MODELS
def test_a_document_with_the_input_gets_the_model_that_has_it(plain, order, model):
    assert definition_of(loaded(plain, order), model.node, model.amount) == model.definition


@pytest.mark.parametrize("order", ["os", "so"])
@MODELS
def test_a_host_that_drops_the_inputs_finds_the_model_by_its_own_category(usd, order, model):
    data = loaded(usd, order)
    category = data.getNodeDef(model.definition).getNodeString()
    assert category == f"mrm_{model.node}"
    assert definition_of(data, category) == model.definition


@pytest.mark.parametrize("order", ["os", "so"])
@MODELS
def test_the_graphs_are_those_that_are_made_in_memory(plain, library, order, model):
    ours, theirs = (data.getNodeGraph(model.graph) for data in (loaded(plain, order), library.document))
    assert written(ours) == written(theirs)


@MODELS
def test_a_document_that_names_the_definition_gets_it_in_either_form(plain, usd, model):
    for folder in (plain, usd):
        document = mx.createDocument()
        document.setDataLibrary(loaded(folder, "os"))
        node = document.addNode(model.node, "s", "surfaceshader")
        node.setNodeDefString(model.definition)
        node.setInputValue(model.amount, 0.5)
        assert node.getNodeDef().getName() == model.definition
        assert document.validate() == (True, "")


def test_a_copy_that_is_chosen_for_every_document_would_be_seen(tmp_path, plain):
    text = (plain / "mrm" / MODELS_FILE).read_text(encoding="utf-8")
    document = mx.createDocument()
    mx.readFromXmlString(document, text)
    document.removeNodeDef("ND_open_pbr_surface_surfaceshader")
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
    assert definition_of(document, "open_pbr_surface") == "ND_mrm_open_pbr_surface_surfaceshader"


@MODELS
@pytest.mark.parametrize("form", ["plain", "usd"])
def test_a_host_without_python_generates_the_same_shader(request, library, make_document, model, form):
    folder = request.getfixturevalue(form)
    given = f'<input name="{model.amount}" type="float" value="0.5"/>'
    text = (
        f'<{model.node} name="s" type="surfaceshader" nodedef="{model.definition}">{given}</{model.node}>'
        '<surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
    )
    path = mx.getDefaultDataSearchPath()
    path.append(mx.FileSearchPath(str(folder)))
    bare = type(library)(library.origin, loaded(folder, "os"), path)
    documents = [(make_document(text, data), data) for data in (library, bare)]  # kept: elements do not keep them
    ours, theirs = (generate(renderable_elements(d)[0], "glsl", data).sources["pixel"] for d, data in documents)
    assert ours == theirs
    assert "mrm_dielectric_bsdf(" in ours or "mrm_generalized_schlick_bsdf(" in ours


@pytest.mark.parametrize("form", ["plain", "usd"])
def test_the_file_says_where_it_comes_from_and_names_no_path(request, form):
    text = (request.getfixturevalue(form) / "mrm" / MODELS_FILE).read_text(encoding="utf-8")
    assert models_version(text) == mx.getVersionString()
    assert models_version(text.replace("mrm library", "hand")) == ""
    assert "Apache" in text
    assert "/libraries" not in text
    assert "xi:include" not in text


# The flag, where MaterialX has none.


def standard_with(flagged: str) -> mx.Document:
    """A standard library without the flag, as a host reads it before ours."""
    document = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
    for node in MICROFACET_NODES:
        document.getNodeDef(f"ND_{node}").removeInput("retroreflective")
    part = mx.createDocument()
    mx.readFromXmlString(part, flagged)
    document.importLibrary(part)
    return document


@pytest.mark.parametrize("version", [v for v in FIRST_DEFINED if v < "1.39.5"])
@pytest.mark.parametrize("node", MICROFACET_NODES)
def test_a_document_with_the_flag_finds_a_definition_where_the_standard_library_comes_first(version, node):
    files = node_library_files(version)
    library = standard_with(flagged_definitions(files, version))
    document = mx.createDocument()
    document.setDataLibrary(library)
    flagged = document.addNode(node, "b", "BSDF")
    flagged.setInputValue("retroreflective", True)
    definition = flagged.getNodeDef()
    assert definition.getName() == f"ND_mrm_flagged_{node}"
    for target in ("genglsl", "genosl", "genmsl"):
        implementation = definition.getImplementation(target)
        assert implementation.getFunction() == f"mrm_{node}"
        assert Path(implementation.getFile()).parent.name in ("genglsl", "genosl")
        assert str(Path(implementation.getFile())).replace("genmsl/../", "") in files


def test_without_them_the_node_has_no_definition():
    library = standard_with("<materialx version='1.39'/>")
    document = mx.createDocument()
    document.setDataLibrary(library)
    flagged = document.addNode("conductor_bsdf", "b", "BSDF")
    flagged.setInputValue("retroreflective", True)
    assert flagged.getNodeDef() is None


def test_a_materialx_that_has_the_flag_needs_no_other_names(usd):
    assert flagged_definitions(node_library_files("1.39.5"), "1.39.5") == ""
    assert not (usd / "mrm" / FLAG_FILE).exists()


# The portable form.


@pytest.fixture(scope="module")
def portable(tmp_path_factory):
    """Folder of the portable form for hosts that choose a definition by its name."""
    return mrm.install_library(tmp_path_factory.mktemp("portable"), host="usd-26.08", form="portable").folder


def base_of(library: mx.Document, definition: str) -> set[str]:
    """The definitions of the microfacet nodes in the graph of a definition."""
    nodes = library.getNodeDef(definition).getImplementation("").getNodes()
    return {str(n.getNodeDef().getName()) for n in nodes if n.getCategory() in MICROFACET_NODES}


@pytest.mark.parametrize("order", ["os", "so"])
def test_the_lobes_of_stock_models_are_no_graphs_of_the_portable_form(portable, order):
    library = loaded(portable, order)
    assert library.validate() == (True, "")
    for model in SURFACE_MODELS:
        assert base_of(library, f"ND_{model.node}_surfaceshader") <= {f"ND_{node}" for node in MICROFACET_NODES}
        found = base_of(library, model.definition)
        assert found <= {f"ND_{node}" for node in MICROFACET_NODES}


def test_without_the_standard_definitions_they_would_be(portable):
    library = mx.createDocument()
    files = host_models.without_standard_nodes({"x.mtlx": (portable / "mrm" / "mrm_defs.mtlx").read_bytes()})
    mx.readFromXmlString(library, files["x.mtlx"].decode())
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    assert any("portable" in name for name in base_of(library, "ND_open_pbr_surface_surfaceshader"))


def test_the_doctor_knows_the_form_that_was_installed(portable, usd):
    for folder, form in ((portable, "portable"), (usd, "sources")):
        found = next(c for c in checks(HOSTS["usd-26.08"], "1.39.5", folder, None) if c.name == "library")
        assert (found.ok, found.found) == (True, f"for MaterialX 1.39.5, form {form}")


def test_the_doctor_knows_the_portable_form(portable, monkeypatch):
    houdini = HOSTS["houdini"]
    assert {c.name: c.ok for c in checks(houdini, "1.39.5", portable, None)} == {
        "variable": False, "folder": True, "library": True, "models": True, "host": None,
    }  # fmt: skip
    files = portable / "mrm" / "mrm_flag_ng.mtlx"
    before = files.read_text(encoding="utf-8")
    files.write_text(before.replace('value="0"', 'value="1"', 1), encoding="utf-8")
    assert {c.name: c.ok for c in checks(houdini, "1.39.5", portable, None)}["library"] is False
    files.write_text(before, encoding="utf-8")


# Read by other versions themselves.

LOAD = f"""
import sys
import MaterialX as mx

library = mx.createDocument()
mx.loadLibraries(["mrm"], mx.FileSearchPath(sys.argv[1]), library)
mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
valid, message = library.validate()
assert valid, message
for definition, node, amount in {[(m.definition, m.node, m.amount) for m in SURFACE_MODELS]!r}:
    document = mx.createDocument()
    document.importLibrary(library)
    ordinary = document.addNode(node, "ordinary", "surfaceshader")
    assert ordinary.getNodeDef().getName() == f"ND_{{node}}_surfaceshader", ordinary.getNodeDef().getName()
    for inner in library.getNodeDef(f"ND_{{node}}_surfaceshader").getImplementation("").getNodes():
        assert "portable" not in inner.getNodeDef().getName(), inner.getNodeDef().getName()
    asked = document.addNode(node, "asked", "surfaceshader")
    asked.setNodeDefString(definition)
    asked.setInputValue(amount, 0.5)
    assert asked.getNodeDef().getName() == definition
    assert asked.getNodeDef().getImplementation("").getName() == definition.replace("ND_", "NG_")
    valid, message = document.validate()
    assert valid, message
print(mx.getVersionString())
"""


@pytest.mark.versions
@pytest.mark.parametrize("form", ["sources", "portable"])
@pytest.mark.parametrize("host", ["plain", "usd-26.08"])
@pytest.mark.parametrize("version", ["1.39.0", "1.39.1", "1.39.2", "1.39.3", "1.39.4", "1.39.5"])
def test_the_library_is_valid_in_the_version_that_it_is_for(with_materialx, tmp_path, version, host, form):
    python = with_materialx(version)
    if form == "portable" and dialect(version).walks_every_path:
        with pytest.raises(mrm.ArgumentError, match=r"form: the portable form is for MaterialX 1\.39\.2 and later"):
            mrm.install_library(tmp_path, host=host, materialx=version, stdlib=python.parents[1], form=form)
        return
    mrm.install_library(tmp_path, host=host, materialx=version, stdlib=python.parents[1], form=form)
    done = subprocess.run([python, "-c", LOAD, str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout == f"{version}\n"


def test_models_of_a_library_without_any_are_no_file(tmp_path):
    class Empty:
        version = "1.39.5"

        @staticmethod
        def surface_models() -> mx.Document:
            return mx.createDocument()

    models = host_models.surface_models_for(Empty(), host_models.Choice.NAME)  # type: ignore[arg-type]
    assert models.text == ""
    assert [each.reason for each in models.extensions] == [f"this MaterialX has no '{m.node}'" for m in SURFACE_MODELS]
