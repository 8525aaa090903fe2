"""Mutations of measured data: tables, ALTA text, MERL binary, OpenMATERIAL JSON."""

from __future__ import annotations

import re
import struct
from typing import TYPE_CHECKING

from tools.fuzz import gltf, odd, raw

if TYPE_CHECKING:
    from random import Random

_WORDS = (
    "theta_l_deg", "theta_v_rad", "dphi_deg", "f_per_sr", "f_cos_l_per_sr", "observation_deg", "entrance_deg",
    "entrance2_deg", "ra_cd_per_lx_m2", "rl_mcd_per_lx_m2", "f_r_per_sr", "#DIM 2 3", "#DIM 99 99", "#PARAM_IN",
    "#PARAM_OUT", "#VS 1", "#CONF", "ISOTROPIC_TL_TV_PROJ_DPHI", "INV_STERADIAN", "RGB_COLOR", "# name: x", ",",
    ",,", ";", "\t", "\r\n", "\n", "\n\n", '"', "\ufeff", "#",
)  # fmt: skip


def text(data: bytes, rng: Random, other: bytes) -> bytes:
    """A table or ALTA text with one to four changes."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        kind = rng.randrange(5)
        if kind == 0:
            data = raw.mutated(data, rng, other)
        elif kind < 3:
            data = _token(data, rng)
        else:
            data = _lines(data, rng, other)
    return data


def _token(data: bytes, rng: Random) -> bytes:
    found = list(re.finditer(rb"[^\s,]+|[\s,]", data))
    if not found:
        return data
    chosen = rng.choice(found)
    new = rng.choice((rng.choice(odd.NUMBERS), rng.choice(_WORDS), rng.choice(odd.NAMES))).encode()
    return data[: chosen.start()] + new + data[chosen.end() :]


def _lines(data: bytes, rng: Random, other: bytes) -> bytes:
    lines = data.split(b"\n")
    where, kind = rng.randrange(len(lines)), rng.randrange(4)
    if kind == 0:
        del lines[where]
    elif kind == 1:
        lines[where:where] = [lines[rng.randrange(len(lines))]] * rng.choice((1, 2, 500))
    elif kind == 2:
        lines[where:where] = other.split(b"\n")[: rng.choice((1, 3, 50))]
    else:
        lines.insert(rng.randrange(len(lines)), lines.pop(where))
    return b"\n".join(lines)


def merl(_data: bytes, rng: Random, _other: bytes) -> bytes:
    """MERL binary with changed sizes or samples: of the whole size, or short."""
    samples = 3 * 90 * 90 * 180
    changed = bytearray(struct.pack("<3i", 90, 90, 180)) + bytearray(struct.pack("<d", 100.0) * samples)
    kind = rng.randrange(5)
    if kind == 0:
        struct.pack_into("<i", changed, 4 * rng.randrange(3), rng.choice((0, 1, -1, 89, 2**31 - 1)))
    elif kind == 1:
        value = rng.choice((float("nan"), float("inf"), -1.0, 1e308, 1e-320))
        struct.pack_into("<d", changed, 12 + 8 * rng.randrange(samples), value)
    elif kind == 2:
        changed += b"\0"
    else:
        del changed[rng.choice((0, 3, 11, 12, 20, len(changed) - 1)) :]
    return bytes(changed)


def openmaterial(data: bytes, rng: Random, other: bytes) -> bytes:
    """An OpenMATERIAL file with one to four changes."""
    return gltf.text(data, rng, other)
