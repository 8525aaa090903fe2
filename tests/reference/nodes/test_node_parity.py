"""The reference's nodes of numbers against the generated GLSL: every definition of the standard library that is one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mrm_mtlx.documents.graph import defining_graph
from mrm_mtlx.library import load_library
from mrm_mtlx.reference import versions
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.nodes import NODES
from tests.fixtures.versions import since

# Nodes that are not of this kind: pictures, noises, shaders.
OTHERS = {
    *("image", "hextiledimage", "hextilednormalmap", "surface_unlit", "surfacematerial"),
    *(f"{noise}{size}d" for noise in ("noise", "fractal", "cellnoise", "worleynoise", "flake") for size in (2, 3)),
}
SHADERS = ("surfaceshader", "volumeshader", "displacementshader", "lightshader")
TEXTS = ("string", "filename")

# Sheets are by the first of these types that a node has: a shader takes 16 inputs.
KINDS = ("matrix44", "matrix33", "vector4", "vector3", "vector2", "color4", "color3", "float", "integer", "boolean")


def sheet_of(definition: Any) -> str:
    """Which nodes are drawn with this one; those of the shading frame need its inputs as well."""
    if str(definition.getNodeGroup()) in ("geometric", "npr") and definition.getNodeString() != "geompropvalue":
        return "frame"
    inputs, outputs = (
        {str(port.getType()) for port in ports}
        for ports in (definition.getActiveInputs(), definition.getActiveOutputs())
    )
    return next(kind for kind in KINDS if kind in (inputs.intersection(KINDS) or outputs))


def sheets() -> dict[str, list[str]]:
    """The definitions of the standard library that MaterialX implements in source and that have numbers, by sheet."""
    found: dict[str, list[str]] = {}
    for definition in load_library().document.getNodeDefs():
        implementation = definition.getImplementation("genglsl")
        if implementation is None or defining_graph(definition) is not None or definition.getNodeString() in OTHERS:
            continue
        ours = any(f"/{library}/" in definition.getActiveSourceUri() for library in ("stdlib", "nprlib"))
        # What was implemented in source before 1.39.4, and is a graph since, has no function in the reference.
        known = definition.getName() in NODES or Deviation.MATRIX_PRODUCTS not in versions.installed().deviations
        if ours and known and definition.getActiveOutputs()[0].getType() not in (*SHADERS, *TEXTS):
            found.setdefault(sheet_of(definition), []).append(str(definition.getName()))
    return found


SHEETS = sheets()


# Share of the samples in which the values of another sample have to differ. A node that tells two cases has half of
# them, one that clamps less.
SOME = 0.2


@pytest.mark.parametrize("sheet", SHEETS)
def test_nodes_agree_with_the_generated_glsl(shown, sheet):
    differing, blind = {}, {}
    for node in shown(SHEETS[sheet]):
        tolerance = node.tolerance()
        differing[node.label] = float(np.max(tolerance.excess(node.found)))
        if np.ptp(tolerance.expected, axis=0).any():
            blind[node.label] = float(np.mean(tolerance.excess(np.roll(node.found, 1, axis=0)) > 1.0))
    assert {label: excess for label, excess in differing.items() if not excess <= 1.0} == {}
    assert {label: share for label, share in blind.items() if share < SOME} == {}


MODULES = (
    *("adjustment", "channels", "compositing", "conditionals", "geometry", "math", "matrices", "ramps"),
    *("sources", "vectors"),
)


@since("1.39.5", "definition of each function of the reference")
def test_every_function_is_drawn_or_has_no_numbers_to_draw():
    functions = {name for name, function in NODES.items() if function.__module__.rpartition(".")[2] in MODULES}
    texts = {f"ND_{node}_{kind}" for node in ("constant", "dot", "geompropvalueuniform") for kind in TEXTS}
    assert functions - {name for names in SHEETS.values() for name in names} == {*texts, "ND_dot_surfaceshader"}


@since("1.39.5", "definition of each function of the reference")
def test_no_function_is_for_a_definition_that_the_library_does_not_have(library):
    assert [name for name in NODES if library.document.getNodeDef(name) is None] == []


def transformed_as_column(inputs):
    return np.einsum("ij...,j...->i...", inputs.array("mat"), inputs.array("in"))


def transformed_as_direction(inputs):
    return np.einsum("i...,ij...->j...", inputs.array("in"), inputs.array("mat")[:3])[:3]


def inverse_transposed(inputs):
    return np.moveaxis(np.linalg.inv(np.moveaxis(inputs.array("in"), -1, 0)), 0, -1).swapaxes(0, 1)


def rotated_the_other_way(inputs):
    (x, y), angle = inputs.array("in"), np.deg2rad(inputs.array("amount"))
    return np.stack([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y])


def rotated_by_radians(inputs):
    (x, y), angle = inputs.array("in"), inputs.array("amount")
    return np.stack([np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x])


def mean_of_channels(inputs):
    return np.broadcast_to(np.mean(inputs.array("in"), axis=0), inputs.array("in").shape)


def with_bitangent_down(inputs):
    x, y, z = 2.0 * inputs.array("in") - 1.0
    scale, axes = inputs.array("scale"), [inputs.array(name) for name in ("tangent", "bitangent", "normal")]
    n = axes[0] * x * scale - axes[1] * y * scale + axes[2] * z
    return n / np.linalg.norm(n, axis=0)


def ramp_from_the_top(inputs):
    t = np.clip(inputs.array("texcoord")[1], 0.0, 1.0)
    return inputs.array("valuet") * (1.0 - t) + inputs.array("valueb") * t


def of(function, *names):
    """A function of inputs' arrays as a node's function."""
    return lambda inputs: function(*(inputs.array(name) for name in names))


# Planted errors: the smallest ones of their kind, each in one definition.
WRONG = {
    "ND_subtract_vector3": of(lambda a, b: b - a, "in1", "in2"),
    "ND_divide_color3FA": of(np.multiply, "in1", "in2"),
    "ND_modulo_float": of(np.fmod, "in1", "in2"),
    "ND_fract_float": of(lambda a: a - np.trunc(a), "in"),
    "ND_floor_vector2": of(np.trunc, "in"),
    "ND_round_integer": of(np.floor, "in"),
    "ND_power_float": of(lambda a, b: np.abs(b) ** a, "in1", "in2"),
    "ND_sin_float": of(lambda a: np.sin(a) * 1.002, "in"),
    "ND_atan2_float": of(np.arctan2, "inx", "iny"),
    "ND_exp_float": of(np.exp2, "in"),
    "ND_ln_float": of(np.log2, "in"),
    "ND_clamp_color4": of(np.minimum, "in", "high"),
    "ND_max_vector4FA": of(np.minimum, "in1", "in2"),
    "ND_ifgreatereq_floatI": of(lambda a, b, x, y: np.where(a > b, x, y), "value1", "value2", "in1", "in2"),
    "ND_ifequal_color3B": of(lambda a, b, x, y: np.where(a == b, y, x), "value1", "value2", "in1", "in2"),
    "ND_logical_or": of(np.logical_and, "in1", "in2"),
    "ND_extract_vector4": of(lambda a, i: np.choose(3 - i.astype(int), a), "in", "index"),
    "ND_extract_matrix33": of(lambda a, i: np.choose(i.astype(int), a.swapaxes(0, 1)), "in", "index"),
    "ND_creatematrix_vector3_matrix33": of(lambda *rows: np.stack(rows, axis=1), "in1", "in2", "in3"),
    "ND_multiply_matrix33": of(lambda a, b: np.einsum("ij...,jk...->ik...", b, a), "in1", "in2"),
    "ND_invertmatrix_matrix33": inverse_transposed,
    "ND_transformmatrix_vector3": transformed_as_column,
    "ND_transformmatrix_vector3M4": transformed_as_direction,
    "ND_crossproduct_vector3": of(lambda a, b: np.cross(b, a, axis=0), "in1", "in2"),
    "ND_rotate2d_vector2": rotated_the_other_way,
    "ND_luminance_color3": mean_of_channels,
    "ND_rgbtohsv_color3": of(lambda a: np.roll(a, 1, axis=0), "in"),
    "ND_smoothstep_float": of(lambda x, a, b: np.clip((x - a) / (b - a), 0.0, 1.0), "in", "low", "high"),
    "ND_screen_float": of(lambda f, b, m: (f + b) * m + b * (1.0 - m), "fg", "bg", "mix"),
    "ND_mix_color4": of(lambda f, b, m: f * (1.0 - m) + b * m, "fg", "bg", "mix"),
    "ND_premult_color4": of(lambda a: a * a[3], "in"),
    "ND_over_color4": of(lambda f, b, m: (f + b) * m + b * (1.0 - m), "fg", "bg", "mix"),
    "ND_normalmap_float": with_bitangent_down,
    "ND_ramptb_float": ramp_from_the_top,
    "ND_splitlr_float": of(lambda a, b, c, uv: np.where(uv[0] < c, b, a), "valuel", "valuer", "center", "texcoord"),
}

# Share of a node's samples in which an error has to show; some leave what is equal or positive as it is.
SEEN = 0.1


@pytest.mark.parametrize("sheet", [sheet for sheet, names in SHEETS.items() if WRONG.keys() & set(names)])
def test_errors_in_a_function_are_seen(shown, monkeypatch, sheet):
    right, seen = {}, {}
    # A ramp from the top is what MaterialX had before 1.39.5.
    known = versions.installed().deviations
    right_here = {"ND_ramptb_float"} if Deviation.VERTICAL_RAMPS in known else set()
    # Products of matrices are the other way round before 1.39.4, whatever function there is.
    right_here |= {f"ND_{op}_matrix33" for op in ("multiply", "divide") if Deviation.MATRIX_PRODUCTS in known}
    for node in shown([name for name in SHEETS[sheet] if name in WRONG.keys() - right_here]):
        name = node.label.split()[0]
        right[name] = max(right.get(name, 0.0), float(np.max(node.tolerance().excess(node.found))))
        with monkeypatch.context() as patch:
            patch.setitem(NODES, name, WRONG[name])
            seen[name] = max(seen.get(name, 0.0), float(np.mean(node.tolerance().excess(node.found) > 1.0)))
    assert {name: excess for name, excess in right.items() if not excess <= 1.0} == {}
    assert {name: share for name, share in seen.items() if share < SEEN} == {}
