"""What things look like and are made of, and from where they are seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Vector = tuple[float, float, float]


def _given(**keys: Any) -> dict[str, Any]:
    """Only what was given; vectors as lists of floats."""

    def plain(value: Any) -> Any:
        if isinstance(value, (bool, str)):
            return value
        return [float(x) for x in value] if hasattr(value, "__len__") else float(value)

    return {key: plain(value) for key, value in keys.items() if value is not None}


@dataclass(frozen=True, kw_only=True)
class Material:
    """What an object is made of. Everything is optional.

    `mu` is the linear attenuation coefficient, one over the scene's unit of length; `density` mass per cubed unit. The
    rest is for pictures, from 0 to 1: `color` as sRGB, the strength of the highlight `specular`, and the share of light
    that is mirrored, `mirror`; `shininess` is the exponent of the highlight (Phong).
    """

    mu: float | None = None
    density: float | None = None
    color: Vector | None = None
    specular: float | None = None
    shininess: float | None = None
    mirror: float | None = None

    def _keys(self) -> dict[str, Any]:
        return _given(**vars(self))


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Where a picture is seen from: at `eye`, looking at `target`, in world coordinates; `up` is up in the picture.

    With `fov`, the vertical angle of view in degrees, in perspective; with `height`, that of the picture in world units,
    parallel. One of the two must be given.
    """

    eye: Vector
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 0.0, 1.0)
    fov: float | None = None
    height: float | None = None

    def __post_init__(self) -> None:
        if (self.fov is None) == (self.height is None):
            raise ValueError("a camera takes either fov (perspective) or height (parallel)")

    def _keys(self) -> dict[str, Any]:
        return _given(**vars(self))


@dataclass(frozen=True, kw_only=True)
class Light:
    """A light: from a `point`, from far away travelling in a `direction`, or from everywhere (`ambient`).

    `color` is sRGB from 0 to 1, white if not given; `intensity` is 1 if not given, and does not weaken with distance.
    """

    point: Vector | None = None
    direction: Vector | None = None
    ambient: bool | None = None
    color: Vector | None = None
    intensity: float | None = None

    def __post_init__(self) -> None:
        if sum(bool(x is not None and x is not False) for x in (self.point, self.direction, self.ambient)) != 1:
            raise ValueError("a light takes one of point, direction and ambient=True")

    def _keys(self) -> dict[str, Any]:
        return _given(**vars(self))
