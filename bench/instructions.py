#!/usr/bin/env python3
"""Compare the instructions that small casts take with the table `instructions.tsv` beside this file.

usage: instructions.py [--binary PATH] [--write] [--reason TEXT]

Fails if a cast takes more than 5 % more than the table says. With --write a new table is written; a cast that has grown by
more than 5 % then needs a reason, which is kept beside its figure. A fall of more than 5 % is no failure, but should be
written too, so that the figure guards what was gained.

The counts are from callgrind (valgrind), of the program `crates/shotline/examples/instructions.rs` as the tests of Rust build
it: optimised, with assertions. Valgrind knows no AVX-512, so it runs the code for AVX2. Counts are the same from run to run
on one machine, and nearly so wherever the program lies, but not between compilers: where another one is in use than that of
the table, nothing is compared.
"""

import argparse
import os
import platform
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TABLE = Path(__file__).with_suffix(".tsv")
# What this run has found, in one line, for the end of a log.
VERDICT = ROOT / "out" / "instructions.txt"
TOLERANCE = 0.05


def compiler() -> str:
    return subprocess.run(["rustc", "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def obstacle() -> str | None:
    """Why nothing can be measured here."""
    if shutil.which("valgrind") is None:
        return "there is no valgrind"
    cpu = Path("/proc/cpuinfo")
    flags = set(cpu.read_text().split()) if cpu.exists() else set()
    if platform.machine() != "x86_64" or not {"avx2", "fma"} <= flags:
        return "the table is for x86-64 with AVX2"
    return None


def count(binary: Path, name: str) -> int:
    """The instructions of a cast."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "--toggle-collect=*measured*"]
    # The environment moves the stack, and so changes a few instructions of copies of memory; the path of the program does too.
    environment = {"PATH": os.environ["PATH"]}
    done = subprocess.run([*command, str(binary), name], env=environment, capture_output=True, text=True)
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or found is None or int(found[1]) == 0:
        sys.exit(f"'{name}' was not measured:\n{done.stderr}")
    return int(found[1])


def measure(binary: Path) -> dict[str, int]:
    names = subprocess.run([binary], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(zip(names, pool.map(lambda name: count(binary, name), names), strict=True))


def read_table() -> tuple[str, dict[str, tuple[int, str]]]:
    """The compiler, and the figure and the reason of each cast."""
    if not TABLE.exists():
        return "", {}
    head, _, *rows = TABLE.read_text().splitlines()
    cells = [row.split("\t") for row in rows]
    return head.removeprefix("# "), {name: (int(figure), reason) for name, figure, reason in cells}


def write_table(found: dict[str, int], known: dict[str, tuple[int, str]], reason: str) -> None:
    rows = [f"# {compiler()}", "cast\tinstructions\treason of the last growth"]
    for name, figure in found.items():
        before, kept = known.get(name, (figure, ""))
        grown = figure > before * (1 + TOLERANCE)
        if grown and not reason:
            sys.exit(f"'{name}' has grown from {before:,} to {figure:,}: say why, with --reason")
        rows.append(f"{name}\t{figure}\t{reason if grown else kept}")
    TABLE.write_text("\n".join(rows) + "\n")


def compare(found: dict[str, int], known: dict[str, tuple[int, str]]) -> tuple[bool, str]:
    """Whether no cast has grown, and what to say about it."""
    grown, fallen = [], []
    for name, figure in found.items():
        before, _ = known.get(name, (0, ""))
        change = figure / before - 1 if before else float("inf")
        print(f"{name:18} {figure:>12,} {100 * change:+7.1f} %")
        if change > TOLERANCE:
            grown.append(name)
        elif change < -TOLERANCE:
            fallen.append(name)
    gone = known.keys() - found.keys()
    if grown or gone:
        names = ", ".join([*grown, *sorted(gone)])
        return False, f"FAILED: instruction counts of {names}: mend it, or make instructions REASON=why"
    if fallen:
        return True, f"passed: instruction counts; lower those of {', '.join(fallen)}: make instructions"
    return True, f"passed: instruction counts of {len(found)} casts, with AVX2"


def main() -> None:
    parser = argparse.ArgumentParser(usage=(__doc__ or "").split("\n")[2].removeprefix("usage: "))
    target = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target")
    parser.add_argument("--binary", type=Path, default=target / "debug" / "examples" / "instructions")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--reason", default="")
    options = parser.parse_args()
    of_table, known = read_table()
    why = obstacle()
    if not options.write and why is None and of_table != compiler():
        why = f"the table is of {of_table}, here is {compiler()}"
    if why:
        passed, verdict = not options.write, f"skipped: instruction counts: {why}"
    else:
        found = measure(options.binary)
        if options.write:
            write_table(found, known, options.reason)
            known = read_table()[1]
        passed, verdict = compare(found, known)
    VERDICT.parent.mkdir(exist_ok=True)
    VERDICT.write_text(verdict + "\n")
    print(verdict)
    sys.exit(not passed)


if __name__ == "__main__":
    main()
