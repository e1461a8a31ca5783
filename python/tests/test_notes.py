"""Loading warns of items that a reader drops or repairs, and not of items that it only skips."""

import warnings

import pytest
import shotline

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def test_load_warns_of_faces_that_were_dropped(tmp_path):
    path = tmp_path / "part.obj"
    path.write_text(TETRAHEDRON + "f 1 2\n")
    with pytest.warns(
        shotline.ReadWarning, match="part.obj: 1 face of fewer than three corners was dropped, on line 10"
    ):
        scene = shotline.load(path)
    assert scene.count([0.1, 0.1, -1], [0, 0, 1]) == 2


def test_load_does_not_warn_of_skipped_items(tmp_path):
    path = tmp_path / "part.obj"
    path.write_text("\ufeff" + TETRAHEDRON.replace("\n", "\r"), encoding="utf-8", newline="")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert shotline.load(path).count([0.1, 0.1, -1], [0, 0, 1]) == 2
