"""Documents that mean harm, and what they reach for: secrets outside of their folder, pipes, endless work.

A test here is named after what the document did. Every one has a limit of time, so that what hangs fails.
"""

from __future__ import annotations

import os
import signal
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

# Seconds after which a test here counts as hung; the longest takes about twenty.
TEST_LIMIT_S = 240
# Seconds between two looks at a pipe.
_LOOK_S = 0.02

# A material without fault, for documents that are to fail for one reason alone.
SURFACE = """
  <oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">{inputs}</oren_nayar_diffuse_bsdf>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf"/></surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>"""


@pytest.fixture(autouse=True)
def time_limit() -> Iterator[None]:
    """Fail a test that hangs, also in a system call that waits for a pipe."""
    if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def hung(*_: object) -> None:
        pytest.fail(f"not finished within {TEST_LIMIT_S} s", pytrace=False)

    before = signal.signal(signal.SIGALRM, hung)
    signal.alarm(TEST_LIMIT_S)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="session")
def document_text() -> Callable[..., str]:
    """Function from elements, and inputs of the diffuse lobe, to the text of a document with the material `m`."""

    def make(elements: str = "", inputs: str = "", attributes: str = "") -> str:
        surface = SURFACE.format(inputs=inputs)
        return f'<?xml version="1.0"?>\n<materialx version="1.39" {attributes}>{elements}{surface}\n</materialx>\n'

    return make


@dataclass(frozen=True)
class Place:
    """A folder whose documents are checked, and one beside it that nothing is read from.

    `secrets` has a file of each kind in the folder outside, by its ending (".mtlx", ".png", ".usda", ".glsl", ".bin"),
    each but the picture with the word `SECRET` in what it says.
    """

    folder: Path
    outside: Path
    secrets: dict[str, Path]

    def write(self, name: str, text: str | bytes) -> Path:
        """A file in the folder, below which `name` may lie."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    def picture(self, name: str, size: int = 4) -> Path:
        """A small picture in the folder; the ending names its format."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        save_picture(path, size)
        return path


SECRET = "SECRET"


def save_picture(path: Path, size: int = 4) -> None:
    """Write a picture of a size by OpenImageIO."""
    import OpenImageIO as oiio

    pixels = np.linspace(0.0, 1.0, size * size * 3, dtype=np.float32).reshape(size, size, 3)
    kind = oiio.FLOAT if path.suffix in (".exr", ".hdr") else oiio.UINT8
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), oiio.ImageSpec(size, size, 3, kind))
    assert out.write_image(pixels)
    assert out.close()


@pytest.fixture
def place(tmp_path: Path, document_text: Callable[..., str]) -> Place:
    """The two folders, `tmp_path / "documents"` and `tmp_path / "outside"`."""
    folder, outside = tmp_path / "documents", tmp_path / "outside"
    folder.mkdir()
    outside.mkdir()
    secrets = {suffix: outside / f"secret{suffix}" for suffix in (".mtlx", ".png", ".usda", ".glsl", ".bin")}
    secrets[".mtlx"].write_text(document_text(f'<constant name="{SECRET}" type="float"/>'), encoding="utf-8")
    secrets[".usda"].write_text(f'#usda 1.0\ndef Scope "{SECRET}" {{}}\n', encoding="utf-8")
    secrets[".glsl"].write_text(f"// {SECRET}\n", encoding="utf-8")
    secrets[".bin"].write_text(SECRET, encoding="utf-8")
    save_picture(secrets[".png"])
    return Place(folder, outside, secrets)


@dataclass
class Pipe:
    """A named pipe that nobody writes to, and whether anybody opened it for reading.

    Whoever does would wait for ever; here it is let go at once, with an empty file.
    """

    path: Path
    opened: bool = False


@pytest.fixture
def pipe() -> Iterator[Callable[[Path], Pipe]]:
    """Function from a path to a named pipe there. The test fails if anything, in whatever process, opened one."""
    if not hasattr(os, "mkfifo"):
        pytest.skip("there are no named pipes")
    pipes: list[Pipe] = []
    ended = threading.Event()

    def look() -> None:
        while not ended.wait(_LOOK_S):
            for made in pipes:
                made.opened = _has_reader(made.path) or made.opened

    def make(path: Path) -> Pipe:
        path.parent.mkdir(parents=True, exist_ok=True)
        os.mkfifo(path)
        pipes.append(Pipe(path))
        return pipes[-1]

    thread = threading.Thread(target=look, daemon=True)
    thread.start()
    yield make
    ended.set()
    thread.join()
    assert [made.path.name for made in pipes if made.opened] == [], "a pipe was opened"


def _has_reader(path: Path) -> bool:
    """Whether somebody has a pipe open for reading; who waits in that call goes on, with the end of the file."""
    try:
        os.close(os.open(path, os.O_WRONLY | os.O_NONBLOCK))
    except OSError:  # ENXIO: nobody; or the pipe is gone
        return False
    return True


@pytest.fixture
def full_disk() -> Path:
    """A file that can be opened for writing and takes nothing, as on a full disk."""
    device = Path("/dev/full")
    if not device.exists():
        pytest.skip("there is no /dev/full")
    return device


@pytest.fixture
def link() -> Callable[[Path, Path], Path]:
    """Function that makes a symbolic link at the first path, which leads to the second; skips where there are none."""

    def make(path: Path, target: Path) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            path.symlink_to(target)
        except OSError:
            pytest.skip("no symbolic links here")
        return path

    return make
