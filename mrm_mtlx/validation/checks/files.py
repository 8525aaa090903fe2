"""Checks of the files that a document names: images, and sources of its implementations (`sources`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import MaterialX as mx

from mrm_mtlx.documents.elements import is_connected, location, nodes_of
from mrm_mtlx.documents.filenames import filename_of
from mrm_mtlx.documents.image_checks import check_image
from mrm_mtlx.validation.checks.sources import check_sources

if TYPE_CHECKING:
    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary


def check_files(document: mx.Document, reach: Reach, library: DataLibrary) -> list[Finding]:
    """Findings about files that are missing, no files, or lie outside the folder."""
    try:
        named = _images(document)
    except LookupError:  # a definition that inherits from itself: the check of the graph says so
        named = {}
    images = [found for place, name in named.items() for found in check_image(name, reach, place)]
    return images + check_sources(document, reach, library)


def _images(document: mx.Document) -> dict[str, str]:
    """Names of the images that a document's values name, by the places of these values.

    Of a node definition of the document they are the defaults that a node takes. What is connected has no value.
    """
    given = [
        element
        for element in document.traverseTree()
        if element.isA(mx.Input) and not element.getParent().isA(mx.NodeDef) and not is_connected(element)
    ]
    own = {child.getName() for child in document.getChildren() if child.isA(mx.NodeDef)}
    for node in nodes_of(document):
        definition = node.getNodeDef()
        if definition is not None and definition.getName() in own:
            given += [default for default in definition.getActiveInputs() if node.getInput(default.getName()) is None]
    return {location(element): name for element in given if (name := filename_of(element))}
