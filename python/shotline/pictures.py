"""Pictures of a compiled scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from . import _native
from .appearance import Camera
from .image import Image, PictureOptions, picture_args
from .progress import callback
from .values import threads_of
from .viewing import View, show


class Pictures:
    """The pictures of a `Scene`."""

    __slots__ = ()
    _native: _native.Scene

    def render(
        self,
        camera: Camera | str | None = None,
        *,
        size: tuple[int, int] = (800, 600),
        samples: int = 4,
        look: str = "lit",
        lighting: str = "sharp",
        background: str | None = None,
        counter: str = "boxes",
        edges: bool = False,
        clip: str | Sequence[str | Sequence[float]] = (),
        hatch: bool = False,
        hide: str | Sequence[str] = (),
        only: str | Sequence[str] = (),
        opacity: Mapping[str, float] = MappingProxyType({}),
        threads: int = 0,
        progress: Any = None,
    ) -> Image:
        """A picture, with the scene's materials and lights.

        Args:
            camera: the camera; "front", "back", "left", "right", "top", "bottom" or "iso" for a view of everything in parallel
                projection, with z up; None for that of the scene, or one that frames everything.
            size: width and height in pixels.
            samples: samples per pixel; more give smoother edges.
            look: the render mode: "lit", "normal", "depth", "thickness" (with a legend in the scene's units), "xray" or
                "cost".
            lighting: "sharp", "plain" without shadows and reflections, or, with 32 samples or more, "soft".
            background: "studio", "white", "black", "transparent" or a colour such as "#336699"; None takes
                that of the look.
            counter: the counter that the look "cost" shows: "boxes", "cells", "planes", "solids", "tags", "heap" or
                "all".
            edges: draw dark lines where the object, its instance, the surface, the normal or the depth changes, as in a technical
                drawing; for the looks "lit", "normal" and "depth".
            clip: planes that cut the scene open: "x=1" removes the points with x > 1, and (nx, ny, nz, d) those with
                nx x + ny y + nz z > d. What is cut through is drawn flat.
            hatch: hatch what is cut through, in the look "lit", in directions that alternate from object to object.
            hide: names of objects that are left out, but not what they contain; `*` stands for any letters. If neither
                `hide` nor `only` is given, an object that encloses all others is left out.
            only: names of objects that are shown with what they contain, and no others.
            opacity: how opaque objects are, by name, from 0 to 1, as in `{"wall": 0.3}`, for the looks "lit" and "normal"; `*`
                stands for any letters. What is seen through casts no shadow.

        Returns:
            `Image`, an array of shape (height, width, 3), or 4 with a transparent background, uint8 sRGB.

        Raises:
            ValueError: for a camera that sees nothing, a size out of range, an unknown name, an invalid plane,
                both `hide` and `only`, edges, hatching or opacity in a look that has none, hatching
                without planes.
        """
        options = PictureOptions(
            size, samples, look, lighting, background, counter, edges, clip, hatch, hide, only, opacity
        )
        settings, view = picture_args(camera, options)
        return Image(_native.render(self._native, settings, view, threads_of(threads), callback(progress)))

    def picture_camera(self, camera: Camera | str | None = None, *, size: tuple[int, int] = (800, 600)) -> Camera:
        """The camera of `render` with this camera and size: that of the scene, or one that frames everything.

        >>> Scene(Sphere(radius=1)).picture_camera("front").eye[0]
        0.0
        """
        settings, view = picture_args(camera, PictureOptions(size=size))
        eye, target, up, fov, height = _native.picture_camera(self._native, settings, view)
        return Camera(eye=eye, target=target, up=up, fov=fov, height=height)

    def show(self, *, open_browser: bool | None = None, port: int = 0) -> View:
        """Show the scene on a page in the browser: it turns, cuts and slices the scene, hides objects, lists the crossings of the
        ray that is clicked, and draws the steps of an accelerator. The page is on 127.0.0.1 and ends with the result: keep it.

        Args:
            open_browser: open the page; None opens it except in notebooks, which show a picture and the address, or with anywidget
                a picture that can be turned (`shotline.widget`).
            port: the port; 0 for a free one.

        Raises OSError if the port is taken.
        """
        return show(self, self._native, open_browser, port)
