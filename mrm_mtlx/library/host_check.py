"""Whether a host finds the node library: the variable, the folder, its contents, and what the host itself says."""

from __future__ import annotations

import importlib.util
import json
import os
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.library.host_models import MODELS_FILE, models_version, without_standard_nodes
from mrm_mtlx.library.hosts import STANDARD_VARIABLE, Choice, Form
from mrm_mtlx.library.install import FOLDER, nodes
from mrm_mtlx.library.standard_library import FIRST_DEFINED, StandardLibraryError, version_of_folder
from mrm_mtlx.library.surface_models import SURFACE_MODELS
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.library.hosts import Host

QUESTION = Path(__file__).with_name("host_question.py")
_MARK = "mrm-host-answer "
# Seconds; Blender loads in one, from a cold disk in ten.
_LONGEST_S = 120.0

# Of each form a definition that has the flag.
_OURS = {Form.SOURCES: "ND_conductor_bsdf", Form.PORTABLE: "ND_mrm_portable_conductor_bsdf"}
_MODEL = SURFACE_MODELS[0]
_STOCK = f"ND_{_MODEL.node}_surfaceshader"


@dataclass(frozen=True)
class Check:
    """One thing that was looked at.

    Attributes
    ----------
    name
        Of what was looked at, a word.
    ok
        None if it could not be looked at.
    found
        How it is.
    remedy
        What to do, "" if nothing has to be done.
    """

    name: str
    ok: bool | None
    found: str
    remedy: str = ""


def checks(host: Host, version: str, path: Path | None, program: str | None) -> list[Check]:
    """Look whether a host finds the node library.

    Parameters
    ----------
    host
        Which host.
    version
        Of its MaterialX.
    path
        Folder that the library was installed into; None for that which the host's variable names.
    program
        The host's own interpreter, or Blender; None for what is found here.
    """
    folder = path or _named(host)
    install = _install(folder, host, version)
    found = [_variable(host, path, f"{install} says how to set it")] if host.variable else []
    if folder is None:
        found.append(Check("folder", None, "no folder is named", install))
        return [*found, *_asked(host, version, host.form, None, program)] if program else found
    found.append(_folder(folder, install))
    form = _form(folder / FOLDER, version) or host.form
    if found[-1].ok:
        found += [_nodes(folder / FOLDER, version, form, install), _models(folder / FOLDER, host, version, install)]
    return [*found, *_asked(host, version, form, folder, program)] if host.variable else found


def _install(folder: Path | None, host: Host, version: str) -> str:
    """The command that installs the library, as a shell takes it."""
    return f"mrm library install {shlex.quote(str(folder)) if folder else 'DIR'} {host.chosen(version)}"


def _variable(host: Host, path: Path | None, setting: str) -> Check:
    name, folders = host.variable, _folders(host)
    if not folders:
        return Check("variable", False, f"{name} is not set in this shell", setting)
    ours = [path.resolve()] if path else [each for each in folders if _is_ours(each)]
    if not ours or ours[0] not in folders:
        shown = printable(os.environ[name])
        return Check("variable", False, f"{name} names no folder of the node library, but {shown}", setting)
    if host.with_standard and folders.index(ours[0]) > 0:
        return Check("variable", False, f"{name} names the standard library before {ours[0]}", setting)
    return Check("variable", True, f"{name} names {ours[0]}")


def _folder(folder: Path, install: str) -> Check:
    if not _is_ours(folder):
        return Check("folder", False, f"{folder} has no folder '{FOLDER}' with the node library", install)
    return Check("folder", True, str(folder / FOLDER))


def _form(folder: Path, version: str) -> Form | None:
    """The form of the node library that a folder has for a version; None if it has none for it."""
    return next((form for form in Form if _agrees(folder, version, form)), None)


def _nodes(folder: Path, version: str, form: Form, install: str) -> Check:
    """Whether the files are those for a version."""
    if _agrees(folder, version, form):
        return Check("library", True, f"for MaterialX {version}, form {form.value}")
    others = [other for other in reversed(FIRST_DEFINED) if _agrees(folder, other, form)]
    if others:
        return Check("library", False, f"for MaterialX {' or '.join(others)}, not for {version}", install)
    return Check("library", False, "files are missing, changed, or of another version of this package", install)


def _models(folder: Path, host: Host, version: str, install: str) -> Check:
    try:
        text = (folder / MODELS_FILE).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return Check("models", False, f"{MODELS_FILE} is missing", install)
    made = models_version(text)
    if made != version:
        return Check("models", False, f"made from MaterialX {made or 'of no known version'}, not {version}", install)
    choice = Choice.NAME if f'node="mrm_{_MODEL.node}"' in text else Choice.INPUTS
    if choice is not host.choice:
        return Check("models", False, "written for hosts that choose a definition in another way", install)
    return Check("models", True, f"made from MaterialX {version}")


def _asked(host: Host, version: str, form: Form, folder: Path | None, program: str | None) -> list[Check]:
    """What the host says; without a folder, what it is."""
    chosen = program or _program(host)
    if chosen is None:
        return [Check("host", None, "not asked", "--ask PROGRAM names its Python interpreter, or Blender")]
    node = _OURS[form]
    answer = _answer(chosen, host.module, [node, _MODEL.definition, _STOCK])
    if "error" in answer:
        said = f"{chosen} does not answer: {answer['error']}"
        return [Check("host", False, said, "--ask PROGRAM names another interpreter")]
    defined = answer["definitions"]
    if not defined:
        said = f"OpenUSD {answer['usd']} knows no definition of MaterialX"
        remedy = f"usd-core is built without; other builds may need {STANDARD_VARIABLE}"
        return [Check("host", False, said, remedy)]
    found = [_host_version(answer["usd"], defined, version, host)]
    if folder is None:
        return found
    ours, model, stock = (defined.get(name) for name in (node, _MODEL.definition, _STOCK))
    remedy = "the variable has to be set where the host is started, and name this folder first"
    if ours is None or not _is_below(ours["file"], folder):
        found.append(Check("nodes", False, f"{node} is found {_where(ours)}, not in {folder}", remedy))
    elif not _flags(ours["inputs"]):
        found.append(Check("nodes", False, f"{node} has no flag", _install(folder, host, version)))
    else:
        found.append(Check("nodes", True, f"{node} is ours, with {', '.join(_flags(ours['inputs']))}"))
    if model is None or not _flags(model["inputs"]):
        found.append(Check("model", False, f"{_MODEL.definition} is not known", remedy))
    else:
        found.append(Check("model", True, f"{_MODEL.definition} has {', '.join(_flags(model['inputs']))}"))
    if stock is None or _is_below(stock["file"], folder) or _flags(stock["inputs"]):
        found.append(Check("stock", False, f"{_STOCK} is not the host's own, but found {_where(stock)}", remedy))
    else:
        found.append(Check("stock", True, f"{_STOCK} is the host's own"))
    return found


def _where(definition: Mapping[str, Any] | None) -> str:
    return f"in {printable(definition['file'])}" if definition else "nowhere"


def _host_version(usd: str, defined: Mapping[str, Any], version: str, host: Host) -> Check:
    """Whether the host's MaterialX is the one that is expected: its own standard library tells."""
    file = Path(defined[_STOCK]["file"]) if _STOCK in defined else None
    try:
        found = version_of_folder(file.parents[1]) if file and len(file.parents) > 1 else ""
    except StandardLibraryError:
        found = ""
    if not found:
        return Check("host", None, f"OpenUSD {usd}; its standard library of MaterialX was not found")
    said = f"OpenUSD {usd} with MaterialX {found}"
    if found != version:
        return Check(
            "host", False, f"{said}, not {version}", f"mrm library install DIR --host {host.name} --for {found}"
        )
    return Check("host", True, said)


def _answer(program: str, module: str, definitions: list[str]) -> dict[str, Any]:
    """What a host says of the definitions, by name; or `error`."""
    names = [*([module] if module else []), *definitions]
    blender = Path(program).stem.lower().startswith("blender")
    options = ["--background", "--factory-startup", "--python", str(QUESTION), "--"] if blender else [str(QUESTION)]
    try:
        done = subprocess.run(
            [program, *options, *names],
            capture_output=True, encoding="utf-8", errors="replace", timeout=_LONGEST_S, check=False,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as error:
        return {"error": getattr(error, "strerror", None) or f"not finished within {_LONGEST_S:.0f} s"}
    lines = [line for line in done.stdout.splitlines() if line.startswith(_MARK)]
    if not lines:
        last = done.stderr.strip().splitlines()[-1:] or [f"exit status {done.returncode}"]
        return {"error": printable(last[0])[:200]}
    answer: dict[str, Any] = json.loads(lines[-1].removeprefix(_MARK))
    return answer


def _program(host: Host) -> str | None:
    """The interpreter of this process, if it has the module that brings the host in the host's version."""
    spec = importlib.util.find_spec(host.module) if host.module else None
    release = host.name.rpartition("-")[2]
    locations = (spec.submodule_search_locations or ()) if spec else ()
    return sys.executable if any(Path(location, release).is_dir() for location in locations) else None


def _named(host: Host) -> Path | None:
    """The first folder of the host's variable that has the node library, or None."""
    return next((folder for folder in _folders(host) if _is_ours(folder)), None) if host.variable else None


def _folders(host: Host) -> list[Path]:
    return [Path(each).resolve() for each in os.environ.get(host.variable, "").split(os.pathsep) if each]


def _is_ours(folder: Path) -> bool:
    return (folder / FOLDER / "mrm_defs.mtlx").is_file()


def _agrees(folder: Path, version: str, form: Form) -> bool:
    """Whether a folder has the node library for a version, whatever else it has."""
    try:
        expected = nodes(version, form)
        found = {name: (folder / name).read_bytes() for name in expected}
        if form is Form.PORTABLE:
            found, expected = without_standard_nodes(found), without_standard_nodes(expected)
    except Exception:  # not there, no document, or not of this form: MaterialX's exceptions have no base of their own
        return False
    return found == expected


def _is_below(file: str, folder: Path) -> bool:
    return Path(file).resolve().is_relative_to(folder.resolve())


def _flags(inputs: list[str]) -> list[str]:
    return [name for name in inputs if "retroreflecti" in name]
