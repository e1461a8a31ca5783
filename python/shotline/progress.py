"""Progress callbacks of long calls."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

ProgressCallback = Callable[[int, int], Any]


def callback(progress: Any) -> ProgressCallback | None:
    """The function that the core calls with (done, total), from `True`, a callable, or a bar with `update` (tqdm)."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return _bar()
    if hasattr(progress, "update"):
        return _increments(progress)
    if not callable(progress):
        raise TypeError("progress is True, a callable of (done, total), or a bar such as tqdm's")
    report: ProgressCallback = progress
    return report


def _increments(bar: Any) -> ProgressCallback:
    """Converts totals to the increments that a bar takes; its total may be unknown when it is created."""
    reported = 0

    def report(done: int, total: int) -> None:
        nonlocal reported
        if getattr(bar, "total", total) is None:
            bar.total = total
        bar.update(done - reported)
        reported = done

    return report


def _bar() -> ProgressCallback:
    """A bar of tqdm if it is installed, else a plain line on stderr."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _line
    bar = tqdm(total=None, unit="ray", unit_scale=True)
    report = _increments(bar)

    def report_and_close(done: int, total: int) -> None:
        report(done, total)
        if done >= total:
            bar.close()

    return report_and_close


def _line(done: int, total: int) -> None:
    end = "\n" if done >= total else ""
    print(f"\rshotline: {done} of {total} rays", end=end, file=sys.stderr, flush=True)
