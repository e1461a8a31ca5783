"""Measures compared with closed forms."""

import json
import subprocess
import sys

import numpy as np
import pytest
from shotline import Box, Cylinder, Group, Halfspace, Scene, Sphere, Torus


def test_closed_forms():
    ring = Torus(R=3, r=0.5).rotate(20, 30, 40).scale(1, 2, 1).translate(1, 2, 3)
    scene = Scene(
        Box(min=(0, 0, 0), max=(1, 2, 3)).named("box", material="steel"),
        ring.named("ring"),
        Group(Sphere(radius=1).translate(9, 0, 0), Sphere(radius=1).translate(-9, 0, 0)).named("two"),
        materials={"steel": {"density": 7.5}},
    )
    m = scene.measure()
    assert m.exact.all() and (m.volume_err == 0).all() and (m.rays == 0).all()
    np.testing.assert_allclose(m.volume, [6, 2 * 2 * np.pi**2 * 3 * 0.25, 2 * 4 / 3 * np.pi], rtol=1e-13)
    np.testing.assert_allclose(m.centroid, [[0.5, 1, 1.5], [1, 2, 3], [0, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(m.inertia[0], np.diag([13, 10, 5]) * 6 / 12, rtol=1e-13, atol=1e-12)
    assert m.mass[0] == pytest.approx(45) and np.isnan(m.mass[1:]).all()
    assert m.bounds[0].tolist() == [[0, 0, 0], [1, 2, 3]] and m.bounds.shape == (3, 2, 3)
    assert repr(m).startswith("measures of 3 objects")


def test_masses_are_in_grams_where_there_are_units():
    def mass(units):
        cube = Box(min=(0, 0, 0), max=(10, 10, 10)).named("cube", "steel")
        return Scene(cube, materials={"steel": {"density": 7.8}}, units=units).measure().mass[0]

    assert mass("mm") == pytest.approx(7.8, rel=1e-15) and mass("cm") == 7800 and mass("m") == 7.8e9
    assert mass(None) == mass("none") == 7800
    scenes = [Scene(Sphere(radius=1), units=units) for units in ("nm", "um", "mm", "cm", "m", "km", "in", "ft")]
    assert [scene.units for scene in scenes] == ["nm", "um", "mm", "cm", "m", "km", "in", "ft"]
    assert Scene(Sphere(radius=1)).units is None is Scene(Sphere(radius=1), units="none").units


def test_by_rays():
    """This combination has no closed form. The actual errors must agree with the reported standard errors."""
    scene = Scene((Box(min=(-2, -2, 0), max=(2, 2, 1)) - Cylinder(radius=1, z0=0, z1=1)).named("washer"))
    truth, errors = 16 - np.pi, []
    for seed in range(12):
        m = scene.measure(rays=4800, seed=seed)
        assert not m.exact[0] and m.rays[0] == 4800 and 0 < m.volume_err[0] < 0.05
        errors.append(abs(m.volume[0] - truth) / m.volume_err[0])
    assert max(errors) < 6 and np.mean(np.array(errors) < 3) > 0.8
    again = scene.measure(rays=4800, seed=3, threads=2)
    assert all(
        a.tobytes() == b.tobytes() for a, b in zip(again, scene.measure(rays=4800, seed=3, threads=1), strict=True)
    )
    ball = Scene(Sphere(radius=1))
    rough = ball.measure(method="rays", rays=9600)
    assert not rough.exact[0] and abs(rough.volume[0] - 4 / 3 * np.pi) < 6 * rough.volume_err[0]


def test_a_volume_out_of_range_is_refused():
    for radius, word in ((1e120, "large"), (1e-110, "small")):
        with pytest.raises(ValueError, match=f"its volume is too {word} for a 64-bit number"):
            Scene(Sphere(radius=radius)).measure()


def test_chosen_objects_and_the_command(tmp_path):
    scene = Scene(Sphere(radius=1).named("a"), Sphere(radius=2).named("b"))
    assert scene.measure(objects=["b"]).object.tolist() == [1] == scene.measure(objects=[1]).object.tolist()
    scene.save(tmp_path / "two.json")
    words = [sys.executable, "-m", "shotline", "measure", str(tmp_path / "two.json"), "--json"]
    out = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    assert "volume" in out and str(scene.measure().volume[0]) in json.dumps(json.loads(out))


def test_unbounded_objects_and_invalid_arguments():
    endless = Halfspace(normal=(0, 0, 1), offset=-2).named("endless")
    both = Scene(endless, Sphere(radius=1).named("ball")).measure()
    assert np.isnan(both.volume[0]) and not both.exact[0]
    assert both.exact[1] and both.volume[1] == Scene(Sphere(radius=1)).measure().volume[0]
    ball = Scene(Sphere(radius=1).named("ball"))
    for wrong in [{"objects": ["bal"]}, {"method": "x"}, {"rays": 0}, {"overlaps": "x"}, {"objects": [7]}]:
        with pytest.raises(ValueError):
            ball.measure(**wrong)
