"""What Blender's own MaterialX and Storm make of the materials."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from mrm_mtlx.library import materials_folder

if TYPE_CHECKING:
    from pathlib import Path

MATERIALS = sorted(path.stem for path in materials_folder().glob("*.mtlx"))
# What Storm shows for what it has no shader of, magenta, has this share of the red in its green.
MAGENTA = 0.1
# Of the brightest channel. Storm has a twentieth less green than Cycles of the light that Blender hands it, which is
# 0.06 at most in these pictures, by Blender 5.0.
SAME_HUE = 0.08


@pytest.fixture
def networks(files, tmp_path) -> Path:
    """A folder with the networks."""
    folder = tmp_path / "networks"
    folder.mkdir()
    for name in MATERIALS:
        (folder / f"{name}.usda").write_bytes(files[f"data/networks/{name}.usda"])
    return folder


def test_blender_takes_the_zip_and_knows_every_node(session, blender, zipped, networks):
    validated, _, nodes = session(
        blender,
        [
            ("validate", {"archive": str(zipped)}),
            ("install", {"archive": str(zipped)}),
            ("undefined", {"folder": str(networks)}),
        ],
    ).answers
    assert validated == 0
    assert nodes == [len(MATERIALS), []]


def test_a_node_that_blender_does_not_know_is_seen(session, blender, zipped, networks):
    path = networks / "cats_eye.usda"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("ND_artistic_ior", "ND_artists_ior").replace("inputs:mix", "inputs:mixed"))
    _, nodes = session(
        blender, [("install", {"archive": str(zipped)}), ("undefined", {"folder": str(networks)})]
    ).answers
    assert nodes[1] == ["cats_eye.usda: ND_artists_ior", "cats_eye.usda: ND_mix_bsdf mixed"]


def test_a_folder_that_cannot_be_is_told_and_costs_no_more_than_the_asset_library(session, blender, zipped):
    install, add = (
        ("install", {"archive": str(zipped)}),
        {"operator": "add_material", "sphere": 1, "material": "cats_eye"},
    )
    write = ("click", {"operator": "write_library"})
    told = session(blender, [("block_library", {}), install, ("scene", {}), write, ("click", add), ("uninstall", {})])
    assert told.answers[3] == "Error: Blender cannot make the folder of the asset library; its message has the reason"
    assert told.answers[4] == told.answers[5] == ["FINISHED"]
    assert "Traceback" not in told.log


@pytest.mark.large
def test_every_material_is_drawn_by_both_engines(session, blender, zipped, tmp_path):
    drawn = gallery(session, blender, zipped, tmp_path)
    assert_drawn(drawn)


@pytest.mark.large
def test_every_material_is_drawn_by_other_blenders(session, other_blenders, zipped, networks, tmp_path):
    for number, interpreter in enumerate(other_blenders):
        folder = tmp_path / str(number)
        folder.mkdir()
        assert_drawn(gallery(session, interpreter, zipped, folder))
        install = ("install", {"archive": str(zipped)})
        _, nodes = session(interpreter, [install, ("undefined", {"folder": str(networks)})]).answers
        assert nodes == [len(MATERIALS), []]


def gallery(session, interpreter: str, zipped: Path, folder: Path) -> dict[tuple[str, str], dict[str, Any]]:
    """Each material in each engine, on the right sphere."""
    wanted = [(name, engine) for name in MATERIALS for engine in ("CYCLES", "HYDRA_STORM")]
    steps: list[tuple[str, dict[str, Any]]] = [("install", {"archive": str(zipped)})]
    for name, engine in wanted:
        picture = str(folder / f"{name}.{engine}.exr")
        steps += [
            ("scene", {}),
            ("click", {"operator": "add_material", "sphere": 1, "material": name}),
            ("headlight", {"irradiance": 0.05}),
            ("render", {"engine": engine, "picture": picture, "width": 64}),
        ]
    return dict(zip(wanted, session(interpreter, steps).answers[4::4], strict=True))


def assert_drawn(drawn: dict[tuple[str, str], dict[str, Any]]) -> None:
    """Neither black, nor not finite, nor magenta, and of the same hue in both engines."""
    for (name, engine), picture in drawn.items():
        red, green, blue = picture["means"][1]
        assert picture["finite"], (name, engine)
        assert max(red, green, blue) > 1e-3, (name, engine)
        assert not (green < MAGENTA * red and green < MAGENTA * blue), (name, engine)
    for name in {name for name, _ in drawn}:
        cycles, storm = (hue(drawn[name, engine]) for engine in ("CYCLES", "HYDRA_STORM"))
        assert storm == pytest.approx(cycles, abs=SAME_HUE), name


def hue(picture: dict[str, Any]) -> list[float]:
    """The channels of the right sphere, of the brightest."""
    return [channel / max(picture["means"][1]) for channel in picture["means"][1]]


@pytest.mark.parametrize("wrong", [[1.0, 0.05, 1.0], [1e-4, 1e-4, 1e-4], [1.0, 1.0, 0.9]])
def test_a_picture_that_is_magenta_black_or_of_another_hue_is_seen(wrong):
    right = {"means": [[], [3.0, 2.9, 3.0]], "finite": True}
    assert_drawn({("a", "CYCLES"): right, ("a", "HYDRA_STORM"): right})
    with pytest.raises(AssertionError):
        assert_drawn({("a", "CYCLES"): right, ("a", "HYDRA_STORM"): {**right, "means": [[], wrong]}})
