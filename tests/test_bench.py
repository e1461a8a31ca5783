"""The comparison with other packages runs, even without most of them, and finds no wrong result of shotline."""

import os
import subprocess
import sys

import pytest
from command import ROOT

DATA = os.environ.get("SHOTLINE_DATA", ROOT.parent / "shared/data")


@pytest.mark.parametrize("section, heading", [("aimed", "wrong answers"), ("overhead", "What Python costs")])
def test_peers(section, heading):
    if section == "overhead" and not os.path.exists(os.path.join(DATA, "bunny.ply")):
        pytest.skip("the bunny is not here")
    command = [sys.executable, ROOT / "bench/peers.py", "--only", section, "--quick", "--data", DATA]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert answer.returncode == 0, answer.stderr
    assert heading in answer.stdout
