"""What the tests of hostile documents rely on does see what it is to see."""

from __future__ import annotations

import subprocess
import sys
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


def test_a_pipe_that_another_process_opens_is_noticed_and_lets_it_go(pipe: Callable, place) -> None:
    made = pipe(place.folder / "pipe.mtlx")
    assert not made.opened
    code = f"print(repr(open({str(made.path)!r}, 'rb').read()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "b''"
    time.sleep(0.1)
    assert made.opened
    made.opened = False  # seen; the end of the test is not to fail of it


def test_the_material_of_these_tests_is_without_fault(place, document_text: Callable, check: Callable) -> None:
    (result,) = check(place.write("m.mtlx", document_text()))
    assert [f.code for f in result.findings] == []
    assert [r.targets["glsl"].status for r in result.renderables] == ["pass"]


def test_pictures_of_these_tests_can_be_read(place) -> None:
    from mrm_mtlx.documents.images import read_image

    for name in ("p.png", "p.exr", "p.jpg", "p.hdr", "p.tif"):
        path: Path = place.picture(name, 8)
        assert read_image(path).shape == (8, 8, 3)
