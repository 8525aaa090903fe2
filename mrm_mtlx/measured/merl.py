"""Reader of the binary format of the MERL BRDF database (Matusik et al. 2003).

Three little-endian 32-bit integers, 90, 90 and 180, then 3 x 90 x 90 x 180 little-endian doubles: the red samples, then
the green, then the blue. In each, the angle phi_d runs fastest, then theta_d, then theta_h. With h the half-vector of l
and v, theta_h is its angle from the normal, and (theta_d, phi_d) is l in the frame of h (Rusinkiewicz 1998). Samples
stand for intervals, here for their middles:

    theta_h = (i + 1/2)^2 / 90 degrees        theta_d = j + 1/2 degrees        phi_d = k + 1/2 degrees

phi_d covers half a turn, as f(v, l) = f(l, v). A number times 1/1500, 1.15/1500 or 1.66/1500 (red, green, blue) is f in
1/sr. What is negative was not measured.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.measured.measurement import GRAZING, Measurement
from mrm_mtlx.measured.text import LineError, located, opened

if TYPE_CHECKING:
    from pathlib import Path
    from typing import BinaryIO

    from mrm_mtlx.bsdf.arrays import Array

# Numbers of theta_h, theta_d, phi_d.
SHAPE = (90, 90, 180)
SCALE = np.array([1.0, 1.15, 1.66]) / 1500.0

_HEADER = struct.Struct("<3i")
_SAMPLES = SHAPE[0] * SHAPE[1] * SHAPE[2]
BYTES = _HEADER.size + 3 * 8 * _SAMPLES


def read_merl(path: Path) -> Measurement:
    """Read an isotropic BRDF of the MERL database.

    Parameters
    ----------
    path
        A regular file.

    Returns
    -------
    Measurement
        Its samples with both directions above the horizon and all channels measured, f in 1/sr, three channels. A full
        file has some 1.1 million.

    Raises
    ------
    ValueError
        With the name of the file, if its header has other sizes, if it is shorter or longer than these ask, if a number
        is not finite, or if no sample is valid.
    OSError
        If the file cannot be opened.
    """
    with opened(path, BYTES + 2**20) as stream, located(path):
        return _measurement(stream, path.stem, path.stat().st_size)


def is_merl(head: bytes) -> bool:
    """True if a file that begins so has the sizes of this format."""
    return len(head) >= _HEADER.size and _HEADER.unpack_from(head) == SHAPE


def _measurement(stream: BinaryIO, name: str, size: int) -> Measurement:
    head = stream.read(_HEADER.size)
    if len(head) < _HEADER.size:
        raise LineError(0, f"{len(head)} bytes; expected the binary format of MERL, {BYTES} bytes")
    sizes = _HEADER.unpack(head)
    if sizes != SHAPE:
        found, expected = (" x ".join(map(str, numbers)) for numbers in (sizes, SHAPE))
        raise LineError(0, f"the header announces {found} samples; the binary format of MERL has {expected}")
    if size != BYTES:
        state = "truncated" if size < BYTES else "too long"
        raise LineError(0, f"{state}: {size} bytes; the header asks for {BYTES}")
    numbers = np.frombuffer(stream.read(), dtype="<f8").reshape(3, _SAMPLES)
    if not np.all(np.isfinite(numbers)):
        channel, index = np.argwhere(~np.isfinite(numbers))[0]
        i, j, k = np.unravel_index(index, SHAPE)
        place = f"channel {'RGB'[channel]}, theta_h {i}, theta_d {j}, phi_d {k}"
        raise LineError(0, f"{numbers[channel, index]} is no finite number, at {place}")
    theta_l, theta_v, dphi = (angle.ravel() for angle in angles())
    above = np.maximum(theta_l, theta_v) < np.pi / 2 - GRAZING
    valid = above & np.all(numbers >= 0.0, axis=0)
    if not valid.any():
        raise LineError(0, "every sample is negative, which means not measured")
    f = numbers[:, valid].T * SCALE
    return Measurement(name, theta_l[valid], theta_v[valid], dphi[valid], f)


def angles() -> tuple[Array, Array, Array]:
    """theta_l, theta_v, dphi [rad] of all samples, each of shape `SHAPE`; see `Measurement`.

    With h at azimuth 0, l = Ry(theta_h) d and v = Ry(theta_h) d', where d has the angles theta_d and phi_d and d' is d
    turned by half a turn: the reflection of l at h.
    """
    i, j, k = (np.arange(n) + 0.5 for n in SHAPE)
    theta_h = np.deg2rad(np.square(i) / SHAPE[0])[:, None, None]
    theta_d = np.deg2rad(j)[:, None]
    phi_d = np.deg2rad(k)
    x, y, z = np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d), np.cos(theta_d)
    cos_h, sin_h = np.cos(theta_h), np.sin(theta_h)
    azimuths, polars = [], []
    for side in (1.0, -1.0):  # l, then v
        along = cos_h * side * x + sin_h * z
        azimuths.append(np.broadcast_to(np.arctan2(side * y, along), SHAPE))
        polars.append(np.arccos(np.clip(cos_h * z - sin_h * side * x, -1.0, 1.0)))
    turn = azimuths[1] - azimuths[0]
    return polars[0], polars[1], np.arctan2(np.sin(turn), np.cos(turn))
