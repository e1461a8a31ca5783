"""Rows of answers: points, names, selections and other forms."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest
import shotline
from shotline import Scene, Sphere


@pytest.fixture(scope="module")
def answers(sample_scene, sample_rays):
    o, d = sample_rays
    return [getattr(sample_scene, query)(o, d) for query in ("closest", "crossings", "segments", "cost")]


def same(one, other):
    assert type(one) is type(other)
    for a, b in zip(one, other, strict=True):
        assert a is b is None or (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes())
    return True


def test_points_and_distances(sample_scene, sample_rays, answers):
    o, d = sample_rays
    hits, rows, segments, _ = answers
    hit = np.isfinite(hits.t)
    assert hit.any() and not hit.all() and np.isnan(hits.points[~hit]).all() and np.isinf(hits.distance[~hit]).all()
    assert np.array_equal(hits.points[hit], (o + hits.t[:, None] * d)[hit])
    np.testing.assert_allclose(np.linalg.norm(hits.points - o, axis=1)[hit], hits.distance[hit], rtol=1e-12)
    assert np.array_equal(rows.points, o[rows.ray_ids] + rows.t[:, None] * d[rows.ray_ids])
    np.testing.assert_allclose(rows.distance, rows.t * np.linalg.norm(d, axis=1)[rows.ray_ids])
    assert segments.points.shape == (len(segments), 2, 3) and segments.distance.shape == (len(segments), 2)
    np.testing.assert_allclose(np.diff(segments.distance, axis=1)[:, 0], segments.length, rtol=1e-9)


def test_points_of_rays_of_all_forms(sample_scene):
    o, d = np.zeros((4, 1, 3)) - [0, 0, 9], np.random.default_rng(1).normal(size=(5, 3)) * 0.1 + [0, 0, 1]
    spread = sample_scene.closest(o, d)
    hit = np.isfinite(spread.t)
    assert spread.points.shape == (4, 5, 3) and np.isnan(spread.points[~hit]).all()
    assert np.array_equal(spread.points[hit], (o + spread.t[..., None] * d)[hit])
    both = sample_scene.closest(np.concatenate(np.broadcast_arrays(o, d), axis=-1))
    assert both.points.tobytes() == spread.points.tobytes() and both.distance.tobytes() == spread.distance.tobytes()
    shared = sample_scene.crossings(o[0, 0], d)
    assert np.array_equal(shared.points, o[0, 0] + shared.t[:, None] * d[shared.ray_ids])
    one = sample_scene.closest([-1, 0, -9], [0, 0, 2])
    assert one.points.tolist() == [-1, 0, float(one.t) * 2 - 9] and one.distance == 2 * one.t
    assert sample_scene.closest(np.zeros((0, 3)), [1, 0, 0]).points.shape == (0, 3)
    inside = Scene(Sphere(radius=1)).crossings([0, 0, 0], [1, 0, 0])
    assert inside.points.tolist() == [[0, 0, 0], [1, 0, 0]]
    endless = Scene(shotline.Halfspace(normal=(0, 0, 1), offset=0)).crossings([0, 0, 0.5], [0, 0, -1])
    assert endless.t.tolist() == [0.5, np.inf] and np.isnan(endless.points[1]).all()


def test_names(sample_scene, answers):
    hits, rows, segments, _ = answers
    for result in (hits, rows, segments):
        expected = [sample_scene.object_names[i] if i >= 0 else None for i in result.object.tolist()]
        assert result.object_names().tolist() == expected
        paths = [sample_scene.path_name(i) if i >= 0 else None for i in result.path.tolist()]
        assert result.path_names().tolist() == paths
    surfaces = [sample_scene.surface_name(i) if i >= 0 else None for i in rows.surface.tolist()]
    assert rows.surface_names().tolist() == surfaces
    assert None in hits.surface_names() and hits.surface_names().shape == hits.t.shape
    assert set(segments.material_names()) == {"steel", "brass"}
    bare = Scene(Sphere(radius=1)).segments([-3, 0, 0], [1, 0, 0])
    assert bare.material_names().tolist() == [None] and bare.object_names().tolist() == ["object0"]
    assert Scene(Sphere(radius=1).named("a")).measure().object_names().tolist() == ["a"]
    with pytest.raises(KeyError, match="not among the fields"):
        sample_scene.closest([0, 0, -9], [0, 0, 1], fields=["t"]).object_names()
    with pytest.raises(ValueError, match="by hand"):
        shotline.Closest(*hits).points


def test_rows_are_selected_by_index_slice_and_mask(answers):
    hits, _, _, cost = answers
    for key in (slice(3, 90, 7), [4, 2, 2], np.isfinite(hits.t), -1, np.int64(5), [], np.arange(0)):
        some, ids = hits[key], np.arange(500)[np.array(key, int) if isinstance(key, list) else key]
        assert isinstance(some, shotline.Closest) and len(some) == ids.size
        for name, column in some.to_dict().items():
            assert np.array_equal(column, hits[name][ids], equal_nan=column.dtype.kind == "f")
        assert np.array_equal(some.points, hits.points[ids], equal_nan=True)
        assert np.array_equal(some.distance, hits.distance[ids])
    assert hits[7].t.shape == () and hits.ray(7).t == hits.t[7] and hits[100:][5:][3].points.shape == (3,)
    assert cost[3:5].all.tolist() == cost.all[3:5].tolist() and len(cost) == 500
    for wrong in (500, -501, np.ones(3, bool)):
        with pytest.raises(IndexError):
            hits[wrong]
    with pytest.raises(TypeError, match="chosen by numbers, slices and masks"):
        hits[1.5]
    with pytest.raises(IndexError, match="500 rays"):
        hits.ray(500)


def test_selections_of_lists_choose_rays(answers):
    _, rows, segments, _ = answers
    for result in (rows, segments):
        counts = np.diff(result.ray_splits)
        for key in (slice(3, 90, 7), [4, 2, 2], counts > 2, 17, [], slice(0, 0)):
            ids = np.atleast_1d(np.arange(500)[np.array(key, int) if isinstance(key, list) else key])
            some = result[key]
            assert type(some) is type(result) and some.ray_splits.dtype == np.int64
            assert np.diff(some.ray_splits).tolist() == counts[ids].tolist()
            spans = [np.arange(*result.ray_splits[[i, i + 1]]) for i in ids]
            kept = np.concatenate([np.arange(0), *spans]).astype(int)
            for name, column in some.to_dict().items():
                if name != "ray_splits":
                    assert np.array_equal(column, result[name][kept], equal_nan=column.dtype.kind == "f")
            assert np.array_equal(some.points, result.points[kept])
        busy = int(np.argmax(counts))
        assert len(result.ray(busy)) == counts[busy] and len(result.ray(busy).ray_splits) == 2
        assert np.array_equal(result[10:][5:].ray(2).points, result.ray(17).points)


def test_rays_of_several_axes_have_indices(sample_scene):
    o = np.stack(np.meshgrid(np.linspace(-2, 2, 4), np.linspace(-2, 2, 5), [-9.0], indexing="ij"), -1)[:, :, 0]
    hits, rows = sample_scene.closest(o, [0, 0, 1]), sample_scene.crossings(o, [0, 0, 1])
    assert len(hits) == 20 and hits[2, 3].t == hits.t[2, 3] == hits.ray(13).t == hits.ray((2, 3)).t
    assert hits[1:3, ::2].t.tolist() == hits.t[1:3, ::2].tolist()
    assert hits[1:3, ::2].points.shape == (2, 3, 3)
    mask = np.isfinite(hits.t)
    assert np.array_equal(hits[mask].points, hits.points[mask])
    assert rows.ray((2, 3)).t.tolist() == rows.ray(13).t.tolist() == rows[2, 3].t.tolist()
    assert len(rows[mask]) == len(rows)


def test_unpacking_and_membership(answers):
    hits, rows, *_ = answers
    t, normal, *_ = hits
    assert t is hits.t and normal is hits.normal and len(tuple(rows)) == 10
    assert "t" in hits and "t_hit" in hits and "tee" not in hits and "ray_ids" in rows
    with pytest.raises(AttributeError):
        hits.t = 3
    with pytest.raises(TypeError):
        reversed(hits)


def test_pickles_keep_rays_and_names_without_the_scene(sample_scene, sample_rays, answers):
    for result in (*answers, sample_scene.measure(rays=1000)):
        again = pickle.loads(pickle.dumps(result))
        assert same(again, result) and same(copy.deepcopy(result), result) and repr(again) == repr(result)
    hits, rows, *_ = answers
    some = pickle.loads(pickle.dumps(hits[:10]))
    assert some.points.tobytes() == hits.points[:10].tobytes()
    assert len(pickle.dumps(hits[:10])) < len(pickle.dumps(hits)) / 10
    again = pickle.loads(pickle.dumps(rows))
    assert again.path_names().tolist() == rows.path_names().tolist()
    assert same(pickle.loads(pickle.dumps(again)), rows)


def test_tables_show_names_and_misses(answers):
    hits, rows, segments, _ = answers
    mixed = hits[np.r_[np.flatnonzero(np.isinf(hits.t))[:1], np.flatnonzero(np.isfinite(hits.t))[:1]]]
    head, miss, hit = repr(mixed).splitlines()[1:]
    assert miss.split() == ["0", "miss"] and mixed.object_names()[1] in hit.split()
    assert "block" in repr(rows) and "steel" in repr(segments)
    page = hits._repr_html_()
    assert page.count("<tr>") == 12 and "<th>surface</th>" in page and "miss" in page
    assert "&lt;b&gt;" in Scene(Sphere(radius=1).named("<b>")).closest([-3, 0, 0], [1, 0, 0])._repr_html_()


def test_saved_files_are_those_of_the_command(tmp_path, sample_scene, sample_rays):
    o, d = sample_rays
    sample_scene.save(tmp_path / "part.json")
    np.save(tmp_path / "rays.npy", np.hstack([o, d]))
    for query in ("closest", "crossings", "segments"):
        words = [sys.executable, "-m", "shotline", "cast", "part.json", "--rays", "rays.npy", "--query", query]
        subprocess.run([*words, "-o", "command.npz"], cwd=tmp_path, check=True, capture_output=True)
        getattr(sample_scene, query)(o, d).save(tmp_path / "python.npz")
        with np.load(tmp_path / "command.npz") as command, np.load(tmp_path / "python.npz") as python:
            assert sorted(command) == sorted(python) and "path_names" in python
            for name, column in command.items():
                assert (python[name].dtype, python[name].shape) == (column.dtype, column.shape), name
                assert python[name].tobytes() == column.tobytes(), name
    assert sorted(path.name for path in tmp_path.iterdir() if "tmp" in path.name) == []
    sample_scene.closest(o, d, fields=["t"]).save(tmp_path / "few.NPZ")
    with np.load(tmp_path / "few.NPZ") as few:
        assert sorted(few) == ["material_names", "object_names", "t"]
    with pytest.raises(ValueError, match="saved as .npz"):
        sample_scene.closest(o, d).save(tmp_path / "x.csv")
    with pytest.raises(OSError):
        sample_scene.closest(o, d).save(tmp_path / "no" / "x.npz")


def test_pandas(answers, sample_scene):
    pytest.importorskip("pandas", reason="pandas is not installed")
    hits, rows, segments, _ = answers
    frame = hits.to_pandas()
    assert len(frame) == 500 and frame["normal_z"].dtype == np.float64
    assert frame["object"].isna().sum() == np.isinf(hits.t).sum()
    table = rows.to_pandas()
    assert table["ray"].tolist() == rows.ray_ids.tolist() and table.columns[0] == "ray"
    lengths = segments.to_pandas().groupby("material", observed=True)["length"].sum()
    assert lengths["steel"] == pytest.approx(segments.length[segments.material_names() == "steel"].sum())
    measures = sample_scene.measure(rays=1000).to_pandas()
    assert {"centroid_x", "inertia_xz", "bounds_min_y", "bounds_max_z"} <= set(measures.columns)


def test_awkward(answers):
    awkward = pytest.importorskip("awkward", reason="awkward is not installed")
    _, rows, segments, _ = answers
    lists = rows.to_awkward()
    assert len(lists) == 500 and awkward.num(lists).tolist() == np.diff(rows.ray_splits).tolist()
    assert np.array_equal(awkward.flatten(lists.normal).to_numpy(), rows.normal, equal_nan=True)
    assert awkward.sum(segments.to_awkward().length, axis=1)[3] == pytest.approx(segments.ray(3).length.sum())


@pytest.mark.parametrize("package, method", [("pandas", "to_pandas"), ("awkward", "to_awkward")])
def test_absent_packages_are_named(monkeypatch, answers, package, method):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=f"{method} needs {package}: pip install"):
        getattr(answers[1], method)()
