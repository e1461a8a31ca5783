import numpy as np
import pytest
from shotline import Scene, Sphere

SCENE = Scene(Sphere(radius=1), Sphere(radius=1).translate(0, 0, 5))
MANY = np.zeros((30, 3)) - [0, 0, 5], [0, 0, 1]


def test_aliases():
    hits, rows, segments = SCENE.closest(*MANY), SCENE.crossings(*MANY), SCENE.segments(*MANY)
    for result in (hits, rows):
        for alias, name in [
            ("t_hit", "t"),
            ("geometry_ids", "object"),
            ("primitive_ids", "primitive"),
            ("primitive_normals", "normal"),
        ]:
            assert result[alias] is result[name] is getattr(result, alias) is getattr(result, name)
    assert rows["ray_ids"].tolist() == np.repeat(np.arange(30), 4).tolist()
    assert segments.ray_ids.tolist() == np.repeat(np.arange(30), 2).tolist() and segments["length"][0] == 2
    assert len(hits) == 30 and list(hits.to_dict()) == list(hits._fields)
    t, normal, *_ = hits
    assert t is hits.t
    with pytest.raises(KeyError, match="t_hit"):
        hits["tee"]


def test_tables():
    lines = repr(SCENE.crossings(*MANY)).splitlines()
    assert lines[0] == "120 crossings of 30 rays"
    assert lines[1].split()[:4] == ["ray", "t", "normal", "entering"]
    assert len(lines) == 13 and lines[7].split()[0] == "..."
    assert lines[2].split()[:5] == ["0", "0", "4", "(0,", "0,"] and lines[-1].split()[:3] == ["119", "29", "11"]
    assert "-0" not in repr(SCENE.closest(*MANY))
    one = repr(SCENE.closest([0, 0, -5], [0, 0, 1]))
    assert one.splitlines()[0] == "closest crossings of rays of shape (): 1 hit" and len(one.splitlines()) == 3
    empty = SCENE.crossings(np.zeros((0, 3)), [0, 0, 1])
    assert repr(empty).splitlines()[0] == "0 crossings of 0 rays"
    assert repr(SCENE.segments(*MANY)).startswith("60 segments of 30 rays")


def test_only_the_fields_that_are_asked_for():
    full, rows = SCENE.closest(*MANY), SCENE.crossings(*MANY)
    hits = SCENE.closest(*MANY, fields=["normal", "t_err"])
    assert list(hits.to_dict()) == ["t", "normal", "t_err"] and hits.object is None
    for name, column in hits.to_dict().items():
        assert np.array_equal(column, full[name])
    with pytest.raises(KeyError, match="not among the fields"):
        hits["primitive_ids"]
    assert "t_err" in repr(hits) and "surface" not in repr(hits)
    some = SCENE.crossings(*MANY, fields=("kind", "ray_splits"))
    assert list(some.to_dict()) == ["ray_splits", "t", "kind"]
    assert np.array_equal(some.kind, rows.kind) and np.array_equal(some.t, rows.t)
    assert list(SCENE.crossings(*MANY, fields=[]).to_dict()) == ["ray_splits", "t"]
    with pytest.raises(ValueError, match="'kind' is not a field; the fields are t, normal"):
        SCENE.closest(*MANY, fields=["kind"])
    with pytest.raises(TypeError, match="a list of names"):
        SCENE.closest(*MANY, fields="normal")
