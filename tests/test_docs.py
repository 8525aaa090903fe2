"""What the documents say is true: each command is run, each snippet executed, each generated page up to date."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from mrm_mtlx.engines import storm as storm_engine
from mrm_mtlx.engines.osl import availability as osl_availability

if TYPE_CHECKING:
    from collections.abc import Callable

REPOSITORY = Path(__file__).parents[1]
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    "benchmarks/README.md",
    "libraries/pbrlib/README.md",
    "docs/development.md",
    "docs/api.md",
    "docs/classes.md",
    "docs/comparison.md",
    "docs/fitting.md",
    "docs/gltf.md",
    "docs/hosts.md",
    "docs/hosts/houdini.md",
    "docs/hosts/maya.md",
    "docs/hosts/omniverse.md",
    "docs/hosts/blender.md",
    "docs/hosts/openusd.md",
    "docs/hosts/threejs.md",
    "docs/model.md",
    "docs/openmaterial.md",
    "docs/openpbr.md",
    "docs/osl.md",
    "docs/photometry.md",
    "docs/plots.md",
    "docs/portable.md",
    "docs/prismatic.md",
    "docs/reference.md",
    "docs/releasing.md",
    "docs/reliability.md",
    "docs/storm.md",
    "docs/usd.md",
    "materials/README.md",
    "tools/README.md",
)
# The commands of these are run elsewhere, in the process of the tests: a second less each.
ELSEWHERE = {
    "docs/fitting.md": "tests/cli/test_fit.py",
    "docs/gltf.md": "tests/cli/test_convert_gltf.py",
    "docs/hosts.md": "tests/cli/test_library.py",
    "docs/hosts/houdini.md": "tests/cli/test_convert.py",
    "docs/hosts/maya.md": "tests/cli/test_library.py",
    "docs/hosts/omniverse.md": "tests/cli/test_convert_usd.py",
    "docs/hosts/openusd.md": "tests/cli/test_library.py",
    "docs/hosts/threejs.md": "tests/cli/test_convert_gltf.py",
    "docs/openmaterial.md": "tests/cli/test_convert.py",
    "docs/photometry.md": "tests/cli/test_photometry.py",
    "docs/portable.md": "tests/cli/test_convert.py",
    "docs/usd.md": "tests/cli/test_convert_usd.py",
}

# How a test runs each command of the pages: None as it stands, a string in its place (the same command at a size that
# suits a test), or a reason in parentheses why it is not run here.
COMMANDS = {
    "mrm fit --classes -o materials_classes": "(takes half a minute; tests/fitting/test_classes.py fits two again)",
    "mrm photometry materials_classes/dot_c2_red.mtlx --class DOT-C2 --color red": (
        "(tests/fitting/test_classes.py measures each)"
    ),
    "python -m tools.make_docs classes.md images/classes.png": "(tests/fitting/test_classes.py makes the page)",
    "pip install . && mrm validate materials/": "mrm validate materials/ --samples 1024 --target glsl",
    "pip install '.[test]' && pytest": "(this is the run)",
    "mrm library install hosts": None,
    "python3 -m venv .venv && . .venv/bin/activate": "(tests/test_wheel.py sets up an environment)",
    "pip install -e '.[dev]'": "(tests/test_wheel.py installs)",
    "python3 -m venv fresh && fresh/bin/pip install -e '.[dev]' && fresh/bin/pip freeze --exclude-editable": (
        "(tests/test_constraints.py compares with what is installed)"
    ),
    "mrm doctor": None,
    "mrm doctor --coverage": None,
    # Some of them: a driver takes seconds for each variant of a surface model.
    "mrm validate materials/ --retro-sweep": (
        "mrm validate materials/shoe_trim.mtlx materials/licence_plate.mtlx materials/embossed_foil.mtlx --retro-sweep "
        "--samples 256 --target glsl"
    ),
    "mrm validate materials/segmented_trim.mtlx": "(the first command of the README has it)",
    "mrm render materials/segmented_trim.mtlx -o trim.png": (
        "mrm render materials/segmented_trim.mtlx -o trim.png --size 32"
    ),
    "mrm photometry materials/segmented_trim.mtlx": None,
    "pytest": "(this is the run)",
    "ruff check . && ruff format --check .": "(.ci/run)",
    "mypy": "(.ci/run)",
    "mrm conformance": "(tests/cli/test_commands.py runs it)",
    "mrm conformance --library upstream --target glsl --target essl": (
        "mrm conformance --library upstream --target glsl --target essl --samples 512"
    ),
    "mrm render materials/traffic_cone_collar.mtlx --engine storm --shape cone --compare -o collar.png": (
        "mrm render materials/traffic_cone_collar.mtlx --engine storm --shape cone --compare -o collar.png --size 32"
    ),
    "mrm validate materials/ --target storm": "mrm validate materials/cats_eye.mtlx --target storm --samples 64",
    "mrm conformance --target storm": "(tests/engines/test_storm.py runs cases, and among the large ones the command)",
    "mrm generate materials/cats_eye.mtlx --target storm": None,
    "mrm conformance --target osl": "(tests/conformance/test_conformance_osl.py runs its steps, .ci/run the command)",
    "mrm validate materials/ --target osl": "mrm validate materials/ --target osl --samples 64",
    "mrm generate materials/hi_vis_tape_silver.mtlx --target osl --osl-mode cycles": None,
    "mrm generate materials/hi_vis_tape_silver.mtlx --target osl --self-contained": None,
    "mrm generate materials/segmented_trim.mtlx --target osl --script-node -o blender": None,
    "mrm render materials/traffic_cone_collar.mtlx --shape cone --engine cycles --compare -o collar.png": (
        "mrm render materials/traffic_cone_collar.mtlx --shape cone --engine cycles --compare -o collar.png --size 32 "
        "--paths 4"
    ),
    "pip install 'mrm-mtlx[osl]'": "(tests/test_wheel.py installs)",
    "python -m tools.osl_accuracy > docs/osl-accuracy.md": "(takes minutes; tests/tools/test_make_docs.py imports it)",
    "python -m tools.make_docs": "(takes minutes; tests/tools/test_make_docs.py has its parts)",
    "python -m build ../mrm-mtlx-$VERSION": "(tests/test_wheel.py builds)",
    "python3 -m venv fresh && fresh/bin/pip install ../mrm-mtlx-$VERSION/dist/*.whl": "(tests/test_wheel.py installs)",
    "python -m tools.make_docs --check": "(takes half a minute; tests/tools/test_make_docs.py has its parts)",
    "python -m benchmarks.oracle": "(takes a minute; tests/benchmarks runs it at another size)",
    "python -m benchmarks.oracle --save": "(takes a minute; tests/benchmarks runs it at another size)",
    "mrm plot --roughness 0.4 --light 20 --light 60 -o lobes.svg": None,
    "mrm plot --roughness 0.4 --light 20 --light 60 --scale polar -o polar.svg": None,
    "mrm plot --model conductor --alpha 0.05 --distribution beckmann --masking v_cavity -o gold.png": None,
    "mrm plot materials/retroreflective_tape_yellow.mtlx --light 15 --light 60 -o tape.svg": None,
    "mrm plot --figure all -o figures": "(tests/cli/test_plot.py draws them)",
    "mrm plot --figure 4 --measured retro_3m_yellow.dat -o figure4.svg": "(tests/cli/test_plot.py has the data)",
    "mrm render show/materials/sign.mtlx -o sign.png --root show": "(tests/cli/test_roots.py has such folders)",
    "mrm validate show/materials --root show --root studio/library": "(tests/cli/test_roots.py has such folders)",
    "python -m tools.fuzz -j 2": "(takes half an hour; tests/hostile/test_fuzz.py runs 2,000)",
    "python -m tools.fuzz --kind mtlx --count 25000 --seed 1 -j 2": (
        "python -m tools.fuzz --kind mtlx --count 25 --seed 1"
    ),
    "python -m tools.fuzz --kind mtlx --replay 1:124": None,
    "python -m tools.compare_outputs ../before . --keep before-outputs": (
        "(takes minutes; tests/tools/test_compare_outputs.py compares small ones)"
    ),
    (
        "python -m tools.environments ENVIRONMENTS 1.39.2 1.39.4 "
        '--run "conformance --target glsl --target essl --samples 8192" --run "validate materials"'
    ): "(needs the package index; .ci/run does it, tests/tools/test_environments.py a part)",
    "python -m tools.blender_extension -o dist": None,
    "python -m tools.blender_extension --previews": "(tests/tools/test_blender_extension.py draws one)",
    "python -m tools.blender_extension.figures -o docs/images": (
        "(takes minutes; tests/extension/test_first_steps.py draws small ones)"
    ),
    "pytest -m versions": "(needs the package index)",
    "python -m tools.trace_files": "(takes minutes; tests/hostile/test_trace.py runs a part)",
    "mrm vectors --format csv -o vectors.csv": "(tests/cli/test_vectors.py writes them)",
    "mrm fit data.csv -o sheet.mtlx": "(tests/cli/test_fit.py has the data)",
    "mrm render sheet.mtlx -o sheet.png": "(tests/cli/test_fit.py has the data)",
}
RUN = {command: told or command for command, told in COMMANDS.items() if told is None or not told.startswith("(")}
# Those over all materials: a driver takes a second for each that it has not seen.
LARGE = ("pip install . && mrm validate materials/", "mrm validate materials/ --target osl")


def commands() -> set[str]:
    """Lines of the pages' indented blocks that are commands."""
    found = set()
    for page in sorted(set(PAGES) - set(ELSEWHERE)):
        for line in (REPOSITORY / page).read_text(encoding="utf-8").splitlines():
            if re.match(r"^    (?:    )?(mrm|pip|python|python3|pytest|ruff|mypy)\b", line):
                found.add(line.strip())
    return found


def test_every_command_of_the_pages_is_accounted_for() -> None:
    assert commands() == set(COMMANDS)


@pytest.mark.parametrize(
    "command", [pytest.param(each, marks=pytest.mark.large) if each in LARGE else each for each in sorted(RUN)]
)
def test_a_command_of_the_pages_runs(mrm_here: Callable[..., Any], command: str, tmp_path: Path) -> None:
    (tmp_path / "materials").symlink_to(REPOSITORY / "materials")
    program, *arguments = shlex.split(RUN[command])
    assert program in ("mrm", "python")
    if {"osl", "cycles"} & set(arguments) and not osl_availability().available:
        pytest.skip(f"OSL runtime not available: {osl_availability().detail}; {osl_availability().remedy}")
    if "storm" in arguments and command.count("--engine") and not storm_engine.ENGINE.availability().available:
        pytest.skip(f"Storm not available: {storm_engine.ENGINE.availability().reason}")
    done = mrm_here(*arguments) if program == "mrm" else run_a_tool(arguments, tmp_path)
    # Without a driver, nothing can be compared (3), and the doctor says so (1).
    allowed = (0, 3) if "conformance" in arguments else (0, 1) if "doctor" in arguments else (0,)
    assert done.returncode in allowed, done.stderr


def run_a_tool(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """A finished program of the checkout."""
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join([*sys.path, str(REPOSITORY)])}
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=variables)


def test_the_snippet_of_the_readme_runs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "materials").symlink_to(REPOSITORY / "materials")
    text = (REPOSITORY / "README.md").read_text(encoding="utf-8")
    (snippet,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(snippet, "README.md", "exec"), {})
    assert (tmp_path / "trim.png").is_file()
    # At normal incidence l = v is the peak, f = F / (4 pi alpha^2): 0.15 / (4 pi 0.005^2) = 477.
    values = [float(x) for x in re.findall(r"[\d.]+", capsys.readouterr().out)]
    assert [round(x) for x in values] == [477, 477, 477]


def test_the_snippet_of_the_model_runs(capsys: pytest.CaptureFixture[str]) -> None:
    text = (REPOSITORY / "docs/model.md").read_text(encoding="utf-8")
    (snippet,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(snippet, "model.md", "exec"), {})
    radiance, energy = (float(re.findall(r"[\d.]+", line)[0]) for line in capsys.readouterr().out.strip().splitlines())
    # Nearly all light is scattered; what is refracted, some 0.9 of it, is thinner inside by the index squared.
    assert 0.9 < energy < 1.0
    assert 0.4 < radiance < 0.55


def test_the_snippet_of_the_reference_runs(capsys: pytest.CaptureFixture[str]) -> None:
    text = (REPOSITORY / "docs/reference.md").read_text(encoding="utf-8")
    (snippet,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(snippet, "reference.md", "exec"), {})
    lit, around = (
        [float(x) for x in re.findall(r"[\d.]+", line)] for line in capsys.readouterr().out.strip().splitlines()
    )
    assert min(lit) > 0.8 / 3.2  # more than a white diffuser's 0.8 / pi, by its highlights
    assert 0.5 < min(around) <= max(around) <= 1.0


def test_the_snippet_of_photometry_runs(capsys: pytest.CaptureFixture[str]) -> None:
    text = (REPOSITORY / "docs/photometry.md").read_text(encoding="utf-8")
    (snippet,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(snippet, "photometry.md", "exec"), {})
    numbers = [float(x) for x in re.findall(r"[\d.]+\d", capsys.readouterr().out)]
    # At observation 0.2 degrees and entrance -4: 0.1 D / 4 over 250, D = 1 / (pi a^2 (1 + (tan(0.1 deg) / a)^2)^2).
    assert round(numbers[0], 2) == round(0.1 / (4 * 3.14159 * 0.004**2 * (1 + (0.00174533 / 0.004) ** 2) ** 2) / 250, 2)
    assert round(numbers[-2], 2) == 6.89
    # Nearly all of the lobe's tenth comes back within 2 degrees: t^2 / (a^2 + t^2) = 0.950 with t = tan(1 deg).
    assert round(numbers[-1], 3) == 0.095


def test_the_snippet_of_prismatic_sheeting_runs() -> None:
    text = (REPOSITORY / "docs/prismatic.md").read_text(encoding="utf-8")
    lines = re.findall(r"^    (from mrm_mtlx.*|sheet = .*)$", text, re.MULTILINE)
    names: dict[str, Any] = {}
    exec("\n".join(lines), names)
    v = np.array([0.0, 0.0, 1.0])
    red, green, blue = names["sheet"].eval(v, v)
    assert red > green > blue > 0.0  # the tint of the snippet is orange


def test_the_snippet_of_the_node_library_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import mrm_mtlx as mrm

    mrm.install_library(tmp_path / "hosts")
    monkeypatch.chdir(tmp_path)
    text = (REPOSITORY / "libraries/pbrlib/README.md").read_text(encoding="utf-8")
    (snippet,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names: dict[str, object] = {}
    exec(compile("\n".join(line.removeprefix("  ") for line in snippet.splitlines()), "README.md", "exec"), names)
    library = names["library"]
    implementation = library.getNodeDef("ND_conductor_bsdf").getImplementation("genglsl")  # type: ignore[attr-defined]
    assert implementation.getName() == "IM_mrm_conductor_bsdf_genglsl"
    model = library.getNodeDef("ND_mrm_gltf_pbr_surfaceshader")  # type: ignore[attr-defined]
    assert model.getImplementation("").getName() == "NG_mrm_gltf_pbr_surfaceshader"


def test_the_page_of_rules_is_up_to_date() -> None:
    from mrm_mtlx.findings.catalogue import RULES
    from mrm_mtlx.findings.pages import markdown_page

    page = (REPOSITORY / "docs/rules.md").read_text(encoding="utf-8")
    assert page == markdown_page(list(RULES.values())) + "\n", "run: python -m tools.make_docs rules.md"


DECISIONS = sorted(p.relative_to(REPOSITORY).as_posix() for p in (REPOSITORY / "docs/decisions").glob("*.md"))


@pytest.mark.parametrize("page", [*PAGES, "docs/upstream-notes.md", *DECISIONS])
def test_links_of_the_pages_lead_somewhere(page: str) -> None:
    path = REPOSITORY / page
    links = re.findall(r"\]\((?!https?:)([^)#]+)", path.read_text(encoding="utf-8"))
    assert [link for link in links if not (path.parent / link).exists()] == []


def test_the_limits_of_the_page_are_those_of_the_code() -> None:
    from mrm_mtlx.documents import document_images, images
    from mrm_mtlx.engines.gl import program
    from mrm_mtlx.findings import finding as findings
    from mrm_mtlx.formats.gltf import container
    from mrm_mtlx.formats.gltf.importer import textures
    from mrm_mtlx.formats.usd.opening import composition_size, layers, stage_files
    from mrm_mtlx.measured import alta, any_format, table
    from mrm_mtlx.system import limits, process_limits
    from mrm_mtlx.validation import steps
    from mrm_mtlx.validation.checks import cycles

    mebi, gibi = 2**20, 2**30
    known = {
        "seconds for opening": (process_limits.TIME_LIMIT_S, 1),
        "private memory": (process_limits.MAXIMUM_MEMORY, gibi),
        "a document with its includes": (limits.MAXIMUM_DOCUMENT_BYTES, mebi),
        "files that a document includes": (limits.MAXIMUM_INCLUDES, 1),
        "nesting of XML": (limits.MAXIMUM_XML_DEPTH, 1),
        "nodes that a surface": (limits.MAXIMUM_NODES, 1),
        "nodes in a chain": (cycles.MAXIMUM_CHAIN, 1),
        "findings of one rule": (findings.MAXIMUM_OF_A_RULE, 1),
        "parts of the check of one document": (steps.MAXIMUM_LOST, 1),
        "side of an image": (images.MAXIMUM_SIDE, 1),
        "values of an image": (images.MAXIMUM_VALUES, 1),
        "bytes of an image file": (images.MAXIMUM_FILE_BYTES, mebi),
        "images of a surface together": (document_images.MAXIMUM_HELD_BYTES, mebi),
        "textures of a shader": (program.MAXIMUM_TEXTURE_BYTES, mebi),
        "layers of a stage together": (layers.MAXIMUM_STAGE_BYTES, mebi),
        "layers of a stage": (stage_files.MAXIMUM_LAYERS, 1),
        "prims that a stage composes": (composition_size.MAXIMUM_PRIMS, 1),
        "JSON of a glTF": (container.MAXIMUM_JSON_BYTES, mebi),
        "pictures unpacked": (textures.MAXIMUM_UNPACKED_BYTES, mebi),
        "a file of measured data": (alta.MAXIMUM_BYTES, mebi),
        "samples of measured data": (table.MAXIMUM_SAMPLES, 1),
    }
    assert (any_format.MAXIMUM_BYTES, table.MAXIMUM_BYTES) == (alta.MAXIMUM_BYTES,) * 2
    assert alta.MAXIMUM_SAMPLES == table.MAXIMUM_SAMPLES
    text = (REPOSITORY / "docs/reliability.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([^|]+) \| ([\d,]+)(?: [GM]iB)? \|$", text.partition("## How it is tried")[0], re.MULTILINE)
    assert len(rows) == len(known)
    for what, value in rows:
        named = max((name for name in known if what.startswith(name)), key=len)
        number, unit = known.pop(named)
        assert int(value.replace(",", "")) * unit == number, what


def test_the_page_of_reliability_names_every_test_of_hostile_documents() -> None:
    text = (REPOSITORY / "docs/reliability.md").read_text(encoding="utf-8")
    # Those of the tools themselves, and of what the tests share, are no finds.
    found = {path.name for path in (REPOSITORY / "tests/hostile").glob("test_*.py")}
    tools = {"test_fuzz.py", "test_trace.py", "test_scaffolding.py"}
    assert set(re.findall(r"`(test_\w+\.py)`", text)) == found - tools
