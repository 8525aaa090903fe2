"""`python -m tools.environments FOLDER 1.39.2 1.39.4`: `mrm` in environments with other versions of MaterialX.

An environment is a virtual one with the wheel of its version alone. Whatever else it needs is that of the environment
that makes it, this project's dependencies and the project itself included, so that it takes seconds and differs in
MaterialX alone. One that is there already is used as it is.

There are no wheels of MaterialX's main branch: `--main FOLDER` makes the environment `main`, with the newest wheel and
the data libraries of FOLDER, `libraries/` of a checkout, in the place of its own.

`--run COMMAND` runs `mrm COMMAND` in each environment; the exit status is 1 if it fails in one.
"""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import site
import subprocess
import sys
import tempfile
import time
import venv
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from mrm_mtlx.library.dialects import VARIABLE

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

MAIN = "main"
# The version that main will be released as, and the release whose wheel its data libraries are put into.
MAIN_VERSION, NEWEST_WHEEL = "1.39.6", "1.39.5"
_NO_WHEEL = "No matching distribution found"


class EnvironmentUnavailableError(Exception):
    """An environment cannot be made here; the message says why."""


def environment(folder: Path, version: str, main: Path | None = None) -> Path:
    """The Python interpreter of the environment of a version in a folder, which is made if it is not there.

    Parameters
    ----------
    folder
        Of all environments; created if missing.
    version
        Of MaterialX, such as "1.39.2"; or `MAIN`.
    main
        For `MAIN`, its data libraries.

    Raises
    ------
    EnvironmentUnavailableError
        If there is no wheel of this version for this Python, or the package index cannot be reached.
    """
    made = folder.resolve() / version
    if not made.is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        # Under its name only once it is whole: what is interrupted, or made twice at a time, leaves no half of one.
        with tempfile.TemporaryDirectory(dir=folder, prefix=f".{version}-", ignore_cleanup_errors=True) as scratch:
            begun = Path(scratch) / "environment"
            _make(begun, version, main)
            if not made.is_dir():
                begun.rename(made)
    return _interpreter(made)


def _make(folder: Path, version: str, main: Path | None) -> None:
    if version == MAIN and (main is None or not (main / "pbrlib").is_dir()):
        msg = f"{main} is no folder of data libraries, such as `libraries` in a checkout of MaterialX"
        raise EnvironmentUnavailableError(msg)
    venv.create(folder, with_pip=True)
    _install(_interpreter(folder), NEWEST_WHEEL if version == MAIN else version)
    packages = next(folder.rglob("MaterialX")).parent
    lines = [f"import site; site.addsitedir({path!r})" for path in site.getsitepackages()]
    if main is not None and version == MAIN:
        libraries = packages / "MaterialX" / "libraries"
        shutil.rmtree(libraries)
        shutil.copytree(main, libraries)
        lines.append(f"import os; os.environ.setdefault({VARIABLE!r}, {MAIN_VERSION!r})")
    # After the packages of the environment itself, so that its MaterialX is the one that is found.
    (packages / "shared.pth").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _install(python: Path, version: str) -> None:
    # Constraints of the environment here are of another MaterialX.
    variables = {key: value for key, value in os.environ.items() if key != "PIP_CONSTRAINT"}
    options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--only-binary", ":all:"]
    command = [str(python), "-m", "pip", "install", *options, f"MaterialX=={version}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=variables)
    if done.returncode:
        words = done.stderr.strip() or done.stdout.strip()
        here = f"Python {sys.version_info.major}.{sys.version_info.minor}"
        none = f"no wheel of MaterialX {version} for {here} on this system is at the package index"
        raise EnvironmentUnavailableError(none if _NO_WHEEL in words else words)


def _interpreter(folder: Path) -> Path:
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def run(python: Path, command: str) -> int:
    """Run `mrm` with an interpreter; its exit status."""
    return subprocess.run([python, "-m", "mrm_mtlx.cli.main", *shlex.split(command)], check=False).returncode


def main(arguments: Sequence[str]) -> int:
    """Run the command; 0 if all commands succeeded in all environments, 1 if not."""
    options = _parser().parse_args(arguments)
    failed = []
    for version in [*options.versions, *([MAIN] if options.main else [])]:
        try:
            with _timed(version) as said:
                python = environment(options.folder, version, options.main)
                said.append(str(python))
        except EnvironmentUnavailableError as error:
            print(f"--- {version}: {error}", flush=True)
            failed.append(version)
            continue
        for command in options.run:
            with _timed(version) as said:
                status = run(python, command)
                said.append(f"mrm {command}: exit status {status}")
            failed += [f"{version} ({command})"] * bool(status)
    if failed:
        print(f"FAILED: {', '.join(failed)}")
    return int(bool(failed))


@contextmanager
def _timed(version: str) -> Iterator[list[str]]:
    """A list of words, which are printed in a line with how long it took to find them."""
    start, said = time.perf_counter(), list[str]()
    yield said
    print(f"--- {version}: {' '.join(said)} ({time.perf_counter() - start:.0f} s)", flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tools.environments", description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="where they are, or are made")
    parser.add_argument("versions", nargs="*", metavar="VERSION", help="of MaterialX, such as 1.39.2")
    parser.add_argument("--main", type=Path, metavar="FOLDER", help="data libraries of the main branch")
    parser.add_argument(
        "--run", action="append", default=[], metavar="COMMAND", help="arguments of `mrm`; may be repeated"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
