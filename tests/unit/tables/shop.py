"""Samples on their way to trigger programs and step tables."""

from functools import cache
from pathlib import Path

from msgspec.structs import replace

from beamcam.emitters import simotion
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import SheetPlan
from beamcam.model.program import TriggerTable
from beamcam.motion.triggers import trigger_table
from beamcam.planning.sheet import plan_sheet
from beamcam.readers import read

SAMPLES = Path(__file__).resolve().parents[3] / "samples" / "json"
NAMES = ("four-nodes", "rounded-rectangle", "shield", "shield-small", "two-tangents")


@cache
def part(name: str) -> Part:
    path = SAMPLES / f"{name}.json"
    reading = read(path.read_bytes(), path.name)
    assert len(reading.parts) == 1, reading.diagnostics
    return reading.parts[0]


@cache
def steel_part(name: str) -> Part:
    """The part in what the torch has data of; some samples are acrylic, for the laser."""
    return replace(part(name), grade="S235")


@cache
def plan(name: str, machine: str) -> SheetPlan:
    own = load(machine)
    return plan_sheet([part(name) if own.stepper else steel_part(name)], own)


def table_machine(**changes: object) -> Machine:
    """The table on SIMOTION with some of its data changed."""
    machine = load("table-simotion")
    assert machine.triggers is not None
    return replace(machine, triggers=replace(machine.triggers, **changes))


def plain_machine(**changes: object) -> Machine:
    """The table on PLCopen blocks with some of its data changed."""
    machine = load("table-plcopen")
    assert machine.triggers is not None
    return replace(machine, triggers=replace(machine.triggers, **changes))


def triggers(name: str, machine: Machine | None = None) -> TriggerTable:
    return trigger_table(plan(name, "table-simotion"), machine or table_machine(), name)


def program(name: str, style: str, machine: Machine | None = None) -> str:
    machine = machine or table_machine()
    return simotion.emit(triggers(name, machine), machine, style)
