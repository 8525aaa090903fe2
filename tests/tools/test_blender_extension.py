"""The Blender extension as it is built: the same zip each time, accepted by Blender, with what its parts need."""

from __future__ import annotations

import json
import tomllib
import zipfile
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from pxr import Sdf

from mrm_mtlx.documents.images import read_image
from mrm_mtlx.library import materials_folder
from mrm_mtlx.library.assembly import node_library_files
from mrm_mtlx.system.versions import __version__
from tools.blender_extension import previews
from tools.blender_extension.__main__ import main
from tools.blender_extension.archive import archive
from tools.blender_extension.contents import VERSIONS, contents

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

PREVIEWS = previews.PREVIEWS
# Of a picture's values: drivers differ by a step of 8 bits in some of its pixels.
ROUNDINGS = 1.0 / 255.0
MATERIALS = sorted(path.stem for path in materials_folder().glob("*.mtlx"))


@pytest.fixture(scope="module")
def files() -> Mapping[str, bytes]:
    return contents()


@pytest.fixture(scope="module")
def described(files) -> Mapping[str, Any]:
    return {each["name"]: each for each in json.loads(files["data/materials.json"])}


def attributes(text: bytes) -> Iterator[tuple[str, Any]]:
    """Names of a layer's attributes below its material, and their values."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text.decode())
    (material,) = layer.GetPrimAtPath("/Materials").nameChildren

    def below(prim: Sdf.PrimSpec) -> Iterator[tuple[str, Any]]:
        for each in prim.attributes:
            yield str(each.path.MakeRelativePath(material.path)), each.default
        for child in prim.nameChildren:
            yield from below(child)

    yield from below(material)


def test_the_command_writes_the_zip(tmp_path, capsys):
    assert main(["-o", str(tmp_path)]) == 0
    path = tmp_path / f"mrm-blender-{__version__}.zip"
    assert capsys.readouterr().out == f"{path}\n"
    assert zipfile.is_zipfile(path)


def test_a_folder_that_cannot_be_is_named(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main(["-o", str(tmp_path / "file" / "folder")]) == 2
    assert capsys.readouterr().err == f"{tmp_path}/file/folder: Not a directory\n"


def test_the_same_files_make_the_same_zip(files):
    assert archive(files) == archive(dict(reversed(list(contents().items()))))


def test_the_zip_has_what_the_extension_reads(files):
    names = zipfile.ZipFile(BytesIO(archive(files))).namelist()
    manifest = tomllib.loads(files["blender_manifest.toml"].decode())
    assert (manifest["version"], manifest["license"]) == (__version__, ["SPDX:Apache-2.0"])
    assert "permissions" not in manifest
    for name in MATERIALS:
        assert {f"data/scripts/{name}.osl", f"data/networks/{name}.usda", f"previews/{name}.png"} < set(names)
    assert not [name for name in names if "__pycache__" in name or name.startswith("/")]


@pytest.mark.parametrize("version", ["1.39.0", "1.39.1", "1.39.2", "1.39.3", "1.39.4", "1.39.5"])
def test_each_materialx_finds_the_library_in_its_form(files, version):
    chosen = max(folder for folder in VERSIONS if folder <= version)
    below = f"data/libraries/{chosen}/mrm/"
    there = {name.removeprefix(below): text for name, text in files.items() if name.startswith(below)}
    wanted = dict(node_library_files(version))
    # 1.39.0 wants a list for MSL that later ones inherit: the same implementations, said twice.
    there = {name: text for name, text in there.items() if name in wanted or not name.startswith("genmsl/")}
    assert there == wanted


@pytest.mark.parametrize("name", MATERIALS)
def test_a_script_needs_nothing_beside_it(files, repository, name):
    source = files[f"data/scripts/{name}.osl"].decode()
    assert "#include" not in source
    assert str(repository) not in source
    assert "MRM_OSL_MODE" in source


@pytest.mark.parametrize("name", MATERIALS)
def test_the_sockets_set_attributes_of_the_network_that_have_their_values(files, described, name):
    values = dict(attributes(files[f"data/networks/{name}.usda"]))
    source = files[f"data/scripts/{name}.osl"].decode()
    assert described[name]["sockets"]
    for socket in described[name]["sockets"]:
        known, default = values[socket["attribute"]], socket["default"]
        if socket["type"] == "color" or not hasattr(known, "__len__"):
            assert known == pytest.approx(default, rel=1e-6)  # float32
        else:
            assert [known[index] for index in socket["components"]] == pytest.approx(
                [default] * len(socket["components"])
            )
        assert f" {socket['name']} = " in source


def test_a_surface_model_comes_as_its_graph(files):
    identifiers = [value for name, value in attributes(files["data/networks/segmented_trim.usda"]) if "info:id" in name]
    assert "ND_mrm_dielectric_bsdf" in identifiers
    assert not [each for each in identifiers if "open_pbr_surface" in each]


def test_the_colour_by_day_is_that_of_the_reference(described):
    # The README of the materials has the luminance factor, 3.3 and 48.4 %.
    grey = {name: described[name]["by_day"][1] for name in ("cats_eye", "traffic_cone_collar")}
    assert grey == pytest.approx({"cats_eye": 0.033, "traffic_cone_collar": 0.484}, abs=5e-4)
    red, green, blue = described["prismatic_tape_orange"]["by_day"]
    assert red > green > blue


def test_a_preview_is_the_picture_that_is_drawn_again(gl, tmp_path, monkeypatch):
    monkeypatch.setattr(previews, "PREVIEWS", tmp_path)
    previews.draw_previews([materials_folder() / "cats_eye.mtlx"])
    again, kept = (read_image(folder / "cats_eye.png") for folder in (tmp_path, PREVIEWS))
    assert again.shape == (previews.SIZE, previews.SIZE, 3)
    assert np.abs(again - kept).mean() < ROUNDINGS
