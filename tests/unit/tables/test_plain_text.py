"""Plain trigger programs as a compiler of IEC 61131-3, edition 2, would take them, word by word."""

import re
from functools import cache

import pytest

from beamcam.controllers.simotion.trial import check
from beamcam.controllers.simotion.types import parse_plain
from beamcam.machine.runtime import shipped

from . import test_grammar as stranger
from .plant import STYLES
from .shop import NAMES
from .test_plcopen import program

BLOCKS = shipped("plcopen_blocks")


@cache
def whole(name: str, style: str) -> str:
    """The blocks of the library and a program, as they are compiled."""
    return BLOCKS + program(name, style)


def codes(text: str) -> list[str]:
    units, said = parse_plain(text, "a.st")
    return [d.code for d in said or check(units, {}, "a.st")]


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", NAMES)
def test_every_name_type_and_bound_holds(name: str, style: str) -> None:
    assert codes(whole(name, style)) == []


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", NAMES)
def test_the_grammar_of_a_stranger_accepts_it(name: str, style: str) -> None:
    assert stranger.faults(whole(name, style)) == []


OPERATIONS = re.compile(r"FUNCTION_BLOCK FB_Operations.*?END_FUNCTION_BLOCK", re.DOTALL)


@pytest.mark.exhaustive
def test_the_parser_of_another_stranger_accepts_it() -> None:
    """Whose dialect has no configurations. It is slow: of a table, the block that differs."""
    blark = pytest.importorskip("blark.parse", reason="no blark")
    text = re.sub(r"CONFIGURATION.*END_CONFIGURATION", "", whole("shield", "chain"), flags=re.S)
    (table,) = OPERATIONS.findall(program("shield", "table"))
    for one in (text, table):
        assert blark.parse_source_code(one).exception is None
    assert blark.parse_source_code(table.replace("THEN", "THAN", 1)).exception is not None


CHANGES = [
    # What is changed, into what, and the code that has to be said.
    ("(* One axis", "// One axis", "st-syntax"),
    ("    faulty :=", "    {once} faulty :=", "st-syntax"),
    ("    faulty :=", "    faulti :=", "st-name"),
    ("        targetSpeed : LREAL;\n", "        goal : LREAL;\n", "st-name"),
    ("        targetSpeed : LREAL;\n", "        targetSpeed : REAL;\n", "st-type"),
    ("        operation : DINT;\n        operationKind", "        operationKind", "st-name"),
    ("        axis : AXIS_REF;", "        axis : AXIS_REF := 0;", "st-syntax"),
    ("        commandFault : BOOL;", "        commandFault : BOOL := FALSE;", "st-syntax"),
    ("        runsX : BOOL := FALSE;", "        runsX AT %QX1.0 : BOOL := FALSE;", "st-syntax"),
    ("        power : MC_Power;", "        power : FB_Home;", "st-syntax"),  # which comes later
    ("        power : MC_Power;", "        power : MC_Energy;", "st-syntax"),
    ("        power : MC_Power;", "        limit : MC_Power;", "st-declaration"),
    ("        axis : AXIS_REF;", "        axis : posAxis;", "st-syntax"),
    ("power(Axis := axis, Enable", "power(Achse := axis, Enable", "st-parameter"),
    ("power(Axis := axis, Enable", "power(Enable", "st-parameter"),
    ("power(Axis := axis, Enable", "power(Axis := powered, Enable", "st-type"),
    ("Enable := powered", "Enable := lastSet", "st-type"),
    ("ParameterNumber := COMMANDED", "ParameterNumber := LREAL#1.0 + STANDSTILL", "st-name"),
    ("setPosition := commanded.Value;", "setPosition := commanded.Wert;", "st-name"),
    ("setPosition := commanded.Value;", "STANDSTILL_WINDOW := commanded.Value;", "st-type"),
    ("setPosition := commanded.Value;", "powered := TRUE;", "st-type"),
    ("setPosition := commanded.Value;", "IF powered THEN END_IF;", "st-syntax"),
    ("setPosition := commanded.Value;", "_stop(axis := axis);", "st-name"),
    ("setPosition := commanded.Value;", "setPosition := ACTIVE;", "st-name"),
    ("axisStatus.Standstill AND", "axisStatus.ErrorID AND", "st-name"),
    ("    startBefore := startButton;", "    startButton := startBefore;", "st-type"),
    ("triggerActive[0] := TRUE;", "triggerActive[-1] := TRUE;", "st-bounds"),
    ("triggerActive[3] := TRUE;", "triggerActive[12] := TRUE;", "st-bounds"),
    ("END_FUNCTION_BLOCK", "END_REGION END_FUNCTION_BLOCK", "st-syntax"),
    ("END_FUNCTION_BLOCK", "METHOD m END_METHOD END_FUNCTION_BLOCK", "st-syntax"),
    ("CONFIGURATION CuttingTable", "CONFIGURATION Limit", "st-syntax"),
    ("WITH CutTask", "WITH OtherTask", "st-syntax"),
    ("CutTask : CutPart", "CutTask : CutPort", "st-name"),
    ("INTERVAL := T#25ms", "INTERVAL := 25", "st-syntax"),
    ("    VAR_GLOBAL\n", "    VAR_GLOBAL END_VAR VAR_GLOBAL\n", "st-syntax"),
    ("        workDone : BOOL := FALSE;", "        workDone : BOOL := INT#0;", "st-type"),
    ("        workDone : BOOL := FALSE;", "        workDone, x : BOOL;", "st-syntax"),
]  # fmt: skip


@pytest.mark.parametrize(("find", "put", "code"), CHANGES)
def test_what_a_compiler_would_refuse_is_refused(find: str, put: str, code: str) -> None:
    text = program("shield", "chain")
    assert find in text
    assert code in codes(BLOCKS + text.replace(find, put, 1))


def test_a_text_without_a_configuration_is_not_whole() -> None:
    text = re.sub(r"CONFIGURATION.*", "", whole("shield", "chain"), flags=re.DOTALL)
    assert codes(text) == ["st-syntax"]


def test_an_array_that_is_not_filled_is_refused() -> None:
    text = whole("shield", "table")
    assert codes(text.replace("LREAL#25.0, ", "", 1)) == ["st-array"]
    assert set(codes(text.replace("[1..11] OF LREAL", "[11..1] OF LREAL", 1))) == {"st-bounds"}
