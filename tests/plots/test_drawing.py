"""Pictures: they show their curves, tell them apart, can be read in a column, and come out the same twice."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from mrm_mtlx import bsdf
from mrm_mtlx.measured import Measurement
from mrm_mtlx.plots import drawing, paper, style
from mrm_mtlx.plots.curves import Curve, lobe_curve

COLUMN_INCH = 8.5 / 2.54


def curves(names=("ordinary", "retroreflective"), lights_deg=(20.0, 60.0), alpha=0.16):
    lobe = {"retroreflective": bsdf.GeneralizedSchlick(alpha=(alpha, alpha), retroreflective=True)}
    ordinary = bsdf.GeneralizedSchlick(alpha=(alpha, alpha))
    return [
        lobe_curve(name, f"light at {degrees:g}°", lobe.get(name, ordinary), np.deg2rad(degrees))
        for name in names
        for degrees in lights_deg
    ]


def dots():
    theta = np.deg2rad(np.array([15.0, 30.0, 60.0]))
    return Measurement("", theta, theta, np.zeros(3), np.full((3, 1), 10.0))


# They differ at their ends alone.
LONG = tuple(f"M_a_material_with_a_very_long_name_of_several_words_{i}" for i in range(style.MAXIMUM_NAMES))
PICTURES = {
    "log": lambda: drawing.lobes(curves(), "log"),
    "linear": lambda: drawing.lobes(curves(), "linear"),
    "polar": lambda: drawing.lobes(curves(), "polar"),
    "turned": lambda: drawing.lobes(curves(), "polar", np.deg2rad(-133.3)),
    "one curve": lambda: drawing.lobes(curves(("EON",), (45.0,)), "log"),
    "as many lights as there can be": lambda: drawing.lobes(curves(lights_deg=range(0, 90, 15)), "linear"),
    "as many lights around": lambda: drawing.lobes(curves(lights_deg=range(0, 90, 15)), "polar"),
    "as many long names as there can be": lambda: drawing.lobes(curves(LONG, (10.0,)), "log"),
    "a narrow lobe": lambda: drawing.lobes(curves(alpha=0.0025), "linear"),
    "figure 2": lambda: drawing.figure_2(paper.figure_2()),
    "figure 4": lambda: drawing.by_light(paper.figure_4()),
    "figure 4 with points": lambda: drawing.by_light(paper.figure_4(dots())),
}


@cache
def picture(name):
    """One of the pictures, for tests that only look at it."""
    return PICTURES[name]()


def texts_drawn(figure):
    """Put everything in its place; the texts that are drawn, and where: labels beyond the axes' ends are not."""
    canvas = FigureCanvasAgg(figure)
    found = []
    with pytest.MonkeyPatch.context() as patch:
        draw = Text.draw
        patch.setattr(Text, "draw", lambda self, *a, **k: (found.append(self), draw(self, *a, **k)))
        canvas.draw()
    shown = [t for t in found if t.get_visible() and t.get_text().strip()]
    return {t: t.get_window_extent(canvas.get_renderer()) for t in shown}


def misplaced(figure):
    """Texts that stick out of the picture, and pairs of texts that touch."""
    boxes = texts_drawn(figure)
    frame = figure.bbox
    outside = [
        t.get_text()
        for t, box in boxes.items()
        if box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1
    ]
    touching = [(a.get_text(), b.get_text()) for a, b in combinations(boxes, 2) if boxes[a].overlaps(boxes[b])]
    return outside + touching


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_fits_a_column_and_can_be_read_there(name):
    figure = picture(name)
    assert figure.get_figwidth() == pytest.approx(COLUMN_INCH, rel=1e-12)
    assert figure.get_figheight() <= 1.25 * COLUMN_INCH
    assert misplaced(figure) == []
    assert all(text.get_fontsize() >= style.SMALLEST_LETTERS for text in texts_drawn(figure))


def test_what_sticks_out_or_touches_is_seen():
    figure = drawing.lobes(curves(), "log")
    figure.text(0.9, 0.5, "a text that is longer than there is room for")
    figure.axes[0].set_xticks(np.arange(-90, 91, 5))
    assert len(misplaced(figure)) > 10


@pytest.mark.parametrize("name", PICTURES)
def test_axes_have_their_quantities_and_units(name):
    figure = picture(name)
    labels = {t.get_text() for t in figure.findobj(Text)}
    assert any("BRDF [1/sr]" in label for label in labels)
    assert any(r"view angle $\theta_v$ [°]" in label for label in labels)
    assert figure.legends


def lines_of(axes, curve):
    """Lines of a plot that have a curve's samples."""
    factor = 1.0 if axes.name == "polar" else 180.0 / np.pi
    return [
        line
        for line in axes.lines
        if len(line.get_xdata()) == len(curve.theta_v)
        and np.allclose(line.get_xdata(), curve.theta_v * factor, rtol=1e-14)
        and np.array_equal(line.get_ydata(), curve.value)
    ]


@pytest.mark.parametrize("scale", drawing.SCALES)
def test_every_curve_is_drawn_once_with_a_line_of_its_own(scale):
    every = curves(lights_deg=(10.0, 50.0, 70.0))
    (axes,) = drawing.lobes(every, scale).axes
    looks = set()
    for curve in every:
        (line,) = lines_of(axes, curve)
        looks.add((line.get_color(), str(line.get_linestyle()), str(line._unscaled_dash_pattern)))
    assert len(looks) == len(every)


@pytest.mark.parametrize("count", [1, 6])
def test_curves_of_one_light_differ_in_colour_and_dashes(count):
    every = curves(LONG[:count], (10.0,))
    (axes,) = drawing.lobes(every, "log").axes
    # All are of the same values: only their looks tell them apart.
    found = lines_of(axes, every[0])
    assert len({line.get_color() for line in found}) == count
    assert len({str(line._unscaled_dash_pattern) for line in found}) == count


@pytest.mark.parametrize("panels", [drawing.figure_2, drawing.by_light])
def test_the_figures_of_the_paper_show_their_curves_in_its_colours(panels):
    data = paper.figure_2() if panels is drawing.figure_2 else paper.figure_4(dots())
    expected = {"GGX": style.BLUE, "MRM": style.GREEN, "EON": style.ORANGE}
    for axes, panel in zip(panels(data).axes, data, strict=True):
        assert axes.get_yscale() == "log"
        for curve in panel.curves:
            (line,) = lines_of(axes, curve)
            assert line.get_color() == expected[curve.name]
            assert line.is_dashed() == (curve.variant != "roughness 0.666")
        points = [line for line in axes.lines if line.get_marker() == "o"]
        assert len(points) == (panel.points is not None)
        for line in points:
            assert line.get_color() == "black"
            np.testing.assert_allclose(line.get_xdata(), np.rad2deg(panel.points[0]), rtol=1e-14)


def test_lambert_is_a_red_line_at_1_over_pi():
    for figure in (drawing.lobes(curves(), "log"), drawing.figure_2(paper.figure_2())):
        for axes in figure.axes:
            (line,) = [line for line in axes.lines if line.get_color() == style.RED]
            np.testing.assert_array_equal(line.get_ydata(), 1.0 / np.pi)


def test_marks_stand_where_the_lights_do():
    (axes,) = drawing.lobes(curves(), "log").axes
    (marks,) = [line for line in axes.lines if line.get_marker() == "v"]
    np.testing.assert_allclose(marks.get_xdata(), [20.0, 60.0], rtol=1e-14)


def test_a_polar_plot_has_the_normal_up_and_the_light_to_the_right_with_an_arrow():
    figure = drawing.lobes(curves(lights_deg=(60.0,)), "polar")
    texts_drawn(figure)
    (axes,) = figure.axes
    center, up, light = (axes.transData.transform(p) for p in ((0.0, 0.0), (0.0, 1.0), (np.deg2rad(60.0), 1.0)))
    assert up - center == pytest.approx([0.0, up[1] - center[1]], abs=1e-6)
    assert up[1] > center[1]
    # The same radius, turned by 60 degrees to the right.
    expected = (up[1] - center[1]) * np.array([np.sin(np.pi / 3.0), 0.5])
    assert light - center == pytest.approx(expected, rel=1e-9)
    arrows = [(text.xy, text.xyann) for text in axes.texts if text.arrow_patch is not None]
    ((head, tail),) = arrows
    assert head[0] == tail[0] == pytest.approx(np.pi / 3.0)
    assert head[1] < tail[1]  # towards the surface
    highest = max(curve.value.max() for curve in curves(lights_deg=(60.0,)))
    assert head[1] > highest  # clear of the lobes


@pytest.mark.parametrize("scale", ["linear", "log"])
def test_the_highest_value_is_in_the_picture_and_negative_ones_are_where_the_scale_has_them(scale):
    dark = bsdf.GeneralizedSchlick(0.19, 0.0, 1.0, alpha=(0.05, 0.05))  # below zero near 82 degrees
    curve = lobe_curve("dark", "", dark, np.deg2rad(80.0))
    assert curve.value.min() < 0.0
    (axes,) = drawing.lobes([curve], scale).axes
    low, high = axes.get_ylim()
    assert high > max(curve.value.max(), 1.0 / np.pi)
    assert (low < curve.value.min()) if scale == "linear" else (0.0 < low < 1.0 / np.pi)


def test_a_name_is_no_formula_and_not_hidden():
    figure = drawing.lobes(curves(("_a$x$b",), (10.0,)), "log")
    assert r"_a\$x\$b" in [text.get_text() for text in figure.legends[0].get_texts()]
    texts_drawn(figure)


def test_long_names_keep_both_ends():
    shown = [text.get_text() for text in drawing.lobes(curves(LONG, (10.0,)), "log").legends[0].get_texts()]
    assert len(set(shown[: len(LONG)])) == len(LONG)
    assert all(name.startswith("M_a_material") for name in shown[: len(LONG)])


def test_more_than_can_be_told_apart_is_refused():
    with pytest.raises(ValueError, match="7 names and 1 variants; at most 6 and 6"):
        drawing.lobes(curves([f"m{i}" for i in range(7)], (10.0,)), "log")


@pytest.mark.parametrize("suffix", style.SUFFIXES)
def test_the_same_data_give_the_same_bytes(tmp_path, suffix):
    written = []
    for folder in ("first", "second"):
        path = tmp_path / folder / f"picture{suffix}"
        path.parent.mkdir()
        drawing.save(PICTURES["figure 4 with points"](), path)
        written.append(path.read_bytes())
    assert written[0] == written[1]
    assert len(written[0]) > 10_000  # something is in it
    other = tmp_path / f"other{suffix}"
    drawing.save(picture("figure 4"), other)
    assert other.read_bytes() != written[0]


def test_a_png_has_300_dots_per_inch(tmp_path):
    from mrm_mtlx.documents.images import read_image

    drawing.save(drawing.lobes(curves(), "log"), tmp_path / "a.png")
    assert read_image(tmp_path / "a.png").shape[1] == int(300 * COLUMN_INCH)


def test_settings_of_the_process_are_left_alone(tmp_path):
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    drawing.save(drawing.lobes(curves(), "log"), tmp_path / "a.svg")
    assert dict(mpl.rcParams) == before


@pytest.mark.parametrize("path", ["picture.gif", "picture"])
def test_another_suffix_is_refused(tmp_path, path):
    with pytest.raises(ValueError, match=r"expected a name that ends in \.png, \.svg, \.pdf"):
        drawing.save(drawing.lobes(curves(), "log"), tmp_path / path)


def test_a_folder_that_does_not_exist_is_one_message_and_leaves_nothing(tmp_path):
    with pytest.raises(ValueError, match=r"a\.png cannot be written: No such file"):
        drawing.save(drawing.lobes(curves(), "log"), tmp_path / "nowhere" / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_a_picture_is_there_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "a.svg"
    path.write_text("what was there", encoding="utf-8")
    figure = drawing.lobes(curves(), "log")

    def full_disk(target, **_options):
        target.write(b"half a pic")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(figure, "savefig", full_disk)
    with pytest.raises(ValueError, match="No space left"):
        drawing.save(figure, path)
    assert [p.name for p in tmp_path.iterdir()] == ["a.svg"]
    assert path.read_text(encoding="utf-8") == "what was there"


def test_a_black_lobe_can_be_drawn_on_a_logarithmic_scale():
    theta = np.linspace(-1.5, 1.5, 5)
    figure = drawing.lobes([Curve("black", "", 0.5, theta, np.zeros(5))], "log")
    (axes,) = figure.axes
    low, high = axes.get_ylim()
    assert 0.0 < low < 1.0 / np.pi < high
