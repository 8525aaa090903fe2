"""The optics need NumPy and nothing else."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

# Imports NumPy first, then the module, and prints what came on top: top-level packages, and modules of ours.
PROBE = """
import json, pkgutil, sys
import numpy
before = set(sys.modules)
import {module}
package = sys.modules["{module}"]
for found in pkgutil.iter_modules(package.__path__, "{module}."):
    __import__(found.name)
new = set(sys.modules) - before
top = sorted({{name.partition(".")[0] for name in new}} - set(sys.stdlib_module_names) - {{"numpy"}})
print(json.dumps([top, sorted(name for name in new if name.startswith("mrm_mtlx."))]))
"""

TIME_LIMIT_S = 60


def imported(module: str) -> tuple[list[str], list[str]]:
    """Foreign top-level packages, and modules of ours, that a package and all its modules bring in."""
    run = subprocess.run(
        [sys.executable, "-c", PROBE.format(module=module)],
        capture_output=True, text=True, check=True, timeout=TIME_LIMIT_S,
    )  # fmt: skip
    packages, modules = json.loads(run.stdout)
    return packages, modules


def test_the_optics_import_numpy_and_the_standard_library_alone():
    packages, modules = imported("mrm_mtlx.bsdf")
    assert packages == ["mrm_mtlx"]
    assert all(name.startswith("mrm_mtlx.bsdf") for name in modules)


@pytest.mark.parametrize(
    ("module", "foreign"), [("mrm_mtlx.library", "MaterialX"), ("mrm_mtlx.reference", "MaterialX")]
)
def test_a_foreign_package_is_seen(module, foreign):
    assert foreign in imported(module)[0]
