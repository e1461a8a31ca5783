# cython: language_level=3
"""Loops over rays in Raysect without a Python call per ray: the speed of its engine, which its users do not get."""
from raysect.core.intersection cimport Intersection
from raysect.core.math.point cimport new_point3d
from raysect.core.math.vector cimport new_vector3d
from raysect.core.ray cimport Ray, new_ray
from raysect.core.scenegraph.primitive cimport Primitive


cdef Ray ray(double[:, ::1] rays, Py_ssize_t i):
    return new_ray(
        new_point3d(rays[i, 0], rays[i, 1], rays[i, 2]), new_vector3d(rays[i, 3], rays[i, 4], rays[i, 5]), float("inf")
    )


def first(Primitive solid, double[:, ::1] rays):
    """The distance of each ray's first hit, None for a miss."""
    cdef Py_ssize_t i
    cdef Intersection hit
    out = []
    for i in range(rays.shape[0]):
        hit = solid.hit(ray(rays, i))
        out.append(None if hit is None else hit.ray_distance)
    return out


def every(Primitive solid, double[:, ::1] rays):
    """The distances of all hits of each ray."""
    cdef Py_ssize_t i
    cdef Intersection hit
    out = []
    for i in range(rays.shape[0]):
        row = []
        hit = solid.hit(ray(rays, i))
        while hit is not None:
            row.append(hit.ray_distance)
            hit = solid.next_intersection()
        out.append(row)
    return out
