"""Pictures of copers' programs: every hole lies where the part has it, on its own face."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from beamcam.errors import VerifyError
from beamcam.machine import Machine, load
from beamcam.model.part import Feature, Hole, Part, Profile, Slot
from beamcam.pictures import ReadProgram
from beamcam.pictures.comparison import compared_programs
from beamcam.pictures.formats import to_svg
from beamcam.pictures.overlay import Overlay
from beamcam.pictures.program import program_scene
from beamcam.pictures.scene import Circle, Polyline, Scene, Text
from beamcam.pipeline import post, read_file
from tests.conftest import GOLDEN, SAMPLES
from tests.runs import call
from tests.unit.coping.samples import AT, COPER, IPE300, UPN200, part_of, program_of
from tests.unit.pictures.drawings import Drawing

COPING = SAMPLES / "coping"
MACHINES = {
    "coped": "coper-linuxcnc", "trimmer": "coper-linuxcnc", "cleat": "coper-linuxcnc",
    "stub": "tube-linuxcnc", "leg": "tube-linuxcnc", "hip": "tube-linuxcnc",
}  # fmt: skip


def drawn(name: str, knows_part: bool = True) -> tuple[Part, Scene]:
    (part,) = read_file(str(COPING / f"{name}.nc1")).parts
    machine = load(MACHINES[name])
    text = post([part], machine).text
    parts = (part,) if knows_part else ()
    return part, program_scene(ReadProgram(text.encode(), machine, f"{name}.ngc", parts=parts))


@pytest.mark.parametrize("name", [name for name in MACHINES if name not in ("leg", "hip")])
def test_every_hole_is_cut_where_it_is_asked_for(name: str) -> None:
    """The path of a hole is a circle half a kerf within it; its lead starts inside."""
    part, scene = drawn(name)
    holes = [f for f in part.features if isinstance(f, Hole) and f.kind != "mark"]
    asked = [s for s in scene.shapes if isinstance(s, Circle) and s.classes == "same"]
    assert len(asked) == len(holes) > 0
    paths = [s for s in scene.shapes if isinstance(s, Polyline)
             and s.classes.startswith("path-") and "legend" not in s.classes]  # fmt: skip
    relief: list[Circle] = []
    for circle in asked:
        (x, y), radius = circle.at, circle.radius
        around = [p for p in paths if all(abs(px - x) <= radius and abs(py - y) <= radius
                                          for px, py in p.points)]  # fmt: skip
        if name == "coped" and not around:  # the hole in the corner of the cope, cut with it
            relief.append(circle)
            continue
        assert len(around) == 1
        xs, ys = zip(*around[0].points, strict=True)
        assert (min(xs) + max(xs)) / 2 == pytest.approx(x, abs=0.6)
        assert (min(ys) + max(ys)) / 2 == pytest.approx(y, abs=0.6)
    assert len(relief) == (name == "coped")
    numbers = [s.text for s in scene.shapes if isinstance(s, Text) and "number" in s.classes]
    assert sorted(numbers, key=int) == [str(k) for k in range(1, len(paths) + 1)]


def test_a_program_alone_has_the_section_of_its_head() -> None:
    for name in ("trimmer", "cleat"):
        alone = drawn(name, knows_part=False)[1]
        whole = drawn(name)[1]
        ways = [[s for s in scene.shapes if isinstance(s, Polyline) and "path-" in s.classes]
                for scene in (alone, whole)]  # fmt: skip
        assert ways[0] == ways[1]


def test_a_tube_out_of_the_catalogue_is_known_by_its_name() -> None:
    """PIPE88.9*5 is a plate of 279.29 mm in its file, 88.901 mm round."""
    ways = [[s.points for s in drawn("stub", knows_part=known)[1].shapes
             if isinstance(s, Polyline) and s.classes.startswith("path-") and s.line]
            for known in (False, True)]  # fmt: skip
    assert [len(way) for way in ways[0]] == [len(way) for way in ways[1]]
    assert len(ways[0]) == 3
    for alone, whole in zip(*ways, strict=True):
        for one, other in zip(alone, whole, strict=True):
            assert one == pytest.approx(other, abs=0.02)


@pytest.mark.parametrize("name", ["BUILT", "PIPE88.9", "CHS20_10", "CHS0_0"])
def test_a_section_that_nobody_knows_is_asked_for(name: str) -> None:
    machine = load("tube-linuxcnc")
    (part,) = read_file(str(COPING / "brace.nc1")).parts
    text = post([part], machine).text.replace("(SECTION CHS168.3_8", f"(SECTION {name}")
    with pytest.raises(VerifyError) as error:
        program_scene(ReadProgram(text.encode(), machine, "brace.ngc"))
    (said,) = error.value.diagnostics
    assert said.code == "picture-section"
    assert "--machine tube-linuxcnc" in said.message


def test_a_rectangular_tube_is_drawn_once_round() -> None:
    """Its window over the corner of v and o is one path, within what is asked for there."""
    _, scene = drawn("leg")
    paths = [s for s in scene.shapes if isinstance(s, Polyline)
             and s.classes.startswith("path-") and "legend" not in s.classes]  # fmt: skip
    assert len(paths) == 7
    assert len({len(p.points) for p in paths}) > 3
    lines = [s for s in scene.shapes if isinstance(s, Polyline)]
    asked = [s for s in lines if s.classes == "same" and s.closed]
    window = paths[3].points[2:]
    box = [f(p[k] for p in window) for k in (0, 1) for f in (min, max)]
    around = [
        s for s in asked
        if (xs := [p[0] for p in s.points]) and (ys := [p[1] for p in s.points])
        and 0 < box[0] - min(xs) < 3 and 0 < max(xs) - box[1] < 3
        and 0 < box[2] - min(ys) < 3 and 0 < max(ys) - box[3] < 3
    ]  # fmt: skip
    assert len(around) == 1


def test_the_corners_of_a_tube_are_those_that_its_program_goes_round() -> None:
    """Without the part all its paths lie where they do with it; one that goes round no corner
    says nothing of them."""
    part, _ = drawn("leg")
    text = (GOLDEN / "tube-linuxcnc" / "leg.ngc").read_text()
    machine = load("tube-linuxcnc")
    program = ReadProgram(text.encode(), machine, "leg.ngc", parts=())
    paths = [
        [s.points for s in program_scene(one).shapes if isinstance(s, Polyline)
         and s.classes.startswith("path-") and "legend" not in s.classes]
        for one in (program, replace(program, parts=(part,)))
    ]  # fmt: skip
    assert [len(p) for p in paths[0]] == [len(p) for p in paths[1]]
    assert len(paths[0]) == 7
    head = text[: text.index("(cut-out)")]
    with pytest.raises(VerifyError) as error:
        program_scene(ReadProgram(f"{head}M30\n%\n".encode(), machine, "leg.ngc", parts=()))
    assert error.value.diagnostics[0].code == "picture-section"


def test_what_is_wrong_by_itself_is_told_and_not_drawn() -> None:
    (part,) = read_file(str(COPING / "trimmer.nc1")).parts
    machine = load("coper-linuxcnc")
    text = post([part], machine).text.replace("M5", "M3 S1", 1)
    with pytest.raises(VerifyError) as error:
        program_scene(ReadProgram(text.encode(), machine, "t.ngc", parts=(part,)))
    assert {said.code for said in error.value.diagnostics} == {"verify-coping-torch"}


def test_plot_draws_it_from_the_command_line(tmp_path: Path) -> None:
    out = tmp_path / "t.svg"
    words = ["plot", str(COPING / "trimmer.nc1"), "--machine", "coper-linuxcnc", "--show",
             "program", "-o", str(out)]  # fmt: skip
    assert call(*words).exit_code == 0
    assert "cut at 3000 mm/min" in out.read_text(encoding="utf-8")


# --- two programs ---------------------------------------------------------------------------------


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
    call("diff", *names, "-o", out, status=1)
    assert out.stat().st_size > 1000
    if suffix == ".html":
        assert "statements: X +15.0000" in out.read_text()  # the list beside the picture
