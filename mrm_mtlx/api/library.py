"""The node library in a folder for other MaterialX hosts, and the folders of the ready materials."""

from __future__ import annotations

import os
import shlex
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mrm_mtlx.system.arguments import ArgumentError, path_of
from mrm_mtlx.system.shown import Shown

if TYPE_CHECKING:
    from mrm_mtlx.api.opening import PathLike
    from mrm_mtlx.library.hosts import Host
    from mrm_mtlx.library.standard_library import StandardLibrary


@dataclass(frozen=True, repr=False)
class InstalledLibrary(Shown):
    """The node library in a folder.

    Attributes
    ----------
    folder
        What the host has to be told.
    files
        What was written.
    left_out
        Why a surface model of MaterialX is not extended, by its node.
    host
        Whom it is for.
    version
        Of the host's MaterialX.
    models_from
        Where the standard library is from that the surface models were made of, in words.
    variable
        Of the environment, which the host finds the folder by; "" for a host that is told in another way.
    value
        Of that variable.
    """

    folder: Path
    files: tuple[Path, ...]
    left_out: dict[str, str]
    host: str
    version: str
    models_from: str
    variable: str
    value: str

    def report(self) -> str:
        """The files, a line each."""
        return "\n".join(map(str, self.files))

    def notes(self) -> list[str]:
        """Lines on what it is for, on the models that are left out, and on what to set."""
        from mrm_mtlx.library.hosts import HOSTS
        from mrm_mtlx.library.install import FOLDER
        from mrm_mtlx.system.shells import assignments

        host = HOSTS[self.host]
        lines = [f"For {host.title}, MaterialX {self.version}; surface models made from {self.models_from}."]
        lines += [f"{node} is left out: {reason}" for node, reason in self.left_out.items()]
        if not self.variable:
            return [
                *lines,
                f"Search path '{self.folder}'. Load the folder '{FOLDER}' before the standard library; "
                f"for example generateshader --path {shlex.quote(str(self.folder))} --library {FOLDER} ...",
            ]
        lines.append(f"Set one variable before the host starts, {self.variable}:")
        lines += [f"  {shell:<10} {line}" for shell, line in assignments(self.variable, self.value).items()]
        lines += [host.remark] if host.remark else []
        return [*lines, f"Then: mrm doctor {host.chosen(self.version)}"]


def install_library(
    folder: PathLike,
    *,
    host: str = "plain",
    materialx: str | None = None,
    stdlib: PathLike | None = None,
    form: str | None = None,
) -> InstalledLibrary:
    """Write the node library to folder/mrm as a host wants it, with the surface models of the host's MaterialX.

    Nothing is written if all of it cannot be. What was written for another host before is replaced.

    Parameters
    ----------
    folder
        Made if it is missing.
    host
        Name of a host, such as "blender-5.0"; "plain" is any program over the MaterialX that is installed here.
    materialx
        Version of the host's MaterialX, such as "1.39.3", where it is not the one that is known of the host. For
        "plain" it is by default that of `stdlib`, or the one that is installed here.
    stdlib
        Folder of the host, or of its standard library, of which the surface models are made. Default: where the host is
        commonly installed, the MaterialX that is installed here, another host's, or a wheel that is fetched, whichever
        has the version.
    form
        "sources" or "portable"; by default the one that the host takes.

    Raises
    ------
    ArgumentError
        If a host, a version or a form is not known, the folder cannot be written, or there is no standard library of
        the version.
    """
    from mrm_mtlx.library.hosts import Form
    from mrm_mtlx.library.install import library_for, write_library
    from mrm_mtlx.library.standard_library import StandardLibraryError
    from mrm_mtlx.system.arguments import check_choice

    destination = path_of("folder", folder).expanduser()
    chosen = known_host(host)
    check_choice("form", form, [each.value for each in Form])
    version = _version(chosen, materialx, stdlib)
    with tempfile.TemporaryDirectory(prefix="mrm-") as scratch:
        try:
            standard = _standard_library(chosen, version, stdlib, Path(scratch))
            library = library_for(standard, Form(form) if form else chosen.form, chosen.choice)
        except StandardLibraryError as error:
            raise ArgumentError(str(error), "stdlib" if stdlib else "") from error
        except LookupError as error:
            raise ArgumentError(str(error.args[0]), "form") from error
        value = _value(chosen, destination, standard, kept=not standard.folder.is_relative_to(scratch))
        try:
            files = write_library(destination, library.files)
        except OSError as error:
            msg = f"{folder} cannot be written: {error.strerror or error}"
            raise ArgumentError(msg, "folder") from error
    return InstalledLibrary(
        folder=destination,
        files=tuple(files),
        left_out={x.model.node: x.reason for x in library.extensions if x.reason},
        host=chosen.name,
        version=version,
        models_from=standard.origin,
        variable=chosen.variable,
        value=value,
    )


def known_host(name: str) -> Host:
    """The host of a name; an ArgumentError for another name."""
    from mrm_mtlx.library.hosts import host_called

    try:
        return host_called(name)
    except LookupError as error:
        raise ArgumentError(str(error.args[0]), "host") from error


def served_version(host: Host, stated: str | None) -> str:
    """The version of a host's MaterialX, or the one that is stated; an ArgumentError for one that is not served."""
    from mrm_mtlx.library.assembly import served
    from mrm_mtlx.library.dialects import materialx_version
    from mrm_mtlx.library.standard_library import FIRST_DEFINED

    version = stated or host.materialx or materialx_version()
    try:
        served(version)
    except (LookupError, ValueError) as error:
        raise ArgumentError(str(error.args[0]), "materialx") from error
    if version not in FIRST_DEFINED:
        msg = f"MaterialX {version} is not known here: expected one of {', '.join(reversed(FIRST_DEFINED))}"
        raise ArgumentError(msg, "materialx")
    return version


def _version(host: Host, stated: str | None, stdlib: PathLike | None) -> str:
    """As `served_version`; for a host of no version, that of the standard library which is given."""
    from mrm_mtlx.library.standard_library import StandardLibraryError, find, version_of_folder

    if not (stated or host.materialx) and stdlib is not None:
        folder = find(path_of("stdlib", stdlib).expanduser())
        try:
            stated = version_of_folder(folder) if folder else None
        except StandardLibraryError as error:
            raise ArgumentError(str(error), "stdlib") from error
    return served_version(host, stated)


def _standard_library(host: Host, version: str, stdlib: PathLike | None, scratch: Path) -> StandardLibrary:
    from mrm_mtlx.library import standard_library, wheel
    from mrm_mtlx.library.hosts import HOSTS

    if stdlib is not None:
        return standard_library.given(path_of("stdlib", stdlib).expanduser(), version)
    found = standard_library.of_hosts([host], version) or standard_library.installed(version)
    # The data of a version are the same wherever they lie.
    found = found or standard_library.of_hosts((each for each in HOSTS.values() if each != host), version)
    return found or wheel.fetched(version, scratch)


def _value(host: Host, folder: Path, standard: StandardLibrary, *, kept: bool) -> str:
    """The value of the host's variable, "" if it has none; an ArgumentError if it needs a folder that is not kept."""
    if host.with_standard and not kept:
        msg = f"{host.name} needs a standard library that stays: name its folder with `stdlib`"
        raise ArgumentError(msg, "host")
    folders = [folder, *([standard.folder] if host.with_standard else [])]
    return os.pathsep.join(str(each.resolve()) for each in folders) if host.variable else ""
