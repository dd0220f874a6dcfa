"""Skew ends of round tubes that only the header has, and what square cuts leave of bevels."""

from math import cos, degrees, hypot, pi, radians, sin, sqrt, tan
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.model.part import Bevel, Contour, EndCuts, Part
from beamcam.model.request import Request
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.kernel import kernel
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from tests.conftest import examples, sampled
from tests.rs274 import needs_rs274
from tests.unit.coping.samples import outline
from tests.unit.coping.test_tubes import HOLE, TUBE, TURN, burns, found, planned, program_of, tube

R = 84.15


def skew(**cuts: float) -> Part:
    return replace(tube(HOLE), cuts=EndCuts(**cuts))


def places(part: Part, kind: str) -> list[tuple[float, float]]:
    """x and the angle round the tube, from its lowest line, along an end."""
    (cut,) = [one for one in planned(part).operations if one.kind == kind]
    return [(x, u / R) for x, u in cut.path[cut.lead :]]


def test_a_mitre_worked_by_hand() -> None:
    """30 degrees of the web: the lowest line is 500 long, and cut outside; the highest, which is
    cut at the inside of its 8 mm, is shorter by the diameter less the wall."""
    at = dict[int, float]()
    for x, turn in places(skew(web_end=30.0), "far"):
        for deg in (0, 180):
            if abs((degrees(turn) - deg + 180.0) % 360.0 - 180.0) < 1.0:
                at[deg] = x - 1.1  # half a kerf of 2.2
    assert at[0] == pytest.approx(500.0, abs=0.02)
    assert at[180] == pytest.approx(500.0 - (168.3 - 8.0) * tan(radians(30.0)), abs=0.02)


def test_what_is_left_inside_is_told() -> None:
    part = skew(web_start=20.0, flange_start=35.0)
    (told,) = [d for d in planned(part).remarks if d.code == "plan-coping-slant"]
    most = 8.0 * hypot(tan(radians(20.0)), tan(radians(35.0)))
    assert f"up to {most:.2f} mm off at the inside of the walls v" in told.message


@pytest.mark.parametrize("wall", [4.0, 8.0, 14.0, 24.0])
@pytest.mark.parametrize("chords", [24, 72])
@pytest.mark.parametrize("steep", [0.2, 1.0])
def test_an_end_whose_peak_lies_on_the_seam(wall: float, chords: int, steep: float) -> None:
    """As exporters draw mitres and saddles, whatever the kerf of the wall's row."""
    turns = [2 * pi * k / chords for k in range(chords + 1)]
    peak = [(500.0 - R * steep * (1 - cos(turn)), R * turn) for turn in turns]
    profile = replace(tube().profile, web_thickness=wall, flange_thickness=wall)
    part = tube(outline("v", [(0.0, 0.0), *peak, (0.0, TURN)]), profile=profile)
    assert not found(program_of(part), part)


ANGLES = st.one_of(st.just(0.0), st.floats(-50.0, 50.0))


@given(ANGLES, ANGLES, ANGLES, ANGLES)
@settings(max_examples=examples(12))
def test_random_ends_are_read_back(a: float, b: float, c: float, d: float) -> None:
    part = skew(web_start=a, web_end=b, flange_start=c, flange_end=d)
    assert not found(program_of(part), part)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "cuts", sampled([EndCuts(20.0, -35.0, 15.0, -10.0), EndCuts(web_end=45.0)], 2)
)
def test_the_solid_agrees_and_sees_another_angle(cuts: EndCuts) -> None:
    part = replace(tube(HOLE), cuts=cuts)
    text = program_of(part)
    (told,) = solid_faults(text, Request((part,), TUBE))
    assert told.code == "solid-square"
    other = replace(part, cuts=replace(cuts, web_end=cuts.web_end + 1.0))
    assert {d.code for d in solid_faults(text, Request((other,), TUBE))} & {
        "solid-extra", "solid-missing"
    }  # fmt: skip
    assert found(text, other)


def sine(web: float, deep: float) -> Contour:
    """The outline of a far end skew in the view of v, as its trace `deep` below the surface."""
    steps = [2 * pi * k / 240 for k in range(241)]
    reach = R * tan(radians(web))
    far = [(500.0 - reach + (R - deep) * tan(radians(web)) * cos(t), R * t) for t in steps]
    return outline("v", [(0.0, 0.0), *far, (0.0, TURN)])


@pytest.mark.parametrize("deep", [0.0, 8.0])
def test_an_outline_that_is_the_plane_of_the_header_is_cut_as_drawn(deep: float) -> None:
    part = replace(tube(sine(30.0, deep)), cuts=EndCuts(web_end=30.0))
    plan = planned(part)
    assert [row["kind"] for row in manual_rows(plan)] == ["outline"]
    program_of(part)  # the read-back has the same
    top = min(x for x, _ in places(part, "far"))
    assert top == pytest.approx(501.1 - (2 * R - deep) * tan(radians(30.0)), abs=0.05)
    with pytest.raises(PlanError, match="plan-cut-denied"):
        planned(replace(part, cuts=EndCuts(web_end=-30.0)))


def test_wedges_of_bevels_are_told_in_mm() -> None:
    """45 degrees over 8 mm less a land of 2: 6 mm; 30 degrees over all of it: 4.6."""
    edge = outline("v", [(0.0, 0.0), (500.0, 0.0), (500.0, TURN), (0.0, TURN)])
    part = tube(replace(edge, bevels=(Bevel(1, -45.0, 2.0), Bevel(3, 30.0, 0.0))))
    plan = planned(part)
    (told,) = [d for d in plan.remarks if d.code == "plan-coping-wedge"]
    assert "through 8 mm; up to 6.00 mm left" in told.message
    assert [row["angle"] for row in manual_rows(plan)] == [-45.0, 30.0]
    small = tube(replace(edge, bevels=(Bevel(1, 3.0, 0.0),)))
    assert "plan-coping-wedge" not in {d.code for d in planned(small).remarks}


@needs_rs274
def test_the_path_that_rs274_prints_leaves_all_of_the_solid(tmp_path: Path) -> None:
    """Through the wall under the path there is no steel of the part half a kerf and a little
    beyond it, and some as much before it."""
    part = skew(web_end=30.0, flange_start=-25.0)
    (tmp_path / "t.ngc").write_text(program_of(part))
    _, near, far = burns(tmp_path / "t.ngc")
    solid, m = part_solid(part), kernel()

    def steel(x: float, a_deg: float) -> bool:
        n = -sin(radians(a_deg)), cos(radians(a_deg))
        balls = [
            m.Manifold.sphere(0.1, 12).translate((x, R + r * n[0], R + r * n[1]))
            for r in (R - 0.2, R - 2.0, R - 4.0, R - 6.0, R - 7.8)
        ]
        return any((ball ^ solid).volume() > 1e-4 for ball in balls)

    for stroke, side, angle in ((near, -1.0, 25.0), (far, 1.0, 30.0)):
        assert len(stroke) > 100
        for x, a_deg in stroke[2::9]:
            assert not steel(x + side * 0.5, a_deg)
            assert steel(x - side * (1.1 * sqrt(1 + tan(radians(angle)) ** 2) + 0.4), a_deg)
