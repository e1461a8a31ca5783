"""Installs a wheel in a fresh virtual environment, with no compiler on the path, and makes a picture with it.

python tests/try_wheel.py out/wheels/shotline-0.1.0-cp310-abi3-manylinux_2_17_x86_64.whl
"""

import os
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

PROGRAM = """
import shotline
from shotline import Box, Scene, Sphere
scene = Scene((Box(min=(-1, -1, -1), max=(1, 1, 1)) - Sphere(radius=1.2)).named("part"))
assert scene.crossings([[-2, 0.9, 0.9]], [[1, 0, 0]]).t.round(3).tolist() == [1.0, 3.0]
scene.render(size=(320, 240)).save("part.png")
"""


def main() -> None:
    wheel = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        programs = Path(folder) / ("Scripts" if os.name == "nt" else "bin")
        # No Rust, no C compiler: the wheel must not need them.
        environment = {"PATH": str(programs), "HOME": folder}
        environment |= {
            name: value for name, value in os.environ.items() if name.startswith("PIP_") or "CERT" in name
        }

        def run(*command: str) -> str:
            done = subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True, text=True)
            return done.stdout

        begin = time.perf_counter()
        run(str(programs / "pip"), "install", "--quiet", "--no-cache-dir", str(wheel))
        installed = time.perf_counter()
        run(str(programs / "python"), "-c", PROGRAM)
        made = time.perf_counter()
        version = run(str(programs / "shotline"), "--version").strip()
        size = (Path(folder) / "part.png").stat().st_size
        print(f"{wheel.name}: {wheel.stat().st_size / 2**20:.1f} MiB, {version}")
        print(
            f"installed in {installed - begin:.1f} s, first picture ({size} bytes) {made - installed:.1f} s after that"
        )


if __name__ == "__main__":
    main()
