"""Files that a stage names, such as textures, under the names that they have in a document."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

from pxr import Ar, Sdf

from mrm_mtlx.interchange.imported import Remark, UnreadableError
from mrm_mtlx.interchange.usd.opening import SUFFIXES, folder_of
from mrm_mtlx.library.files import Reach

if TYPE_CHECKING:
    from pxr import Usd

# Of all files in a package together, unpacked; and their number.
MAXIMUM_BYTES = 256 * 2**20
MAXIMUM_FILES = 4096


class Assets:
    """The files of one stage: names are relative to its folder, or for a package to `scratch`, where it is unpacked.

    `seen` are the absolute paths of those that were asked for.

    Raises
    ------
    UnreadableError
        If a package cannot be unpacked within the bounds.
    """

    def __init__(self, path: Path, reach: Reach, scratch: Path) -> None:
        self.packed = path.suffix.lower() == ".usdz"
        self.reach = Reach.only(scratch) if self.packed else reach.at(path.resolve().parent)
        self.remarks: list[Remark] = []
        self.seen: set[str] = set()
        if self.packed:
            _unpack(path, scratch)

    def name(self, attribute: Usd.Attribute) -> str:
        """Name of the file that an attribute means, "" for none."""
        value = attribute.Get(attribute.GetTimeSamples()[0]) if attribute.GetNumTimeSamples() else attribute.Get()
        if not isinstance(value, Sdf.AssetPath) or not value.path:
            return ""
        absolute = _absolute(attribute, value.path)
        self.seen.add(absolute)
        outer, inner = Ar.SplitPackageRelativePathOuter(absolute)
        if self.packed:
            return str(inner or value.path)
        if inner:
            message = f"the image '{inner}' lies inside {Path(outer).name}, from which it is not read; unpack it"
            self.remarks.append(Remark("INTERCHANGE_LOST", str(attribute.GetPath()), message))
            return ""
        return os.path.relpath(outer, self.reach.folder).replace(os.sep, "/")


def _absolute(attribute: Usd.Attribute, name: str) -> str:
    """The path that a name means in the layer that gives the attribute its value."""
    for spec in attribute.GetPropertyStack():
        if spec.HasInfo("default") or spec.HasInfo("timeSamples"):
            found = str(spec.layer.ComputeAbsolutePath(name))
            return found if Path(found).is_absolute() else str(folder_of(spec.layer) / found)
    return name


def _unpack(path: Path, folder: Path) -> None:
    """Take everything but layers out of a package."""
    try:
        with zipfile.ZipFile(path) as package:
            entries = [e for e in package.infolist() if not e.is_dir() and not e.filename.lower().endswith(SUFFIXES)]
            size = sum(entry.file_size for entry in entries)
            if size > MAXIMUM_BYTES or len(entries) > MAXIMUM_FILES:
                found = f"{len(entries)} files of {size / 2**20:.0f} MiB"
                bounds = f"{MAXIMUM_FILES} files and {MAXIMUM_BYTES // 2**20} MiB are read"
                raise UnreadableError(Remark("READ_TOO_LARGE", "", f"the package holds {found}; {bounds}"))
            for entry in entries:
                target = Reach.only(folder).inside(Path(entry.filename))
                if target is not None:
                    target.parent.mkdir(parents=True, exist_ok=True)
                    with package.open(entry) as stream:
                        target.write_bytes(stream.read(entry.file_size))
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        reason = error.strerror if isinstance(error, OSError) else error  # whose text names a folder of this machine
        raise UnreadableError(Remark("READ_FORMAT", "", f"the package cannot be unpacked: {reason}")) from error
