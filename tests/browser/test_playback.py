"""The playback of a setup sheet: in one window, by keys whatever was clicked, zoomed and moved."""

import base64
import io
import json
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.browser.conftest import Browser, mouse
from tests.conftest import sampled
from tests.runs import call

ROUNDS = 20_000  #: blocks of the long program
HEAD = "%\n(JOB)\nG21 G17 G90 G91.1 G40 G94\nG64 P0.01\nG0 X700 Y500\nM3 S1\nF3000\n"


@pytest.fixture(scope="module")
def spiral(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sheet of a program of 20,000 moves."""
    made = tmp_path_factory.mktemp("long")
    turns = ((2 * pi * k / 400, 200.0 + 250.0 * k / ROUNDS) for k in range(ROUNDS))
    moves = "".join(f"G1 X{750 + r * cos(a):.4f} Y{500 + r * sin(a):.4f}\n" for a, r in turns)
    program = made / "long.ngc"
    program.write_text(f"{HEAD}{moves}M5\nM2\n%\n")
    call("report", program, "--machine", "plate-linuxcnc", "-o", made / "long.html")
    return made / "long.html"


def box(browser: Browser, selector: str) -> dict[str, float]:
    found: dict[str, float] = json.loads(browser.run(
        "return JSON.stringify(document.querySelector(arguments[0]).getBoundingClientRect())",
        selector,
    ))  # fmt: skip
    return found


def number(browser: Browser, script: str) -> float:
    return float(browser.run(f"return {script}"))


@pytest.mark.parametrize("name", sampled(["bar", "plate"], 2))
def test_view_slider_and_play_are_in_the_window_at_once(
    browser: Browser, folder: Path, name: str
) -> None:
    browser.open(folder / f"{name}.html", 1280, 800)
    view = box(browser, ".views canvas:not([hidden])")
    assert view["width"] > 800
    assert view["height"] > 350
    for selector in ("#play", "#time", "#next", "#listing", ".views canvas:not([hidden])"):
        one = box(browser, selector)
        assert one["top"] >= 0, selector
        assert one["bottom"] <= 800, selector
    assert box(browser, "#play")["left"] > view["right"]
    assert number(browser, "window.scrollY") == 0


@pytest.mark.parametrize(
    "clicked", sampled(["#time", "#forward", "#play", "button[data-zoom=in]"], 4)
)
def test_keys_work_whatever_was_clicked(browser: Browser, folder: Path, clicked: str) -> None:
    browser.open(folder / "bar.html")
    browser.click(clicked)
    if clicked == "#play":
        browser.click(clicked)
    browser.run("Sheet.go(0)")
    browser.keys("..")
    stepped = number(browser, "Sheet.time")
    assert stepped > 0
    browser.keys(",")
    assert 0 < number(browser, "Sheet.time") < stepped
    browser.keys(" ")
    assert browser.run("return Sheet.playing") is True
    browser.keys(" ")
    assert browser.run("return Sheet.playing") is False
    browser.keys("\ue011")  # Home
    assert number(browser, "Sheet.time") == 0


def test_a_button_that_the_keyboard_came_to_keeps_its_blank(browser: Browser, folder: Path) -> None:
    browser.open(folder / "bar.html")
    browser.run("document.getElementById('back').focus()")
    browser.keys("\ue004")  # Tab: play
    assert browser.run("return document.activeElement.id") == "play"
    browser.keys(" ")
    assert browser.run("return Sheet.playing") is True
    browser.keys("\ue004")  # forward
    browser.keys(" ")
    assert browser.run("return Sheet.playing") is True  # it steps and does not pause
    browser.run("Sheet.play(false)")


def zoomed(browser: Browser) -> Any:
    return browser.run(
        "const v = Sheet.views.find(({view}) => view.canvas.clientWidth).view;"
        "return [v.zoom, ...v.shift]"
    )


@pytest.mark.parametrize("name", sampled(["bar", "plate"], 2))
def test_a_view_zooms_about_the_pointer_and_moves(
    browser: Browser, folder: Path, name: str
) -> None:
    browser.open(folder / f"{name}.html", 1280, 800)
    browser.run("Sheet.go(Sheet.trace.duration * 0.4)")
    image = "return document.querySelector('.views canvas:not([hidden])').toDataURL()"
    whole = browser.run(image)
    frame = box(browser, ".views canvas:not([hidden])")
    x, y = frame["left"] + 200, frame["top"] + 120
    mouse(browser, "mousePressed", x, y, buttons=1)
    mouse(browser, "mouseReleased", x, y)
    mouse(browser, "mouseWheel", x, y, deltaX=0, deltaY=-400, button="none")
    zoom, dx, dy = zoomed(browser)
    assert zoom == pytest.approx(2.718, abs=0.01)
    # What lay under the pointer lies there still.
    for at, size, shift in ((200, frame["width"], dx), (120, frame["height"], dy)):
        middle = size / 2 - 1  # within the border
        assert middle + (at - 1 - middle) * zoom + shift == pytest.approx(at - 1, abs=0.6)
    assert browser.run(image) != whole
    mouse(browser, "mousePressed", x, y, buttons=1)
    mouse(browser, "mouseMoved", x + 50, y + 30, buttons=1)
    mouse(browser, "mouseReleased", x + 50, y + 30)
    assert zoomed(browser) == pytest.approx([zoom, dx + 50, dy + 30], abs=0.01)
    browser.click("button[data-zoom=fit]")
    assert zoomed(browser) == [1, 0, 0]
    assert browser.run(image) == whole
    browser.click("button[data-zoom=in]")
    assert zoomed(browser)[0] == pytest.approx(1.4)
    browser.run("document.querySelector('.views canvas:not([hidden])').focus()")
    browser.keys("0")
    assert zoomed(browser) == [1, 0, 0]


def test_the_slider_has_marks_of_cuts_and_tool_changes(browser: Browser, folder: Path) -> None:
    browser.open(folder / "bar.html")
    marks = browser.run(
        "return [...document.querySelectorAll('#marks i')].map((e) => [e.className, e.title, "
        "e.getBoundingClientRect().left])"
    )
    cuts = [title for kind, title, _ in marks if kind == "cut"]
    assert len(cuts) == number(browser, "Sheet.data.cuts.length") == 5
    tools = [title.split(", ")[1] for kind, title, _ in marks if kind == "tool"]
    assert {"tool 14", "tool 18", "tool 22"} == {*tools}
    # A mark lies where the slider is at that time: the page goes there by a click on it.
    at = next(k for k, (kind, _, _) in enumerate(marks) if kind == "cut" and k > 3)
    browser.run("document.querySelectorAll('#marks i')[arguments[0]].click()", at)
    time = number(browser, "Sheet.time")
    assert browser.run("return Sheet.trace.stateAt(Sheet.time).sawing") is True
    track = box(browser, "#time")
    share = time / number(browser, "Sheet.trace.duration")
    place = track["left"] + 8 + (track["width"] - 16) * share
    assert marks[at][2] == pytest.approx(place, abs=3)
    browser.open(folder / "plate.html")
    kinds = browser.run("return [...document.querySelectorAll('#marks i')].map((e) => e.title)")
    assert sum(title.startswith("cut,") for title in kinds) == 5
    assert sum(title.startswith("mark,") for title in kinds) == 1


def test_what_comes_next_stands_in_large_letters(browser: Browser, folder: Path) -> None:
    browser.open(folder / "bar.html")
    rows = browser.run(
        "return Sheet.operations.map((o) => [o.begin, `${o.number}  ${o.what}`, o.faces])"
    )
    assert len(rows) == 29
    assert browser.text("next-what").startswith(rows[0][1])
    beside = [(a, b) for a, b in pairwise(rows) if b[0] - a[0] >= 0.01]
    for (begin, said, faces), (_, following, _) in beside[::4]:
        browser.run("Sheet.go(arguments[0])", begin + 0.005)
        assert browser.text("next-what").startswith(following)
        assert browser.text("last-what").startswith(f"begun: {said}")
        assert faces in browser.text("last-what")
    browser.run("Sheet.go(Sheet.trace.duration)")
    assert browser.text("next-what") == "end of the program"
    size = browser.run(
        "return ['next-what', 'state'].map((id) => parseFloat(getComputedStyle("
        "document.getElementById(id)).fontSize))"
    )
    assert size[0] > 1.4 * size[1]


def test_a_frame_draws_only_what_is_new(browser: Browser, spiral: Path) -> None:
    browser.open(spiral)
    assert number(browser, "Sheet.trace.count") >= ROUNDS
    browser.run("Sheet.go(Sheet.trace.duration * 0.5)")
    drawn = "Sheet.model.drawn"
    before, now = number(browser, drawn), number(browser, "Sheet.model.until")
    for _ in range(10):
        browser.run("Sheet.go(Sheet.time + 0.05)")
    new = number(browser, "Sheet.model.until") - now
    assert new > 0
    assert number(browser, drawn) - before == new < 100
    rows = browser.run("window.old = document.querySelector('#listing .now'); return 0")
    browser.run("Sheet.go(Sheet.trace.step(Sheet.time, 1))")
    assert browser.run("return window.old.isConnected") is True, rows  # the rows are kept
    # Back again, or nearer: all of it.
    for script in ("Sheet.go(Sheet.time - 5)", "document.querySelector('[data-zoom=in]').click()"):
        before = number(browser, drawn)
        browser.run(script)
        count, until = number(browser, "Sheet.trace.count"), number(browser, "Sheet.model.until")
        assert number(browser, drawn) - before == count + until
    assert browser.complaints == []


def test_what_is_drawn_piece_by_piece_is_what_is_drawn_at_once(
    browser: Browser, folder: Path
) -> None:
    browser.open(folder / "plate.html")
    image = "return document.querySelector('canvas[data-view=table]').toDataURL()"
    for k in range(20):
        browser.run("Sheet.go(Sheet.trace.duration * arguments[0])", 0.6 * k / 19)
    grown = pixels(browser.run(image))
    browser.run("Sheet.model.key = ''; Sheet.draw()")
    at_once = pixels(browser.run(image))
    assert (abs(grown - at_once).max(axis=2) > 60).mean() < 0.003  # joints of dashes


def pixels(url: str) -> Any:
    picture = Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).convert("RGB")
    return np.array(picture).astype(int)


def touch(browser: Browser, kind: str, *points: tuple[float, float]) -> None:
    browser.driver.execute_cdp_cmd(
        "Input.dispatchTouchEvent",
        {"type": kind, "touchPoints": [{"x": x, "y": y, "id": k}
                                       for k, (x, y) in enumerate(points)]},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("selector", "scale"),
    [("canvas[data-view=table]", "Sheet.views[0].view.zoom"), ("#solid-view", "Sheet.solid.scale")],
)
def test_two_fingers_zoom(browser: Browser, folder: Path, selector: str, scale: str) -> None:
    browser.open(folder / "plate.html", 800, 900)
    browser.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", selector)
    frame = box(browser, selector)
    x, y = frame["left"] + frame["width"] / 2, frame["top"] + frame["height"] / 2
    enabled = {"enabled": True, "maxTouchPoints": 2}
    browser.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", enabled)
    try:
        touch(browser, "touchStart", (x, y))
        touch(browser, "touchEnd")
        before = number(browser, scale)
        touch(browser, "touchStart", (x - 40, y), (x + 40, y))
        for way in (50, 60, 70, 80):
            touch(browser, "touchMove", (x - way, y), (x + way, y))
        touch(browser, "touchEnd")
        assert number(browser, scale) == pytest.approx(2 * before, rel=0.1)
    finally:
        enabled = {"enabled": False, "maxTouchPoints": 1}
        browser.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", enabled)
