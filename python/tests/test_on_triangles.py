"""Weights of corners at hits."""

import pickle

import numpy as np
import pytest
from shotline import Group, Mesh, Scene, Sphere

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)])
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
MATRIX = np.array([[2, 0.5, 0, 1], [0, 1, 0.25, -2], [0.5, 0, 1.5, 3]])


def test_weighted_corners_are_the_points_that_are_hit():
    random = np.random.default_rng(4)
    mesh = Mesh(CORNERS, FACES)
    ball = Sphere(radius=0.2).translate(1, -2, 9)
    copies = Group(mesh.named("copy"), mesh.named("copy").translate(0, 9, 0)).rotate(0, 0, 30)
    scene = Scene(mesh.transform(MATRIX).named("moved"), ball.named("ball"), copies)
    inside = random.dirichlet([1] * 4, 300) @ CORNERS
    targets = np.concatenate([inside[:200] @ MATRIX[:, :3].T + MATRIX[:, 3], inside[200:] * 0.8])
    origins = random.normal(size=(len(targets), 3)) * 20
    for hits in (scene.closest(origins, targets - origins), scene.crossings(origins, targets - origins)):
        weights, hit = hits.barycentric, hits.primitive >= 0
        assert weights.shape == hits.points.shape and hit.sum() > 30
        assert np.isnan(weights[~hit]).all() and np.isfinite(weights[hit]).all()
        np.testing.assert_allclose(weights[hit].sum(axis=1), 1)
        assert (weights[hit] > -1e-12).all()
        for row in np.flatnonzero(hit):
            matrix = scene.path_transform(int(hits.path[row]))
            corners = CORNERS[FACES[hits.primitive[row]]] @ matrix[:, :3].T + matrix[:, 3]
            np.testing.assert_allclose(weights[row] @ corners, hits.points[row], atol=1e-12)


def test_where_there_is_no_triangle_it_is_nan():
    mesh = Mesh(CORNERS, FACES)
    part = Scene((mesh - Sphere(radius=0.1)).named("part"), Sphere(radius=0.2).translate(5, 0, 0).named("ball"))
    hits = part.closest([[0.2, 0.2, -1], [5, 0, -1], [9, 9, 9]], [0, 0, 1])
    assert hits.primitive.tolist() == [0, -1, -1] and np.isnan(hits.barycentric[1:]).all()
    np.testing.assert_allclose(hits.barycentric[0], [0.6, 0.2, 0.2])
    assert part.closest(np.zeros((0, 3)), [0, 0, 1]).barycentric.shape == (0, 3)
    with pytest.raises(KeyError, match="not among the fields"):
        _ = part.closest([0, 0, -1], [0, 0, 1], fields=["t"]).barycentric
    hits = pickle.loads(pickle.dumps(Scene(mesh.named("m")).closest([0.2, 0.2, -1], [0, 0, 1])))
    with pytest.raises(ValueError, match="from a pickle"):
        _ = hits.barycentric
