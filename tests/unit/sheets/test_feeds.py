"""Small holes and corners: cut slower in the program, in its times and for the read-back."""

import re
from itertools import pairwise
from math import acos, atan2, cos, degrees, dist, hypot, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch_faults import torch_faults
from beamcam.pipeline import post
from tests.conftest import examples, sampled
from tests.unit.sheets.parts import box, circle, contour, drawing, lines

TABLES = ("plate-linuxcnc", "plate-oxyfuel", "plate-codesys", "laser-grbl")
FEED, HOLE, CORNER, DISTANCE = 5200.0, 0.6, 0.5, 5.0
#: A plate with two round holes, of which one is small, a small square one and a large one.
PART = drawing(
    contour(box(0, 0, 200, 120)), contour(circle(40, 40, 20), line=2),
    contour(circle(100, 60, 40), line=3), contour(box(150, 20, 8, 8), line=4),
    contour(box(150, 70, 40, 30), line=5), thickness=3.0,
)  # fmt: skip


def slowed(
    name: str = "plate-linuxcnc", torch: dict[str, object] | None = None, **row: float
) -> Machine:
    asked = {
        "hole_diameter": 32.0, "hole_feed_share": HOLE, "corner_angle": 30.0,
        "corner_distance": DISTANCE, "corner_share": CORNER, **row,
    }  # fmt: skip
    machine = with_torch(load(name), thickness=3.0, **(torch or {}))  # type: ignore[arg-type]
    assert machine.torch is not None
    rows = tuple(replace(r, **asked) if r.process == "cut" else r for r in machine.torch.rows)
    return replace(machine, torch=replace(machine.torch, rows=rows))


def strokes(text: str) -> list[list[tuple[list[tuple[float, float]], float]]]:
    """The strokes of a program for LinuxCNC by a parser of the test: points and feed of moves."""
    here, feed, found = (0.0, 0.0), 0.0, []
    for block in text.splitlines():
        words = {w[0]: float(w[1:]) for w in re.findall(r"[A-Z]-?[\d.]+", block.split("(")[0])}
        feed = words.get("F", feed)
        if block.startswith("M3"):
            found.append([])
        if "X" not in words:
            continue
        end = words["X"], words["Y"]
        if words["G"] == 1:
            found[-1].append(([here, end], feed))
        elif words["G"] in (2, 3):
            middle = here[0] + words["I"], here[1] + words["J"]
            radius = hypot(words["I"], words["J"])
            first = atan2(here[1] - middle[1], here[0] - middle[0])
            last = atan2(end[1] - middle[1], end[0] - middle[0])
            sweep = (last - first) % (2 * pi) if words["G"] == 3 else -((first - last) % (2 * pi))
            count = max(2, int(abs(sweep) * 40))
            points = [
                (middle[0] + radius * cos(first + sweep * k / count),
                 middle[1] + radius * sin(first + sweep * k / count))
                for k in range(count + 1)
            ]  # fmt: skip
            found[-1].append((points, feed))
        here = end
    return [stroke for stroke in found if stroke]


def feeds_of(text: str) -> list[tuple[float, float, float]]:
    """X, Y and feed of each move with the tool on."""
    return [(*points[-1], feed) for stroke in strokes(text) for points, feed in stroke]


def length(points: list[tuple[float, float]]) -> float:
    return sum(dist(a, b) for a, b in pairwise(points))


def heading(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    return (b[0] - a[0]) / dist(a, b), (b[1] - a[1]) / dist(a, b)


def test_feeds_by_a_parser_of_the_test() -> None:
    """At every mm of every stroke: full, but 60 % in a small hole and half near a corner."""
    text = post((PART,), slowed()).text
    seen = set()
    for stroke in strokes(text):
        around = length([p for points, _ in stroke[1:-1] for p in points])
        base = HOLE if around < pi * 32 - 2 else 1.0
        reached, corners, places = 0.0, [], []
        for k, (points, feed) in enumerate(stroke):
            if k:
                before, (a, b) = stroke[k - 1][0], points[:2]
                u, v = heading(*before[-2:]), heading(a, b)
                if degrees(acos(max(-1.0, min(1.0, u[0] * v[0] + u[1] * v[1])))) > 30:
                    corners.append(reached)
            size = length(points)
            places += [(reached + share * size, feed) for share in (0.02, 0.25, 0.5, 0.75, 0.98)]
            reached += size
        for at, feed in places:
            away = min((abs(at - c) for c in corners), default=99.0)
            if abs(away - DISTANCE) > 0.1:
                expected = FEED * (min(base, CORNER) if away < DISTANCE else base)
                assert feed == pytest.approx(expected), (at, away, base)
                seen.add(round(feed))
    assert seen == {5200, 3120, 2600}


@pytest.mark.parametrize("name", TABLES)
@settings(max_examples=examples(25), deadline=None)
@given(
    corners=st.lists(st.tuples(st.floats(20, 90), st.floats(0.02, 1)), min_size=3, max_size=9),
    hole=st.floats(4, 30), diameter=st.floats(0, 60), share=st.sampled_from([0.3, 0.6, 1.0]),
    angle=st.floats(5, 120), distance=st.floats(0, 30), corner=st.sampled_from([0.4, 0.8, 1.0]),
    torch=st.sampled_from(
        [{}, {"overcut": 2.0}, {"tabs": 2}, {"lead": "none"}, {"kerf_by": "none"}]
    ),
)  # fmt: skip
def test_whatever_is_asked_is_read_back(
    name: str, corners: list[tuple[float, float]], hole: float, diameter: float, share: float,
    angle: float, distance: float, corner: float, torch: dict[str, object],
) -> None:  # fmt: skip
    """A star of any corners and a hole: nothing is refused, and shares of 1 change nothing."""
    turn, points = 0.0, []
    for radius, step in corners:
        turn += step
        points.append((radius, turn))
    ring = [(200 + r * cos(2 * pi * a / turn), 200 + r * sin(2 * pi * a / turn)) for r, a in points]
    part = drawing(
        contour(box(0, 0, 420, 420)), contour(lines(*ring), line=2),
        contour(circle(20 + hole, 20 + hole, hole), line=3), thickness=3.0,
    )  # fmt: skip
    machine = slowed(
        name, torch, hole_diameter=diameter, hole_feed_share=share, corner_angle=angle,
        corner_distance=distance, corner_share=corner,
    )  # fmt: skip
    try:
        text = post((part,), machine).text
    except Exception as error:
        if "plan-" in str(error):  # a star that is too narrow for the kerf
            return
        raise
    if share == corner == 1.0:
        assert text == post((part,), with_torch(load(name), thickness=3.0, **torch)).text  # type: ignore[arg-type]


def mutants(text: str) -> list[str]:
    """Programs with one F word dropped, changed, or a block too early or too late."""
    blocks = text.splitlines(keepends=True)
    found = []
    for k, block in enumerate(blocks):
        if re.fullmatch(r"F[\d.]+\n", block):
            rest = blocks[:k] + blocks[k + 1 :]
            found.append("".join(rest))
            for factor in (0.5, 0.9, 1.1, 2.0):
                other = f"F{float(block[1:]) * factor:g}\n"
                found.append("".join([*blocks[:k], other, *blocks[k + 1 :]]))
            for at in (k - 1, k + 1):
                found.append("".join([*rest[:at], block, *rest[at:]]))
    return found


@pytest.mark.parametrize("values", sampled([
    {}, {"corner_share": 1.0}, {"hole_feed_share": 1.0}, {"corner_distance": 1.0},
], 2))  # fmt: skip
@pytest.mark.parametrize("every", [9, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_every_wrong_feed_is_refused(every: int, values: dict[str, float]) -> None:
    """And none that leaves the feed of every move as it is."""
    machine = slowed(**values)
    text = post((PART,), machine).text
    right, wrong = feeds_of(text), 0
    for mutant in mutants(text)[::every]:
        refused = bool(verify_sheet(mutant, (PART,), machine))
        if feeds_of(mutant) == right:
            assert not refused
        else:
            assert refused, mutant
            wrong += 1
    assert wrong >= 30 / every


@pytest.mark.parametrize(("other", "code"), [
    ({"hole_diameter": 12.0}, "verify-sheet-hole-feed"),
    ({"hole_diameter": 60.0}, "verify-sheet-hole-feed"),
    ({"hole_feed_share": 0.7}, "verify-sheet-feed"),
    ({"hole_feed_share": 1.0}, "verify-sheet-hole-feed"),
    ({"corner_share": 0.6}, "verify-sheet-feed"), ({"corner_share": 1.0}, "verify-sheet-feed"),
    ({"corner_distance": 4.5}, "verify-sheet-feed"),
    ({"corner_distance": 5.5}, "verify-sheet-feed"),
    ({"corner_angle": 100.0}, "verify-sheet-feed"),
])  # fmt: skip
@pytest.mark.parametrize("name", sampled(["plate-linuxcnc", "plate-codesys"], 2))
def test_a_program_of_other_shares_is_refused(
    name: str, other: dict[str, float], code: str
) -> None:
    """The program of one row, read by the other: both ways round."""
    one, two = slowed(name), slowed(name, **other)
    found = {d.code for d in verify_sheet(post((PART,), two).text, (PART,), one)}
    assert code in found
    assert verify_sheet(post((PART,), one).text, (PART,), two)


@pytest.mark.parametrize("name", ["plate-linuxcnc", "plate-oxyfuel", "plate-codesys"])
def test_compensation_by_the_machine_is_read_back_too(name: str) -> None:
    """Corners are those of the programmed path, holes those of the drawing."""
    machine = slowed(name, {"kerf_by": "machine", "lead": "line"})
    text = post((PART,), machine).text
    other = slowed(name, {"kerf_by": "machine", "lead": "line"}, hole_diameter=15.0)
    assert "verify-sheet-hole-feed" in {d.code for d in verify_sheet(text, (PART,), other)}


def test_the_times_are_those_of_the_slower_feeds() -> None:
    """By hand: the length of every move by its feed."""
    machine = replace(slowed(), axes=())  # no accelerations are known then
    posted = post((PART,), machine)
    cut = sum(length(p) / f * 60 for stroke in strokes(posted.text) for p, f in stroke)
    assert machine.torch is not None
    plain = post((PART,), replace(slowed(hole_feed_share=1.0, corner_share=1.0), axes=()))
    full = sum(length(p) / f * 60 for stroke in strokes(plain.text) for p, f in stroke)
    gained = sum(posted.time(machine).operations) - sum(plain.time(machine).operations)
    assert gained == pytest.approx(cut - full, abs=0.01)
    assert gained > 1


def test_a_small_rounded_corner_is_one() -> None:
    """An arc of a hundredth turns the path as a corner does; one of five mm does not."""
    for radius, is_one in ((0.01, True), (5.0, False)):
        arc = Arc((100 - radius, radius), radius, 270.0, 90.0)
        ring: tuple[Curve, ...] = (
            Line((0, 0), (100 - radius, 0)), arc, Line((100, radius), (100, 80)),
            Line((100, 80), (0, 80)), Line((0, 80), (0, 0)),
        )  # fmt: skip
        part = drawing(contour(ring), thickness=3.0)
        text = post((part,), slowed("laser-grbl", corner_distance=3.0)).text
        near = [f for x, y, f in grbl_feeds(text) if x > 90 and y < 20]
        assert (min(near) < max(near)) == is_one


def grbl_feeds(text: str) -> list[tuple[float, float, float]]:
    feed, found = 0.0, []
    for block in text.splitlines():
        words = {w[0]: float(w[1:]) for w in re.findall(r"[A-Z]-?[\d.]+", block)}
        feed = words.get("F", feed)
        if words.get("G") in (1, 2, 3) and "X" in words:
            found.append((words["X"], words["Y"], feed))
    return found


@pytest.mark.parametrize(("name", "values"), [
    ("laser-stepper", {"hole_diameter": 20.0, "hole_feed_share": 0.5}),
    ("table-simotion", {"corner_distance": 2.0, "corner_share": 0.5}),
])  # fmt: skip
def test_a_machine_without_words_for_it_is_told(name: str, values: dict[str, float]) -> None:
    machine = load(name)
    assert machine.torch is not None
    rows = tuple(replace(row, **values) for row in machine.torch.rows)
    faults = list(torch_faults(replace(machine, torch=replace(machine.torch, rows=rows))))
    assert {key for key, _ in faults} >= {f"torch.rows.0.{list(values)[1]}"}
