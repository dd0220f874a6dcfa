"""Copes of rectangular tubes whose edge lies in the round of a corner: by hand, by strangers."""

from itertools import pairwise
from math import asin, hypot, sin
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import PlanError, errors_in
from beamcam.model.part import Face, Part, Profile
from beamcam.model.request import Request
from beamcam.model.surface import around
from beamcam.solid.opinion import solid_faults
from tests.conftest import examples, sampled
from tests.random_boxes import outline
from tests.rs274 import needs_rs274
from tests.unit.coping.test_box_tubes import (
    RHS,
    TUBE,
    burns,
    found,
    in_section,
    planned,
    program_of,
    tube,
)

ROUND = Profile("M", "RHS150*100*6", 150.0, 100.0, 6.0, 6.0, 18.0)


def coped(profile: Profile, into: float, back: float, at_top: bool, at_end: bool) -> Part:
    """A tube of 500 whose upper or lower wall is cut back, up to `into` mm into its corners."""
    h, b, length = profile.height, profile.width, 500.0
    edge = h - profile.radius + into

    def drawn(face: str, *points: tuple[float, float]) -> object:
        moved = [(x if at_end else length - x, y) for x, y in points]
        if face in "vh" and not at_top:
            moved = [(x, h - y) for x, y in moved]
        return outline(face, moved)  # type: ignore[arg-type]

    side = [(0.0, 0.0), (length, 0.0), (length, edge), (back, edge), (back, h), (0.0, h)]
    off, whole = ("o", "u") if at_top else ("u", "o")
    features = [
        drawn("v", *side), drawn("h", *side),
        drawn(off, (0.0, 0.0), (back, 0.0), (back, b), (0.0, b)),
        drawn(whole, (0.0, 0.0), (length, 0.0), (length, b), (0.0, b)),
    ]  # fmt: skip
    return tube(*features, profile=profile)  # type: ignore[arg-type]


def test_the_edge_of_a_cope_lies_where_the_wall_reaches_farthest() -> None:
    """2.5 mm into corners of 10 with walls of 5: outside it is seen at asin(1/4), inside, where
    the round is 5, at asin(1/2). The torch stays half a kerf of 1 beyond that."""
    plan = planned(coped(RHS, 2.5, 460.0, True, True))
    far = plan.operations[-1].path
    way = around(RHS)
    along = [s for x, s in far[1:] if 475.0 < x < 490.0]
    ends = [s for (x, s), (x2, s2) in pairwise(far)
            if abs(s - s2) < 1e-6 and abs(x - x2) > 20.0]  # fmt: skip
    v = way.on_face("v")
    wanted = v.s(110.0) + 10.0 * asin(0.5) + 1.0
    h = way.on_face("h")
    other = h.s(110.0) - 10.0 * asin(0.5) - 1.0
    near = sorted(min(abs(s - one + k * way.turn) for s in (*along, *ends) for k in (-1, 0, 1))
                  for one in (wanted, other))  # fmt: skip
    assert near == pytest.approx([0.0, 0.0], abs=0.02)
    (told, *_) = [d for d in plan.remarks if d.code == "plan-coping-reaches"]
    assert "2.50 mm into a corner" in told.message
    assert f"up to {10.0 * (asin(0.5) - asin(0.25)):.2f} mm of steel more" in told.message


@given(
    st.sampled_from((RHS, ROUND)), st.floats(0.0, 1.0) | st.just(1.0),
    st.sampled_from((0.0, 0.0, -0.05, 0.08)), st.floats(420.0, 470.0), st.booleans(), st.booleans(),
)  # fmt: skip
@settings(max_examples=examples(15))
def test_copes_into_corners_are_planned_and_read_back(
    profile: Profile, share: float, off: float, back: float, at_top: bool, at_end: bool
) -> None:
    """Up to the inside of the wall beside, which is cut off with all its thickness, and what a
    drawing may be off from it. A cope 1 mm shorter is another part."""
    into = max(0.0, round(share * (profile.radius - profile.flange_thickness), 2) + off)
    part = coped(profile, into, back, at_top, at_end)
    text = program_of(part)
    assert found(text, coped(profile, into, back - 1.0, at_top, at_end))
    assert found(text, coped(profile, into, back, not at_top, at_end))


@pytest.mark.parametrize("into", [5.15, 8.0])
def test_an_edge_beyond_the_inside_of_the_wall_is_refused(into: float) -> None:
    with pytest.raises(PlanError, match=r"plan-coping-(corner|narrow)"):
        planned(coped(RHS, into, 460.0, True, True))


@pytest.mark.parametrize("into", sampled([2.5, 1.0, 5.0], 3))
def test_the_solid_agrees_and_sees_a_longer_cope(into: float) -> None:
    part = coped(RHS, into, 460.0, True, True)
    text = program_of(part)
    said = solid_faults(text, Request((part,), TUBE))
    assert {d.code for d in said} == {"solid-rounded", "solid-square"}
    assert errors_in(solid_faults(text, Request((coped(RHS, into, 457.0, True, True),), TUBE)))


@needs_rs274
def test_rs274_goes_along_the_edge_above_all_steel_of_the_web(tmp_path: Path) -> None:
    """Seen square to face v, the jet's side towards the web is nowhere lower than the edge, inside
    of the wall neither."""
    part = coped(RHS, 2.5, 440.0, True, True)
    (tmp_path / "t.ngc").write_text(program_of(part))
    far = burns(tmp_path / "t.ngc")[-1]
    edge = [
        in_section(place, part) for pair in pairwise(far) if abs(pair[0][0] - pair[1][0]) > 20.0
        for place in pair
    ]  # fmt: skip
    assert len(edge) >= 4
    for _, y, z in edge:
        out = y - 110.0, abs(z - 40.0) - 30.0
        turned = asin(out[0] / hypot(*out)) - 1.0 / 10.0  # half a kerf of 1 nearer to the web
        assert 110.0 + 5.0 * sin(turned) == pytest.approx(112.5, abs=0.03)


# --- windows and outlines that end at a corner ----------------------------------------------------


def window(profile: Profile, face: Face, into: float, at_high: bool) -> Part:
    """A tube with a window that ends so far beyond a tangent of its face."""
    wide, r = profile.face_width(face), profile.radius
    low, high = (0.45 * wide, wide - r + into) if at_high else (r - into, 0.55 * wide)
    ring = [(200.0, low), (240.0, low), (240.0, high), (200.0, high)]
    return tube(outline(face, ring, "inner"), profile=profile)


@pytest.mark.parametrize("profile", [RHS, ROUND])
@pytest.mark.parametrize("into", sampled([-0.01, -1e-4, 1e-4, 0.0, 2.0, 1e-7, 4.99, 0.011], 4))
@pytest.mark.parametrize(
    ("face", "at_high"), [("u", False), ("u", True), ("o", False), ("v", True)]
)
def test_a_window_may_end_at_a_tangent_or_within_the_corner(
    profile: Profile, into: float, face: Face, at_high: bool
) -> None:
    """A lead that goes over the tangent has several blocks; the seam lies beside face u."""
    part = window(profile, face, into, at_high)
    text = program_of(part)
    assert found(text, window(profile, face, into - 1.0, at_high))


def test_the_edge_of_a_window_in_a_corner_worked_by_hand() -> None:
    """2 mm beyond the tangent of a corner of 10 its edge is asin(0.2) round, half a kerf off it."""
    (cut,) = (c for c in planned(window(RHS, "v", 2.0, True)).operations if c.kind == "inner")
    edge = around(RHS).on_face("v").s(110.0) + 10.0 * asin(0.2)
    assert max(s for _, s in cut.path) == pytest.approx(edge - cut.row.kerf / 2, abs=0.011)


def faced(profile: Profile, faces: str, off: float, cut_back: float = 0.0) -> Part:
    """A tube of 500, mitred in the web's view by so much, each outline so far off its edges."""
    features = []
    for face in faces:
        wide = profile.face_width(face)  # type: ignore[arg-type]
        slope = cut_back / profile.height
        ends = [
            500.0 - (slope * y if face in "vh" else cut_back if face == "o" else 0.0)
            for y in (off, wide - off)
        ]  # fmt: skip
        points = [(0.0, off), (ends[0], off), (ends[1], wide - off), (0.0, wide - off)]
        features.append(outline(face, points))  # type: ignore[arg-type]
    return tube(*features, profile=profile)


@pytest.mark.parametrize("faces", sampled(["v", "h", "ou", "o", "vhou", "u", "vh"], 2))
@pytest.mark.parametrize("off", [0.0, 9.7, 10.3])
def test_outlines_that_end_at_the_tangents_go_on_to_the_edges(faces: str, off: float) -> None:
    part = faced(RHS, faces, off)
    plan = planned(part)
    told = [d.code for d in plan.remarks]
    assert ("plan-coping-tangents" in told) == (off > 0.0)
    plain = planned(tube(profile=RHS))
    assert [cut.path for cut in plan.operations] == [cut.path for cut in plain.operations]
    text = program_of(part)
    if off == 9.7:
        assert not solid_faults(text, Request((part,), TUBE))


def test_a_mitre_that_is_drawn_to_the_tangents_is_the_same_end() -> None:
    whole, short = (faced(RHS, "vhou", off, 60.0) for off in (0.0, 10.0))
    text = program_of(short)
    assert not found(text, whole)
    assert found(text, faced(RHS, "vhou", 10.0, 57.0))
    assert not errors_in(solid_faults(text, Request((short,), TUBE)))
