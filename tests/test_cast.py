"""`shotline cast`: names and types of the arrays, and results compared with formulas."""

import csv
import json

import numpy as np
import pytest
from command import attempt, cast, object_scene, run

PER_HIT = {
    "t": "f8",
    "t_err": "f8",
    "normal": "f8",
    "object": "i4",
    "surface": "i4",
    "primitive": "i4",
    "path": "i8",
    "entering": "?",
}
ARRAYS = {
    "closest": PER_HIT,
    "any": {"any": "?"},
    "count": {"count": "i8"},
    "crossings": PER_HIT | {"ray_splits": "i8", "kind": "i1"},
    "segments": {
        "ray_splits": "i8",
        "t_in": "f8",
        "t_out": "f8",
        "length": "f8",
        "material": "i4",
        "object": "i4",
        "path": "i8",
    },
    "thickness": {"thickness": "f8"},
}
TABLES = {
    "closest": {"object_names", "material_names", "path_names"},
    "any": {"object_names", "material_names"},
    "count": {"object_names", "material_names"},
    "crossings": {"object_names", "material_names", "path_names"},
    "segments": {"object_names", "material_names", "path_names"},
    "thickness": {"object_names", "material_names"},
}

BALL = {"kind": "sphere", "radius": 1.25}
CUBE = {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}
# The ball protrudes through the six faces of the cube.
HOLLOWED = {"op": "difference", "args": [CUBE, BALL]}
SCENE = {
    "shotline": 1,
    "units": "mm",
    "materials": {"steel": {}, "air": {}},
    "objects": [
        {"name": "frame", "material": "steel", "node": HOLLOWED},
        {
            "name": "ring",
            "material": "air",
            "node": {
                "op": "group",
                "args": [{"kind": "torus", "R": 2, "r": 0.25}, {"kind": "torus", "R": 3, "r": 0.25}],
            },
        },
    ],
}


def random_rays(n, seed=7):
    """Rays from a ball of radius 5 towards points near the origin."""
    rng = np.random.default_rng(seed)
    origin = rng.normal(size=(n, 3))
    origin *= 5 / np.linalg.norm(origin, axis=1, keepdims=True)
    target = rng.uniform(-1.5, 1.5, size=(n, 3))
    return np.hstack([origin, (target - origin) * rng.uniform(0.1, 3, size=(n, 1))])


def lists(arrays, name="t"):
    """The rows of an array, as one list per ray."""
    return np.split(arrays[name], arrays["ray_splits"][1:-1])


@pytest.mark.parametrize("query", ARRAYS)
@pytest.mark.parametrize("n", [0, 1, 500])
def test_names_and_types(tmp_path, query, n):
    arrays = cast(tmp_path, SCENE, random_rays(n), query)
    assert set(arrays) == set(ARRAYS[query]) | TABLES[query]
    for name, dtype in ARRAYS[query].items():
        assert arrays[name].dtype == np.dtype(dtype), name
    rows = n
    if "ray_splits" in arrays:
        splits = arrays["ray_splits"]
        assert splits.shape == (n + 1,) and splits[0] == 0 and (np.diff(splits) >= 0).all()
        rows = splits[-1]
    for name in set(ARRAYS[query]) - {"ray_splits"}:
        # The columns of thickness: two materials, and no material.
        assert arrays[name].shape == ((rows, 3) if name in ("normal", "thickness") else (rows,)), name


@pytest.mark.parametrize("query", ARRAYS)
def test_names_are_looked_up_in_tables(tmp_path, query):
    arrays = cast(tmp_path, SCENE, random_rays(500), query)
    for table in TABLES[query]:
        assert arrays[table].dtype.kind == "U"
    assert list(arrays["object_names"]) == ["frame", "ring"]
    assert sorted(arrays["material_names"]) == ["air", "steel"]
    for column in {"object", "material", "path"} & set(arrays):
        known = arrays[column][arrays[column] >= 0]
        assert set(known) == set(range(len(arrays[column + "_names"]))), column
    if "path_names" in arrays:
        hit = arrays["path"] >= 0
        objects = arrays["object_names"][arrays["object"][hit]]
        paths = arrays["path_names"][arrays["path"][hit]]
        assert all(name in path for name, path in zip(objects, paths, strict=False))


@pytest.mark.parametrize("query", ARRAYS)
def test_same_bits_for_every_accelerator_and_number_of_threads(tmp_path, query):
    rays = random_rays(5000)
    first = None
    for accel in ["brute", "bvh"]:
        for threads in [1, 2]:
            arrays = cast(tmp_path, SCENE, rays, query, "--accel", accel, "--threads", threads)
            found = {name: array.tobytes() for name, array in arrays.items()}
            first = first or found
            assert found == first, (accel, threads)


def test_stats_are_one_line_of_json(tmp_path):
    answer = attempt(tmp_path, SCENE, random_rays(100), "closest", "--stats", "--threads", "2", "--accel", "bvh")
    assert answer.returncode == 0 and answer.stdout.count("\n") == 1
    stats = json.loads(answer.stdout)
    keys = {"rays", "threads", "accel", "load_s", "build_s", "cast_s", "rays_per_s", "memory_bytes", "repaired"}
    assert keys <= set(stats)
    assert (stats["rays"], stats["threads"], stats["accel"], stats["repaired"]) == (100, 2, "bvh", 0)
    assert stats["rays_per_s"] > 0 and stats["memory_bytes"] > 0


def test_queries_agree(tmp_path):
    rays = random_rays(2000)
    found = {query: cast(tmp_path, SCENE, rays, query) for query in ARRAYS}
    per_ray = np.diff(found["crossings"]["ray_splits"])
    assert (found["count"]["count"] == per_ray).all()
    assert (found["any"]["any"] == (per_ray > 0)).all()
    first = found["crossings"]["ray_splits"][:-1][per_ray > 0]
    for name in ["t", "normal", "object", "surface", "primitive", "entering"]:
        assert (found["closest"][name][per_ray > 0] == found["crossings"][name][first]).all(), name
    missed = per_ray == 0
    assert np.isinf(found["closest"]["t"][missed]).all() and np.isnan(found["closest"]["normal"][missed]).all()
    assert (found["closest"]["object"][missed] == -1).all() and (found["closest"]["path"][missed] == -1).all()
    segments = found["segments"]
    assert (np.diff(segments["ray_splits"]) * 2 == per_ray).all()
    ray = np.repeat(np.arange(len(rays)), np.diff(segments["ray_splits"]))
    lengths = (segments["t_out"] - segments["t_in"]) * np.linalg.norm(rays[ray, 3:], axis=1)
    assert np.allclose(segments["length"], lengths, rtol=1e-12, atol=0)
    by_object = cast(tmp_path, SCENE, rays, "thickness", "--by", "object")["thickness"]
    for thickness, column, count in [(found["thickness"]["thickness"], "material", 3), (by_object, "object", 2)]:
        total = np.zeros((len(rays), count))
        np.add.at(total, (ray, segments[column]), segments["length"])
        assert thickness.tobytes() == total.tobytes(), column


def test_thickness_without_materials_is_in_the_last_column(tmp_path):
    scene = {"shotline": 1, "objects": [{"name": "ball", "node": BALL}]}
    rays = np.array([[-5, 0, 0, 2, 0, 0], [-5, 2, 0, 2, 0, 0.0]])
    thickness = cast(tmp_path, scene, rays, "thickness")["thickness"]
    assert thickness.tolist() == [[2.5], [0]]


def through_ball(rays, radius):
    """The t at which rays cross a ball about the origin, in extended precision; NaN where they miss it."""
    o, d = rays[:, :3].astype(np.longdouble), rays[:, 3:].astype(np.longdouble)
    a, b, c = (d * d).sum(1), (o * d).sum(1), (o * o).sum(1) - np.longdouble(radius) ** 2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - a * c)
    return (-b - root) / a, (-b + root) / a


def through_cube(rays):
    """The t at which rays cross the cube from -1 to 1; NaN where they miss it."""
    o, d = rays[:, :3].astype(np.longdouble), rays[:, 3:].astype(np.longdouble)
    low, high = np.sort([(-1 - o) / d, (1 - o) / d], axis=0)
    low, high = low.max(1), high.min(1)
    return np.where(low < high, low, np.nan), np.where(low < high, high, np.nan)


def test_ball_by_formula(tmp_path):
    rays = random_rays(2000)
    arrays = cast(tmp_path, object_scene(BALL), rays, "crossings")
    expected = [[] if np.isnan(pair[0]) else list(pair) for pair in zip(*through_ball(rays, 1.25), strict=False)]
    assert_crossings(arrays, expected)
    points = rays[ray_of(arrays), :3] + arrays["t"][:, None] * rays[ray_of(arrays), 3:]
    assert np.allclose(arrays["normal"], points / 1.25, atol=1e-12)


def test_cube_minus_ball_by_formula(tmp_path):
    rays = random_rays(2000)
    arrays = cast(tmp_path, object_scene(HOLLOWED), rays, "crossings")
    expected = []
    for a, b, c, d in zip(*through_cube(rays), *through_ball(rays, 1.25), strict=False):
        inside = [] if np.isnan(a) else [(a, b)] if np.isnan(c) else [(a, min(b, c)), (max(a, d), b)]
        expected.append([t for pair in inside if pair[0] < pair[1] for t in pair])
    assert_crossings(arrays, expected)
    # The normal points out of the result: into the ball where the ball was subtracted.
    ray = ray_of(arrays)
    facing = (arrays["normal"] * rays[ray, 3:]).sum(1) < 0
    assert (facing == arrays["entering"]).all()
    assert np.allclose(np.linalg.norm(arrays["normal"], axis=1), 1)


def ray_of(arrays):
    return np.repeat(np.arange(len(arrays["ray_splits"]) - 1), np.diff(arrays["ray_splits"]))


def assert_crossings(arrays, expected):
    """The counts are the same, every t is within its own bound, and entering and exiting alternate."""
    assert [len(row) for row in lists(arrays)] == [len(row) for row in expected]
    assert max(len(row) for row in expected) >= 2 and min(len(row) for row in expected) == 0
    exact = np.array([t for row in expected for t in row], dtype=np.longdouble)
    assert (np.abs(arrays["t"] - exact) <= arrays["t_err"] + np.spacing(arrays["t"])).all()
    assert (arrays["t_err"] < 1e-13 * np.abs(arrays["t"]).clip(1)).mean() > 0.99
    place = np.concatenate([np.arange(len(row)) for row in expected])
    assert (arrays["entering"] == (place % 2 == 0)).all()
    assert (arrays["kind"] == 0).all() and (arrays["object"] == 0).all() and (arrays["primitive"] == -1).all()


def test_lists_begin_and_end_inside(tmp_path):
    inside = np.array([[0, 0, 0, 0, 0, 0.5]])
    arrays = cast(tmp_path, object_scene(BALL), inside, "crossings")
    assert arrays["t"].tolist() == [0, 2.5] and arrays["kind"].tolist() == [1, 0]
    below = {"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}
    down = np.array([[0, 0, 4, 0, 0, -2.0]])
    arrays = cast(tmp_path, object_scene(below), down, "crossings")
    assert arrays["t"].tolist() == [2, np.inf] and arrays["kind"].tolist() == [0, 2]
    assert arrays["entering"].tolist() == [True, False]


def test_a_bad_row_is_named_or_missed(tmp_path):
    rays = random_rays(10)
    rays[3, 4] = np.nan
    rays[7, 3:] = 0
    answer = attempt(tmp_path, SCENE, rays, "count")
    assert answer.returncode == 2 and "row 3" in answer.stderr and not (tmp_path / "out.npz").exists()
    counts = cast(tmp_path, SCENE, rays, "count", "--on-invalid", "miss")["count"]
    assert len(counts) == 10 and counts[3] == 0 and counts[7] == 0


def test_rays_and_results_as_csv(tmp_path):
    rays = np.array([[-3, 0.5, 0.25, 2, 0, 0], [-3, 9, 0, 1, 0, 0], [0, 0, 0, 0, 0.1, 1]])
    (tmp_path / "rays.csv").write_text(
        "ox,oy,oz,dx,dy,dz\n" + "".join(",".join(map(repr, row)) + "\n" for row in rays.tolist())
    )
    (tmp_path / "scene.json").write_text(json.dumps(SCENE))
    for query in ("closest", "any", "count", "crossings", "segments", "thickness"):
        arrays = cast(tmp_path, SCENE, rays, query)
        files = [tmp_path / "scene.json", "--rays", tmp_path / "rays.csv", "-o", tmp_path / "out.csv"]
        answer = run("cast", *files, "--query", query)
        assert answer.returncode == 0, answer.stderr
        with open(tmp_path / "out.csv", newline="") as file:
            lines = list(csv.DictReader(file))
        if query == "thickness":
            names = [*arrays["material_names"], "no material"]
            assert [[float(line[name]) for name in names] for line in lines] == arrays["thickness"].tolist()
            continue
        assert len(lines) == len(arrays[{"any": "any", "count": "count", "segments": "t_in"}.get(query, "t")])
        if "ray_splits" in arrays:
            counts = np.bincount([int(line["ray"]) for line in lines], minlength=len(rays))
            assert counts.tolist() == np.diff(arrays["ray_splits"]).tolist()
        for i, line in enumerate(lines):
            for name in ("t", "t_in", "t_out", "length"):
                assert name not in arrays or float(line[name]) == arrays[name][i]
            for name in ("object", "material", "path"):
                if name in arrays:
                    number = arrays[name][i]
                    assert line[name] == (arrays[f"{name}_names"][number] if number >= 0 else "")
            if "normal" in arrays:
                normal = [line[f"normal_{axis}"] for axis in "xyz"]
                expected = arrays["normal"][i]
                assert (
                    normal == ["", "", ""]
                    if np.isnan(expected).all()
                    else [*map(float, normal)] == expected.tolist()
                )
    (tmp_path / "rays.csv").write_text("1,2,3,4,5,6\n1,2,3\n")
    answer = run("cast", *files, "--query", "any")
    assert answer.returncode == 2 and "line 2: a ray has six numbers, not 3" in answer.stderr
