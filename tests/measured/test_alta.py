"""The reader of ALTA's text format: what it makes of good files, and what it says of bad ones."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.measured import alta, read_alta

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

HEADER = """#SAMPLE "a tape"
#DIM 3 1
#VS 0
#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI
#PARAM_OUT INV_STERADIAN_COSINE_FACTOR
"""
LINES_OF_HEADER = 5

# float64: a handful of roundings of numbers of order one.
ROUNDING = 1e-14


@pytest.fixture
def written(written: Callable[..., Path]) -> Callable[..., Path]:
    """Function from text or bytes to a file in ALTA's format that holds it."""
    return lambda content: written(content, "tape.dat")


def refusal(path: Path) -> str:
    """What the reader says of a file that it refuses: one line."""
    with pytest.raises(ValueError, match=r"^tape\.dat") as caught:
        read_alta(path)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_coordinates_become_angles_and_the_cosine_of_the_light_is_divided_out(written):
    tape = read_alta(written(HEADER + "0.5 0.3 0.4 2.0\n\n1.0 -0.7 0.0 3e0\r\n0 0 0 0\n"))
    assert (tape.name, len(tape)) == ("a tape", 3)
    np.testing.assert_allclose(tape.theta_l, [0.5, 1.0, 0.0])
    np.testing.assert_allclose(tape.theta_v, [0.5, 0.7, 0.0], rtol=ROUNDING)
    np.testing.assert_allclose(tape.dphi, [np.arctan2(0.4, 0.3), np.pi, 0.0], rtol=ROUNDING)
    np.testing.assert_allclose(tape.f, [[2.0 / np.cos(0.5)], [3.0 / np.cos(1.0)], [0.0]], rtol=ROUNDING)


def test_values_in_1_per_sr_are_taken_as_they_are_with_all_their_channels(written):
    header = HEADER.replace("INV_STERADIAN_COSINE_FACTOR", "INV_STERADIAN").replace("3 1", "3 3")
    np.testing.assert_array_equal(read_alta(written(header + "1.2 0 0 1 2 3\n")).f, [[1.0, 2.0, 3.0]])


def test_the_plane_of_incidence_is_sorted_and_has_the_light_on_its_positive_side(written):
    lines = "0.5 0.5 0 7\n0.5 0.2 0.3 8\n0.50001 -0.5 -1e-17 9\n0.5 0 0 6\n1.0 0.1 0 5\n"
    tape = read_alta(written(HEADER.replace("_COSINE_FACTOR", "") + lines))
    np.testing.assert_array_equal(tape.lights(), [0.5, 1.0])
    theta_v, f = tape.plane_of_incidence(0.5)
    np.testing.assert_allclose(theta_v, [-0.5, 0.0, 0.5], rtol=ROUNDING)
    np.testing.assert_array_equal(f, [[9.0], [6.0], [7.0]])


def test_a_tape_of_the_model_is_read_with_its_peaks(tape_file):
    tape = read_alta(tape_file)
    np.testing.assert_allclose(np.rad2deg(tape.lights()), [15.0, 30.0, 60.0], rtol=1e-12)
    for theta_l in tape.lights():
        theta_v, f = tape.plane_of_incidence(theta_l)
        assert np.all(np.diff(theta_v) >= 0.0)
        for side in (theta_v > 0.0, theta_v < 0.0):
            # Retroreflective on the light's side and mirrored on the other, to the file's step or two.
            assert abs(theta_v[side][f[side, 0].argmax()]) == pytest.approx(theta_l, abs=np.deg2rad(2.5))


def test_the_file_that_the_paper_fits_is_read(shared):
    tape = read_alta(shared / "measured" / "retro_3m_yellow.dat")
    assert (tape.name, tape.f.shape) == ("3M Yellow", (7397, 1))
    lights = tape.lights()
    # The file gives the angles to 32 digits of pi/12 and so on, less one rounding.
    np.testing.assert_allclose(np.rad2deg(lights), [15.0, 30.0, 60.0], rtol=1e-12)
    # The peaks on record for this file [1/sr], to the digits that are on record: retroreflective, then mirror.
    for theta_l, retro, mirror in zip(lights, (12.29, 13.24, 15.07), (11.19, 11.65, 37.36), strict=True):
        theta_v, f = tape.plane_of_incidence(theta_l)
        assert len(theta_v) == 87
        for side, expected in ((theta_v > 0.0, retro), (theta_v < 0.0, mirror)):
            near = side & (np.abs(np.abs(theta_v) - theta_l) < np.deg2rad(5.0))  # what the peak is within
            assert f[near, 0].max() == pytest.approx(expected, abs=0.005)


SAMPLE = "0.5 0.3 0.4 2.0\n"

# Content of a file, the line that is at fault (0: none), and words of the message.
MALFORMED = {
    "empty": ("", 0, "no samples"),
    "header alone": (HEADER, 0, "no samples"),
    "no number": (HEADER + SAMPLE + "0.5 0.3 bright 2.0\n", 7, "'bright' is no finite number"),
    "NaN": (HEADER + "0.5 0.3 0.4 nan\n", 6, "'nan' is no finite number"),
    "infinite": (HEADER + "0.5 0.3 1e999 1\n", 6, "'1e999' is no finite number"),
    "underscore": (HEADER + "0.5 0.3 0.4 1_0\n", 6, "'1_0' is no finite number"),
    "column missing": (HEADER + SAMPLE * 2 + "0.5 0.3 0.4\n", 8, "3 columns, where DIM in the header says 4"),
    "column too many": (HEADER + "0.5 0.3 0.4 1 1\n", 6, "5 columns"),
    "negative": (HEADER + "0.5 0.3 0.4 -0.1\n", 6, "-0.1 is negative"),
    "light below the horizon": (HEADER + "1.6 0.3 0.4 1\n", 6, "theta_l is 1.6"),
    "light at the horizon": (HEADER + "1.5707963267948966 0.3 0.4 1\n", 6, "theta_l is 1.5708"),
    "light at a negative angle": (HEADER + "-0.1 0.3 0.4 1\n", 6, "theta_l is -0.1"),
    "view below the horizon": (HEADER + "0.1 1.2 1.2 1\n", 6, "theta_v is 1.69"),
    "degrees": (HEADER + "15 30 0 1\n", 6, "theta_l is 15 rad"),
    "no DIM": (HEADER.replace("#DIM 3 1\n", "") + SAMPLE, 5, "'#DIM'"),
    "no PARAM_IN": (SAMPLE, 1, "'#DIM'"),
    "no PARAM_OUT": (HEADER.replace("#PARAM_OUT", "#PARAM") + SAMPLE, 6, "'#PARAM_OUT'"),
    "other coordinates": (HEADER.replace("ISOTROPIC_TL_TV_PROJ_DPHI", "RUSIN_TH_TD") + SAMPLE, 6, "'RUSIN_TH_TD'"),
    "other values": (HEADER.replace("INV_STERADIAN_COSINE_FACTOR", "ENERGY") + SAMPLE, 6, "'ENERGY'"),
    "uncertainties": (HEADER.replace("VS 0", "VS 2") + SAMPLE, 6, "VS is '2'"),
    "two coordinates": (HEADER.replace("3 1", "2 1") + SAMPLE, 6, "DIM is '2 1'"),
    "no channel": (HEADER.replace("3 1", "3 0") + SAMPLE, 6, "DIM is '3 0'"),
    "too many channels": (HEADER.replace("3 1", "3 9999") + SAMPLE, 6, "DIM is '3 9999'"),
    "DIM of letters": (HEADER.replace("3 1", "three one") + SAMPLE, 6, "DIM is 'three one'"),
    "DIM of one number": (HEADER.replace("3 1", "3") + SAMPLE, 6, "DIM is '3'"),
    "header in the middle": (HEADER + SAMPLE + "#DIM 3 2\n", 7, "'#DIM' after the first sample"),
    "line without end": (HEADER + "0 " * 3000, 6, "longer than"),
    "not text": (HEADER.encode() + b"\xff\xfe\x00\n", 6, "not UTF-8"),
    "long word": (HEADER + "0.5 0.3 0.4 " + "x" * 2000 + "\n", 6, "'" + "x" * 40 + "...'"),
    "control characters": (HEADER + "0.5 0.3 0.4 \x1b[31m\n", 6, "' [31m' is no finite number"),
}


@pytest.mark.parametrize("case", MALFORMED)
def test_a_malformed_file_gives_one_message_with_its_line(written, case):
    content, line, words = MALFORMED[case]
    message = refusal(written(content))
    assert message.startswith(f"tape.dat line {line}: " if line else "tape.dat: ")
    assert words in message
    assert len(message) < 200


def test_the_sample_of_the_malformed_files_is_good_by_itself(written):
    assert len(read_alta(written(HEADER + SAMPLE))) == 1


def test_more_samples_than_the_bound_are_refused(written, monkeypatch):
    monkeypatch.setattr(alta, "MAXIMUM_SAMPLES", 3)
    assert len(read_alta(written(HEADER + SAMPLE * 3))) == 3
    assert refusal(written(HEADER + SAMPLE * 4)).startswith(f"tape.dat line {LINES_OF_HEADER + 4}: more than the 3 ")


def test_a_larger_file_than_the_bound_is_refused_before_it_is_read(written, monkeypatch):
    monkeypatch.setattr(alta, "MAXIMUM_BYTES", 2**20)
    path = written(HEADER + SAMPLE)
    os.truncate(path, 2**20 + 1)
    assert "larger than the 1 MiB" in refusal(path)


@pytest.mark.skipif(os.name != "posix", reason="named pipes are another thing elsewhere")
def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "tape.dat")
    assert "not a regular file" in refusal(tmp_path / "tape.dat")


def test_a_file_that_does_not_exist_and_a_folder_are_refused(tmp_path):
    assert "does not exist" in refusal(tmp_path / "tape.dat")
    (tmp_path / "tape.dat").mkdir()
    assert "not a regular file" in refusal(tmp_path / "tape.dat")
