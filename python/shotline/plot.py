"""Plots of rays and slices, with matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .queries import Queries
from .slices import Slice

# The most lines of the legend of a slice.
_MOST_LINES = 24


def plot_ray(scene: Queries, o: ArrayLike, d: ArrayLike, *, ax: Any, t_min: float, t_max: float) -> Any:
    """See `Scene.plot_ray`."""
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("plot_ray draws with matplotlib: pip install shotline[plot]") from error
    hits = scene.crossings(o, d, t_min=t_min, t_max=t_max)
    if len(hits.ray_splits) != 2:
        raise ValueError(f"plot_ray draws one ray, not {len(hits.ray_splits) - 1}")
    paths = sorted(set(hits.path.tolist()), key=lambda path: float(hits.t[hits.path == path][0]))
    if ax is None:
        _, ax = pyplot.subplots(figsize=(8, 1 + 0.5 * max(len(paths), 1)), layout="constrained")
    finite = hits.t[np.isfinite(hits.t)]
    end = float(finite.max() + 0.05 * np.ptp(finite) + 1e-9) if len(finite) else 1.0
    for row, path in enumerate(paths):
        in_path = hits.path == path
        t, entering, kind = np.minimum(hits.t[in_path], end), hits.entering[in_path], hits.kind[in_path]
        color = f"C{int(hits.object[in_path][0]) % 10}"
        if entering[::2].all() and not entering[1::2].any() and len(t) % 2 == 0:
            ax.barh([row] * (len(t) // 2), t[1::2] - t[::2], left=t[::2], height=0.5, color=color, alpha=0.45)
        for direction, marker in ((True, ">"), (False, "<")):
            surface = (entering == direction) & (kind == 0)
            ax.plot(t[surface], np.full(surface.sum(), row), marker, color=color, markersize=7)
    ax.set_yticks(range(len(paths)), [scene.path_name(path) for path in paths])
    ax.set_ylim(len(paths) - 0.5 if paths else 0.5, -0.5)
    ax.set_xlabel("t, in lengths of the direction")
    ax.set_xlim(min(t_min, float(finite.min())) if len(finite) else t_min, end)
    return ax


def plot_slice(scene: Queries, found: Slice, *, ax: Any) -> Any:
    """See `Scene.plot_slice`."""
    try:
        from matplotlib import pyplot
        from matplotlib.colors import ListedColormap
        from matplotlib.patches import Patch
    except ImportError as error:
        raise ImportError("plot_slice draws with matplotlib: pip install shotline[plot]") from error
    if ax is None:
        _, ax = pyplot.subplots(figsize=(9, 5.5), layout="constrained")
    ax.imshow(found.colors(), extent=found.extent, interpolation="nearest")
    entries = [
        Patch(facecolor=_color(region.color), edgecolor="0.3", label=region.name) for region in found.regions
    ]
    if found.overlaps:
        rows, columns = found.overlap.shape
        stripes = np.add.outer(np.arange(rows), np.arange(columns)) // max(max(rows, columns) // 150, 1) % 2
        hatch = ListedColormap(["#e01020", "#ffe0e0"])
        marked = np.ma.masked_where(found.overlap < 0, stripes)
        ax.imshow(marked, extent=found.extent, interpolation="nearest", cmap=hatch, vmin=0, vmax=1)
        pairs = [
            Patch(facecolor="#e01020", edgecolor="white", hatch="///", label=overlap.text)
            for overlap in found.overlaps
        ]
        entries = [*pairs, *entries]
    if len(entries) > _MOST_LINES:
        more = Patch(facecolor="none", label=f"and {len(entries) - _MOST_LINES + 1} more")
        entries = [*entries[: _MOST_LINES - 1], more]
    if entries:
        ax.legend(handles=entries, loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0, frameon=False)
    unit = f" ({scene.units})" if scene.units else ""
    ax.set_xlabel(f"{found.axes[0]}{unit}")
    ax.set_ylabel(f"{found.axes[1]}{unit}")
    ax.set_title(f"{found.title}{' ' + scene.units if scene.units else ''}, by {found.by}")
    return ax


def _color(color: tuple[int, int, int]) -> tuple[float, float, float]:
    red, green, blue = color
    return red / 255, green / 255, blue / 255
