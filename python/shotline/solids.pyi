# Made from the registry of solids: UPDATE_STUBS=1 python -m pytest python/tests/test_stubs.py
from numpy.typing import ArrayLike

from .nodes import Vector
from .solid import Solid

__all__ = ["Halfspace", "Box", "Sphere", "Ellipsoid", "Cylinder", "Cone", "Paraboloid", "Hyperboloid", "Hyperboloid2", "Quadric", "Torus", "Tube", "ConeSection", "CutTube", "EllipsoidSection", "EllipticalCone", "EllipticalCylinder", "HyperboloidShell", "ParaboloidSection", "SphereSection", "TorusSection", "Revolved", "Polycone", "Polyhedra", "GenericPolyhedra", "Extruded", "Tetrahedron", "Trapezoid", "TwistedTube", "TwistedTrapezoid"]

class Halfspace(Solid):
    normal: Vector
    offset: float
    def __init__(self, normal: ArrayLike, offset: float) -> None: ...

class Box(Solid):
    min: Vector
    max: Vector
    def __init__(self, min: ArrayLike, max: ArrayLike) -> None: ...

class Sphere(Solid):
    radius: float
    def __init__(self, radius: float) -> None: ...

class Ellipsoid(Solid):
    semi_axes: Vector
    def __init__(self, semi_axes: ArrayLike) -> None: ...

class Cylinder(Solid):
    radius: float
    z0: float
    z1: float
    def __init__(self, radius: float, z0: float, z1: float) -> None: ...

class Cone(Solid):
    r0: float
    r1: float
    z0: float
    z1: float
    def __init__(self, r0: float, r1: float, z0: float, z1: float) -> None: ...

class Paraboloid(Solid):
    radius: float
    z0: float
    z1: float
    def __init__(self, radius: float, z0: float, z1: float) -> None: ...

class Hyperboloid(Solid):
    a: float
    c: float
    z0: float
    z1: float
    def __init__(self, a: float, c: float, z0: float, z1: float) -> None: ...

class Hyperboloid2(Solid):
    a: float
    c: float
    z0: float
    z1: float
    def __init__(self, a: float, c: float, z0: float, z1: float) -> None: ...

class Quadric(Solid):
    coeffs: tuple[float, ...]
    def __init__(self, coeffs: ArrayLike) -> None: ...

class Torus(Solid):
    R: float
    r: float
    def __init__(self, R: float, r: float) -> None: ...

class Tube(Solid):
    rmin: float
    rmax: float
    z0: float
    z1: float
    phi0: float
    dphi: float
    def __init__(self, rmin: float, rmax: float, z0: float, z1: float, phi0: float = ..., dphi: float = ...) -> None: ...

class ConeSection(Solid):
    rmin0: float
    rmax0: float
    rmin1: float
    rmax1: float
    z0: float
    z1: float
    phi0: float
    dphi: float
    def __init__(self, rmin0: float, rmax0: float, rmin1: float, rmax1: float, z0: float, z1: float, phi0: float = ..., dphi: float = ...) -> None: ...

class CutTube(Solid):
    rmin: float
    rmax: float
    z0: float
    z1: float
    normal0: Vector
    normal1: Vector
    phi0: float
    dphi: float
    def __init__(self, rmin: float, rmax: float, z0: float, z1: float, normal0: ArrayLike, normal1: ArrayLike, phi0: float = ..., dphi: float = ...) -> None: ...

class EllipsoidSection(Solid):
    semi_axes: Vector
    z0: float
    z1: float
    def __init__(self, semi_axes: ArrayLike, z0: float, z1: float) -> None: ...

class EllipticalCone(Solid):
    a: float
    b: float
    height: float
    apex: float
    z0: float
    z1: float
    def __init__(self, a: float, b: float, height: float, apex: float, z0: float, z1: float) -> None: ...

class EllipticalCylinder(Solid):
    a: float
    b: float
    z0: float
    z1: float
    def __init__(self, a: float, b: float, z0: float, z1: float) -> None: ...

class HyperboloidShell(Solid):
    rmin: float
    rmax: float
    stereo_min: float
    stereo_max: float
    z0: float
    z1: float
    def __init__(self, rmin: float, rmax: float, stereo_min: float, stereo_max: float, z0: float, z1: float) -> None: ...

class ParaboloidSection(Solid):
    r0: float
    r1: float
    z0: float
    z1: float
    def __init__(self, r0: float, r1: float, z0: float, z1: float) -> None: ...

class SphereSection(Solid):
    rmin: float
    rmax: float
    phi0: float
    dphi: float
    theta0: float
    dtheta: float
    def __init__(self, rmin: float, rmax: float, phi0: float = ..., dphi: float = ..., theta0: float = ..., dtheta: float = ...) -> None: ...

class TorusSection(Solid):
    R: float
    rmin: float
    rmax: float
    phi0: float
    dphi: float
    def __init__(self, R: float, rmin: float, rmax: float, phi0: float = ..., dphi: float = ...) -> None: ...

class Revolved(Solid):
    points: tuple[tuple[float, ...], ...]
    phi0: float
    dphi: float
    def __init__(self, points: ArrayLike, phi0: float = ..., dphi: float = ...) -> None: ...

class Polycone(Solid):
    planes: tuple[tuple[float, ...], ...]
    phi0: float
    dphi: float
    def __init__(self, planes: ArrayLike, phi0: float = ..., dphi: float = ...) -> None: ...

class Polyhedra(Solid):
    planes: tuple[tuple[float, ...], ...]
    sides: float
    phi0: float
    dphi: float
    def __init__(self, planes: ArrayLike, sides: float, phi0: float = ..., dphi: float = ...) -> None: ...

class GenericPolyhedra(Solid):
    points: tuple[tuple[float, ...], ...]
    sides: float
    phi0: float
    dphi: float
    def __init__(self, points: ArrayLike, sides: float, phi0: float = ..., dphi: float = ...) -> None: ...

class Extruded(Solid):
    polygon: tuple[tuple[float, ...], ...]
    sections: tuple[tuple[float, ...], ...]
    def __init__(self, polygon: ArrayLike, sections: ArrayLike) -> None: ...

class Tetrahedron(Solid):
    corners: tuple[tuple[float, ...], ...]
    def __init__(self, corners: ArrayLike) -> None: ...

class Trapezoid(Solid):
    z: float
    lower: tuple[tuple[float, ...], ...]
    upper: tuple[tuple[float, ...], ...]
    def __init__(self, z: float, lower: ArrayLike, upper: ArrayLike) -> None: ...

class TwistedTube(Solid):
    rmin: float
    rmax: float
    z0: float
    z1: float
    twist: float
    phi0: float
    dphi: float
    def __init__(self, rmin: float, rmax: float, z0: float, z1: float, twist: float, phi0: float = ..., dphi: float = ...) -> None: ...

class TwistedTrapezoid(Solid):
    z: float
    lower: tuple[tuple[float, ...], ...]
    upper: tuple[tuple[float, ...], ...]
    twist: float
    shift_x: float
    shift_y: float
    def __init__(self, z: float, lower: ArrayLike, upper: ArrayLike, twist: float, shift_x: float = ..., shift_y: float = ...) -> None: ...
