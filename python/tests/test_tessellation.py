"""Solids as meshes."""

import numpy as np
import pytest
import shotline
from shotline import Box, Cylinder, Halfspace, Mesh, Scene, Sphere, Torus


def test_meshes_agree_with_the_exact_solids(rng, tmp_path):
    part = (Box(min=(-1, -1, -0.5), max=(1, 1, 0.5)) - Cylinder(radius=0.4, z0=-1, z1=1)).rotate(20, 30, 40)
    scene = Scene(
        part.named("part", material="steel"),
        Torus(R=1, r=0.3).translate(4, 0, 0).named("ring"),
        Mesh([(9, 0, 0), (10, 0, 0), (9, 1, 0)], [(0, 1, 2)]).named("sheet"),
        materials={"steel": {"color": (0.5, 0.5, 0.5)}},
        units="cm",
    )
    meshes = scene.to_mesh(0.01, threads=1)
    # What is a mesh already comes as it is, in its place.
    assert sorted(meshes.object_names) == ["part", "ring", "sheet"]
    assert meshes.units == "cm" and meshes["part"].material == "steel"
    for name in ("part", "ring"):
        assert isinstance(meshes[name].node, Mesh) and meshes[name].node.is_closed
    points = rng.uniform([-2, -2, -2], [6, 2, 2], (20_000, 3))
    solid = Scene(scene["part"], scene["ring"], materials=scene.materials)
    mesh = Scene(meshes["part"], meshes["ring"], materials=scene.materials)
    differ = solid.contains(points) != mesh.contains(points)
    near = np.min([meshes[name].node.closest_points(points).distance for name in ("part", "ring")], axis=0)
    assert near[differ].max(initial=0) <= 0.01 and differ.sum() < 200
    meshes.save(tmp_path / "both.json")
    assert shotline.load(tmp_path / "both.json").object_names == meshes.object_names


def test_what_cannot_be_a_mesh_is_told():
    with pytest.raises(ValueError, match="object 'ground' has no bounds, so no mesh can hold it"):
        Scene(Halfspace(normal=(0, 0, 1), offset=0).named("ground")).to_mesh(0.1)
    ball = Scene(Sphere(radius=1).named("ball"))
    for tolerance in (0, -1, np.nan):
        with pytest.raises(ValueError, match="must be positive and finite"):
            ball.to_mesh(tolerance)
    with pytest.raises(TypeError, match="tolerance"):
        ball.to_mesh("fine")
