"""The pictures of the asset browser, drawn into the sources of the extension: each material on a sphere at night."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import OpenImageIO as oiio

from mrm_mtlx.api.render import render
from mrm_mtlx.library import materials_folder

if TYPE_CHECKING:
    from collections.abc import Iterable

PREVIEWS = Path(__file__).parents[2] / "extensions" / "blender" / "previews"
# Pixels; Blender shows assets at 96 to 256.
SIZE = 128
# Degrees between light and eye: lobes of all widths are seen, and the sphere keeps its shape.
_LIGHT_DEG = 2.0


def draw_previews(paths: Iterable[Path] = ()) -> None:
    """Draw the picture of each ready material."""
    for path in paths or sorted(materials_folder().glob("*.mtlx")):
        target = PREVIEWS / f"{path.stem}.png"
        print(target.name, file=sys.stderr, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            drawn = Path(folder, target.name)
            render(path, output=drawn, shape="sphere", size=SIZE, light=_LIGHT_DEG)
            picture = oiio.ImageBuf(str(drawn))
            picture.specmod().erase_attribute("Software")
            picture.write(str(target))
