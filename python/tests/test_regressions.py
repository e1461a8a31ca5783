"""One function for each fault that was ever found in the Python package, with what was wrong. Each builds the smallest
scene that showed it and holds the answer to a closed form.

Faults of the core are in `crates/shotline/tests/regressions.rs`, those of readers in
`crates/shotline-io/tests/regressions.rs`."""

import json
import math
import pickle
import subprocess
import sys
import textwrap
from types import SimpleNamespace

import numpy as np
import pytest
import shotline
from shotline import Box, Camera, Group, Halfspace, Mesh, Scene, Sphere, Union

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
BALL = Scene(Sphere(radius=1).named("ball"))


def centre(node):
    return np.round(Scene(node).bounds.mean(axis=0), 9).tolist()


# Building


def test_a_part_that_is_placed_named_and_placed_again_keeps_both_placements():
    """As a root of a scene it lost the first."""
    ball = Sphere(radius=1)
    assert centre(ball.translate(1, 0, 0).named("a").translate(10, 0, 0)) == [11, 0, 0]
    assert centre(ball.translate(5, 0, 0).named("a").rotate(0, 0, 180)) == [-5, 0, 0]
    assert centre(Box(min=(0, 0, 0), max=(1, 1, 1)).scale(2).named("a").scale(3)) == [3, 3, 3]


def test_named_on_an_object_renames_it():
    """A second name was that of an object around the first, or an error."""
    ball = Sphere(radius=1).named("a", material="iron")
    scene = Scene(ball.named("b"), materials={"iron": {}})
    assert scene.object_names == ["b"] and ball.named("b").material == "iron"


def test_nodes_that_are_made_alike_are_equal():
    """They were compared by identity, while scenes were compared by content."""
    assert Sphere(radius=1) == Sphere(radius=1.0) and hash(Sphere(radius=1)) == hash(Sphere(radius=1.0))
    assert Sphere(radius=1) != Sphere(radius=2) and Group(Sphere(radius=1)) != Union(Sphere(radius=1))


def test_parameters_may_be_given_in_order():
    """`Sphere(1)` said that a method takes 1 positional argument but 2 were given."""
    assert Sphere(1) == Sphere(radius=1)
    assert Box((0, 0, 0), (1, 2, 3)) == Box(min=(0, 0, 0), max=(1, 2, 3))


def test_a_camera_needs_no_field_of_view():
    """In scene files `fov` is 40 if absent; the package asked for it."""
    assert Camera(eye=(0, -5, 0)) == Camera(eye=(0, -5, 0), target=(0, 0, 0), up=(0, 0, 1), fov=40)


def test_names_of_several_objects_are_warned_of():
    """They were accepted without a warning."""
    with pytest.warns(shotline.DuplicateNameWarning, match="'a'"):
        Scene(Sphere(radius=1).named("a"), Box(min=(2, 0, 0), max=(3, 1, 1)).named("a"))


# Refusals


@pytest.mark.parametrize(
    "wrong, error, words",
    [
        (lambda: Sphere(radius="1"), TypeError, "radius must be a real number"),
        (lambda: BALL.closest([-5, 0, 0], [1, 0, 0], t_min="1"), TypeError, "t_min"),
        (lambda: Sphere(radius=1).named("a", priority=1.5), TypeError, "priority"),
        (lambda: BALL.path_name(0.5), TypeError, "0.5"),
        (lambda: BALL.closest(np.ma.masked_array(np.ones(3), [0, 0, 1]), [1, 0, 0]), ValueError, "1 entry masked"),
        (lambda: Scene(Sphere(radius=1), units="furlong"), ValueError, "furlong"),
    ],
)
def test_what_is_no_number_is_refused(wrong, error, words):
    """Text, fractions and masked entries were converted without an error: a priority of 1.5 became 1."""
    with pytest.raises(error, match=words):
        wrong()


@pytest.mark.parametrize(
    "wrong, words",
    [
        (lambda: BALL.measure(rays=10**30), "rays"),
        (lambda: BALL.measure(seed=-1), "seed"),
        (lambda: BALL.render(size=(-1, 5)), "size"),
        (lambda: Scene(Sphere(radius=1).named("a", material="iron")), "iron"),
    ],
)
def test_messages_do_not_name_internals(wrong, words):
    """They named fields of the bindings, or showed a text of JSON that the user never wrote."""
    with pytest.raises((TypeError, ValueError, OverflowError), match=words) as caught:
        wrong()
    assert not any(internal in str(caught.value) for internal in ("How", "Style", '"shotline"', "extract"))


def test_names_beyond_the_last_are_index_errors(tmp_path):
    """`surface_name` was a panic behind an object of empty groups, and an OverflowError for large numbers."""
    nothing = {"op": "union", "args": [{"op": "group", "args": []}]}
    objects = [{"node": {"kind": "sphere", "radius": 1}}, {"node": nothing}]
    (tmp_path / "scene.json").write_text(json.dumps({"shotline": 1, "objects": objects}))
    scene = shotline.load(tmp_path / "scene.json")
    assert scene.surface_name(0) == "sphere"
    for surface in (1, 2**31, 2**40, 2**70):
        with pytest.raises(IndexError):
            scene.surface_name(surface)


def test_errors_have_the_row_of_the_ray():
    """Its number stood in the text alone."""
    d = np.tile([1.0, 0, 0], (5, 1))
    d[3] = 0
    with pytest.raises(ValueError, match="ray 3: the direction is zero") as caught:
        BALL.count([-5, 0, 0], d)
    assert caught.value.row == 3


# Meshes of other packages


def test_lines_of_meshio_are_left_out_and_quads_cut():
    """Files of gmsh hold line and vertex cells beside the triangles, and were refused."""
    cells = [SimpleNamespace(type="line", data=np.array([[0, 1]]))]
    cells += [SimpleNamespace(type="triangle", data=np.array(FACES))]
    with pytest.warns(UserWarning, match="1 line left out"):
        mesh = Mesh(SimpleNamespace(points=np.array(CORNERS, float), cells_dict={}, cells=cells))
    assert mesh.is_closed and Scene(mesh).count([0.2, 0.2, -1], [0, 0, 1]) == 2


def test_the_message_of_a_wrong_index_says_what_may_be():
    """For -1 it said that vertices are numbered from 0 to 4294967295."""
    with pytest.raises(ValueError, match="0 to 3"):
        Mesh(CORNERS, np.array(FACES) - 1)


def test_polygons_that_are_not_convex_are_cut_within():
    """Faces of any number of corners had to be cut by hand, and fans cover notches."""
    ell = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]
    sheet = Mesh(ell, [(2, 3, 4, 5, 0, 1)])
    assert Scene(sheet).count([[1.5, 1.5, -1], [0.5, 1.5, -1], [1.5, 0.5, -1]], [0, 0, 1]).tolist() == [0, 1, 1]
    assert sheet.polygons.tolist() == [0, 0, 0, 0]


def test_far_vertices_do_not_hide_a_mesh():
    """A vertex that no face uses, 1e16 away, made the mesh vanish."""
    scene = Scene(Mesh([*CORNERS, (1e16, 0, 0)], FACES))
    assert scene.crossings([0.25, 0.25, -1], [0, 0, 1]).t.tolist() == [1.0, 1.5]


# Pickling


def test_pickled_meshes_keep_polygons_and_the_note_of_welding():
    """Both were lost."""
    quad = Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
    again = pickle.loads(pickle.dumps(quad))
    assert again == quad and again.polygons.tolist() == [0, 0]
    noisy = Mesh([*CORNERS, (2.7e-17, 0, 1)], [(0, 2, 1), (0, 1, 4), (1, 2, 3), (2, 0, 3)], weld="auto")
    again = pickle.loads(pickle.dumps(noisy))
    assert noisy.is_closed and noisy.weld_note and again.weld_note == noisy.weld_note


def test_arrays_of_a_pickle_may_begin_anywhere():
    """Buffers that a cluster hands over are not aligned. Its workers refused them, and the cast never ended."""
    scene, buffers = Scene(Mesh(CORNERS, FACES)), []
    packed = pickle.dumps(scene, protocol=5, buffer_callback=buffers.append)
    shifted = [memoryview(b"x" + bytes(buffer.raw()))[1:] for buffer in buffers]
    digest = scene.content_hash
    del scene
    again = pickle.loads(packed, buffers=shifted)
    assert len(shifted) >= 2 and again.content_hash == digest
    assert again.crossings([0.25, 0.25, -1], [0, 0, 1]).t.tolist() == [1.0, 1.5]


# Queries and their columns


def test_from_inside_a_room_its_walls_can_be_asked_for():
    """`closest` was 0 and `any` True from inside, with no way to ask for surfaces only."""
    room, ray = Scene(Box(min=(-1, -1, -1), max=(1, 1, 1))), ([0, 0, 0], [1, 0, 0])
    assert room.closest(*ray, surfaces_only=True).t == 1
    assert not room.any(*ray, t_max=0.1, surfaces_only=True) and room.count(*ray, surfaces_only=True) == 1


def test_a_segment_has_one_path():
    """Parts of several paths were one segment, which had the path of the first, and later -1."""
    cell = Box(min=(0, 0, 0), max=(1, 1, 1))
    cells = Scene(Group(cell, cell.translate(1, 0, 0), cell.translate(3, 0, 0)).named("cells"))
    assert cells.segments([-1, 0.5, 0.5], [1, 0, 0]).path.tolist() == [0, 1, 2]


def test_thickness_counts_what_has_no_material():
    """Without materials it was an array of no columns."""
    ray = [-5, 0, 0], [1, 0, 0]
    assert np.asarray(BALL.thickness(*ray)).tolist() == [2.0]
    two = Scene(Sphere(radius=1).named("a"), Sphere(radius=2).translate(9, 0, 0).named("b"))
    assert np.asarray(two.thickness(*ray, by="object")).tolist() == [2.0, 4.0]


def test_boxes_of_one_union_abut_without_a_seam():
    """A ray in the face that they share saw nothing."""
    stack = Scene(Box(min=(0, 0, 0), max=(1, 1, 1)) | Box(min=(0, 0, 1), max=(1, 1, 2)))
    assert stack.crossings([-1, 0.5, 1], [1, 0, 0]).t.tolist() == [1, 2]


def test_a_scene_without_an_end_is_measured_but_for_it():
    """`measure` refused the whole scene."""
    ground = Halfspace(normal=(0, 0, 1), offset=0)
    found = Scene(ground.named("ground"), Box(min=(0, 0, 0), max=(1, 2, 3)).named("block")).measure()
    assert math.isnan(found.volume[0]) and found.volume[1] == pytest.approx(6, rel=1e-14)


def test_masses_are_in_grams():
    """The mass was the density times the volume in whatever units the scene has."""
    cube = Box(min=(0, 0, 0), max=(10, 10, 10)).named("cube", material="steel")
    scene = Scene(cube, materials={"steel": {"density": 7.8}}, units="mm")
    assert scene.measure().mass[0] == pytest.approx(7.8, rel=1e-14)


# Running


ENDLESS = """
import os, signal, threading, time
import shotline
level = shotline.Sphere(radius=1)
for _ in range(40):
    level = shotline.Group(level, level.translate(0, 0, 0))
scene = shotline.Scene(level)
def later():
    time.sleep(0.2)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=later).start()
try:
    scene.count([-5, 0.1, 0.2], [1, 0, 0])
    print("answered")
except KeyboardInterrupt:
    print("ended")
"""


def test_ctrl_c_ends_one_ray_through_2_to_the_40_spheres():
    """It was heeded between rays only, and memory grew with every sphere until the interpreter was aborted."""
    done = subprocess.run([sys.executable, "-c", ENDLESS], capture_output=True, text=True, timeout=60)
    assert done.stdout == "ended\n", done.stderr


def test_a_scene_may_be_unpickled_beside_the_first_import():
    """Threads of a new Dask worker do both at once, and each import waited for the other."""
    script = """
        import pickle, sys, threading, time
        begun = threading.Event()
        class Slow:
            def find_spec(self, name, path=None, target=None):
                if name == "shotline.appearance":
                    begun.set()
                    time.sleep(0.2)
        sys.meta_path.insert(0, Slow())
        thread = threading.Thread(target=lambda: __import__("shotline"))
        thread.start()
        begun.wait()
        print(pickle.loads(bytes.fromhex(sys.argv[1])))
        thread.join()
    """
    words = [sys.executable, "-c", textwrap.dedent(script), pickle.dumps(BALL).hex()]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == repr(BALL) and not done.stderr, done.stderr
