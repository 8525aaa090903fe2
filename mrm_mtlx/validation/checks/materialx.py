"""Messages of MaterialX's own validation, as findings with a place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.elements import location
from mrm_mtlx.findings import rules
from mrm_mtlx.library.dialects import document_version
from mrm_mtlx.system.text import text_lines
from mrm_mtlx.validation.checks.connections import names_only_output

if TYPE_CHECKING:
    from collections.abc import Iterator

    import MaterialX as mx

    from mrm_mtlx.findings.finding import Finding

# Messages that a more precise rule here covers.
_COVERED = (
    "Node interface error",
    "Node interface doesn't support",
    "Invalid value",
    "Invalid port connection",
    "No output found for port connection",
    "Mismatched types in port connection",
    "NodeGraph implementation has a different",
)
# Messages about outputs that are named where there is one alone, which the specification has ignored.
_NAMED_ALONE = ("Multi-output type expected in port connection", "No output found for port connection")
_VERSIONS = ("Future document version", "Unsupported document version")


def messages_of_validation(document: mx.Document, messages: str, *, explained: bool) -> Iterator[Finding]:
    """MaterialX's messages, without those that findings of other rules have `explained` already."""
    elements: dict[str, list[Any]] = {}
    for element in document.traverseTree():
        elements.setdefault(str(element), []).append(element)
    for line in text_lines(messages.strip()):
        message, _, found = line.strip().partition(": <")
        if message in _VERSIONS:
            yield _of_version(document)
        elif not (explained and message.startswith(_COVERED)):
            wrong = next((e for e in elements.get(f"<{found}", ()) if not e.validate()[0]), None)
            if wrong is None or not (message in _NAMED_ALONE and names_only_output(wrong)):
                yield rules.DOC_INVALID.at("" if wrong is None else location(wrong), line.strip())


def _of_version(document: mx.Document) -> Finding:
    """The finding that MaterialX does not know the document's version."""
    known = document_version()
    message = f"its version is '{document.getVersionString()}', expected one up to {known}, which MaterialX reads here"
    return rules.DOC_INVALID.at("", message, f'Write version="{known}" if the document is of it, or update MaterialX.')
