"""The meshes are the shapes that the rays of a picture meet, outside out, with the same frames."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.render.meshes import MESHES, mesh
from mrm_mtlx.render.shapes import EYE, SHAPES, intersect

# A chord of 512 around the sphere lies up to 1.9e-5 below it; of its normals, interpolated, as much is lost.
CHORD = 1e-4


def test_the_shapes_are_the_same():
    assert list(MESHES) == list(SHAPES)


@pytest.mark.parametrize("shape", SHAPES)
def test_rays_toward_a_mesh_meet_the_shape_there_with_its_normal_tangent_and_coordinates(shape):
    made = mesh(shape)
    corners = made.vertices[made.faces]
    middle, normals = corners.mean(axis=1), made.normals.mean(axis=1)
    # Where a chord is seen at a steep angle; along the rim its depth below the surface moves the hit far aside.
    to_eye = (EYE - middle) / np.linalg.norm(EYE - middle, axis=1, keepdims=True)
    facing = np.flatnonzero(np.sum(normals * to_eye, axis=1) > 0.2)
    rays = middle[facing] - EYE
    hits = intersect(shape, rays / np.linalg.norm(rays, axis=1, keepdims=True))
    # Rays to the rim of the plane and to the ends of the cone may pass by.
    assert np.mean(hits.found) > 0.99
    seen = facing[hits.found]
    np.testing.assert_allclose(hits.position[hits.found], middle[seen], atol=CHORD * 10)
    np.testing.assert_allclose(hits.normal[hits.found], normals[seen], atol=0.02)
    inner = np.abs(made.texcoords[seen, :, 0].mean(axis=1) - 0.5) < 0.45
    np.testing.assert_allclose(hits.texcoord[hits.found][inner], made.texcoords[seen].mean(axis=1)[inner], atol=2e-3)
    # What renderers without coordinates take for the tangent: along u, whichever way.
    along = corners[seen, 0] - corners[seen, 2]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    assert np.min(np.abs(np.sum(along * hits.tangent[hits.found], axis=1))[inner]) > 0.99


@pytest.mark.parametrize("shape", SHAPES)
def test_corners_go_round_as_the_normals_point(shape):
    made = mesh(shape)
    a, b, c = np.moveaxis(made.vertices[made.faces], 1, 0)
    area = np.cross(b - a, c - a)
    assert np.all(np.sum(area * made.normals.mean(axis=1), axis=1) > 0.0)
