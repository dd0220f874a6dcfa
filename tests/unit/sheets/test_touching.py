"""Contours that touch one another or themselves at corners, as those of square codes do."""

from math import cos, radians, sin

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import PlanError
from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import Point
from beamcam.model.part import Part
from beamcam.pipeline import post
from tests.conftest import examples
from tests.unit.sheets.parts import box, circle, contour, drawing, lines, table

MACHINE = table("plate-linuxcnc")
Cell = tuple[int, int]
#: Steps round a cell, and to the cell beside each of its sides.
SIDES = (((0, 0), (1, 0), (0, -1)), ((1, 0), (1, 1), (1, 0)),
         ((1, 1), (0, 1), (0, 1)), ((0, 1), (0, 0), (-1, 0)))  # fmt: skip


def rings(cells: set[Cell]) -> list[list[Cell]]:
    """The edges of cells as rings, which go on along the waste where cells share a corner only."""
    onward: dict[Cell, list[Cell]] = {}
    for x, y in sorted(cells):
        for (ax, ay), (bx, by), (ox, oy) in SIDES:
            if (x + ox, y + oy) not in cells:
                onward.setdefault((x + ax, y + ay), []).append((x + bx, y + by))
    found = []
    while onward:
        at = start = min(onward)
        came, ring = (0, 0), []
        while True:
            ring.append(at)
            ends = onward[at]
            # The part is on the left: turning right stays at the same waste.
            right = (at[0] + came[1], at[1] - came[0])
            to = right if right in ends else ends[0]
            ends.remove(to)
            if not ends:
                del onward[at]
            came, at = (to[0] - at[0], to[1] - at[1]), to
            if at == start and (at not in onward or len(ring) > 3):
                break
        found.append(ring)
    return found


def code(cells: set[Cell], size: float = 12.0, turned_deg: float = 0.0) -> Part:
    """A part of square cells, drawn by their edges."""
    x, y = cos(radians(turned_deg)) * size, sin(radians(turned_deg)) * size

    def place(cell: Cell) -> Point:
        return (cell[0] * x - cell[1] * y, cell[0] * y + cell[1] * x)

    found = rings(cells)
    return drawing(*(contour(lines(*map(place, ring)), line=k) for k, ring in enumerate(found)))


STAIRS = {(0, 0), (1, 1), (2, 2)}


@pytest.mark.parametrize("cells", [
    STAIRS, {(0, 0), (1, 0), (1, 1), (2, 2), (2, 1), (3, 0)},
    {(0, 0), (1, 1), (0, 2), (-1, 1)},
], ids=["stairs", "bent", "round"])  # fmt: skip
@pytest.mark.parametrize("turned_deg", [0.0, 27.0])
def test_squares_that_share_a_corner_are_cut(cells: set[Cell], turned_deg: float) -> None:
    part = code(cells, turned_deg=turned_deg)
    text = post((part,), MACHINE).text
    more = code({*cells, (9, 9)}, turned_deg=turned_deg)
    assert "verify-sheet-missing" in {said.code for said in verify_sheet(text, (more,), MACHINE)}


@settings(deadline=None, max_examples=examples(25))
@given(
    st.sets(st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=1, max_size=18),
    st.sampled_from([5.0, 12.0]), st.sampled_from([0.0, 45.0, 61.0]),
)  # fmt: skip
def test_a_square_code_is_cut_or_refused_by_the_planner(
    cells: set[Cell], size: float, turned_deg: float
) -> None:
    try:
        post((code(cells, size, turned_deg),), MACHINE)
    except PlanError as error:
        code_said = error.diagnostics[0].code
        assert code_said.startswith("plan-")  # never by the read-back
        event(f"refused, {code_said}")
    else:
        event("made")


# --- edges of two contours ------------------------------------------------------------------------

#: Two boxes that share a longest edge, and five of which one has none for itself; clockwise where
#: the part at the far side of that edge lies left of it.
SIDE_BY_SIDE = [lines((0, 0), (0, 140), (40, 140), (40, 0)), box(40, 0, 80, 140)]
BETWEEN = [lines((50, 0), (50, 140), (90, 140), (90, 0)), box(0, 0, 50, 140), box(90, 0, 50, 140),
           box(0, 140, 140, 40), box(0, -40, 140, 40)]  # fmt: skip


@pytest.mark.parametrize("direction", ["climb", "conventional"])
@pytest.mark.parametrize("boxes", [SIDE_BY_SIDE, BETWEEN], ids=["two", "between"])
def test_boxes_with_a_shared_edge_are_outlines_and_go_round_as_such(
    boxes: list[tuple[Curve, ...]], direction: str
) -> None:
    """Beside a shared edge the part is on both sides, so that it says nothing of the waste."""
    part = drawing(*(contour(curves, line=k) for k, curves in enumerate(boxes, 1)))
    machine, other = (
        table("plate-codesys", kerf_by="none", direction=way)
        for way in (direction, "conventional" if direction == "climb" else "climb")
    )
    text = post((part,), machine).text
    assert "verify-sheet-direction" in {said.code for said in verify_sheet(text, (part,), other)}


@pytest.mark.parametrize(("boxes", "asked"), [
    ([box(0, 0, 100, 20), box(0, 20, 50, 60)], {"common_cuts": True}),
    ([box(0, 50, 50, 30), box(0, 120, 50, 30), box(0, 150, 50, 40), box(50, 50, 50, 140)],
     {"kerf_by": "none", "start": "drawn"}),
], ids=["in an edge", "at a corner"])  # fmt: skip
def test_no_bridge_is_where_the_rest_of_another_contour_is_begun(
    boxes: list[tuple[Curve, ...]], asked: dict[str, object]
) -> None:
    """It would be cut there, and the torch would pierce on the edge of a part."""
    part = drawing(*(contour(curves, line=k) for k, curves in enumerate(boxes, 1)))
    for tabs in (1, 2, 3, 4):
        text = post((part,), table("plate-codesys", tabs=tabs, **asked)).text
        assert text.count("M03") > len(boxes)


def test_what_is_left_of_a_contour_holds_a_hole_until_its_last_piece() -> None:
    """Above and below of the box in the middle are cut one by one, its hole between or before."""
    boxes = [box(0, 0, 30, 20), box(80, 0, 40, 140), box(30, 0, 50, 20)]
    hole = contour(circle(61, 10, 12), line=9)
    part = drawing(*(contour(curves, line=k) for k, curves in enumerate(boxes, 1)), hole)
    machine = table("plate-codesys", kerf_by="none", lead="none", start="drawn")
    text = post((part,), machine).text
    blocks = [f"{block}M05\n" for block in text.split("M05\n")]
    (cut,) = [k for k, block in enumerate(blocks) if "G03" in block]
    rests = [k for k, block in enumerate(blocks) if block.count("G01") == 1]
    assert len(rests) == 2
    others = [block for k, block in enumerate(blocks) if k != cut]
    for place in range(1, len(others)):
        moved = "".join([*others[:place], blocks[cut], *others[place:]]).removesuffix("M05\n")
        codes = {said.code for said in verify_sheet(moved, (part,), machine)}
        behind = place > max(k - (k > cut) for k in rests)
        assert ("verify-sheet-order" in codes) == behind, (place, moved)
