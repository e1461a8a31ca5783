#!/usr/bin/env python3
"""Compare shotline's Python package with other packages, taking turns in one run, and count wrong results.

usage: peers.py [--data ../shared/data] [--only meshes,csg,aimed,overhead] [--repeats 5] [--threads 1,0]
                [--rays 250000] [--json FILE] [--bin target/release/shotline] [--quick]

meshes    bunny and dragon, camera rays and random rays: trimesh with Embree, and Open3D
csg       a cube minus N spheres, and a nested combination: Raysect
aimed     closed meshes and rays aimed exactly at their edges and vertices: the number of wrong results
overhead  a million rays from Python and in the Rust program, and the memory of ten million from Python

pip install -r bench/peers.txt installs the others; missing ones are skipped, with a message. Results are Markdown on
stdout and, with --json, all times. Ratios are rays per second of shotline divided by those of the other: the median of
the rounds (minimum to maximum). In each round the engines take turns. docs/peers.md says what is fair and what is not.
"""

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "bench"))
import aimed  # noqa: E402
import engines  # noqa: E402
from engines import Missing  # noqa: E402
from run import cast_once  # noqa: E402

OF_MESHES = (engines.Shotline, engines.Trimesh, engines.Open3D)
# Relative errors of t that do not count as wrong: float64 or float32, with a generous margin.
TOLERANCE = {"shotline": 1e-12}
COARSE = 1e-4


def say(text=""):
    print(text, flush=True)


def table(rows):
    head, *rows = rows
    say("| " + " | ".join(head) + " |\n|" + " --- |" * len(head))
    for row in rows:
        say("| " + " | ".join(map(str, row)) + " |")
    say()


def present(makers, left_out):
    """The engines that can be constructed; for each of the others the reason is printed once."""
    out = []
    for make in makers:
        try:
            out.append(make())
        except Missing as error:
            if str(error) not in left_out:
                left_out.add(str(error))
                print(f"left out, not installed: {error}", file=sys.stderr)
    return out


# --- rays


def camera_rays(low, high, count):
    """About `count` rays of a square pinhole image that frames a box, row by row; exact in float32."""
    middle, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    back = np.array([0.45, 0.35, 1.0]) / np.linalg.norm([0.45, 0.35, 1.0])
    right = np.cross([0, 1, 0], back) / np.linalg.norm(np.cross([0, 1, 0], back))
    side = round(count**0.5)
    s = ((np.arange(side) + 0.5) / side * 2 - 1) * np.tan(np.radians(20))
    d = s[None, :, None] * right - s[:, None, None] * np.cross(back, right) - back
    return rays_of(middle + back * radius * 2.6, d.reshape(-1, 3))


def random_rays(low, high, count):
    """Rays from a sphere around a box to points within it; exact in float32."""
    rng = np.random.default_rng(1)
    o = rng.normal(size=(count, 3))
    o *= np.linalg.norm(high - low) / 2 / np.linalg.norm(o, axis=1)[:, None]
    o += (low + high) / 2
    return rays_of(o, rng.uniform(low, high, (count, 3)) - o)


def rays_of(o, d):
    d = d / np.linalg.norm(d, axis=1)[:, None]
    return np.hstack([np.broadcast_to(o, d.shape), d]).astype(np.float32).astype(np.float64)


RAYS = {"camera": camera_rays, "random": random_rays}


def ply(path):
    """Vertices and faces of a binary triangle mesh, as in the Stanford scans."""
    with open(path, "rb") as file:
        counts, line = {}, b""
        while line != b"end_header\n":
            line = file.readline()
            if line.startswith(b"element"):
                counts[line.split()[1]] = int(line.split()[2])
        v = np.fromfile(file, "<f4", 3 * counts[b"vertex"]).reshape(-1, 3)
        f = np.fromfile(file, np.dtype([("n", "u1"), ("corners", "<i4", 3)]), counts[b"face"])
    return v.astype(np.float64), f["corners"].copy()


def meshes(data, names):
    for name in names:
        path = os.path.join(data, f"{name}.ply")
        if os.path.exists(path):
            yield name, *ply(path)
        else:
            print(f"left out, not there: {path}", file=sys.stderr)


# --- time


def race(contestants, repeats):
    """Seconds of each contestant (a callable) in each round; they take turns, after a warm-up round that does not count."""
    seconds = {name: [] for name in contestants}
    for _ in range(repeats + 1):
        for name, run in contestants.items():
            begin = time.perf_counter()
            answer = run()
            seconds[name].append(time.perf_counter() - begin)
            del answer
    return {name: times[1:] for name, times in seconds.items()}


def spread(ratios):
    low, middle, high = np.min(ratios), np.median(ratios), np.max(ratios)
    return f"{middle:.3g} ({low:.3g} to {high:.3g})"


def compared(ours, others, rays, threads, repeats, report, step=lambda engine: 1):
    """Rows of query and ratios to each other engine that supports that number of threads; it may get only one in `step`
    of the rays."""
    able = [e for e in others if e.THREADS or threads == 1]
    ready = {e.name: e.ready(rays[:: step(e)]) for e in [ours, *able]}
    for query in dict.fromkeys(query for e in able for query in e.QUERIES):
        asked = [(ours, query.split()[0]), *((e, query) for e in able if query in e.QUERIES)]
        run = {e.name: (lambda e=e, q=q: e.QUERIES[q](ready[e.name], threads)) for e, q in asked}
        seconds = race(run, repeats)
        rates = {
            name: len(rays[:: step(e)]) / np.array(seconds[name])
            for (e, _), name in zip(asked, seconds, strict=False)
        }
        report.append({"query": query, "threads": threads, "rays_per_s": {n: r.tolist() for n, r in rates.items()}})
        yield query, [spread(rates[ours.name] / rates[e.name]) if e.name in rates else "" for e in others]


def measured_meshes(options, report, left_out):
    rows, differ = [], []
    for name, v, f in meshes(options.data, ["bunny", "dragon"]):
        ours, *others = present([lambda c=c: c(v, f) for c in OF_MESHES], left_out)
        rows = rows or [["mesh", "rays", "query", "threads", *(e.name for e in others)]]
        for kind, make in RAYS.items():
            rays = make(v.min(0), v.max(0), options.rays)
            for threads in options.threads:
                part = []
                for query, ratios in compared(ours, others, rays, threads, options.repeats, part):
                    rows.append([name, kind, query, threads or "all", *ratios])
                report += [{"mesh": name, "rays": kind, **row} for row in part]
            counts = ours.count(rays)
            other = {e.name: int((e.count(rays) != counts).sum()) for e in others}
            report.append({"mesh": name, "rays": kind, "number": len(rays), "other_counts": other})
            differ.append([name, kind, len(rays), *other.values()])
    if rows:
        say("## Meshes: rays a second, to the other's\n")
        table(rows)
        say("Rays for which the number of hits is not shotline's:\n")
        table([["mesh", "rays", "number", *(e.name for e in others)], *differ])


# --- combinations


def block(count):
    """A cube of side 2 minus `count` spheres that remove about a third of it."""
    rng = random.Random(count)
    radius = (8 * 0.35 / (count * 4.18879)) ** (1 / 3)
    args = [{"prim": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}]
    for _ in range(count):
        args.append({"prim": "sphere", "center": [rng.uniform(-1, 1) for _ in range(3)], "radius": radius})
    return {"op": "difference", "args": args}


def nested():
    """A machine part: a drilled union and a drilled intersection, joined and cut again."""

    def cylinder(a, b, radius):
        return {"prim": "cylinder", "a": a, "b": b, "radius": radius}

    def box(low, high):
        return {"prim": "box", "min": low, "max": high}

    def op(name, *args):
        return {"op": name, "args": list(args)}

    body = op(
        "difference",
        op("union", box([-2, -1, 0], [2, 1, 1]), cylinder([0, 0, 0], [0, 0, 2], 0.9)),
        cylinder([0, 0, -1], [0, 0, 3], 0.5),
        cylinder([-1.4, 0, -1], [-1.4, 0, 2], 0.35),
        cylinder([1.4, 0, -1], [1.4, 0, 2], 0.35),
        cylinder([-3, 0, 0.5], [3, 0, 0.5], 0.2),
    )
    knob = op(
        "difference",
        op(
            "intersection",
            box([-0.5, -2.3, 0], [0.5, -1.3, 1]),
            {"prim": "sphere", "center": [0, -1.8, 0.5], "radius": 0.65},
        ),
        cylinder([0, -1.8, -1], [0, -1.8, 2], 0.3),
        cylinder([-1, -1.8, 0.5], [1, -1.8, 0.5], 0.3),
    )
    return op("difference", op("union", body, knob), {"prim": "sphere", "center": [0, 0, 2.2], "radius": 0.7})


def measured_csg(options, report, left_out):
    rows, differ = [], []
    scenes = {f"cube minus {n}": block(n) for n in ((10,) if options.quick else (10, 100, 1000))}
    scenes["nested"] = nested()
    for name, node in scenes.items():
        ours = engines.Shotline.of_solid(node)

        def raysect(balanced, loop, what):
            loop = loop and engines.raysect_loop()
            return engines.Raysect(solid=engines.raysect_solid(node, balanced), loop=loop, what=what)

        others = present(
            [
                lambda: raysect(False, False, ""),
                lambda: raysect(False, True, ", no Python"),
                lambda: raysect(True, True, ", no Python, balanced"),
            ],
            left_out,
        )
        if not others:
            return
        rows = rows or [["scene", "rays", "query", "threads", *(e.name for e in others)]]
        low, high = ours.scene.bounds
        # So that no engine takes minutes: the time of Raysect per ray grows with the number of spheres.
        step = {"cube minus 1000": 250, "cube minus 100": 50}.get(name, 10)
        for kind, make in RAYS.items():
            rays = make(low, high, options.rays)
            for threads in options.threads:
                part = []
                asked = compared(
                    ours, others, rays, threads, options.repeats, part, lambda e: 1 if e is ours else step
                )
                for query, ratios in asked:
                    rows.append([name, kind, query, threads or "all", *ratios])
                report += [{"scene": name, "rays": kind, **row} for row in part]
            few = rays[::step]
            counts = ours.count(few)
            other = {e.name: int((np.array([len(ts) for ts in e.every(few)]) != counts).sum()) for e in others}
            report.append({"scene": name, "rays": kind, "number": len(few), "other_counts": other})
            differ.append([name, kind, len(few), *other.values()])
    say("## Combinations: rays a second, to Raysect's\n")
    table(rows)
    say("Rays for which the number of crossings is not shotline's:\n")
    table([["scene", "rays", "number", *(e.name for e in others)], *differ])


# --- rays aimed at edges and vertices

FAULTS = ["odd", "missed", "doubled", "moved", "count", "first", "any"]


def faults(engine, rays, lists):
    """The number of rays with a wrong result, by kind of error, and the rays whose list of hits is wrong."""
    tolerance = TOLERANCE.get(engine.name, COARSE)
    out = dict.fromkeys(FAULTS, 0)
    wrong = np.zeros(len(rays), bool)
    for i, (exact, found) in enumerate(zip(lists, engine.every(rays), strict=False)):
        out["odd"] += len(found) % 2
        if len(found) != len(exact):
            out["missed" if len(found) < len(exact) else "doubled"] += 1
            wrong[i] = True
        elif len(exact) and (np.abs(found - exact) > tolerance * np.abs(exact)).any():
            out["moved"] += 1
            wrong[i] = True
    number = np.array([len(exact) for exact in lists])
    nearest = np.array([exact[0] if len(exact) else np.inf for exact in lists])
    first = engine.first(rays)
    out["first"] = int((~np.isclose(first, nearest, rtol=tolerance, atol=0)).sum())
    for query, exact in (("count", number), ("any", number > 0)):
        out[query] = int((getattr(engine, query)(rays) != exact).sum()) if hasattr(engine, query) else None
    return out, int(wrong.sum())


def measured_aimed(options, report, left_out):
    rng = np.random.default_rng(3)
    classes = (*OF_MESHES, engines.Raysect)
    total, rows, scored, touching, in_plane = {}, [], 0, 0, 0
    for mesh, make in aimed.MESHES.items():
        v, f = make()
        made = present([lambda c=c: c(v.astype(float), f) for c in classes], left_out)
        for kind in aimed.KINDS:
            rays = aimed.rays(v, f, kind, 100 if options.quick else 2000, rng)
            found = aimed.truth(v, f, rays)
            clear = [i for i, answer in enumerate(found) if answer and not answer[1]]
            touch = [i for i, answer in enumerate(found) if answer and answer[1]]
            scored, touching, in_plane = scored + len(clear), touching + len(touch), in_plane + found.count(None)

            def asked(rows):
                return rays[rows].astype(float), [np.array([float(t) for t in found[i][0]]) for i in rows]

            row = [mesh, kind, len(clear)]
            for engine in made:
                wrong, lists = faults(engine, *asked(clear))
                sums = total.setdefault(engine.name, dict.fromkeys(FAULTS, 0))
                for key, value in wrong.items():
                    sums[key] = None if value is None else sums[key] + value
                row.append(lists)
                told = {"mesh": mesh, "aimed": kind, "rays": len(clear), "engine": engine.name, "lists": lists}
                report.append(told | wrong)
            if touch:
                wrong, lists = faults(made[0], *asked(touch))
                told = {"mesh": mesh, "touching": kind, "rays": len(touch), "engine": made[0].name, "lists": lists}
                report.append(told | wrong)
                sums = total.setdefault("shotline, rays that touch too", dict.fromkeys(FAULTS, 0))
                for key, value in wrong.items():
                    sums[key] += value
            rows.append(row)
    say("## Rays aimed at edges and vertices: wrong answers\n")
    say(
        f"{scored} rays are scored. {touching} more touch the mesh somewhere without crossing it; only shotline, which says "
        f"what that means, is held to them. {in_plane} lie in the plane of a triangle and are left out.\n"
    )
    sums = [[name, *("" if n is None else n for n in sums.values())] for name, sums in total.items()]
    table([["engine", *FAULTS], *sums])
    say("Rays whose list of hits is wrong:\n")
    table([["mesh", "aimed at", "rays", *(e.name for e in made)], *rows])
    odd_counts(options, report, left_out)


def odd_counts(options, report, left_out):
    """A closed scan: every ray from outside has an even number of hits, whatever its mesh is."""
    for name, v, f in meshes(options.data, ["armadillo"]):
        made = present([lambda c=c: c(v, f) for c in OF_MESHES], left_out)
        free = random_rays(v.min(0), v.max(0), 4 * options.rays)
        at = (
            np.hstack([free[:, :3], v[np.arange(len(free)) % len(v)] - free[:, :3]])
            .astype(np.float32)
            .astype(float)
        )
        rows = []
        for kind, rays in (("random", free), ("at vertices", at)):
            odd = {e.name: int((e.count(rays) % 2).sum()) for e in made}
            report.append({"mesh": name, "rays": kind, "number": len(rays), "odd_rays": odd})
            rows.append([kind, len(rays), *odd.values()])
        say(f"Odd numbers of hits with the closed {name} ({len(f):,} triangles):\n")
        table([["rays", "number", *(e.name for e in made)], *rows])


# --- what Python costs


def measured_overhead(options, report, _left_out):
    import shotline

    path = os.path.join(options.data, "bunny.ply")
    if not os.path.exists(path) or not os.path.exists(options.bin):
        print(f"overhead: left out, {path} or {options.bin} is not there", file=sys.stderr)
        return
    number = 10_000 if options.quick else 1_000_000
    scene = shotline.load(path)
    low, high = scene.bounds
    rows = [["rays", "query", "Python's time to Rust's", "of the best"]]
    with tempfile.TemporaryDirectory() as folder:
        for kind, make in RAYS.items():
            rays = make(low, high, number)
            file = os.path.join(folder, "rays.npy")
            np.save(file, rays)
            for query in ("closest", "crossings"):
                ours, theirs = [], []
                for _ in range(options.repeats + 1):
                    begin = time.perf_counter()
                    answer = getattr(scene, query)(rays, threads=1)
                    ours.append(time.perf_counter() - begin)
                    del answer
                    theirs.append(in_rust(options.bin, path, file, query, folder))
                ours, theirs = np.array(ours[1:]), np.array(theirs[1:])
                report.append({"rays": kind, "query": query, "python_s": ours.tolist(), "rust_s": theirs.tolist()})
                rows.append([kind, query, spread(ours / theirs), f"{ours.min() / theirs.min():.3f}"])
    say(f"## What Python costs: {number:,} rays on the bunny, one thread\n")
    table(rows)
    number *= 10
    rows = [["rays", "threads", "answer, MB", "peak over the answer"]]
    for kind in RAYS:
        for threads in options.threads:
            command = [sys.executable, os.path.abspath(__file__), "--child", path, kind, str(number), str(threads)]
            got = json.loads(subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout)
            report.append(got)
            rows.append([kind, threads or "all", round(got["answer"] / 1e6), f"{got['peak'] / got['answer']:.2f}"])
    say(f"Memory of every crossing of {number:,} rays, asked from Python at once:\n")
    table(rows)


def in_rust(binary, scene, rays, query, folder):
    """Seconds of the cast itself in the program, without reading, building and writing."""
    return cast_once(binary, scene, rays, query, os.path.join(folder, "out.npz"))["cast_s"]


def child(path, kind, number, threads):
    """In a separate process: its peak memory above that of scene and rays, and the bytes of the result."""
    import shotline

    scene = shotline.load(path)
    low, high = scene.bounds
    number, piece = int(number), 100_000
    pattern = RAYS[kind](low, high, min(number, 10 * piece))
    rays = np.empty((len(pattern) * (number // min(number, 10 * piece)), 6))
    for begin in range(0, len(rays), piece):
        part = (begin + np.arange(min(piece, len(rays) - begin))) % len(pattern)
        rays[begin : begin + piece] = pattern[part]
    before = memory("VmRSS")
    answer = scene.crossings(rays, threads=int(threads))
    peak = memory("VmHWM") - before
    print(
        json.dumps(
            {
                "rays": kind,
                "number": len(rays),
                "threads": int(threads),
                "peak": peak,
                "answer": sum(column.nbytes for column in answer),
            }
        )
    )


def memory(field):
    """Memory of this process in bytes. Not from getrusage, which starts from the peak of the parent."""
    with open("/proc/self/status") as lines:
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(field))


SECTIONS = {"meshes": measured_meshes, "csg": measured_csg, "aimed": measured_aimed, "overhead": measured_overhead}


def main():
    if sys.argv[1:2] == ["--child"]:
        return child(*sys.argv[2:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", default=os.path.join(os.path.dirname(ROOT), "shared", "data"))
    parser.add_argument("--only", default=",".join(SECTIONS))
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--threads", default="1,0", help="numbers of threads; 0 for all")
    parser.add_argument("--rays", type=int, default=250_000)
    parser.add_argument("--json")
    parser.add_argument(
        "--bin", default=os.environ.get("SHOTLINE", os.path.join(ROOT, "target", "release", "shotline"))
    )
    parser.add_argument("--quick", action="store_true", help="few rays and one round, to see that it runs")
    options = parser.parse_args()
    options.threads = [int(number) for number in options.threads.split(",")]
    chosen = options.only.split(",")
    for name in chosen:
        if name not in SECTIONS:
            parser.error(f"there is no section {name!r}; they are {', '.join(SECTIONS)}")
    if options.quick:
        options.rays, options.repeats = min(options.rays, 2500), 1
    report, left_out = {}, set()
    for name in chosen:
        print(f"{name} ...", file=sys.stderr)
        SECTIONS[name](options, report.setdefault(name, []), left_out)
    if options.json:
        with open(options.json, "w") as out:
            json.dump(report, out)
    aimed_rows = report.get("aimed", [])
    wrong = sum(row["odd_rays"]["shotline"] for row in aimed_rows if "odd_rays" in row)
    wrong += sum(row[f] for row in aimed_rows if row.get("engine") == "shotline" for f in FAULTS)
    sys.exit(f"shotline: {wrong} wrong answers" if wrong else 0)


if __name__ == "__main__":
    main()
