"""Plain holes told at a glance, and everything that asks for a closer look."""

from math import nan

import pytest
from msgspec.structs import replace

from beamcam.model.part import Hole, Part, Slot
from beamcam.verify import verify
from beamcam.verify.made import Bore
from beamcam.verify.plain import plain_wants, plainly_made
from beamcam.verify.rack import Rack
from tests.unit.verify.programs import BEAM, FLANGE_HOLES, PART, PROGRAM, WEB_HOLE, hole, part

BEGIN = 798.56
assert BEAM.drill is not None
DRILL = BEAM.drill


def bore(made: Hole, line: int, x: float = 0.0, y: float = 0.0) -> Bore:
    """A bore for a hole, off by x and y."""
    at = BEGIN + made.x + x, made.y + y
    return Bore(line, made.face, *at, made.diameter, 20.0, 2, 100.0, 40.0)


def told(made: Part, *bores: Bore) -> list[tuple[int, Bore]] | None:
    """What a glance tells where every tool, depth and feed is known to be right."""
    rack = Rack(BEAM, DRILL)
    fine = rack.fine(made.profile, made.grade)
    for h in made.holes:
        fine[plain_wants(h)] = [b[4:] for b in bores]
    return plainly_made(bores, [made], [BEGIN], rack, 0.001)


A, B, C = hole("v", 300.0, 80.0, 22.0), hole("v", 300.0, 110.0, 22.0), hole("o", 300.0, 80.0, 22.0)


def test_holes_and_bores_in_any_order() -> None:
    bores = [bore(C, 9), bore(A, 19, 0.0009), bore(B, 29, 0.0009, -0.0007)]
    assert told(part(A, B, C), *bores) == [(0, bores[0]), (0, bores[1]), (0, bores[2])]
    assert told(part(B, C, A), *reversed(bores)) == [(0, bores[0]), (0, bores[1]), (0, bores[2])]
    assert told(part()) == []


@pytest.mark.parametrize(("made", "bores"), [
    ((A, B), [bore(A, 9)]),
    ((A,), [bore(A, 9), bore(B, 19)]),
    ((A, B), [bore(A, 9), bore(C, 19)]),
    ((A, B), [bore(A, 9), bore(B, 19, 0.0021)]),
    ((A, B), [bore(A, 9), bore(B, 19, 0.0, 0.0021)]),
    ((A, B), [bore(A, 9), bore(B, 19, nan)]),
    ((A, A), [bore(A, 9), bore(A, 19)]),  # written twice, and to be drilled once
    ((A, replace(A, y=80.15)), [bore(A, 9), bore(A, 19, 0.0, 0.15)]),
    ((A, replace(A, x=300.15)), [bore(A, 9), bore(A, 19, 0.15)]),
    ((A, replace(B, x=300.0001)), [bore(A, 9), bore(B, 19)]),  # whose order rounding decides
    ((C, replace(C, face="u", diameter=21.9)), [bore(C, 9), bore(replace(C, face="u"), 9)]),
    ((A, Slot("v", 900.0, 80.0, 22.0, 40.0, 0.0, 0.0, A.source)), [bore(A, 9), bore(B, 19)]),
])  # fmt: skip
def test_a_closer_look(made: tuple[Hole, ...], bores: list[Bore]) -> None:
    assert told(part(*made), *bores) is None


def test_what_was_never_judged() -> None:
    assert plainly_made([bore(A, 9)], [part(A)], [BEGIN], Rack(BEAM, DRILL), 0.001) is None


def test_each_part_by_its_own_grade() -> None:
    parts = [part(A), replace(part(B), grade="S355")]
    bores = [bore(A, 9), bore(B, 19, 2000.0)]
    begins = [BEGIN, BEGIN + 2000.0]
    rack = Rack(BEAM, DRILL)
    rack.fine(parts[0].profile, "")[plain_wants(A)] = [b[4:] for b in bores]
    assert plainly_made(bores, parts, begins, rack, 0.001) is None
    rack.fine(parts[0].profile, "S355")[plain_wants(B)] = [bores[1][4:]]
    assert plainly_made(bores, parts, begins, rack, 0.001) == [(0, bores[0]), (1, bores[1])]


def test_a_hole_written_twice_is_not_drilled_twice() -> None:
    lines = PROGRAM.split("\n")
    stroke = lines[6:15]
    assert stroke[0] == "N6 M40 K2 L22"
    text = "\n".join([*lines[:15], *stroke, *lines[15:]])
    twice = part(WEB_HOLE, WEB_HOLE, *FLANGE_HOLES)
    assert verify(PROGRAM, [PART], BEAM) == verify(PROGRAM, [twice], BEAM) == ()
    assert [said.code for said in verify(text, [twice], BEAM)] == ["verify-hole-extra"]
