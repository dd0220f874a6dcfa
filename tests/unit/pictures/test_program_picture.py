"""Pictures of programs: drawn from what was read back, whatever the plan was."""

import re
from hashlib import sha256
from itertools import pairwise
from math import radians, tan
from pathlib import Path
from typing import Literal
from xml.etree.ElementTree import Element

import pytest
from msgspec.structs import replace

from beamcam.checks.bars.stations import Bore, MachinedPath
from beamcam.errors import VerifyError
from beamcam.machine import Machine, load
from beamcam.model.part import Part, Profile
from beamcam.pictures import ReadProgram
from beamcam.pictures.features import SteelDepths
from beamcam.pictures.formats import to_svg
from beamcam.pictures.program import bar_made, program_scene
from beamcam.pipeline import post, read_file
from beamcam.simulation.program import simulate_program
from tests.conftest import SAMPLES
from tests.unit.checks.programs import interpret
from tests.unit.pictures.drawings import Drawing, corners

ANNEX = [SAMPLES / "dstv" / f"{name}.nc1" for name in ("channel", "tie", "channel")]


def parts_of(paths: list[Path]) -> tuple[Part, ...]:
    return tuple(part for path in paths for part in read_file(str(path)).parts)


def program_of(
    paths: list[Path], machine: Machine, style: str | None = None, known: bool = True
) -> ReadProgram:
    parts = parts_of(paths)
    data = b"".join(post(parts, machine, style=style).pieces())
    return ReadProgram(data, machine, "job" + machine.suffix, style or "", parts if known else ())


def drawn(program: ReadProgram) -> Drawing:
    return Drawing(to_svg(program_scene(program)))


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "beamline-pusher"])
def test_a_bar_has_its_cuts_holes_and_parts(name: str, known: bool) -> None:
    machine = load(name)
    program = program_of(ANNEX, machine, known=known)
    made = interpret(program.text, machine)
    found = drawn(program)
    assert found.count("cut") == len(made.cuts)
    assert found.count("hole") == len(made.bores)
    numbers = {int("".join(e.itertext())) for e in found.all("order")}
    assert numbers == set(range(1, len({op.line for op in made.order}) + 1))
    pieces = bar_made(program).pieces()
    assert [p.mark for p in pieces if p.kind == "part"] == (
        ["C1", "T1", "C1"] if known else ["part 1", "part 2", "part 3"]
    )
    faces = 3
    assert found.count("part", "piece") == 3 * faces
    assert found.count("trim", "piece") == faces * sum(p.kind == "trim" for p in pieces)
    assert program.sha256 == sha256(program.data).hexdigest()
    assert program.sha256 in " ".join(found.texts)
    lines = {int(e.get("data-line", "0")) for e in found.all("hole")}
    assert lines == {bore.line for bore in made.bores}
    texts = found.texts
    for size in {bore.diameter for bore in made.bores}:
        count = sum(bore.diameter == size for bore in made.bores)
        (said,) = [text for text in texts if text.startswith(f"drill Ø{size:g}: ")]
        assert sum(int(n) for n in re.findall(r"(\d+) × ", said)) == count
        assert not known or said.endswith(f": {count} × through")
    assert not known or "C1   3000" in texts
    assert texts.count("15°") == 2 or not known


def test_a_width_that_a_program_does_not_say_is_not_drawn() -> None:
    """The annex says a height twice and K3; its file says that K3 is a U and that it takes no L."""
    machine = load("beamline-annex")
    given, alone = (program_of(ANNEX, machine, known=known) for known in (True, False))
    assert any("UPN200 200 x 75" in text for text in drawn(given).texts)
    found = drawn(alone).texts
    assert any("U 200, width not said" in text for text in found)
    titles = [text for text in found if "flange" in text]
    assert len(titles) == 2
    assert all(text.endswith("drawn as far as its holes") for text in titles)
    lowest = bar_made(given).profile.face_width("o")
    holes = [b for b in bar_made(alone).made.bores if b.face == "o"]
    assert max(b.y for b in holes) < bar_made(alone).face_width("o") <= lowest


def test_a_number_that_means_two_sections_says_neither() -> None:
    machine = load("beamline-annex")
    assert machine.layout is not None
    both = replace(machine, layout=replace(machine.layout, profiles=("I", "U", "L")))
    assert (machine.sections_of(3), both.sections_of(3)) == (("U",), ("U", "L"))
    program = program_of(ANNEX, machine, known=False)
    other = ReadProgram(program.data, both, program.name)
    assert bar_made(program).profile.code == "U"
    assert bar_made(other).profile.code == "SO"


def test_tools_have_colours_of_their_own() -> None:
    machine = load("beamline-annex")
    program = program_of(ANNEX, machine)
    made = interpret(program.text, machine)
    by_style: dict[str, set[float]] = {}
    circles = {int(e.get("data-line", "0")): e for e in drawn(program).all("hole")}
    for bore in made.bores:
        style = circles[bore.line].get("class", "").split()[0]
        by_style.setdefault(style, set()).add(bore.diameter)
    assert len(by_style) == len({b.diameter for b in made.bores}) > 1
    assert all(len(found) == 1 for found in by_style.values())


@pytest.mark.parametrize("far", [False, True])
def test_a_table_s_program_is_shown_on_its_table(far: bool) -> None:
    """The shield reaches X 35 and Y 37 of a table of 700 x 700; the picture of it is to scale."""
    machine = load("table-simotion")
    program = program_of([SAMPLES / "json" / "shield.json"], machine)
    if far:
        assert machine.torch is not None
        small = replace(machine.torch, length=35.0, width=28.0)
        program = replace(program, machine=replace(machine, torch=small))
    found = drawn(program)
    (limits,), (work,) = found.all("limits"), found.all("work")
    width, height = (35.0, 28.0) if far else (700.0, 700.0)
    assert f"table {width:g} x {height:g} mm" in found.texts
    assert f"X 0 to {width:g}, Y 0 to {height:g} mm" in found.texts
    assert ("the path leaves it" in found.texts) == far
    assert ("off" in work.get("class", "").split()) == far
    (x0, y0), (x1, y1) = ends(limits)
    (a0, b0), (a1, b1) = ends(work)
    assert (a0, b0) == pytest.approx((x0, y0), abs=0.02)
    assert (a1 - a0) / (x1 - x0) == pytest.approx(35.0 / width, abs=0.002)
    assert (b1 - b0) / (y1 - y0) == pytest.approx(37.0 / height, abs=0.002)


def ends(shape: Element) -> tuple[tuple[float, float], tuple[float, float]]:
    """The lower left and the upper right corner of a shape on the paper."""
    points = corners(shape)
    (x0, x1), (y0, y1) = ((min(v), max(v)) for v in zip(*points, strict=True))
    return (x0, y1), (x1, y0)


def sheet_edges(found: Drawing) -> list[list[tuple[float, float]]]:
    return [corners(e) for e in found.all("sheet-edge")]


@pytest.mark.parametrize("origin", ["table", "lower-left", "centre"])
def test_the_frame_is_the_sheet_with_axes_grid_and_scale(origin: str) -> None:
    """A gusset of 260 x 180 on a sheet of 400 x 300: all four edges, in their places about zero."""
    machine = load("plate-linuxcnc")
    assert machine.torch is not None
    torch = replace(machine.torch, length=400.0, width=300.0, origin=origin)
    program = program_of([SAMPLES / "dstv" / "gusset.nc1"], replace(machine, torch=torch))
    found = drawn(program)
    figures = {float(e.get("data-mm", "nan")): e for e in found.all("figure")
               if e.get("data-mm") and e.get("transform")}  # fmt: skip
    u = 0.5 if origin == "centre" else 0.0
    wanted = {-400.0 * u + 50.0 * k for k in range(9)}
    assert wanted <= {*figures}
    edges = sheet_edges(found)
    assert len(edges) == 4
    xs, ys = ([p[k] for e in edges for p in e] for k in (0, 1))
    scale = (max(xs) - min(xs)) / 400.0
    assert (max(ys) - min(ys)) / scale == pytest.approx(300.0, abs=0.1)
    assert float(figures[-400.0 * u].get("x", 0)) - 3.5 == pytest.approx(min(xs), abs=0.1)
    assert found.count("axis") == 2
    assert {"X", "Y"} <= set(found.texts)


def test_a_small_path_on_a_large_table_is_shown_by_itself() -> None:
    found = drawn(program_of([SAMPLES / "dstv" / "gusset.nc1"], load("plate-codesys")))
    (table,) = found.all("face", "table")
    (x0, y0), (x1, y1) = ends(table)
    assert (x1 - x0) / (y0 - y1) < 1.6  # the gusset's proportions and not the table's 2 to 1
    assert len(sheet_edges(found)) == 2


def test_only_speeds_that_occur_are_in_the_legend() -> None:
    text = to_svg(program_scene(program_of([SAMPLES / "dstv" / "gusset.nc1"],
                                           load("plate-linuxcnc"))))  # fmt: skip
    found = Drawing(text)
    used = {k for k in range(8) if found.count(f"speed-{k}")}
    named = {k for k in range(8) if f'class="speed-{k} legend"' in text}
    assert named == used
    assert 0 < len(used) < 8


def test_a_picture_shows_the_program_and_not_its_part() -> None:
    """A hole moved in the text is moved in the picture, whatever the part says."""
    machine = load("beamline")
    program = program_of(ANNEX[:1], machine)
    before = [float(e.get("cx", 0)) for e in drawn(program).all("hole")]
    text = program.text.replace("X3698.56", "X3598.56")
    assert text != program.text
    moved = ReadProgram(text.encode(), machine, program.name, "", program.parts)
    after = [float(e.get("cx", 0)) for e in drawn(moved).all("hole")]
    assert sorted(before) != sorted(after)
    assert moved.sha256 in to_svg(program_scene(moved))
    assert program.sha256 not in to_svg(program_scene(moved))


@pytest.mark.parametrize(
    ("sample", "name", "style"),
    [
        ("dstv/gusset.nc1", "plate-codesys", None),
        ("dstv/gusset.nc1", "plate-linuxcnc", None),
        ("json/curves.json", "laser-grbl", None),
        ("json/shield.json", "table-simotion", None),
        ("json/shield-small.json", "laser-stepper", ".steps"),
        ("json/shield-small.json", "laser-stepper", ".csv"),
    ],
)
def test_a_table_s_way_is_drawn_by_speed(sample: str, name: str, style: str | None) -> None:
    machine = load(name)
    program = program_of([SAMPLES / sample], machine, style)
    trace = simulate_program(program.data, machine, style=style or "", parts=program.parts).trace
    found = drawn(program)
    starts = sum(
        1
        for a, b in zip([-1, *trace.state[:-1].tolist()], trace.state.tolist(), strict=True)
        if a != b and trace.states[b].process
    )
    assert found.count("pierce") == starts > 0
    assert found.count("rapid") >= 1
    coloured = [e for k in range(8) for e in found.all(f"speed-{k}")]
    assert coloured
    assert {w for e in coloured for w in e.get("class", "").split() if w.startswith("by-")} <= {
        "by-cut", "by-mark", "by-engrave",
    }  # fmt: skip
    assert program.sha256 in " ".join(found.texts)
    # All that is coloured is as long as the way with a tool on, at the picture's scale.
    across = [x for e in (*coloured, *found.all("rapid")) for x, _ in corners(e)]
    scale = (max(across) - min(across)) / (
        trace.positions[:, 0].max() - trace.positions[:, 0].min()
    )
    length = sum(_length(corners(e)) for e in coloured) / scale
    on = [bool(trace.states[s].process) for s in trace.state.tolist()]
    ways = [
        ((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5
        for a, b in zip(trace.positions[:-1].tolist(), trace.positions[1:].tolist(), strict=True)
    ]
    wanted = sum(way for way, is_on in zip(ways, on, strict=True) if is_on)
    assert length == pytest.approx(wanted, rel=0.02)


def _length(points: list[tuple[float, float]]) -> float:
    return sum(((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5 for a, b in pairwise(points))


def test_leads_are_told_from_the_contour() -> None:
    found = drawn(program_of([SAMPLES / "dstv" / "gusset.nc1"], load("plate-codesys")))
    assert found.count("lead") >= 4
    square = drawn(program_of([SAMPLES / "json" / "shield.json"], load("table-simotion")))
    assert square.count("lead") <= 2


@pytest.mark.parametrize("by", ["machine", "offset"])
@pytest.mark.parametrize("name", ["plate-codesys", "plate-linuxcnc"])
def test_the_caption_says_what_the_controller_offsets(
    name: str, by: Literal["machine", "offset"]
) -> None:
    machine = load(name)
    assert machine.torch is not None
    machine = replace(machine, torch=replace(machine.torch, kerf_by=by))
    texts = drawn(program_of([SAMPLES / "dstv" / "gusset.nc1"], machine)).texts
    caption = "path as programmed; the controller keeps 0.8 mm off it (G41, G42)"
    assert (caption in texts) is (by == "machine")


@pytest.mark.parametrize("name", ["beamline", "plate-linuxcnc", "table-simotion"])
def test_what_is_no_program_is_not_drawn(name: str) -> None:
    with pytest.raises(VerifyError):
        program_scene(ReadProgram(b"G01 X! garbage", load(name), "x"))


def test_the_same_program_gives_the_same_bytes() -> None:
    machine = load("plate-linuxcnc")
    program = program_of([SAMPLES / "dstv" / "gusset.nc1"], machine)
    assert to_svg(program_scene(program)) == to_svg(program_scene(program))


@pytest.mark.parametrize(("count", "is_long"), [(1, True), (4, False)])
def test_a_long_remnant_is_broken_off_and_all_else_is_drawn(count: int, is_long: bool) -> None:
    machine, length = load("beamline"), 2400.0
    parts = parts_of([SAMPLES / "dstv" / "tie.nc1"] * count)
    data = b"".join(post(parts, machine, bar=length).pieces())
    program = ReadProgram(data, machine, "job.gcode", "", parts, length)
    found = drawn(program)
    faces = found.count("remnant", "piece")
    assert found.count("break") == (faces if is_long else 0)
    assert found.count("hole") == len(interpret(program.text, machine).bores)
    bar = bar_made(program)
    assert bar.worked < bar.drawn_end <= bar.end == length
    assert f"bar {length:g} mm" in " ".join(found.texts)


# --- depths in the steel --------------------------------------------------------------------------


WEB = 8.5
CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, WEB)
#: Of a drill of 18 mm with a point of 118 degrees: 9 mm / tan 59 degrees.
POINT = 9.0 / tan(radians(59.0))


def bore(kind: str, diameter: float, tip: float) -> Bore:
    return Bore(1, "v", 100.0, 50.0, diameter, tip, 1, 100.0, 0.0, kind)


@pytest.mark.parametrize(
    ("kind", "diameter", "tip", "depth"),
    [
        ("drill", 18.0, WEB + POINT, None), ("drill", 18.0, WEB + POINT + 3.0, None),
        ("drill", 18.0, WEB + POINT - 0.5, WEB - 0.5), ("drill", 18.0, 5.0 + POINT, 5.0),
        ("tap", 16.0, WEB + 2.0, None), ("tap", 16.0, 6.0, 6.0), ("punch", 5.0, 1.0, 1.0),
    ],
)  # fmt: skip
def test_a_depth_is_that_of_the_full_diameter(
    kind: str, diameter: float, tip: float, depth: float | None
) -> None:
    one = bore(kind, diameter, tip)
    found = SteelDepths(load("beamline-annex"), CHANNEL, [one]).of(one)
    assert found == (None if depth is None else pytest.approx(depth))


def test_a_sink_is_as_deep_as_its_cone_is_in_the_steel() -> None:
    """A cone of 90 degrees, 30 mm wide at the surface, over a hole of 18 mm: 15 - 9 = 6 mm."""
    machine = load("beamline-pusher")
    drill, sink = bore("drill", 18.0, 30.0), bore("countersink", 32.0, 15.0)
    depths = SteelDepths(machine, CHANNEL, [drill, sink])
    assert depths.of(sink) == pytest.approx(6.0)
    beside = replace(sink, x=130.0)
    assert depths.of(beside) == pytest.approx(15.0)


def test_of_an_unknown_wall_nothing_goes_through() -> None:
    bare = Profile("SO", "", 0.0, 0.0, 0.0, None)
    one = bore("drill", 18.0, 30.0)
    path = MachinedPath(1, "v", "mill", ((0.0, 0.0),), 10.0, 4.0, 12.0, 1, 100.0)
    depths = SteelDepths(load("beamline-annex"), bare, [one])
    assert depths.of(one) == pytest.approx(30.0 - POINT)
    assert depths.of(path) == 12.0
    assert SteelDepths(load("beamline-annex"), CHANNEL, []).of(path) is None
