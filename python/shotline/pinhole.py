"""The rays of the pixels of pinhole cameras, in the conventions of Open3D: x to the right, y down, z forwards."""

from __future__ import annotations

from typing import Any

import numpy as np

from .tensors import array
from .values import bounded_integer, number


def rays_of_matrices(intrinsic_matrix: Any, extrinsic_matrix: Any, width_px: int, height_px: int) -> np.ndarray:
    """The rays, (height_px, width_px, 6) float64. `intrinsic_matrix` is (3, 3), pixels from camera; `extrinsic_matrix` is
    (4, 4), camera from world. Raises ValueError for other shapes and for a matrix that has no inverse."""
    intrinsic = array(intrinsic_matrix, "intrinsic_matrix", 3)
    extrinsic = array(extrinsic_matrix, "extrinsic_matrix", 4)
    for matrix, size, what in ((intrinsic, 3, "intrinsic_matrix"), (extrinsic, 4, "extrinsic_matrix")):
        if matrix.shape != (size, size):
            raise ValueError(f"{what} must have shape ({size}, {size}), not {matrix.shape}")
    rotation, shift = extrinsic[:3, :3], extrinsic[:3, 3]
    try:
        world_from_pixel = np.linalg.inv(intrinsic @ rotation)
        eye = -np.linalg.solve(rotation, shift)
    except np.linalg.LinAlgError:
        raise ValueError("intrinsic_matrix or extrinsic_matrix is singular, so pixels have no rays") from None
    return _rays(eye, world_from_pixel, width_px, height_px)


def rays_of_field_of_view(
    fov_deg: float, center: Any, eye: Any, up: Any, width_px: int, height_px: int
) -> np.ndarray:
    """The rays, (height_px, width_px, 6) float64, of a camera at `eye` that looks at `center`; `fov_deg` is its horizontal
    field of view in degrees, and its rows go in the direction of `up`. Raises ValueError for an angle that is not between 0
    and 180, and for an axis along `up`."""
    width = bounded_integer(width_px, "width_px", 1, 1 << 20)
    height = bounded_integer(height_px, "height_px", 1, 1 << 20)
    angle = number(fov_deg, "fov_deg")
    if not 0 < angle < 180:
        raise ValueError(f"fov_deg is {angle}, but must be between 0 and 180")
    position = array(eye, "eye", 3)
    forward = array(center, "center", 3) - position
    right = np.cross(array(up, "up", 3), forward)
    if not right.any():
        raise ValueError("the line from eye to center must have a length, and not run along up")
    forward, right = forward / np.linalg.norm(forward), right / np.linalg.norm(right)
    focal = 0.5 * width / np.tan(np.radians(0.5 * angle))
    world_from_camera = np.stack([right, np.cross(forward, right), forward], axis=1)
    camera_from_pixel = np.array([[1, 0, -0.5 * width], [0, 1, -0.5 * height], [0, 0, focal]]) / focal
    return _rays(position, world_from_camera @ camera_from_pixel, width, height)


def _rays(eye: np.ndarray, world_from_pixel: np.ndarray, width_px: int, height_px: int) -> np.ndarray:
    width = bounded_integer(width_px, "width_px", 1, 1 << 20)
    height = bounded_integer(height_px, "height_px", 1, 1 << 20)
    rays = np.empty((height, width, 6))
    rays[..., :3] = eye
    across, down, corner = world_from_pixel.T
    columns, rows = (np.arange(count)[:, None] + 0.5 for count in (width, height))
    rays[..., 3:] = columns * across + (rows * down + corner)[:, None]
    return rays
