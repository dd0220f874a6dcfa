"""The setup sheet in a browser: opened from disk, played, scrubbed, stepped and clicked."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest

from beamcam.machine import load
from beamcam.model.part import Part
from beamcam.pipeline import read_file
from beamcam.simulation.program import simulate_program
from beamcam.simulation.trace import Trace
from tests.browser.conftest import Browser
from tests.conftest import sampled
from tests.runs import call, wait_until

DSTV = Path(__file__).resolve().parents[2] / "samples" / "dstv"
JSON = DSTV.parent / "json"
COPING = DSTV.parent / "coping"
ANNEX = [str(DSTV / f"{name}.nc1") for name in ("channel", "tie", "channel")]
STEP = 0.001  #: of positions in a page
JOBS = {
    "bar": (ANNEX, "beamline-annex", ".gcode"),
    "plate": ([str(DSTV / "gusset.nc1")], "plate-linuxcnc", ".ngc"),
    "laser": ([str(JSON / "curves.json")], "laser-grbl", ".nc"),
    "steps": ([str(JSON / "shield-small.json")], "laser-stepper", ".steps"),
    "triggers": ([str(JSON / "shield.json")], "table-simotion", ".st"),
    "coper": ([str(COPING / "trimmer.nc1")], "coper-linuxcnc", ".ngc"),
    "tube": ([str(COPING / "brace.nc1")], "tube-linuxcnc", ".ngc"),
}
#: Of these a page has the place round the bar behind the place along it.
UNROLLED = ("coper", "tube")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Programs and their sheets."""
    made = tmp_path_factory.mktemp("sheets")
    for name in ("bar", "plate"):
        page_of(made, name)
    return made


def page_of(folder: Path, name: str) -> Path:
    """The sheet of a job, its program beside it, made where they are not there."""
    inputs, machine, suffix = JOBS[name]
    program, page = folder / f"{name}{suffix}", folder / f"{name}.html"
    if not page.exists():
        call("post", *inputs, "--machine", machine, "-o", program, status=0)
        call("report", program, *inputs, "--machine", machine, "-o", page, status=0)
    return page


def trace_of(folder: Path, name: str) -> Trace:
    inputs, machine, suffix = JOBS[name]
    parts: tuple[Part, ...] = tuple(p for path in inputs for p in read_file(path).parts)
    data = (folder / f"{name}{suffix}").read_bytes()
    return simulate_program(data, load(machine), style=suffix, parts=parts).trace


def positions(browser: Browser) -> list[float]:
    """What the table of the axes shows, as the values behind its texts."""
    rows = browser.run(
        "return [...document.querySelectorAll('.axes data')].map((e) => Number(e.value))"
    )
    return [float(v) for v in rows]


def scrub(browser: Browser, time: float) -> None:
    browser.run(
        "const s = document.getElementById('time'); s.value = arguments[0];"
        "s.dispatchEvent(new Event('input'))", time,
    )  # fmt: skip


@pytest.mark.parametrize("name", sampled(JOBS, 4))
def test_a_page_moves_as_the_simulator_says(browser: Browser, folder: Path, name: str) -> None:
    browser.open(page_of(folder, name))
    trace = trace_of(folder, name)
    assert browser.run("return Sheet.trace.duration") == pytest.approx(trace.duration_s, abs=1e-4)
    times = [*np.random.default_rng(1).uniform(0.0, trace.duration_s, 9), trace.duration_s]
    speeds = np.abs(np.diff(trace.positions, axis=0)) / np.diff(trace.time_s)[:, None]
    fastest = float(np.max(speeds))
    for time in times:
        scrub(browser, float(time))
        # A slider keeps no more digits than it likes; what it kept is the page's time.
        kept = float(browser.run("return Sheet.time"))
        assert kept == pytest.approx(time, abs=1e-6)
        wanted = trace.at([kept])[0]
        found = positions(browser)
        del found[1 : 2 if name in UNROLLED else 1]
        assert found == pytest.approx(wanted, abs=1.5 * STEP + 2e-6 * fastest)
    assert browser.complaints == []
    assert browser.requests == [(folder / f"{name}.html").as_uri()]
    assert "is the one that was read back" in browser.text("hash-said")


def drawing(browser: Browser, view: str) -> str:
    """A view as an image."""
    return str(browser.run(
        "return document.querySelector(`canvas[data-view=${arguments[0]}]`).toDataURL()", view
    ))  # fmt: skip


def test_the_cell_is_seen_from_above_from_the_side_and_in_space(
    browser: Browser, folder: Path
) -> None:
    browser.open(folder / "bar.html")
    views = ("above", "side", "space")
    seen = set()
    for view in views:
        browser.click(f"button[data-show={view}]")
        visible = "return [...document.querySelectorAll('canvas[data-view]')].filter((c) => "
        assert browser.run(f"{visible}c.clientWidth).map((c) => c.dataset.view)") == [view]
        for share in (0.0, 0.3, 0.9):
            browser.run("Sheet.go(Sheet.trace.duration * arguments[0])", share)
            seen.add(drawing(browser, view))
    assert len(seen) == 9
    before = drawing(browser, "space")
    browser.run("document.querySelector('canvas[data-view=space]').focus()")
    browser.keys("\ue014")  # the arrow to the right
    turned = drawing(browser, "space")
    assert turned != before
    browser.click("#whole")
    assert drawing(browser, "space") != turned
    assert browser.complaints == []


def test_it_plays_pauses_and_steps_by_block(browser: Browser, folder: Path) -> None:
    browser.open(folder / "bar.html")
    trace = trace_of(folder, "bar")
    browser.run("document.getElementById('speed').value = '50';"
                "document.getElementById('speed').dispatchEvent(new Event('change'))")  # fmt: skip
    browser.click("#play")
    assert browser.text("play") == "Pause"
    browser.driver.execute_async_script(
        "const done = arguments[0]; const wait = () => Sheet.time > 1 ? done() "
        ": requestAnimationFrame(wait); wait()"
    )
    browser.click("#play")
    assert browser.text("play") == "Play"
    time = float(browser.run("return Sheet.time"))
    assert positions(browser) == pytest.approx(trace.at([time])[0], abs=2 * STEP)
    browser.click("#first")
    blocks = [line for k, line in enumerate(trace.line.tolist())
              if k == 0 or line != trace.line[k - 1]]  # fmt: skip
    for line in blocks[1:6]:
        browser.click("#forward")
        assert browser.run("return document.querySelector('#listing .now').dataset.line") == str(
            line
        )
        k = trace.line.tolist().index(line)
        assert positions(browser) == pytest.approx(trace.positions[k], abs=1.5 * STEP)
    browser.click("#back")
    assert browser.run("return Sheet.trace.lineAt(Sheet.time)") == blocks[4]


def test_a_hole_and_its_block_lead_to_each_other(browser: Browser, folder: Path) -> None:
    browser.open(folder / "bar.html")
    hole = browser.run(
        "const e = document.querySelector('.pictures circle.hole'); e.dispatchEvent("
        "new MouseEvent('click', {bubbles: true})); return Number(e.dataset.line)"
    )
    now = browser.run("return Number(document.querySelector('#listing .now').dataset.line)")
    assert now == hole
    shown = browser.run("return document.querySelector('#listing .now').textContent")
    assert " Z" in shown
    assert browser.run("return document.querySelector('circle.hole.now') !== null")
    assert browser.run("return document.querySelector('tr.now') !== null")
    browser.click("#first")
    browser.run("document.querySelector(\"#listing [data-line='12']\").click()")
    assert browser.run("return Sheet.trace.lineAt(Sheet.time)") == 12
    browser.click("td button[data-line]")
    first = browser.run("return Number(document.querySelector('td button').dataset.line)")
    assert browser.run("return Sheet.trace.lineAt(Sheet.time)") == first


def test_all_goes_by_keyboard_and_has_a_name(browser: Browser, folder: Path) -> None:
    browser.open(folder / "plate.html")
    browser.keys(".")
    browser.keys(".")
    at = browser.run("return Sheet.time")
    assert at > 0
    browser.keys(",")
    assert browser.run("return Sheet.time") < at
    browser.keys(" ")
    assert browser.run("return Sheet.playing")
    browser.keys(" ")
    assert not browser.run("return Sheet.playing")
    reached = set()
    browser.run("document.activeElement.blur()")
    for _ in range(40):
        browser.keys("\ue004")  # Tab
        reached.add(str(browser.run("return document.activeElement.id")))
    wanted = "unit program-file time first back play forward speed listing solid-view"
    assert set(wanted.split()) <= reached
    nameless = browser.run(
        "return [...document.querySelectorAll('button, input, select, canvas, [tabindex]')]"
        ".filter((e) => !(e.ariaLabel || e.textContent.trim() || (e.labels && e.labels.length)))"
        ".map((e) => e.outerHTML)"
    )
    assert nameless == []
    assert browser.run("return document.querySelectorAll('svg > title').length") == 2


def test_one_digit_more_is_another_program(browser: Browser, folder: Path, tmp_path: Path) -> None:
    text = (folder / "plate.html").read_text(encoding="utf-8")
    data = re.search(r'id="program">(.*?)</script>', text, re.DOTALL)
    assert data is not None
    program = json.loads(data[1])["text"]
    at = program.index("X")
    digit = program[at + 1]
    changed = data[1].replace(f"X{digit}", f"X{(int(digit) + 1) % 10}", 1)
    broken = tmp_path / "changed.html"
    broken.write_text(text.replace(data[1], changed), encoding="utf-8")
    browser.open(broken)
    assert "was changed" in browser.text("hash-said")
    assert browser.run("return document.getElementById('hash').dataset.state") == "differs"
    other = browser.driver.find_element("id", "program-file")
    browser.open(folder / "plate.html")
    other = browser.driver.find_element("id", "program-file")
    for name, state in (("plate.ngc", "same"), ("bar.gcode", "differs")):
        other.send_keys(str(folder / name))
        browser.driver.execute_async_script(
            "const done = arguments[1]; const wait = () => document.getElementById('hash-said')"
            ".textContent.startsWith(arguments[0]) ? done() : setTimeout(wait, 5); wait()", name,
        )  # fmt: skip
        assert browser.run("return document.getElementById('hash').dataset.state") == state


def test_numbers_are_written_as_the_reader_does(browser: Browser, folder: Path) -> None:
    browser.driver.execute_cdp_cmd("Emulation.setLocaleOverride", {"locale": "de-DE"})
    try:
        browser.open(folder / "bar.html")
        figures = "return [...document.querySelectorAll('text[data-mm]')].map((e) => e.textContent)"
        assert "471,1" in browser.run(figures)
        values = browser.run("return [...document.querySelectorAll('data')].map((e) => e.value)")
        assert not any("," in value for value in values)
        browser.run("const u = document.getElementById('unit'); u.value = 'inch';"
                    "u.dispatchEvent(new Event('change'))")  # fmt: skip
        assert "18,549" in browser.run(figures)
        callouts = browser.run(
            "return [...document.querySelectorAll('text.callout')].map((e) => e.textContent)"
        )
        assert "4 × Ø0,709" in callouts  # of the tie: 18 mm
        notes = "return [...document.querySelectorAll('.unit-note')].map((e) => e.textContent)"
        assert all(note.startswith("lengths in inch") for note in browser.run(notes))
        again = browser.run("return [...document.querySelectorAll('data')].map((e) => e.value)")
        assert again == values
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setLocaleOverride", {})


def test_the_dark_page_is_dark(browser: Browser, folder: Path) -> None:
    light = {"name": "prefers-color-scheme", "value": "light"}
    try:
        browser.open(folder / "bar.html")
        bright = drawing(browser, "above")
        media = {"features": [light | {"value": "dark"}]}
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
        ground = "return getComputedStyle(document.documentElement).backgroundColor"
        assert browser.run(ground) == "rgb(18, 23, 29)"
        wait_until(lambda: drawing(browser, "above") != bright)
        hole = "return getComputedStyle(document.querySelector('circle.hole')).fill"
        assert browser.run(hole) == "rgb(18, 23, 29)"
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [light]})


@pytest.mark.parametrize(
    ("paper", "wanted"),
    sampled([((11.693, 16.535), (1191, 842)), ((8.268, 11.693), (842, 596))], 2),
)
def test_on_paper_it_lies_on_its_side_without_the_playback(
    browser: Browser, folder: Path, paper: tuple[float, float], wanted: tuple[int, int]
) -> None:
    """On A4 and on A3; a picture fills the page and is not cut."""
    browser.open(folder / "bar.html")
    try:
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        style = "return getComputedStyle(document.querySelector(arguments[0]))[arguments[1]]"
        assert browser.run(style, ".playback", "display") == "none"
        assert browser.run(style, "#program-check", "display") == "none"
        assert browser.run(style, ".in-space .controls", "display") == "none"
        assert browser.run(style, "#operations td:last-child", "textAlign") == "right"
        size = {"paperWidth": paper[0], "paperHeight": paper[1], "preferCSSPageSize": True}
        printed = browser.driver.execute_cdp_cmd("Page.printToPDF", size)
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    data = base64.b64decode(printed["data"])
    boxes = {tuple(round(float(v)) for v in found.split())
             for found in re.findall(rb"/MediaBox \[([\d. ]+)\]", data)}  # fmt: skip
    assert {box[2:] for box in boxes} <= {wanted, (wanted[0], wanted[1] - 1)}


@pytest.mark.parametrize("name", sampled(JOBS, 4))
def test_a_phone_shows_it_without_scrolling_sideways(
    browser: Browser, folder: Path, name: str
) -> None:
    browser.open(page_of(folder, name), 390)
    assert browser.run("return document.documentElement.scrollWidth") <= 390
    assert browser.complaints == []
