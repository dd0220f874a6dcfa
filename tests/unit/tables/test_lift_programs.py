"""Programs of tables that lift their torch: made of samples, read back, changed in one place."""

import re
from functools import cache
from pathlib import Path

import pytest
from msgspec.structs import replace

from beamcam.checks.st import verify_triggers
from beamcam.controllers.simotion.job import read_program
from beamcam.emitters import simotion
from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import shipped
from beamcam.machine.torch import TorchRow
from beamcam.machine.torch_faults import table_faults
from beamcam.model.program import LiftTorch, SwitchTool, TriggerTable
from beamcam.motion.triggers import trigger_table, trigger_time
from beamcam.planning.sheet import plan_sheet
from beamcam.simulation.program import trigger_trace
from tests.runs import call

from . import test_grammar as stranger
from .plant import DONE, STYLES, Plant, units_of
from .shop import NAMES, steel_part

MACHINES = Path(__file__).resolve().parents[3] / "samples" / "machines"
KINDS = ("simotion", "paths", "plcopen")


@cache
def lifted(kind: str) -> Machine:
    """The sample of a table that lifts its torch."""
    name = "plcopen" if kind == "plcopen" else "simotion"
    machine = load(str(MACHINES / f"table-{name}-z.toml"))
    assert machine.triggers is not None
    return replace(machine, triggers=replace(machine.triggers, path_objects=kind == "paths"))


def with_z(machine: Machine, **changes: object) -> Machine:
    assert machine.triggers is not None
    assert machine.triggers.z is not None
    z = replace(machine.triggers.z, **changes)
    return replace(machine, triggers=replace(machine.triggers, z=z))


@cache
def table_of(name: str, kind: str) -> TriggerTable:
    machine = lifted(kind)
    return trigger_table(plan_sheet([steel_part(name)], machine), machine, name)


@cache
def program(name: str, kind: str, style: str) -> str:
    return simotion.emit(table_of(name, kind), lifted(kind), style)


def row_of(thickness: float, machine: Machine) -> TorchRow:
    """The row to cut a sheet, worked out once more."""
    assert machine.torch is not None
    return next(r for r in machine.torch.rows if r.process == "cut" and r.up_to >= thickness)


# -- made, read back, run -------------------------------------------------------------------


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", NAMES)
def test_every_sample_makes_its_part(name: str, kind: str, style: str) -> None:
    """Lines, arcs and polynomials."""
    text, machine = program(name, kind, style), lifted(kind)
    assert verify_triggers(text, [steel_part(name)], machine, (), "a.st") == ()
    assert verify_triggers(text, [], machine, (), "a.st") == ()
    job, said = read_program(text, machine)
    assert job is not None, said
    heights = [op.height for op in job.operations if op.kind == 8]
    row = row_of(job.thickness, machine)
    once = [row.pierce_height, row.cut_height, 20.0]
    assert heights == [20.0, *once * (len(heights) // 3), 60.0 - job.thickness]


@pytest.mark.parametrize(
    ("name", "kind", "style"),
    [("shield", "simotion", "table"), ("rounded-rectangle", "paths", "chain"),
     ("four-nodes", "plcopen", "chain")],
)  # fmt: skip
def test_the_program_of_a_part_runs_in_the_time_that_is_told(
    name: str, kind: str, style: str
) -> None:
    """By an executor of its text, by the trace of `simulate`, and by the plan."""
    machine, table = lifted(kind), table_of(name, kind)
    one = Plant(units_of(program(name, kind, style), machine), machine)
    row = row_of(table.thickness, machine)
    one.sheet = (table.thickness, row.pierce_height, row.cut_height)
    one.press_start()
    one.run_while(lambda: one.value("operation") == 0)
    began = one.clock_s
    one.run_until(DONE, 900.0)
    assert one.diagnostics == []
    job, _ = read_program(program(name, kind, style), machine)
    assert job is not None
    trace = trigger_trace(job, machine)
    cycles = len(table.operations) * one.triggers.cycle_s
    assert trace.duration_s == pytest.approx(one.clock_s - began, abs=cycles)
    plan = plan_sheet([steel_part(name)], machine)
    assert trigger_time(plan, table, machine).total_s == pytest.approx(trace.duration_s)
    assert [axis.name for axis in trace.axes] == ["AxisX", "AxisY", "AxisZ"]
    # The heights of the trace while the tool works, and of the executor.
    on = [bool(state.process) for state in trace.states]
    worked = {round(float(z), 6) for z, k in zip(trace.positions[1:, 2], trace.state, strict=True)
              if on[int(k)]}  # fmt: skip
    told = {round(z, 6) for z in one.heights["cut"]}
    assert {min(worked), max(worked)} == {min(told), max(told)}


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("kind", KINDS)
def test_a_compiler_and_the_grammar_of_a_stranger_accept_it(kind: str, style: str) -> None:
    """Each name, type and bound; a table of SIMOTION in several units."""
    machine = lifted(kind)
    if kind != "plcopen":
        triggers = replace(machine.triggers, max_data=1024)  # type: ignore[type-var]
        machine = replace(machine, triggers=triggers)
    text = simotion.emit(table_of("four-nodes", kind), machine, style)
    units_of(text, machine)
    assert verify_triggers(text, [steel_part("four-nodes")], machine, (), "a.st") == ()
    if kind == "plcopen":
        assert stranger.faults(shipped("plcopen_blocks") + text) == []
        return
    units = simotion.units(text)
    assert (len(units) > 1) == (style == "table")
    for _, unit in units:
        assert stranger.faults(stranger.without_frame(unit)) == []


# -- changed in one place -------------------------------------------------------------------

#: What is changed in the shield's chain, into what, and what is said.
SAID = [
    (r"SHEET_THICKNESS : LREAL := LREAL#8\.0", "SHEET_THICKNESS : LREAL := LREAL#6.0",
     "a.st:{line}: error st-height: found a sheet of 6 mm; expected 8 mm"),
    (r"z := LREAL#6\.0, speed := LREAL#15", "z := LREAL#5.0, speed := LREAL#15",
     "st-height: found another height, 6 mm, for a line or a switch; expected 5 mm"),
    (r"z := LREAL#6\.0", "z := LREAL#5.0",
     "st-height: found the tool on at a height of 5 mm; expected pierce_height 6 mm"),
    (r"z := LREAL#3\.0", "z := LREAL#0.3",
     "st-height: found the tool on at a height of 0.3 mm; expected cut_height 3 mm"),
    (r"z := LREAL#20\.0", "z := LREAL#2.0",
     "st-height: found a way with the tool off at a height of 2 mm; expected 20 mm"),
    (r"z := LREAL#52\.0", "z := LREAL#42.0",
     "st-height: found the end at a height of 42 mm; expected 52 mm"),
    (r"z := LREAL#52\.0", "z := LREAL#62.0",
     "st-height: found AxisZ to 62 mm; expected above 0 to 52"),
    (r"z := LREAL#6\.0", "z := LREAL#-6.0",
     "st-height: found AxisZ to -6 mm; expected above 0 to 52"),
    (r"speed := LREAL#15\.0", "speed := LREAL#25.0",
     "st-speed: found 25 mm/s to lift; expected 15 mm/s"),
    (r"kind := USINT#8, x := LREAL#25\.0", "kind := USINT#8, x := LREAL#26.0",
     "st-straight: found a lift at X 26, Y 5; expected it at X 25, Y 5, where the head stands"),
    (r"kind := USINT#8", "kind := USINT#9", "st-command: found kind 9; expected 0 to 8"),
]  # fmt: skip


@pytest.mark.parametrize("kind", ["simotion", "plcopen"])
@pytest.mark.parametrize(("find", "put", "says"), SAID)
def test_what_is_said_of_a_changed_height(find: str, put: str, says: str, kind: str) -> None:
    """The first of its kind, or all of them where the change has no speed beside it."""
    text = program("shield", kind, "chain")
    every = find.startswith("z :=") and "speed" not in find
    changed = re.sub(find, put, text, count=0 if every else 1)
    assert changed != text
    said = verify_triggers(changed, [steel_part("shield")], lifted(kind), (), "a.st")
    pairs = zip(text.split("\n"), changed.split("\n"), strict=True)
    line = next(k for k, (a, b) in enumerate(pairs, 1) if a != b)
    assert any(says.format(line=line) in str(one) for one in said), said


def without(table: TriggerTable, index: int) -> TriggerTable:
    return replace(table, operations=table.operations[:index] + table.operations[index + 1 :])


def exchanged(table: TriggerTable, index: int) -> TriggerTable:
    one, other = table.operations[index : index + 2]
    rest = table.operations[index + 2 :]
    return replace(table, operations=(*table.operations[:index], other, one, *rest))


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["shield", "rounded-rectangle"])
def test_each_lift_that_is_missing_or_out_of_order_is_refused(
    name: str, kind: str, style: str
) -> None:
    """Every lift left out, exchanged with what is behind it, and made higher or lower."""
    table, machine = table_of(name, kind), lifted(kind)
    where = [k for k, op in enumerate(table.operations) if isinstance(op, LiftTorch)]
    assert len(where) >= 5
    changed = [without(table, k) for k in where]
    changed += [exchanged(table, k) for k in where[:-1]]
    changed += [exchanged(table, k - 1) for k in where if k]
    for k in where:
        for by in (-0.5, 0.5):
            own = list(table.operations)
            own[k] = replace(own[k], height=own[k].height + by)  # type: ignore[union-attr]
            changed.append(replace(table, operations=tuple(own)))
    for one in changed:
        text = simotion.emit(one, machine, style)
        said = verify_triggers(text, [steel_part(name)], machine, (), "a.st")
        assert {d.code for d in said} & {"st-height", "st-tool"}, one.operations
        assert verify_triggers(text, [], machine, (), "a.st"), "by the program alone"


def test_a_torch_that_stays_on_as_it_rises_is_refused() -> None:
    table, machine = table_of("shield", "simotion"), lifted("simotion")
    off = next(
        k for k, op in enumerate(table.operations) if isinstance(op, SwitchTool) and not op.on
    )
    text = simotion.emit(exchanged(table, off), machine, "chain")
    said = verify_triggers(text, [steel_part("shield")], machine, (), "a.st")
    assert any("found a lift to 20 mm with the tool on; expected the tool off" in str(d)
               for d in said)  # fmt: skip


def test_a_lift_is_no_operation_of_a_table_without() -> None:
    text = program("shield", "simotion", "chain")
    machine = load("table-simotion")
    assert {d.code for d in verify_triggers(text, [], machine, (), "a.st")} == {"st-runtime"}
    plain = simotion.emit(replace(table_of("shield", "simotion"), operations=(
        *table_of("shield", "simotion").operations[1:2], LiftTorch(1.0, 15.0),
    )), machine, "chain")  # fmt: skip
    said = [str(d) for d in verify_triggers(plain, [], machine, (), "a.st")]
    assert any("found kind 8; expected 0 to 7" in one for one in said)


# -- the machine's file, and the plan -------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "key", "expected"),
    [({"clearance": 60.0}, "triggers.z.clearance", "less than home_height, 60"),
     ({"clearance": 5.0}, "torch.rows.pierce_height", "at most triggers.z.clearance, 5"),
     ({"arrival_window": 0.005}, "triggers.z.arrival_window",
      "a count of the encoder or more, 0.0100 mm"),
     ({"axis": "AxisX"}, "triggers", "each input, output and axis once"),
     ({"axis": "Axis Z"}, "triggers.axes", "letters, digits and single _, a letter first"),
     ({"limits": ("%I1.0", "%I0.0")}, "triggers", "each input, output and axis once"),
     ({"limits": ("%I1.0", "%I1")}, "triggers.limits",
      "an address of an input such as %I0.0 or the name of a variable"),
     ({"home_height": 900.0}, "triggers.max_homing_s",
      "or more for 1700 mm at homing_mm_s and the slow approach")],
)  # fmt: skip
def test_keys_of_the_lift_that_cannot_be(
    changes: dict[str, object], key: str, expected: str
) -> None:
    machine = with_z(lifted("simotion"), **changes)
    faults = [(fault[0], fault[1]) for fault in table_faults(machine)]
    assert any(k == key and e.endswith(expected) for k, e in faults), faults


def with_row(**changes: object) -> Machine:
    machine = lifted("simotion")
    assert machine.torch is not None
    rows = tuple(replace(row, **changes) for row in machine.torch.rows)
    return replace(machine, torch=replace(machine.torch, rows=rows))


@pytest.mark.parametrize("key", ["pierce_height", "cut_height"])
def test_a_height_that_is_not_known_is_refused_by_name(key: str) -> None:
    with pytest.raises(PlanError) as error:
        plan_sheet([steel_part("shield")], with_row(**{key: 0.0}))
    said = str(error.value)
    assert f"plan-torch-height: found no {key} to cut up to 12 mm; expected one in the row" in said
    found = verify_triggers(
        program("shield", "simotion", "chain"), [steel_part("shield")], with_row(**{key: 0.0}), (),
        "a.st",
    )  # fmt: skip
    assert "st-height" in {d.code for d in found}, "the checker has no height either"


def test_a_sheet_that_the_torch_does_not_clear_is_refused() -> None:
    machine = with_z(lifted("simotion"), clearance=55.0)
    with pytest.raises(PlanError, match="plan-torch-headroom: found a sheet of 8 mm; expected at "
                                        "most 5 mm"):  # fmt: skip
        plan_sheet([steel_part("shield")], machine)


@pytest.mark.parametrize("name", ["simotion", "plcopen"])
def test_the_height_is_a_column_beside_the_path(name: str, tmp_path: Path) -> None:
    """Of `simulate`, and of the playback of a report; an encoder is read of X and Y alone."""
    machine = str(MACHINES / f"table-{name}-z.toml")
    sample = str(MACHINES.parent / "json" / "shield.json")
    made, trace, page = (str(tmp_path / f"shield.{end}") for end in ("st", "csv", "html"))
    for words in (
        ["post", sample, "--machine", machine, "-o", made],
        ["simulate", made, "--machine", machine, "-o", trace, "--encoder", "machine"],
        ["report", made, "--machine", machine, "-o", page],
    ):
        call(*words, status=0)
    head, *rows = Path(trace).read_text(encoding="utf-8").splitlines()
    assert head == "time_s,AxisX,AxisY,AxisZ,AxisX read,AxisY read,process,line"
    on = {row.split(",")[3] for row in rows if row.split(",")[6] == "cut"}
    assert {"14.000", "11.000"} <= on, "8 mm of sheet, and 6 and 3 over it"
    assert '"name":"AxisZ"' in Path(page).read_text(encoding="utf-8").replace('": "', '":"')
