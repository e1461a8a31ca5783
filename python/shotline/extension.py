"""Joins the texts of scenes, so that everything in each of them stays as it is: also what Python has no name for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count
from typing import Any, NamedTuple

from . import _native


class Document(NamedTuple):
    """The content of the text of a scene, and the meshes, which it names by their index."""

    content: dict[str, Any]
    meshes: list[_native.Mesh]


class Settings(NamedTuple):
    """What a scene has besides objects; what is None or empty is taken from the scenes that it is made of."""

    materials: dict[str, dict[str, Any]]
    camera: dict[str, Any] | None
    lights: list[dict[str, Any]]
    units: str | None
    accel: str | None

    def content(self) -> dict[str, Any]:
        """The content of a document that has these, and no objects."""
        return {"shotline": 1} | {key: value for key, value in self._asdict().items() if value}


def joined(documents: Sequence[Document], order: Sequence[int], settings: Settings) -> Document:
    """A scene with the objects of several. `order` tells from which of them each object is; names of parts that are taken
    by earlier scenes change."""
    defs: dict[str, Any] = {}
    meshes: list[_native.Mesh] = []
    objects: list[Iterator[Any]] = []
    for document in documents:
        moved = _renumbered(document.content, defs, len(meshes))
        defs |= moved["defs"]
        objects.append(iter(moved["objects"]))
        meshes += document.meshes
    contents = [document.content for document in documents]
    sections = {
        "units": _units(contents, settings.units),
        "defs": defs,
        "accel": settings.accel or _first(contents, "accel"),
        "materials": materials_of(contents, settings.materials),
        "camera": settings.camera or _first(contents, "camera"),
        "lights": settings.lights or _all(contents, "lights"),
        "motions": _all(contents, "motions"),
    }
    content: dict[str, Any] = {"shotline": 1}
    content |= {key: value for key, value in sections.items() if value}
    content["objects"] = [next(objects[source]) for source in order]
    return Document(content, meshes)


def _renumbered(content: dict[str, Any], taken: dict[str, Any], first_mesh: int) -> dict[str, Any]:
    """The parts and objects of a scene, with other names for parts whose names are taken, and other numbers for meshes."""
    defs: dict[str, Any] = content.get("defs", {})
    names = {name: name for name in defs}
    used = {*taken, *defs}
    for name in defs:
        if name in taken:
            names[name] = next(new for new in (f"{name}_{i}" for i in count(2)) if new not in used)
            used.add(names[name])
    copy: dict[str, Any] = {
        "defs": {names[name]: entry for name, entry in defs.items()},
        "objects": list(content["objects"]),
    }
    if first_mesh or not taken.keys().isdisjoint(defs):
        _rename([copy["defs"], copy["objects"]], names, first_mesh)
    return copy


def _rename(owners: list[Any], names: dict[str, str], first_mesh: int) -> None:
    """Renames what entries refer to. They are copied first; not recursive, since scenes may be deep."""
    while owners:
        owner = owners.pop()
        for key, value in owner.items() if isinstance(owner, dict) else enumerate(owner):
            if isinstance(value, dict):
                value = owner[key] = dict(value)
                if "ref" in value:
                    value["ref"] = names[value["ref"]]
                if value.get("kind") == "mesh":
                    value["file"] = str(int(value["file"]) + first_mesh)
                owners.append(value)
            elif isinstance(value, list) and value and isinstance(value[0], dict):
                owner[key] = list(value)
                owners.append(owner[key])


def _units(contents: Sequence[dict[str, Any]], given: str | None) -> str | None:
    found = list(dict.fromkeys(content["units"] for content in contents if "units" in content))
    wanted = given if given is not None else found[0] if found else None
    for units in found:
        if units != wanted:
            raise ValueError(f"a scene in {units} cannot be part of one in {wanted}: no length is converted")
    return wanted


def materials_of(contents: Sequence[dict[str, Any]], given: dict[str, Any]) -> dict[str, Any]:
    """The materials of scenes, and those given, which count instead of others of their names."""
    materials: dict[str, Any] = {}
    for content in contents:
        for name, keys in content.get("materials", {}).items():
            if name not in given and materials.setdefault(name, keys) != keys:
                hint = f"give materials={{{name!r}: ...}}"
                raise ValueError(f"the scenes have different materials that are named {name!r}; {hint}")
            materials.setdefault(name, given.get(name))
    return materials | given


def _first(contents: Sequence[dict[str, Any]], key: str) -> Any:
    return next((content[key] for content in contents if key in content), None)


def _all(contents: Sequence[dict[str, Any]], key: str) -> list[Any]:
    return [entry for content in contents for entry in content.get(key, [])]
