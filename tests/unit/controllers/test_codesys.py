"""The interpreter of CODESYS: modal state, arcs and what the controller does not do."""

from math import cos, isnan, nan, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.controllers import cell_events
from beamcam.controllers.codesys import arc_fault, curve_of
from beamcam.controllers.events import BarEvent, Blending, Compensation, Move, Pause, Switch
from beamcam.controllers.interpreter import sweep_of
from beamcam.geometry.curves import Arc
from beamcam.machine import load
from tests.conftest import examples

CELL = load("beamline")


def events(text: str) -> list[BarEvent]:
    found, said = cell_events(text + "\nM30", CELL, "a")
    assert said == []
    assert found[-1] == Switch(text.count("\n") + 2, 30, {})
    return found[:-1]


def messages(text: str) -> list[str]:
    return [str(d) for d in cell_events(text + "\nM30", CELL, "a")[1]]


def test_moves_are_modal_and_feeds_count_a_minute() -> None:
    first, second, third = events("G00 X1 Y2 Z3\nG01 X4 F5\nY6")
    assert first == Move(1, True, (nan, nan, nan), (1.0, 2.0, 3.0), 0.0) or isnan(first.start[0])  # type: ignore[union-attr]
    assert second == Move(2, False, (1.0, 2.0, 3.0), (4.0, 2.0, 3.0), 300.0, True)
    assert third == Move(3, False, (4.0, 2.0, 3.0), (4.0, 6.0, 3.0), 300.0)


def test_relative_and_absolute() -> None:
    moves = events("G00 X1 Y1 Z1\nG91\nG00 X2\nX-1 Y3\nG90\nX0")
    assert [m.end for m in moves] == [(1, 1, 1), (3, 1, 1), (2, 4, 1), (0, 4, 1)]  # type: ignore[union-attr]


def test_switches_and_pauses() -> None:
    assert events("M40 K13 L14\nG04 T0.5\nG42 D1.5\nG40") == [
        Switch(1, 40, {"K": 13.0, "L": 14.0}), Pause(2, 0.5),
        Compensation(3, "right", 1.5), Compensation(4, "on", 0.0),
    ]  # fmt: skip


@pytest.mark.parametrize(("text", "centre", "sweep"), [
    ("G03 X0 Y10 I-10 J0", (0, 0), 90),
    ("G02 X0 Y10 I-10 J0", (0, 0), -270),
    ("G03 X10 Y0 I-10 J0", (0, 0), 360),
    ("G98\nG03 X0 Y10 I0 J0", (0, 0), 90),
    ("G98\nG99\nG03 X0 Y10 I-10 J0", (0, 0), 90),
    ("G03 X0 Y10 R10", (0, 0), 90),
    ("G02 X0 Y10 R10", (10, 10), -90),
    ("G03 X-10 Y0 R10", (0, 0), 180),
])  # fmt: skip
def test_arcs(text: str, centre: tuple[float, float], sweep: float) -> None:
    turn = events("G00 X10 Y0 Z0\n" + text)[-1]
    assert isinstance(turn, Move)
    assert isinstance(turn.curve, Arc)
    assert turn.curve.centre == pytest.approx(centre)
    assert turn.curve.sweep_deg == pytest.approx(sweep)


@pytest.mark.parametrize(("text", "said"), [
    ("X5", "a:1: error verify-word: found words without a command; expected G or M"),
    ("G04 K5", "a:1: error verify-word: found G04; expected T with seconds"),
    ("G92 X10", "a:1: error verify-word: found G92; expected G00 to G04, G06, G08, G09, G40 to "
                "G42, G50 to G55, G75, G90, G91, G98 or G99"),
    ("G54 X10", "a:1: error verify-word: found G54 X; expected X Y Z"),
    ("G55 I1", "a:1: error verify-word: found G55 I; expected some of X Y Z"),
    ("G53 X1", "a:1: error verify-word: found G53 X; expected no word there"),
    ("G56 X1 Y2", "a:1: error verify-word: found G56, places that count from where the axes "
                  "stand; expected G54 with the place; no program that beamcam writes counts "
                  "from where it is"),
    ("M98 L5", "a:1: error verify-word: found M98, a subprogram; expected its blocks here; no "
               "program that beamcam writes calls a subprogram"),
    ("M99", "a:1: error verify-word: found M99, a subprogram; expected its blocks here; no "
            "program that beamcam writes calls a subprogram"),
    ("G51", "a:1: error verify-word: found G51; expected D, 0 or more, the way to the corner"),
    ("G52 D-1", "a:1: error verify-word: found G52 D; expected D, 0 or more, the way to the "
                "corner"),
    ("G50 D1", "a:1: error verify-word: found G50 D; expected no word there"),
    ("G90 X10", "a:1: error verify-word: found X behind G90; expected no word there"),
    ("G01 X1 K5", "a:1: error verify-word: found K behind G01; expected no such word there"),
    ("G91\nG00 X5", "a:2: error verify-word: found a relative move from nowhere; "
                    "expected an absolute place (G90) before"),
])  # fmt: skip
def test_what_the_controller_does_not_do(text: str, said: str) -> None:
    assert said in messages(text)


def test_zero_is_moved_and_places_are_those_of_the_machine() -> None:
    """By hand: 100 + 5, then 110 + 5; an axis that is not said stays, increments stay increments,
    and a centre that is absolute (G98) moves with them."""
    text = ("G00 X0 Y0 Z0\nG54 X100 Y50 Z-10\nG00 X5 Y5 Z0\nG55 X10\nG00 X5\nG91\nG00 X1\n"
            "G90\nG98\nG02 X20 Y5 I13 J5\nG53\nG00 X1 Y2 Z3\n")  # fmt: skip
    moves = [event for event in events(text) if isinstance(event, Move)]
    assert [move.end for move in moves] == [
        (0, 0, 0), (105, 55, -10), (115, 55, -10), (116, 55, -10), (130, 55, -10), (1, 2, 3),
    ]  # fmt: skip
    turn = moves[4].curve
    assert isinstance(turn, Arc)
    assert turn.centre == pytest.approx((123, 55))


def test_corners_are_cut_by_so_much_and_no_more() -> None:
    found = events("G00 X0 Y0 Z0\nG50\nG51 D0.5\nG01 X1 F1\nG52 D2\nG01 Y1\nG50\nG01 X2\n")
    assert [event.distance for event in found if isinstance(event, Blending)] == [0.5, 2.0, 0.0]


@pytest.mark.parametrize(("text", "fault"), [
    ("G02 X5 Y5 I5 J0", "that starts nowhere"),
    ("G00 X0 Y0 Z0\nG02 X5 Y5 I9 J0", "whose radii at start and end differ by 2.597"),
    ("G00 X0 Y0 Z0\nG02 X10 Y0 R4", "of radius 4 over a chord of 10"),
    ("G00 X0 Y0 Z0\nG02 X10 Y0 R-8", "of radius -8"),
    ("G00 X0 Y0 Z0\nG02 X0 Y0 R8", "by R whose end is its start"),
    ("G00 X0 Y0 Z0\nG02 X10 Y0", "without I, J or R"),
    ("G00 X0 Y0 Z0\nG02 X10 Y0 R8 I5", "with R as well as I and J"),
])  # fmt: skip
def test_arcs_that_would_be_lines(text: str, fault: str) -> None:
    (said,) = messages(text)
    assert f"error verify-arc: found an arc {fault}; expected one that start" in said


@pytest.mark.parametrize(("text", "count"), [
    ("M08\n" * 64, 0),
    ("M08\n" * 65, 1),
    ("G00 X1\n" + "M08\n" * 64 + "G00 X2\n" + "M08\n" * 64, 0),
    ("M08\n" * 64 + "G75\n" + "M08\n" * 64, 0),
    ("M08\n" * 64 + "G90\n" + "M08\n", 1),
    ("M08\n" * 60 + "G04 T1\n" * 4, 0),
    ("M08\n" * 60 + "G04 T1\n" * 5 + "G00 X1\n", 1),  # a dwell waits among them
    ("M08\n" * 60 + "G04 T1\n" * 4 + "M08\n", 1),
    ("G00 X1\n" + "M08\n" * 64 + "G00 X1\n" + "M08\n", 1),  # a move to where it stands is none
    ("M08\n" * 200, 1),
])  # fmt: skip
def test_64_m_words_in_a_row(text: str, count: int) -> None:
    said = messages(text + "G00 X9")
    assert len(said) == count
    assert all("verify-m-queue: found 65 M words in a row; expected at most 64" in s for s in said)


# --- rounded arcs ---------------------------------------------------------------------------------


lengths = st.floats(-500, 500)


def ends(centre: tuple[float, float], radius: float, start: float, sweep: float):  # type: ignore[no-untyped-def]
    a, b = radians(start), radians(start + sweep)
    return (
        (centre[0] + radius * cos(a), centre[1] + radius * sin(a)),
        (centre[0] + radius * cos(b), centre[1] + radius * sin(b)),
    )


@settings(deadline=None, max_examples=examples(300))
@given(lengths, lengths, st.floats(1, 300), st.floats(0, 360), st.floats(10, 350), st.booleans())
def test_an_arc_that_is_large_enough_survives_rounding(
    x: float, y: float, radius: float, start: float, sweep: float, clockwise: bool
) -> None:
    turn = -sweep if clockwise else sweep
    first, last = ends((x, y), radius, start, turn)
    rounded = [(round(a, 3), round(b, 3)) for a, b in (first, last, (x, y))]
    assert arc_fault(*rounded, 0.001) is None
    assert sweep_of(first, last, (x, y), clockwise) == pytest.approx(turn, abs=1e-6)


@settings(deadline=None, max_examples=examples(200))
@given(st.floats(1, 300), st.floats(0, 360), st.floats(5, 175), st.booleans())
def test_the_centre_of_an_arc_by_its_radius(
    radius: float, start: float, sweep: float, clockwise: bool
) -> None:
    turn = -sweep if clockwise else sweep
    first, last = ends((7.0, -3.0), radius, start, turn)
    arc = curve_of(2 if clockwise else 3, first, last, {"R": radius}, first, 0.001)
    assert isinstance(arc, Arc)
    assert arc.centre == pytest.approx((7.0, -3.0), abs=1e-6)


def test_a_centre_off_the_bisector() -> None:
    assert arc_fault((0, 0), (10, 0), (5, 5), 0.001) is None
    assert arc_fault((0, 0), (10, 0), (5.01, 5), 0.001) == (
        "whose radii at start and end differ by 0.01414"
    )
    # On a short chord of a large arc the radii hardly differ though the centre is far off.
    assert arc_fault((0, 0), (0.01, 0), (20, 60), 0.05) == (
        "whose centre lies 20 beside the bisector of its chord"
    )
    assert arc_fault((0, 0), (0, 0), (0, 0), 0.001) == "of radius 0"


def test_no_centre_for_an_arc_that_is_none() -> None:
    arc = curve_of(2, (0, 0), (10, 0), {"R": 4.0}, (0, 0), 0.001)
    assert arc == "of radius 4 over a chord of 10"
