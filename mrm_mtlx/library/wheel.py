"""The standard library of a version of MaterialX from its wheel, in a scratch folder: data alone, nothing is run."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

from mrm_mtlx.library.standard_library import StandardLibrary, StandardLibraryError, given
from mrm_mtlx.system.text import printable, text_lines

if TYPE_CHECKING:
    from pathlib import Path

# A wheel that every version has: the data are the same in all of them.
_PLATFORM, _PYTHON = {"pip": "win_amd64", "uv": "windows"}, "3.11"
_CONSTRAINTS = ("PIP_CONSTRAINT", "UV_CONSTRAINT")
# Seconds for 10 to 20 MB.
_LONGEST_S = 300.0


def fetched(version: str, scratch: Path) -> StandardLibrary:
    """The standard library of a version, from the package index that pip or uv is configured for.

    Parameters
    ----------
    version
        Of MaterialX.
    scratch
        An empty folder, which the caller removes.

    Raises
    ------
    StandardLibraryError
        If the wheel cannot be had: no network, no such version, neither pip nor uv.
    """
    done = _install(version, scratch)
    if done.returncode:
        said = [line for line in text_lines(done.stderr) if line.strip()] or ["no message"]
        msg = (
            f"the standard library of MaterialX {version} is needed, and its wheel could not be fetched "
            f"({printable(said[-1].strip())[:160]}): name the folder of the host's own with `stdlib`, or go online"
        )
        raise StandardLibraryError(msg)
    found = given(scratch, version)
    return StandardLibrary(found.folder, version, f"the wheel of MaterialX {version}")


def _install(version: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Unpack the wheel into a folder that no interpreter looks into."""
    if importlib.util.find_spec("pip") is not None:
        tool, command = "pip", [sys.executable, "-m", "pip", "install", "--no-compile", "--no-input", "--quiet"]
        command += ["--disable-pip-version-check"]
    elif (uv := shutil.which("uv")) is not None:
        tool, command = "uv", [uv, "pip", "install", "--quiet"]
    else:
        msg = f"the wheel of MaterialX {version} is needed, and there is neither pip nor uv: use `stdlib`"
        raise StandardLibraryError(msg)
    platform = "--platform" if tool == "pip" else "--python-platform"
    command += ["--target", str(folder), "--no-deps", "--only-binary=:all:", platform, _PLATFORM[tool]]
    command += ["--python-version", _PYTHON, f"MaterialX=={version}"]
    # Constraints are for the environment here, whose MaterialX is another one.
    variables = {name: value for name, value in os.environ.items() if name not in _CONSTRAINTS}
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=_LONGEST_S, check=False, env=variables)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 1, "", f"not finished within {_LONGEST_S:.0f} s")
