"""Checks of a document's structure against the node definitions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.text import text_lines
from mrm_mtlx.validation.checks.color_spaces import check_color_spaces
from mrm_mtlx.validation.checks.connections import check_connection, check_graph_output
from mrm_mtlx.validation.checks.cycles import check_cycles
from mrm_mtlx.validation.checks.nodes import Spelling, check_node
from mrm_mtlx.validation.checks.size import check_size
from mrm_mtlx.validation.checks.values import check_form
from mrm_mtlx.validation.findings import Finding, Severity, finding

if TYPE_CHECKING:
    from collections.abc import Iterator

# Messages of MaterialX's own validation that a more precise rule here covers.
_COVERED = (
    "Node interface error",
    "Node interface doesn't support",
    "Invalid value",
    "Invalid port connection",
    "No output found for port connection",
    "Mismatched types in port connection",
)


def check_graph(document: mx.Document) -> list[Finding]:
    """Findings about nodes, inputs, values and connections, in document order."""
    try:
        valid, messages = document.validate()
    except Exception as error:  # values of the wrong number of members, definitions that inherit from themselves
        typed = [element for element in document.traverseTree() if element.isA(mx.TypedElement)]
        findings = [found for element in typed for found in check_form(element)]
        return findings or [finding("DOC_INVALID", "", f"MaterialX cannot validate it: {error}")]
    findings = list(check_cycles(document))
    if findings:
        return findings  # whatever follows connections must not run on these
    spelling = Spelling(document)
    for element in document.traverseTree():
        findings += _check_element(element, spelling)
    findings += check_size(document)
    findings += check_color_spaces(document)
    if not valid:
        explained = any(f.severity is Severity.ERROR for f in findings)
        for line in text_lines(messages.strip()):
            if not (explained and line.startswith(_COVERED)):
                findings.append(finding("DOC_INVALID", "", line.strip()))
    return findings


def _check_element(element: Any, spelling: Spelling) -> Iterator[Finding]:
    if element.isA(mx.Node):
        yield from check_node(element, spelling)
    if element.isA(mx.TypedElement):
        yield from check_form(element)
    if element.isA(mx.PortElement):
        yield from check_connection(element)
    if element.isA(mx.Output) and element.getParent().isA(mx.NodeGraph):
        yield from check_graph_output(element)
