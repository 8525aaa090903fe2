"""Delicate intermediate results of the optics: exact ones change nothing, perturbed ones as much as they are off."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf import diffuse, fresnel, thin_film
from mrm_mtlx.bsdf.reflectance import conductor_reflectance, dielectric_reflectance, schlick_reflectance
from mrm_mtlx.reference.float32.intermediates import Perturbed

COSINES = np.linspace(0.05, 1.0, 40)
FILM = (400.0, 1.3)

FORMULAS = {
    "metal": lambda **given: conductor_reflectance(COSINES, 0.2, 3.4, 0.0, 1.5, **given),
    "metal under a film": lambda **given: conductor_reflectance(COSINES, 0.2, 3.4, *FILM, **given),
    "glass under a film": lambda **given: dielectric_reflectance(COSINES, 1.5, *FILM, **given),
    "Schlick under a film": lambda **given: schlick_reflectance(COSINES, 0.3, 1.0, 1.0, 5.0, *FILM, **given),
    "Fujii": lambda **given: diffuse.fujii_albedo(COSINES, 0.4, **given),
}
ERRORS = {
    "modulus_error": {"metal", "metal under a film", "glass under a film"},
    "product_error": {"metal under a film", "glass under a film", "Schlick under a film"},
    "arc_cosine_error": {"Fujii"},
}


@pytest.mark.parametrize("name", FORMULAS)
def test_no_error_changes_no_digit(name):
    assert np.array_equal(FORMULAS[name](), FORMULAS[name](intermediates=Perturbed()))


@pytest.mark.parametrize("error", ERRORS)
def test_an_error_reaches_the_formulas_that_have_the_quantity_and_no_others(error):
    perturbed = Perturbed(**{error: 1e-4})
    changed = {name for name, f in FORMULAS.items() if not np.array_equal(f(), f(intermediates=perturbed))}
    assert changed == ERRORS[error]


def test_the_modulus_of_a_metal_is_off_as_by_differentiation():
    c, n, k, step = 0.4, 0.3, 2.0, 1e-7
    real, product = n * n - k * k - (1.0 - c * c), 4.0 * n * n * k * k

    def perpendicular(modulus: float) -> float:
        twice = 2.0 * np.sqrt(0.5 * (modulus + real)) * c
        return (modulus + c * c - twice) / (modulus + c * c + twice)

    modulus = np.sqrt(real * real + product)
    expected = perpendicular(modulus * (1.0 + step)) - perpendicular(modulus)
    exact, off = (
        fresnel.conductor_polarized(c, n, k, intermediates=Perturbed(modulus_error=e))[1] for e in (0.0, step)
    )
    assert off - exact == pytest.approx(expected, rel=1e-6)
    assert expected != pytest.approx(0.0, abs=1e-9)


def test_the_error_of_a_films_product_brightens_it_whatever_the_phase():
    substrate = thin_film.metal_substrate(thin_film.cosine_in_film(COSINES, 1.3), 1.3, 1.3001, 0.0)
    exact, off = (
        thin_film.reflectance_xyz(COSINES, 400.0, 1.3, substrate, intermediates=Perturbed(product_error=error))
        for error in (0.0, 1e-6)
    )
    assert np.all(off >= exact)
    # Where one of the two reflectances is next to nothing, the root of the error is what there is.
    assert np.max(off - exact) > 1e-5
