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


def sampled_distances(corners, points, steps=60):
    """The distances of all points to all triangles: the least of a convex function of one weight, by trisection, where the
    least along the other is a segment's."""
    a, b, c = (corners[None, :, i] for i in range(3))
    p = points[:, None]

    def at(s):
        """The distance to the segment at weight s of the first corner."""
        start, end = b + s[..., None] * (a - b), c + s[..., None] * (a - c)
        edge = end - start
        length = (edge**2).sum(-1)
        along = np.divide(((p - start) * edge).sum(-1), length, out=np.zeros(s.shape), where=length > 0).clip(0, 1)
        return np.linalg.norm(p - start - along[..., None] * edge, axis=-1)

    low, high = np.zeros((len(points), len(corners))), np.ones((len(points), len(corners)))
    for _ in range(steps):
        third = (high - low) / 3
        is_left = at(low + third) < at(high - third)
        low, high = np.where(is_left, low, low + third), np.where(is_left, high - third, high)
    return np.minimum(at((low + high) / 2), np.minimum(at(np.zeros_like(low)), at(np.ones_like(low))))


def test_points_are_the_nearest_of_all_triangles():
    """Random triangles, with needles and with some whose corners are in a line."""
    rng = np.random.default_rng(5)
    corners = rng.uniform(-1, 1, (100, 1, 3)) + rng.normal(size=(100, 3, 3)) * rng.choice([0.01, 0.5], (100, 1, 1))
    corners[:10, 2] = (corners[:10, 0] + corners[:10, 1]) / 2
    corners[10:20, 2] = corners[10:20, 1] + 1e-9
    points = np.concatenate([rng.uniform(-2, 2, (100, 3)), corners[:30, 0], corners[30:60].mean(axis=1)])
    all_expected = sampled_distances(corners, points)
    for count in (1, 2, 3, 5, 17, 100):
        near = Mesh(corners[:count].reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)).closest_points(points)
        expected = all_expected[:, :count]
        np.testing.assert_allclose(near.distance, expected.min(axis=1), atol=1e-7)
        np.testing.assert_allclose(expected[np.arange(len(points)), near.primitive], near.distance, atol=1e-7)
        assert (near.barycentric >= -1e-12).all()
        np.testing.assert_allclose(near.barycentric.sum(axis=1), 1)
        weighted = np.einsum("ni,nij->nj", near.barycentric, corners[near.primitive])
        np.testing.assert_allclose(weighted, near.points, atol=1e-14)
        np.testing.assert_allclose(np.linalg.norm(points - near.points, axis=1), near.distance, atol=1e-14)


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
