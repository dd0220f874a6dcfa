"""Rounds on a bar line: unrolled outlines and holes, and pipes that are written as plates."""

from math import cos, pi, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.model.part import Contour, EndCuts, Part, Profile, TextMark
from beamcam.model.request import Job, Request
from beamcam.model.section import weight_of
from beamcam.pipeline import post
from beamcam.posts import post_of
from beamcam.solid.opinion import solid_faults
from tests.unit.planning.shop import SOURCE, hole, part

PUSHER = load("beamline-pusher")
D, ROUND = 114.3, 359.08
TUBE = Profile("RO", "CHS114.3*5", D, D, 5.0, 5.0)
PLATE = Profile("B", "CHS114.3*5", ROUND, 0.0, 5.0, 5.0)


def ring(points: list[tuple[float, float]]) -> Contour:
    chain = zip(points, (*points[1:], points[0]), strict=True)
    return Contour("v", "outer", tuple(Line(p, q) for p, q in chain), SOURCE)


def outline(length: float, starts: float, ends: float, phase: float = 0.0, n: int = 48) -> Contour:
    """The surface between two planes that lean by these slopes, unrolled."""
    places = [ROUND * k / n for k in range(n + 1)]
    first, last = (
        [(at + way * abs(lean) * D / 2 + lean * D / 2 * cos(u * 2 / D + phase), u) for u in places]
        for at, way, lean in ((0.0, 1, starts), (length, -1, ends))
    )
    return ring([(round(x, 2), round(u, 2)) for x, u in (*last, *reversed(first))])


def blocks(one: Part) -> list[str]:
    """The cuts of its program, read back."""
    made = post([one], PUSHER)
    assert not solid_faults(made.text, made.job.request)
    return [line.split(" ", 1)[1] for line in made.text.splitlines() if " M42 " in line]


@settings(max_examples=5, deadline=None)
@given(st.integers(-30, 30), st.integers(-30, 30), st.sampled_from([TUBE, PLATE]))
def test_a_drawn_mitre_is_sawn_as_that_of_the_header(
    start: int, end: int, profile: Profile
) -> None:
    slopes = tan(start * pi / 90), tan(end * pi / 90)
    drawn = part(outline(7000.0, *slopes), profile=profile, length=7000.0)
    said = part(profile=TUBE, length=7000.0, cuts=EndCuts(2.0 * start, 2.0 * end))
    angles = [[w for w in line.split() if w[0] in "KL"] for line in blocks(drawn)]
    expected = [[w for w in line.split() if w[0] in "KL"] for line in blocks(said)]
    assert len(angles) == len(expected)
    for found, asked in zip(angles, expected, strict=True):
        for a, b in zip(found, asked, strict=True):
            assert float(a[1:]) == pytest.approx(float(b[1:]), abs=0.05)


@pytest.mark.parametrize("profile", [TUBE, PLATE], ids=["tube", "plate"])
@pytest.mark.parametrize(("quarter", "face"), [(0, "u"), (1, "v"), (2, "o"), (4, "u")])
def test_holes_are_drilled_from_the_face_that_sees_them(
    profile: Profile, quarter: int, face: str
) -> None:
    """With the tube's own wall and depth, as the solid of the part has them."""
    one = part(
        outline(7000.0, 0.0, 0.0), hole(500.0, quarter * pi / 4 * D), profile=profile, length=7000.0
    )
    made = post([one], PUSHER)
    (op,) = [op for op in made.plan.operations if hasattr(op, "faces")]
    assert (op.faces, op.y) == ((face,), pytest.approx(D / 2))
    assert not solid_faults(made.text, made.job.request)
    assert ("plan-pipe" in [d.code for d in made.remarks]) is (profile is PLATE)


HALF = [
    (0.0, 0.0), (3000.0, 0.0), (3000.0, ROUND), (1600.0, ROUND), (1600.0, ROUND / 2),
    (0.0, ROUND / 2),
]  # fmt: skip
UNSEEN = {
    "off the middle": (hole(500.0, D / 2), "y 0.00, 89.77, 179.54, 269.31"),
    "deeper than the drill": (hole(500.0, pi / 4 * D, 40.0), "curves by 2 mm, not 3.99"),
    "leaning to the side": (outline(3000.0, 0.0, 0.5, pi / 2), "lean in the view of v alone"),
    "too coarse": (outline(3000.0, 0.0, 0.5, n=6), "lean in the view of v alone"),
    "half of it cut": (ring(HALF), "lean in the view of v alone"),
}  # fmt: skip


@pytest.mark.parametrize("name", UNSEEN)
def test_what_no_side_shows_is_refused_by_planner_and_read_back(name: str) -> None:
    feature, expected = UNSEEN[name]
    given = part(feature, profile=PLATE)
    with pytest.raises(PlanError) as caught:
        post([given], PUSHER)
    (said,) = [d for d in caught.value.diagnostics if d.code == "plan-round"]
    assert expected in said.message
    job = Job(Request((given,), PUSHER), (0,))
    (read_back,) = post_of(PUSHER).verify("", job)
    assert str(read_back).split(" error ")[1].startswith("verify-round: found ")
    if name in ("too coarse", "half of it cut"):
        made = post([given], PUSHER, skips=("cutout",))
        assert [o.how for o in made.plan.outcomes] == ["skipped"]
        left = solid_faults(made.text, made.job.request)
        assert {d.code for d in left} <= {"solid-left-out"}


def test_a_tube_that_is_drawn_as_it_is_seen_is_sawn() -> None:
    given = part(ring([(0.0, 0.0), (3000.0, 0.0), (3000.0, D), (0.0, D)]), profile=TUBE)
    assert len(blocks(given)) == 2


def test_texts_lie_where_v_shows_them() -> None:
    text = TextMark("v", 300.0, pi / 4 * D, 0.0, 10.0, "A1", SOURCE)
    (seen,) = Job(Request((part(text, profile=TUBE),), PUSHER), (0,)).parts[0].features
    assert (seen.face, seen.y) == ("v", pytest.approx(D / 2))
    back = replace(text, y=pi * 0.75 * D)
    (seen,) = Job(Request((part(back, profile=TUBE),), PUSHER), (0,)).parts[0].features
    assert seen.face == "h"


def test_another_diameter_in_the_name_is_refused_and_flats_stay_flats() -> None:
    with pytest.raises(PlanError) as caught:
        post([part(profile=replace(PLATE, name="CHS88.9*5"))], PUSHER)
    (said,) = caught.value.diagnostics
    assert said.code == "plan-unrolled"
    assert "279.29 mm of width" in said.message
    flat = post([part(profile=replace(PLATE, name="FL359*5"))], PUSHER)
    assert flat.job.parts[0].profile.code == "B"


def test_a_pipe_that_is_written_as_a_plate_weighs_as_its_tube() -> None:
    as_plate, as_tube = (weight_of(part(profile=one)) for one in (PLATE, TUBE))
    assert as_plate == pytest.approx(as_tube, rel=1e-4)
