"""Fitting: what was put into data comes out of them, with the uncertainty that is stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.fitting.fit import FitOptions, fit_stack, warnings
from mrm_mtlx.fitting.model import Evaluator, LayerStack
from mrm_mtlx.fitting.residuals import RESIDUALS, ROOT
from mrm_mtlx.fitting.samples import MAXIMUM, directions, doubts, from_coefficients, from_measurement, reciprocity
from mrm_mtlx.fitting.selection import DECISIVE, Criterion, coefficient_stack, select
from mrm_mtlx.measured import CoefficientSamples, Measurement, read

TAPE = LayerStack(coats=1, lobes=1, falling=True)
# A tape: film, a lobe of eight degrees, base.
VALUES = {
    "coat.weight": np.array([0.8]),
    "coat.alpha": np.array([0.05]),
    "lobe.color0": np.array([0.2]),
    "lobe.alpha": np.array([0.06]),
    "lobe.exponent": np.array([0.7]),
    "diffuse.color": np.array([0.4]),
}


@pytest.fixture(scope="session")
def measured() -> Measurement:
    """Exact values of that tape, at three lights: a grid, and finer steps about both peaks."""
    rows = []
    for light in np.deg2rad([15.0, 30.0, 60.0]):
        for theta_v in np.deg2rad(np.arange(5.0, 79.0, 5.0)):
            rows += [(light, theta_v, dphi) for dphi in np.deg2rad([0.0, 20.0, 60.0, 120.0, 160.0, 180.0])]
        for offset in np.deg2rad(np.arange(-9.0, 9.5, 1.5)):
            rows += [(light, light + offset, dphi) for dphi in (0.0, 0.05, np.pi, np.pi - 0.05)]
    theta_l, theta_v, dphi = np.array(rows).T
    empty = Measurement("tape", theta_l, theta_v, dphi, np.zeros((len(rows), 1)))
    f = Evaluator(TAPE, *directions(empty)).eval(VALUES)[:, :1]
    return replace(empty, f=f)


@pytest.fixture(scope="session")
def samples(measured):
    """The same, to be fitted."""
    return from_measurement(measured)


def noisy(samples, rng, amount=0.03):
    """The same with multiplicative errors."""
    return replace(samples, value=samples.value * np.exp(amount * rng.normal(size=samples.value.shape)))


def number(fit, label):
    (i,) = (i for i, p in enumerate(fit.stack.parameters) if p.label == label)
    return float(fit.values[label][0]), float(fit.errors[i])


START = [np.array([0.5, np.log(0.1), 0.3, np.log(0.1), 0.0, 0.5])]


@pytest.mark.parametrize("loss", ["soft_l1", "linear"])
@pytest.mark.parametrize("residual", ["log", "root", "linear"])
def test_parameters_of_exact_data_are_recovered(measured, residual, loss):
    samples = from_measurement(measured, residual=RESIDUALS[residual])
    fit = fit_stack(TAPE, samples, FitOptions(loss=loss), START)
    for name, value in VALUES.items():
        # A search ends when the cost moves by 1e-7 of itself, which here is next to nothing; six digits are written.
        assert fit.values[name][0] == pytest.approx(value[0], rel=1e-3), name


def test_parameters_of_noisy_data_lie_within_their_stated_errors(samples, rng, significance):
    from scipy import stats

    repeats = 8
    scores = []
    for _ in range(repeats):
        fit = fit_stack(TAPE, noisy(samples, rng), FitOptions(), START)
        scores.append([(fit.values[name][0] - VALUES[name][0]) / number(fit, name)[1] for name in VALUES])
    # Errors of the parameters are correlated; each by itself over the repeats is not.
    level = significance.level(2 * len(VALUES))
    for name, score in zip(VALUES, np.array(scores).T, strict=True):
        chance = stats.chi2.cdf(np.sum(np.square(score)), repeats)
        assert level < chance < 1.0 - level, (name, score)


def test_errors_that_are_stated_too_small_would_be_seen(samples, rng):
    fit = fit_stack(TAPE, noisy(samples, rng), FitOptions(), START)
    value, error = number(fit, "lobe.color0")
    # The error is that of the noise: some 3 % over the root of the samples that the lobe has, ten to a thousand.
    assert 0.03 / np.sqrt(1000) < error / value < 0.03 / np.sqrt(10)


def test_the_data_choose_the_layers_that_they_were_made_with(samples, rng):
    found = select(noisy(samples, rng), FitOptions(starts=1))
    stack = found.fit.stack
    assert (stack.coats, stack.lobes, stack.falling, stack.rough, stack.diffuse) == (1, 1, True, False, True)
    assert [step.what for step in found.steps[1:]].count("fall-off with the entrance angle") == 1
    assert all(step.change < -DECISIVE for step in [*found.steps[1:], *found.without])
    assert all(step.change > -DECISIVE for step in found.refused)
    assert found.fit.rms == pytest.approx(0.03, rel=0.15)  # 3 % of noise, of 500 samples


def test_the_same_seed_gives_the_same_numbers(samples, rng):
    there = noisy(samples, rng)
    fits = [fit_stack(TAPE, there, FitOptions(seed=3, starts=2)) for _ in range(2)]
    assert all(np.array_equal(fits[0].values[name], fits[1].values[name]) for name in VALUES)


def test_a_robust_loss_shrugs_off_a_few_wild_samples(samples, rng):
    there = noisy(samples, rng)
    wild = rng.choice(len(there), len(there) // 50, replace=False)
    there.value[wild] *= 100.0
    robust, plain = (fit_stack(TAPE, there, FitOptions(loss=loss), START) for loss in ("soft_l1", "linear"))
    off = [abs(fit.values["diffuse.color"][0] / 0.4 - 1.0) for fit in (robust, plain)]
    assert off[0] < 0.5 * off[1]


def test_a_number_that_the_data_cannot_tell_is_reported(measured):
    # Under one light, the height of a lobe and its fall-off with the entrance angle are one number.
    there = from_measurement(measured.chosen(np.abs(measured.theta_l - np.deg2rad(30.0)) < 1e-6))
    told = warnings(fit_stack(TAPE, there, FitOptions(), START), there)
    assert any("lobe.color0 and lobe.exponent cannot be told apart" in line for line in told)


def test_what_the_data_can_tell_is_not_reported(samples, rng):
    there = noisy(samples, rng)
    assert warnings(fit_stack(TAPE, there, FitOptions(), START), there) == []


def test_a_lobe_that_no_sample_is_within_is_reported(samples):
    values = VALUES | {"lobe.alpha": np.array([0.003])}
    fit = fit_stack(TAPE, samples, FitOptions(), START)
    missed = samples.chosen(np.linalg.norm(samples.v - samples.l, axis=1) > 0.05)
    assert any(
        line.startswith("lobe: 0 samples are within the width")
        for line in warnings(replace(fit, values=values), missed)
    )


def test_fewer_values_than_numbers_are_refused(samples):
    with pytest.raises(ValueError, match="4 values cannot tell 6 parameters"):
        fit_stack(TAPE, samples.chosen(np.arange(4)), FitOptions(), START)


@pytest.mark.parametrize("channels", [3])
def test_colours_are_fitted_channel_by_channel(measured, channels):
    factors = np.array([1.0, 0.5, 0.2])
    f = np.concatenate(
        [Evaluator(TAPE, *directions(measured)).eval(VALUES | _scaled(factor))[:, :1] for factor in factors], axis=1
    )
    stack = replace(TAPE, channels=channels)
    starts = [stack.vector(VALUES | {name: np.repeat(VALUES[name], 3) for name in ("lobe.color0", "diffuse.color")})]
    fit = fit_stack(stack, from_measurement(replace(measured, f=f)), FitOptions(), starts)
    # Layers pass on the mean of the channels; made one by one, the data differ by the share of the others, 0.2 at most.
    np.testing.assert_allclose(fit.values["lobe.color0"] / fit.values["lobe.color0"][0], factors, rtol=0.1)


def _scaled(factor):
    return {name: VALUES[name] * factor for name in ("lobe.color0", "diffuse.color")}


# Errors in data


def test_reciprocal_data_raise_no_doubt(measured):
    assert doubts(measured) == []
    found = reciprocity(measured)
    assert found.pairs >= 10
    # Neighbours are up to a degree apart, over which the lobe of this tape moves by a few percent.
    assert found.factor < 1.1


def test_a_cosine_of_the_viewer_in_the_values_is_found(measured):
    # f cos(theta_v) is stored, and the reader divides by cos(theta_l).
    stored = measured.f * (np.cos(measured.theta_v) / np.cos(measured.theta_l))[:, None]
    wrong = replace(measured, f=stored, had_cosine=True)
    (doubt,) = doubts(wrong)
    assert "see --cosine view" in doubt
    assert doubts(wrong, viewed=True) == []
    read_right = from_measurement(wrong, viewed=True)
    np.testing.assert_allclose(read_right.value, from_measurement(measured).value, rtol=1e-12)  # one cosine and back


def test_values_without_a_cosine_are_not_read_by_another(measured):
    stored = measured.f * (np.cos(measured.theta_v) / np.cos(measured.theta_l))[:, None]
    wrong = replace(measured, f=stored, had_cosine=False)
    (doubt,) = doubts(wrong)
    assert "--cosine" not in doubt
    with pytest.raises(ValueError, match=r"^the values have no cosine in them that could be that of v"):
        from_measurement(wrong, viewed=True)


def test_values_that_no_cosine_makes_reciprocal_are_doubted(measured):
    wrong = replace(measured, f=measured.f * np.where(measured.theta_l > 0.6, 1.0, 3.0)[:, None])
    (doubt,) = doubts(wrong)
    assert "no parameters can fit both" in doubt


def test_radians_that_are_called_degrees_are_doubted(measured):
    angles = {name: np.deg2rad(getattr(measured, name)) for name in ("theta_l", "theta_v", "dphi")}
    assert any("are they in radians?" in doubt for doubt in doubts(replace(measured, **angles)))


def test_a_column_on_the_wrong_side_shows_no_retroreflection(measured):
    # The azimuth counted from the mirror's side: the retroreflective peak is taken for a mirror's, and the other way.
    turned = from_measurement(replace(measured, dphi=measured.dphi + np.pi))
    right, wrong = (fit_stack(TAPE, there, FitOptions(), START) for there in (from_measurement(measured), turned))
    assert wrong.rms > 100.0 * right.rms


# Which samples


def test_samples_are_chosen_by_angle_plane_and_distance(measured):
    every = len(from_measurement(measured, largest=np.pi / 2))
    assert every == len(measured)
    assert np.min(from_measurement(measured, largest=np.deg2rad(50.0)).v[:, 2]) > np.cos(np.deg2rad(50.0))
    plane = from_measurement(measured, plane=True)
    assert np.max(np.abs(plane.v[:, 1])) <= 1e-3
    near = from_measurement(measured, around=np.deg2rad(5.0))
    assert np.max(np.arccos(np.sum(near.v * near.l, axis=1))) <= np.deg2rad(5.0) * (1.0 + 1e-9)
    with pytest.raises(ValueError, match=r"none of the \d+ samples"):
        from_measurement(measured, largest=np.deg2rad(1.0))


def test_of_many_samples_some_are_drawn_by_the_seed(measured):
    many = measured.chosen(np.tile(np.arange(len(measured)), 2 + MAXIMUM // len(measured)))
    one, same, other = (from_measurement(many, seed=seed) for seed in (0, 0, 1))
    assert len(one) == MAXIMUM
    assert np.array_equal(one.value, same.value)
    assert not np.array_equal(one.value, other.value)


def test_two_channels_are_refused(measured):
    with pytest.raises(ValueError, match="2 channels; a material has one"):
        from_measurement(replace(measured, f=np.tile(measured.f, 2)))


@pytest.mark.parametrize("residual", ["log", "root", "linear"])
def test_derivatives_of_residuals_are_those_of_differences(samples, residual):
    there = replace(samples, residual=RESIDUALS[residual])
    model = Evaluator(TAPE, there.v, there.l)
    vector = TAPE.vector(VALUES)
    r, jacobian = there.residuals_with_jacobian(*model.eval_with_jacobian(vector))
    for i in range(len(vector)):
        step = 1e-6 * np.eye(len(vector))[i]
        moved = there.residuals(model.eval(TAPE.values(vector + step)))
        # Two forward differences, of steps 1e-7 and 1e-6: off by 1e-6 times curvatures of some tens.
        np.testing.assert_allclose((moved - r) / 1e-6, jacobian[:, i], atol=1e-4 * np.max(np.abs(jacobian[:, i])))


# Coefficients of retroreflection


def coefficients(*rows):
    observation, entrance, ra = np.array(rows, dtype=float).T
    return CoefficientSamples("", np.deg2rad(observation), np.deg2rad(entrance), np.zeros(len(rows)), ra)


WHITE, GREY = (1.0, 1.0, 1.0), (0.5, 0.5, 0.5)


@pytest.mark.parametrize("tint", [WHITE, (1.0, 0.1, 0.0)])
def test_two_coefficients_are_met_exactly(tint):
    samples = from_coefficients(coefficients((0.2, -4.0, 250.0), (0.5, -4.0, 65.0)))
    stack = coefficient_stack(samples, tint, GREY)
    assert [p.label for p in stack.parameters] == ["lobe.color0", "lobe.alpha"]
    fit = select(samples, FitOptions(loss="linear", starts=1), base=stack, criterion=Criterion.AICC).fit
    # Six digits are written; D moves by four times as much as alpha.
    np.testing.assert_allclose(
        samples.modelled(Evaluator(stack, samples.v, samples.l).eval(fit.values))[:, 0], [250, 65], rtol=1e-5
    )
    assert any("as many numbers as values" in line for line in warnings(fit, samples))


def test_one_coefficient_is_met_with_the_usual_width(rng):
    samples = from_coefficients(coefficients((0.2, 5.0, 100.0)))
    fit = select(
        samples,
        FitOptions(loss="linear", starts=1),
        base=coefficient_stack(samples, WHITE, GREY),
        criterion=Criterion.AICC,
    ).fit
    assert fit.values["lobe.alpha"] == 0.005
    assert fit.rms < 1e-5


def test_coefficients_at_several_entrance_angles_tell_the_fall_off():
    rows = [(o, e, 1.0) for o in (0.2, 0.33, 0.5, 1.0) for e in (-4.0, 20.0, 30.0, 45.0)]
    there = from_coefficients(coefficients(*rows))
    stack = coefficient_stack(there, WHITE, GREY)
    made = {"lobe.color0": [0.1], "lobe.alpha": [0.005], "lobe.exponent": [0.8], "diffuse.color": GREY}
    made = {name: np.array(value) for name, value in made.items()}
    there = replace(there, value=there.modelled(Evaluator(stack, there.v, there.l).eval(made)))
    found = select(there, FitOptions(loss="linear", starts=1), base=stack, criterion=Criterion.AICC)
    assert found.fit.stack.lobes == 1
    for name in ("lobe.color0", "lobe.alpha", "lobe.exponent"):
        assert found.fit.values[name][0] == pytest.approx(made[name][0], rel=1e-4)  # of a search that ends at 1e-7


def test_a_coefficient_below_the_horizon_is_refused():
    with pytest.raises(ValueError, match="observation 2, entrance -89 degrees: a direction is below"):
        from_coefficients(coefficients((2.0, -89.0, 1.0)))


# A measured tape: as a file of the model's, and the one of the paper


@pytest.fixture(scope="session")
def own_tape(tape_file) -> Measurement:
    """What is read from the file of our own."""
    return read(tape_file)


@pytest.fixture(scope="session")
def tape(shared) -> Measurement:
    """The yellow tape of Belcour et al. 2014."""
    return read(shared / "measured" / "retro_3m_yellow.dat")


# The materials that `mrm fit` finds, to begin near: the selection takes longer than a test should.
FOUND = LayerStack(coats=2, lobes=2, falling=True)
NEAR = {
    "coat.weight": 0.9, "coat.alpha": 0.01, "haze.share": 0.3, "haze.alpha": 0.2,
    "lobe.color0": 0.2, "lobe.alpha": 0.04, "lobe.exponent": 1.0,
    "lobe2.color0": 0.5, "lobe2.alpha": 0.4, "lobe2.exponent": 0.3, "diffuse.color": 0.8,
}  # fmt: skip


def near():
    return [FOUND.vector({name: np.array([value]) for name, value in NEAR.items()})]


def test_a_tape_of_more_layers_is_fitted_better_than_by_three_lobes(measured):
    # Twice a film and twice a lobe: 0.03 is the noise that is put in below.
    values = {**NEAR, "coat.alpha": 0.02, "haze.share": 0.4, "lobe.alpha": 0.05, "lobe2.alpha": 0.3}
    made = {name: np.array([value]) for name, value in values.items()}
    rng = np.random.default_rng(2026)
    there = noisy(from_measurement(replace(measured, f=Evaluator(FOUND, *directions(measured)).eval(made)[:, :1])), rng)
    more, three = fit_stack(FOUND, there, FitOptions(), near()), fit_stack(TAPE, there, FitOptions(), START)
    assert more.rms < 1.2 * 0.03 < 2.0 * more.rms < three.rms


def test_the_cosine_in_a_file_is_found_to_be_that_of_the_viewer(own_tape):
    found = reciprocity(own_tape)
    assert found.pairs > 20
    assert found.by_cosine
    assert found.factor > 1.5
    assert found.as_view < 1.1


def test_the_papers_lobe_comes_out_of_a_tape_that_has_it_under_a_film(own_tape):
    samples = from_measurement(own_tape, viewed=True, residual=ROOT, plane=True, around=np.deg2rad(15.0))
    fit = fit_stack(LayerStack(lobes=1, diffuse=False, paper=True), samples, FitOptions())
    # The lobe of the fixture, roughness 0.23 and F0 0.19, seen through a film that passes on some nine tenths each way.
    assert float(np.sqrt(fit.values["lobe.alpha"][0])) == pytest.approx(0.23, abs=0.01)
    assert 0.8 * 0.19 < float(fit.values["lobe.color0"][0]) < 1.05 * 0.19


@pytest.mark.parametrize(("viewed", "bound"), [(False, 0.49), (True, 0.345)])
def test_the_tape_is_fitted_better_than_by_three_lobes(tape, viewed, bound):
    fit = fit_stack(FOUND, from_measurement(tape, viewed=viewed), FitOptions(), near())
    # One retroreflective lobe, one mirror lobe and a Lambertian term reach 0.530 with the cosine of l. Bounds: what is
    # in docs/fitting.md, to two digits.
    assert fit.rms < bound < 0.53


def test_the_cosine_in_the_file_of_the_tape_is_that_of_the_viewer(tape):
    found = reciprocity(tape)
    assert found.pairs > 100
    assert found.by_cosine
    assert found.factor > 2.5
    assert found.as_view < 1.1


def test_the_parameters_of_the_paper_come_out_of_its_model(tape):
    samples = from_measurement(tape, residual=ROOT, plane=True, around=np.deg2rad(15.0))
    fit = fit_stack(LayerStack(lobes=1, diffuse=False, paper=True), samples, FitOptions())
    # The paper prints two digits: roughness 0.23, F0 0.19, F82 0.
    assert round(float(np.sqrt(fit.values["lobe.alpha"][0])), 2) == 0.23
    assert round(float(fit.values["lobe.color0"][0]), 2) == 0.19
    assert round(float(fit.values["lobe.color82"][0]), 2) == 0.0
