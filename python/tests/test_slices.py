"""Slices: the arrays, their agreement with points and with the program, and plots."""

import os
import subprocess
import sys

import numpy as np
import pytest
import shotline
from shotline import Box, Cylinder, Halfspace, Scene, Sphere


def nest():
    shell = Box(min=(-3, -3, -3), max=(3, 3, 3)) - Sphere(radius=1.5).translate(0.4, 0, 0)
    pins = [
        Cylinder(radius=0.5, z0=-4, z1=4).rotate(0, 20 * i, 0).named(f"pin{i}", material="iron") for i in (1, 2)
    ]
    return Scene(
        shell.named("shell", material="lead"),
        *pins,
        materials={"lead": {"color": [0.2, 0.4, 0.6]}, "iron": {}},
        units="cm",
    )


@pytest.mark.parametrize("plane", ["z=0.25", "x=-1.1", "y=0", (1, 2, 3, 0.5)])
def test_pixels_are_owned_by_what_is_at_their_middles(plane):
    scene = nest()
    found = scene.slice(plane, size=(50, 40))
    assert found.object.shape == (40, 50) and found.object.dtype == np.int32 and found.path.dtype == np.int64
    splits, objects = scene.objects_at(found.points)
    counts = np.diff(splits).reshape(40, 50)
    np.testing.assert_array_equal(counts > 0, found.object >= 0)
    # Of objects of equal priority, the one that is placed later owns the point.
    last = objects[np.maximum(splits[1:] - 1, 0)].reshape(40, 50)
    np.testing.assert_array_equal(np.where(counts > 0, last, -1), found.object)
    material = np.array([0, 1, 1, -1])
    np.testing.assert_array_equal(material[found.object], found.material)
    np.testing.assert_array_equal(found.overlap >= 0, counts > 1)
    for overlap in found.overlaps:
        assert overlap.kind == "overlap" and f"'{scene.object_names[overlap.first]}'" in overlap.text
    for pixel in np.flatnonzero(found.overlap >= 0):
        overlap = found.overlaps[found.overlap.flat[pixel]]
        around = objects[splits[pixel] : splits[pixel + 1]]
        assert {overlap.first, overlap.second} <= set(around.tolist())
    assert sum(overlap.pixels for overlap in found.overlaps) == (found.overlap >= 0).sum() > 0


def test_axes_and_area():
    scene = nest()
    found = scene.slice("x=1", area=(-1, -2, 3, 2), size=(8, 4))
    assert found.axes == ("y", "z") and found.extent == (-1, 3, -2, 2)
    np.testing.assert_allclose(found.points[0, 0], [1, -0.75, 1.5])
    np.testing.assert_allclose(found.points[-1, -1], [1, 2.75, -1.5])
    assert (found.origin, found.u, found.v) == ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    whole = scene.slice("x=1")
    assert max(whole.object.shape) == 800
    regions = {region.name: region for region in scene.slice("z=0", by="material", size=(60, 60)).regions}
    assert regions["lead"].color == (51, 102, 153) and set(regions) == {"lead", "iron"}
    assert sum(region.area for region in whole.regions) == pytest.approx((whole.object >= 0).sum(), rel=1e-2)


def test_unbounded_and_empty():
    ground = Halfspace(normal=(0, 0, 1), offset=0).named("ground")
    scene = Scene(ground, Sphere(radius=1).translate(0, 0, 2).named("ball"))
    found = scene.slice("y=0", size=(20, 40), area=(-2, -2, 2, 6))
    assert found.object[-1].tolist() == [0] * 20 and found.object[20, 10] == 1
    nothing = scene.slice("z=9", size=(4, 4))
    assert (nothing.object == -1).all() and nothing.regions == () and (nothing.colors() == 255).all()
    with pytest.raises(ValueError, match="U0,V0,U1,V1"):
        Scene(ground).slice("x=0")


def test_refusals():
    scene = nest()
    for plane in ("w=1", "z"):
        with pytest.raises(ValueError, match="expected a plane: x=1"):
            scene.slice(plane)
    with pytest.raises(ValueError, match="plane takes 4 numbers, not 3"):
        scene.slice((1, 2, 3))
    with pytest.raises(ValueError, match="U0 < U1"):
        scene.slice(area=(1, 0, 0, 1))
    with pytest.raises(ValueError, match="0x4 pixels"):
        scene.slice(size=(0, 4))
    with pytest.raises(ValueError, match="by is 'objects': did you mean 'object'"):
        scene.slice(by="objects")


def test_the_program_writes_the_same_arrays(tmp_path):
    scene = nest()
    scene.save(tmp_path / "nest.json")
    command = [os.environ.get("SHOTLINE", ""), "slice", tmp_path / "nest.json", "-o", tmp_path / "out.npz"]
    if not command[0]:
        command[:1] = [sys.executable, "-m", "shotline"]
    subprocess.run([*command, "--plane", "1,2,3,0.5", "--size", "70x50", "-q"], check=True)
    found = scene.slice((1, 2, 3, 0.5), size=(70, 50))
    with np.load(tmp_path / "out.npz") as arrays:
        for name in ("object", "material", "overlap"):
            np.testing.assert_array_equal(arrays[name], getattr(found, name))
        names = np.array([*(scene.path_name(path) for path in range(scene.path_count)), ""])
        written = np.array([*arrays["path_names"], ""])
        np.testing.assert_array_equal(written[arrays["path"]], names[found.path])
        assert arrays["area"].tolist() == list(found.area)
        for name in ("origin", "u", "v"):
            assert arrays[name].tolist() == list(getattr(found, name))


def test_plots_have_axes_and_a_legend():
    pytest.importorskip("matplotlib").use("Agg")
    from matplotlib import pyplot

    ax = nest().plot_slice("y=0", size=(60, 60))
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert {"shell", "pin1", "pin2"} <= set(labels) and any("overlap" in label for label in labels)
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("x (cm)", "z (cm)", "y = 0 cm, by object")
    _, other = pyplot.subplots()
    assert nest().plot_slice(ax=other, by="material", size=(20, 20)) is other
    pyplot.close("all")


def test_slices_show_themselves():
    found = nest().slice("y=0", size=(30, 20))
    assert repr(found).startswith("<Slice y = 0: 30x20 pixels by object (shell")
    assert isinstance(found, shotline.Slice)
