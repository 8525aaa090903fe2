"""What Storm makes of a stage in a host that has the library as it is installed for it: shaders, and a picture."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.library.hosts import HOSTS
from tools.hosts_picture.drawing import CENTRES, blender, draw, write_stage

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.large

# Beside the highlight of a sphere, a lobe that is turned back returns many times what the ordinary one does.
BRIGHTER = 3.0


@pytest.fixture(scope="module")
def host(gl, cycles):
    found = blender(os.environ.get("MRM_OSL_PYTHON") or sys.executable)
    if found.host not in HOSTS:
        pytest.skip(f"there is no host {found.host}")
    return found


@pytest.fixture(scope="module")
def drawn(host, tmp_path_factory):
    """Function from a document of a stage, and the host that the library is written for, to shaders and brightness."""

    def draw_with(file: str, written_for: str) -> tuple[list[str], np.ndarray]:
        folder = tmp_path_factory.mktemp("drawn")
        version = HOSTS[host.host].materialx
        library = mrm.install_library(folder / "hosts", host=written_for, materialx=version, stdlib=host.folder)
        variable = mrm.InstalledLibrary(
            **{**vars(library), "variable": HOSTS[host.host].variable, "value": str(library.folder)}
        )
        shaders = draw(host, variable, write_stage(folder, file), folder / "picture.png")
        return shaders, brightness(folder / "picture.png")

    return draw_with


def brightness(path: Path) -> np.ndarray:
    """Mean of each sphere, beside its middle."""
    image = plt.imread(path)[..., :3]
    height, width = image.shape[:2]
    radius = int(0.4 * width * (CENTRES[1] - CENTRES[0]) / 2.2 * 2.0)
    row = slice(height // 2 - 3, height // 2 + 3)
    return np.array([image[row, int(x * width) + radius // 2 : int(x * width) + radius].mean() for x in CENTRES])


def check(shaders: list[str], seen: np.ndarray) -> None:
    """The model with the input is ours, the other the host's own, and what is turned back is seen to be."""
    assert sum("NG_mrm_open_pbr_surface" in shader for shader in shaders) == 1
    assert sum("NG_open_pbr_surface_surfaceshader" in shader for shader in shaders) == 1
    assert sum("mrm_conductor_bsdf" in shader for shader in shaders) >= 1
    assert seen[1] > BRIGHTER * seen[0]
    assert seen[3] > BRIGHTER * seen[2]


def test_stock_models_stay_stock_and_ours_are_ours_in_documents_and_stages(host, drawn):
    (shaders, usda), (_, mtlx) = drawn("spheres.usda", host.host), drawn("spheres.mtlx", host.host)
    check(shaders, usda)
    assert usda == pytest.approx(mtlx, abs=1.0 / 255.0)  # a rounding of the picture's bytes


def test_models_that_are_chosen_by_their_inputs_would_be_seen(drawn):
    shaders, seen = drawn("spheres.usda", "plain")
    with pytest.raises(AssertionError):
        check(shaders, seen)
    assert not any("NG_mrm_open_pbr_surface" in shader for shader in shaders)
