"""What a beam leaves: the part, its corners, slots and necks, and programs that are wrong there."""

import re
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.checks.sheets.region import region_of
from beamcam.checks.sheets.toolpaths import Toolpaths
from beamcam.errors import PlanError
from beamcam.geometry.curves import Arc, BSpline, Curve, Line
from beamcam.machine import Machine
from beamcam.model.part import Part
from beamcam.pipeline import post

from .parts import box, circle, contour, drawing, lines, table

MACHINE = table(kerf=1.2, thickness=3.0, min_hole=0.0, min_hole_share=0.0)
TOLERANCE = 0.02

#: A quarter of a circle as a spline with a weight.
QUARTER = BSpline(
    2, ((40.0, 0.0), (40.0, 40.0), (0.0, 40.0)), (0, 0, 0, 1, 1, 1), (1.0, 0.5**0.5, 1.0)
)
SHAPES = {
    "chamfer shorter than the kerf": contour(
        lines((0, 0), (40, 0), (40, 0.4), (60, 20), (60, 40), (0, 40))
    ),
    "chamfered hole": contour(lines((20, 20), (40, 20), (40, 20.2), (55, 35), (20, 35))),
    "acute corner": contour(lines((0, 0), (60, 0), (30, 12), (60, 40), (0, 40))),
    "arcs in a corner": contour(
        (*lines((0, 0), (50, 0), (50, 30), closed=False), Arc((49.7, 30.0), 0.3, 0.0, 90.0),
         *lines((49.7, 30.3), (0, 30.3), (0, 0), closed=False))
    ),
    "rational quarter": contour((Line((0.0, 0.0), (40.0, 0.0)), QUARTER, Line((0, 40), (0, 0)))),
}  # fmt: skip


def part_of(name: str) -> Part:
    """A shape, in a plate with a window where it is a hole."""
    shape = SHAPES[name]
    if "hole" in name:
        return drawing(contour(box(0, 0, 80, 60)), shape, thickness=3.0)
    return drawing(shape, thickness=3.0)


def codes(text: str, part: Part, machine: Machine = MACHINE) -> set[str]:
    return {
        said.code.removeprefix("verify-sheet-") for said in verify_sheet(text, (part,), machine)
    }


def moved(text: str, by: float, letter: str = "X") -> str:
    """All of the work farther along an axis."""
    return re.sub(rf"{letter}(\S+)", lambda m: f"{letter}{float(m[1]) + by:.4f}", text)


def strokes(text: str) -> list[str]:
    """The blocks from each traverse to the end of its cut."""
    return re.findall(r"^G0 X\S+ Y\S+\nM3.*?\nM5\n", text, re.M | re.S)


def led_through_the_part(text: str) -> str:
    """The way in of the last stroke from the other side of its contour."""
    first = strokes(text)[-1]
    start = re.match(r"G0 X(\S+) Y(\S+)", first)
    assert start
    arc = re.search(r"^G[23] X(\S+) Y(\S+).*$", first, re.M)
    assert arc
    (x0, y0), (x1, y1) = (map(float, found.groups()) for found in (start, arc))
    away = f"G0 X{2 * x1 - x0:.4f} Y{2 * y1 - y0:.4f}"
    straight = f"G1 X{arc[1]} Y{arc[2]}"
    return text.replace(first, first.replace(start[0], away).replace(arc[0], straight))


WRONG: list[Callable[[str], str]] = [
    lambda text: moved(text, 2 * TOLERANCE),
    lambda text: moved(text, -2 * TOLERANCE, "Y"),
    lambda text: moved(text, 0.6),
    lambda text: text.replace(strokes(text)[-1], ""),
    lambda text: text.replace(strokes(text)[0], strokes(text)[0] * 2),
    led_through_the_part,
]


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_that_sampling_misjudged(name: str) -> None:
    part = part_of(name)
    text = post((part,), MACHINE).text
    assert codes(text, part) == set()
    for number, change in enumerate(WRONG):
        assert codes(change(text), part), (name, number)


@pytest.mark.parametrize("name", SHAPES)
def test_the_other_side_of_the_kerf(name: str) -> None:
    """What is cut for a hole is no part."""
    part = part_of(name)
    features = part.features
    inside_out = drawing(contour(box(-20, -20, 120, 100)), *features, thickness=3.0)
    assert "side" in codes(post((inside_out,), table(kerf=1.2, thickness=3.0, margin=5.0)).text,
                           drawing(*features, thickness=3.0),
                           table(kerf=1.2, thickness=3.0, margin=25.0))  # fmt: skip


def posted_for(cut: Part, wanted: Part) -> set[str]:
    """What is said of a program for one part that is compared with another."""
    return codes(post((cut,), MACHINE).text, wanted)


def test_a_slot_that_the_beam_passes() -> None:
    """A slot of 0.6 mm is not in the part, however small the kerf's excuse for corners."""
    plain = drawing(contour(box(0, 0, 60, 40)), thickness=3.0)
    slot = lines((0, 0), (60, 0), (60, 40), (30.6, 40), (30.6, 20), (30, 20), (30, 40), (0, 40))
    assert "missing" in posted_for(plain, drawing(contour(slot), thickness=3.0))


def test_a_neck_that_the_beam_does_not_pass() -> None:
    """Both chambers of a hole are cut, and the neck between them is not."""
    plate = contour(box(0, 0, 80, 60))
    chambers = drawing(
        plate, contour(box(10, 20, 20, 20)), contour(box(34, 20, 20, 20)), thickness=3.0
    )
    joined = lines(
        (10, 20), (30, 20), (30, 29.7), (34, 29.7), (34, 20), (54, 20), (54, 40), (34, 40),
        (34, 30.3), (30, 30.3), (30, 40), (10, 40),
    )  # fmt: skip
    assert "missing" in posted_for(chambers, drawing(plate, contour(joined), thickness=3.0))


def test_a_neck_cut_through() -> None:
    """A web of the part is cut along its middle."""
    part = drawing(contour(box(0, 0, 80, 60)), thickness=3.0)
    text = post((part,), MACHINE).text
    last = strokes(text)[-1]
    across = last + "G0 X50 Y8\nM3 S1\nG4 P0.2\nF5200\nG1 X50 Y72\nM5\n"
    assert codes(text.replace(last, across), part) >= {"extra", "band"}


def toolpaths(*curves: Curve) -> Toolpaths:
    return Toolpaths(list(curves), TOLERANCE / 8)


def in_part(curves: list[Curve], features: list[int], *points: tuple[float, float]) -> list[bool]:
    found = region_of(toolpaths(*curves), np.array(features), 0.05, TOLERANCE / 8)
    inside: list[bool] = found.in_part(np.array(points)).tolist()
    return inside


SQUARE = list(box(0, 0, 30, 30))
PLACES = [(1.0, 1.0), (15.0, 15.0), (40.0, 1.0)]


def test_the_part_is_what_an_odd_number_of_contours_enclose() -> None:
    hole, island = list(box(5, 5, 20, 20)), list(circle(15, 15, 4))
    assert in_part(SQUARE, [0] * 4, *PLACES) == [True, True, False]
    assert in_part(SQUARE + hole, [0] * 4 + [1] * 4, *PLACES) == [True, False, False]
    both = SQUARE + hole + island
    assert in_part(both, [0] * 4 + [1] * 4 + [2], *PLACES) == [True, True, False]


@pytest.mark.parametrize(
    "more",
    [
        box(0, 0, 30, 30),
        box(0.02, 0.01, 29.99, 30),
        lines((10, 0), (20, 0), closed=False),
        lines((20, 0), (45, 0), closed=False),
        lines((10, 10), (20, 10), closed=False),
        lines((10, 10), (20, 10), (10, 10), closed=False),
    ],
    ids=["twice", "almost twice", "an edge in part", "an edge and more", "open", "there and back"],
)
def test_what_is_no_contour_of_its_own(more: tuple[Curve, ...]) -> None:
    features = [0] * 4 + [1] * len(more)
    assert in_part(SQUARE + list(more), features, *PLACES) == [True, True, False]


def test_rings_of_many_features() -> None:
    """Lines in any order and direction, with a gap, an overlap, and one that leads nowhere."""
    loose: list[Curve] = [
        Line((0, 0), (20, 0)), Line((30, 30), (30, 0.04)), Line((30, 0), (15, 0)),
        Line((0, 30), (30, 30)), Line((0, 30), (0, 0)), Line((30, 30), (40, 40)),
    ]  # fmt: skip
    assert in_part(loose, list(range(6)), *PLACES) == [True, True, False]


def test_rings_that_touch_in_a_corner() -> None:
    squares = [*box(0, 0, 30, 30), *box(30, 30, 30, 30)]
    places = [(1.0, 1.0), (45.0, 45.0), (45.0, 1.0)]
    assert in_part(squares, list(range(8)), *places) == [True, True, False]


def test_paths_follow_one_another() -> None:
    """The pieces of a stroke lead on where the one before ends, after compensation too."""
    machine = table(kerf=1.2, thickness=3.0, kerf_by="machine", lead="line")
    from beamcam.checks.sheets.compensation import compensated
    from beamcam.controllers import table_run

    part = drawing(contour(box(0, 0, 60, 40)), contour(circle(20, 20, 12)), thickness=3.0)
    done, _ = table_run(post((part,), machine).text, machine)
    cut = [leg for leg in done.moves.each() if not leg.rapid]
    first = next(k for k, (a, b) in enumerate(pairwise(cut), 1) if a.end != b.start)
    beam = compensated(cut[:first], "left", 0.6)
    assert all(a.end == b.start for a, b in pairwise(beam))
    assert len(beam) >= first


def test_what_is_too_small_to_be_cut_is_posted() -> None:
    """A line no longer than the gap is told, and neither cut nor asked for."""
    dot = contour(lines((30, 20), (30.01, 20), closed=False))
    posted = post((drawing(contour(box(0, 0, 60, 40)), dot, thickness=3.0),), MACHINE)
    assert "plan-tiny" in {said.code for said in posted.remarks}
    assert "plan-left-out" not in {said.code for said in posted.remarks}
    assert len(strokes(posted.text)) == 1


@pytest.mark.parametrize("diameter", [1.22, 1.26, 1.3, 1.34])
def test_a_hole_hardly_wider_than_the_kerf_is_cut_once(diameter: float) -> None:
    """Its path is so small that many samples lie near the place where it closes."""
    hole = contour(circle(30, 30, diameter))
    part = drawing(contour(box(0, 0, 80, 60)), hole, thickness=3.0)
    text = post((part,), MACHINE).text
    assert not codes(text, part)
    (first, *_) = re.findall(r"^G0 X\S+ Y\S+\nM3(?:.|\n)*?M5\n", text, re.M)
    assert "twice" in codes(text.replace(first, first * 2), part)


@pytest.mark.parametrize("wide", [0.03, 0.05, 0.2, 1.0])
@pytest.mark.parametrize("high", [0.3, 1.0, 5.0])
@pytest.mark.parametrize("lean", [0.3, 0.7, 2.0])
def test_under_a_needle_that_leans_is_a_corner_that_no_beam_reaches(
    wide: float, high: float, lean: float
) -> None:
    """The beam touches the tip and the edge below it, or cuts the other side of a thin wall."""
    base = ((0, 0), (40, 0), (40, 30), (20 + wide / 2, 30))
    part = drawing(
        contour(lines(*base, (20 + lean * high, 30 + high), (20 - wide / 2, 30), (0, 30)))
    )
    if (lean, high) == (2.0, 1.0):  # the tip stands before more than a kerf of it
        with pytest.raises(PlanError, match=r"plan-narrow: found a place 1.094 mm wide"):
            post([part], MACHINE)
        return
    said = verify_sheet(post([part], MACHINE).text, [part], MACHINE)
    assert {one.code for one in said} == ({"verify-sheet-left"} if lean == 2.0 < high else set())
