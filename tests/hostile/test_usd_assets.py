"""Names of files in stages, of every form and in every place: nothing outside the folder is opened for any of them."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import zipfile

import pytest
from pxr import Sdf

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.usd import read
from mrm_mtlx.formats.usd.opening.stage import open_stage

HEAD = "#usda 1.0\n"
# Names of the layer outside, or of one in a package outside, as attributes and arcs may have them.
FORMS = ["{out}/secret.usda", "{out}/pk.usdz", "{out}/pk.usdz[s.usda]", "{out}/secret.usda:SDF_FORMAT_ARGS:a=b"]
RELATIVE = [form.replace("{out}", "../outside") for form in FORMS]
# Where a layer may name another, which USD opens when it composes.
ARCS = {
    "sublayer": HEAD + "(\n subLayers = [@{}@]\n)\n",
    "reference": HEAD + 'def "a" (\n references = @{}@</A>\n) {{\n}}\n',
    "payload": HEAD + 'def "a" (\n payload = @{}@\n) {{\n}}\n',
    "payload in a variant": HEAD + 'def "a" (\n prepend variantSets = "v"\n) {{\n variantSet "v" = {{\n "w" (\n '
    "payload = @{}@\n ) {{\n }}\n }}\n}}\n",
    "clips": HEAD + 'def "a" (\n clips = {{\n dictionary d = {{\n asset manifestAssetPath = @{}@\n }}\n }}\n) {{\n}}\n',
    "attribute": HEAD + 'def "a" {{\n asset x = @{}@\n}}\n',
    "attribute at times": HEAD + 'def "a" {{\n asset x.timeSamples = {{\n 1: @{}@\n }}\n}}\n',
    "array": HEAD + 'def "a" {{\n asset[] x = [@{}@]\n}}\n',
}
# Where names stand that no part of USD follows here.
METADATA = {
    "customData": HEAD + 'def "a" (\n customData = {{\n asset x = @{}@\n }}\n) {{\n}}\n',
    "assetInfo": HEAD + 'def "a" (\n assetInfo = {{\n asset identifier = @{}@\n }}\n) {{\n}}\n',
    "layer's own": HEAD + "(\n customLayerData = {{\n asset x = @{}@\n }}\n)\n",
    "colour": HEAD + "(\n colorConfiguration = @{}@\n)\n",
    "attribute's": HEAD + 'def "a" {{\n float x = 1 (\n customData = {{\n asset y = @{}@\n }}\n )\n}}\n',
}


@pytest.fixture
def opened(library, tmp_path):
    """Function from a file to what is read of it, in a folder of its own for what is unpacked."""

    def run(path):
        scratch = tmp_path / "scratch"
        shutil.rmtree(scratch, ignore_errors=True)
        scratch.mkdir()
        return read(path, Reach.beside(path), library, scratch)

    return run


@pytest.fixture
def outside(place):
    """A package with a layer beside the secrets."""
    with zipfile.ZipFile(place.outside / "pk.usdz", "w") as package:
        package.writestr("s.usda", place.secrets[".usda"].read_text(encoding="utf-8"))
    return place.outside


@pytest.mark.parametrize("arc", ARCS)
@pytest.mark.parametrize("form", FORMS + RELATIVE)
def test_a_layer_outside_is_refused_whatever_the_form_of_its_name(place, outside, opened, arc, form):
    path = place.write("s.usda", ARCS[arc].format(form.format(out=outside)))
    with pytest.raises(ReadError) as caught:
        opened(path)
    assert caught.value.finding.code == "READ_OUTSIDE"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
@pytest.mark.parametrize("where", METADATA | {"image": HEAD + 'def "a" {{\n asset x = @{}@\n}}\n'})
@pytest.mark.parametrize("suffix", [".usda", ".usdz", ".usdz[s.usda]", ".png", ".<UDIM>.png"])
def test_a_name_that_is_not_followed_opens_nothing(place, pipe, opened, where, suffix):
    made = pipe(place.folder / f"p{suffix.replace('<UDIM>', '1001').removesuffix('[s.usda]')}")
    text = (METADATA | {"image": HEAD + 'def "a" {{\n asset x = @{}@\n}}\n'})[where]
    path = place.write("s.usda", text.format(made.path if "UDIM" not in suffix else f"./p{suffix}"))
    with contextlib.suppress(ReadError):  # a pipe for a package
        opened(path)


def test_a_layer_in_the_current_folder_or_on_usds_search_path_is_not_found(place, opened, monkeypatch):
    """USD looks there for names that do not begin with a point."""
    (place.outside / "b.usda").write_text(HEAD + 'def "A" {\n}\n')
    monkeypatch.chdir(place.outside)
    path = place.write("s.usda", HEAD + 'def "a" (\n references = @b.usda@</A>\n) {\n}\n')
    (finding,) = [finding for finding in opened(path).findings if finding.code == "USD_MISSING"]
    assert finding.location == "/a"
    code = "import sys, pathlib; from mrm_mtlx.formats.reading import read_document\n"
    code += "from mrm_mtlx.library import load_library\n"
    code += "from mrm_mtlx.documents.files import Reach\n"
    code += "path, scratch = map(pathlib.Path, sys.argv[1:])\n"
    code += "print(read_document(path, Reach.beside(path), load_library(), scratch).findings)"
    (place.folder.parent / "empty").mkdir()
    environment = os.environ | {"PXR_AR_DEFAULT_SEARCH_PATH": str(place.outside)}
    command = [sys.executable, "-c", code, str(path), str(place.folder.parent / "empty")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert "USD_MISSING" in done.stdout


def test_a_layer_of_a_package_names_what_is_in_the_package_alone(place, opened):
    """What lies beside the package, or above it, is not in it."""
    place.write("b.usda", HEAD + 'def "A" {\n}\n')
    for name, code in (("./b.usda", "USD_MISSING"), ("../b.usda", "READ_OUTSIDE"), ("in.usda", "")):
        with zipfile.ZipFile(place.folder / "p.usdz", "w") as package:
            package.writestr("sub/s.usda", HEAD + f'def "a" (\n references = @{name}@</A>\n) {{\n}}\n')
            package.writestr("in.usda", HEAD + 'def "A" {\n}\n')
        if name == "../b.usda":
            name = "../../b.usda"
            with zipfile.ZipFile(place.folder / "p.usdz", "w") as package:
                package.writestr("sub/s.usda", HEAD + f'def "a" (\n references = @{name}@</A>\n) {{\n}}\n')
            with pytest.raises(ReadError) as caught:
                opened(place.folder / "p.usdz")
            assert caught.value.finding.code == code
            continue
        codes = [r.code for r in opened(place.folder / "p.usdz").findings if not r.code.startswith("USD_VALID")]
        assert codes == ([code] if code else [])


def test_packages_in_packages_are_opened_and_bounded(place, opened):
    with zipfile.ZipFile(place.folder / "inner.usdz", "w") as package:
        package.writestr("x.usda", HEAD + 'def Scope "A" {\n}\n')
        package.writestr("y.usda", HEAD + 'def Scope "A" {\n}\n')
    with zipfile.ZipFile(place.folder / "p.usdz", "w") as package:
        package.writestr("s.usda", HEAD + 'def "a" (\n references = @./inner.usdz@</A>\n) {\n}\n')
        package.write(place.folder / "inner.usdz", "inner.usdz")
    for name in ("./p.usdz", "./p.usdz[inner.usdz]", "./p.usdz[inner.usdz[y.usda]]"):
        path = place.write("s.usda", HEAD + f'def "a" (\n references = @{name}@</a>\n) {{\n}}\n')
        assert "USD_MISSING" not in {finding.code for finding in opened(path).findings}
    path = place.write("s.usda", HEAD + 'def "a" (\n references = @./p.usdz[inner.usdz[../../z.usda]]@\n) {\n}\n')
    with pytest.raises(ReadError) as caught:
        opened(path)
    assert caught.value.finding.code == "READ_OUTSIDE"


def test_a_link_in_the_folder_to_a_layer_outside_is_refused(place, opened, link):
    link(place.folder / "b.usda", place.secrets[".usda"])
    path = place.write("s.usda", HEAD + 'def "a" (\n references = @b.usda@\n) {\n}\n')
    with pytest.raises(ReadError) as caught:
        opened(path)
    assert caught.value.finding.code == "READ_OUTSIDE"


@pytest.mark.parametrize("arc", ["reference", "attribute"])
def test_an_expression_that_could_name_a_file_in_a_package_is_refused(place, opened, arc):
    path = place.write("s.usda", ARCS[arc].format('`"${X}.usdz[s.usda]"`'))
    with pytest.raises(ReadError) as caught:
        opened(path)
    assert caught.value.finding.code == "READ_INCLUDE"
    text = HEAD + '(\n expressionVariables = {{\n string X = {}\n }}\n)\ndef "a" {{\n asset x = @`"${{X}}"`@\n}}\n'
    with pytest.raises(ReadError) as caught:
        opened(place.write("s.usda", text.format('"../outside/pk.usdz[s.usda]"')))
    assert caught.value.finding.code == "READ_INCLUDE"
    opened(place.write("s.usda", text.format('"t.png"')))


def test_a_crate_that_has_a_name_of_a_file_in_the_place_of_a_number_opens_nothing(place, opened, pipe):
    """USD's text cannot say so; a crate can, and USD resolves whatever value it is asked for."""
    made = pipe(place.folder / "p.usdz")
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    attribute = Sdf.AttributeSpec(Sdf.CreatePrimInLayer(layer, "/a"), "x", Sdf.ValueTypeNames.Asset)
    attribute.default = Sdf.AssetPath(f"{made.path}[s.usda]")
    layer.Export(str(place.folder / "s.usdc"))
    content = (place.folder / "s.usdc").read_bytes()
    with pytest.raises(ReadError) as caught:
        opened(place.folder / "s.usdc")
    assert (caught.value.finding.code, b"asset" in content) == ("READ_FAILED", True)
    (place.folder / "s.usdc").write_bytes(content.replace(b"asset", b"float"))
    with pytest.raises(ReadError) as caught:
        opened(place.folder / "s.usdc")
    assert caught.value.finding.code == "READ_FAILED"


def test_a_deletion_of_a_reference_that_is_there_counts_and_one_of_a_file_outside_opens_nothing(place, opened):
    place.write("b.usda", HEAD + 'def Material "A" {\n token outputs:mtlx:surface\n}\n')
    under = HEAD + 'def "a" (\n references = @./b.usda@</A>\n) {\n}\n'
    place.write("under.usda", under)
    over = HEAD + '(\n subLayers = [@./under.usda@]\n)\nover "a" (\n delete references = @{}@</A>\n) {{\n}}\n'
    assert opened(place.write("s.usda", over.format("b.usda"))).materialx.getMaterialNodes() == []
    assert len(opened(place.write("s.usda", over.format("../outside/secret.usda"))).materialx.getMaterialNodes()) == 1


def test_offsets_of_sublayers_stay(place, library):
    place.write(
        "b.usda", HEAD + 'over "M" {\n over "s" {\n float inputs:opacity.timeSamples = {\n 0: 0.5,\n 9: 1\n }\n }\n}\n'
    )
    text = (
        HEAD + "(\n subLayers = [@./gone.usda@ (offset = 5), @./b.usda@ (offset = 100)]\n)\n" + 'def Material "M" {\n'
    )
    text += ' token outputs:mtlx:surface.connect = </M/s.outputs:out>\n def Shader "s" {\n'
    text += ' uniform token info:id = "ND_surface"\n float inputs:opacity = 0.25\n token outputs:out\n }\n}\n'
    empty = place.folder.parent / "empty"
    empty.mkdir()
    path = place.write("s.usda", text)
    stage = open_stage(path, Reach.only(place.folder), empty, library).stage
    layer = stage.GetRootLayer()
    assert [offset.offset for offset in layer.subLayerOffsets] == [5.0, 100.0]


def test_clips_inside_the_folder_are_not_left_to_usd_either(place, library, tmp_path):
    """It looks for their files when it composes, whatever a template means by then."""
    place.write("clip.usda", HEAD)
    path = place.write("s.usda", ARCS["clips"].format("./clip.usda"))
    (tmp_path / "empty").mkdir()
    opened = open_stage(path, Reach.only(place.folder), tmp_path / "empty", library)
    assert [finding.code for finding in opened.findings] == ["INTERCHANGE_LOST"]
    assert not opened.stage.GetPrimAtPath("/a").HasAuthoredMetadata("clips")
