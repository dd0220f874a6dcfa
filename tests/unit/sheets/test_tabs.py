"""Bridges: planned clear of corners, read back by number, width and place, others refused."""

import re
from itertools import pairwise
from math import cos, dist, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.geometry.curves import Arc, Bezier, Curve, Line
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Contour, Part
from beamcam.model.request import Request
from beamcam.pipeline import post, whole_job
from beamcam.planning.contours.outline import stretch
from beamcam.posts import post_of
from tests.conftest import examples, sampled
from tests.unit.sheets.parts import box, circle, contour, drawing, lines

GRBL = load("laser-grbl")
#: A plate with a round and a square hole, and one that is too short for two bridges.
PART = drawing(
    contour(box(0, 0, 80, 60)), contour(circle(20, 30, 20), line=2),
    contour(box(40, 20, 26, 20), line=3), contour(circle(70, 10, 1), line=4), thickness=3.0,
)  # fmt: skip
STROKE = re.compile(r"G0 X(\S+) Y(\S+)\nM4.*\n((?:G[123] .*\n)+)M5")
WORD = re.compile(r"X(\S+) Y(\S+)")


def asked(machine: Machine = GRBL, **values: object) -> Machine:
    return with_torch(machine, thickness=3.0, **values)  # type: ignore[arg-type]


def ends(text: str) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Both ends of each stroke of a program for grbl."""
    found = []
    for x, y, moves in STROKE.findall(text):
        last = WORD.findall(moves)[-1]
        found.append(((float(x), float(y)), (float(last[0]), float(last[1]))))
    return found


@pytest.mark.parametrize(("inner", "counts"), [(False, (1, 1, 1, 2)), (True, (1, 2, 2, 2))])
def test_bridges_by_a_parser_of_the_test(inner: bool, counts: tuple[int, ...]) -> None:
    """The inner contours come first; each bridge of a straight side is as wide as asked."""
    machine = asked(tabs=2, tab_width=1.4, inner_tabs=inner)
    strokes = ends(post((PART,), machine).text)
    rings, first = [], 0
    for k in range(1, len(strokes) + 1):
        if dist(strokes[k - 1][1], strokes[first][0]) < 0.01:
            rings.append(strokes[first:k])
            first = k
    assert first == len(strokes)
    assert sorted(len(ring) - 1 for ring in rings) == sorted(c if c > 1 else 0 for c in counts)
    for ring in rings:
        for (_, end), (start, _) in pairwise(ring):
            assert dist(end, start) == pytest.approx(1.4, abs=0.03)


shapes = st.one_of(
    st.builds(lambda w, h: box(10, 10, w, h), st.floats(5, 60), st.floats(5, 60)),
    st.builds(lambda d: circle(40, 40, d), st.floats(3, 60)),
    st.builds(
        lambda n, r, turn: lines(*[
            (40 + r * cos(turn + 2 * pi * k / n), 40 + r * sin(turn + 2 * pi * k / n))
            for k in range(n)
        ]),
        st.integers(3, 24), st.floats(4, 30), st.floats(0, 6),
    ),
)  # fmt: skip


@settings(max_examples=examples(25), deadline=None)
@given(
    outline=shapes, tabs=st.integers(1, 5), width=st.floats(0.3, 3), clear=st.floats(0, 3),
    kerf_by=st.sampled_from(["none", "offset"]),
    name=st.sampled_from(["laser-grbl", "plate-codesys", "laser-stepper"]),
)  # fmt: skip
def test_whatever_is_planned_is_found_right(
    outline: tuple[Curve, ...], tabs: int, width: float, clear: float, kerf_by: str, name: str
) -> None:
    part = drawing(contour(outline), thickness=3.0)
    machine = asked(
        load(name), tabs=tabs, tab_width=width, min_tab_to_corner=clear, kerf_by=kerf_by,
        lead="none", margin=10.0, place="corner",
    )  # fmt: skip
    assert post((part,), machine).plan.operations


def cut_again(machine: Machine, part: Part, cuts: list[tuple[float, float]]) -> str:
    """The program with the bridges of its last contour from and up to these lengths along it."""
    whole = replace(machine, torch=replace(machine.torch, tabs=0))  # type: ignore[type-var]
    job = whole_job(Request((part,), machine))
    row = post_of(machine)
    plan, closed = row.plan(job), row.plan(whole_job(Request((part,), whole))).operations[-1]  # type: ignore[union-attr]
    curves = closed.passes[0].curves  # type: ignore[union-attr]
    lengths = [curve.length for curve in curves]
    bounds = [0.0, *(end for cut in cuts for end in cut), sum(lengths)]
    last = plan.operations[-1]
    one = last.passes[0]  # type: ignore[union-attr]
    passes = tuple(
        replace(one, lead_in=(), curves=stretch(curves, lengths, a, b), lead_out=())
        for a, b in zip(bounds[::2], bounds[1::2], strict=True)
    )
    changed = replace(plan, operations=(*plan.operations[:-1], replace(last, passes=passes)))  # type: ignore[type-var]
    return str(row.emit(row.motion(changed, machine, "JOB"), job))


OUTLINE = drawing(contour(box(0, 0, 80, 60)), thickness=3.0)  # 280 mm round, corners at 0, 80, ...
MISPLACED = {
    "as many, as wide": ([(20, 21), (160, 161)], set()),
    "a bridge too few": ([(69.5, 70.5)], {"verify-sheet-tabs"}),
    "none": ([], {"verify-sheet-tabs"}),
    "a bridge too many": ([(20, 21), (100, 101), (180, 181)], {"verify-sheet-tabs"}),
    "a narrow one": ([(20, 20.9), (160, 161)], {"verify-sheet-tab-width"}),
    "a wide one": ([(20, 21.02), (160, 161)], set()),  # by no more than a path may be off
    "the other a little wider": ([(20, 21), (160, 161.1)], {"verify-sheet-tab-width"}),
    "one far too wide": ([(20, 21), (160, 165)], {"verify-sheet-open", "verify-sheet-missing"}),
    "one beside the other": ([(20, 21), (40, 41)], {"verify-sheet-tab-place"}),
    "both at one end": ([(20, 21), (85, 86)], {"verify-sheet-tab-place"}),
    "over a corner": ([(79.293, 80.707), (219.293, 220.707)], {"verify-sheet-tab-place"}),
    "over a corner, as much of the contour as its width": (
        [(79.5, 80.5), (220.5, 221.5)], {"verify-sheet-tab-width", "verify-sheet-tab-place"},
    ),
    "beside a corner": ([(20, 21), (140.7, 141.7)], {"verify-sheet-tab-place"}),
}  # fmt: skip


@pytest.mark.parametrize("fault", MISPLACED)
def test_bridges_elsewhere_are_refused(fault: str) -> None:
    cuts, codes = MISPLACED[fault]
    machine = asked(tabs=2, min_tab_to_corner=2.0)
    text = cut_again(machine, OUTLINE, [(float(a), float(b)) for a, b in cuts])
    assert {one.code for one in verify_sheet(text, (OUTLINE,), machine)} == codes


def comb(teeth: int, wide: float, long: float) -> tuple[Curve, ...]:
    """A bar of 10 mm with teeth and gaps on one side, and square corners all over."""
    points = [(0.0, 0.0), (2 * teeth * wide, 0.0), (2 * teeth * wide, 10.0)]
    for k in range(teeth, 0, -1):
        right, left = (2 * k - 1) * wide, (2 * k - 2) * wide
        points += [(right, 10.0), (right, 10.0 + long), (left, 10.0 + long), (left, 10.0)]
    return lines(*((10 + x, 10 + y) for x, y in points))


@settings(max_examples=examples(20), deadline=None)
@given(
    outline=st.one_of(
        shapes, st.builds(comb, st.integers(2, 9), st.floats(1, 4), st.floats(0.5, 20))
    ),
    tabs=st.integers(1, 6), width=st.floats(0.4, 1.5),
)  # fmt: skip
def test_what_holds_is_as_wide_as_asked(
    outline: tuple[Curve, ...], tabs: int, width: float
) -> None:
    """From one end of the cut to the other, over corners, round bends and beside narrow teeth."""
    machine = asked(tabs=tabs, tab_width=width, lead="none", min_tab_to_corner=0.0)
    strokes = ends(post((drawing(contour(outline), thickness=3.0),), machine).text)
    for (_, end), (start, _) in pairwise(strokes):
        assert dist(end, start) == pytest.approx(width, abs=0.03)


def test_a_bridge_at_a_corner_passes_where_no_place_is_better() -> None:
    """On a side of 5 mm there is no place 4 mm off both corners."""
    part = drawing(contour(box(0, 0, 5, 5)), thickness=3.0)
    machine = asked(tabs=1, min_tab_to_corner=4.0)
    assert post((part,), machine).text.count("M4") == 2


@pytest.mark.parametrize(("boxes", "tabs", "width"), [
    ([(10, 10, 26.82, 28), (36.82, 10.54, 7.2, 29.78), (10, 38, 26.82, 29.78)], 3, 1.1),
    ([(10, 10, 18.1, 30.6), (28.1, 10, 33, 30.6), (10, 40.6, 18.1, 17.2)], 3, 1.2),
])  # fmt: skip
def test_bridges_of_parts_that_share_edges_are_found(
    boxes: list[tuple[float, float, float, float]], tabs: int, width: float
) -> None:
    """An edge that two parts share is cut once, up to a bridge in the corner of one of them."""
    part = drawing(*(contour(box(*one), line=k) for k, one in enumerate(boxes, 1)), thickness=3.0)
    machine = asked(tabs=tabs, tab_width=width, kerf_by="none", lead="none", inner_tabs=True)
    assert post((part,), machine).plan.operations


def test_bridges_keep_their_distance_to_corners_of_their_own_contour_alone() -> None:
    """A corner of the part beside it may lie beside a bridge."""
    boxes = [(10, 10, 22, 30), (32, 13, 20, 12)]
    part = drawing(*(contour(box(*one), line=k) for k, one in enumerate(boxes, 1)), thickness=3.0)
    for clear in (1.0, 3.0):
        machine = asked(tabs=2, min_tab_to_corner=clear, kerf_by="none", lead="none")
        assert post((part,), machine).plan.operations


def test_an_inner_contour_with_a_bridge_is_refused_unless_asked_for() -> None:
    both, outer = asked(tabs=1, inner_tabs=True), asked(tabs=1)
    for made, machine in ((both, outer), (outer, both)):
        said = verify_sheet(post((PART,), made).text, (PART,), machine)
        assert {one.code for one in said} == {"verify-sheet-tabs"}


def open_line(*curves: Curve, line: int) -> Contour:
    return replace(contour(curves, line=line), kind="open", closed=False)


@pytest.mark.parametrize("overcut", [0.0, 1.0])
@pytest.mark.parametrize(
    "lines_cut",
    [
        (Line((100, 10), (100.6, 10)),),
        (Line((100, 10), (100.6, 10)), Line((100.6, 10), (100, 10))),
        (Arc((0.5, 59.625), 0.625, 36.86989764584402, 106.26020470831199),),
    ],
    ids=["short line", "there and back", "arc with both ends on an edge"],
)
def test_what_is_cut_is_no_bridge(lines_cut: tuple[Curve, ...], overcut: float) -> None:
    """Open cuts whose ends are as far apart as a bridge is wide, by themselves or on a contour."""
    part = drawing(contour(box(0, 0, 80, 60)), open_line(*lines_cut, line=2), thickness=3.0)
    machine = asked(tabs=2, tab_width=1.0, overcut=overcut, allow_open=True)
    text = post((part,), machine).text
    assert not verify_sheet(text, (part,), machine)


@pytest.mark.parametrize("overcut", sampled([0.6, 0.3, 1.0], 3))
@pytest.mark.parametrize("tabs", [0, 1, 2])
@pytest.mark.parametrize("radius", [0.7, 1.1, 3.0])
def test_overcut_of_a_ring_of_cubics(radius: float, tabs: int, overcut: float) -> None:
    """Where its overcut begins a move ends, whatever arcs are fitted to it."""
    k = 0.5522847498 * radius
    at = [(radius, 0), (0, radius), (-radius, 0), (0, -radius), (radius, 0)]
    ring = tuple(
        Bezier(
            ((20 + x0, 20 + y0), (20 + x0 - k / radius * y0, 20 + y0 + k / radius * x0),
             (20 + x1 + k / radius * y1, 20 + y1 - k / radius * x1), (20 + x1, 20 + y1))
        )
        for (x0, y0), (x1, y1) in pairwise(at)
    )  # fmt: skip
    part = drawing(contour(ring), thickness=3.0)
    machine = asked(tabs=tabs, tab_width=0.8, overcut=overcut)
    text = post((part,), machine).text
    assert not verify_sheet(text, (part,), machine)
