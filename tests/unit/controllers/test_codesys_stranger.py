"""The interpreter of CODESYS against a parser of this file: words by a split, places by a dict."""

from math import atan2, cos, hypot, isnan, pi, sin
from pathlib import Path
from random import Random
from typing import Any

import pytest

from beamcam.controllers import cell_events, table_events
from beamcam.controllers.events import Move, Pause, Switch
from beamcam.geometry.curves import Arc
from beamcam.machine import load
from tests.conftest import GOLDEN

PROGRAMS = sorted((GOLDEN / "beamline").glob("*.gcode"))
SHEETS = sorted((GOLDEN / "plate-codesys").glob("*.gcode"))


def told(text: str) -> list[tuple[Any, ...]]:
    """What a program says, statement by statement: moves, M words and dwells."""
    found: list[tuple[Any, ...]] = []
    at: dict[str, float] = {}
    feed, code, relative, from_zero = 0.0, "", False, False
    for line in text.splitlines():
        words = [w for w in line.split("(")[0].upper().split() if w[0] not in "N%"]
        if line.startswith("%") or not words:
            continue
        values = {w[0] if w[1:2] != "-" or w[0] != "E" else "E-": float(w[1:]) for w in words}
        if words[0][0] == "M":
            number = int(values.pop("M"))
            found.append(("M", number, values))
            continue
        if words[0][0] == "G":
            code = words[0] if int(words[0][1:]) < 10 and int(words[0][1:]) != 4 else code
            number = int(values.pop("G"))
            if number == 4:
                found.append(("wait", values["T"]))
            relative = number == 91 if number in (90, 91) else relative
            from_zero = number == 98 if number in (98, 99) else from_zero
            if number in (4, 40, 90, 91, 98, 99):
                continue
        feed = values.get("F", feed)
        start = dict(at)
        for axis in "XYZ":
            if axis in values:
                at[axis] = values[axis] + (at[axis] if relative else 0.0)
        kind = int(code[1:])
        centre = None
        if kind in (2, 3) and "R" in values:
            centre = below_half(start, at, values["R"], kind == 2)
        elif "I" in values:
            base = (0.0, 0.0) if from_zero else (start["X"], start["Y"])
            centre = base[0] + values["I"], base[1] + values["J"]
        found.append(("move", kind, dict(at), feed * 60.0, centre))
    return found


def below_half(
    start: dict[str, float], end: dict[str, float], radius: float, clockwise: bool
) -> tuple[float, float]:
    """The centre from which both ends are seen under less than 180 degrees."""
    x, y = end["X"] - start["X"], end["Y"] - start["Y"]
    away = (radius**2 - (x * x + y * y) / 4) ** 0.5
    turn = atan2(y, x) + (-pi / 2 if clockwise else pi / 2)
    middle = (start["X"] + x / 2, start["Y"] + y / 2)
    return middle[0] + away * cos(turn), middle[1] + away * sin(turn)


def agrees(text: str, name: str) -> int:
    """Compares the events of a program with what it says; how many there are."""
    machine = load(name)
    events, said = (cell_events if machine.stock == "beam" else table_events)(text, machine)
    assert said == []
    ours = [e for e in events if isinstance(e, Move | Switch | Pause)]
    theirs = told(text)
    assert len(ours) == len(theirs)
    for event, (kind, *rest) in zip(ours, theirs, strict=True):
        if isinstance(event, Switch):
            assert (kind, event.number, event.words) == ("M", *rest)
        elif isinstance(event, Pause):
            assert (kind, event.seconds) == ("wait", *rest)
        else:
            number, place, feed, centre = rest
            assert kind == "move"
            assert event.rapid == (number == 0)
            named = {k: v for k, v in zip("XYZ", event.end, strict=False) if not isnan(v)}
            assert named == pytest.approx(place, abs=1e-9)
            assert event.feed_mm_min == pytest.approx(feed)
            assert (event.curve is not None) == (number > 1)
            if isinstance(event.curve, Arc):
                assert event.curve.centre == pytest.approx(centre, abs=1e-6)
                assert (event.curve.sweep_deg < 0) == (number == 2)
                assert event.curve.end == pytest.approx(event.end[:2], abs=3e-3)
    return len(ours)


@pytest.mark.parametrize("path", [*PROGRAMS, *SHEETS], ids=lambda p: f"{p.parent.name}/{p.name}")
def test_golden(path: Path) -> None:
    assert agrees(path.read_text("utf-8"), path.parent.name) > 10


def test_there_are_golden_programs() -> None:
    assert len(PROGRAMS) >= 3
    assert len(SHEETS) >= 4


def walk(random: Random, sheet: bool) -> str:
    """A program that goes anywhere, with modes that change and words that go on."""
    lines = ["% WALK", "G90", "G99", "G00 X0 Y0" + ("" if sheet else " Z0")]
    x = y = 0.0
    relative = False
    for _ in range(60):
        kind = random.randrange(9)
        dx, dy = random.randint(-90, 90) / 8, random.randint(1, 90) / 8
        to = (dx, dy) if relative else (x + dx, y + dy)
        feed = random.choice(["", f" F{random.randint(1, 900)}"])
        if kind < 3:
            lines.append(f"G01 X{to[0]} Y{to[1]}{feed}")
        elif kind == 3:  # half a circle, about the middle of its chord
            lines.append(f"G0{random.choice('23')} X{to[0]} Y{to[1]} I{dx / 2} J{dy / 2}{feed}")
        elif kind == 4:
            radius = hypot(dx, dy) * random.uniform(0.6, 3.0)
            lines.append(f"G0{random.choice('23')} X{to[0]} Y{to[1]} R{radius:.6f}{feed}")
        elif kind == 5:
            relative = not relative
            lines.append("G91" if relative else "G90")
            continue
        elif kind == 6:
            lines.append(random.choice(["M08", "M40 K1 L20.5", "M03"]))
            continue
        elif kind == 7:
            lines += ["G04 T0.5", "G40"]
            continue
        else:
            lines += ["G01" + (feed or " F5"), f"X{to[0]}"]
            dy = 0.0
        x, y = x + dx, y + dy
    numbered = [f"N{k} {line}" if k % 3 else line.lower() for k, line in enumerate(lines)]
    return "\n".join([lines[0], *numbered[1:], "M30", "%", ""])


@pytest.mark.parametrize("name", ["beamline", "plate-codesys"])
def test_walks(name: str) -> None:
    assert sum(agrees(walk(Random(seed), name != "beamline"), name) for seed in range(40)) > 1500
