"""Scenes: compiled, immutable, ready to be asked."""

from __future__ import annotations

import hashlib
import math
import os
import threading
import warnings
import weakref
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native, text
from .looks import Camera, Light, Material
from .mesh import Mesh
from .nodes import Node
from .progress import callback
from .rays import rays
from .results import Closest, Crossings, Segments


class Scene:
    """A scene, compiled when it is made and immutable from then on; any number of threads may ask it.

    `objects` are objects (`node.named("bolt", material="steel")`) or plain nodes, which become objects named `object0`
    and so on. `materials` maps names to `Material`s or dicts of their parameters. `accel` names the accelerator of
    everything; no answer depends on it.

    Raises ValueError with everything that is wrong.

    >>> scene = Scene(Sphere(radius=2).named("ball"))
    >>> float(scene.closest([-5, 0, 0], [1, 0, 0]).t)
    3.0
    """

    __slots__ = ("_accel", "_hash", "_native", "_packed", "__weakref__")

    def __init__(
        self,
        *objects: Node | Iterable[Node],
        materials: Mapping[str, Material | Mapping[str, Any]] | None = None,
        camera: Camera | None = None,
        lights: Iterable[Light] = (),
        units: str | None = None,
        accel: str | None = None,
    ) -> None:
        if len(objects) == 1 and not isinstance(objects[0], Node):
            objects = tuple(objects[0])  # type: ignore[arg-type]
        for item in objects:
            if not isinstance(item, Node):
                raise TypeError(f"a scene is made of objects and other nodes, not of {type(item).__name__}")
        made = {name: _material(material) for name, material in (materials or {}).items()}
        words, meshes = text.write(
            objects,  # type: ignore[arg-type]
            {name: material._keys() for name, material in made.items()},
            camera._keys() if camera else None,
            [light._keys() for light in lights],
            units,
            accel,
        )
        self._set(_native.Scene.parse(words, [mesh._native for mesh in meshes], None), None)

    def _set(self, native: _native.Scene, accel: str | None) -> None:
        self._native, self._accel = native, accel
        self._packed: tuple[str, list[_native.Mesh]] | None = None
        self._hash: str | None = None

    @classmethod
    def _of(cls, native: _native.Scene, accel: str | None) -> Scene:
        scene = cls.__new__(cls)
        scene._set(native, accel)
        return scene

    # --- queries

    def closest(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        threads: int = 0,
        progress: Any = None,
    ) -> Closest:
        """The first crossing of each ray.

        Args:
            o: origins, (..., 3) in world coordinates; or, without `d`, rays of shape (..., 6): origin, direction.
            d: directions, (..., 3), of any length but zero; broadcast against `o`.
            t_min: only crossings from here on; a ray that is inside there has a crossing at `t_min` itself.
            t_max: only crossings up to here.
            threads: 0 for one a core. The bits are the same for any number.
            progress: True, a callable of (done, total), or a bar with `update` such as tqdm's.

        Arrays of float64 in C order are read in place: do not change them meanwhile from another thread.

        Returns:
            `Closest`, its arrays of the broadcast shape (...).

        Raises:
            ValueError: for shapes that do not fit, and for a ray with NaN, infinite numbers or without direction: its
                row is named, numbered in C order, before any work is done.
        """
        shape, ask = _ask(o, d, t_min, t_max, threads, progress)
        t, normal, *rest = self._native.closest(ask)
        return Closest(t.reshape(shape), normal.reshape(*shape, 3), *(column.reshape(shape) for column in rest))

    def any(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        threads: int = 0,
        progress: Any = None,
    ) -> np.ndarray:
        """Whether each ray has any crossing: (...) bool. Takes and raises what `closest` does."""
        shape, ask = _ask(o, d, t_min, t_max, threads, progress)
        return self._native.any(ask).reshape(shape)

    def count(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        threads: int = 0,
        progress: Any = None,
    ) -> np.ndarray:
        """The number of crossings of each ray: (...) int64. Takes and raises what `closest` does."""
        shape, ask = _ask(o, d, t_min, t_max, threads, progress)
        return self._native.count(ask).reshape(shape)

    def crossings(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        threads: int = 0,
        progress: Any = None,
    ) -> Crossings:
        """Every crossing of each ray, in order: see `Crossings`. Takes and raises what `closest` does; also ValueError
        for more than 10^9 rows.

        >>> torus = Scene(Torus(R=2, r=0.5))
        >>> torus.crossings([-5, 0, 0], [1, 0, 0]).t.tolist()
        [2.5, 3.5, 6.5, 7.5]
        """
        _, ask = _ask(o, d, t_min, t_max, threads, progress)
        return Crossings(*self._native.crossings(ask))

    def segments(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        overlaps: str = "error",
        t_min: float = 0.0,
        t_max: float = math.inf,
        threads: int = 0,
        progress: Any = None,
    ) -> Segments:
        """The stretches of each ray inside objects, with their materials and lengths: see `Segments`.

        Where objects overlap, the one of the higher priority owns the stretch. Of equal priority: with "error" that is a
        ValueError, which names both and the place; with "priority" the later one owns it; with "all" both keep it.
        Takes and raises what `closest` does; also ValueError where a mesh is not closed.
        """
        _, ask = _ask(o, d, t_min, t_max, threads, progress)
        *columns, _met = self._native.segments(ask, overlaps)
        return Segments(*columns)

    # --- names and sizes

    @property
    def object_names(self) -> list[str]:
        """The names of the objects, in the order of their numbers."""
        return self._native.object_names()

    @property
    def material_names(self) -> list[str]:
        """The names of the materials, in the order of their numbers."""
        return self._native.material_names()

    def surface_name(self, surface: int) -> str:
        """What a surface's number stands for, as in `cylinder#1.side`. IndexError for a number not in use."""
        return self._native.surface_name(_number(surface, "surface"))

    def path_name(self, path: int) -> str:
        """What a path's number stands for, as in `world/arm[2]/bolt[0]`. IndexError for a number not in use."""
        return self._native.path_name(_number(path, "path"))

    def path_transform(self, path: int) -> np.ndarray:
        """The matrix of a path, (3, 4) float64: world coordinates from those of what is placed there."""
        return np.array(self._native.path_transform(_number(path, "path"))).reshape(3, 4)

    @property
    def path_count(self) -> int:
        """How many instance paths there are; they are numbered from 0."""
        return self._native.path_count()

    @property
    def bounds(self) -> np.ndarray:
        """The least and the greatest corner of a box around everything, (2, 3) float64; infinite where it has no end."""
        return np.array(self._native.bounds())

    @property
    def stats(self) -> dict[str, Any]:
        """Sizes: nodes, objects, leaves, virtual_leaves (every placement counted), memory_bytes, and the largest
        condition number of a matrix on the way to a solid."""
        return self._native.stats()

    # --- keeping and sending

    def save(self, path: str | os.PathLike[str]) -> list[str]:
        """Write a scene file, or the meshes into a mesh file, by the ending of its name. The file appears whole or not
        at all. Returns what was lost, and which other files were written."""
        return self._native.save(os.fspath(path))

    def _pack(self) -> tuple[str, list[_native.Mesh]]:
        if self._packed is None:
            self._packed = self._native.pack()
        return self._packed

    @property
    def content_hash(self) -> str:
        """A hash of all that the scene consists of: scenes of equal hash give equal answers, bit for bit."""
        if self._hash is None:
            words, meshes = self._pack()
            digest = hashlib.blake2b(words.encode(), digest_size=32)
            for mesh in meshes:
                vertices, faces = mesh.vertices(), mesh.faces()
                digest.update(f"{vertices.shape}{faces.shape}".encode())
                digest.update(np.ascontiguousarray(vertices, "<f8").data)
                digest.update(np.ascontiguousarray(faces, "<u4").data)
            self._hash = digest.hexdigest()
        return self._hash

    def __reduce__(self) -> Any:
        words, meshes = self._pack()
        return _unpacked, (self.content_hash, words, [(mesh.vertices(), mesh.faces()) for mesh in meshes], self._accel)

    def __dask_tokenize__(self) -> tuple[str, str]:
        return "shotline.Scene", self.content_hash

    def __copy__(self) -> Scene:
        return self

    def __deepcopy__(self, memo: Any) -> Scene:
        return self

    def __eq__(self, other: object) -> bool:
        return self.content_hash == other.content_hash if isinstance(other, Scene) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.content_hash)

    def __repr__(self) -> str:
        names = self.object_names
        shown = ", ".join(names[:5]) + (", ..." if len(names) > 5 else "")
        return f"<Scene: {len(names)} object{'' if len(names) == 1 else 's'} ({shown})>"


def _ask(o: Any, d: Any, t_min: float, t_max: float, threads: int, progress: Any) -> tuple[tuple[int, ...], tuple]:
    """A query in the terms of the core, and the shape of its answer."""
    threads = int(threads)
    if not 0 <= threads <= 1024:
        raise ValueError(f"threads is {threads}, but must be from 0 (one a core) to 1024")
    shape, count, origins, directions = rays(o, d)
    return shape, (count, origins, directions, float(t_min), float(t_max), threads, callback(progress))


def _number(value: int, what: str) -> int:
    if value < 0:
        raise IndexError(f"the scene has no such {what}: {value}")
    return int(value)


def _material(material: Material | Mapping[str, Any]) -> Material:
    return material if isinstance(material, Material) else Material(**material)


# Scenes that were unpickled and are in use, by content hash and accelerator: a process builds each only once.
_known: weakref.WeakValueDictionary[tuple[str, str | None], Scene] = weakref.WeakValueDictionary()
_building = threading.Lock()


def _unpacked(digest: str, words: str, meshes: list[tuple[np.ndarray, np.ndarray]], accel: str | None) -> Scene:
    with _building:
        scene = _known.get((digest, accel))
        if scene is None:
            scene = _known[digest, accel] = _built(words, meshes, accel)
            scene._hash = digest
        return scene


# Pickles name it by the package: a thread that began with this module, beside another that imports the package, would
# wait for that one, which waits for this module.
_unpacked.__module__ = "shotline"


def _built(words: str, meshes: list[tuple[np.ndarray, np.ndarray]], accel: str | None) -> Scene:
    natives = [Mesh(vertices, faces)._native for vertices, faces in meshes]
    return Scene._of(_native.Scene.parse(words, natives, accel), accel)


def _forget_building() -> None:
    """In a forked child, whose parent may have been building in a thread that the child does not have."""
    global _building
    _building = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_building)


def load(path: str | os.PathLike[str], *, accel: str | None = None, allow_outside: bool = False) -> Scene:
    """Read a scene file (JSON), or a mesh (PLY, STL, OBJ) as a scene of one object named after the file.

    Args:
        path: the file.
        accel: the accelerator used everywhere, whatever the file says; no answer depends on it.
        allow_outside: let the scene name mesh files outside of its own folder.

    Raises:
        FileNotFoundError: if there is no such file.
        ValueError: with everything that is wrong, each with its line and how to mend it.
    """
    path = os.fspath(path)
    os.stat(path)
    native, notes = _native.Scene.load(path, accel, allow_outside)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return Scene._of(native, accel)
