"""Round openings of drawings that a torch cannot cut are for the drill, as holes of parts are."""

import re
from itertools import pairwise
from math import cos, pi, radians, sin, tau

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import PlanError
from beamcam.geometry.curves import Arc, Bezier, Curve, Line
from beamcam.machine import Machine, load
from beamcam.model.part import Hole, Part
from beamcam.model.plan import SheetPlan
from beamcam.model.request import Request
from beamcam.pipeline import post
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.opinion import solid_faults
from tests.unit.sheets.parts import S, box, circle, contour, drawing, lines, plate, table

#: On 6 mm plate-linuxcnc cuts holes of 4.8 mm and larger.
OUTLINE = contour(box(0, 0, 200, 100), line=1)
SMALL, LARGE = contour(circle(50, 50, 4), line=2), contour(circle(120, 50, 20), line=3)
PART = drawing(OUTLINE, SMALL, LARGE)


def by_beziers(x: float, y: float, diameter: float) -> tuple[Curve, ...]:
    r, k = diameter / 2, 0.5522847498 * diameter / 2
    at = [(r, 0.0), (0.0, r), (-r, 0.0), (0.0, -r), (r, 0.0)]
    return tuple(
        Bezier(((x + a, y + b), (x + a - k / r * b, y + b + k / r * a),
                (x + c + k / r * d, y + d - k / r * c), (x + c, y + d)))
        for (a, b), (c, d) in pairwise(at)
    )  # fmt: skip


def polygon(x: float, y: float, diameter: float, corners: int) -> tuple[Curve, ...]:
    turn = [tau * k / corners for k in range(corners)]
    return lines(*((x + diameter / 2 * np.cos(a), y + diameter / 2 * np.sin(a)) for a in turn))


def crosses(text: str) -> list[tuple[float, ...]]:
    """The strokes that mark: X and Y of both ends."""
    return [
        tuple(map(float, ends)) for ends in re.findall(
            r"G0 X(\S+) Y(\S+)\nM3 \$1.*\n(?:G4.*\n)?(?:F.*\n)?G1 X(\S+) Y(\S+)", text
        )
    ]  # fmt: skip


def codes(text: str, part: Part, machine: Machine) -> set[str]:
    return {d.code for d in verify_sheet(text, (part,), machine)}


def hand(part: Part, machine: Machine) -> list[int]:
    """The features that a plan leaves for manual work."""
    plan = post((part,), machine).plan
    assert isinstance(plan, SheetPlan)
    return [o.feature[1] for o in plan.outcomes if o.how == "listed"]


@pytest.mark.parametrize(
    "small", [circle(50, 50, 4), by_beziers(50, 50, 4),
              (Arc((50, 50), 2, 0, 180), Arc((50, 50), 2, 180, 180)), polygon(50, 50, 4, 64)],
)  # fmt: skip
def test_its_centre_is_marked_as_that_of_a_hole(small: tuple[Curve, ...]) -> None:
    machine = table()
    part = drawing(OUTLINE, contour(small, line=2), LARGE)
    posted = post((part,), machine)
    assert hand(part, machine) == [1]
    assert codes(posted.text, part, machine) == {"verify-by-hand"}
    own = post((plate(Hole("v", 50, 50, 4.0, S)),), machine).text
    # Arcs that stand for chords lie within the tolerance of them.
    found, wanted = (sorted(crosses(text)) for text in (posted.text, own))
    assert len(found) == len(wanted) == 2
    for one, other in zip(found, wanted, strict=True):
        assert one == pytest.approx(other, abs=0.01)


@pytest.mark.parametrize("corners", [4, 6, 8, 12])
def test_what_is_no_circle_is_cut(corners: int) -> None:
    part = drawing(OUTLINE, contour(polygon(50, 50, 4, corners), line=2))
    assert hand(part, table()) == []
    assert codes(post((part,), table()).text, part, table()) <= {"verify-sheet-uncut"}


def test_a_disc_is_a_part() -> None:
    part = drawing(OUTLINE, contour(circle(120, 50, 20)), contour(circle(120, 50, 4)))
    assert hand(part, table(lead="none")) == []
    lonely = drawing(contour(circle(0, 0, 4)))
    assert hand(lonely, table(lead="none")) == []


def test_a_circle_within_one_and_one_that_lies_on_it_go_with_it() -> None:
    part = drawing(OUTLINE, SMALL, contour(circle(50, 50, 2), line=4), contour(circle(50, 50, 4)))
    machine = table()
    text = post((part,), machine).text
    assert hand(part, machine) == [1, 2]
    assert codes(text, part, machine) == {"verify-by-hand"}


def test_an_outline_of_single_lines_encloses_too() -> None:
    sides = [contour((side,), line=k) for k, side in enumerate(OUTLINE.curves)]
    part = drawing(*sides, SMALL)
    assert hand(part, table()) == [4]
    assert codes(post((part,), table()).text, part, table()) == {"verify-by-hand"}


def test_a_table_that_spots_spots_it() -> None:
    machine = load("plate-qtplasmac")
    text = post((PART,), machine).text
    assert text.count("M3 $2") == 1
    assert codes(text, PART, machine) == {"verify-by-hand"}


def test_a_table_that_marks_nothing_refuses_it_or_leaves_it_out() -> None:
    machine = table(drilled="refuse")
    with pytest.raises(PlanError, match=r"plan-tool.* of diameter 4.*at least 4.8"):
        post((PART,), machine)
    posted = post((PART,), machine, skips=("tool",))
    assert "plan-left-out" in {d.code for d in posted.remarks}
    assert {d.code for d in verify_sheet(posted.text, (PART,), machine, skips=("tool",))} == {
        "verify-left-out"
    }


def test_a_program_that_cuts_it_is_refused() -> None:
    cutting = table(min_hole=0.0, min_hole_share=0.0)
    text = post((PART,), cutting).text
    assert "verify-sheet-extra" in codes(text, PART, table())
    without = drawing(OUTLINE, LARGE)
    assert "verify-sheet-missing" in codes(post((without,), table()).text, PART, table())


def test_a_cross_that_reaches_beyond_the_part_lies_on_the_table_too() -> None:
    """The corner of all that is made lies at the table's, as the read-back places it."""
    tiny = drawing(contour(box(0, 0, 6, 4), line=1), contour(circle(1.5, 2, 1), line=2))
    machine = table(lead="none", kerf=0.3)
    assert codes(post((tiny,), machine).text, tiny, machine) == {"verify-by-hand"}


def slot(x: float, y: float, length: float, width: float, turn: float) -> tuple[Curve, ...]:
    """Two lines and two half circles about a middle, turned by degrees."""
    a, b, r = cos(radians(turn)), sin(radians(turn)), width / 2
    half = length / 2 - r

    def at(u: float, v: float) -> tuple[float, float]:
        return x + a * u - b * v, y + b * u + a * v

    return (
        Line(at(-half, -r), at(half, -r)), Arc(at(half, 0), r, turn - 90.0, 180.0),
        Line(at(half, r), at(-half, r)), Arc(at(-half, 0), r, turn + 90.0, 180.0),
    )  # fmt: skip


@pytest.mark.parametrize("turn", [0.0, 90.0, 30.0, -17.3])
def test_the_ends_of_a_narrow_slot_are_marked(turn: float) -> None:
    """24 x 4 on 6 mm: the middles of its ends lie 10 mm from its own."""
    machine = table()
    part = drawing(OUTLINE, contour(slot(60, 50, 24, 4, turn), line=2), LARGE)
    text = post((part,), machine).text
    assert hand(part, machine) == [1]
    assert codes(text, part, machine) == {"verify-by-hand"}
    middles = sorted(
        {(round((a + c) / 2, 3), round((b + d) / 2, 3)) for a, b, c, d in crosses(text)}
    )
    c, s = 10 * cos(radians(turn)), 10 * sin(radians(turn))
    expected = sorted([(70 - c, 60 - s), (70 + c, 60 + s)])
    assert len(middles) == 2
    for found, wanted in zip(middles, expected, strict=True):
        assert found == pytest.approx(wanted, abs=1e-3)
    rows = manual_rows(post((part,), machine).plan)
    assert [(row["kind"], row["size"]) for row in rows] == [("slot", "24 x 4")]
    assert (rows[0]["x"], rows[0]["y"]) == pytest.approx((60, 50))
    assert {d.code for d in solid_faults(text, Request((part,), machine, name="a"))} == {
        "solid-left-out"
    }


def test_a_slot_as_wide_as_the_torch_can_cut_and_a_window_are_cut() -> None:
    for narrow in (slot(60, 50, 24, 4.8, 30.0), box(50, 48, 24, 4)):
        part = drawing(OUTLINE, contour(narrow, line=2))
        assert hand(part, table(lead="none")) == []


def test_a_slot_that_nothing_marks_is_refused_as_one() -> None:
    part = drawing(OUTLINE, contour(slot(60, 50, 24, 4, 0.0), line=2))
    machine = table(drilled="refuse")
    with pytest.raises(PlanError, match=r"plan-slot.*24 x 4.*at least 4.8 wide"):
        post((part,), machine)
    posted = post((part,), machine, skips=("slot",))
    assert {d.code for d in verify_sheet(posted.text, (part,), machine, skips=("slot",))} == {
        "verify-left-out"
    }


@given(
    width=st.floats(0.5, 8.0), more=st.floats(0.0, 40.0), turn=st.floats(-180.0, 180.0),
    thickness=st.floats(1.0, 9.0), loose=st.booleans(),
)  # fmt: skip
def test_slots_of_any_size_are_read_back(
    width: float, more: float, turn: float, thickness: float, loose: bool
) -> None:
    curves = slot(100, 50, width + more, width, turn) if more > 1.0 else circle(100, 50, width)
    drawn = [contour((c,), line=k) for k, c in enumerate(curves, 2)] if loose else [contour(curves)]
    part = drawing(OUTLINE, *drawn, thickness=thickness)
    machine = table(lead="none", kerf=0.3)
    is_small = width < max(4.0, 0.8 * thickness)
    assert bool(hand(part, machine)) == is_small
    post((part,), machine)


def test_the_solid_knows_it() -> None:
    request = Request((PART,), table(), name="a.ngc")
    said = {d.code for d in solid_faults(post((PART,), table()).text, request)}
    assert said == {"solid-left-out"}
    wrong = post((PART,), table(min_hole=0.0, min_hole_share=0.0)).text
    assert {d.code for d in solid_faults(wrong, Request((PART,), table()))} & {
        "solid-missing", "solid-extra"
    }  # fmt: skip


@given(
    diameters=st.lists(st.floats(0.5, 12.0), min_size=1, max_size=5),
    thickness=st.floats(1.0, 12.0), turned=st.booleans(),
)  # fmt: skip
def test_the_smaller_ones_are_marked_and_all_is_read_back(
    diameters: list[float], thickness: float, turned: bool
) -> None:
    drawn = [
        contour((Arc((30.0 * k - 25, 50), d / 2, 90.0 * turned, 360.0),), line=k)
        for k, d in enumerate(diameters, 2)
    ]
    part = drawing(OUTLINE, *drawn, thickness=thickness)
    least = max(4.0, 0.8 * thickness)
    machine = table(lead="none", kerf=0.3)
    posted = post((part,), machine)
    small = [k for k, d in enumerate(diameters, 1) if d < least]
    assert hand(part, machine) == small
    assert sum(d.code == "plan-by-hand" for d in posted.remarks) == len(small)
    cut = re.findall(r"^G[23] X.* I\S+ J\S+", posted.text, re.M)
    length = sum(pi * d for d in diameters if d >= least)
    assert bool(cut) == (length > 0.0)
