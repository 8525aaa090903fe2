"""The reference's nodes of numbers against the generated GLSL: every definition of the standard library that is one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mrm_mtlx.library import load_library
from mrm_mtlx.reference.graph import defining_graph

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
        if ours and definition.getActiveOutputs()[0].getType() not in (*SHADERS, *TEXTS):
            found.setdefault(sheet_of(definition), []).append(str(definition.getName()))
    return found


SHEETS = sheets()


@pytest.mark.parametrize("sheet", SHEETS)
def test_nodes_agree_with_the_generated_glsl(shown, sheet):
    results = shown(SHEETS[sheet])
    bad = {r.label: float(np.max(r.excess)) for r in results if np.max(r.excess) > 1.0}
    assert not bad
