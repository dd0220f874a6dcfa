"""Solids in a page: unpacked again they are the pieces, whole holes, within the room there is."""

import base64
import json
import zlib
from functools import cache
from itertools import accumulate
from typing import Any

import numpy as np
import pytest

from beamcam.errors import Source
from beamcam.machine import load
from beamcam.model.part import Hole, Part, Profile
from beamcam.pictures import ReadProgram
from beamcam.pictures.program import bar_made, table_made
from beamcam.pipeline import post, read_file
from beamcam.setup_sheet import solid_data
from beamcam.setup_sheet.content import SheetSources, content_of
from beamcam.setup_sheet.page import setup_page
from beamcam.setup_sheet.solid_data import CHORDS, LIMIT, Solids, solids_of
from tests.conftest import SAMPLES

HERE = Source("x.nc1", 1)
CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)


@cache
def program_of(*parts: Part, machine: str = "beamline-annex") -> ReadProgram:
    used = load(machine)
    return ReadProgram(post(parts, used).text.encode(), used, f"job{used.suffix}", "", parts)


def drilled(count: int) -> Part:
    """A channel with rows of holes in its web."""
    holes = tuple(Hole("v", 60.0 + 35.0 * (k // 3), 60.0 + 40.0 * (k % 3), 18.0, HERE)
                  for k in range(count))  # fmt: skip
    return Part("D1", CHANNEL, 120.0 + 35.0 * (count // 3), HERE, features=holes)


def unpacked(piece: dict[str, Any]) -> tuple[Any, Any]:
    """Points in their grid and corners of triangles, read byte by byte."""
    data, at = zlib.decompress(base64.b64decode(piece["data"])), 0
    columns = []
    for count, wide in ((piece["points"], 2),) * 3 + ((3 * piece["triangles"], piece["wide"]),):
        steps = [sum(data[at + plane * count + k] << 8 * plane for plane in range(wide))
                 for k in range(count)]  # fmt: skip
        columns.append(np.array(list(accumulate(steps)), dtype=np.int64) % 256**wide)
        at += wide * count
    assert at == len(data)
    return np.stack(columns[:3], axis=1), columns[3].reshape(-1, 3)


def holes_in(solids: Solids) -> set[int]:
    return {line for piece in solids.pieces for line, count in piece["lines"] if line and count}


def test_unpacked_it_is_the_piece() -> None:
    part = read_file(str(SAMPLES / "dstv" / "tie.nc1")).parts[0]
    program = program_of(part)
    made = bar_made(program)
    solids = solids_of(program, made)
    kinds = [(piece["kind"], piece["mark"]) for piece in solids.pieces]
    assert ("part", "T1") in kinds
    piece = solids.pieces[kinds.index(("part", "T1"))]
    points, corners = unpacked(piece)
    low, size = np.array(piece["box"][:3]), np.array(piece["box"][3:])
    assert size == pytest.approx([part.length, 200.0, 75.0], abs=0.2)
    assert len(points) == piece["points"] > corners.max()
    assert sum(count for _, count in piece["lines"]) == len(corners)
    a, b, c = (low + points / 65535 * size)[corners].transpose(1, 0, 2)
    steel = float(np.sum(a * np.cross(b, c)) / 6)
    holes = sum(np.pi * h.diameter**2 / 4 * 8.5 for h in part.holes)
    bare = part.length * (2 * 75.0 * 11.5 + 177.0 * 8.5) - holes
    assert bare < steel < 1.03 * bare


@pytest.mark.parametrize(("count", "is_coarse"), [(30, False), (700, True)])
def test_circles_grow_coarser_and_no_hole_is_dropped(count: int, is_coarse: bool) -> None:
    program = program_of(drilled(count))
    made = bar_made(program)
    solids = solids_of(program, made)
    assert solids.without == ""
    assert len(json.dumps(solids.pieces)) <= LIMIT
    assert (solids.chord > CHORDS[0]) is is_coarse
    assert {b.line for b in made.made.bores} <= holes_in(solids)


def test_what_is_too_large_is_not_drawn_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    program = program_of(drilled(30))
    made = bar_made(program)
    monkeypatch.setattr(solid_data, "LIMIT", 1000)
    solids = solids_of(program, made)
    assert solids.pieces == ()
    assert solids.without.startswith("it would take ")
    monkeypatch.setattr(solid_data, "MAX_WORK", 10)
    assert solids_of(program, made).without == f"{len(made.made.order)} cuts and moves are too many"


def test_a_page_says_why_it_has_no_solid() -> None:
    program = program_of(drilled(30))
    alone = ReadProgram(program.data, program.machine, program.name)
    page = setup_page(content_of(SheetSources(alone)))
    assert "<p>No solid: found a width of 0 mm" in page
    assert 'id="solid"' not in page
    given = setup_page(content_of(SheetSources(program)))
    assert 'id="solid"' in given
    assert "every hole is there" not in given


def test_a_page_says_that_its_circles_are_coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solid_data, "LIMIT", LIMIT // 10)
    program = program_of(drilled(70))
    page = setup_page(content_of(SheetSources(program)))
    assert "to keep the page small; every hole is there" in page
    (data,) = [line for line in page.split("<script") if 'id="solid"' in line]
    assert len(data) < 30_000


@pytest.mark.parametrize(
    ("sample", "machine", "thickness"),
    [("dstv/gusset.nc1", "plate-linuxcnc", 6.0), ("json/curves.json", "laser-grbl", 3.0),
     ("json/shield.json", "table-simotion", 8.0)],
)  # fmt: skip
def test_a_table_s_pieces_are_as_thick_as_its_sheet(
    sample: str, machine: str, thickness: float
) -> None:
    part = read_file(str(SAMPLES / sample)).parts[0]
    program = program_of(part, machine=machine)
    solids = solids_of(program, table_made(program))
    (piece,) = solids.pieces
    assert piece["box"][5] == thickness
    assert piece["box"][3:5] == pytest.approx(
        (20.99, 31.99) if "shield" in sample else (part.length, part.profile.height), abs=0.1
    )


def test_nothing_that_comes_free_or_no_thickness_is_said() -> None:
    part = read_file(str(SAMPLES / "json" / "curves.json")).parts[0]
    program = program_of(part, machine="laser-grbl")
    alone = ReadProgram(program.data, program.machine, program.name)
    assert solids_of(alone, table_made(alone)).without == "the thickness of the sheet is not known"
    text = "G21 G17 G90 G91.1 G40 G94\nG64 P0.01\nG0 X0 Y0\nM3 $0 S1\nG1 X10 Y0 F1000\nM5 $0\nM2\n"
    plate = load("plate-linuxcnc")
    line = ReadProgram(text.encode(), plate, "line.ngc",
                       parts=read_file(str(SAMPLES / "dstv" / "gusset.nc1")).parts)  # fmt: skip
    found = solids_of(line, table_made(line))
    assert (found.pieces, found.without) == ((), "nothing comes free of the sheet")
