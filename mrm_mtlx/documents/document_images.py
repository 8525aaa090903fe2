"""The images of a document, in memory: each file once, and no more of them than memory is meant for."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.images import read_stored, stored_bytes

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.documents.files import Reach

# Of the images that are held for one surface, as they are stored: ten of 4096 x 4096 with four channels of 8 bits.
MAXIMUM_HELD_BYTES = 640 * 2**20


class ImagesTooLargeError(ValueError):
    """The images of a surface take more memory than they may; the text goes on from "it has"."""


class DocumentImages:
    """The image files that a document names: each is read once, and only within reach.

    `problems` are those of the files that cannot be read; files that are missing or outside are findings of the
    document's structure.
    """

    def __init__(self, reach: Reach) -> None:
        self.problems: list[str] = []
        self._reach = reach
        self._known: dict[str, NDArray[Any] | None] = {}
        self._asked: set[str] = set()
        self._excess = ""
        self._lock = threading.Lock()  # surfaces are evaluated by several threads

    def __call__(self, name: str) -> NDArray[Any] | None:
        """Pixels of a file by its name in the document, or None; see `read_stored`.

        Raises
        ------
        ImagesTooLargeError
            If the images of one surface come to more than `MAXIMUM_HELD_BYTES`; then none of them is held any more.
        """
        with self._lock:
            if self._excess:
                raise ImagesTooLargeError(self._excess)
            self._asked.add(name)
            if name not in self._known:
                self._known[name] = self._read(name)
            return self._known[name]

    def of(self, files: Mapping[str, str]) -> dict[str, NDArray[Any]]:
        """Pixels of files by the keys of their names; what cannot be read is left out.

        Raises
        ------
        ImagesTooLargeError
            If there is too much of them.
        """
        pixels = {key: self(name) for key, name in files.items()}
        return {key: image for key, image in pixels.items() if image is not None}

    def start_surface(self) -> None:
        """Another surface is begun: what is held for those before it makes room where that is needed."""
        self._asked.clear()
        self._excess = ""

    def release(self) -> None:
        """Hold nothing; what is asked for again is read again."""
        self.start_surface()
        self._known.clear()

    def _read(self, name: str) -> NDArray[Any] | None:
        path = self._reach.regular(name)
        if path is None:
            return None
        try:
            self._make_room(stored_bytes(path))
            return read_stored(path)
        except ImagesTooLargeError as error:
            self._known.clear()
            self._excess = str(error)
            raise
        except ValueError as error:
            if str(error) not in self.problems:
                self.problems.append(str(error))
            return None

    def _make_room(self, size: int) -> None:
        if self._held() + size > MAXIMUM_HELD_BYTES:
            self._known = {name: pixels for name, pixels in self._known.items() if name in self._asked}
        if self._held() + size > MAXIMUM_HELD_BYTES:
            raise ImagesTooLargeError(too_large("images that take", self._held() + size, MAXIMUM_HELD_BYTES))

    def _held(self) -> int:
        return sum(pixels.nbytes for pixels in self._known.values() if pixels is not None)


def refuse_excess(names: Iterable[str], reach: Reach) -> None:
    """Look at the headers of files that another process is to read.

    Raises
    ------
    ImagesTooLargeError
        If they come to more than `MAXIMUM_HELD_BYTES`.
    ValueError
        If one is no image that is read.
    """
    paths = {path for name in names if (path := reach.regular(name)) is not None}
    size = sum(map(stored_bytes, sorted(paths)))
    if size > MAXIMUM_HELD_BYTES:
        raise ImagesTooLargeError(too_large("images that take", size, MAXIMUM_HELD_BYTES))


def too_large(what: str, found: int, allowed: int) -> str:
    """The text of an `ImagesTooLargeError`."""
    return f"{what} {-(-found // 2**20)} MiB of memory or more; {allowed // 2**20} MiB are for them"
