"""Answers of rays with directions whose squares overflow or underflow, and forms of single answers."""

import numpy as np
import pytest
from shotline import Box, Scene, Sphere, Union, load

LENGTH = 3 - np.sqrt(1 - 0.1**2)


@pytest.mark.parametrize("size", [1e-200, 1e-162, 1e-160, 1.0, 1e155, 1e200])
def test_lengths_and_derivatives_of_any_directions(size):
    scene = Scene(Sphere(radius=1))
    hit = scene.closest([-3, 0, 0.1], [size, 0, 0])
    np.testing.assert_allclose(hit.distance, LENGTH, rtol=1e-14)
    np.testing.assert_allclose(hit.dt_do * size, [-1, 0, 0.1 / np.sqrt(1 - 0.1**2)], atol=1e-14)
    segment = scene.segments([-3, 0, 0.1], [size, 0, 0])
    np.testing.assert_allclose(segment.distance[0], [LENGTH, 6 - LENGTH], rtol=1e-14)
    miss = scene.closest([-3, 9, 9], [size, 0, 0])
    assert miss.distance == np.inf and np.isnan(miss.dt_do).all()


def test_names_of_one_ray_are_arrays():
    scene = Scene(Sphere(radius=1).named("ball"))
    for o, name in (([0, 0, -3], "ball"), ([9, 0, -3], None)):
        hit = scene.closest(o, [0, 0, 1])
        for names in (hit.object_names(), hit.ray(0).object_names()):
            assert isinstance(names, np.ndarray) and names.shape == () and names.tolist() == name


def test_what_is_written_evaluates_to_the_same_node():
    ball, box = Sphere(radius=1), Box(min=(0, 0, 0), max=(1, 1, 1))
    for node in (ball.transform(np.eye(3, 4) + 0.1), Union(ball, box, accel="brute"), ball.translate(1, 2, 3)):
        assert eval(repr(node)) == node


def test_one_plane_needs_no_list():
    scene = Scene(Sphere(radius=1))
    assert (scene.render(clip=(1, 0, 0, 0.5), size=(20, 15)) == scene.render(clip="x=0.5", size=(20, 15))).all()


def test_messages_speak_of_what_was_written(tmp_path):
    scene = Scene(Sphere(radius=1))
    with pytest.raises(IndexError, match="the scene has 1 objects, numbered from 0: there is no 3"):
        scene[3]
    with pytest.raises(ValueError, match="a transform has an inverse"):
        scene.closest([-3, 0, 0], [1, 0, 0]).dt_dtransform(np.zeros((3, 4)))
    (tmp_path / "x.gdml").write_text("<gdml/>")
    with pytest.raises(TypeError, match="setup must be a string"):
        load(tmp_path / "x.gdml", setup=3)
