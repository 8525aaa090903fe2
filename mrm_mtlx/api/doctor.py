"""The state of this machine: engines, and the commands that add what is missing; and the reference's coverage."""

from __future__ import annotations

import json
import textwrap
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mrm_mtlx.system.shown import COLUMNS, Shown, in_lines

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.api.opening import PathLike
    from mrm_mtlx.engines.base import Availability
    from mrm_mtlx.library.host_check import Check
    from mrm_mtlx.library.surface_models import Extension
    from mrm_mtlx.reference.coverage import Coverage

# Where the second column of the report begins.
_INDENT = 11


@dataclass(frozen=True, repr=False)
class DoctorReport(Shown):
    """The state of this installation and machine.

    Attributes
    ----------
    versions
        Of what a verdict depends on.
    library
        Whether the node library is found.
    targets
        What source can be generated for.
    lacking
        What it cannot be generated for with this version of MaterialX, and can with others.
    models
        Surface models of MaterialX, each with the input that makes it retroreflect, or the reason why it has none.
    engines
        By name, what each is for, and how it is.
    ok
        Whether generated GLSL can be run and compared.
    """

    versions: Mapping[str, str]
    library: bool
    targets: tuple[str, ...]
    lacking: tuple[str, ...]
    models: tuple[Extension, ...]
    engines: Mapping[str, tuple[str, Availability]]
    ok: bool

    def report(self) -> str:
        """All of it, with the command that adds what is missing."""
        versions = [f"{name} {version}" for name, version in self.versions.items()]
        extended = [f"{x.model.node} {x.model.amount}" for x in self.models if not x.reason] or ["none"]
        lines = [
            *_listed("versions", versions),
            f"library    {'found' if self.library else 'missing'}",
            *_listed("targets", self.targets, "(source can be generated)"),
            *(
                f"{'':{_INDENT}}MaterialX {self.versions['materialx']} has no generator for {name}"
                for name in self.lacking
            ),
            *_listed("models", extended, "(partly retroreflective)"),
            *(f"{'':{_INDENT}}{x.model.node} is left out: {x.reason}" for x in self.models if x.reason),
        ]
        width = max(len(use) for use, _ in self.engines.values())
        for name, (use, state) in self.engines.items():
            line = f"{name:<9}  {'ok     ' if state.available else 'missing'}  {use:<{width}}"
            fits = len(line) + 2 + len(state.detail) <= COLUMNS
            lines += [f"{line}  {state.detail}"] if fits else [line.rstrip(), *_wrapped(state.detail, _INDENT)]
            if state.remedy:
                lines.append(f"{'':20}to add it: {state.remedy}")
        return "\n".join(lines)

    def to_json(self) -> str:
        """The same as JSON."""
        report = {
            "schema": "mrm.doctor/1",
            "versions": self.versions,
            "targets": list(self.targets),
            "surface_models": [
                {"node": x.model.node, "input": x.model.amount, "reason": x.reason} for x in self.models
            ],
            "engines": {
                name: {"use": use, "available": a.available, "detail": a.detail, "remedy": a.remedy}
                for name, (use, a) in self.engines.items()
            },
        }
        return json.dumps(report, indent=2)


@dataclass(frozen=True, repr=False)
class CoverageReport(Shown):
    """Node definitions of MaterialX, each with how the reference evaluates it, or why not."""

    versions: Mapping[str, str]
    definitions: tuple[Coverage, ...]

    @property
    def covered(self) -> int:
        """The number of definitions that it evaluates."""
        return sum(bool(definition.how) for definition in self.definitions)

    def report(self) -> str:
        """A row per library of MaterialX, and the definitions that are not covered."""
        from mrm_mtlx.reference.coverage import How

        every = Counter(c.library for c in self.definitions)
        how = Counter((c.library, c.how) for c in self.definitions)
        lines = [f"{'library':<9}{'nodes':>7}{'functions':>11}{'graphs':>8}{'covered':>9}"]
        for name, total in every.items():
            functions, graphs = how[name, How.FUNCTION], how[name, How.GRAPH]
            share = (functions + graphs) / total
            lines.append(f"{name:<9}{total:>7}{functions:>11}{graphs:>8}{share:>9.1%}")
        number = len(self.definitions)
        lines.append(f"{'all':<9}{number:>7}{'':>19}{self.covered / number:>9.1%}")
        missing = (c for c in self.definitions if not c.how)
        return "\n".join([*lines, *(f"not covered: {c.name} ({c.library}): {c.reason}" for c in missing)])

    def to_json(self) -> str:
        """The same as JSON, all definitions listed."""
        nodes = [{"name": c.name, "library": c.library, "how": c.how, "reason": c.reason} for c in self.definitions]
        report = {
            "schema": "mrm.coverage/1", "versions": self.versions, "covered": self.covered, "definitions": nodes,
        }  # fmt: skip
        return json.dumps(report, indent=2)


def doctor() -> DoctorReport:
    """Say which targets can be generated, compiled and run here, and what to install for the others."""
    from mrm_mtlx.engines import registry
    from mrm_mtlx.library import load_library, node_library_folder
    from mrm_mtlx.library.dialects import versions
    from mrm_mtlx.shadergen import available_targets, lacking_targets

    engines, models = survey(), load_library().surface_models
    runner = registry.engine_for("glsl", registry.runs)
    ok = runner is not None and runner.availability().available
    found = node_library_folder().is_dir()
    return DoctorReport(versions(), found, available_targets(), lacking_targets(), tuple(models), engines, ok)


def coverage() -> CoverageReport:
    """Say which of MaterialX's nodes the reference evaluates."""
    from mrm_mtlx.library import load_library
    from mrm_mtlx.library.dialects import versions
    from mrm_mtlx.reference.coverage import coverage as covered

    return CoverageReport(versions(), tuple(covered(load_library().document)))


@dataclass(frozen=True, repr=False)
class HostReport(Shown):
    """Whether a host finds the node library.

    Attributes
    ----------
    host
        Its name.
    version
        Of its MaterialX, as it is expected.
    checks
        What was looked at, in order.
    """

    host: str
    version: str
    checks: tuple[Check, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing was found to be wrong."""
        return all(check.ok is not False for check in self.checks)

    def report(self) -> str:
        """A line each, and what to do under what is wrong."""
        states = {True: "ok", False: "wrong", None: "-"}
        lines = [f"{self.host}, MaterialX {self.version}"]
        for check in self.checks:
            lines.append(f"{check.name:<9}  {states[check.ok]:<5}  {check.found}")
            if check.remedy:
                lines.append(f"{'':18}to do: {check.remedy}")
        return "\n".join(lines)

    def to_json(self) -> str:
        """The same as JSON."""
        checks = [{"name": c.name, "ok": c.ok, "found": c.found, "remedy": c.remedy} for c in self.checks]
        report = {"schema": "mrm.host/1", "host": self.host, "materialx": self.version, "ok": self.ok, "checks": checks}
        return json.dumps(report, indent=2)


def check_host(
    host: str, *, path: PathLike | None = None, materialx: str | None = None, ask: PathLike | None = None
) -> HostReport:
    """Look whether a host finds the node library that was installed for it.

    Parameters
    ----------
    host
        Its name, as `install_library` takes it.
    path
        Folder that the library was installed into; default: the one that the host's variable names.
    materialx
        Version of the host's MaterialX, where it is not the one that is known of the host.
    ask
        The host's own Python interpreter, or Blender, which is started and asked; default: this interpreter if it
        has the host as a module, else nothing is asked.

    Raises
    ------
    ArgumentError
        If the host or the version is not known, or nothing says where the library is.
    """
    from mrm_mtlx.api.library import known_host, served_version
    from mrm_mtlx.library.host_check import checks
    from mrm_mtlx.system.arguments import ArgumentError, path_of

    chosen = known_host(host)
    version = served_version(chosen, materialx)
    if not chosen.variable and path is None:
        msg = f"{chosen.name} has no variable that names the folder of the node library: name it"
        raise ArgumentError(msg, "path")
    folder = None if path is None else path_of("path", path).expanduser()
    program = None if ask is None else str(path_of("ask", ask).expanduser())
    return HostReport(chosen.name, version, tuple(checks(chosen, version, folder, program)))


def survey() -> dict[str, tuple[str, Availability]]:
    """Engines by name: what each is for, and whether it works here."""
    from mrm_mtlx.engines import registry

    return {name: (engine.use, engine.availability()) for name, engine in registry.engines().items()}


def _wrapped(text: str, indent: int) -> list[str]:
    """A sentence in lines of `COLUMNS`, behind an indent; what is not to be broken, such as a path, is as it is."""
    margin = " " * indent
    return textwrap.wrap(
        text, COLUMNS, initial_indent=margin, subsequent_indent=margin, break_long_words=False, break_on_hyphens=False
    )


def _listed(name: str, items: list[str] | tuple[str, ...], end: str = "") -> list[str]:
    """A list beside its name, in as many lines as it takes."""
    lines = in_lines([*items[:-1], f"{items[-1]} {end}".rstrip()], _INDENT)
    return [f"{name:<{_INDENT}}{lines[0]}", *(f"{'':{_INDENT}}{line}" for line in lines[1:])]
