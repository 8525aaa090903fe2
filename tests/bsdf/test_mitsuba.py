"""The same model by other hands: `roughconductor` and `roughdielectric` of Mitsuba 3, in float32.

Mitsuba's value includes the cosine of l; its masking is separable. A retroreflective lobe at v is Mitsuba's at v'.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from mrm_mtlx.bsdf import Conductor, Dielectric, beckmann, fresnel, ggx, microfacet, mirror

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

PROGRAM = Path(__file__).with_name("mitsuba_program.py")
NO_RUNTIME = 3  # the exit status of the program
TIME_LIMIT_S = 300
SEED = 5
PAIRS = 1024

# Relative to the value, which is some thirty float32 operations, each off by at most 6e-8; measured 1.0e-6 for GGX and
# 4.2e-6 for Beckmann, whose exponent is up to 14 where values are not `SMALL`.
TOL = 1e-5

# Values below this share of the lobe's largest count as this. Far in a Gaussian's tail a value is exp(-x) with x up to
# 46, where Mitsuba ends it, and a rounding of x is x roundings of the value.
SMALL = 1e-6

# One rounding of float32, and how many of them may meet in a condition of `conditions`; measured 7.8.
ROUNDING = 2.0**-24
ROUNDINGS = 16.0

# Share of a case's pairs that a planted error must show in. In the narrowest interface, what is refracted is known to
# 1e-3 alone, and half of the random pairs are; in the narrowest Gaussian most values are 0.
ENOUGH = 0.05

# Mitsuba's masking of Beckmann facets is a rational fit with an error of "less than 0.35 %" in G1 (Walter et al. 2007).
FIT_ERROR = 0.0035


class RationalBeckmann:
    """Beckmann facets with Mitsuba's masking: the rational fit of Walter et al. 2007 (after eq. 27) for G1."""

    distribution = staticmethod(beckmann.distribution)
    sample_normal = staticmethod(beckmann.sample_normal)
    sample_visible = staticmethod(beckmann.sample_visible)

    @staticmethod
    def smith_lambda(x: Array, y: Array, z: Array, alpha_x: Array, alpha_y: Array) -> Array:
        across = np.hypot(alpha_x * x, alpha_y * y)
        a = np.minimum(z / np.maximum(across, 1e-30), 1.6)  # the fit is 1 from here on
        g1 = (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)
        return np.where(a < 1.6, 1.0 / g1 - 1.0, 0.0)


FACETS = {"ggx": ggx, "beckmann": RationalBeckmann()}


@dataclass(frozen=True)
class Case:
    """A lobe, Mitsuba's description of it, and what both are asked: v, l and u, (m, 3), rounded to float32."""

    name: str
    lobe: Any
    description: dict[str, Any]
    v: Array
    l: Array
    u: Array


def rounded(values: Any) -> Array:
    """As float32 has it."""
    return np.asarray(values, dtype=np.float32).astype(float)


def make_lobe(kind: str, distribution: str, alpha: tuple[float, float], rng: np.random.Generator) -> Any:
    """A lobe with a random index."""
    facets = {"alpha": alpha, "distribution": FACETS[distribution], "masking": "smith_separable", "sampling": "visible"}
    if kind == "conductor":
        return Conductor(rounded(rng.uniform(0.1, 3.0, 3)), rounded(rng.uniform(1.0, 6.0, 3)), **facets)
    ior = rng.uniform(1.2, 2.4)
    return Dielectric(float(rounded(ior if rng.uniform() < 0.7 else 1.0 / ior)), scatter_mode="RT", **facets)


def described(lobe: Any, kind: str, distribution: str, visible: bool) -> dict[str, Any]:
    """Mitsuba's description of a lobe."""
    if kind == "conductor":
        colors = {"eta": lobe.ior, "k": lobe.extinction}
        index: dict[str, Any] = {name: {"type": "rgb", "value": c.tolist()} for name, c in colors.items()}
    else:
        index = {"int_ior": lobe.ior, "ext_ior": 1.0}
    widths = {"alpha_u": lobe.alpha[0], "alpha_v": lobe.alpha[1]}
    return {"type": f"rough{kind}", "distribution": distribution, "sample_visible": visible, **widths, **index}


def directions(lobe: Any, kind: str, rng: np.random.Generator, hemisphere: Callable[..., Array]) -> tuple[Array, Array]:
    """Pairs over both sides where the lobe has two; in a half of them l is sampled from the lobe."""
    v, l = hemisphere(rng, PAIRS), hemisphere(rng, PAIRS)
    if kind == "dielectric":
        for w in (v, l):
            w[:, 2] *= np.where(rng.uniform(size=PAIRS) < 0.5, -1.0, 1.0)
    sampled = lobe.sample(v, rng.uniform(size=(PAIRS, 3)))
    taken = np.any(sampled != 0.0, axis=-1) & (np.arange(PAIRS) % 2 == 0)
    return rounded(v), rounded(np.where(taken[:, None], sampled, l))


def make_cases(hemisphere: Callable[..., Array]) -> list[Case]:
    """Random parameters: a narrow lobe, isotropic and anisotropic ones, of each kind and distribution."""
    rng = np.random.default_rng(SEED)
    cases = []
    for kind in ("conductor", "dielectric"):
        for distribution in FACETS:
            for k in range(6):
                wide = 10.0 ** rng.uniform(-1.5, 0.0, 2)
                alpha = tuple(float(a) for a in rounded((0.0025, 0.0025) if k == 0 else wide[[0, k % 2]]))
                lobe = make_lobe(kind, distribution, alpha, rng)
                visible = k < 4
                widths = f"alpha {alpha[0]:.4f} {alpha[1]:.4f}"
                name = f"{kind}, {distribution}, {'visible' if visible else 'all'} facets, {widths}"
                description = described(lobe, kind, distribution, visible)
                v, l = directions(lobe, kind, rng, hemisphere)
                cases.append(Case(name, lobe, description, v, l, rounded(rng.uniform(size=(PAIRS, 3)))))
    return cases


@pytest.fixture(scope="module")
def answers(hemisphere, tmp_path_factory) -> list[tuple[Case, dict[str, Array]]]:
    """Every case with Mitsuba's values, densities and samples."""
    if importlib.util.find_spec("mitsuba") is None:
        pytest.skip("Mitsuba 3 is not installed; pip install mitsuba")
    cases = make_cases(hemisphere)
    folder = tmp_path_factory.mktemp("mitsuba")
    arrays = {f"{name}{k}": getattr(case, name).astype(np.float32) for k, case in enumerate(cases) for name in "vlu"}
    np.savez(folder / "request.npz", bsdfs=json.dumps([case.description for case in cases]), **arrays)
    command = [sys.executable, str(PROGRAM), str(folder / "request.npz"), str(folder / "answer.npz")]
    run = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT_S, check=False)
    if run.returncode == NO_RUNTIME:
        pytest.skip(run.stderr.strip())
    assert run.returncode == 0, run.stderr
    names = ("eval", "pdf", "sample", "weight", "sampled_pdf")
    with np.load(folder / "answer.npz") as found:
        return [(case, {name: found[f"{name}{k}"] for name in names}) for k, case in enumerate(cases)]


def conditions(case: Case, v: Array, l: Array, *, sampled: bool = False) -> Array:
    """Relative error that one rounding e of the directions makes, beyond `TOL`; shape (m,).

    * Unit vectors in float32 are unit to a rounding, so that v.m and l.m, one number where light is reflected, differ
      by e / v.m; and a refracted cosine is the root of a difference, off by e / cosine. Relative to the cosine, that is
      e / cosine^2, for the smallest of them.
    * A facet normal m = (v + eta l) / |v + eta l| turns by e / |v + eta l|, of a lobe as wide as alpha. Not where light
      is reflected: v + l is exact where it is short. A `sampled` direction is itself rounded, and always counts.

    With visible facets a metal's value and density have no v.m, and so no condition.
    """
    is_metal = isinstance(case.lobe, Conductor)
    if is_metal and case.description["sample_visible"] and not sampled:
        return np.zeros(len(v))
    eta = np.ones(len(v)) if is_metal else case.lobe.ior ** np.sign(v[:, 2])
    refracted = v[:, 2] * l[:, 2] < 0.0
    toward = v + np.where(refracted, eta, 1.0)[:, None] * l
    length = np.linalg.norm(toward, axis=-1)
    v_m, l_m = (np.abs(np.sum(w * toward, axis=-1)) / length for w in (v, l))
    squares = np.min([v_m**2, l_m**2, np.abs(1.0 - (1.0 - v_m**2) / eta**2)], axis=0)
    turned = np.where(refracted | sampled, 1.0 / (length * np.min(case.lobe.alpha)), 0.0)
    return ROUNDING * (1.0 / np.maximum(squares, ROUNDING) + turned)


def deviation(ours: Array, theirs: Array, condition: Array) -> Array:
    """Difference over what is allowed, shape (m,): above 1 is a disagreement."""
    ours, theirs = ours.reshape(len(ours), -1), theirs.reshape(len(theirs), -1)
    scale = np.maximum(np.abs(ours), SMALL * np.max(ours))
    return np.max(np.abs(ours - theirs) / scale, axis=-1) / (TOL + ROUNDINGS * condition)


def value(lobe: Any, v: Array, l: Array) -> Array:
    """What Mitsuba calls the value: with the cosine of l."""
    return lobe.eval(v, l) * np.abs(l[:, 2:])


def value_deviation(case: Case, theirs: dict[str, Array], ours: Array) -> Array:
    """Of values that should be Mitsuba's."""
    return deviation(ours, theirs["eval"], conditions(case, case.v, case.l))


def density(case: Case, v: Array, l: Array) -> Array:
    """The density that Mitsuba samples with: of visible facets, which is the lobe's own, or of all."""
    return case.lobe.pdf(v, l) if case.description["sample_visible"] else density_of_all_facets(case, v, l)


def density_of_all_facets(case: Case, v: Array, l: Array) -> Array:
    """D(m) mz, its Jacobian and, at an interface, the choice (Walter et al. 2007, eq. 14, 17, 24), from our parts."""
    up = np.where(v[:, 2] < 0.0, -1.0, 1.0)
    v, l = (v * up[:, None]).T, (l * up[:, None]).T
    facets, alpha = case.lobe.distribution, case.lobe.alpha
    at = microfacet.reflecting(v, l)
    if isinstance(case.lobe, Conductor):
        return np.where(at.counts & (up > 0.0), facets.distribution(*at.m, *alpha) * at.m[2] / (4.0 * at.l_m), 0.0)
    # Mitsuba widens the facets here, as Walter et al. advise (section 5.3).
    widened = [a * (1.2 - 0.2 * np.sqrt(np.abs(v[2]))) for a in alpha]
    eta = case.lobe.ior**up
    reflected = fresnel.dielectric(at.v_m, eta) / (4.0 * at.l_m)
    through = microfacet.refracting(v, l, eta)
    transmitted = (1.0 - fresnel.dielectric(np.clip(through.v_m, 0.0, 1.0), eta)) * np.abs(through.l_m)
    transmitted *= np.square(eta / through.path)
    return sum(
        np.where(g.counts, facets.distribution(*g.m, *widened) * g.m[2] * share, 0.0)
        for g, share in ((at, reflected), (through, transmitted))
    )


def assert_agrees(deviations: dict[str, Array]) -> None:
    """No deviation above what is allowed; the worst is printed."""
    name, worst = max(((name, float(np.max(d))) for name, d in deviations.items()), key=lambda item: item[1])
    print(f"at most {worst:.3f} of what is allowed: {name}")
    assert worst <= 1.0, f"{name}: {worst:.3g} times what is allowed"


def is_visible(case: Case) -> bool:
    return case.description["sample_visible"]


# Agreement ----------------------------------------------------------------------------------------------------------


def test_values_are_those_of_mitsuba(answers):
    assert_agrees({case.name: value_deviation(case, m, value(case.lobe, case.v, case.l)) for case, m in answers})


def test_densities_are_those_of_mitsuba(answers):
    assert_agrees(
        {
            case.name: deviation(density(case, case.v, case.l), m["pdf"], conditions(case, case.v, case.l))
            for case, m in answers
        }
    )


@pytest.mark.parametrize("btdf", [False, True], ids=["ordinary transmission", "retroreflective transmission"])
def test_a_retroreflective_lobe_is_that_of_mitsuba_at_the_mirrored_view(answers, btdf):
    deviations = {}
    for case, m in filter(lambda answer: is_visible(answer[0]), answers):
        is_metal = isinstance(case.lobe, Conductor)
        lobe = replace(case.lobe, retroreflective=True, **({} if is_metal else {"retroreflective_btdf": btdf}))
        mirrored = (case.v[:, 2:] * case.l[:, 2:] > 0.0) | btdf
        v = np.where(mirrored, mirror(case.v), case.v)
        deviations[case.name] = value_deviation(case, m, value(lobe, v, case.l))
        densities = deviation(lobe.pdf(v, case.l), m["pdf"], conditions(case, case.v, case.l))
        deviations[f"density, {case.name}"] = densities
        wrong = value_deviation(case, m, value(lobe, case.v, case.l))  # as if the flag were ignored
        assert np.mean(wrong > 1.0) > ENOUGH
    assert_agrees(deviations)


def test_what_mitsuba_samples_has_our_density_and_weight(answers):
    # With all facets instead of the visible ones, Mitsuba's weights at interfaces are not its value over its density:
    # the widened facets are left out of them. There is nothing to compare with.
    deviations = {}
    for case, m in filter(lambda answer: is_visible(answer[0]), answers):
        kept = np.any(m["weight"] > 0.0, axis=-1)
        v, l = case.v[kept], m["sample"][kept]
        condition = conditions(case, v, l, sampled=True)
        densities = case.lobe.pdf(v, l)
        deviations[f"density, {case.name}"] = deviation(densities, m["sampled_pdf"][kept], condition)
        deviations[case.name] = deviation(value(case.lobe, v, l) / densities[:, None], m["weight"][kept], condition)
        assert np.mean(deviation(1.001 * densities, m["sampled_pdf"][kept], condition) > 1.0) > ENOUGH
    assert_agrees(deviations)


def test_most_pairs_are_compared_to_the_tolerance_itself(answers):
    # What `conditions` allows on top is for grazing pairs and narrow interfaces.
    shares = [np.mean(ROUNDINGS * conditions(case, case.v, case.l) < TOL) for case, _ in answers]
    print(f"share of the pairs: {np.mean(shares):.2f}, in one case at least {np.min(shares):.2f}")
    assert np.mean(shares) > 0.5
    assert np.min(shares) > ENOUGH


# Differences that are known ------------------------------------------------------------------------------------------


def test_exact_beckmann_masking_differs_from_mitsuba_by_its_rational_fit(answers):
    for case, m in answers:
        if case.description["distribution"] == "ggx":
            continue
        exact = value_deviation(case, m, value(replace(case.lobe, distribution="beckmann"), case.v, case.l))
        condition = conditions(case, case.v, case.l)
        # G1 of v times G1 of l.
        assert np.all(exact * (TOL + ROUNDINGS * condition) < 2.0 * FIT_ERROR + TOL + ROUNDINGS * condition)
        if min(case.lobe.alpha) > 0.3:  # a narrow one masks next to nothing
            assert np.mean(exact > 1.0) > ENOUGH


# Planted errors ------------------------------------------------------------------------------------------------------


def gain(lobe: Any, v: Array, l: Array) -> Array:
    return value(lobe, v, l) * (1.0 + 1e-4)


def wider(lobe: Any, v: Array, l: Array) -> Array:
    return value(replace(lobe, alpha=tuple(a * (1.0 + 1e-4) for a in lobe.alpha)), v, l)


def height_correlated(lobe: Any, v: Array, l: Array) -> Array:
    return value(replace(lobe, masking="smith"), v, l)


def cosine_left_out(lobe: Any, v: Array, l: Array) -> Array:
    return lobe.eval(v, l)


def index_squared_left_out(lobe: Any, v: Array, l: Array) -> Array:
    eta = lobe.ior ** np.sign(v[:, 2:])
    return value(lobe, v, l) * np.where(v[:, 2:] * l[:, 2:] < 0.0, eta**2, 1.0)


def half_vector_of_the_difference(lobe: Any, v: Array, l: Array) -> Array:
    return value(lobe, v, l * [-1.0, -1.0, 1.0])


def index_inverted(lobe: Any, v: Array, l: Array) -> Array:
    return value(replace(lobe, ior=1.0 / lobe.ior), v, l)


OF_ANY_LOBE = (gain, wider, cosine_left_out, half_vector_of_the_difference)


@pytest.mark.parametrize("wrong", OF_ANY_LOBE)
def test_a_planted_error_is_seen(answers, wrong):
    for case, m in answers:
        share = np.mean(value_deviation(case, m, wrong(case.lobe, case.v, case.l)) > 1.0)
        assert share > ENOUGH, case.name


@pytest.mark.parametrize("wrong", [index_squared_left_out, index_inverted])
def test_a_planted_error_of_an_interface_is_seen(answers, wrong):
    for case, m in answers:
        if isinstance(case.lobe, Dielectric):
            share = np.mean(value_deviation(case, m, wrong(case.lobe, case.v, case.l)) > 1.0)
            assert share > ENOUGH, case.name


def test_other_masking_is_seen(answers):
    for case, m in answers:
        if min(case.lobe.alpha) > 0.3:  # a narrow one masks next to nothing
            share = np.mean(value_deviation(case, m, height_correlated(case.lobe, case.v, case.l)) > 1.0)
            assert share > ENOUGH, case.name


def test_a_gain_of_the_density_is_seen(answers):
    for case, m in answers:
        wrong = density(case, case.v, case.l) * (1.0 + 1e-4)
        share = np.mean(deviation(wrong, m["pdf"], conditions(case, case.v, case.l)) > 1.0)
        assert share > ENOUGH, case.name
