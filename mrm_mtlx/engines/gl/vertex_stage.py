"""The vertex stage that feeds a generated fragment shader: one point per sample, every input an attribute.

The fragment shader's inputs are per-point attributes instead of quantities interpolated over a mesh. A point covers one
pixel and has constant inputs, so that the values reach the fragment shader bit for bit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrm_mtlx.shadergen import Shader

GLSL_TYPES = {
    "float": "float",
    "integer": "int",
    "boolean": "bool",
    "vector2": "vec2",
    "vector3": "vec3",
    "vector4": "vec4",
    "color3": "vec3",
    "color4": "vec4",
}

COMPONENTS = {"float": 1, "vector2": 2, "vector3": 3, "vector4": 4, "color3": 3, "color4": 4, "integer": 1}


def vertex_source(shader: Shader) -> str:
    """GLSL of the vertex stage for a generated pixel stage, in the same language version."""
    version = shader.sources["pixel"].split("\n", 1)[0]
    # Interface variables of integer type cannot be interpolated; GLSL asks for `flat` on both sides.
    flat = ["flat " if port.type == "integer" else "" for port in shader.inputs]
    declarations = [f"{GLSL_TYPES[port.type]} {port.variable};" for port in shader.inputs]
    lines = [version, "uniform ivec2 mrm_size;"]
    lines += [f"in {GLSL_TYPES[port.type]} mrm_{port.variable};" for port in shader.inputs]
    if shader.input_block and declarations:
        members = [f"{qualifier}{line}" for qualifier, line in zip(flat, declarations, strict=True)]
        lines += ["out VertexData {", *members, f"}} {shader.input_block};"]
    else:
        lines += [f"{qualifier}out {line}" for qualifier, line in zip(flat, declarations, strict=True)]
    prefix = f"{shader.input_block}." if shader.input_block else ""
    lines += [
        "void main() {",
        *(f"    {prefix}{port.variable} = mrm_{port.variable};" for port in shader.inputs),
        # Centre of the sample's pixel, in clip space.
        "    vec2 pixel = vec2(gl_VertexID % mrm_size.x, gl_VertexID / mrm_size.x) + 0.5;",
        "    gl_Position = vec4(2.0 * pixel / vec2(mrm_size) - 1.0, 0.0, 1.0);",
        "    gl_PointSize = 1.0;",
        "}",
    ]
    return "\n".join(lines) + "\n"
