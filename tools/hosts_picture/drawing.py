"""A stage with a row of spheres, drawn by the Storm of a Blender that has the library which was installed for it."""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import mrm_mtlx as mrm
from mrm_mtlx.engines import storm

PROGRAM = Path(__file__).with_name("draw_in_host.py")
SERVER = Path(storm.__file__).with_name("storm_server.py")
# What is asked of an interpreter: its Blender, and where that lies.
_ASK = (
    "import importlib.util as u; folder = u.find_spec('bpy').submodule_search_locations[0]; "
    "import bpy; print('', *bpy.app.version[:2], folder, sep='\\n')"
)
# Seconds: the first shaders of a surface model take ten, and three times that on a busy machine.
_LONGEST_S = 300.0

# The materials, by what is written under them: a metal by OpenPBR and by its own node, ordinary and turned back.
_METAL = (
    '<input name="base_color" type="color3" value="0.7, 0.3, 0.1" />'
    '<input name="base_metalness" type="float" value="1" /><input name="specular_roughness" type="float" value="0.4" />'
)
_OPEN_PBR = '<open_pbr_surface name="{name}" type="surfaceshader"{definition}>{inputs}</open_pbr_surface>'
_AMOUNT = '<input name="specular_retroreflectivity" type="float" value="1" />'
_CONDUCTOR = (
    '<conductor_bsdf name="b_{name}" type="BSDF"><input name="roughness" type="vector2" value="0.16, 0.16" />{inputs}'
    '</conductor_bsdf><surface name="{name}" type="surfaceshader">'
    '<input name="bsdf" type="BSDF" nodename="b_{name}" /></surface>'
)
_FLAG = '<input name="retroreflective" type="boolean" value="true" />'
SURFACES = {
    "OpenPBR": _OPEN_PBR.format(name="ordinary_model", definition="", inputs=_METAL),
    "OpenPBR with the amount": _OPEN_PBR.format(
        name="turned_model", definition=' nodedef="ND_mrm_open_pbr_surface_surfaceshader"', inputs=_METAL + _AMOUNT
    ),
    "conductor_bsdf": _CONDUCTOR.format(name="ordinary_node", inputs=""),
    "conductor_bsdf with the flag": _CONDUCTOR.format(name="turned_node", inputs=_FLAG),
}
NAMES = ("ordinary_model", "turned_model", "ordinary_node", "turned_node")
_STEP, _DISTANCE, _FOCAL, _APERTURE = 2.2, 20.0, 45.0, 20.0
# Where their spheres are in the picture, as shares of its width.
CENTRES = tuple(0.5 + _STEP * (i - 1.5) / _DISTANCE * _FOCAL / _APERTURE for i in range(len(NAMES)))

_MATERIAL = (
    '<surfacematerial name="M_{name}" type="material">'
    '<input name="surfaceshader" type="surfaceshader" nodename="{name}" /></surfacematerial>'
)
_SPHERE = """
def "M_{name}" (references = @./{file}@<{root}/M_{name}>) {{ }}
def Sphere "sphere_{name}" (prepend apiSchemas = ["MaterialBindingAPI"])
{{
    rel material:binding = </M_{name}>
    double3 xformOp:translate = ({x}, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
"""
# The light is a little above the camera: what is turned back is lit all over, and what is not has a highlight.
_STAGE = """#usda 1.0
(
    upAxis = "Y"
)
{spheres}
def Camera "camera"
{{
    float focalLength = {focal}
    float horizontalAperture = {aperture}
    float verticalAperture = 6
    float2 clippingRange = (1, 100)
    double3 xformOp:translate = ({centre}, 0, {distance})
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def SphereLight "light"
{{
    float inputs:intensity = 400
    float inputs:radius = 0.2
    double3 xformOp:translate = ({centre}, 1.2, {distance})
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
"""


@dataclass(frozen=True)
class Blender:
    """A Blender as a module.

    Attributes
    ----------
    python
        Its interpreter.
    release
        Such as "5.0".
    folder
        Where it lies.
    """

    python: str
    release: str
    folder: str

    @property
    def host(self) -> str:
        """Its name in the table of hosts."""
        return f"blender-{self.release}"


def blender(python: str) -> Blender:
    """The Blender of an interpreter."""
    done = subprocess.run([python, "-c", _ASK], capture_output=True, text=True, check=True)
    major, minor, folder = done.stdout.strip().splitlines()[-3:]
    return Blender(python, f"{major}.{minor}", folder)


def write_stage(folder: Path, file: str) -> Path:
    """A stage with a sphere of each material; they are those of spheres.mtlx, or of spheres.usda that is made of it."""
    document = folder / "spheres.mtlx"
    surfaces = "".join([*SURFACES.values(), *(_MATERIAL.format(name=name) for name in NAMES)])
    document.write_text(f'<?xml version="1.0"?>\n<materialx version="1.39">{surfaces}</materialx>\n', encoding="utf-8")
    root = "/MaterialX/Materials"
    if file.endswith(".usda"):
        mrm.convert(document, folder / file, force=True)
        root = "/Materials"
    spheres = [_SPHERE.format(name=name, file=file, root=root, x=_STEP * i) for i, name in enumerate(NAMES)]
    stage = folder / f"stage_{Path(file).suffix[1:]}.usda"
    camera = {"focal": _FOCAL, "aperture": _APERTURE, "distance": _DISTANCE, "centre": 1.5 * _STEP}
    stage.write_text(_STAGE.format(spheres="".join(spheres), **camera), encoding="utf-8")
    return stage


def draw(host: Blender, library: mrm.InstalledLibrary | None, stage: Path, picture: Path) -> list[str]:
    """Draw a stage in a Blender with an installed library, or none; the fragment shaders that Storm compiled."""
    variables = {key: value for key, value in os.environ.items() if not key.startswith(("PXR_MTLX", "PYTHONPATH"))}
    if library is not None:
        variables[library.variable] = library.value
    shaders = picture.with_suffix(".shaders")
    shaders.mkdir()
    subprocess.run(
        [host.python, str(PROGRAM), str(SERVER), str(stage.resolve()), str(picture.resolve())],
        env={**variables, "TF_DEBUG": "HDST_DUMP_SHADER_SOURCEFILE"}, cwd=shaders,
        capture_output=True, check=True, timeout=_LONGEST_S,
    )  # fmt: skip
    return [path.read_text(encoding="utf-8", errors="replace") for path in sorted(shaders.glob("*FRAGMENT*"))]
