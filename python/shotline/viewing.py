"""Scenes on a page in the browser."""

from __future__ import annotations

import html
import importlib.util
import sys
import webbrowser
from typing import Any

from . import _native
from .image import Pictured


class View:
    """A page that shows a scene. It ends when this is closed, deleted, or leaves its `with` block.

    >>> with Scene(Sphere(radius=1)).show(open_browser=False) as view:
    ...     view.url.startswith("http://127.0.0.1:")
    True
    """

    __slots__ = ("_scene", "_viewer")

    def __init__(self, scene: Pictured, viewer: _native.Viewer) -> None:
        self._scene = scene
        self._viewer = viewer

    @property
    def url(self) -> str:
        """The address of the page. Who knows it, on this machine, may look."""
        return self._viewer.url()

    def close(self) -> None:
        """End the page."""
        self._viewer.close()

    def __enter__(self) -> View:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<shotline.View at {self.url}>"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Any:
        """In notebooks: a picture that can be turned, or without anywidget a picture and the address."""
        if importlib.util.find_spec("anywidget"):
            from .widget import Widget

            return Widget(self._scene)._repr_mimebundle_(include=include, exclude=exclude)
        picture = self._scene.render()._repr_png_()
        link = html.escape(self.url)
        return {"image/png": picture, "text/html": f'<a href="{link}">{link}</a>', "text/plain": repr(self)}


def show(scene: Pictured, native: _native.Scene, open_browser: bool | None, port: int) -> View:
    """See `Scene.show`."""
    view = View(scene, _native.Viewer(native, port))
    if open_browser or (open_browser is None and not _is_notebook()):
        webbrowser.open(view.url)
    return view


def _is_notebook() -> bool:
    """Whether a notebook shows what the code returns."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")
