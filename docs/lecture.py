#!/usr/bin/env python3
"""Make the pictures of docs/lecture.md: python docs/lecture.py

The blocks of the page run one after the other. Where the page shows lecture-NAME.png, the function NAME below draws it from
what the blocks have made so far.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import numpy as np
from PIL import Image as Pixels
from shotline import Camera, Light, Scene

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

DOCS = Path(__file__).resolve().parent
# A block of code, or a picture.
PART = re.compile(r"^```python\n(.*?)^```$|^!\[[^\n]*\]\(pictures/lecture-(\w+)\.png\)$", re.DOTALL | re.MULTILINE)
RAY = {"arrowstyle": "->", "color": "crimson"}
LIGHTS = [Light(point=(-6, -10, 12), intensity=0.8), Light(ambient=True, intensity=0.45)]


def section(ax, scene, area, plane="z=0"):
    """Draws what is inside, in grey."""
    found = scene.slice(plane, area=area, size=(800, round(800 * (area[3] - area[1]) / (area[2] - area[0]))))
    inside = found.object >= 0
    ax.imshow(inside, extent=found.extent, cmap="Greys", vmax=4, alpha=inside.astype(float), zorder=2)
    ax.set(aspect="equal", xlabel="x", ylabel="z" if plane.startswith("y") else "y")


def normals(page):
    """Normals of an ellipsoid, right and wrong."""
    fig, ax = plt.subplots(figsize=(8, 3.2), layout="constrained")
    section(ax, page.egg, (-2.8, -1.1, 2.8, 1.1))
    ways = ((page.right, "tab:blue", "$(T^{-1})^T n$"), (page.wrong, "tab:red", "$T n$, wrong"))
    for arrows, color, label in ways:
        arrows = arrows / np.linalg.norm(arrows, axis=1)[:, None]
        at = page.hits.points[:, :2].T
        ax.quiver(*at, *arrows[:, :2].T, color=color, label=label, scale=20, width=0.004, zorder=3)
    ax.legend(loc="center")
    return fig


def implicit(page):
    """The values of a quadric, and its normals."""
    fig, ax = plt.subplots(figsize=(6.2, 4), layout="constrained")
    x, z = np.meshgrid(np.linspace(-3.2, 3.2, 200), np.linspace(-2.3, 2.3, 140))
    points = np.stack([x, 0 * x, z, np.ones_like(x)], axis=-1)
    f = np.einsum("...i,ij,...j", points, page.Q, points)
    values = ax.contourf(x, z, f, levels=range(-8, 11, 2), cmap="RdBu", vmin=-10, vmax=10)
    ax.contour(x, z, f, levels=[0], colors="black")
    ax.quiver(*page.hits.points[:, ::2].T, *page.hits.normal[:, ::2].T, scale=16, width=0.005)
    ax.set(aspect="equal", xlabel="x", ylabel="z", title="$x^2 + y^2 - z^2 - 1$ at y = 0, and normals")
    fig.colorbar(values)
    return fig


def graph(page):
    """A plate in two frames, with one ray."""
    fig, axes = plt.subplots(1, 2, figsize=(10, 3.4), layout="constrained")
    areas = ((-0.5, -0.2, 8.7, 4.4), (-2.6, -1.2, 2.2, 1.2))
    for ax, (scene, o, d), area in zip(axes, (page.world, page.local), areas, strict=True):
        section(ax, scene, area)
        ax.annotate("", (o + 8.3 * d)[:2], o[:2], arrowprops=RAY)
        hits = scene.crossings(o, d)
        ax.quiver(*hits.points[:, :2].T, *hits.normal[:, :2].T, color="tab:blue", scale=14, width=0.006, zorder=3)
        for t, point in zip(hits.t, hits.points, strict=True):
            ax.annotate(f"{t:.2f}", point[:2], (2, -15), textcoords="offset points")
    axes[0].set(title="the world")
    axes[1].set(title="the plate's own frame")
    return fig


def instances(page):
    """Heaps of heaps."""
    camera = Camera(eye=(4, 2.2, 3), target=(0, 0, 0), fov=30)
    return page.fun.render(camera, size=(360, 300), samples=6)


def torus(page):
    """The four roots."""
    fig, (side, curve) = plt.subplots(1, 2, figsize=(10, 2.8), layout="constrained", width_ratios=(1.6, 1))
    section(side, page.ring, (-4, -1.2, 4, 1.2), "y=0")
    side.annotate("", (page.o + 8 * page.d)[::2], page.o[::2], arrowprops=RAY)
    side.plot(*(page.o + page.roots[:, None] * page.d)[:, ::2].T, "o", color="tab:blue")
    t = np.linspace(0.8, 7.2, 200)
    curve.plot(t, page.quartic(t), color="crimson")
    curve.axhline(0, color="0.4", linewidth=0.8)
    curve.plot(page.roots, 0 * page.roots, "o", color="tab:blue")
    curve.set(xlabel="t", title="the quartic along the ray")
    return fig


def hits(page):
    """Four rays and a pipe."""
    fig, ax = plt.subplots(figsize=(7, 3.6), layout="constrained")
    section(ax, page.pipe, (-4, -2.2, 4, 2.3))
    colors = ("tab:blue", "tab:orange", "tab:green", "tab:red")
    for color, (name, found) in zip(colors, page.lists.items(), strict=True):
        x, y, _ = page.starts[name]
        ax.annotate("", (4, y), (x, y), arrowprops=RAY | {"color": color})
        ax.text(2.2, y + 0.08, name, color=color)
        for t_in, t_out in zip(found.t[::2], found.t[1::2], strict=True):
            ends = [x + t_in, x + t_out]
            ax.plot(ends, [y, y], color=color, linewidth=5, solid_capstyle="butt", alpha=0.6, zorder=3)
    return fig


def roth(page):
    """Three combinations, and the lists of one ray."""
    fig, axes = plt.subplots(2, 3, figsize=(9, 4), layout="constrained", height_ratios=(2, 1), sharey="row")
    camera = Camera(eye=(-1.5, -8, 5), target=(2.6, 0, 0), fov=21)
    for (view, bars), name in zip(axes.T, ("A + B", "A * B", "A - B"), strict=True):
        clay = {"clay": {"color": (0.9, 0.6, 0.5)}}
        scene = Scene(page.solids[name].named(name, material="clay"), materials=clay, lights=LIGHTS)
        view.imshow(scene.render(camera, size=(300, 180), background="white"))
        view.set(title=name)
        view.axis("off")
        for row, (of, color) in enumerate((("A", "tab:blue"), ("B", "tab:orange"), (name, "tab:green"))):
            t_in, t_out = page.lists[of]
            bars.barh(row, t_out - t_in, left=t_in, color=color, height=0.6)
        bars.set(xlim=(0, 5), xticks=(0.9, 2.5, 3.1, 4.5), ylim=(2.6, -0.6), xlabel="t")
        bars.set(yticks=(0, 1, 2), yticklabels=("A", "B", "result"))
    return fig


def coherence(page):
    """Where pixels see other things than their neighbours in space and time."""
    fig, axes = plt.subplots(1, 4, figsize=(11, 2.5), layout="constrained")
    edges = ~np.pad(page.same_pixel, ((0, 0), (1, 0)), constant_values=True)
    floor = page.table.object_names.index("floor")
    shown = {
        "object": np.where(page.first.object == floor, -1, page.first.object),
        "other than its neighbour": edges,
        "other in the next frame": ~page.same_frame,
        "what occludes the lamp": page.occluder,
    }
    for ax, (title, values) in zip(axes, shown.items(), strict=True):
        seen = {"cmap": "Greys"} if values.dtype == bool else {"cmap": "prism", "alpha": (values >= 0) * 0.8}
        ax.imshow(values, interpolation="nearest", **seen)
        ax.set(title=title, xticks=(), yticks=())
    return fig


def cells(page):
    """What one ray opens in four structures."""
    fig, axes = plt.subplots(2, 2, figsize=(10, 6.2), layout="constrained", sharex=True, sharey=True)
    for ax, accel in zip(axes.flat, ("bvh_fast", "grid", "octree", "bsp"), strict=True):
        opened = opened_parts(accel)
        for part in opened:
            corner, width, height = rectangle(part, page)
            box = plt.Rectangle(corner, width, height, facecolor=(0.2, 0.5, 0.8, 0.12), edgecolor="tab:blue")
            ax.add_patch(box)
        section(ax, page.flat, (-1.2, -0.8, 17.2, 10))
        ax.annotate("", (17, 2.2), (-1, 4), arrowprops=RAY)
        ax.set(title=f"{accel}: {len(opened)} opened")
        ax.label_outer()
    return fig


def opened_parts(accel):
    """What the ray of the page opens, without leaves of a BSP tree, which the steps do not place."""
    ray = ["--from=-1,4,0", "--dir=1,-0.1,0"]
    shoot = [
        sys.executable,
        "-m",
        "shotline",
        "shoot",
        "flat.json",
        *ray,
        "--trace=closest",
        "--json",
        "--accel",
        accel,
    ]
    steps = json.loads(subprocess.run(shoot, check=True, capture_output=True).stdout)["trace"]["steps"]
    return [step["part"] for step in steps if step["step"] == "open" and "leaf" not in step["part"]]


def rectangle(part, page):
    """The corner and the size of a box, a cell or a plane, as a step names it."""
    low = np.array([page.x - page.size, page.y - page.size]).min(axis=1)
    high = np.array([page.x + page.size, page.y + page.size]).max(axis=1)
    numbers = [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", part)]
    if " of " in part:  # cell i,j,k of n x m x l
        step = (high - low) / numbers[3:5]
        return low + step * numbers[:2], *step
    if part.startswith("plane"):
        across = np.array([part[6] == "x", part[6] == "y"])
        return np.where(across, numbers[0], low), *np.where(across, 0, high - low)
    return (numbers[0], numbers[2]), numbers[1] - numbers[0], numbers[3] - numbers[2]


def cost(page):
    """The work at a mesh in five structures."""
    fig, axes = plt.subplots(1, 5, figsize=(11, 2.5), layout="constrained")
    for ax, (name, work) in zip(axes, page.costs.items(), strict=True):
        image = ax.imshow(work.all, origin="lower", vmin=0, vmax=120, cmap="inferno", interpolation="nearest")
        ax.set(title=f"{name}: {work.all.mean():.0f}", xticks=(), yticks=())
    fig.colorbar(image, ax=axes, label="work of a ray", extend="max")
    return fig


FIGURES = {f.__name__: f for f in (normals, implicit, graph, instances, torus, hits, roth, coherence, cells, cost)}


def save(picture, name):
    """Few colours keep the repository small."""
    path = DOCS / "pictures" / f"lecture-{name}.png"
    picture.savefig(path, dpi=80) if isinstance(picture, plt.Figure) else picture.save(path)
    with Pixels.open(path) as made:
        made.convert("RGB").quantize(128, dither=Pixels.Dither.NONE).save(path, optimize=True)
    print(f"{path.name}: {path.stat().st_size / 1024:.0f} KiB")


def main():
    page = DOCS / "lecture.md"
    names = {"__name__": "__main__"}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for code, figure in PART.findall(page.read_text()):
            if figure:
                save(FIGURES[figure](SimpleNamespace(**names)), figure)
            else:
                exec(compile(code, str(page), "exec"), names)
        os.chdir(DOCS)


if __name__ == "__main__":
    main()
