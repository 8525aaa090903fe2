"""Colour spaces that a document declares."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.elements import location
from mrm_mtlx.findings import rules
from mrm_mtlx.library.color_spaces import LINEAR, equivalent, in_opencolorio, is_handled

if TYPE_CHECKING:
    from collections.abc import Iterator

    import MaterialX as mx

    from mrm_mtlx.findings.finding import Finding


def check_color_spaces(document: mx.Document) -> Iterator[Finding]:
    """Colour spaces that MaterialX has no transform for, each once, where it is declared first."""
    declared: dict[str, list[Any]] = {}
    for element in document.traverseTree():
        if element.getAttribute("colorspace"):
            declared.setdefault(element.getAttribute("colorspace"), []).append(element)
    for space, elements in declared.items():
        if not is_handled(document, space):
            yield _unknown_space(space, equivalent(document, space), elements)


def _unknown_space(space: str, known: str, elements: list[Any]) -> Finding:
    more = f" (it is declared {len(elements)} times)" if len(elements) > 1 else ""
    if known:
        message = f"'{space}' is OpenColorIO's name of {known}, and unknown to MaterialX's generators{more}"
        return rules.DOC_COLOR_SPACE.at(location(elements[0]), message, f"Write {known}.")
    whose = "of OpenColorIO's configurations " if in_opencolorio(space) else ""
    message = f"'{space}' {whose}cannot be converted to {LINEAR}{more}"
    return rules.DOC_COLOR_SPACE.at(location(elements[0]), message)
