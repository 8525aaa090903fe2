"""The check of one renderable element: energy, code on every target, and the comparison with the reference."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.elements import location
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.engines import registry
from mrm_mtlx.engines.base import EngineFailure
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.rules.optics import ALBEDO_BOUND, STEEP_DEGREES
from mrm_mtlx.library import load_library
from mrm_mtlx.shadergen import GenerationError, MissingCodeError, generate
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.closures import compare_closures
from mrm_mtlx.validation.comparison.drawing import check_draws, judged
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.mending import mended_shaders
from mrm_mtlx.validation.compiling import check_compiles, refused
from mrm_mtlx.validation.energy import directional_albedos
from mrm_mtlx.validation.flag_use import ignored_flags
from mrm_mtlx.validation.results import RenderableResult, Stage, Status, TargetResult
from mrm_mtlx.validation.retro_sweep import variants
from mrm_mtlx.validation.steps import Step

if TYPE_CHECKING:
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.shadergen import Shader
    from mrm_mtlx.validation.options import Request
    from mrm_mtlx.validation.retro_sweep import Variant
    from mrm_mtlx.validation.steps import Steps


# Why a target is not tried, see `Steps.skips`.
GIVEN_UP = "given up after other parts of the document"


@dataclass
class _Outcome:
    """The outcome of a step: a target's result, findings, and the nodes whose flag the code ignores."""

    result: TargetResult
    findings: list[Finding]
    image_findings: list[Finding] = field(default_factory=list)
    ignoring: frozenset[str] = frozenset()


class ElementCheck:
    """The check of one renderable element on all targets, each of which is a step."""

    def __init__(
        self, request: Request, element: Any, renderable: RenderableResult, flags: list[Any], steps: Steps
    ) -> None:
        self._request = request
        self._element = element
        self._renderable = renderable
        self._flags = flags
        self._steps = steps
        self._place = location(element)
        self._images = CheckedImages(request.reach, self._place)
        self._library = load_library(request.origin)
        self._rng = sampling.generator(request.seed, renderable.name)
        self._findings: list[Finding] = []
        self._expectation: Expectation

    def run(self) -> list[Finding]:
        """Check every target; fill the results, return the findings."""
        reference, energy = (Step(self._renderable.name, part) for part in ("reference", "energy"))
        if not self._steps.skips(reference):
            self._expectation = self._steps.run(reference, self._expect, self._expect, kept=False)
        if not self._steps.skips(energy):
            self._findings += self._steps.run(energy, self._check_energy, lambda found: [found])
        image_findings, ignoring = list(self._images.findings), {}
        for target in self._request.targets:
            outcome = self._outcome(target)
            self._renderable.targets[target] = outcome.result
            self._findings += outcome.findings
            image_findings += outcome.image_findings
            if outcome.ignoring:
                ignoring[target] = outcome.ignoring
        if ignoring:
            names = ", ".join(sorted(frozenset().union(*ignoring.values())))
            message = f"{', '.join(ignoring)}: the code does not depend on the flag of {names}"
            self._findings.append(rules.SHADER_IGNORES_RETRO.at(self._place, message))
        return self._findings + list(dict.fromkeys(image_findings))

    def _expect(self, lost: Finding | None = None) -> Expectation:
        """The reference; if a process was lost in it, what there is without."""
        self._findings += [lost] if lost else []
        reason = f"the reference: {lost.message}" if lost else ""
        return Expectation(self._element, self._rng, self._request.samples, self._images, reason)

    def _check_energy(self) -> list[Finding]:
        surface, lobes = self._expectation.surface, self._expectation.lobes
        if surface is None or surface.is_pattern:
            return []
        # Four standard errors: one false alarm in 30,000 view angles at which a surface reflects exactly the bound.
        albedos = directional_albedos(surface, lobes, self._rng)
        gains = [a for a in albedos if a.value - 4.0 * a.error > ALBEDO_BOUND]
        if not gains:
            return []
        worst = max(gains, key=lambda a: a.value)
        steep = any(a.view_deg <= STEEP_DEGREES for a in gains)
        anisotropic = any(lobe.alpha_x != lobe.alpha_y for lobe in lobes)
        found = f"albedo {worst.value:.3f} at a view angle of {worst.view_deg:g} degrees"
        rule = rules.ENERGY_ANISOTROPIC if anisotropic and not steep else rules.ENERGY_GAIN
        return [rule.at(self._place, f"{found}, expected at most 1 (up to {ALBEDO_BOUND:g} passes)")]

    def _outcome(self, target: str) -> _Outcome:
        """The outcome of the check of a target, now or in the process before."""
        step = Step(self._renderable.name, target)
        if self._steps.skips(step):
            return _Outcome(TargetResult(Stage.READ, Status.SKIP, GIVEN_UP), [])
        return self._steps.run(step, lambda: self._check_target(target), _lost)

    def _check_target(self, target: str) -> _Outcome:
        try:
            shader = generate(self._element, target, self._library)
        except MissingCodeError as error:
            return _Outcome(TargetResult(Stage.GENERATE, Status.SKIP, str(error)), [])
        except GenerationError as error:
            found = rules.SHADER_GENERATE.at(self._place, f"{target}: {error}")
            return _Outcome(TargetResult(Stage.GENERATE, Status.FAIL), [found])
        ignoring = ignored_flags(shader, self._flags)
        result, findings = self._compiled_or_run(shader, honoured=not ignoring)
        return _Outcome(result, findings, self._images.findings, ignoring)

    def _compiled_or_run(self, shader: Shader, *, honoured: bool) -> tuple[TargetResult, list[Finding]]:
        """The result of a shader in its engine; closures are compared where the flags are `honoured`."""
        engine = registry.engine_for(shader.target)
        if engine is None:
            return TargetResult(Stage.GENERATE, Status.SKIP, registry.unserved(shader.target)), []
        if registry.runs(engine):
            mended = partial(mended_shaders, self._element, self._library)
            found = check_draws(engine, shader, self._images, {"": (self._expectation, {})}, self._place, mended)
            return found[""]
        result, findings = check_compiles(engine, shader, self._place)
        if result.status is Status.PASS and honoured:
            return self._compare_closures(shader.target, result)
        return result, findings

    def _compare_closures(self, target: str, compiled: TargetResult) -> tuple[TargetResult, list[Finding]]:
        """The comparison of what closures reflect; where nothing here measures it, what the compiler said."""
        engine = registry.engine_for(target, registry.measures_closures)
        if engine is None or engine.bench is None or not engine.availability().available:
            return compiled, []
        rng = sampling.generator(self._request.seed, f"{self._renderable.name} {target}")
        try:
            found = compare_closures(self._element, self._library, self._request.samples, rng, engine.bench)
        except EngineFailure as error:
            return refused(target, error, self._place)
        return (replace(compiled, reason=found), []) if isinstance(found, str) else judged(target, found, self._place)


def _lost(found: Finding) -> _Outcome:
    """The outcome of a target in whose check a process was lost."""
    return _Outcome(TargetResult(Stage.GENERATE, Status.FAIL), [found])


class ElementSweep:
    """The check of an element of a flattened copy with the flag of each of its ordinary specular nodes on in turn."""

    def __init__(self, request: Request, element: Any, steps: Steps) -> None:
        self._request = request
        self._element = element
        self._steps = steps
        self._name = str(element.getNamePath())
        self._place = location(element)
        self._images = CheckedImages(request.reach, self._place)
        self._variants = variants(element)

    def run(self) -> tuple[list[RenderableResult], list[Finding]]:
        """Results of a renderable per node, and findings; those on images are told where the element is checked."""
        names = [v.name for v in self._variants]
        results = {name: RenderableResult(self._name, switched=name) for name in names}
        findings: list[Finding] = []
        for target in (t for t in self._request.targets if t in registry.targets(registry.runs) and results):
            step = Step(self._name, f"{target}, with the flag of each node on")
            if self._steps.skips(step):
                continue
            outcomes = self._steps.run(step, partial(self._check, target), self._lost)
            for name, outcome in outcomes.items():
                results[name].targets[target] = outcome.result
                findings += outcome.findings
        return list(results.values()), list(dict.fromkeys(findings))

    def _check(self, target: str) -> dict[str, _Outcome]:
        try:
            shader = generate(self._element, target, load_library(self._request.origin))
        except MissingCodeError as error:
            return {v.name: _Outcome(TargetResult(Stage.GENERATE, Status.SKIP, str(error)), []) for v in self._variants}
        except GenerationError as error:
            message = f"with the flag of {self._variants[0].name}: {error}"
            return self._lost(rules.SHADER_GENERATE.at(self._place, message))
        engine = registry.engine_for(target, registry.runs)
        assert engine is not None  # `run` asks for targets that an engine runs
        switched = {v.name: (self._expectations[v.name], _flag(v, shader)) for v in self._variants}
        outcomes = {}
        for name, (result, found) in check_draws(engine, shader, self._images, switched, self._place).items():
            told = [replace(f, message=f"with the flag of {name} on: {f.message}") for f in found]
            outcomes[name] = _Outcome(result, told)
        return outcomes

    def _lost(self, found: Finding) -> dict[str, _Outcome]:
        return {v.name: _Outcome(TargetResult(Stage.GENERATE, Status.FAIL), [found]) for v in self._variants}

    @cached_property
    def _expectations(self) -> dict[str, Expectation]:
        """The reference of each variant."""
        expectations = {}
        for variant in self._variants:
            rng = sampling.generator(self._request.seed, f"{self._name} {variant.name}")
            copy = variant.switched()  # an element does not keep its document alive
            swept = copy.getDescendant(self._name)
            expectations[variant.name] = Expectation(swept, rng, self._request.samples, self._images)
        return expectations


def _flag(variant: Variant, shader: Shader) -> dict[str, Any]:
    variable = variant.uniform(shader)
    return {} if variable is None else {variable: True}
