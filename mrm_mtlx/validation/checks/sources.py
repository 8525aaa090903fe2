"""Checks of the shader sources that a document's implementations name, and of what these include.

Generators open whatever file these names lead to, a pipe as well, and put its text into the shader and so into a
compiler's messages. Their rules are followed here (MaterialX 1.39.5, `GenContext::resolveSourceFile`,
`ShaderStage::addInclude`): a name is looked for beside the file that has it, then in the libraries, and is else one of
the folder in which the command runs.
"""

from __future__ import annotations

import glob
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.elements import location
from mrm_mtlx.documents.files import Reach, read_regular
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.finding import Finding
from mrm_mtlx.system.limits import MAXIMUM_DOCUMENT_BYTES, MAXIMUM_INCLUDES
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.findings.finding import Finding, Rule
    from mrm_mtlx.library import DataLibrary

_INCLUDE = "#include"
# What generators replace in the name of an include.
_TOKEN = re.compile(r"\$\w+")
# What is left for a compiler to include, however it is spelt: across lines, with comments, by a digraph.
_CONTINUED = re.compile(r"\\[ \t]*\r?\n")
_BLANK = r"(?:\s|/\*(?:[^*]|\*(?!/))*+\*/)*+"
_DIRECTIVE = re.compile(rf"(?:#|%:|\?\?=){_BLANK}(?:include|import|embed)|__has_(?:include|embed)")
_SLANG_IMPORT = re.compile(r"\b(?:import|__include|implementing)\b")


def check_sources(document: mx.Document, reach: Reach, library: DataLibrary) -> list[Finding]:
    """Findings about sources of the document's own implementations: each is there, regular, inside, and not endless."""
    sources = _Sources(reach, library)
    own = (child for child in document.getChildren() if child.isA(mx.Implementation))  # without those of the library
    return [found for implementation in own for found in sources.check(implementation)]


class _RefusedError(Exception):
    """A source that a generator must not open; under which rule, and what is wrong with it."""

    def __init__(self, rule: Rule, what: str) -> None:
        super().__init__(what)
        self.rule = rule


class _Sources:
    """The sources of one document; each is read once."""

    def __init__(self, reach: Reach, library: DataLibrary) -> None:
        self._root = reach.root
        self._libraries = library.source_folders
        self._allowed = Reach(reach.root, reach.root, (*reach.search, *self._libraries))
        self._size = 0
        self._known: set[tuple[Path, bool]] = set()

    def check(self, implementation: Any) -> Iterator[Finding]:
        """Findings on the source of an implementation."""
        place, is_slang = location(implementation), implementation.getTarget() == "genslang"
        inline, name = str(implementation.getAttribute("sourcecode")), str(implementation.getFile())
        if inline:
            yield from _left_to_the_compiler(inline, "its code", place, is_slang=is_slang)
        elif name:
            waiting = [(name, Path(implementation.getActiveSourceUri()).parent, 0)]
            while waiting:
                name, folder, depth = waiting.pop()
                what = f"the {'included ' if depth else ''}source file '{printable(name)}'"
                try:
                    for path, text in self._texts(name, folder, depth, is_slang):
                        included, rest = _split(text)
                        yield from _left_to_the_compiler(rest, what, place, is_slang=is_slang)
                        waiting += [(inner, path.parent, depth + 1) for inner in included]
                except _RefusedError as error:
                    yield error.rule.at(place, f"{what} {error}")

    def _texts(self, name: str, folder: Path, depth: int, is_slang: bool) -> Iterator[tuple[Path, str]]:
        """The files that a generator may open for a name, and what they say; without those of a library.

        Raises
        ------
        _RefusedError
            If one must not be opened.
        """
        if depth > MAXIMUM_INCLUDES:
            raise _RefusedError(rules.READ_INCLUDE, f"is included more than {MAXIMUM_INCLUDES} levels deep")
        for found in self._found(name, folder):
            # MaterialX looks for the first, and opens the second, where steps to parents do not follow links.
            path = Path(os.path.normpath(found))
            for file in (found, path):
                target = self._allowed.inside(file)
                if target is None:
                    raise _RefusedError(rules.READ_OUTSIDE, "lies outside the folder being checked")
                if not target.exists():
                    raise _RefusedError(rules.DOC_FILE, "does not exist")
            if (path, is_slang) not in self._known and not any(path.is_relative_to(of) for of in self._libraries):
                self._known.add((path, is_slang))
                yield path, self._text(path)

    def _found(self, name: str, folder: Path) -> list[Path]:
        """Files that a generator tries for a name; one of its tokens may stand for any text."""
        place = Reach(folder, self._root, self._libraries).locate(name)
        if not _TOKEN.search(name) or ".." in place.parts or not place.is_relative_to(folder):
            return [place]
        pattern = _TOKEN.sub("*", glob.escape(str(place.relative_to(folder))))
        found = (sorted(base.glob(pattern)) for base in (folder, *self._libraries))
        return next(filter(None, found), [place])

    def _text(self, path: Path) -> str:
        try:
            content = read_regular(path, MAXIMUM_DOCUMENT_BYTES + 1)
        except OSError as error:
            raise _RefusedError(rules.DOC_FILE, f"cannot be opened: {error.strerror}") from error
        if not content:
            raise _RefusedError(rules.DOC_FILE, "is not a regular file" if content is None else "is empty")
        self._size += len(content)
        if self._size > MAXIMUM_DOCUMENT_BYTES:
            what = f"makes more than {MAXIMUM_DOCUMENT_BYTES // 2**20} MiB of all sources"
            raise _RefusedError(rules.READ_TOO_LARGE, what)
        return content.decode("utf-8", "surrogateescape")


def _split(text: str) -> tuple[list[str], str]:
    """The names that a generator includes from a source, and the lines that it leaves to a compiler."""
    lines = text.split("\n")
    named = (line for line in lines if _INCLUDE in line)
    names = (line[line.find('"') + 1 : line.rfind('"')] for line in named if line.count('"') > 1)
    return [name for name in names if name], "\n".join(line for line in lines if _INCLUDE not in line)


def _left_to_the_compiler(text: str, what: str, place: str, *, is_slang: bool) -> Iterator[Finding]:
    """A finding if a text has a compiler open files, which none is to do."""
    text = _CONTINUED.sub("", text)
    if _DIRECTIVE.search(text) or (is_slang and _SLANG_IMPORT.search(text)):
        hint = f'Write it as {_INCLUDE} "file" on a line of its own, in a source file: MaterialX resolves these.'
        yield rules.READ_INCLUDE.at(place, f"{what} includes a file in a way that only a compiler resolves", hint)
