"""Files: where a name of a document leads, and reading what is regular."""

from __future__ import annotations

import os
import re
import stat
from dataclasses import dataclass, replace
from pathlib import Path

# What stands for a part of a name that is known only where the file is read: a tile, a frame, a property of geometry or
# of the host (MaterialX specification 1.39, section "Filename Substitutions"); and what it may be. Tokens of
# interfaces, "[name]", have been replaced in a name that is resolved.
_TOKEN = re.compile(r"<\w+>|\{\w+\}")
_TILES = {"<UDIM>": "[0-9]{4}", "<UVTILE>": "u[0-9]+_v[0-9]+"}
_FRAME = re.compile(r"\{(0\d+)?frame\}")

# What begins with a drive is absolute for MaterialX, on every system.
_DRIVE = re.compile("[A-Za-z]:")


@dataclass(frozen=True)
class Reach:
    """The folders to which the names of files in a document may lead; plain data that crosses processes.

    Attributes
    ----------
    folder
        What relative names are relative to.
    root
        Folder that is being checked. Nothing outside of it, and of those in `search`, is opened.
    search
        Folders in which a relative name is looked for, in order, that is not found in `folder`.
    """

    folder: Path
    root: Path
    search: tuple[Path, ...] = ()

    @classmethod
    def only(cls, folder: Path) -> Reach:
        """The reach of names that are relative to a folder, and lead nowhere else."""
        return cls(folder, folder)

    @classmethod
    def beside(cls, path: Path, search: tuple[Path, ...] = ()) -> Reach:
        """The reach of a document that is checked by itself: what lies in its folder."""
        return cls(path.parent, path.parent, search)

    def at(self, folder: Path) -> Reach:
        """The same for names that are relative to another folder, as those of an included file are."""
        return replace(self, folder=folder)

    def locate(self, name: str) -> Path:
        """The path to which a name leads, links not followed.

        The name is read as MaterialX reads it: both separators count, and the first folder that has the file wins. A
        file that is nowhere would lie in `folder`.
        """
        return self.find(name) or self.folder.absolute() / _plain(name)

    def find(self, name: str) -> Path | None:
        """The same; None for a file that is nowhere. Of a set, the folder wins that has any of its files."""
        places = [folder.absolute() / _plain(name) for folder in (self.folder, *self.search)]
        return next((place for place in places if _exists(place)), None) or (
            next((place for place in places if self._tiles(place)), None) if _TOKEN.search(name) else None
        )

    def inside(self, path: Path) -> Path | None:
        """A path, relative to `folder`, with links followed; None if it lies outside or nowhere."""
        try:
            target = (self.folder / path).resolve()
            target.exists()  # raises OSError of a name that is too long, as whatever asks for the file later would
        except (OSError, RuntimeError, ValueError):  # a link that leads to itself, a name with a zero byte
            return None
        return target if self._root_of(target) else None

    def resolve(self, name: str) -> Path | None:
        """The file that a name means, links followed; None if it lies outside or nowhere."""
        return self.inside(self.locate(name))

    def regular(self, name: str) -> Path | None:
        """The same, of a set its first file; None for what is not regular: a pipe or a device would never end."""
        members = [] if is_left_open(name) else self.members(name)
        target = self.inside(members[0]) if members else None
        return target if target is not None and target.is_file() else None

    def members(self, name: str) -> list[Path]:
        """The files that a name means, as they lie: of a set, with "<UDIM>" or the like in its name, those there are.

        None of one outside. Members of a set may be links that lead outside; `inside` tells.
        """
        place = self.locate(name)
        if self.inside(place) is None:
            return []
        return [place] if _exists(place) else self._tiles(place)

    def _tiles(self, place: Path) -> list[Path]:
        """Files of the set that a path with tokens names. Only folders inside are looked into."""
        found = [Path(place.anchor)]
        for part in place.relative_to(place.anchor).parts:
            if not _TOKEN.search(part):
                found = [path / part for path in found]
                continue
            form = re.compile(_form(part))
            found = [
                entry for path in found if self.inside(path) for entry in _entries(path) if form.fullmatch(entry.name)
            ]
        return [path for path in found if path != place and _exists(path)]

    def within(self, target: Path) -> Path:
        """The path of a file that was resolved, as seen from the folder that holds it.

        Raises
        ------
        ValueError
            If it lies outside.
        """
        root = self._root_of(target)
        if root is None:
            msg = f"{target.name} lies outside"
            raise ValueError(msg)
        return target.relative_to(root)

    def shown(self, path: Path) -> str:
        """A path as reports show it, see `shown_path`: of a file that lies elsewhere, from the folder that holds it."""
        absolute = Path.cwd() / path
        roots = (Path.cwd() / root for root in (self.root, *self.search))
        return shown_path(absolute, next((root for root in roots if absolute.is_relative_to(root)), None))

    def _root_of(self, target: Path) -> Path | None:
        roots = (root.resolve() for root in (self.root, *self.search))
        return next((root for root in roots if target.is_relative_to(root)), None)


def _plain(name: str) -> str:
    """A name as MaterialX reads it, with "/" between its parts."""
    is_absolute = name.startswith(("/", "\\\\")) or (os.name != "nt" and _DRIVE.match(name))
    return ("/" if is_absolute else "") + "/".join(part for part in re.split(r"[/\\]", name) if part)


def names_nothing(name: str) -> bool:
    """True if a name is empty, or that of a folder, as a prefix is to which no name was added."""
    return not name or name.endswith(("/", "\\"))


def names_tiles(name: str) -> bool:
    """True if a name is that of a set of tiles or frames, of which there has to be one at least."""
    return bool(_FRAME.search(name)) or any(token in name for token in _TILES)


def is_left_open(name: str) -> bool:
    """True if a name means what only geometry or a host knows: nothing need be there."""
    return bool(_TOKEN.search(name)) and not names_tiles(name)


def _form(part: str) -> str:
    """A regular expression of what a part of a path with tokens may be."""
    form, end = "", 0
    for token in _TOKEN.finditer(part):
        form += re.escape(part[end : token.start()])
        form += "-?[0-9]+" if _FRAME.fullmatch(token[0]) else _TILES.get(token[0], ".*")
        end = token.end()
    return form + re.escape(part[end:])


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def read_regular(path: Path, most: int) -> bytes | None:
    """Content of a file, `most` bytes at most; None if it is not regular: a pipe or a device would never end.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    if not path.is_file():
        return None
    # Should it be another file by now: what is asked for its kind is what is read, and a pipe is not waited for.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            return None
        with os.fdopen(descriptor, "rb", closefd=False) as stream:
            return stream.read(most)
    finally:
        os.close(descriptor)


def shown_path(path: Path, folder: Path | None = None) -> str:
    """A path as reports show it: never absolute.

    Relative to the current folder; of one that lies elsewhere, the part from the `folder` on in which it was found, or
    its last two parts.
    """
    absolute = Path.cwd() / path
    if absolute.is_relative_to(Path.cwd()):
        name = absolute.relative_to(Path.cwd()).as_posix()
    elif folder is not None:
        name = (Path((Path.cwd() / folder).name) / path.relative_to(folder)).as_posix()
    else:
        name = Path(*absolute.parts[-2:]).as_posix().lstrip("/")
    # Names of files are bytes on some systems; reports are text.
    return name.encode("utf-8", "backslashreplace").decode("utf-8")
