"""Findings know their line: for every rule's document, that on which a search of the text finds the element."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.library import load_library
