"""Scenes: compiled, immutable, ready for queries."""

from __future__ import annotations

import hashlib
import json
import math
import os
import threading
import warnings
import weakref
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .accelerators import accelerator
from .appearance import Camera, Light, Material
from .contents import Contents, Read
from .extension import Document, Settings, joined, materials_of
from .foreign import instances, is_scene
from .html_repr import html
from .mesh import Mesh
from .native_args import MeasureSettings
from .nodes import Node, Object
from .origin import Origin
from .path_names import path_hint
from .pictures import Pictures
from .plot import plot_ray, plot_slice
from .progress import callback
from .queries import Queries, number_of
from .results import Measures
from .serialize import serialize
from .values import affine, bounded_integer, choice, number, suggestion, text, threads_of


class Scene(Contents, Pictures, Queries):
    """A scene, compiled on construction and then immutable; any number of threads may query it.

    `objects` are objects (`node.named("bolt", material="steel")`) or plain nodes, which become objects named `object0`
    and so on. A `trimesh.Scene` may be given instead: its nodes become objects of the same names, and meshes
    with several instances are shared. `materials` maps names to `Material`s or dicts of their parameters. `units` is
    the unit of length: "nm", "um", "mm", "cm", "m", "km", "in" or "ft"; "none" or None for a scene without one. No
    length is converted.

    Other scenes may be among the objects, also those that were loaded: all of their objects become objects of this one, and
    rays find them as before, bit for bit. Their materials, lights and motions are joined, those given here are taken instead
    of others of the same name; the camera, the unit and the accelerator are those of the first scene that has them.

    The scene is read back by `objects`, `materials`, `camera`, `lights` and `units`. `scene["plate"]` and `scene[3]` are
    objects by name and number, iteration gives all objects, and `len` is their number.

    `accel` names the accelerator of all nodes that have none of their own: a combination, a mesh or a shared group made
    with `accel=` keeps that. No result depends on it. `load(path, accel=...)` also overrides the accelerators of nodes.

    Raises ValueError for a scene that cannot be compiled, and for scenes with different units or with different materials
    of one name; warns (`DuplicateNameWarning`) if different objects have
    the same name.

    >>> scene = Scene(Sphere(radius=2).named("ball"))
    >>> float(scene.closest([-5, 0, 0], [1, 0, 0]).t)
    3.0
    >>> scene["ball"].node.radius, len(Scene(scene, Box(min=(3, 0, 0), max=(4, 1, 1))))
    (2.0, 2)
    """

    __slots__ = ("__weakref__", "_accel", "_hash", "_native", "_packed")

    def __init__(
        self,
        *objects: Node | Scene | Iterable[Node | Scene],
        materials: Mapping[str, Material | Mapping[str, Any]] | None = None,
        camera: Camera | None = None,
        lights: Iterable[Light] = (),
        units: str | None = None,
        accel: str | None = None,
    ) -> None:
        items = _items(objects)
        for item in items:
            if not isinstance(item, (Node, Scene)):
                raise TypeError(_not_a_node(item))
        if camera is not None and not isinstance(camera, Camera):
            raise TypeError(f"camera must be a Camera, not {type(camera).__name__}")
        checked = _materials(materials or {})
        settings = Settings(
            {name: material._keys() for name, material in checked.items()},
            camera._keys() if camera else None,
            _lights(lights),
            None if units is None else choice(units, "units", _native.units()),
            accelerator(accel),
        )
        self._set(_native.Scene.parse(*_document(items, settings), None), None)

    def _set(self, native: _native.Scene, accel: str | None) -> None:
        self._native, self._accel = native, accel
        self._read: Read | None = None
        self._packed: tuple[str, list[_native.Mesh]] | None = None
        self._hash: str | None = None

    @classmethod
    def from_json(cls, document: str, *, meshes: Iterable[Mesh] = (), accel: str | None = None) -> Scene:
        """A scene from the text of a scene file, as `to_json` returns it.

        Args:
            document: the text; comments and trailing commas are allowed.
            meshes: the meshes that it names by their index, as in `"file": "0"`. Files are not read: `load` does that.
            accel: the accelerator of everything, instead of those in the text; no result depends on it.

        Raises ValueError with everything that is wrong.
        """
        given = [_mesh(mesh)._native for mesh in meshes]
        return cls._of(_native.Scene.parse(text(document, "the text of a scene"), given, accelerator(accel)), accel)

    @classmethod
    def _of(cls, native: _native.Scene, accel: str | None) -> Scene:
        scene = cls.__new__(cls)
        scene._set(native, accel)
        return scene

    # --- measuring, pictures and moves

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

        Exact where there are closed forms: parametric solids and closed meshes, alone or several whose boxes do not
        overlap, under any transforms. Otherwise by rays: their intervals inside are integrated in closed form, and the
        rays are stratified by the boxes of solids, in sixteen independent sets. The standard error follows from the
        differences between these sets, or between the three axes. It is an estimate, not a bound, and rays may miss a
        small feature completely.

        Args:
            rays: rays for each object without a closed form.
            seed: selects the rays; for the same seed and `rays` every bit is the same, for any number of threads.
            method: "best" uses closed forms, "rays" does not.
            overlaps: "all" measures each object independently of others; otherwise as in `segments`.
            objects: which ones, by number or name; None for all.
            threads, progress: as in `closest`.

        Raises:
            ValueError: for a mesh that is not closed, a volume that overflows or underflows, and an unknown name or
                number of an object.

        >>> scene = Scene(Box(min=(0, 0, 0), max=(1, 2, 3)).named("box"))
        >>> scene.measure().volume, scene.measure().centroid.round(12)
        (array([6.]), array([[0.5, 1. , 1.5]]))
        """
        if method not in ("best", "rays"):
            raise ValueError(f'method is {method!r}, but must be "best" or "rays"')
        rays, seed = bounded_integer(rays, "rays", 1, 2**63 - 1), bounded_integer(seed, "seed", 0, 2**64 - 1)
        if isinstance(objects, str):
            raise TypeError(f"objects is a list of names and numbers, as in [{objects!r}], not a string")
        numbers = None if objects is None else [n for item in objects for n in self._objects(item)]
        settings = MeasureSettings(rays, seed, method == "best", text(overlaps, "overlaps"), numbers)
        columns = _native.measure(self._native, settings, threads_of(threads), callback(progress))
        return Measures._of(columns, Origin(self, None, (len(columns[0]),)))

    def _objects(self, item: int | str) -> list[int]:
        if not isinstance(item, str):
            return [number_of(item, "object", 2**32)]
        found = [number for number, name in enumerate(self.object_names) if name == item]
        if not found:
            raise ValueError(f"there is no object {item!r}; {suggestion(item, self.object_names, 'the names are')}")
        return found

    def plot_ray(
        self, o: ArrayLike, d: ArrayLike, *, ax: Any = None, t_min: float = 0.0, t_max: float = math.inf
    ) -> Any:
        """Draw the intervals of one ray inside each path as bars over t, with `matplotlib`. Triangles mark the
        crossings; they point right where the ray enters and left where it exits.

        Args:
            o, d: one ray, (3,) each.
            ax: the axes to draw on; None for new ones.
            t_min, t_max: as in `closest`.

        Returns:
            The axes. Raises ImportError without matplotlib (`pip install shotline[plot]`).
        """
        return plot_ray(self, o, d, ax=ax, t_min=t_min, t_max=t_max)

    def plot_slice(self, plane: str | Sequence[float] = "z=0", *, ax: Any = None, **options: Any) -> Any:
        """Draw `slice(plane, **options)` with `matplotlib`: axes in the units of the scene, a legend, and hatched where
        objects overlap.

        Returns the axes, `ax` or new ones. Raises ImportError without matplotlib (`pip install shotline[plot]`).
        """
        return plot_slice(self, self.slice(plane, **options), ax=ax)

    def with_moved(self, path: str, transform: ArrayLike) -> Scene:
        """A scene in which one node has another transform; this scene does not change.

        Only the levels above the moved node are compiled again; the rest is shared between the two scenes. The first
        call takes as long as compiling; later calls, also on the returned scenes, take hardly any time.

        Args:
            path: the node to move: the name of a path as `path_name` returns it, or the beginning of one:
                "robot/arm[2]/bolt[0]", "robot/arm[2]" or "robot". A shared node moves in all its instances.
            transform: of shape (3, 4), (4, 4) or (12,): the coordinates of its group from its own. It replaces all
                transforms between the two.

        Raises:
            ValueError: for an unknown path, with those that might be meant, a path that begins with the name of several objects, and
                a singular matrix. The numbers of a path are never left out: else a second member of a name would change what moves.

        >>> scene = Scene(Sphere(radius=1).named("ball"))
        >>> moved = scene.with_moved("ball", [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5]])
        >>> float(moved.closest([0, 0, 0], [0, 0, 1]).t), float(scene.closest([0, 0, -3], [0, 0, 1]).t)
        (4.0, 2.0)
        """
        try:
            moved = self._native.with_moved(path, affine(transform))
        except ValueError as error:
            if not str(error).startswith("no path begins with"):
                raise
            raise ValueError(f"{error}; {path_hint(self, path)}") from None
        return Scene._of(moved, self._accel)

    def to_mesh(self, tolerance: float, *, threads: int = 0) -> Scene:
        """The scene with each object as a mesh within `tolerance` of its surface: closed, with sharp edges. Parts that are placed several
        times share a mesh and stay placed; the other objects at the root are in world coordinates. What an object contains is not cut out;
        an empty object is left out. Raises ValueError for unbounded objects and too small a tolerance.

        >>> part = Box(min=(0, 0, 0), max=(2, 2, 1)) - Cylinder(radius=0.5, z0=0, z1=1).translate(1, 1, 0)
        >>> mesh = Scene(part.named("part")).to_mesh(0.01)["part"].node
        >>> mesh.is_closed, round(float(mesh.areas.sum()), 1)
        (True, 17.6)
        """
        return Scene._of(self._native.to_mesh(number(tolerance, "tolerance"), threads_of(threads)), self._accel)

    # --- saving, pickling and hashing

    def save(self, path: str | os.PathLike[str]) -> list[str]:
        """Write a scene file, a GDML file, or the meshes to a glTF, 3MF or mesh file, by the extension of its name. The file
        appears complete or not at all. Returns what was lost, and which other files were written."""
        return self._native.save(os.fspath(path))

    def _pack(self) -> tuple[str, list[_native.Mesh]]:
        if self._packed is None:
            self._packed = self._native.pack()
        return self._packed

    @property
    def content_hash(self) -> str:
        """A hash of the whole content of the scene: scenes of equal hash give equal results, bit for bit."""
        if self._hash is None:
            document, meshes = self._pack()
            digest = hashlib.blake2b(document.encode(), digest_size=32)
            for mesh in meshes:
                vertices, faces = mesh.vertices(), mesh.faces()
                digest.update(f"{vertices.shape}{faces.shape}".encode())
                arrays: list[Any] = [vertices, faces, mesh.polygons()]
                for name, values, corners in mesh.attributes():
                    digest.update(f"{name!r}{values.shape}{corners is None}".encode())
                    arrays += [values, corners]
                for array in arrays:
                    if array is not None:
                        digest.update(np.ascontiguousarray(array, array.dtype.newbyteorder("<")).data)
            self._hash = digest.hexdigest()
        return self._hash

    def __reduce__(self) -> Any:
        document, meshes = self._pack()
        return _unpacked, (
            self.content_hash,
            document,
            [(mesh.vertices(), mesh.faces(), mesh.polygons(), mesh.attributes()) for mesh in meshes],
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
        return html(self._contents().document, repr(self))


def _placed_meshes(scene: Any) -> Iterable[Object]:
    """The meshes of a scene of trimesh as objects named after their nodes; a mesh with several instances is shared."""
    found, notes = instances(scene)
    for note in notes:
        warnings.warn(note, stacklevel=4)
    meshes: dict[int, Mesh] = {}
    for name, mesh, matrix in found:
        shared = meshes.get(id(mesh)) or meshes.setdefault(id(mesh), Mesh(mesh))
        is_identity = np.array_equal(matrix, np.eye(4))
        yield (shared if is_identity else shared.transform(matrix)).named(name)


def _items(given: tuple[Any, ...]) -> tuple[Any, ...]:
    """What a scene is made of: given one by one, as one list, or as a scene of trimesh."""
    if len(given) != 1 or isinstance(given[0], (Node, Scene)):
        return given
    if isinstance(given[0], (str, os.PathLike)):
        raise TypeError(_not_a_node(given[0]))
    if isinstance(given[0], Mapping):
        raise TypeError(f"{_not_a_node(given[0])}: objects get their names by .named(name)")
    if is_scene(given[0]):
        return tuple(_placed_meshes(given[0]))
    try:
        return tuple(given[0])
    except TypeError:
        raise TypeError(_not_a_node(given[0])) from None


def _document(items: tuple[Any, ...], settings: Settings) -> tuple[str, list[_native.Mesh]]:
    """The text of a scene that is made of nodes and other scenes, and the meshes that it names by their index."""
    scenes = [item for item in items if isinstance(item, Scene)]
    documents = [Document(scene._contents().document, scene._pack()[1]) for scene in scenes]
    materials = materials_of([document.content for document in documents], settings.materials)
    taken = {name for scene in scenes for name in scene.object_names}
    nodes = [item for item in items if isinstance(item, Node)] if scenes else items
    made = serialize(nodes, materials, taken)
    meshes = [mesh._native for mesh in made.meshes]
    if not scenes:
        return f"{json.dumps(settings.content(), allow_nan=False)[:-1]}, {made.members()}}}", meshes
    documents.append(Document(json.loads(f"{{{made.members()}}}"), meshes))
    order: list[int] = []
    number = iter(range(len(scenes)))
    for item in items:
        source = next(number) if isinstance(item, Scene) else len(scenes)
        order += [source] * (len(documents[source].content["objects"]) if isinstance(item, Scene) else 1)
    document = joined(documents, order, settings)
    return json.dumps(document.content, allow_nan=False), document.meshes


def _mesh(mesh: Any) -> Mesh:
    if not isinstance(mesh, Mesh):
        raise TypeError(f"meshes are Mesh objects, not {_kind(mesh)}")
    return mesh


def _not_a_node(item: Any) -> str:
    message = f"a scene is made of objects and other nodes, not of {_kind(item)}"
    if isinstance(item, os.PathLike) or (isinstance(item, str) and os.path.splitext(item)[1]):
        return f"{message}: a file is read by shotline.load({os.fspath(item)!r})"
    if isinstance(item, (list, tuple)):
        return f"{message}: give one list of nodes, or a Group for each list"
    is_mesh = hasattr(item, "faces") or hasattr(item, "triangles") or hasattr(item, "cells_dict")
    return f"{message}: wrap a mesh of another package, as in Scene(Mesh(mesh))" if is_mesh else message


def _materials(materials: Any) -> dict[str, Material]:
    if not isinstance(materials, Mapping):
        raise TypeError(f"materials are a dict of Materials by name, not {_kind(materials)}")
    return {text(name, "a material's name"): _material(name, item) for name, item in materials.items()}


def _lights(lights: Any) -> list[dict[str, Any]]:
    if isinstance(lights, Light):
        raise TypeError("lights are a list, as in lights=[Light(ambient=True)], not one Light")
    return [_light(light)._keys() for light in lights]


def _material(name: str, material: Material | Mapping[str, Any]) -> Material:
    if isinstance(material, Material):
        return material
    if not isinstance(material, Mapping):
        raise TypeError(f"material {name!r} must be a Material or a dict of its parameters, not {_kind(material)}")
    known = [field.name for field in fields(Material)]
    unknown = [key for key in material if key not in known]
    if unknown:
        hint = suggestion(str(unknown[0]), known, "it takes")
        raise TypeError(f"material {name!r} has no parameter {unknown[0]!r}; {hint}")
    return Material(**material)


def _light(light: Any) -> Light:
    if not isinstance(light, Light):
        raise TypeError(f"lights are Light objects, not {_kind(light)}")
    return light


def _kind(value: Any) -> str:
    return type(value).__name__


# The vertices and faces of a mesh, the polygon of each face, and the attributes.
_Arrays = tuple[np.ndarray, np.ndarray, np.ndarray | None, list[tuple[str, np.ndarray, np.ndarray | None]]]

# Unpickled scenes in use, by content hash and accelerator, so that a process builds each only once.
_known: weakref.WeakValueDictionary[tuple[str, str | None], Scene] = weakref.WeakValueDictionary()
_building = threading.Lock()


def _unpacked(digest: str, document: str, meshes: list[_Arrays], accel: str | None) -> Scene:
    with _building:
        scene = _known.get((digest, accel))
        if scene is None:
            scene = _known[digest, accel] = _built(document, meshes, accel)
            scene._hash = digest
        return scene


# Pickles refer to the function by the package. Otherwise a thread that imports this module could deadlock with a thread
# that imports the package.
_unpacked.__module__ = "shotline"


def _built(document: str, meshes: list[_Arrays], accel: str | None) -> Scene:
    natives = [
        _native.Mesh(
            _aligned(vertices),
            _aligned(faces).reshape(-1),
            None,
            _aligned(polygons),
            [(name, _aligned(values), _aligned(corners)) for name, values, corners in attributes],
            None,
        )
        for vertices, faces, polygons, attributes in meshes
    ]
    return Scene._of(_native.Scene.parse(document, natives, accel), accel)


def _aligned(array: Any) -> Any:
    """An aligned array: an array received as a separate buffer may start at any byte."""
    return None if array is None else np.require(array, requirements=["C", "A"])


def _reset_building_lock() -> None:
    """Replaces the lock in a forked child: a thread that the child does not have may hold it."""
    global _building
    _building = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_reset_building_lock)
