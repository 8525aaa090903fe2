"""What the tests of commands share; the command itself is in the conftest of all tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def metal(documents: Path, tmp_path: Path) -> Path:
    """A document without fault in the test's folder, by its name there."""
    path = tmp_path / "metal.mtlx"
    path.write_bytes((documents / "READ_XML" / "passes.mtlx").read_bytes())
    return path
