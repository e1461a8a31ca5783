"""Radiographs compared with closed forms."""

import numpy as np
import pytest
import shotline
from shotline import Box, Cylinder, Detector, Scene, Sphere, radiograph, radiography

BALL = Scene(Sphere(radius=2).named("ball", material="lead"), materials={"lead": {}})


def chord(source, pixels, radius):
    """The length, inside a ball around the origin, of each line from a source to a pixel."""
    direction = pixels - source
    length = np.linalg.norm(direction, axis=-1)
    distance = np.linalg.norm(np.cross(direction, -source), axis=-1) / length
    return 2 * np.sqrt(np.maximum(radius**2 - distance**2, 0))


def test_a_ball_in_a_cone_beam():
    source = np.array([-20.0, 1.0, 0.5])
    detector = Detector.facing(source, [10, 0, 0], pixel=0.3, shape=(40, 50))
    expected = chord(source, detector.pixels(), 2)
    assert (expected > 0).sum() > 300 and (expected == 0).sum() > 100
    image = radiograph(BALL, source, detector, {"lead": 0.7})
    assert image.shape == (40, 50) and image.dtype == np.float64
    np.testing.assert_allclose(image, 0.7 * expected, atol=1e-6, rtol=1e-12)
    # The square root of a small number is inexact, so only pixels away from the edge agree to the last digits.
    well = expected > 0.5
    np.testing.assert_allclose(image[well], 0.7 * expected[well], rtol=1e-13)
    through = radiograph(BALL, source, detector, {"lead": 0.7}, quantity="transmission")
    np.testing.assert_array_equal(through, np.exp(-image))
    lengths = radiograph(BALL, source, detector, None, quantity="thickness")
    assert lengths.shape == (40, 50, 2) and not lengths[..., 1].any()
    np.testing.assert_allclose(lengths[..., 0], expected, atol=1e-6)


def test_a_ball_in_a_parallel_beam():
    detector = Detector(center=[0, 0, -7], u=[0.1, 0, 0], v=[0, -0.1, 0], shape=(60, 60))
    x, y, _ = np.moveaxis(detector.pixels(), -1, 0)
    expected = 2 * np.sqrt(np.maximum(4 - x**2 - y**2, 0))
    image = radiograph(BALL, [0, 0, -3], detector, [1.0], beam="parallel")
    np.testing.assert_allclose(image, expected, atol=1e-6)
    # The mean over the detector is the volume.
    assert image.sum() * 0.01 == pytest.approx(4 / 3 * np.pi * 8, rel=2e-3)
    # A detector inside the ball measures only the half in front of it.
    inside = Detector(center=[0, 0, 0], u=[0.1, 0, 0], v=[0, -0.1, 0], shape=(3, 3))
    assert radiograph(BALL, [0, 0, -1], inside, [1.0], beam="parallel")[1, 1] == pytest.approx(2, rel=1e-14)


def test_materials_and_energies():
    block = Box(min=(-3, -3, 0), max=(3, 3, 2)) - Cylinder(radius=1, z0=0, z1=2)
    scene = Scene(
        block.named("block", material="steel"),
        Cylinder(radius=1, z0=0, z1=1).named("plug", material="wax"),
        Sphere(radius=0.5).translate(0, 0, 9).named("nothing"),
        materials={"steel": {}, "wax": {}},
    )
    detector = Detector(center=[0, 0, -5], u=[0.25, 0, 0], v=[0, -0.25, 0], shape=(21, 21))
    energies = np.array([[2.0, 1.0, 0.5], [0.3, 0.2, 0.1]])
    image = radiograph(scene, [0, 0, -1], detector, energies, beam="parallel")
    assert image.shape == (21, 21, 3)
    np.testing.assert_allclose(image[10, 10], 1 * energies[1], rtol=1e-13)
    np.testing.assert_allclose(image[0, 0], 2 * energies[0], rtol=1e-13)
    named = radiograph(scene, [0, 0, -1], detector, {"wax": 0.3, "steel": 2.0}, beam="parallel")
    np.testing.assert_allclose(named, image[..., 0], rtol=1e-15)


def test_rows_run_down_and_columns_to_the_right():
    detector = Detector.facing([0, -10, 0], [0, 10, 0], pixel=2, shape=(3, 5))
    pixels = detector.pixels()
    np.testing.assert_allclose(pixels[0, 0], [-4, 10, 2], atol=1e-12)
    np.testing.assert_allclose(pixels[2, 4], [4, 10, -2], atol=1e-12)
    cone = detector.cone([0, -10, 0])
    origins, directions = cone.rays(0, len(cone))
    np.testing.assert_allclose((origins + directions).reshape(3, 5, 3), pixels, atol=1e-12)
    np.testing.assert_array_equal(detector.parallel([0, -1, 0]).rays(0, 15)[0].reshape(3, 5, 3), pixels)
    upright = Detector.facing([0, 0, 10], [0, 0, -10], pixel=1, shape=(3, 3)).pixels()
    assert np.isfinite(upright).all() and np.ptp(upright[..., 2]) == 0


def test_blocks_of_rays_do_not_change_the_image(monkeypatch):
    source, detector = [-20, 0, 0], Detector.facing([-20, 0, 0], [10, 0, 0], pixel=0.3, shape=(30, 20))
    expected = radiograph(BALL, source, detector, [1.0])
    monkeypatch.setattr(radiography, "_BLOCK", 100)
    reports = []
    image = radiograph(BALL, source, detector, [1.0], progress=lambda done, total: reports.append((done, total)))
    assert image.tobytes() == expected.tobytes()
    assert reports[-1] == (600, 600) and reports == sorted(reports)


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"mu": {}}, "none for 'lead'"),
        ({"mu": {"lead": 1, "gold": 2}}, "no material 'gold'"),
        ({"mu": [1, 2]}, "1 materials"),
        ({"mu": [-1]}, "not negative"),
        ({"beam": "fan"}, "cone"),
        ({"quantity": "x"}, "attenuation"),
        ({"source": [0, 0]}, r"\(..., 3\)|three"),
        ({"source": [0, 0, 0], "beam": "parallel"}, "direction"),
    ],
)
def test_invalid_arguments_are_errors(changes, message):
    detector = Detector(center=[0, 0, -5], u=[1, 0, 0], v=[0, -1, 0], shape=(3, 3))
    given = {"source": [0, 0, 9], "detector": detector, "mu": [1.0]} | changes
    with pytest.raises(ValueError, match=message):
        radiograph(BALL, **given)


def test_invalid_detectors_are_errors():
    for wrong in [
        {"center": [0, 0, 0], "u": [1, 0, 0], "v": [2, 0, 0], "shape": (3, 3)},
        {"center": [0, 0, np.nan], "u": [1, 0, 0], "v": [0, 1, 0], "shape": (3, 3)},
        {"center": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0], "shape": (0, 3)},
    ]:
        with pytest.raises(ValueError):
            Detector(**wrong)
    with pytest.raises(ValueError, match="middle"):
        Detector.facing([1, 2, 3], [1, 2, 3], pixel=1, shape=(3, 3))


def test_coefficients_are_those_of_the_materials():
    scene = Scene(
        Sphere(radius=1).named("a", "lead"),
        Sphere(radius=1).translate(0, 0, 3).named("b", "wax"),
        Sphere(radius=1).translate(0, 0, 6).named("c"),
        materials={"lead": {"mu": 2.0}, "wax": {"mu": 0.25}},
    )
    detector = Detector(center=[0, 0, -5], u=[1, 0, 0], v=[0, -1, 0], shape=(1, 1))

    def image(*mu):
        return radiograph(scene, [0, 0, -1], detector, *mu, beam="parallel")[0, 0]

    assert image() == image(None) == image({}) == pytest.approx(4.5)
    assert image({"wax": 1}) == pytest.approx(6) and image([1, 1]) == pytest.approx(4)
    with pytest.raises(ValueError, match="none for 'lead'; give the materials mu="):
        radiograph(BALL, [0, 0, 9], detector)


def test_a_scene_without_materials_has_no_radiograph_but_thickness():
    scene, detector = Scene(Sphere(radius=1)), Detector(center=[0, 0, -5], u=[1, 0, 0], v=[0, 1, 0], shape=(1, 1))
    for mu in (None, {}, []):
        with pytest.raises(ValueError, match="nothing attenuates"):
            radiograph(scene, [0, 0, 9], detector, mu)
    assert radiograph(scene, [0, 0, 9], detector, quantity="thickness")[0, 0] == pytest.approx([2])
    assert radiograph(Scene(), [0, 0, 9], detector).tolist() == [[0]]


def test_overlaps_are_errors():
    scene = Scene(Sphere(radius=1).named("a", "x"), Sphere(radius=1).named("b", "x"), materials={"x": {}})
    detector = Detector(center=[0, 0, -5], u=[1, 0, 0], v=[0, -1, 0], shape=(3, 3))
    with pytest.raises(ValueError, match="overlap"):
        radiograph(scene, [0, 0, 9], detector, [1.0])
    assert radiograph(scene, [0, 0, 9], detector, [1.0], overlaps="priority")[1, 1] == pytest.approx(2)


def test_public():
    assert shotline.radiograph is radiograph and shotline.Detector is Detector


def test_several_detectors_make_a_stack_of_views():
    scene = Scene(Sphere(radius=1).named("ball", material="lead"), materials={"lead": {"mu": 0.7}})
    sources = np.array([[-10.0, 0, 0], [0, -10, 0], [-7, -7, 1]])
    panels = [Detector.facing(source, -source, pixel=0.25, shape=(5, 7)) for source in sources]
    stack = radiograph(scene, sources, panels)
    assert stack.shape == (3, 5, 7)
    for view, source, panel in zip(stack, sources, panels, strict=True):
        assert np.array_equal(view, radiograph(scene, source, panel))
    assert radiograph(scene, [1, 0, 0], panels[:1], beam="parallel", quantity="thickness").shape == (1, 5, 7, 2)
    assert radiograph(scene, sources[:2], panels[:2], [[0.1, 0.2, 0.3]]).shape == (2, 5, 7, 3)
    done = []
    radiograph(scene, sources, panels, progress=lambda *steps: done.append(steps))
    assert done[-1] == (105, 105)


def test_views_that_do_not_match_are_refused():
    scene = Scene(Sphere(radius=1).named("ball", material="lead"), materials={"lead": {"mu": 0.7}})
    panel = Detector.facing((-9, 0, 0), (9, 0, 0), pixel=1, shape=(2, 2))
    other = Detector.facing((-9, 0, 0), (9, 0, 0), pixel=1, shape=(2, 3))
    with pytest.raises(ValueError, match=r"must have one shape, not \(2, 2\) and \(2, 3\)"):
        radiograph(scene, (-9, 0, 0), [panel, other])
    with pytest.raises(ValueError, match=r"source has shape \(3,\), or \(2, 3\) .* not \(3, 3\)"):
        radiograph(scene, np.zeros((3, 3)), [panel, panel])
    with pytest.raises(TypeError, match="a Detector, not int"):
        radiograph(scene, (-9, 0, 0), [panel, 3])
