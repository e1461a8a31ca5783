#!/usr/bin/env python3
"""Make the pictures of the page of solids: python docs/solids.py [NAME ...]

One small picture of each kind of solid, which also shows its bottom and, where it is hollow, its inside. A kind without an
example here is found by a test.
"""

import sys
from pathlib import Path

import numpy as np
import shotline
from PIL import Image as Pixels
from shotline import Camera, Light, Material, Node, Scene

OUT = Path(__file__).resolve().parent / "pictures/solids"
SIZE = (200, 150)
WALL = [(-1, 0.5, 1.2), (0, 0.5, 1.2), (0, 0.3, 0.8), (1, 0.3, 1)]
SQUARE, SMALL = [(-1, -1), (1, -1), (1, 1), (-1, 1)], [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
ELL = [(-1, -1), (1, -1), (1, -0.3), (-0.3, -0.3), (-0.3, 1), (-1, 1)]

# The parameters of one typical example of each kind.
EXAMPLES = {
    "Halfspace": {"normal": (0, 0.3, 1), "offset": 0},
    "Box": {"min": (-1, -0.7, -0.5), "max": (1, 0.7, 0.5)},
    "Sphere": {"radius": 1},
    "Ellipsoid": {"semi_axes": (1.2, 0.8, 0.6)},
    "Cylinder": {"radius": 0.8, "z0": -0.8, "z1": 0.8},
    "Cone": {"r0": 1, "r1": 0.4, "z0": -0.7, "z1": 0.7},
    "Paraboloid": {"radius": 1, "z0": -0.7, "z1": 0.7},
    "Hyperboloid": {"a": 0.5, "c": 0.6, "z0": -0.9, "z1": 0.9},
    "Hyperboloid2": {"a": 0.35, "c": 0.35, "z0": -0.85, "z1": 0.85},
    "Quadric": {"coeffs": (1, 1, -0.5, 0.6, 0, 0, 0, 0, 0, -0.3)},
    "Torus": {"R": 1, "r": 0.4},
    "Tube": {"rmin": 0.6, "rmax": 1, "z0": -0.7, "z1": 0.7, "phi0": 0, "dphi": 270},
    "ConeSection": {
        "rmin0": 0.7,
        "rmax0": 1,
        "rmin1": 0.3,
        "rmax1": 0.6,
        "z0": -0.7,
        "z1": 0.7,
        "phi0": 0,
        "dphi": 270,
    },
    "CutTube": {
        "rmin": 0.5,
        "rmax": 0.9,
        "z0": -0.7,
        "z1": 0.7,
        "normal0": (0, -0.4, -1),
        "normal1": (0.5, 0, 1),
    },
    "EllipsoidSection": {"semi_axes": (1.2, 0.8, 1), "z0": -0.5, "z1": 0.6},
    "EllipticalCone": {"a": 0.5, "b": 0.3, "height": 1, "apex": 1.4, "z0": -0.7, "z1": 0.7},
    "EllipticalCylinder": {"a": 1.1, "b": 0.6, "z0": -0.7, "z1": 0.7},
    "HyperboloidShell": {"rmin": 0.4, "rmax": 0.6, "stereo_min": 30, "stereo_max": 35, "z0": -1, "z1": 1},
    "ParaboloidSection": {"r0": 0.4, "r1": 1, "z0": -0.7, "z1": 0.7},
    "SphereSection": {"rmin": 0.6, "rmax": 1, "phi0": 0, "dphi": 270, "theta0": 20, "dtheta": 110},
    "TorusSection": {"R": 1, "rmin": 0.25, "rmax": 0.4, "phi0": 0, "dphi": 270},
    "Revolved": {"points": [(0.6, -0.7), (1.2, -0.7), (1.2, 0), (0.8, 0.7), (0.6, 0.3)], "phi0": 0, "dphi": 270},
    "Polycone": {"planes": WALL, "phi0": 0, "dphi": 270},
    "Polyhedra": {"planes": WALL, "sides": 6, "phi0": 0, "dphi": 270},
    "GenericPolyhedra": {"points": [(0.6, -0.7), (1.2, -0.7), (1.2, 0), (0.8, 0.7), (0.6, 0.3)], "sides": 8},
    "Extruded": {"polygon": ELL, "sections": [(-0.8, 0, 0, 1), (0, 0, 0, 0.6), (0.8, 0.3, 0, 0.8)]},
    "Tetrahedron": {"corners": [(-1, -0.7, -0.7), (1, -0.7, -0.7), (0, 1, -0.7), (0, 0, 0.9)]},
    "Trapezoid": {"z": 0.7, "lower": SQUARE, "upper": SMALL},
    "TwistedTube": {"rmin": 0.5, "rmax": 1, "z0": -1, "z1": 1, "twist": 60, "phi0": 0, "dphi": 60},
    "TwistedTrapezoid": {"z": 0.8, "lower": SQUARE, "upper": SMALL, "twist": 50},
}
# These have no bounds. A box is shown of each.
UNBOUNDED = {"Halfspace", "Quadric"}


def picture(name: str) -> shotline.Image:
    """One kind, on a transparent ground, so that it suits pages with a light and with a dark one."""
    solid: Node = getattr(shotline, name)(**EXAMPLES[name])
    if name in UNBOUNDED:
        solid &= shotline.Box(min=(-1, -1, -0.7), max=(1, 1, 0.7))
    lights = [Light(direction=(0.5, 0.9, -1.2), intensity=0.75), Light(ambient=True, intensity=0.4)]
    materials = {"blue": Material(color=(0.36, 0.56, 0.80), specular=0.3, shininess=40)}
    scene = Scene(solid.named("solid", material="blue"), materials=materials, lights=lights)
    camera = Camera(eye=(2.6, -4.4, 3.4), target=(0, 0, 0), fov=26)
    return scene.render(camera, size=SIZE, samples=32, background="transparent")


def main() -> None:
    OUT.mkdir(exist_ok=True)
    wanted = sys.argv[1:]
    for name in wanted or EXAMPLES:
        path = OUT / f"{name}.png"
        Pixels.fromarray(np.asarray(picture(name))).save(path, optimize=True)
        print(f"{path.name}: {path.stat().st_size / 1024:.0f} KiB")


if __name__ == "__main__":
    main()
