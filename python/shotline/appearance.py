"""Materials, cameras and lights."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .values import number, numbers, picture_size, text

Vector = tuple[float, float, float]

_INFINITY = float("inf")


def _given(**keys: Any) -> dict[str, Any]:
    """The keys that have a value; vectors as lists."""
    return {k: list(v) if isinstance(v, tuple) else v for k, v in keys.items() if v is not None}


def _set(owner: Any, name: str, value: Any) -> None:
    """Sets a field of a frozen dataclass during construction."""
    object.__setattr__(owner, name, value)


def _vector(owner: Any, name: str) -> None:
    value = getattr(owner, name)
    if value is not None:
        _set(owner, name, numbers(value, 3, name))


def _number(owner: Any, name: str, least: float = 0.0, most: float = _INFINITY) -> None:
    """Checks a field that may be None: a finite number from `least` to `most`."""
    value = getattr(owner, name)
    if value is None:
        return
    (value,) = numbers(number(value, name), 1, name)
    if not least <= value <= most:
        bounds = f"from {least:g} to {most:g}" if most < _INFINITY else f"at least {least:g}"
        raise ValueError(f"{name} is {value:g}, but must be {bounds}")
    _set(owner, name, value)


def _unit(vector: np.ndarray) -> np.ndarray:
    """The unit vector along a vector, also where the square of its length would overflow or underflow; zero for zero."""
    size = np.abs(vector).max()
    scaled = vector / size if size > 0 else vector
    return np.asarray(scaled / (np.linalg.norm(scaled) or 1.0))


def _color(owner: Any) -> None:
    _vector(owner, "color")
    if owner.color is not None and not all(0.0 <= x <= 1.0 for x in owner.color):
        raise ValueError(f"color is {list(owner.color)}, but each of its components must be from 0 to 1")


@dataclass(frozen=True, kw_only=True)
class Material:
    """The material of an object. Everything is optional.

    `mu` is the linear attenuation coefficient, one over the scene's unit of length, at least 0. `density` is in g/cm^3,
    independent of the scene's unit of length; in a scene without units it is mass per cubed length. The rest is for
    pictures, from 0 to 1: `color` as sRGB, the strength of the highlight `specular`, and the fraction of light that is
    reflected, `mirror`; `shininess` is the exponent of the highlight (Phong). `composition` gives the elements, each with its
    share of the mass, from 0 to 1, as in `{"H": 0.112, "O": 0.888}`; it is kept as pairs, and no answer depends on it.

    Raises ValueError for numbers out of range, TypeError for values that are not numbers.
    """

    mu: float | None = None
    density: float | None = None
    color: Vector | None = None
    specular: float | None = None
    shininess: float | None = None
    mirror: float | None = None
    composition: Mapping[str, float] | Sequence[tuple[str, float]] | None = None

    def __post_init__(self) -> None:
        if self.composition is not None:
            _set(self, "composition", _shares(self.composition))
        for name in ("mu", "density", "shininess"):
            _number(self, name)
        for name in ("specular", "mirror"):
            _number(self, name, most=1.0)
        _color(self)

    def _keys(self) -> dict[str, Any]:
        keys = _given(**vars(self))
        return keys | {"composition": dict(keys["composition"])} if "composition" in keys else keys


def _shares(composition: Any) -> tuple[tuple[str, float], ...]:
    """The elements of a material, each with its share of the mass."""
    pairs = dict(composition).items()
    shares = tuple((text(name, "an element"), number(share, f"the share of {name!r}")) for name, share in pairs)
    for name, share in shares:
        if not 0.0 <= share <= 1.0:
            raise ValueError(f"the share of {name!r} in the composition is {share:g}, but must be from 0 to 1")
    return shares


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A camera at `eye` that looks at `target`, in world coordinates. `up` points up in the picture: z if not given, y
    for a view along z.

    With `fov`, the vertical angle of view in degrees, the projection is perspective; with `height`, the height of the
    picture in world units, it is parallel. With neither, `fov` is 40. Raises ValueError for both, and for numbers out
    of range.
    """

    eye: Vector
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector | None = None
    fov: float | None = None
    height: float | None = None

    def __post_init__(self) -> None:
        for name in ("eye", "target", "up"):
            _vector(self, name)
        _number(self, "fov", least=-_INFINITY)
        _number(self, "height", least=-_INFINITY)
        if self.fov is not None and self.height is not None:
            raise ValueError("a camera takes fov (perspective) or height (parallel), not both")
        if self.fov is not None and not 0.0 < self.fov < 180.0:
            raise ValueError(f"fov is {self.fov:g}, but must be above 0 and below 180 degrees")
        if self.height is not None and not self.height > 0.0:
            raise ValueError(f"height is {self.height:g}, but must be above 0")
        if self.eye == self.target:
            raise ValueError("eye and target of the camera are the same point")
        if self.fov is None and self.height is None:
            _set(self, "fov", 40.0)
        if self.up is None:
            along_z = self.eye[:2] == self.target[:2]
            _set(self, "up", (0.0, 1.0, 0.0) if along_z else (0.0, 0.0, 1.0))

    def rays(self, size: tuple[int, int]) -> np.ndarray:
        """The rays through the middles of the pixels of a picture, as queries take them: (height, width, 6) float64, origins and
        directions, rows from the top. They are those of `Scene.render` with one sample.

        The component of a direction along the view is 1, so `t` is the distance from the plane of the eye.

        Args:
            size: width and height in pixels.

        Raises ValueError if `up` is along the direction of view.

        >>> Scene(Sphere(radius=1)).any(Camera(eye=(0, -5, 0), fov=40).rays((3, 3))).tolist()
        [[False, False, False], [False, True, False], [False, False, False]]
        """
        width, height = picture_size(size)
        forward, right, up = self._basis()
        across = (2.0 * (np.arange(width) + 0.5) - width) / max(height, 1)
        down = 1.0 - 2.0 * (np.arange(height) + 0.5) / max(height, 1)
        offsets = across[None, :, None] * right + down[:, None, None] * up
        rays = np.empty((height, width, 6))
        if self.fov is None:
            rays[..., :3] = np.array(self.eye) + offsets * ((self.height or 0.0) / 2)
            rays[..., 3:] = forward
        else:
            rays[..., :3] = self.eye
            rays[..., 3:] = forward + offsets * math.tan(math.radians(self.fov / 2))
        return rays

    def _basis(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Forward, right and up: unit vectors, perpendicular to each other."""
        forward = _unit(np.subtract(self.target, self.eye))
        right = np.cross(forward, _unit(np.array(self.up)))
        # Below this sine the direction of "right" would be mostly rounding.
        if np.linalg.norm(right) < 1e-9:
            raise ValueError("up points along the direction of view, or is zero; choose another up")
        right = _unit(right)
        return forward, right, np.cross(right, forward)

    def _keys(self) -> dict[str, Any]:
        return _given(**vars(self))


@dataclass(frozen=True, kw_only=True)
class Light:
    """A light: from a `point`, from far away travelling in a `direction`, or from everywhere (`ambient`).

    `color` is sRGB from 0 to 1, white if not given; `intensity` is 1 if not given, and does not decrease with distance.
    """

    point: Vector | None = None
    direction: Vector | None = None
    ambient: bool | None = None
    color: Vector | None = None
    intensity: float | None = None

    def __post_init__(self) -> None:
        if sum(bool(x is not None and x is not False) for x in (self.point, self.direction, self.ambient)) != 1:
            raise ValueError("a light takes one of point, direction and ambient=True")
        for name in ("point", "direction"):
            _vector(self, name)
        if self.direction == (0.0, 0.0, 0.0):
            raise ValueError("the direction of the light is zero")
        _number(self, "intensity")
        _color(self)

    def _keys(self) -> dict[str, Any]:
        return _given(**vars(self))
