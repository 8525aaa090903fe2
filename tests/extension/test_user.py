"""The extension in Blender: installed, clicked, rendered and removed, in sessions that a user might have."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from mrm_mtlx.library import materials_folder

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

MATERIAL, LABEL = "cats_eye", "Cats eye"
VARIABLE = "PXR_MTLX_PLUGIN_SEARCH_PATHS"
# A folder that a user has put into the variable.
THEIRS = "/opt/materialx"
# At the right sphere [W/m2].
IRRADIANCE = 0.003
MATERIALS = sorted(path.stem for path in materials_folder().glob("*.mtlx"))

# The means of the spheres, where the flag is on and where it is off. The lens returns 0.14 of the light within half a
# degree, 100 / sr at its peak; without the flag the socket's diffuse 0.04 is left, 0.013 / sr, and the mirror image of
# the light, which a sphere shows in 1e-4 of its disk.
BRIGHTER = 100.0
# The aligned lobe and that through the portal, of the sphere's mean: docs/osl.md has 1 % of the albedo to 60 degrees,
# and beyond is half of the disk's rim.
SAME_MEAN = 0.05


def steps(zipped: Path, folder: Path) -> list[tuple[str, dict[str, Any]]]:
    """A session from the installation to the removal."""
    picture = {name: str(folder / f"{name}.exr") for name in ("cycles", "exact", "storm", "off")}
    return [
        ("state", {}),
        ("install", {"archive": str(zipped)}),
        ("state", {}),
        ("scene", {}),
        ("click", {"operator": "write_library"}),
        ("counts", {}),
        ("click", {"operator": "add_material", "material": MATERIAL}),
        ("click", {"operator": "add_material", "sphere": 1, "material": MATERIAL}),
        ("click", {"operator": "add_material", "sphere": 0, "material": MATERIAL}),
        ("counts", {}),
        ("set_sockets", {"sphere": 0, "label": "Retroreflective", "value": False}),
        ("describe", {"sphere": 0}),
        ("headlight", {"irradiance": IRRADIANCE}),
        ("render", {"engine": "CYCLES", "picture": picture["cycles"]}),
        ("render", {"engine": "HYDRA_STORM", "picture": picture["storm"]}),
        ("click", {"operator": "set_mode", "sphere": 0, "mode": "cycles"}),
        ("click", {"operator": "set_mode", "sphere": 1, "mode": "cycles"}),
        ("describe", {"sphere": 0}),
        ("render", {"engine": "CYCLES", "picture": picture["exact"]}),
        ("add_node", {}),
        ("counts", {}),
        ("assets", {}),
        ("drawn", {}),
        ("hook_off", {}),
        ("render", {"engine": "HYDRA_STORM", "picture": picture["off"]}),
        ("uninstall", {}),
        ("state", {}),
        ("leave_something", {}),
        ("state", {}),
    ]


NAMES = (
    "before",
    "installed",
    "with it",
    "scene",
    "library",
    "with library",
    "no object",
    "right",
    "left",
    "two materials",
    "switched off",
    "material",
    "light",
    "cycles",
    "storm",
    "exact on the left",
    "exact on the right",
    "material, exact",
    "exact",
    "node",
    "with node",
    "assets",
    "drawn",
    "hook off",
    "off",
    "removed",
    "after",
    "planted",
    "with leftovers",
)


@pytest.fixture(scope="module")
def seen(session, blender, zipped, tmp_path_factory) -> Mapping[str, Any]:
    """What the steps of the session returned, by `NAMES`."""
    folder = tmp_path_factory.mktemp("pictures")
    return of(session(blender, steps(zipped, folder), **{VARIABLE: THEIRS}).answers)


def of(answers: list[Any]) -> dict[str, Any]:
    return dict(zip(NAMES, answers, strict=True))


def test_it_installs_into_menus_operators_and_asset_libraries(seen):
    assert seen["installed"] == ["FINISHED"]
    here = seen["with it"]
    assert set(here["operators"]) == {"add_headlight", "add_material", "add_node", "set_mode", "write_library"}
    assert set(here["menus"].values()) == {1}
    assert here["hooks"] == ["MRM_USD_hook"]
    assert [name for name, _ in here["libraries"]].count("Retroreflective Materials") == 1


def test_the_variable_keeps_what_a_user_has_put_there(seen):
    theirs, ours = seen["with it"]["variable"].split(":")
    assert theirs == THEIRS
    assert ours.endswith("/data/libraries/1.39.3")
    assert seen["after"]["variable"] == THEIRS


def test_the_asset_library_has_each_material_with_its_picture(seen):
    assert seen["library"] == ["FINISHED"]
    assert set(seen["with library"].values()) == {0}, "it was not made in the user's file"
    assert sorted(seen["assets"]) == sorted(name.replace("_", " ").capitalize() for name in MATERIALS)
    for known in seen["assets"].values():
        assert known["preview"] == [128, 128]
        assert known["tags"] == ["retroreflective"]


def test_one_click_gives_the_active_object_the_material(seen):
    assert seen["right"] == seen["left"] == ["FINISHED"]
    known = seen["material"]
    assert known["name"].startswith(LABEL)
    assert (known["shading_system"], known["export_method"]) == (True, "USD")
    assert known["panels"] == ["Aluminium", "Dark socket", "Polished glass", "Aluminised lens back", "Lens"]
    assert known["sockets"][-1] == ["Lens", "Mix"]
    # Both objects have a material of their own, and share the group and its script.
    assert (seen["two materials"]["materials"], seen["two materials"]["node_groups"]) == (2, 1)
    assert seen["two materials"]["texts"] == 1


def test_without_an_object_the_user_is_told(seen):
    assert seen["no object"] == "Error: Select an object that can have a material, such as a mesh"


def test_a_node_is_added_to_the_material_that_is_edited(seen):
    assert seen["node"] == ["FINISHED"]
    assert seen["with node"]["node_groups"] == seen["two materials"]["node_groups"] + 2  # the exact one, and this


def test_the_menus_have_each_material_and_the_panel_its_modes(seen):
    here = seen["drawn"]
    assert here["VIEW3D_MT_add"] == here["MATERIAL_MT_context_menu"] == [["MRM_MT_materials", {}]]
    assert here["NODE_MT_add"] == [["MRM_MT_nodes", {}]]
    for menu, operator in (("MRM_MT_materials", "mrm.add_material"), ("MRM_MT_nodes", "mrm.add_node")):
        assert [options["material"] for name, options in here[menu] if name == operator] == MATERIALS
    assert here["MRM_MT_materials"][-1] == ["mrm.add_headlight", {}]
    modes = [["mrm.set_mode", {"mode": mode}] for mode in ("aligned", "cycles")]
    # Storm has been the engine last, and lacks nothing.
    assert here["MRM_PT_material"] == [*modes, ["mrm.add_headlight", {}]]


def test_the_light_hangs_on_the_camera(seen):
    assert (seen["light"]["parent"], seen["light"]["offset"]) == ("CAMERA", [0.0, 0.0, 0.0])
    assert seen["light"]["energy"] == pytest.approx(4.0 * np.pi * (1.1**2 + 8.0**2) * IRRADIANCE, rel=1e-5)  # float32


@pytest.mark.parametrize("engine", ["cycles", "exact", "storm"])
def test_it_retroreflects_where_its_switch_is_on(seen, engine):
    assert retroreflects(seen[engine])


def retroreflects(picture: Mapping[str, Any]) -> bool:
    left, right = (min(half) for half in picture["means"])
    return picture["finite"] and right > BRIGHTER * left


def test_without_the_hook_storm_shows_no_retroreflection(seen):
    """The planted error: the check above sees it."""
    assert not retroreflects(seen["off"])


def test_the_modes_of_cycles_agree_and_keep_the_values(seen):
    aligned, exact = (np.array(seen[name]["means"][1]) for name in ("cycles", "exact"))
    assert np.abs(aligned / exact - 1.0).max() < SAME_MEAN
    assert (aligned != exact).any()
    assert seen["material"]["values"] == seen["material, exact"]["values"]


def test_removal_leaves_nothing(seen):
    assert seen["removed"] == ["FINISHED"]
    before, after = (dict(seen[name]) for name in ("before", "after"))
    after["addons"].remove("hydra_storm")  # the session turned it on itself
    assert after == before
    assert seen["with leftovers"] != seen["after"], "and what is left would be seen"


@pytest.mark.large
def test_other_blenders_do_the_same(session, zipped, other_blenders, tmp_path):
    for number, interpreter in enumerate(other_blenders):
        folder = tmp_path / str(number)
        folder.mkdir()
        there = of(session(interpreter, steps(zipped, folder), **{VARIABLE: THEIRS}).answers)
        test_it_installs_into_menus_operators_and_asset_libraries(there)
        test_the_asset_library_has_each_material_with_its_picture(there)
        test_one_click_gives_the_active_object_the_material(there)
        for engine in ("cycles", "exact", "storm"):
            assert retroreflects(there[engine]), (interpreter, engine)
        test_without_the_hook_storm_shows_no_retroreflection(there)
        test_the_modes_of_cycles_agree_and_keep_the_values(there)
        test_removal_leaves_nothing(there)
