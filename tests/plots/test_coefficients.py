"""Pictures of coefficients: the curves go through what reports say, and the minima stand where classes have them."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf import GeneralizedSchlick, Lambert
from mrm_mtlx.photometry.report import PhotometryOptions, measure
from mrm_mtlx.plots import coefficients, drawing, style
from mrm_mtlx.plots.coefficients_drawing import picture
from mrm_mtlx.standards import limits

POINT = PhotometryOptions(rotations_deg=(0.0,))
LOBE = GeneralizedSchlick(0.1, 1.0, 0.1, alpha=(0.004, 0.004), retroreflective=True).eval

# Relative: straight lines between samples 1 % apart in the angle, of a curve that falls with its fourth power at most.
BETWEEN = 1e-2


@pytest.mark.parametrize(
    ("name", "colour", "settings", "shown"),
    [
        ("DOT-C2", "white", POINT, (6, 6)),
        (
            "front",
            "clear",
            PhotometryOptions((0.0,), area_cm2=20.0),
            (12, 10),
        ),  # 10 up or down is not on the axis to the side
        ("R4 permanent", "white", POINT, (1, 1)),
    ],
)
def test_curves_go_through_the_values_of_the_report(name, colour, settings, shown):
    chosen = limits(name, colour)
    cells = {(c.observation_deg, c.beta1_deg, c.beta2_deg): c for c in measure(LOBE, chosen, settings).cells}
    panels = coefficients.class_panels(LOBE, chosen, settings)
    assert tuple(sum(len(series.limit) for series in panel.series) for panel in panels) == shown
    for panel in panels:
        for series in panel.series:
            for angle, minimum in zip(series.limit_deg, series.limit, strict=True):
                at = [cell for cell in cells.values() if cell.minimum == minimum]
                value = np.interp(angle, series.angle_deg, series.value)
                assert any(abs(value / cell.value - 1.0) < BETWEEN for cell in at)


def test_without_a_class_there_are_curves_and_no_marks():
    panels = coefficients.class_panels(Lambert().eval, [], POINT)
    assert [panel.angle for panel in panels] == ["observation", "entrance"]
    assert all(len(series.limit) == 0 for panel in panels for series in panel.series)
    np.testing.assert_allclose(panels[1].series[0].value[panels[1].series[0].angle_deg == 0.0], 1.0 / np.pi, rtol=1e-4)


def test_a_picture_has_the_marks_the_labels_and_the_width_of_a_column():
    figure = picture(coefficients.class_panels(LOBE, limits("DOT-C2", "red"), POINT))
    assert figure.get_size_inches()[0] == pytest.approx(style.COLUMN)
    above, below = figure.axes
    assert (above.get_xscale(), above.get_yscale(), below.get_yscale()) == ("log", "log", "log")
    assert above.get_ylabel() == "$R_A$ [cd/lx/m²]"
    marks = [line for line in above.lines if line.get_marker() == "^"]
    assert sorted(y for line in marks for y in line.get_ydata()) == [4.0, 15.0, 15.0, 15.0, 60.0, 60.0]
    low, high = above.get_ylim()
    assert low < 4.0
    assert high > 60.0
    assert [text.get_text() for text in above.get_legend().get_texts()] == ["−4°", "30°", "45°", "minimum"]


def test_black_and_a_deep_fall_can_be_drawn(tmp_path):
    for brdf in (Lambert(0.0).eval, LOBE):
        drawing.save(picture(coefficients.class_panels(brdf, [], POINT)), tmp_path / "a.png")
        assert (tmp_path / "a.png").stat().st_size > 0


def test_every_class_has_lines_that_can_be_told_apart():
    from mrm_mtlx.standards.tables import classes

    sized = PhotometryOptions((0.0,), area_cm2=20.0, radius_cm=30.0)
    for chosen in classes():
        rows = limits(chosen.class_name, chosen.colour, standard=chosen.standard)
        for panel in coefficients.class_panels(Lambert().eval, rows, sized):
            assert len(panel.series) <= min(style.MAXIMUM_NAMES, style.MAXIMUM_VARIANTS)
