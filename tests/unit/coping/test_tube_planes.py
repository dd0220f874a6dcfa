"""Tubes whose ends are planes of their own, of any direction: planned, read back, by strangers."""

from itertools import product, starmap
from math import cos, dist, hypot, pi, radians, sin, tan
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import PlanError, errors_in
from beamcam.machine import load
from beamcam.machine.overlay import with_section
from beamcam.model.part import EndCuts, EndPlane, Part, Profile
from beamcam.model.request import Request
from beamcam.model.surface import around
from beamcam.pipeline import read_file
from beamcam.planning.manual_list import manual_rows
from beamcam.recovery import recover
from beamcam.solid.kernel import kernel
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from tests.conftest import THIRD_PARTY, examples, sampled
from tests.random_boxes import mitred, over_corner
from tests.rs274 import needs_rs274
from tests.unit.coping.test_box_tubes import (
    AT,
    HOLE,
    RHS,
    SHS,
    TUBE,
    burns,
    found,
    in_section,
    planned,
    program_of,
    tube,
)

CHS = Profile("RO", "CHS168.3*8", 168.3, 168.3, 0.0, 8.0)


def plane(x: float, by_y: float, by_z: float, profile: Profile, side: float = 1.0) -> EndPlane:
    """A plane that is at x on the axis, whose x falls by so much along Y and Z."""
    at = (x, profile.height / 2, profile.width / 2)
    size = side * hypot(1.0, by_y, by_z)
    return EndPlane(at, (1.0 / size, by_y / size, by_z / size), AT)


def ended(profile: Profile, *planes: tuple[float, float, float], side: float = 1.0) -> Part:
    """A tube of 500 with a hole, ended by planes."""
    return tube(HOLE, *(plane(*one, profile, side) for one in planes), profile=profile)


def test_a_plane_both_ways_is_cut_where_the_wall_reaches_farthest() -> None:
    """At 400 on the axis, 0.5 along Y and -0.3 along Z: where a side of the path begins or ends,
    on faces at Y or Z, outside or inside of 5 mm, half a kerf farther."""
    far = planned(ended(RHS, (400.0, 0.5, -0.3))).operations[-1]
    way, path = around(RHS), far.path[far.lead :]
    half_kerf = {"u": hypot(1.0, 0.3), "o": hypot(1.0, 0.3), "v": hypot(1.0, 0.5),
                 "h": hypot(1.0, 0.5)}  # fmt: skip
    seen = set()
    for x, s in path:
        leg = max((one for one in way.legs if one.begin <= s % way.turn), key=lambda o: o.begin,
                  default=way.legs[-1])  # fmt: skip
        face = leg.patch.name
        if face not in half_kerf:
            continue
        seen.add(face)
        _, y, z = leg.patch.point(0.0, leg.u(s % way.turn if s % way.turn >= leg.begin else s))
        (ny, nz), xs = leg.patch.outward, []
        for deep in (0.0, 5.0):
            xs.append(400.0 - 0.5 * (y - deep * ny - 60.0) + 0.3 * (z - deep * nz - 40.0))
        assert x == pytest.approx(max(xs) + half_kerf[face], abs=0.35)
    assert seen == {"u", "v", "o", "h"}


SLOPES = st.one_of(st.just(0.0), st.floats(-1.5, 1.5))
PROFILES = st.sampled_from((RHS, SHS, Profile("M", "RHS150*50*6", 150.0, 50.0, 6.0, 6.0, 25.0)))
PLANES = st.lists(st.tuples(st.floats(330.0, 470.0), SLOPES, SLOPES), min_size=1, max_size=2)


@given(PROFILES, PLANES)
@settings(max_examples=examples(15))
def test_planes_of_any_direction_are_planned_and_read_back(
    profile: Profile, planes: list[tuple[float, float, float]]
) -> None:
    """Two of them make a roof. One that leans the other way is another part."""
    part = ended(profile, *planes)
    text = program_of(part)
    x, by_y, by_z = planes[0]
    if max(abs(by_y), abs(by_z)) > 0.1 and len(planes) == 1:
        for slopes in ((-by_y, by_z), (by_y, -by_z)):
            if slopes != (by_y, by_z):
                assert found(text, ended(profile, (x, *slopes)))
    assert found(text, ended(profile, (x - 1.5, by_y, by_z), *planes[1:])) or len(planes) > 1


@given(PLANES)
@settings(max_examples=examples(10))
def test_planes_of_round_tubes_are_planned_and_read_back(
    planes: list[tuple[float, float, float]],
) -> None:
    part = ended(CHS, *planes)
    assert not found(program_of(part), part)


@given(st.floats(0.0, 2 * pi), st.floats(0.1, 1.2))
@settings(max_examples=examples(6))
def test_a_round_tube_is_cut_alike_whatever_way_its_plane_leans(turn: float, lean: float) -> None:
    """Turned about its axis it is the same end; u begins elsewhere."""
    reach = []
    for way in (0.0, turn):
        part = ended(CHS, (400.0, lean * cos(way), lean * sin(way)))
        xs = [x for x, _ in planned(part).operations[-1].path[1:]]
        reach.append((min(xs), max(xs)))
    assert reach[0] == pytest.approx(reach[1], abs=0.05)


def test_a_header_that_says_the_plane_once_more_denies_nothing() -> None:
    """Its angles belong to the plane, though an outline goes square beyond it."""
    cut = plane(400.0, tan(radians(20.0)), tan(radians(-10.0)), RHS)
    cuts = EndCuts(web_end=20.0, flange_end=-10.0)
    square = mitred(RHS, 500.0, 0.0, True)
    plain = planned(tube(cut, profile=RHS)).operations[-1].path
    for part in (tube(cut, profile=RHS, cuts=cuts), tube(cut, *square, profile=RHS, cuts=cuts)):
        path = planned(part).operations[-1].path
        assert max(starmap(dist, zip(path, plain, strict=True))) < 0.01
        assert not found(program_of(part), part)
    with pytest.raises(PlanError, match="plan-cut-denied"):
        planned(tube(*square, profile=RHS, cuts=cuts))


def test_what_a_square_cut_leaves_is_told_and_on_the_list() -> None:
    """0.5 and 0.3 along the normals of walls of 5 mm, and of 8 mm round."""
    plan = planned(ended(RHS, (400.0, 0.5, -0.3)))
    (told,) = [d for d in plan.remarks if d.code == "plan-coping-slant"]
    assert "up to 2.50 mm off at the inside of the walls u, v, o, h" in told.message
    assert [row["why"] for row in manual_rows(plan)] == ["bevel"]
    part = ended(CHS, (400.0, 0.3, 0.4))
    (told,) = [d for d in planned(part).remarks if d.code == "plan-coping-slant"]
    assert "up to 4.00 mm" in told.message
    level = ended(RHS, (400.0, 0.0, 0.0))
    assert not manual_rows(planned(level))


def test_a_plane_along_the_tube_is_refused() -> None:
    along = EndPlane((0.0, 100.0, 0.0), (0.0, 1.0, 0.0), AT)
    with pytest.raises(PlanError, match="plan-other"):
        planned(tube(along, profile=RHS))
    assert found(program_of(tube(profile=RHS)), tube(plane(300.0, 0.0, 0.0, RHS), profile=RHS))


def test_a_plane_through_a_window_over_a_corner() -> None:
    part = tube(*over_corner(RHS, 1, 380.0, 60.0, 0.0), plane(410.0, 0.3, 0.2, RHS), profile=RHS)
    assert not found(program_of(part), part)


@pytest.mark.parametrize(
    ("profile", "slopes"), sampled(product([RHS, CHS], [(0.5, -0.3), (-0.2, 0.9)]), 4)
)
def test_the_solid_agrees_and_sees_another_plane(
    profile: Profile, slopes: tuple[float, float]
) -> None:
    part, other = (ended(profile, (x, *slopes)) for x in (400.0, 402.0))
    text = program_of(part)
    assert {d.code for d in solid_faults(text, Request((part,), TUBE))} <= {"solid-square"}
    codes = {d.code for d in solid_faults(text, Request((other,), TUBE))}
    assert codes & {"solid-extra", "solid-missing"}


def test_what_is_recovered_makes_the_same_program() -> None:
    part = ended(RHS, (400.0, 0.5, -0.3))
    (again,) = recover(program_of(part), TUBE, "p").parts
    assert not found(program_of(part), again)


@needs_rs274
@pytest.mark.parametrize("slopes", [(0.5, -0.3), (-0.7, 0.4)])
def test_rs274_leaves_all_of_the_solid_behind_a_plane(
    slopes: tuple[float, float], tmp_path: Path
) -> None:
    """Half a kerf and a little beyond the path there is no steel through the wall, and some before
    it."""
    part = tube(plane(400.0, *slopes, RHS), profile=RHS)
    (tmp_path / "t.ngc").write_text(program_of(part))
    far = burns(tmp_path / "t.ngc")[-1]
    solid, m = part_solid(part), kernel()

    def steel(x: float, y: float, z: float, n: tuple[float, float]) -> bool:
        return any(
            (m.Manifold.sphere(0.1, 12).translate((x, y - deep * n[0], z - deep * n[1])) ^ solid)
            .volume() > 1e-4
            for deep in (0.2, 1.5, 2.5, 3.5, 4.8)
        )  # fmt: skip

    assert len(far) > 100
    for place in far[2::5]:
        x, y, z = in_section(place, part)
        n = -sin(radians(place[3])), cos(radians(place[3]))
        assert not steel(x + 0.5, y, z, n)
        assert steel(x - hypot(1.0, *slopes) - 0.4, y, z, n)


@pytest.mark.third_party
@pytest.mark.parametrize("corner", [12.0, 20.0])
def test_real_tubes_mitred_both_ways(corner: float) -> None:
    """One of them has no corners in the model, one corners thinner than its wall."""
    path = THIRD_PARTY / "cases" / "ifc" / "rhs_mitred_both_ways.ifc"
    machine = with_section(load("tube-linuxcnc"), corner, None)
    parts = read_file(str(path)).parts
    assert sum(isinstance(f, EndPlane) for part in parts for f in part.features) == 4
    for part in parts:
        text = program_of(part, machine)
        assert not errors_in(solid_faults(text, Request((part,), machine)))
