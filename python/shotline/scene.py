"""Scenes: compiled, immutable, ready to be asked."""

from __future__ import annotations

import hashlib
import json
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
from .image import Image
from .looks import Camera, Light, Material
from .mesh import Mesh
from .nodes import Node, affine
from .progress import callback
from .rays import points, rays
from .results import Closest, Cost, Crossings, Measures, Segments


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

    __slots__ = ("__weakref__", "_accel", "_hash", "_native", "_packed")

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
            objects = tuple(objects[0])
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

    def thickness(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        overlaps: str = "error",
        t_min: float = 0.0,
        t_max: float = math.inf,
        threads: int = 0,
        progress: Any = None,
    ) -> np.ndarray:
        """How far each ray goes through each material: (..., n_materials) float64, in world units, in the order of
        `material_names`. Objects without a material count for none.

        It is the sum of `segments` by material, and takes and raises what that does.

        >>> scene = Scene(Sphere(radius=1).named("ball", material="lead"), materials={"lead": {"mu": 1.2}})
        >>> scene.thickness([[-5, 0, 0], [-5, 0.6, 0]], [2, 0, 0]).round(12).tolist()
        [[2.0], [1.6]]
        """
        shape, ask = _ask(o, d, t_min, t_max, threads, progress)
        lengths, _met = self._native.thickness(ask, overlaps)
        return lengths.reshape(*shape, -1) if lengths.size else np.zeros((*shape, len(self.material_names)))

    def cost(
        self,
        o: ArrayLike,
        d: ArrayLike | None = None,
        *,
        t_min: float = 0.0,
        t_max: float = math.inf,
        threads: int = 0,
        progress: Any = None,
    ) -> Cost:
        """What finding the first crossing of each ray takes: see `Cost`. Takes and raises what `closest` does."""
        shape, ask = _ask(o, d, t_min, t_max, threads, progress)
        return Cost(*(column.reshape(shape) for column in self._native.cost(ask).T))

    def contains(self, p: ArrayLike, *, threads: int = 0, progress: Any = None) -> np.ndarray:
        """Whether points of shape (..., 3) are inside of any object: (...) bool. No promise within rounding of a
        surface.

        Raises ValueError for a point with NaN or infinite numbers, by its row, and where a mesh is not closed.
        """
        where = points(p, "p")
        inside = self._native.contains(where.reshape(-1, 3), _threads(threads), callback(progress))
        return inside.reshape(where.shape[:-1])

    def objects_at(self, p: ArrayLike, *, threads: int = 0, progress: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """The objects that hold each of n points: `splits`, (n + 1,) int64, and `object`, (rows,) int32; those of point
        i are `object[splits[i] : splits[i + 1]]`, ascending. Takes and raises what `contains` does."""
        where = points(p, "p")
        return self._native.objects_containing(where.reshape(-1, 3), _threads(threads), callback(progress))

    def measure(
        self,
        *,
        rays: int = 1 << 16,
        seed: int = 0,
        method: str = "best",
        overlaps: str = "all",
        objects: Iterable[int | str] | None = None,
        threads: int = 0,
        progress: Any = None,
    ) -> Measures:
        """Volume, mass, centroid and inertia of objects, with their errors: see `Measures`.

        Exact where there are closed forms: solids given by parameters and closed meshes, by themselves or several whose
        boxes do not overlap, under any transforms. Else by rays: their stretches inside are integrated in closed form
        and the rays are spread evenly, sixteen times over; how much these differ tells the standard error. It is an
        estimate, not a bound, and a part too small for the rays may not be seen at all.

        Args:
            rays: rays for each object without a closed form.
            seed: chooses the rays; with it and `rays` every bit is the same, for any number of threads.
            method: "best" uses closed forms, "rays" none.
            overlaps: "all" measures each object whatever else is there; otherwise as of `segments`.
            objects: which ones, by number or name; None for all.
            threads, progress: as of `closest`.

        Raises:
            ValueError: for an object without end, a mesh that is not closed, and a name that is none.

        >>> scene = Scene(Box(min=(0, 0, 0), max=(1, 2, 3)).named("box"))
        >>> scene.measure().volume, scene.measure().centroid.round(12)
        (array([6.]), array([[0.5, 1. , 1.5]]))
        """
        if method not in ("best", "rays"):
            raise ValueError(f'method is {method!r}, but must be "best" or "rays"')
        if rays < 1:
            raise ValueError(f"rays is {rays}, but must be positive")
        chosen = None if objects is None else [n for item in objects for n in self._objects(item)]
        how = (int(rays), int(seed), method == "best", overlaps, chosen)
        return Measures(*_native.measure(self._native, how, _threads(threads), callback(progress)))

    def _objects(self, item: int | str) -> list[int]:
        if not isinstance(item, str):
            return [_number(item, "object")]
        found = [number for number, name in enumerate(self.object_names) if name == item]
        if not found:
            raise ValueError(f"there is no object {item!r}")
        return found

    # --- pictures

    def render(
        self,
        camera: Camera | None = None,
        *,
        size: tuple[int, int] = (800, 600),
        samples: int = 4,
        look: str = "lit",
        lighting: str = "sharp",
        background: str | None = None,
        counter: str = "boxes",
        threads: int = 0,
        progress: Any = None,
    ) -> Image:
        """A picture, with the scene's materials and lights.

        Args:
            camera: from where; None for the scene's own camera, or one that frames everything.
            size: width and height in pixels.
            samples: samples a pixel; more make smoother edges.
            look: what it shows: "lit", "normal", "depth", "thickness" or "cost".
            lighting: "sharp" or, with 32 samples or more, "soft".
            background: "studio", "white", "black", "transparent" or a colour such as "#336699"; None leaves it to the
                look.
            counter: what the look "cost" counts: "boxes", "cells", "planes", "solids", "tags", "heap" or "all".

        Returns:
            `Image`, an array of shape (height, width, 3), or 4 with a transparent background, uint8 sRGB.

        Raises:
            ValueError: for a camera that sees nothing, a size out of range, a name that is none.
        """
        width, height = size
        seen = (camera.eye, camera.target, camera.up, camera.fov, camera.height) if camera else None
        style = (width, height, samples, look, lighting, counter, background)
        return Image(_native.render(self._native, style, seen, _threads(threads), callback(progress)))

    def plot_ray(
        self, o: ArrayLike, d: ArrayLike, *, ax: Any = None, t_min: float = 0.0, t_max: float = math.inf
    ) -> Any:
        """Draw the stretches of one ray inside each path as bars over t, with `matplotlib`; crossings are marked by
        triangles that point right where the ray enters and left where it leaves.

        Args:
            o, d: one ray, (3,) each.
            ax: the axes to draw on; None for new ones.
            t_min, t_max: as of `closest`.

        Returns:
            The axes. Raises ImportError without matplotlib (`pip install shotline[plot]`).
        """
        from .plot import plot_ray

        return plot_ray(self, o, d, ax=ax, t_min=t_min, t_max=t_max)

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

    def with_moved(self, path: str, transform: ArrayLike) -> Scene:
        """A scene in which one thing is placed elsewhere; this one stays as it is.

        Only what lies above the move is worked out again, and the rest is shared between the two scenes. The first call
        takes as long as compiling; those after it, and those of the scenes it returns, hardly any time.

        Args:
            path: what to move: the name of a path, or the beginning of one, as `path_name` tells it:
                "robot/arm[2]/bolt[0]", "robot/arm[2]" or "robot". A part that is shared moves wherever it is.
            transform: of shape (3, 4), (4, 4) or (12,): the coordinates of the group it is in from its own, instead of
                all that placed it there.

        Raises:
            ValueError: for a path that is none, and a matrix that is singular.

        >>> scene = Scene(Sphere(radius=1).named("ball"))
        >>> moved = scene.with_moved("ball", [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5]])
        >>> float(moved.closest([0, 0, 0], [0, 0, 1]).t), float(scene.closest([0, 0, -3], [0, 0, 1]).t)
        (4.0, 2.0)
        """
        return Scene._of(self._native.with_moved(path, affine(transform)), self._accel)

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

    def _repr_html_(self) -> str:
        from .tree import html

        return html(json.loads(self._pack()[0]), repr(self))


def _ask(
    o: Any, d: Any, t_min: float, t_max: float, threads: int, progress: Any
) -> tuple[tuple[int, ...], tuple[Any, ...]]:
    """A query in the terms of the core, and the shape of its answer."""
    shape, count, origins, directions = rays(o, d)
    return shape, (count, origins, directions, float(t_min), float(t_max), _threads(threads), callback(progress))


def _threads(threads: int) -> int:
    if not 0 <= threads <= 1024:
        raise ValueError(f"threads is {threads}, but must be from 0 (one a core) to 1024")
    return int(threads)


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
