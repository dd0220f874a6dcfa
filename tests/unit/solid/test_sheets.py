"""Plates cut as solids: sound programs agree, and every lie of a program is seen."""

import re
from functools import cache
from itertools import pairwise
from math import pi

import pytest
from msgspec.structs import replace

from beamcam.controllers import table_events
from beamcam.errors import Severity
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import Machine, load
from beamcam.model.part import Bevel, Contour, Hole, Part, Profile, Slot
from beamcam.model.request import Request
from beamcam.pipeline import post, read_file
from beamcam.solid.opinion import solid_faults
from beamcam.solid.plates import plate_of
from beamcam.solid.sheet_solid import pieces_cut, rows_for, starting_words, strokes_of
from tests.conftest import ROOT, sampled
from tests.unit.solid.programs import SRC

MACHINES = (
    "plate-linuxcnc", "plate-codesys", "plate-oxyfuel", "plate-mach3", "plate-qtplasmac",
)  # fmt: skip


def closed(*points: tuple[float, float]) -> tuple[Line, ...]:
    places = [(float(x), float(y)) for x, y in points]
    return tuple(map(Line, places, [*places[1:], places[0]]))


#: Nothing of it is symmetric; its notch leaves inner corners.
ODD = Part(
    "ODD", Profile("B", "PL6", 150.0, 0.0, 0.0, 6.0), 300.0, SRC, grade="S235",
    features=(
        Contour("v", "outer", closed(
            (0, 0), (300, 0), (300, 90), (240, 150), (120, 150), (120, 110), (60, 110), (60, 150),
            (0, 150)), SRC),
        Contour("v", "inner", closed((200, 30), (200, 70), (260, 70)), SRC),
        Hole("v", 40.0, 40.0, 18.0, SRC),
        Slot("v", 110.0, 60.0, 14.0, 30.0, 0.0, 30.0, SRC),
    ),
)  # fmt: skip


#: Without its round openings: turned solids of many facets take long.
STRAIGHT = replace(ODD, features=ODD.features[:2])


@cache
def machine_of(name: str, kerf_by: str = "offset", **torch: object) -> Machine:
    machine = load(name)
    assert machine.torch is not None
    torch = {"allow_open": True, **torch}
    thick = {} if machine.torch.thickness else {"thickness": 3.0, "material": "acrylic"}
    return replace(
        machine,
        torch=replace(machine.torch, kerf_by=kerf_by, **thick, **torch),  # type: ignore[arg-type]
    )


def posted(part: Part, machine: Machine) -> str:
    return post([part], machine, skips=("all",)).text


def codes(text: str, machine: Machine, *parts: Part) -> list[str]:
    said = solid_faults(text, Request(parts, machine, ("all",)))
    return [d.code for d in said if d.severity is not Severity.NOTE]


def mirrored(part: Part) -> Part:
    """The part seen from behind, as its numbers on the same face."""
    flip = ((-1.0, 0.0, part.length), (0.0, 1.0, 0.0))
    features = tuple(
        replace(f, curves=tuple(c.transformed(flip) for c in f.curves)) if isinstance(f, Contour)
        else replace(f, x=part.length - f.x, angle=180 - f.angle) if isinstance(f, Slot)
        else replace(f, x=part.length - f.x)  # type: ignore[call-arg]
        for f in part.features
    )  # fmt: skip
    return replace(part, features=features)


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("name", sampled(["gusset", "plate", "bent", "lettered"], 2))
def test_sound_programs_of_samples_agree(name: str, machine: str) -> None:
    (part,) = read_file(str(ROOT / f"samples/dstv/{name}.nc1")).parts
    assert codes(posted(part, machine_of(machine)), machine_of(machine), part) == []


@pytest.mark.parametrize("name", ["dxf/plate.dxf", "dxf/splines.dxf", "svg/corel-2021.svg",
                                  "svg/tag.svg", "json/curves.json", "json/cam.json"])  # fmt: skip
@pytest.mark.parametrize("machine", ["plate-linuxcnc", "laser-grbl"])
def test_sound_programs_of_drawings_agree(name: str, machine: str) -> None:
    made = machine_of(machine, "none" if machine == "laser-grbl" else "offset")
    if name.endswith("splines.dxf"):
        colours = {**made.torch.colours, "white": "cut"} if made.torch else {}
        made = replace(made, torch=replace(made.torch, colours=colours))  # type: ignore[type-var]
    (part,) = read_file(str(ROOT / "samples" / name)).parts
    assert codes(posted(part, made), made, part) == []


@pytest.mark.parametrize("kerf_by", ["offset", "machine"])
@pytest.mark.parametrize("machine", MACHINES)
def test_the_odd_plate_agrees(machine: str, kerf_by: str) -> None:
    if not load(machine).words.left:
        kerf_by = "offset"  # it has no words to keep beside a contour
    made = machine_of(machine, kerf_by)
    assert codes(posted(ODD, made), made, ODD) == []


@pytest.mark.parametrize(
    "torch",
    [
        {"rotate": 30.0}, {"rotate": 90.0}, {"mirror": "x"}, {"mirror": "y", "rotate": 45.0},
        {"copies": (2, 3)},
    ],
)  # fmt: skip
def test_a_plate_that_lies_as_it_is_asked_to(torch: dict[str, object]) -> None:
    made = machine_of("plate-linuxcnc", "offset", **torch)
    assert codes(posted(ODD, made), made, ODD) == []


def test_the_mirror_image_is_another_part() -> None:
    made = machine_of("plate-linuxcnc")
    assert codes(posted(mirrored(STRAIGHT), made), made, STRAIGHT) == ["solid-hand"]
    # Where it is asked for, it is the drawn one that is refused.
    asked = machine_of("plate-linuxcnc", "offset", mirror="x")
    assert codes(posted(mirrored(STRAIGHT), made), asked, STRAIGHT) == []
    assert codes(posted(STRAIGHT, made), asked, STRAIGHT) == ["solid-hand"]


def test_a_missing_hole_is_named_by_its_place() -> None:
    made = machine_of("plate-linuxcnc")
    more = replace(ODD, features=ODD.features[:3])
    said = solid_faults(posted(STRAIGHT, made), Request((more,), made))
    assert [d.code for d in said] == ["solid-extra"]
    assert "1 lump(s)" in said[0].message
    assert "on face v at x 40.0, y 40.0" in said[0].message


@pytest.mark.parametrize("off", sampled([-2.0, -0.3, 0.3, 5.0], 2))
def test_another_length(off: float) -> None:
    made = machine_of("plate-linuxcnc")
    outer = ODD.features[0]
    assert isinstance(outer, Contour)
    curves = closed(
        (0, 0), (300 + off, 0), (300 + off, 90), (240 + off, 150), (120, 150), (120, 110),
        (60, 110), (60, 150), (0, 150),
    )  # fmt: skip
    longer = replace(
        STRAIGHT, length=300 + off, features=(replace(outer, curves=curves), ODD.features[1])
    )
    said = codes(posted(longer, made), made, STRAIGHT)
    assert said
    assert ("solid-size" in said) == (abs(off) > 0.2)


def test_a_cut_on_the_line_is_half_a_kerf_off() -> None:
    """Nobody keeps off the contour: pieces are small by half a kerf, holes large."""
    made, on_line = machine_of("plate-linuxcnc"), machine_of("plate-linuxcnc", "none")
    said = codes(posted(STRAIGHT, on_line), made, STRAIGHT)
    assert set(said) == {"solid-missing", "solid-size"}


@pytest.mark.parametrize("machine", sampled(["plate-linuxcnc", "plate-codesys"], 2))
def test_the_kerf_on_the_wrong_side(machine: str) -> None:
    made = machine_of(machine, "machine")
    outline = replace(STRAIGHT, features=STRAIGHT.features[:1])
    text = posted(outline, made)
    turned = re.sub(r"G4([12])(?=\D)", lambda m: "G42" if m[1] == "1" else "G41", text)
    assert turned != text
    assert "solid-missing" in codes(turned, made, outline)


def test_pieces_are_counted() -> None:
    made = machine_of("plate-linuxcnc")
    two = post([ODD, ODD], made).text
    assert codes(two, made, ODD, ODD) == []
    assert codes(two, made, ODD) == ["solid-pieces"]
    assert codes(two, made, ODD, ODD, ODD)[-1] in ("solid-missing", "solid-pieces")
    uncut = re.sub(r"(?s)\AX?(.*)G0 X\S+ Y\S+\nM3 S1\n.*?M5\n", r"\1", posted(ODD, made))
    assert codes(uncut, made, ODD) != []


def test_holes_for_the_drill_are_told() -> None:
    made = machine_of("plate-linuxcnc")
    small = replace(ODD, features=(*ODD.features, Hole("v", 150.0, 20.0, 3.0, SRC)))
    (said,) = solid_faults(posted(small, made), Request((small,), made))
    assert said.code == "solid-left-out"
    assert "of a hole on face v left on ODD" in said.message


def test_bevels_are_cut_square() -> None:
    made = machine_of("plate-linuxcnc")
    outer = ODD.features[0]
    assert isinstance(outer, Contour)
    slanted = replace(
        ODD, features=(replace(outer, bevels=(Bevel(1, 30.0, 0.0),)), *ODD.features[1:])
    )
    assert codes(posted(slanted, made), made, slanted) == []


def test_parts_in_bridges_have_no_pieces() -> None:
    made = machine_of("plate-linuxcnc", "offset", tabs=2)
    assert codes(posted(ODD, made), made, ODD) == ["solid-none"]


def test_marks_alone_are_no_piece() -> None:
    made = machine_of("plate-linuxcnc")
    line = Contour("v", "open", (Line((0.0, 0.0), (50.0, 0.0)),), SRC, "mark", False)
    drawing = read_file(str(ROOT / "samples/dxf/plate.dxf")).parts[0]
    assert codes("", made, replace(drawing, features=(line,))) == ["solid-none"]


def drawing(*features: object) -> Part:
    whole = read_file(str(ROOT / "samples/dxf/plate.dxf")).parts[0]
    return replace(whole, features=features)  # type: ignore[arg-type]


def ring(x: float, y: float, radius: float) -> Contour:
    return Contour("v", "outer", (Arc((x, y), radius, 0.0, 360.0),), SRC)


def lines(*points: tuple[float, float]) -> list[Contour]:
    """A chain of points as lines of their own."""
    places = [(float(x), float(y)) for x, y in points]
    return [
        Contour("v", "open", (Line(a, b),), SRC, "cut", False) for a, b in pairwise(places)
    ]  # fmt: skip


def areas(part: Part) -> list[float]:
    torch = machine_of("plate-linuxcnc").torch
    assert torch is not None
    return sorted(round(float(p.area), 1) for p in plate_of(part, torch, ()).pieces)


def test_what_lines_and_circles_of_a_drawing_enclose() -> None:
    outline = lines((0, 0), (100, 0), (100, 50), (0, 50), (0, 0.004))
    assert areas(drawing(*outline)) == [pytest.approx(5000.0, abs=1)]
    # A circle in it is a hole, one in the hole a piece again.
    disc = pi * 100
    inner = drawing(*outline, ring(50, 25, 20), ring(50, 25, 10))
    assert areas(inner) == [pytest.approx(disc, abs=1), pytest.approx(5000 - 4 * disc, abs=2)]


def test_a_line_in_a_plate_is_a_slit() -> None:
    made = machine_of("plate-linuxcnc")
    torch = made.torch
    assert torch is not None
    part = drawing(ring(50, 50, 50), *lines((40, 40), (60, 60)))
    plate = plate_of(part, torch, ())
    assert plate.slits.length == pytest.approx(20 * 2**0.5, abs=0.1)
    assert codes(posted(part, made), made, part) == []


def test_openings_for_the_drill_are_measured_by_their_curves() -> None:
    """A circle as wide as the least is cut, one narrower by 0.001 mm is not; nor is a slot, whose
    four curves are drawn singly."""
    made = machine_of("plate-linuxcnc", min_hole=8.0, min_hole_share=0.0)
    slot = [
        Line((40.0, 27.0), (50.0, 27.0)), Arc((50.0, 30.0), 3.0, -90.0, 180.0),
        Line((50.0, 33.0), (40.0, 33.0)), Arc((40.0, 30.0), 3.0, 90.0, 180.0),
    ]  # fmt: skip
    singly = [Contour("v", "open", (curve,), SRC, closed=False) for curve in slot]
    for radius, drilled in ((4.0, 1), (3.9995, 2), (4.0005, 1)):
        part = drawing(ring(50, 50, 50), ring(50, 60, radius), *singly)
        assert made.torch is not None
        assert len(plate_of(part, made.torch, ()).left) == drilled
        assert codes(posted(part, made), made, part) == []


def test_a_contour_without_area_is_a_slit() -> None:
    """A line there and back, which DSTV calls a contour, encloses no opening of any size."""
    (part,) = read_file(str(ROOT / "samples" / "bad" / "dstv" / "dstv-contour-area.nc1")).parts
    machine = machine_of("plate-linuxcnc", allow_open=True)
    assert codes(posted(part, machine), machine, part) == []


def test_a_cut_out_as_large_as_a_piece_is_no_piece_more() -> None:
    made = machine_of("laser-grbl", "none")
    part = drawing(
        *(
            replace(r, colour="#ff0000")
            for r in (ring(50, 50, 50), ring(50, 50, 10), ring(130, 50, 10))
        )
    )
    assert (
        len(areas(replace(part, features=tuple(replace(f, colour=None) for f in part.contours))))
        == 2
    )
    assert codes(posted(part, made), made, part) == []
    one = replace(part, features=part.features[:2])
    assert codes(posted(part, made), made, one) == []  # the disc may be its cut-out


def test_a_square_swept_by_hand() -> None:
    """A path round a square of 102 by a kerf of 2 frees a square of 100."""
    made = machine_of("plate-linuxcnc")
    text = (
        "G21 G90\nG0 X10 Y9\nM3 S1\nF1000\nG1 X111 Y9\nG1 X111 Y111\nG1 X9 Y111\nG1 X9 Y9\n"
        "G1 X10 Y9\nM5\nM2\n"
    )
    events, _ = table_events(text, made)
    (piece,) = pieces_cut(strokes_of(events, made, [], "hand"), 2.0)
    assert piece.bounds == (10.0, 10.0, 110.0, 110.0)
    assert piece.area == pytest.approx(10000.0)


def test_the_words_that_start_a_tool() -> None:
    plasma, laser = (starting_words(machine_of(n)) for n in ("plate-linuxcnc", "laser-grbl"))
    assert [(w.process, w.number, dict(w.fixed)) for w in plasma] == [
        ("cut", 3, {"S": 1.0}), ("mark", 3, {"S": 1.0, "$": 1.0}),
    ]  # fmt: skip
    assert {w.carried for w in laser} == {(("S", "power"),)}
    torch = machine_of("laser-grbl").torch
    assert torch is not None
    rows = {row.process: row for row in rows_for(torch, 3.0, "acrylic")}
    assert (rows["cut"].power, rows["mark"].power) == (900.0, 120.0)
