"""Contours that cross one another or themselves, that double back, and needles."""

import re
from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import PlanError, Severity
from beamcam.geometry.curves import Bezier, Line
from beamcam.machine import Machine
from beamcam.model.part import Part
from beamcam.pipeline import post
from beamcam.planning.contours import running_back
from tests.conftest import examples

from .parts import box, circle, contour, drawing, lines, table

MACHINE = table("laser-grbl", material="wood", kerf_by="none", lead="none")

TONGUE = drawing(contour(lines((0, 0), (60, 0), (60, 30), (-30, 30), (0, 30))), thickness=3.0)
SPIKE = drawing(
    contour(
        (*lines((0, 0), (60, 0), (60, 30), closed=False), Bezier(((60, 30), (90, 40), (60, 30))),
         Line((60, 30), (0, 0)))
    ),
    thickness=3.0,
)  # fmt: skip
CROSSED = drawing(
    contour(box(0, 0, 100, 40), line=1),
    contour(box(20, 20, 10, 60), line=2),
    contour(circle(25, 30, 6), line=3),
    thickness=3.0,
)


def strokes(text: str) -> list[str]:
    return re.findall(r"^G0 X\S+ Y\S+\nM[34](?:.|\n)*?M5\n", text, re.M)


@pytest.mark.parametrize("part", [TONGUE, SPIKE])
def test_a_contour_that_doubles_back_is_posted_and_not_followed_again(part: object) -> None:
    text = post((part,), MACHINE).text  # type: ignore[arg-type]
    assert not verify_sheet(text, (part,), MACHINE)  # type: ignore[arg-type]
    (first, *_) = strokes(text)
    again = verify_sheet(text.replace(first, first * 2), (part,), MACHINE)  # type: ignore[arg-type]
    assert "verify-sheet-twice" in {said.code for said in again}


def test_a_tongue_that_is_cut_short_is_told() -> None:
    """Half of the line that the contour has twice, and that is followed once."""
    text = post((TONGUE,), MACHINE).text
    short = text.replace("G0 X2 Y32", "G0 X17 Y32")
    assert short != text
    codes = {said.code for said in verify_sheet(short, (TONGUE,), MACHINE)}
    assert "verify-sheet-missing" in codes


def test_what_lies_in_two_contours_that_cross_is_cut_before_both() -> None:
    text = post((CROSSED,), MACHINE).text
    assert not verify_sheet(text, (CROSSED,), MACHINE)
    cuts = strokes(text)
    assert len(cuts) == 3
    (round_cut,) = [cut for cut in cuts if re.search(r"^G[23] ", cut, re.M)]
    assert cuts[0] == round_cut
    late = text.replace(round_cut, "").replace(cuts[2], cuts[2] + round_cut)
    assert "verify-sheet-order" in {said.code for said in verify_sheet(late, (CROSSED,), MACHINE)}


PLASMA = table(thickness=3.0)
LOOP = lines((25, 5), (35, 15), (35, 35), (15, 37), (16, 37), (14, 35), (14, 15))


def test_a_small_loop_of_a_large_contour_crosses_it() -> None:
    """The loop is measured by its own length, not by that of the contour that it is part of."""
    with pytest.raises(PlanError, match=r"crosses itself near x 15\.909, y 36\.909") as caught:
        post((drawing(contour(LOOP), thickness=3.0),), PLASMA)
    assert [said.code for said in caught.value.diagnostics] == ["plan-crossing"]


def test_a_loop_that_joining_leaves_does_not_cross() -> None:
    """Two lines that pass one another by less than the gap meet at their corner."""
    sides = lines((0, 0), (40, 0), (40, 30), (0, 30))
    passing = (Line((0, 0), (40.03, 0)), Line((40, -0.03), (40, 30)), *sides[2:])
    loose = [contour((side,), line=k) for k, side in enumerate(passing)]
    assert post((drawing(*loose, thickness=3.0),), PLASMA).text


@pytest.mark.parametrize("height", [0.07, 0.3, 1.0, 5.0])
@pytest.mark.parametrize("width", [0.002, 0.05, 0.2])
def test_both_sides_of_a_needle_are_corners(width: float, height: float) -> None:
    """The tip is all of a low needle that the beam touches."""
    feet = (20 + width / 2, 30), (20 - width / 2, 30)
    outline = lines((0, 0), (40, 0), (40, 30), feet[0], (20, 30 + height), feet[1], (0, 30))
    assert post((drawing(contour(outline), thickness=3.0),), PLASMA).text


def test_corners_of_a_star() -> None:
    """Its points are drawn in any order, so that neighbours in a ring are none in the list."""
    outer = [(20 + 20 * sin(0.4 * pi * k), 20 + 20 * cos(0.4 * pi * k)) for k in range(5)]
    turns = [0.4 * pi * (k + 0.5) for k in range(5)]
    inner = [(20 + 9 * sin(turn), 20 + 9 * cos(turn)) for turn in turns]
    corners = [point for pair in zip(outer, inner, strict=True) for point in pair]
    sides = lines(*corners)
    mixed = (*sides[::3], *sides[1::3], *sides[2::3])
    loose = [contour((side,), line=k) for k, side in enumerate(mixed)]
    assert post((drawing(*loose, thickness=3.0),), PLASMA).text


BACK = [
    (Bezier(((0, 0), (40, 0), (0, 0))), 20.0),
    (Bezier(((0, 0), (60, 0), (60, 0), (30, 0))), 19.705),
    (Bezier(((0, 0), (30, 10), (60, 0), (30, 10), (0, 0))), 37.990),
]


@pytest.mark.parametrize(("curve", "length"), BACK)
def test_a_curve_that_runs_back_along_itself_is_told(curve: Bezier, length: float) -> None:
    part = drawing(contour((curve,)), thickness=3.0)
    (said,) = (d for d in post((part,), MACHINE).remarks if d.code == "plan-doubles-back")
    assert f"runs back along itself for {length:.3f} mm; it is followed" in str(said)
    with pytest.raises(PlanError, match=f"along itself for {length:.3f} mm; expected") as caught:
        post((part,), PLASMA)
    assert [d.code for d in caught.value.diagnostics] == ["plan-doubles-back-kerf"]


def wound(times: float, growth: float = 0.0) -> Part:
    """A curve about a centre that goes round so often, so much farther out each time."""
    turns = np.linspace(0.0, 2 * np.pi * times, int(24 * times) + 1)
    radius = 30.0 + growth * turns / (2 * np.pi)
    slope = growth / (2 * np.pi)
    at = np.column_stack((radius * np.cos(turns), radius * np.sin(turns)))
    speed = np.column_stack((slope * np.cos(turns) - at[:, 1], slope * np.sin(turns) + at[:, 0]))
    reach = speed * (turns[1] - turns[0]) / 3
    hulls = np.stack((at[:-1], at[:-1] + reach[:-1], at[1:] - reach[1:], at[1:]), axis=1)
    curves = tuple(Bezier(tuple(map(tuple, hull))) for hull in hulls.tolist())
    return drawing(contour(curves), thickness=3.0)


@pytest.mark.parametrize("machine", [MACHINE, PLASMA], ids=["laser", "plasma"])
@pytest.mark.parametrize(("times", "length"), [(1.25, 47.1), (2.0, 188.5), (3.5, 471.2)])
def test_a_curve_that_runs_over_itself_is_refused(
    machine: Machine, times: float, length: float
) -> None:
    with pytest.raises(PlanError, match="plan-runs-over-itself") as caught:
        post((wound(times),), machine)
    found = float(re.findall(r"for (\S+) mm", caught.value.diagnostics[0].message)[0])
    assert found == pytest.approx(length, abs=0.6)


def test_hundreds_of_rounds_are_not_compared_pair_by_pair(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is found so far is enough to refuse the curve."""
    monkeypatch.setattr(running_back, "AT_ONCE", 100)
    monkeypatch.setattr(running_back, "MAX_PAIRS", 1000)
    with pytest.raises(PlanError, match="plan-runs-over-itself") as caught:
        post((wound(3.5),), MACHINE)
    found = float(re.findall(r"for (\S+) mm", caught.value.diagnostics[0].message)[0])
    assert running_back.MIN_LENGTH < found < 471.0


@pytest.mark.parametrize("part", [wound(1.0), wound(3.5, 4.0)], ids=["ring", "spiral"])
def test_a_ring_and_a_spiral_do_not_run_over_themselves(part: Part) -> None:
    assert "plan-runs-over-itself" not in {d.code for d in post((part,), MACHINE).remarks}


def test_a_cusp_does_not_run_back() -> None:
    cusp = Bezier(((0, 0), (40, 20), (0, 20), (40, 0)))
    part = drawing(contour((cusp, Line((40, 0), (40, -9)))), thickness=3.0)
    assert "plan-doubles-back" not in {d.code for d in post((part,), MACHINE).remarks}


def test_a_hook_beyond_the_end_of_a_straight_curve_is_followed() -> None:
    """It is on the line through both ends, and not between them."""
    hook = Bezier(((0, 0), (90, 0), (-50, 0), (20, 0)))
    part = drawing(contour((hook,)), thickness=3.0)
    text = post((part,), MACHINE).text
    xs = [float(x) for x in re.findall(r"^G1 X(\S+)", text, re.M)]
    assert max(xs) - min(xs) == pytest.approx(hook.bbox[2] - hook.bbox[0], abs=0.02)


@pytest.mark.parametrize("width", [0.0015, 0.0019, 0.0021, 0.003, 0.005, 0.02, 0.05])
def test_contours_hardly_wider_than_nothing(width: float) -> None:
    """Planner and read-back agree on which of them have an inside."""
    part = drawing(contour(box(0, 0, width, 0.2)), contour(box(9, 0, 30, width)), thickness=3.0)
    assert post((part,), PLASMA).text


def test_what_lies_beside_a_contour_drawn_twice_may_be_cut_after_it() -> None:
    """The ring that is cut once is known, whichever of both drawings lies nearer to its path."""
    features = (
        contour(circle(50, 50, 101.6), line=1), contour(circle(50, 50, 50.8), line=2),
        *(contour(circle(50 + x, 50 + y, 6.35), line=3) for x, y in ((41, 0), (-41, 0), (0, 41))),
        contour(circle(50, 50, 50.8), line=4),
    )  # fmt: skip
    assert post((drawing(*features),), table("plate-codesys")).text


@settings(max_examples=examples(60), deadline=None)
@given(
    side=st.integers(0, 3), share=st.floats(0, 1), back=st.floats(1e-10, 9.9e-4),
    kind=st.sampled_from(["step", "out", "in", "sharp"]), drawn=st.booleans(),
)  # fmt: skip
def test_a_step_back_of_a_micrometre_is_no_fault(
    side: int, share: float, back: float, kind: str, drawn: bool
) -> None:
    """A contour that runs back along itself by less than 0.001 mm is cut as if it did not."""
    corners = [(0.0, 0.0), (80.0, 0.0), (80.0, 60.0), (0.0, 60.0)]
    (x0, y0), (x1, y1) = corners[side], corners[(side + 1) % 4]
    ux, uy = (x1 - x0) / hypot(x1 - x0, y1 - y0), (y1 - y0) / hypot(x1 - x0, y1 - y0)
    x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
    odd = {
        "step": [(x, y), (x - back * ux, y - back * uy)],
        "out": [(x, y), (x + back * uy, y - back * ux), (x, y)],
        "in": [(x, y), (x - back * uy, y + back * ux), (x, y)],
        "sharp": [(x, y), (x - back * ux, y - back * uy), (x + back / 10 * uy, y - back / 10 * ux)],
    }[kind]
    points = [*corners[: side + 1], *odd, *corners[side + 1 :]]
    curves = lines(*points)
    features = (
        [contour((one,), line=k + 1) for k, one in enumerate(curves)]
        if drawn
        else [contour(curves)]
    )
    part = drawing(*features, thickness=3.0)
    posted = post((part,), table("plate-linuxcnc", thickness=3.0))
    assert len(posted.plan.operations) == 1
    assert not [d for d in posted.remarks if d.severity is Severity.ERROR]
