"""`mrm plot`: pictures of documents and of parameters, figures of the paper, and how wrong calls are refused."""

from __future__ import annotations

import re
import shlex
from functools import partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.text import Text

from mrm_mtlx.plots import drawing, style
from tools.make_docs import FIGURES, same_picture

BEGINNINGS = {".png": b"\x89PNG\r\n\x1a\n", ".svg": b"<?xml", ".pdf": b"%PDF-"}

MATERIALS = Path(__file__).parents[2] / "materials"
TAPE = MATERIALS / "retroreflective_tape_yellow.mtlx"

ALTA = """#DIM 3 1
#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI
#PARAM_OUT INV_STERADIAN
0.2617993878 0.2617993878 0 9
0.5235987756 0.5235987756 0 9
1.0471975512 1.0471975512 0 9
"""


@pytest.fixture
def here(in_process):
    """Function from arguments of `mrm plot` to the finished command."""
    return partial(in_process, "plot")


@pytest.fixture
def pictured(here, monkeypatch):
    """Function from options to the picture that would be written."""
    kept = []
    monkeypatch.setattr(drawing, "save", lambda figure, _path: kept.append(figure))

    def run(*arguments: object):
        done = here(*arguments, "-o", "a.svg")
        assert (done.exit_code, done.stdout, done.stderr) == (0, "", "wrote a.svg\n")
        return kept.pop()

    return run


def data(figure):
    """What a picture of one pair of axes shows: their kind, scale and lines."""
    (axes,) = figure.axes
    lines = [(line.get_color(), list(line.get_xdata()), list(line.get_ydata())) for line in axes.lines]
    return axes.name, axes.get_yscale(), lines


def texts(figure):
    """All texts of a picture."""
    return {text.get_text() for text in figure.findobj(Text)}


def words(path: Path) -> str:
    """The texts of an SVG file, which stand beside their outlines as comments."""
    return "\n".join(re.findall(r"<!-- (.*?) -->", path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("suffix", BEGINNINGS)
def test_a_picture_is_written_in_every_kind_of_file(here, tmp_path, suffix):
    done = here("-o", f"a{suffix}")
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", f"wrote a{suffix}\n")
    assert (tmp_path / f"a{suffix}").read_bytes().startswith(BEGINNINGS[suffix])


def test_two_processes_write_the_same_bytes(mrm, here, tmp_path):
    options = ("--light", "30", "--roughness", "0.2", "-o")
    done = mrm("plot", *options, "first.svg")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "wrote first.svg\n")
    assert here(*options, "second.svg").exit_code == 0
    assert (tmp_path / "first.svg").read_bytes() == (tmp_path / "second.svg").read_bytes()


def test_a_wrong_call_of_the_real_command_is_one_line(mrm):
    done = mrm("plot", "-o", "a.png", "--alpha", "2")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.strip().split("\n")[3].startswith("Error: Invalid value: alpha is 2; expected more than 0")


def test_what_is_asked_for_is_in_the_picture(pictured):
    both = pictured()
    assert {"ordinary", "retroreflective", "Lambert, 1/π", "light", "BRDF [1/sr]"} <= texts(both)
    assert "ordinary" not in texts(pictured("--retroreflective"))
    assert "retroreflective" not in texts(pictured("--ordinary"))
    assert data(pictured("--ordinary", "--retroreflective")) == data(both)
    assert {"light at 12.5°", "light at 60°"} <= texts(pictured("--light", "12.5", "--light", "60"))
    assert "EON" in texts(pictured("--model", "eon", "--color", "0.2,0.5,0.1"))
    assert "Lambert" in texts(pictured("--model", "lambert"))
    assert any(r"$\varphi$ = 45°" in text for text in texts(pictured("--azimuth", "45")))
    assert any("radius: BRDF" in text for text in texts(pictured("--scale", "polar")))


@pytest.mark.parametrize(
    "options",
    [
        "--light 44.9",
        "--azimuth 1",
        "--scale linear",
        "--scale polar",
        "--model dielectric",
        "--model conductor",
        "--model conductor --extinction 1,2,3",
        "--model conductor --ior 0.1",
        "--roughness 0.31",
        "--alpha 0.08",
        "--distribution beckmann",
        "--distribution phong",
        "--masking smith_separable",
        "--masking v_cavity",
        "--color0 0.9",
        "--color82 0.9",
        "--color0 0.5 --color90 0.9",
        "--ordinary",
        "--retroreflective",
    ],
)
def test_every_option_changes_the_picture(pictured, options):
    model = options.split()[:2] if options.startswith("--model conductor --") else []
    assert data(pictured(*options.split())) != data(pictured(*model))


def test_a_document_is_plotted_by_the_reference_with_a_line_per_light(pictured):
    two, one = pictured(TAPE, "--light", "15", "--light", "60"), pictured(TAPE, "--light", "15")
    assert {"M_retroreflective_tape_yellow", "light at 15°", "light at 60°"} <= texts(two)
    assert not [text for text in texts(one) if "light at" in text]  # one needs no name
    assert len(data(two)[2]) == len(data(one)[2]) + 1
    # The diffuse part under the lobe shifts its peak by less than half a degree.
    (_, theta_v, value) = data(one)[2][0]
    near = np.abs(np.array(theta_v) - 15.0) < 10.0
    assert np.array(theta_v)[near][np.array(value)[near].argmax()] == pytest.approx(15.0, abs=0.5)


@pytest.mark.parametrize("path", sorted(MATERIALS.glob("*.mtlx")), ids=lambda path: path.stem)
def test_every_material_can_be_plotted(pictured, path):
    assert np.max(data(pictured(path, "--scale", "polar"))[2][0][2]) > 0.0


def with_materials(metal: Path, count: int) -> None:
    """Give a document more materials: m1, m2 and so on."""
    text = metal.read_text(encoding="utf-8")
    first = text[text.index("<surfacematerial") : text.index("</materialx>")]
    more = "".join(first.replace('"material" type', f'"m{i}" type') for i in range(1, count))
    metal.write_text(text.replace("</materialx>", f"{more}</materialx>"), encoding="utf-8")


def test_one_element_of_a_document_can_be_chosen(pictured, here, metal):
    with_materials(metal, 3)
    assert {"material", "m1", "m2"} <= texts(pictured(metal))
    assert {"material", "m1", "m2"} & texts(pictured(metal, "--element", "m1")) == {"m1"}
    done = here(metal, "--element", "m9", "-o", "none.svg")
    assert (done.exit_code, done.stderr.rpartition(": m9: ")[2]) == (2, "expected one of material, m1, m2\n")


def test_more_surfaces_than_can_be_told_apart_are_refused_with_what_to_do(here, metal, tmp_path):
    with_materials(metal, style.MAXIMUM_NAMES + 1)
    done = here(metal, "-o", "all.svg")
    assert done.exit_code == 2
    assert done.stderr.splitlines()[-1].endswith("told apart in a picture; choose one with --element")
    assert here(metal, "--element", "m6", "-o", "one.svg").exit_code == 0


BROKEN = {"READ_MISSING": 1, "READ_XML": 1, "DOC_CYCLE": 1, "DOC_FILE": 1, "DOC_NO_RENDERABLE": 3}


@pytest.mark.parametrize("code", BROKEN)
def test_a_broken_document_is_refused_with_its_finding(here, documents, tmp_path, code):
    done = here(documents / code / "triggers.mtlx", "-o", "a.svg")
    assert (done.exit_code, done.stdout) == (BROKEN[code], "")
    assert "has nothing to render" in done.stderr or f"error {code}" in done.stderr.splitlines()[0]
    assert list(tmp_path.iterdir()) == []


def test_an_image_that_cannot_be_read_is_a_finding(here, tmp_path):
    (tmp_path / "noise.png").write_bytes(b"no picture at all")
    (tmp_path / "a.mtlx").write_text(
        '<?xml version="1.0"?><materialx version="1.39"><image name="i" type="color3">'
        '<input name="file" type="filename" value="noise.png"/></image>'
        '<oren_nayar_diffuse_bsdf name="d" type="BSDF"><input name="color" type="color3" nodename="i"/>'
        '</oren_nayar_diffuse_bsdf><surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="d"/>'
        '</surface><surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" '
        'nodename="s"/></surfacematerial></materialx>',
        encoding="utf-8",
    )
    done = here("a.mtlx", "-o", "a.svg")
    assert (done.exit_code, done.stdout) == (1, "")
    assert done.stderr.splitlines()[-1].startswith("a.mtlx:1:354: error DOC_FILE /m: noise.png: ")
    assert not (tmp_path / "a.svg").exists()


def test_a_surface_that_the_reference_does_not_know_is_named(here, documents, tmp_path):
    done = here(documents / "SHADER_COMPILE" / "triggers.mtlx", "-o", "a.svg")
    assert (done.exit_code, done.stdout) == (3, "")
    assert done.stderr.splitlines()[-1] == "mrm: /material has no reference: the reference does not know ND_dust"
    assert list(tmp_path.iterdir()) == []


WRONG = {
    "": "Missing option '--output'",
    "-o a.gif": "a.gif: expected a name that ends in .png, .svg, .pdf",
    "-o nowhere/a.png": "the folder nowhere does not exist",
    "-o a.png --light 90": "90: expected an angle from 0 to 89 degrees",
    "-o a.png --light -10": "-10: expected an angle from 0 to 89 degrees",
    "-o a.png --light nan": "nan: expected an angle",
    "-o a.png --light 1 --light 2 --light 3 --light 4 --light 5 --light 6 --light 7": "at most 6 can be told",
    "-o a.png --azimuth 181": "181: expected an angle from -180 to 180 degrees",
    "-o a.png --scale cubic": "'cubic': expected one of",
    "-o a.png --model phong": "'phong': expected one of",
    "-o a.png --distribution gauss": "'gauss': expected one of",
    "-o a.png --roughness 0": "roughness is 0; expected more than 0, and at most 1",
    "-o a.png --alpha 2": "alpha is 2; expected",
    "-o a.png --alpha 0.1 --roughness 0.1": "one quantity",
    "-o a.png --color0 red": "'red': expected a number, or three as R,G,B",
    "-o a.png --color0 1,0": "'1,0': expected a number, or three as R,G,B",
    "-o a.png --color0 nan": "color0 is nan; expected",
    "-o a.png --ior 1.5": "ior is no parameter of schlick, but of conductor, dielectric",
    "-o a.png --model eon --retroreflective": "not with eon, a diffuse model",
    "-o a.png --model lambert --roughness 0.5": "roughness is no parameter of lambert, but of",
    "-o a.png --element m": "only with a document",
    "-o a.png --measured b.dat": "only with --figure 4",
    "-o a.png --alpha 1e-200": "the lobe 'ordinary' has values that are not finite",
    "-o a.png --model conductor --ior 1e200": "the lobe 'ordinary' has values that are not finite",
    "{metal} -o a.png --alpha 0.1": "--alpha: not with a document",
    "{metal} -o a.png --retroreflective": "--retroreflective: not with a document",
    "{metal} -o a.png --model eon": "--model: not with a document",
    "{folder} -o a.png": "is a folder; name one document",
    "--figure 3 -o a.png": "'3': expected one of",
    "{metal} --figure 2 -o a.png": "not with --figure",
    "--figure 2 -o a.png --light 10": "--light: not with --figure",
    "--figure 2 -o a.png --scale log": "--scale: not with --figure",
    "--figure 2 -o a.png --azimuth 0": "--azimuth: not with --figure",
    "--figure 4 -o a.png --roughness 0.2": "--roughness: not with --figure",
    "--figure 2 -o a.png --measured b.dat": "only with --figure 4",
    "--figure 2 -o a.gif": "expected a name that ends in",
    "--figure all -o a.png": "a.png: expected a folder",
    "--figure all -o {metal_without_suffix}": "File exists",
    "--figure 4 -o a.png --measured nowhere.dat": "nowhere.dat: it does not exist",
    "--figure 4 -o a.png --measured {metal}": "metal.mtlx line 1: ",
}


@pytest.mark.parametrize("call", WRONG)
def test_a_wrong_call_is_a_usage_message_of_one_line(here, metal, tmp_path, call):
    (tmp_path / "in_the_way").write_text("", encoding="utf-8")
    before = sorted(tmp_path.iterdir())
    done = here(*shlex.split(call.format(metal=metal, folder=tmp_path, metal_without_suffix="in_the_way")))
    assert (done.exit_code, done.stdout) == (2, "")
    usage, hint, empty, error = done.stderr.strip().split("\n")
    assert usage.startswith("Usage: mrm plot")
    assert hint.startswith("Try '")
    assert (empty, error[:7]) == ("", "Error: ")
    assert WRONG[call] in error.replace(f"{tmp_path}/", "")
    assert sorted(tmp_path.iterdir()) == before


def test_all_figures_are_made_in_a_folder_and_one_in_a_file(here, tmp_path):
    done = here("--figure", "all", "-o", "new/folder")
    assert (done.exit_code, done.stdout) == (0, "")
    assert done.stderr == "wrote new/folder/figure2.svg\nwrote new/folder/figure4.svg\n"
    for name in ("2", "4"):
        assert here("--figure", name, "-o", f"{name}.svg").exit_code == 0
        assert (tmp_path / f"{name}.svg").read_bytes() == (tmp_path / f"new/folder/figure{name}.svg").read_bytes()
    assert {"GGX", "MRM", "EON", "roughness 0.1", "roughness 0.666"} <= set(words(tmp_path / "2.svg").splitlines())


def test_figure_4_has_points_where_there_is_a_measurement(here, tmp_path):
    (tmp_path / "tape.dat").write_text(ALTA, encoding="utf-8")
    assert here("--figure", "4", "-o", "without.svg").exit_code == 0
    assert here("--figure", "4", "-o", "with.svg", "--measured", "tape.dat").exit_code == 0
    assert "measured" not in words(tmp_path / "without.svg").splitlines()
    assert "measured" in words(tmp_path / "with.svg").splitlines()


def test_a_malformed_measurement_is_refused_with_its_line(here, tmp_path):
    (tmp_path / "tape.dat").write_text(ALTA + "0.1 0.1 0 nan\n", encoding="utf-8")
    done = here("--figure", "4", "-o", "a.svg", "--measured", "tape.dat")
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1].endswith("tape.dat line 7: 'nan' is no finite number")
    (tmp_path / "tape.dat").write_text(ALTA.replace("1.0471975512", "1.1"), encoding="utf-8")
    done = here("--figure", "4", "-o", "a.svg", "--measured", "tape.dat")
    assert done.stderr.splitlines()[-1].endswith("at theta_l = 60 degrees; its lights are 15, 30, 63.03")


@pytest.mark.parametrize("name", FIGURES)
def test_the_pictures_of_the_documentation_are_up_to_date(here, repository, tmp_path, name):
    kept = (repository / "docs" / name).read_text(encoding="utf-8")
    version = re.search(r"Matplotlib v([\d.]+)", kept)[1]
    if version != mpl.__version__:
        pytest.skip(f"drawn by Matplotlib {version}, which sets letters in another way than {mpl.__version__}")
    call = FIGURES[name].format(file="new.svg").replace("materials/retroreflective_tape_yellow.mtlx", str(TAPE))
    assert here(*shlex.split(call)).exit_code == 0
    assert same_picture(kept, (tmp_path / "new.svg").read_text(encoding="utf-8")), (
        f"run: python -m tools.make_docs {name}"
    )


def test_a_picture_that_is_out_of_date_is_seen(here, repository, tmp_path):
    kept = (repository / "docs" / "figures" / "lobes.svg").read_text(encoding="utf-8")
    assert same_picture(kept, kept)
    assert here("--roughness", "0.402", "--light", "20", "--light", "60", "-o", "new.svg").exit_code == 0
    assert not same_picture(kept, (tmp_path / "new.svg").read_text(encoding="utf-8"))
    assert not same_picture(kept, kept.replace("ordinary", "other"))
