"""Every crossing of rays with exact solids, in order, entering or exiting.

>>> import shotline
>>> plate = shotline.Box(min=(-2, -2, 0), max=(2, 2, 1)) - shotline.Cylinder(radius=0.5, z0=0, z1=1)
>>> scene = shotline.Scene(plate.named("plate"))
>>> hits = scene.crossings([-4, 0, 0.5], [2, 0, 0])
>>> hits.t.tolist(), hits.entering.tolist()
([1.0, 1.75, 2.25, 3.0], [True, False, True, False])

A ray is `o + t d`; `d` is any finite non-zero vector and `t` counts lengths of `d`. Lengths are in the units that the
scene is written in; nothing is converted. Everything is float64.
"""

from ._native import __version__
from .appearance import Camera, Light, Material
from .closest_points import ClosestPoints
from .image import Image
from .lattices import HexagonalLattice, Lattice, ring
from .loading import ReadWarning, load
from .mesh import Mesh
from .nodes import Difference, Group, Intersection, Node, Object, Union
from .queries import OverlapWarning
from .radiography import Detector, radiograph
from .results import Closest, Cost, Crossings, Measures, SegmentPerRay, Segments
from .scene import Scene, _unpacked  # noqa: F401
from .serialize import DuplicateNameWarning
from .slices import Slice
from .solids import *  # noqa: F403
from .solids import __all__ as _solids
from .viewing import View

__all__ = [
    "Camera",
    "Closest",
    "ClosestPoints",
    "Cost",
    "Crossings",
    "Detector",
    "Difference",
    "DuplicateNameWarning",
    "Group",
    "HexagonalLattice",
    "Image",
    "Intersection",
    "Lattice",
    "Light",
    "Material",
    "Measures",
    "Mesh",
    "Node",
    "Object",
    "OverlapWarning",
    "ReadWarning",
    "Scene",
    "SegmentPerRay",
    "Segments",
    "Slice",
    "Union",
    "View",
    "__version__",
    "load",
    "radiograph",
    "ring",
    *_solids,
]
