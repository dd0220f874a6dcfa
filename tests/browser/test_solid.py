"""The solid of a setup sheet in a browser: turned, moved, zoomed and clicked."""

import base64
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pypdfium2
import pytest
from PIL import Image

from tests.browser.conftest import Browser, mouse
from tests.runs import call, wait_until

DSTV = Path(__file__).resolve().parents[2] / "samples" / "dstv"
NO_WEBGL = (
    "const own = HTMLCanvasElement.prototype.getContext;"
    "HTMLCanvasElement.prototype.getContext = function (kind, ...more) {"
    "return kind === 'webgl' ? null : own.call(this, kind, ...more); };"
)


@pytest.fixture
def without_webgl(browser: Browser) -> Iterator[None]:
    found = browser.driver.execute_cdp_cmd(
        "Page.addScriptToEvaluateOnNewDocument", {"source": NO_WEBGL}
    )
    yield
    browser.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", found)


def seen(browser: Browser) -> Any:
    """What the canvas shows, as an array of colours."""
    url = browser.run("return document.querySelector('#solid-view canvas').toDataURL()")
    return np.array(Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).convert("RGB"))


def letters(browser: Browser) -> set[str]:
    """The faces whose letters are to be seen."""
    return set(browser.run(
        "return [...document.querySelectorAll('.face-letter')].filter((e) => !e.hidden)"
        ".map((e) => e.textContent)"
    ))  # fmt: skip


def place(browser: Browser) -> tuple[float, float]:
    """The middle of the view, in pixels of the window."""
    x, y = browser.run(
        "const e = document.getElementById('solid-view'); e.scrollIntoView({block: 'center'});"
        "const r = e.getBoundingClientRect(); return [r.left + r.width / 2, r.top + r.height / 2]"
    )
    return float(x), float(y)


def drag(browser: Browser, dx: float, dy: float, modifiers: int = 0) -> None:
    x, y = place(browser)
    mouse(browser, "mousePressed", x, y, modifiers=modifiers, buttons=1)
    mouse(browser, "mouseMoved", x + dx / 2, y + dy / 2, modifiers=modifiers, buttons=1)
    mouse(browser, "mouseMoved", x + dx, y + dy, modifiers=modifiers, buttons=1)
    mouse(browser, "mouseReleased", x + dx, y + dy, modifiers=modifiers)


def test_it_is_drawn_and_turns_by_mouse_and_by_keys(browser: Browser, folder: Path) -> None:
    browser.open(folder / "bar.html")
    assert browser.run("return document.getElementById('solid-view').dataset.drawn") == "webgl"
    first = seen(browser)
    paper = (first == 255).all(axis=2)
    assert 0.02 < 1.0 - paper.mean() < 0.9
    assert letters(browser) == {"v", "o"}
    drag(browser, 470, 0)  # half round
    assert letters(browser) == {"h", "o"}
    assert (seen(browser) != first).any()
    browser.run("document.getElementById('solid-view').focus()")
    for _ in range(10):
        browser.keys("\ue015")  # arrow down: from above
    assert "u" not in letters(browser)
    pitch = browser.run("return Sheet.solid.pitch")
    for _ in range(20):
        browser.keys("\ue013")  # arrow up
    assert browser.run("return Sheet.solid.pitch") == pytest.approx(pitch - 2.0, abs=0.01)
    assert "u" in letters(browser)
    assert browser.complaints == []


def test_it_moves_and_zooms_and_comes_back(browser: Browser, folder: Path) -> None:
    browser.open(folder / "plate.html")
    scale = "return Sheet.solid.scale"
    target = "return Sheet.solid.target"
    fitted, middle = browser.run(scale), browser.run(target)
    drag(browser, 60, 0, modifiers=8)  # shift
    assert browser.run(target) != middle
    assert browser.run("return Sheet.solid.yaw") == pytest.approx(-0.45)
    x, y = place(browser)
    browser.run("document.activeElement.blur()")
    mouse(browser, "mouseWheel", x, y, deltaX=0, deltaY=-100, button="none")
    assert browser.run(scale) == fitted  # the page scrolls
    mouse(browser, "mousePressed", x, y, buttons=1)
    mouse(browser, "mouseReleased", x, y)
    x, y = place(browser)
    mouse(browser, "mouseWheel", x, y, deltaX=0, deltaY=-100, button="none")
    assert browser.run(scale) > fitted
    browser.click("button[data-solid=in]")
    browser.click("button[data-solid=fit]")
    assert browser.run(scale) == pytest.approx(fitted)
    assert browser.run(target) == middle
    for key, grows in (("+", True), ("-", False)):
        before = browser.run(scale)
        browser.run("document.getElementById('solid-view').focus()")
        browser.keys(key)
        assert (browser.run(scale) > before) is grows


def test_an_operation_shows_its_hole_and_a_hole_its_operation(
    browser: Browser, folder: Path
) -> None:
    browser.open(folder / "bar.html")
    work = [213, 94, 0]
    buttons = browser.run(
        "return [...document.querySelectorAll('td button')].map((e) => Number(e.dataset.line))"
    )
    faces = browser.run("return Sheet.data.bores.map((b) => [b.line, b.face])")
    for face in "vo":
        line = next(number for number, one in faces if one == face)
        browser.click(f"td button[data-line='{line}']")
        assert browser.run("return Sheet.solid.line") == line
        assert face in letters(browser)
        colours = seen(browser).reshape(-1, 3).astype(int)
        hues = colours / np.maximum(colours.max(axis=1, keepdims=True), 1)
        lit = np.abs(hues - np.array(work) / 213).max(axis=1) < 0.06
        lit &= colours[:, 0] > 60
        assert 20 < lit.sum() < 20_000
        view = browser.run(
            "const r = document.getElementById('solid-view').getBoundingClientRect();"
            "return [r.top, r.bottom, innerHeight]"
        )
        assert view[0] >= -1
        assert view[1] <= view[2] + 1
    assert line in buttons
    # A click on the hole itself: its wall is seen beside the middle of the view.
    at = browser.run(
        "const s = Sheet.solid; for (const p of s.shown()) { const at = s.projected(p);"
        "for (let t = 0; t < p.n; t++) { if (p.line[t] !== arguments[0]) continue;"
        "const [x, y] = [0, 1].map((k) => (at[9 * t + k] + at[9 * t + 3 + k] + at[9 * t + 6 + k])"
        " / 3); if (s.lineAt(x, y) === arguments[0]) return [x, y]; } } return null", line,
    )  # fmt: skip
    assert at is not None
    browser.click("#first")
    place(browser)
    left, top = browser.run(
        "const r = document.getElementById('solid-view').getBoundingClientRect();"
        "return [r.left, r.top]"
    )
    mouse(browser, "mousePressed", left + at[0], top + at[1], buttons=1)
    mouse(browser, "mouseReleased", left + at[0], top + at[1])
    assert browser.run("return Sheet.trace.lineAt(Sheet.time)") == line
    assert browser.run("return document.querySelector('tr.now') !== null")


def test_pieces_are_shown_one_by_one(browser: Browser, folder: Path) -> None:
    browser.open(folder / "bar.html")
    names = browser.run(
        "return [...document.querySelectorAll('button[data-piece]')].map((e) => e.textContent)"
    )
    assert names[:4] == ["all", "trim", "C1", "T1"]
    whole = browser.run("return Sheet.solid.scale")
    browser.click("button[data-piece='2']")
    assert browser.run("return Sheet.solid.scale") > 3 * whole
    assert browser.run("return Sheet.solid.shown().map((p) => p.mark)") == ["T1"]
    pressed = "return document.querySelector('button[data-piece][aria-pressed=true]').textContent"
    assert browser.run(pressed) == "T1"


def test_a_mirrored_part_is_seen_to_be_another(
    browser: Browser, folder: Path, tmp_path: Path
) -> None:
    """The holes of the flanges of the channel counted from the other edge: another picture."""
    text = (DSTV / "channel.nc1").read_text(encoding="utf-8")
    mirrored = tmp_path / "mirrored.nc1"
    mirrored.write_text(text.replace("     45.00     14.00", "     30.00     14.00"))
    pages = []
    for path in (DSTV / "channel.nc1", mirrored):
        page = tmp_path / f"{path.stem}.html"
        words = ["report", str(path), "--machine", "beamline", "-o", str(page)]
        assert call(*words).exit_code == 0
        browser.open(page)
        browser.run("Sheet.solid.pitch = 1.57; Sheet.solid.yaw = 0; Sheet.solid.fit()")
        pages.append(seen(browser))
    assert (pages[0] != pages[1]).any()


def test_without_webgl_there_is_a_still_picture(
    browser: Browser, folder: Path, without_webgl: None
) -> None:
    browser.open(folder / "plate.html")
    assert browser.run("return document.getElementById('solid-view').dataset.drawn") == "still"
    still = seen(browser)
    paper = (still == 255).all(axis=2)
    assert 0.05 < 1.0 - paper.mean() < 0.9
    drag(browser, 300, 0)
    assert (seen(browser) == still).all()
    assert browser.complaints == []


def test_the_still_picture_is_that_of_webgl(
    browser: Browser, folder: Path, without_webgl: None
) -> None:
    browser.open(folder / "plate.html")
    still = (seen(browser) == 255).all(axis=2)
    browser.driver.execute_async_script(
        "HTMLCanvasElement.prototype.getContext = own;"
        "const old = document.querySelector('#solid-view canvas'), made = old.cloneNode();"
        "old.replaceWith(made);"
        "Sheet.space(JSON.parse(document.getElementById('solid').textContent)).then(arguments[0])"
    )
    assert browser.run("return document.getElementById('solid-view').dataset.drawn") == "webgl"
    drawn = (seen(browser) == 255).all(axis=2)
    assert (still != drawn).mean() < 0.01


def test_a_browser_that_cannot_unpack_it_says_so(
    browser: Browser, folder: Path, tmp_path: Path
) -> None:
    text = (folder / "plate.html").read_text(encoding="utf-8")
    page = tmp_path / "old.html"
    page.write_text(text.replace("DecompressionStream", "NoSuchStream"), encoding="utf-8")
    browser.open(page)
    assert "too old to unpack the solid" in browser.text("solid-view")
    browser.keys(" ")
    assert browser.run("return Sheet.playing") is True
    browser.run("Sheet.play(false)")


def test_in_the_dark_and_on_paper_it_has_their_ground(browser: Browser, folder: Path) -> None:
    try:
        for feature, ground in (("dark", [18, 23, 29]), ("light", [255, 255, 255])):
            media = {"features": [{"name": "prefers-color-scheme", "value": feature}]}
            browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
            browser.open(folder / "plate.html")
            assert seen(browser)[2, 2].tolist() == ground
        media = {"media": "print", "features": [{"name": "prefers-color-scheme", "value": "dark"}]}
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
        browser.open(folder / "plate.html")
        assert seen(browser)[2, 2].tolist() == [255, 255, 255]
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": []})


def test_a_printer_has_it_too(browser: Browser, folder: Path) -> None:
    """Some browsers print no WebGL, so that the page paints its picture over it on paper."""
    browser.open(folder / "plate.html")
    assert browser.run("return document.querySelector('#solid-view .printed')") is None
    shown = "return getComputedStyle(document.querySelector('#solid-view .printed')).display"
    same = (
        "const [gl, copy] = document.querySelectorAll('#solid-view canvas');"
        "const pen = document.createElement('canvas').getContext('2d');"
        "[pen.canvas.width, pen.canvas.height] = [gl.width, gl.height]; pen.drawImage(gl, 0, 0);"
        "return pen.canvas.toDataURL() === copy.toDataURL()"
    )
    try:
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        wait_until(lambda: browser.run("return 'printed' in Sheet.solid"))
        assert browser.run(shown) == "block"
        assert browser.run(same) is True
        printed = browser.driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert browser.run(shown) == "none"
    page = pypdfium2.PdfDocument(base64.b64decode(printed["data"]))[0]
    colours = np.array(page.render(scale=1.0).to_pil().convert("RGB")).astype(int)
    red, green, blue = colours[..., 0], colours[..., 1], colours[..., 2]
    steel = (blue > red + 15) & (blue > green + 5) & (blue < 240)
    assert steel.mean() > 0.02
