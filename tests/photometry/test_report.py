"""What a surface measures in the geometries of a class, and in which units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.bsdf import GeneralizedSchlick, Lambert
from mrm_mtlx.photometry import luminance_weights
from mrm_mtlx.photometry.report import PhotometryOptions, check_sizes, measure, values
from mrm_mtlx.standards import Quantity, limits

# Relative: products of a handful of numbers, and a cosine of degrees.
EXACT = 1e-12

POINT = PhotometryOptions(rotations_deg=(0.0,))
WHITE = Lambert(1.0).eval


def retroreflector(color):
    """A lobe of constant reflectance: R_A = color / (4 pi alpha^2) at v = l along the normal."""
    return GeneralizedSchlick(color, 1.0, color, alpha=(0.004, 0.004), retroreflective=True).eval


def test_a_class_is_measured_in_its_own_geometries_and_order():
    chosen = limits("DOT-C2", "white")
    report = measure(WHITE, chosen, POINT)
    assert [(c.observation_deg, c.entrance_deg, c.minimum) for c in report.cells] == [
        (limit.observation_deg, limit.entrance_deg, limit.minimum) for limit in chosen
    ]
    for cell in report.cells:
        cosines = np.cos(np.deg2rad(cell.entrance_deg)) * np.cos(np.deg2rad(cell.entrance_deg - cell.observation_deg))
        assert cell.value == pytest.approx(cosines / np.pi, rel=EXACT)
    assert not report.met
    assert not any(cell.met for cell in report.cells)


def test_values_are_weighted_by_the_luminance_under_illuminant_a():
    colored = Lambert((0.8, 0.4, 0.1)).eval
    for method in ("spectral", "rgb"):
        found = values(colored, Quantity.R_A, "cd/lx/m2", 0.0, 0.0, 0.0, replace(POINT, method=method))
        expected = np.dot((0.8, 0.4, 0.1), luminance_weights("A", method)) / np.pi
        assert float(found) == pytest.approx(expected, rel=EXACT)
    daylight = np.dot((0.8, 0.4, 0.1), luminance_weights("D65")) / np.pi
    assert abs(daylight / expected - 1.0) > 0.1


def test_intensities_are_r_a_times_the_area_in_the_unit_of_the_class():
    sized = replace(POINT, area_cm2=20.0, radius_cm=25.0)
    r_a = float(values(WHITE, Quantity.R_A, "cd/lx/m2", 0.0, 0.0, 0.0, sized))
    found = {
        unit: float(values(WHITE, quantity, unit, 0.0, 0.0, 0.0, sized))
        for quantity, unit in ((Quantity.R_I, "mcd/lx"), (Quantity.R_I, "cd/fc"), (Quantity.R_I_OVER_R, "m"))
    }
    assert found["mcd/lx"] == pytest.approx(r_a * 20e-4 * 1000.0, rel=EXACT)
    # 1 cd/fc = 92.903 mcd/lx; its digits.
    assert found["mcd/lx"] / found["cd/fc"] == pytest.approx(92.903, rel=1e-5)
    assert found["m"] == pytest.approx(r_a * 20e-4 / 0.25, rel=EXACT)


@pytest.mark.parametrize(
    ("name", "colour", "sizes", "message"),
    [
        ("reflex reflector", "white", {}, r"R_I \[mcd/lx\] is of a whole reflector: give its area, `area` CM2"),
        ("tyre", None, {"area_cm2": 30.0}, r"R_I/r \[m\] is of a whole strip .* `radius` CM"),
        ("DOT-C2", "white", {"area_cm2": 30.0}, "an area is for limits of intensity"),
        ("pedal", "clear", {"area_cm2": 30.0, "radius_cm": 1.0}, "a radius is for strips"),
        (None, None, {"area_cm2": 30.0}, "an area is for limits of intensity"),
    ],
)
def test_sizes_that_are_missing_or_of_no_use_are_refused(name, colour, sizes, message):
    standard = "FMVSS 108" if name == "reflex reflector" else None
    chosen = limits(name if standard is None else "reflex reflector", colour, standard=standard) if name else []
    with pytest.raises(ValueError, match=message):
        check_sizes(chosen, replace(POINT, **sizes))


def test_rotations_are_averaged():
    lobe = GeneralizedSchlick(0.1, 1.0, 0.1, alpha=(0.004, 0.02), retroreflective=True).eval
    where = np.deg2rad([0.5, 5.0, 0.0])
    turned = [
        float(values(lobe, Quantity.R_A, "", *where, replace(POINT, rotations_deg=(turn,)))) for turn in (0.0, 90.0)
    ]
    both = float(values(lobe, Quantity.R_A, "", *where, replace(POINT, rotations_deg=(0.0, 90.0))))
    assert both == pytest.approx(np.mean(turned), rel=EXACT)
    assert turned[0] / turned[1] < 0.5


def test_discs_are_handed_on():
    lobe, where = retroreflector(0.1), np.deg2rad([0.2, 5.0, 0.0])
    point = float(values(lobe, Quantity.R_A, "", *where, POINT))
    disc = replace(POINT, receiver_aperture_deg=0.2)
    # A disc of 0.1 degrees radius reads 1 to 3 % off at 0.2 degrees, on a lobe of this width.
    assert 0.005 < abs(float(values(lobe, Quantity.R_A, "", *where, disc)) / point - 1.0) < 0.05


def test_a_diffuser_without_a_class_has_the_textbook_values():
    report = measure(WHITE, [], POINT)
    by_place = {(c.quantity, c.observation_deg, c.entrance_deg): c.value for c in report.cells}
    assert round(by_place[Quantity.R_A, 0.1, 0.0], 3) == 0.318
    assert round(by_place[Quantity.R_L, 1.05, 88.76], 1) == 6.9
    assert report.met
    assert all(cell.minimum is None for cell in report.cells)
    # Light that comes back within 2 degrees of where it came from: sin^2(2 deg) cos(5 deg).
    assert report.returned == pytest.approx(np.sin(np.deg2rad(2.0)) ** 2 * np.cos(np.deg2rad(5.0)), rel=1e-9)


def test_the_day_is_d65_at_45_0_and_the_night_is_a_in_the_geometry_of_its_table():
    day, night = measure(WHITE, [], POINT).colors
    assert (day.illuminant, day.observation_deg, day.beta1_deg) == ("D65", 45.0, 45.0)
    assert (night.illuminant, night.observation_deg, night.beta1_deg) == ("A", 0.33, 5.0)
    assert day.factor == pytest.approx(1.0, rel=EXACT)
    assert (day.box.colour, night.box.colour) == ("white", "white")
    marking = measure(WHITE, limits("R4 permanent", "white"), POINT).colors
    assert [(c.observation_deg, c.beta1_deg, c.box.table) for c in marking] == [
        (45.0, 45.0, "Table 5"),
        (1.05, 88.76, "Table 6"),
    ]


def test_a_colour_is_held_to_the_box_of_its_class_and_else_to_the_one_that_fits_best():
    red = Lambert((0.5, 0.005, 0.005)).eval
    assert measure(red, [], POINT).colors[0].box.colour == "red"
    assert measure(red, limits("Type I", "white"), POINT).colors[0].box.colour == "white"
    assert measure(red, limits("Type I", "white"), POINT).colors[0].margin < 0.0
    amber = limits("reflex reflector", "amber", standard="FMVSS 108")
    assert measure(red, amber, replace(POINT, area_cm2=1.0)).colors[0].box.colour == "yellow"


def test_only_a_box_of_the_same_standard_counts():
    red = retroreflector((2.0, 0.005, 0.005))
    own = measure(red, limits(standard="DPR", color="white"), POINT)
    assert own.colors[0].counts
    assert not own.colors[1].counts
    assert own.colors[0].margin < 0.0
    assert not own.met
    foreign = measure(retroreflector(2.0), limits("DOT-C2", "red"), POINT)
    assert not any(color.counts for color in foreign.colors)
    assert foreign.colors[1].margin < 0.0
    assert foreign.met


def test_black_has_no_colour_and_meets_nothing():
    report = measure(Lambert(0.0).eval, limits("DOT-C2", "white"), POINT)
    assert all(np.isnan(color.x) and color.box is None for color in report.colors)
    assert not report.met
