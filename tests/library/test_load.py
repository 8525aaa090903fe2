"""Loading order: our implementations win, and the standard library can still be had alone."""

from __future__ import annotations

from pathlib import Path

import MaterialX as mx
import pytest

from mrm_mtlx.library import Origin, load_library, node_library_folder
from mrm_mtlx.library.dialects import VARIABLE
from mrm_mtlx.library.load import add_node_library, definitions_for, set_data_library
from mrm_mtlx.shadergen import TARGETS, available_targets

NODES = ("dielectric_bsdf", "conductor_bsdf", "generalized_schlick_bsdf")
NEW_NODES = (*NODES, "prismatic_weight", "cube_corner_share")
SURFACE_MODELS = ("open_pbr_surface", "standard_surface", "gltf_pbr")
# Those of the installed MaterialX.
HARDWARE = sorted(name for name in available_targets() if TARGETS[name].hardware)
OTHERS = sorted(name for name in available_targets() if not TARGETS[name].hardware and name != "osl")


def winner(document: mx.Document, node: str, target: str) -> str:
    """Function of the implementation that MaterialX takes for a node and a target's own name."""
    implementation = document.getNodeDef(f"ND_{node}").getImplementation(target)
    return str(implementation.getAttribute("function"))


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("target", ["genglsl", "essl", "genmsl", *(["genslang"] if "slang" in HARDWARE else [])])
def test_our_implementation_wins_for_every_target_of_the_glsl_family(library, node, target):
    assert winner(library.document, node, target) == f"mrm_{node}"


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("name", HARDWARE)
def test_our_implementation_wins_for_every_generator_of_the_glsl_family(library, node, name):
    assert winner(library.document, node, TARGETS[name].create().getTarget()) == f"mrm_{node}"


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("name", OTHERS)
def test_targets_without_an_implementation_of_ours_keep_the_stock_one(library, upstream_library, node, name):
    target = TARGETS[name].create().getTarget()
    assert winner(library.document, node, target) == winner(upstream_library.document, node, target)


@pytest.mark.parametrize(
    ("version", "folder"),
    [("1.39.0", "dialects/1.39.0/genglsl"), ("1.39.4", "dialects/1.39.3/genglsl"), ("1.39.5", "genglsl")],
)
def test_the_sources_of_a_dialect_are_used_where_they_lie(monkeypatch, version, folder):
    monkeypatch.setenv(VARIABLE, version)
    document = mx.createDocument()
    add_node_library(document)
    pbrlib = node_library_folder() / "pbrlib"
    hardware = [i for i in document.getImplementations() if i.getTarget() != "genosl"]
    assert {i.getTarget() for i in hardware} == ({"genglsl", "genmsl"} if version == "1.39.0" else {"genglsl"})
    assert {Path(i.getFile()).parent for i in hardware} == {pbrlib / folder}
    assert all(Path(i.getFile()).is_file() for i in document.getImplementations())


def test_a_document_gets_the_definitions_of_a_library(library):
    document = mx.createDocument()
    assert definitions_for(document) is document
    set_data_library(document, library.document)
    assert definitions_for(document).getNodeDef("ND_mrm_conductor_bsdf") is not None


@pytest.mark.parametrize("node", NODES)
def test_loaded_after_the_standard_library_ours_would_lose(upstream_library, node):
    late = upstream_library.document.copy()
    mx.loadLibraries(["pbrlib"], mx.FileSearchPath(str(node_library_folder())), late)
    assert winner(late, node, "genglsl") == f"mx_{node}"


def test_the_standard_library_is_complete_beside_ours(library, upstream_library):
    names = {d.getName() for d in upstream_library.document.getNodeDefs()}
    added = {d.getName() for d in library.document.getNodeDefs()} - names
    models = {f"ND_mrm_{model}_surfaceshader" for model in SURFACE_MODELS}
    assert added == models | {f"ND_mrm_{node}" for node in NEW_NODES}
    assert names <= {d.getName() for d in library.document.getNodeDefs()}
    stock = {i.getName() for i in upstream_library.document.getImplementations()}
    added = {i.getName() for i in library.document.getImplementations()} - stock
    assert added == {f"IM_mrm_{node}_gen{kind}" for node in NODES for kind in ("glsl", "osl")} | {
        "IM_mrm_surface_genosl"
    }


def test_the_loaded_library_is_valid(library):
    valid, message = library.document.validate()
    assert valid, message


def test_the_upstream_library_is_untouched(upstream_library):
    assert upstream_library.origin is Origin.UPSTREAM
    stock = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), stock)
    assert mx.writeToXmlString(upstream_library.document) == mx.writeToXmlString(stock)
    assert upstream_library.search_path.asString() == mx.getDefaultDataSearchPath().asString()
    assert "mrm_" not in mx.writeToXmlString(upstream_library.document)


def test_each_library_is_loaded_once():
    assert load_library() is load_library()
    assert load_library(Origin.UPSTREAM) is load_library(Origin.UPSTREAM)
    assert load_library(Origin.UPSTREAM) is not load_library(Origin.MRM)


def test_the_default_library_is_the_same_copy_as_the_one_asked_for_by_name():
    assert load_library() is load_library(Origin.MRM)


def test_no_file_of_ours_has_the_name_of_a_standard_one(upstream_library):
    # The includes of both are looked up on one path.
    stock = {
        path.asString().rpartition("/")[2]
        for root in mx.getDefaultDataLibraryFolders()
        for folder in upstream_library.search_path.find(root).getSubDirectories()
        for ending in ("mtlx", "glsl", "osl")
        for path in (folder / name for name in folder.getFilesInDirectory(ending))
    }
    ours = {path.name for path in node_library_folder().rglob("*") if path.is_file()} - {"README.md"}
    assert "mx_conductor_bsdf.glsl" in stock
    assert ours
    assert not ours & stock
