"""The page's half of the picture in a notebook, in a browser, with a model in place of that of a notebook."""

import pytest
from command import ROOT
from viewer import NEEDS_CHROMIUM, chromium, until

MODEL = """
const [code, png] = arguments, done = arguments[arguments.length - 1];
const listeners = {};
window.told = [];
window.answer = (picture) => {
  model.values.picture = picture;
  listeners["change:picture"]?.();
  listeners["msg:custom"]?.({ kind: "drawn" });
};
const model = {
  values: { width: 320, height: 240, picture: new Uint8Array(png) },
  get: (name) => model.values[name],
  send: (message) => told.push(message),
  on: (name, listener) => { listeners[name] = listener; },
  off: (name) => { delete listeners[name]; },
};
window.listeners = listeners;
import(URL.createObjectURL(new Blob([code], { type: "text/javascript" }))).then((module) => {
  window.end = module.default.render({ model, el: document.body });
  done();
});
"""
# One grey pixel.
PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010800000000"
    "3a7e9b550000000a49444154789c63680000008200814b1e8b5d0000000049454e44ae426082"
)


@pytest.fixture(scope="module")
def page():
    if NEEDS_CHROMIUM.args[0]:
        pytest.skip(NEEDS_CHROMIUM.kwargs["reason"])
    with chromium((600, 400)) as driver:
        driver.get("about:blank")
        code = (ROOT / "python" / "shotline" / "widget.js").read_text()
        driver.execute_async_script(MODEL, code, list(PNG))
        yield driver


def told(page, count):
    until(lambda: page.execute_script("return told.length") >= count, f"{count} messages")
    return page.execute_script("return told")


def test_what_the_user_does_is_told_when_the_last_picture_has_come(page):
    from selenium.webdriver import ActionChains, Keys

    picture = page.find_element("css selector", "img")
    assert picture.size["width"] == 320
    ActionChains(page, duration=0).move_to_element(picture).click_and_hold().move_by_offset(30, 10).perform()
    ActionChains(page, duration=0).move_by_offset(5, 0).release().perform()
    first = told(page, 1)
    # The second move waits until the picture of the first has come, and then says that nothing moves any more.
    assert [first[0][name] for name in ("turn", "shift", "zoom", "moving")] == [[30, 10], [0, 0], 1, True]
    assert len(first) == 1
    page.execute_script("answer(new Uint8Array(arguments[0]))", list(PNG))
    rest = told(page, 2)[1:]
    assert sum(move["turn"][0] for move in rest) == 5
    until(lambda: page.execute_script("answer(new Uint8Array()); return told.at(-1).moving") is False, "stillness")
    count = page.execute_script("return told.length")
    ActionChains(page).send_keys("+", Keys.ARROW_LEFT).perform()
    keys = told(page, count + 1)[count:]
    assert keys[0]["zoom"] == 1.2
    until(lambda: page.execute_script("answer(new Uint8Array()); return told.at(-1).moving") is False, "stillness")
    assert sum(move["turn"][0] for move in page.execute_script("return told")[count:]) == -20
    page.execute_script("window.end()")
    assert page.execute_script("return Object.keys(listeners).length") == 0
