"""What is said: each rule of trigger programs and of tables, with what was found and expected."""

import re

import pytest
from msgspec.structs import replace

from beamcam.checks.st import verify_triggers
from beamcam.checks.steps import rules as steps_rules
from beamcam.checks.steps import verify_table
from beamcam.controllers import step_table as row_rules
from beamcam.controllers.simotion import rules as st_rules
from beamcam.controllers.simotion.cutting_table import CuttingTable
from beamcam.controllers.simotion.parser import parse
from beamcam.controllers.simotion.trial import check, project_objects
from beamcam.emitters import step_table as forms
from beamcam.errors import Diagnostic, VerifyError
from beamcam.machine import load
from beamcam.machine.faults import with_found
from beamcam.machine.machine import Machine
from beamcam.machine.torch_faults import table_faults
from beamcam.motion.steps import step_table
from tests.conftest import rules_of

from . import test_lift_programs as lifts
from .shop import part, plan, program, steel_part, table_machine

# -- trigger programs -----------------------------------------------------------------------

#: Style of the shield's program, what is changed, into what, and the first thing that is said
#: behind the name of the file.
SAID_OF_PROGRAMS = [
    ("chain", r"speed := LREAL#2\.0", "speed := LREAL#2",
     "{line}: error st-syntax: found 'speed := LREAL#2);'; expected speed := LREAL#...);"),
    ("chain", "workDone := workState = INT#3", "workDone := TRUE",
     "{line}: error st-runtime: found 'workDone := TRUE;' in the fixed part of the program; "
     "expected 'workDone := workState = INT#3;'"),
    ("table", "USES unit_shield_1", "USES unit_shield_2",
     "{line}: error st-name: found unit unit_shield_2, which is not declared; expected "
     "unit_shield_1"),
    ("table", r"(?s)\n\(\* ===== UNIT unit_shield_1.*", "\n",
     "{line}: error st-syntax: found 'the end of the program'; expected (* ===== UNIT "
     "unit_shield_1 ===== *); join the file of that unit behind this one"),
    ("chain", r"ARRAY \[0\.\.11\] OF BOOL", "ARRAY [0..10] OF BOOL",
     "{line}: error st-bounds: found index 10 of triggerActive; expected 0 to 11"),
    ("table", r"LREAL#25\.0, LREAL#35\.0, ", "LREAL#25.0, ",
     "{array}: error st-array: found 10 values for pointX_1; expected 11"),
    ("chain", r"x := LREAL#35\.0, y := L", "x := LREAL#-35.0, y := L",
     "{block}: error st-command: found AxisX to -35; expected 0 to 700"),
    ("chain", r"NOT triggerActive\[5\]", "NOT triggerActive[6]",
     "{line}: error st-trigger: found trigger 5 behind 4, but not 6; expected trigger 5 behind 4, "
     "but not 5"),
    ("chain", "PIERCE_CUT : TIME := T#800ms", "PIERCE_CUT : TIME := T#80ms",
     "{switch}: error st-tool: found a wait of 0.080 s behind the start of the tool; expected "
     "0.8 s"),
    ("chain", r"kind := USINT#1, x := LREAL#25\.0", "kind := USINT#1, x := LREAL#26.0",
     "{block}: error st-straight: found a switch at X 26, Y 5; expected it at X 25, Y 5, where "
     "the head stands"),
    ("chain", r"speed := LREAL#2\.0", "speed := LREAL#9.0",
     "{speed}: error st-speed: found 9 mm/s to cut; expected above 0 and at most 2 mm/s"),
    ("chain", r"speed := LREAL#2\.0", "speed := LREAL#0.2",
     "{speed}: error st-speed: found 0.2 mm/s to cut; expected 2 mm/s"),
    ("chain", r"x := LREAL#0\.0, y := LREAL#0\.0", "x := LREAL#1.0, y := LREAL#0.0",
     "{block}: error st-run: found the end at X 1.000, Y 0.000; expected both axes at 0"),
]  # fmt: skip


@pytest.mark.parametrize(("style", "find", "put", "says"), SAID_OF_PROGRAMS)
def test_what_is_said_of_a_program(style: str, find: str, put: str, says: str) -> None:
    text = program("shield", style)
    changed = re.sub(find, lambda _: put, text, count=1)
    assert changed != text
    line = next(k for k, (a, b) in enumerate(zip(text.split("\n"), changed.split("\n"),
                                                 strict=False), 1) if a != b)  # fmt: skip
    switch = text.partition("kind := USINT#1")[0].count("\n") - 1
    places = {"line": line, "block": line - 2, "speed": line - 3, "array": line - 1,
              "switch": switch}  # fmt: skip
    said = verify_triggers(changed, [steel_part("shield")], table_machine(), (), "a.st")
    message, _, contour = str(said[0]).partition(", beside the contour of ")
    assert message == f"a.st:{says.format(**places)}"
    # What is wrong with an operation, or in its block, is told with the contour that is nearest.
    in_block = "triggerActive[" in find.replace("\\", "") or "speed :=" in find
    is_of_operation = in_block or not says.startswith(("{line}", "{array}"))
    assert contour.startswith("shield.json:") == is_of_operation


#: What is changed in the fixed part of a machine's programs, and the first thing that is said.
SAID_OF_RUNTIMES = [
    (r"END_IF;\n +END_FUNCTION_BLOCK", "END_FUNCTION_BLOCK",
     "st-syntax: found 'END_FUNCTION_BLOCK'; expected a statement or ELSE"),
    ("TYPE := DIRECT|Type := DIRECT", "Type := \xdcBER",
     "st-syntax: found '\xdcBER, veloci'; expected ASCII letters, numbers and characters of "
     "Structured Text"),
    ("INT := INT#0", "INT := INT#99999",
     "st-syntax: found 'INT#99999'; expected a value of INT"),
    (r"wait\.Q", "wait.P", "st-name: found .P, which is not declared; expected a name that is"),
    ("workState := INT#3", "workStat := INT#3",
     "st-name: found workStat, which is not declared; expected workState"),
    ("shareX : LREAL;", "dt : LREAL;",
     "st-declaration: found the name dt as a variable; expected another, as it means something "
     "already"),
    ("shareX : LREAL;", "shareX : LREAL; shareX : LREAL;",
     "st-declaration: found the name shareX twice; expected it once"),
    (r"x := LREAL#25\.0, y := L", "z := LREAL#25.0, y := L",
     "st-parameter: found z in a call of next; expected a name that is"),
    ("workState := INT#3", "workState := LREAL#3.0",
     "st-type: found LREAL for workState; expected INT"),
    ("direction := POSITIVE", "direction := ABSOLUTE",
     "st-type: found ABSOLUTE for direction of _pos; expected POSITIVE or NEGATIVE or BY_VALUE or "
     "SHORTEST_WAY"),
    (r"fault <> INT#0\) AND", "fault <> LREAL#0.0) AND",
     "st-type: found LREAL for <> with INT; expected INT"),
    (r"triggerActive\[11\] := TRUE", "triggerActive[12] := TRUE",
     "st-bounds: found index 12 of triggerActive; expected 0 to 11"),
    (r"way := SQRT\(", "way := LREAL#0.0 / LREAL#0.0 * SQRT(",
     "st-run: found a division by 0; expected none"),
    (r"FOR k := DINT#0 TO LAST_OPERATION", "FOR k := DINT#0 TO LAST_OPERATION + DINT#1",
     "st-bounds: found index 12 of triggerActive; expected 0 to 11"),
    (r"velocity := targetSpeed \* shareX", "velocity := LREAL#0.0",
     "st-command: found velocity 0; expected more than 0"),
    ("velocityProfile := TRAPEZOIDAL", "velocityProfile := SMOOTH",
     "st-command: found a smooth profile; expected TRAPEZOIDAL, so that axes arrive together"),
    ("mergeMode := IMMEDIATELY,\n +nextCommand := IMMEDIATELY",
     "mergeMode := SEQUENTIAL, nextCommand := IMMEDIATELY",
     "st-command: found ABSOLUTE with SEQUENTIAL; expected ABSOLUTE with IMMEDIATELY"),
    ("mergeMode := IMMEDIATELY,\n +nextCommand := IMMEDIATELY",
     "mergeMode := IMMEDIATELY, nextCommand := WHEN_MOTION_DONE",
     "st-command: found nextCommand WHEN_MOTION_DONE; expected IMMEDIATELY in a cycle"),
    ("homingMode := DIRECT_HOMING", "homingMode := ACTIVE_HOMING",
     "st-command: found ACTIVE_HOMING; expected DIRECT_HOMING to a DIRECT position"),
]  # fmt: skip


@pytest.mark.parametrize(("find", "put", "says"), SAID_OF_RUNTIMES)
def test_what_is_said_of_a_fixed_part(find: str, put: str, says: str) -> None:
    text = program("shield", "chain")
    changed = re.sub(find, lambda _: put, text, count=1)
    assert changed != text
    line = next(k for k, (a, b) in enumerate(zip(text.split("\n"), changed.split("\n"),
                                                 strict=False), 1) if a != b)  # fmt: skip
    said = said_of(changed)
    assert f": error {says}" in str(said[0])
    assert abs((said[0].source.line or 0) - line) <= 8


def said_of(text: str) -> list[Diagnostic]:
    """What checker and executor say of a text that is no longer the shipped one."""
    machine = table_machine()
    units, said = parse(text, "a.st")
    said = said or check(units, project_objects(machine), "a.st")
    if said:
        return said
    cell = CuttingTable(units, machine, "a.st")
    try:
        while not cell.diagnostics and cell.clock_s < 20:
            cell.start = cell.clock_s > 0.0
            cell.cycle()
    except VerifyError as fault:
        return [*fault.diagnostics]
    return cell.diagnostics


def test_every_rule_of_programs_is_said() -> None:
    cases = (*SAID_OF_PROGRAMS, *SAID_OF_RUNTIMES, *lifts.SAID)
    met = {word.rstrip(":") for *_, says in cases
           for word in says.split() if word.startswith("st-")}  # fmt: skip
    assert met == {rule.code for rule in rules_of(st_rules)}


# -- tables ---------------------------------------------------------------------------------

LASER = load("laser-stepper")
TABLE = step_table(plan("shield-small", "laser-stepper"), LASER, "shield-small")
WRITTEN = {form: b"".join(write(TABLE)).decode("latin-1") for form, write in forms.FORMS.items()}

SAID_OF_TABLES = [
    (".steps", "time_us,x,y,laser", "time,x,y,laser",
     "2: error steps-row: found time,x,y,laser; expected time_us,x,y,laser"),
    (".steps", "\n000000000000,00,00,0", "\n000000000000,00,0x,0",
     "3: error steps-row: found '000000000000,00,0x,0\\n'; expected as 000000001234,01,10,1"),
    (".steps", "step 0.01 mm", "step 0.02 mm",
     "1: error steps-head: found # beamcam/steps/1 job shield-small step  in the head of the "
     "table; expected # beamcam/steps/1 job JOB step 0.01 mm"),
    (".h", r"\(row\) >> 4", "(row) >> 3",
     "9: error steps-head: found '#define BEAMCAM_LASER(row) (((row) >> 3)' in the head of the "
     "table; expected '#define BEAMCAM_LASER(row) (((row) >> 4) & 1u)'"),
    (".bin", "BCSTEPS1", "BCSTEPS2",
     "1: error steps-row: found 'BCSTEPS2'; expected BCSTEPS1 and a head of 32 bytes"),
    (".steps", "\n000000011648,01,01,0", "\n000000011648,10,01,0",
     "4: error steps-word: found word 10 of X behind 00; expected a neighbour in the sequence "
     "00 01 10 11"),
    (".steps", "\n000000016711,", "\n000000000711,",
     "5: error steps-time: found a time before the last one; expected a later one"),
    (".steps", "\n000000016711,", "\n000000011700,",
     "5: error steps-frequency: found steps of X 52 us apart; expected at least 100 us"),
    (".steps", r"\n(\d{12},\d\d,\d\d),0\n\Z", r"\n\1,1\n",
     "3205: error steps-laser: found a step in the row that switches the laser; expected the "
     "head at rest"),
    (".csv", "\n5,5,56.5685,", "\n5,5.05,56.5685,",
     "3: error steps-count: found 500 steps of Y up to X 5, Y 5.05; expected 505"),
    (".csv", "\n7,12,0,4,1,", "\n7,12,0,-4,1,",
     "5: error steps-velocity: found velocity 0, -4 for a way of 0, 4; expected it along the way"),
    (".csv", ",0,400,0,400\n", ",0,400,0,401\n",
     "5: error steps-velocity: found 401 Hz of Y; expected 400 Hz for 4 mm/s"),
    (".csv", "\n7,12,0,4,1,0,400,0,400\n", "\n7,12,0,4.4,1,0,400,0,440\n",
     "5: error steps-speed: found 4.40 mm/s to cut; expected at most 4 mm/s, "
     "beside the contour of shield-small.json:contours[0]"),
    (".csv", "\n7,12,0,4,1,0,400,0,400\n", "\n7,12,0,3.6,1,0,400,0,360\n",
     "5: error steps-speed: found 3.60 mm/s to cut; expected at least 4 mm/s, "
     "beside the contour of shield-small.json:contours[0]"),
    (".csv", "\n0,0,-56.5685,-56.5685,0,-500,-500,5656.85,5656.85\n", "\n",
     " error steps-place: found the head at X 5, Y 5; expected it in the corner at the end"),
    (".csv", "\n0,0,-56.5685,-56.5685,0,-500,-500,5656.85,5656.85\n",
     "\n0,0,-28.5685,-28.5685,0,-500,-500,2856.85,2856.85\n",
     "11: error steps-speed: found 40.402 mm/s to traverse; expected 80 mm/s"),
]  # fmt: skip


@pytest.mark.parametrize(("form", "find", "put", "says"), SAID_OF_TABLES)
def test_what_is_said_of_a_table(form: str, find: str, put: str, says: str) -> None:
    changed = re.sub(find, put, WRITTEN[form], count=1)
    assert changed != WRITTEN[form]
    data = changed.encode("latin-1")
    said = verify_table(form, (data,), [part("shield-small")], LASER, (), "a")
    assert str(said[0]) == f"a:{says}"


def test_an_acceleration_is_told_with_its_limit() -> None:
    up = [(k * 110, k) for k in range(2000)]
    rows = up + [(220_000 + k * 110, 2000 - k) for k in range(1, 2001)]
    lines = "".join(f"{t:012d},{x & 3:02b},00,0\n" for t, x in rows)
    said = verify_table(".steps", (f"time_us,x,y,laser\n{lines}".encode(),), [], LASER, (), "a")
    assert [str(d) for d in said] == [
        "a: error steps-acceleration: found X at 35600 mm/s2 near X 19.99, Y 0.00; expected at "
        "most 500 mm/s2"
    ]
    said = verify_table(
        ".steps", (f"time_us,x,y,laser\n{lines}".encode(),), [part("shield-small")], LASER, (), "a"
    )
    (only,) = [str(d) for d in said if d.code == "steps-acceleration"]
    assert "mm/s2, beside the contour of " in only


def test_every_rule_of_tables_is_said() -> None:
    met = {word.rstrip(":") for *_, says in SAID_OF_TABLES for word in says.split()
           if word.startswith("steps-")}  # fmt: skip
    assert met | {"steps-acceleration"} == {rule.code for rule in rules_of(row_rules, steps_rules)}


@pytest.mark.parametrize("form", [".st", ".txt", ""])
def test_another_form_is_refused(form: str) -> None:
    with pytest.raises(ValueError, match=r"expected one of \.steps, \.bin, \.h, \.csv"):
        verify_table(form, (), [], LASER)


# -- machines -------------------------------------------------------------------------------


def stepper(**changes: object) -> Machine:
    assert LASER.stepper is not None
    return replace(LASER, stepper=replace(LASER.stepper, **changes))


FAULTY = [
    (replace(LASER, stepper=None), "stepper", None, "a table, since the controller is stepper"),
    (replace(table_machine(), triggers=None), "triggers", None,
     "a table, since the controller is simotion"),
    (stepper(sequence=("00", "01", "10", "10")), "stepper.sequence", ["00", "01", "10", "10"],
     "each of 00, 01, 10, 11 once"),
    (table_machine(axes=("Eje X", "EjeY")), "triggers.axes", "Eje X",
     "letters, digits and single _, a letter first"),
    (table_machine(outputs={"cut": "%Q0.0"}), "triggers.outputs", {"cut": "%Q0.0"},
     "an output for mark"),
    (table_machine(outputs={"cut": "%Q0.9", "mark": "%Q0.1"}), "triggers.outputs", "%Q0.9",
     "an address of an output such as %Q62.0 or the name of a variable"),
    (table_machine(normally_closed=("%I0.7",)), "triggers.normally_closed", "%I0.7",
     "one of the inputs %I0.0, %I0.1, %I0.2, %I0.3, %I0.4, %I0.5, %I0.6"),
    (table_machine(stop="stop!", normally_closed=()), "triggers.limits", "stop!",
     "an address of an input such as %I0.0 or the name of a variable"),
    (table_machine(homing_slow_mm_s=11.0), "triggers.homing_slow_mm_s", 11.0,
     "at most homing_mm_s, 10"),
    (table_machine(max_late_s=0.2), "triggers.max_late_s", 0.2,
     "0.25 or more, 4 cycles and 3 times following_lag_s"),
    (table_machine(start="I0.4"), "triggers.limits", "I0.4",
     "an address of an input such as %I0.0 or the name of a variable"),
    (table_machine(start=""), "triggers.limits", "",
     "an address of an input such as %I0.0 or the name of a variable"),
    (table_machine(fault_lamp="the lamp"), "triggers.outputs", "the lamp",
     "an address of an output such as %Q62.0 or the name of a variable"),
    (table_machine(uses=("a-b",)), "triggers.axes", "a-b",
     "letters, digits and single _, a letter first"),
    (table_machine(arrival_window=0.1), "triggers.arrival_window", 0.1,
     "a count of the encoder or more, 0.1270 mm"),
    (table_machine(arrival_window=0.03, quadrature=True), "triggers.arrival_window", 0.03,
     "a count of the encoder or more, 0.0317 mm"),
    (table_machine(arrival_window=0.015, quadrature=True, counted="centre"),
     "triggers.arrival_window", 0.015, "half a count of the encoder or more, 0.0159 mm"),
    (table_machine(max_homing_s=60.0), "triggers.max_homing_s", 60.0,
     "82.06 or more for 775 mm at homing_mm_s and the slow approach"),
]  # fmt: skip


@pytest.mark.parametrize(("machine", "key", "found", "expected"), FAULTY)
def test_what_is_said_of_a_machine(
    machine: Machine, key: str, found: object, expected: str
) -> None:
    assert list(with_found(table_faults(machine), machine)) == [(key, found, expected)]
