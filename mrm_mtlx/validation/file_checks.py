"""Checks of the files that a document names: images, and sources of its implementations (`source_checks`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.validation.checks.elements import location, nodes_of
from mrm_mtlx.validation.findings import Finding, finding
from mrm_mtlx.validation.source_checks import check_sources

if TYPE_CHECKING:
    from collections.abc import Iterator

    import MaterialX as mx

    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.library.files import Reach


def check_files(document: mx.Document, reach: Reach, library: DataLibrary) -> list[Finding]:
    """Findings about files that are missing, or lie outside the folder."""
    findings = [found for node in nodes_of(document) for found in check_images(node, reach)]
    return findings + check_sources(document, reach, library)


def check_images(node: Any, reach: Reach) -> Iterator[Finding]:
    """Whether the images that a node names exist, inside the folder."""
    for given in node.getInputs():
        if given.getType() != "filename" or not given.getValueString():
            continue
        name = given.getResolvedValueString()
        target = reach.resolve(name)
        if target is None:
            yield finding("READ_OUTSIDE", location(given), f"the image '{name}' lies outside the folder being checked")
        elif "<" not in name and not target.is_file():  # <UDIM> and the like name a set of files
            yield finding("DOC_FILE", location(given), f"the image '{name}' does not exist")
        for file in reach.members(name):
            if reach.inside(file) is None:
                message = f"'{file.name}' of the image '{name}' is a link that leads outside the folder being checked"
                yield finding("READ_OUTSIDE", location(given), message)
