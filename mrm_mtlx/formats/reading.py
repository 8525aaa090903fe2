"""Reads untrusted files of any format as documents: bounded, inside one folder, with a finding for what is wrong."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.locations import WholeFile
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats.format import Capability
from mrm_mtlx.formats.registry import MATERIALX, format_of

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.format import Format
    from mrm_mtlx.library import DataLibrary


def read_document(path: Path, reach: Reach, library: DataLibrary, scratch: Path) -> Document:
    """Read a file as a document, with what it includes and the data library set.

    Parameters
    ----------
    path
        The file. One whose ending is not known is taken for MaterialX.
    reach
        Where the names of files in it lead.
    library
        Its definitions.
    scratch
        An empty folder for files that are inside of the file, see `formats.format`.

    Returns
    -------
    Document
        With findings that do not prevent reading it.

    Raises
    ------
    ReadError
        If it cannot be read, for any reason that lies in the file.
    """
    file_format = format_of(path) or MATERIALX
    file = reach.shown(path)
    try:
        if not file_format.can(Capability.READ):
            raise ReadError(_no_material(file_format))
        document = file_format.read(path, reach, library, scratch)
    except ReadError as error:
        raise ReadError(replace(error.finding, source=error.finding.source or SourceLocation(file))) from error
    document.locations = document.locations or WholeFile(file)
    document.findings = [document.located(found) for found in document.findings]
    return document


def _no_material(file_format: Format) -> Finding:
    """The finding about a file from which no document can be made."""
    if file_format.can(Capability.COEFFICIENTS):
        message = f"a file of {file_format.title} holds no more of a material than coefficients of retroreflection"
        return rules.READ_FORMAT.at("", message, "Fit a material to them: mrm convert FILE MATERIAL.mtlx")
    return rules.READ_FORMAT.at("", f"files of {file_format.title} are written, and not read")
