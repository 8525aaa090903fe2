"""Readers of MERL's binary format and of CSV tables: what they make of good files, and what they say of bad ones."""

from __future__ import annotations

import os
import struct
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.measured import CoefficientSamples, Measurement, merl, read, read_table, table

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

# float64: a handful of roundings of numbers of order one.
ROUNDING = 1e-14

BRDF = "theta_l_deg, theta_v_deg, dphi_deg, f_per_sr\n"
RA = "observation_deg, entrance_deg, ra_cd_per_lx_m2\n"
EUROPEAN = "theta_l_deg;theta_v_deg;dphi_deg;f_per_sr\n"


def refusal(path: Path) -> str:
    """What `read` says of a file that it refuses: one short line with the file's name."""
    with pytest.raises(ValueError, match=r"^tape\.") as caught:
        read(path)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 320
    return message


# CSV


def test_a_table_of_brdf_samples_is_read_in_any_order_of_columns(written):
    text = "# name: a tape\nf_per_sr, dphi_deg,theta_v_deg , theta_l_deg\n\n2.5,190,30,15\n# a comment\n0, -90, 90, 0\n"
    tape = read(written(text))
    assert isinstance(tape, Measurement)
    assert tape.name == "a tape"
    np.testing.assert_allclose(np.rad2deg(tape.theta_l), [15.0, 0.0], rtol=ROUNDING)
    np.testing.assert_allclose(np.rad2deg(tape.theta_v), [30.0, 90.0], rtol=ROUNDING)
    np.testing.assert_allclose(np.rad2deg(tape.dphi), [-170.0, -90.0], rtol=ROUNDING)
    np.testing.assert_array_equal(tape.f, [[2.5], [0.0]])


@pytest.mark.parametrize("sample", ["12,5;30;-0,25;2,5", "12.5; 30; -0.25; 2.5", "1,25e1;30;-25e-2;2,50"])
def test_a_table_with_semicolons_is_read_with_either_decimal_mark(written, sample):
    tape = read(written("\ufeff# name: Folie\n" + EUROPEAN + sample + "\n"))
    assert tape.name == "Folie"
    np.testing.assert_allclose(np.rad2deg([tape.theta_l, tape.theta_v, tape.dphi]), [[12.5], [30.0], [-0.25]])
    np.testing.assert_array_equal(tape.f, [[2.5]])


def test_radians_channels_and_a_cosine_of_the_light_are_converted(written):
    text = "theta_l_rad,theta_v_rad,dphi_rad,f_cos_l_r_per_sr,f_cos_l_g_per_sr,f_cos_l_b_per_sr\n0.5,0.25,1,3,2,1\n"
    tape = read_table(written(text))
    assert (tape.theta_l[0], tape.theta_v[0], tape.name) == (0.5, 0.25, "tape")
    np.testing.assert_allclose(tape.f, [np.array([3.0, 2.0, 1.0]) / np.cos(0.5)], rtol=ROUNDING)


def test_a_table_of_coefficients_is_read(written):
    sheet = read(written(RA + "0.2,-4,250\n0.5,30,65\n"))
    assert isinstance(sheet, CoefficientSamples)
    np.testing.assert_allclose(np.rad2deg(sheet.observation), [0.2, 0.5], rtol=ROUNDING)
    np.testing.assert_allclose(np.rad2deg(sheet.beta1), [-4.0, 30.0], rtol=ROUNDING)
    np.testing.assert_array_equal(sheet.ra, [250.0, 65.0])
    np.testing.assert_array_equal(sheet.beta2, [0.0, 0.0])


def test_a_coefficient_of_retroreflected_luminance_becomes_one_of_retroreflection(written):
    # The 30 m geometry of road markings: R_A = 0.039968 R_L. The viewer's angle, to 1e-4 degrees, moves that by 4e-5.
    sheet = read(written("observation_deg,entrance_deg,rl_mcd_per_lx_m2\n1.0494,88.7588,100\n"))
    assert sheet.ra[0] == pytest.approx(0.039968 * 0.1, rel=5e-5)


# Content of a table, the line at fault (0: none), and words of the message.
BAD_TABLES = {
    "empty": ("", 0, "format is not known|no line with names"),
    "names alone": (BRDF, 1, "no samples"),
    "wrong unit": (BRDF.replace("theta_v_deg", "theta_v_grad"), 1, "the unit 'grad'; expected theta_v_deg or"),
    "no unit": (BRDF.replace("f_per_sr", "f"), 1, "'f', has no unit; expected f_per_sr"),
    "unit of another quantity": (RA.replace("cd_per_lx_m2", "per_sr"), 1, "the unit 'per_sr'"),
    "unknown column": (BRDF.replace("dphi_deg", "phi_deg"), 1, "column 3 is 'phi_deg'; expected one of theta_l"),
    "missing column": (BRDF.replace("dphi_deg, ", ""), 1, "no column dphi_deg or dphi_rad"),
    "missing values": ("theta_l_deg,theta_v_deg,dphi_deg\n1,2,3\n", 1, "columns of values 'none'; expected f_per_sr"),
    "two kinds of values": (BRDF.strip() + ",f_cos_l_per_sr\n", 1, "columns of values"),
    "one channel of three": (BRDF.replace("f_per", "f_r_per"), 1, "columns of values 'f_r'"),
    "both kinds of tables": (BRDF.strip() + ",observation_deg\n", 1, "expected one kind"),
    "column twice": (BRDF.strip() + ",f_per_sr\n", 1, "'f' stands in two columns"),
    "no separator": (BRDF.replace(",", " "), 0, "format is not known|separated by one of them"),
    "both separators": (BRDF.replace(",", ";", 1), 1, "has both commas and semicolons"),
    "semicolons in the samples alone": (BRDF + "15;14;0;9,8\n", 2, "2 columns, where the line of names has 4"),
    "decimal commas between commas": (BRDF + "15,14,0,9,8\n", 2, "with decimal commas, separate columns by semicolons"),
    "two decimal marks": (
        EUROPEAN + "15;14;0;9.8\n15;14;0,5;9\n",
        3,
        "'0,5': a decimal point in line 2 and a decimal comma in line 3",
    ),
    "thousands": (EUROPEAN + "15;14;0;1.234,5\n", 2, "no mark between thousands"),
    "two commas in a number": (EUROPEAN + "15;14;0;1,234,5\n", 2, "'1,234,5' is no finite number"),
    "no number": (BRDF + "15,14,0,bright\n", 2, "'bright' is no finite number"),
    "NaN": (BRDF + "15,14,0,1\n15,14,0,nan\n", 3, "'nan' is no finite number"),
    "infinite": (BRDF + "15,14,0,inf\n", 2, "'inf' is no finite number"),
    "value missing": (BRDF + "15,14,0,\n", 2, "'' is no finite number"),
    "column too few": (BRDF + "15,14,0\n", 2, "3 columns, where the line of names has 4"),
    "negative": (BRDF + "15,14,0,-0.5\n", 2, "f_per_sr is -0.5; expected 0 or more"),
    "negative view": (BRDF + "15,-14,0,1\n", 2, "theta_v_deg is -14; expected 0 to 90"),
    "light below": (BRDF + "95,14,0,1\n", 2, "theta_l_deg is 95; expected 0 to less than 90"),
    "degrees called radians": (BRDF.replace("_deg", "_rad") + "15,14,0,1\n", 2, "theta_l_rad is 15; expected 0 to"),
    "coefficient of nothing": (RA + "0.2,5,0\n", 2, "ra_cd_per_lx_m2 is 0; expected more than 0"),
    "observation negative": (RA + "-0.2,5,1\n", 2, "observation_deg is -0.2"),
    "viewer below": (RA + "2,-89,1\n", 2, "below the surface's horizon"),
    "not text": (BRDF.encode() + b"\xff\xfe,1\n", 2, "not UTF-8"),
    "line without end": (BRDF + "1," * 4000, 2, "longer than"),
}


@pytest.mark.parametrize("case", BAD_TABLES)
def test_a_malformed_table_gives_one_message_with_its_line(written, case):
    content, line, words = BAD_TABLES[case]
    message = refusal(written(content))
    assert message.startswith(f"tape.csv line {line}: " if line else "tape.csv")
    assert any(part in message for part in words.split("|")), message


def test_more_samples_than_the_bound_are_refused(written, monkeypatch):
    monkeypatch.setattr(table, "MAXIMUM_SAMPLES", 2)
    assert len(read_table(written(BRDF + "15,14,0,1\n" * 2))) == 2
    assert "line 4: more than the 2 samples" in refusal(written(BRDF + "15,14,0,1\n" * 3))
    monkeypatch.setattr(table, "MAXIMUM_COEFFICIENTS", 1)
    assert "line 3: more than the 1 samples" in refusal(written(RA + "0.2,5,100\n" * 2))


# MERL


@pytest.fixture(scope="module")
def merl_bytes() -> Callable[[np.ndarray], bytes]:
    """Function from samples, shape (3, 90, 90, 180), to a file of the format."""
    return lambda numbers: struct.pack("<3i", *merl.SHAPE) + numbers.astype("<f8").tobytes()


def test_a_lobe_is_read_at_the_directions_it_was_written_for(merl_bytes, written):
    # A function of both directions that no exchange or mirror image of axes leaves as it is, but that of l and v does.
    theta_l, theta_v, dphi = merl.angles()
    f = np.cos(theta_l) * np.cos(theta_v) * (2.0 + np.cos(dphi))
    numbers = np.stack([f, 2.0 * f, 3.0 * f]) / merl.SCALE[:, None, None, None]
    numbers[:, 0, 0, 7] = -1.0  # not measured, and above the horizon
    tape = read(written(merl_bytes(numbers), "tape.binary"))
    assert isinstance(tape, Measurement)
    expected = np.cos(tape.theta_l) * np.cos(tape.theta_v) * (2.0 + np.cos(tape.dphi))
    np.testing.assert_allclose(tape.f, expected[:, None] * [1.0, 2.0, 3.0], rtol=ROUNDING)
    above = np.maximum(theta_l, theta_v) < np.pi / 2 - 1e-3
    assert len(tape) == np.count_nonzero(above) - 1


def test_the_angles_of_merl_are_those_of_the_half_vector(rng):
    # By a second way: from the directions back to the half-vector and the difference angles.
    indices = rng.integers(0, merl.angles()[0].size, 2000)
    theta_l, theta_v, dphi = (a.ravel()[indices] for a in merl.angles())
    l = np.stack([np.sin(theta_l), 0.0 * theta_l, np.cos(theta_l)], axis=1)
    v = np.stack([np.sin(theta_v) * np.cos(dphi), np.sin(theta_v) * np.sin(dphi), np.cos(theta_v)], axis=1)
    h = (l + v) / np.linalg.norm(l + v, axis=1, keepdims=True)
    i, j, k = np.unravel_index(indices, merl.SHAPE)
    half, difference = np.rad2deg(np.arccos(h[:, 2])), np.rad2deg(np.arccos(np.sum(l * h, axis=1)))
    # Arc cosines near 1 keep half of the digits.
    np.testing.assert_allclose(half, np.square(i + 0.5) / 90.0, atol=1e-5)
    np.testing.assert_allclose(difference, j + 0.5, atol=1e-5)
    # phi_d: the angle of l about h, from the direction in which h tilts; cos(phi_d) sin(theta_d) = l . (y x h).
    tilt = np.cross(_normalised(np.cross([0.0, 0.0, 1.0], h)), h)
    np.testing.assert_allclose(
        np.sum(l * tilt, axis=1), np.cos(np.deg2rad(k + 0.5)) * np.sin(np.deg2rad(j + 0.5)), atol=1e-9
    )


@pytest.mark.parametrize(
    "case", ["short header", "billion", "negative size", "truncated", "too long", "NaN", "all invalid"]
)
def test_a_malformed_merl_file_gives_one_message(merl_bytes, tmp_path, case):
    path = tmp_path / "tape.binary"
    header = struct.pack("<3i", *merl.SHAPE)
    words = _write_malformed(path, case, header, merl_bytes)
    message = refusal(path)
    assert words in message


def _write_malformed(path: Path, case: str, header: bytes, merl_bytes: Callable) -> str:
    """Writes the file, sparse where its content does not matter; returns words of the message."""
    if case == "short header":
        path.write_bytes(b"\0" * 8)
        return "8 bytes; expected the binary format of MERL"
    if case in ("billion", "negative size"):
        first = 1_000_000_000 if case == "billion" else -90
        path.write_bytes(struct.pack("<3i", first, 90, 180) + b"\0" * 64)
        return f"the header announces {first} x 90 x 180 samples"
    if case in ("truncated", "too long"):
        path.write_bytes(header)
        os.truncate(path, merl.BYTES + (8 if case == "too long" else -8))
        return f"{case}: {merl.BYTES + (8 if case == 'too long' else -8)} bytes; the header asks for {merl.BYTES}"
    numbers = np.full((3, *merl.SHAPE), -1.0)
    if case == "NaN":
        numbers[1, 2, 3, 4] = np.nan
        path.write_bytes(merl_bytes(numbers))
        return "nan is no finite number, at channel G, theta_h 2, theta_d 3, phi_d 4"
    path.write_bytes(merl_bytes(numbers))
    return "every sample is negative, which means not measured"


# Any of them


def test_the_content_decides_what_a_file_is(written, tape_file):
    assert read(tape_file).had_cosine
    assert isinstance(read(written(RA + "0.2,-4,250\n", "tape.dat")), CoefficientSamples)


@pytest.mark.parametrize("name", ["tape.png", "tape.txt"])
def test_what_is_of_no_format_is_refused(written, name):
    assert "its format is not known; expected MERL binary" in refusal(written(b"\x89PNG\0\0", name))


def test_a_file_that_does_not_exist_is_refused(tmp_path):
    assert "does not exist" in refusal(tmp_path / "tape.csv")


def _normalised(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
