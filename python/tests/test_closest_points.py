"""The nearest points of meshes, against all triangles one by one."""

import numpy as np
import pytest
from shotline import Mesh


def sphere(count=16):
    """A closed mesh around the origin: the corners are on the unit sphere, the two poles among them."""
    theta, phi = np.pi * np.arange(1, count) / count, 2 * np.pi * np.arange(count) / count
    grid = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), phi**0),
        ],
        axis=-1,
    )
    corners = np.concatenate([[[0, 0, 1]], grid.reshape(-1, 3), [[0, 0, -1]]])
    at = 1 + np.arange((count - 1) * count).reshape(count - 1, count)
    right = np.roll(at, -1, axis=1)
    last = len(corners) - 1
    faces = [(0, a, b) for a, b in zip(at[0], right[0], strict=True)]
    faces += [(last, b, a) for a, b in zip(at[-1], right[-1], strict=True)]
    for row in range(count - 2):
        for a, b, c, d in zip(at[row], right[row], at[row + 1], right[row + 1], strict=True):
            faces += [(a, c, d), (a, d, b)]
    return corners, np.array(faces)


def least_distances(corners, points, cells=60):
    """Upper bounds on the distances, by the points of a fine grid in each triangle."""
    u, v = np.meshgrid(np.arange(cells + 1), np.arange(cells + 1))
    inside = u + v <= cells
    u, v = u[inside] / cells, v[inside] / cells
    weights = np.stack([1 - u - v, u, v], axis=1)
    grid = np.einsum("gk,tkc->tgc", weights, corners).reshape(-1, 3)
    return np.sqrt(((points[:, None] - grid[None]) ** 2).sum(axis=2).min(axis=1))


def test_points_are_nearest():
    vertices, faces = sphere(6)
    mesh = Mesh(vertices, faces)
    points = np.random.default_rng(2).uniform(-1.5, 1.5, (60, 3))
    near = mesh.closest_points(points)
    bounds = least_distances(vertices[faces], points)
    assert (near.distance <= bounds + 1e-12).all() and (near.distance > bounds - 0.02).all()
    np.testing.assert_allclose(np.linalg.norm(near.points - points, axis=1), near.distance, atol=1e-14)
    weighted = np.einsum("nk,nkc->nc", near.barycentric, vertices[faces[near.primitive]])
    np.testing.assert_allclose(weighted, near.points, atol=1e-14)
    np.testing.assert_allclose(near.barycentric.sum(axis=1), 1)


def test_any_shape_and_any_threads():
    mesh = Mesh(*sphere(20))
    points = np.random.default_rng(3).normal(size=(40, 50, 3))
    one = mesh.closest_points(points, threads=1)
    assert one.points.shape == (40, 50, 3) and one.distance.shape == one.primitive.shape == (40, 50)
    for threads in (2, 3):
        many = mesh.closest_points(points, threads=threads)
        assert all((a == b).all() for a, b in zip(one, many, strict=True))
    single = mesh.closest_points(points[3, 4])
    assert single.distance.shape == () and single.distance == one.distance[3, 4]
    assert mesh.closest_points(np.empty((0, 3))).points.shape == (0, 3)
    assert one.distance.dtype == np.float64 and one.primitive.dtype == np.int32


def test_points_without_a_nearest_one():
    near = Mesh(*sphere(6)).closest_points([[np.nan, 0, 0], [np.inf, 0, 0], [0, 0, 3]])
    assert near.distance.tolist() == [np.inf, np.inf, 2] and near.primitive.tolist()[:2] == [-1, -1]
    assert np.isnan(near.points[:2]).all() and np.isnan(near.barycentric[:2]).all()


def test_wrong_points_are_errors():
    mesh = Mesh(*sphere(6))
    for wrong, error in (([1, 2], ValueError), (["a", "b", "c"], TypeError), (3, ValueError)):
        with pytest.raises(error, match="points"):
            mesh.closest_points(wrong)
