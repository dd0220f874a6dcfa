"""Trigger programs: run to their ends, and every kind of mutant caught."""

import re

import pytest

from beamcam.emitters import simotion, simotion_units
from beamcam.machine.faults import table_faults
from beamcam.machine.machine import Machine
from beamcam.model.triggers import Switch
from beamcam.verify.st import check_text, run, verify_triggers

from .shop import NAMES, part, program, table_machine, triggers


def codes(text: str, name: str = "shield") -> set[str]:
    return {d.code for d in verify_triggers(text, [part(name)], table_machine(), (), "a.st")}


@pytest.mark.parametrize("style", ["chain", "table"])
@pytest.mark.parametrize("name", NAMES)
def test_every_sample_runs_to_its_end_and_makes_its_part(name: str, style: str) -> None:
    text = program(name, style)
    assert verify_triggers(text, [part(name)], table_machine(), (), "a.st") == ()


def test_a_circle_by_other_rules_is_refused() -> None:
    machine = table_machine(path_objects=True)
    text = program("rounded-rectangle", "chain", machine)
    for find, put in (("ijkMode := ABSOLUTE", "ijkMode := RELATIVE"), ("X_Y", "Y_Z")):
        found = verify_triggers(
            text.replace(find, put), [part("rounded-rectangle")], machine, (), "a.st"
        )
        assert "st-command" in {d.code for d in found}


@pytest.mark.parametrize("style", ["chain", "table"])
@pytest.mark.parametrize("name", ["rounded-rectangle", "shield"])
def test_a_path_object_runs_lines_and_circles(name: str, style: str) -> None:
    machine = table_machine(path_objects=True)
    text = program(name, style, machine)
    assert "_movePathCircular" in text
    assert "FB_Line;" not in text
    assert verify_triggers(text, [part(name)], machine, (), "a.st") == ()


def test_set_points_are_split_over_units_by_their_size() -> None:
    machine = table_machine(greatest_data=1024)
    text = program("rounded-rectangle", "table", machine)
    units = simotion_units.split_units(text)
    count = len(triggers("rounded-rectangle").operations)
    assert len(units) == 1 + -(-count // (1024 // simotion.POINT_BYTES))
    assert "".join(unit for _, unit in units) == text
    assert verify_triggers(text, [part("rounded-rectangle")], machine, (), "a.st") == ()


def test_a_long_path_is_a_table_and_a_chain_of_it_is_refused() -> None:
    machine = table_machine(greatest_chain=50)
    table = triggers("rounded-rectangle", machine)
    assert "FB_Fetch" in simotion.emit(table, machine)
    with pytest.raises(simotion.ChainError, match="100 operations; expected at most 50"):
        simotion.emit(table, machine, "chain")


def test_an_axis_that_does_not_move_is_not_commanded() -> None:
    from beamcam.verify.st.cell import Cell

    machine = table_machine()
    units, said = check_text(program("rounded-rectangle", "chain"), machine)
    assert not said
    cell = Cell(units, machine, "a.st")
    sent: list[str] = []
    real = cell.command

    def count(name: str, values: dict[str, object], line: int) -> int:
        if name == "_POS" and cell.working:
            sent.append(values["AXIS"].name)  # type: ignore[attr-defined]
        return real(name, values, line)

    cell.command = count  # type: ignore[method-assign]
    while not cell.interpreter.globals["WORKDONE"]:
        cell.cycle()
    here, expected = (0.0, 0.0), {"AxisX": 0, "AxisY": 0}
    for op in triggers("rounded-rectangle").operations:
        if not isinstance(op, Switch):
            expected["AxisX"] += op.x != here[0]
            expected["AxisY"] += op.y != here[1]
            here = op.x, op.y
    assert {axis: sent.count(axis) for axis in expected} == expected


@pytest.mark.parametrize("name", NAMES)
def test_every_trigger_fires_once(name: str) -> None:
    from beamcam.verify.st.cell import Cell

    units, _ = check_text(program(name, "chain"), table_machine())
    cell = Cell(units, table_machine(), "a.st")
    fired = [0] * (len(triggers(name).operations) + 1)
    before = [False] * len(fired)
    while not cell.interpreter.globals["WORKDONE"]:
        cell.cycle()
        now = list(cell.interpreter.globals["TRIGGERACTIVE"])
        fired = [n + (b and not a) for n, a, b in zip(fired, before, now, strict=True)]
        before = now
    assert fired == [1] * len(fired)


def test_the_same_text_for_the_same_part_in_ascii() -> None:
    assert program("shield", "chain") == program("shield", "chain")
    assert program("shield", "table").isascii()
    assert simotion_units.unit_name("Träger 12/a") == "unit_Tr_ger_12_a"
    assert simotion_units.unit_name("***") == "unit_job"
    left, right = (simotion_units.unit_name(f"bracket of the {w} gallery") for w in ("L", "R"))
    assert left != right
    assert len(left) == len("unit_") + simotion_units.GREATEST_NAME
    assert simotion_units.unit_name(left.removeprefix("unit_")) == left


MUTANTS = [
    # what is changed, into what, and the code that has to be said
    (r"triggerActive\[4\] AND NOT triggerActive\[5\]", "triggerActive[3] AND NOT triggerActive[5]",
     "st-trigger"),
    (r"triggerActive\[4\] AND NOT triggerActive\[5\]", "triggerActive[4] AND NOT triggerActive[6]",
     "st-trigger"),
    (r"triggerActive\[5\] := TRUE", "triggerActive[6] := TRUE", "st-trigger"),
    (r"\n +triggerActive\[5\] := TRUE;", "", "st-trigger"),
    (r" AND NOT triggerActive\[5\]", "", "st-trigger"),
    (r"endX := LREAL#35.0, endY := LREAL#35.0", "endX := LREAL#-35.0, endY := LREAL#35.0",
     "st-command"),
    (r"wayX := endX - startX", "wayX := endX + startX", "st-"),
    (r"ABS\(wayX\) / length", "-ABS(wayX) / length", "st-command"),
    (r"velocity := scaled.velocityX", "velocity := scaled.velocityY", "st-straight"),
    (r"speed := LREAL#2.0", "speed := LREAL#9.0", "st-speed"),
    (r"ARRAY \[0..11\] OF BOOL", "ARRAY [0..10] OF BOOL", "st-bounds"),
    (r"ARRAY \[0..11\] OF BOOL", "ARRAY [0..12] OF BOOL", "st-trigger"),
    (r"startY := LREAL#5.0", "startV := LREAL#5.0", "st-parameter"),
    (r"velocityProfile := TRAPEZOIDAL, mergeMode", "mergeMode", "st-parameter"),
    (r"negativeAccelType := DIRECT", "negativAccelType := DIRECT", "st-parameter"),
    (r"scaled.velocityX,", "scaled.velocityZ,", "st-name"),
    (r"workState := INT#3", "workstat := INT#3", "st-name"),
    (r"workState := INT#3", "workState := LREAL#3.0", "st-type"),
    (r"position := endX", "position := DINT#5", "st-type"),
    (r"answer := _pos", "scaled := _pos", "st-type"),
    (r"direction := POSITIVE", "direction := ABSOLUTE", "st-type"),
    (r"mergeMode := IMMEDIATELY,\n +nextCommand := IMMEDIATELY\);\n +IF answer",
     "mergeMode := IMMEDIATELY, nextCommand := WHEN_MOTION_DONE);\nIF answer", "st-command"),
    (r"axis := AxisY, direction", "axis := AxisX, direction", "st-trigger"),
    (r"endX := LREAL#35.0, endY := LREAL#35.0", "endX := LREAL#35.0, endY := LREAL#34.9",
     "st-run"),
    (r"cutOn := TRUE;", "cutOn := FALSE;", "verify-sheet-missing"),
    (r"PIERCE_CUT : TIME := T#800ms", "PIERCE_CUT : TIME := T#80ms", "st-tool"),
    (r"homePosition := LREAL#0.0, nextCommand := IMMEDIATELY\);\n +phase := INT#6",
     "homePosition := LREAL#7.0, nextCommand := IMMEDIATELY);\n phase := INT#6", "st-homing"),
    (r" OR limitYHigh", "", "st-homing"),
    (r"homeY\(axis := AxisY", "homeY(axis := AxisX", "st-"),
    (r"END_IF;\n +END_FUNCTION_BLOCK", "END_FUNCTION_BLOCK", "st-syntax"),
    (r"workState : INT := INT#0", "workState : INT := INT#99999", "st-syntax"),
    (r"answer : DINT;", "answer : DINT; answer : DINT;", "st-declaration"),
    (r"length : LREAL;", "dt : LREAL;", "st-declaration"),
    (r"ABS\(AxisX.basicMotion.position - LREAL#35.0\) <= IN_POSITION",
     "AxisX.basicMotion.position = LREAL#35.0", "st-type"),
]  # fmt: skip


@pytest.mark.parametrize(("find", "put", "code"), MUTANTS)
def test_a_mutant_is_caught(find: str, put: str, code: str) -> None:
    text = program("shield", "chain")
    changed = re.sub(find, lambda _: put, text, count=1)
    assert changed != text
    found = codes(changed)
    assert any(c.startswith(code) for c in found), found


TABLE_MUTANTS = [
    (r"pointX_1\[row\]", "pointY_1[row]", ""),
    (r"row := index - DINT#0", "row := index - DINT#1", "st-bounds"),
    (r"row := index - DINT#0", "row := index", "same"),
    (r"ARRAY \[1..11\] OF LREAL", "ARRAY [1..10] OF LREAL", "st-array"),
    (r"index <= DINT#11", "index <= DINT#10", ""),
    (r"LAST_OPERATION : DINT := DINT#11", "LAST_OPERATION : DINT := DINT#10", ""),
    (r"operation := operation \+ DINT#1", "operation := operation + DINT#2", ""),
    (r"triggerActive := operationArrived", "triggerActive := TRUE", "st-trigger"),
    (r"USES unit_shield_1", "USES unit_shield_2", "st-name"),
]


@pytest.mark.parametrize(("find", "put", "code"), TABLE_MUTANTS)
def test_a_mutant_of_a_table_is_caught(find: str, put: str, code: str) -> None:
    text = program("shield", "table")
    changed = re.sub(find, lambda _: put, text, count=1)
    assert changed != text
    found = codes(changed)
    if code == "same":  # an index without its offset of 0 is the same program
        assert not found
    else:
        assert any(c.startswith(code) for c in found), found


def test_faults_are_told_with_their_lines() -> None:
    text = program("shield", "chain").replace("wait.Q", "wait.P")
    line = next(k for k, row in enumerate(text.splitlines(), 1) if "wait.P" in row)
    (said,) = check_text(text, table_machine(), "a.st")[1]
    assert str(said).startswith(f"a.st:{line}: error st-name: found .P, which is not declared")


def test_a_program_that_waits_for_ever_is_ended() -> None:
    text = program("shield", "chain").replace("IN_POSITION : LREAL := LREAL#0.005",
                                              "IN_POSITION : LREAL := LREAL#-1.0")  # fmt: skip
    units, said = check_text(text, table_machine())
    assert not said
    found = run(units, table_machine(), "a.st")[1]
    assert any(d.code == "st-run" and "waiting for ever" in d.message for d in found)


def test_a_division_by_zero_stops_the_controller() -> None:
    text = program("shield", "chain").replace("length := SQRT(", "length := LREAL#0.0 * SQRT(")
    assert "st-run" in codes(text)


def renamed(**names: str) -> Machine:
    return table_machine(path_objects=True, names=names)


@pytest.mark.parametrize("style", ["chain", "table"])
def test_names_of_the_library_are_written_and_read_as_the_machine_calls_them(style: str) -> None:
    machine = renamed(pathObject="pathObjectType", X_Y="XY", _homing="_home", control="servo")
    text = program("shield", style, machine)
    for name in ("pathObjectType := Path", "pathPlane := XY", "_home(", "axis.servo = ACTIVE"):
        assert name in text
    assert not re.search(r"\b(pathObject|X_Y|_homing|control)\b", text)
    assert verify_triggers(text, [part("shield")], machine, (), "a.st") == ()


def test_a_name_that_is_called_otherwise_is_refused() -> None:
    text = program("shield", "chain", renamed())
    said = check_text(text, renamed(pathObject="pathObjectType"), "a.st")[1]
    line = next(k for k, row in enumerate(text.splitlines(), 1) if "pathObject :=" in row)
    assert str(next(d for d in said if d.source.line == line)) == (
        f"a.st:{line}: error st-parameter: found pathObject (here pathObjectType) in a call of "
        "_movePathLinear; expected a name that is"
    )


def test_only_names_that_are_not_confirmed_may_be_called_otherwise() -> None:
    faults = list(table_faults(renamed(_pos="_position", X_Y="X Y")))
    assert [(key, found) for key, found, _ in faults] == [
        ("triggers.names", "_pos"), ("triggers.names.X_Y", "X Y"),
    ]  # fmt: skip
