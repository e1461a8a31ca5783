"""`shotline.open3d` has the methods and results of Open3D's `RaycastingScene`. What is expected is computed in closed form
or over all triangles; the last tests compare with Open3D, if it is installed."""

import numpy as np
import pytest
import shotline
from shotline.open3d import RaycastingScene

# The cube [0, 1]^3.
CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
QUADS = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)], np.uint32)
FACES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
MISS = RaycastingScene.INVALID_ID


def cube(*shifts):
    scene = RaycastingScene()
    for shift in shifts or [(0, 0, 0)]:
        scene.add_triangles(CORNERS + np.float32(shift), FACES)
    return scene


class Tensor:
    """A stand-in with those methods of a tensor of Open3D that are relied on."""

    def __init__(self, values):
        self.values = np.array(values)

    def cpu(self):
        return self

    def numpy(self):
        return self.values


def test_first_hits_have_the_names_and_types_of_open3d():
    """One ray hits the second cube from outside, one the first from inside, one nothing."""
    rays = [[[5.25, 0.5, -1, 0, 0, 2], [0.25, 0.5, 0.25, 0, 0, 1], [9, 9, 9, 1, 0, 0]]]
    scene = cube((0, 0, 0), (5, 0, 0))
    found = scene.cast_rays(rays)
    assert found["t_hit"].numpy().tolist() == [[0.5, 0.75, np.inf]]
    assert found["geometry_ids"].numpy().tolist() == [[1, 0, MISS]] and found["primitive_ids"][0, 2] == MISS
    assert found["primitive_normals"].numpy().tolist() == [[[0, 0, -1], [0, 0, 1], [0, 0, 0]]]
    types = {name: (column.dtype.name, column.shape) for name, column in found.items()}
    assert types == {
        "t_hit": ("float32", (1, 3)),
        "geometry_ids": ("uint32", (1, 3)),
        "primitive_ids": ("uint32", (1, 3)),
        "primitive_uvs": ("float32", (1, 3, 2)),
        "primitive_normals": ("float32", (1, 3, 3)),
    }


def test_barycentric_weights_give_the_hits(rng):
    scene = cube()
    o = rng.uniform(-2, 3, (500, 3))
    rays = np.concatenate([o, rng.uniform(0, 1, (500, 3)) - o], axis=1)
    listed, first = scene.list_intersections(rays), scene.cast_rays(rays)
    is_hit = first["t_hit"].isfinite()
    for found, ray in (
        (listed, listed["ray_ids"]),
        ({n: c[is_hit] for n, c in first.items()}, is_hit.nonzero()[0]),
    ):
        a, b, c = (CORNERS[FACES[found["primitive_ids"], i]] for i in range(3))
        u, v = found["primitive_uvs"].numpy()[:, :1], found["primitive_uvs"].numpy()[:, 1:]
        positions = rays[ray, :3] + found["t_hit"].numpy()[:, None] * rays[ray, 3:]
        np.testing.assert_allclose((1 - u - v) * a + u * b + v * c, positions, atol=2e-6)


def test_lists_counts_and_occlusions_agree():
    rays = np.array([[0.25, 0.5, -1, 0, 0, 1], [0.25, 0.5, 0.25, 0, 0, 1], [9, 9, 9, 0, 0, 1]])
    scene = cube((0, 0, 0), (0, 0, 3))
    listed = scene.list_intersections(rays)
    assert listed["ray_splits"].numpy().tolist() == [0, 4, 7, 7]
    assert listed["ray_ids"].numpy().tolist() == [0, 0, 0, 0, 1, 1, 1]
    assert listed["t_hit"].numpy().tolist() == [1, 2, 4, 5, 0.75, 2.75, 3.75]
    assert listed["geometry_ids"].numpy().tolist() == [0, 0, 1, 1, 0, 1, 1]
    types = {name: column.dtype.name for name, column in listed.items()}
    assert {name for name in types if types[name] == "float32"} == {"t_hit", "primitive_uvs"}
    assert {name for name in types if types[name] == "uint32"} == set(types) - {"t_hit", "primitive_uvs"}
    count = scene.count_intersections(rays.reshape(3, 1, 6))
    assert count.numpy().tolist() == [[4], [3], [0]] and count.dtype == np.int32
    assert scene.test_occlusions(rays).numpy().tolist() == [True, True, False]
    assert scene.test_occlusions(rays, tnear=1.5, tfar=1.75).numpy().tolist() == [False, False, False]
    assert scene.test_occlusions(rays, 1.5, 2.0, 1).tolist() == [True, False, False]


def test_occupancy_is_the_parity_of_walls():
    """A small cube in a large one is a cavity."""
    scene = cube()
    scene.add_triangles(CORNERS / 2 + np.float32(0.25), FACES)
    points = [[[0.5, 0.5, 0.5], [0.1, 0.5, 0.5], [2, 0.5, 0.5]]]
    assert scene.compute_occupancy(points).numpy().tolist() == [[0, 1, 0]]
    assert scene.compute_occupancy(points).dtype == np.float32
    with pytest.raises(ValueError, match="nsamples is 2, but must be odd"):
        scene.compute_occupancy(points, nsamples=2)


def test_occupancy_of_an_open_mesh_is_voted_on():
    """The cube without a face: most lines still cross one wall on their way out."""
    scene = RaycastingScene()
    scene.add_triangles(CORNERS, np.delete(FACES, [0, 6], axis=0))
    inside = scene.compute_occupancy([[0.9, 0.5, 0.5], [2, 3, 0.5]], nsamples=31)
    assert inside.numpy().tolist() == [1, 0]


def test_distances_are_those_of_a_cube(rng):
    scene, points = cube(), rng.uniform(-1, 2, (40, 50, 3))
    beyond = np.maximum(np.maximum(-points, points - 1), 0)
    depth = np.minimum(points, 1 - points).min(axis=-1)
    signed = np.where(depth > 0, -depth, np.linalg.norm(beyond, axis=-1))
    distance = scene.compute_distance(points)
    assert distance.dtype == np.float32 and distance.shape == (40, 50)
    np.testing.assert_allclose(distance, np.abs(signed), rtol=1e-6)
    np.testing.assert_allclose(scene.compute_signed_distance(points), signed, rtol=1e-6)


def test_closest_points_are_grouped_by_mesh():
    found = cube((0, 0, 0), (5, 0, 0)).compute_closest_points([[0.25, 0.5, -2], [5.25, 0.5, 3]])
    assert found["points"].numpy().tolist() == [[0.25, 0.5, 0], [5.25, 0.5, 1]]
    assert found["geometry_ids"].numpy().tolist() == [0, 1]
    assert found["primitive_normals"].numpy().tolist() == [[0, 0, -1], [0, 0, 1]]
    assert (CORNERS[FACES[found["primitive_ids"]]][:, :, 2] == [[0] * 3, [1] * 3]).all()
    assert found["primitive_uvs"].shape == (2, 2) and found["points"].dtype == np.float32


def test_an_empty_scene_has_misses():
    for scene in (RaycastingScene(), RaycastingScene(nthreads=2, device="CPU:0")):
        assert scene.cast_rays([[0, 0, 0, 0, 0, 1]])["primitive_ids"].numpy().tolist() == [MISS]
        assert scene.list_intersections([[0, 0, 0, 0, 0, 1]])["ray_splits"].numpy().tolist() == [0, 0]
        assert scene.compute_signed_distance([[0, 0, 0]]).numpy().tolist() == [np.inf]
        assert scene.compute_closest_points([[0, 0, 0]])["geometry_ids"].numpy().tolist() == [MISS]
        assert scene.add_triangles(np.zeros((0, 3)), np.zeros((0, 3), np.uint32)) == 0
        assert scene.add_triangles(CORNERS, FACES) == 1
        assert scene.cast_rays([[0.2, 0.5, -1, 0, 0, 1]])["geometry_ids"].numpy().tolist() == [1]


def test_meshes_of_packages_are_added():
    class Bag:
        vertices, triangles = CORNERS, FACES

    scene = RaycastingScene()
    assert scene.add_triangles(Bag()) == 0
    assert scene.add_triangles(mesh=shotline.Mesh(CORNERS + [5, 0, 0], FACES)) == 1
    assert scene.add_triangles(vertex_positions=Tensor(CORNERS + [0, 5, 0]), triangle_indices=Tensor(FACES)) == 2
    rays = [[x + 0.25, y + 0.5, -1, 0, 0, 1] for x, y in ((0, 0), (5, 0), (0, 5))]
    assert scene.cast_rays(rays)["geometry_ids"].numpy().tolist() == [0, 1, 2]


def test_tensors_in_and_tensors_out():
    rays = Tensor([[0.25, 0.5, -1, 0, 0, 2]])
    found = cube().cast_rays(rays)
    assert all(type(column) is Tensor for column in found.values()) and found["t_hit"].numpy().tolist() == [0.5]
    assert type(cube().compute_distance(Tensor([[0, 0, 3.0]]))) is Tensor
    pixels = RaycastingScene.create_rays_pinhole(Tensor(np.eye(3)), np.eye(4), 2, 3)
    assert type(pixels) is Tensor and pixels.numpy().shape == (3, 2, 6)


def test_arrays_have_the_methods_that_scripts_call():
    found = cube().cast_rays([[0.25, 0.5, -1, 0, 0, 2], [9, 9, 9, 0, 0, 1]])["t_hit"]
    assert type(found.numpy()) is np.ndarray and type(found.cpu().clone()) is type(found)
    assert found.isfinite().numpy().tolist() == [True, False] == (~found.isinf()).tolist()
    assert not found.isnan().any()


def test_pinhole_rays_of_matrices():
    """A camera at (1, 2, 3), turned by a quarter around z."""
    extrinsic = np.array([(0, 1, 0, -2), (-1, 0, 0, 1), (0, 0, 1, -3), (0, 0, 0, 1)], float)
    intrinsic = [(100, 0, 16), (0, 50, 12), (0, 0, 1)]
    rays = RaycastingScene.create_rays_pinhole(intrinsic, extrinsic, width_px=4, height_px=3)
    assert rays.shape == (3, 4, 6) and rays.dtype == np.float32
    x, y = (np.arange(4) + 0.5 - 16) / 100, (np.arange(3) + 0.5 - 12) / 50
    np.testing.assert_allclose(rays[..., :3], np.broadcast_to([1, 2, 3], (3, 4, 3)), rtol=1e-6)
    np.testing.assert_allclose(rays[1, 2, 3:], [-y[1], x[2], 1], rtol=1e-6)
    with pytest.raises(ValueError, match="singular"):
        RaycastingScene.create_rays_pinhole(np.zeros((3, 3)), extrinsic, 4, 3)
    with pytest.raises(ValueError, match=r"extrinsic_matrix must have shape \(4, 4\), not \(3, 4\)"):
        RaycastingScene.create_rays_pinhole(intrinsic, extrinsic[:3], 4, 3)


def test_pinhole_rays_of_a_field_of_view():
    """A camera above the origin that looks down, with the y axis up: rows run along y, columns against x."""
    view = {"fov_deg": 90, "center": [0, 0, 0], "eye": [0, 0, 5], "up": [0, 1, 0], "width_px": 4, "height_px": 2}
    rays = RaycastingScene.create_rays_pinhole(**view)
    assert rays.shape == (2, 4, 6) and np.array_equal(rays, RaycastingScene.create_rays_pinhole(*view.values()))
    x, y = np.array([0.75, 0.25, -0.25, -0.75]), np.array([-0.25, 0.25])
    np.testing.assert_allclose(rays[..., 3], np.broadcast_to(x, (2, 4)), atol=1e-7)
    np.testing.assert_allclose(rays[..., 4], np.broadcast_to(y[:, None], (2, 4)), atol=1e-7)
    assert (rays[..., 5] == -1).all() and (rays[..., :3] == [0, 0, 5]).all()
    for wrong, message in (({"fov_deg": 180}, "between 0 and 180"), ({"up": [0, 0, 1]}, "not run along up")):
        with pytest.raises(ValueError, match=message):
            RaycastingScene.create_rays_pinhole(**(view | wrong))


def test_bad_arguments_are_named():
    scene = cube()
    with pytest.raises(ValueError, match=r"rays must have shape \(..., 6\), not \(1, 5\)"):
        scene.cast_rays([[0, 0, 0, 0, 1]])
    with pytest.raises(ValueError) as caught:
        scene.count_intersections([[0, 0, 0, 0, 0, 1], [0, 0, np.nan, 0, 0, 1]])
    assert caught.value.row == 1
    with pytest.raises(ValueError, match="query_points: row 1 is .* must be finite"):
        scene.compute_distance([[0, 0, 0], [np.inf, 0, 0]])
    with pytest.raises(ValueError, match="threads is -1"):
        scene.compute_distance([[0, 0, 0]], nthreads=-1)
    with pytest.raises(TypeError, match="vertices and faces, or one mesh"):
        scene.add_triangles()
    with pytest.raises(ValueError, match=r"faces must have shape \(m, 3\), not \(6, 4\)"):
        scene.add_triangles(CORNERS, QUADS)


def test_results_are_those_of_open3d(rng):
    o3d = pytest.importorskip("open3d", reason="Open3D is not installed: not compared with it")
    mesh = o3d.t.geometry.TriangleMesh.from_legacy(o3d.geometry.TriangleMesh.create_torus(1, 0.3, 40, 20))
    theirs, ours = o3d.t.geometry.RaycastingScene(), RaycastingScene()
    assert theirs.INVALID_ID == ours.INVALID_ID
    assert [scene.add_triangles(mesh) for scene in (theirs, ours)] == [0, 0]
    o = rng.uniform(-2, 2, (1000, 3))
    rays = np.concatenate([o, rng.uniform(-1, 1, (1000, 3)) - o], axis=1).astype(np.float32)
    points = o3d.core.Tensor(rays[:, :3].copy())
    queries = {
        "cast_rays": (rays,),
        "count_intersections": (rays,),
        "test_occlusions": (rays, 0.2, 0.8),
        "compute_occupancy": (points,),
        "compute_signed_distance": (points,),
    }
    for name, arguments in queries.items():
        expected, found = getattr(theirs, name)(*arguments), getattr(ours, name)(*arguments)
        if not isinstance(expected, dict):
            expected, found = {name: expected}, {name: found}
        assert set(expected) == set(found)
        for column in expected:
            a, b = expected[column].numpy(), found[column].numpy()
            assert a.dtype == b.dtype and a.shape == b.shape
            np.testing.assert_allclose(b, a, rtol=1e-3, atol=1e-4)
    assert type(ours.compute_distance(points)) is o3d.core.Tensor
    for view in (
        {"fov_deg": 60, "center": [0, 0, 0], "eye": [1, 2, 5], "up": [0, 1, 0]},
        {"intrinsic_matrix": np.array([(90, 5, 16), (0, 80, 12), (0, 0, 1.0)]), "extrinsic_matrix": np.eye(4)},
    ):
        pixels = [scene.create_rays_pinhole(**view, width_px=4, height_px=3).numpy() for scene in (theirs, ours)]
        np.testing.assert_allclose(pixels[1], pixels[0], atol=1e-6)
