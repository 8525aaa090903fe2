"""Materials to render, small pictures of them, and environments."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.engines.gl import ENGINE
from mrm_mtlx.render import picture

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.library import DataLibrary

# Pixels along a side: enough to see the shape, few enough to be drawn in a moment.
SIZE = 24


def tape(flag: str, alpha: str = "0.1, 0.1") -> str:
    """Grey paper under beads: a surface of two lobes, of which the flag turns one."""
    return (
        '<oren_nayar_diffuse_bsdf name="paper" type="BSDF"><input name="color" type="color3" value="0.2, 0.3, 0.4"/>'
        '</oren_nayar_diffuse_bsdf><generalized_schlick_bsdf name="beads" type="BSDF">'
        '<input name="color0" type="color3" value="0.3, 0.2, 0.1"/>'
        f'<input name="roughness" type="vector2" value="{alpha}"/>'
        f'<input name="retroreflective" type="boolean" value="{flag}"/></generalized_schlick_bsdf>'
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="beads"/>'
        '<input name="base" type="BSDF" nodename="paper"/></layer>'
    )


@pytest.fixture(scope="session")
def tape_nodes() -> Callable[..., str]:
    """Function from the flag and two widths, as text, to the nodes of a retroreflective tape."""
    return tape


@pytest.fixture(scope="module")
def rendered(gl, surface_document: Callable, library: DataLibrary, tmp_path_factory) -> Callable[..., Array]:
    """Function from BSDF nodes, as text, and settings to the picture's radiance, two samples per pixel and axis."""
    folder = tmp_path_factory.mktemp("textures")

    def draw(nodes: str, **changes: object) -> Array:
        document = surface_document(nodes)
        plain = {"shape": "sphere", "light_degrees": None, "size": SIZE, "environment": None, "compare": False}
        settings = picture.PictureOptions(**{**plain, **changes})
        return picture.render(document.getNode("m"), library, Reach.only(folder), settings, ENGINE)

    return draw
