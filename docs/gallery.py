#!/usr/bin/env python3
"""Make the pictures of the documentation with the package: python docs/gallery.py [NAME ...]

Those of the gallery are rendered; those of the concepts are sections through scenes, whose shapes and crossings also come
from shotline.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np
import shotline
from PIL import Image as Pixels
from shotline import Box, Camera, Cylinder, Group, Halfspace, Light, Paraboloid, Scene, Sphere, Torus

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

OUT = Path(__file__).resolve().parent / "pictures"
SIZE = (560, 420)
LIGHTS = [
    Light(point=(-16, -10, 20), color=(1, 0.97, 0.92), intensity=0.72),
    Light(ambient=True, color=(0.93, 0.96, 1), intensity=0.45),
]
MATERIALS = {
    "steel": {"color": (0.72, 0.74, 0.76), "specular": 0.7, "shininess": 110, "mirror": 0.2},
    "brass": {"color": (0.90, 0.75, 0.45), "specular": 0.5, "shininess": 80},
    "blue": {"color": (0.46, 0.62, 0.77), "specular": 0.35, "shininess": 50},
    "coral": {"color": (0.90, 0.50, 0.43), "specular": 0.3, "shininess": 50},
    "ground": {"color": (0.95, 0.94, 0.92)},
}


def ground(z):
    return Halfspace(normal=(0, 0, 1), offset=z).named("ground", material="ground")


# --- the gallery


def bearing_parts():
    """Two rings with a toroidal groove, and twelve balls, which are instances of one part."""
    groove = Torus(R=3, r=0.62)
    outer = Cylinder(radius=4, z0=-0.8, z1=0.8) - Cylinder(radius=3.35, z0=-0.8, z1=0.8) - groove
    inner = Cylinder(radius=2.65, z0=-0.8, z1=0.8) - Cylinder(radius=1.8, z0=-0.8, z1=0.8) - groove
    ball = Sphere(radius=0.6).translate(3, 0, 0).part("ball")
    balls = Group(ball.rotate(0, 0, 30 * k) for k in range(12))
    return outer, inner, balls


def bearing():
    """A ball bearing with a quarter of its outer ring cut away."""
    outer, inner, balls = bearing_parts()
    quarter = Box(min=(-5, -5, -1), max=(0.6, 0, 1))
    scene = Scene(
        (outer - quarter).named("outer ring", material="blue"),
        inner.named("inner ring", material="coral"),
        balls.named("balls", material="steel"),
        ground(-0.8),
        materials=MATERIALS,
        lights=LIGHTS,
    )
    return scene.render(
        Camera(eye=(-7, -11, 9), target=(0, 0, -0.3), fov=30), size=SIZE, samples=48, lighting="soft"
    )


def bearing_xray(look="xray"):
    """The fraction of light that passes through it."""
    scene = Scene(*(part.named(f"part{k}") for k, part in enumerate(bearing_parts())), units="cm")
    camera = Camera(eye=(-7, -11, 9), target=(0, 0, -0.3), fov=30)
    return scene.render(camera, size=SIZE, samples=16, look=look)


def bearing_thickness():
    """The length of rays inside it."""
    return bearing_xray("thickness")


def sponge_part():
    """Menger's sponge, subdivided three times: one cube minus 273 bars, flush at both ends, which pass through each other."""
    cube = Box(min=(-1, -1, -1), max=(1, 1, 1))
    holes = []
    for level in range(1, 4):
        width = 1 / 3**level
        middles = 2 * width * (3 * np.arange(3 ** (level - 1)) + 1) - 1 + width
        for x in middles:
            for y in middles:
                bar = ((x - width, x + width), (y - width, y + width), (-1, 1))
                for turn in range(3):
                    low, high = zip(*(bar[turn:] + bar[:turn]), strict=True)
                    holes.append(Box(min=low, max=high))
    return shotline.Difference(cube, *holes)


def sponge():
    scene = Scene(sponge_part().named("sponge", material="brass"), ground(-1), materials=MATERIALS, lights=LIGHTS)
    return scene.render(
        Camera(eye=(-3.2, -5.2, 2.9), target=(0.1, 0, -0.15), fov=30), size=SIZE, samples=48, lighting="soft"
    )


def chain():
    """Three links of a chain that are one shared part, and a bowl that is a paraboloid minus a paraboloid."""
    straight = Cylinder(radius=0.3, z0=-1, z1=1).rotate(0, 90, 0)
    bend = Torus(R=1, r=0.3) & Halfspace(normal=(1, 0, 0), offset=0)
    link = (
        straight.translate(0, 1, 0)
        | straight.translate(0, -1, 0)
        | bend.translate(-1, 0, 0)
        | bend.rotate(0, 0, 180).translate(1, 0, 0)
    ).part("link")
    links = Group(
        link.rotate(45, 0, 0).translate(-3.0, 0, 0),
        link.rotate(-45, 0, 0),
        link.rotate(45, 0, 0).translate(3.0, 0, 0),
    )
    bowl = Paraboloid(radius=1.8, z0=0, z1=1.6) - Paraboloid(radius=1.65, z0=0.15, z1=1.6)
    scene = Scene(
        links.named("chain", material="steel"),
        bowl.translate(0.4, -4.2, -1.0).named("bowl", material="coral"),
        ground(-1.0),
        materials=MATERIALS,
        lights=LIGHTS,
    )
    return scene.render(
        Camera(eye=(-6, -15, 9), target=(0, -1.3, -0.2), fov=31), size=SIZE, samples=48, lighting="soft"
    )


def drilled():
    """A block minus 3,000 spheres: one combination."""
    rng = np.random.default_rng(3)
    where, radius = rng.uniform(-1, 1, (3000, 3)), rng.uniform(0.03, 0.13, 3000)
    block = Box(min=(-1, -1, -1), max=(1, 1, 1))
    holes = [Sphere(radius=r).translate(p) for p, r in zip(where, radius, strict=True)]
    scene = Scene(
        shotline.Difference(block, *holes).named("pumice", material="blue"),
        ground(-1),
        materials=MATERIALS,
        lights=LIGHTS,
    )
    return scene.render(
        Camera(eye=(-3.2, -5.2, 2.9), target=(0.1, 0, -0.15), fov=30), size=SIZE, samples=48, lighting="soft"
    )


def bearings_cost():
    """The work of finding the first crossing, per pixel, in a field of bearings."""
    outer, inner, balls = bearing_parts()
    one = Group(outer, inner, balls).part("bearing")
    field = Group(one.translate(9 * i, 9 * j, 0) for i in range(-4, 5) for j in range(0, 9))
    scene = Scene(field.named("bearings"))
    return scene.render(
        Camera(eye=(0, -24, 16), target=(0, 14, 0), fov=40), size=SIZE, samples=4, look="cost", counter="heap"
    )


# --- the concepts


SOLID, RAY, WALL = "#9fb4c7", "#c2452d", "#41566b"


def section(ax, scene, x, z):
    """The interior of a scene in the plane y = 0."""
    xs, zs = np.linspace(*x, 600), np.linspace(*z, 400)
    points = np.stack(np.broadcast_arrays(xs[None, :], 0.0, zs[:, None]), axis=-1)
    inside = scene.contains(points).astype(float)
    ax.contourf(xs, zs, inside, levels=[0.5, 1.5], colors=[SOLID])
    ax.contour(xs, zs, inside, levels=[0.5], colors=[WALL], linewidths=1)
    ax.set_aspect("equal")
    ax.set_xlim(*x)
    ax.set_ylim(*z)
    ax.axis("off")


def ray(ax, scene, o, d, length, **span):
    """A ray and its crossings: triangles point right where it enters and left where it exits."""
    o, d = np.asarray(o, float), np.asarray(d, float)
    begin, end = o + span.get("t_min", 0) * d, o + min(length, span.get("t_max", length)) * d
    ax.annotate("", end[[0, 2]], begin[[0, 2]], arrowprops={"arrowstyle": "->", "color": RAY, "lw": 1.5})
    ax.plot(*begin[[0, 2]], "o", color=RAY, ms=5)
    hits = scene.crossings(o, d, **span)
    for t, entering, kind in zip(hits.t, hits.entering, hits.kind, strict=True):
        p = o + t * d
        if kind == 0:
            ax.plot(p[0], p[2], ">" if entering else "<", color=RAY, ms=9)
        side, ha = (0, "center") if kind else (-4, "right") if entering else (4, "left")
        ax.annotate(f"{t:g}", p[[0, 2]], (side, 8), textcoords="offset points", ha=ha, fontsize=10)
    return hits


def figure(columns, width=8.0, height=2.4):
    fig, axes = plt.subplots(1, columns, figsize=(width, height), layout="constrained", dpi=110)
    return fig, axes


def concept_crossings():
    fig, ax = figure(1, height=2.3)
    plate = Box(min=(-2, -2, 0), max=(2, 2, 1)) - Cylinder(radius=0.5, z0=0, z1=1)
    scene = Scene(plate.named("plate"))
    section(ax, scene, (-4.3, 4.3), (-0.4, 1.6))
    ray(ax, scene, (-4, 0, 0.5), (2, 0, 0), 3.9)
    ax.text(-4, 0.62, "o", fontsize=11, color=RAY, ha="center")
    return fig


def concept_ends():
    fig, axes = figure(3, height=1.9)
    scene = Scene(Box(min=(-1, -1, -0.5), max=(1, 1, 0.5)))
    for ax, o, span, words in [
        (axes[0], (-1.8, 0, 0), {}, "from outside: surface, surface"),
        (axes[1], (-0.4, 0, 0), {}, "from inside: start, surface"),
        (axes[2], (-0.4, 0, 0), {"t_max": 1.0}, "t_max = 1: start, end"),
    ]:
        section(ax, scene, (-2, 2), (-0.8, 0.8))
        ray(ax, scene, o, (1, 0, 0), 1.9 - o[0], **span)
        ax.set_title(words, fontsize=10)
    return fig


def concept_touching():
    fig, axes = figure(4, height=2.4)
    box = Box(min=(-1, -1, -0.6), max=(1, 1, 0.6))
    cases = [
        ("tangent", Scene(Sphere(radius=0.8)), (-1.4, 0, 0.8), (1, 0, 0), 2.8),
        (
            "stacked boxes",
            Scene(Box(min=(-1, -1, -0.6), max=(0, 1, 0.6)) | Box(min=(0, -1, -0.6), max=(1, 1, 0.6))),
            (-1.4, 0, 0),
            (1, 0, 0),
            2.8,
        ),
        ("a flush hole", Scene(box - Cylinder(radius=0.4, z0=-0.6, z1=0.6)), (0, 0, 1.1), (0, 0, -1), 2.2),
        ("A - A", Scene(box - box), (-1.4, 0, 0), (1, 0, 0), 2.8),
    ]
    for ax, (title, scene, o, d, length) in zip(axes, cases, strict=True):
        if title == "A - A":
            ax.plot([-1, 1, 1, -1, -1], [-0.6, -0.6, 0.6, 0.6, -0.6], ":", color=WALL, lw=1)
        section(ax, scene, (-1.6, 1.6), (-1.2, 1.2))
        hits = ray(ax, scene, o, d, length)
        ax.set_title(f"{title}: {len(hits.t)} crossings", fontsize=10)
    return fig


def concept_csg():
    fig, axes = figure(3, height=2.0)
    a, b = Sphere(radius=1).translate(-0.5, 0, 0), Sphere(radius=1).translate(0.5, 0, 0)
    for ax, title, node in [
        (axes[0], "A | B, union", a | b),
        (axes[1], "A & B, intersection", a & b),
        (axes[2], "A - B, difference", a - b),
    ]:
        for x in (-0.5, 0.5):
            ax.add_patch(plt.Circle((x, 0), 1, fill=False, ls=":", color=WALL))
        scene = Scene(node)
        section(ax, scene, (-2.2, 2.2), (-1.2, 1.2))
        ray(ax, scene, (-2, 0, 0), (1, 0, 0), 4)
        ax.set_title(title, fontsize=10)
    return fig


def concept_t():
    fig, axes = figure(2, height=1.8)
    scene = Scene(Box(min=(0, -1, -0.5), max=(2, 1, 0.5)))
    for ax, d in [(axes[0], 1.0), (axes[1], 2.0)]:
        section(ax, scene, (-2.3, 3.3), (-0.9, 0.9))
        ray(ax, scene, (-2, 0, 0), (d, 0, 0), 5.0 / d)
        ax.annotate(
            "", (-2 + d, -0.3), (-2, -0.3), arrowprops={"arrowstyle": "|-|", "color": WALL, "mutation_scale": 3}
        )
        ax.text(-2 + d / 2, -0.7, "d", ha="center", color=WALL, fontsize=11)
        ax.set_title(f"d = ({d:g}, 0, 0)", fontsize=10)
    return fig


RENDERED = [bearing, bearing_xray, bearing_thickness, sponge, chain, drilled, bearings_cost]
DRAWN = [concept_crossings, concept_ends, concept_touching, concept_csg, concept_t]


def main():
    wanted = sys.argv[1:]
    for make in [*RENDERED, *DRAWN]:
        name = make.__name__.replace("_", "-")
        if wanted and name not in wanted:
            continue
        path = OUT / f"{name}.png"
        if make in RENDERED:
            # 256 colours, so that the repository stays small.
            Pixels.fromarray(np.asarray(make())).quantize(256, dither=Pixels.Dither.NONE).save(path, optimize=True)
        else:
            fig = make()
            fig.savefig(path, bbox_inches="tight")
            plt.close(fig)
        print(f"{path.name}: {path.stat().st_size / 1024:.0f} KiB")


if __name__ == "__main__":
    main()
