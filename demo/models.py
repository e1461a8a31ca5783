"""The scenes around large meshes, as the dictionaries that scene files contain."""

import json
import shutil

import mesh

BLUE = {"color": [0.44, 0.64, 0.84], "specular": 0.3, "shininess": 50}
CORAL = {"color": [0.93, 0.57, 0.49], "specular": 0.3, "shininess": 50}
GROUND = {"color": [0.95, 0.94, 0.92]}
LAMPS = [
    {"point": [-5, -10, 8], "color": [1, 0.97, 0.92], "intensity": 0.75},
    {"ambient": True, "color": [0.93, 0.96, 1], "intensity": 0.42},
]


class Model:
    """A mesh scene in two files: with a ground, for pictures, and without it, for measurements."""

    def __init__(self, name, node, floor, camera, material, looks):
        self.name, self.node, self.floor, self.camera = name, node, floor, camera
        self.material, self.looks = material, looks

    def write(self, folder):
        """Writes both files and returns their paths."""
        thing = {"name": self.name, "material": "thing", "node": self.node}
        ground = {
            "name": "ground",
            "material": "ground",
            "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": self.floor},
        }
        paths = []
        for suffix, objects in [("", [thing, ground]), ("-alone", [thing])]:
            scene = {
                "shotline": 1,
                "objects": objects,
                "camera": self.camera,
                "lights": LAMPS,
                "materials": {"thing": self.material, "ground": GROUND},
            }
            path = folder / f"{self.name}{suffix}.json"
            path.write_text(json.dumps(scene, indent=1))
            paths.append(path)
        return paths


def models(data, folder):
    """The models: real meshes where there is a folder with them, otherwise a generated one."""
    if (data / "armadillo.ply").exists() and (data / "bunny.ply").exists():
        for name in ["bunny.ply", "armadillo.ply"]:
            shutil.copyfile(data / name, folder / name)
        return [bunny(), armadillo()]
    mesh.write_ply(folder / "knot.ply", *mesh.knot())
    return [knot()]


def bunny():
    """A mesh that is open at the bottom: a surface, not a solid. Its y axis points up."""
    node = {"kind": "mesh", "file": "bunny.ply", "rotate": [90, 0, 0]}
    camera = {"eye": [-0.12, -0.5, 0.28], "target": [-0.017, 0, 0.105], "up": [0, 0, 1], "fov": 26}
    return Model("bunny", node, 0.033, camera, BLUE, ["lit", "normal"])


def armadillo():
    """A mesh minus a torus around its belly, which leaves a groove like a belt. Its y axis points up."""
    node = {
        "op": "difference",
        "rotate": [90, 0, 0],
        "args": [
            {"kind": "mesh", "file": "armadillo.ply"},
            {"kind": "torus", "R": 0.135, "r": 0.045, "translate": [-0.005, -0.02, -0.075], "rotate": [78, 8, 0]},
        ],
    }
    camera = {"eye": [0.62, -2.15, 0.62], "target": [0, 0, -0.085], "up": [0, 0, 1], "fov": 30}
    return Model("armadillo", node, -0.572, camera, CORAL | {"mu": 8}, ["lit", "xray", "thickness"])


def knot():
    """The knot minus a torus that lies on it and leaves grooves in its upper turns."""
    node = {
        "op": "difference",
        "args": [
            {"kind": "mesh", "file": "knot.ply"},
            {"kind": "torus", "R": 1, "r": 0.2, "translate": [0, 0, 0.6]},
        ],
    }
    camera = {"eye": [-1.2, -5, 4.6], "target": [0, 0, -0.05], "up": [0, 0, 1], "fov": 32}
    return Model("knot", node, -0.73, camera, CORAL | {"mu": 2.4}, ["lit", "normal", "xray", "thickness"])
