"""Lobes from a few numbers: the right model with the right width, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx import bsdf
from mrm_mtlx.bsdf.masking import DISTRIBUTIONS, MASKINGS
from mrm_mtlx.plots.parameters import DIFFUSE, MICROFACET, PARAMETERS, lobe

GOLD = ((0.183, 0.421, 1.373), (3.424, 2.346, 1.770))

CASES = {
    "white by default": (("schlick", {}), bsdf.GeneralizedSchlick(alpha=(0.09, 0.09))),
    "alpha is the square of roughness": (("schlick", {"roughness": 0.5}), bsdf.GeneralizedSchlick(alpha=(0.25, 0.25))),
    "alpha as it is": (("schlick", {"alpha": 0.5}), bsdf.GeneralizedSchlick(alpha=(0.5, 0.5))),
    "fit of Figure 4": (
        ("schlick", {"roughness": 0.23, "color0": 0.19, "color82": 0.0}),
        bsdf.GeneralizedSchlick(0.19, 0.0, 1.0, alpha=(0.0529, 0.0529)),
    ),
    "gold": (("conductor", {"alpha": 0.1}), bsdf.Conductor(*GOLD, alpha=(0.1, 0.1))),
    "another metal": (
        ("conductor", {"alpha": 0.1, "ior": 0.2, "extinction": (3.0, 4.0, 5.0)}),
        bsdf.Conductor(0.2, (3.0, 4.0, 5.0), alpha=(0.1, 0.1)),
    ),
    "glass": (("dielectric", {"alpha": 0.1}), bsdf.Dielectric(1.5, alpha=(0.1, 0.1))),
    "diamond, other facets": (
        ("dielectric", {"alpha": 0.1, "ior": 2.4, "distribution": "phong", "masking": "v_cavity"}),
        bsdf.Dielectric(2.4, alpha=(0.1, 0.1), distribution="phong", masking="v_cavity"),
    ),
    "EON's roughness is its own": (("eon", {"roughness": 0.5, "color": 0.8}), bsdf.EON(0.8, 0.5)),
    "Lambert": (("lambert", {"color": (0.1, 0.2, 0.3)}), bsdf.Lambert((0.1, 0.2, 0.3))),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("retroreflective", [False, True])
def test_a_lobe_is_the_one_that_is_described(case, retroreflective, rng, direction_pairs):
    (model, given), expected = CASES[case]
    v, l = direction_pairs(rng, 200)
    found = lobe(model, given, retroreflective=retroreflective).eval(v, l)
    seen_from = bsdf.mirror(v) if retroreflective and model in MICROFACET else v
    # 0.23 squared and 0.0529 differ by a rounding, which a value takes a few times; mirroring is exact.
    np.testing.assert_allclose(found, expected.eval(seen_from, l), rtol=1e-12)


WRONG = {
    "of another model": ("schlick", {"ior": 1.5}, r"ior is no parameter of schlick, but of conductor, dielectric"),
    "a width for Lambert": ("lambert", {"roughness": 0.5}, "no parameter of lambert"),
    "a width for EON": ("eon", {"alpha": 0.5}, "alpha is no parameter of eon, but of schlick, conductor, dielectric"),
    "twice": ("schlick", {"alpha": 0.5, "roughness": 0.7}, "one quantity"),
    "no width": ("schlick", {"alpha": 0.0}, "alpha is 0; expected more than 0, and at most 1"),
    "no roughness": ("schlick", {"roughness": 0.0}, "roughness is 0; expected more than 0, and at most 1"),
    "too wide": ("schlick", {"alpha": 1.5}, "alpha is 1.5"),
    "NaN": ("schlick", {"alpha": float("nan")}, "alpha is nan"),
    "infinite": ("conductor", {"extinction": float("inf")}, "extinction is inf; expected 0 or more"),
    "negative index": ("dielectric", {"ior": -1.5}, "ior is -1.5; expected more than 0"),
    "no index": ("dielectric", {"ior": 0.0}, "ior is 0; expected more than 0"),
    "brighter than white": ("schlick", {"color0": (0.5, 2.0, 0.5)}, "color0 is 0.5, 2, 0.5; expected 0 or more, and"),
    "negative colour": ("eon", {"color": -0.5}, "color is -0.5"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_parameter_that_is_wrong_is_refused_with_what_is_expected(case):
    model, given, message = WRONG[case]
    with pytest.raises(ValueError, match=message):
        lobe(model, given)


def test_smooth_eon_is_lambert_and_black_is_allowed(rng, direction_pairs):
    v, l = direction_pairs(rng, 100)
    # EON's multiply scattered part is never less than 1e-8, so that nothing is divided by zero.
    np.testing.assert_allclose(lobe("eon", {"roughness": 0.0}).eval(v, l), lobe("lambert", {}).eval(v, l), rtol=2e-8)
    assert not lobe("schlick", {"color0": 0.0, "color90": 0.0}).eval(v, l).any()


@pytest.mark.parametrize("name", [*DISTRIBUTIONS, *MASKINGS])
def test_every_distribution_and_masking_of_the_optics_can_be_chosen(name, rng, direction_pairs):
    v, l = direction_pairs(rng, 50)
    key = "distribution" if name in DISTRIBUTIONS else "masking"
    assert lobe("schlick", {key: name}).eval(v, l).max() > 0.0


def test_every_model_has_a_form_for_pictures():
    assert {*MICROFACET, *DIFFUSE} == set(PARAMETERS)
