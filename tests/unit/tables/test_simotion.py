"""Trigger programs: read back, run to their ends, and every kind of mutant caught."""

import random
import re
from itertools import pairwise
from math import cos, dist, pi, sin

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.st import Execution, verify_triggers
from beamcam.controllers.simotion import trial as trials
from beamcam.controllers.simotion.job import read_program
from beamcam.controllers.simotion.trial import trial
from beamcam.emitters import simotion
from beamcam.geometry.curves import Line
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import runtime_of
from beamcam.machine.torch_faults import table_faults
from beamcam.model.program import SwitchTool, Travel
from beamcam.motion.triggers import trigger_table
from beamcam.planning.sheet import plan_sheet
from tests.conftest import sampled
from tests.distances import distances
from tests.unit.sheets.parts import circle, contour, drawing

from .plant import DONE, Plant, units_of
from .shop import NAMES, program, steel_part, table_machine, triggers

STYLES = ("chain", "table")


def codes(text: str, name: str = "shield", machine: Machine | None = None) -> set[str]:
    machine = machine or table_machine()
    return {d.code for d in verify_triggers(text, [steel_part(name)], machine, (), "a.st")}


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("path_objects", [False, True])
@pytest.mark.parametrize("name", sampled(NAMES, 2))
def test_every_sample_makes_its_part(name: str, path_objects: bool, style: str) -> None:
    machine = table_machine(path_objects=path_objects)
    text = program(name, style, machine)
    assert verify_triggers(text, [steel_part(name)], machine, (), "a.st") == ()
    assert verify_triggers(text, [], machine, (), "a.st") == ()
    assert ("_movePathCircular(" in text) is path_objects
    assert text.isascii()
    assert text == program(name, style, machine)


@pytest.mark.parametrize(
    ("name", "style", "path_objects"),
    [("shield-small", "chain", False), ("rounded-rectangle", "table", False),
     ("rounded-rectangle", "chain", True)],
)  # fmt: skip
def test_what_is_read_is_what_an_executor_of_the_text_does(
    name: str, style: str, path_objects: bool
) -> None:
    machine = table_machine(path_objects=path_objects, max_data=1024)
    text = program(name, style, machine)
    job, said = read_program(text, machine)
    assert said == []
    assert job is not None
    assert machine.torch is not None
    execution = Execution(job, machine, machine.torch.rows, "a.st")
    execution.follow()
    assert execution.diagnostics == []
    plant = Plant(units_of(text, machine), machine)
    plant.press_start()
    plant.run_until(DONE, 600.0)
    assert plant.diagnostics == []
    for process in {stroke.process for stroke in execution.strokes}:
        lines = [s.points for s in execution.strokes if s.process == process]
        way = shapely.MultiLineString(lines)
        ran = shapely.LineString(plant.points[process])
        assert max(distances(plant.points[process], way)) <= 0.001
        assert max(distances([p for line in lines for p in line], ran)) <= 0.005


def test_set_points_are_split_over_units_by_their_size() -> None:
    machine = table_machine(max_data=1024)
    text = program("rounded-rectangle", "table", machine)
    units = simotion.split_units(text)
    count = len(triggers("rounded-rectangle").operations)
    assert len(units) == 1 + -(-count // (1024 // simotion.POINT_BYTES))
    assert "".join(unit for _, unit in units) == text
    assert codes(text, "rounded-rectangle", machine) == set()


def test_a_long_path_is_a_table_and_a_chain_of_it_is_refused() -> None:
    machine = table_machine(max_chain=50)
    table = triggers("rounded-rectangle", machine)
    assert "pointX_1" in simotion.emit(table, machine)
    with pytest.raises(simotion.ChainError, match="100 operations; expected at most 50"):
        simotion.emit(table, machine, "chain")


def test_an_axis_that_does_not_move_is_not_commanded() -> None:
    machine = table_machine()
    plant = Plant(units_of(program("rounded-rectangle", "chain"), machine), machine)
    sent: list[str] = []
    real = plant.command

    def count(name: str, values: dict[str, object], line: int) -> int:
        if name == "_POS" and plant.value("workState") == 2:
            sent.append(values["AXIS"].name)  # type: ignore[attr-defined]
        return real(name, values, line)

    plant.command = count  # type: ignore[method-assign]
    plant.press_start()
    plant.run_until(DONE, 600.0)
    here, expected = (0.0, 0.0), {"AxisX": 0, "AxisY": 0}
    for op in triggers("rounded-rectangle").operations:
        if not isinstance(op, SwitchTool):
            expected["AxisX"] += op.x != here[0]
            expected["AxisY"] += op.y != here[1]
            here = op.x, op.y
    assert {axis: sent.count(axis) for axis in expected} == expected


def test_names_of_units() -> None:
    assert simotion.unit_name("Träger 12/a") == "unit_Tr_ger_12_a"
    assert simotion.unit_name("***") == "unit_job"
    left, right = (simotion.unit_name(f"bracket of the {w} gallery") for w in ("L", "R"))
    assert left != right
    assert len(left) == len("unit_") + simotion.MAX_NAME
    assert simotion.unit_name(left.removeprefix("unit_")) == left


def test_a_thousand_set_points_are_read_back() -> None:
    turns = [2 * pi * k / 1000 for k in range(1000)]
    gear = [((200 + (k % 2) * 5) * cos(t) + 300, (200 + (k % 2) * 5) * sin(t) + 300)
            for k, t in enumerate(turns)]  # fmt: skip
    outer = contour(tuple(Line(a, b) for a, b in pairwise([*gear, gear[0]])))
    plate = drawing(outer, contour(circle(300, 300, 60)), contour(circle(300, 420, 20)),
                    thickness=3.0)  # fmt: skip
    machine = table_machine()
    table = trigger_table(plan_sheet([plate], machine), machine, "gear")
    assert len(table.operations) > 1000
    text = simotion.emit(table, machine, "table")
    assert verify_triggers(text, [plate], machine) == ()


# -- the fixed part -------------------------------------------------------------------------


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("path_objects", [False, True])
def test_the_fixed_part_is_the_same_for_every_job(style: str, path_objects: bool) -> None:
    machine = table_machine(path_objects=path_objects)
    fixed = runtime_of(machine, style)
    for name in NAMES:
        text = program(name, style, machine)
        for piece in (fixed.head, fixed.middle, fixed.end):
            assert text.count(piece) == 1


@given(data=st.data())
def test_a_changed_byte_of_the_fixed_part_is_refused_by_name(data: st.DataObject) -> None:
    style = data.draw(st.sampled_from(STYLES))
    text = program("shield", style)
    fixed = runtime_of(table_machine(), style)
    piece = data.draw(st.sampled_from((fixed.head, fixed.middle, fixed.end)))
    at = text.index(piece) + data.draw(st.integers(0, len(piece) - 2))
    other = data.draw(
        st.characters(min_codepoint=9, max_codepoint=126).filter(lambda c: c != text[at])
    )
    how = data.draw(st.sampled_from(("changed", "left out", "put in")))
    changed = (
        text[:at]
        + {"changed": other, "left out": "", "put in": other + text[at]}[how]
        + text[at + 1 :]
    )
    if changed.replace("\r\n", "\n") == text or changed == text:
        return
    (said,) = verify_triggers(changed, [steel_part("shield")], table_machine(), (), "a.st")
    assert said.code == "st-runtime"


def test_a_changed_line_of_the_fixed_part_is_told() -> None:
    text = program("shield", "chain").replace("IF fault <> INT#0", "IF fault <> INT#1")
    text = text.replace("(fault <> INT#0)", "(fault <> INT#9)")
    line = text[: text.index("(fault <> INT#9)")].count("\n") + 1
    (said,) = verify_triggers(text, [steel_part("shield")], table_machine(), (), "a.st")
    assert str(said).startswith(
        f"a.st:{line}: error st-runtime: found 'IF (fault <> INT#9) AND (workState <> INT#4) THEN' "
        "in the fixed part of the program; expected 'IF (fault <> INT#0) AND"
    )


def test_lines_may_end_as_on_windows() -> None:
    assert codes(program("shield", "table").replace("\n", "\r\n")) == set()


def test_a_program_of_another_machine_is_refused() -> None:
    assert codes(program("shield", "chain", table_machine(back_off=20.0))) == {"st-runtime"}


# -- the job --------------------------------------------------------------------------------

CHAIN_MUTANTS = [
    # what is changed, into what, and the code that has to be said
    (r"triggerActive\[4\] AND NOT triggerActive\[5\]", "triggerActive[3] AND NOT triggerActive[5]",
     "st-trigger"),
    (r"triggerActive\[4\] AND NOT triggerActive\[5\]", "triggerActive[4] AND NOT triggerActive[6]",
     "st-trigger"),
    (r"triggerActive\[5\] := TRUE", "triggerActive[6] := TRUE", "st-trigger"),
    (r"\n +triggerActive\[5\] := TRUE;", "", "st-syntax"),
    (r" AND NOT triggerActive\[5\]", "", "st-syntax"),
    (r"operationArrived AND triggerActive\[4\]", "triggerActive[4]", "st-syntax"),
    (r"x := LREAL#35.0, y := LREAL#35.0", "x := LREAL#-35.0, y := LREAL#35.0", "st-command"),
    (r"x := LREAL#35.0, y := LREAL#35.0", "x := LREAL#35.0, y := LREAL#34.9", "verify-sheet"),
    (r"x := LREAL#35.0, y := LREAL#35.0", "x := LREAL#35.0, y := LREAL#15.0", "st-command"),
    (r"x := LREAL#35.0, y := LREAL#35.0", "x := LREAL#35, y := LREAL#35.0", "st-syntax"),
    (r"speed := LREAL#2.0", "speed := LREAL#9.0", "st-speed"),
    (r"speed := LREAL#2.0", "speed := LREAL#1.0", "st-speed"),
    (r"speed := LREAL#2.0", "speed := LREAL#1.99999", "st-speed"),
    (r"speed := LREAL#20.0", "speed := LREAL#19.999", "st-speed"),
    (r"speed := LREAL#2.0", "speed := LREAL#0.0", "st-speed"),
    (r"speed := LREAL#20.0", "speed := LREAL#30.0", "st-speed"),
    (r"ARRAY \[0..11\] OF BOOL", "ARRAY [0..10] OF BOOL", "st-bounds"),
    (r"ARRAY \[0..11\] OF BOOL", "ARRAY [0..12] OF BOOL", "st-bounds"),
    (r"LAST_OPERATION : DINT := DINT#11", "LAST_OPERATION : DINT := DINT#10", "st-bounds"),
    (r"(?s)DINT#11(.*)\.\.11\]", r"DINT#10\1..10]", "st-trigger"),
    (r"PIERCE_CUT : TIME := T#800ms", "PIERCE_CUT : TIME := T#80ms", "st-tool"),
    (r"kind := USINT#1, ", "kind := USINT#3, ", "st-tool"),
    (r"kind := USINT#1, ", "kind := USINT#2, ", "st-tool"),
    (r"kind := USINT#1, ", "kind := USINT#9, ", "st-command"),
    (r"kind := USINT#1, ", "kind := USINT#7, ", "st-command"),
    (r"kind := USINT#1, x := LREAL#25.0", "kind := USINT#1, x := LREAL#26.0", "st-straight"),
    (r"kind := USINT#2, ", "kind := USINT#4, ", "st-tool"),
    (r"END_IF;\n( +\(\* 5: line)", r"END_IF;\n        cutOn := TRUE;\n\1", "st-syntax"),
    (r"    VAR_GLOBAL CONSTANT\n( +LAST)", r"    USES unit_x;\n    VAR_GLOBAL CONSTANT\n\1",
     "st-name"),
    (r"END_IMPLEMENTATION\n", "END_IMPLEMENTATION\n(* more *)\n", "st-syntax"),
    (r"\(\* ===== UNIT unit_shield ===== \*\)\n", "", "st-syntax"),
    (r"\(\* ----- Runtime ----- \*\)", "", "st-runtime"),
]  # fmt: skip


@pytest.mark.parametrize(("find", "put", "code"), sampled(CHAIN_MUTANTS, 2))
def test_a_mutant_of_a_chain_is_caught(find: str, put: str, code: str) -> None:
    text = program("shield", "chain")
    changed = re.sub(find, put, text, count=1)
    assert changed != text
    found = codes(changed)
    assert any(c.startswith(code) for c in found), found


@pytest.mark.parametrize(("diameter", "feed"), [(3.0, 7.3), (17.0, 39.7)])
def test_speeds_are_those_of_the_table_and_of_the_cycle(diameter: float, feed: float) -> None:
    """Curves too fast for the cycle time are slowed by their shortest chord, and by no more."""
    machine = table_machine()
    rows = tuple(replace(row, feed_mm_min=60 * feed) for row in machine.torch.rows)  # type: ignore[union-attr]
    machine = replace(machine, torch=replace(machine.torch, rows=rows))  # type: ignore[type-var]
    hole = drawing(contour(circle(50, 50, diameter)), thickness=2.0)
    table = trigger_table(plan_sheet((hole,), machine), machine, "JOB")
    assert 0.0 < min(op.speed_mm_s for op in table.operations if isinstance(op, Travel)) < feed
    for share, said in ((1.0, set()), (0.9999, {"st-speed"})):
        operations = tuple(
            replace(op, speed_mm_s=share * op.speed_mm_s) if isinstance(op, Travel) else op
            for op in table.operations
        )
        text = simotion.emit(replace(table, operations=operations), machine, "table")
        assert {d.code for d in verify_triggers(text, [hole], machine, (), "a.st")} == said


TABLE_MUTANTS = [
    (r"pointX_1\[row\]", "pointY_1[row]", "st-syntax"),
    (r"pointX_1\[row\]", "pointX_1[row - DINT#1]", "st-syntax"),
    (r"\[1..11\] OF LREAL", "[1..10] OF LREAL", "st-syntax"),
    (r"\(row <= DINT#11\)", "(row <= DINT#10)", "st-syntax"),
    (r"\(row >= DINT#1\)", "(row >= DINT#2)", "st-bounds"),
    (r"LAST_OPERATION : DINT := DINT#11", "LAST_OPERATION : DINT := DINT#10", "st-trigger"),
    (r"LREAL#25.0, LREAL#35.0", "LREAL#25.0 LREAL#35.0", "st-syntax"),
    (r"LREAL#25.0, LREAL#35.0", "LREAL#25.0, LREAL#36.0", "verify-sheet"),
    (r"LREAL#25.0, LREAL#35.0, ", "LREAL#25.0, ", "st-array"),
    (r"USINT#1, ", "USINT#0, ", ""),
    (r"USES unit_shield_1", "USES unit_shield_2", "st-name"),
    (r"    USES unit_shield_1;\n", "", "st-syntax"),
    (r"UNIT unit_shield_1", "UNIT unit_shield_7", "st-name"),
]  # fmt: skip


@pytest.mark.parametrize(("find", "put", "code"), TABLE_MUTANTS)
def test_a_mutant_of_a_table_is_caught(find: str, put: str, code: str) -> None:
    text = program("shield", "table")
    changed = re.sub(find, put, text, count=1)
    assert changed != text
    found = codes(changed)
    assert any(c.startswith(code) for c in found), found


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", sampled(["shield", "rounded-rectangle"], 2))
def test_each_digit_of_a_job_counts(name: str, style: str) -> None:
    """A digit that is changed is another part, another speed, or refused by the text's form."""
    text = program(name, style)
    fixed = runtime_of(table_machine(), style)
    rng = random.Random(name + style)
    spans = [(text.index(fixed.head) + len(fixed.head), text.index(fixed.middle)),
             (text.index(fixed.middle) + len(fixed.middle), text.index(fixed.end)),
             (text.index(fixed.end) + len(fixed.end), len(text))]  # fmt: skip
    digits = [k for a, b in spans for k in range(a, b) if text[k].isdigit() and text[k - 1] != "."]
    for at in rng.sample(digits, 8):
        line = text[text.rfind("\n", 0, at) + 1 : text.find("\n", at)]
        other = "5" if text[at] != "5" else "6"
        changed = text[:at] + other + text[at + 1 :]
        small = re.search(r"\.\d*$", text[:at].split("#")[-1])  # behind the point
        harmless = line.strip().startswith("(*") or "PIERCE" in line or small
        assert harmless or codes(changed, name), line


def test_an_arc_that_is_too_long_for_its_chords_is_refused() -> None:
    machine = table_machine(path_objects=True)
    text = program("rounded-rectangle", "chain", machine)
    found = re.sub(r"middleX := LREAL#[\d.]+, middleY := LREAL#[\d.]+(?=\);\n        END_IF;\n)",
                   "middleX := LREAL#1.0, middleY := LREAL#1.0", text)  # fmt: skip
    assert codes(found, "rounded-rectangle", machine) & {"st-straight", "verify-sheet-extra"}
    line = "found a circle through points in a line (alarm 50002); expected an arc"
    arc = re.search(r"kind := USINT#7, x := (LREAL#[\d.]+), y := (LREAL#[\d.]+)", text)
    assert arc is not None
    flat = text.replace(text[arc.start() :].split("middleX := ")[1].split(");")[0],
                        f"{arc[1]}, middleY := {arc[2]}", 1)  # fmt: skip
    said = verify_triggers(flat, [steel_part("rounded-rectangle")], machine, (), "a.st")
    assert any(line in d.message for d in said)


# -- machines -------------------------------------------------------------------------------


def renamed(**names: str) -> Machine:
    return table_machine(
        path_objects=True, names={k.replace("__", "."): v for k, v in names.items()}
    )


@pytest.mark.parametrize("style", STYLES)
def test_names_of_the_library_are_written_and_read_as_the_machine_calls_them(style: str) -> None:
    machine = renamed(pathObject="pathObjectType", X_Y="XY", _homing="_home", control="servo",
                      basicMotion__position="positioningState.actualPosition")  # fmt: skip
    text = program("shield", style, machine)
    for name in ("pathObjectType := Path", "pathPlane := XY", "_home(", "axis.servo = ACTIVE",
                 "axis.positioningState.actualPosition - axis."):  # fmt: skip
        assert name in text
    assert not re.search(r"\b(pathObject|X_Y|_homing|control|basicMotion)\b", text)
    assert verify_triggers(text, [steel_part("shield")], machine, (), "a.st") == ()
    assert codes(text, machine=table_machine(path_objects=True)) == {"st-runtime"}


def test_only_names_that_are_not_confirmed_may_be_called_otherwise() -> None:
    faults = list(table_faults(renamed(_pos="_position", X_Y="X Y")))
    assert [(key, found) for key, _, found in faults] == [
        ("triggers.names", "_pos"), ("triggers.names.X_Y", "X Y"),
    ]  # fmt: skip


def test_inputs_and_outputs_may_be_variables() -> None:
    machine = table_machine(
        limits=("opXLow", "%I0.1", "opYLow", "opYHigh"), start="opStart", acknowledge="opClear",
        outputs={"cut": "torchOn", "mark": "%Q62.1"}, fault_lamp="lamp", uses=("io_unit", "hmi"),
        stop="opStop", normally_closed=("opXLow", "%I0.1", "opStop"),
    )  # fmt: skip
    assert list(table_faults(machine)) == []
    assert trial(machine) == ()
    for style in STYLES:
        text = program("shield", style, machine)
        assert codes(text, machine=machine) == set()
        assert "        limitXLow := NOT opXLow;\n" in text
        assert "        limitXHighWire AT %I0.1 : BOOL;\n" in text
        assert "        limitXHigh := NOT limitXHighWire;\n" in text
        assert "        limitYLow := opYLow;\n" in text
        assert "        stopButton := NOT opStop;\n" in text
        assert text.count("        torchOn := cutOn;\n") == 3  # of the start, of work, of faults
        assert "        lamp := workFault;\n" in text
        assert re.search(r"    USES io_unit, hmi(, unit_shield_1)?;\n", text)
        assert codes(text.replace("USES io_unit, hmi", "USES io_unit"), machine=machine) == {
            "st-name"
        }
    plain = table_machine(acknowledge="", fault_lamp="", stop="", normally_closed=())
    assert trial(plain) == ()
    text = program("shield", "chain", plain)
    for line in ("acknowledgeButton : BOOL := FALSE;", "stopButton : BOOL := FALSE;",
                 "limitXLow AT %I0.0 : BOOL;"):  # fmt: skip
        assert f"        {line}\n" in text
    assert "Wire" not in text


def test_a_program_with_inputs_that_close_is_refused_where_they_open() -> None:
    plain = table_machine(normally_closed=())
    assert codes(program("shield", "chain", plain), machine=plain) == set()
    assert codes(program("shield", "chain", plain)) == {"st-runtime"}
    assert codes(program("shield", "chain", table_machine(stop="", normally_closed=()))) == {
        "st-runtime"
    }


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"axes": ("answer", "AxisY")}, "found the name answer twice; expected it once"),
        ({"path_objects": True, "path_object": "way"}, "found the name way twice; expected it "
                                                       "once"),
        ({"axes": ("AxisX", "axisx")}, "one axis"),
        ({"max_homing_s": 0.2}, "found fault 3; expected work to its end"),
    ],
)  # fmt: skip
def test_a_machine_that_the_fixed_part_cannot_run_is_told(
    changes: dict[str, object], said: str
) -> None:
    machine = table_machine(**changes)
    if said == "one axis":
        assert trial(machine)
    else:
        assert said in [d.message for d in trial(machine)]


def test_path_objects_name_the_package_that_they_need() -> None:
    assert "    USEPACKAGE CAM;\n" in program("shield", "chain")
    machine = table_machine(path_objects=True)
    assert "    USEPACKAGE PATH;\n" in program("shield", "chain", machine)
    assert list(
        table_faults(replace(machine, triggers=replace(machine.triggers, package="CAM")))
    ) == [("triggers.package", "PATH or CAM_EXT, which have path objects")]


def test_the_head_names_the_tasks_and_the_cycle() -> None:
    head = program("shield", "chain").partition("INTERFACE")[0]
    said = " ".join(head.split())
    for words in (
        "StartupTask CutStart",
        "TimerInterruptTask CutPart every 25 ms, equidistant",
        "TechnologicalFaultTask CutFault",
        "BackgroundTask, MotionTask: nothing",
    ):
        assert words in said
    for name in ("CutStart", "CutPart", "CutFault"):
        assert f"    PROGRAM {name};\n" in program("shield", "chain")


def test_an_arc_of_a_plan_is_no_longer_than_the_runtime_allows() -> None:
    machine = table_machine(path_objects=True)
    job, _ = read_program(program("rounded-rectangle", "chain", machine), machine)
    assert job is not None
    arcs = [(a, b) for a, b in pairwise(job.operations) if b.kind == 7]
    assert arcs
    for a, b in arcs:
        assert b.via is not None
        chords = dist((a.x, a.y), b.via) + dist(b.via, (b.x, b.y))
        assert chords > 0


def test_a_trial_that_does_not_end_is_a_fault_of_the_machine(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(trials, "MOST_CYCLES", 50)
    said = [d.message for d in trial(table_machine())]
    assert said == [
        "found no end of a line of 3.4 mm after 1.25 s, 50 cycles; expected fewer, by back_off, "
        "homing_mm_s and cycle_s"
    ]
