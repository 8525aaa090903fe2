"""A generated surface shader, linked and ready to be drawn over arrays of samples."""

from __future__ import annotations

import contextlib
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.document_images import ImagesTooLargeError, too_large
from mrm_mtlx.engines.base import Capabilities, CompileError, CompileMessage, DirectionalLight, PointLight, Program
from mrm_mtlx.engines.gl.context import context, free_textures, parking_target
from mrm_mtlx.engines.gl.image_calls import samplings
from mrm_mtlx.engines.gl.textures import stand_in, texture_bytes, upload
from mrm_mtlx.engines.gl.vertex_stage import COMPONENTS, vertex_source
from mrm_mtlx.library import dialects
from mrm_mtlx.shadergen.generate import LIGHT_TYPES
from mrm_mtlx.system.text import text_lines

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from mrm_mtlx.engines.base import Lighting, SurfacePoints
    from mrm_mtlx.shadergen import Shader

# Width of the float image that holds one sample per pixel, and its greatest height: OpenGL 4.3 has at least 16,384.
_ROW, _ROWS = 2048, 16384

# Largest textures of one shader together, as a driver without a memory of its own holds them: what is stored in whole
# numbers or float16 takes two bytes a value, no more values than are read, and four for three: of ten images of
# 4096 x 4096, four may be colours. With the images that are held, what evaluating and drawing take beside it stays
# within a process of 2 GiB.
MAXIMUM_TEXTURE_BYTES = 704 * 2**20

# How generated code names geometric properties.
_PROPERTY = "i_geomprop_"

# Names of the matrices between world and object space, which are one and the same here.
_SPACES = "u_world"

# The standard environment orientation of MaterialX's viewers would turn images by half a turn; ours are as they lie.
_IDENTITY = tuple(float(row == column) for row in range(4) for column in range(4))


class SurfaceProgram(Program):
    """A shader in the driver.

    Parameters
    ----------
    shader
        A generated `glsl` or `essl` shader; its pixel stage runs unmodified.
    textures
        Pixels, shape (height, width, channels), row 0 at the top, for uniforms of image files, by variable name. In
        the place of missing ones is a pixel of the node's default, as MaterialX's viewers have it; a default that is
        computed is taken as zero.

    Raises
    ------
    CompileError
        If the driver refuses the source.
    ImagesTooLargeError
        If its textures would take more than `MAXIMUM_TEXTURE_BYTES`.
    RuntimeError
        If there is no OpenGL here.
    """

    capabilities = Capabilities(
        runs=True,
        textures=True,
        lights=frozenset({DirectionalLight, PointLight}),
        environment=True,
        largest_batch=_ROW * _ROWS,
    )

    def __init__(self, shader: Shader, textures: Mapping[str, NDArray[np.floating]] | None = None) -> None:
        import moderngl

        self._context = context()
        self._shader = shader
        self._textures: dict[str, Any] = {}
        sampled = samplings(shader)
        images = {name: (textures or {}).get(name, stand_in(sampling)) for name, sampling in sampled.items()}
        size = sum(texture_bytes(pixels, sampled[name]) for name, pixels in images.items())
        if size > MAXIMUM_TEXTURE_BYTES:
            raise ImagesTooLargeError(too_large("images that take, as textures,", size, MAXIMUM_TEXTURE_BYTES))
        self._document_values = {port.variable: port.value for port in shader.uniforms if port.value is not None}
        try:
            self._program = self._context.program(
                vertex_shader=vertex_source(shader), fragment_shader=shader.sources["pixel"]
            )
        except moderngl.Error as error:
            # The log names lines of the stage that failed; the vertex stage is ours and has no line of the document.
            source = "" if "vertex_shader" in str(error) else shader.sources["pixel"]
            raise CompileError(_parse_log(str(error), source)) from error
        self._members = {name: self._program[name] for name in self._program}
        for name, pixels in images.items():
            # Each sample is a point of its own and has no neighbours, so that level 0 alone is ever read.
            self._textures[name] = upload(self._context, pixels, sampled[name], mipmaps=False)
        for port in shader.uniforms:
            if port.type != "filename" and port.value is not None and not isinstance(port.value, str):
                self._set(port.variable, port.value)
            elif port.variable.startswith(_SPACES):
                self._set(port.variable, _IDENTITY)
        self._set("u_frame", 1.0)  # the specification's default, for hosts that have no frames

    def release(self) -> None:
        """Free the program and its textures in the driver."""
        self._program.release()
        for texture in self._textures.values():
            texture.release()
        if self._textures:
            free_textures()
        self._textures.clear()

    @property
    def input_names(self) -> tuple[str, ...]:
        """Variables that vary per sample and that `draw` wants values for."""
        return tuple(port.variable for port in self._shader.inputs)

    def surface_inputs(
        self,
        position: NDArray[np.floating],
        normal: NDArray[np.floating],
        tangent: NDArray[np.floating],
        texcoord: NDArray[np.floating],
        properties: Mapping[str, NDArray[np.floating]] | None = None,
    ) -> dict[str, NDArray[np.floating]]:
        """Inputs for `draw` from points of a surface, under the names that MaterialX gives them.

        World and object space are the same; every set of texture coordinates is `texcoord` (a third coordinate is 0),
        every vertex colour white; geometric properties that are not given are zero. Shapes (samples, 3), texcoord
        (samples, 2).
        """
        count = len(position)
        frame = {"position": position, "normal": normal, "tangent": tangent, "bitangent": np.cross(normal, tangent)}
        inputs: dict[str, NDArray[np.floating]] = {
            f"{name}{space}": value for name, value in frame.items() for space in ("World", "Object")
        }
        for port in self._shader.inputs:
            if port.variable.startswith("texcoord_"):
                further = np.zeros((count, COMPONENTS[port.type] - 2))
                inputs[port.variable] = np.concatenate([texcoord, further], axis=1)
            elif port.variable.startswith("color_"):
                inputs[port.variable] = np.ones((count, COMPONENTS[port.type]))
            elif port.variable.startswith(_PROPERTY):
                empty = np.zeros((count, COMPONENTS[port.type]))
                inputs[port.variable] = (properties or {}).get(port.variable.removeprefix(_PROPERTY), empty)
        return inputs

    def evaluate(
        self, points: SurfacePoints, lighting: Lighting, uniforms: Mapping[str, Any] | None = None
    ) -> NDArray[np.float32]:
        """As `Program.evaluate`: the shader's inputs come from the points."""
        inputs = self.surface_inputs(points.position, points.normal, points.tangent, points.texcoord, points.properties)
        return self.draw(inputs, lighting, uniforms)

    def draw(
        self,
        inputs: Mapping[str, ArrayLike],
        lighting: Lighting,
        uniforms: Mapping[str, Any] | None = None,
    ) -> NDArray[np.float32]:
        """Run the shader once per sample.

        Parameters
        ----------
        inputs
            Per-sample values by variable name (`positionWorld`, `normalWorld`, ...), shape (samples, components) or
            (samples,) for scalars; more names than the shader uses are allowed. Their length is the number of samples.
        lighting
            Light, environment and eye.
        uniforms
            Values that replace those of the document in this draw, by variable name.

        Returns
        -------
        ndarray, shape (samples, 4), float32
            The output colour, unclamped; the fourth channel is what the shader writes there.

        Raises
        ------
        KeyError
            If the shader reads an input that is not given, or a uniform is named that it does not have.
        """
        missing = [name for name in self.input_names if name not in inputs]
        if missing:
            msg = f"the shader reads {', '.join(missing)}, which the caller did not give"
            raise KeyError(msg)
        known = {port.variable for port in self._shader.uniforms}
        unknown = sorted(set(uniforms or {}) - known)
        if unknown:
            msg = f"the shader has no uniform {', '.join(unknown)}"
            raise KeyError(msg)
        with contextlib.ExitStack() as stack:
            for name, value in (uniforms or {}).items():
                self._set(name, value)
                stack.callback(self._set, name, self._document_values.get(name, value))
            self._set_lighting(lighting, stack)
            return self._draw_points(inputs, stack)

    def _draw_points(self, inputs: Mapping[str, ArrayLike], stack: contextlib.ExitStack) -> NDArray[np.float32]:
        count = len(np.asarray(next(iter(inputs.values()), ())))
        if count == 0:
            return np.zeros((0, 4), dtype=np.float32)
        width = min(_ROW, max(count, 1))
        height = max(-(-count // width), 1)
        self._set("mrm_size", (width, height))
        bindings = []
        for port in self._shader.inputs:
            if f"mrm_{port.variable}" not in self._members:  # the driver dropped an input that nothing depends on
                continue
            kind = "i4" if port.type == "integer" else "f4"
            data = np.ascontiguousarray(inputs[port.variable], dtype=kind).reshape(count, COMPONENTS[port.type])
            buffer = self._context.buffer(data.tobytes())
            stack.callback(buffer.release)
            bindings.append((buffer, f"{COMPONENTS[port.type]}{'i' if kind == 'i4' else 'f'}", f"mrm_{port.variable}"))
        vertices = self._context.vertex_array(self._program, bindings)
        stack.callback(vertices.release)
        image = self._context.texture((width, height), 4, dtype="f4")
        stack.callback(image.release)
        target = self._context.framebuffer(color_attachments=[image])
        stack.callback(target.release)
        stack.callback(parking_target().use)  # runs before the release
        target.use()
        target.clear(0.0, 0.0, 0.0, 0.0)
        vertices.render(self._context.POINTS, vertices=count)
        pixels = np.frombuffer(target.read(components=4, dtype="f4"), dtype=np.float32)
        error = self._context.error
        if error != "GL_NO_ERROR":
            msg = f"the driver reported {error} while drawing"
            raise RuntimeError(msg)
        return pixels.reshape(-1, 4)[:count].copy()

    def _set_lighting(self, lighting: Lighting, stack: contextlib.ExitStack) -> None:
        self._set("u_viewPosition", lighting.view_position)
        self._set("u_envMatrix", _IDENTITY)
        self._set("u_envLightIntensity", 1.0)
        self._set("u_refractionTwoSided", False)
        self._set_light(lighting)
        environment = lighting.environment
        black = np.zeros((1, 1, 3), dtype=np.float32)
        images = {
            "u_envRadiance": black if environment is None else environment.radiance,
            "u_envIrradiance": black if environment is None else environment.irradiance,
        }
        bound = dict(self._textures)
        for name, pixels in images.items():
            # MaterialX's latitude-longitude lookup has row 0 at +y, as the image file has: no flip.
            bound[name] = upload(self._context, pixels[::-1])
            # At the seam the longitude wraps, at the poles the latitude ends.
            bound[name].repeat_y = False
            stack.callback(bound[name].release)
        mips = 1 + int(np.log2(max(images["u_envRadiance"].shape[:2])))
        self._set("u_envRadianceMips", mips)
        least = dialects.installed().least_environment_samples
        self._set("u_envRadianceSamples", least if environment is None else environment.samples)
        for unit, (name, texture) in enumerate(sorted(bound.items())):
            texture.use(location=unit)
            self._set(name, unit)

    def _set_light(self, lighting: Lighting) -> None:
        self._set("u_numActiveLightSources", 0 if lighting.light is None else 1)
        field = "u_lightData[0].{}".format
        self._set(field("intensity"), 1.0)
        match lighting.light:
            case DirectionalLight(to_light, irradiance):
                self._set(field("type"), LIGHT_TYPES["directional_light"])
                self._set(field("direction"), tuple(-float(x) for x in to_light))
                self._set(field("color"), irradiance)
            case PointLight(position, intensity):
                self._set(field("type"), LIGHT_TYPES["point_light"])
                self._set(field("position"), position)
                self._set(field("color"), intensity)
                self._set(field("decay_rate"), 2.0)

    def _set(self, name: str, value: Any) -> None:
        """Set a uniform; names the driver has optimised away are passed over."""
        if name in self._members:
            self._members[name].value = value


def _parse_log(log: str, source: str) -> list[CompileMessage]:
    """The driver's messages with source lines; Mesa writes `0:12(3): error: ...`, NVIDIA `0(12) : error C0000: ...`."""
    lines = source.split("\n")
    messages = []
    for match in re.finditer(r"^\s*\d+[:(](\d+)\)?(?:\(\d+\))?\s*:\s*(?=.*error)(.+)$", log, re.MULTILINE):
        number = int(match[1])
        text = lines[number - 1].strip() if 0 < number <= len(lines) else ""
        messages.append(CompileMessage(number, text, match[2].strip()))
    if not messages:
        kept = [line.strip() for line in text_lines(log) if line.strip() and not set(line.strip()) <= set("=-")]
        messages.append(CompileMessage(0, "", " ".join(kept) or "the driver gave no reason"))
    return messages
