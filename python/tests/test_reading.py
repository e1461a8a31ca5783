"""Scenes that are read back and extended."""

import json
import pathlib
import pickle

import numpy as np
import pytest
import shotline
from shotline import (
    Box,
    Camera,
    DuplicateNameWarning,
    Group,
    HexagonalLattice,
    Lattice,
    Light,
    Material,
    Mesh,
    Scene,
    Sphere,
)

SCENES = sorted((pathlib.Path(__file__).resolve().parents[2] / "scenes").glob("*.json"))
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def everything():
    """A scene with all forms of nodes and settings."""
    ball = Sphere(radius=1)
    mesh = Mesh(CORNERS, FACES, accel="grid")
    arm = (ball | ball.translate(0.1, 0, 0)).part("arm")
    inner = Sphere(radius=1).named("inner", material="iron")
    return Scene(
        arm.translate(0, 0, 1).rotate(1, 2, 3),
        arm.scale(2).translate(0, 9, 0).named("arms", material="steel", priority=3),
        mesh.translate(9, 0, 0).named("mesh"),
        Mesh(CORNERS, FACES).scale(1, 2, -1).translate(-9, 0, 0).named("second mesh"),
        Lattice(
            [ball, Sphere(radius=2)], counts=(2, 1, 3), pitch=9, cells=[[[0, 1, -1]], [[1, 0, 1]]], stagger=True
        )
        .translate(30, 0, 0)
        .named("lattice"),
        HexagonalLattice([inner], rings=2, pitch=3, cells=[0, -1, 0, 0, 0, -1, 0])
        .translate(0, 40, 0)
        .named("hexagon"),
        Sphere(radius=9)
        .named("outer", contents=[inner.translate(3, 0, 0), Group(inner)], clip=True)
        .translate(0, 0, 90),
        Box(min=(0, 0, 50), max=(1, 1, 51)).rotate(axis=(0, 1, 1), degrees=20).named("turned"),
        (ball & ball.translate(0, 0, 1.5) - Sphere(radius=0.5)).translate(0, 0, -20).named("cut"),
        materials={
            "steel": Material(mu=1, density=7.8, color=(1, 0, 0.5)),
            "iron": Material(composition={"Fe": 0.9, "C": 0.1}),
            "unused": {},
        },
        camera=Camera(eye=(1, 2, 3), height=4),
        lights=[Light(ambient=True, intensity=0.25), Light(direction=(1, 2, -3))],
        units="mm",
        accel="octree",
    )


def rays(seed=3, count=400):
    random = np.random.default_rng(seed)
    o = random.normal(size=(count, 3)) * 60
    return o, random.normal(size=(count, 3)) * 12 + [0, 0, 10] - o


def same_crossings(one, other, o, d):
    columns = zip(one.crossings(o, d), other.crossings(o, d), strict=True)
    return all(a.tobytes() == b.tobytes() for a, b in columns)


def test_parts_are_read_back():
    scene = everything()
    assert [item.name for item in scene.objects] == scene.object_names and len(scene) == len(scene.objects)
    assert list(scene) == list(scene.objects) and scene[0] is scene.objects[0]
    assert scene.materials["steel"] == Material(mu=1, density=7.8, color=(1, 0, 0.5))
    assert scene.materials["iron"].composition == (("Fe", 0.9), ("C", 0.1))
    assert list(scene.materials) == scene.material_names == ["steel", "iron", "unused"]
    assert scene.camera == Camera(eye=(1, 2, 3), height=4) and scene.units == "mm"
    assert scene.lights == (Light(ambient=True, intensity=0.25), Light(direction=(1, 2, -3)))
    bare = Scene(Sphere(radius=1))
    assert (
        bare.camera is None
        and bare.lights == ()
        and bare.materials == {}
        and bare.units is None
        and bare.meshes == ()
    )
    assert len(Scene()) == 0 and Scene().objects == () and Scene()


def test_nodes_are_read_back():
    scene = everything()
    assert scene["arms"].material == "steel" and scene["arms"].priority == 3
    assert scene["outer"].clip and [part.node.name for part in scene["outer"].contents[:1]] == ["inner"]
    assert scene["turned"] == Box((0, 0, 50), (1, 1, 51)).rotate(axis=(0, 1, 1), degrees=20).named("turned")
    assert scene["mesh"].node.node.vertices.tolist() == [list(map(float, corner)) for corner in CORNERS]
    assert scene["mesh"].node.node.faces.tolist() == [list(face) for face in FACES]
    lattice, hexagon = scene["lattice"].node.node, scene["hexagon"].node.node
    assert (lattice.counts, lattice.pitch, lattice.stagger) == ((2, 1, 3), (9, 9, 9), True)
    assert lattice.cells.tolist() == [[[0, 1, -1]], [[1, 0, 1]]] and lattice.children[1].radius == 2
    assert (hexagon.rings, hexagon.pitch, hexagon.layers, hexagon.height) == (2, 3, 1, 0)
    assert hexagon.cells.tolist() == [0, -1, 0, 0, 0, -1, 0]
    assert Lattice(Sphere(radius=1), counts=(2, 1, 1), pitch=3).cells is None
    arm = scene["arms"].node
    assert arm.steps == (("scale", (2, 2, 2)), ("translate", (0, 9, 0))) and arm.node.name == "arm"
    assert [type(child).__name__ for child in arm.node.node.children] == ["Sphere", "Placed"]
    # A shared part is one node.
    assert scene[0].node.children[0] is arm.node


@pytest.mark.parametrize("name", ["Halfspace", "Quadric", "Torus", "Tube", "Revolved", "Extruded", "Tetrahedron"])
def test_parameters_of_all_forms_are_read_back(name):
    made = getattr(shotline, name)(**SOLIDS[name])
    assert Scene(made.named("a"))["a"].node == made


SOLIDS = {
    "Halfspace": {"normal": (0, 0, 1), "offset": -0.25},
    "Quadric": {"coeffs": (1, 1, 1, 0, 0, 0, 0, 0, -0.0, -1)},
    "Torus": {"R": 2, "r": 0.1},
    "Tube": {"rmin": 0.1, "rmax": 1, "z0": 0, "z1": 1e-3, "dphi": 90},
    "Revolved": {"points": [(0, 0), (1, 0), (0.1, 1)]},
    "Extruded": {"polygon": [(0, 0), (1, 0), (0, 1)], "sections": [(0, 0, 0, 1), (1, 0.5, 0, 2)]},
    "Tetrahedron": {"corners": CORNERS},
}


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_loaded_scenes_are_read_back(path):
    scene = shotline.load(path)
    assert [item.name for item in scene.objects] == scene.object_names
    again = Scene.from_json(scene.to_json(), meshes=scene.meshes)
    assert again == scene and again.to_json() == scene.to_json()
    if len(json.loads(scene.to_json())["objects"]) < len(scene):
        # Members of groups are objects too, so that a scene of all objects would have them twice.
        return
    settings = {"materials": scene.materials, "camera": scene.camera, "lights": scene.lights, "units": scene.units}
    rebuilt = Scene(*scene.objects, **settings)
    assert same_crossings(rebuilt, scene, *rays(count=100)) and rebuilt.path_count == scene.path_count
    paths = range(0, scene.path_count, 1 + scene.path_count // 50)
    assert [rebuilt.path_name(path) for path in paths] == [scene.path_name(path) for path in paths]


def test_json_keeps_every_bit():
    scene = everything()
    again = Scene.from_json(scene.to_json(), meshes=scene.meshes)
    assert again == scene and again.to_json() == scene.to_json() and again.objects == scene.objects
    assert same_crossings(again, scene, *rays())
    assert pickle.loads(pickle.dumps(scene)).objects == scene.objects
    by_hand = Scene.from_json(
        '{ "shotline": 1, // a comment\n "objects": [{"node": {"kind": "sphere", "radius": 2},}] }'
    )
    assert by_hand.objects == (Sphere(radius=2).named("object0"),)
    assert Scene.from_json(by_hand.to_json(), accel="grid") == by_hand


def test_errors_of_texts():
    for words, error, message in [
        (
            '{ "shotline": 1, "objects": [{"node": {"kind": "sphere", "raduis": 2}}] }',
            ValueError,
            "did you mean 'radius'",
        ),
        (everything().to_json(), ValueError, "0 meshes are given"),
        ("[1]", ValueError, "must be an object"),
        (b"{}", TypeError, "must be a string, not bytes"),
    ]:
        with pytest.raises(error, match=message):
            Scene.from_json(words)
    with pytest.raises(TypeError, match="Mesh objects, not str"):
        Scene.from_json("{}", meshes=["part.ply"])
    with pytest.raises(ValueError, match="accel"):
        Scene.from_json("{}", accel="magic")


def test_objects_by_name():
    scene = everything()
    assert scene["cut"].name == "cut" and "cut" in scene and "cat" not in scene and scene[2] in scene
    with pytest.raises(KeyError, match="no object 'inter': did you mean 'inner'"):
        scene["inter"]
    with pytest.raises(KeyError, match="the names are object0, arms"):
        scene["zzz"]
    with pytest.raises(IndexError):
        scene[99]
    with pytest.raises(TypeError, match="whole number"):
        scene[1.5]
    with pytest.warns(DuplicateNameWarning):
        twice = Scene(Sphere(radius=1).named("a"), Sphere(radius=2).translate(9, 0, 0).named("a"))
    with pytest.raises(KeyError, match="2 objects are named 'a'"):
        twice["a"]


def test_extended_scenes_keep_what_they_had():
    base, (o, d) = everything(), rays()
    extra = Sphere(radius=3).named("far", material="steel").translate(0, -500, 0)
    more = Scene(base, extra)
    assert more.object_names == [*base.object_names, "far"] and more.materials == base.materials
    assert (more.camera, more.lights, more.units) == (base.camera, base.lights, "mm")
    assert same_crossings(more, base, o, d) and more["far"] == Sphere(radius=3).translate(0, -500, 0).named(
        "far", "steel"
    )
    assert more.count([0, -500, 9], [0, 0, -1]) == 2
    assert Scene(base) == base and Scene([base]) == base
    first = Scene(
        extra.named("far", material="new"), base, materials={"new": {"mu": 2}}, camera=Camera(eye=(9, 9, 9))
    )
    assert first.object_names == ["far", *base.object_names] and first.camera.eye == (9, 9, 9)
    assert first.material_names == ["steel", "iron", "unused", "new"]


def test_scenes_with_the_same_names_of_parts_are_joined():
    def scene(radius, x):
        part = Sphere(radius=radius).part("ball")
        both = (
            Group(part.translate(x, 0, 0), part.translate(x, 9, 0)) if x else Group(part, part.translate(0, 9, 0))
        )
        return Scene(
            both.named(f"at {x}"), Mesh(np.array(CORNERS) * radius, FACES).translate(x, -50, 50).named(f"mesh {x}")
        )

    one, two = scene(1, 0), scene(2, 100)
    both = Scene(one, Sphere(radius=0.5).translate(50, 0, 0), two)
    assert both.object_names == [*one.object_names, "object2", *two.object_names]
    for x, radius in [(0, 1), (100, 2)]:
        for y in (0, 9):
            assert both.crossings([x, y, -10], [0, 0, 1]).t.tolist() == [10 - radius, 10 + radius]
    near = np.random.default_rng(2).uniform(-1, 3, (200, 3)) + [0, -50, 50]
    points = np.concatenate([near, near + [100, 0, 0]])
    assert (
        both.contains(points).any()
        and (both.contains(points) == (one.contains(points) | two.contains(points))).all()
    )
    assert [len(mesh.vertices) for mesh in both.meshes] == [4, 4]


def test_loaded_scenes_are_extended():
    loaded = shotline.load(SCENES[0])
    extended = Scene(loaded, Sphere(radius=0.1).translate(1e4, 0, 0).named("probe"))
    assert same_crossings(extended, loaded, *rays()) and extended.object_names[-1] == "probe"
    assert extended.lights == loaded.lights and extended.camera == loaded.camera


def test_scenes_that_do_not_fit_are_errors():
    def unit(units):
        return Scene(Sphere(radius=1).named(str(units)), units=units)

    with pytest.raises(ValueError, match="a scene in cm cannot be part of one in mm: no length is converted"):
        Scene(unit("mm"), unit("cm"))
    with pytest.raises(ValueError, match="cannot be part of one in m"):
        Scene(unit("mm"), units="m")
    assert Scene(unit(None), unit("mm")).units == "mm"
    lead, other = (Scene(Sphere(radius=1).named(str(mu), "lead"), materials={"lead": {"mu": mu}}) for mu in (1, 2))
    with pytest.raises(ValueError, match="different materials that are named 'lead'"):
        Scene(lead, other)
    assert Scene(lead, other, materials={"lead": {"mu": 3}}).materials == {"lead": Material(mu=3)}
    with pytest.raises(ValueError, match="has the material 'laed'.* did you mean 'lead'"):
        Scene(lead, Sphere(radius=1).named("a", "laed"))
    with pytest.warns(DuplicateNameWarning, match="'1'"):
        Scene(lead, Sphere(radius=1).translate(9, 0, 0).named("1"))


def test_deep_scenes_are_read_back():
    node = Sphere(radius=1)
    for i in range(2000):
        node = node.translate(1, 0, 0) if i % 2 else node | Sphere(radius=0.5)
    deep = Scene(node.named("deep"))
    assert Scene(deep.objects[0]).object_names == ["deep"] and "deep" in deep._repr_html_()


@pytest.mark.parametrize("share, error", [(2, ValueError), ("x", TypeError)])
def test_compositions_are_checked(share, error):
    with pytest.raises(error, match="the share of 'H'"):
        Material(composition={"H": share})
    assert hash(Material(composition={"H": 1})) == hash(Material(composition=[("H", 1.0)]))
