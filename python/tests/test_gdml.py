"""Detectors in GDML, against Geant4 where its answers are at hand."""

from pathlib import Path

import numpy as np
import pytest
import shotline

TEXT = """<gdml><define/><materials><material name="Al" Z="13"><D value="2.7"/></material></materials>
<solids><box name="hall" x="100" y="100" z="100"/><tube name="rod" rmax="4" z="20" deltaphi="360" aunit="deg"/>{solids}</solids>
<structure><volume name="rod"><materialref ref="Al"/><solidref ref="rod"/></volume>{volumes}
<volume name="world"><solidref ref="hall"/><physvol name="left" copynumber="1"><volumeref ref="rod"/><position x="-20"/></physvol>
<physvol name="right"><volumeref ref="rod"/><position x="2" unit="cm"/></physvol></volume></structure>
<setup name="Default" version="1.0"><world ref="world"/></setup></gdml>"""

TRUTH = Path(__file__).parents[3] / "shared" / "data" / "gdml"


def write(folder, solids="", volumes=""):
    path = folder / "part.gdml"
    path.write_text(TEXT.format(solids=solids, volumes=volumes))
    return path


def test_volumes_are_objects_and_placements_are_paths(tmp_path):
    scene = shotline.load(write(tmp_path))
    segments = scene.segments(np.array([[-50.0, 0, 0, 1, 0, 0]]))
    names = [scene.object_names[i] for i in segments.object]
    assert names == ["world", "rod", "world", "rod", "world"]
    assert segments.t_in.tolist() == [0, 26, 34, 66, 74]
    paths = [scene.path_name(path) for path in segments.path]
    assert paths == ["world", "world/left[1]", "world", "world/right", "world"]


def test_what_is_not_supported_is_left_out_on_request(tmp_path):
    volumes = '<volume name="odd"><solidref ref="blob"/></volume>'
    path = write(tmp_path, solids='<metaball name="blob"/>', volumes=volumes)
    with pytest.raises(ValueError, match=r"part\.gdml:2:.*1 of <metaball> is not supported"):
        shotline.load(path)
    with pytest.warns(shotline.ReadWarning, match="1 of <metaball> left out, on line 2"):
        scene = shotline.load(path, partial=True)
    assert "odd" not in scene.object_names


def lists(ends, names, t_in, t_out):
    """The names, entries and exits of each ray, of the segments that are longer than 1e-6 mm."""
    rows = np.flatnonzero(t_out - t_in > 1e-6)
    cuts = np.searchsorted(rows, ends)
    return [np.split(column[rows], cuts) for column in (names, t_in, t_out)]


def differing(scene, truth):
    """The rays on which Geant4 agrees with itself, and those of them on which its segments are others."""
    own = scene.segments(truth["rays"], overlaps="priority")
    ours = lists(own.ray_splits[1:-1], np.array(scene.object_names)[own.object], own.t_in, own.t_out)
    # The boundaries of a ray are one more than its segments.
    last = np.cumsum(np.diff(truth["offsets"]) + 1) - 1
    t_in, t_out = np.delete(truth["t"], last), np.delete(truth["t"], np.append(0, last[:-1] + 1))
    # Geant4 gives a reflected volume a name of its own.
    volumes = np.char.replace(truth["lv_names"], "_refl", "")[truth["node_lv"][truth["node"]]]
    theirs = lists(truth["offsets"][1:-1], volumes, t_in, t_out)
    judged = np.flatnonzero(truth["sym"] & truth["mid"])
    return judged, [
        ray for ray in judged if not are_same(*[[column[ray] for column in all] for all in (ours, theirs)])
    ]


def are_same(ours, theirs):
    return (
        len(ours[0]) == len(theirs[0])
        and (np.char.replace(ours[0], "_refl", "") == theirs[0]).all()
        and np.allclose(ours[1:], theirs[1:], rtol=1e-6, atol=1e-6)
    )


@pytest.mark.filterwarnings("ignore::shotline.OverlapWarning")
@pytest.mark.parametrize("name", ["g4_solids", "celeritas_solids", "cmse", "lhcb_calos", "protodunehd_v8"])
def test_segments_are_those_of_geant4(name):
    """They differ only where siblings overlap: Geant4 stays in the one that it has entered first."""
    if not TRUTH.is_dir():
        pytest.skip(f"needs the files of {TRUTH}")
    scene = shotline.load(TRUTH / f"{name}.gdml")
    truth = np.load(TRUTH / f"{name}.truth.npz")
    judged, different = differing(scene, truth)
    assert len(judged) > 300
    assert len(different) <= len(judged) / 500
    for ray in different:
        with pytest.raises(ValueError, match="overlap"):
            scene.segments(truth["rays"][ray : ray + 1])
