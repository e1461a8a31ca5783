"""Beams generate the same rays in every range."""

import hashlib
import itertools
import pickle

import numpy as np
import pytest
from shotline.beams import Cone, Function, Parallel, Random

PANEL = dict(center=(1, 2, 3), u=(0.1, 0.2, 0), v=(0, 0.3, 0.7), shape=(37, 53))
VIEWS = dict(center=[(1, 2, 3), (3, 2, 1), (0, 0, 0)], u=(0.1, 0.2, 0), v=(0, 0.3, 0.7), shape=(7, 53))
BEAMS = {
    "parallel": Parallel(direction=(0, 0.1, 1), **PANEL),
    "cone": Cone(source=(0, 0, -9), **PANEL),
    "views": Cone(source=[(0, 0, -9), (0, 0, -8), (0, -7, 0)], **VIEWS),
    "random": Random(20_000, seed=2**100 + 3, min=(-1, -2, -3), max=(1, 2, 4)),
    "function": Function(1000, lambda start, stop: (np.arange(3 * start, 3 * stop).reshape(-1, 3), (0, 0, 1))),
}


def bits(rays):
    return [np.ascontiguousarray(array).tobytes() for array in rays]


@pytest.mark.parametrize("name", BEAMS)
def test_any_split_gives_the_same_rays(name):
    beam = BEAMS[name]
    whole = [np.broadcast_to(array, (len(beam), 3)) for array in beam.rays(0, len(beam))]
    random = np.random.default_rng(len(name))
    for _ in range(5):
        cuts = [0, *np.sort(random.integers(0, len(beam) + 1, 4)).tolist(), len(beam)]
        for start, stop in itertools.pairwise(cuts):
            piece = [np.broadcast_to(array, (stop - start, 3)) for array in beam.rays(start, stop)]
            assert bits(piece) == bits([array[start:stop] for array in whole])
    if name != "function":
        assert bits(pickle.loads(pickle.dumps(beam)).rays(3, 99)) == bits(beam.rays(3, 99))


def test_panels():
    o, d = BEAMS["parallel"].rays(0, 37 * 53)
    assert np.allclose(o.mean(axis=0), (1, 2, 3)) and (d == (0, 0.1, 1)).all()
    assert np.allclose(o[1] - o[0], (0.1, 0.2, 0)) and np.allclose(o[53] - o[0], (0, 0.3, 0.7))
    o, d = BEAMS["cone"].rays(0, 37 * 53)
    assert (o == (0, 0, -9)).all() and np.allclose((o + d).reshape(37, 53, 3)[18, 26], (1, 2, 3))
    assert BEAMS["views"].shape == (3, 7, 53)
    o, d = BEAMS["views"].rays(0, 3 * 7 * 53)
    middles = (o + d).reshape(3, 7, 53, 3)[:, 3, 26]
    assert np.allclose(middles, VIEWS["center"]) and o[-1].tolist() == [0, -7, 0]


def test_random_rays():
    o, d = BEAMS["random"].rays(0, 20_000)
    assert (o >= (-1, -2, -3)).all() and (o < (1, 2, 4)).all()
    # The tolerances are four standard deviations of a mean of 20,000.
    assert np.allclose(o.mean(axis=0), (0, 0, 0.5), atol=4 * 7 / np.sqrt(12 * 20_000))
    assert np.allclose(np.linalg.norm(d, axis=1), 1, atol=1e-15, rtol=0)
    assert np.allclose(d.mean(axis=0), 0, atol=4 / np.sqrt(3 * 20_000))
    assert np.allclose((d**2).mean(axis=0), 1 / 3, atol=0.01)
    assert len(np.unique(d[:, 0])) > 19_900
    other, _ = Random(100, seed=2, min=(-1, -2, -3), max=(1, 2, 4)).rays(0, 100)
    assert not (other == o[:100]).any()
    o, _ = Random(10, seed=1, min=(1, 2, 3), max=(1, 2, 3)).rays(0, 10)
    assert (o == (1, 2, 3)).all()


def test_random_rays_stay_the_same():
    """Every machine and version must generate these bits."""
    rays = b"".join(bits(Random(30_000, seed=5, min=(0, 0, 0), max=(1, 2, 3)).rays(9_000, 29_000)))
    assert hashlib.sha256(rays).hexdigest()[:16] == "1a4d8648e1383181"


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Cone(source=(0, 0), **PANEL), "source must have shape"),
        (lambda: Cone(source=np.zeros((2, 3)), **VIEWS), r"source \(2, 3\)"),
        (lambda: Parallel(direction=np.zeros((2, 2, 3)), **PANEL), r"\(views, 3\)"),
        (lambda: Parallel(direction=(0, 0, 1), **PANEL | {"shape": (0, 3)}), "shape has 0"),
        (lambda: Random(-1, seed=1), "count has -1"),
        (lambda: Random(1, seed=-1), "seed is -1"),
        (lambda: Function(10, print, shape=(3, 3)), "10 rays do not fill"),
    ],
)
def test_bad_beams(make, message):
    with pytest.raises(ValueError, match=message):
        make()
