import numpy as np
import pytest
import shotline
from shotline import Box, Group, Scene, Sphere, Torus


def at(x, y, z):
    return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z]]


def test_moved_scenes_equal_scenes_built_with_the_new_transform(sample_rays):
    def built(*offset):
        arm = Group(Sphere(radius=1), Torus(R=2, r=0.4).transform(at(*offset)))
        return Scene(
            Group(arm, arm.translate(6, 0, 0), Sphere(radius=1.5).translate(0, 0, 4) - Sphere(radius=1)).named(
                "robot"
            )
        )

    scene = built(0, 0, 1)
    before = scene.crossings(*sample_rays)
    for offset in [(0, 0, 2), (1, 2, 3), (0.1, 0.2, 0.3)]:
        moved = scene.with_moved("robot/group[1]/torus[1]", at(*offset))
        for a, b in zip(moved.crossings(*sample_rays), built(*offset).crossings(*sample_rays), strict=True):
            assert a.tobytes() == b.tobytes()
        assert moved == built(*offset) and moved != scene
        for a, b in zip(scene.crossings(*sample_rays), before, strict=True):
            assert a.tobytes() == b.tobytes()
    chain = scene
    for i in range(5):
        chain = chain.with_moved("robot/group[1]", at(i, 0, 0)).with_moved("robot", at(0, 0, i))
    np.testing.assert_array_equal(chain.path_transform(2), at(4, 0, 4))
    assert float(chain.closest([4, 0, 20], [0, 0, -1]).t) == 15


def test_invalid_moves_are_errors():
    scene = Scene(Sphere(radius=1).named("ball"))
    with pytest.raises(ValueError, match="no path begins with 'bal'"):
        scene.with_moved("bal", at(0, 0, 1))
    with pytest.warns(shotline.DuplicateNameWarning):
        twins = Scene(Sphere(radius=1).named("a"), Sphere(radius=1).translate(5, 0, 0).named("a"))
    with pytest.raises(ValueError, match="'a' stands for several things, as 2 objects have one name"):
        twins.with_moved("a", at(0, 0, 1))
    with pytest.raises(ValueError, match="singular"):
        scene.with_moved("ball", np.zeros((3, 4)))
    with pytest.raises(ValueError, match="shape"):
        scene.with_moved("ball", np.eye(3))
    assert float(scene.closest([0, 0, -3], [0, 0, 1]).t) == 2


def test_an_unknown_path_is_told_which_was_meant():
    def hall(*contents):
        return Scene(Box(min=(-9, -9, -9), max=(9, 9, 9)).named("hall", contents=contents))

    cart, pillar = Sphere(radius=1).named("cart"), Sphere(radius=1).translate(5, 0, 0).named("pillar")
    for wrong in ("hall/cart", "hall/crt[1]"):
        with pytest.raises(ValueError, match=r"no path begins with .*; did you mean 'hall/cart\[1\]'\?$"):
            hall(pillar, cart).with_moved(wrong, at(0, 0, 1))
    with pytest.raises(ValueError, match=r"; there are hall/cart\[0\], hall/cart\[1\]$"):
        hall(cart.translate(5, 0, 0), cart).with_moved("hall/cart", at(0, 0, 1))
    with pytest.raises(ValueError, match="; the scene is not so deep$"):
        hall().with_moved("hall/cart", at(0, 0, 1))
