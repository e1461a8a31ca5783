"""`shotline view` in a browser: what it shows is what the other commands say."""

import base64
import io
import json

import numpy as np
import pytest
from command import ROOT, run
from PIL import Image
from viewer import NEEDS_CHROMIUM, chromium, until, viewer

pytestmark = NEEDS_CHROMIUM

SIZE = (720, 400)
MATERIALS = {"steel": {"color": [0.6, 0.65, 0.7]}, "wax": {"color": [0.9, 0.7, 0.3]}}
EYE = [6, -10, 12]
SCENE = {
    "shotline": 1,
    "units": "mm",
    "materials": MATERIALS,
    "camera": {"eye": EYE, "target": [0, 0, 0], "up": [0, 0, 1], "fov": 30},
    "objects": [
        {
            "name": "block",
            "material": "steel",
            "node": {
                "op": "difference",
                "args": [
                    {"kind": "box", "min": [-3, -2, -2], "max": [3, 2, 2]},
                    {"kind": "cylinder", "radius": 1.25, "z0": -3, "z1": 3},
                ],
            },
        },
        {"name": "ball", "material": "wax", "node": {"kind": "sphere", "radius": 0.75}},
        {
            "name": "beads",
            "node": {
                "op": "group",
                "args": [{"kind": "sphere", "radius": 0.2, "translate": [x / 2, -3, -1.5]} for x in range(-6, 7)],
            },
        },
    ],
}


@pytest.fixture(scope="module")
def browser():
    with chromium(SIZE) as driver:
        yield driver
        log = [entry["message"] for entry in driver.get_log("browser")]
        assert not [line for line in log if "SEVERE" in line or "Uncaught" in line], log


@pytest.fixture
def page(browser, tmp_path):
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps(SCENE))
    with viewer(scene) as address:
        browser.get(address)
        yield Page(browser, scene, address)


class Page:
    """The page, as a user meets it."""

    def __init__(self, browser, scene, address):
        self.browser, self.scene, self.address = browser, scene, address
        self.picture()

    def one(self, selector):
        return self.browser.find_element("css selector", selector)

    def all(self, selector):
        return self.browser.find_elements("css selector", selector)

    def script(self, code, *arguments):
        return self.browser.execute_script(code, *arguments)

    def names(self):
        """The names in the tree, read at once: it may change at any time."""
        return self.script("return [...document.querySelectorAll('#tree .what')].map((node) => node.textContent)")

    def press(self, *keys):
        self.one("#pane-0 .overlay").send_keys(*keys)

    def overlay(self):
        from selenium.webdriver import ActionChains

        return ActionChains(self.browser), self.one("#pane-0 .overlay")

    def is_final(self):
        return self.script("return document.body.dataset.state === 'final'")

    def picture(self, pane=0):
        """The finished picture as an array of bytes: rows, columns, red, green and blue."""
        until(self.is_final, "a finished picture")
        address = self.script(f"return document.querySelector('#pane-{pane} .picture').toDataURL()")
        with Image.open(io.BytesIO(base64.b64decode(address.split(",")[1]))) as pixels:
            return np.asarray(pixels.convert("RGB"))

    def change(self, act):
        """Acts, and waits for the picture that follows."""
        before = self.picture()
        act()
        until(lambda: not np.array_equal(self.picture(), before), "another picture")
        return self.picture()

    def rendered(self, *flags):
        """What `shotline render` makes of the scene in the size of the picture."""
        height, width, _ = self.picture().shape
        out = self.scene.with_name("out.png")
        made = run("render", self.scene, "-o", out, "--size", f"{width}x{height}", "--samples", 16, *flags)
        assert made.returncode == 0, made.stderr
        with Image.open(out) as pixels:
            return np.asarray(pixels.convert("RGB"))

    def choose(self, select, value):
        from selenium.webdriver.support.ui import Select

        Select(self.one(select)).select_by_visible_text(value)

    def shoot(self, origin, direction):
        """Types a ray, and returns the rows of its table."""
        from selenium.webdriver.common.keys import Keys

        if not self.one("#ray").is_displayed():
            actions, overlay = self.overlay()
            actions.click(overlay).perform()
            until(self.one("#ray").is_displayed, "the table")
        for field, text in (("#ray-from", origin), ("#ray-along", direction)):
            self.one(field).clear()
            self.one(field).send_keys(text)
        before = self.script("return state.ray")
        self.one("#ray-from").send_keys(Keys.ENTER)
        until(lambda: self.script("return state.ray") != before, "another ray")
        return [row.text for row in self.all("#crossings tbody tr")]


def test_pictures_are_those_of_render(page):
    assert np.array_equal(page.picture(), page.rendered())
    for look in ("normal", "depth", "xray"):
        page.change(lambda look=look: page.choose("#look", look))
        assert np.array_equal(page.picture(), page.rendered("--look", look)), look


def test_the_camera_follows_mouse_and_keys(page):
    first = page.picture()
    actions, overlay = page.overlay()
    turned = page.change(lambda: actions.drag_and_drop_by_offset(overlay, 60, 15).perform())
    assert page.script("return state.camera.up") == [0, 0, 1]
    page.change(lambda: page.press("+"))
    distance = page.script("return length(subtract(state.camera.eye, state.camera.target))")
    assert abs(distance - np.linalg.norm(EYE) / 1.15) < 1e-9
    top = page.change(lambda: page.press("5"))
    assert np.array_equal(top, page.rendered("--view", "top"))
    assert np.array_equal(page.change(lambda: page.press("f")), first)
    assert not np.array_equal(turned, first)


def test_a_click_shows_the_crossings_of_its_ray(page):
    height, width, _ = page.picture().shape
    actions, overlay = page.overlay()
    actions.click(overlay).perform()
    rows = until(lambda: page.all("#crossings tbody tr"), "a table")
    # The ray through the middle of the picture goes through the target.
    ray = page.script("return [state.ray.origin, state.ray.direction]")
    expected = -np.array(EYE) / np.linalg.norm(EYE)
    across = 0.5 * (30 / height) * np.pi / 180
    assert ray[0] == EYE and np.abs(ray[1] - expected).max() < across, width
    told = run(
        "shoot",
        page.scene,
        f"--from={','.join(map(repr, ray[0]))}",
        f"--dir={','.join(map(repr, ray[1]))}",
        "--json",
    )
    crossings = json.loads(told.stdout)["crossings"]
    assert len(rows) == len(crossings) > 3
    for row, crossing in zip(rows, crossings, strict=True):
        assert crossing["object"] in row.text and ("in" if crossing["entering"] else "out") in row.text
    assert (
        f"{len(rows)} crossings" in page.one("#ray-summary").text and "mm inside" in page.one("#ray-summary").text
    )
    assert float(page.one("#ray").get_attribute("data-ms")) < 5000


def test_a_ray_can_be_typed(page):
    rows = page.shoot("-10, 0, 0", "1, 0, 0")
    assert [row.split()[:4] for row in rows] == [
        ["1", "7", "in", "block"],
        ["2", "8.75", "out", "block"],
        ["3", "9.25", "in", "ball"],
        ["4", "10.75", "out", "ball"],
        ["5", "11.25", "in", "block"],
        ["6", "13", "out", "block"],
    ]
    page.one("#ray-along").clear()
    page.one("#ray-along").send_keys("0 0 0\n")
    until(page.one("#trouble").is_displayed, "a message")
    assert "not all 0" in page.one("#trouble").text


def test_the_steps_of_an_accelerator(page):
    page.shoot("-10, 0, 0", "1, 0, 0")
    for accel in ("bvh", "grid", "bsp"):
        page.choose("#accel", accel)
        if not page.one("#steps").is_displayed():
            page.one("#trace-button").click()
        flags = ["--from=-10,0,0", "--dir=1,0,0", "--accel", accel, "--trace", "--json"]
        steps = json.loads(run("shoot", page.scene, *flags).stdout)["trace"]["steps"]
        until(lambda steps=steps: len(page.all("#steps li")) == len(steps), f"the steps of {accel}")
    # Some step has lines, and they are drawn.
    with_lines = page.script("return state.steps.findIndex((step) => step.lines.length)")
    assert with_lines >= 0
    ink = "return document.querySelector('#pane-0 .overlay').toDataURL()"
    plain = page.script(ink)
    page.script(f"document.querySelectorAll('#steps li')[{with_lines}].click()")
    assert page.script(ink) != plain
    assert page.one("#trace-number").text == f"{with_lines + 1} of {len(steps)}"
    page.press(".")
    assert page.one("#trace-number").text == f"{min(with_lines + 2, len(steps))} of {len(steps)}"


def test_objects_are_found_hidden_and_shown_alone(page):
    first = page.picture()
    names = page.names()
    assert names == ["block", "ball", "beads"]
    hidden = page.change(page.one("#tree [aria-label='Hide block']").click)
    assert np.array_equal(hidden, page.rendered("--hide", "block"))
    assert page.one("#chosen-text").text == "1 hidden"
    alone = page.change(page.one("#tree [aria-label='Show block alone']").click)
    assert np.array_equal(alone, page.rendered("--only", "block"))
    assert np.array_equal(page.change(page.one("#show-all").click), first)
    page.one("#search").send_keys("BAL")
    until(lambda: page.names() == ["ball"], "what is searched")
    page.one("#search").clear()
    page.one("#search").send_keys("nothing")
    until(lambda: "no object" in page.one("#tree").text, "that nothing is found")


def test_planes_cut_the_scene_open(page):
    cut = page.change(page.one("#clip-add").click)
    assert page.one(".clip output").text == "without z > 0 mm"
    assert np.array_equal(cut, page.rendered("--clip", "0,0,1,0"))
    # The handle is dragged along the normal.
    x, y, _ = page.script("return project(state.camera, sizeOf(panes[0]), planeHandle(state.planes[0]))")
    overlay = page.one("#pane-0 .overlay")
    actions, _ = page.overlay()
    middle = [overlay.size["width"] / 2, overlay.size["height"] / 2]
    actions.move_to_element_with_offset(overlay, round(x - middle[0]), round(y - middle[1])).click_and_hold()
    page.change(lambda: actions.move_by_offset(-20, -10).release().perform())
    height = page.script("return state.planes[0].height")
    assert height != 0 and -2 <= height <= 2
    page.change(page.one(".clip button[title='Remove the cut']").click)
    assert np.array_equal(page.picture(), page.rendered())


def test_a_slice_is_shown(page):
    page.one("#slice-button").click()
    width = "return document.getElementById('slice-picture').naturalWidth"
    until(lambda: page.script(width), "a slice")
    before = page.one("#slice-picture").get_attribute("src")
    page.choose("#slice-axis", "x")
    until(lambda: page.one("#slice-picture").get_attribute("src") != before, "another slice")
    assert page.one("#slice-height").get_attribute("value") == "0"


def test_the_cost_of_two_accelerators_side_by_side(page):
    page.one("#compare").click()
    until(page.one("#pane-1").is_displayed, "a second picture")
    page.choose("#versus", "brute")
    until(lambda: page.one("#pane-1 figcaption").text == "brute", "the other accelerator")
    left, right = page.picture(0), page.picture(1)
    assert page.one("#pane-0 figcaption").text == "bvh" and not np.array_equal(left, right)
    for picture, accel in ((left, "bvh"), (right, "brute")):
        assert np.array_equal(picture, page.rendered("--look", "cost", "--accel", accel)), accel


def test_the_page_follows_the_file(page):
    changed = json.loads(json.dumps(SCENE))
    changed["objects"][1]["name"] = "pearl"
    page.scene.write_text(json.dumps(changed))
    until(lambda: page.names() == ["block", "pearl", "beads"], "the new name")
    page.scene.write_text(json.dumps(SCENE).replace('"radius": 0.75', '"radius": -1'))
    until(page.one("#trouble").is_displayed, "what is wrong")
    assert "radius" in page.one("#trouble").text and "scene.json:1:" in page.one("#trouble").text
    page.scene.write_text(json.dumps(SCENE))
    until(lambda: not page.one("#trouble").is_displayed(), "that all is well")
    assert np.array_equal(page.picture(), page.rendered())


def test_a_scene_that_has_no_picture_may_get_one(browser, tmp_path):
    scene = tmp_path / "scene.json"
    nodes = [{"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}, {"kind": "sphere", "radius": 1}]
    texts = [json.dumps({"shotline": 1, "objects": [{"name": "thing", "node": node}]}) for node in nodes]
    scene.write_text(texts[0])
    with viewer(scene) as address:
        browser.get(address)
        until(browser.find_element("id", "trouble").is_displayed, "that there is nothing to frame")
        scene.write_text(texts[1])
        until(lambda: browser.execute_script("return document.body.dataset.state === 'final'"), "a picture")
        assert not browser.find_element("id", "trouble").is_displayed()


def test_narrow_pages_and_dark_ones(page):
    metrics = {"width": 390, "height": 700, "deviceScaleFactor": 1, "mobile": True}
    page.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    try:
        page.browser.get(page.address)
        until(page.is_final, "a picture")
        assert page.script("return document.documentElement.scrollWidth") <= 390
        light = page.script("return getComputedStyle(document.body).backgroundColor")
        page.one("#theme").click()
        assert page.script("return getComputedStyle(document.body).backgroundColor") != light
    finally:
        page.one("#theme").click()
        metrics |= {"width": SIZE[0], "height": SIZE[1], "mobile": False}
        page.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def test_shipped_scenes_and_infinite_ones(browser):
    for name in ("section", "roth"):
        with viewer(ROOT / "scenes" / f"{name}.json") as address:
            browser.get(address)
            until(lambda: browser.execute_script("return document.body.dataset.state"), name)
            assert not browser.find_element("id", "trouble").is_displayed()
