"""Trigger programs in plain IEC 61131-3: the same path as on SIMOTION, and the same laws."""

from functools import cache

import pytest
import shapely

from beamcam.checks.st import verify_triggers
from beamcam.emitters import simotion
from beamcam.machine.runtime import runtime_of
from tests.conftest import sampled

from .deeds import close, mend
from .plant import (
    DONE,
    FAULT,
    HOMING,
    STOPPED_S,
    STYLES,
    WAITS,
    WORK,
    Plant,
    cutting,
    plant,
    small_job,
    small_machine,
    units_of,
)
from .shop import NAMES, plain_machine, steel_part, table_machine, triggers


@cache
def program(name: str, style: str) -> str:
    return simotion.emit(triggers(name), plain_machine(), style)


# -- what it makes --------------------------------------------------------------------------


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", sampled(NAMES, 2))
def test_every_sample_makes_its_part(name: str, style: str) -> None:
    text = program(name, style)
    machine = plain_machine()
    assert verify_triggers(text, [steel_part(name)], machine, (), "a.st") == ()
    assert verify_triggers(text, [], machine, (), "a.st") == ()
    assert text.isascii()
    assert "//" not in text
    fixed = runtime_of(machine, style)
    for piece in (fixed.head, fixed.middle, fixed.end):
        assert text.count(piece) == 1


@pytest.mark.parametrize(
    ("name", "style"),
    sampled([("shield", "chain"), ("four-nodes", "chain"), ("rounded-rectangle", "table"),
             ("two-tangents", "table")], 2),
)  # fmt: skip
def test_both_dialects_draw_the_same_path(name: str, style: str) -> None:
    """Lines, arcs and a polynomial, run by an executor of each text."""
    points = {}
    for machine in (table_machine(), plain_machine()):
        text = simotion.emit(triggers(name), machine, style)
        one = Plant(units_of(text, machine), machine)
        one.press_start()
        one.run_until(DONE, 900.0)
        assert one.diagnostics == []
        assert one.states == [WAITS, HOMING, WORK, DONE]
        points[machine.name] = one.points
    simotion_points, plain_points = points.values()
    assert simotion_points.keys() == plain_points.keys() != set()
    tolerance = plain_machine().torch.tolerance  # type: ignore[union-attr]
    for process, drawn in simotion_points.items():
        one, other = shapely.LineString(drawn), shapely.LineString(plain_points[process])
        assert shapely.hausdorff_distance(one, other) <= tolerance


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("restarts", [0, 1])
def test_both_dialects_take_the_same_path_and_time(style: str, restarts: int) -> None:
    """A restart begins the part anew, behind a fault in mid cut."""
    told = []
    for machine in (small_machine(), small_machine("blocks")):
        one = Plant(units_of(simotion.emit(small_job(), machine, style), machine), machine)
        for _ in range(restarts):
            cutting(one)
            one.wait(0.3)
            close(1)(one)
            one.cycle()
            assert (one.value("workState"), one.value("faultNumber")) == (FAULT, 1)
            assert not one.tool_on
            one.wait(STOPPED_S)
            assert one.still
            mend(one)
            one.press_acknowledge()
            one.cycle()
            assert one.value("workState") == WAITS
            one.points.clear()
        one.press_start()
        one.run_until(WORK)
        before = one.count
        one.run_until(DONE)
        assert [round(axis.position, 6) for axis in one.axes] == [0.0, 0.0]
        told.append((one.count - before, one.points))
    (cycles, points), (other_cycles, other_points) = told
    assert cycles == other_cycles
    assert points.keys() == other_points.keys() == {"cut", "mark"}
    for process in points:
        pairs = zip(points[process], other_points[process], strict=True)
        assert all(a == pytest.approx(b, abs=1e-6) for a, b in pairs)


def test_an_axis_that_is_held_by_a_stop_is_let_go_by_the_acknowledgement() -> None:
    one = plant(kind="blocks")
    one.press_start()
    one.run_until(WORK)
    close(3)(one)
    one.wait(STOPPED_S)
    assert all(axis.held_by is not None for axis in one.axes)
    mend(one)
    one.press_acknowledge()
    one.wait(0.1)
    assert all(axis.held_by is None for axis in one.axes)


def test_drives_are_off_until_the_first_start() -> None:
    one = plant(kind="blocks")
    one.wait(0.5)
    assert not any(axis.enabled for axis in one.axes)
    one.press_start()
    one.wait(0.1)
    assert all(axis.enabled for axis in one.axes)
