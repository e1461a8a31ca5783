"""Reading files."""

from __future__ import annotations

import os
import warnings

from . import _native
from .mesh import weld_text
from .scene import Scene
from .values import text


class ReadWarning(UserWarning):
    """A reader dropped or repaired part of a file; the message names what, how often, and the first line or byte.

    To refuse such files: `warnings.simplefilter("error", shotline.ReadWarning)`.
    """


def load(
    path: str | os.PathLike[str],
    *,
    accel: str | None = None,
    allow_outside: bool = False,
    weld: float | str | None = None,
    partial: bool = False,
    setup: str | None = None,
) -> Scene:
    """Read a scene file (JSON), a geometry of Geant4 (GDML), a scene in glTF, or a print in 3MF.

    A mesh (PLY, STL, OBJ, OFF) is read as a scene of one object named after the file.

    Args:
        path: the file.
        accel: the accelerator of everything, instead of those in the file; no result depends on it.
        allow_outside: whether the scene may name mesh files outside of its own folder.
        weld: merge vertices of meshes up to this distance apart, in the lengths of the file; "auto" merges those within
            rounding error of each other and far from all others.
        partial: whether a GDML file is read without the parts that are not supported, each of which is a warning.
        setup: which setup of a GDML file is read, by its name; None reads the one named Default, or else the first.
            Of a glTF file, which scene; None reads the default one.

    Warns:
        ReadWarning: for each kind of item that was dropped or repaired. `shotline info FILE` lists all notes.

    Raises:
        FileNotFoundError: if there is no such file.
        ValueError: with everything that is wrong, each with its line and how to correct it.
    """
    path = os.fspath(path)
    os.stat(path)
    native, notes = _native.Scene.load(
        path, accel, allow_outside, weld_text(weld), partial, setup and text(setup, "setup")
    )
    for note, changed in notes:
        if changed:
            warnings.warn(note, ReadWarning, stacklevel=2)
    return Scene._of(native, accel)
