"""Reading the materials of a large stage.

Seconds for the materials of a stage of many prims, best of 3: safe opening, translation, USD's own validators.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.timing import Table, best_time, run
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.library import load_library

if TYPE_CHECKING:
    from collections.abc import Iterator

PRIMS = 10_000
MATERIALS = 20
_MATERIAL = """def Material "M{0}" {{
    token outputs:mtlx:surface.connect = </W/M{0}/s.outputs:out>
    def Shader "s" {{
        uniform token info:id = "ND_surface"
        token inputs:bsdf.connect = </W/M{0}/c.outputs:out>
    }}
    def Shader "c" {{
        uniform token info:id = "ND_conductor_bsdf"
        float2 inputs:roughness = (0.1, 0.{0:02})
    }}
}}
"""
_MESH = """def Mesh "m{0}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    rel material:binding = </W/M{1}>
}}
"""


def measure() -> Table:
    """One stage."""
    return Table(("stage", "s", "findings"), _rows(), ("usd-core", "MaterialX"))


def _rows() -> Iterator[tuple[str, ...]]:
    materials = "".join(_MATERIAL.format(k) for k in range(MATERIALS))
    meshes = "".join(_MESH.format(k, k % MATERIALS) for k in range(PRIMS))
    head = '#usda 1.0\n(\n defaultPrim = "W"\n metersPerUnit = 1\n upAxis = "Y"\n)\n'
    library = load_library()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "stage.usda")
        path.write_text(f'{head}def Xform "W" {{\n{materials}{meshes}}}\n', encoding="utf-8")
        found = read_document(path, Reach.beside(path), library, path.parent).findings
        seconds = best_time(lambda: read_document(path, Reach.beside(path), library, path.parent), 3)
    yield f"{MATERIALS} materials, {PRIMS:,} prims", f"{seconds:.2f}", str(len(found))


if __name__ == "__main__":
    run(__doc__, measure, __file__)
