"""What a drawing's style rules show and hide: as a browser has it."""

import re
from pathlib import Path

import pytest

from beamcam.readers import read
from tests.browser.conftest import Browser
from tests.conftest import sampled

#: Rules of a sheet over the drawing below.
SHEETS = (
    "g > line {stroke:hsl(120,100%,25%)}",
    "g line {stroke:#00f8}",
    ".a > .b {stroke:#0ff}",
    "#top > g > line {stroke:hsl(0.5turn 100% 50%)}",
    "#top line {display:none}",
    "g > g > line {opacity:0}",
    ".a .b {stroke:transparent}",
    "g>line.b{stroke:hsl(60 50% 50%)}",
    "line {stroke:red} g line {stroke:lime} #l1 {stroke:blue}",
    ".a {opacity:0}",
    ".b {stroke:lime} g g line {stroke:red}",
    "svg > line {visibility:hidden}",
    "* > .b {stroke:#f00} line {stroke:#0f0 !important}",
    ".a * {stroke:rgba(1,2,3,0)}",
    "#top > line {stroke:#abcd} #top > .a > line {stroke:#abc0}",
    "g.a.c line {stroke:red}",
    "line.b.b {stroke:red} line.b {stroke:blue}",
    "g > * {stroke:hsl(-90 100% 50% / 0.5)}",
)
LINES = """\
<g id="top"><line id="l1" x2="5"/><line id="l2" class="b" x2="6"/>
<g class="a"><line id="l3" x2="7"/><line id="l4" class="b" x2="8"/>
<g><line id="l5" class="b c" x2="9"/></g></g></g><line id="l6" x2="10"/>"""
#: Whether a line shows, and in which colour: of itself and of all that it lies in.
SEEN = """return [...document.querySelectorAll('line')].map(line => {
    let shown = getComputedStyle(line).visibility == 'visible'
    for (let one = line; one instanceof Element; one = one.parentElement) {
        const style = getComputedStyle(one)
        shown = shown && style.display != 'none' && style.opacity != '0'
    }
    return [line.id, shown ? getComputedStyle(line).stroke : 'none']
})"""


def shown(computed: str) -> str | None:
    """The colour that a browser computes, "#rrggbb"; None where nothing is seen."""
    numbers = re.findall(r"[\d.]+", computed)
    if len(numbers) < 3 or (len(numbers) > 3 and float(numbers[3]) == 0.0):
        return None
    return "#" + "".join(f"{int(number):02x}" for number in numbers[:3])


@pytest.mark.parametrize("sheet", sampled(SHEETS, 2))
def test_lines_show_in_the_colours_of_a_browser(
    sheet: str, browser: Browser, tmp_path: Path
) -> None:
    text = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="0 0 20 20">'
        f"<style>{sheet}</style>{LINES}</svg>"
    )
    path = tmp_path / "a.svg"
    path.write_text(text)
    browser.driver.get(path.as_uri())
    expected = {name: shown(colour) for name, colour in browser.driver.execute_script(SEEN)}
    reading = read(text.encode(), "a.svg")
    assert not any(d.code.startswith("svg-css") for d in reading.diagnostics)
    found = {c.source.where: c.colour for part in reading.parts for c in part.contours}
    assert {name: found.get(name) for name in expected} == expected
