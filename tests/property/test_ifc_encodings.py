"""What goes into a model comes back, whichever way an exporter wrote it."""

from functools import cache
from random import Random
from typing import Any

import pytest

from beamcam.model.part import Hole, Part, Slot
from beamcam.readers import dstv
from beamcam.readers.ifc import read
from beamcam.writers.dstv import write
from tests.conftest import sampled
from tests.property.ifc_builder import ENCODINGS, Member, expected_holes, model_text, random_member

EACH = 30  #: members of a model: 9 encodings x 2 models x 30 = 540 members

FACETED = ("brep", "mesh")
#: Turns of the section onto itself: (x reversed, Y reversed, Z reversed).
TURNS = {
    "I": ((0, 0, 0), (1, 0, 1), (1, 1, 0), (0, 1, 1)),
    "M": ((0, 0, 0), (1, 0, 1), (1, 1, 0), (0, 1, 1)),
    "B": ((0, 0, 0), (1, 0, 1), (1, 1, 0), (0, 1, 1)),
    "U": ((0, 0, 0), (1, 1, 0)),
    "T": ((0, 0, 0), (1, 1, 0)),
    "L": ((0, 0, 0),),
}

#: What a mirror leaves of a section whose x still runs the way of its extrusion; an angle's cannot.
MIRRORS = {
    "I": (0, 0, 1), "M": (0, 0, 1), "B": (0, 0, 1), "U": (0, 1, 0), "T": (0, 1, 0), "L": (1, 0, 0)
}  # fmt: skip


@cache
def model(encoding: str, seed: int) -> tuple[list[Member], list[Part], Any]:
    random = Random(f"{encoding}{seed}")
    members = [random_member(random, encoding) for _ in range(EACH)]
    text, guids = model_text(members, encoding, random)
    reading = read(text.encode(), "model.ifc")
    by_guid = {part.guid: part for part in reading.parts}
    assert not reading.refused, "\n".join(map(str, reading.diagnostics))
    assert list(by_guid) == guids
    return members, [by_guid[g] for g in guids], reading


def found_holes(part: Part) -> list[tuple[Any, ...]]:
    out = []
    for f in part.features:
        if isinstance(f, Hole):
            out.append((f.face, f.x, f.y, f.diameter, 0.0, False))
        elif isinstance(f, Slot):
            out.append((f.face, f.x, f.y, f.diameter, f.length, abs(f.angle - 90) < 1))
    return out


def turned(
    part: Part, holes: list[tuple[Any, ...]], by: tuple[int, int, int]
) -> list[tuple[Any, ...]]:
    """Holes of a part that is laid down another way."""
    # The stem of a tee is on o whichever way up it lies.
    swaps = {"o": "u", "u": "o"} if by[1] and part.profile.code != "T" else {}
    if by[2] and part.profile.code == "M":
        swaps |= {"v": "h", "h": "v"}
    out = []
    for face, x, q, *rest in holes:
        flip = by[1] if face in ("v", "h") else by[2]
        width = part.profile.face_width(face)
        out.append(
            (
                swaps.get(face, face),
                part.length - x if by[0] else x,
                width - q if flip else q,
                *rest,
            )
        )
    return out


def ends_turned(part: Part, by: tuple[int, int, int]) -> tuple[tuple[float, float], ...]:
    c = part.cuts
    ends = [[c.web_start, c.flange_start], [c.web_end, c.flange_end]]
    if by[0]:
        ends = [[-w, -f] for w, f in reversed(ends)]
    if by[1]:
        ends = [[-w, f] for w, f in ends]
    if by[2]:
        ends = [[w, -f] for w, f in ends]
    return tuple((w, f) for w, f in ends)


def alike(a: list[tuple[Any, ...]], b: list[tuple[Any, ...]], slack: float) -> bool:
    if len(a) != len(b):
        return False
    rest = list(b)
    for face, x, q, d, slot, across in a:
        match = next(
            (
                o
                for o in rest
                if o[0] == face
                and abs(o[1] - x) < slack
                and abs(o[2] - q) < slack
                and abs(o[3] - d) < slack
                and abs(o[4] - slot) < slack
                and o[5] == across
            ),
            None,
        )
        if match is None:
            return False
        rest.remove(match)
    return True


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize("encoding", sampled(ENCODINGS, 3))
def test_members_come_back_as_they_went_in(encoding: str, seed: int) -> None:
    members, parts, _ = model(encoding, seed)
    mirrored = encoding == "mirrored"
    slack = 0.03 if encoding in FACETED else 0.002
    for member, part in zip(members, parts, strict=True):
        profile = part.profile
        assert profile.code == member.code
        sizes = (profile.height, profile.width, profile.flange_thickness, profile.web_thickness)
        expected = member.sizes
        if member.code == "B":
            expected = (member.sizes[0], 0.0, 0.0, member.sizes[1])
        assert sizes == pytest.approx(expected, abs=0.01)
        assert part.length == pytest.approx(member.length, abs=0.01)
        assert part.mark == member.mark
        wanted, ends = expected_holes(member), member.ends
        turns = TURNS[member.code] if encoding in FACETED else TURNS[member.code][:1]
        if mirrored:
            turns = (MIRRORS[member.code],)
        fits = [
            alike(wanted, turned(part, found_holes(part), by), slack)
            and all(
                abs(a - b) < 0.02
                for one, other in zip(ends_turned(part, by), ends, strict=True)
                for a, b in zip(one, other, strict=True)
            )
            for by in turns
        ]
        assert any(fits), (member, found_holes(part), part.cuts)


@pytest.mark.parametrize("encoding", sampled(["csg", "brep"], 2))
def test_dstv_keeps_the_part(encoding: str) -> None:
    _, parts, _ = model(encoding, 1)
    for part in parts:
        (again,) = dstv.read(write(part).encode(), "part.nc1").parts
        assert again.profile.code == part.profile.code
        assert again.length == pytest.approx(part.length, abs=1e-4)
        assert found_holes(again) == [
            (face, *(pytest.approx(v, abs=1e-4) for v in row), across)
            for face, *row, across in found_holes(part)
        ]
        for name in ("web_start", "web_end", "flange_start", "flange_end"):
            assert getattr(again.cuts, name) == pytest.approx(getattr(part.cuts, name), abs=1e-4)
