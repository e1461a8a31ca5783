"""What a scene is made of, read back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property

from ._native import Mesh as NativeMesh
from ._native import Scene as NativeScene
from .appearance import Camera, Light, Material
from .mesh import Mesh
from .nodes import Object
from .reading import Reader, parsed
from .values import integer, suggestion


class Read:
    """The parts of a scene, read from its text when they are needed."""

    def __init__(self, text: str, meshes: Iterable[NativeMesh]) -> None:
        self.document = parsed(text)
        self.meshes = tuple(Mesh._of_native(native) for native in meshes)

    @cached_property
    def objects(self) -> tuple[Object, ...]:
        return tuple(Reader(self.document, self.meshes).objects())


class Contents:
    """The parts of a `Scene`."""

    __slots__ = ("_read",)
    _native: NativeScene
    _read: Read | None

    def _pack(self) -> tuple[str, list[NativeMesh]]:
        raise NotImplementedError

    def _contents(self) -> Read:
        if self._read is None:
            self._read = Read(*self._pack())
        return self._read

    @property
    def objects(self) -> tuple[Object, ...]:
        """The objects in the order of their numbers, so `scene.objects[hits.object[i]]` is what ray i hit. Also those inside
        other objects and in groups.

        An object that is at the top level, once, is where it is in the world. Any other is in the coordinates of what it
        is in; `path_transform` tells where its copies are. Labels of placements are not kept.
        """
        return self._contents().objects

    @property
    def materials(self) -> dict[str, Material]:
        """The materials by name, in the order of their numbers; a copy."""
        materials = self._contents().document.get("materials", {})
        return {name: Material(**keys) for name, keys in materials.items()}

    @property
    def camera(self) -> Camera | None:
        """The camera of the scene, if it has one."""
        keys = self._contents().document.get("camera")
        return None if keys is None else Camera(**keys)

    @property
    def lights(self) -> tuple[Light, ...]:
        """The lights of the scene."""
        return tuple(Light(**keys) for keys in self._contents().document.get("lights", []))

    @property
    def meshes(self) -> tuple[Mesh, ...]:
        """The meshes, each once, in the order in which the text of `to_json` numbers them."""
        return self._contents().meshes

    def to_json(self) -> str:
        """The scene as the text of a scene file. Meshes are named by their index in `meshes`, as in `"file": "0"`; to
        write them to files, use `save`.

        >>> scene = Scene(Sphere(radius=2).named("ball"), units="mm")
        >>> Scene.from_json(scene.to_json()) == scene
        True
        """
        return self._pack()[0]

    def __getitem__(self, key: str | int) -> Object:
        """The object of a name or number. Raises KeyError for a name that no object has, or several; IndexError for a
        number that does not exist."""
        if not isinstance(key, str):
            number, count = integer(key, "the number of an object"), len(self.objects)
            if not -count <= number < count:
                raise IndexError(f"the scene has {count} objects, numbered from 0: there is no {number}")
            return self.objects[number]
        found = [item for item in self.objects if item.name == key]
        if len(found) == 1:
            return found[0]
        if found:
            raise KeyError(f"{len(found)} objects are named {key!r}: choose from scene.objects")
        names = list(dict.fromkeys(item.name for item in self.objects))
        hint = suggestion(key, names, "the names are") if names else "the scene is empty"
        raise KeyError(f"there is no object {key!r}: {hint}")

    def __iter__(self) -> Iterator[Object]:
        return iter(self.objects)

    def __len__(self) -> int:
        """The number of objects."""
        return len(self._native.object_names())

    def __bool__(self) -> bool:
        return True

    def __contains__(self, key: object) -> bool:
        """Whether there is an object of this name, or that is equal to this one."""
        return key in self._native.object_names() if isinstance(key, str) else key in self.objects
