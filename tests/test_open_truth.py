"""Certified crossing lists that leave open what rounded inputs cannot determine (testdata/truth/README.md): rays parallel
to unbounded surfaces, thin walls, parts that abut, extreme frames. Four queries, compared with the truth and each other."""

import json

import numpy as np
import pytest
from command import cast, object_scene
from test_truth import GUARDED, TRUTH, load, write_meshes

FAMILIES = ["unbounded", "thin", "abutting", "solids2"]
# A crossing is right within this many times the effect of half an ulp in every input.
TOLERANCE = 256


@pytest.mark.parametrize("family", FAMILIES)
def test_family(tmp_path, family):
    truth = load(TRUTH / f"{family}.npz")
    scenes = json.loads((TRUTH / f"{family}.json").read_text())["scenes"]
    problems = []
    for scene in scenes:
        document = object_scene(scene["root"], defs=scene.get("defs", {}))
        write_meshes(tmp_path, family, [scene["root"], *document["defs"].values()])
        rows = np.nonzero(truth["scene"] == scene["id"])[0]
        for window in sorted({(truth["t_min"][row], truth["t_max"][row]) for row in rows}):
            inside = rows[(truth["t_min"][rows] == window[0]) & (truth["t_max"][rows] == window[1])]
            found = window_faults(tmp_path, document, truth, inside, window)
            problems += [f"scene {scene['id']} ({scene['name']}), {problem}" for problem in found]
    assert not problems, "\n".join([f"{len(problems)} faults", *problems[:20]])


def window_faults(folder, document, truth, rows, window):
    """The faults in the results of four queries for rays over one span, the window."""
    rays = np.hstack([truth["origin"][rows], truth["direction"][rows]])
    flags = [
        "--t-min",
        repr(float(window[0])),
        *(["--t-max", repr(float(window[1]))] if window[1] < np.inf else []),
    ]
    answers = {q: cast(folder, document, rays, q, *flags) for q in ("crossings", "closest", "any", "count")}
    lists = answers["crossings"]
    for i, (row, begin, end) in enumerate(zip(rows, lists["ray_splits"], lists["ray_splits"][1:], strict=False)):
        t, entering, kind = (lists[name][begin:end] for name in ("t", "entering", "kind"))
        first = t[0] if len(t) else np.inf
        alike = (answers["closest"]["t"][i], answers["any"]["any"][i], answers["count"]["count"][i])
        if alike != (first, len(t) > 0, len(t)):
            yield f"ray {row}: closest, any and count are {alike}, crossings {t}"
        # An unbounded interval has no exit in the truth.
        closed = kind != 2
        t, entering = t[closed], entering[closed]
        if (np.diff(t) < 0).any() or (entering != (np.arange(len(t)) % 2 == 0)).any() or not np.isfinite(t).all():
            yield f"ray {row}: {t} does not ascend and alternate from an entry"
        elif not truth["guard"][row] & GUARDED and not is_right(truth, row, t, entering):
            yield f"ray {row}: {t} instead of {truth['t'][truth['offsets'][row] : truth['offsets'][row + 1]]}"


def is_right(truth, row, t, entering):
    """Whether a list agrees with the truth up to its horizon, with or without the optional crossings there."""
    part = slice(truth["offsets"][row], truth["offsets"][row + 1])
    exact, exact_entering, optional = (truth[name][part] for name in ("t", "entering", "optional"))
    unit = np.maximum(truth["sens"][part], np.abs(exact)) * 2.0**-53
    tolerance = TOLERANCE * unit + truth["slack"][part]
    horizon = truth["horizon"][row]
    known, seen = int((exact <= horizon).sum()), int((t <= horizon).sum())
    # Every index in the truth up to which the list so far can agree with it; crossings are skipped in pairs only.
    places = {-1}
    for k in range(seen):
        agrees = (exact_entering == entering[k]) & (np.abs(exact - t[k]) <= tolerance)
        places = {
            j
            for j in np.nonzero(agrees[:known])[0]
            for i in places
            if j > i and (j - i) % 2 == 1 and optional[i + 1 : j].all()
        }
    return any((known - 1 - i) % 2 == 0 and optional[i + 1 : known].all() for i in places)
