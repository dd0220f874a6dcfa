"""Differences by meaning, in sentences."""

import pytest
from msgspec.structs import replace

from beamcam.checks.bars import run
from beamcam.comparison.bars import diff_programs
from beamcam.comparison.parts import diff_parts
from beamcam.errors import Source
from beamcam.geometry.curves import Line
from beamcam.model.part import Contour, Part, Slot, TextMark
from tests.unit.checks.programs import BEAM, PART, PROGRAM, edit, hole


def programs(a: str, b: str) -> list[str]:
    made = [run(text, BEAM).made for text in (a, b)]
    return [d.text for d in diff_programs(made[0], made[1], BEAM.format.resolution)]


def parts(a: Part, b: Part) -> list[str]:
    return [d.text for d in diff_parts((a,), (b,))]


def move(dx: float, dy: float = 0.0) -> str:
    """The program with its web hole moved."""
    text = PROGRAM.replace("X1098.56 Y20", f"X{1098.56 + dx:.3f} Y{20 - dy:.3f}")
    assert text != PROGRAM
    return text


def test_a_program_is_itself_however_it_is_written() -> None:
    other = PROGRAM.replace("N", "N0").replace(" G00", " G0").replace("\n", " (seen)\n")
    other = other.replace("% P1 (seen)", "% P9").replace("% (seen)", "%")
    assert programs(PROGRAM, other) == []


@pytest.mark.parametrize(("text", "said"), [
    (move(2), ["hole v at x 1098.6 moved by 2.0 mm"]),
    (move(0, 1.5), ["hole v at x 1098.6 moved by 1.5 mm across"]),
    (move(3, 4), ["hole v at x 1098.6 moved by 5.0 mm in x and y"]),
    (move(0.0004), []),  # the output cannot tell that
    (edit(("K2 L22", "K2 L18"), text=move(2)),
     ["hole v at x 1098.6 moved by 2.0 mm, drill 22 to 18"]),
    (edit(("Z61.409", "Z60")), ["hole v at x 1098.6 stroke 61.409 to 60"]),
    (edit(("N9 M03 K362", "N9 M03 K400")), ["hole v at x 1098.6 speed 362 to 400"]),
    (edit(("Z42.2", "Z44")), ["hole v at x 1098.6 feed from 42.2 to from 44"]),
    (edit(("F1.507", "F1.5")), ["hole v at x 1098.6 feed 90.42 to 90 mm/min"]),
    (edit(("M40 K13", "M40 K1")), ["hole o at x 1498.6 spindle 13 to 1",
                                   "hole u at x 1498.6 only in A"]),
    (edit(("N24 M42 K0", "N24 M42 K5")), ["cut at x 2022.0 angle 0 to 5"]),
    (edit(("X2022.02", "X2032.02")), ["cut at x 2022.0 moved by 10.0 mm"]),
    (edit(("N24 M42 K0 F41.667\n", "")), ["cut at x 2022.0 only in A"]),
    (edit(("M44 K100", "M44 K120")), ["width 100 to 120"]),
    (edit(("N15 M40", "N15 M42 K3 F41.667\nM40")), ["cut at x 1098.6 only in B"]),
])  # fmt: skip
def test_what_is_said_of_programs(text: str, said: list[str]) -> None:
    assert programs(PROGRAM, text) == said


def test_the_same_work_in_another_order() -> None:
    a = PROGRAM.replace("M42 K0 F41.667\nN6", "M42 K0 F41.667\nM42 K5 F41.667\nN6")
    b = PROGRAM.replace("M42 K0 F41.667\nN6", "M42 K5 F41.667\nM42 K0 F41.667\nN6")
    assert programs(a, b) == ["the same cuts and holes in another order"]


def test_holes_that_share_an_x_are_told_apart_by_y() -> None:
    start = PROGRAM.index("N6 M40")
    cycle = PROGRAM[start : PROGRAM.index("N15")]
    two = PROGRAM.replace("N15 M40", cycle.replace("Y20", "Y-50") + "N15 M40")
    assert programs(two, two.replace("Y-50", "Y-53")) == [
        "hole v at x 1098.6, y 150.0 moved by 3.0 mm across"
    ]


def test_parts_by_meaning() -> None:
    elsewhere = tuple(replace(f, source=Source("other", 9)) for f in PART.features[::-1])  # type: ignore[call-arg]
    assert parts(PART, replace(PART, features=elsewhere, source=Source("x"))) == []


SLOT = Slot("v", 900.0, 100.0, 18.0, 30.0, 0.0, 0.0, Source("a"))
TEXT = TextMark("v", 100.0, 100.0, 0.0, 10.0, "P1", Source("a"))


def square(size: float, at: float = 500.0, first: int = 0) -> Contour:
    corners = [(at, 20.0), (at + size, 20.0), (at + size, 20.0 + size), (at, 20.0 + size)]
    corners = corners[first:] + corners[:first]
    lines = tuple(Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    return Contour("v", "inner", lines, Source("a"))


def part(*features: object, **changes: object) -> Part:
    return replace(PART, features=features, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(("a", "b", "said"), [
    (part(hole("v", 1200, 80, 18)), part(hole("v", 1202, 80, 22)),
     ["hole v at x 1200.0 moved by 2.0 mm, diameter 18 to 22"]),
    (part(hole("v", 1200, 80, 18)), part(hole("v", 1200, 80, 18, 6)),
     ["hole v at x 1200.0 depth none to 6, kind through to blind"]),
    (part(hole("v", 1200, 80, 18)), part(hole("o", 1200, 80, 18)),
     ["hole o at x 1200.0 only in B", "hole v at x 1200.0 only in A"]),
    (part(hole("v", 100, 80, 18)), part(hole("v", 900, 80, 18)),
     ["hole v at x 100.0 only in A", "hole v at x 900.0 only in B"]),
    (part(), part(length=2100.0, grade="S355"), ["length 2000 to 2100", "grade none to S355"]),
    (part(SLOT), part(replace(SLOT, length=40.0)), ["slot v at x 900.0 length 30 to 40"]),
    (part(TEXT), part(replace(TEXT, text="P2")), ["text 'P1' v at x 100.0 text P1 to P2"]),
    (part(square(40)), part(square(40, first=2)), []),
    (part(square(40)), part(square(40, 505)), ["cut-out v at x 520.0 moved by 5.0 mm"]),
    (part(square(40)), part(square(44)), ["cut-out v at x 520.0 moved by 2.828 mm in x and y, "
                                          "another course"]),
])  # fmt: skip
def test_what_is_said_of_parts(a: Part, b: Part, said: list[str]) -> None:
    assert parts(a, b) == said


def test_a_part_more() -> None:
    assert [d.text for d in diff_parts((PART,), (PART, PART))] == ["part P1 only in B"]
    assert [d.text for d in diff_parts((PART, PART), (PART,))] == ["part P1 only in A"]
