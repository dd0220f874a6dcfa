"""Cutting data of the shipped lines: rows by steel, tool material and diameter."""

from itertools import pairwise
from math import pi

import pytest
from msgspec.structs import replace

from beamcam.machine import load
from beamcam.machine.stations import (
    Cutting,
    Drill,
    Tool,
    ToolMaterial,
    cutting_row,
    is_unnamed,
    names_grade,
    speed_and_feed,
)
from beamcam.pipeline import post
from tests.unit.planning.shop import hole, part

LINES = ("beamline", "beamline-pusher")
#: By rising hardness to cut.
STEELS = (
    ("S235JR", "S275J0", "S185", "A36", "RSt37-2", "300"),
    ("S355J2+N", "S390GP", "A992", "350"),
    ("S460ML", "S690QL"),
)
STAINLESS = ("1.4301", "X5CrNi18-10", "AISI 316L", "304", "316Ti")


def drill_of(name: str) -> Drill:
    drill = load(name).drill
    assert drill is not None
    return drill


def table(drill: Drill, grade: str, material: ToolMaterial = "hss") -> list[Cutting]:
    """The rows of 8 to 50 mm, a mm apart."""
    tools = [Tool("drill", float(d), tool_material=material) for d in range(8, 51)]
    return [cutting_row(tool, drill, grade) for tool in tools]


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize("material", ["hss", "carbide"])
@pytest.mark.parametrize("grade", [*(g for row in STEELS for g in row), *STAINLESS, "", "C45"])
def test_feed_grows_with_the_diameter_and_speed_stays_in_range(
    name: str, material: ToolMaterial, grade: str
) -> None:
    drill = drill_of(name)
    feeds = [row.feed_per_turn for row in table(drill, grade, material)]
    assert all(a <= b for a, b in pairwise(feeds))
    assert feeds[0] < feeds[-1]
    for diameter in range(8, 51):
        tool = Tool("drill", float(diameter), tool_material=material)
        turns, feed = speed_and_feed(tool, drill, grade)
        assert 150 <= turns <= 2500
        assert feed == pytest.approx(turns * feeds[diameter - 8])


def test_a_point_turns_as_fast_as_the_spindle_may() -> None:
    """A program may name a tool of no diameter, which is simulated all the same."""
    drill = drill_of("beamline")
    assert speed_and_feed(Tool("drill", 0.0), drill, "")[0] == drill.max_speed_rpm


@pytest.mark.parametrize("name", LINES)
def test_harder_steel_is_cut_more_slowly_and_carbide_faster(name: str) -> None:
    drill = drill_of(name)
    mild, usual, hard = (table(drill, row[0]) for row in STEELS)
    for a, b, c in zip(mild, usual, hard, strict=True):
        assert a.speed_m_min > b.speed_m_min > c.speed_m_min
        assert a.feed_per_turn >= b.feed_per_turn >= c.feed_per_turn
    for hss, carbide in zip(mild, table(drill, STEELS[0][0], "carbide"), strict=True):
        assert carbide.speed_m_min > 2 * hss.speed_m_min


@pytest.mark.parametrize("name", LINES)
def test_each_grade_has_the_rows_of_its_kind(name: str) -> None:
    drill = drill_of(name)
    for grades in (*STEELS, STAINLESS):
        rows = {id(cutting_row(Tool("drill", 20.0), drill, grade)) for grade in grades}
        assert len(rows) == 1, grades
    assert not any(is_unnamed(drill, g) for row in (*STEELS, STAINLESS) for g in row)
    # Names of steels of other standards are not taken for something that they are not.
    assert all(is_unnamed(drill, g) for g in ("C45", "42CrMo4", "NA", "K"))


def test_patterns_of_a_row() -> None:
    row = Cutting(20.0, 25.0, 0.2, grade="s235* | A36")
    assert [names_grade(row, g) for g in ("S235JR", "a36", "A360", "S355")] == [
        True, True, False, False,
    ]  # fmt: skip


def test_a_steel_that_nobody_names_gets_the_rows_for_any() -> None:
    drill = drill_of("beamline")
    assert cutting_row(Tool("drill", 20.0), drill, "C45").grade == "*"
    plain = replace(drill, cutting=(Cutting(50.0, 25.0, 0.2),))
    assert not is_unnamed(plain, "C45")  # a machine without rows by grade has nothing to say


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize(("grade", "v"), [("S235JR", 30), ("S355J2", 25), ("S690QL", 15)])
def test_the_program_says_the_speed(name: str, grade: str, v: float) -> None:
    text = post((part(hole(500, 150, 22), grade=grade),), load(name)).text
    assert f"M03 K{1000 * v / (pi * 22):.0f}\n" in text


def test_the_feed_of_the_saw_stands_at_the_cut() -> None:
    for name, feed in (("beamline", "41.667"), ("beamline-pusher", "1.333")):
        lines = post((part(hole(500)),), load(name)).text.splitlines()
        cuts = [i for i, line in enumerate(lines) if " M42 " in line]
        assert cuts
        assert all(lines[i].endswith(f" F{feed}") for i in cuts)
        assert all(" G00 X" in lines[i - 1] and " F" not in lines[i - 1] for i in cuts)


def test_a_tool_by_hand_stops_the_program() -> None:
    seven = part(*(hole(400 + 100 * i, 150, 12 + i) for i in range(7)))
    machine = load("beamline")
    lines = post((seven,), machine).text.splitlines()
    stops = [i for i, line in enumerate(lines) if " M06 " in line]
    assert [lines[i].split(" ", 1)[1] for i in stops] == ["M06 K2 L17", "M06 K2 L18"]
    assert [lines[i - 1] for i in stops] == [
        "(web station 1: drill 17 for drill 12)", "(web station 1: drill 18 for drill 17)"
    ]  # fmt: skip
    assert all(" M40 K2 L" in lines[i + 1] for i in stops)
    plain = replace(machine, words=replace(machine.words, change=("M00",)))
    assert post((seven,), plain).text.count(" M00\n") == 2


def test_a_program_without_speeds_says_nothing_of_them() -> None:
    odd = part(hole(500, diameter=45), grade="1.4301"), part(hole(500), grade="C45")
    for made in odd:
        codes = [said.code for said in post((made,), load("beamline-annex")).remarks]
        assert not {"plan-grade", "plan-cutting-speed"} & set(codes)
