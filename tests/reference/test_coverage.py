"""Which node definitions the reference covers, and that one it does not is named."""

from __future__ import annotations

from mrm_mtlx.reference.coverage import coverage
from mrm_mtlx.reference.nodes import NODES

# Nodes of the physically based library that a surface's reference has no use for, or MaterialX no hardware code.
NOT_OF_SURFACES = {
    "ND_conical_edf": "MaterialX has no hardware implementation of it",
    "ND_measured_edf": "MaterialX has no hardware implementation of it",
    "ND_absorption_vdf": "MaterialX has no hardware implementation of it",
    "ND_mix_vdf": "MaterialX has no hardware implementation of it",
    "ND_add_vdf": "MaterialX has no hardware implementation of it",
    "ND_multiply_vdfF": "MaterialX has no hardware implementation of it",
    "ND_multiply_vdfC": "MaterialX has no hardware implementation of it",
    "ND_volume": "MaterialX has no hardware implementation of it",
    "ND_light": "a light, not a surface",
    "ND_displacement_float": "moves the surface before it is shaded",
    "ND_displacement_vector3": "moves the surface before it is shaded",
}


def test_all_of_pbrlib_is_covered_but_what_has_a_reason(library):
    missing = {c.name: c.reason for c in coverage(library.document) if c.library == "pbrlib" and not c.how}
    assert missing == NOT_OF_SURFACES


def test_all_of_bxdf_and_most_of_everything_is_covered(library):
    found = coverage(library.document)
    assert [c.name for c in found if c.library == "bxdf" and not c.how] == []
    assert sum(bool(c.how) for c in found) >= 0.85 * len(found)


def test_every_definition_is_there_once_and_every_gap_has_a_reason(library):
    found = coverage(library.document)
    names = [str(d.getName()) for d in library.document.getNodeDefs()]
    assert [c.name for c in found] == names
    assert all(bool(c.how) != bool(c.reason) for c in found)


def test_a_function_that_is_missing_uncovers_the_graphs_that_need_it(library, monkeypatch):
    monkeypatch.delitem(NODES, "ND_sheen_bsdf")
    found = {c.name: c for c in coverage(library.document)}
    assert found["ND_sheen_bsdf"].reason == "no function yet"
    assert found["ND_standard_surface_surfaceshader"].reason == "its graph needs ND_sheen_bsdf"
