"""A checkout, and what its commands print and write."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tools.compare_outputs.subjects import Run

# Seconds that a command may take, all documents of a folder among them.
_LIMIT_S = 3600
# The file beside an output that says what it is of.
_STEPS = "steps"


@dataclass(frozen=True)
class Checkout:
    """A checkout, and how its arguments differ from those of `subjects`: (command, what is replaced, by what)."""

    root: Path
    changes: Sequence[tuple[str, str, str]]

    def start(self) -> list[str]:
        """What starts `mrm` of this checkout."""
        module, function = self._entry()
        return [sys.executable, "-c", f"import sys; from {module} import {function} as f; sys.argv[0] = 'mrm'; f()"]

    def check(self) -> None:
        """End the program where the interpreter would import another package than that of this checkout."""
        module, _ = self._entry()
        command = [sys.executable, "-c", f"import {module} as m; print(m.__file__)"]
        done = subprocess.run(
            command, capture_output=True, text=True, cwd=self.root, env=self.environment(), check=False
        )
        if not Path(done.stdout.strip()).is_relative_to(self.root):
            sys.exit(f"{self.root} is not what is imported: {done.stdout}{done.stderr}")

    def _entry(self) -> tuple[str, str]:
        """Module and function of the command."""
        project = tomllib.loads((self.root / "pyproject.toml").read_text(encoding="utf-8"))
        module, function = project["project"]["scripts"]["mrm"].split(":")
        return module, function

    def step(self, step: str) -> list[str]:
        """The arguments of a step, as this checkout has them."""
        for command, old, new in self.changes:
            if step.startswith(f"{command} "):
                step = step.replace(f" {old}", f" {new}") if old else f"{step} {new}"
        return shlex.split(step)

    def environment(self) -> dict[str, str]:
        """The environment in which the package is that of this checkout."""
        plain = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "FORCE_COLOR", "PYTHONPATH")}
        return {**plain, "COLUMNS": "80", "PYTHONUTF8": "1", "PYTHONPATH": str(self.root)}


@dataclass(frozen=True)
class Outputs:
    """The outputs of a checkout, a folder per run, and the copies of the documents that they are computed from."""

    checkout: Checkout
    documents: Path
    folder: Path

    def add(self, run: Run) -> None:
        """Do a run in a fresh copy of the documents, unless that was done before."""
        kept = self.folder / run.name
        steps = "\n".join(run.steps)
        if (kept / _STEPS).is_file() and (kept / _STEPS).read_text(encoding="utf-8") == steps:
            return
        with tempfile.TemporaryDirectory(dir=self.folder.parent, prefix="run-") as name:
            place, written = Path(name, "documents"), Path(name, "written")
            shutil.copytree(self.documents, place, symlinks=True)
            written.mkdir()
            for number, step in enumerate(run.steps, start=1):
                status = self._step(step, place, written / str(number))
                if status:
                    break
            if (place / "out").is_dir():
                (place / "out").rename(written / "out")
            (written / _STEPS).write_text(steps, encoding="utf-8")
            kept.parent.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(kept, ignore_errors=True)  # of other steps
            written.rename(kept)

    def _step(self, step: str, place: Path, written: Path) -> int:
        """Exit status of a step in a folder; what it prints is written beside a path."""
        (place / "out").mkdir(exist_ok=True)
        with written.with_suffix(".stdout").open("wb") as out, written.with_suffix(".stderr").open("wb") as err:
            command = [*self.checkout.start(), *self.checkout.step(step.replace("{out}", "out"))]
            done = subprocess.run(
                command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, cwd=place,
                env=self.checkout.environment(), timeout=_LIMIT_S, check=False,
            )  # fmt: skip
            err.write(f"exit status {done.returncode}\n".encode())
        return done.returncode

    def files(self, run: Run) -> dict[str, bytes]:
        """What a run printed and wrote."""
        folder = self.folder / run.name
        paths = (path for path in sorted(folder.rglob("*")) if path.is_file() and path.name != _STEPS)
        return {f"{run.name}/{path.relative_to(folder).as_posix()}": path.read_bytes() for path in paths}
