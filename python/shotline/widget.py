"""A picture in a notebook that can be turned. It needs anywidget (`pip install anywidget`).

The picture is made where Python runs, so this works on a server too, which the page of `Scene.show` does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import anywidget
import numpy as np
import traitlets

from .appearance import Camera
from .image import Pictured

# Radians for a pixel that the pointer moves.
_TURN = 0.008
# So many degrees from the vertical, the picture would turn over.
_STEEPEST = np.radians(89.5)
# While it moves, a pixel stands for so many in each direction.
_COARSE = 3


class Widget(anywidget.AnyWidget):
    """A picture of a scene that can be turned: drag to turn it, drag with shift to move it, scroll to zoom. The arrow keys, + and - do
    the same. `camera` is that of the picture; setting it or `look` draws it again.

    Args:
        scene: the scene.
        camera: as in `Scene.render`.
        size: width and height in pixels.
    """

    _esm = Path(__file__).parent / "widget.js"
    width = traitlets.Int().tag(sync=True)
    height = traitlets.Int().tag(sync=True)
    picture = traitlets.Bytes().tag(sync=True)
    look = traitlets.Unicode("lit")
    camera = traitlets.Instance(Camera)

    def __init__(
        self, scene: Pictured, *, camera: Camera | str | None = None, size: tuple[int, int] = (640, 480)
    ) -> None:
        self._scene = scene
        self._is_moving = False
        super().__init__(width=size[0], height=size[1], camera=scene.picture_camera(camera, size=size))
        self._draw()
        self.observe(lambda _: self._draw(), ["camera", "look"])
        self.on_msg(self._move)

    def _move(self, _: Any, move: dict[str, Any], __: Any) -> None:
        """What the page has done, in pixels of its picture; it waits for the answer."""
        was_moving, self._is_moving = self._is_moving, bool(move["moving"])
        try:
            camera = moved(self.camera, move["turn"], move["shift"], move["zoom"], self.height)
            if camera != self.camera:
                self.camera = camera
            elif was_moving != self._is_moving:
                self._draw()
        finally:
            self.send({"kind": "drawn"})

    def _draw(self) -> None:
        coarse = _COARSE if self._is_moving else 1
        size = (max(1, self.width // coarse), max(1, self.height // coarse))
        samples, lighting = (1, "plain") if self._is_moving else (4, "sharp")
        self.picture = self._scene.render(
            self.camera, size=size, samples=samples, look=self.look, lighting=lighting
        ).to_png()


def moved(camera: Camera, turn: Sequence[float], shift: Sequence[float], zoom: float, height: int) -> Camera:
    """A camera after a drag that turns it about its target, one that shifts the picture, and a zoom. Drags are in pixels of a
    picture of a height. The upright stays upright.
    """
    eye, target = np.array(camera.eye), np.array(camera.target)
    upright = np.array(camera.up or (0.0, 0.0, 1.0))
    upright /= np.linalg.norm(upright)
    back = eye - target
    distance = np.linalg.norm(back)
    right = np.cross(upright, back)
    right /= np.linalg.norm(right)
    lift = np.arcsin(np.clip(back @ upright / distance, -1, 1))
    tilt = np.clip(lift + turn[1] * _TURN, -_STEEPEST, _STEEPEST) - lift
    back = _rotated(_rotated(back, right, -tilt), upright, -turn[0] * _TURN)
    right = np.cross(upright, back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right) / distance
    half = camera.height / 2 if camera.height else distance * np.tan(np.radians(camera.fov or 40.0) / 2)
    offset = (up * shift[1] - right * shift[0]) * 2 * half / height
    if camera.height is None:
        back /= zoom
    new_height = None if camera.height is None else camera.height / zoom
    target = target + offset
    return replace(camera, eye=tuple((target + back).tolist()), target=tuple(target.tolist()), height=new_height)


def _rotated(vector: np.ndarray, axis: np.ndarray, angle: float) -> np.ndarray:
    """A vector turned about a unit axis (Rodrigues)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    rotated: np.ndarray = vector * cosine + np.cross(axis, vector) * sine + axis * (axis @ vector) * (1 - cosine)
    return rotated
