"""Areas, normals and random points of meshes."""

import numpy as np
import pytest
from shotline import Mesh

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def test_areas_and_normals_of_a_corner():
    mesh = Mesh(CORNERS, FACES)
    assert np.allclose(mesh.areas, [0.5, 0.5, np.sqrt(3) / 2, 0.5], rtol=1e-15)
    slanted = [1 / np.sqrt(3)] * 3
    assert np.allclose(mesh.normals, [[0, 0, -1], [0, -1, 0], slanted, [-1, 0, 0]], rtol=1e-15)
    assert mesh.areas.dtype == mesh.normals.dtype == np.float64


@pytest.mark.parametrize("size", [1e-150, 1e-3, 1e150])
def test_any_size_has_areas_and_normals(size):
    mesh = Mesh(np.array(CORNERS) * size, FACES)
    assert np.allclose(mesh.areas / size**2, Mesh(CORNERS, FACES).areas, rtol=1e-14)
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, rtol=1e-15)


def test_a_face_without_area_has_no_normal():
    mesh = Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 3), (0, 0, 3)])
    assert mesh.areas.tolist() == [0, 0.5, 0]
    assert np.isnan(mesh.normals[[0, 2]]).all() and mesh.normals[1].tolist() == [0, 0, 1]
    assert set(mesh.sample(100).primitive.tolist()) == {1}


def test_samples_are_on_their_faces_and_spread_by_area():
    mesh = Mesh(CORNERS, FACES)
    points, face, weights = mesh.sample(40_000, seed=7)
    assert points.shape == weights.shape == (40_000, 3) and face.shape == (40_000,) and face.dtype == np.int32
    assert (weights >= 0).all() and np.allclose(weights.sum(axis=1), 1, rtol=1e-15)
    assert np.allclose(points, (weights[:, :, None] * mesh.vertices[mesh.faces[face]]).sum(axis=1), atol=1e-15)
    share = np.bincount(face, minlength=4) / 40_000
    assert np.allclose(share, mesh.areas / mesh.areas.sum(), atol=0.01)
    # Uniform on each face: the mean is its centroid, and a quarter of the points is nearest to a corner's half.
    for number in range(4):
        assert np.allclose(weights[face == number].mean(axis=0), 1 / 3, atol=0.01)
        assert np.allclose((weights[face == number] > 0.5).mean(axis=0), 1 / 4, atol=0.015)


def test_a_seed_gives_the_same_points():
    mesh = Mesh(CORNERS, FACES)
    assert np.array_equal(mesh.sample(50, seed=3).points, mesh.sample(50, seed=3).points)
    assert not np.array_equal(mesh.sample(50, seed=3).points, mesh.sample(50, seed=4).points)
    assert mesh.sample(0).points.shape == (0, 3)


def test_what_cannot_be_sampled_is_refused():
    with pytest.raises(ValueError, match="the area of the mesh is 0"):
        Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)]).sample(1)
    with pytest.raises(ValueError, match="n is -1, but must be from 0"):
        Mesh(CORNERS, FACES).sample(-1)
