"""The names of accelerators."""

from __future__ import annotations

from . import _native
from .values import choice

_NAMES = _native.accelerators()[0]


def accelerator(name: str | None) -> str | None:
    """A checked name of an accelerator; None for the default of the scene."""
    return None if name is None else choice(name, "accel", _NAMES)
