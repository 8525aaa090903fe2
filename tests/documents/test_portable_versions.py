"""Portable documents in earlier versions of MaterialX, which know neither the flag nor this library."""

from __future__ import annotations

import json
import subprocess

import pytest

import mrm_mtlx as mrm
from mrm_mtlx.library import materials_folder

pytestmark = pytest.mark.versions

# A lobe under a layer, one by a mask, and a surface model with an amount.
MATERIALS = ("traffic_cone_collar", "embossed_foil", "segmented_trim")
# Nodes of the standard library that these versions have: whether each node of a document is one of them.
RESOLVE = """
import sys
import MaterialX as mx
library = mx.createDocument()
mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
for path in sys.argv[1:]:
    document = mx.createDocument()
    mx.readFromXmlFile(document, path)
    own = [e.getNamePath() for e in document.traverseTree() if e.isA(mx.Node)]
    document.importLibrary(library)
    for name in own:
        if document.getDescendant(name).getNodeDef() is None:
            print(name)
"""


@pytest.fixture(scope="module")
def converted(tmp_path_factory):
    """The portable forms of ready materials."""
    folder = tmp_path_factory.mktemp("portable")
    for name in MATERIALS:
        mrm.convert(materials_folder() / f"{name}.mtlx", folder / f"{name}.mtlx", portable=True)
    return folder


def resolved(python, *paths) -> list[str]:
    """Nodes of documents that the library of an environment has not."""
    command = [python, "-c", RESOLVE, *map(str, paths)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


@pytest.mark.parametrize("version", ["1.39.0", "1.39.1", "1.39.2", "1.39.3", "1.39.4"])
def test_every_node_is_one_of_the_version(with_materialx, converted, version):
    python = with_materialx(version)
    assert resolved(python, *sorted(converted.glob("*.mtlx"))) == []
    # One that it has not is seen.
    text = (converted / "embossed_foil.mtlx").read_text(encoding="utf-8")
    wrong = converted.parent / "wrong.mtlx"
    wrong.write_text(text.replace("<viewdirection ", "<eyedirection ").replace("</viewdirection>", "</eyedirection>"))
    (name,) = resolved(python, wrong)
    assert name.endswith("_viewdirection")


@pytest.mark.parametrize("version", ["1.39.2", "1.39.4"])
def test_they_draw_as_the_reference_has_them(mrm_with, converted, version):
    options = ("--library", "upstream", "--target", "glsl", "--samples", "512", "--format", "json")
    run = mrm_with(version, "validate", converted, *options)
    assert run.returncode == 0, run.stderr
    documents = json.loads(run.stdout)["documents"]
    assert [d["renderables"][0]["targets"]["glsl"]["status"] for d in documents] == ["pass"] * len(MATERIALS)


@pytest.mark.parametrize("version", ["1.39.2"])
def test_the_bounds_hold(mrm_with, version):
    run = mrm_with(version, "conformance", "--form", "portable", "--target", "glsl", "--samples", "512")
    assert run.returncode == 0, run.stdout
