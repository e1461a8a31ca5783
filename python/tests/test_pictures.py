import io
import struct

import numpy as np
import pytest
from shotline import Box, Camera, Image, Light, Scene, Sphere

SCENE = Scene(Sphere(radius=1).named("ball"), Box(min=(-3, -3, -1.2), max=(3, 3, -1.1)))


def test_pictures_are_arrays(tmp_path):
    picture = SCENE.render(size=(40, 30), samples=1)
    assert isinstance(picture, Image) and picture.shape == (30, 40, 3) and picture.dtype == np.uint8
    assert SCENE.render(size=(40, 30), samples=1, background="transparent").shape == (30, 40, 4)
    assert picture.std() > 5 and (picture[:5] != 0).any() and isinstance(picture.mean(), float)
    png = picture._repr_png_()
    assert png.startswith(b"\x89PNG") and struct.unpack(">II", png[16:24]) == (40, 30)
    picture.save(tmp_path / "ball.png")
    assert (tmp_path / "ball.png").read_bytes() == png
    Image(picture[::-1, ::2]).save(str(tmp_path / "half.png"))
    picture.save(tmp_path / "ball.JPEG")
    jpeg = (tmp_path / "ball.JPEG").read_bytes()
    assert jpeg.startswith(b"\xff\xd8") and jpeg.endswith(b"\xff\xd9")
    assert picture[0]._repr_png_() is None
    pyplot = pytest.importorskip("matplotlib.pyplot", reason="matplotlib is not installed")
    assert (np.rint(pyplot.imread(io.BytesIO(png)) * 255).astype(np.uint8)[..., :3] == picture).all()


def test_drawings_and_objects_that_are_seen_through():
    options = {"camera": "iso", "size": (60, 40), "samples": 1, "background": "white"}
    plain = SCENE.render(**options)
    drawn = SCENE.render(**options, edges=True)
    assert (drawn < 40).all(axis=2).sum() > 20 > (plain < 40).all(axis=2).sum()
    assert (SCENE.render(**options, opacity={"ball": 0.3}) != plain).any()
    assert (SCENE.render(**options, opacity={"*": 1}) == plain).all()
    cut = SCENE.render(**options, clip="x=0.2")
    assert (SCENE.render(**options, clip="x=0.2", hatch=True) != cut).any()


def test_the_same_picture_for_any_threads():
    one = SCENE.render(size=(80, 60), threads=1)
    assert (SCENE.render(size=(80, 60), threads=3) == one).all()


def test_cameras_and_looks():
    front = SCENE.render(
        Camera(eye=(0, -5, 0), fov=40), size=(40, 40), samples=1, background="#000000", look="normal"
    )
    assert (front[20, 20] > 0).any() and (front[0, 0] == 0).all()
    flat = SCENE.render(
        Camera(eye=(0, 0, 9), up=(0, 1, 0), height=20), size=(40, 40), samples=1, background="black", look="depth"
    )
    assert (flat[20, 20] > 0).any() and (flat[0, 0] == 0).all()
    lights = [Light(direction=(0, 0, -1)), Light(ambient=True, intensity=0.2)]
    lit = Scene(Sphere(radius=1), lights=lights, camera=Camera(eye=(0, -5, 0), fov=40)).render(
        size=(40, 40), samples=1
    )
    assert lit[12, 20].sum() > lit[28, 20].sum()
    for look in ("thickness", "xray", "cost"):
        assert SCENE.render(look=look, size=(20, 20), samples=1).std() > 1


@pytest.mark.parametrize(
    "wrong, error, message",
    [
        (lambda: SCENE.render(look="x"), ValueError, "lit, normal"),
        (lambda: SCENE.render(lighting="x"), ValueError, "sharp, plain, soft"),
        (lambda: SCENE.render(counter="x"), ValueError, "boxes"),
        (lambda: SCENE.render(background="red"), ValueError, "#336699"),
        (lambda: SCENE.render(clip=["x"]), ValueError, "NX,NY,NZ,D"),
        (
            lambda: SCENE.render(edges=True, look="xray"),
            ValueError,
            "'xray' has no edges.* choose 'lit', 'normal' or",
        ),
        (lambda: SCENE.render(opacity={"ball": 1.5}), ValueError, "opacity of 'ball' is 1.5, but must be from 0"),
        (lambda: SCENE.render(opacity={"ghost": 0.5}), ValueError, "opacity: no object is named 'ghost'"),
        (
            lambda: SCENE.render(opacity={"ball": 0.5}, look="depth"),
            ValueError,
            "'depth' shows no objects that are",
        ),
        (lambda: SCENE.render(opacity=0.5), TypeError, "opacity maps names to numbers"),
        (lambda: SCENE.render(opacity={"ball": "x"}), TypeError, "opacity.*ball"),
        (lambda: SCENE.render(hatch=True), ValueError, "nothing to hatch: give a plane"),
        (lambda: SCENE.render(hatch=True, clip="x=0", look="depth"), ValueError, "'depth' hatches no cuts"),
        (lambda: SCENE.render(hatch=1), TypeError, "hatch must be True or False"),
        (lambda: SCENE.render(edges=2), TypeError, "edges must be True or False"),
        (lambda: SCENE.render(hide="ghost"), ValueError, "no object is named 'ghost'; scene.object_names"),
        (lambda: SCENE.render(hide=[1]), TypeError, "a name in hide"),
        (lambda: SCENE.render(hide="*", only="*"), ValueError, "either hide or only"),
        (lambda: SCENE.render(clip=[(0, 0, 0, 1)]), ValueError, "normal"),
        (lambda: SCENE.render(size=(0, 3)), ValueError, "0x3"),
        (lambda: SCENE.render(samples=0), ValueError, "samples"),
        (lambda: SCENE.render(Camera(eye=(0, 0, 0), fov=30)), ValueError, "same point"),
        (lambda: SCENE.render(size=(2, 2)).save("/no/such/folder/x.png"), OSError, "folder"),
        (lambda: SCENE.render(size=(2, 2)).save("x.gif"), ValueError, "png, .jpg or"),
        (
            lambda: SCENE.render(size=(2, 2), background="transparent").save("x.jpg"),
            ValueError,
            "JPEG has no trans",
        ),
        (lambda: Image(np.zeros((3, 3))), ValueError, "uint8"),
    ],
)
def test_invalid_arguments_are_errors(wrong, error, message):
    with pytest.raises(error, match=message):
        wrong()


def test_pictures_are_cut_open():
    camera = Camera(eye=(0, -5, 0), fov=40)

    def depth(scene, **options):
        return scene.render(camera, size=(20, 20), samples=1, look="depth", **options)

    half = Scene(Sphere(radius=1) & Box(min=(-2, 0, -2), max=(2, 2, 2)))
    for clip in ([(0, -1, 0, 0)], "0,-1,0,0", ["y=3", (0, -2, 0, 0.0)]):
        assert (depth(Scene(Sphere(radius=1)), clip=clip) == depth(half)).all()
    assert (depth(half) != depth(Scene(Sphere(radius=1)))).any()


def test_objects_are_left_out():
    camera = Camera(eye=(0, -5, 0), fov=40)
    ball, cube = Sphere(radius=1), Box(min=(1.2, -1, -1), max=(2, 1, 1))
    hall = Box(min=(-3, -3, -3), max=(3, 3, 3)).named(
        "hall", contents=[ball.named("ball"), cube.named("cube")], clip=True
    )

    def depth(scene, **options):
        return scene.render(camera, size=(20, 20), samples=1, look="depth", **options)

    both = depth(Scene(ball, cube))
    # What encloses all others is left out unless objects are chosen.
    assert (depth(Scene(hall)) == both).all() and (depth(Scene(hall), hide="ha*") == both).all()
    assert (depth(Scene(hall), only=["ball", "cube"]) == both).all()
    assert (depth(Scene(hall), only="ball") == depth(Scene(ball))).all()
    assert (depth(Scene(hall), hide=["hall", "ball"]) == depth(Scene(cube))).all()
    assert (depth(Scene(hall), only="hall") != both).any()


def test_html_trees():
    text = SCENE._repr_html_()
    assert "ball" in text and "radius=1" in text and text.count("<ul>") == text.count("</ul>")
    many = Scene([Sphere(radius=1).named(f"<{i}>").translate(i, 0, 0) for i in range(100)])
    assert "... 80 more" in many._repr_html_() and "&lt;1&gt;" in many._repr_html_()


def test_rays_are_drawn():
    pytest.importorskip("matplotlib", reason="matplotlib is not installed").use("agg")
    ax = SCENE.plot_ray([0, 0, 5], [0, 0, -1])
    assert [label.get_text() for label in ax.get_yticklabels()] == ["ball", "object1"]
    assert sorted((bar.get_x(), bar.get_width()) for bar in ax.patches) == [(4.0, 2.0), pytest.approx((6.1, 0.1))]
    assert SCENE.plot_ray([0, 0, 5], [0, 0, 1]) is not ax
    inside = SCENE.plot_ray([0, 0, 0], [0, 0, -1], ax=ax)
    assert inside is ax
    with pytest.raises(ValueError, match="one ray, not 2"):
        SCENE.plot_ray([[0, 0, 5]] * 2, [0, 0, 1])


def test_standard_views_are_named():
    scene = Scene(Box(min=(0, 0, 0), max=(4, 1, 2)).named("box"))
    front = scene.render("front", size=(40, 30), look="normal", samples=1)
    assert (front != scene.render("iso", size=(40, 30), look="normal", samples=1)).any()
    # Twice as wide as high.
    drawn = (front != front[0, 0]).any(axis=2)
    assert drawn.any(axis=0).sum() == pytest.approx(2 * drawn.any(axis=1).sum(), abs=2)
    with pytest.raises(ValueError, match='there is no view "side": the views are front, back'):
        scene.render("side")
    with pytest.raises(TypeError, match="camera must be a Camera or the name of a view"):
        scene.render(3)
