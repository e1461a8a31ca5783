import pickle

import numpy as np
import pytest
import shotline
from shotline import (
    Box,
    Camera,
    Cylinder,
    Difference,
    Group,
    Light,
    Mesh,
    Object,
    Scene,
    Sphere,
    Torus,
    Union,
    _native,
)
from shotline.plain_objects import plain_objects
from shotline.serialize import Serializer, _root_object, serialize

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def ts(scene, o, d):
    return scene.crossings(o, d).t.tolist()


def test_every_kind_has_a_class():
    kinds = _native.kinds()
    assert len(kinds) >= 11
    for kind, summary, parameters in kinds:
        cls = getattr(shotline, "".join(word.capitalize() for word in kind.split("_")))
        assert cls.__doc__.startswith(summary)
        assert all(f"    {name}: " in cls.__doc__ for name, *_ in parameters)
        with pytest.raises(TypeError, match="is missing"):
            cls()


def test_parameters_are_kept_and_shown():
    box = Box(min=np.array([0, 0, 0]), max=[1, 2, 3])
    assert box.min == (0.0, 0.0, 0.0) and Sphere(radius=np.float32(0.5)).radius == 0.5
    assert repr(box) == "Box(min=(0.0, 0.0, 0.0), max=(1.0, 2.0, 3.0))"
    with pytest.raises(AttributeError):
        box.radius


def test_lists_are_rows():
    corners = [(0, 0), (1, 0), (0, 1)]
    turned = shotline.Revolved(points=corners)
    assert turned.points == ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)) and turned.dphi == 360.0
    assert turned == shotline.Revolved(np.array(corners)) != shotline.Revolved(corners[::-1])
    assert repr(turned) == "Revolved(points=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), phi0=0.0, dphi=360.0)"
    assert ts(Scene(turned), (-2, 0, 0.5), (1, 0, 0)) == [1.5, 2.5]


@pytest.mark.parametrize(
    "wrong, message",
    [
        (lambda: Sphere(radius=-1), "radius is -1, but must be positive"),
        (lambda: Sphere(radius=float("nan")), "radius is .*finite"),
        (lambda: Box(min=(0, 0), max=(1, 1, 1)), "min takes 3 numbers, not 2"),
        (lambda: Box(min=(0, 0, 0), max=(1, 1, -1)), "max"),
        (lambda: shotline.Revolved([(0, 0), (1, 0)]), "points has 2 rows, but takes at least 3"),
        (lambda: shotline.Revolved([(0, 0, 0)] * 3), r"points takes rows of 2 numbers, .* not \(3, 3\)"),
        (lambda: shotline.Revolved([(0, 0), (1, 0), (0, np.nan)]), "points row 3 of 3 is .*finite"),
        (lambda: shotline.Revolved([(0, 0), (1, 0), (-1, 1)]), "points row 3 of 3 .* must not be negative"),
        (lambda: Sphere(radius=1).scale(1, 0, 1), "no factor may be zero"),
        (lambda: Sphere(radius=1).rotate(axis=(0, 0, 0), degrees=3), "no direction"),
        (lambda: Sphere(radius=1).rotate(1, 2, 3, axis=(0, 0, 1), degrees=3), "together"),
        (lambda: Sphere(radius=1).transform(np.ones((3, 4))), "singular"),
        (lambda: Sphere(radius=1).transform(np.ones((4, 4))), "last row"),
        (lambda: Sphere(radius=1).transform(np.ones((2, 2))), "shape"),
        (lambda: Union(), "at least one"),
        (lambda: Scene(Sphere(radius=1).named("a", material="steel")), "steel"),
        (lambda: Scene(Sphere(radius=1), accel="magic"), "magic"),
        (lambda: Scene(Sphere(radius=1).named("a") - Sphere(radius=2)), "object"),
        (lambda: Scene(Sphere(radius=1).part("x"), Box(min=(0, 0, 0), max=(1, 1, 1)).part("x")), "named 'x'"),
        (lambda: Camera(eye=(1, 0, 0), fov=40, height=2), "fov"),
        (lambda: Camera(eye=(0, 0, 0)), "same point"),
        (lambda: Light(), "one of"),
    ],
)
def test_invalid_values_are_errors(wrong, message):
    with pytest.raises(ValueError, match=message):
        wrong()


def test_wrong_types_are_errors():
    for wrong in [
        lambda: Sphere(r=1),
        lambda: Sphere(radius=1) | 3,
        lambda: Scene(3),
        lambda: Group(Sphere(radius=1), 3),
    ]:
        with pytest.raises(TypeError):
            wrong()


def test_operators_make_flat_chains():
    a, b, c = (Sphere(radius=1).translate(i, 0, 0) for i in range(3))
    assert isinstance(a - b - c, Difference) and len((a - b - c)._args) == 3
    assert len((a | b | c)._args) == 3 and len((a & b & c)._args) == 3
    assert len((a - (b - c))._args) == 2
    o, d = [-5, 0, 0], [1, 0, 0]
    assert ts(Scene(a | b | c), o, d) == [4, 8]
    assert ts(Scene(a & b), o, d) == [5, 6]
    assert ts(Scene(a - b), o, d) == [4, 5]


def test_transforms():
    ball = Sphere(radius=1)
    o, d = [0, 0, -10], [0, 0, 1]
    assert ts(Scene(ball.translate(0, 0, 3)), o, d) == [12, 14]
    assert ts(Scene(ball.translate((0, 0, 3)).scale(2)), o, d) == [14, 18]
    assert ts(Scene(ball.scale(1, 1, 2).translate(0, 0, 3)), o, d) == [11, 15]
    assert ts(Scene(Cylinder(radius=1, z0=0, z1=5).rotate(180, 0, 0)), o, d) == [5, 10]
    assert ts(Scene(Cylinder(radius=1, z0=0, z1=5).rotate(axis=(0, 1, 0), degrees=90)), o, d) == []
    matrix = np.eye(4)
    matrix[2, 3] = 3
    for shape in [(4, 4), (3, 4), (12,)]:
        given = matrix if shape == (4, 4) else matrix[:3].reshape(shape)
        assert ts(Scene(ball.transform(given)), o, d) == [12, 14]
    np.testing.assert_array_equal(
        ball.translate(0, 0, 1.5).scale(2).matrix, matrix[:3] * [[2, 1, 1, 1], [1, 2, 1, 1], [1, 1, 2, 1]]
    )


def test_chains_of_transforms_are_matrix_products(rng):
    """Steps in any order have NumPy's product of their matrices."""
    for _ in range(20):
        node, expected = Sphere(radius=1), np.eye(4)
        for step in rng.integers(0, 4, 4):
            v = rng.uniform(0.5, 2, 3)
            if step == 3:
                matrix = np.vstack([rng.normal(size=(3, 4)) + 2 * np.eye(3, 4), [0, 0, 0, 1]])
                node = node.transform(matrix)
            else:
                node = (node.translate, node.scale, node.rotate)[step](*v)
                alone = (Sphere(radius=1).translate, Sphere(radius=1).scale, Sphere(radius=1).rotate)[step](*v)
                matrix = np.vstack([alone.matrix, [0, 0, 0, 1]])
            expected = matrix @ expected
        np.testing.assert_allclose(node.matrix, expected[:3], rtol=1e-13, atol=1e-13)
        scene = Scene(node)
        np.testing.assert_allclose(scene.path_transform(0), expected[:3], rtol=1e-12, atol=1e-12)


def test_shared_nodes_are_stored_once():
    ball = Sphere(radius=1)
    level = Group(ball, ball.translate(3, 0, 0))
    for i in range(30):
        level = Group(level, level.translate(7.0 * 2**i, 0, 0))
    scene = Scene(level)
    assert scene.stats["virtual_leaves"] == 2**31 and scene.stats["memory_bytes"] < 100_000
    assert int(scene.count([-5, 0, 0], [1, 0, 0], t_max=13.5)) == 6


def test_names_of_paths():
    arm = Group(Sphere(radius=1).part("ball"), Torus(R=3, r=0.5).translate(0, 0, 1))
    scene = Scene(Group(arm, arm.translate(0, 0, 9)).named("robot"))
    names = [scene.path_name(i) for i in range(scene.path_count)]
    assert names == [
        "robot/group[0]/ball[0]",
        "robot/group[0]/torus[1]",
        "robot/group[1]/ball[0]",
        "robot/group[1]/torus[1]",
    ]
    assert scene.path_transform(3)[2, 3] == 10
    assert scene.surface_name(int(scene.closest([0, 0, -5], [0, 0, 1]).surface)) == "sphere"
    for wrong in (lambda: scene.path_name(4), lambda: scene.path_name(-1), lambda: scene.surface_name(99)):
        with pytest.raises(IndexError):
            wrong()


def test_objects_can_be_transformed():
    ball = Sphere(radius=1).named("ball", priority=2)
    scene = Scene(ball.translate(0, 0, 5), Group(ball, ball.translate(9, 0, 0)).named("both"))
    assert scene.object_names == ["ball", "both", "ball"]
    assert [scene.path_name(i) for i in range(3)] == ["ball", "both/ball[0]", "both/ball[1]"]
    assert (
        float(scene.closest([9, 0, -5], [0, 0, 1]).t) == 4 and int(scene.closest([9, 0, -5], [0, 0, 1]).object) == 2
    )
    assert ball.name == "ball" and ball.priority == 2 and ball.material is None and ball.node.radius == 1


def test_deep_nesting():
    node = Sphere(radius=1)
    for i in range(3000):
        other = Sphere(radius=1).translate(0.001 * i, 0, 0)
        node = Union(node, other) if i % 2 else Difference(node, other.translate(0, 9, 0))
    assert Scene(node).stats["leaves"] == 3001


def test_meshes_accept_any_arrays():
    expected = ts(Scene(Mesh(CORNERS, FACES)), [0.1, 0.2, -1], [0, 0, 1])
    assert expected == pytest.approx([1, 1.7])
    points = np.zeros((8, 6), ">f8")[::2, ::2]
    points[...] = CORNERS
    for vertices in (points, np.asarray(CORNERS, np.float32), np.asfortranarray(np.asarray(CORNERS, float))):
        for faces in (np.asarray(FACES, np.int64), np.asarray(FACES, np.uint8), np.asarray(FACES, ">i4")):
            assert ts(Scene(Mesh(vertices, faces)), [0.1, 0.2, -1], [0, 0, 1]) == expected
    mesh = Mesh(CORNERS, FACES)
    assert mesh.is_closed and mesh.why_open is None
    assert (
        mesh.vertices.tolist() == np.array(CORNERS, float).tolist()
        and mesh.faces.tolist() == np.array(FACES).tolist()
    )
    again = pickle.loads(pickle.dumps(mesh))
    assert again.weld_note is None
    welded = Mesh(CORNERS, FACES, weld=0.001)
    assert "no vertices were merged" in welded.weld_note
    assert pickle.loads(pickle.dumps(welded)).weld_note == welded.weld_note
    assert again.vertices.tobytes() == mesh.vertices.tobytes() and again.faces.tobytes() == mesh.faces.tobytes()


@pytest.mark.parametrize(
    "vertices, faces, error, message",
    [
        (CORNERS, [(0, 1, 9)], ValueError, r"face 0 is \[0, 1, 9\], but vertices are numbered from 0 to 3"),
        (CORNERS, [(0, 1, 2), (0, 1, -1)], ValueError, r"face 1 is \[0, 1, -1\], .* from 0 to 3"),
        (CORNERS, [(0.0, 1.0, 2.0)], TypeError, "integers"),
        (CORNERS, [], ValueError, "no face"),
        ([(0, 0), (1, 1)], FACES, ValueError, r"\(n, 3\)"),
        ([(0, 0, 0), (1, 0, 0), (0, np.nan, 0), (0, 0, 1)], FACES, ValueError, "vertex 2"),
    ],
)
def test_invalid_meshes_are_errors(vertices, faces, error, message):
    with pytest.raises(error, match=message):
        Mesh(vertices, faces)


def test_open_meshes_have_hits_but_no_inside():
    mesh = Mesh(CORNERS, FACES[:3])
    assert not mesh.is_closed and "open" in mesh.why_open
    scene = Scene(mesh)
    assert int(scene.count([0.1, 0.2, -1], [0, 0, 1])) == 2
    with pytest.raises(ValueError, match="not closed"):
        scene.segments([0.1, 0.2, -1], [0, 0, 1])


class Bag:
    def __init__(self, **attributes):
        vars(self).update(attributes)


def test_meshes_of_other_packages():
    v, f = np.array(CORNERS, float), np.array(FACES)

    def tensor(array):
        return Bag(numpy=lambda: array)

    others = [
        Bag(vertices=v, faces=f),
        Bag(vertices=v, triangles=f),
        Bag(vertex=Bag(positions=tensor(v)), triangle=Bag(indices=tensor(f))),
        Bag(points=v, cells_dict={"triangle": f}),
    ]
    assert all(Mesh(other).is_closed for other in others)
    with pytest.raises(TypeError, match="Bag"):
        Mesh(Bag())


def test_meshes_of_trimesh_and_meshio():
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    ball = trimesh.creation.icosphere(subdivisions=2)
    assert Mesh(ball).is_closed and len(Mesh(ball).faces) == 320
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    same = Mesh(meshio.Mesh(ball.vertices, [("triangle", ball.faces)]))
    assert same.vertices.tobytes() == Mesh(ball).vertices.tobytes() and same.is_closed


def test_sharing_does_not_change_results(rng):
    """Random scenes with shared nodes have the same crossings as the same scenes without sharing."""
    crossings = 0
    for _ in range(40):
        # A recipe is (kind, indices of its child recipes, parameters). Scenes are built with and without sharing.
        recipes = [("sphere", [], rng.uniform(0.5, 1, 1)), ("box", [], rng.uniform(0.5, 1, 3))]
        for _ in range(rng.integers(4, 12)):
            kind = rng.choice(["union", "difference", "intersection", "group", "place", "place", "part"])
            count = 1 if kind in ("place", "part") else rng.integers(2, 4)
            recipes.append((kind, rng.integers(0, len(recipes), count).tolist(), rng.uniform(-1, 1, 6)))

        def build(number, memo, recipes=recipes):
            if memo is not None and number in memo:
                return memo[number]
            kind, children, values = recipes[number]
            args = [build(child, memo) for child in children]
            if kind == "sphere":
                node = Sphere(radius=values[0])
            elif kind == "box":
                node = Box(min=-values, max=values)
            elif kind == "place":
                node = args[0].rotate(*(90 * values[:3])).translate(*values[3:])
            elif kind == "part":
                node = args[0].part(f"part {number}") if memo is not None else args[0]
            else:
                kinds = {
                    "union": Union,
                    "difference": Difference,
                    "group": Group,
                    "intersection": shotline.Intersection,
                }
                node = kinds[kind](args)
            if memo is not None:
                memo[number] = node
            return node

        top = len(recipes) - 1
        shared, apart = Scene(build(top, {}).named("it")), Scene(build(top, None).named("it"))
        o = rng.normal(size=(100, 3)) * 5
        aim = rng.normal(size=(100, 3)) - o
        a, b = shared.crossings(o, aim), apart.crossings(o, aim)
        assert shared.path_count == apart.path_count
        assert a.ray_splits.tolist() == b.ray_splits.tolist() and a.entering.tolist() == b.entering.tolist()
        assert np.abs(a.t - b.t).max(initial=0) < 1e-12
        crossings += len(a.t)
    assert crossings > 2000


def test_generated_names_avoid_given_names():
    """Nodes that need a name in the scene file get an unused one."""
    balls = [Sphere(radius=1 + i / 100) for i in range(50)]
    child = Box(min=(0, 0, 0), max=(1, 1, 1)).part("sphere_3")
    scene = Scene(Group([*(node for ball in balls for node in (ball, ball.translate(9, 0, 0))), child]))
    names = [scene.path_name(i) for i in range(scene.path_count)]
    assert len(set(names)) == 101 and names[:2] == ["object0/sphere[0]", "object0/sphere[1]"]
    assert names[-1] == "object0/sphere_3[100]" and names[4] == "object0/sphere_4[4]"


def test_nodes_are_immutable_and_pickle():
    node = (Sphere(radius=1).translate(1, 2, 3) - Box(min=(0, 0, 0), max=(1, 1, 1)).part("b")).named(
        "x", priority=3
    )
    again = pickle.loads(pickle.dumps(node))
    assert Scene(again) == Scene(node) and repr(again) == repr(node)
    for change in [lambda: setattr(Sphere(radius=1), "radius", 2), lambda: setattr(node, "name", "y")]:
        with pytest.raises(AttributeError):
            change()


def test_objects_contain_objects():
    ball = Sphere(radius=1).named("ball", material="lead")
    row = Group(ball.translate(-2, 0, 0), ball.translate(2, 0, 0))
    tank = Box(min=(-5, -5, -5), max=(5, 5, 5)).named("tank", contents=[row], clip=True).translate(10, 0, 0)
    scene = Scene(tank, materials={"lead": {"density": 11.3}})
    segments = scene.segments([0, 0, 0], [1, 0, 0])
    assert segments.length.tolist() == [2.0, 2.0, 2.0, 2.0, 2.0]
    paths = [scene.path_name(path) for path in segments.path.tolist()]
    balls = [f"tank/group[0]/ball[{i}]" for i in range(2)]
    assert paths == ["tank", balls[0], "tank", balls[1], "tank"]
    assert scene.objects_at([8, 0, 0])[1].tolist() == [0, 1]
    moved = scene.with_moved("tank", [[1, 0, 0, 20], [0, 1, 0, 0], [0, 0, 1, 0]])
    assert moved.segments([0, 0, 0], [1, 0, 0]).t_in.tolist() == [15.0, 17.0, 19.0, 21.0, 23.0]
    assert Object(tank, "other").clip and len(Object(tank, "other").contents) == 1
    with pytest.raises(ValueError, match=r"the contents of 'a' are objects and groups of them: name Sphere"):
        Sphere(radius=2).named("a", contents=[Sphere(radius=1)])


def test_contents_that_stick_out_of_what_clips_them_do_not_count():
    rod = Box(min=(-3, -1, -1), max=(3, 1, 1)).named("rod")
    for clip, length in [(True, 4.0), (False, 6.0)]:
        scene = Scene(Box(min=(-2, -2, -2), max=(2, 2, 2)).named("shell", contents=[rod], clip=clip))
        segments = scene.segments([-9, 0, 0], [1, 0, 0])
        assert (segments.length.tolist(), segments.object.tolist()) == ([length], [1])
        assert scene.contains([[-2.5, 0, 0], [0, 0, 0]]).tolist() == [not clip, True]


def test_objects_of_one_solid_each_are_written_as_all_others_are():
    moved = Torus(R=2, r=0.5).rotate(0, 90, 0).translate(0.1, -0.0, 1e300).scale(2)
    plain = [
        Sphere(radius=0.1).translate(1.0, 2.0, 3.0).named('a "quoted" ä', material="lead", priority=3),
        Box(min=(0, 0, 0), max=(1, 1, 1)).named("box", clip=True),
        Sphere(radius=5),
        moved,
        moved.node.named("torus").translate(4, 5, 6),
    ]
    assert plain_objects(list(map(_root_object, plain))) is None
    assert plain_objects(list(map(_root_object, plain[:4]))) is not None
    roots = [_root_object(node) for node in plain]
    serializer = Serializer(roots)
    expected = [serializer.of(root) for root in roots]
    # The last two share a torus, so it gets a name; apart from that they are written in the same way.
    assert serialize(plain, ["lead"], []).objects == expected
    assert serialize(plain[:4], ["lead"], []).objects == expected[:3] + [
        expected[3].replace('{"ref": "torus"', '{"kind": "torus", "R": 2.0, "r": 0.5')
    ]


def test_parameters_are_the_same_however_they_are_given():
    for equal in [Torus(r=0.5, R=2.0), Torus(2, 0.5), Torus(R=np.float32(2), r=0.5)]:
        assert equal == Torus(R=2.0, r=0.5) and repr(equal) == "Torus(R=2.0, r=0.5)"
    assert Sphere(radius=1).translate(1e308, 1e308, 0.0).steps == (("translate", (1e308, 1e308, 0.0)),)
    for wrong in [float("nan"), float("inf")]:
        with pytest.raises(ValueError, match="r is (nan|inf), but must be finite"):
            Torus(R=2.0, r=wrong)
        with pytest.raises(ValueError, match="translate is .*, but must be finite"):
            Sphere(radius=1).translate(0.0, wrong, 0.0)
