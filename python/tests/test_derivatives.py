"""Derivatives of crossings against differences of crossings of neighbouring rays and neighbouring scenes."""

import numpy as np
import pytest
import shotline
from shotline import Box, Camera, Mesh, Scene, Sphere

STEP = 1e-6


SQUARE = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
SMALL = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
PLANES = [(-1, 0.2, 1), (0, 0.4, 1.2), (1, 0.2, 0.8)]
PROFILE = [(0.3, -1), (1, -1), (1.2, 0), (0.8, 1), (0.3, 1)]

# The parameters of a solid of each kind.
SOLIDS = {
    "Box": [(-1, -0.8, -0.6), (1, 0.9, 0.7)],
    "Cone": [1, 0.3, -1, 1],
    "ConeSection": [0.2, 1, 0.3, 0.7, -1, 1, 20, 250],
    "CutTube": [0.3, 1, -1, 1, (0.1, 0.2, -1), (0.2, 0, 1)],
    "Cylinder": [0.9, -1, 1],
    "Ellipsoid": [(1, 0.8, 0.6)],
    "EllipsoidSection": [(1, 0.8, 1.2), -0.7, 0.9],
    "EllipticalCone": [1, 0.6, 2, 1.5, -1, 1],
    "EllipticalCylinder": [1, 0.6, -1, 1],
    "Extruded": [SQUARE, [(-1, 0, 0, 1), (0.2, 0.1, 0, 0.6), (1, 0, 0.2, 0.9)]],
    "GenericPolyhedra": [PROFILE, 6],
    "Halfspace": [(0.3, 0.2, 1), 0.4],
    "Hyperboloid": [0.5, 0.8, -1, 1],
    "Hyperboloid2": [0.5, 0.4, 0.2, 1.2],
    "HyperboloidShell": [0.3, 0.7, 10, 25, -1, 1],
    "Paraboloid": [1, -1, 1],
    "ParaboloidSection": [0.4, 1, -1, 1],
    "Polycone": [PLANES],
    "Polyhedra": [PLANES, 5],
    "Quadric": [(1, 0.5, 0.8, 0.2, 0, 0.1, 0, 0.3, 0, -1)],
    "Revolved": [PROFILE, 0, 300],
    "Sphere": [1],
    "SphereSection": [0.4, 1, 10, 280, 20, 130],
    "Tetrahedron": [[(-1, -1, -1), (1, -1, -0.8), (0, 1, -0.9), (0, 0, 1)]],
    "Torus": [0.8, 0.3],
    "TorusSection": [0.8, 0.1, 0.4, 0, 290],
    "Trapezoid": [1, SQUARE, [(-0.5, -0.6), (0.4, -0.7), (0.6, 0.5), (-0.4, 0.8)]],
    "Tube": [0.4, 1, -1, 1, 30, 200],
    "TwistedTrapezoid": [1, SQUARE, SMALL, 40],
    "TwistedTube": [0.4, 1, -1, 1, 30, 10, 120],
}


def solids():
    """A solid of each kind, a combination and a mesh."""
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    yield pytest.param(Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]), id="mesh")
    yield pytest.param(Sphere(radius=1) - Box(min=(0, 0, 0), max=(2, 2, 2)), id="combination")
    for name, parameters in SOLIDS.items():
        yield pytest.param(getattr(shotline, name)(*parameters), id=name)


def test_every_kind_of_solid_is_tried():
    assert sorted(SOLIDS) == sorted(shotline.solids.__all__)


def rays(count=400):
    random = np.random.default_rng(3)
    origins = random.normal(size=(count, 3))
    origins *= 6 / np.linalg.norm(origins, axis=1)[:, None]
    return origins, random.uniform(-0.7, 0.7, (count, 3)) - origins * random.uniform(0.2, 1, (count, 1))


def slope(cast, hits, name):
    """The derivative by differences, where both neighbours hit the same surface, and its error by their curvature."""
    steps = [cast(sign * STEP) for sign in (-1, 1)]
    same = np.isfinite(hits.t)
    for step in steps:
        same &= (step.surface == hits.surface) & (step.primitive == hits.primitive)
    with np.errstate(invalid="ignore"):
        found = (steps[1].t - steps[0].t) / (2 * STEP)
        curved = np.abs(steps[1].t + steps[0].t - 2 * hits.t) / STEP
    # Near a tangent the difference is not the derivative.
    same &= curved < 1e-3
    return found, same


@pytest.mark.parametrize("solid", list(solids()))
def test_derivatives_are_the_limits_of_differences(solid):
    placed = np.array([[0.8, 0.1, 0, 0.2], [-0.1, 0.9, 0.2, 0], [0, -0.1, 1.1, -0.1]])
    node = solid.transform(placed)
    scene = Scene(node.named("part"))
    origins, directions = rays()
    hits = scene.closest(origins, directions, surfaces_only=True)
    checked = 0
    for axis in range(3):
        unit = np.eye(3)[axis]
        for name, cast in (
            ("dt_do", lambda h, unit=unit: scene.closest(origins + h * unit, directions, surfaces_only=True)),
            ("dt_dd", lambda h, unit=unit: scene.closest(origins, directions + h * unit, surfaces_only=True)),
        ):
            found, same = slope(cast, hits, name)
            exact = getattr(hits, name)[:, axis]
            np.testing.assert_allclose(exact[same], found[same], rtol=1e-4, atol=1e-4)
            checked += same.sum()
    changes = hits.dt_dtransform(placed)
    for row, column in np.ndindex(3, 4):
        change = np.zeros((3, 4))
        change[row, column] = 1

        def cast(h, change=change):
            return Scene(solid.transform(placed + h * change).named("part")).closest(
                origins, directions, surfaces_only=True
            )

        found, same = slope(cast, hits, "transform")
        np.testing.assert_allclose(changes[same, row, column], found[same], rtol=1e-4, atol=1e-4)
    assert checked > 100, checked


def test_crossings_have_the_derivatives_of_their_own_rays():
    scene = Scene(Sphere(radius=1))
    hits = scene.crossings([[-3, 0, 0.6], [0, 9, 0], [0, 0.6, -3]], [[1, 0, 0], [1, 0, 0], [0, 0, 2]])
    np.testing.assert_allclose(hits.dt_do, [[-1, 0, 0.75], [-1, 0, -0.75], [0, 0.375, -0.5], [0, -0.375, -0.5]])
    np.testing.assert_allclose(hits.dt_dd, hits.t[:, None] * hits.dt_do)
    assert hits.dt_dtransform(np.eye(4)).shape == (4, 3, 4)


def test_where_there_is_no_derivative_it_is_nan():
    scene = Scene(Sphere(radius=1))
    hits = scene.closest([[-3, 0, 0], [-3, 5, 0], [0, 0, 0]], [1, 0, 0])
    assert np.isnan(hits.dt_do).any(axis=1).tolist() == [False, True, True]
    assert np.isnan(hits.dt_dtransform(np.eye(4))).any(axis=(1, 2)).tolist() == [False, True, True]
    with pytest.raises(KeyError, match="not among the fields"):
        _ = scene.closest([-3, 0, 0], [1, 0, 0], fields=["t"]).dt_do
    picture = Scene(Sphere(radius=1)).closest(Camera(eye=(0, -5, 0), fov=40).rays((4, 3)))
    assert picture.dt_do.shape == (3, 4, 3) and picture.dt_dtransform(np.eye(4)).shape == (3, 4, 3, 4)
