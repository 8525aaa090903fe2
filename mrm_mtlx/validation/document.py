"""Checks one document, from its bytes to the comparison of its shaders. Runs in a worker process."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines import compilers, gl, osl
from mrm_mtlx.engines.gl.textures import read_image
from mrm_mtlx.library import Origin, load_library
from mrm_mtlx.shadergen import GenerationError, generate, renderable_elements
from mrm_mtlx.validation import sampling
from mrm_mtlx.validation.catalogue import ALBEDO_BOUND, STEEP_DEGREES
from mrm_mtlx.validation.energy import directional_albedos
from mrm_mtlx.validation.expectation import Expectation
from mrm_mtlx.validation.findings import Severity, finding
from mrm_mtlx.validation.graph_checks import check_graph, location
from mrm_mtlx.validation.reading import ReadError, read_document, resolve_inside
from mrm_mtlx.validation.results import DocumentResult, RenderableResult, TargetResult
from mrm_mtlx.validation.retro_checks import check_retroreflection, is_retroreflective, microfacet_nodes

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.engines.availability import Availability
    from mrm_mtlx.reference import Surface
    from mrm_mtlx.shadergen import Shader
    from mrm_mtlx.validation.comparison import Comparison
    from mrm_mtlx.validation.findings import Finding

# Source targets that the OpenGL driver compiles and runs.
GL_TARGETS = ("glsl", "essl")

# Why targets end at the source: no compiler for them runs here.
_NO_COMPILER = {
    "msl": "no Metal compiler: Apple's tools only",
    "wgsl": "no WGSL compiler: MaterialX writes GLSL to be transpiled",
    "mdl": "no MDL compiler",
}


@dataclass(frozen=True)
class Request:
    """One document to check, and how.

    Attributes
    ----------
    path, root
        The document, and the folder outside of which nothing is opened.
    shown
        The document's path in reports.
    targets
        Names of the targets to generate.
    samples, seed
        Samples per comparison; the seed fixes them.
    origin
        Whose implementation of the flag is checked.
    """

    path: Path
    root: Path
    shown: str
    targets: tuple[str, ...]
    samples: int = 16384
    seed: int = 0
    origin: Origin = Origin.MRM


def check_document(request: Request) -> DocumentResult:
    """Read, check, generate, compile, run and compare one document."""
    result = DocumentResult(request.shown)
    library = load_library(request.origin)
    try:
        document, result.findings = read_document(request.path, request.root, library)
    except ReadError as error:
        result.findings = [error.finding]
        return result
    result.findings += check_graph(document, request.path.parent, request.root)
    blocked = any(f.severity is Severity.ERROR for f in result.findings)
    if any(f.code == "DOC_CYCLE" for f in result.findings):
        return result
    elements = renderable_elements(document)
    if not elements:
        result.findings.append(finding("DOC_NO_RENDERABLE", "", "no material and no output of shader type"))
    if not blocked:
        result.findings += check_retroreflection(document)
    flags = [] if blocked else [n for n in microfacet_nodes(document) if is_retroreflective(n)]
    for element in elements:
        renderable = RenderableResult(str(element.getNamePath()))
        result.renderables.append(renderable)
        if blocked:
            skip = TargetResult("read", "skip", "the document has errors")
            renderable.targets = dict.fromkeys(request.targets, skip)
        else:
            result.findings += _ElementCheck(request, element, renderable, flags).run()
    return result


class _ElementCheck:
    """The check of one renderable element on all targets."""

    def __init__(self, request: Request, element: Any, renderable: RenderableResult, flags: list[Any]) -> None:
        self._request = request
        self._element = element
        self._renderable = renderable
        self._flags = flags
        self._place = location(element)
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
        return self._findings

    def _report(self, code: str, message: str) -> None:
        self._findings.append(finding(code, self._place, message))

    def _prepare_reference(self) -> None:
        rng = sampling.generator(self._request.seed, self._renderable.name)
        images = document_images(self._request.path.parent, self._request.root)
        self._expectation = Expectation(self._element, rng, self._request.samples, images)
        if self._expectation.surface is not None:
            self._check_energy(self._expectation.surface, self._expectation.lobes, rng)

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
        ignoring = {str(n.getName()) for n in self._flags if ignores_flag(shader, n.getName())}
        if ignoring:
            self._ignoring[target] = ignoring
        if target in GL_TARGETS:
            return self._run_in_gl(shader)
        return self._compile(shader)

    def _compile(self, shader: Shader) -> TargetResult:
        if shader.target in _NO_COMPILER:
            return TargetResult("generate", "skip", _NO_COMPILER[shader.target])
        find, compiler = _COMPILERS[shader.target]
        available = find()
        if not available.available:
            return TargetResult("generate", "skip", available.reason)
        message = compiler(shader)
        if message:
            self._report("SHADER_COMPILE", f"{shader.target}: {message}")
        return TargetResult("compile", "fail" if message else "pass")

    def _run_in_gl(self, shader: Shader) -> TargetResult:
        available = gl.availability()
        if not available.available:
            return TargetResult("generate", "skip", available.reason)
        try:
            with gl.SurfaceProgram(shader, self._textures(shader)) as program:
                found = self._expectation.draw(program)
        except gl.CompileError as error:
            self._report("SHADER_COMPILE", f"{shader.target}: {error.messages[0]}")
            return TargetResult("compile", "fail")
        count = sum(len(colors) for colors in found)
        bad = sum(int(np.count_nonzero(~np.isfinite(colors).all(axis=1))) for colors in found)
        if bad:
            self._report("SHADER_NOT_FINITE", f"{shader.target}: {bad / count:.2%} of the samples are NaN or infinite")
            return TargetResult("compare", "fail", samples=count)
        if self._expectation.reason:
            return TargetResult("compile", "skip", self._expectation.reason, samples=count)
        comparison = self._expectation.compare(found)
        if not comparison.passed:
            self._report("SHADER_DIFFERS", f"{shader.target}: {describe(comparison)}")
        return compared(comparison)

    def _textures(self, shader: Shader) -> dict[str, NDArray[np.floating]]:
        """Images of the shader's file uniforms; those that cannot be read are reported and stay black."""
        textures: dict[str, NDArray[np.floating]] = {}
        folder, root = self._request.path.parent, self._request.root
        for port in shader.uniforms:
            if port.type != "filename" or not port.value:
                continue
            path = resolve_inside(str(port.value), folder, root)
            if path is None or not path.is_file():  # reported with the document's structure
                continue
            try:
                textures[port.variable] = read_image(path)
            except ValueError as error:
                self._report("DOC_FILE", f"{shader.target}: {error}")
        return textures


def document_images(folder: Path, root: Path) -> Callable[[str], Array | None]:
    """Function from a file name of a document in `folder` to its pixels, read once; None for what cannot be read."""
    known: dict[str, Array | None] = {}

    def read(name: str) -> Array | None:
        if name not in known:
            path = resolve_inside(name, folder, root)
            try:
                known[name] = None if path is None or not path.is_file() else read_image(path).astype(float)
            except ValueError:  # reported where the shader's textures are read
                known[name] = None
        return known[name]

    return read


def _compile_osl(shader: Shader) -> str:
    """The OSL compiler's first error with its source line, or "" if it accepts the source."""
    try:
        osl.check(shader.sources["pixel"], shader.name)
    except osl.CompileError as error:
        return str(error.messages[0])
    except osl.RuntimeFailure as error:
        return str(error)
    return ""


# How targets that do not run here are compiled: whether they can be, and the compiler's message, "" for none.
_COMPILERS: dict[str, tuple[Callable[[], Availability], Callable[[Shader], str]]] = {
    "vulkan": (compilers.vulkan_availability, compilers.compile_vulkan),
    "slang": (compilers.slang_availability, compilers.compile_slang),
    "osl": (osl.compiler_availability, _compile_osl),
}


def compared(comparison: Comparison) -> TargetResult:
    """The result of a comparison."""
    return TargetResult(
        stage="compare",
        status="pass" if comparison.passed else "fail",
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


def ignores_flag(shader: Shader, node_name: str) -> bool:
    """Whether the generated code does not depend on a node's retroreflective flag.

    The flag is a variable. It is ignored if it is declared and never read again, or handed to functions none of which
    reads the parameter. In MDL it is handed to a module that honours it from version 1.11 on.
    """
    source = shader.sources["pixel"]
    if shader.target == "mdl":
        versions = [int(v) for v in re.findall(r"materialx::pbrlib_1_(\d+)", source)]
        return max(versions, default=0) < 11
    flag = rf"\b{re.escape(node_name)}_retroreflective\b"
    calls = re.findall(rf"(\w+)\s*\(([^;{{}}]*{flag}[^;{{}}]*)\)\s*;", source)
    return not any(_reads_argument(source, function, arguments, flag) for function, arguments in calls)


def _reads_argument(source: str, function: str, arguments: str, flag: str) -> bool:
    """Whether a function that the source defines reads the parameter that the flag is given for."""
    definition = re.search(rf"^\w[\w ]*\b{function}\s*\(([^)]*)\)\s*\{{(.*?)^\}}", source, re.MULTILINE | re.DOTALL)
    if definition is None:  # built into the language: nothing is known against it
        return True
    index = next(i for i, argument in enumerate(arguments.split(",")) if re.search(flag, argument))
    parameter = definition[1].split(",")[index].split()[-1]
    return re.search(rf"\b{parameter}\b", definition[2]) is not None
