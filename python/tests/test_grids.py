"""Rays of cameras and detectors, and grids of voxels."""

import numpy as np
import pytest
from shotline import Box, Camera, Detector, Group, OverlapWarning, Scene, Sphere, Torus, radiograph


def scene():
    fuel = Sphere(radius=0.7).named("fuel", material="fuel")
    shell = Sphere(radius=1).named("shell", material="steel", contents=[fuel])
    return Scene(
        Group(shell, shell.translate(3, 0, 0)).named("pair"),
        (Box(min=(-2, -3, -1), max=(2, -1.5, 1)) - Torus(R=1, r=0.3).translate(0, -2, 0)).named("block", "steel"),
        Torus(R=5, r=0.4).rotate(20, 0, 0).named("ring"),
        materials={"steel": {"mu": 1}, "fuel": {"mu": 2}},
    )


@pytest.mark.parametrize(
    "camera",
    [
        Camera(eye=(3, -9, 4), fov=50),
        Camera(eye=(3, -9, 4), target=(0, 1, 0), up=(1, 0, 1), height=9),
        Camera(eye=(0.5, 0, 20)),
        Camera(eye=(1e-3, 1e200, 0), fov=1e-3),
    ],
)
def test_rays_of_a_camera_are_those_of_its_picture(camera):
    rays, parts = camera.rays((41, 30)), scene()
    assert rays.shape == (30, 41, 6) and rays.dtype == np.float64
    if camera.eye[1] > 1e100:
        assert np.isfinite(rays).all()
        return
    depth = parts.closest(rays).t
    picture = parts.render(camera, size=(41, 30), samples=1, look="depth")[..., 0].astype(int)
    hit = np.isfinite(depth)
    assert hit.any() and ((picture > 0) == hit).all()
    near, far = depth[hit].min(), depth[hit].max()
    grey = 0.12 + 0.88 * (near / depth[hit]) * (far - depth[hit]) / (far - near)
    assert np.abs(picture[hit] - 255 * grey).max() <= 1


def test_errors_of_camera_rays():
    with pytest.raises(ValueError, match="up points along"):
        Camera(eye=(0, 0, 3), up=(0, 0, 1)).rays((3, 3))
    with pytest.raises(TypeError, match="width and height"):
        Camera(eye=(0, 0, 3)).rays(3)
    assert Camera(eye=(0, 0, 3)).rays((0, 5)).shape == (5, 0, 6)


@pytest.mark.parametrize("beam, source", [("cone", (-20, 1, 2)), ("parallel", (2, 0.1, 0.2))])
def test_rays_of_a_detector_are_those_of_its_radiograph(beam, source):
    parts = scene()
    panel = Detector.facing([-20, 1, 2], [12, 0, 0], pixel=0.4, shape=(20, 30))
    rays = panel.rays(source, beam=beam, scene=parts)
    assert rays.shape == (20, 30, 6)
    np.testing.assert_allclose(rays[..., :3] + rays[..., 3:], panel.pixels(), atol=1e-12)
    lengths = radiograph(parts, source, panel, beam=beam, quantity="thickness")
    assert lengths.any()
    np.testing.assert_allclose(parts.thickness(rays, t_max=1), lengths, rtol=1e-9, atol=1e-9)


def test_errors_of_detector_rays():
    panel = Detector.facing([-20, 1, 2], [12, 0, 0], pixel=0.4, shape=(2, 3))
    with pytest.raises(ValueError, match="give scene="):
        panel.rays((1, 0, 0), beam="parallel")
    with pytest.raises(ValueError, match="three finite numbers"):
        panel.rays((np.nan, 0, 0))


@pytest.mark.parametrize("shape", [(31, 17, 11), (7, 40, 9), (1, 1, 1), (5, 6, 50)])
def test_voxels_are_owned_by_what_holds_their_centre(shape):
    parts, bounds = scene(), np.array([[-6, -5.5, -2.5], [5.7, 6, 2.2]])
    owners = parts.voxels(bounds, shape)
    assert owners.shape == shape and owners.dtype == np.int32
    axes = [np.linspace(a, b, 2 * n + 1)[1::2] for a, b, n in zip(*bounds, shape, strict=True)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    splits, held = parts.objects_at(centres)
    # What is inside another object has the higher number, and owns the point.
    innermost = [held[a:b].max() if b > a else -1 for a, b in zip(splits[:-1], splits[1:], strict=True)]
    assert owners.reshape(-1).tolist() == innermost
    materials = parts.voxels(bounds, shape, by="material")
    of_object = {"pair": -1, "shell": 0, "fuel": 1, "block": 0, "ring": -1}
    table = np.array([*(of_object[name] for name in parts.object_names), -1])
    assert (materials == table[owners]).all()


def test_overlaps_in_voxels():
    two = Scene(Box(min=(0, 0, 0), max=(2, 1, 1)), Box(min=(1, 0, 0), max=(3, 1, 1)))
    grid = [[-1, 0, 0], [4, 1, 1]], (5, 1, 1)
    with pytest.raises(ValueError, match="overlap"):
        two.voxels(*grid)
    with pytest.warns(OverlapWarning, match="1 overlap"):
        assert two.voxels(*grid, overlaps="priority")[:, 0, 0].tolist() == [-1, 0, 1, 1, -1]


@pytest.mark.parametrize(
    "bounds, shape, error, message",
    [
        ([[0, 0, 0], [1, 0, 1]], (2, 2, 2), ValueError, "no volume"),
        ([[0, 0, 0], [1, np.inf, 1]], (2, 2, 2), ValueError, "finite"),
        ([0, 0, 0], (2, 2, 2), ValueError, "least and the greatest corner"),
        ([[0, 0, 0], [1, 1, 1]], 5, TypeError, "cells along x, y and z"),
        ([[0, 0, 0], [1, 1, 1]], (2, 2, 0), ValueError, "from 1 to"),
        ([[0, 0, 0], [1, 1, 1]], (2**20, 2**20, 1), ValueError, "cells"),
    ],
)
def test_grids_that_do_not_exist_are_errors(bounds, shape, error, message):
    with pytest.raises(error, match=message):
        Scene(Sphere(radius=1)).voxels(bounds, shape)
