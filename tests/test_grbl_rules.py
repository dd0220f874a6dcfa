"""Programs for grbl, line by line by the rules of its own interpreter (gcode.c of grbl 1.1).

Nothing of beamcam reads them here: lengths of lines, words, modal groups, radii of arcs.
"""

import re
from collections.abc import Iterator
from math import hypot
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import LayerSettings
from beamcam.pipeline import post
from beamcam.readers import read
from tests.conftest import GOLDEN, examples

PROGRAMS = sorted((GOLDEN / "laser-grbl").glob("*.nc"))
MAX_LINE = 79  #: of a buffer of 80, without spaces and comments
MAX_RECEIVED = 127  #: of a serial buffer of 128, with them
GROUPS = {
    "motion": {"G0", "G1", "G2", "G3", "G80"}, "plane": {"G17", "G18", "G19"},
    "distance": {"G90", "G91"}, "feed": {"G93", "G94"}, "units": {"G20", "G21"},
    "compensation": {"G40"}, "dwell": {"G4"}, "stop": {"M0", "M1", "M2", "M30"},
    "spindle": {"M3", "M4", "M5"},
}  # fmt: skip
GROUP = {word: group for group, words in GROUPS.items() for word in words}
WORD = re.compile(r"([A-Z])([+-]?(?:\d+\.?\d*|\.\d+))")


def faults(text: str) -> Iterator[str]:
    """Everything that grbl would answer with an error, each with its line."""
    motion, feed, here = "G0", 0.0, (0.0, 0.0)
    for number, line in enumerate(text.splitlines(), 1):
        if not line.isascii() or not line.isprintable() or len(line) > MAX_RECEIVED:
            yield f"{number}: {line!r} is no line"
        code = re.sub(r"\([^()]*\)|\s", "", line).upper()
        if len(code) > MAX_LINE or re.search(r"[()$!?~%;]", code):
            yield f"{number}: overflow, or a character that is a command of its own"
        words = WORD.findall(code)
        if "".join(letter + value for letter, value in words) != code:
            yield f"{number}: {code} is not made of words"
        values: dict[str, float] = {}
        groups: set[str] = set()
        for letter, value in words:
            name = f"{letter}{float(value):g}"
            if letter in "GM":
                if name not in GROUP or GROUP[name] in groups:
                    yield f"{number}: {name} is unknown, or a second one of its group"
                groups.add(GROUP.get(name, ""))
                motion = name if GROUP.get(name) == "motion" else motion
            elif letter not in "FIJNPRSXY" or letter in values:
                yield f"{number}: {name} is unknown, or said twice"
            values[letter] = float(value)
        feed = values.get("F", feed)
        if values.get("F", 1.0) <= 0.0 or not 0.0 <= values.get("S", 0.0) <= 1000.0:
            yield f"{number}: a feed or a power out of range"
        if values.keys() & set("XY"):
            end = values.get("X", here[0]), values.get("Y", here[1])
            if motion == "G80" or (motion != "G0" and feed <= 0.0):
                yield f"{number}: a move without its mode or its feed"
            if motion in ("G2", "G3"):
                yield from (f"{number}: {what}" for what in arc_faults(here, end, values))
            elif values.keys() & set("IJR"):
                yield f"{number}: words of an arc that none takes"
            here = end
        elif values.keys() & set("IJR") or groups & {"motion"}:
            yield f"{number}: a motion that moves nothing"


def arc_faults(
    here: tuple[float, float], end: tuple[float, float], values: dict[str, float]
) -> Iterator[str]:
    """What grbl says of an arc: error 33 beyond 0.005 mm, if that is a thousandth of the radius."""
    if not values.keys() & set("IJ") or "R" in values:
        yield "an arc without its centre"
        return
    i, j = values.get("I", 0.0), values.get("J", 0.0)
    start_radius = hypot(i, j)
    apart = abs(hypot(end[0] - here[0] - i, end[1] - here[1] - j) - start_radius)
    if not start_radius or apart > 0.5 or (apart > 0.005 and apart > 0.001 * start_radius):
        yield f"radii {apart:.4f} mm apart"


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.name)
def test_golden_programs_keep_the_rules(path: Path) -> None:
    assert list(faults(path.read_text(encoding="utf-8"))) == []


places = st.floats(5, 90).map(lambda v: round(v, 2))
sizes = st.floats(1, 40).map(lambda v: round(v, 3))
shapes = st.one_of(
    st.builds('<circle cx="{}" cy="{}" r="{}"/>'.format, places, places, sizes),
    st.builds('<ellipse cx="{}" cy="{}" rx="{}" ry="{}"/>'.format, places, places, sizes, sizes),
    st.builds('<path d="M{} {} c{} {} {} 5 30 {}"/>'.format, places, places, *[sizes] * 4),
    st.builds('<path d="M{} {} l{} {}"/>'.format, places, places, sizes, sizes),
)


@settings(max_examples=examples(12), deadline=None)
@given(
    drawn=st.lists(shapes, min_size=1, max_size=5), rotate=st.floats(-180, 180),
    speed=st.floats(1, 9000), power=st.floats(0, 1000), passes=st.integers(1, 3),
    copies=st.tuples(st.integers(1, 2), st.integers(1, 2)),
    origin=st.sampled_from(["table", "centre", "upper-right"]),
    hatch=st.none() | st.floats(2, 9), one_way=st.booleans(), outline=st.booleans(),
    tabs=st.integers(0, 3), overcut=st.floats(0, 5), lead=st.sampled_from(["none", "arc"]),
)  # fmt: skip
def test_generated_programs_keep_the_rules(
    drawn: list[str], rotate: float, speed: float, power: float, passes: int,
    copies: tuple[int, int], origin: str, hatch: float | None, one_way: bool, outline: bool,
    tabs: int, overcut: float, lead: str,
) -> None:  # fmt: skip
    text = f"""<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="200mm"
    viewBox="0 0 200 200"><g fill="none" stroke="blue">{"".join(drawn)}</g>
    <g fill="none"><rect x="1" y="1" width="95" height="95" stroke="red"/>
    <circle cx="50" cy="50" r="7" stroke="black"/></g></svg>"""
    (part,) = read(text.encode(), "t.svg").parts
    part = replace(part, profile=replace(part.profile, web_thickness=3.0))
    machine = with_torch(
        load("laser-grbl"), {"blue": "mark", "black": "engrave", "red": "cut"},
        settings={
            "blue": LayerSettings(speed, power, passes),
            "black": LayerSettings(
                hatch=hatch, hatch_angle=rotate, hatch_one_way=one_way, hatch_outline=outline
            ),
        },
        # Leads would reach over an origin in the corner of the work.
        tabs=tabs, overcut=overcut, lead="none" if "right" in origin else lead,
        lead_in=0.9, lead_out=0.5, margin=2.0,
        rotate=rotate, copies=copies, spacing=3.0, origin=origin,
    )  # fmt: skip
    written = post((part,), machine, "A NAME WITH (BRACKETS); AND $ % ! ? ~").text
    assert list(faults(written)) == []


BROKEN = {
    "G1 G2 X1 Y1 I1": "a second one of its group", "G5 X1": "unknown", "G1 X1 X2": "said twice",
    "G2 X1 Y1": "without its centre", "G2 X10 Y0 I4 J0": "radii", "G1 X1": "its feed",
    "G0 I1 X1": "that none takes", "G0": "moves nothing", "X1 Y": "not made of words",
    "M4 S1001": "out of range", "G0 X1 (" + 130 * "a" + ")": "no line",
    "G0 X" + 80 * "1": "overflow", "G0 X1 %": "command of its own",
}  # fmt: skip


@pytest.mark.parametrize("line", BROKEN)
def test_the_rules_can_be_broken(line: str) -> None:
    before = "F100\n" if line.startswith("G2") else ""
    assert any(BROKEN[line] in fault for fault in faults(before + line))
