"""Documents as BRDFs, and the ready materials against the figures that their page states."""

from __future__ import annotations

import re

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.photometry import chromaticity, coefficient, directions, document_brdf, luminance
from mrm_mtlx.photometry.color import METHODS, luminance_weights
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.standards import boxes

# Relative: the reference computes with directions of float64, but its lobe's clamps are those of float32.
DIFFUSE = 1e-9


def test_a_white_diffuser_has_one_over_pi_in_any_shape(surface_document, hemisphere, rng):
    document = surface_document(
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" value="1, 1, 1"/>'
        "</oren_nayar_diffuse_bsdf>"
    )
    brdf = document_brdf(document.getNode("m"))
    v, l = hemisphere(rng, 12).reshape(3, 4, 3), hemisphere(rng, 4)
    found = brdf(v, l)
    assert found.shape == (3, 4, 3)
    np.testing.assert_allclose(found, 1.0 / np.pi, rtol=DIFFUSE)
    assert np.all(brdf(v * [1.0, 1.0, -1.0], l) == 0.0)
    assert np.all(brdf(v, l * [1.0, 1.0, -1.0]) == 0.0)
    np.testing.assert_allclose(coefficient(brdf, 0.0, 0.0), 1.0 / np.pi, rtol=DIFFUSE)


def test_a_lobe_of_a_document_has_a_quarter_of_its_distribution(surface_document):
    """F / (4 pi alpha^2) at v = l along the normal, times the energy compensation of the node."""
    document = surface_document(
        '<generalized_schlick_bsdf name="bsdf" type="BSDF"><input name="color0" type="color3" value="0.1, 0.1, 0.1"/>'
        '<input name="color90" type="color3" value="0.1, 0.1, 0.1"/>'
        '<input name="roughness" type="vector2" value="0.01, 0.01"/>'
        '<input name="retroreflective" type="boolean" value="true"/></generalized_schlick_bsdf>'
    )
    expected = 0.1 / (4.0 * np.pi * 0.01**2)
    # Compensation is 1 + F (1 - E) / E, with an albedo E of 1 that MaterialX's fit has to a percent: F = 0.1 of that.
    np.testing.assert_allclose(coefficient(document_brdf(document.getNode("m")), 0.0, 0.0), expected, rtol=1e-3)


@pytest.fixture(scope="module")
def page(repository):
    """The page of the materials, which tests of the package's own data need."""
    return (repository / "materials" / "README.md").read_text(encoding="utf-8")


def table_rows(page, header):
    """Cells of the rows of the table whose header begins so, by the name in the first cell."""
    after = page.split(header, 1)[1].split("\n\n", 1)[0].splitlines()[2:]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in after]
    return {row[0].strip("`"): row[1:] for row in rows}


@pytest.fixture(scope="module")
def method(page):
    """How the page takes colours under illuminant A, by the weights that it states."""
    stated = [float(x) for x in re.search(r"\(([\d.]+) R \+ ([\d.]+) G \+ ([\d.]+) B\)", page).groups()]
    # To the digits stated.
    fitting = [name for name in METHODS if np.allclose(luminance_weights("A", name), stated, rtol=0.0, atol=6e-4)]
    assert len(fitting) == 1
    return fitting[0]


@pytest.fixture(scope="module")
def brdf_of(repository, library):
    """Function from the name of a material to its BRDF."""

    def make(name):
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(repository / "materials" / f"{name}.mtlx"))
        document.setDataLibrary(library.document)
        (element,) = renderable_elements(document)
        return document_brdf(element)

    return make


def test_the_ready_materials_have_the_r_a_that_their_page_states(page, method, brdf_of):
    rows = table_rows(page, "| file | what it is | source of the numbers |")
    assert len(rows) >= 13
    for name, cells in rows.items():
        found = float(luminance(coefficient(brdf_of(name), *np.deg2rad([0.2, 5.0])), "A", method))
        # Half of the last digit stated.
        digit = 0.05 if "." in cells[2] else 0.5
        assert abs(found - float(cells[2])) <= 1.01 * digit, name


def box_named(text, illuminant):
    """The box that a cell of the page names: of sheeting by its colour, of markings, or of DPR 495/1992."""
    name = re.search(r"\((.*)\)", text)[1]
    wanted = {"marking": ("pavement marking", "white"), "DPR": ("new prismatic material", "white")}
    subject, colour = wanted.get(name, ("sheeting", name))
    (box,) = [b for b in boxes() if (b.illuminant, b.subject, b.colour) == (illuminant, subject, colour)]
    return box


def test_the_ready_materials_have_the_colours_that_their_page_states(page, method, brdf_of):
    rows = table_rows(page, "| file | x, y by day | box margin |")
    assert len(rows) >= 13
    for name, (day, day_box, factor, night, night_box, _) in rows.items():
        brdf = brdf_of(name)
        for illuminant, stated, margin in (("D65", day, day_box), ("A", night, night_box)):
            box = box_named(margin, illuminant)
            f = brdf(*directions(*np.deg2rad([box.observation_deg, box.beta1_deg])))
            x, y = chromaticity(f, illuminant, method)
            # The last digit stated, of coordinates and of the margins made of them.
            np.testing.assert_allclose([x, y], [float(part) for part in stated.split(",")], rtol=0.0, atol=1e-3)
            assert abs(box.margin(x, y) - float(margin.split()[0].replace("−", "-"))) <= 1e-3, name
            if illuminant == "D65":
                assert abs(100.0 * np.pi * luminance(f, "D65") - float(factor)) <= 0.1, name


def test_figures_of_daylight_weights_would_not_be_those_of_the_page(page, brdf_of):
    rows = table_rows(page, "| file | what it is | source of the numbers |")
    name = "conspicuity_tape_red"
    found = float(luminance(coefficient(brdf_of(name), *np.deg2rad([0.2, 5.0])), "D65"))
    assert abs(found / float(rows[name][2]) - 1.0) > 0.2
