"""`shotline.trimesh` has the methods and results of trimesh's intersectors. What is expected is computed in closed form or
over all pairs of rays and faces; the last tests compare with trimesh, if it is installed."""

import copy
import pickle

import numpy as np
import pytest
from shotline.trimesh import RayMeshIntersector

# The cube [-1, 1]^3.
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
FACES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])


class Bag:
    def __init__(self, vertices, faces):
        self.vertices, self.faces = np.array(vertices, float), np.array(faces)


def cube():
    return Bag(CORNERS, FACES)


def torus(rings=24, sides=12):
    """A closed torus around z with radii 2 and 0.7."""
    i, j = (axis.reshape(-1) for axis in np.mgrid[:rings, :sides])
    u, v = 2 * np.pi * i / rings, 2 * np.pi * j / sides
    r = 2 + 0.7 * np.cos(v)
    k, m = (i + 1) % rings, (j + 1) % sides
    a, b, c, d = i * sides + j, k * sides + j, k * sides + m, i * sides + m
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Bag(np.stack([r * np.cos(u), r * np.sin(u), 0.7 * np.sin(v)], 1), faces)


def all_pairs(mesh, o, d):
    """The t of each ray with each face, (rays, faces); inf where it misses."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    p = np.cross(d[:, None], c - a)
    volume = np.einsum("rfi,fi->rf", p, b - a)
    s = o[:, None] - a
    u = np.einsum("rfi,rfi->rf", s, p) / volume
    q = np.cross(s, b - a)
    v = np.einsum("ri,rfi->rf", d, q) / volume
    t = np.einsum("rfi,fi->rf", q, c - a) / volume
    return np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0), t, np.inf)


def sample(rng, count=400):
    o = rng.uniform(-4, 4, (count, 3))
    return o, rng.uniform(-2, 2, (count, 3)) - o


def test_all_hits_equal_those_of_all_pairs(rng):
    mesh, (o, d) = torus(), sample(rng)
    t = all_pairs(mesh, o, d)
    face, ray, where = RayMeshIntersector(mesh).intersects_id(o, d, return_locations=True)
    # Grouped by ray, ascending along it.
    expected_ray = np.repeat(np.arange(len(o)), np.isfinite(t).sum(axis=1))
    order = np.argsort(t, axis=1, kind="stable")
    expected_face = np.concatenate([row[: np.isfinite(t[i]).sum()] for i, row in enumerate(order)])
    assert np.array_equal(ray, expected_ray) and np.array_equal(face, expected_face)
    np.testing.assert_allclose(where, o[ray] + t[ray, face][:, None] * d[ray], atol=1e-12)
    assert face.dtype == ray.dtype == np.int64 and where.dtype == np.float64


def test_first_and_any_equal_those_of_all_pairs(rng):
    mesh, (o, d) = torus(), sample(rng)
    t = all_pairs(mesh, o, d)
    is_hit = np.isfinite(t).any(axis=1)
    first = np.where(is_hit, t.argmin(axis=1), -1)
    intersector = RayMeshIntersector(mesh)
    assert np.array_equal(intersector.intersects_first(o, d), first)
    assert intersector.intersects_first(o, d).dtype == np.int64
    assert np.array_equal(intersector.intersects_any(o, d), is_hit)
    face, ray = intersector.intersects_id(o, d, multiple_hits=False)
    assert np.array_equal(ray, np.flatnonzero(is_hit)) and np.array_equal(face, first[is_hit])
    where, ray, face = intersector.intersects_location(o, d, multiple_hits=False)
    np.testing.assert_allclose(where, o[ray] + t.min(axis=1)[ray, None] * d[ray], atol=1e-12)
    assert np.array_equal(face, first[is_hit])


def test_max_hits_keeps_the_first_ones(rng):
    intersector, (o, d) = RayMeshIntersector(torus()), sample(rng)
    face, ray = intersector.intersects_id(o, d)
    rank = np.arange(len(ray)) - np.searchsorted(ray, ray)
    for most in range(4):
        some = intersector.intersects_id(o, d, max_hits=most)
        assert np.array_equal(some[0], face[rank < most]) and np.array_equal(some[1], ray[rank < most])
    assert len(intersector.intersects_id(o, d, multiple_hits=False, max_hits=0)[0]) == 0
    with pytest.raises(ValueError, match="max_hits is -1"):
        intersector.intersects_id(o, d, max_hits=-1)


def test_directions_need_no_length():
    where, _, _ = RayMeshIntersector(cube()).intersects_location([[0.25, 0.5, -5]] * 2, [[0, 0, 1], [0, 0, 1000]])
    assert where.tolist() == [[0.25, 0.5, -1], [0.25, 0.5, 1]] * 2


def test_edges_and_vertices_count_once():
    """Rays along z through the diagonals of the faces, and along the diagonal of the cube through two vertices."""
    origins = [[0, 0, -5], [0.5, 0.5, -5], [-0.5, 0.5, -5], [-3, -3, -3]]
    _, ray = RayMeshIntersector(cube()).intersects_id(origins, [[0, 0, 1]] * 3 + [[1, 1, 1]])
    assert np.bincount(ray).tolist() == [2, 2, 2, 2]


def test_a_ray_from_inside_hits_the_wall():
    intersector = RayMeshIntersector(cube())
    where, ray, _ = intersector.intersects_location([[0.1, 0.2, 0.3]], [[0, 0, 1]])
    assert where.tolist() == [[0.1, 0.2, 1.0]] and ray.tolist() == [0]
    assert intersector.intersects_any([[0.1, 0.2, 0.3]], [[0, 0, 1]]).tolist() == [True]


def test_open_meshes_have_hits():
    """The cube without its top."""
    mesh = Bag(CORNERS, FACES[[i for i in range(12) if not (CORNERS[FACES[i], 2] == 1).all()]])
    intersector = RayMeshIntersector(mesh)
    where, ray, _ = intersector.intersects_location([[0.1, 0.2, -5], [0.1, 0.2, 0], [0.1, 0.2, 5]], [[0, 0, 1]] * 3)
    assert where.tolist() == [[0.1, 0.2, -1]] and ray.tolist() == [0]
    # A line through the side walls decides, unless it leaves through the opening.
    assert intersector.contains_points([[0.1, 0.2, -0.9], [0, 0, 5], [9, 0, 0], [0, 0, -2]]).tolist() == [
        1,
        0,
        0,
        0,
    ]


def test_contains_is_that_of_a_torus(rng):
    mesh = torus(96, 96)
    p = rng.uniform(-3, 3, (2000, 3))
    gap = np.hypot(np.hypot(p[:, 0], p[:, 1]) - 2, p[:, 2]) - 0.7
    far = np.abs(gap) > 0.01
    inside = RayMeshIntersector(mesh).contains_points(p)
    assert inside.dtype == bool and np.array_equal(inside[far], gap[far] < 0)


def test_walls_of_no_thickness_cancel():
    """A square whose faces are given twice, in opposite directions, in a cube."""
    sheet = np.array([(0, 1, 2), (0, 2, 3), (0, 2, 1), (0, 3, 2)]) + 8
    square = [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]
    intersector = RayMeshIntersector(Bag([*CORNERS, *square], [*FACES, *sheet]))
    where, _, _ = intersector.intersects_location([[0.1, 0.2, -5]], [[0, 0, 1]])
    assert where[:, 2].tolist() == [-1, 1]


def test_a_changed_mesh_is_compiled_again():
    mesh = cube()
    intersector = RayMeshIntersector(mesh)
    ray = [[0.1, 0.2, -5]], [[0, 0, 1]]
    assert intersector.intersects_location(*ray)[0][:, 2].tolist() == [-1, 1]
    scene = intersector._current().scene
    assert intersector._current().scene is scene
    mesh.vertices *= 2
    assert intersector.intersects_location(*ray)[0][:, 2].tolist() == [-2, 2]
    mesh.faces = mesh.faces[:0]
    assert [len(part) for part in intersector.intersects_location(*ray)] == [0, 0, 0]
    assert intersector.contains_points([[0, 0, 0]]).tolist() == [False]


def test_copies_and_pickles_answer():
    intersector = RayMeshIntersector(cube())
    intersector.intersects_any([[0, 0, -5]], [[0, 0, 1]])
    for other in (pickle.loads(pickle.dumps(intersector)), copy.deepcopy(intersector), copy.copy(intersector)):
        assert other.intersects_any([[0, 0, -5], [9, 0, -5]], [[0, 0, 1]] * 2).tolist() == [True, False]
    assert RayMeshIntersector(geometry=intersector.mesh, scale_to_box=False).mesh is intersector.mesh


@pytest.mark.parametrize("empty", [[], np.zeros((0, 3))])
def test_no_rays_have_typed_results(empty):
    intersector = RayMeshIntersector(cube())
    for multiple in (True, False):
        where, ray, face = intersector.intersects_location(empty, empty, multiple_hits=multiple)
        assert where.shape == (0, 3) and where.dtype == np.float64 and ray.dtype == face.dtype == np.int64
    assert intersector.intersects_first(empty, empty).dtype == np.int64
    assert intersector.intersects_any(empty, empty).dtype == bool
    assert intersector.contains_points(empty).shape == (0,)


def test_bad_arguments_are_named():
    intersector = RayMeshIntersector(cube())
    with pytest.raises(ValueError, match=r"shape \(1, 3\) and ray_directions of shape \(2, 3\) do not match"):
        intersector.intersects_id([[0, 0, 0]], [[0, 0, 1]] * 2)
    with pytest.raises(ValueError, match=r"ray_origins must have shape \(n, 3\)"):
        intersector.intersects_any([0, 0, 0], [0, 0, 1])
    with pytest.raises(ValueError, match="1") as caught:
        intersector.intersects_first([[0, 0, 0]] * 2, [[0, 0, 1], [0, 0, 0]])
    assert caught.value.row == 1
    with pytest.raises(TypeError, match="one mesh"):
        RayMeshIntersector()
    with pytest.raises(TypeError, match="has vertices and faces, but int has not"):
        RayMeshIntersector(3).intersects_any([[0, 0, 0]], [[0, 0, 1]])
    with pytest.raises(ValueError, match=r"faces must have shape \(m, 3\), not \(6, 4\)"):
        RayMeshIntersector(Bag(CORNERS, QUADS)).intersects_any([[0, 0, 0]], [[0, 0, 1]])


def test_results_are_those_of_trimesh(rng):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed: not compared with it")
    pytest.importorskip(
        "rtree", reason="rtree, which trimesh casts rays with, is not installed: not compared with it"
    )
    made = torus()
    mesh = trimesh.Trimesh(made.vertices, made.faces, process=False)
    theirs, ours = trimesh.ray.ray_triangle.RayMeshIntersector(mesh), RayMeshIntersector(mesh)
    o, d = sample(rng, 100)
    assert np.array_equal(theirs.intersects_first(o, d), ours.intersects_first(o, d))
    assert np.array_equal(theirs.intersects_any(o, d), ours.intersects_any(o, d))
    assert set(zip(*theirs.intersects_id(o, d), strict=True)) == set(zip(*ours.intersects_id(o, d), strict=True))
    assert np.array_equal(theirs.contains_points(o), ours.contains_points(o))
    mesh.ray = ours
    mesh.apply_translation([100, 0, 0])
    assert (
        not mesh.ray.intersects_any(o, d).any()
        and mesh.contains(o + [100, 0, 0]).sum() == theirs.contains_points(o + [100, 0, 0]).sum()
    )
