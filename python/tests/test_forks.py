"""Processes that are forked from one that has used threads: they do not have these threads."""

import multiprocessing

import numpy as np
import pytest
import shotline
from shotline import _native

pytestmark = pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")

# So many faces and vertices that every step of the work on a mesh is divided among threads.
ROWS, COLUMNS = 300, 200


def ring(radius=0.4):
    """A closed mesh of 120,000 faces."""
    row, column = np.divmod(np.arange(ROWS * COLUMNS), COLUMNS)
    around, along = 2 * np.pi * row / ROWS, 2 * np.pi * column / COLUMNS
    out = 1 + radius * np.cos(along)
    vertices = np.stack([out * np.cos(around), out * np.sin(around), radius * np.sin(along)], axis=1)
    a, b = row * COLUMNS, (row + 1) % ROWS * COLUMNS
    next_column = (column + 1) % COLUMNS
    lower = np.stack([a + column, b + column, b + next_column], axis=1)
    upper = np.stack([a + column, b + next_column, a + next_column], axis=1)
    return vertices, np.concatenate([lower, upper])


def rays(count):
    random = np.random.default_rng(7)
    o = random.normal(size=(count, 3)) * 4
    return o, random.uniform(-1, 1, (count, 3)) - o


def built(accel):
    scene = shotline.Scene(shotline.Mesh(*ring(), accel=accel))
    return scene.count(*rays(50)).tobytes(), scene.count(*rays(6_000)).tobytes()


def welded():
    vertices, faces = ring()
    return shotline.Mesh(
        vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3), weld=1e-9
    ).vertices.tobytes()


def queried(scene):
    """The results of all queries, of few rays and of many, on one thread and on several."""
    for count, threads in [(50, 0), (6_000, 0), (6_000, 1), (6_000, 3)]:
        o, d = rays(count)
        yield scene.closest(o, d, threads=threads).t.tobytes()
        yield scene.any(o, d, threads=threads).tobytes()
        yield scene.crossings(o, d, threads=threads).t.tobytes()
        yield scene.segments(o, d, threads=threads).length.tobytes()
        yield scene.contains(o, threads=threads).tobytes()


def cast():
    return list(queried(shotline.Scene(shotline.Mesh(*ring()))))


def moved():
    scene = shotline.Scene(shotline.Mesh(*ring()).named("ring"), shotline.Sphere(radius=0.3).named("ball"))
    return list(queried(scene.with_moved("ball", np.eye(4) + np.eye(4, k=3) * 0.2)))


def of_many_parts():
    ball, random = shotline.Sphere(radius=0.01), np.random.default_rng(8)
    parts = [ball.translate(*at) for at in random.normal(size=(100_000, 3))]
    return list(queried(shotline.Scene(shotline.Group(*parts))))


def rendered():
    scene = shotline.Scene(shotline.Mesh(*ring()))
    return [scene.render(size=(96, 64), samples=2, threads=threads).tobytes() for threads in (0, 1)]


def measured():
    """A sound mesh, one that passes through itself, and a combination."""
    vertices, faces = ring()
    twice = shotline.Mesh(
        np.concatenate([vertices, vertices + 0.3]), np.concatenate([faces, faces + len(vertices)])
    )
    cut = shotline.Mesh(vertices, faces) - shotline.Sphere(radius=0.9)
    for node, threads in [(shotline.Mesh(vertices, faces), 0), (twice, 0), (cut, 0), (cut, 1)]:
        yield shotline.Scene(node).measure(rays=9600, threads=threads).volume.tobytes()


def checked(path):
    return _native.main(["shotline", "check", path])


def loaded(path):
    return shotline.load(path).count(*rays(50)).tobytes()


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("forks") / "ring.json"
    shotline.Scene(shotline.Mesh(*ring())).save(path)
    return str(path)


def everything(path):
    """All work that may be divided among threads, by name."""
    works = {f"build {accel}": (built, accel) for accel in ("bvh", "bvh_best", "bvh_fast", "grid")}
    works |= {work.__name__: (work,) for work in (welded, cast, moved, of_many_parts, rendered)}
    works["measured"] = (lambda: list(measured()),)
    works |= {"check": (checked, path), "load": (loaded, path)}
    return works


def in_child(pipe, works):
    for name, (work, *arguments) in works.items():
        pipe.send((name, None))
        pipe.send((name, work(*arguments)))
    pipe.close()


def test_nothing_waits_for_threads_of_the_parent(path):
    works = everything(path)
    expected = {name: work(*arguments) for name, (work, *arguments) in works.items()}
    fork = multiprocessing.get_context("fork")
    receive, send = fork.Pipe(duplex=False)
    child = fork.Process(target=in_child, args=(send, works))
    child.start()
    send.close()
    name, results = "start", {}
    try:
        while len(results) < len(works):
            assert receive.poll(120), f"{name} does not end in a forked process"
            name, result = receive.recv()
            if result is not None:
                results[name] = result
    finally:
        child.kill()
        child.join()
    assert results == expected


def test_a_scene_of_the_parent_is_cast_in_a_forked_process():
    """What a mesh computes for its first rays is not computed by threads of the parent."""
    scene, fresh = (shotline.Scene(shotline.Mesh(*ring())) for _ in range(2))
    expected = list(queried(scene))
    fork = multiprocessing.get_context("fork")
    receive, send = fork.Pipe(duplex=False)
    child = fork.Process(target=lambda: send.send([list(queried(scene)), list(queried(fresh))]))
    child.start()
    try:
        assert receive.poll(60), "casting does not end in a forked process"
        assert receive.recv() == [expected, expected]
    finally:
        child.kill()
        child.join()
