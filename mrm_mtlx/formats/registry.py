"""The formats that there are: those of this package, and those that other packages register.

The one place that names them. A format of another package is an entry point of the group `mrm_mtlx.formats` whose value
is a `format.Format`:

    [project.entry-points."mrm_mtlx.formats"]
    sbsar = "my_package:SBSAR"
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from mrm_mtlx.documents.files import read_regular
from mrm_mtlx.formats.format import Capability, Format
from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.plugins import PluginError, registered

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.formats.options import Option, Options

GROUP = "mrm_mtlx.formats"

# MaterialX's own; what a file without a known ending is taken for.
MATERIALX = Format("materialx", "MaterialX", (".mtlx",), "mrm_mtlx.formats.materialx", holds_networks=True)

_OWN = (
    MATERIALX,
    Format(
        "usd",
        "USD",
        (".usda", ".usdc", ".usd", ".usdz"),
        "mrm_mtlx.formats.usd",
        options="mrm_mtlx.formats.usd.options:UsdOptions",
        holds_networks=True,
    ),
    Format(
        "gltf",
        "glTF",
        (".gltf", ".glb"),
        "mrm_mtlx.formats.gltf",
        options="mrm_mtlx.formats.gltf.options:GltfOptions",
    ),
    Format(
        "openmaterial",
        "OpenMATERIAL",
        (".json",),
        "mrm_mtlx.formats.openmaterial.translation",
        frozenset((Capability.WRITE, Capability.COMPARE, Capability.COEFFICIENTS)),
        ambiguous=True,
        options="mrm_mtlx.formats.openmaterial.options:OpenMaterialOptions",
    ),
)

# Bytes by which a format recognises its files.
_START = 1 << 16


@cache
def formats() -> tuple[Format, ...]:
    """All formats: first those of this package, then those of others, by the names of their entry points.

    Raises
    ------
    PluginError
        If one does not load, or has the name or an ending of another.
    """
    found = list(_OWN)
    for other in registered(GROUP, Format):
        for known in found:
            both = [suffix for suffix in other.suffixes if suffix in known.suffixes]
            if other.name == known.name or (both and not (other.ambiguous and known.ambiguous)):
                what = f"the ending {both[0]}" if both else f"the name {known.name}"
                msg = f"two formats have {what}: {known.module} and {other.module}; remove the package of the latter"
                raise PluginError(msg)
        found.append(other)
    return tuple(found)


def formats_that(capability: Capability) -> list[Format]:
    """The formats with a capability."""
    return [known for known in formats() if known.can(capability)]


def format_of(path: Path) -> Format | None:
    """The format of a file that is there: by its ending, and by its content where other files have that ending, too.

    None if that is none that is known.
    """
    having = _having(path)
    if not any(known.ambiguous for known in having):
        return having[0] if having else None
    start = _start(path)
    # Those of other packages are asked first: what tells our own is little.
    return next((known for known in reversed(having) if known.recognises(start)), None)


def format_for(path: Path) -> Format | None:
    """The format of a file that is to be written, by its ending; None for one that is not known."""
    return next((known for known in _having(path) if known.can(Capability.WRITE)), None)


def suffixes(capability: Capability, *, of_folders: bool = False) -> tuple[str, ...]:
    """Endings of the files with which something can be done; of those for which folders are searched."""
    having = (known for known in formats_that(capability) if not (of_folders and known.ambiguous))
    return tuple(suffix for known in having for suffix in known.suffixes)


def declared_options() -> dict[str, tuple[Any, Option]]:
    """The type and the words of each option that formats have, by name; of several formats, those of the first."""
    found: dict[str, tuple[Any, Option]] = {}
    for known in reversed(formats()):
        found |= known.options_class.declared()
    return found


def options_for(owner: Format, given: Mapping[str, Any]) -> Options:
    """The options of a format, of those that are given by name; None is not given.

    Raises
    ------
    ArgumentError
        If it has no such option, with the formats that have; or if it refuses a value.
    """
    given = {name: value for name, value in given.items() if value is not None}
    own = owner.options_class.declared()
    for name in given:
        if name not in own:
            having = [known for known in formats() if name in known.options_class.names()]
            of = "; ".join(f"{', '.join(known.suffixes)}, {known.title}" for known in having)
            raise ArgumentError(f"only for {of}" if of else "there is no such option", name)
    paths = {name: Path(value) for name, value in given.items() if Path in get_args(own[name][0])}
    return owner.options_class(**{**given, **paths})


def _having(path: Path) -> list[Format]:
    """The formats that have the ending of a file."""
    return [known for known in formats() if path.suffix.lower() in known.suffixes]


def _start(path: Path) -> bytes:
    try:
        return read_regular(path, _START) or b""
    except OSError:
        return b""
