"""Invalid arguments that were once accepted silently, or refused in terms of something that the user never wrote."""

import math
import pickle
import re
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import shotline
from shotline import Box, Camera, Cylinder, Detector, Group, Light, Material, Mesh, Scene, Sphere, Tube, Union

BALL = Scene(Sphere(radius=1).named("ball"))
MASKED = np.ma.masked_array(np.ones((4, 3)), mask=[[0, 0, 0]] * 3 + [[0, 0, 1]])
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]


@pytest.mark.parametrize(
    "wrong, error, message",
    [
        # Masked entries, which have no value.
        (lambda: BALL.closest(MASKED, [1, 0, 0]), ValueError, "o has 1 entry masked"),
        (lambda: BALL.count([0, 0, 0], list(MASKED)), ValueError, "d has 1 entry masked"),
        (lambda: BALL.contains(MASKED), ValueError, "p has 1 entry masked"),
        (lambda: Box(min=MASKED[3], max=(2, 2, 2)), ValueError, "min has 1 entry masked"),
        (lambda: Sphere(radius=1).translate(MASKED[3]), ValueError, "translate has 1 entry masked"),
        (lambda: Sphere(radius=1).transform(MASKED.T), ValueError, "the matrix has 1 entry masked"),
        (lambda: Mesh(MASKED, [(0, 1, 2)]), ValueError, "vertices has 1 entry masked"),
        (lambda: Mesh(CORNERS, np.ma.masked_equal([(0, 1, 2), (0, 2, 3)], 3)), ValueError, "faces has 1 entry"),
        # Values of the wrong type, size or count.
        (lambda: Sphere(radius="1"), TypeError, "radius must be a real number, not '1'"),
        (lambda: Sphere(radius=1j), TypeError, "radius must be a real number, not 1j"),
        (lambda: Sphere(radius=None), TypeError, "radius must be a real number, not None"),
        (lambda: Sphere(radius=[1]), TypeError, "radius must be one number, not an array"),
        (lambda: Box(min=("0", "0", "0"), max=(1, 1, 1)), TypeError, "min must be real numbers, not strings"),
        (lambda: Sphere(radius=10**400), ValueError, "radius .*float64"),
        (lambda: Sphere(radius=1).scale("2"), TypeError, "scale must be a real number"),
        (lambda: Sphere(radius=1).scale(1, 2), ValueError, "scale takes one factor or three, not 2"),
        (lambda: BALL.closest("abc", "d"), TypeError, "o must be an array of real numbers, not 'abc'"),
        (lambda: Sphere(radius=1).translate("abc"), TypeError, "translate must be 3 real numbers, not 'abc'"),
        (lambda: BALL.closest([0, 0, -5], [0, 0, 1], t_min="1"), TypeError, "t_min must be a real number"),
        (lambda: BALL.closest([0, 0, -5], [0, 0, 1], t_max=[1, 2]), TypeError, "t_max must be one number"),
        (lambda: BALL.closest([0, 0, -5], [0, 0, 1], threads=1.5), TypeError, "threads must be a whole number"),
        (lambda: BALL.closest([[0, 0], [0, 0, 1]], [0, 0, 1]), ValueError, "o has rows of several lengths"),
        (lambda: Sphere(radius=1).named("a", priority=1.5), TypeError, "priority must be a whole number, not 1.5"),
        (lambda: Sphere(radius=1).named("a", priority=2**31), ValueError, "priority is 2147483648, but must be"),
        (lambda: Sphere(radius=1).named(5), TypeError, "the name of an object must be a string, not int"),
        (lambda: Sphere(radius=1).named("\ud800"), ValueError, "surrogate"),
        (lambda: Sphere(radius=1).part(None), TypeError, "the name of a part must be a string"),
        (lambda: Sphere(radius=1).named("a", Material(mu=1)), TypeError, r"material \(the name of one\)"),
        (lambda: Union(Sphere(radius=1), accel="bhv"), ValueError, "did you mean 'bvh'"),
        (lambda: BALL.path_name(0.5), TypeError, "path must be a whole number, not 0.5"),
        (lambda: BALL.surface_name("0"), TypeError, "surface must be a whole number"),
        # Numbers of surfaces and paths that do not exist.
        (lambda: BALL.surface_name(2**40), IndexError, "no such surface"),
        (lambda: BALL.path_name(2**70), IndexError, "no such path"),
        (lambda: BALL.path_transform(-1), IndexError, "no such path: -1"),
        (lambda: BALL.path_transform(7), IndexError, "no such path: 7"),
        (lambda: BALL.path_name(7), IndexError, "no such path: 7"),
        (lambda: BALL.surface_name(99), IndexError, "no such surface: 99"),
        # Messages once named internals: How.0, How.1, Style.0 ...
        (lambda: BALL.measure(rays=10**30), ValueError, "^rays is 1000000000000000000000000000000, but must be"),
        (lambda: BALL.measure(seed=-1), ValueError, "^seed is -1, but must be from 0"),
        (lambda: BALL.measure(objects="ball"), TypeError, "objects is a list"),
        (lambda: BALL.measure(objects=[2**40]), IndexError, "no such object"),
        (lambda: BALL.render(size=(-1, 5)), ValueError, "the width in size is -1"),
        (lambda: BALL.render(size=(2, 2), background="redd"), ValueError, 'background is "redd": expected studio'),
        (lambda: BALL.save("/nodir/a.json"), OSError, "/nodir/a.json: cannot be written: there is no such folder"),
        (lambda: Mesh(CORNERS, [(0, 2, 1)], weld=-1), ValueError, "^-1 is not a distance to weld within"),
        (lambda: Mesh(CORNERS, [(0, 2, 1)], weld=100), ValueError, "after welding within 100 the mesh has no face"),
        (lambda: BALL.render(size=640), TypeError, r"size is width and height in pixels.*, not 640"),
        (lambda: BALL.render(size=(2, 2), samples=-1), ValueError, "samples is -1"),
        (lambda: BALL.render(size=(2, 2), look=None), TypeError, "look must be a string"),
        (lambda: BALL.render(3, size=(2, 2)), TypeError, "camera must be a Camera"),
        (lambda: BALL.segments([0, 0, -5], [0, 0, 1], overlaps=0), TypeError, "overlaps must be a string"),
        (lambda: BALL.measure(overlaps=None), TypeError, "overlaps must be a string"),
        (lambda: Sphere(radius=1).rotate((0, 0, 1), 90), ValueError, r"rotate\(axis=\(x, y, z\), degrees=angle\)"),
        (lambda: Sphere(1, 2), TypeError, r"Sphere\(radius=...\): 2 parameters are too many"),
        (
            lambda: Tube(rmin=1, rmax=2, z0=0),
            TypeError,
            r"Tube\(rmin=\.\.\., rmax=\.\.\., z0=\.\.\., z1=\.\.\., phi0=0, dphi=360\): z1 is missing",
        ),
        (lambda: Sphere(1, radius=2), TypeError, r"Sphere\(radius=...\): radius is given twice"),
        (lambda: Sphere(radius=1, center=(0, 0, 1)), TypeError, r"placed with .translate\(x, y, z\)"),
        (lambda: setattr(Sphere(radius=1), "radius", 2), AttributeError, "a Sphere cannot be changed"),
        (lambda: Detector(center=(0, 0, 0), u=(1, 0, 0), v=(0, 1, 0), shape=5), TypeError, "rows and columns"),
        (
            lambda: Detector(center=(0, 0, 0), u=(1, 0, 0), v=(0, 1, 0), shape=(2.5, 3)),
            TypeError,
            "the number of rows in shape",
        ),
        (
            lambda: Detector(center=(0, 0, 0), u=(1, 0, 0), v=(0, 1, 0), shape=(0, 4)),
            ValueError,
            "the number of rows in shape is 0, but must be from 1",
        ),
        (lambda: Detector.facing((0, 0, 9), (0, 0, 0), pixel="1", shape=(2, 2)), TypeError, "pixel must be a real"),
        (
            lambda: Detector.facing((0, 0, 9), (0, 0, 0), pixel=-1, shape=(2, 2)),
            ValueError,
            "pixel is -1, but must be",
        ),
        # Cameras, lights and materials.
        (lambda: Camera(eye=(0, 0)), ValueError, "eye takes 3 numbers, not 2"),
        (lambda: Camera(eye=(0, 0, 5), fov="40"), TypeError, "fov must be a real number"),
        (lambda: Camera(eye=(0, 0, 5), fov=180), ValueError, "fov is 180, but must be above 0 and below 180"),
        (lambda: Camera(eye=(0, 0, 5), fov=-5), ValueError, "fov is -5, but must be above 0 and below 180"),
        (lambda: Camera(eye=(0, 0, 5), height=0), ValueError, "height is 0, but must be above 0"),
        (lambda: Light(direction=(0, 0, 0)), ValueError, "direction of the light is zero"),
        (lambda: Material(mu=-1), ValueError, "mu is -1, but must be at least 0"),
        (lambda: Material(density="7.8"), TypeError, "density must be a real number"),
        (lambda: Material(color=(0, 0, 2)), ValueError, "color is .*from 0 to 1"),
        (lambda: Scene(Sphere(radius=1), materials={"a": {"nu": 1}}), TypeError, "material 'a'.*'nu'.*mu, density"),
        (lambda: Scene(Sphere(radius=1), materials={"a": 3}), TypeError, "material 'a'.*not int"),
        (lambda: Scene(Sphere(radius=1), camera=3), TypeError, "camera must be a Camera, not int"),
        (lambda: Scene(Sphere(radius=1), lights=[3]), TypeError, "lights are Light objects, not int"),
        (lambda: Scene(Sphere(radius=1), units="furlong"), ValueError, "units is 'furlong'.*nm, um, mm"),
        (lambda: Scene(Sphere(radius=1), units="Mm"), ValueError, "did you mean 'mm'"),
        (lambda: Scene(Sphere(radius=1), accel="magic"), ValueError, "accel is 'magic'"),
    ],
)
def test_errors_name_the_argument(wrong, error, message):
    with pytest.raises(error, match=message) as raised:
        wrong()
    assert not re.search(r"How\.|Style\.|Sight\.|\"shotline\"|inhomogeneous|__init__|unpack", str(raised.value))


@pytest.mark.parametrize(
    "wrong, words",
    [
        (lambda: Scene(Sphere(radius=1).named("a", "iron")), ["object 'a'", "'iron'", "materials={'iron': ...}"]),
        (
            lambda: Scene(Sphere(radius=1).named("a", "irn"), materials={"iron": {}, "wood": {}}),
            ["object 'a'", "'irn'", "did you mean 'iron'?"],
        ),
        (
            lambda: Scene(Sphere(radius=1).named("a", "gold"), materials={"iron": {}, "wood": {}}),
            ["its materials are 'iron', 'wood'"],
        ),
        (
            lambda: Scene((Mesh(CORNERS, [(0, 2, 1)]) - Sphere(radius=1)).named("cut")),
            ["object 'cut'", "a mesh that is not closed"],
        ),
        (
            lambda: Scene(Group(Group(Sphere(radius=1).scale(1e-9, 1, 1)).scale(1e-9, 1, 1)).named("flat")),
            ["object 'flat'"],
        ),
    ],
)
def test_errors_do_not_quote_the_generated_scene_file(wrong, words):
    with pytest.raises(ValueError) as raised:
        wrong()
    message = str(raised.value)
    assert all(word in message for word in words), message
    assert not re.search(r"\"|\d+:\d+|\^\^", message), message


def test_all_wrong_materials_are_reported_together():
    with pytest.raises(ValueError, match="'a'.*'iron'[\\s\\S]*'b'.*'wood'"):
        Scene(Sphere(radius=1).named("a", "iron"), Sphere(radius=1).named("b", "wood"))


def test_numbers_of_any_type_are_accepted():
    for radius in (1, 1.0, np.float32(1), np.array(1), Fraction(1), Decimal(1), np.ma.masked_array(1.0)):
        assert Sphere(radius=radius).radius == 1.0
    assert Sphere(radius=1).named("a", priority=np.int8(3)).priority == 3
    assert len(BALL.measure(rays=1e2, method="rays").rays) == 1
    hits = BALL.closest(np.ma.masked_array([[0, 0, -5.0]]), [[0, 0, Fraction(1, 2)]], t_min=np.float32(0))
    assert hits.t.tolist() == [8.0]


def test_different_objects_of_the_same_name_cause_a_warning():
    ball, box = Sphere(radius=1), Box(min=(0, 0, 0), max=(1, 1, 1))
    with pytest.warns(shotline.DuplicateNameWarning, match="'a'") as caught:
        Scene(ball.named("a"), Group(box.named("a"), ball.named("b")).named("c"))
    assert caught[0].filename == __file__


def test_instances_of_one_object_cause_no_warning(recwarn):
    bolt = Sphere(radius=1).named("bolt")
    Scene(bolt, bolt.translate(5, 0, 0), Sphere(radius=1).named("bolt"), Group(bolt.scale(2)).named("more"))
    assert len(recwarn) == 0


def test_equal_nodes_are_equal_and_hash_alike():
    def build(radius=1.0, name="a", degrees=90.0):
        ball = Sphere(radius=radius)
        part = (ball | ball.rotate(axis=(0, 0, 1), degrees=degrees)) - Cylinder(radius=0.1, z0=-2, z1=2)
        return Group(part.part("p"), Mesh(CORNERS, [(0, 2, 1)]).scale(2)).named(name, "iron", 2)

    assert Sphere(radius=1) == Sphere(radius=1) and hash(Sphere(radius=1)) == hash(Sphere(radius=1))
    assert build() == build() and hash(build()) == hash(build()) and len({build(), build()}) == 1
    others = [build(radius=2), build(name="b"), build(degrees=91), build().node, build().translate(0, 0, 0)]
    assert all(build() != other for other in others) and len({build(), *others}) == 6
    assert Sphere(radius=1) != 1 and Mesh(CORNERS, [(0, 2, 1)]) != Mesh(CORNERS, [(0, 1, 2)])
    assert Sphere(radius=1) != Cylinder(radius=1, z0=0, z1=1) and Group(Sphere(radius=1)) != Union(Sphere(radius=1))
    again = pickle.loads(pickle.dumps(build()))
    assert again == build() and hash(again) == hash(build())


def test_equality_of_deep_and_shared_nodes_is_quick():
    def nest():
        node = Sphere(radius=1)
        for i in range(3000):
            node = Group(node, node.translate(i, 0, 0))
        return node

    assert nest() == nest() and hash(nest()) == hash(nest())


def test_cameras_have_the_defaults_of_scene_files():
    assert Camera(eye=(0, -5, 0)) == Camera(eye=(0, -5, 0), target=(0, 0, 0), up=(0, 0, 1), fov=40)
    assert Camera(eye=(1, 2, 9), target=(1, 2, 0)).up == (0, 1, 0)
    assert Camera(eye=(0, -5, 0), height=3).fov is None
    same = Scene(Sphere(radius=1), camera=Camera(eye=(0, 0, 9)))
    assert Scene(Sphere(radius=1), camera=Camera(eye=[0, 0, 9], up=np.array([0, 1, 0]), fov=40)) == same


def test_parameters_are_known_to_help_and_completion():
    import inspect

    assert "radius" in dir(Sphere(radius=1))
    assert str(inspect.signature(Cylinder)).startswith("(radius: ")
    assert "z1" in inspect.signature(Cylinder).parameters
    assert math.isclose(Cylinder(**dict.fromkeys(["radius", "z1"], 1.0), z0=0).radius, 1.0)
