"""Casts on the workers of a Dask cluster, bit for bit what one machine answers: `pip install shotline[dask]`.

>>> import shotline, shotline.dask
>>> from dask.distributed import Client
>>> scene = shotline.Scene(shotline.Sphere(radius=2).named("ball"))
>>> panel = {"center": (0, 0, -5), "u": (0.01, 0, 0), "v": (0, 0.01, 0), "shape": (500, 500)}
>>> beam = shotline.dask.Parallel(direction=(0, 0, 1), **panel)
>>> with Client(processes=False, dashboard_address=":0") as client:
...     hits = shotline.dask.cast(scene, beam, client)
>>> hits.t.shape, round(float(hits.t.min()), 4)
((500, 500), 3.0)
"""

# Dask is not typed throughout.
# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

import functools
import math
import operator
import threading
import uuid
import weakref
from collections import deque
from collections.abc import Callable, Generator
from contextlib import closing
from typing import Any, NamedTuple, NoReturn

import numpy as np

from . import __version__, _native
from .beams import Cone, Function, Parallel, Random
from .image import Image, settings
from .looks import Camera
from .progress import callback
from .rays import rays as checked
from .results import Closest, Crossings, Segments
from .scene import Scene
from .values import choice
from .values import number as real

try:
    import cloudpickle  # type: ignore[import-untyped,unused-ignore]
    import dask
    from distributed import Client, Future, as_completed, default_client
    from distributed.scheduler import KilledWorker
except ImportError as error:
    raise ImportError(
        "shotline.dask needs Dask's distributed: pip install 'shotline[dask]'", name=error.name
    ) from error

__all__ = ["Block", "BlockError", "Cone", "Function", "Parallel", "Random", "cast", "render"]

_TABLES = {"crossings": Crossings, "segments": Segments}
_QUERIES = ("closest", "any", "count", "crossings", "segments", "thickness")

# Fewer rays than this in a block are not worth what Dask does for one: see docs/dask.md.
_LEAST = 25_000

# Blocks that wait or run for each thread of the workers, so that none is idle and the rays sent stay few.
_AHEAD = 2


class Block(NamedTuple):
    """A stretch of rays on a worker: its number, the rays `start` to before `stop`, and their origins and directions as
    the beam made them; `d` is None where `o` holds both."""

    number: int
    start: int
    stop: int
    o: np.ndarray
    d: np.ndarray | None


class BlockError(RuntimeError):
    """A block of rays that has no answer. `number`, `start` and `stop` tell which; `__cause__` is what its worker
    raised."""

    def __init__(self, number: int, start: int, stop: int, why: str) -> None:
        super().__init__(number, start, stop, why)
        self.number, self.start, self.stop, self.why = number, start, stop, why

    def __str__(self) -> str:
        return f"block {self.number} (rays {self.start} to {self.stop}): {self.why}"


def cast(
    scene: Scene,
    rays: Any,
    client: Client | None = None,
    *,
    query: str = "closest",
    block: int = 250_000,
    t_min: float = 0.0,
    t_max: float = math.inf,
    surfaces_only: bool = False,
    overlaps: str | None = None,
    by: str | None = None,
    reduce: Callable[[Any, Block], Any] | None = None,
    combine: Callable[[Any, Any], Any] = operator.add,
    progress: Any = None,
) -> Any:
    """Ask a scene about many rays, on the workers of a Dask cluster.

    Args:
        scene: it is sent once for as long as it and the client live. A worker process builds it once, and keeps the two
            scenes that it was asked last.
        rays: a beam, which makes its rays on the workers (see `shotline.beams`): best, as nothing is sent. Or a pair
            of arrays (o, d), or one array (..., 6), as queries take them: each block is sent its own rows.
        client: a `dask.distributed.Client`; without it, the one that is in use. None is started.
        query: "closest", "any", "count", "crossings", "segments" or "thickness".
        block: rays of a block, the unit of work. Without `reduce`, blocks are made smaller, down to 25,000 rays, where
            threads of workers would get none; with it, they are this long on any cluster, but for the last one.
        t_min, t_max: as of queries; in lengths of the directions.
        surfaces_only: as of queries.
        overlaps: as of `segments` and `thickness`, and only for those.
        by: as of `thickness`, and only for that: "material", if not given, or "object".
        reduce: called on the worker as reduce(answer, block) with what the query answers for the rays of a `Block`. What
            it returns is sent back in place of the answer. It travels by cloudpickle.
        combine: joins what `reduce` returned for two stretches of rays, in the order of the rays: added, if not given.
        progress: True, a callable of (done, total) in rays, or a bar with `update` such as tqdm's.

    Each block runs on one thread, and a worker runs as many blocks as it has threads. Workers may come and go: blocks
    of lost ones are run again. An interrupt (Ctrl-C) and errors cancel what has not begun.

    Returns:
        What the query of the scene itself returns, the same bits, of the shape of the rays or of the beam. With
        `reduce`, what was combined: the same bits on any cluster for the same `block`.

    Raises:
        BlockError: for a block that raised on its worker (a bad ray is named by its row in all rays, which is `row` of
            the `__cause__`), and for one that
            ended its worker process time and again (Dask's setting allowed-failures).
        RuntimeError: without a client, and if the workers cannot unpickle the scene, the beam or `reduce`.
        TypeError, ValueError: for arguments that do not fit, before anything is sent.
    """
    client = _client(client)
    if not isinstance(scene, Scene):
        raise TypeError(f"scene must be a Scene, not {type(scene).__name__}")
    if query not in _QUERIES:
        raise ValueError(f"query is {query!r}, but must be one of {', '.join(_QUERIES)}")
    options: dict[str, Any] = {"t_min": real(t_min, "t_min"), "t_max": real(t_max, "t_max")}
    if surfaces_only:
        if query in ("segments", "thickness"):
            raise ValueError(f"surfaces_only is for closest, any, count and crossings, not for {query}")
        options["surfaces_only"] = True
    if overlaps is not None:
        if query not in ("segments", "thickness"):
            raise ValueError(f"overlaps is for segments and thickness, not for {query}")
        options["overlaps"] = overlaps
    if by is not None:
        if query != "thickness":
            raise ValueError(f"by is for thickness, not for {query}")
        options["by"] = choice(by, "by", ("material", "object"))
    if (block := operator.index(block)) < 1:
        raise ValueError(f"block is {block}, but must be at least 1")
    beam, sent = (rays, None) if hasattr(rays, "rays") else (None, _Sent(rays))
    count = len(rays) if sent is None else len(sent)
    shape = tuple(getattr(rays, "shape", (count,))) if sent is None else sent.shape
    if reduce is None:
        share = -(-count // max(1, sum(client.nthreads().values())))
        block = min(block, max(share, _LEAST))
    # Without rays there is one empty block, which tells the types.
    spans = [(start, min(start + block, count)) for start in range(0, max(count, 1), block)]
    answers: Any = _Ragged(_TABLES[query]) if query in _TABLES else _Rows(count, shape, query)
    if reduce is not None:
        answers = _Folded(combine)
    tell = callback(progress)
    done = 0
    run = _Run(client, scene, _Job(__version__, beam, query, options, reduce), sent, spans)
    with closing(run.parts()) as parts:
        for number, part in parts:
            answers.put(number, spans[number][0], part)
            done += spans[number][1] - spans[number][0]
            if tell:
                tell(done, count)
    return answers.whole()


def render(
    scene: Scene,
    camera: Camera | None = None,
    client: Client | None = None,
    *,
    size: tuple[int, int] = (800, 600),
    samples: int = 4,
    look: str = "lit",
    lighting: str = "sharp",
    background: str | None = None,
    counter: str = "boxes",
    block: int = 32,
    progress: Any = None,
) -> Image:
    """A picture, its rows exposed on the workers of a Dask cluster: bit for bit what `scene.render` makes.

    `block` is the number of rows of a block; `client`, blocks, errors and `progress`, in rows, are as of `cast`, the rest as of
    `Scene.render`. A `BlockError` tells rows where that of `cast` tells rays.
    """
    client = _client(client)
    style, sight = settings(camera, size, samples, look, lighting, background, counter)
    # Bad settings are an error before anything is sent.
    _native.expose(scene._native, (*style[:2], 1, *style[3:]), sight, (0, 1), 1)
    width, height = size
    if (block := operator.index(block)) < 1:
        raise ValueError(f"block is {block}, but must be at least 1")
    spans = [(top, min(top + block, height)) for top in range(0, height, block)]
    exposed = np.empty((height, width, 4))
    tell = callback(progress)
    done = 0
    job = _Job(__version__, None, "render", {"style": style, "sight": sight}, None)
    with closing(_Run(client, scene, job, None, spans, _expose).parts()) as parts:
        for number, part in parts:
            exposed[slice(*spans[number])] = part
            done += len(part)
            if tell:
                tell(done, height)
    return Image(_native.develop(scene._native, style, sight, exposed))


def _client(client: Client | None) -> Client:
    if client is None:
        try:
            client = default_client()
        except ValueError:
            message = "there is no Dask client: make one with dask.distributed.Client(), or pass client="
            raise RuntimeError(message) from None
    if not isinstance(client, Client):
        raise TypeError(f"client must be a dask.distributed.Client, not {type(client).__name__}")
    if client.asynchronous:
        raise TypeError("the client is asynchronous; cast waits for its answer, so it takes a synchronous one")
    return client


# --- on the workers


class _Job(NamedTuple):
    """What all blocks have in common."""

    version: str
    beam: Any
    query: str
    options: dict[str, Any]
    reduce: Callable[[Any, Block], Any] | None


class _Unpicklable(RuntimeError):
    """What the workers cannot unpickle."""


_unpickling = threading.Lock()


# For two scenes and two jobs: Dask drops copies that no task is waiting for, and scenes would be built again.
@functools.lru_cache(maxsize=4)
def _unpickled(pickled: bytes, what: str) -> Any:
    try:
        return cloudpickle.loads(pickled)
    except Exception as error:
        raise _Unpicklable(f"the workers could not unpickle {what}: {_words(error)}") from error


def _unpack(scene_bytes: bytes, job_bytes: bytes) -> tuple[Scene, _Job]:
    """The scene and the job, built by one of the threads.

    They travel as bytes, so that what cannot be unpickled is an error of the block: where Dask unpickles what one
    worker sends to another, it tries again for ever.
    """
    with _unpickling:
        wanted = _unpickled(job_bytes, "the beam or reduce")
        if wanted.version != __version__:
            raise RuntimeError(f"the worker has shotline {__version__}, but the client {wanted.version}")
        return _unpickled(scene_bytes, "the scene"), wanted


def _answer(
    scene_bytes: bytes, job_bytes: bytes, number: int, start: int, stop: int, sent: tuple[Any, Any] | None
) -> Any:
    """What is sent back for a block: what `reduce` returns, or the columns of the answer, a row a ray."""
    scene, job = _unpack(scene_bytes, job_bytes)
    o, d = job.beam.rays(start, stop) if sent is None else sent
    shape = checked(o, d).shape
    if math.prod(shape) != stop - start:
        raise ValueError(f"the beam made {math.prod(shape)} rays, not {stop - start}")
    try:
        answer = getattr(scene, job.query)(o, d, threads=1, **job.options)
    except ValueError as error:
        raise _of_all_rays(error, start) from None
    if job.reduce is not None:
        return job.reduce(answer, Block(number, start, stop, o, d))
    if job.query in _TABLES:
        return list(answer)
    columns = answer if job.query == "closest" else [answer]
    return [column.reshape(stop - start, *column.shape[len(shape) :]) for column in columns]


def _of_all_rays(error: ValueError, start: int) -> ValueError:
    """The error of a row of a block that begins at a ray as the error of that row of all rays."""
    row = getattr(error, "row", None)
    if row is None:
        return error
    told = ValueError(str(error).replace(f"ray {row}", f"ray {start + row}", 1))
    setattr(told, "row", start + row)  # noqa: B010
    return told


def _expose(scene_bytes: bytes, job_bytes: bytes, number: int, start: int, stop: int, sent: None) -> np.ndarray:
    """Rows of a picture."""
    scene, job = _unpack(scene_bytes, job_bytes)
    return _native.expose(scene._native, job.options["style"], job.options["sight"], (start, stop), 1)


# --- on the client


class _Sent:
    """Rays that the client has."""

    def __init__(self, rays: Any) -> None:
        o, d = rays if isinstance(rays, tuple) and len(rays) == 2 else (rays, None)
        self.shape, self._count, self._o, self._d = checked(o, d)

    def __len__(self) -> int:
        return self._count

    def part(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray | None]:
        """One vector for all rays stays one."""

        def cut(vectors: np.ndarray) -> np.ndarray:
            return vectors[start:stop] if vectors.ndim == 2 else vectors

        return cut(self._o), None if self._d is None else cut(self._d)


# The scenes that clients have sent, by client and accelerator.
_shipped: weakref.WeakKeyDictionary[Scene, dict[tuple[str, str | None], Future[Any]]] = weakref.WeakKeyDictionary()


def _ship(client: Client, scene: Scene) -> Future[Any]:
    """The scene on the cluster, pickled. It is a task, not data of a worker, so that losing that worker does not lose it."""
    futures = _shipped.setdefault(scene, {})
    name = client.id, scene._accel
    if name not in futures or futures[name].status in ("cancelled", "error", "lost"):
        for stale in [key for key, future in futures.items() if future.client.status == "closed"]:
            del futures[stale]
        key = f"shotline-scene-{scene.content_hash}-{scene._accel}-{uuid.uuid4().hex}"
        futures[name] = _submit(client, key, bytes, cloudpickle.dumps(scene))
    return futures[name]


def _submit(client: Client, key: str, function: Callable[..., Any], *args: Any) -> Future[Any]:
    # Blocks in flight are few, so it is meant that rays are sent with their task: it can be run anywhere again.
    with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TB"}):
        return client.submit(function, *args, key=key, pure=False)


class _Run:
    """Blocks on their way through the cluster."""

    def __init__(
        self,
        client: Client,
        scene: Scene,
        job: _Job,
        sent: _Sent | None,
        spans: list[tuple[int, int]],
        task: Callable[..., Any] = _answer,
    ) -> None:
        self.client, self.sent, self.spans, self.task = client, sent, spans, task
        self.id = uuid.uuid4().hex
        self.scene = _ship(client, scene)
        self.job = _submit(client, f"shotline-job-{self.id}", bytes, cloudpickle.dumps(job))
        self.running: dict[Future[Any], int] = {}
        self.arriving = as_completed(loop=client.loop)

    def parts(self) -> Generator[tuple[int, Any], None, None]:
        """The answers of blocks with their numbers, as they come.

        Dask counts for each block how many workers died that had it, so a block that kills its worker takes down those
        beside it. Blocks it gives up are suspects, and run alone, where only the guilty one fails again.
        """
        todo, suspects, alone = deque(range(len(self.spans))), deque[int](), None
        try:
            while todo or suspects or self.running:
                if not suspects and alone is None:
                    ahead = max(2, _AHEAD * sum(self.client.nthreads().values()))
                    while todo and len(self.running) < ahead:
                        self._start(todo.popleft())
                elif not self.running:
                    alone = suspects.popleft()
                    self._start(alone, "-alone")
                number, part, error = self._arrived()
                if error is None:
                    yield number, part
                elif number != alone and isinstance(error, KilledWorker):
                    suspects.append(number)
                else:
                    self._raise(number, error)
                if number == alone:
                    alone = None
        except BaseException:
            self.client.cancel([*self.running, self.job])
            raise

    def _arrived(self) -> tuple[int, Any, Exception | None]:
        """The next block that is done: its number, and its answer or why there is none."""
        future = next(self.arriving)
        try:
            number, part, failure = self.running[future], future.result(), None
        except Exception as error:
            number, part, failure = self.running[future], None, error
            # The traceback holds on to it.
            self.client.cancel([future])
        del self.running[future]
        return number, part, failure

    def _start(self, number: int, note: str = "") -> None:
        start, stop = self.spans[number]
        sent = self.sent.part(start, stop) if self.sent is not None else None
        key = f"shotline-block-{self.id}-{number}{note}"
        future = _submit(self.client, key, self.task, self.scene, self.job, number, start, stop, sent)
        self.running[future] = number
        self.arriving.add(future)

    def _raise(self, number: int, error: BaseException) -> NoReturn:
        if isinstance(error, _Unpicklable):
            raise RuntimeError(str(error)) from error
        raise BlockError(number, *self.spans[number], _words(error)) from error


def _words(error: BaseException) -> str:
    if isinstance(error, KilledWorker):
        return f"{error.allowed_failures + 1} workers died while they had it; their logs may say why"
    return str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"


class _Rows:
    """Answers of a row a ray, put in their places."""

    def __init__(self, count: int, shape: tuple[int, ...], query: str) -> None:
        if math.prod(shape) != count:
            raise ValueError(f"the shape of the beam, {shape}, does not hold its {count} rays")
        self.count, self.shape, self.query = count, shape, query
        self.columns: list[np.ndarray] = []

    def put(self, number: int, start: int, part: list[np.ndarray]) -> None:
        if not self.columns:
            self.columns = [np.empty((self.count, *new.shape[1:]), new.dtype) for new in part]
        for column, new in zip(self.columns, part, strict=True):
            column[start : start + len(new)] = new

    def whole(self) -> Any:
        columns = [column.reshape(self.shape + column.shape[1:]) for column in self.columns]
        return Closest(*columns) if self.query == "closest" else columns[0]


class _Ragged:
    """Answers of any number of rows a ray, joined when all are there."""

    def __init__(self, table: type) -> None:
        self.table = table
        self.parts: dict[int, list[np.ndarray]] = {}

    def put(self, number: int, start: int, part: list[np.ndarray]) -> None:
        self.parts[number] = part

    def whole(self) -> Any:
        splits, *columns = zip(*(self.parts.pop(number) for number in sorted(self.parts)), strict=True)
        rows = np.cumsum([0, *(part[-1] for part in splits)])
        shifted = [part[1:] + before for part, before in zip(splits, rows, strict=False)]
        return self.table(np.concatenate([splits[0][:1], *shifted]), *map(np.concatenate, columns))


class _Folded:
    """What `reduce` returned, combined in the order of the blocks as soon as it can be."""

    def __init__(self, combine: Callable[[Any, Any], Any]) -> None:
        self.combine, self.total = combine, None
        self.next = 0
        self.waiting: dict[int, Any] = {}

    def put(self, number: int, start: int, part: Any) -> None:
        self.waiting[number] = part
        while self.next in self.waiting:
            new = self.waiting.pop(self.next)
            self.total = self.combine(self.total, new) if self.next else new
            self.next += 1

    def whole(self) -> Any:
        return self.total
