"""Contours that turn round at a joint of two curves and run back beside themselves."""

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import PlanError
from beamcam.geometry.curves import Bezier, Curve, Line
from beamcam.model.part import Part
from beamcam.pipeline import post
from tests.conftest import examples
from tests.unit.sheets.parts import box, contour, drawing, lines, table
from tests.unit.sheets.spikes import Spike, cut

MACHINE = table("plate-linuxcnc", allow_open=True)
KERF = 1.9  #: of 8 mm of steel
KINDS = ("line", "arc", "quadratic", "cubic")

kinds = st.sampled_from(KINDS)
#: All around, and along the sides beside the corner, which lie at 188 and 259 degrees.
headings = st.floats(-100.0, 260.0) | st.floats(165.0, 200.0) | st.floats(240.0, 280.0)
spikes = st.builds(
    Spike,
    st.tuples(kinds, kinds, kinds, kinds),
    st.tuples(*(st.sampled_from([0.0, 0.05, 0.15]) for _ in range(4))),
    headings, st.floats(0.1, 4.0), st.tuples(kinds, kinds),
    st.sampled_from([0.0, 0.0, 0.05, 0.15, -0.1]),
    st.sampled_from([0.0, 1e-6, 5e-4, 1.5e-3, 0.004, 0.01, 0.018, -0.004, -0.03]),
    st.sampled_from([0.0, 0.0, 0.002, 0.01, 0.03, -0.01]), st.booleans(), st.booleans(),
)  # fmt: skip


@settings(deadline=None, max_examples=examples(20))
@given(spikes)
def test_a_spike_at_a_joint_is_cut_or_refused_by_the_planner(spike: Spike) -> None:
    """Cut as the beam measures it, apart from the read-back; never refused by that."""
    try:
        text = post((spike.part(),), MACHINE).text
    except PlanError as error:
        codes = {said.code for said in error.diagnostics}
        event(", ".join(sorted(codes)))
        assert all(code.startswith(("plan-", "read-")) for code in codes)
        return
    event("cut")
    assert not list(cut(spike, text, KERF).faults())


#: A corner that runs a little beyond itself in one curve, as a damaged drawing has it.
CUSP = (
    *lines((12.7, 63.5), (88.9, 63.5), (88.9, 12.7), (10.16, 12.7), (10.16, 60.96), closed=False),
    Bezier(((10.16, 60.96), (10.16, 62.357), (11.303, 63.5), (10.414, 63.5))),
    Line((10.414, 63.5), (12.7, 63.5)),
)
SPIKES = [
    Spike(("line",) * 4, (0.0,) * 4, 200.0, 0.3, ("cubic", "line"), 0.0, 0.01, 0.01),
    Spike(("line",) * 4, (0.0,) * 4, 45.0, 2.0, ("cubic", "line"), -0.05, 0.004, 0.01),
    Spike(("line",) * 4, (0.0, 0.0, 0.15, 0.0), 115.0, 1.5, ("line", "arc"), 0.0, -0.03),
]


@pytest.mark.parametrize(
    "curves", [CUSP, *(spike.ring() for spike in SPIKES)],
    ids=["cusp", "slit", "needle", "needle beside a corner"],
)  # fmt: skip
def test_a_spike_within_the_tolerance_is_cut(curves: tuple[Curve, ...]) -> None:
    """And a program that leaves a contour out is refused in such a drawing, too."""
    part = drawing(contour(curves), thickness=8.0)
    text = post((part,), MACHINE).text
    more = drawing(contour(curves), contour(box(20, 20, 8, 8), line=2), thickness=8.0)
    assert "verify-sheet-missing" in {said.code for said in verify_sheet(text, (more,), MACHINE)}


@pytest.mark.parametrize("apart", [0.0, 0.004])
@pytest.mark.parametrize("start", range(6))
def test_what_is_followed_there_and_back_from_a_joint_is_refused(start: int, apart: float) -> None:
    spike = Spike(("line",) * 4, (0.0,) * 4, 45.0, 2.0, ("cubic", "arc"), 0.1, apart)
    ring = spike.ring()
    part = drawing(contour((*ring[start:], *ring[:start])), thickness=8.0)
    with pytest.raises(PlanError, match=r"turns round at x 48\.414, y 43\.414") as caught:
        post((part,), MACHINE)
    assert [said.code for said in caught.value.diagnostics] == ["plan-doubles-back-kerf"]


@pytest.mark.parametrize(("spike", "place"), [
    (Spike(("line",) * 4, (0.0,) * 4, 254.0, 4.0, ("line", "arc"), 0.0, 0.0015),
     "45.897, y 38.155"),
    (Spike(("line",) * 4, (0.0,) * 4, 192.0, 2.0, ("cubic", "line"), 0.0, -0.03, 0.01),
     "45.044, y 41.584"),
    (Spike(("line",) * 4, (0.0,) * 4, 258.0, 0.9, ("line", "cubic"), 0.0, 0.0015, 0.03),
     "46.813, y 41.120"),
], ids=["in the waste", "in the part", "mouth"])  # fmt: skip
@pytest.mark.parametrize("start", range(6))
def test_a_needle_beside_the_next_edge_is_refused(spike: Spike, place: str, start: int) -> None:
    """In the wedge between both there is no saying where the waste is."""
    ring = spike.ring()
    part = drawing(contour((*ring[start:], *ring[:start])), thickness=8.0)
    with pytest.raises(PlanError, match=f"turns round at x {place}") as caught:
        post((part,), MACHINE)
    assert {said.code for said in caught.value.diagnostics} == {"plan-doubles-back-kerf"}


def test_a_needle_with_a_mouth_a_hair_wide_is_refused() -> None:
    """A mouth that is written so does not close; both ends of it are one place all the same."""
    spike = Spike(
        ("line",) * 4, (0.0,) * 4, 45.0, 0.4, ("cubic", "arc"), 0.0, 5e-4, 1e-5, is_hole=True
    )
    with pytest.raises(PlanError, match=r"turns round at x 47\.283, y 42\.283") as caught:
        post((spike.part(),), MACHINE)
    assert [said.code for said in caught.value.diagnostics] == ["plan-doubles-back-kerf"]


def window(*ring: tuple[float, float]) -> Part:
    return drawing(contour(lines(*ring)), thickness=8.0)


OUTSIDE = ((0, 40), (0, 0), (60, 0), (60, 40))
INSIDE = ((30, 40), (38, 30), (30, 12), (22, 30), (30, 40))
HOLES = ((0, 0), (20, 20), (0, 40), (40, 40), (20, 20), (40, 0))


@pytest.mark.parametrize(("part", "count"), [
    (window(*OUTSIDE, *INSIDE), 2),
    (window(*INSIDE[2:], *OUTSIDE, *INSIDE[:2]), 2),
    (drawing(contour(box(-20, -20, 100, 80)), contour(lines(*HOLES), line=2), thickness=8.0), 3),
], ids=["window", "from the window", "holes"])  # fmt: skip
def test_waste_that_hangs_together_by_a_point_is_cut_as_two(part: Part, count: int) -> None:
    assert post((part,), MACHINE).text.count("\nM3") == count


def test_a_part_that_hangs_together_by_a_point_stays_one() -> None:
    part = window((0, 0), (20, 0), (20, 20), (40, 20), (40, 40), (20, 40), (20, 20), (0, 20))
    assert post((part,), MACHINE).text.count("\nM3") == 1


@pytest.mark.parametrize("back", [(0.0, 20.0), (0.0, 0.0, 20.0), (0.0, 8.0, 9.0, 20.0)])
def test_a_line_there_and_a_straight_curve_back_is_cut_once(back: tuple[float, ...]) -> None:
    home = Bezier(tuple((x, 10.0) for x in back))
    part = drawing(
        contour((Line((20.0, 10.0), (0.0, 10.0)), home)), contour(box(-10, -10, 60, 60), line=2),
        thickness=8.0,
    )  # fmt: skip
    assert post((part,), MACHINE).text.count("\nM3") == 2
