"""The node library against the oracle passes, and a library that is wrong anywhere fails there."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf.vectors import half_vector, mirror
from mrm_mtlx.conformance import NODES, Case, cases, run
from mrm_mtlx.conformance.cases import ALPHA_RANGE, case_document, case_points
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.library import DataLibrary, Origin
from mrm_mtlx.reference import Surface
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.samples import compare, draw

# Enough that every case meets its peaks and its grazing directions some hundred times.
SAMPLES = 1024


def test_the_cases_are_every_node_flag_and_shape_once():
    names = [case.name for case in cases()]
    assert len(names) == len(set(names)) == len(NODES) * 2 * 2 * 2


def assert_passed(results) -> None:
    for result in results:
        assert result.status == "pass", (result.case.name, result.target)
        assert result.comparison.samples == SAMPLES
        # Two-sided: float32 was at work. Its errors are neither nothing nor as large as what is allowed.
        assert 2.0**-26 < result.comparison.median_error < 2.0**-16
        assert 0.0 < result.comparison.excess < 1.0


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("origin", Origin)
def test_every_case_passes_with_our_library_and_with_the_standard_one(gl_clean, origin, node):
    chosen = [case for case in cases() if case.node == node]
    heard: list[tuple[int, int]] = []
    results = list(run(("glsl",), SAMPLES, 0, origin, lambda done, total: heard.append((done, total)), chosen))
    assert [result.case for result in results] == chosen
    assert_passed(results)
    assert heard == [(k, len(chosen)) for k in range(1, len(chosen) + 1)]


@pytest.mark.parametrize("node", NODES)
def test_every_node_passes_on_both_targets(gl_clean, node):
    case = Case(node, retroreflective=True, anisotropic=True, film=False)
    results = list(run(("glsl", "essl"), SAMPLES, 0, Origin.MRM, chosen=[case]))
    assert [result.target for result in results] == ["glsl", "essl"]
    assert_passed(results)


def test_results_depend_on_the_seed_and_not_on_what_else_runs(gl):
    case = Case("dielectric_bsdf", retroreflective=True, anisotropic=False, film=False)
    alone, again, other = (next(run(("glsl",), 256, seed, Origin.MRM, chosen=[case])).to_json() for seed in (0, 0, 1))
    among = [r.to_json() for r in run(("glsl",), 256, 0, Origin.MRM, chosen=[cases()[0], case])][1]
    assert alone == again == among
    assert alone["worst"] != other["worst"]


def test_samples_beyond_one_batch_are_all_compared(gl):
    case = Case("conductor_bsdf", retroreflective=True, anisotropic=True, film=False)
    count = (1 << 16) + 7
    (result,) = run(("glsl",), count, 0, Origin.MRM, chosen=[case])
    assert result.comparison.samples == count
    assert result.status == "pass"


def test_a_target_that_does_not_run_here_is_refused():
    with pytest.raises(ValueError, match="runs on glsl, essl, osl, storm, not on msl"):
        next(run(("glsl", "msl"), 16, 0, Origin.MRM))


# What is drawn --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.name)
def test_the_document_of_a_case_varies_every_input_but_the_flag(library, case):
    document = case_document(case, library.document)
    valid, message = document.validate()
    assert valid, message
    lobe = document.getNode("lobe")
    assert lobe.getInputValue("retroreflective") is case.retroreflective
    connected = {given.getName() for given in lobe.getInputs() if given.getNodeName()}
    left = {"retroreflective", "normal", "tangent", "distribution", "scatter_mode"}
    film = {"thinfilm_thickness", "thinfilm_ior"}
    declared = {declared.getName() for declared in lobe.getNodeDef().getActiveInputs()}
    assert connected == declared - left - (set() if case.film else film)


def test_widths_cover_their_range_and_lobes_are_hit(rng):
    case = Case("conductor_bsdf", retroreflective=True, anisotropic=True, film=True)
    points = case_points(case, 8192, rng)
    alpha = points.properties["roughness"]
    low, high = ALPHA_RANGE
    assert low * 0.99 <= np.min(alpha) < 1.1 * low
    assert 0.9 * high < np.max(alpha) <= high
    assert abs(np.corrcoef(np.log(alpha).T)[0, 1]) < 0.1  # the two widths are drawn apart
    # Local directions again: the frame of each sample, turned to face the view.
    n = points.normal * np.sign(np.sum(points.normal * points.view, axis=1, keepdims=True))
    frame = np.stack([points.tangent, np.cross(n, points.tangent), n], axis=1)
    v, l = (np.einsum("nij,nj->ni", frame, np.broadcast_to(a, n.shape)) for a in (points.view, points.light))
    m = half_vector(mirror(v), l)
    within = np.hypot(m[:, 0] / alpha[:, 0], m[:, 1] / alpha[:, 1]) <= m[:, 2]
    assert np.mean(within) > 0.4


# A library that is wrong ----------------------------------------------------------------------------------------------


@pytest.fixture
def failing(gl_clean, changed_library):
    """Function from a change to a file of the node library to the names of the cases that then fail."""

    def names(file: str, old: str, new: str, chosen: list[Case]) -> set[str]:
        wrong, _ = changed_library(f"genglsl/{file}", old, new)
        return {case.name for case in chosen if not passes(case, wrong)}

    return names


def passes(case: Case, library: DataLibrary) -> bool:
    """One case of a library, as `conformance.run` does it with the installed one."""
    document = case_document(case, library.document)
    element = renderable_elements(document)[0]
    points = case_points(case, SAMPLES, sampling.generator(0, case.name))
    with SurfaceProgram(generate(element, "glsl", library)) as program:
        return compare(draw(program, points).colors, Surface(element).tolerance(points), points).passed


# A compiler takes a second or two per case, so each damage is tried on few: one node with and without the flag, or one
# case of each node.
PAIR = [Case("conductor_bsdf", flag, anisotropic=True, film=False) for flag in (False, True)]
ORDINARY, RETRO = ({case.name for case in PAIR if case.retroreflective is flag} for flag in (False, True))
EACH = [Case(node, retroreflective=True, anisotropic=True, film=False) for node in NODES]
MIRROR, CALL = "lib/mrm_retroreflection.glsl", "mrm_{}.glsl"

DAMAGE = {
    "nothing": (MIRROR, "(retroreflective", "(retroreflective", set()),
    "the flag ignored": (MIRROR, "(retroreflective && reflects)", "(false)", RETRO),
    "the flag always on": (MIRROR, "(retroreflective && reflects)", "(reflects)", ORDINARY),
    "the view turned round, not reflected": (MIRROR, "reflect(-closureData.V, N)", "-closureData.V", RETRO),
    "the light reflected too": (MIRROR, "closureData.L, V", "reflect(-closureData.L, N), V", ORDINARY | RETRO),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_wrong_library_fails_in_the_cases_that_it_is_wrong_in(failing, damage):
    file, old, new, expected = DAMAGE[damage]
    assert failing(file, old, new, PAIR) == expected


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize(
    ("old", "new"),
    [("mirrored, weight", "mirrored, 1.001 * weight"), (" roughness, false", " roughness.yx, false")],
    ids=["a thousandth brighter", "widths exchanged"],
)
def test_a_wrong_wrapper_fails_for_its_node_alone(failing, node, old, new):
    assert failing(CALL.format(node), old, new, EACH) == {case.name for case in EACH if case.node == node}


def test_a_wrapper_that_turns_the_view_twice_is_ordinary_and_fails(failing):
    # The reason why the wrappers switch off the flag of the standard function.
    found = failing("mrm_conductor_bsdf.glsl", "roughness, false", "roughness, retroreflective", PAIR)
    assert found == RETRO
