"""Hatches in laser mode: the tool on from line to line, dark before and behind each of them."""

import re
from math import dist, hypot

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.checks.sheets.required_layout import laid_out
from beamcam.errors import PlanError
from beamcam.machine import Machine
from beamcam.machine.torch_faults import torch_faults
from beamcam.pipeline import post
from tests.conftest import examples
from tests.unit.sheets.parts import box, circle, contour, drawing
from tests.unit.sheets.test_hatch import GRBL, PART, asked

BLACK = "#000000"
Lit = tuple[tuple[float, float], tuple[float, float]]


def laser(overscan: float = 0.0, margin: float = 10.0, mode: bool = True) -> Machine:
    assert GRBL.torch is not None
    torch = replace(GRBL.torch, laser_mode=mode, overscan=overscan, margin=margin)
    return replace(GRBL, torch=torch)


def moves(text: str, mode: bool = True) -> list[tuple[Lit, float, int]]:
    """Each move by a reader of the test: its ends, the power that it is made with, its motion."""
    here, power, on, motion, found = (0.0, 0.0), 0.0, False, 0, []
    for block in text.splitlines():
        words = re.findall(r"([A-Z])(-?[\d.]+)", block.split("(")[0])
        place = dict.fromkeys("XY", None)
        for letter, number in words:
            if letter == "S":
                power = float(number)
            elif letter == "M":
                on = number in ("3", "4") or (on and number != "5")
            elif letter == "G" and number in ("0", "1", "2", "3"):
                motion = int(number)
            elif letter in place:
                place[letter] = float(number)  # type: ignore[assignment]
        if place["X"] is not None and place["Y"] is not None:
            end = place["X"], place["Y"]
            dark = not on or (mode and motion == 0)
            found.append(((here, end), 0.0 if dark else power, motion))
            here = end
    return found


def lit(text: str, mode: bool = True) -> list[tuple[Lit, float]]:
    return [(ends, power) for ends, power, _ in moves(text, mode) if power]


@pytest.mark.parametrize("overscan", [0.0, 2.5])
def test_what_is_lit_is_what_was_lit_line_by_line(overscan: float) -> None:
    """The same lines at the same power; the tool is switched on once for neighbouring ones."""
    one_by_one = post((PART,), asked(laser(mode=False), 2.0)).text
    together = post((PART,), asked(laser(overscan), 2.0)).text
    assert sorted(lit(together)) == sorted(lit(one_by_one, mode=False))
    assert together.count("M4") < one_by_one.count("M4") / 2
    assert together.count("M4") == together.count("M5") - 1  # one stands in the head


def test_each_line_has_its_overscan_in_its_direction() -> None:
    text = post((PART,), asked(laser(3.0), 2.0)).text
    every = moves(text)
    seen = 0
    for before, (ends, power, _), behind in zip(every, every[1:], every[2:], strict=False):
        if power != 300.0 or before[2] != 1 or before[1]:
            continue
        (a, b), (run_up, _), (_, run_out) = ends, before[0], behind[0]
        assert dist(run_up, a) == pytest.approx(3.0, abs=0.002)
        assert dist(b, run_out) == pytest.approx(3.0, abs=0.002)
        assert (before[1], behind[1], behind[2]) == (0.0, 0.0, 1)
        u, v = (b[0] - a[0]) / dist(a, b), (b[1] - a[1]) / dist(a, b)
        assert hypot(a[0] - run_up[0] - 3 * u, a[1] - run_up[1] - 3 * v) < 0.003
        seen += 1
    assert seen > 20


@settings(max_examples=examples(30), deadline=None)
@given(
    width=st.floats(5, 60), height=st.floats(5, 60), hole=st.floats(1, 30),
    distance=st.floats(0.3, 5), angle=st.floats(-180, 180), one_way=st.booleans(),
    overscan=st.sampled_from([0.0, 0.5, 4.0]),
)  # fmt: skip
def test_no_hatch_is_refused(
    width: float, height: float, hole: float, distance: float, angle: float, one_way: bool,
    overscan: float,
) -> None:  # fmt: skip
    part = drawing(
        contour(box(-30, -30, 130, 130)), contour(box(0, 0, width, height), BLACK, line=2),
        contour(circle(width / 2, height / 2, hole), BLACK, line=3), thickness=3.0,
    )  # fmt: skip
    machine = asked(laser(overscan), distance, angle, one_way=one_way)
    try:
        posted = post((part,), machine)
    except PlanError:  # contours that cross, or a hatch that fills nothing
        return
    assert posted.time(machine).total_s > 0.0
    assert len(posted.time(machine).operations) == len(posted.plan.operations)


LINE = r"(G0 X\S+ Y24\n)(M4 S0 F3500\n)(G1 X24 Y24\n)(S300\n)(G1 X76 Y24\n)(S0\n)(G1 X79 Y24\n)"
WRONG = [
    ("run-up lit", r"\1M4 S300 F3500\n\3\4\5\6\7"), ("run-out lit", r"\1\2\3\4\5\7"),
    ("line dark", r"\1\2\3\5\6\7"), ("line at another power", r"\1\2\3S200\n\5\6\7"),
    ("no run-up", r"G0 X24 Y24\n\2\4\5\6\7"), ("no run-out", r"\1\2\3\4\5\6"),
    ("run-up too short", r"G0 X22 Y24\n\2\3\4\5\6\7"),
    ("run-up from the side", r"G0 X24 Y21\n\2\3\4\5\6\7"),
    ("run-out too long", r"\1\2\3\4\5\6G1 X84 Y24\n"),
    ("line too short", r"\1\2\3\4G1 X70 Y24\n\6\7"),
    ("another dark feed", r"\1\2\3\4\5\6\7G1 X79 Y28\n"),
]  # fmt: skip


@pytest.mark.parametrize(("what", "other"), WRONG, ids=[what for what, _ in WRONG])
def test_another_overscan_is_refused(what: str, other: str) -> None:
    machine = asked(laser(3.0), 8.0)
    text = post((PART,), machine).text
    assert re.search(LINE, text)
    parts, _ = laid_out((PART,), machine.torch)
    assert not verify_sheet(text, parts, machine)
    assert verify_sheet(re.sub(LINE, other, text), parts, machine), what


def test_a_contour_has_no_overscan() -> None:
    """A dark feed in front of one is told."""
    machine = asked(laser(3.0), 8.0)
    text = post((PART,), machine).text
    parts, _ = laid_out((PART,), machine.torch)
    wrong = text.replace("G0 X90 Y70\n", "G0 X93 Y70\nG1 X90 Y70\n")
    assert wrong != text
    assert {d.code for d in verify_sheet(wrong, parts, machine)} & {
        "verify-sheet-overscan", "verify-sheet-idle",
    }  # fmt: skip


def test_it_has_to_fit_on_the_table() -> None:
    post((PART,), asked(laser(3.0, margin=10.0), 8.0))
    edge = drawing(contour(box(0, 0, 80, 60), BLACK), thickness=3.0)
    with pytest.raises(PlanError, match="plan-sheet-place"):
        post((edge,), asked(laser(30.0, margin=10.0), 8.0))


@pytest.mark.parametrize("mode", [False, True])
def test_a_machine_without_laser_mode_or_words_is_told(mode: bool) -> None:
    machine = laser(2.0, mode=mode)
    if mode:
        machine = replace(machine, words=replace(machine.words, power=()))
    assert "torch.overscan" in {key for key, _ in torch_faults(machine)}
    assert "torch.overscan" not in {key for key, _ in torch_faults(laser(2.0))}
