"""A part beside its body, as solids: where they differ, and which hand the part has."""

from collections.abc import Iterator
from itertools import pairwise
from random import Random
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from beamcam.errors import Severity, Source
from beamcam.model.part import EndCuts, Hole, Slot
from beamcam.readers.ifc import Options, read, same_solid
from beamcam.readers.ifc.checks import section_diagnostics
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.finish import Shaped, part_of
from beamcam.readers.ifc.kernel import Built, built
from beamcam.readers.ifc.same_solid import Fineness, differences
from beamcam.readers.ifc.section import BareStock, Section, plain_stock
from beamcam.readers.ifc.shell import Shell, shell
from beamcam.readers.ifc.solid_body import section_area, solid_of
from beamcam.readers.ifc.space import IDENTITY, Frame
from tests.property.ifc_builder import model_text, random_member
from tests.property.ifc_cuts import SIZES, Bar, Half, model_of
from tests.unit.readers.ifc.models import Small, opened
from tests.unit.readers.ifc.test_checks import patched

FACES = Fineness(slack=0.04, facet_rad=0.6)
SOURCE = Source("m.ifc")
Corners = list[tuple[float, float, float]]


def flat(height: float = 100.0, thickness: float = 10.0) -> Section:
    return Section(
        "B", height, thickness, 0.0, thickness, 0.0, (0.0, 0.0), (0.0, 1.0), (1.0, 0.0),
        height * thickness,
    )  # fmt: skip


def plate(*features: Hole | Slot, length: float = 400.0) -> Shaped:
    """A flat bar 100 x 10 with these features."""
    return Shaped(flat(), length, EndCuts(), features, 1000.0 * length, length)


def box_faces(low: tuple[float, ...], high: tuple[float, ...]) -> Iterator[Corners]:
    """The six sides of a box, counter-clockwise from outside."""
    (a, b, c), (d, e, f) = low, high
    yield [(a, b, c), (a, e, c), (d, e, c), (d, b, c)]
    yield [(a, b, f), (d, b, f), (d, e, f), (a, e, f)]
    yield [(a, b, c), (d, b, c), (d, b, f), (a, b, f)]
    yield [(a, e, c), (a, e, f), (d, e, f), (d, e, c)]
    yield [(a, b, c), (a, b, f), (a, e, f), (a, e, c)]
    yield [(d, b, c), (d, e, c), (d, e, f), (d, b, f)]


def body(*faces: Corners) -> Shell:
    points = np.array([corner for face in faces for corner in face])
    return shell(points, [len(face) for face in faces], range(len(faces)))


def ring(x: float, y: float, radius: float, count: int) -> list[tuple[float, float]]:
    turns = 2 * np.pi * np.arange(count) / count
    return [(x + radius * float(np.cos(t)), y + radius * float(np.sin(t))) for t in turns]


def drilled(x: float, y: float, radius: float, count: int = 12) -> Shell:
    """The flat bar with a hole of so many facets, its two sides as faces with a hollow."""
    sides = [*box_faces((0.0, 0.0, 0.0), (400.0, 100.0, 10.0))]
    around = ring(x, y, radius, count)
    wall = [
        [(px, py, 0.0), (qx, qy, 0.0), (qx, qy, 10.0), (px, py, 10.0)]
        for (qx, qy), (px, py) in pairwise([*around, around[0]])
    ]
    hollows: list[Corners] = [[(*p, z) for p in around] for z in (0.0, 10.0)]
    rows = [sides[0], hollows[0], sides[1], hollows[1], *sides[2:], *wall]
    faces = [0, 0, 1, 1, *range(2, 6 + len(wall))]
    points = np.array([corner for row in rows for corner in row])
    return shell(points, [len(row) for row in rows], faces)


def told(shaped: Shaped, of: Shell) -> tuple[str, ...]:
    found = differences(shaped, of, plain_stock(flat()), FACES)
    return tuple(str(one) for one in found.lumps)


def test_a_shell_with_hollow_faces_is_a_solid() -> None:
    solid = solid_of(drilled(150.0, 40.0, 11.0))
    assert solid is not None
    manual_work = 400.0 * 100 * 10 - 10 * 12 * 11.0**2 * float(np.sin(np.pi / 6)) / 2
    assert solid.volume() == pytest.approx(manual_work, rel=1e-9)


def test_a_shell_turned_inside_out_is_the_same_solid() -> None:
    faces = [face[::-1] for face in box_faces((0.0, 0.0, 0.0), (400.0, 100.0, 10.0))]
    solid = solid_of(body(*faces))
    assert solid is not None
    assert solid.volume() == pytest.approx(400.0 * 100 * 10)


@pytest.mark.parametrize("count", [12, 24, 60])
def test_facets_of_a_hole_are_no_difference(count: int) -> None:
    hole = Hole("v", 150.0, 40.0, 22.0, SOURCE)
    assert told(plate(hole), drilled(150.0, 40.0, 11.0, count)) == ()


def test_a_hole_is_named_where_only_one_has_it() -> None:
    gone = told(plate(), drilled(150.0, 40.0, 11.0))
    assert gone == ("3.63 cm3 less on face v at x 139.0 to 161.0",)
    kept = told(plate(Hole("v", 150.0, 40.0, 22.0, SOURCE)), body(*box_of_bar()))
    (only,) = kept
    assert "more on face v at x 139.0 to 161.0" in only


def box_of_bar() -> list[Corners]:
    return [*box_faces((0.0, 0.0, 0.0), (400.0, 100.0, 10.0))]


@pytest.mark.parametrize("off", [1.0, 3.0])
def test_a_hole_beside_its_place_is_steel_too_much_and_too_little(off: float) -> None:
    hole = Hole("v", 150.0 + off, 40.0, 22.0, SOURCE)
    found = differences(plate(hole), drilled(150.0, 40.0, 11.0, 60), plain_stock(flat()), FACES)
    assert {one.more for one in found.lumps} == {True, False}


def test_the_mirror_image_of_a_body_is_no_part_of_it() -> None:
    hole = Hole("v", 150.0, 40.0, 22.0, SOURCE)
    over = Frame(IDENTITY.o, IDENTITY.x, IDENTITY.y, (0.0, 0.0, -1.0))
    with pytest.raises(Unreadable, match="mirror image"):
        differences(
            replace(plate(hole), frame=over), drilled(150.0, 40.0, 11.0), plain_stock(flat()), FACES
        )


def test_a_body_that_is_no_manifold_is_compared_by_its_sections() -> None:
    """One face is turned the other way than its neighbours."""
    first, *rest = box_of_bar()
    turned = body(first[::-1], *rest)
    assert solid_of(turned) is None
    assert section_area(turned) == pytest.approx(400.0 * 100 * 10)
    assert told(plate(), turned) == ()
    hole = Hole("v", 200.0, 50.0, 40.0, SOURCE)
    (only,) = told(plate(hole), turned)
    assert "more on face v at x 180.4 to 219.6" in only


def test_rounded_toes_and_missing_fillets_are_told_and_slopes_are_not() -> None:
    from shapely import Point, Polygon, box

    section = Section("L", 60.0, 60.0, 6.0, 6.0, 0.0, (0.0, 0.0), (0.0, 1.0), (1.0, 0.0), 684.0)
    shaped = Shaped(section, 500.0, EndCuts(), (), 342e3, 500.0)
    sharp = Polygon([(0, 0), (60, 0), (60, 6), (6, 6), (6, 60), (0, 60)])
    assert section_diagnostics(shaped, BareStock(sharp, sharp.area), SOURCE) == ()
    toes = (
        box(54, 0, 60, 6)
        .difference(Point(54, 0).buffer(6, 64))
        .union(box(0, 54, 6, 60).difference(Point(0, 54).buffer(6, 64)))
    )
    rounded = sharp.difference(toes)
    (said,) = section_diagnostics(shaped, BareStock(rounded, rounded.area), SOURCE)
    assert (said.code, said["found"], said["expected"]) == ("ifc-section-area", "6.69", "6.84")
    sloped = Polygon([(0, 0), (60, 0), (60, 5), (7, 7), (5, 60), (0, 60)])
    assert section_diagnostics(shaped, BareStock(sloped, sloped.area), SOURCE) == ()


def test_plain_members_are_compared_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kernel whose solid has a hole that the definition has not."""

    def with_a_hole(*_: object) -> Built:
        m = Small()
        m.element(m.minus(m.extruded(m.ipe300(), 2000.0), m.hole((500, -20, 0), (0, 1, 0), 22, 40)))
        other = opened(m.data)
        return built(other, other.file.by_type("IfcBeam")[0])

    patched(monkeypatch, with_a_hole)
    m = Small()
    m.element(m.extruded(m.ipe300(), 2000.0))
    found = read(m.data, "m.ifc", options=Options(kernel=True))
    (said,) = [d for d in found.diagnostics if d.severity is Severity.ERROR]
    assert said.code == "ifc-unexplained"
    assert "less on face v at x 489.0 to 511.0" in said.message


def test_a_cut_inside_a_flange_is_found() -> None:
    """A bore along the flange, which none of its surfaces shows."""
    m = Small()
    bore = m.hole((800, -70, 144.65), (0, 1, 0), 6, 140)
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), bore))
    found = read(m.data, "m.ifc", options=Options(kernel=True))
    (said,) = [d for d in found.diagnostics if d.severity is Severity.ERROR]
    assert "less on face o at x 797.0 to 803.0" in said.message


@pytest.mark.parametrize("encoding", ["brep", "mesh"])
def test_the_plain_look_and_the_whole_comparison_say_the_same(
    encoding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    random = Random(encoding)
    members = [random_member(random, encoding) for _ in range(3)]
    data = model_text(members, encoding, random)[0].encode()
    looked: list[float | None] = []
    plain = same_solid._plainly_drilled

    def noted(*of: Any) -> float | None:
        looked.append(plain(*of))
        return looked[-1]

    monkeypatch.setattr(same_solid, "_plainly_drilled", noted)
    found = read(data, "m.ifc")
    monkeypatch.setattr(same_solid, "_plainly_drilled", lambda *_: None)
    assert read(data, "m.ifc") == found
    assert None not in looked


@pytest.mark.parametrize(
    "hole",
    [
        Hole("v", 200.3, 50.0, 22.0, SOURCE),
        Hole("v", 200.0, 50.0, 22.4, SOURCE),
        Hole("v", 200.0, 50.0, 22.0, SOURCE, depth=5.0),
        Slot("v", 200.0, 50.0, 22.0, 10.0, 0.0, 0.0, SOURCE),
    ],
)  # fmt: skip
def test_the_plain_look_passes_no_other_hole(hole: Hole | Slot) -> None:
    solid = solid_of(drilled(200.0, 50.0, 11.0, 24))
    assert solid is not None
    stock = plain_stock(flat())

    def plain(*features: Hole | Slot) -> float | None:
        shaped = plate(*features)
        return same_solid._plainly_drilled(solid, part_of(shaped), shaped, stock, FACES)

    right = Hole("v", 200.0, 50.0, 22.0, SOURCE)
    assert plain(right) == pytest.approx(400.0 * 1000.0 - 10.0 * np.pi * 11.0**2, rel=1e-4)
    assert plain(hole) is None
    assert plain(right, hole) is None
    assert plain() is None


def test_a_flange_that_is_planed_off_is_told_by_how_much() -> None:
    bar = Bar("I", 900.0, SIZES["I"])
    found = read(
        model_of(bar, [Half((0.0, 290.0, 0.0), (0.0, 1.0, 0.0))]),
        "m.ifc",
        options=Options(kernel=True),
    )
    (said,) = [d for d in found.diagnostics if d.severity is Severity.ERROR]
    assert "less on face o at x 0.0 to 900.0 (10.0 mm off its 10.7 mm)" in said.message


def test_a_body_of_two_solids_is_refused_as_one() -> None:
    """An I with its end plate, whose sections have cracks that enclose nothing."""
    m = Small()
    plate = m.extruded(m.box(200.0, 400.0), 20.0, m.step.axes((-20, 0, 0), (1, 0, 0), (0, 1, 0)))
    beam = m.extruded(m.ipe300(), 3000.0, m.step.axes((0, 0, 0), (1, 0, 0), (0, 1, 0)))
    m.element(f"{beam},{plate}")
    found = read(m.data, "m.ifc", options=Options(kernel=True))
    (said,) = [d for d in found.diagnostics if d.severity is Severity.ERROR]
    assert said["found"].startswith("a body of 2 solids; by the kernel more steel")
