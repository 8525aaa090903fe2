"""Hosts of MaterialX by name: the version that each has, and how it finds the node library.

A host is a program that has a MaterialX of its own. What is different between two of them is a field of `Host`; nothing
asks for a name. A MaterialX whose version is another than the table's is served as well, with the version given.
"""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from enum import StrEnum


class Evidence(StrEnum):
    """How the table knows of a host: it was run here, its source or release notes were read, or neither."""

    SEEN = "seen"
    READ = "read"
    ASSUMED = "assumed"


class Form(StrEnum):
    """The form of the node library.

    `sources`: definitions, implemented in source code of shaders. `portable`: definitions that graphs of standard
    nodes implement, for hosts that take no source.
    """

    SOURCES = "sources"
    PORTABLE = "portable"


class Choice(StrEnum):
    """How a host finds the definition of a surface model with our input.

    `inputs`: by the inputs that the node of a document has, as MaterialX does. `name`: by the name of the definition,
    and below that by the category that the definition has; Hydra drops the inputs before MaterialX chooses, and would
    take one definition of a category for all documents.
    """

    INPUTS = "inputs"
    NAME = "name"


PLUGIN_VARIABLE, STANDARD_VARIABLE = "PXR_MTLX_PLUGIN_SEARCH_PATHS", "PXR_MTLX_STDLIB_SEARCH_PATHS"


@dataclass(frozen=True)
class Host:
    """A program with a MaterialX of its own.

    Attributes
    ----------
    name
        By which it is asked for.
    title
        What people call it.
    materialx
        Version of its MaterialX; "" for that which is installed here.
    evidence
        How that is known, and what else is said of it.
    variable
        Of the environment: names the folder that holds the library; "" if the host is told in another way.
    with_standard
        Whether that variable has to name the standard library as well, behind ours.
    form
        Of the library.
    choice
        How the definition of a surface model is chosen.
    module
        Python module that brings the host, if one does.
    places
        Where it is commonly installed: folders, with `~` and wildcards.
    remark
        What else its user has to know.
    """

    name: str
    title: str
    materialx: str
    evidence: Evidence
    variable: str = ""
    with_standard: bool = False
    form: Form = Form.SOURCES
    choice: Choice = Choice.NAME
    module: str = ""
    places: tuple[str, ...] = ()
    remark: str = ""

    def chosen(self, version: str) -> str:
        """The options that choose it with a MaterialX of a version."""
        return f"--host {self.name}" + (f" --for {version}" if version != self.materialx and self.variable else "")


def _blender(version: str, materialx: str) -> Host:
    return Host(
        name=f"blender-{version}",
        title=f"Blender {version}, Hydra Storm",
        materialx=materialx,
        evidence=Evidence.SEEN,
        variable=PLUGIN_VARIABLE,
        module="bpy",
        places=(
            "/Applications/Blender.app/Contents/Resources",
            f"C:/Program Files/Blender Foundation/Blender {version}",
            f"/opt/blender-{version}*",
            f"~/blender-{version}*",
        ),
        remark="Start Blender from this shell; the extension of this project needs no variable.",
    )


_USD = ("/usr/local/USD", "/opt/USD", "~/USD", "C:/USD")

_HOSTS = (
    Host(
        name="plain",
        title="any program over MaterialX",
        materialx="",
        evidence=Evidence.SEEN,
        choice=Choice.INPUTS,
    ),
    _blender("4.5", "1.39.2"),
    _blender("5.0", "1.39.3"),
    _blender("5.1", "1.39.4"),
    _blender("5.3", "1.39.4"),
    Host(
        name="usd-25.08",
        title="OpenUSD 25.08, usdview",
        materialx="1.39.3",
        evidence=Evidence.SEEN,
        variable=PLUGIN_VARIABLE,
        places=_USD,
    ),
    Host(
        name="usd-26.08",
        title="OpenUSD 26.08, usdview",
        materialx="1.39.5",
        evidence=Evidence.SEEN,
        variable=PLUGIN_VARIABLE,
        places=_USD,
    ),
    Host(
        name="usd-exchange",
        title="usd-exchange 3, a Python package of OpenUSD 26.08",
        materialx="1.39.5",
        evidence=Evidence.SEEN,
        variable=STANDARD_VARIABLE,
        with_standard=True,
        remark="The package has no pbrlib of MaterialX: the second folder is a whole standard library.",
    ),
    Host(
        name="maya-2027",
        title="Maya 2027, viewport 2.0 over USD",
        materialx="1.39.4",
        evidence=Evidence.READ,
        variable=PLUGIN_VARIABLE,
        places=(
            "/usr/autodesk/mayausd/maya2027",
            "/Applications/Autodesk/mayausd/maya2027",
            "C:/Program Files/Autodesk/MayaUSD/Maya2027",
        ),
        remark="Arnold in Maya reads another variable: `--host arnold`.",
    ),
    Host(
        name="arnold",
        title="Arnold, over USD",
        materialx="1.39.4",
        evidence=Evidence.ASSUMED,
        variable=STANDARD_VARIABLE,
        remark="Which MaterialX an Arnold has is not known here; `--for` names another. Booleans come from 7.5.3 on.",
    ),
    Host(
        name="houdini",
        title="Houdini, Karma",
        materialx="1.39.3",
        evidence=Evidence.ASSUMED,
        variable=PLUGIN_VARIABLE,
        form=Form.PORTABLE,
        places=("/opt/hfs21*", "/opt/hfs22*", "C:/Program Files/Side Effects Software/Houdini 2*"),
        remark="Which MaterialX a Houdini has is not known here; `--for` names another.",
    ),
    Host(
        name="quiltix",
        title="QuiltiX 0.8",
        materialx="1.39.2",
        evidence=Evidence.READ,
        variable=PLUGIN_VARIABLE,
    ),
)

HOSTS = {host.name: host for host in _HOSTS}

PLAIN = HOSTS["plain"]


def host_called(name: str) -> Host:
    """The host of a name.

    Raises
    ------
    LookupError
        If there is none; the message names the nearest, and all.
    """
    if name not in HOSTS:
        near = get_close_matches(name.lower(), HOSTS, 1)
        guess = f"; did you mean {near[0]}?" if near else "."
        msg = f"no host is called '{name}'{guess} Known: {', '.join(HOSTS)}"
        raise LookupError(msg)
    return HOSTS[name]
