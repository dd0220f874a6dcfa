"""docs/sources.md: its commands show what it says, and its figures are computed anew.

A figure is what this file computes from the description, or what a program of beamcam holds,
rounded as the page writes it.
"""

import re
import subprocess
from collections.abc import Callable
from itertools import pairwise
from math import asin, atan, atan2, degrees, dist, hypot, sin
from pathlib import Path

import pytest

from beamcam.checks.bars import verify
from beamcam.machine import load
from beamcam.pipeline import parts_of, post, read_file
from tests.conftest import BEAM_CELL, ROOT, SAMPLES
from tests.runs import HANG_S
from tests.test_readme import blocks, commands, run_here, script

PAGE = ROOT / "docs" / "sources.md"
SECTIONS = {
    section.partition("\n")[0]: section
    for section in re.split(r"^### ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
}
_ROW = re.compile(r"^\| ([^|]*[^|\s-]) \| (-?[\d.]+) \|$", re.MULTILINE)
Figures = dict[str, float]


def figures(section: str) -> dict[str, str]:
    """The figures of a section, as they are written."""
    return dict(_ROW.findall(section))


def check(title: str, found: Figures) -> None:
    """Whether the figures of a section are those that were found, each to its last digit."""
    written = figures(SECTIONS[title])
    assert written.keys() == found.keys()
    for label, text in written.items():
        decimals = len(text.partition(".")[2])
        assert f"{found[label]:.{decimals}f}" == text, label


def said(text: str) -> str:
    """A text with its blanks made one."""
    return re.sub(r"\s+", " ", text)


@pytest.mark.parametrize("title", SECTIONS)
def test_commands_show_what_the_page_says(
    title: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "samples").symlink_to(SAMPLES)
    monkeypatch.chdir(tmp_path)
    asked, output = commands(SECTIONS[title]), ""
    assert any(command.startswith("beamcam ") for command, _ in asked)
    for command, status in asked:
        if command.startswith("beamcam "):
            found, text = run_here(command)
            assert found == status, text
            output += text
        else:
            done = subprocess.run(
                ["sh", "-c", script([(command, status)])], check=True, timeout=HANG_S,
                capture_output=True, text=True,
            )  # fmt: skip
            output += done.stdout
    for block in blocks(SECTIONS[title], "text"):
        for line in block.splitlines():
            assert said(line) in said(output), line


# --- figures --------------------------------------------------------------------------------------


def points(sample: str) -> list[tuple[int, float, float]]:
    """The operations of a trigger program: what they are, and where they end."""
    parts, _ = parts_of([read_file(str(SAMPLES / "json" / f"{sample}.json"))])
    text = post(parts, load("table-simotion")).text
    job = text[text.index("(* ----- Job ----- *)") :]
    found = re.findall(r"kind := USINT#(\d), x := LREAL#(\S+), y := LREAL#([^,]+),", job)
    return [(int(kind), float(x), float(y)) for kind, x, y in found]


def polynomial() -> Figures:
    nodes = [(10.0, 11.0), (40.0, 22.0), (60.0, 20.0), (90.0, 5.0)]
    xs, differences = [x for x, _ in nodes], [y for _, y in nodes]
    rows = [differences]
    while len(rows[-1]) > 1:
        rows.append([b - a for a, b in zip(rows[-1], rows[-1][1:], strict=False)])
    t, term, forward = (90.0 - 10.0) / 30.0, 1.0, 0.0
    for order, row in enumerate(rows):
        forward += row[0] * term
        term *= (t - order) / (order + 1)
    divided = list(differences)
    for order in range(1, 4):
        for k in range(3, order - 1, -1):
            divided[k] = (divided[k] - divided[k - 1]) / (xs[k] - xs[k - order])
    value = divided[3]
    for k in (2, 1, 0):
        value = value * (90.0 - xs[k]) + divided[k]
    ends = {(x, y) for _, x, y in points("four-nodes")}
    return {
        "y of forward differences at x = 90": forward,
        "y of divided differences at x = 90": value,
        "nodes that are points of the program": len(ends & set(nodes)),
    }


def step_angle() -> Figures:
    v, cycle, radius = 8.0, 0.025, 10.0
    three = 2 * asin(3 * v * cycle / (2 * radius))
    found = points("rounded-rectangle")
    first = next(k for k, op in enumerate(found) if op[1:] == (40.0, 10.0))
    last = next(k for k, op in enumerate(found) if op[1:] == (50.0, 20.0))
    steps = last - first
    for _, x, y in found[first : last + 1]:
        assert dist((x, y), (40.0, 20.0)) == pytest.approx(radius, abs=0.0011)
    return {
        "degrees of a chord of three cycles": degrees(three),
        "degrees of a chord of one": degrees(2 * asin(v * cycle / (2 * radius))),
        "mm of three cycles off the arc": radius * (1 - (1 - sin(three / 2) ** 2) ** 0.5),
        "least R of three cycles, mm": 3 * v * cycle / 2,
        f"degrees of a step as written, {steps} of them in 90": 90.0 / steps,
    }


def together() -> Figures:
    v, a = 2.0, 100.0
    ways = (3.0, 2.0)
    length = hypot(*ways)
    x, y = (way / (v * way / length) + v * way / length / a for way in ways)
    return {"s of X": x, "s of Y": y, "s of both, acceleration shared out": length / v + v / a}


def arrival() -> Figures:
    count, fine = 65 / 512, 65 / 2048
    read = 25.0 // count * count
    return {
        "mm of a count": count, "mm in quadrature": fine, "what is read at X 25": read,
        "mm off": 25.0 - read, "read to the nearest count of 2048": round(25.0 / fine) * fine,
    }  # fmt: skip


def twice() -> Figures:
    at = [op for op in points("shield") if op[1:] == (25.0, 5.0)]
    return {"operations of the shield that end at X 25, Y 5": len(at)}


def quadrant() -> Figures:
    dx, dy = 14.0 - 16.0, 35.0 - 37.0
    return {
        "degrees by arctangent": degrees(atan(dy / dx)),
        "degrees of the edge": degrees(atan2(dy, dx)) % 360.0,
    }


def room() -> Figures:
    torch = load("table-simotion").torch
    assert torch is not None
    assert torch.length == torch.width
    return {
        "mm of the table along X": torch.length,
        "greatest X of the rounded rectangle": max(x for _, x, _ in points("rounded-rectangle")),
    }


def table(style: str) -> list[list[str]]:
    """The rows of a step table of the small shield."""
    parts, _ = parts_of([read_file(str(SAMPLES / "json" / "shield-small.json"))])
    done = b"".join(post(parts, load("laser-stepper"), style=style).pieces()).decode()
    rows = [line.split(",") for line in done.splitlines() if not line.startswith("#")]
    return rows[1:] if style == ".csv" else [r for r in rows if r[0].isdigit()]


def frequencies() -> Figures:
    pitch, steps, speed = 2.0, 200.0, 4.0
    x, y = (speed * way / hypot(2.0, 3.0) / pitch * steps for way in (2.0, 3.0))
    _, row = table(".csv")[:2]
    assert [float(v) for v in row[7:]] == pytest.approx([x, y], abs=0.005)
    return {
        "Hz of X": x, "Hz of Y": y, "Hz of both by the speed of the path": speed / pitch * steps,
        "mm of a step": pitch / steps,
    }  # fmt: skip


def first_step() -> Figures:
    rows = table(".steps")
    velocity = float(table(".csv")[0][2])
    return {
        "ms to the first step as written": int(rows[1][0]) / 1000.0,
        "ms at full speed, 56.5685 mm/s": 0.01 / velocity * 1000.0,
    }


def words() -> Figures:
    order = ["00", "01", "10", "11"]
    turned = [order.index(row[1]) for row in table(".steps")]
    steps = [(b - a) % 4 for a, b in pairwise(turned)]
    return {
        "words of X that are no neighbours of the one before": steps.count(2),
        "steps forwards less steps back, X": steps.count(1) - steps.count(3),
    }


def circles() -> Figures:
    half, radius = (40.0 - 10.0) / 2, 17.0
    off = (radius**2 - half**2) ** 0.5
    return {"y of the centre on the left": 20.0 + off, "y of the centre on the right": 20.0 - off}


def parabola() -> Figures:
    (p0, p2), vertex = ((100.0, 200.0), (-100.0, 200.0)), (0.0, 0.0)
    middle = 2 * vertex[1] - (p0[1] + p2[1]) / 2
    return {
        "y of the middle point": middle,
        "y of the curve half way": (p0[1] + 2 * middle + p2[1]) / 4,
    }


FIGURES: dict[str, Callable[[], Figures]] = {
    "The polynomial misses its last node": polynomial,
    "The step angle and its factor of three": step_angle,
    "Two axes that are to arrive together": together,
    "An arrival that is never read": arrival,
    "A trigger that fires twice": twice,
    "An angle without its quadrant": quadrant,
    "How large the table is": room,
    "The step frequency of an axis": frequencies,
    "A velocity that begins at once": first_step,
    "The next word of a motor": words,
    "Two points and a radius are two circles": circles,
    "The vertex of a parabola": parabola,
}


@pytest.mark.parametrize("title", FIGURES)
def test_figures_are_computed_anew(title: str) -> None:
    check(title, FIGURES[title]())


# --- the printed program --------------------------------------------------------------------------


def printed() -> str:
    return (BEAM_CELL / "annex-a.gcode").read_text(encoding="ascii")


def dstv(name: str) -> list[str]:
    return (BEAM_CELL / f"{name}.nc1").read_text(encoding="latin-1").split()


def said_twice() -> Figures:
    (width,) = re.findall(r"M44 K(\d+) L\1\n", printed())
    head = dstv("M58")
    return {
        "width of the section in the program, K of M44": float(width),
        "width of a PFC380": float(head[head.index("U") + 3]),
    }


def kerf() -> Figures:
    lengths = {n: float(dstv(n)[dstv(n).index("U") + 1]) for n in ("M74", "M58")}
    hole = next(x for x in re.findall(r"G01 X([\d.]+) Y-77.8 Z0", printed()))
    end, start = 71.12 + lengths["M74"], float(hole) - 778.56 - 44.94
    parts, _ = parts_of(read_file(str(BEAM_CELL / f"{n}.nc1")) for n in ("M74", "M58", "M74"))
    codes = [d.code for d in verify(printed(), parts, load("beamline-annex"))]
    saw = load("beamline-annex").saw
    assert saw is not None
    return {
        "end of M74 on the bar, 71.12 + its length": end,
        "start of M58 on the bar, hole X 1040.7 − 778.56 − 44.94": start,
        "mm between them": start - end,
        "kerf": saw.kerf,
        "holes of the printed program that are elsewhere": codes.count("verify-hole-place"),
        "cuts of the DSTV files that it does not make": codes.count("verify-cut-missing"),
    }


def middle() -> Figures:
    strokes = re.findall(r"M40 K13 L14\n.*\n.*\n.*\nN\d+ G01 X\S+ Y(\d+)", printed())
    head = dstv("M58")
    height = float(head[head.index("U") + 2])
    return {
        "height of a PFC380": height,
        "both strokes together": 2 * float(strokes[0]),
        "strokes of the printed program that meet": sum(2 * float(y) >= height for y in strokes),
    }


def turned() -> Figures:
    return {f"{word} in the printed program": printed().count(word) for word in ("M04", "M03")}


def ordered() -> Figures:
    text = printed()
    cut = list(re.finditer(r"G01 X([\d.]+)\nN\d+ M41", text))[-1]
    holes = list(re.finditer(r"M40 K13 L14\nN\d+ G01 X([\d.]+)", text))
    assert cut.end() < holes[-1].start()
    place = float(holes[-1][1])
    return {
        "machine X of the last cut": float(cut[1]),
        "machine X of holes of M58 behind it in the program": place,
        "bar x of these": place - 778.56,
    }


def fed() -> Figures:
    return {
        "feed of the saw, mm/s": 2500 / 60,
        "F words of the printed program": len(re.findall(r"\bF[\d.]", printed())),
    }


PRINTED: dict[str, Callable[[], Figures]] = {
    "M44 is width and height, or the height twice": said_twice,
    "Parts lie a kerf apart, but one does not": kerf,
    "Both flanges are drilled to the middle at once": middle,
    "The drills turn the wrong way": turned,
    "A cut comes before holes that lie before it": ordered,
    "Feeds are listed, and the program has none": fed,
}


@pytest.mark.third_party
@pytest.mark.parametrize("title", PRINTED)
def test_figures_of_the_printed_program(title: str) -> None:
    check(title, PRINTED[title]())


def test_every_figure_of_the_page_is_computed() -> None:
    with_figures = {title for title, section in SECTIONS.items() if figures(section)}
    assert with_figures == {*FIGURES, *PRINTED}
    tables = sum(section.count("\n| --- | --- |\n") for section in SECTIONS.values())
    assert tables == len(with_figures)


def test_the_checks_can_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    title = "An angle without its quadrant"
    monkeypatch.setitem(SECTIONS, title, SECTIONS[title].replace("| 225 |", "| 45 |"))
    with pytest.raises(AssertionError, match="degrees of the edge"):
        check(title, quadrant())
