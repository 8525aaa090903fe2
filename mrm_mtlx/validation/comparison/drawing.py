"""A shader in an engine that runs it: compiled with the document's images, drawn, and held against the reference."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.document_images import ImagesTooLargeError
from mrm_mtlx.engines.base import FLOAT32_BITS, CompileError, DirectionalLight, EngineFailure
from mrm_mtlx.findings import rules
from mrm_mtlx.validation.comparison.expectation import Verdict
from mrm_mtlx.validation.comparison.mending import mended_sources
from mrm_mtlx.validation.compiling import refused
from mrm_mtlx.validation.results import Stage, Status, TargetResult

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from mrm_mtlx.documents.image_checks import CheckedImages
    from mrm_mtlx.engines.base import Engine
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.reference.deviations import Deviation
    from mrm_mtlx.shadergen import Shader
    from mrm_mtlx.validation.comparison.expectation import Expectation
    from mrm_mtlx.validation.comparison.mending import Mended
    from mrm_mtlx.validation.comparison.samples import Comparison, Drawing

# Functions of the languages for which derivatives are differences between neighbouring samples, and nodes whose code
# has them, in materials for hosts that generate it.
_DERIVATIVES = re.compile(r"\b(dFdx|dFdy|fwidth|ddx|ddy|dpdx|dpdy|ND_(heighttonormal|bump|hextiled\w*)_\w+)\b")


def check_draws(
    engine: Engine,
    shader: Shader,
    images: CheckedImages,
    expectations: Mapping[str, tuple[Expectation, Mapping[str, Any]]],
    place: str,
    mended: Mended = mended_sources,
) -> dict[str, tuple[TargetResult, list[Finding]]]:
    """Compile a shader once and draw it for each expectation.

    Parameters
    ----------
    engine
        One that runs shaders of this target.
    shader, images
        A shader, and the images it may ask for.
    expectations
        By a name of the caller's: the reference, and values that replace uniforms of the shader.
    place
        Path of the element in findings.
    mended
        Gives the shader without known deviations, for one that differs.

    Returns
    -------
    dict
        By the same names: the result, and findings.
    """
    available = engine.availability()
    if not available.available:
        return dict.fromkeys(expectations, (TargetResult(Stage.GENERATE, Status.SKIP, available.reason), []))
    try:
        unfit = _unfit(engine, shader)
        if unfit:
            engine.compile(shader).release()
            return dict.fromkeys(expectations, (TargetResult(Stage.COMPILE, Status.SKIP, f"{engine.name} {unfit}"), []))
        try:
            with engine.compile(shader, images.of(shader.files)) as program:
                found = {name: reference.draw(program, changed) for name, (reference, changed) in expectations.items()}
            return {
                name: _check(engine, shader, images, *expectations[name], found[name], mended, place)
                for name in expectations
            }
        except ImagesTooLargeError as error:
            engine.compile(shader).release()  # at least it is compiled
            return dict.fromkeys(expectations, (TargetResult(Stage.COMPILE, Status.SKIP, f"it has {error}"), []))
    except CompileError as error:
        return dict.fromkeys(expectations, refused(shader.target, error.messages[0], place))
    except EngineFailure as error:
        return dict.fromkeys(expectations, refused(shader.target, error, place))


def _unfit(engine: Engine, shader: Shader) -> str:
    """The reason why what an engine gives cannot be compared, continuing its name; "" if it can."""
    can = engine.capabilities
    if can.significand_bits < FLOAT32_BITS:
        return "computes with fewer bits than float32, for which tolerances are made"
    if DirectionalLight not in can.lights:
        return "takes no directional light"
    if shader.files and not can.textures:
        return "looks up no images"
    if can.derivatives and _DERIVATIVES.search(shader.sources["pixel"]):
        return "takes derivatives between samples, which are no neighbours on the surface"
    return ""


def _check(
    engine: Engine,
    shader: Shader,
    images: CheckedImages,
    expectation: Expectation,
    uniforms: Mapping[str, Any],
    found: tuple[Drawing, ...],
    mended: Mended,
    place: str,
) -> tuple[TargetResult, list[Finding]]:
    target, count = shader.target, sum(len(drawing.points) for drawing in found)
    broken = _not_finite(found)
    if expectation.reason and not broken:
        return TargetResult(Stage.COMPILE, Status.SKIP, expectation.reason, samples=count), []
    verdict = None if broken else expectation.compare(found)
    if (verdict is None or not verdict.comparison.passed) and not expectation.reason:
        verdict = _explained(engine, verdict, mended(shader), images, expectation, uniforms)
    if verdict is None:
        node = expectation.not_finite()
        where = f"; in the reference, the node '{node}' is the first that is" if node else ""
        found_broken = rules.SHADER_NOT_FINITE.at(place, f"{target}: {broken}{where}")
        return TargetResult(Stage.COMPARE, Status.FAIL, samples=count), [found_broken]
    if not verdict.deviations:
        return judged(target, verdict.comparison, place)
    names = ", ".join(sorted(d.value for d in verdict.deviations))
    difference = broken if verdict.specified is None else describe(verdict.specified)
    message = f"{target}: it deviates as known ({names}); from the specification: {difference}"
    return _compared(verdict.comparison), [rules.UPSTREAM_DEVIATION.at(place, message)]


def _not_finite(found: tuple[Drawing, ...]) -> str:
    """How many of the colours are no numbers, "" if none is."""
    bad = sum(int(np.count_nonzero(~np.isfinite(drawing.colors).all(axis=1))) for drawing in found)
    return (
        f"{bad / sum(len(drawing.points) for drawing in found):.2%} of the samples are NaN or infinite" if bad else ""
    )


def _explained(
    engine: Engine,
    verdict: Verdict | None,
    mended: Iterable[tuple[frozenset[Deviation], Shader]],
    images: CheckedImages,
    expectation: Expectation,
    uniforms: Mapping[str, Any],
) -> Verdict | None:
    """The verdict on the first of the mended shaders that is right; the one given, if none is.

    None stands for that on colours that are no numbers.
    """
    for deviations, shader in mended:
        with engine.compile(shader, images.of(shader.files)) as program:
            found = expectation.draw(program, uniforms)
        right = None if _not_finite(found) else expectation.compare(found)
        if right is not None and right.comparison.passed:
            specified = None if verdict is None else verdict.comparison
            return Verdict(right.comparison, deviations | right.deviations, specified)
    return verdict


def judged(target: str, comparison: Comparison, place: str) -> tuple[TargetResult, list[Finding]]:
    """The result of a comparison, and a finding if it failed."""
    findings = [] if comparison.passed else [rules.SHADER_DIFFERS.at(place, f"{target}: {describe(comparison)}")]
    return _compared(comparison), findings


def _compared(comparison: Comparison) -> TargetResult:
    """The result of a comparison."""
    return TargetResult(
        stage=Stage.COMPARE,
        status=Status.of(comparison.passed),
        samples=comparison.samples,
        max_error=comparison.max_error,
        median_error=comparison.median_error,
        tolerance=comparison.tolerance,
        worst=comparison.worst,
    )


def describe(comparison: Comparison) -> str:
    """One line on a failed comparison: how many samples, and the worst of them."""
    worst = comparison.worst
    found, expected = (", ".join(f"{x:.6g}" for x in worst[key]) for key in ("found", "expected"))
    v, l = (", ".join(f"{x:.5f}" for x in worst[key]) for key in ("v", "l"))
    return (
        f"{comparison.differing} of {comparison.samples} samples differ; worst at v = ({v}), l = ({l}): found "
        f"({found}), expected ({expected}), relative error {worst['error']:.3g}, allowed {worst['tolerance']:.3g}"
    )
