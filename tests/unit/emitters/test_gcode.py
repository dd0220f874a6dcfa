"""Texts of bars: kept pieces make what filling in a template makes, and blocks are counted."""

import re

from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.emitters.gcode import emit, numbered
from beamcam.errors import Source
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.program import (
    Command,
    Comment,
    DrillCycle,
    Program,
    SawStroke,
    SpindleStroke,
    StartBar,
)
from tests.conftest import examples

SOURCE = Source("a.nc1", 1)
LENGTHS = st.sampled_from((0.0, -0.0, 5.0, 12.5, 300.125, -0.0004, 99999.9996))
PLACES = st.tuples(LENGTHS, LENGTHS)
STROKES = st.builds(
    SpindleStroke, st.sampled_from((1, 13)), LENGTHS, PLACES, PLACES, PLACES, LENGTHS, LENGTHS
)
CYCLES = st.builds(DrillCycle, LENGTHS, STROKES, st.just(SOURCE))
CUTS = st.builds(SawStroke, LENGTHS, LENGTHS, LENGTHS, st.just(SOURCE), LENGTHS)


def padded(machine: Machine) -> Machine:
    """The same with an X of nine places, so that no text can be cut there and kept."""

    def wide(template: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(line.replace("{x}", "{x:_>9}") for line in template)

    words = machine.words
    return replace(machine, words=replace(words, drill=wide(words.drill), saw=wide(words.saw)))


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(CYCLES | CUTS, max_size=8))
def test_what_is_kept_makes_the_same_text(commands: list[Command]) -> None:
    machine = load("beamline")
    program = Program("J", (StartBar(1, 150.0, 300.0), *commands))
    text = emit(program, machine)
    assert emit(program, machine) == text
    assert emit(program, replace(machine)) == text
    manual_work = emit(program, padded(machine))
    assert re.sub(r" X_+", " X", manual_work) == text
    assert all(len(x) >= 9 for x in re.findall(r" X(\S+)", manual_work))


def test_a_word_without_a_template_is_no_line() -> None:
    machine = load("beamline")
    bare = replace(machine, words=replace(machine.words, header=(), saw=(), footer=()))
    commands = (StartBar(1, 150.0, 300.0), SawStroke(1.0, 0.0, 60.0, SOURCE), Comment("a note"))
    assert emit(Program("J", commands), bare) == "(a note)\n"


LINES = st.sampled_from(("G90", "M30", "%", "% JOB", "(a note)", "M03 (on)", "G01 X5", ""))


@given(st.lists(st.lists(LINES, min_size=1, max_size=3).map("\n".join), max_size=12))
def test_blocks_are_counted_and_comments_are_not(blocks: list[str]) -> None:
    text = "".join(f"{block}\n" for block in blocks)
    count = 0
    for line, written in zip(text.split("\n")[:-1], numbered(text).split("\n")[:-1], strict=True):
        if line.startswith(("%", "(")):
            assert written == line
        else:
            count += 1
            assert written == f"N{count} {line}"
