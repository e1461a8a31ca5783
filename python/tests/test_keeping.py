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


def test_pickled_scenes_answer_the_same(part, aimed):
    o, d = aimed
    for scene in (part, with_mesh()):
        for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
            again = pickle.loads(pickle.dumps(scene, protocol))
            assert again == scene and again.content_hash == scene.content_hash
            assert again.object_names == scene.object_names and again.material_names == scene.material_names
            for a, b in zip(again.crossings(o, d), scene.crossings(o, d), strict=True):
                assert a.tobytes() == b.tobytes()
    assert copy.copy(part) is part and copy.deepcopy(part) is part


def test_hashes_tell_scenes_apart():
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


def test_save_and_load(tmp_path, part, aimed):
    assert part.save(tmp_path / "part.json") == []
    again = shotline.load(tmp_path / "part.json")
    assert again == part
    assert json.loads((tmp_path / "part.json").read_text())["units"] == "cm"
    notes = with_mesh().save(str(tmp_path / "two.json"))
    assert len(notes) == 1 and "ply" in notes[0]
    two = shotline.load(tmp_path / "two.json", accel="grid")
    assert two.crossings(*aimed).t.tobytes() == with_mesh().crossings(*aimed).t.tobytes()
    assert Scene(Mesh(CORNERS, FACES)).save(tmp_path / "mesh.ply") == []
    assert shotline.load(tmp_path / "mesh.ply").object_names == ["mesh"]


def test_what_cannot_be_loaded_or_saved(tmp_path, part):
    with pytest.raises(FileNotFoundError):
        shotline.load(tmp_path / "none.json")
    bad = tmp_path / "bad.json"
    bad.write_text('{ "shotline": 1,\n  "objects": [{ "node": { "kind": "sphere", "raduis": 2 } }] }')
    with pytest.raises(ValueError, match=r"bad.json:2:[\s\S]*did you mean 'radius'"):
        shotline.load(bad)
    with pytest.raises(ValueError, match="magic"):
        part.save(tmp_path / "good.json")
        shotline.load(tmp_path / "good.json", accel="magic")
    for name, error, message in [
        ("part.xyz", ValueError, "xyz"),
        ("part.stl", ValueError, "triangles only"),
        ("no/such/folder.json", OSError, "folder"),
    ]:
        with pytest.raises(error, match=message):
            part.save(tmp_path / name)
    assert not (tmp_path / "part.stl").exists()


def test_scenes_are_immutable(part):
    with pytest.raises(AttributeError):
        part.bounds = 3
    with pytest.raises(AttributeError):
        part.anything = 3
