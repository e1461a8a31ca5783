"""Progress of long calls, told in the ways that people use."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

Told = Callable[[int, int], Any]


def callback(progress: Any) -> Told | None:
    """What the core calls with (done, total), from `True`, a callable, or a bar with `update` (tqdm)."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return _bar()
    if hasattr(progress, "update"):
        return _steps(progress)
    if not callable(progress):
        raise TypeError("progress is True, a callable of (done, total), or a bar such as tqdm's")
    tell: Told = progress
    return tell


def _steps(bar: Any) -> Told:
    """A bar takes steps, and its total may be unknown when it is made."""
    told = 0

    def tell(done: int, total: int) -> None:
        nonlocal told
        if getattr(bar, "total", total) is None:
            bar.total = total
        bar.update(done - told)
        told = done

    return tell


def _bar() -> Told:
    """tqdm's bar if it is installed, else a plain line on stderr."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _line
    bar = tqdm(total=None, unit="ray", unit_scale=True)
    tell = _steps(bar)

    def tell_and_close(done: int, total: int) -> None:
        tell(done, total)
        if done >= total:
            bar.close()

    return tell_and_close


def _line(done: int, total: int) -> None:
    end = "\n" if done >= total else ""
    print(f"\rshotline: {done} of {total} rays", end=end, file=sys.stderr, flush=True)
