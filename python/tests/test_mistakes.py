"""Errors name what the user wrote, and how to write it."""

import pathlib

import numpy as np
import pytest
from shotline import Detector, Lattice, Light, Material, Scene, Sphere, radiograph

BALL = Sphere(radius=1)
SCENE = Scene(BALL.named("ball"))


@pytest.mark.parametrize(
    "wrong, error, message",
    [
        (lambda: Scene([[BALL]]), TypeError, "not of list: give one list of nodes"),
        (lambda: Scene("part.json"), TypeError, r"shotline.load\('part.json'\)"),
        (lambda: Scene(pathlib.Path("part.stl")), TypeError, r"shotline.load\('part.stl'\)"),
        (lambda: Scene({"ball": BALL}), TypeError, r"not of dict: objects get their names by .named\(name\)"),
        (lambda: Scene(BALL, materials=["steel"]), TypeError, "a dict of Materials by name, not list"),
        (lambda: Scene(BALL, materials={"steel": {"colour": (1, 0, 0)}}), TypeError, "did you mean 'color'"),
        (lambda: Scene(BALL, lights=Light(ambient=True)), TypeError, r"lights are a list, as in lights=\[Light"),
        (lambda: BALL.named("a", material=Material(mu=1)), TypeError, 'as in material="steel".* not Material'),
        (lambda: BALL.rotate(90), ValueError, "three angles, about x, y and z"),
        (lambda: Lattice(BALL, counts=3, pitch=1), TypeError, r"along x, y and z, as in \(3, 3, 1\), not 3"),
        (lambda: SCENE.measure(objects=["bal"]), ValueError, "no object 'bal'; did you mean 'ball'"),
        (lambda: SCENE.closest([0, 0, 0], [0, 0, 1], fields=["normals"]), ValueError, "did you mean 'normal'"),
        (lambda: radiograph(SCENE, [0, 0, -9], (10, 10)), TypeError, "a Detector, not tuple; Detector.facing"),
        (
            lambda: radiograph(
                BALL, [0, 0, -9], Detector(center=(0, 0, 9), u=(1, 0, 0), v=(0, 1, 0), shape=(1, 1))
            ),
            TypeError,
            "a Scene, not Sphere",
        ),
        (
            lambda: SCENE.closest(np.zeros((3, 100)), [0, 0, 1]),
            ValueError,
            r"not \(3, 100\): give its transpose, o.T",
        ),
        (lambda: SCENE.closest(np.zeros((4, 3))), ValueError, r"not \(4, 3\): directions are given as d"),
        (
            lambda: BALL.closest([0, 0, 0], [0, 0, 1]),
            AttributeError,
            r"a scene has it, as in Scene\(node\).closest",
        ),
        (lambda: (BALL | BALL).render(), AttributeError, r"Union has no attribute 'render': a scene has it"),
        (
            lambda: Scene(BALL, accel="kdtree"),
            ValueError,
            r"did you mean 'octree'\? it must be one of brute, .*bvh",
        ),
        (lambda: SCENE["bal"], KeyError, "did you mean 'ball'"),
        (lambda: SCENE.closest(np.zeros((1, 3)), [0, 0, 1])["object_name"], KeyError, "the names are t, normal"),
    ],
)
def test_mistakes_are_explained(wrong, error, message):
    with pytest.raises(error, match=message) as caught:
        wrong()
    assert "JSON" not in str(caught.value) and "{" not in str(caught.value).replace('{"steel"', "")
