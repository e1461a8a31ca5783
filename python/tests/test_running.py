"""Long calls: Ctrl-C, progress, threads and processes."""

import concurrent.futures
import multiprocessing
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
import shotline

# A ray that meets 2^40 spheres takes seconds to reach its limits.
ENDLESS = """
import shotline
level = shotline.Sphere(radius=1)
for i in range(40):
    level = shotline.Group(level, level.translate(0, 0, 0))
scene = shotline.Scene(level)
"""


def run(script, **options):
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True, **options
    )


@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_ends_a_long_call(threads):
    script = f"""
        import os, signal, sys, threading, time
        import numpy as np
        import shotline
        rng = np.random.default_rng(1)
        scene = shotline.Scene([shotline.Torus(R=1, r=0.3).translate(rng.normal(size=3)) for _ in range(300)])
        o = rng.normal(size=(10_000_000, 3))
        before = threading.active_count()
        def later():
            time.sleep(0.5)
            print("now", time.monotonic(), flush=True)
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=later).start()
        try:
            scene.crossings(o, -o, threads={threads})
        except KeyboardInterrupt:
            print("ended", time.monotonic(), flush=True)
        time.sleep(0.05)
        print("threads", threading.active_count() - before, len(os.listdir("/proc/self/task")))
        print("again", int(scene.count([9, 0, 0], [-1, 0, 0]) >= 0))
    """
    out, _ = run(script).communicate(timeout=60)
    lines = dict(line.split(maxsplit=1) for line in out.splitlines())
    assert float(lines["ended"]) - float(lines["now"]) < 5, out  # the whole call would take minutes
    assert lines["threads"].startswith("0 ") and lines["again"] == "1"


@pytest.mark.parametrize("query", ["closest", "count", "crossings", "segments", "cost"])
@pytest.mark.parametrize("rows", [1, 5000])
def test_ctrl_c_ends_a_single_ray(query, rows):
    """Also on the calling thread, on which calls with few rays run. The ray meets no sphere: no limit ends it soon."""
    script = f"""
        import os, signal, threading, time
        {textwrap.indent(ENDLESS, " " * 8).strip()}
        def later():
            time.sleep(0.2)
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=later).start()
        try:
            scene.{query}([[-5, 0.9, 0.9]] * {rows}, [1, 0, 0])
            print("answered")
        except KeyboardInterrupt:
            print("ended")
    """
    out, _ = run(script).communicate(timeout=60)
    assert out == "ended\n"


def test_ctrl_c_ends_the_command(tmp_path):
    random = np.random.default_rng(2)
    np.save(tmp_path / "rays.npy", random.normal(size=(3_000_000, 6)))
    scene = shotline.Scene([shotline.Torus(R=1, r=0.3).translate(*random.normal(size=3)) for _ in range(300)])
    scene.save(tmp_path / "tori.json")
    words = ["-m", "shotline", "cast", "tori.json", "--rays", "rays.npy", "--query", "crossings", "-o", "out.npz"]
    process = subprocess.Popen([sys.executable, *words], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 130 and "interrupted" in errors
    assert not (tmp_path / "out.npz").exists()


def test_progress_is_reported(sample_scene):
    o = np.random.default_rng(3).normal(size=(300_000, 3)) * 9
    reports = []
    expected = sample_scene.count(o, -o)
    assert (sample_scene.count(o, -o, progress=lambda done, total: reports.append((done, total))) == expected).all()
    assert reports[-1] == (300_000, 300_000) and reports == sorted(reports)

    class Bar:
        total, n = None, 0

        def update(self, steps):
            self.n += steps

    bar = Bar()
    sample_scene.count(o, -o, progress=bar)
    assert bar.n == bar.total == 300_000
    with pytest.raises(TypeError, match="progress"):
        sample_scene.count(o, -o, progress=3)


def test_progress_on_stderr(sample_scene, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    sample_scene.count(np.ones((1000, 3)), [1, 0, 0], progress=True)
    assert "1000 of 1000 rays" in capsys.readouterr().err


def test_an_exception_of_progress_ends_the_call(sample_scene):
    o = np.random.default_rng(4).normal(size=(2_000_000, 3)) * 9

    def fail(done, total):
        raise RuntimeError(f"enough at {done}")

    with pytest.raises(RuntimeError, match="enough"):
        sample_scene.crossings(o, -o, progress=fail)
    assert sample_scene.any([9, 9, 9], [-1, -1, -1]).shape == ()


def test_the_gil_is_released(sample_scene):
    o = np.random.default_rng(5).normal(size=(400_000, 3)) * 9
    ticks, stop = 0, threading.Event()

    def tick():
        nonlocal ticks
        while not stop.is_set():
            ticks += 1
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    sample_scene.crossings(o, -o, threads=1)
    took = time.monotonic() - begin
    stop.set()
    thread.join()
    assert ticks > 20 * took


def test_threads_may_query_concurrently(sample_scene, sample_rays):
    expected = sample_scene.crossings(*sample_rays)
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        for rows in pool.map(lambda _: sample_scene.crossings(*sample_rays, threads=2), range(12)):
            assert rows.t.tobytes() == expected.t.tobytes()


def cast(arguments):
    scene, o, d = arguments
    return scene.crossings(np.tile(o, (20, 1)), np.tile(d, (20, 1)), threads=2).t.tobytes()


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_processes(sample_scene, sample_rays, method):
    """Also if the parent has cast on several threads before the fork."""
    expected = cast((sample_scene, *sample_rays))
    with multiprocessing.get_context(method).Pool(2) as pool:
        results = pool.map_async(cast, [(sample_scene, *sample_rays)] * 4).get(timeout=60)
    assert results == [expected] * 4


def measured(scene):
    return [scene.measure(rays=9600, threads=threads).volume.tobytes() for threads in (1, 2)]


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_measuring_after_a_fork():
    """Also on one thread, and with meshes, which are checked by several threads."""
    mesh = shotline.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    cut = shotline.Box(min=(4, 4, 4), max=(6, 6, 6)) - shotline.Sphere(radius=1).translate(5, 5, 5)
    scene = shotline.Scene(mesh.named("mesh"), cut.named("cut"))
    expected = measured(scene)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply_async(measured, (scene,)).get(timeout=30) == expected
    assert expected[0] == expected[1]


def test_import_needs_numpy_only():
    script = """
        import sys
        class Refuse:
            def find_spec(self, name, path=None, target=None):
                if name.split(".")[0] in {"matplotlib", "pandas", "scipy", "tqdm", "dask", "trimesh", "PIL", "IPython"}:
                    raise ImportError(name)
        sys.meta_path.insert(0, Refuse())
        import shotline
        print(shotline.Scene(shotline.Sphere(radius=1)).closest([0, 0, -3], [0, 0, 1]).t)
    """
    out, _ = run(script, env={}).communicate(timeout=60)
    assert out.strip() == "2.0"


def test_calls_do_not_look_up_numpy():
    """Ctrl-C while the bindings look up NumPy's interfaces would cause a panic, so they do that on import."""
    script = """
        import numpy, numpy.lib._version, shotline
        def interrupted(*_):
            raise KeyboardInterrupt
        numpy.lib._version.NumpyVersion.__init__ = interrupted
        scene = shotline.Scene(shotline.Sphere(radius=1))
        print(scene.count([0, 0, -3], [0, 0, 1]), scene.contains([0, 0, 0]), len(scene.crossings([0, 0, -3], [0, 0, 1]).t))
    """
    out, _ = run(script).communicate(timeout=60)
    assert out.split() == ["2", "True", "2"]
