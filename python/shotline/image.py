"""Pictures."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .appearance import Camera
from .native_args import PictureSettings, View
from .values import MAX_NATIVE, bounded_integer, number, picture_size, text


class Image(np.ndarray[Any, np.dtype[np.uint8]]):
    """A picture: an array of shape (height, width, 3), or 4 with alpha, uint8 sRGB, rows from the top.

    It is an ordinary array, shows itself in notebooks, and saves itself as PNG or JPEG.

    >>> picture = Scene(Sphere(radius=1)).render(size=(32, 24), samples=1)
    >>> picture.shape, picture.dtype
    ((24, 32, 3), dtype('uint8'))
    """

    def __new__(cls, pixels: ArrayLike) -> Image:
        """Wrap an array of that shape and type without copying it."""
        array = np.asarray(pixels)
        if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] not in (3, 4) or array.size == 0:
            raise ValueError(f"a picture is uint8 of shape (h, w, 3 or 4), not {array.dtype} of {array.shape}")
        return array.view(cls)

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """Results of computations on a picture are ordinary arrays or numbers."""
        plain = np.asarray(array)
        return plain[()] if plain.ndim == 0 else plain

    def to_png(self) -> bytes:
        """The picture as the bytes of a PNG file."""
        return _native.encode_png(np.ascontiguousarray(self, np.uint8))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file, PNG or JPEG by the suffix of its name. It appears complete or not at all.

        Raises ValueError for another suffix, and for a JPEG with alpha.
        """
        path = os.fspath(path)
        suffix = os.path.splitext(path)[1].lower()
        if suffix not in (".png", ".jpg", ".jpeg"):
            raise ValueError(f"pictures are saved as .png, .jpg or .jpeg, not as {path}")
        save = _native.save_png if suffix == ".png" else _native.save_jpeg
        save(path, np.ascontiguousarray(self, np.uint8))

    def _repr_png_(self) -> bytes | None:
        return self.to_png() if self.ndim == 3 and self.dtype == np.uint8 and self.shape[2] in (3, 4) else None


class Pictured(Protocol):
    """What has pictures: a `Scene`."""

    @property
    def render(self) -> Callable[..., Image]: ...

    @property
    def picture_camera(self) -> Callable[..., Camera]: ...


class PictureOptions(NamedTuple):
    """The options of `Scene.render`."""

    size: tuple[int, int] = (800, 600)
    samples: int = 4
    look: str = "lit"
    lighting: str = "sharp"
    background: str | None = None
    counter: str = "boxes"
    edges: bool = False
    clip: str | Sequence[str | Sequence[float]] = ()
    hatch: bool = False
    hide: str | Sequence[str] = ()
    only: str | Sequence[str] = ()
    opacity: Mapping[str, float] = MappingProxyType({})


def picture_args(camera: Camera | str | None, options: PictureOptions) -> tuple[PictureSettings, View | None]:
    """The camera and the options of `Scene.render` in the form that the native half takes. Raises TypeError and ValueError."""
    size, samples, look, lighting, background, counter, edges, clip, hatch, hide, only, opacity = options
    width, height = picture_size(size)
    standard_view, camera = (camera, None) if isinstance(camera, str) else (None, camera)
    if camera is not None and not isinstance(camera, Camera):
        raise TypeError(f'camera must be a Camera or the name of a view, as in "iso", not {type(camera).__name__}')
    samples = bounded_integer(samples, "samples", 0, MAX_NATIVE)
    look, lighting, counter = text(look, "look"), text(lighting, "lighting"), text(counter, "counter")
    background = None if background is None else text(background, "background")
    view = (
        View(camera.eye, camera.target, camera.up or (0.0, 0.0, 1.0), camera.fov, camera.height) if camera else None
    )
    for value, name in ((edges, "edges"), (hatch, "hatch")):
        if not isinstance(value, (bool, np.bool_)):
            raise TypeError(f"{name} must be True or False, not {value!r}")
    settings = PictureSettings(
        width,
        height,
        samples,
        look,
        lighting,
        counter,
        background,
        bool(edges),
        clip=_planes(clip),
        hatch=bool(hatch),
        hide=_names(hide, "hide"),
        only=_names(only, "only"),
        opacity=_opacity(opacity),
        view=standard_view,
    )
    return settings, view


def _names(names: str | Sequence[str], what: str) -> list[str]:
    return [text(name, f"a name in {what}") for name in ([names] if isinstance(names, str) else names)]


def _opacity(opacity: Mapping[str, float]) -> list[tuple[str, float]]:
    if not isinstance(opacity, Mapping):
        raise TypeError(f'opacity maps names to numbers, as in {{"wall": 0.3}}, not {opacity!r}')
    return [
        (text(name, "a name in opacity"), number(share, f"opacity[{name!r}]")) for name, share in opacity.items()
    ]


def _planes(clip: str | Sequence[str | Sequence[float]]) -> list[str]:
    """The planes of a cut as the command line takes them."""
    is_one = isinstance(clip, str) or (
        len(clip) == 4 and all(np.isscalar(x) and not isinstance(x, str) for x in clip)
    )
    planes: Any = [clip] if is_one else clip
    return [plane if isinstance(plane, str) else ",".join(repr(float(x)) for x in plane) for plane in planes]
