import copy
import json
import pickle

import numpy as np
import pytest
import shotline
from shotline import Mesh, Scene, Sphere

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def with_mesh():
    mesh = Mesh(CORNERS, FACES)
    return Scene(
        (mesh | mesh.translate(0.1, 0.1, 0.1)).named("two", "glass"), materials={"glass": {"mu": 0.5}}, units="mm"
    )


def test_pickled_scenes_give_the_same_results(sample_scene, sample_rays):
    o, d = sample_rays
    for scene in (sample_scene, with_mesh()):
        for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
            again = pickle.loads(pickle.dumps(scene, protocol))
            assert again == scene and again.content_hash == scene.content_hash
            assert again.object_names == scene.object_names and again.material_names == scene.material_names
            for a, b in zip(again.crossings(o, d), scene.crossings(o, d), strict=True):
                assert a.tobytes() == b.tobytes()
    assert copy.copy(sample_scene) is sample_scene and copy.deepcopy(sample_scene) is sample_scene


def test_different_scenes_have_different_hashes():
    scenes = [
        Scene(Sphere(radius=1)),
        Scene(Sphere(radius=np.nextafter(1, 2))),
        Scene(Sphere(radius=1).named("a")),
        Scene(Sphere(radius=1), units="mm"),
        Scene(Mesh(CORNERS, FACES)),
        Scene(Mesh(np.array(CORNERS) * 2.0, FACES)),
        Scene(Mesh(CORNERS, FACES[1:] + FACES[:1])),
    ]
    assert len({scene.content_hash for scene in scenes}) == len(set(scenes)) == len(scenes)
    assert Scene(Sphere(radius=1)) == scenes[0] and Scene(Sphere(radius=1)) != 3


def test_save_and_load(tmp_path, sample_scene, sample_rays):
    assert sample_scene.save(tmp_path / "part.json") == []
    again = shotline.load(tmp_path / "part.json")
    assert again == sample_scene
    assert json.loads((tmp_path / "part.json").read_text())["units"] == "cm"
    notes = with_mesh().save(str(tmp_path / "two.json"))
    assert len(notes) == 1 and "ply" in notes[0]
    two = shotline.load(tmp_path / "two.json", accel="grid")
    assert two.crossings(*sample_rays).t.tobytes() == with_mesh().crossings(*sample_rays).t.tobytes()
    assert Scene(Mesh(CORNERS, FACES)).save(tmp_path / "mesh.ply") == []
    assert shotline.load(tmp_path / "mesh.ply").object_names == ["mesh"]


def test_errors_of_load_and_save(tmp_path, sample_scene):
    with pytest.raises(FileNotFoundError):
        shotline.load(tmp_path / "none.json")
    bad = tmp_path / "bad.json"
    bad.write_text('{ "shotline": 1,\n  "objects": [{ "node": { "kind": "sphere", "raduis": 2 } }] }')
    with pytest.raises(ValueError, match=r"bad.json:2:[\s\S]*did you mean 'radius'"):
        shotline.load(bad)
    with pytest.raises(ValueError, match="magic"):
        sample_scene.save(tmp_path / "good.json")
        shotline.load(tmp_path / "good.json", accel="magic")
    for name, error, message in [
        ("part.xyz", ValueError, "xyz"),
        ("part.stl", ValueError, "triangles only"),
        ("no/such/folder.json", OSError, "folder"),
    ]:
        with pytest.raises(error, match=message):
            sample_scene.save(tmp_path / name)
    assert not (tmp_path / "part.stl").exists()


def test_scenes_are_immutable(sample_scene):
    with pytest.raises(AttributeError):
        sample_scene.bounds = 3
    with pytest.raises(AttributeError):
        sample_scene.anything = 3


# A prism over a dart, a concave quadrilateral, as faces of four corners.
DART = [(0, 0, 0), (2, -2, 0), (0, 2, 0), (-2, -2, 0), (0, 0, 1), (2, -2, 1), (0, 2, 1), (-2, -2, 1)]
SIDES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def test_polygons_survive_pickling():
    mesh = Mesh(DART, SIDES)
    assert mesh.polygons.tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5] and mesh.is_closed
    again = pickle.loads(pickle.dumps(mesh))
    assert again == mesh and again.polygons.tolist() == mesh.polygons.tolist()
    (words, [(_, _, polygons, _)]) = Scene(mesh).__reduce__()[1][1:3]
    assert "mesh" in words and polygons.tolist() == mesh.polygons.tolist()
    plain = Mesh(mesh.vertices, mesh.faces)
    assert plain.polygons.tolist() == list(range(12)) and plain != mesh
    assert Scene(plain).content_hash != Scene(mesh).content_hash


def random_scene(random):
    """A random scene with combinations, meshes, transforms, materials, a camera and a light."""

    def number():
        return float(random.uniform(0.2, 2.0))

    def shape(depth):
        choice = random.integers(5 if depth else 2)
        if choice == 0:
            return Sphere(radius=number())
        if choice == 1:
            return Mesh(DART, SIDES, accel=random.choice([None, "grid"]), weld=random.choice([None, "auto"]))
        if choice == 2:
            return shape(depth - 1) - shape(depth - 1)
        placed = shape(depth - 1).scale(number()).rotate(number() * 50, number() * 20, 0)
        return placed.translate(number(), -number(), 0.1) if choice == 3 else placed | shape(depth - 1)

    names = ["a", 'b "\u00e9"', ""]
    objects = [
        shape(3).named(names[i], random.choice([None, "m \n", "n"]), priority=int(random.integers(-2, 3)))
        for i in range(3)
    ]
    materials = {"m \n": {"mu": number(), "color": (0.1, 0.25, 1.0)}, "n": {"density": number(), "mirror": 0.5}}
    camera = shotline.Camera(eye=(number(), 9, 1e-300), target=(0, -0.0, 0), fov=33.3)
    lights = [shotline.Light(direction=(0, 1, number()), intensity=number())]
    return Scene(objects, materials=materials, camera=camera, lights=lights, units="um", accel="octree")


def test_random_scenes_survive_saving(tmp_path):
    random, crossings = np.random.default_rng(8), 0
    for i in range(25):
        scene = random_scene(random)
        path = tmp_path / f"{i}.json"
        scene.save(path)
        again = shotline.load(path)
        # A scene that was read names mesh files, and one that was built numbers its meshes, but both pack to the same.
        assert again == scene and again.save(path) == []
        assert again.units == "um" and again.material_names == scene.material_names
        o = random.normal(size=(60, 3)) * 5
        d = random.normal(size=(60, 3)) - o
        found = scene.crossings(o, d)
        crossings += len(found.t)
        for a, b in zip(again.crossings(o, d), found, strict=True):
            assert a.tobytes() == b.tobytes()
    assert crossings > 500


def test_buffers_of_a_pickle_may_be_misaligned():
    mesh = shotline.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    scene = shotline.Scene(mesh)
    buffers = []
    packed = pickle.dumps(scene, protocol=5, buffer_callback=buffers.append)
    shifted = [memoryview(b"x" + bytes(buffer.raw()))[1:] for buffer in buffers]
    digest = scene.content_hash
    del scene
    again = pickle.loads(packed, buffers=shifted)
    assert len(shifted) >= 2 and again.content_hash == digest
    assert again.count([0.2, 0.2, -1], [0, 0, 1]) == 2
