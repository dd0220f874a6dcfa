"""Two programs of copers over each other: what is the same, moved, wider, gone and new."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from beamcam.errors import VerifyError
from beamcam.machine import Machine, load
from beamcam.model.part import Feature, Hole, Part, Profile, Slot
from beamcam.pictures.comparison import compared_programs
from beamcam.pictures.formats import to_svg
from beamcam.pictures.overlay import Overlay
from beamcam.pictures.program import ReadProgram
from tests.runs import call
from tests.unit.coping.samples import AT, COPER, IPE300, UPN200, part_of, program_of
from tests.unit.pictures.drawings import Drawing

TUBE = load("tube-linuxcnc")
CHS = Profile("RO", "CHS168.3*8", 168.3, 168.3, 8.0, 8.0)
ENDS = 6  #: cuts of two square ends, on three faces
WEB, WIDE = Hole("v", 200.0, 150.0, 22.0, AT), Hole("v", 450.0, 150.0, 60.0, AT)
FLANGE = Hole("o", 300.0, 30.0, 18.0, AT)
SLOT = Slot("u", 300.0, 30.0, 18.0, 40.0, 0.0, 0.0, AT)


def read(part: Part, machine: Machine = COPER) -> ReadProgram:
    return ReadProgram(program_of(part, machine).encode(), machine, f"{part.mark}.ngc")


def over(a: Part, b: Part, machine: Machine = COPER) -> Overlay:
    return compared_programs(read(a, machine), read(b, machine))


def counts(found: Overlay) -> tuple[int, int, int, int]:
    return found.same, found.changed, found.gone, found.new


def called(found: Overlay) -> list[str]:
    drawing = Drawing(to_svg(found.scene))
    return sorted("".join(e.itertext()) for e in drawing.all("callout"))


def test_a_program_is_the_same_as_itself() -> None:
    part = part_of(WEB, FLANGE)
    found = over(part, part)
    assert counts(found) == (ENDS + 2, 0, 0, 0)
    drawing = Drawing(to_svg(found.scene))
    assert drawing.count("gone", "trail-of") == drawing.count("new", "trail-of") == 0
    assert drawing.count("same", "trail-of") == ENDS + 2
    assert drawing.count("same", "stock-outline") == 3
    assert called(found) == []


def test_what_differs_is_marked_on_its_face_and_called_by_its_size() -> None:
    """Sizes are those of the openings: the paths lie half a kerf within them."""
    moved, wider = replace(WEB, x=215.0), replace(WIDE, diameter=80.0)
    found = over(part_of(WEB, WIDE, FLANGE), part_of(moved, wider, SLOT))
    assert counts(found) == (ENDS, 2, 1, 1)
    assert called(found) == ["A Ø60, B Ø80", "only A: Ø18", "only B: 58 x 18", "Ø22"]
    drawing = Drawing(to_svg(found.scene))
    assert drawing.count("moved", "arrow") == 1
    assert drawing.count("gone", "trail-of") == drawing.count("new", "trail-of") == 3
    assert {"200", "215", "450", "300"} <= set(drawing.texts)  # where things differ
    assert "6 the same, 2 changed, 1 gone, 1 new" in drawing.texts


def test_a_longer_part_of_another_section_has_another_outline() -> None:
    found = over(part_of(), part_of(length=700.0))
    drawing = Drawing(to_svg(found.scene))
    assert drawing.count("gone", "stock-outline") == drawing.count("new", "stock-outline") == 3
    assert found.same == 3  # the near end
    other = over(part_of(profile=IPE300), part_of(profile=UPN200))
    assert other.same == 0


def test_another_feed_is_a_change_without_an_arrow() -> None:
    part = part_of(Hole("v", 300.0, 150.0, 30.0, AT))
    assert COPER.coper is not None
    rows = tuple(
        replace(row, feed_mm_min=2999.0) if row.feed_mm_min == 3000.0 else row
        for row in COPER.coper.rows
    )
    slower = replace(COPER, coper=replace(COPER.coper, rows=rows))
    found = compared_programs(read(part), read(part, slower))
    assert (found.changed, found.gone, found.new) == (3, 0, 0)  # the hole and the web's two ends
    assert Drawing(to_svg(found.scene)).count("moved", "arrow") == 0


def tube(*features: Feature) -> Part:
    return Part("T1", CHS, 500.0, AT, features=features, grade="S235JR")


def test_a_tube_is_unrolled() -> None:
    """A hole through its axis is called by the drill's diameter."""
    hole = Hole("v", 200.0, 100.0, 60.0, AT)
    found = over(tube(hole), tube(replace(hole, x=230.0)), TUBE)
    assert counts(found) == (2, 1, 0, 0)
    assert called(found) == ["Ø60"]
    drawing = Drawing(to_svg(found.scene))
    assert any("unrolled" in text for text in drawing.texts)
    assert drawing.count("moved", "arrow") == 1


def test_a_program_that_is_wrong_by_itself_is_not_drawn() -> None:
    good = read(part_of(WEB))
    wrong = replace(good, data=good.data.replace(b"M5", b"M3 S1", 1))
    with pytest.raises(VerifyError, match="verify-coping-torch"):
        compared_programs(good, wrong)


@pytest.mark.parametrize("suffix", [".svg", ".html", ".pdf"])
def test_the_command_draws_them(suffix: str, tmp_path: Path) -> None:
    names = []
    for name, part in (("a", part_of(WEB)), ("b", part_of(replace(WEB, x=215.0)))):
        names.append(str(tmp_path / f"{name}.ngc"))
        Path(names[-1]).write_text(program_of(part))
    out = tmp_path / f"d{suffix}"
    done = call("diff", *names, "-o", out)
    assert done.exit_code == 1  # they differ
    assert out.stat().st_size > 1000
    if suffix == ".html":
        assert "statements: X +15.0000" in out.read_text()  # the list beside the picture
