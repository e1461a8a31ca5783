"""Casts on the workers of a Dask cluster, with the same bits as on one machine: `pip install shotline[dask]`.

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

# Dask is not fully typed.
# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

import functools
import inspect
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
from .appearance import Camera
from .beams import Cone, Function, Parallel, Random
from .image import Image, PictureOptions, picture_args
from .joining import RaggedResults, Reduction, RowResults
from .origin import BeamOrigin, Origin, RayOrigin
from .progress import callback
from .rays import rays as checked_rays
from .results import Crossings, Segments
from .scene import Scene
from .values import choice, suggestion
from .values import number as real_number

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

# The fewest rays of a block for which the overhead of Dask is small: see docs/dask.md.
_MIN_BLOCK = 25_000

# Blocks in flight for each thread of the workers: enough to keep all busy, and few enough to hold little memory.
_IN_FLIGHT = 2


class Block(NamedTuple):
    """A range of rays on a worker: its number, the rays `start` to `stop - 1`, and their origins and directions as the
    beam generated them; `d` is None if `o` holds both."""

    number: int
    start: int
    stop: int
    o: np.ndarray
    d: np.ndarray | None


class BlockError(RuntimeError):
    """A block of rays that failed. `number`, `start` and `stop` identify it; `__cause__` is what its worker raised."""

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
    """Cast many rays at a scene, on the workers of a Dask cluster.

    Args:
        scene: it is sent once in the lifetime of the scene and the client. A worker process builds it once, and keeps
            the two scenes used last.
        rays: a beam, which generates its rays on the workers (see `shotline.beams`); preferred, because no rays are
            sent. Or a pair of arrays (o, d), or one array (..., 6), as queries take them; each block is sent its own
            rows.
        client: a `dask.distributed.Client`; None for the default client. No client is started.
        query: "closest", "any", "count", "crossings", "segments" or "thickness".
        block: rays per block, the unit of work. Without `reduce`, blocks are made smaller, down to 25,000 rays, if some
            threads of workers would get none; with it, all blocks but the last have this length on any cluster.
        t_min, t_max: as in queries; in lengths of the directions.
        surfaces_only: as in queries.
        overlaps: as in `segments` and `thickness`, and only for those.
        by: as in `thickness`, and only for that: "material", if not given, or "object".
        reduce: called on the worker as reduce(result, block) with the result of the query for the rays of a `Block`.
            What it returns is sent back in place of the result. It is sent by cloudpickle.
        combine: combines two return values of `reduce`, in the order of the rays; addition if not given.
        progress: True, a callable of (done, total) in rays, or a bar with `update` such as tqdm's.

    Each block runs on one thread, and a worker runs as many blocks as it has threads. Workers may join and leave:
    blocks of lost workers are run again. An interrupt (Ctrl-C) and errors cancel blocks that have not started.

    Returns:
        The result of the query on one machine, with the same bits, in the shape of the rays or of the beam. With
        `reduce`, the combined value: the same bits on any cluster for the same `block`.

    Raises:
        BlockError: for a block that raised on its worker (an invalid ray is named by its row among all rays, which is
            `row` of the `__cause__`), and for a block that ended its worker process repeatedly (Dask's setting
            allowed-failures).
        RuntimeError: without a client, and if the workers cannot unpickle the scene, the beam or `reduce`.
        TypeError, ValueError: for invalid arguments, before anything is sent.
    """
    client = _client(client)
    if not isinstance(scene, Scene):
        raise TypeError(f"scene must be a Scene, not {type(scene).__name__}")
    if query not in _QUERIES:
        raise ValueError(f"query is {query!r}, but must be one of {', '.join(_QUERIES)}")
    options: dict[str, Any] = {"t_min": real_number(t_min, "t_min"), "t_max": real_number(t_max, "t_max")}
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
    beam, sent = (rays, None) if hasattr(rays, "rays") else (None, _ClientRays(rays))
    count = len(rays) if sent is None else len(sent)
    shape = tuple(getattr(rays, "shape", (count,))) if sent is None else sent.shape
    if reduce is None:
        share = -(-count // max(1, sum(client.nthreads().values())))
        block = min(block, max(share, _MIN_BLOCK))
    # Without rays there is one empty block, whose result has the types of the columns.
    spans = [(start, min(start + block, count)) for start in range(0, max(count, 1), block)]
    origin = Origin(scene, BeamOrigin(beam) if sent is None else RayOrigin(sent.rays), shape)
    results: Any = (
        RaggedResults(_TABLES[query], origin) if query in _TABLES else RowResults(count, shape, query, origin)
    )
    if reduce is not None:
        results = Reduction(combine)
    report = callback(progress)
    done = 0
    run = _Run(client, scene, _Job(__version__, beam, query, options, reduce), sent, spans)
    with closing(run.blocks()) as blocks:
        for number, value in blocks:
            results.put(number, spans[number][0], value)
            done += spans[number][1] - spans[number][0]
            if report:
                report(done, count)
    return results.finish()


def render(
    scene: Scene,
    camera: Camera | str | None = None,
    client: Client | None = None,
    *,
    block: int = 32,
    progress: Any = None,
    **options: Any,
) -> Image:
    """A picture, rendered in rows on the workers of a Dask cluster, with the same bits as `scene.render`.

    `block` is the number of rows of a block; `client`, blocks, errors and `progress`, in rows, are as in `cast`, the
    other arguments as in `Scene.render`. The range of a `BlockError` counts rows, not rays.
    """
    client = _client(client)
    for name in options:
        if name not in PictureOptions._fields:
            raise TypeError(
                f"render has no argument {name!r}; {suggestion(name, PictureOptions._fields, 'it takes')}"
            )
    settings, view = picture_args(camera, PictureOptions(**options))
    # Invalid settings raise before anything is sent.
    _native.expose(scene._native, settings._replace(samples=1), view, (0, 1), 1)
    width, height = settings.width, settings.height
    if (block := operator.index(block)) < 1:
        raise ValueError(f"block is {block}, but must be at least 1")
    spans = [(top, min(top + block, height)) for top in range(0, height, block)]
    exposed = np.empty((height, width, 5))
    report = callback(progress)
    done = 0
    job = _Job(__version__, None, "render", {"settings": settings, "view": view}, None)
    with closing(_Run(client, scene, job, None, spans, _expose).blocks()) as blocks:
        for number, rows in blocks:
            exposed[slice(*spans[number])] = rows
            done += len(rows)
            if report:
                report(done, height)
    return Image(_native.develop(scene._native, settings, view, exposed))


def _signature() -> inspect.Signature:
    """The signature of `render` with the options by name, for help and completion."""
    own, named = inspect.signature(render), inspect.signature(Scene.render).parameters
    *first, block, progress, _ = own.parameters.values()
    return own.replace(parameters=[*first, *(named[name] for name in PictureOptions._fields), block, progress])


render.__signature__ = _signature()  # type: ignore[attr-defined]


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
        raise TypeError("the client is asynchronous; cast waits for its result, so it needs a synchronous one")
    return client


# --- on the workers


class _Job(NamedTuple):
    """The data that all blocks share."""

    version: str
    beam: Any
    query: str
    options: dict[str, Any]
    reduce: Callable[[Any, Block], Any] | None


class _Unpicklable(RuntimeError):
    """The workers cannot unpickle something."""


_unpickling = threading.Lock()


# For two scenes and two jobs. Dask drops copies that no task waits for; without the cache scenes would be built again.
@functools.lru_cache(maxsize=4)
def _unpickled(pickled: bytes, what: str) -> Any:
    try:
        return cloudpickle.loads(pickled)
    except Exception as error:
        raise _Unpicklable(f"the workers could not unpickle {what}: {_message(error)}") from error


def _unpack(scene_bytes: bytes, job_bytes: bytes) -> tuple[Scene, _Job]:
    """The scene and the job, built by one thread at a time.

    They are sent as bytes, so that a failure to unpickle is an error of the block. If Dask itself unpickled them on a
    transfer between workers, it would retry forever.
    """
    with _unpickling:
        job = _unpickled(job_bytes, "the beam or reduce")
        if job.version != __version__:
            raise RuntimeError(f"the worker has shotline {__version__}, but the client {job.version}")
        return _unpickled(scene_bytes, "the scene"), job


def _cast_block(
    scene_bytes: bytes, job_bytes: bytes, number: int, start: int, stop: int, sent: tuple[Any, Any] | None
) -> Any:
    """The value to send back for a block: that of `reduce`, or the columns of the result, a row for each ray."""
    scene, job = _unpack(scene_bytes, job_bytes)
    o, d = job.beam.rays(start, stop) if sent is None else sent
    shape = checked_rays(o, d).shape
    if math.prod(shape) != stop - start:
        raise ValueError(f"the beam made {math.prod(shape)} rays, not {stop - start}")
    try:
        result = getattr(scene, job.query)(o, d, threads=1, **job.options)
    except ValueError as error:
        raise _renumbered(error, start) from None
    if job.reduce is not None:
        return job.reduce(result, Block(number, start, stop, o, d))
    if job.query in _TABLES:
        return list(result)
    columns = result if job.query == "closest" else [result]
    return [column.reshape(stop - start, *column.shape[len(shape) :]) for column in columns]


def _renumbered(error: ValueError, start: int) -> ValueError:
    """The error of a row of a block that starts at ray `start`, renumbered to the row among all rays."""
    row = getattr(error, "row", None)
    if row is None:
        return error
    renumbered = ValueError(str(error).replace(f"ray {row}", f"ray {start + row}", 1))
    setattr(renumbered, "row", start + row)  # noqa: B010
    return renumbered


def _expose(scene_bytes: bytes, job_bytes: bytes, number: int, start: int, stop: int, sent: None) -> np.ndarray:
    """Rows of a picture."""
    scene, job = _unpack(scene_bytes, job_bytes)
    return _native.expose(scene._native, job.options["settings"], job.options["view"], (start, stop), 1)


# --- on the client


class _ClientRays:
    """Rays in arrays of the client."""

    def __init__(self, rays: Any) -> None:
        o, d = rays if isinstance(rays, tuple) and len(rays) == 2 else (rays, None)
        self.rays = checked_rays(o, d)
        self.shape = self.rays.shape

    def __len__(self) -> int:
        return self.rays.ray_count

    def rows(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray | None]:
        """The rows of a block. A single vector for all rays stays single."""

        def cut(vectors: np.ndarray) -> np.ndarray:
            return vectors[start:stop] if vectors.ndim == 2 else vectors

        directions = self.rays.directions
        return cut(self.rays.origins), None if directions is None else cut(directions)


# The scenes that were sent, by client and accelerator.
_sent_scenes: weakref.WeakKeyDictionary[Scene, dict[tuple[str, str | None], Future[Any]]] = (
    weakref.WeakKeyDictionary()
)


def _send_scene(client: Client, scene: Scene) -> Future[Any]:
    """The pickled scene on the cluster. It is a task, not data of a worker, so that it survives the loss of a
    worker."""
    futures = _sent_scenes.setdefault(scene, {})
    name = client.id, scene._accel
    if name not in futures or futures[name].status in ("cancelled", "error", "lost"):
        for stale in [key for key, future in futures.items() if future.client.status == "closed"]:
            del futures[stale]
        key = f"shotline-scene-{scene.content_hash}-{scene._accel}-{uuid.uuid4().hex}"
        futures[name] = _submit(client, key, bytes, cloudpickle.dumps(scene))
    return futures[name]


def _submit(client: Client, key: str, function: Callable[..., Any], *args: Any) -> Future[Any]:
    # Rays are sent with their task on purpose, so that it can be run again anywhere; few blocks are in flight at a
    # time.
    with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TB"}):
        return client.submit(function, *args, key=key, pure=False)


class _Run:
    """The blocks of one call on the cluster."""

    def __init__(
        self,
        client: Client,
        scene: Scene,
        job: _Job,
        sent: _ClientRays | None,
        spans: list[tuple[int, int]],
        task: Callable[..., Any] = _cast_block,
    ) -> None:
        self.client, self.sent, self.spans, self.task = client, sent, spans, task
        self.id = uuid.uuid4().hex
        self.scene = _send_scene(client, scene)
        self.job = _submit(client, f"shotline-job-{self.id}", bytes, cloudpickle.dumps(job))
        self.running: dict[Future[Any], int] = {}
        self.arriving = as_completed(loop=client.loop)

    def blocks(self) -> Generator[tuple[int, Any], None, None]:
        """The values of blocks with their numbers, in order of completion.

        Dask counts for each block how many of its workers died, so a block that kills its worker also fails the blocks
        that ran beside it. Blocks that Dask gives up are run again one at a time; then only the faulty one fails again.
        """
        todo, suspects, alone = deque(range(len(self.spans))), deque[int](), None
        try:
            while todo or suspects or self.running:
                if not suspects and alone is None:
                    in_flight = max(2, _IN_FLIGHT * sum(self.client.nthreads().values()))
                    while todo and len(self.running) < in_flight:
                        self._start(todo.popleft())
                elif not self.running:
                    alone = suspects.popleft()
                    self._start(alone, "-alone")
                number, value, error = self._next_result()
                if error is None:
                    yield number, value
                elif number != alone and isinstance(error, KilledWorker):
                    suspects.append(number)
                else:
                    self._raise(number, error)
                if number == alone:
                    alone = None
        except BaseException:
            self.client.cancel([*self.running, self.job])
            raise

    def _next_result(self) -> tuple[int, Any, Exception | None]:
        """The next block that is done: its number, and its value or its error."""
        future = next(self.arriving)
        try:
            number, value, failure = self.running[future], future.result(), None
        except Exception as error:
            number, value, failure = self.running[future], None, error
            # The traceback keeps a reference to the future, so it must be cancelled.
            self.client.cancel([future])
        del self.running[future]
        return number, value, failure

    def _start(self, number: int, note: str = "") -> None:
        start, stop = self.spans[number]
        sent = self.sent.rows(start, stop) if self.sent is not None else None
        key = f"shotline-block-{self.id}-{number}{note}"
        future = _submit(self.client, key, self.task, self.scene, self.job, number, start, stop, sent)
        self.running[future] = number
        self.arriving.add(future)

    def _raise(self, number: int, error: BaseException) -> NoReturn:
        if isinstance(error, _Unpicklable):
            raise RuntimeError(str(error)) from error
        raise BlockError(number, *self.spans[number], _message(error)) from error


def _message(error: BaseException) -> str:
    if isinstance(error, KilledWorker):
        return f"{error.allowed_failures + 1} workers died while they had it; their logs may say why"
    return str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
