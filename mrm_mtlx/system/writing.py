"""Writing files whole or not at all: one, or several that belong together."""

from __future__ import annotations

import contextlib
import errno
import filecmp
import os
import secrets
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from mrm_mtlx.system.arguments import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import TracebackType
    from typing import Self


# Files that a message names.
_SHOWN = 3


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """An empty file of the same suffix, to write to; it takes the place of `path` if all went well.

    It lies beside `path`, under a name that nobody can have foreseen. Whatever happens before it takes that place, a
    full disk or an interrupt, leaves `path` as it was and nothing beside it. What is not a plain file (a pipe,
    /dev/stdout) gets the finished content.

    Raises
    ------
    OSError
        If the file cannot take the place of `path`.
    """
    if path.exists() and not path.is_file():
        with tempfile.TemporaryDirectory(prefix="mrm-") as folder:
            yield (finished := _create(Path(folder), path.suffix))
            with finished.open("rb") as source, path.open("wb") as device:
                shutil.copyfileobj(source, device)
        return
    target = path.resolve()  # a link keeps leading where it led
    unfinished = _create(target.parent, target.suffix)
    try:
        yield unfinished
        if not unfinished.stat().st_size:
            raise FileNotFoundError(errno.ENOENT, "nothing was written")
        _move(unfinished, target)
    finally:
        unfinished.unlink(missing_ok=True)


def check_folder(path: Path, argument: str = "output") -> None:
    """Raise an ArgumentError if the folder of a file is not there: before the work is done in vain."""
    if not path.parent.is_dir():
        msg = f"{path} cannot be written: the folder {path.parent} does not exist"
        raise ArgumentError(msg, argument)


def write_text(path: Path, text: str, argument: str = "output") -> None:
    """Write a text file whole or not at all; raise an ArgumentError if it cannot be written."""
    try:
        with replacing(path) as unfinished:
            unfinished.write_text(text, encoding="utf-8")
    except OSError as error:
        msg = f"{path} cannot be written: {error.strerror}"
        raise ArgumentError(msg, argument) from error


@dataclass
class FileSet:
    """Files that belong together: all of them are written, or none; as a context.

    The end of the context puts them where they belong, unless it is left by an exception. If one cannot be put there,
    what was there before is put back.

    Attributes
    ----------
    folder
        Where they belong, or below it; there is nothing of them anywhere else before the end.
    force
        Whether `beside` may replace files.
    own
        The files that belong to what is replaced, which `beside` may replace, too; asked for where there is need.
    """

    folder: Path
    force: bool = False
    own: Callable[[], set[Path]] = set
    _scratch: Path = field(init=False)
    _files: dict[Path, tuple[Path, bool]] = field(default_factory=dict, init=False)
    _main: set[Path] = field(default_factory=set, init=False)

    def __enter__(self) -> Self:
        """Itself."""
        self._scratch = Path(tempfile.mkdtemp(prefix=".mrm-", dir=self.folder.resolve()))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Put the files where they belong.

        Raises
        ------
        FileExistsError
            If there is a file already that may not be replaced; it is named.
        OSError
            If it cannot be done.
        """
        try:
            if kind is None:
                self._refuse_conflicts()
                self._put()
        finally:
            for finished, _ in self._files.values():
                finished.unlink(missing_ok=True)
            shutil.rmtree(self._scratch, ignore_errors=True)

    def named(self, path: Path) -> Path:
        """An empty file to write to, for `path`, which the user named: what is there is replaced."""
        target = path.resolve()  # a link keeps leading where it led
        self._main.add(target)
        return self._new(target, replaces=True)

    def beside(self, path: Path) -> Path:
        """The same for a file that nobody named: what is there has to be the same already, or `force` is needed.

        Raises
        ------
        OSError
            If a folder on the way is a link that leads out of `folder`.
        """
        target = path.parent.resolve() / path.name  # a link at the place itself is not followed
        if not target.is_relative_to(self._scratch.parent):
            raise OSError(errno.EXDEV, f"{path.name} would lie elsewhere: a folder on the way is a link")
        return self._new(target, replaces=self.force)

    def copied(self, source: Path, path: Path) -> None:
        """A copy of a file, `beside`."""
        shutil.copyfile(source, self.beside(path))

    def _new(self, path: Path, *, replaces: bool) -> Path:
        if path not in self._files:
            # Where a link led to, there may be another disk.
            folder = self._scratch if path.parent.is_relative_to(self._scratch.parent) else path.parent
            self._files[path] = (_create(folder, path.suffix), replaces)
        return self._files[path][0]

    def _refuse_conflicts(self) -> None:
        found = [
            path
            for path, (finished, replaces) in self._files.items()
            if not replaces and os.path.lexists(path) and not _same(path, finished)
        ]
        own = self.own() if found else set()
        if others := [self._shown(path) for path in found if path not in own]:
            more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
            names = ", ".join(others[:_SHOWN]) + more
            raise FileExistsError(errno.EEXIST, f"already there, with other content: {names}; `force` replaces such")

    def _shown(self, path: Path) -> str:
        return os.path.relpath(path, self._scratch.parent).replace(os.sep, "/")

    def _put(self) -> None:
        """Move the files; each step's undoing is known before the step is done, so that an interrupt loses nothing."""
        with contextlib.ExitStack() as undo:
            # What refers to the others comes last.
            ordered = sorted(self._files.items(), key=lambda item: item[0] in self._main)
            for number, (path, (finished, _)) in enumerate(ordered):
                for parent in reversed([path.parent, *path.parent.parents]):
                    if not parent.exists():
                        undo.callback(_remove_folder, parent)
                        parent.mkdir()
                before = self._scratch / f"before-{number}"
                if os.path.lexists(path):
                    _keep(path, before)
                    undo.callback(shutil.move, before, path)
                else:
                    undo.callback(path.unlink, missing_ok=True)
                _move(finished, path)
            undo.pop_all()


def _create(folder: Path, suffix: str) -> Path:
    """A new empty file with the permissions of any other, under a name that nobody can have foreseen."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0)
    path = folder / f".mrm-{secrets.token_hex(12)}{suffix}"
    os.close(os.open(path, flags, 0o666))
    return path


def _keep(path: Path, before: Path) -> None:
    """A second name of a file, or where that cannot be, a copy: the file itself stays until another replaces it."""
    try:
        os.link(path, before, follow_symlinks=False)
    except (OSError, NotImplementedError):
        shutil.copy2(path, before, follow_symlinks=False)


def _remove_folder(folder: Path) -> None:
    with contextlib.suppress(OSError):  # it was not made, or somebody uses it by now
        folder.rmdir()


def _move(finished: Path, target: Path) -> None:
    """Put a finished file in the place of another, once all of it has reached the disk."""
    with finished.open("r+b") as stream:
        os.fsync(stream.fileno())  # a network's disk, or one with quotas, says only here that it is full
    if target.is_file():
        shutil.copymode(target, finished)
    finished.replace(target)


def _same(path: Path, finished: Path) -> bool:
    return path.is_file() and not path.is_symlink() and filecmp.cmp(path, finished, shallow=False)
