"""Dialects of MaterialX: which version has what, in one table.

Whatever depends on the version of MaterialX asks here, and numbers that do are tables by version
(`mrm_mtlx.reference.versions`) that `entry` is asked for. Versions are compared in this module and nowhere else.

A version is written with two numbers where it is a document's ("1.39"), with three where it is an installation's
("1.39.5"). One of two numbers stands for the newest of them: a document of 1.39 may use whatever 1.39 has got since.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

import MaterialX as mx

from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.text import shown
from mrm_mtlx.system.versions import versions as installed_versions

if TYPE_CHECKING:
    from collections.abc import Mapping

_Entry = TypeVar("_Entry")

# Names the version of the data libraries where they are not those that came with the module.
VARIABLE = "MRM_MATERIALX_VERSION"

_DOCUMENT_VERSION = re.compile(r"\d{1,4}\.\d{1,4}", re.ASCII)
_VERSION = re.compile(r"\d{1,4}(\.\d{1,4}){1,2}", re.ASCII)


@dataclass(frozen=True)
class Dialect:
    """Features of a version of MaterialX, and of the versions after it up to the next entry of `DIALECTS`.

    Attributes
    ----------
    has_retroreflective
        The flag `retroreflective` of the three microfacet nodes.
    closures
        Folder of `libraries/pbrlib/dialects` with the GLSL that calls its microfacet functions; "" for the files of
        `libraries/pbrlib` as they are.
    unserved
        Why the node library does not serve it, "" if it does.
    msl_inherits
        Target `genmsl` takes the microfacet functions of `genglsl`, and has no implementation elements for them.
    has_data_libraries
        Documents refer to a data library, and have no copy of its elements.
    type_registration
        The method by which a shader generator learns the types of a document; "" where it has none.
    least_environment_samples
        Fewest directions to an environment with which generated code gives a number; 0 gives 0 / 0 before 1.39.5.
    walks_every_path
        Validation and generation walk a graph along every path through it, so that those of the portable form, with
        values that many nodes use, take hours.
    """

    has_retroreflective: bool
    closures: str = ""
    unserved: str = ""
    msl_inherits: bool = True
    has_data_libraries: bool = True
    type_registration: str = "registerTypeDefs"
    least_environment_samples: int = 0
    walks_every_path: bool = False


_BEFORE_1_39 = Dialect(
    has_retroreflective=False,
    unserved="it refuses documents of version 1.39, and its microfacet nodes have neither a thin film nor color82",
)
_1_39_0 = Dialect(
    has_retroreflective=False,
    closures="1.39.0",
    msl_inherits=False,
    has_data_libraries=False,
    type_registration="",
    least_environment_samples=1,
    walks_every_path=True,
)
_1_39_2 = replace(
    _1_39_0,
    msl_inherits=True,
    has_data_libraries=True,
    type_registration="loadStructTypeDefs",
    walks_every_path=False,
)
_1_39_3 = replace(_1_39_2, closures="1.39.3", type_registration="registerTypeDefs")

DIALECTS = {
    "0.0": _BEFORE_1_39,
    "1.39.0": _1_39_0,
    "1.39.2": _1_39_2,
    "1.39.3": _1_39_3,
    "1.39.5": Dialect(has_retroreflective=True),
}


def materialx_version() -> str:
    """Version of the installed MaterialX, such as "1.39.5", or that of its data libraries, if `VARIABLE` states one.

    Raises
    ------
    ArgumentError
        If the variable has what is no version, or the node library does not serve the version.
    """
    stated = os.environ.get(VARIABLE, "")
    if stated and _VERSION.fullmatch(stated) is None:
        msg = f"the environment variable {VARIABLE} is {shown(stated)}, which is no version, such as 1.39.6"
        raise ArgumentError(msg)
    version = stated or str(mx.getVersionString())
    if reason := dialect(version).unserved:
        msg = f"MaterialX {version} is not served: {reason}"
        raise ArgumentError(msg)
    return version


def versions() -> dict[str, str]:
    """Versions of what a verdict depends on, as `system.versions.versions`; of MaterialX as `materialx_version`."""
    return installed_versions() | {"materialx": materialx_version()}


def installed() -> Dialect:
    """The dialect of `materialx_version`."""
    return dialect(materialx_version())


def module() -> Dialect:
    """The dialect of the module MaterialX, whichever its data libraries are: what its classes have."""
    return dialect(str(mx.getVersionString()))


def dialect(version: str) -> Dialect:
    """The dialect of a version of MaterialX.

    Raises
    ------
    ValueError
        If it is no version.

    Examples
    --------
    >>> dialect("1.39.4").has_retroreflective, dialect("1.39").has_retroreflective
    (False, True)
    """
    return entry(DIALECTS, version)


def entry(table: Mapping[str, _Entry], version: str) -> _Entry:
    """The entry for a version of MaterialX in a table by version: the newest that is no newer than it.

    Raises
    ------
    LookupError
        If the version is older than every entry.
    """
    wanted = _numbers(version)
    known = [name for name in table if _numbers(name)[: len(wanted)] <= wanted]
    if not known:
        msg = f"MaterialX {version} is older than {min(table, key=_numbers)}, the first version that is known here"
        raise LookupError(msg)
    return table[max(known, key=_numbers)]


def document_version() -> str:
    """The newest version of documents that the installed MaterialX reads, such as "1.39"."""
    return ".".join(materialx_version().split(".")[:2])


def version_of(document: Any) -> str:
    """The version of MaterialX that a document is of, such as "1.39"; the installed one's if it states none."""
    return ".".join(map(str, document.getVersionIntegers()))


def is_document_version(text: str) -> bool:
    """True for a text that is a version as documents state it."""
    return _DOCUMENT_VERSION.fullmatch(text) is not None


def is_upgraded(version: str) -> bool:
    """True if the installed MaterialX upgrades documents of this version; False for a text that is no version."""
    return is_document_version(version) and _numbers(version) < _numbers(document_version())


def lacks_retroreflective(version: str) -> bool:
    """True if documents of this version have no retroreflective flag; False for what is no version."""
    return is_document_version(version) and not dialect(version).has_retroreflective


def _numbers(version: str) -> tuple[int, ...]:
    if _VERSION.fullmatch(version) is None:
        msg = f"{shown(version)} is no version of MaterialX, such as 1.39.3"
        raise ValueError(msg)
    return tuple(map(int, version.split(".")))
