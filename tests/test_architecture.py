"""The shape of the package: which layer imports which, and what is imported at start."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from mrm_mtlx.engines.registry import engines
from mrm_mtlx.findings.catalogue import RULES
from mrm_mtlx.shadergen import HOST_TARGETS, TARGETS

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


def findings_from_strings(source: str) -> list[int]:
    """Lines that make a finding by hand, name a rule by a text, or hang on the text of a code."""
    wrong = []
    for node in ast.walk(ast.parse(source)):
        made = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("Finding", "Rule")
        named = isinstance(node, ast.Constant) and node.value in RULES
        compared = isinstance(node, ast.Compare) and any(map(_is_code, (node.left, *node.comparators)))
        begun = isinstance(node, ast.Attribute) and node.attr == "startswith" and _is_code(node.value)
        if made or named or compared or begun:
            wrong.append(node.lineno)
    return wrong


def _is_code(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and node.attr == "code"


def test_findings_are_made_of_rules() -> None:
    sources = [path for path in PACKAGE.rglob("*.py") if path.relative_to(PACKAGE).parts[0] != "findings"]
    wrong = {str(path): findings_from_strings(path.read_text(encoding="utf-8")) for path in sources}
    assert {path: lines for path, lines in wrong.items() if lines} == {}


@pytest.mark.parametrize(
    "line",
    [
        'Finding("DOC_CYCLE", "/a", "found", "hint")',
        'report("DOC_CYCLE", place)',
        'found.code == "DOC_" + "CYCLE"',
        'found.code.startswith("USD_")',
    ],
)
def test_a_finding_of_a_text_is_seen(line: str) -> None:
    assert findings_from_strings(f"x = 1\n{line}\n") != []


# The modules of engines that those above may import, and names of engines that no target has.
SEAM = {"base", "registry"}
ENGINE_NAMES = set(engines()) - {*TARGETS, *HOST_TARGETS}


def concrete_engines(source: str) -> list[int]:
    """Lines that import the module of an engine, or tell engines apart by their names."""
    return sorted(node.lineno for node in ast.walk(ast.parse(source)) if _imports_engine(node) or _names_engine(node))


def _imports_engine(node: ast.AST) -> bool:
    modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
    if isinstance(node, ast.ImportFrom) and node.module:
        modules = [f"{node.module}.{alias.name}" for alias in node.names]
    parts = [module.split(".") for module in modules]
    return any(p[:2] == ["mrm_mtlx", "engines"] and len(p) > 2 and p[2] not in SEAM for p in parts)


def _names_engine(node: ast.AST) -> bool:
    """Whether an expression hangs on the text of an engine's name; an enumeration may have a member of that text."""
    match node:
        case ast.Compare(left=left, comparators=comparators):
            sides = [left, *comparators]
            told = any(isinstance(side, ast.Attribute) and side.attr == "name" and _is_engine(side) for side in sides)
            return told or any(_has_name(side) for side in sides)
        case ast.Subscript(value=ast.Name(id="Literal")):
            return False  # a type, of which a text may be a member as of an enumeration
        case ast.Subscript(value=ast.Call(func=called), slice=ast.Constant(value=str())):
            return "engines" in ast.unparse(called)
        case ast.Subscript(slice=key) | ast.MatchValue(value=key):
            return _has_name(key)
        case ast.Call(args=arguments):
            return any(_has_name(argument) for argument in arguments)
        case ast.Dict(keys=keys):
            return any(_has_name(key) for key in keys if key is not None)
    return False


def _is_engine(side: ast.Attribute) -> bool:
    return isinstance(side.value, ast.Name) and side.value.id == "engine"


def _has_name(node: ast.AST) -> bool:
    """Whether a text, or one of several, is the name of an engine."""
    return any(isinstance(part, ast.Constant) and part.value in ENGINE_NAMES for part in _items(node))


def _items(node: ast.AST) -> list[ast.expr]:
    return list(node.elts) if isinstance(node, ast.Tuple | ast.List | ast.Set) else [node]


def test_nothing_above_the_engines_names_one() -> None:
    sources = [path for path in PACKAGE.rglob("*.py") if path.relative_to(PACKAGE).parts[0] != "engines"]
    wrong = {str(path): concrete_engines(path.read_text(encoding="utf-8")) for path in sources}
    assert {path: lines for path, lines in wrong.items() if lines} == {}


@pytest.mark.parametrize(
    "planted",
    [
        "from mrm_mtlx.engines import gl",
        "from mrm_mtlx.engines.osl.process import runtime",
        "def late():\n    import mrm_mtlx.engines.slang",
        'if engine == "cycles": pass',
        'if engine.name != "slang": pass',
        'if name in ("gl", "metal"): pass',
        'registry.engines()["osl"]',
        'states["gl"].available',
        'choose("cycles")',
        'match engine:\n    case "gl": pass',
        '{"gl": draw, "osl": trace}',
    ],
)
def test_an_engine_that_is_named_is_seen(planted: str) -> None:
    assert concrete_engines(planted)


@pytest.mark.parametrize(
    "allowed",
    [
        "from mrm_mtlx.engines import base, registry",
        "from mrm_mtlx.engines.base import Engine",
        'class Mode(StrEnum):\n    CYCLES = "cycles"',
        'if target == "osl": pass',
        'registry.engine_for("glsl")',
    ],
)
def test_targets_and_the_seam_are_no_engines(allowed: str) -> None:
    assert concrete_engines(allowed) == []


# Circles --------------------------------------------------------------------------------------------------------------


def module_name(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def arrows(sources: dict[str, str]) -> dict[str, set[str]]:
    """Which modules each module imports, wherever in it and for whatever use; by name, of those given."""
    found: dict[str, set[str]] = {}
    for name, source in sources.items():
        found[name] = set()
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Import):
                found[name] |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                inner = {f"{node.module}.{alias.name}" for alias in node.names}
                found[name] |= {whole if whole in sources else node.module for whole in inner}
    return {name: found[name] & sources.keys() for name in found}


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Paths along imports that end where they begin, one for every module that closes one."""
    found: list[list[str]] = []
    done: set[str] = set()

    def visit(name: str, trail: list[str]) -> None:
        if name in trail:
            found.append([*trail[trail.index(name) :], name])
        elif name not in done:
            for below in sorted(graph[name]):
                visit(below, [*trail, name])
            done.add(name)

    for name in sorted(graph):
        visit(name, [])
    return found


def test_imports_make_no_circle() -> None:
    sources = {module_name(path): path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    assert circles(arrows(sources)) == []


@pytest.mark.parametrize(
    "back",
    [
        "from p.a import x",
        "from p import a",
        "import p.a",
        "if TYPE_CHECKING:\n    from p.a import x",
        "def late():\n    from p.a import x",
    ],
)
def test_a_circle_of_modules_is_seen(back: str) -> None:
    planted = {"p.a": "from p import b", "p.b": "from p.c import y", "p.c": f"import os\n{back}\n", "p.d": "import p.a"}
    assert circles(arrows(planted)) == [["p.a", "p.b", "p.c", "p.a"]]
    assert circles(arrows(planted | {"p.c": "import os"})) == []


# Versions of MaterialX ------------------------------------------------------------------------------------------------

# Where versions of MaterialX are compared, and where they choose numbers.
VERSIONS = ("library/dialects.py", "reference/versions/")
# A version of MaterialX as a text, or its first two numbers.
_VERSION = re.compile(r"1\.3[0-9](\.[0-9]+)?")
_ASKED = ("getVersionIntegers", "materialx_version", "document_version", "version_of")


def compared_versions(source: str) -> list[int]:
    """Lines that ask MaterialX for its version, or compare one."""
    return [node.lineno for node in ast.walk(ast.parse(source)) if _asks_version(node) or _compares_version(node)]


def _asks_version(node: ast.AST) -> bool:
    """Whether it is a version as numbers, which are there to be compared, or the module's own."""
    if not isinstance(node, ast.Attribute):
        return False
    of_module = isinstance(node.value, ast.Name) and node.value.id in ("mx", "MaterialX")
    return node.attr == "getVersionIntegers" or (of_module and node.attr in ("getVersionString", "__version__"))


def _compares_version(node: ast.AST) -> bool:
    match node:
        case ast.Compare(left=left, comparators=comparators):
            return any(map(_is_version, (left, *comparators)))
        case ast.MatchValue(value=value):
            return _is_version(value)
        case ast.Call(func=ast.Attribute(attr="startswith" | "split" | "index"), args=arguments):
            return _is_version(node.func.value) or any(map(_is_version, arguments))
        case ast.Subscript(value=value):
            return _is_version(value)
    return False


def _is_version(node: ast.AST) -> bool:
    match node:
        case ast.Constant(value=str() as text):
            return _VERSION.fullmatch(text) is not None
        case ast.Tuple(elts=[ast.Constant(value=1), ast.Constant(value=int() as minor), *_]):
            return 30 <= minor < 40
        case ast.Tuple(elts=items) | ast.List(elts=items) | ast.Set(elts=items):
            return any(map(_is_version, items))
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)):
            return name in _ASKED
    return False


def test_versions_of_materialx_are_compared_in_one_place() -> None:
    sources = {path.relative_to(PACKAGE).as_posix(): path for path in PACKAGE.rglob("*.py")}
    outside = {name: path for name, path in sources.items() if not name.startswith(VERSIONS)}
    assert len(outside) < len(sources)
    wrong = {name: compared_versions(path.read_text(encoding="utf-8")) for name, path in outside.items()}
    assert {name: lines for name, lines in wrong.items() if lines} == {}


@pytest.mark.parametrize(
    "planted",
    [
        'if version < "1.39": pass',
        'if version == "1.39.5": pass',
        'if version in ("1.38", "1.39"): pass',
        "if numbers >= (1, 39, 5): pass",
        "if materialx_version() != known: pass",
        "document.getVersionIntegers()",
        "mx.getVersionString()",
        'mx.__version__ == "x"',
        'text.startswith("1.39")',
        'materialx_version().split(".")',
        "dialects.version_of(document)[:4]",
        'match version:\n    case "1.39.5": pass',
    ],
)
def test_a_version_that_is_compared_elsewhere_is_seen(planted: str) -> None:
    assert compared_versions(planted)


@pytest.mark.parametrize(
    "allowed",
    [
        'text = f"from MaterialX {materialx_version()}"',
        "node.getVersionString() == definition.getVersionString()",
        'UNSTATED = "1.38"',
        "if dialect(version).has_retroreflective: pass",
        "if index < 1.39: pass",
    ],
)
def test_versions_may_be_shown(allowed: str) -> None:
    assert compared_versions(allowed) == []


# The command line is arguments, one call and a print.
LONGEST_COMMAND = 150


def test_no_module_of_the_command_line_is_an_application() -> None:
    lengths = {path.name: len(path.read_text(encoding="utf-8").splitlines()) for path in (PACKAGE / "cli").glob("*.py")}
    assert len(lengths) > 10
    assert {name: length for name, length in lengths.items() if length > LONGEST_COMMAND} == {}
