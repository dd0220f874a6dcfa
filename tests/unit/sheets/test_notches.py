"""Cut-outs with a side on the outline of their plate: notches, by the area that is left."""

from itertools import pairwise

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError, VerifyError
from beamcam.geometry.curves import Arc, Line
from beamcam.model.part import Bevel, Contour, Part
from beamcam.pipeline import post
from beamcam.planning.contours.plate_edges import Notches
from beamcam.planning.manual_list import manual_rows
from beamcam.planning.sheet import plan_sheet
from tests.unit.sheets.parts import S, box, contour, plate, table

#: The plate of 200 x 100 from corner to corner, and where each edge begins.
RING = [(0.0, 0.0), (200.0, 0.0), (200.0, 100.0), (0.0, 100.0)]
OUTLINE = contour(box(0, 0, 200, 100), None)


def cut_out(ring: list[tuple[float, float]]) -> Contour:
    sides = tuple(Line(a, b) for a, b in pairwise([*ring, ring[0]]))
    return Contour("v", "inner", sides, S)


def area(part: Part, **values: object) -> float:
    """What the cuts of a plan on their lines leave."""
    plan = plan_sheet((part,), table(kerf=0.0, **values))
    rings = []
    for op in plan.operations:
        points = [p for curve in op.passes[0].curves for p in (curve.start, curve.point(0.5))]
        rings.append((op.depth, shapely.Polygon(points)))
    return sum((1 if depth % 2 == 0 else -1) * ring.area for depth, ring in rings)


@st.composite
def at_edge(draw: st.DrawFn) -> list[tuple[float, float]]:
    """A trapezium on an edge of the plate, with its corner on one too; either way round."""
    edge, at = draw(st.integers(0, 3)), draw(st.sampled_from([0.0, 12.0, 30.0]))
    wide, deep, lean = (draw(st.sampled_from(each)) for each in ((20.0, 37.5), (15, 40), (0, 4)))
    if at == 0.0:
        lean = 0
    (x0, y0), (x1, y1) = RING[edge], RING[(edge + 1) % 4]
    size = abs(x1 - x0) + abs(y1 - y0)
    u, v = (x1 - x0) / size, (y1 - y0) / size
    local = [(at, 0.0), (at + wide, 0.0), (at + wide - lean, deep), (at + lean, deep)]
    ring = [(x0 + u * a - v * b, y0 + v * a + u * b) for a, b in local]
    turn = draw(st.integers(0, 3))
    ring = ring[turn:] + ring[:turn]
    return ring[::-1] if draw(st.booleans()) else ring


@given(at_edge(), st.booleans())
def test_the_notch_is_what_the_cut_out_takes(ring: list[tuple[float, float]], own: bool) -> None:
    part = plate(cut_out(ring), *([OUTLINE] if own else []))
    wanted = shapely.Polygon(RING).difference(shapely.Polygon(ring))
    assert area(part) == pytest.approx(wanted.area, abs=1e-3)
    posted = post((part,), table())  # and read back
    assert [d.code for d in posted.remarks].count("plan-sheet-notch") == 1
    assert len(posted.plan.operations) == 1
    assert [o.how for o in posted.plan.outcomes] == ["made"] * len(part.features)


def test_several_notches_and_parts_on_one_sheet() -> None:
    features = (OUTLINE, cut_out([(50, 0), (90, 0), (90, 30), (50, 30)]),
                cut_out([(120, 0), (150, 0), (150, 20), (120, 20)]),
                cut_out([(0, 60), (30, 60), (30, 100), (0, 100)]))  # fmt: skip
    part = plate(*features)
    assert area(part) == pytest.approx(20000 - 1200 - 600 - 1200)
    bare = plate(*features[1:])
    assert len(post((part, bare, part), table()).plan.operations) == 3
    sides = (Arc((100.0, 100.0), 20.0, 180.0, 180.0), Line((120.0, 100.0), (80.0, 100.0)))
    round_off = Contour("v", "inner", sides, S)
    half = plate(OUTLINE, round_off)
    assert len(post((half,), table()).plan.operations) == 1


@pytest.mark.parametrize("ring", [
    [(50, 0), (90, 0), (90, 100), (50, 100)],  # from edge to edge: two parts
    [(50, 90), (90, 90), (90, 110), (50, 110)],  # beyond the edge
    [(50, 0), (90, 0), (90, -30), (50, -30)],  # beside the plate
])  # fmt: skip
def test_what_is_no_notch_stays_refused(ring: list[tuple[float, float]]) -> None:
    part = plate(OUTLINE, cut_out(ring))
    with pytest.raises(PlanError, match=r"plan-(shared-edge|crossing|sheet-off)"):
        post((part,), table())


def test_a_plan_that_cuts_it_out_is_not_sound(monkeypatch: pytest.MonkeyPatch) -> None:
    """On its lines, where an edge that two contours have would be cut once."""
    part = plate(OUTLINE, cut_out([(50, 0), (90, 0), (90, 30), (50, 30)]))
    post((part,), table(kerf_by="none"))
    module = "beamcam.planning.contours.assign_process.notches_in"
    monkeypatch.setattr(module, lambda *_: Notches())
    with pytest.raises(VerifyError, match="verify-sheet"):
        post((part,), table(kerf_by="none"))


def test_bevels_of_the_outline_stay_on_the_list() -> None:
    bevelled = replace(OUTLINE, bevels=(Bevel(1, 30.0, 0.0),))
    part = plate(bevelled, cut_out([(50, 0), (90, 0), (90, 30), (50, 30)]))
    (row,) = manual_rows(post((part,), table()).plan)
    assert (row["kind"], row["length"]) == ("bevel", 100.0)
