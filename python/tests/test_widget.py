"""The picture in a notebook that can be turned."""

import sys

import numpy as np
import pytest
from shotline import Box, Camera, Scene, Sphere

pytest.importorskip("anywidget", reason="needs anywidget")
from shotline.widget import Widget, moved

SCENE = Scene(Sphere(radius=1).named("ball"), Box(min=(1, 1, 0), max=(2, 2, 1)).named("box"))
STILL = {"turn": [0, 0], "shift": [0, 0], "zoom": 1, "moving": False}


@pytest.fixture
def sent(monkeypatch):
    """What a widget sends to its page."""
    messages = []
    monkeypatch.setattr(Widget, "send", lambda _, content, buffers=None: messages.append(content))
    return messages


def tell(widget, **move):
    widget._handle_custom_msg({**STILL, **move}, [])


def test_the_picture_follows_the_page(sent):
    widget = Widget(SCENE, size=(90, 60))
    start = widget.camera
    assert start == SCENE.picture_camera(size=(90, 60))
    assert widget.picture == SCENE.render(start, size=(90, 60)).to_png()
    tell(widget, turn=[30, 0], moving=True)
    assert sent == [{"kind": "drawn"}]
    assert widget.camera != start
    assert widget.picture == SCENE.render(widget.camera, size=(30, 20), samples=1, lighting="plain").to_png()
    tell(widget)
    assert widget.picture == SCENE.render(widget.camera, size=(90, 60)).to_png()
    widget.look = "normal"
    assert widget.picture == SCENE.render(widget.camera, size=(90, 60), look="normal").to_png()
    assert len(sent) == 2


def test_a_picture_that_fails_is_answered(sent):
    widget = Widget(SCENE, size=(90, 60))
    start = widget.camera
    tell(widget, turn=[float("nan"), 0])
    assert widget.camera == start
    assert sent == [{"kind": "drawn"}]


def test_cameras_move_as_the_picture_is_dragged():
    camera = Camera(eye=(0, -10, 0), target=(0, 0, 0), fov=90)
    eye = np.array(moved(camera, (0, 100), (0, 0), 1, 400).eye)
    # The picture is dragged down: the camera rises.
    assert np.allclose(np.linalg.norm(eye), 10) and np.isclose(np.degrees(np.arcsin(eye[2] / 10)), np.degrees(0.8))
    eye = np.array(moved(camera, (100, 0), (0, 0), 1, 400).eye)
    # To the right: the camera goes to the left.
    assert np.isclose(np.arctan2(-eye[0], -eye[1]), 0.8)
    shifted = moved(camera, (0, 0), (200, 100), 2, 400)
    assert np.allclose(shifted.target, (-10, 0, 5)) and np.allclose(shifted.eye, (-10, -5, 5))
    parallel = moved(Camera(eye=(0, -10, 0), height=8), (0, 0), (0, -100), 2, 400)
    assert parallel.height == 4 and np.allclose(parallel.eye, (0, -10, -2))
    # Not over the pole.
    steep = np.array(moved(camera, (0, 1e6), (0, 0), 1, 400).eye)
    assert np.degrees(np.arcsin(steep[2] / 10)) == pytest.approx(89.5)


def test_notebooks_show_it(monkeypatch):
    with SCENE.show(open_browser=False) as view:
        bundle = view._repr_mimebundle_()
        assert "application/vnd.jupyter.widget-view+json" in (bundle[0] if isinstance(bundle, tuple) else bundle)
        monkeypatch.setitem(sys.modules, "anywidget", None)
        monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
        assert set(view._repr_mimebundle_()) == {"image/png", "text/html", "text/plain"}
