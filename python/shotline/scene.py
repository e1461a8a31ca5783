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
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native, text
from .foreign import instances, is_scene
from .image import Image, settings
from .looks import Camera, Light, Material
from .mesh import Mesh, weld_text
from .nodes import Node, Object, accelerator, affine
from .progress import callback
from .queries import Queries, number_of, threads_of
from .results import Measures
from .values import choice, whole
from .values import text as text_of


class Scene(Queries):
    """A scene, compiled when it is made and immutable from then on; any number of threads may ask it.

    `objects` are objects (`node.named("bolt", material="steel")`) or plain nodes, which become objects named `object0`
    and so on. A `trimesh.Scene` may be given in their place: its nodes become objects of their names, and meshes that it
    places several times are shared. `materials` maps names to `Material`s or dicts of their parameters. `units` is the unit of length: "nm",
    "um", "mm", "cm", "m", "km", "in" or "ft"; "none" or None for a scene without one. No length is converted.

    `accel` names the accelerator of all parts that have none of their own: a combination, a mesh or a shared group that
    was made with `accel=` keeps that. No answer depends on it. `load(path, accel=...)` overrides those of parts too.

    Raises ValueError for a scene that cannot be built, and warns (`DuplicateNameWarning`) where one name stands for
    objects that are not the same.

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
        if len(objects) == 1 and is_scene(objects[0]):
            objects = tuple(_placed_meshes(objects[0]))
        elif len(objects) == 1 and not isinstance(objects[0], Node):
            objects = _nodes(objects[0])
        for item in objects:
            if not isinstance(item, Node):
                raise TypeError(_no_node(item))
        made = {
            text_of(name, "a material's name"): _material(name, item) for name, item in (materials or {}).items()
        }
        if camera is not None and not isinstance(camera, Camera):
            raise TypeError(f"camera must be a Camera, not {type(camera).__name__}")
        words, meshes = text.write(
            objects,  # type: ignore[arg-type]
            {name: material._keys() for name, material in made.items()},
            camera._keys() if camera else None,
            [_light(light)._keys() for light in lights],
            None if units is None else choice(units, "units", _native.units()),
            accelerator(accel),
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

    # --- more than rays

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
        and the rays are spread over strata by the boxes of solids, sixteen times over; how much these, or the three
        axes, differ tells the standard error. It is an estimate, not a bound, and a part too small for the rays may
        not be seen at all.

        Args:
            rays: rays for each object without a closed form.
            seed: chooses the rays; with it and `rays` every bit is the same, for any number of threads.
            method: "best" uses closed forms, "rays" none.
            overlaps: "all" measures each object whatever else is there; otherwise as of `segments`.
            objects: which ones, by number or name; None for all.
            threads, progress: as of `closest`.

        Raises:
            ValueError: for a mesh that is not closed, a volume that overflows or underflows, and a name or a number
                that no object has.

        >>> scene = Scene(Box(min=(0, 0, 0), max=(1, 2, 3)).named("box"))
        >>> scene.measure().volume, scene.measure().centroid.round(12)
        (array([6.]), array([[0.5, 1. , 1.5]]))
        """
        if method not in ("best", "rays"):
            raise ValueError(f'method is {method!r}, but must be "best" or "rays"')
        rays, seed = whole(rays, "rays", 1, 2**63 - 1), whole(seed, "seed", 0, 2**64 - 1)
        if isinstance(objects, str):
            raise TypeError(f"objects is a list of names and numbers, as in [{objects!r}], not a string")
        chosen = None if objects is None else [n for item in objects for n in self._objects(item)]
        how = (rays, seed, method == "best", text_of(overlaps, "overlaps"), chosen)
        return Measures(*_native.measure(self._native, how, threads_of(threads), callback(progress)))

    def _objects(self, item: int | str) -> list[int]:
        if not isinstance(item, str):
            return [number_of(item, "object", 2**32)]
        found = [number for number, name in enumerate(self.object_names) if name == item]
        if not found:
            raise ValueError(f"there is no object {item!r}")
        return found

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
            look: what it shows: "lit", "normal", "depth", "thickness" (with a legend in the scene's units), "xray" or "cost".
            lighting: "sharp" or, with 32 samples or more, "soft".
            background: "studio", "white", "black", "transparent" or a colour such as "#336699"; None leaves it to the
                look.
            counter: what the look "cost" counts: "boxes", "cells", "planes", "solids", "tags", "heap" or "all".

        Returns:
            `Image`, an array of shape (height, width, 3), or 4 with a transparent background, uint8 sRGB.

        Raises:
            ValueError: for a camera that sees nothing, a size out of range, an unknown name.
        """
        style, sight = settings(camera, size, samples, look, lighting, background, counter)
        return Image(_native.render(self._native, style, sight, threads_of(threads), callback(progress)))

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
            ValueError: for an unknown path, one that begins with the name of several objects, and a matrix that is singular.

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
                if (polygons := mesh.polygons()) is not None:
                    digest.update(np.ascontiguousarray(polygons, "<u4").data)
            self._hash = digest.hexdigest()
        return self._hash

    def __reduce__(self) -> Any:
        words, meshes = self._pack()
        return _unpacked, (
            self.content_hash,
            words,
            [(mesh.vertices(), mesh.faces(), mesh.polygons()) for mesh in meshes],
            self._accel,
        )

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


def _placed_meshes(scene: Any) -> Iterable[Object]:
    """The meshes of a scene of trimesh as objects named after their nodes; one that is placed twice is shared."""
    found, notes = instances(scene)
    for note in notes:
        warnings.warn(note, stacklevel=3)
    meshes: dict[int, Mesh] = {}
    for name, mesh, matrix in found:
        shared = meshes.get(id(mesh)) or meshes.setdefault(id(mesh), Mesh(mesh))
        plain = np.array_equal(matrix, np.eye(4))
        yield (shared if plain else shared.transform(matrix)).named(name)


def _nodes(items: Any) -> tuple[Any, ...]:
    try:
        return tuple(items)
    except TypeError:
        raise TypeError(_no_node(items)) from None


def _no_node(item: Any) -> str:
    message = f"a scene is made of objects and other nodes, not of {_kind(item)}"
    wrapped = hasattr(item, "faces") or hasattr(item, "triangles") or hasattr(item, "cells_dict")
    return f"{message}: wrap a mesh of another package, as in Scene(Mesh(mesh))" if wrapped else message


def _material(name: str, material: Material | Mapping[str, Any]) -> Material:
    if isinstance(material, Material):
        return material
    if not isinstance(material, Mapping):
        raise TypeError(f"material {name!r} must be a Material or a dict of its parameters, not {_kind(material)}")
    known = [field.name for field in fields(Material)]
    unknown = [key for key in material if key not in known]
    if unknown:
        raise TypeError(f"material {name!r} has no parameter {unknown[0]!r}; it takes {', '.join(known)}")
    return Material(**material)


def _light(light: Any) -> Light:
    if not isinstance(light, Light):
        raise TypeError(f"lights are Light objects, not {_kind(light)}")
    return light


def _kind(value: Any) -> str:
    return type(value).__name__


# The vertices and faces of a mesh, and the polygons that these were cut from.
_Arrays = tuple[np.ndarray, np.ndarray, np.ndarray | None]

# Scenes that were unpickled and are in use, by content hash and accelerator: a process builds each only once.
_known: weakref.WeakValueDictionary[tuple[str, str | None], Scene] = weakref.WeakValueDictionary()
_building = threading.Lock()


def _unpacked(digest: str, words: str, meshes: list[_Arrays], accel: str | None) -> Scene:
    with _building:
        scene = _known.get((digest, accel))
        if scene is None:
            scene = _known[digest, accel] = _built(words, meshes, accel)
            scene._hash = digest
        return scene


# Pickles name it by the package: a thread that began with this module, beside another that imports the package, would
# wait for that one, which waits for this module.
_unpacked.__module__ = "shotline"


def _built(words: str, meshes: list[_Arrays], accel: str | None) -> Scene:
    natives = [
        _native.Mesh(_aligned(vertices), _aligned(faces).reshape(-1), None, _aligned(polygons), None)
        for vertices, faces, polygons in meshes
    ]
    return Scene._of(_native.Scene.parse(words, natives, accel), accel)


def _aligned(array: Any) -> Any:
    """An array that came as a buffer of its own may begin anywhere in what was received."""
    return None if array is None else np.require(array, requirements=["C", "A"])


def _forget_building() -> None:
    """In a forked child, whose parent may have been building in a thread that the child does not have."""
    global _building
    _building = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_building)


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
) -> Scene:
    """Read a scene file (JSON), or a mesh (PLY, STL, OBJ) as a scene of one object named after the file.

    Args:
        path: the file.
        accel: the accelerator used everywhere, whatever the file says; no answer depends on it.
        allow_outside: let the scene name mesh files outside of its own folder.
        weld: weld the vertices of meshes that are up to this distance apart, in the lengths of the file; "auto" for those
            within rounding of each other and far from all others.

    Warns:
        ReadWarning: for each kind of thing that was dropped or repaired. `shotline info FILE` lists all notes.

    Raises:
        FileNotFoundError: if there is no such file.
        ValueError: with everything that is wrong, each with its line and how to mend it.
    """
    path = os.fspath(path)
    os.stat(path)
    native, notes = _native.Scene.load(path, accel, allow_outside, weld_text(weld))
    for note, changed in notes:
        if changed:
            warnings.warn(note, ReadWarning, stacklevel=2)
    return Scene._of(native, accel)
