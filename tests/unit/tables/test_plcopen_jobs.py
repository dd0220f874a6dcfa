"""Trigger programs in plain IEC 61131-3 read back, and what a machine's file may say of them."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.checks.st import verify_triggers
from beamcam.controllers.simotion.job import read_program
from beamcam.emitters import simotion
from beamcam.machine.runtime import runtime_of
from beamcam.machine.torch_faults import table_faults
from tests.conftest import examples, sampled

from . import test_simotion as forms
from .plant import DONE, STYLES, Plant, units_of
from .shop import plain_machine, steel_part, table_machine, triggers
from .test_plcopen import program

# -- read back ------------------------------------------------------------------------------


@given(data=st.data())
@settings(max_examples=examples(60), deadline=None)
def test_a_changed_byte_of_the_fixed_part_is_refused_by_name(data: st.DataObject) -> None:
    style = data.draw(st.sampled_from(STYLES))
    text, machine = program("shield", style), plain_machine()
    fixed = runtime_of(machine, style)
    piece = data.draw(st.sampled_from((fixed.head, fixed.middle, fixed.end)))
    at = text.index(piece) + data.draw(st.integers(0, len(piece) - 2))
    other = data.draw(
        st.characters(min_codepoint=33, max_codepoint=126).filter(lambda c: c != text[at])
    )
    changed = text[:at] + other + text[at + 1 :]
    (said,) = verify_triggers(changed, [steel_part("shield")], machine, (), "a.st")
    assert said.code == "st-runtime"


def of_style(style: str) -> list[tuple[str, str, str]]:
    """The mutants of the other dialect whose text a program of this one has too."""
    mutants = {"chain": forms.CHAIN_MUTANTS, "table": forms.TABLE_MUTANTS}[style]
    text = program("shield", style)
    return [mutant for mutant in mutants if re.search(mutant[0], text)]


#: Codes that a plain program has for mutants, where they are others than those of the units.
OTHERWISE = {
    ("table", r"\(row <= DINT#11\)"): "st-bounds",
    ("table", forms.TABLE_MUTANTS[5][0]): "st-syntax",
}
MUTANTS = [
    (style, find, put, OTHERWISE.get((style, find), code))
    for style in STYLES
    for find, put, code in of_style(style)
]


def test_most_mutants_apply_to_both_dialects() -> None:
    known = len(forms.CHAIN_MUTANTS) + len(forms.TABLE_MUTANTS)
    assert known - len(MUTANTS) <= 5  # of units, which a plain program has none of


@pytest.mark.parametrize(("style", "find", "put", "code"), sampled(MUTANTS, 2))
def test_a_mutant_of_a_job_is_caught(style: str, find: str, put: str, code: str) -> None:
    text = program("shield", style)
    changed = re.sub(find, put, text, count=1)
    assert changed != text
    said = verify_triggers(changed, [steel_part("shield")], plain_machine(), (), "a.st")
    assert any(d.code.startswith(code) for d in said), said


def test_a_program_of_the_other_dialect_is_refused() -> None:
    for style in STYLES:
        plain, other = program("shield", style), forms.program("shield", style)
        assert read_program(plain, table_machine())[1][0].code == "st-runtime"
        assert read_program(other, plain_machine())[1][0].code == "st-runtime"


def test_a_table_of_any_length_is_one_text() -> None:
    assert program("rounded-rectangle", "table").count("===== UNIT") == 1


# -- the machine's file ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "key"),
    [({"path_objects": True}, "triggers.path_objects"), ({"package": "CAM"}, "triggers.package"),
     ({"uses": ("io",)}, "triggers.uses"), ({"max_data": 2048}, "triggers.max_data"),
     ({"names": {"_move": "x"}}, "triggers.names"), ({"start": "%I"}, "triggers.limits"),
     ({"start": "%QX0.4"}, "triggers.limits"), ({"axes": ("A__B", "Y")}, "triggers.axes")],
)  # fmt: skip
def test_keys_that_mean_nothing_to_the_dialect_are_refused(
    changes: dict[str, object], key: str
) -> None:
    assert [fault[0] for fault in table_faults(plain_machine(**changes))] == [key]


def test_an_address_with_and_without_its_letter_is_one_place() -> None:
    (fault,) = table_faults(plain_machine(start="%I0.5"))
    assert fault == ("triggers", "each input, output and axis once", "%I0.5")


@pytest.mark.parametrize("place", ["%IX0.4", "%I0.4", "%IX3", "%IX1.2.3", "startFromPanel"])
def test_addresses_and_names_of_inputs(place: str) -> None:
    machine = plain_machine(start=place)
    assert list(table_faults(machine)) == []
    text = simotion.emit(triggers("shield"), machine, "chain")
    units_of(text, machine)
    assert read_program(text, machine)[1] == []


def test_a_library_may_call_its_blocks_otherwise() -> None:
    machine = plain_machine(names={"AXIS_REF": "AXIS_REF_SM3", "MC_Power": "OEM_Power"})
    assert list(table_faults(machine)) == []
    text = simotion.emit(triggers("shield"), machine, "chain")
    assert "AXIS_REF_SM3" in text
    assert "OEM_Power" in text
    assert not re.search(r"\bAXIS_REF\b|\bMC_Power\b", text)
    assert verify_triggers(text, [steel_part("shield")], machine, (), "a.st") == ()


def test_named_inputs_and_outputs_are_declared() -> None:
    machine = plain_machine(
        limits=("xLow", "xHigh", "yLow", "yHigh"), start="go", acknowledge="quit", stop="halt",
        normally_closed=("xLow", "halt"),
        outputs={"cut": "torchValve", "mark": "scriber"},
    )  # fmt: skip
    text = simotion.emit(triggers("shield-small"), machine, "chain")
    one = Plant(units_of(text, machine), machine)
    one.press_start()
    one.run_until(DONE, 600.0)
    assert one.diagnostics == []
    assert one.points["cut"]
    lit = simotion.emit(triggers("shield"), plain_machine(fault_lamp="lamp"), "chain")
    assert "    lamp := workFault;\n" in lit
    units_of(lit, plain_machine(fault_lamp="lamp"))
