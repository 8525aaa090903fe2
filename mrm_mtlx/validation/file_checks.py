"""Checks of the files that a document names: images, and sources of its implementations."""

from __future__ import annotations

import re
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.library.files import MAXIMUM_BYTES
from mrm_mtlx.validation.checks.elements import location, nodes_of
from mrm_mtlx.validation.findings import Finding, finding

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mrm_mtlx.library.files import Reach


def check_files(document: mx.Document, reach: Reach) -> list[Finding]:
    """Findings about files that are missing, or lie outside the folder."""
    findings = [found for node in nodes_of(document) for found in check_images(node, reach)]
    return findings + list(check_sources(document, reach))


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


def check_sources(document: mx.Document, reach: Reach) -> Iterator[Finding]:
    """Whether the shader sources of the document's own implementations, and what they include, lie inside the folder.

    Generators open these files and put their text into the shader, and so into a compiler's messages.
    """
    for implementation in document.getChildren():  # getImplementations() would add those of the library
        if not implementation.isA(mx.Implementation):
            continue
        name = implementation.getFile()
        source = reach.resolve(name) if name else None
        if name and source is None:
            message = f"the source file '{name}' lies outside the folder being checked"
            yield finding("READ_OUTSIDE", location(implementation), message)
            continue
        text = implementation.getAttribute("sourcecode") + (_source_text(source) if source else "")
        for include in _includes(text, reach.at(source.parent) if source else reach, set()):
            message = f"the included source '{include}' lies outside the folder being checked"
            yield finding("READ_OUTSIDE", location(implementation), message)


def _includes(text: str, reach: Reach, seen: set[Path]) -> Iterator[str]:
    """Include directives that leave the folder; those that name files of the libraries stay below their roots."""
    for name in re.findall(r'#\s*include\s*["<]([^">\n]+)[">]', text):
        target = reach.resolve(name)
        climbs = PurePath(name).is_absolute() or ".." in PurePath(name).parts
        if target is None and (climbs or (reach.folder / name).exists()):
            yield name
        elif target is not None and target not in seen:
            seen.add(target)
            yield from _includes(_source_text(target), reach.at(target.parent), seen)


def _source_text(path: Path) -> str:
    """Text of a source file, as much of it as a source file can sensibly have; empty if it cannot be read."""
    try:
        if not path.is_file():  # a pipe would wait for ever
            return ""
        with path.open("rb") as stream:
            return stream.read(MAXIMUM_BYTES).decode("utf-8", "replace")
    except OSError:
        return ""
