"""Pictures that a process has written."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.engines.base import EngineFailure

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray


def read_picture(path: Path, whose: str, layer: str = "") -> NDArray[np.float32]:
    """A picture, (height, width, RGBA), row 0 on top; the file is removed.

    Parameters
    ----------
    path
        An EXR file.
    whose
        What an error calls its maker, such as "Storm's".
    layer
        What the names of its channels begin with.

    Raises
    ------
    EngineFailure
        If it cannot be read.
    """
    import OpenImageIO as oiio

    image = oiio.ImageInput.open(str(path))
    pixels = None if image is None else image.read_image("float")
    if image is None or pixels is None:
        oiio.geterror()  # or it is printed at the end of the process
        raise EngineFailure(f"{whose} picture could not be read back; is the disk of temporary files full?")
    names = list(image.spec().channelnames)
    image.close()
    path.unlink()
    return np.stack([pixels[..., names.index(f"{layer}{c}")] for c in "RGBA"], axis=-1)
