"""Fits from measured data to a report: the samples, the stack that they ask for, and what is to be said of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mrm_mtlx.fitting.fit import FitOptions, fit_stack, warnings
from mrm_mtlx.fitting.model import LayerStack
from mrm_mtlx.fitting.report import FitReport
from mrm_mtlx.fitting.residuals import LOG
from mrm_mtlx.fitting.samples import doubts, from_coefficients, from_measurement
from mrm_mtlx.fitting.selection import coefficient_stack, select

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.fitting.residuals import Residual
    from mrm_mtlx.fitting.selection import Criterion
    from mrm_mtlx.measured import CoefficientSamples, Measurement

    Progress = Callable[[int, int], None]
    Color = tuple[float, float, float]


@dataclass(frozen=True)
class Sampling:
    """The choice of samples of a measured BRDF, and their residual.

    Attributes
    ----------
    residual
        The scale of the comparison.
    theta_max_deg
        Largest angle from the normal.
    plane
        Whether only those in the plane of incidence are.
    around_deg
        Largest angle from retroreflection; None for any.
    viewed
        Whether values with a cosine in them have that of the viewer, not of the light.
    """

    residual: Residual = LOG
    theta_max_deg: float = 80.0
    plane: bool = False
    around_deg: float | None = None
    viewed: bool = False


def fit_measurement(
    measured: Measurement,
    source: str,
    sampling: Sampling,
    options: FitOptions,
    criterion: Criterion | None,
    progress: Progress,
) -> FitReport:
    """Fit the layers that a measured BRDF asks for by a criterion; without one, the paper's one lobe.

    Raises
    ------
    ValueError
        If the data cannot be fitted.
    """
    samples = from_measurement(
        measured,
        residual=sampling.residual,
        largest=math.radians(sampling.theta_max_deg),
        plane=sampling.plane,
        around=None if sampling.around_deg is None else math.radians(sampling.around_deg),
        viewed=sampling.viewed,
        seed=options.seed,
    )
    selection = None
    if criterion is None:
        stack = LayerStack(lobes=1, diffuse=False, paper=True, channels=samples.value.shape[1])
        found = fit_stack(stack, samples, options)
    else:
        selection = select(samples, options, criterion=criterion, progress=progress)
        found = selection.fit
    told = [*doubts(measured, viewed=sampling.viewed), *warnings(found, samples)]
    return FitReport(source, samples, options, found, selection, told)


def fit_coefficients(
    measured: CoefficientSamples,
    source: str,
    tint: Color,
    base: Color,
    options: FitOptions,
    criterion: Criterion,
    progress: Progress,
) -> FitReport:
    """Fit lobes of a tint over a base, as many as coefficients of retroreflection ask for.

    Raises
    ------
    ValueError
        If they cannot be fitted.
    """
    samples = from_coefficients(measured)
    stack = coefficient_stack(samples, tint, base)
    selection = select(samples, options, base=stack, criterion=criterion, progress=progress)
    if not math.isfinite(selection.fit.rms):
        msg = f"no lobe returns as little as {measured.ra.min():g} cd/(lx m2); is the unit right?"
        raise ValueError(msg)
    return FitReport(source, samples, options, selection.fit, selection, warnings(selection.fit, samples))
