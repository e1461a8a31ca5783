#!/usr/bin/env python3
"""Make the pictures of the tutorials: python docs/tutorials.py [PAGE ...]

The code is that of the pages: their blocks run one after the other, and the figures that they save as tutorial-*.png become
docs/pictures/tutorial-*.png. Those above 140 kB are reduced to 256 colours, so that the repository stays small.
"""

import os
import re
import sys
import tempfile
from pathlib import Path

import matplotlib
from PIL import Image as Pixels

matplotlib.use("Agg")

LIMIT = 140_000
DOCS = Path(__file__).resolve().parent
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def make(page):
    """Run the blocks of a page in a new folder beside the example scenes; keep its pictures."""
    code = "\n".join(BLOCK.findall(page.read_text()))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("scenes").symlink_to(DOCS.parent / "scenes")
        exec(compile(code, str(page), "exec"), {"__name__": "__main__"})
        for made in sorted(Path().glob("tutorial-*.png")):
            path = DOCS / "pictures" / made.name
            with Pixels.open(made) as picture:
                picture.convert("RGB").save(path, optimize=True)
                if path.stat().st_size > LIMIT:
                    picture.convert("RGB").quantize(256, dither=Pixels.Dither.NONE).save(path, optimize=True)
            print(f"{path.name}: {path.stat().st_size / 1024:.0f} KiB")
        os.chdir(DOCS)


def main():
    wanted = sys.argv[1:]
    for page in sorted((DOCS / "tutorials").glob("*.md")):
        if not wanted or page.stem in wanted:
            make(page)


if __name__ == "__main__":
    main()
