"""Checks of a document's structure against the node definitions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.text import text_lines
from mrm_mtlx.validation.checks.color_spaces import check_color_spaces
from mrm_mtlx.validation.checks.connections import check_outputs
from mrm_mtlx.validation.checks.cycles import check_cycles
from mrm_mtlx.validation.checks.elements import nodes_of
from mrm_mtlx.validation.checks.nodes import check_node
from mrm_mtlx.validation.findings import Finding, Severity, finding

if TYPE_CHECKING:
    import MaterialX as mx

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
    except Exception as error:  # definitions that inherit from themselves, types that contain themselves
        return [finding("DOC_INVALID", "", f"MaterialX cannot validate it: {error}")]
    findings = list(check_cycles(document))
    if findings:
        return findings  # whatever follows connections must not run on these
    for node in nodes_of(document):
        findings += check_node(node)
    findings += check_outputs(document)
    findings += check_color_spaces(document)
    if not valid:
        explained = any(f.severity is Severity.ERROR for f in findings)
        for line in text_lines(messages.strip()):
            if not (explained and line.startswith(_COVERED)):
                findings.append(finding("DOC_INVALID", "", line.strip()))
    return findings
