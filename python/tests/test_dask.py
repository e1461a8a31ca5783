"""Casts on a cluster have the bits of one machine, even if workers die."""

import doctest
import inspect
import operator
import os
import pickle
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import shotline

pytest.importorskip("distributed", reason="needs Dask's distributed: pip install 'shotline[dask]'")

import cloudpickle
import dask
from distributed import Client, LocalCluster
from shotline.columns import Columns
from shotline.dask import BlockError, Cone, Function, Random, cast, render
from shotline.image import PictureOptions

# Workers cannot import this file.
cloudpickle.register_pickle_by_value(sys.modules[__name__])

BEAM = Random(40_000, seed=7, min=(-4, -4, -4), max=(4, 4, 4))
QUERIES = ["closest", "any", "count", "crossings", "segments", "thickness"]


@pytest.fixture(scope="module")
def client():
    # A block may lose only one worker, so that Dask soon gives up blocks that kill their workers.
    with dask.config.set({"distributed.scheduler.allowed-failures": 1}):
        with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster:
            with Client(cluster) as client:
                yield client


@pytest.fixture(scope="module")
def lone_client(client):
    """The client of a cluster of one worker with two threads."""
    with LocalCluster(n_workers=1, threads_per_worker=2, processes=True, dashboard_address=":0") as cluster:
        with Client(cluster, set_as_default=False) as lone_client:
            yield lone_client


@pytest.fixture(scope="module")
def scene():
    plate = shotline.Box(min=(-2, -2, -1), max=(2, 2, 1)) - shotline.Cylinder(radius=0.5, z0=-2, z1=2)
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    mesh = shotline.Mesh(corners, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    return shotline.Scene(
        plate.named("plate", material="steel"),
        shotline.Torus(R=4, r=0.4).named("ring", material="brass"),
        mesh.translate(0, 0, 3).named("mesh"),
        materials={"steel": {}, "brass": {}},
    )


def same(one, other):
    if isinstance(one, (tuple, Columns)):
        assert type(one) is type(other)
        assert all(same(a, b) for a, b in zip(one, other, strict=True))
    else:
        assert (one.dtype, one.shape) == (other.dtype, other.shape) and one.tobytes() == other.tobytes()
    return True


def unfinished(client):
    """The blocks that the scheduler still has."""
    return client.run_on_scheduler(lambda dask_scheduler: [k for k in dask_scheduler.tasks if "block" in str(k)])


def wait_until(condition, seconds=20):
    end = time.monotonic() + seconds
    while not (met := condition()):
        assert time.monotonic() < end, f"waited in vain: {met}"
        time.sleep(0.02)
    return met


@pytest.mark.parametrize("query", QUERIES)
def test_the_bits_of_one_machine(client, scene, query):
    if not hasattr(scene, query):
        pytest.skip(f"this shotline has no {query}")
    o, d = BEAM.rays(0, len(BEAM))
    local = getattr(scene, query)(o, d, t_max=6)
    for rays in (BEAM, (o, d), np.hstack([o, d])):
        assert same(cast(scene, rays, client, query=query, t_max=6, block=7000), local)


@pytest.mark.parametrize("query", ["closest", "crossings"])
def test_answers_know_their_rays_and_names(client, scene, query):
    o, d = BEAM.rays(0, len(BEAM))
    local = getattr(scene, query)(o, d)
    for rays in (BEAM, (o, d)):
        found = cast(scene, rays, client, query=query, block=7000)
        assert found.points.tobytes() == local.points.tobytes()
        assert found[5:9000].points.tobytes() == local[5:9000].points.tobytes()
        assert (found.path_names() == local.path_names()).all()
    first = cast(scene, BEAM, client, query=query, block=7000, reduce=lambda result, block: [result[:10]])
    assert len(first) == 6 and all(len(part.object_names()) == len(part) for part in first)
    assert first[1].points.tobytes() == local[7000:7010].points.tobytes()


def test_options(client, scene):
    overlapping = shotline.Scene(shotline.Sphere(radius=2).named("a"), shotline.Sphere(radius=1).named("b"))
    for overlaps in ("priority", "all"):
        local = overlapping.segments(*BEAM.rays(0, len(BEAM)), overlaps=overlaps)
        assert same(cast(overlapping, BEAM, client, query="segments", overlaps=overlaps, block=9000), local)
    with pytest.raises(
        BlockError, match=r"block \d \(rays \d+ to \d+\): ray \d+: objects 'a' and 'b' of equal priority overlap"
    ) as raised:
        cast(overlapping, BEAM, client, query="segments", block=9000)
    assert isinstance(raised.value.__cause__, ValueError)
    row = raised.value.__cause__.row
    assert raised.value.start <= row < raised.value.stop and f"ray {row}: " in str(raised.value)
    o, d = BEAM.rays(0, len(BEAM))
    local = overlapping.thickness(o, d, by="object", overlaps="all")
    assert same(cast(overlapping, BEAM, client, query="thickness", by="object", overlaps="all", block=9000), local)
    with pytest.raises(ValueError, match="by is for thickness, not for segments"):
        cast(overlapping, BEAM, client, query="segments", by="object")


def test_shapes(client, scene):
    cone = Cone(source=[(0, 0, -9), (0, 1, -9)], center=(0, 0, 4), u=(0.1, 0, 0), v=(0, 0.1, 0), shape=(90, 70))
    hits = cast(scene, cone, client, block=1999)
    assert hits.t.shape == (2, 90, 70) and hits.normal.shape == (2, 90, 70, 3) and np.isfinite(hits.t).any()
    o, d = (array.reshape(2, 90, 70, 3) for array in cone.rays(0, len(cone)))
    assert same(hits, scene.closest(o, d))
    assert same(cast(scene, (o, d), client), hits)
    # Broadcast, single and no rays.
    assert same(cast(scene, (o[0], (0, 0, 1)), client), scene.closest(o[0], (0, 0, 1)))
    assert same(cast(scene, ((0, 0, -9), d[1]), client), scene.closest((0, 0, -9), d[1]))
    assert same(cast(scene, ((0, 1, -9), (0, 0, 1)), client), scene.closest((0, 1, -9), (0, 0, 1)))
    assert same(cast(scene, [[0, 1, -9, 0, 0, 1]], client), scene.closest([[0, 1, -9, 0, 0, 1]]))
    for query in ("closest", "any", "crossings"):
        empty = np.empty((0, 6))
        assert same(cast(scene, empty, client, query=query), getattr(scene, query)(empty))


def test_reduce_runs_on_the_workers(client, scene):
    def tracks(result, block):
        assert len(result.t) == block.stop - block.start == len(block.o)
        return np.histogram(result.t, bins=20, range=(0, 10))[0]

    t = scene.closest(*BEAM.rays(0, len(BEAM))).t
    assert (
        cast(scene, BEAM, client, block=1500, reduce=tracks) == np.histogram(t, bins=20, range=(0, 10))[0]
    ).all()

    # Values are combined in the order of the blocks, although the first blocks take longest.
    def slow(result, block):
        time.sleep(0.2 if block.number < 2 else 0)
        return [(block.start, block.stop)]

    order = cast(scene, BEAM, client, block=7000, query="any", reduce=slow)
    assert order == [(start, min(start + 7000, 40_000)) for start in range(0, 40_000, 7000)]
    largest = cast(scene, BEAM, client, query="count", block=7000, reduce=lambda n, _: n.max(), combine=max)
    assert largest == scene.count(*BEAM.rays(0, len(BEAM))).max()


def test_killing_a_worker_changes_nothing(client, scene, tmp_path):
    """Block 2 waits on its worker until that worker is dead."""
    at_work, dead = tmp_path / "at_work", tmp_path / "dead"

    def rays(start, stop):
        if start == 10_000 and not dead.exists():
            (tmp_path / "new").write_text(str(os.getpid()))
            (tmp_path / "new").rename(at_work)
            wait_until(dead.exists)
        return BEAM.rays(start, stop)

    killed = []

    def kill():
        killed.append(int(wait_until(lambda: at_work.exists() and at_work.read_text())))
        os.kill(killed[0], signal.SIGKILL)
        wait_until(lambda: not running(killed[0]))
        dead.touch()

    before = client.run(os.getpid)
    thread = threading.Thread(target=kill)
    thread.start()
    result = cast(scene, Function(len(BEAM), rays), client, query="crossings", block=5000)
    thread.join()
    assert killed[0] in before.values()
    assert same(result, scene.crossings(*BEAM.rays(0, len(BEAM))))
    client.wait_for_workers(2, timeout=20)


def running(pid):
    """Whether a process is running. A killed one stays in the process table until its parent has waited for it."""
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_killing_the_only_worker_changes_nothing(lone_client, scene, tmp_path):
    """No other worker has the scene, the beam or the rays."""
    once = tmp_path / "once"

    def die(result, block):
        if block.number == 3 and not once.exists():
            once.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return result.tolist()

    result = cast(scene, BEAM.rays(0, len(BEAM)), lone_client, query="count", block=5000, reduce=die)
    assert once.exists()
    assert result == scene.count(*BEAM.rays(0, len(BEAM))).tolist()


def test_a_block_that_raises_is_named(client, scene, tmp_path):
    def rays(start, stop):
        (tmp_path / str(start)).touch()
        if start == 7 * 1000:
            raise KeyError("no such ray")
        return BEAM.rays(start, stop)

    with pytest.raises(BlockError, match=r"^block 7 \(rays 7000 to 8000\): KeyError: 'no such ray'$") as raised:
        cast(scene, Function(len(BEAM), rays), client, query="count", block=1000, reduce=lambda n, _: n.sum())
    error = raised.value
    assert (error.number, error.start, error.stop) == (7, 7000, 8000) and isinstance(error.__cause__, KeyError)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
    wait_until(lambda: not unfinished(client))
    assert len(list(tmp_path.iterdir())) < 20  # of 40


def test_a_block_that_kills_its_worker_is_named(lone_client, scene):
    """The error does not name the block that ran beside it."""

    def die(result, block):
        if block.number == 1:
            time.sleep(0.1)
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(0.4)
        return result.sum()

    with pytest.raises(BlockError, match=r"^block 1 \(rays 1000 to 2000\): 2 workers died while they had it"):
        cast(scene, BEAM, lone_client, query="count", block=1000, reduce=die)
    wait_until(lambda: not unfinished(lone_client))


def test_a_bad_ray_is_named_by_its_row(client, scene):
    rays = np.hstack(BEAM.rays(0, len(BEAM)))
    rays[33_333, 3:] = 0
    with pytest.raises(
        BlockError, match=re.escape("block 3 (rays 30000 to 40000): ray 33333: the direction is zero")
    ):
        cast(scene, rays, client, block=10_000)


def test_beams_with_a_wrong_number_of_rays_are_errors(client, scene):
    with pytest.raises(BlockError, match=r"block 0 .*: the beam made 9 rays, not 10"):
        cast(scene, Function(10, lambda start, stop: (np.zeros((9, 3)), (0, 0, 1))), client)


def test_interrupts_cancel(client, scene, tmp_path):
    def slow(result, block):
        (tmp_path / str(block.number)).touch()
        time.sleep(0.1)
        return 0

    def interrupt():
        wait_until(lambda: list(tmp_path.iterdir()))
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        cast(scene, BEAM, client, query="any", block=100, reduce=slow)  # 20 s
    assert time.monotonic() - begin < 5
    thread.join()
    wait_until(lambda: not unfinished(client))


def test_a_process_builds_the_scene_once(client):
    def watch():
        from shotline import scene

        scene.builds = []
        built = getattr(scene, "plainly_built", scene._built)

        def counted(*args):
            scene.builds.append(1)
            return built(*args)

        scene.plainly_built, scene._built = built, counted

    client.run(watch)
    new = shotline.Scene(shotline.Sphere(radius=1.25).named("new"))
    for query in ("count", "crossings"):
        cast(new, BEAM, client, query=query, block=1000)
        # Dask does this every few seconds: it drops all copies but one.
        client.amm.run_once()
        time.sleep(0.2)
    # Nor do tasks that get the scene as an argument build it again.
    twice = [client.submit(lambda s, i: s.content_hash, new, i, pure=False) for i in range(4)]
    assert set(client.gather(twice)) == {new.content_hash}
    builds = client.run(lambda: len(__import__("shotline.scene").scene.builds))
    assert list(builds.values()) == [1, 1]


def test_scenes_are_pickled_and_tokenized_by_content(scene):
    again = pickle.loads(pickle.dumps(scene))
    assert again is pickle.loads(pickle.dumps(scene)) and again.content_hash == scene.content_hash
    assert again._native.pack()[0] == scene._native.pack()[0]
    assert dask.base.tokenize(again) == dask.base.tokenize(scene)
    other = shotline.Scene(shotline.Sphere(radius=1))
    assert dask.base.tokenize(other) != dask.base.tokenize(scene)


def test_progress(client, scene):
    reports = []
    cast(
        scene,
        BEAM,
        client,
        block=10_000,
        query="any",
        progress=lambda *numbers: reports.append(numbers),
        reduce=len_of,
    )
    assert reports == [(done, 40_000) for done in (10_000, 20_000, 30_000, 40_000)]

    def enough(done, total):
        raise InterruptedError("enough")

    with pytest.raises(InterruptedError):
        cast(scene, BEAM, client, block=1000, query="any", progress=enough)
    wait_until(lambda: not unfinished(client))


def len_of(result, block):
    return len(result)


def test_another_version_is_refused(client, scene, monkeypatch):
    monkeypatch.setattr("shotline.dask.__version__", "0.0.1")
    with pytest.raises(BlockError, match=f"the worker has shotline {shotline.__version__}, but the client 0.0.1"):
        cast(scene, BEAM, client)


def test_a_reduce_that_cannot_be_unpickled(client, scene):
    class Bad:
        def __reduce__(self):
            return operator.truediv, (1, 0)

        def __call__(self, result, block):
            return 0

    with pytest.raises(RuntimeError, match="could not unpickle the beam or reduce: ZeroDivisionError"):
        cast(scene, BEAM, client, reduce=Bad())


def test_a_reduce_that_only_one_worker_can_unpickle(client, scene, tmp_path):
    """If Dask itself unpickled it on a transfer between workers, it would retry forever."""
    first = tmp_path / "first"

    class Chosen:
        def __init__(self):
            self.only = first

        def __setstate__(self, state):
            try:
                state["only"].open("x").write(str(os.getpid()))
            except FileExistsError:
                raise LookupError("another worker has it") from None

        def __call__(self, result, block):
            time.sleep(0.1)
            return 0

    with pytest.raises(
        RuntimeError, match="could not unpickle the beam or reduce: LookupError: another worker has"
    ):
        cast(scene, BEAM, client, query="any", block=1000, reduce=Chosen())


def test_a_result_that_cannot_be_unpickled(client, scene):
    class Torn:
        def __reduce__(self):
            return operator.truediv, (1, 0)

    with pytest.raises(BlockError, match=r"^block \d .*: ZeroDivisionError"):
        cast(scene, BEAM, client, query="any", block=5000, reduce=lambda result, block: Torn())


@pytest.mark.parametrize(
    "error, message, changes",
    [
        (ValueError, "query is 'first'", {"query": "first"}),
        (ValueError, "block is 0", {"block": 0}),
        (ValueError, "overlaps is for segments", {"overlaps": "all"}),
        (ValueError, "shape", {"rays": np.zeros((5, 3))}),
        (TypeError, "scene must be a Scene", {"scene": 3}),
        (TypeError, "client must be", {"client": "tcp://localhost"}),
    ],
)
def test_bad_arguments(client, scene, error, message, changes):
    with pytest.raises(error, match=message):
        cast(**{"scene": scene, "rays": BEAM, "client": client} | changes)


def test_without_a_client(scene, monkeypatch):
    def none():
        raise ValueError

    monkeypatch.setattr("shotline.dask.default_client", none)
    with pytest.raises(RuntimeError, match="there is no Dask client: make one"):
        cast(scene, BEAM)


def test_the_client_in_use_is_found(client, scene):
    assert same(cast(scene, BEAM, query="any"), scene.any(*BEAM.rays(0, len(BEAM))))


def test_the_import_error_names_the_extra():
    script = """
        import sys
        sys.modules["distributed"] = None
        import shotline
        assert "dask" not in sys.modules
        try:
            import shotline.dask
        except ImportError as error:
            print(error)
    """
    out = subprocess.run([sys.executable, "-c", "if 1:" + script], capture_output=True, text=True, timeout=60)
    assert "pip install 'shotline[dask]'" in out.stdout, out


def test_examples():
    assert doctest.testmod(shotline.dask).failed == 0


def test_pictures(client, scene):
    reports = []
    options = {"size": (50, 41), "samples": 2, "background": "transparent"}
    for look in ("lit", "depth", "cost"):
        options |= {"edges": look != "cost", "opacity": {"*": 0.5} if look == "lit" else {}}
        local = scene.render(look=look, **options)
        picture = render(scene, client=client, look=look, block=7, progress=lambda *n: reports.append(n), **options)
        assert isinstance(picture, shotline.Image) and (picture == local).all()
    assert reports[-1] == (41, 41)
    with pytest.raises(ValueError, match="no look"):
        render(scene, client=client, look="x")
    with pytest.raises(TypeError, match="render has no argument 'sampless'; did you mean 'samples'?"):
        render(scene, client=client, sampless=3)


def test_pictures_of_a_cluster_have_the_options_of_scenes():
    of_scenes = inspect.signature(shotline.Scene.render).parameters
    assert PictureOptions._field_defaults == {
        name: parameter.default
        for name, parameter in of_scenes.items()
        if name not in ("self", "camera", "threads", "progress")
    }
    named = ["scene", "camera", "client", *PictureOptions._fields, "block", "progress"]
    assert list(inspect.signature(render).parameters) == named
