"""Checks of a document's structure against the node definitions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.findings import rules
from mrm_mtlx.findings.catalogue import brought_findings
from mrm_mtlx.findings.finding import Finding, Severity
from mrm_mtlx.validation.checks.color_spaces import check_color_spaces
from mrm_mtlx.validation.checks.connections import check_connection, check_graph_output
from mrm_mtlx.validation.checks.cycles import check_cycles
from mrm_mtlx.validation.checks.definitions import check_definition
from mrm_mtlx.validation.checks.looks import check_look
from mrm_mtlx.validation.checks.materialx import messages_of_validation
from mrm_mtlx.validation.checks.nodes import Spelling, check_node, check_property_name
from mrm_mtlx.validation.checks.scope import check_scope
from mrm_mtlx.validation.checks.size import check_size
from mrm_mtlx.validation.checks.values import check_form

if TYPE_CHECKING:
    from collections.abc import Iterator


def check_graph(document: mx.Document) -> list[Finding]:
    """Findings about nodes, inputs, values and connections, in document order."""
    try:
        valid, messages = document.validate()
    except Exception as error:  # values of the wrong number of members, definitions that inherit from themselves
        typed = [element for element in document.traverseTree() if element.isA(mx.TypedElement)]
        findings = [found for element in typed for found in check_form(element)]
        return findings or [rules.DOC_INVALID.at("", f"MaterialX cannot validate it: {error}")]
    if any(element.hasInheritanceCycle() for element in document.traverseTree()):
        return list(messages_of_validation(document, messages, explained=False))
    findings = list(check_cycles(document))
    if findings:
        return findings  # whatever follows connections must not run on these
    spelling = Spelling(document)
    for element in document.traverseTree():
        findings += _check_element(element, spelling)
    findings += check_size(document)
    findings += check_color_spaces(document)
    findings += check_scope(document)
    findings += brought_findings(document)
    if not valid:
        explained = any(f.severity is Severity.ERROR for f in findings)
        findings += messages_of_validation(document, messages, explained=explained)
    return findings


def _check_element(element: Any, spelling: Spelling) -> Iterator[Finding]:
    if element.isA(mx.Node):
        yield from check_node(element, spelling)
        yield from check_property_name(element)
    if element.isA(mx.TypedElement):
        yield from check_form(element)
    if element.isA(mx.PortElement):
        yield from check_connection(element)
    yield from check_definition(element)
    yield from check_look(element)
    if element.isA(mx.Output) and element.getParent().isA(mx.NodeGraph):
        yield from check_graph_output(element)
