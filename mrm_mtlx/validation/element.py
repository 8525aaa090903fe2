"""The check of one renderable element: energy, code on every target, and the comparison with the reference."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from mrm_mtlx.engines import osl
from mrm_mtlx.library import load_library
from mrm_mtlx.library.surface_models import amount_input
from mrm_mtlx.shadergen import GenerationError, generate
from mrm_mtlx.validation import sampling
from mrm_mtlx.validation.catalogue import ALBEDO_BOUND, STEEP_DEGREES
from mrm_mtlx.validation.checks.elements import location
from mrm_mtlx.validation.compiling import check_compiles
from mrm_mtlx.validation.drawing import GL_TARGETS, DocumentImages, check_draws, judged
from mrm_mtlx.validation.energy import directional_albedos
from mrm_mtlx.validation.expectation import Expectation
from mrm_mtlx.validation.findings import finding
from mrm_mtlx.validation.flag_use import ignores_flag
from mrm_mtlx.validation.osl_light import compare_in_osl
from mrm_mtlx.validation.results import RenderableResult, TargetResult
from mrm_mtlx.validation.retro_sweep import variants

if TYPE_CHECKING:
    import numpy as np

    from mrm_mtlx.reference import Surface
    from mrm_mtlx.shadergen import Shader
    from mrm_mtlx.validation.findings import Finding
    from mrm_mtlx.validation.request import Request
    from mrm_mtlx.validation.retro_sweep import Variant


class ElementCheck:
    """The check of one renderable element on all targets."""

    def __init__(self, request: Request, element: Any, renderable: RenderableResult, flags: list[Any]) -> None:
        self._request = request
        self._element = element
        self._renderable = renderable
        self._flags = flags
        self._place = location(element)
        self._images = DocumentImages(request.reach, self._place)
        self._library = load_library(request.origin)
        self._findings: list[Finding] = []
        self._ignoring: dict[str, set[str]] = {}
        self._expectation: Expectation

    def run(self) -> list[Finding]:
        """Check every target; fill the results, return the findings."""
        self._prepare_reference()
        for target in self._request.targets:
            self._renderable.targets[target] = self._check_target(target)
        if self._ignoring:
            targets = ", ".join(target for target in self._request.targets if target in self._ignoring)
            names = ", ".join(sorted(set().union(*self._ignoring.values())))
            self._report("SHADER_IGNORES_RETRO", f"{targets}: the code does not depend on the flag of {names}")
        return self._findings + self._images.findings

    def _report(self, code: str, message: str) -> None:
        self._findings.append(finding(code, self._place, message))

    def _prepare_reference(self) -> None:
        rng = sampling.generator(self._request.seed, self._renderable.name)
        self._expectation = Expectation(self._element, rng, self._request.samples, self._images)
        surface = self._expectation.surface
        if surface is not None and not surface.is_pattern:
            self._check_energy(surface, self._expectation.lobes, rng)

    def _check_energy(self, surface: Surface, lobes: list[sampling.LobeShape], rng: np.random.Generator) -> None:
        # Four standard errors: one false alarm in 30,000 view angles at which a surface reflects exactly the bound.
        gains = [a for a in directional_albedos(surface, lobes, rng) if a.value - 4.0 * a.error > ALBEDO_BOUND]
        if gains:
            worst = max(gains, key=lambda a: a.value)
            steep = any(a.view_deg <= STEEP_DEGREES for a in gains)
            anisotropic = any(lobe.alpha_x != lobe.alpha_y for lobe in lobes)
            found = f"albedo {worst.value:.3f} at a view angle of {worst.view_deg:g} degrees"
            self._report(
                "ENERGY_ANISOTROPIC" if anisotropic and not steep else "ENERGY_GAIN",
                f"{found}, expected at most 1 (up to {ALBEDO_BOUND:g} passes)",
            )

    def _check_target(self, target: str) -> TargetResult:
        try:
            shader = generate(self._element, target, self._library)
        except GenerationError as error:
            self._report("SHADER_GENERATE", f"{target}: {error}")
            return TargetResult("generate", "fail")
        # An amount has no variable; the graph behind it has flags, which this library honours wherever it has code.
        flags = [n for n in self._flags if target == "mdl" or not amount_input(n)]
        ignoring = {str(n.getName()) for n in flags if ignores_flag(shader, n.getName())}
        if ignoring:
            self._ignoring[target] = ignoring
        if target in GL_TARGETS:
            result, findings = check_draws(shader, self._images, {"": (self._expectation, {})}, self._place)[""]
        else:
            result, findings = check_compiles(shader, self._place)
            if target == "osl" and result.status == "pass" and not ignoring:
                result, findings = self._compare_osl(result)
        self._findings += findings
        return result

    def _compare_osl(self, compiled: TargetResult) -> tuple[TargetResult, list[Finding]]:
        """The comparison in Cycles; without Cycles, or where there is none, what the compiler said."""
        if not osl.availability().available:
            return compiled, []
        rng = sampling.generator(self._request.seed, f"{self._renderable.name} osl")
        try:
            found = compare_in_osl(self._element, self._library, self._request.samples, rng)
        except osl.RuntimeFailure as error:
            return TargetResult("compile", "fail"), [finding("SHADER_COMPILE", self._place, f"osl: {error}")]
        return (replace(compiled, reason=found), []) if isinstance(found, str) else judged("osl", found, self._place)


def sweep_element(request: Request, element: Any) -> tuple[list[RenderableResult], list[Finding]]:
    """Check an element of a dissolved copy with the flag of each of its ordinary specular nodes on, one at a time."""
    found = variants(element)
    if not found:
        return [], []
    place, library = location(element), load_library(request.origin)
    images = DocumentImages(request.reach, place)
    results = {v.name: RenderableResult(f"{element.getNamePath()} + retroreflective {v.name}") for v in found}
    findings: list[Finding] = []
    targets = [target for target in request.targets if target in GL_TARGETS]
    try:
        shaders = {target: generate(element, target, library) for target in targets}
    except GenerationError as error:
        return [], [finding("SHADER_GENERATE", place, f"with the flag of {found[0].name}: {error}")]
    expectations = {}
    for variant in found:
        rng = sampling.generator(request.seed, f"{element.getNamePath()} {variant.name}")
        copy = variant.switched()
        swept = copy.getDescendant(element.getNamePath())
        expectations[variant.name] = Expectation(swept, rng, request.samples, images)
    for target, shader in shaders.items():
        switched = {v.name: (expectations[v.name], _flag(v, shader)) for v in found}
        for name, (result, why) in check_draws(shader, images, switched, place).items():
            results[name].targets[target] = result
            findings += [replace(f, message=f"with the flag of {name} on: {f.message}") for f in why]
    return list(results.values()), findings  # what is wrong with images is told where the element itself is checked


def _flag(variant: Variant, shader: Shader) -> dict[str, Any]:
    variable = variant.uniform(shader)
    return {} if variable is None else {variable: True}
