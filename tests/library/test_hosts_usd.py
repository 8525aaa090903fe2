"""The node library in hosts of OpenUSD, which are asked in their own interpreters: Blender's, and usd-exchange."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import mrm_mtlx as mrm
from mrm_mtlx.engines.osl import availability as osl_availability
from mrm_mtlx.library.hosts import HOSTS, PLUGIN_VARIABLE, STANDARD_VARIABLE
from mrm_mtlx.library.surface_models import MICROFACET_NODES, SURFACE_MODELS

# Opens stages; of each shader its definition and the values that it has, and of each definition the file it is from.
OPEN = """
import json, sys
try:
    import bpy
    bpy.utils.expose_bundled_modules()
except ImportError:
    pass
from pxr import Sdr, Usd, UsdShade
registry = Sdr.Registry()
find = getattr(registry, "GetShaderNodeByIdentifier", None) or registry.GetNodeByIdentifier
shaders, files = {}, {}
for name in sys.argv[1:]:
    stage = Usd.Stage.Open(name)
    for prim in stage.Traverse():
        if prim.IsA(UsdShade.Shader) and prim.GetParent().GetParent().GetName() != "MaterialX":
            shader = UsdShade.Shader(prim)
            # UsdMtlx gives the inputs of a surface to its material: the value is where the connection leads.
            sources = {i.GetBaseName(): i.GetValueProducingAttributes() for i in shader.GetInputs()}
            values = {name: made[0].Get() for name, made in sources.items() if made and made[0].HasAuthoredValue()}
            identifier = shader.GetIdAttr().Get()
            shaders.setdefault(prim.GetName(), [identifier, values])
            node = find(identifier) if identifier else None
            files[identifier] = node.GetResolvedDefinitionURI() if node else ""
print("\\n" + json.dumps([shaders, files], default=str))
"""

FLAG = '<input name="retroreflective" type="boolean" value="{}"/>'
CASES = {"on": True, "off": False, "unset": None}


def document(nodes: tuple[str, ...] = MICROFACET_NODES) -> str:
    """Each microfacet node with the flag true, false and unset; and the surface models with and without our input."""
    parts = []
    for node in nodes:
        for case, value in CASES.items():
            name, given = f"{node}_{case}", "" if value is None else FLAG.format(str(value).lower())
            parts.append(
                f'<{node} name="{name}" type="BSDF">{given}</{node}>'
                f'<surface name="s_{name}" type="surfaceshader">'
                f'<input name="bsdf" type="BSDF" nodename="{name}"/></surface>{material(f"s_{name}")}'
            )
    for model in SURFACE_MODELS:
        amount = f'<input name="{model.amount}" type="float" value="0.75"/>'
        parts.append(f'<{model.node} name="{model.node}" type="surfaceshader"/>{material(model.node)}')
        parts.append(
            f'<{model.node} name="mrm_{model.node}" type="surfaceshader" nodedef="{model.definition}">{amount}'
            f"</{model.node}>{material(f'mrm_{model.node}')}"
        )
    return f'<?xml version="1.0"?>\n<materialx version="1.39">{"".join(parts)}</materialx>\n'


def material(surface: str) -> str:
    return (
        f'<surfacematerial name="M_{surface}" type="material">'
        f'<input name="surfaceshader" type="surfaceshader" nodename="{surface}"/></surfacematerial>'
    )


@pytest.fixture
def stages(tmp_path):
    """The document, and what `mrm convert` makes of it."""
    written = tmp_path / "flags.mtlx"
    written.write_text(document(), encoding="utf-8")
    assert mrm.convert(written, tmp_path / "flags.usda").complete
    return {"mtlx": written, "usda": tmp_path / "flags.usda"}


def opened(python: Path | str, stage: Path, **variables: str) -> tuple[dict, dict, str]:
    """Shaders of a stage, the files of their definitions, and warnings, as a host sees them."""
    others = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", PLUGIN_VARIABLE, STANDARD_VARIABLE)}
    done = subprocess.run(
        [str(python), "-c", OPEN, str(stage)],
        capture_output=True, text=True, check=False, env={**others, **variables}, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    shaders, files = json.loads(done.stdout.splitlines()[-1])
    return shaders, files, done.stderr


def check(shaders: dict, files: dict, folder: Path) -> None:
    """Every value is that of the document, every definition that should be is ours, and the others are not."""
    for node in MICROFACET_NODES:
        for case, value in CASES.items():
            identifier, values = shaders[f"{node}_{case}"]
            assert values.get("retroreflective") is value
            assert identifier in (f"ND_{node}", f"ND_mrm_flagged_{node}")
            assert Path(files[identifier]).is_relative_to(folder)
    for model in SURFACE_MODELS:
        identifier, values = shaders[f"mrm_{model.node}"]
        assert (identifier, values[model.amount]) == (model.definition, 0.75)
        assert Path(files[identifier]).is_relative_to(folder)
        stock, _ = shaders[model.node]
        assert stock == f"ND_{model.node}_surfaceshader"
        assert not Path(files[stock]).is_relative_to(folder)


@pytest.mark.versions
@pytest.mark.parametrize("form", ["mtlx", "usda"])
def test_usd_exchange_opens_documents_with_their_values_and_our_definitions(usd_exchange, stages, tmp_path, form):
    installed = mrm.install_library(tmp_path / "hosts", host="usd-exchange")
    shaders, files, said = opened(usd_exchange, stages[form], **{installed.variable: installed.value})
    check(shaders, files, tmp_path / "hosts")
    assert said == ""


@pytest.mark.versions
@pytest.mark.parametrize("form", ["mtlx", "usda"])
def test_openusd_with_its_standard_library_takes_ours_from_the_variable_for_plugins(
    usd_exchange, stages, tmp_path, form
):
    installed = mrm.install_library(tmp_path / "hosts", host="usd-26.08")
    standard = mrm.install_library(tmp_path / "other", host="usd-exchange").value.split(os.pathsep)[1]
    variables = {installed.variable: installed.value, STANDARD_VARIABLE: standard}
    shaders, files, said = opened(usd_exchange, stages[form], **variables)
    check(shaders, files, tmp_path / "hosts")
    assert said == ""


@pytest.mark.versions
def test_without_our_folder_the_definitions_are_not_ours(usd_exchange, stages, tmp_path):
    standard = mrm.install_library(tmp_path / "other", host="usd-exchange").value.split(os.pathsep)[1]
    shaders, files, _ = opened(usd_exchange, stages["usda"], **{STANDARD_VARIABLE: standard})
    with pytest.raises(AssertionError):
        check(shaders, files, tmp_path / "other")


@pytest.mark.versions
def test_the_doctor_sees_that_usd_exchange_finds_the_library(usd_exchange, tmp_path, monkeypatch):
    installed = mrm.install_library(tmp_path / "hosts", host="usd-exchange")
    monkeypatch.delenv(installed.variable, raising=False)
    before = mrm.check_host("usd-exchange", path=tmp_path / "hosts", ask=usd_exchange)
    assert {c.name for c in before.checks if c.ok is False} == {"variable", "nodes", "model"}
    monkeypatch.setenv(installed.variable, installed.value)
    assert "OpenUSD 26.08 with MaterialX 1.39.5" in str(after := mrm.check_host("usd-exchange", ask=usd_exchange))
    assert all(check.ok for check in after.checks)
    monkeypatch.setenv(installed.variable, os.pathsep.join(reversed(installed.value.split(os.pathsep))))
    swapped = mrm.check_host("usd-exchange", ask=usd_exchange)
    assert {c.name for c in swapped.checks if c.ok is False} == {"variable", "nodes"}


# Blender's OpenUSD: a MaterialX without the flag.


@pytest.fixture(scope="module")
def blender() -> tuple[str, str]:
    """An interpreter that has Blender as a module, and the host that it is."""
    state = osl_availability()
    if not state.available:
        pytest.skip(f"OSL runtime not available: {state.detail}; {state.remedy}")
    python = os.environ.get("MRM_OSL_PYTHON") or sys.executable
    code = "import bpy; print(*bpy.app.version[:2], sep='.')"
    version = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.split()[-1]
    if f"blender-{version}" not in HOSTS:
        pytest.skip(f"there is no host blender-{version}")
    return python, f"blender-{version}"


@pytest.fixture(scope="module")
def blender_folder(blender) -> str:
    """Where that Blender is."""
    code = "import importlib.util as u; print(u.find_spec('bpy').submodule_search_locations[0])"
    return subprocess.run([blender[0], "-c", code], capture_output=True, text=True, check=True).stdout.strip()


@pytest.fixture(scope="module")
def in_blender(blender, blender_folder, tmp_path_factory):
    """The library installed for that Blender, from its own standard library."""
    return mrm.install_library(tmp_path_factory.mktemp("hosts"), host=blender[1], stdlib=blender_folder)


@pytest.mark.parametrize("form", ["mtlx", "usda"])
def test_blender_opens_documents_with_their_values_and_our_definitions(blender, in_blender, stages, form):
    shaders, files, said = opened(blender[0], stages[form], **{in_blender.variable: in_blender.value})
    check(shaders, files, in_blender.folder)
    assert "Unable to find the nodedef" not in said


def test_without_other_names_for_the_flag_blender_would_drop_the_node(blender, in_blender, stages, tmp_path):
    for path in in_blender.files:
        if path.name != "mrm_flagged_defs.mtlx":
            target = tmp_path / "hosts" / path.relative_to(in_blender.folder)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(path.read_bytes())
    shaders, _, said = opened(blender[0], stages["mtlx"], **{in_blender.variable: str(tmp_path / "hosts")})
    assert "Unable to find the nodedef for 'conductor_bsdf_on' node" in said
    assert shaders["conductor_bsdf_on"][0] is None
    with pytest.raises(AssertionError):
        check(shaders, {}, tmp_path / "hosts")


def test_the_doctor_sees_whether_blender_finds_the_library(blender, in_blender, monkeypatch):
    python, host = blender
    monkeypatch.delenv(in_blender.variable, raising=False)
    before = mrm.check_host(host, path=in_blender.folder, ask=python)
    assert {c.name for c in before.checks if c.ok is False} == {"variable", "nodes", "model"}
    monkeypatch.setenv(in_blender.variable, in_blender.value)
    after = mrm.check_host(host, ask=python)
    assert all(check.ok for check in after.checks), str(after)


def test_the_doctor_asks_blender_for_the_nodes_of_the_portable_form(
    blender, in_blender, blender_folder, monkeypatch, tmp_path
):
    python, host = blender
    installed = mrm.install_library(tmp_path, host=host, stdlib=blender_folder, form="portable")
    monkeypatch.setenv(installed.variable, installed.value)
    report = mrm.check_host(host, ask=python)
    assert all(check.ok for check in report.checks), str(report)
    assert "ND_mrm_portable_conductor_bsdf is ours, with retroreflective" in str(report)
    (tmp_path / "mrm" / "mrm_flag_ng.mtlx").unlink()  # not of the portable form any more: asked for the other's node
    damaged = mrm.check_host(host, ask=python)
    assert {c.name for c in damaged.checks if c.ok is False} == {"library", "nodes"}


def test_the_doctor_sees_models_for_hosts_that_choose_by_inputs(
    blender, in_blender, blender_folder, monkeypatch, tmp_path
):
    python, host = blender
    plain = mrm.install_library(tmp_path, materialx=in_blender.version, stdlib=blender_folder)
    monkeypatch.setenv(in_blender.variable, str(plain.folder))
    report = mrm.check_host(host, ask=python)
    assert {c.name for c in report.checks if c.ok is False} == {"models", "stock"}
