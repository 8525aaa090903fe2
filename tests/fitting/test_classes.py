"""Materials of known performance: they meet their classes, within the energy and the colours that there are."""

from __future__ import annotations

import re
from dataclasses import replace

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.fitting import performance
from mrm_mtlx.fitting.classes import MATERIALS, document
from mrm_mtlx.fitting.performance import CEILINGS, MARGIN, meet
from mrm_mtlx.library import class_materials_folder
from mrm_mtlx.photometry import document_brdf
from mrm_mtlx.photometry.coefficients import WITHIN
from mrm_mtlx.photometry.report import PhotometryOptions, measure
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.standards import Quantity
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.options import Request
from tools import classes_page

# Numbers of a document have six digits, and a value follows its lobe's height: relative, 1e-6, and as much again for
# the width, to whose square it goes.
DIGITS = 1e-5
# Luminance factors of 23 CFR 655, subpart F, Table 1a (sheeting Types I to III) and 5a (markings).
FACTORS = {"white": (0.27, 1.0), "yellow": (0.15, 0.45), "red": (0.025, 0.12), "marking": (0.35, 1.0)}
# A search ends where its sum changes by 1e-9, so its numbers are known to the root of that and a factor for how little
# the sum depends on them: relative, against those of the documents.
SEARCHED = 1e-2

BY_NAME = {material.name: material for material in MATERIALS}


def path_of(material):
    return class_materials_folder() / f"{material.name}.mtlx"


def read(text, library):
    """A document from text, with its material."""
    found = mx.createDocument()
    mx.readFromXmlString(found, text)
    found.setDataLibrary(library.document)
    return found, renderable_elements(found)[0]


def measured(material, text, library):
    """What a document of the material measures against its class."""
    held, element = read(text, library)
    found = measure(
        document_brdf(element), material.limits(), PhotometryOptions((0.0,), area_cm2=material.make.area_cm2)
    )
    assert held is not None
    return found


@pytest.fixture(scope="module")
def reports(library):
    """What each document measures."""
    return {m.name: measured(m, path_of(m).read_text(encoding="utf-8"), library) for m in MATERIALS}


def test_every_document_has_its_material_and_every_material_its_document():
    assert sorted(path.stem for path in class_materials_folder().iterdir()) == sorted(BY_NAME)


@pytest.mark.parametrize("name", BY_NAME)
def test_a_material_stands_above_every_minimum_of_its_class_by_the_margin(reports, name):
    report = reports[name]
    assert report.met
    assert len(report.cells) == len(BY_NAME[name].limits())
    ratios = [cell.value / cell.minimum for cell in report.cells]
    assert min(ratios) >= MARGIN * (1.0 - DIGITS)
    # One minimum decides the height, so nothing is brighter than it has to be; what the clear face mirrors to the
    # receiver at entrance angle 0 comes on top, here up to some 3 % (R_A = F0 D / 4 of a face of alpha 0.01).
    assert min(ratios) <= MARGIN * 1.04


def test_a_darker_lobe_and_a_wider_one_are_seen_to_fail(library):
    material = BY_NAME["dot_c2_white"]
    text = path_of(material).read_text(encoding="utf-8")
    assert measured(material, text, library).met
    (color0,) = re.findall(r'"color0" type="color3" value="([\d.]+), ', text)
    (alpha,) = re.findall(r'"vector2" value="(0\.003\d+), ', text)
    # Below the margin of 3 % by one; the peak goes as 1 / alpha^2.
    assert not measured(material, text.replace(color0, f"{float(color0) * 0.96:.6f}"), library).met
    assert not measured(material, text.replace(alpha, f"{float(alpha) * 1.1:.6f}"), library).met


def lobes(material):
    """Width and colour of each retroreflective lobe of a document."""
    text = path_of(material).read_text(encoding="utf-8")
    pattern = r'name="lobe.*?"color0" type="color3" value="(.*?)".*?"vector2" value="([\d.]+),'
    return [(float(a), np.array(c.split(", "), dtype=float)) for c, a in re.findall(pattern, text, re.DOTALL)]


@pytest.mark.parametrize("name", BY_NAME)
def test_a_material_returns_no_more_than_its_construction_can(reports, name):
    material = BY_NAME[name]
    t2 = np.tan(0.5 * WITHIN) ** 2
    share = np.max(np.sum([color0 * t2 / (alpha**2 + t2) for alpha, color0 in lobes(material)], axis=0))
    ceiling = CEILINGS[material.make.construction]
    assert 0.0 < share <= ceiling
    # By quadrature of the whole document; base and film give and take some thousandths.
    assert 0.0 < reports[name].returned <= ceiling
    assert all(alpha >= 0.003 for alpha, _ in lobes(material))


# No box for amber was read.
@pytest.mark.parametrize("name", [name for name, material in BY_NAME.items() if material.colour != "amber"])
def test_colours_are_inside_the_boxes_that_were_read(reports, name):
    material, report = BY_NAME[name], reports[name]
    for color in report.colors:
        assert color.margin is not None
        assert color.margin > 0.0
        assert color.box.colour == {"clear": "white", "unspecified": "white"}.get(material.colour, material.colour)
    x, y, factor = material.make.day
    day = report.colors[0]
    np.testing.assert_allclose([day.x, day.y, day.factor], [x, y, factor], rtol=DIGITS)
    kind = "marking" if material.limits()[0].quantity is Quantity.R_L else day.box.colour
    assert FACTORS[kind][0] <= factor <= FACTORS[kind][1]


# Each structure; and the narrowest and widest lobes, steepest and flattest falls of all. The others differ in numbers
# alone; `mrm validate materials_classes` has them.
STRUCTURES = ("dpr_495_white", "iso_20471_silver", "en_1436_r5_white")
EXTREMES = ("dpr_495_red", "fmvss_131_prismatic_white", "cpsc_reflector_clear", "dot_c2_white")


@pytest.mark.parametrize("name", [*STRUCTURES, *(pytest.param(name, marks=pytest.mark.large) for name in EXTREMES)])
def test_the_shader_of_a_material_is_as_the_reference_has_it(gl, name):
    path = path_of(BY_NAME[name])
    found = check_document(Request(path, Reach.beside(path), path.name, targets=("glsl",), samples=64))
    (renderable,) = found.renderables
    assert found.findings == []
    assert (renderable.targets["glsl"].stage, renderable.targets["glsl"].status) == ("compare", "pass")


# Face and lobe, two lobes, lobe alone.
@pytest.mark.parametrize("name", STRUCTURES)
def test_the_osl_of_a_material_compiles(cycles, name):
    path = path_of(BY_NAME[name])
    (renderable,) = check_document(
        Request(path, Reach.beside(path), path.name, targets=("osl",), samples=16)
    ).renderables
    assert (renderable.targets["osl"].stage, renderable.targets["osl"].status) == ("compile", "pass")


@pytest.mark.parametrize("name", ["cpsc_pedal_amber", "en_1436_r4_white"])
def test_fitting_a_class_again_gives_its_document(name):
    material = BY_NAME[name]
    met = meet(material.limits(), material.make)
    # The base gets its colour at the end, a little brighter than what stood for it: of R_L, by less than a thousandth.
    assert 1.0 - DIGITS <= np.min(met.ratios) <= 1.001
    numbers = re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])")
    written, again = path_of(material).read_text(encoding="utf-8"), document(material, met)
    assert numbers.sub("#", written) == numbers.sub("#", again)
    np.testing.assert_allclose(
        [float(x) for x in numbers.findall(again)], [float(x) for x in numbers.findall(written)], rtol=SEARCHED
    )


def test_what_cannot_be_is_refused(monkeypatch):
    material = BY_NAME["en_1436_r5_white"]
    monkeypatch.setitem(CEILINGS, "mud", 0.001)
    starts = performance._Problem._starts
    monkeypatch.setattr(performance._Problem, "_starts", lambda problem: starts(problem)[:1])  # one vain search will do
    with pytest.raises(ValueError, match=r"do not meet the class within the 0\.001 that mud return"):
        meet(material.limits(), replace(material.make, construction="mud"))
    with pytest.raises(ValueError, match="the base would need the colour"):  # the lobe takes some of the light
        meet(material.limits(), replace(material.make, day=(0.3127, 0.329, 1.0)))


def test_the_page_of_the_documentation_is_up_to_date(repository):
    kept = (repository / "docs" / "classes.md").read_text(encoding="utf-8")
    assert kept == classes_page.page(), "run: python -m tools.make_docs classes.md"
