"""Chains of building methods, in any order, compared with NumPy's products of matrices."""

from random import Random

import numpy as np
import pytest
from shotline import Box, Difference, Group, Intersection, Scene, Sphere, Union

TURN = [[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 0]]
# Origin and direction, in homogeneous coordinates, of a line that crosses the cube [0, 1]^3 at t = 1 and t = 2.
LINE = np.array([[0.3, 0.4, -1.0, 1.0], [0.1, 0.2, 1.0, 0.0]])


def centre(node):
    return np.round(Scene(node).bounds.mean(axis=0), 9).tolist()


def test_a_named_node_that_is_placed_again_keeps_both_placements():
    ball, cube = Sphere(radius=1), Box(min=(0, 0, 0), max=(1, 1, 1))
    for node, expected in [
        (ball.translate(1, 0, 0).named("a").translate(10, 0, 0), [11, 0, 0]),
        (ball.translate(5, 0, 0).named("a").rotate(0, 0, 180), [-5, 0, 0]),
        (ball.transform(TURN).named("a").transform(TURN), [5, 5, 0]),
        (cube.scale(2).named("a").scale(3), [3, 3, 3]),
        (ball.translate(1, 0, 0).named("a").transform(TURN), [5, 1, 0]),
        (ball.transform(TURN).named("a").translate(1, 0, 0), [6, 0, 0]),
    ]:
        assert centre(node) == expected == centre(Group(node))


def test_objects_named_again_are_renamed():
    ball = Sphere(radius=1)
    first = ball.translate(1, 0, 0).named("a", material="iron", priority=3)
    for node in [
        first.named("b"),
        first.part("p").named("b"),
        first.translate(1, 0, 0).part("p").translate(-1, 0, 0).named("b"),
    ]:
        scene = Scene(node, materials={"iron": {}})
        assert scene.object_names == ["b"] and centre(node.named("b", "iron").node) == [1, 0, 0]
        assert (node.material, node.priority) == ("iron", 3)
    again = first.named("b", material="wood", priority=0)
    assert (again.material, again.priority) == ("wood", 0)


def test_an_object_that_is_a_part_is_still_an_object():
    bolt = Sphere(radius=1).named("bolt").part("m8")
    scene = Scene(bolt.translate(5, 0, 0), Group(bolt, bolt.translate(9, 0, 0)).named("more"))
    assert scene.object_names == ["bolt", "more", "bolt"]
    assert [scene.path_transform(i)[0, 3] for i in range(3)] == [5, 0, 9]


@pytest.mark.parametrize("kind", [Union, Intersection, Difference])
def test_objects_as_operands_are_refused_on_construction(kind):
    ball = Sphere(radius=1)
    for node in [ball.named("a"), ball.named("a").part("p").scale(2), Group(ball, ball.named("a"))]:
        with pytest.raises(ValueError, match=f"the object 'a' cannot be an operand of a {kind.__name__}"):
            kind(ball, node)


def rotation(axis, degrees):
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross, angle = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.radians(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def affine(linear, offset=(0, 0, 0)):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, offset
    return matrix


ALWAYS = ["translate", "rotate", "about", "scale", "transform", "named", "part", "group", "shared"]
SHAPES = [*ALWAYS, "or", "and", "sub", "union"]
IDENTITY = np.eye(4)


def step(random, node, count):
    """Applies a random building method to a node; returns the new node and the matrix of the method."""
    x, y, z = v = [random.uniform(-2, 2) for _ in range(3)]
    kind = random.choice(SHAPES if node._object is None else ALWAYS)
    if kind == "translate":
        return node.translate(*v), affine(np.eye(3), v)
    if kind == "rotate":
        about = [rotation(axis, 60 * a) for axis, a in zip(np.eye(3), v, strict=True)]
        return node.rotate(60 * x, 60 * y, 60 * z), affine(about[2] @ about[1] @ about[0])
    if kind == "about":
        return node.rotate(axis=v, degrees=90 * x), affine(rotation(v, 90 * x))
    if kind == "scale":
        factors = [0.5 + abs(x)] if random.random() < 0.5 else [a + (0.5 if a > 0 else -0.5) for a in v]
        return node.scale(*factors), affine(np.diag(factors if len(factors) == 3 else factors * 3))
    if kind == "transform":
        linear = [[(i == j) + random.uniform(-0.4, 0.4) for j in range(3)] for i in range(3)]
        matrix = affine(linear, v)
        return node.transform(matrix[: random.choice([3, 4])]), matrix
    # None of these changes the set of points near the cube.
    same = {
        "named": lambda: node.named(f"n{count}", random.choice([None, "iron"]), priority=random.randrange(-3, 3)),
        "part": lambda: node.part(f"n{count}"),
        "group": lambda: Group(node),
        "shared": lambda: Group(node, node.translate(1e4, 0, 0)),
        "or": lambda: node | node,
        "and": lambda: node & node,
        "sub": lambda: node - Sphere(radius=1e-3).translate(1e4, x, y),
        "union": lambda: Union(node, node, accel="bvh"),
    }
    return same[kind](), IDENTITY


def test_ten_thousand_chains_of_all_methods_are_matrix_products():
    """An affine map of both the cube and the line does not change the t of the crossings."""
    random = Random(11)
    expected = np.array([1.0, 2.0])
    named_between = 0
    for number in range(10_000):
        node, matrix = Box(min=(0, 0, 0), max=(1, 1, 1)), IDENTITY
        for count in range(random.randint(1, 6)):
            node, placed = step(random, node, count)
            matrix = placed @ matrix
        o, d = LINE[0] @ matrix.T, np.append(LINE[1, :3], 0.0) @ matrix.T
        t = Scene(node, materials={"iron": {}}).crossings(o[:3], d[:3], t_max=3).t
        assert t.shape == (2,) and np.abs(t - expected).max() < 1e-9, f"chain {number}: {t}, {node!r}"
        named_between += node._object is not None
    assert named_between > 2000
