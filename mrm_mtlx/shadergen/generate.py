"""From a renderable element to source code, through MaterialX's generators."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import MaterialX as mx
from MaterialX import PyMaterialXGenShader as mx_gen

from mrm_mtlx.library import dialects
from mrm_mtlx.shadergen.coverage import of_two_transforms, without_code
from mrm_mtlx.shadergen.names import shader_name
from mrm_mtlx.shadergen.targets import TARGETS, Target
from mrm_mtlx.system.console import silenced

if TYPE_CHECKING:
    from mrm_mtlx.library import DataLibrary

# Numbers by which the generated light loop tells the light types apart.
LIGHT_TYPES = {"directional_light": 1, "point_light": 2}


class OslMode(StrEnum):
    """The ways in which the node library makes a retroreflective lobe in OSL, see docs/osl.md.

    `ALIGNED`: of a standard closure, in any renderer, approximate. `CYCLES`: through a ray portal, exact, in Cycles on
    the CPU alone. `KEYWORD`: of a closure with the keyword argument "retroreflective", in a renderer that knows it.
    """

    ALIGNED = "aligned"
    CYCLES = "cycles"
    KEYWORD = "keyword"

    @property
    def definition(self) -> str:
        """The line that chooses it at the head of a source; "" for the default."""
        return "" if self is OslMode.ALIGNED else f"#define MRM_OSL_MODE {_OSL_NUMBERS[self]}\n"


# Numbers of the ways in the sources of the node library, see lib/mrm_retroreflection.osl.
_OSL_NUMBERS = {OslMode.ALIGNED: 1, OslMode.CYCLES: 2, OslMode.KEYWORD: 3}


class GenerationError(Exception):
    """MaterialX could not generate a shader; the message is MaterialX's own."""


class MissingCodeError(GenerationError):
    """The libraries define nodes of the element for other targets alone; the message names them."""


@dataclass(frozen=True)
class Port:
    """A variable of the generated code: a uniform or an interpolated input.

    `path` is the document element the value came from, or "" for the generator's own variables; `value` is a plain
    Python value (bool, int, float, str or a tuple of floats), or None where the host is to supply it; of a type with
    members, its text.
    """

    variable: str
    type: str
    value: Any
    path: str


@dataclass(frozen=True)
class Shader:
    """Generated source code and its interface.

    `sources` maps a stage ("vertex", "pixel") to its code; `uniforms` are those of the pixel stage; `inputs` are the
    pixel stage's interpolated inputs, in the block instance `input_block` (empty where the target has no blocks).
    """

    target: str
    name: str
    sources: dict[str, str]
    uniforms: tuple[Port, ...]
    inputs: tuple[Port, ...]
    input_block: str

    @property
    def files(self) -> dict[str, str]:
        """Names of files that uniforms have as values, by variable."""
        return {port.variable: str(port.value) for port in self.uniforms if port.type == "filename" and port.value}


def renderable_elements(document: mx.Document) -> list[Any]:
    """Materials, and outputs of shader type that no material uses; what MaterialX calls renderable, in file order."""
    return list(mx_gen.findRenderableElements(document))


def generate(element: Any, target_name: str, library: DataLibrary, osl_mode: OslMode = OslMode.ALIGNED) -> Shader:
    """Generate the shader of a renderable element for a target; `osl_mode` is for OSL alone.

    Directional and point lights are bound, one light at most at a time, so that the hardware targets have a light loop.
    Environment lighting uses filtered importance sampling: with method NONE, MaterialX 1.39.5 emits GLSL that does not
    compile (u_refractionTwoSided is undeclared).

    Raises
    ------
    MissingCodeError
        If the libraries have no code for the target of nodes that they define.
    GenerationError
        If MaterialX refuses; the message is its own.
    """
    target = TARGETS[target_name]
    generator = target.create()
    context = _context(generator, target, library, element.getDocument())
    dying = of_two_transforms(element, generator.getTarget())
    if dying:
        msg = f"MaterialX dies of two files in a colour space on one node; transform what '{dying}' gives instead"
        raise GenerationError(msg)
    name = shader_name(element.getName(), target_name)
    try:
        with silenced():  # generators print warnings; what matters of them is a finding of validation
            shader = generator.generate(name, element, context)
    except Exception as error:  # MaterialX throws several unrelated types
        missing = without_code(element, generator.getTarget())
        if missing:
            msg = f"MaterialX has no code of {', '.join(missing)} for this target"
            raise MissingCodeError(msg) from error
        raise GenerationError(str(error)) from error
    if shader is None:
        msg = "MaterialX returned no shader and gave no reason"
        raise GenerationError(msg)
    try:
        sources = {stage: str(shader.getSourceCode(stage)) for stage in target.suffixes}
    except UnicodeDecodeError as error:
        msg = "the code is not UTF-8; a file that an implementation names is no source"
        raise GenerationError(msg) from error
    if not sources["pixel"].strip():
        msg = "MaterialX returned an empty shader"
        raise GenerationError(msg)
    if target.closures:
        sources["pixel"] = osl_mode.definition + sources["pixel"]
    stage = shader.getStage("pixel")
    return Shader(target.name, name, sources, _uniforms(stage), *_inputs(stage, generator, target))


def _context(generator: Any, target: Target, library: DataLibrary, document: mx.Document) -> Any:
    context = mx_gen.GenContext(generator)
    context.registerSourceCodeSearchPath(library.search_path)
    if dialects.module().type_registration:
        getattr(generator, dialects.module().type_registration)(document)  # and of its data library
    colours = mx_gen.DefaultColorManagementSystem.create(generator.getTarget())
    colours.loadLibrary(library.document)
    generator.setColorManagementSystem(colours)
    generator.setUnitSystem(_units(generator, library.document))
    options = context.getOptions()
    options.targetDistanceUnit = "meter"
    options.targetColorSpaceOverride = "lin_rec709"
    if target.hardware:
        options.hwSpecularEnvironmentMethod = mx_gen.HwSpecularEnvironmentMethod.SPECULAR_ENVIRONMENT_FIS
        options.hwMaxActiveLightSources = 1
        for light, number in LIGHT_TYPES.items():
            definition = library.document.getNodeDef(f"ND_{light}")
            mx_gen.HwShaderGenerator.bindLightShader(definition, number, context)
    return context


def _units(generator: Any, library: mx.Document) -> Any:
    units = mx_gen.UnitSystem.create(generator.getTarget())
    registry = mx.UnitConverterRegistry.create()
    for kind in ("distance", "angle"):
        definition = library.getUnitTypeDef(kind)
        registry.addUnitConverter(definition, mx.LinearUnitConverter.create(definition))
    units.loadLibrary(library)
    units.setUnitConverterRegistry(registry)
    return units


def _uniforms(stage: Any) -> tuple[Port, ...]:
    blocks = stage.getUniformBlocks()
    return tuple(_port(port) for name in sorted(blocks) if name != "LightData" for port in blocks[name])


def _inputs(stage: Any, generator: Any, target: Target) -> tuple[tuple[Port, ...], str]:
    if not target.hardware:
        return (), ""
    ports = tuple(_port(port) for block in stage.getInputBlocks().values() for port in block)
    # ESSL has no interface blocks: each input is a variable of its own.
    return ports, "" if generator.getVersion().endswith("es") else "vd"


def _port(port: Any) -> Port:
    value = port.getValue()
    if value is not None:  # one of a type with members has nothing but its text
        value = plain_value(value.getData()) if hasattr(value, "getData") else str(value.getValueString())
    return Port(str(port.getVariable()), str(port.getType().getName()), value, str(port.getPath()))


def plain_value(value: Any) -> Any:
    """MaterialX vectors, colours and matrices as flat tuples of floats; other values as they are."""
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, mx.Matrix33 | mx.Matrix44):
        size = range(value.numRows())
        return tuple(float(value[row, column]) for row in size for column in size)
    return tuple(float(x) for x in value.asTuple())
