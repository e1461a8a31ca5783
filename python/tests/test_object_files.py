"""Files that keep the objects of a scene, as shotline and trimesh read them."""

import numpy as np
import pytest
import shotline
from shotline import Material, Mesh, Scene

CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


@pytest.fixture
def two_objects():
    corner = Mesh(CORNERS, FACES)
    return Scene(
        corner.named("left", material="red"),
        corner.translate(5, 0, 2).named("right", material="plain"),
        materials={"red": Material(color=(1.0, 0.0, 0.2)), "plain": Material()},
        units="cm",
    )


@pytest.mark.parametrize("name", ["a.obj", "a.glb", "a.gltf", "a.3mf"])
def test_objects_come_back(two_objects, tmp_path, name):
    assert two_objects.save(tmp_path / name)
    back = shotline.load(tmp_path / name)
    assert back.object_names == ["left", "right"]
    assert [back.materials[material].color is None for material in ["red", "plain"]] == [False, name != "a.3mf"]
    assert back.materials["red"].color == pytest.approx((1.0, 0.0, 0.2))
    assert all(mesh.is_closed for mesh in back.meshes)


def test_trimesh_reads_gltf(two_objects, tmp_path):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    two_objects.save(tmp_path / "a.glb")
    scene = trimesh.load_scene(tmp_path / "a.glb")
    assert scene.bounds == pytest.approx(np.array([[0, 0, -0.01], [0.06, 0.03, 0]]))
    left, right = (scene.geometry[name] for name in ["left", "right"])
    assert left.is_watertight and right.is_watertight
    assert left.visual.material.baseColorFactor.tolist() == [255, 0, 8, 255], "linear, unlike that of a scene"


def test_trimesh_reads_obj(two_objects, tmp_path):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    two_objects.save(tmp_path / "a.obj")
    scene = trimesh.load_scene(tmp_path / "a.obj", split_objects=True)
    volumes = [mesh.volume for mesh in scene.geometry.values()]
    assert volumes == pytest.approx([1 / 6, 1 / 6])


def test_trimesh_reads_3mf(two_objects, tmp_path):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    pytest.importorskip("networkx", reason="trimesh reads 3MF with networkx")
    pytest.importorskip("lxml", reason="trimesh reads 3MF with lxml")
    two_objects.save(tmp_path / "a.3mf")
    scene = trimesh.load_scene(tmp_path / "a.3mf")
    assert scene.bounds == pytest.approx(np.array([[0, 0, 0], [6, 1, 3]]))
    assert all(mesh.is_watertight for mesh in scene.geometry.values())
