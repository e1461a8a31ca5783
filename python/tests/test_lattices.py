import numpy as np
import pytest
import shotline
from shotline import Box, Cylinder, Group, HexagonalLattice, Lattice, Scene, Sphere


def everything(scene, rays):
    found = scene.crossings(rays)
    return {
        name: getattr(found, name).tobytes()
        for name in ("t", "t_err", "normal", "entering", "path", "surface", "ray_splits")
    }


def rays_through(count):
    random = np.random.default_rng(5)
    rays = np.concatenate([random.uniform(-3, 6, (count, 3)), random.uniform(-1, 1, (count, 3))], axis=1)
    rays[::3, 3:] = np.eye(3)[random.integers(0, 3, len(rays[::3]))]
    rays[::4] = np.round(rays[::4])
    return rays[np.any(rays[:, 3:] != 0, axis=1)]


@pytest.mark.parametrize("turned", [False, True])
def test_a_lattice_is_its_cells_listed_one_by_one(turned):
    pin = (
        Sphere(radius=0.5).rotate(10, 20, 30) - Box(min=(0, 0, -1), max=(1, 1, 1)) if turned else Sphere(radius=0.5)
    )
    pitch = (1.1, 1.3, 0.9)
    lattice = Lattice(pin, counts=(4, 3, 5), pitch=pitch)
    cells = [
        pin.translate(i * pitch[0], j * pitch[1], k * pitch[2])
        for k in range(5)
        for j in range(3)
        for i in range(4)
    ]
    rays = rays_through(3000)
    listed = Scene(Group(cells).named("pins"))
    assert everything(Scene(lattice.named("pins")), rays) == everything(listed, rays)
    assert listed.crossings(rays).t.size > 500


def test_a_billion_cells():
    scene = Scene(Lattice(Sphere(radius=0.25), counts=(1000, 1000, 1000), pitch=1).named("balls"))
    assert scene.stats["memory_bytes"] < 10_000
    assert scene.stats["virtual_leaves"] == 10**9
    hits = scene.closest([-5.0, 7.0, 11.0], [1.0, 0.0, 0.0])
    assert hits.t == 4.75
    assert scene.path_name(int(hits.path)) == "balls/sphere[0,7,11]"
    assert scene.count([-5.0, -5.0, -5.0], [1.0, 1.0, 1.0]) == 2000


def test_cells_are_chosen_by_a_table():
    table = np.full((3, 2, 1), -1)
    table[0, 0, 0], table[2, 1, 0] = 0, 1
    scene = Scene(
        Lattice(
            [Sphere(radius=0.25), Box(min=(0, 0, 0), max=(0.5, 0.5, 0.5))], counts=(3, 2, 1), pitch=1, cells=table
        )
    )
    assert scene.crossings([-1, 0, 0], [1, 0, 0]).t.tolist() == [0.75, 1.25]
    assert scene.crossings([-1, 1.25, 0.25], [1, 0, 0]).t.tolist() == [3.0, 3.5]


def test_hexagons_may_hold_objects():
    fuel = Cylinder(radius=0.3, z0=0, z1=10).named("fuel", material="u")
    core = Cylinder(radius=9, z0=-1, z1=11).named(
        "core", contents=[HexagonalLattice(fuel, rings=5, pitch=1.0)], clip=True
    )
    scene = Scene(core, materials={"u": shotline.Material(density=19.0)})
    segments = scene.segments([-20, 0, 5], [1, 0, 0])
    names = [scene.object_names[number] for number in segments.object]
    assert names == ["core", *["fuel", "core"] * 9]


def test_mistakes_are_told():
    ball = Sphere(radius=1)
    for wrong, message in [
        (lambda: Lattice(ball, counts=(2, 2), pitch=1), "three numbers of cells"),
        (lambda: Lattice(ball, counts=(0, 2, 2), pitch=1), "counts is 0, but must be from 1"),
        (lambda: Lattice([], counts=(2, 2, 2), pitch=1), "at least one node"),
        (lambda: Lattice(ball, counts=(2, 2, 2), pitch=(1, 2)), "pitch"),
        (lambda: Lattice(ball, counts=(2, 2, 2), pitch=1, cells=[0, 0]), r"integers of shape \(2, 2, 2\)"),
        (lambda: Lattice(ball, counts=(2, 1, 1), pitch=1, cells=np.zeros((2, 1, 1))), "not float64"),
        (lambda: Lattice(ball, counts=(2, 2, 2), pitch=0), "positive where there are several cells"),
        (lambda: Lattice(ball, counts=(2, 2, 2), pitch=1e308), "finite distance"),
        (lambda: Lattice(ball, counts=(65536, 65536, 1), pitch=1), "at most 2147483648; nest"),
        (lambda: Lattice(ball, counts=(2, 1, 1), pitch=1, cells=[[[0]], [[-2]]]), "-1 for an empty cell"),
        (lambda: Lattice(ball, counts=(2, 1, 1), pitch=1, cells=[[[0]], [[1]]]), "from 0 to 0"),
        (lambda: HexagonalLattice(ball, rings=1, pitch=1, layers=2), "height is 0.0"),
        (lambda: shotline.ring(ball, 3, step=float("inf")), "step"),
        (lambda: HexagonalLattice(ball, rings=0, pitch=1), "rings is 0"),
        (lambda: HexagonalLattice(ball, rings=2, pitch=-1.0), "pitch is -1.0"),
    ]:
        with pytest.raises(ValueError, match=message):
            wrong()
    for wrong in (
        lambda: Lattice(ball, counts=(2, 2, 2), pitch=1, stagger="no"),
        lambda: Lattice(ball, counts=(True, 2, 2), pitch=1),
    ):
        with pytest.raises(TypeError):
            wrong()
