#!/usr/bin/env python3
"""Draw sections, cut-open views and a material budget of detectors: python docs/detectors.py [FOLDER with cmse.gdml, ...]

A section is made of rays that lie in it: what owns each part of a ray is the colour of its pixels. The views in three
dimensions have the colours of the sections.
"""

import json
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import matplotlib
import numpy as np
import shotline

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402
from PIL import Image as Pixels  # noqa: E402

OUT = Path(__file__).resolve().parent / "pictures"
FOLDER = Path(__file__).resolve().parents[2] / "shared" / "data" / "gdml"

# For each file what is coloured, the axis across the plane, the axes along the picture and upwards with their ranges in
# metres, and where the plane is. All volumes of cmse are of air.
SECTIONS = {
    "cmse": ("object", "y", "z", "x", (-16, 16), (-9, 9), 0.0),
    "lhcb_calos": ("material", "y", "z", "x", (11.9, 15.6), (-1.2, 1.2), 0.105),
    "protodunehd_v8": ("material", "z", "x", "y", (-7.5, 7.5), (-2.5, 10.5), 2.3),
}

OTHER = (0.6, 0.6, 0.6)

# For each file the planes that cut it open, what is not shown, and the camera, in metres.
VIEWS = {
    "cmse": {
        "clip": ["1,0,0,0", "0,0,1,16", "0,0,-1,16"],
        "hide": ["OCMS", "CMSE", "CMStoZDC", "ZDCtoFP420"],
        "eye": (34, 17, 24),
        "target": (0, -0.6, 0.8),
        "fov": 29,
    },
    "lhcb_calos": {
        "clip": ["0,1,0,0.105", "0,-1,0,0.8", "1,0,0,1.3", "-1,0,0,1.3"],
        "hide": ["Air", "Vacuum"],
        "eye": (-2.6, 3.4, 9.0),
        "target": (0, -0.25, 13.6),
        "fov": 25,
    },
    "protodunehd_v8": {
        "clip": ["0,0,-1,-2.3", "1,0,0,6.2", "-1,0,0,6.2"],
        "hide": ["Air", "LAr", "ArGas", "Concrete"],
        "eye": (-7, 11, -15),
        "target": (0.4, 3.2, 4),
        "fov": 36,
    },
}


def axis(name):
    return "xyz".index(name)


def section(scene, what, across, along, upwards, width, height, at, pixels=(900, 620)):
    """The material or object of each pixel of a section; -1 outside of all."""
    rows = np.linspace(*height, 2 * pixels[1] + 1)[1::2] * 1000
    rays = np.zeros((len(rows), 6))
    rays[:, axis(across)], rays[:, axis(along)], rays[:, axis(upwards)] = at * 1000, width[0] * 1000, rows
    rays[:, 3 + axis(along)] = 1
    found = scene.segments(rays, overlaps="priority")
    t = np.linspace(0, (width[1] - width[0]) * 1000, 2 * pixels[0] + 1)[1::2]
    image = np.full((len(rows), len(t)), -1)
    for row, (first, last) in enumerate(zip(found.ray_splits[:-1], found.ray_splits[1:], strict=True)):
        number = np.searchsorted(found.t_in[first:last], t, side="right") - 1
        inside = (number >= 0) & (t < found.t_out[first:last][number])
        image[row, inside] = getattr(found, what)[first:last][number[inside]]
    return image


def short(name):
    """A name without the folders and the address that programs add."""
    return name.split("0x")[0].split("_")[-1]


def draw_section(name, folder):
    """Draws a section. Returns the colours by short name, those of the largest areas first."""
    scene = shotline.load(folder / f"{name}.gdml")
    what, across, along, upwards, width, height, at = SECTIONS[name]
    names = scene.object_names if what == "object" else scene.material_names
    image = section(scene, what, across, along, upwards, width, height, at)
    numbers, counts = np.unique(image[image >= 0], return_counts=True)
    numbers = numbers[np.argsort(-counts)]
    colours = np.ones((len(names) + 1, 3))
    palette = iter(plt.get_cmap("tab20").colors * 9)
    for number in numbers:
        colours[number] = (0.93, 0.94, 0.96) if short(names[number]) in ("Air", "OCMS") else next(palette)
    figure, axes = plt.subplots(figsize=(10, 6.2), dpi=90, layout="constrained")
    axes.imshow(colours[image], extent=(*width, *height), origin="lower", interpolation="nearest", aspect="equal")
    axes.set(xlabel=f"{along} in m", ylabel=f"{upwards} in m", title=f"{name}, {across} = {at} m")
    by_name = {short(names[number]): tuple(map(float, colours[number])) for number in numbers}
    add_legend(axes, by_name)
    figure.savefig(OUT / f"detector-{name}.png")
    plt.close(figure)
    return by_name


def add_legend(axes, colours):
    for name in list(colours)[:14]:
        axes.plot([], [], "s", color=colours[name], markeredgecolor="0.6", label=name)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8, frameon=False)


def objects_of(node):
    """All objects below a node of a scene file."""
    if isinstance(node, dict):
        if "name" in node and "node" in node:
            yield node
        for below in node.values():
            yield from objects_of(below)
    elif isinstance(node, list):
        for below in node:
            yield from objects_of(below)


def draw_view(name, folder, colours):
    """Draws a detector cut open, with the colours of its section."""
    what, view = SECTIONS[name][0], VIEWS[name]
    with tempfile.TemporaryDirectory() as temporary:
        path, picture = Path(temporary, f"{name}.json"), Path(temporary, f"{name}.png")
        subprocess.run(["shotline", "convert", folder / f"{name}.gdml", path], check=True, capture_output=True)
        scene = json.loads(path.read_text())
        hidden, kinds = [], set()
        for part in objects_of([scene["defs"], scene["objects"]]):
            if what == "object":
                part["material"] = part["name"]
            kinds.add(kind := part.get("material", ""))
            if short(kind) in view["hide"]:
                hidden.append(part["name"])
        shown = {part: colour for part, colour in colours.items() if part not in view["hide"]}
        scene["materials"] = {kind: {"color": shown.get(short(kind), OTHER)} for kind in kinds if kind}
        scene["camera"] = {"eye": [1000 * x for x in view["eye"]], "target": [1000 * x for x in view["target"]]}
        scene["camera"] |= {"up": [0, 1, 0], "fov": view["fov"]}
        path.write_text(json.dumps(scene))
        planes = [plane.split(",") for plane in view["clip"]]
        options = [f"--clip={','.join(plane[:3])},{1000 * float(plane[3])}" for plane in planes]
        options += [f"--hide={part}" for part in dict.fromkeys(hidden)]
        options += ["--size", "900x620", "--samples", "6", "--background", "white"]
        subprocess.run(["shotline", "render", path, "-o", picture, *options], check=True, capture_output=True)
        image = plt.imread(picture)
    figure, axes = plt.subplots(figsize=(10, 6.2), dpi=90, layout="constrained")
    axes.imshow(image)
    axes.set_axis_off()
    axes.set_title(f"{name}, cut open")
    add_legend(axes, dict(list(shown.items())[:13]) | {"other": OTHER})
    path = OUT / f"detector-{name}-cut.png"
    figure.savefig(path, bbox_inches="tight")
    # 256 colours, so that the repository stays small; an octree keeps the rare ones of the legend.
    few = Pixels.open(path).convert("RGB").quantize(256, Pixels.Quantize.FASTOCTREE, dither=Pixels.Dither.NONE)
    few.save(path, optimize=True)
    plt.close(figure)


def densities(path):
    """The density of each material, as `shotline info` tells it, in g/cm^3."""
    told = subprocess.run(["shotline", "info", path, "--json"], check=True, capture_output=True, text=True)
    return {material["name"]: material["density"] or 0.0 for material in json.loads(told.stdout)["materials"]}


def draw_budget(name, folder):
    """The mass that rays from the origin pass, by where they are 12 m away."""
    path = folder / f"{name}.gdml"
    scene = shotline.load(path)
    x, y = np.meshgrid(np.linspace(-4.2, 4.2, 420), np.linspace(-3.6, 3.6, 360))
    aims = np.stack([x, y, np.full_like(x, 12.0)], -1) * 1000
    directions = aims / np.linalg.norm(aims, axis=-1, keepdims=True)
    rays = np.concatenate([np.zeros_like(directions), directions], -1)
    known = densities(path)
    weights = np.array([known[material] for material in scene.material_names] + [0.0])
    mass = scene.thickness(rays, overlaps="priority") @ weights / 10
    figure, axes = plt.subplots(figsize=(9, 6.6), dpi=90, layout="constrained")
    shown = axes.imshow(mass, extent=(-4.2, 4.2, -3.6, 3.6), origin="lower", cmap="viridis")
    figure.colorbar(shown, label="g/cm$^2$")
    axes.set(xlabel="x in m, 12 m away", ylabel="y in m", title=f"{name}: mass along rays from the origin")
    figure.savefig(OUT / f"detector-{name}-budget.png")
    plt.close(figure)


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    warnings.simplefilter("ignore", shotline.OverlapWarning)
    for name in SECTIONS:
        draw_view(name, folder, draw_section(name, folder))
    draw_budget("lhcb_calos", folder)


if __name__ == "__main__":
    main()
