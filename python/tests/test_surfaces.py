"""Queries for surfaces only, and rays that exceed their limits."""

import math

import numpy as np
import pytest
from shotline import Box, Group, Halfspace, Mesh, Scene, Sphere


@pytest.fixture
def mixed():
    """A closed mesh, an open one, a combination and an unbounded ground."""
    tetrahedron = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    sheet = Mesh([(-2, -2, 0.3), (2, -2, 0.3), (0, 2, 0.3)], [(0, 1, 2)])
    shell = Sphere(radius=1.5) - Sphere(radius=1.2)
    ground = Halfspace(normal=(0, 0, 1), offset=-0.5)
    return Scene(tetrahedron.named("mesh"), sheet.named("sheet"), shell.named("shell"), ground.named("ground"))


@pytest.mark.parametrize("window", [(0.0, math.inf), (0.0, 0.6), (0.4, 1.1), (-2.0, 0.3)])
def test_surfaces_only_is_the_list_without_start_and_end(mixed, window):
    rng = np.random.default_rng(7)
    o, d = rng.uniform(-2, 2, (500, 3)), rng.normal(size=(500, 3))
    span = {"t_min": window[0], "t_max": window[1]}
    everything = mixed.crossings(o, d, **span)
    surface = everything.kind == 0
    assert 50 < (~surface).sum()
    hits = mixed.crossings(o, d, surfaces_only=True, **span)
    for name in ("t", "entering", "object", "surface", "primitive", "path", "kind", "t_err"):
        assert getattr(hits, name).tobytes() == getattr(everything, name)[surface].tobytes(), name
    count = np.diff(hits.ray_splits)
    assert (mixed.count(o, d, surfaces_only=True, **span) == count).all()
    assert (mixed.any(o, d, surfaces_only=True, **span) == (count > 0)).all()
    first = mixed.closest(o, d, surfaces_only=True, **span)
    rows = hits.ray_splits[:-1][count > 0]
    assert (first.t[count > 0] == hits.t[rows]).all() and np.isinf(first.t[count == 0]).all()
    assert (first.path[count > 0] == hits.path[rows]).all()


def test_a_room_has_walls():
    room = Scene(Box(min=(-1, -1, -1), max=(1, 1, 1)))
    ray = [0, 0, 0], [1, 0, 0]
    assert room.closest(*ray).t == 0 and room.closest(*ray, surfaces_only=True).t == 1
    assert room.any(*ray, t_max=0.1) and not room.any(*ray, t_max=0.1, surfaces_only=True)
    assert room.count(*ray) == 2 and room.count(*ray, surfaces_only=True) == 1
    assert room.crossings(*ray, surfaces_only=True).entering.tolist() == [False]
    assert room.cost(*ray, surfaces_only=True).solids >= 1
    for query in (room.segments, room.thickness):
        with pytest.raises(ValueError, match="surfaces_only is not for"):
            query(*ray, surfaces_only=True)


def test_segments_have_the_paths_of_their_owners():
    cell = Box(min=(0, 0, 0), max=(1, 1, 1))
    cells = Scene(Group(cell, cell.translate(1, 0, 0), cell.translate(3, 0, 0)).named("cells"))
    assert cells.segments([-1, 0.5, 0.5], [1, 0, 0]).path.tolist() == [0, 1, 2]


def test_one_ray_has_limits():
    level = Sphere(radius=1)
    for _ in range(40):
        level = Group(level, level.translate(0, 0, 0))
    scene = Scene(level)
    ray = [-5, 0.1, 0.2], [1, 0, 0]
    assert scene.any(*ray)
    for query in (scene.crossings, scene.segments, scene.thickness):
        with pytest.raises(ValueError, match="ray 0: .*more than 1048576 crossings"):
            query(*ray)
    for query in (scene.closest, scene.count, scene.cost):
        with pytest.raises(ValueError, match="ray 0: .*more than 10000000 steps.*t_max"):
            query(*ray)
