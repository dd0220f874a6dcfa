"""A round tube whose axis counts mm of the surface: the same cuts in another dialect."""

import re
from dataclasses import dataclass
from math import radians
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.controllers import cell_events
from beamcam.controllers.events import Move, in_degrees
from beamcam.errors import PlanError, errors_in
from beamcam.machine import load
from beamcam.machine.overlay import with_section
from beamcam.model.part import Hole
from beamcam.model.request import Request
from beamcam.pipeline import post
from beamcam.recovery import recover
from beamcam.simulation.program import simulate_program
from beamcam.solid.opinion import solid_faults
from tests.conftest import examples, sampled
from tests.random_boxes import random_box
from tests.random_tubes import random_tube, window
from tests.rs274 import needs_rs274
from tests.unit.coping.samples import AT, sample
from tests.unit.coping.test_tubes import TUBE, TURN, burns, found, program_of, tube

SURFACE = load("tube-surface")


@dataclass
class Block:
    """A move as it is written."""

    words: str  #: without A
    a: float


def blocks(text: str) -> list[Block]:
    """The moves of a program that turn the tube."""
    lines = [line for line in text.splitlines() if re.match(r"G[01] .*A", line)]
    seen = [re.fullmatch(r"(G[01] .*?) ?A(-?[\d.]+)( F.*)?", line) for line in lines]
    seen += [re.fullmatch(r"(G0) A(-?[\d.]+)()", line) for line in lines if line.startswith("G0 A")]
    return [Block(f"{m[1]}{m[3] or ''}", float(m[2])) for m in seen if m is not None]


@given(st.integers(0, 5000))
@settings(max_examples=examples(15))
def test_each_block_is_that_of_the_other_dialect(seed: int) -> None:
    """u = R (90 - A), in radians; X, Y, Z and F are the same."""
    part = random_tube(seed)
    radius = part.profile.height / 2
    by_degrees, by_mm = (blocks(program_of(part, machine)) for machine in (TUBE, SURFACE))
    assert [b.words for b in by_degrees] == [b.words for b in by_mm]
    assert all(
        abs(radius * radians(90.0 - one.a) - other.a) < 1e-3
        for one, other in zip(by_degrees, by_mm, strict=True)
    )


def test_a_program_is_the_unrolled_drawing() -> None:
    """A window from 150 to 180 of the way round, its middle half a kerf wider each side."""
    text = program_of(tube(window(300.0, 150.0, 60.0, 30.0)), SURFACE)
    cut = text[text.index("(cut-out)") : text.index("(near end)")]
    us = [float(u) for u in re.findall(r"A([\d.]+) F", cut)]
    assert (min(us[1:]), max(us)) == pytest.approx((151.1, 178.9), abs=0.01)


@pytest.mark.parametrize("name", sampled(["stub", "brace"], 2))
def test_samples_are_read_back_by_all(name: str) -> None:
    part = sample(name)
    text = program_of(part, SURFACE)
    told = {d.code for d in solid_faults(text, Request((part,), SURFACE))}
    assert told <= {"solid-rounded", "solid-square"}
    (back,) = recover(text, SURFACE).parts
    assert not errors_in(verify_coping(program_of(back, SURFACE), (part,), SURFACE))
    done = simulate_program(text, SURFACE, "p.ngc")
    assert [axis.unit for axis in done.trace.axes] == ["mm"] * 4
    assert done.trace.duration_s == pytest.approx(
        post((part,), SURFACE).time(SURFACE).total_s, abs=0.01
    )


def test_the_other_dialect_and_another_place_are_refused() -> None:
    part = tube(Hole("v", 200.0, 100.0, 26.0, AT))
    text = program_of(part, SURFACE)
    assert found(text, part, TUBE)
    assert found(program_of(part), part, SURFACE)
    shifted = re.sub(r"A(-?[\d.]+)", lambda m: f"A{float(m[1]) + 1.0:g}", text[: text.index("M5")])
    assert found(shifted + text[text.index("M5") :], part, SURFACE)
    assert solid_faults(shifted + text[text.index("M5") :], Request((part,), SURFACE))


def test_limits_are_those_of_the_axis_in_mm() -> None:
    part = tube(Hole("v", 200.0, 100.0, 26.0, AT))
    axes = tuple(replace(a, min=0.0, max=520.0) if a.moves == "A" else a for a in SURFACE.axes)
    text = program_of(part, SURFACE)
    said = {d.code for d in found(text, part, replace(SURFACE, axes=axes))}
    assert said == {"verify-coping-limit"}  # the ends go on to the circumference
    wide = tuple(replace(a, min=0.0, max=2 * TURN) if a.moves == "A" else a for a in SURFACE.axes)
    assert not found(text, part, replace(SURFACE, axes=wide))


def test_a_rectangular_tube_is_not_for_it() -> None:
    part = random_box(1)
    with pytest.raises(PlanError, match="plan-stock"):
        post((part,), SURFACE)
    (said,) = verify_coping(program_of(part), (part,), SURFACE)
    assert (said.code, said["expected"]) == ("verify-coping-section", "RO")
    assert with_section(SURFACE, 10.0, None) is SURFACE


def test_events_of_a_machine_in_degrees_stay() -> None:
    events, _ = cell_events("G90\nG0 A20\nM2\n", TUBE)
    assert TUBE.coper is not None
    assert in_degrees(events, TUBE.coper, 100.0) == events
    assert SURFACE.coper is not None
    (move,) = [e for e in in_degrees(events, SURFACE.coper, 100.0) if isinstance(e, Move)]
    assert radians(90.0 - move.a_deg[1]) * 50.0 == pytest.approx(20.0)


@needs_rs274
def test_the_path_that_rs274_prints_is_the_contour(tmp_path: Path) -> None:
    part = tube(window(300.0, 200.0, 60.0, 50.0))
    (tmp_path / "t.ngc").write_text(program_of(part, SURFACE))
    inner, near, far = burns(tmp_path / "t.ngc")
    xs, us = [x for x, _ in inner[2:]], [u for _, u in inner[2:]]
    assert (min(xs), max(xs)) == pytest.approx((301.1, 358.9), abs=0.01)
    assert (min(us), max(us)) == pytest.approx((201.1, 248.9), abs=0.01)
    for stroke, x in ((near, -1.1), (far, 501.1)):
        assert all(place[0] == pytest.approx(x, abs=1e-3) for place in stroke[2:])
        assert abs(stroke[-1][1] - stroke[2][1]) == pytest.approx(TURN, abs=1e-3)
