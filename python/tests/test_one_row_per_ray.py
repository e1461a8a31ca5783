"""`first`, `last` and `sum` of ragged answers, and the cosine of incidence."""

import pickle

import numpy as np
import pytest
from shotline import Box, Closest, Crossings, Cylinder, Scene, SegmentPerRay, Sphere


@pytest.fixture(scope="module")
def grid():
    """Rays of shape (8, 9) at the sample scene, some of which miss."""
    random = np.random.default_rng(3)
    o = random.normal(size=(8, 9, 3)) * 8
    return o, random.uniform([-4, -4, -3], [9, 4, 6], (8, 9, 3)) - o


def same(a, b):
    return a.dtype == b.dtype and a.shape == b.shape and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def test_the_first_crossing_is_the_closest(sample_scene, grid):
    hits, closest = sample_scene.crossings(*grid), sample_scene.closest(*grid)
    first = hits.first()
    assert isinstance(first, Closest) and 0 < np.isfinite(first.t).sum() < 72
    for name, column in closest.to_dict().items():
        assert same(first[name], column), name
    assert same(first.points, closest.points) and (first.object_names() == closest.object_names()).all()


def test_the_last_crossing_is_the_last_row_of_its_ray(sample_scene, grid):
    hits = sample_scene.crossings(*grid)
    last = hits.last()
    for ray in range(72):
        rows = hits.ray(ray)
        t = rows.t[-1] if len(rows) else np.inf
        assert last.t.flat[ray] == t
        assert len(rows) == 0 or np.array_equal(last.normal.reshape(-1, 3)[ray], rows.normal[-1])
    assert repr(last).startswith("last crossings of rays of shape (8, 9)")
    assert repr(last[2:4]).startswith("last crossings of rays of shape (2,)")
    assert same(pickle.loads(pickle.dumps(last)).t, last.t)


def test_columns_that_were_not_asked_for_stay_away(sample_scene, grid):
    first = sample_scene.crossings(*grid, fields=["t", "object"]).first()
    assert list(first.to_dict()) == ["t", "object"]


def test_segments_of_rays_that_miss():
    scene = Scene(Box(min=(0, 0, 0), max=(2, 1, 1)), Box(min=(3, 0, 0), max=(7, 1, 1)))
    segments = scene.segments([[-1, 0.5, 0.5], [-1, 5, 5], [1, 0.5, 0.5]], [2, 0, 0])
    first, last = segments.first(), segments.last()
    assert isinstance(first, SegmentPerRay) and len(first) == 3
    assert np.array_equal(first.length, [2, np.nan, 1], equal_nan=True)
    assert np.array_equal(last.length, [4, np.nan, 4], equal_nan=True)
    assert first.t_in.tolist() == [0.5, np.inf, 0] and first.t_out.tolist() == [1.5, np.inf, 0.5]
    assert first.object.tolist() == [0, -1, 0] and last.path.tolist() == [1, -1, 1]
    assert first.object_names().tolist() == ["object0", None, "object0"]
    assert repr(first).startswith("one segment of each ray, of shape (3,): 2 have one")
    assert first[2].length.shape == () and first.ray(0).length == 2


def test_one_ray_has_arrays_without_axes():
    scene = Scene(Sphere(radius=1))
    hits, segments = scene.crossings([-3, 0, 0], [1, 0, 0]), scene.segments([-3, 0, 0], [1, 0, 0])
    assert hits.first().t.shape == () and hits.last().normal.shape == (3,) and hits.last().t == 4
    assert segments.first().length == segments.sum("length") == 2


def test_no_rays_and_no_rows():
    scene = Scene(Sphere(radius=1))
    none = scene.crossings(np.empty((0, 3)), [1, 0, 0])
    assert none.first().t.shape == (0,) and none.sum("t").shape == (0,)
    missed = scene.crossings([[5, 5, 5]], [1, 0, 0])
    assert missed.first().t.tolist() == [np.inf] and missed.sum("t").tolist() == [0]
    by_hand = Crossings(np.array([0, 2, 2]), np.array([1.0, 2.0]), *[None] * 8)
    assert by_hand.last().t.tolist() == [2.0, np.inf] and by_hand.sum("t").tolist() == [3, 0]


def test_sums_are_of_the_rows_of_each_ray(sample_scene, grid):
    segments = sample_scene.segments(*grid)
    lengths = segments.sum("length")
    assert lengths.shape == (8, 9)
    assert np.allclose(lengths, sample_scene.thickness(*grid).sum(axis=-1), rtol=1e-14)
    # Weighted by the density of each material: what a ray passes, in mass per area.
    density = np.array([7.8, 8.5])
    mass = segments.sum(segments.length * density[segments.material])
    assert np.allclose(mass, sample_scene.thickness(*grid)[..., :-1] @ density, rtol=1e-14)
    both = segments.sum(segments.length[:, None] * np.array([[1.0, 2.0]]))
    assert both.shape == (8, 9, 2) and np.array_equal(both[..., 0], lengths)


def test_sums_of_something_else_are_refused(sample_scene, grid):
    segments = sample_scene.segments(*grid)
    with pytest.raises(KeyError, match="'lengths'; the names are ray_splits"):
        segments.sum("lengths")
    with pytest.raises(ValueError, match=rf"a number for each of the {len(segments)} rows, not shape \(3,\)"):
        segments.sum([1, 2, 3])


def test_the_thickness_of_a_wall_is_the_length_of_the_first_segment():
    tube = Scene(Cylinder(radius=2, z0=0, z1=9) - Cylinder(radius=1.5, z0=0, z1=9))
    segments = tube.segments([[-5, 0, 1], [2, 0, 1]], [[1, 0, 0], [-3, 0, 0]])
    assert np.allclose(segments.first().length, 0.5, rtol=1e-14)


def test_the_cosine_of_incidence(sample_scene, grid):
    for hits, d in [(sample_scene.closest(*grid), grid[1]), (sample_scene.crossings(*grid), None)]:
        directions = d if d is not None else grid[1].reshape(-1, 3)[hits.ray_ids]
        unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
        expected = np.abs((hits.normal * unit).sum(axis=-1))
        assert hits.cosine.shape == hits.t.shape
        assert np.allclose(hits.cosine, expected, rtol=1e-14, equal_nan=True) and not (hits.cosine > 1).any()
    assert np.isnan(sample_scene.closest([50, 50, 50], [0, 0, 1]).cosine)
    # Neither the square of the direction's length nor its product with the normal is in the range of float64.
    ball = Scene(Sphere(radius=1e-160)).closest([-3e-160, 0, 0.6e-160], [2e-160, 0, 0])
    assert abs(float(ball.cosine) - 0.8) < 1e-14
