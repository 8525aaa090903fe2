"""Number of nodes that a document's surfaces come to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.elements import location
from mrm_mtlx.documents.flattening import Sizes
from mrm_mtlx.findings import rules
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.system.limits import MAXIMUM_NODES
from mrm_mtlx.validation.checks.cycles import upstream

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.findings.finding import Finding


def check_size(document: mx.Document) -> Iterator[Finding]:
    """Surfaces that come to more than `MAXIMUM_NODES` nodes, those of definitions counted out."""
    sizes = Sizes(document)
    for element in renderable_elements(document):
        if sum(sizes.of(node) for node in _reached(element)) > MAXIMUM_NODES:
            message = f"its definitions come to more than {MAXIMUM_NODES} nodes"
            yield rules.DOC_TOO_LARGE.at(location(element), message)


def _reached(element: Any) -> list[Any]:
    """The nodes that an element depends on, each once, with itself."""
    start = element.getConnectedNode() if element.isA(mx.Output) else element
    found = {} if start is None else {str(start.getNamePath()): start}
    waiting = list(found.values())
    while waiting:
        for node in upstream(waiting.pop(), {}):
            if str(node.getNamePath()) not in found:
                found[str(node.getNamePath())] = node
                waiting.append(node)
    return list(found.values())
