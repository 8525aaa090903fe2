"""The documents of files and folders, and what of them cannot be checked."""

from __future__ import annotations

import os
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

from mrm_mtlx.documents.files import Reach, shown_path
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.format import Capability
from mrm_mtlx.formats.registry import suffixes
from mrm_mtlx.validation.options import Request
from mrm_mtlx.validation.results import DocumentResult

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.validation.options import ValidationOptions


def collect(paths: Sequence[Path], options: ValidationOptions) -> tuple[list[DocumentResult], list[Request]]:
    """Results for paths that cannot be checked, and a request per document, each document once."""
    missing: list[DocumentResult] = []
    requests: dict[Path, Request] = {}
    for path in paths:
        if not path.exists():
            message = f"'{path.as_posix()}' does not exist"
            missing.append(DocumentResult(shown_path(path), [rules.READ_MISSING.at("", message)]))
            continue
        is_folder = path.is_dir()
        root = path if is_folder else path.parent
        for file in documents_of(path, options.exclude) if is_folder else [path]:
            name = shown_path(file, path if is_folder else None)
            reach = Reach(file.parent, root, options.roots)
            problem = _unreadable(file, reach if is_folder else None)
            if problem is not None:
                missing.append(DocumentResult(name, [problem]))
                continue
            requests.setdefault(file.resolve(), Request.of(options, file, reach, name))
    return missing, list(requests.values())


def documents_of(folder: Path, exclude: Sequence[str] = ()) -> list[Path]:
    """Files of all formats in a folder and those below it, sorted.

    Folders below it that are hidden, as `.git` is, or that tools fill with packages (`node_modules`) are passed over;
    links to folders are not followed.

    Parameters
    ----------
    folder
        Searched whatever its own name is.
    exclude
        Patterns of what is passed over as well, with `*`, `?` and `[...]` for any characters. One without `/` is for
        the name of a file or folder anywhere below; one with `/` is for a path relative to the folder.
    """
    found: list[Path] = []
    endings = suffixes(Capability.READ, of_folders=True)
    for here, folders, files in os.walk(folder):
        below = Path(here).relative_to(folder)
        folders[:] = [name for name in folders if not (_is_a_tools(name) or _matches(below / name, exclude))]
        # What is called as a document is, and is a folder, is found here and refused where it is read.
        names = [name for name in (*folders, *files) if Path(name).suffix.lower() in endings]
        found += [Path(here, name) for name in names if not _matches(below / name, exclude)]
    return sorted(found, key=Path.as_posix)


def _is_a_tools(name: str) -> bool:
    """True if a folder below the one that was named belongs to a tool."""
    return name.startswith(".") or name == "node_modules"


def _matches(path: Path, patterns: Sequence[str]) -> bool:
    """True if a pattern is for a path, relative to the folder that was named."""
    return any(fnmatchcase(path.as_posix() if "/" in each else path.name, each.strip("/")) for each in patterns)


def _unreadable(file: Path, reach: Reach | None) -> Finding | None:
    """The finding on a file that no worker is given, or None; `reach` is that of one found in a folder."""
    try:
        file.resolve()
        str(file).encode("utf-8")
    except (OSError, RuntimeError):
        return rules.READ_FAILED.at("", "it is a link that leads to itself")
    except UnicodeEncodeError:
        return rules.READ_FAILED.at("", "its name is not valid UTF-8")
    if reach is not None and reach.inside(Path(file.name)) is None:
        return rules.READ_OUTSIDE.at("", "it is a link that leads out of the folder being checked")
    return None
