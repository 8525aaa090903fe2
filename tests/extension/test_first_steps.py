"""docs/hosts/blender.md, followed to the letter by a Blender that nobody has used before."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from tools.blender_extension.figures import ENGINES, SCENES, draw, first_steps, picture, spheres

if TYPE_CHECKING:
    from collections.abc import Mapping

# Values of a picture are sRGB, through the view transform of a new file: with the light at the camera the cube is
# beyond middle grey, and without its lobe, 0.007 of that, near black.
BRIGHT, DARK = 0.6, 0.25


@pytest.fixture(scope="module")
def drawn(blender, tmp_path_factory):
    folder = tmp_path_factory.mktemp("steps")
    draw(folder, ["licence_plate"], width=96, samples=4)
    return folder


@pytest.fixture
def page(repository) -> str:
    return " ".join((repository / "docs/hosts/blender.md").read_text(encoding="utf-8").split())


def of_the_cube(drawn, scene: str, engine: str) -> float:
    """The brightness of a front of the cube, which is in the middle of the picture."""
    pixels = picture(drawn / f"{scene}.{engine}.png")
    height, width, _ = pixels.shape
    return float(pixels[height // 2 : height // 2 + 4, int(width * 0.46) : int(width * 0.49)].mean())


@pytest.mark.parametrize("engine", ENGINES)
def test_the_steps_end_in_a_cube_that_shines_from_the_camera(drawn, engine):
    seen = {scene: of_the_cube(drawn, scene, engine) for scene in SCENES}
    assert seen["camera"] > BRIGHT
    assert max(seen["aside"], seen["off"]) < DARK  # this front looks away from the lamp


def test_the_figures_are_made_of_these_pictures(drawn, tmp_path):
    first_steps(drawn, tmp_path / "first.png")
    spheres(drawn, ["licence_plate"], tmp_path / "spheres.png")
    assert picture(tmp_path / "first.png").ndim == picture(tmp_path / "spheres.png").ndim == 3


def test_the_page_calls_things_as_blender_shows_them(page, files: Mapping[str, bytes]):
    sources = b"".join(text for name, text in files.items() if name.endswith((".py", ".json"))).decode()
    items = set(re.findall(r"Add > Retroreflective > ([^*]+)\*\*", page))
    assert items == {"Traffic cone collar", "Light at the Camera"}
    for label in (*items, "Irradiance", "Aligned", "Exact", "By Day", "Encapsulated beads"):
        assert f'"{label}"' in sources
        assert label in page
