"""Shader source of a document for a target."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.api.opening import LibraryName, OpenDocument, PathLike, open_document
from mrm_mtlx.system.arguments import ArgumentError, check_choice, one_or_more, refuse
from mrm_mtlx.system.shown import Shown
from mrm_mtlx.system.text import plural

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.shadergen import Shader

# How OSL makes a retroreflective lobe; the names of shadergen.OslMode.
OslModeName: TypeAlias = Literal["aligned", "cycles", "keyword"]


@dataclass(frozen=True, repr=False)
class GeneratedSource(Shown):
    """Shader source of a document's surfaces; as text, the source itself.

    Attributes
    ----------
    target
        The shading language.
    shaders
        By surface, its source per stage, its uniforms and inputs.
    files
        The source of each surface and stage, by the name of a file for it.
    findings
        What is to be said of the document.
    """

    target: str
    shaders: Mapping[str, Shader]
    files: Mapping[str, str]
    findings: tuple[Finding, ...]

    def report(self) -> str:
        """The source of all surfaces and stages."""
        return "\n".join(self.files.values())

    def __repr__(self) -> str:
        lines = [f"{name:<60}{source.count(chr(10)) + 1:>7} lines" for name, source in self.files.items()]
        return "\n".join([f"{self.target} source of {plural(len(self.shaders), 'surface')}", *lines])

    def save(self, folder: PathLike) -> list[Path]:
        """Write a file per surface and stage into a folder, which is made, all or none; the files.

        Raises
        ------
        ArgumentError
            If they cannot be written.
        """
        return _write(self.files, Path(folder), "folder")


def generate(
    path: PathLike | OpenDocument,
    *,
    target: str = "glsl",
    element: str | None = None,
    output: PathLike | None = None,
    osl_mode: OslModeName | None = None,
    self_contained: bool = False,
    script_node: bool = False,
    stated_precision: bool = False,
    library: LibraryName = "mrm",
    root: PathLike | Sequence[PathLike] = (),
    listener: Listener = SILENT,
) -> GeneratedSource:
    """Generate the source of a document's surfaces.

    Parameters
    ----------
    path
        A document.
    target
        The shading language.
    element
        Only this renderable element.
    output
        A folder to write one file per stage into, if any.
    osl_mode
        How OSL makes a retroreflective lobe, with that target; see docs/osl.md. Default: aligned.
    self_contained
        OSL with MaterialX's headers in it, for hosts that have none of them.
    script_node
        Self-contained OSL for Blender's Script node, whose sockets are the inputs that the document sets.
    stated_precision
        ESSL keeps mediump floats where MaterialX (before 1.39.5) states them; otherwise they are highp. A finding says
        so in either case.
    library
        Whose implementation of the flag: this project's or MaterialX's ("upstream").
    root
        Folders from which files may be read besides the document's own.
    listener
        Told of findings and files.

    Raises
    ------
    ArgumentError
        If the call is wrong.
    DocumentError
        If the document cannot be used; ShaderError if MaterialX refuses a surface.
    """
    from mrm_mtlx.findings import rules
    from mrm_mtlx.shadergen import GenerationError, OslMode, closure_targets, suffixes_of
    from mrm_mtlx.shadergen import generate as generate_shader

    check_targets([target], library)
    check_choice("osl_mode", osl_mode, tuple(OslMode))
    if target not in closure_targets():
        forms = {"osl_mode": osl_mode, "self_contained": self_contained, "script_node": script_node}
        refuse(forms, f"only with `target` {' or '.join(closure_targets())}")
    if target != "essl":
        refuse({"stated_precision": stated_precision}, "only with `target` essl")
    opened = open_document(path, element=element, library=library, root=root, listener=listener)
    mode = OslMode(osl_mode or "aligned")
    shaders: dict[str, Shader] = {}
    findings: list[Finding] = []
    for name in opened.elements:
        try:
            shader = generate_shader(opened.element(name), target, opened.library, mode)
            shader = _in_form(opened.element(name), shader, self_contained, script_node)
        except GenerationError as error:
            raise opened.shader_error(rules.SHADER_GENERATE, name, error) from error
        shaders[name], found = _mended(shader, stated=stated_precision)
        findings += [opened.source.in_source(rules.UPSTREAM_DEVIATION.at(f"/{name}", message)) for message in found]
    listener.findings(findings)
    files = {
        f"{name.replace('/', '_')}{suffix}": shader.sources[stage]
        for name, shader in shaders.items()
        for stage, suffix in suffixes_of(target).items()
    }
    if output is not None:
        for file in _write(files, Path(output), "output"):
            listener.wrote(file)
    return GeneratedSource(target, shaders, files, (*opened.findings, *findings))


def _mended(shader: Shader, *, stated: bool) -> tuple[Shader, list[str]]:
    """The shader with its floats highp, or as stated, and in a form that compiles; and what is to be said of it."""
    from mrm_mtlx.library import materialx_version
    from mrm_mtlx.shadergen.precision import states_mediump, with_highp
    from mrm_mtlx.shadergen.undeclared_block import names_undeclared_block, with_members_alone

    if names_undeclared_block(shader):
        names = f"vulkan: MaterialX {materialx_version()} names a block that it does not declare (undeclared-block)"
        return with_members_alone(shader), [f"{names}; here its members are named alone, or nothing would compile"]
    if not states_mediump(shader):
        return shader, []
    states = f"essl: MaterialX {materialx_version()} states mediump of floats (mediump-floats)"
    if stated:
        return shader, [f"{states}, in which a driver may have 16 bits: no narrow lobe is left of them"]
    return with_highp(shader), [f"{states}; here they are highp, where a host that generates has mediump"]


def check_targets(
    names: str | Sequence[str],
    library: LibraryName = "mrm",
    allowed: Sequence[str] | None = None,
    default: Sequence[str] | None = None,
) -> tuple[str, ...]:
    """The targets asked for, each once, or those of the default.

    Parameters
    ----------
    names
        None for the default.
    library
        Whose implementation of the flag. Hosts that generate their shaders themselves have this project's.
    allowed, default
        By default, all that there are, and those that the installed MaterialX generates.

    Raises
    ------
    ArgumentError
        If one is not among the allowed.
    """
    from mrm_mtlx.library import materialx_version
    from mrm_mtlx.shadergen import all_targets, available_targets, lacking_targets

    allowed = all_targets() if allowed is None else allowed
    names = one_or_more(names)
    unknown = [name for name in names if name not in allowed]
    if unknown:
        later = [name for name in unknown if name in lacking_targets()]
        lacks = f"MaterialX {materialx_version()} has no generator for {', '.join(later)}; " if later else ""
        msg = f"{', '.join(map(str, unknown))}: {lacks}expected one of {', '.join(allowed)}"
        raise ArgumentError(msg, "target")
    check_library(names, library, "target")
    return tuple(dict.fromkeys(names)) or tuple(available_targets() if default is None else default)


def check_library(targets: Sequence[str], library: str, argument: str) -> None:
    """Refuse MaterialX's own implementation of the flag for the targets of hosts, which are given this project's."""
    from mrm_mtlx.shadergen import HOST_TARGETS

    hosts = [name for name in targets if name in HOST_TARGETS]
    if hosts and library != "mrm":
        msg = f"{', '.join(hosts)}: has a MaterialX of its own, to which the library mrm is given; not {library}"
        raise ArgumentError(msg, argument)


def _in_form(element: Any, shader: Shader, self_contained: bool, script_node: bool) -> Shader:
    """A generated shader in the form that is asked for; a Script node's is self-contained."""
    from mrm_mtlx import shadergen

    if script_node:
        return shadergen.script_node(element, shader).shader
    return shadergen.self_contained(shader) if self_contained else shader


def _write(sources: Mapping[str, str], folder: Path, argument: str) -> list[Path]:
    from mrm_mtlx.system.writing import FileSet

    try:
        folder.mkdir(parents=True, exist_ok=True)
        with FileSet(folder) as files:
            for name, source in sources.items():
                files.named(folder / name).write_text(source, encoding="utf-8")
    except OSError as error:
        msg = f"{folder} cannot be written: {error.strerror}"
        raise ArgumentError(msg, argument) from error
    return [folder / name for name in sources]
