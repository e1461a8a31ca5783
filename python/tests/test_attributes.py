"""Attributes of meshes, and their values at hits."""

import copy
import pickle

import numpy as np
import pytest
import shotline
from shotline import Mesh, Scene, Sphere

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)])
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
MATRIX = np.array([[2, 0.5, 0, 1], [0, 1, 0.25, -2], [0.5, 0, 1.5, 3]])


def test_a_linear_attribute_is_the_position_at_every_hit(rng):
    """Coordinates as an attribute are the points that are hit, in the frame of the mesh."""
    per_corner = CORNERS[FACES]
    mesh = Mesh(CORNERS, FACES, attributes={"place": CORNERS, "corner": per_corner, "x": CORNERS[:, 0]})
    scene = Scene(mesh.transform(MATRIX).named("moved"), Sphere(radius=0.1).translate(0, 9, 0))
    targets = rng.dirichlet([1] * 4, 500) @ CORNERS @ MATRIX[:, :3].T + MATRIX[:, 3]
    origins = rng.normal(size=(500, 3)) * 20
    for hits in (scene.closest(origins, targets - origins), scene.crossings(origins, targets - origins)):
        hit = hits.primitive >= 0
        assert hit.sum() > 300
        local = np.linalg.solve(MATRIX[:, :3], (hits.points[hit] - MATRIX[:, 3]).T).T
        for name in ("place", "corner"):
            values = hits.interpolate(name)
            assert values.shape == hits.points.shape
            np.testing.assert_allclose(values[hit], local, atol=1e-12)
        np.testing.assert_allclose(hits.interpolate("x")[hit, 0], local[:, 0], atol=1e-12)
        assert np.isnan(hits.interpolate("place")[~hit]).all()


def test_attributes_are_kept_by_scenes_pickles_and_files(tmp_path):
    values = {"heat": np.array([[1.0], [2], [3], [np.nan]]), "uv": np.arange(24.0).reshape(4, 3, 2) / 7}
    mesh = Mesh(CORNERS, FACES, attributes=values)
    other = Mesh(CORNERS, FACES)
    scene = Scene(mesh.named("part"))
    assert mesh != other and mesh == copy.deepcopy(mesh)
    assert scene.content_hash != Scene(other.named("part")).content_hash
    scene.save(tmp_path / "part.ply")
    scene.save(tmp_path / "part.json")
    for same in (
        pickle.loads(pickle.dumps(mesh)),
        pickle.loads(pickle.dumps(scene))["part"].node,
        shotline.load(tmp_path / "part.ply")["part"].node,
        shotline.load(tmp_path / "part.json")["part"].node,
    ):
        assert same.attributes.keys() == values.keys()
        for name, array in values.items():
            np.testing.assert_array_equal(same.attributes[name], array)


def test_parts_of_an_obj_are_objects_with_colours_and_texture(tmp_path):
    box = "v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nv 0 0 {w}\n"
    faces = "f {0}/1 {2}/1 {1}/1\nf {0}/1 {1}/2 {3}/3\nf {1}/2 {2}/2 {3}/3\nf {2}/1 {0}/1 {3}/2\n"
    text = "mtllib a.mtl\nvt 0 0\nvt 1 0\nvt 0 1\n"
    for number, name in enumerate(("base", "lid")):
        text += f"o {name}\nusemtl {name}ing\n" + box.format(z=2 * number, w=2 * number + 1)
        text += faces.format(*range(4 * number + 1, 4 * number + 5))
    (tmp_path / "a.obj").write_text(text)
    (tmp_path / "a.mtl").write_text("newmtl baseing\nKd 1 0 0\nnewmtl liding\nKd 0 0.5 1\n")
    scene = shotline.load(tmp_path / "a.obj")
    assert scene.object_names == ["base", "lid"] and scene.material_names == ["baseing", "liding"]
    assert scene.materials["liding"].color == (0, 0.5, 1)
    hits = scene.closest([[0.25, -1, 0.25], [0.25, -1, 2.25], [0.25, -1, 9]], [0, 1, 0])
    assert hits.object_names().tolist() == ["base", "lid", None]
    np.testing.assert_allclose(hits.interpolate("uv"), [[0.25, 0.25], [0.25, 0.25], [np.nan, np.nan]])
    assert scene.thickness([0.25, 0.25, -1], [0, 0, 1]).round(12).tolist() == [0.5, 0.5, 0]


def test_what_does_not_fit_is_told():
    with pytest.raises(
        ValueError, match=r"attribute 'uv' has shape \(3, 2\), but must be \(4,\) or \(4, k\) for vert"
    ):
        Mesh(CORNERS, FACES, attributes={"uv": np.zeros((3, 2))})
    with pytest.raises(ValueError, match=r"or \(4, 3, k\) for corners"):
        Mesh(CORNERS, FACES, attributes={"uv": np.zeros((4, 4, 2))})
    with pytest.raises(TypeError, match="named by strings, not by int"):
        Mesh(CORNERS, FACES, attributes={1: CORNERS})
    hits = Scene(Mesh(CORNERS, FACES, attributes={"b": CORNERS, "a": CORNERS})).closest([0.1, 0.1, -1], [0, 0, 1])
    with pytest.raises(KeyError, match="'uv'; the meshes that are hit have a, b"):
        hits.interpolate("uv")
    with pytest.raises(KeyError, match="no attributes"):
        Scene(Mesh(CORNERS, FACES)).closest([0.1, 0.1, -1], [0, 0, 1]).interpolate("uv")
    two = [Mesh(CORNERS, FACES, attributes={"a": np.zeros((4, k))}).translate(0, 0, 3 * k) for k in (1, 2)]
    hits = Scene(*two).crossings([0.1, 0.1, -1], [0, 0, 1])
    with pytest.raises(ValueError, match="'a' has 1 numbers in one mesh and 2 in another"):
        hits.interpolate("a")


def test_attributes_without_a_name_or_numbers_are_refused():
    with pytest.raises(ValueError, match="an attribute has an empty name"):
        Mesh(CORNERS, FACES, attributes={"": [0, 1, 2, 3]})
    with pytest.raises(ValueError, match=r"attribute 'heat' has shape \(4, 0\), so it has no numbers"):
        Mesh(CORNERS, FACES, attributes={"heat": np.zeros((4, 0))})
