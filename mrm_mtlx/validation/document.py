"""Checks one document, from its bytes to the comparison of its shaders. Runs in a worker process."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.flattening import TooManyNodesError
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.finding import capped
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.library import load_library
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.validation.checks.files import check_files
from mrm_mtlx.validation.checks.graph import check_graph
from mrm_mtlx.validation.checks.retroreflection import check_retroreflection, is_retroreflective, retroreflecting_nodes
from mrm_mtlx.validation.checks.scope import nothing_to_render
from mrm_mtlx.validation.element import ElementCheck, ElementSweep
from mrm_mtlx.validation.results import DocumentResult, RenderableResult, Stage, Status, TargetResult
from mrm_mtlx.validation.retro_sweep import flattened
from mrm_mtlx.validation.steps import READING, Step, Steps

if TYPE_CHECKING:
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.validation.options import Request


def check_document(request: Request, steps: Steps | None = None) -> DocumentResult:
    """Read, check, generate, compile, run and compare one document, or a file of another format as one.

    `steps` are those of a process that may die; by default, an error inside of the check is raised.
    """
    result = DocumentResult(request.shown)
    steps = steps or Steps()
    steps.begin(READING)
    with tempfile.TemporaryDirectory(prefix="mrm-") as scratch:
        try:
            library = load_library(request.origin)
            document = read_document(request.path, request.reach, library, Path(scratch))
        except ReadError as error:
            result.findings = [error.finding]
            return result
        result.findings = list(document.findings)
        _check(replace(request, reach=document.reach), document.materialx, result, steps)
    result.findings = [document.in_source(found) for found in capped(result.findings)]
    for renderable in result.renderables:
        renderable.path = document.source_location(renderable.path)
    return result


def _check(request: Request, document: Any, result: DocumentResult, steps: Steps) -> None:
    """Add the findings and results of a document that was read."""
    result.findings += check_graph(document)
    result.findings += check_files(document, request.reach, load_library(request.origin))
    blocked = any(f.blocks for f in result.findings)
    if any(f.rule is rules.DOC_CYCLE for f in result.findings):
        return
    elements = renderable_elements(document)
    if not elements:
        result.findings.append(nothing_to_render(document))
    if not blocked:
        result.findings += check_retroreflection(document)
    if request.only_check:
        return
    flags = [] if blocked else [n for n in retroreflecting_nodes(document) if is_retroreflective(n)]
    for element in elements:
        renderable = RenderableResult(str(element.getNamePath()))
        result.renderables.append(renderable)
        if blocked:
            skip = TargetResult(Stage.READ, Status.SKIP, "the document has errors")
            renderable.targets = dict.fromkeys(request.targets, skip)
        else:
            result.findings += ElementCheck(request, element, renderable, flags, steps).run()
    if request.retro_sweep and not blocked:
        _sweep(request, document, result, steps)


def _sweep(request: Request, document: Any, result: DocumentResult, steps: Steps) -> None:
    """Add the results of each surface with the flag of each of its specular nodes switched on."""

    def refused(found: Finding) -> None:
        result.findings.append(found)

    def flatten() -> Any:
        try:
            return flattened(document)
        except ValueError as error:
            rule = rules.DOC_TOO_LARGE if isinstance(error, TooManyNodesError) else rules.SHADER_GENERATE
            return refused(rule.at("", f"the graphs cannot be flattened: {error}"))

    copy = steps.run(Step("", "flattening"), flatten, refused, kept=False)
    for element in renderable_elements(copy) if copy is not None else ():
        renderables, findings = ElementSweep(request, element, steps).run()
        result.renderables += renderables
        result.findings += findings
