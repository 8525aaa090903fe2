"""The shape of the package: which layer imports which, and what is imported at start."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "mrm_mtlx"

# A layer may import the layers below it, and itself.
LAYERS = (
    {"cli"},
    {"api"},
    {"plots"},
    {"conformance"},
    {"validation", "render"},
    {"fitting"},
    {"formats"},
    {"photometry"},
    {"measured", "standards"},
    {"engines", "reference"},
    {"shadergen"},
    {"documents"},
    {"library"},
    {"findings"},
    {"system", "bsdf"},
)
RANK = {name: rank for rank, layer in enumerate(LAYERS) for name in layer}
# Heavy packages that no command may load before it needs them.
HEAVY = ("MaterialX", "numpy", "moderngl", "OpenImageIO", "rich", "pebble", "slangpy", "matplotlib", "scipy", "pxr")


def imports(path: Path) -> set[str]:
    """Modules that a source file imports, at any depth."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
    return found


def violations(sources: dict[str, set[str]]) -> list[str]:
    """Imports that run upward, or sideways between packages of one layer; `sources` maps a package to its imports."""
    wrong = []
    for package, modules in sources.items():
        for module in modules:
            parts = module.split(".")
            if parts[0] != "mrm_mtlx" or len(parts) < 2 or parts[1] not in RANK or parts[1] == package:
                continue
            if RANK[parts[1]] <= RANK[package]:
                wrong.append(f"{package} imports {module}")
    return wrong


def test_imports_run_downward() -> None:
    sources: dict[str, set[str]] = {}
    for path in PACKAGE.rglob("*.py"):
        package = path.relative_to(PACKAGE).parts[0]
        if package in RANK:
            sources[package] = sources.get(package, set()) | imports(path)
    assert sources.keys() == RANK.keys()
    assert violations(sources) == []


@pytest.mark.parametrize(
    ("package", "module"),
    [("bsdf", "mrm_mtlx.reference"), ("reference", "mrm_mtlx.engines.gl"), ("shadergen", "mrm_mtlx.cli.main")],
)
def test_an_upward_or_sideways_import_is_seen(package: str, module: str) -> None:
    assert violations({package: {module}})


def test_help_loads_nothing_heavy() -> None:
    code = "import sys; sys.argv = ['mrm', '--help']\nfrom mrm_mtlx.cli.main import run\n"
    code += f"try:\n    run()\nfinally:\n    print([m for m in {HEAVY!r} if m in sys.modules], file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(done.stderr.splitlines()) == {"[]"}  # of the command's process, and of the one that waits for it
