"""Meshes and scenes of other packages as arrays. They are recognised by the attributes that those packages document."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .values import floats


class Polygons(NamedTuple):
    """Faces with any number of corners: the vertex indices of their corners, one face after the other, and the number
    of corners of each."""

    corners: np.ndarray
    sizes: np.ndarray

    @classmethod
    def of(cls, blocks: Sequence[np.ndarray]) -> Polygons:
        """From blocks, each with faces of one size."""
        corners = np.concatenate([block.reshape(-1) for block in blocks])
        return cls(corners, np.repeat([block.shape[1] for block in blocks], [len(block) for block in blocks]))


class Surface(NamedTuple):
    """A surface, and notes of what was left out. The faces are `Polygons` or anything that `Mesh` takes."""

    vertices: Any
    faces: Any
    notes: list[str]


class Instance(NamedTuple):
    """An instance of a mesh in a scene: its name, the mesh, and the matrix (4, 4), scene from mesh."""

    name: str
    mesh: Any
    matrix: np.ndarray


def surface(source: Any) -> Surface:
    """The faces of a mesh of another package.

    Lines and points are left out and noted. Raises ValueError for volume meshes and curved cells, TypeError for
    anything that is not a mesh.
    """
    if is_scene(source):
        return _of_scene(source)
    for belongs, read in _READERS:
        if belongs(source):
            return read(source)
    if hasattr(source, "extract_surface"):
        raise ValueError(f"a {_kind(source)} holds more than a surface: take its extract_surface()")
    if isinstance(source, str) or hasattr(source, "__fspath__"):
        raise TypeError(f"a mesh takes vertices and faces, not a file: shotline.load({str(source)!r}) reads one")
    raise TypeError(f"a mesh takes vertices and faces, or a mesh of another package, not {_kind(source)}")


def is_scene(source: Any) -> bool:
    """Whether it is a scene of trimesh: named geometries, and a graph of their instances."""
    return hasattr(source, "geometry") and hasattr(getattr(source, "graph", None), "nodes_geometry")


def instances(scene: Any) -> tuple[list[Instance], list[str]]:
    """Every instance of a mesh in a scene of trimesh, in the order of its nodes, and notes of what is left out."""
    found, notes = [], []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        mesh = scene.geometry[name]
        if hasattr(mesh, "faces"):
            found.append(Instance(str(node), mesh, np.asarray(matrix, np.float64)))
        else:
            notes.append(f"{node!r} is left out: a {_kind(mesh)} has no faces")
    return found, notes


def _of_scene(scene: Any) -> Surface:
    """All meshes of a scene, transformed and joined."""
    found, notes = instances(scene)
    if not found:
        raise ValueError("the scene holds no mesh")
    vertices, faces, count = [], [], 0
    for _, mesh, matrix in found:
        points, corners = floats(mesh.vertices, "vertices"), np.asarray(mesh.faces)
        # A reflection inverts the orientation of faces.
        mirrored = np.linalg.det(matrix[:3, :3]) < 0
        vertices.append(points @ matrix[:3, :3].T + matrix[:3, 3])
        faces.append((corners[:, ::-1] if mirrored else corners) + count)
        count += len(points)
    return Surface(np.concatenate(vertices), np.concatenate(faces), notes)


# --- meshio

# Cells without an area.
_THIN = {"vertex": "points", "line": "lines", "line3": "lines", "VTK_LAGRANGE_CURVE": "lines"}
_FLAT = {"triangle", "quad", "polygon"}


def _of_meshio(source: Any) -> Surface:
    points = floats(source.points, "points")
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    faces, left_out, refused = [], dict[str, int](), dict[str, int]()
    # Not from the dictionary where possible: it has only polygons of one size.
    blocks = [(block.type, block.data) for block in getattr(source, "cells", ())] or source.cells_dict.items()
    for kind, data in blocks:
        cells = np.asarray(data)
        if kind in _FLAT:
            faces.append(cells)
        else:
            counts = left_out if kind in _THIN else refused
            kind = _THIN.get(kind, kind)
            counts[kind] = counts.get(kind, 0) + len(cells)
    if refused:
        kinds = ", ".join(f"{count} of {kind}" for kind, count in refused.items())
        message = f"this mesh has cells that are not triangles, quads or polygons: {kinds}"
        raise ValueError(f"{message}; extract its surface with the package that made it")
    if not faces:
        raise ValueError(f"this mesh has no triangles, but {_counted(left_out) or 'no cells'}")
    return Surface(points, Polygons.of(faces), _left_out(left_out))


# --- pyvista


def _of_pyvista(source: Any) -> Surface:
    points = floats(source.points, "points")
    cells = np.asarray(source.faces)
    sizes = _sizes(cells)
    # Each face follows the number of its corners.
    is_count = np.zeros(len(cells), bool)
    is_count[np.cumsum(sizes + 1) - sizes - 1] = True
    is_face = np.repeat(sizes >= 3, sizes)
    corners, kept = [cells[~is_count][is_face]], [sizes[sizes >= 3]]
    strips = np.asarray(source.strips)
    start = 0
    while start < len(strips):
        strip = _of_strip(strips[start + 1 : start + 1 + strips[start]])
        corners.append(strip.reshape(-1))
        kept.append(np.full(len(strip), 3))
        start += 1 + int(strips[start])
    faces = Polygons(np.concatenate(corners), np.concatenate(kept))
    left_out = {
        "lines": int(source.n_lines),
        "points": int(source.n_verts),
        "faces of two corners": int((sizes < 3).sum()),
    }
    if not len(faces.sizes):
        raise ValueError(f"this mesh has no faces, but {_counted(left_out) or 'no cells'}")
    return Surface(points, faces, _left_out(left_out))


def _sizes(cells: np.ndarray) -> np.ndarray:
    """The number of corners of each face, in an array where each face follows its number of corners."""
    if cells.size % 4 == 0 and (cells[::4] == 3).all():
        return np.full(cells.size // 4, 3)
    sizes, start = [], 0
    while start < len(cells):
        sizes.append(int(cells[start]))
        start += 1 + sizes[-1]
    return np.array(sizes, np.int64)


def _of_strip(strip: np.ndarray) -> np.ndarray:
    """The triangles of a strip; every second one has its orientation reversed."""
    faces = np.column_stack([strip[:-2], strip[1:-1], strip[2:]])
    faces[1::2] = faces[1::2, [1, 0, 2]]
    return faces


# --- shared by all packages


def _left_out(counts: dict[str, int]) -> list[str]:
    return [f"{_counted(counts)} left out: without an area"] if any(counts.values()) else []


def _counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{count} {_one(kind) if count == 1 else kind}" for kind, count in counts.items() if count)


def _one(kinds: str) -> str:
    return {"lines": "line", "points": "point", "faces of two corners": "face of two corners"}.get(kinds, kinds)


def _kind(source: Any) -> str:
    return type(source).__name__


def _has(*names: str) -> Callable[[Any], bool]:
    return lambda source: all(hasattr(source, name) for name in names)


def _is_meshio(source: Any) -> bool:
    # The grids of pyvista have these attributes too.
    return hasattr(source, "points") and hasattr(source, "cells_dict") and not hasattr(source, "extract_surface")


def _of_open3d(source: Any) -> Surface:
    return Surface(np.asarray(source.vertices), np.asarray(source.triangles), [])


def _of_open3d_tensors(source: Any) -> Surface:
    return Surface(source.vertex.positions.numpy(), source.triangle.indices.numpy(), [])


_READERS: list[tuple[Callable[[Any], bool], Callable[[Any], Surface]]] = [
    (_is_meshio, _of_meshio),
    (_has("points", "faces", "strips", "n_lines", "n_verts"), _of_pyvista),
    (_has("vertices", "faces"), lambda source: Surface(source.vertices, source.faces, [])),  # trimesh
    (_has("vertices", "triangles"), _of_open3d),
    (_has("vertex", "triangle"), _of_open3d_tensors),
]
