import subprocess
import sys

import numpy as np
import pytest
import shotline
from shotline import Box, Scene, Sphere

BALL = Scene(Sphere(radius=1).named("ball"))
QUERIES = ["closest", "any", "count", "crossings", "segments", "thickness"]


def arrays(result):
    return (result,) if isinstance(result, np.ndarray) else tuple(result)


def same(a, b):
    return all(
        x.dtype == y.dtype and x.shape == y.shape and x.tobytes() == y.tobytes()
        for x, y in zip(arrays(a), arrays(b), strict=True)
    )


def test_shapes_broadcast():
    for o, d, shape in [
        ((3,), (3,), ()),
        ((5, 3), (3,), (5,)),
        ((3,), (5, 3), (5,)),
        ((2, 1, 3), (4, 3), (2, 4)),
        ((1, 3), (3,), (1,)),
        ((0, 3), (3,), (0,)),
        ((2, 0, 3), (0, 3), (2, 0)),
    ]:
        origins, directions = np.zeros(o) + [0.1, 0.2, -5], np.zeros(d) + [0, 0, 1]
        hits = BALL.closest(origins, directions)
        assert hits.t.shape == shape and hits.normal.shape == (*shape, 3)
        assert all(column.shape == shape for name, column in hits.to_dict().items() if name != "normal")
        assert BALL.any(origins, directions).shape == BALL.count(origins, directions).shape == shape
        assert len(BALL.crossings(origins, directions).ray_splits) == np.prod(shape, dtype=int) + 1
        both = np.concatenate(np.broadcast_arrays(origins, directions), -1)
        assert same(BALL.closest(both), BALL.closest(*np.broadcast_arrays(origins, directions)))


def test_dtypes():
    hits = BALL.closest(np.zeros((2, 3)) - [0, 0, 5], [[0, 0, 1], [0, 0, -1]])
    assert {name: str(column.dtype) for name, column in hits.to_dict().items()} == {
        "t": "float64", "normal": "float64", "object": "int32", "surface": "int32", "primitive": "int32",
        "path": "int64", "entering": "bool", "t_err": "float64",
    }  # fmt: skip
    assert hits.t.tolist() == [4.0, np.inf] and hits.object.tolist() == [0, -1] and hits.path.tolist() == [0, -1]
    assert np.isnan(hits.normal[1]).all() and np.isnan(hits.t_err[1]) and hits.entering.tolist() == [True, False]
    rows = BALL.crossings([0, 0, -5], [0, 0, 1])
    assert {name: str(column.dtype) for name, column in rows.to_dict().items()} == {
        "ray_splits": "int64", "t": "float64", "normal": "float64", "entering": "bool", "object": "int32",
        "surface": "int32", "primitive": "int32", "path": "int64", "kind": "int8", "t_err": "float64",
    }  # fmt: skip
    segments = BALL.segments([0, 0, -5], [0, 0, 2])
    assert {name: str(column.dtype) for name, column in segments.to_dict().items()} == {
        "ray_splits": "int64", "t_in": "float64", "t_out": "float64", "length": "float64", "material": "int32",
        "object": "int32", "path": "int64",
    }  # fmt: skip
    assert segments.length.tolist() == [2.0] and segments.t_in.tolist() == [2.0]
    assert str(BALL.any([0, 0, -5], [0, 0, 1]).dtype) == "bool"
    assert str(BALL.count([0, 0, -5], [0, 0, 1]).dtype) == "int64"


def test_any_strides_and_byte_orders(sample_scene, sample_rays):
    o, d = sample_rays
    wide = np.zeros((1000, 9))
    wide[::2, 1:7:2], wide[::2, 2:8:2] = o, d
    for query in QUERIES:
        cast = getattr(sample_scene, query)
        expected = cast(o, d)
        assert same(cast(wide[::2, 1:7:2], wide[::2, 2:8:2]), expected)
        assert same(cast(np.asfortranarray(o), d.astype(">f8")), expected)
        assert same(cast(o[::-1][::-1], d.tolist()), expected)
        assert same(cast(np.concatenate([o, d], 1)), expected)
    assert sample_scene.closest(o.astype(np.float32), d).t.dtype == np.float64


def test_arrays_of_the_right_type_are_read_in_place():
    from shotline.rays import rays

    o, d = np.zeros((7, 3)), np.ones((7, 3))
    converted = rays(o, d)
    assert np.shares_memory(converted.origins, o) and np.shares_memory(converted.directions, d)
    both = np.ones((2, 3, 6))
    assert np.shares_memory(rays(both, None).origins, both)
    assert rays([0, 0, 0], d).origins.shape == (3,)


def test_results_are_returned_without_a_copy(sample_scene, sample_rays):
    rows = sample_scene.crossings(*sample_rays)
    for column in rows:
        assert column.flags.c_contiguous and column.flags.writeable
        base = column if column.base is None else column.base
        assert type(base).__name__ == "PySliceContainer" or type(base.base).__name__ == "PySliceContainer"


def test_threads_and_accelerators_change_no_bit(sample_scene, sample_rays):
    for query in QUERIES:
        expected = getattr(sample_scene, query)(*sample_rays, threads=1)
        assert same(getattr(sample_scene, query)(*sample_rays, threads=3), expected)
        for accel in ["brute", "grid", "bsp"]:
            import pickle

            words, meshes = sample_scene._pack()
            other = pickle.loads(pickle.dumps(sample_scene))
            other._native = shotline._native.Scene.parse(words, meshes, accel)
            assert same(getattr(other, query)(*sample_rays), expected)


def test_the_same_bits_as_the_command(sample_scene, sample_rays, tmp_path):
    o, d = sample_rays
    sample_scene.save(tmp_path / "part.json")
    np.save(tmp_path / "rays.npy", np.concatenate([o, d], 1))
    for query in QUERIES:
        words = [
            sys.executable,
            "-m",
            "shotline",
            "cast",
            "part.json",
            "--rays",
            "rays.npy",
            "--query",
            query,
            "-o",
            "out.npz",
        ]
        subprocess.run(words, cwd=tmp_path, check=True, capture_output=True)
        result = getattr(sample_scene, query)(o, d)
        columns = {query: result} if isinstance(result, np.ndarray) else result.to_dict()
        with np.load(tmp_path / "out.npz") as written:
            assert written["object_names"].tolist() == sample_scene.object_names
            for name, column in columns.items():
                if name == "path":
                    column = np.unique(column[column >= 0], return_inverse=True)[1]
                    assert written[name][written[name] >= 0].tolist() == column.tolist()
                else:
                    assert same(written[name], column), name


def test_spans():
    scene = Scene(Sphere(radius=1), Sphere(radius=1).translate(0, 0, 5))
    o, d = [0, 0, -3], [0, 0, 1]
    assert scene.crossings(o, d).t.tolist() == [2, 4, 7, 9]
    rows = scene.crossings(o, d, t_min=3, t_max=8)
    assert rows.t.tolist() == [3, 4, 7, 8] and rows.kind.tolist() == [1, 0, 0, 2]
    assert int(scene.count(o, d, t_min=4.5, t_max=6)) == 0 and not scene.any(o, d, t_min=4.5, t_max=6)
    inside = scene.closest([0, 0, 0], d)
    assert float(inside.t) == 0 and np.isnan(inside.normal).all() and int(inside.surface) == -1 and inside.entering


@pytest.mark.parametrize("query", QUERIES)
def test_bad_rays_are_named(query):
    cast = getattr(BALL, query)
    d = np.ones((4, 5, 3))
    d[2, 3] = 0
    with pytest.raises(ValueError, match="ray 13: the direction is zero"):
        cast([0, 0, 0], d)
    o = np.zeros((100_000, 3))
    o[77_777, 1] = np.nan
    with pytest.raises(ValueError, match="ray 77777: the origin") as raised:
        cast(o, [1, 0, 0])
    assert raised.value.row == 77777
    for o, d, message in [
        (np.zeros((3, 3)), np.ones((2, 3)), "do not broadcast"),
        (np.zeros((3, 2)), np.ones(3), r"\(\.\.\., 3\)"),
        (np.zeros((3, 3)), None, r"\(\.\.\., 6\)"),
        (0.0, np.ones(3), r"\(\.\.\., 3\)"),
    ]:
        with pytest.raises(ValueError, match=message):
            cast(o, d)
    for span in [{"t_min": 2, "t_max": 1}, {"t_min": np.nan}, {"t_min": -np.inf}]:
        with pytest.raises(ValueError, match="interval"):
            cast([0, 0, 0], [1, 0, 0], **span)
    with pytest.raises(TypeError, match="complex"):
        cast(np.zeros(3, complex), [1, 0, 0])
    for threads in (-1, 10_000):
        with pytest.raises(ValueError, match="threads"):
            cast([0, 0, 0], [1, 0, 0], threads=threads)


def test_overlaps():
    scene = Scene(Sphere(radius=1).named("a"), Sphere(radius=1).translate(1, 0, 0).named("b"))
    o, d = [-5, 0, 0], [1, 0, 0]
    with pytest.raises(ValueError, match="'a' and 'b'|a and b"):
        scene.segments(o, d)
    assert scene.segments(o, d, overlaps="all").t_out.tolist() == [6, 7]
    with pytest.warns(shotline.OverlapWarning, match="1 overlap of"):
        assert scene.segments(o, d, overlaps="priority").t_out.tolist() == [5, 7]
    with pytest.warns(shotline.OverlapWarning, match="2 overlaps of"):
        scene.thickness([o, o], d, overlaps="priority")
    with pytest.raises(ValueError, match="overlaps"):
        scene.segments(o, d, overlaps="perhaps")


def test_thickness_is_the_sum_of_segments(sample_scene, sample_rays):
    o, d = sample_rays
    segments = sample_scene.segments(o, d, overlaps="priority")
    expected, by_object = np.zeros((len(o), 3)), np.zeros((len(o), 2))
    np.add.at(by_object, (segments.ray_ids, segments.object), segments.length)
    np.add.at(expected, (segments.ray_ids, segments.material), segments.length)
    lengths = sample_scene.thickness(o, d, overlaps="priority")
    assert sample_scene.thickness(o, d, by="object", overlaps="priority").tobytes() == by_object.tobytes()
    assert lengths.shape == (500, 3) and lengths.tobytes() == expected.tobytes() and (lengths > 0).sum() > 300
    assert sample_scene.thickness(o.reshape(50, 10, 3), d[0]).shape == (50, 10, 3)
    assert sample_scene.thickness(np.zeros((0, 3)), [0, 0, 1]).shape == (0, 3)
    assert sample_scene.thickness([0, 0, 9], [0, 0, -2]).shape == (3,)


def test_thickness_without_material_is_in_the_last_column():
    mixed = Scene(
        Sphere(radius=1).named("ball"),
        Sphere(radius=1).translate(0, 0, 3).named("lead", "lead"),
        materials={"lead": {}},
    )
    assert BALL.thickness([[0, 0, -5]] * 3, [0, 0, 1]).tolist() == [[2], [2], [2]]
    assert mixed.thickness([0, 0, -5], [0, 0, 2]).tolist() == [2, 2]
    assert mixed.thickness([0, 0, -5], [0, 0, 2], t_max=3).tolist() == [0, 2]
    assert Scene().thickness([0, 0, -5], [0, 0, 1]).tolist() == [0]
    assert Scene().thickness([[0, 0, -5]], [0, 0, 1], by="object").shape == (1, 0)
    with pytest.raises(ValueError, match="by is 'objects': did you mean 'object'"):
        BALL.thickness([0, 0, -5], [0, 0, 1], by="objects")


def test_points_inside_objects(rng):
    scene = Scene(Sphere(radius=1).named("a"), Box(min=(0, 0, 0), max=(2, 2, 2)).named("b"))
    p = rng.uniform(-1.5, 2.5, (40, 50, 3))
    in_a, in_b = (p**2).sum(-1) < 1, ((p > 0) & (p < 2)).all(-1)
    inside = scene.contains(p)
    assert inside.shape == (40, 50) and inside.dtype == bool and (inside == in_a | in_b).all()
    splits, objects = scene.objects_at(p)
    assert splits.dtype == np.int64 and objects.dtype == np.int32
    assert objects.tolist() == [
        i for a, b in zip(in_a.flat, in_b.flat, strict=True) for i in [0] * int(a) + [1] * int(b)
    ]
    assert (np.diff(splits) == in_a.astype(int).ravel() + in_b.ravel()).all()
    assert scene.contains([0, 0, 0.5]).shape == () and scene.contains(np.zeros((0, 3))).shape == (0,)
    p[3, 4, 0] = np.nan
    with pytest.raises(ValueError, match="point 154"):
        scene.contains(p)
    with pytest.raises(ValueError, match="shape"):
        scene.contains([1, 2])


def test_costs(sample_scene, sample_rays):
    cost = sample_scene.cost(*sample_rays)
    assert all(column.shape == (500,) and column.dtype == np.int64 for column in cost)
    assert (cost.all == cost.boxes + cost.cells + cost.planes + cost.solids).all() and cost.boxes.min() >= 1
    assert cost._fields == tuple(name for name, _ in shotline._native.counters())
    assert repr(cost).startswith("costs of rays of shape (500,)")
    assert sample_scene.cost([0, 0, 9], [0, 0, -1]).solids.shape == ()


def test_no_leaks_at_edges_and_vertices(rng):
    """Rays through vertices and edges of a closed mesh enter and exit alternately, and always exit."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
    mesh = shotline.Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    scene = Scene(mesh)
    i, j = rng.integers(0, 4, (2, 20_000))
    aims = corners[i] + (corners[j] - corners[i]) * rng.integers(0, 3, (20_000, 1)) / 2
    o = rng.normal(size=(20_000, 3)) * 3
    rows = scene.crossings(o, aims - o)
    assert (np.diff(rows.ray_splits) % 2 == 0).all()
    assert (rows.entering[::2] & ~rows.entering[1::2]).all()
    assert (scene.count(o, aims - o) == np.diff(rows.ray_splits)).all()


def test_boxes_abut_without_a_seam():
    stack = Box(min=(0, 0, 0), max=(1, 1, 0.1)) | Box(min=(0, 0, 0.1), max=(1, 1, 0.3))
    assert Scene(stack).crossings([0.5, 0.5, -1], [0, 0, 1]).t.tolist() == [1.0, 1.3]
