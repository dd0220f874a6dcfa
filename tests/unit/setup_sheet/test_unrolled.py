"""Setup sheets of copers: the torch over the surface, unrolled, and a row for each cut."""

import re
from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from beamcam.machine import load
from beamcam.model.request import Request
from beamcam.pictures import ReadProgram
from beamcam.pipeline import post, read_back, read_file
from beamcam.setup_sheet.content import SheetContent, SheetSources, content_of
from beamcam.setup_sheet.page import setup_page
from beamcam.setup_sheet.paper import setup_pdf
from beamcam.setup_sheet.solid_data import coper_meshes, solids_of
from beamcam.solid.part_solid import part_solid
from tests.conftest import SAMPLES

COPING = SAMPLES / "coping"


@cache
def sheet(name: str, machine: str) -> tuple[SheetContent, str]:
    parts = read_file(str(next(p for p in COPING.iterdir() if p.stem == name))).parts
    made, used = post(parts, load(machine)), load(machine)
    program = ReadProgram(made.text.encode(), used, f"{name}.ngc", parts=tuple(parts))
    return content_of(SheetSources(program, made.plan, made.remarks)), made.text


@pytest.mark.parametrize("name", ["coped", "trimmer", "cleat"])
def test_each_cut_has_its_face_and_its_length(name: str) -> None:
    """By hand from the words: A says the face, and moves with the torch on the way."""
    content, text = sheet(name, "coper-linuxcnc")
    here = {"X": np.nan, "Y": np.nan, "Z": np.nan, "A": np.nan}
    wanted: list[tuple[str, float]] = []
    on = False
    for line in text.split("\n"):
        words = {} if line.startswith("(") else dict(re.findall(r"\b([XYZAM])(-?[\d.]+)", line))
        before = dict(here)
        here |= {axis: float(v) for axis, v in words.items() if axis in here}
        if words.get("M") == "3":
            on = True
            wanted.append(({-90.0: "o", 0.0: "v", 90.0: "u"}[here["A"]], 0.0))
        elif words.get("M") == "5":
            on = False
        elif on and not line.startswith("("):
            face, length = wanted[-1]
            across = "Y" if face == "v" else "Z"
            step = np.hypot(here["X"] - before["X"], here[across] - before[across])
            wanted[-1] = face, length + float(step)
    found = [(op.what.removeprefix("cut on face "), op.length) for op in content.operations]
    assert [face for face, _ in found] == [face for face, _ in wanted]
    assert [length for _, length in found] == pytest.approx([long for _, long in wanted], abs=0.1)
    assert content.seconds == pytest.approx(sum(row.seconds for row in content.totals[:-1]))


def test_faces_lie_beside_each_other_as_a_bar_unfolds() -> None:
    content, _ = sheet("coped", "coper-linuxcnc")
    made = content.made
    names = [axis.name for axis in content.trace.axes]
    assert names[:2] == ["carriage", "round the bar"]
    height = 300.0  # of an IPE300
    for (first, last, _), op in zip(made.strokes, content.operations, strict=True):  # type: ignore[union-attr]
        at = content.trace.positions[first : last + 1, 1]
        low, high = {"o": (height, 999.0), "v": (0.0, height), "u": (-999.0, 0.0)}[op.what[-1]]
        assert low - 5.0 < at.min() <= at.max() < high + 5.0


def test_a_tube_is_as_wide_as_it_is_round() -> None:
    content, _ = sheet("stub", "tube-linuxcnc")
    first, last, _ = content.made.strokes[-1]  # type: ignore[union-attr]  # the far end, all round
    way = content.trace.positions[first : last + 1, 1]
    assert way.max() - way.min() == pytest.approx(np.pi * 88.9, abs=0.1)


def test_a_rectangular_tube_has_the_face_of_each_cut_and_goes_once_round() -> None:
    content, _ = sheet("leg", "tube-linuxcnc")
    assert [op.what.removeprefix("cut on face ") for op in content.operations] == [
        "v", "h", "u", "v", "u", "u", "u"
    ]  # fmt: skip
    first, last, _ = content.made.strokes[-1]  # type: ignore[union-attr]  # the far end, all round
    way = content.trace.positions[first : last + 1, 1]
    assert way.max() - way.min() == pytest.approx(2 * (100 + 60) + 20 * np.pi, abs=0.1)


SOLIDS = [
    ("trimmer", "coper-linuxcnc", "vouh"), ("hanger", "coper-linuxcnc", "vouh"),
    ("header-rest", "coper-linuxcnc", "vouh"), ("leg", "tube-linuxcnc", "vouh"),
    ("hip", "tube-linuxcnc", "vouh"), ("trimmer", "tube-linuxcnc", "vouh"),
    ("hanger", "tube-linuxcnc", "vouh"), ("joist", "coper-linuxcnc", "vouh"),
    ("joist", "tube-linuxcnc", "vouh"), ("lintel-rest", "tube-linuxcnc", "vouh"),
    ("mast-rest", "tube-linuxcnc", "vouh"), ("strut-rest", "tube-linuxcnc", "vouh"),
    ("stub", "tube-linuxcnc", "v"), ("stub", "tube-surface", "v"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "machine", "faces"), SOLIDS)
def test_the_solid_is_the_part_and_its_cuts_have_their_lines(
    name: str, machine: str, faces: str
) -> None:
    """As large as the part, its volume that of the part but for rounds and wedges."""
    content, text = sheet(name, machine)
    (part,) = content.program.parts
    solids = solids_of(content.program, content.made)
    (piece,) = solids.pieces
    assert (solids.faces, piece["kind"], piece["mark"]) == (faces, "part", part.mark)
    across = [part.profile.height, part.profile.width] if name != "stub" else [88.9, 88.9]
    assert piece["box"] == pytest.approx([0.0, 0.0, 0.0, part.length, *across], abs=0.1)
    (mesh,) = coper_meshes(text, content.program.machine, part, "p", 0.05)
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    volume = float((np.cross(a, b) * c).sum() / 6.0)
    whole = replace(part, features=(*part.features, *(part.made or ())), made=None)
    if name != "stub":  # a plate that is a pipe
        assert volume == pytest.approx(part_solid(whole).volume(), rel=0.004)
    starts = {k for k, line in enumerate(text.splitlines(), 1) if line.startswith("M3 ")}
    lines = {line for line, _ in piece["lines"]}
    assert lines - {0} == starts  # each cut leaves a surface of the part
    assert sum(count for _, count in piece["lines"]) == piece["triangles"]


def test_a_program_that_parts_nothing_has_no_solid_and_says_so() -> None:
    content, text = sheet("stub", "tube-linuxcnc")
    end = text.rindex("(far end")
    data = (text[:end] + "M30\n%\n").encode()
    program = replace(content.program, data=data)
    solids = solids_of(program, content.made)
    assert (solids.pieces, solids.without) == ((), "nothing comes free of the bar")


def test_page_and_paper_are_made() -> None:
    content, text = sheet("trimmer", "coper-linuxcnc")
    page = setup_page(content)
    assert "No solid" not in page
    assert page == setup_page(content)
    assert setup_pdf(content).startswith(b"%PDF")
    assert len(content.operations) == text.count("M3 ")


def test_corners_that_are_cut_round_are_in_the_verdict() -> None:
    for name, is_rounded in (("coped", True), ("trimmer", False), ("cleat", True)):
        content, _ = sheet(name, "coper-linuxcnc")
        told = any(said.code == "plan-coping-rounded" for said in content.messages)
        assert told == is_rounded, name
        assert ("but for corners that are cut round." in setup_page(content)) == is_rounded
        assert ("exactly these parts" in setup_page(content)) == (not is_rounded)


def test_a_program_and_its_part_alone_claim_no_more_than_is_known() -> None:
    for name, machine in (("leg", "tube-linuxcnc"), ("trimmer", "coper-linuxcnc")):
        content, _ = sheet(name, machine)
        found = read_back(content.program.text, Request(content.program.parts, load(machine)))
        page = setup_page(content_of(SheetSources(content.program, read_back=found)))
        assert "exactly these parts" not in page
        assert ("manual work and corners that are cut round." in page) == (name == "leg")
