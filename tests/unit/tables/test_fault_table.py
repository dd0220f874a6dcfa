"""What each fault costs with the torch on, measured and held against the table of docs/simotion.md.

Each fault is thrown in at ten moments of the small job's cuts, with commands to axes, path objects
and blocks, and at ten of a slanting edge of 600 mm, in both styles: when is the torch off, how far
has it burnt, how far off its path.
"""

from collections.abc import Callable
from functools import cache
from math import dist, hypot
from pathlib import Path

import pytest
from msgspec import Struct

from beamcam.emitters import simotion
from beamcam.machine.machine import Machine
from beamcam.model.program import SwitchTool, Travel, TriggerTable
from tests.conftest import Golden, sampled

from .deeds import (
    alarm,
    break_wire,
    close,
    creep,
    disable,
    fault_task,
    freeze,
    override,
    press_stop,
)
from .plant import (
    CUT,
    FAULT,
    KINDS,
    LIFT_SPEED,
    LIFTED,
    STOPPED_S,
    STYLES,
    THICKNESS,
    Deed,
    Plant,
    small_job,
    small_machine,
    units_of,
)
from .shop import plain_machine, table_machine

DOCS = Path(__file__).resolve().parents[3] / "docs" / "simotion.md"
BEGIN, END = "<!-- measured faults -->\n", "<!-- end -->\n"
FEED = 8.0  #: mm/s, of both jobs
Z = 2  #: index of the axis that lifts the torch
MOMENTS = 10


Seen = Callable[[Plant], bool]


def at_once(_: Plant) -> bool:
    """A fault that a bit tells."""
    return True


def beyond(index: int) -> Seen:
    """Whether an axis is further from its set position than it may be."""
    return lambda one: off(one, index) > window_of(one, index) + one.may_trail[index]


def leaves(index: int) -> Seen:
    """Whether an axis is further from its set position than its encoder can be wrong."""
    return lambda one: off(one, index) > one.triggers.counts()[index]


def window_of(one: Plant, index: int) -> float:
    """Of an axis at rest; Z has its own."""
    z = one.triggers.z
    return z.arrival_window if z and index == Z else one.triggers.arrival_window


def off(one: Plant, index: int) -> float:
    axis = one.axes[index]
    return abs(axis.actual - axis.position)


def stands(cycles: int) -> Seen:
    """Whether both set positions rest on a way that was commanded more than so many cycles ago."""

    def seen(one: Plant) -> bool:
        end = one.value("targetX"), one.value("targetY")
        on_the_way = dist(end, [a.position for a in one.axes[:Z]]) > one.triggers.in_position
        late = one.count - 1 > one.commanded + cycles
        moves = one.value("operationKind") in (0, 7)
        return moves and one.speeds == [0.0, 0.0] and on_the_way and late

    return seen


class Row(Struct, frozen=True):
    """A fault: its number, what happens; deeds, since when they matter and can be seen."""

    number: int
    what: str
    deeds: tuple[tuple[Deed, Seen, Seen], ...]
    while_z: str = ""  #: what the third axis does then: it "rests", or goes "down"


def told(*deeds: Deed) -> tuple[tuple[Deed, Seen, Seen], ...]:
    """Deeds that a bit tells at once."""
    return tuple((deed, at_once, at_once) for deed in deeds)


ROWS = (
    Row(1, "a limit switch is actuated, or its wire breaks",
        told(*map(close, range(4)), *map(break_wire, range(4)))),
    Row(2, "a drive drops out", told(disable(0), disable(1))),
    Row(2, "an axis reports an error", told(alarm(0), alarm(1))),
    Row(4, "the set positions stop short of their end", ((override(0.0), stands(0), stands(2)),)),
    Row(6, "a fault task is called", told(fault_task)),
    Row(7, "an axis sticks, and its drive says nothing",
        tuple((freeze(k), leaves(k), beyond(k)) for k in (0, 1))),
    Row(7, "an axis creeps away at 8 mm/s, and its drive says nothing",
        tuple((creep(k, v), leaves(k), beyond(k)) for k in (0, 1) for v in (FEED, -FEED))),
    Row(7, "Z sticks as it comes down to cut, and its drive says nothing",
        ((freeze(Z), leaves(Z), beyond(Z)),), "down"),
    Row(7, "Z creeps up or down at 8 mm/s, and its drive says nothing",
        tuple((creep(Z, v), leaves(Z), beyond(Z)) for v in (FEED, -FEED)), "rests"),
    Row(9, "the stop button is pressed, or its wire breaks", told(press_stop, break_wire(6))),
)  # fmt: skip


@cache
def long_edge(style: str, kind: str) -> tuple[Plant, list[object]]:
    """An edge of 600 mm on the shipped table, and ten moments of it."""
    machine = plain_machine() if kind == "blocks" else table_machine()
    job = TriggerTable("long", (
        Travel(50, 20, 20.0), SwitchTool("cut", True, 0.3), Travel(410, 500, FEED),
        SwitchTool("cut", False), Travel(0, 0, 20.0),
    ))  # fmt: skip
    assert hypot(410 - 50, 500 - 20) == 600
    return moments(machine, job, style)


@cache
def short_job(style: str, kind: str, while_z: str = "") -> tuple[Plant, list[object]]:
    return moments(small_machine(kind), small_job(kind), style, while_z)


def moments(
    machine: Machine, job: TriggerTable, style: str, while_z: str = ""
) -> tuple[Plant, list[object]]:
    """A plant, and copies of it at ten moments with the torch on: first, last and between."""

    def lasts() -> bool:
        if while_z == "down":  # until it is a window above the end of its way
            return one.axes[Z].position > CUT + THICKNESS + 2 * window_of(one, Z)
        return one.tool("cut")

    one = Plant(units_of(simotion.emit(job, machine, style), machine), machine)
    one.press_start()
    while not one.tool("cut") or (while_z == "rests" and max(one.speeds[:Z]) == 0.0):
        one.cycle()
    first = one.keep()
    count = 0
    while lasts():
        one.cycle()
        count += 1
    one.go_back(first)
    wanted = [round(k * (count - 2) / (MOMENTS - 1)) for k in range(MOMENTS)]
    kept = []
    for k in range(count):
        if k in wanted:
            kept.append(one.keep())
        one.cycle()
    assert len(kept) == MOMENTS
    return one, kept


class Cost(Struct, frozen=True):
    """What a fault costs until the torch is off."""

    cycles: int  #: since it can be seen
    seconds: float  #: since it matters
    burnt: float  #: mm of way since then
    off: float  #: mm between set and actual position
    runs_on: float  #: mm of way until both axes rest, with the torch off


def scan(one: Plant) -> list[float]:
    """A cycle, and where the head was by its encoders when the program looked at it."""
    places = [axis.position for axis in one.axes]
    one.cycle()
    return [place + axis.lag for place, axis in zip(places, one.axes, strict=True)]


def cost(one: Plant, number: int, deed: Deed, matters: Seen, seen: Seen) -> Cost | None:
    """The cost of a fault that begins right behind a scan. None if the cut ends before it harms."""
    here = scan(one)
    before = one.clock_s - one.triggers.cycle_s
    began = before if matters is at_once else None
    deed(one)
    cycles, burnt, most_off = 0, 0.0, 0.0
    while one.tool_on:
        last, here = here, scan(one)
        if began is None and matters(one):
            began = before
        if began is not None:
            burnt += dist(last[:Z], here[:Z])
        before = one.clock_s - one.triggers.cycle_s
        cycles += seen(one)
        most_off = max(most_off, *(off(one, k) for k in range(len(one.axes))))
    one.cycle()  # which sees what a fault task has done
    if one.value("workState") != FAULT:
        assert most_off <= one.triggers.arrival_window
        return None
    assert one.value("faultNumber") == number
    assert began is not None
    way = 0.0
    for _ in range(round(STOPPED_S / one.triggers.cycle_s)):
        last, here = here, scan(one)
        way += dist(last, here)
    assert max(one.speeds) == 0.0
    return Cost(cycles, before - began, burnt, most_off, way)


@cache
def costs(number: int, what: str) -> tuple[Cost, ...]:
    """Of a fault, at every moment, in both jobs and styles."""
    found = []
    (row,) = (row for row in ROWS if (row.number, row.what) == (number, what))
    for style in STYLES:
        jobs = [short_job(style, kind, row.while_z) for kind in (LIFTED if row.while_z else KINDS)]
        if not row.while_z:
            jobs += [long_edge(style, kind) for kind in ("axes", "blocks")]
        for one, kept in jobs:
            if number == 6 and not one.interpreter.has("CutFault"):
                continue  # blocks of PLCopen have no fault tasks
            for moment in kept:
                for deed, matters, seen in row.deeds:
                    one.go_back(moment)
                    found.append(cost(one, row.number, deed, matters, seen))
    harmful = tuple(c for c in found if c is not None)
    assert len(harmful) >= 0.8 * len(found)
    return harmful


@pytest.mark.parametrize("row", sampled(ROWS, 3), ids=lambda row: row.what)
def test_the_torch_is_off_within_two_cycles(row: Row) -> None:
    found = costs(row.number, row.what)
    t = table_machine().triggers
    assert t is not None
    speed = LIFT_SPEED if row.while_z == "down" else FEED
    window = t.arrival_window + speed * t.following_lag_s
    assert {c.cycles for c in found} <= {0, 1, 2}
    # The window, and as far as an axis goes in the cycle before, in the two of the fault, and the
    # jitter of a count.
    assert max(c.off for c in found) <= window + 3 * speed * t.cycle_s + t.count
    if row.number != 7:  # which takes as long as an axis needs to be off by its window
        assert max(c.seconds for c in found) <= 4 * t.cycle_s + 1e-9


@pytest.mark.parametrize("every", [3, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_the_page_has_the_measured_table(every: int, golden: Golden) -> None:
    page = DOCS.read_text(encoding="utf-8")
    before, _, rest = page.partition(BEGIN)
    table, _, behind = rest.partition(END)
    assert behind, "the page has lost its table"
    _, _, *written = table.splitlines(keepends=True)
    lines = [
        "| number | what happens | cycles | s | mm burnt | mm off the path | mm run on |\n",
        "| --- | --- | --- | --- | --- | --- | --- |\n",
    ]
    for k, row in enumerate(ROWS):
        if k % every and not golden.update:
            lines += written[k : k + 1]
            continue
        found = costs(row.number, row.what)
        worst = [max(getattr(c, key) for c in found) for key in Cost.__struct_fields__]
        figures = f"{worst[0]} | {worst[1]:.3f} | " + " | ".join(f"{v:.2f}" for v in worst[2:])
        lines.append(f"| {row.number} | {row.what} | {figures} |\n")
    golden.check(DOCS, f"{before}{BEGIN}{''.join(lines)}{END}{behind}")
