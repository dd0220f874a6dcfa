"""The BREP text of the kernel: exact planes and cylinders, and what is said of other texts."""

from math import hypot

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc
from beamcam.model.part import Hole, Part, Slot
from beamcam.readers.ifc import kernel, read
from beamcam.readers.ifc.brep import (
    BrepError,
    Cone,
    Cylinder,
    Plane,
    Unnamed,
    surfaces_of,
)
from beamcam.readers.ifc.kernel import build_both
from beamcam.readers.ifc.space import cross, dot, size, sub
from tests.conftest import examples
from tests.unit.readers.ifc.models import Small, opened
from tests.unit.readers.ifc.test_features import contours, only

CUT = (1, 0, 0)
AXES = "0 0 0 0 0 1 1 0 0 0 1 0"


def two_plates(m: Small, *cutters: str) -> Part:
    """A plate 1100 x 200 x 20 of two solids, which only the kernel reads."""
    first = m.extruded(m.box(200, 20), 600.0)
    second = m.extruded(m.box(200, 20), 500.0, m.step.axes((600, 0, 0), CUT, (0, 1, 0)))
    m.element(m.minus(m.add(f"IFCBOOLEANRESULT(.UNION.,{first},{second})"), *cutters))
    return only(m)


def text(surface: str, places: str = "0", at: int = 0, root: int = 0, version: int = 2) -> str:
    """A solid of one face with one vertex and one edge beside it, as the kernel writes them."""
    uv = "" if version == 1 else "0 0 1 1"
    return f"""
CASCADE Topology V{version}, (c) Matra-Datavision
Locations {places}
Curve2ds 1
1 0 0 1 0
Curves 1
1 0 0 0 1 0 0
Polygon3D 0
PolygonOnTriangulations 0
Surfaces 1
{surface}
Triangulations 0

TShapes 5
Ve
1e-07
0 0 0
0 0

0101101
*
Ed
 1e-07 1 1 0
1  1 0 0 0.5
2  1 1 0 0 0.5
{uv}
3  1 1CN 1 0 0 0.5
{uv}
0

0101000
+5 0 -5 0 *
Wi

0101100
+4 0 *
Fa
0  1e-07 1 {at}
2 1

0111000
+3 0 *
So

0100000
+2 0 *
+1 {root} """


@settings(max_examples=examples(25), deadline=None)
@given(st.floats(6.0, 60.0), st.floats(60.0, 1040.0), st.floats(-60.0, 60.0), st.booleans())
def test_a_hole_comes_back_as_it_was_drilled(
    diameter: float, x: float, y: float, inches: bool
) -> None:
    m = Small(unit="inch" if inches else "mm")
    part = two_plates(m, m.hole((x, y, -50), (0, 0, 1), diameter, 100))
    (hole,) = (f for f in part.features if isinstance(f, Hole))
    assert hole.diameter == pytest.approx(diameter, abs=2e-9)
    # The plate may be seen from either side and either end.
    assert min(abs(hole.x - x), abs(1100 - hole.x - x)) < 1e-8
    assert min(abs(hole.y - 100 - y), abs(hole.y - 100 + y)) < 1e-8


def test_the_kernels_surfaces_are_those_of_the_model() -> None:
    m = Small()
    m.element(m.minus(m.extruded(m.box(200, 20), 600.0), m.hole((100, 30, -50), (0, 0, 1), 22, 99)))
    model = opened(m.data)
    (element,) = model.file.by_type("IfcBeam")
    _, found = build_both(model, element)
    assert {(round(c.radius, 9), tuple(map(abs, c.axis))) for c in found.cylinders} == {
        (11.0, (0.0, 0.0, 1.0))
    }
    assert {(round(c.frame.o[0], 9), round(c.frame.o[1], 9)) for c in found.cylinders} == {
        (100.0, 30.0)
    }
    assert found.others == ()


def test_the_corners_of_all_facets_lie_on_the_surfaces() -> None:
    """Mesh and text are of one solid, in one place, mirrored as well."""
    m = Small()
    solid = m.minus(
        m.extruded(m.ipe300(), 900.0), m.hole((200, -40, 50), (0, 1, 0), 22, 80),
    )  # fmt: skip
    shape = m.add(f"IFCSHAPEREPRESENTATION({m.step.context},'Body','CSG',({solid}))")
    source = m.add(f"IFCREPRESENTATIONMAP({m.step.world},{shape})")
    by = m.add(
        f"IFCCARTESIANTRANSFORMATIONOPERATOR3D({m.step.direction(0, 1, 0)},"
        f"{m.step.direction(1, 0, 0)},{m.step.point(10, 20, 30)},2.,{m.step.direction(0, 0, 1)})"
    )
    m.element(m.add(f"IFCMAPPEDITEM({source},{by})"))
    model = opened(m.data)
    (element,) = model.file.by_type("IfcBeam")
    built, exact = build_both(model, element)
    points, cylinders = built.shell.points, exact.cylinders
    assert {round(c.radius, 9) for c in cylinders} == {22.0, 30.0}
    for one in cylinders:
        reach = [size(cross(sub(p, one.frame.o), one.axis)) for p in points]
        assert sum(abs(r - one.radius) < 1e-7 for r in reach) >= 6


def test_a_short_arc_keeps_its_radius() -> None:
    """The radius is the cylinder's own, to the last digit."""
    m = Small()
    part = two_plates(m, m.hole((500, 395, -50), (0, 0, 1), 600, 100))
    arcs = [c for c in contours(part)["v", "outer"].curves if isinstance(c, Arc)]
    assert [a.radius for a in arcs] == [pytest.approx(300.0, abs=1e-12)]


def test_a_nick_in_a_long_edge_is_not_lost() -> None:
    """It is 3 mm2 of 220,000, and half a millimetre deep."""
    m = Small()
    part = two_plates(m, m.hole((500, 119.5, -50), (0, 0, 1), 40, 100))
    arcs = [c for c in contours(part)["v", "outer"].curves if isinstance(c, Arc)]
    assert [a.radius for a in arcs] == [pytest.approx(20.0, abs=1e-9)]


def test_a_slot_made_less_round_for_the_kernel_is_as_round_as_it_was() -> None:
    m = Small()
    profile = m.add(f"IFCROUNDEDRECTANGLEPROFILEDEF(.AREA.,$,{m.flat},62.,22.,11.)")
    at = m.step.axes((300, 20, -50), (0, 0, 1), (1, 0, 0))
    part = two_plates(m, m.extruded(profile, 100.0, at))
    (slot,) = (f for f in part.features if isinstance(f, Slot))
    assert (slot.diameter, slot.length, slot.height) == pytest.approx((22.0, 40.0, 0.0), abs=1e-5)


@pytest.mark.parametrize("version", [1, 2, 3])
@pytest.mark.parametrize(
    ("surface", "kind"),
    [
        (f"1 {AXES}", Plane),
        (f"2 {AXES} 0.5", Cylinder),
        (f"3 {AXES} 0.5 0.25", Cone),
        (f"6 0 0 1 2 {AXES} 0.5", Cylinder),
        ("6 0 0 1 1 0 0 0 1 0 0", Plane),
        (f"10 0 1 0 1 2 {AXES} 0.5", Cylinder),
        (f"6 0 0 1 8 0 1 2 {AXES} 0.5", Cylinder),
    ],
)
def test_surfaces_of_every_version(surface: str, kind: type, version: int) -> None:
    (found,) = surfaces_of(text(surface, version=version))
    assert isinstance(found, kind)
    assert getattr(found, "radius", 500.0) == 500.0


@pytest.mark.parametrize(
    ("surface", "name"),
    [
        (f"4 {AXES} 1", "sphere"),
        (f"5 {AXES} 2 1", "torus"),
        (f"6 0 0.6 0.8 2 {AXES} 0.5", "circle extruded at a slant"),
        (f"6 0 0 1 3 {AXES} 2 1", "extruded ellipse"),
        (f"6 0 0 1 4 {AXES} 2", "extruded parabola"),
        (f"6 0 0 1 5 {AXES} 2 1", "extruded hyperbola"),
        ("6 0 0 1 6 1 1 0 0 0 1 1 0 0 1", "extruded Bezier curve"),
        ("6 0 0 1 7 0 0 1 2 2 0 0 0 1 0 0 0 2 1 2", "extruded B-spline curve"),
        (f"6 0 0 1 9 1 0 0 1 2 {AXES} 0.5", "extruded offset curve"),
        (f"7 0 0 0 0 0 1 2 {AXES} 0.5", "surface of revolution"),
        ("8 0 0 1 1 0 0 0 1 0 0 0 1 0 1 1 0", "Bezier surface"),
        ("9 0 0 0 0 1 1 2 2 2 2 0 0 0 1 0 0 0 1 0 1 1 0 0 2 1 2 0 2 1 2", "B-spline surface"),
        (
            "9 1 0 0 0 1 1 2 2 2 2 0 0 0 1 1 0 0 1 0 1 0 1 1 1 0 1 0 2 1 2 0 2 1 2",
            "B-spline surface",
        ),
        (f"11 1 2 {AXES} 0.5", "offset surface"),
    ],
)
def test_other_surfaces_are_named(surface: str, name: str) -> None:
    assert surfaces_of(text(surface)) == (Unnamed(name),)


def test_locations_are_put_to_the_left_and_raised_to_powers() -> None:
    """A quarter turn about z, then 1 along x: the face is where the matrices' product says."""
    turn, step = "1 0 -1 0 0 1 0 0 0 0 0 1 0", "1 1 0 0 1 0 1 0 0 0 0 1 0"
    surface = "2 3 0 0 0 0 1 1 0 0 0 1 0 0.5"

    def at(both: str) -> tuple[float, ...]:
        (found,) = surfaces_of(text(surface, f"3 {turn} {step} {both}", 0, 3))
        assert isinstance(found, Cylinder)
        return tuple(round(v, 6) for v in found.frame.o)

    assert at("2 1 1 2 1 0") == (1000.0, 3000.0, 0.0)  # turned, then moved
    assert at("2 2 1 1 1 0") == (0.0, 4000.0, 0.0)  # moved, then turned
    assert at("2 2 -3 0") == (0.0, 0.0, 0.0)  # three steps back
    (found,) = surfaces_of(text(surface, f"2 {turn} {step}", 1, 2))
    assert isinstance(found, Cylinder)
    assert hypot(found.frame.o[0] - 1000, found.frame.o[1] - 3000) < 1e-9
    assert dot(found.axis, (0, 0, 1)) == 1.0


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        ("no solid", "found 'no solid'"),
        (text(f"1 {AXES}", version=4), "found version 4"),
        (text(f"12 {AXES}"), "found surface type '12'"),
        ("CASCADE Topology V2, \nLocations 0\nCurves 0", "found no table 'Surfaces'"),
        (text("6 0 0 1 10 1"), "found curve type '10'"),
        (text(f"1 {AXES}").replace("Wi", "Xx"), "found shape 'Xx'"),
        (text(f"1 {AXES}")[:-10], "found the end of the text"),
        (text(f"1 {AXES}").replace("+1 0", "+9 0"), "found a table that does not hold"),
        (text(f"1 {AXES}").replace("+2 0", "2 0"), "found part '2'"),
        (text("1 0 0 x 0 0 1 1 0 0 0 1 0"), "could not convert"),
        ("CASCADE Topology V2, Locations 0 Surfaces 0 TShapes 1 Ed 0 1 1 0", "found no flags"),
    ],
)
def test_what_is_no_brep_is_said(broken: str, said: str) -> None:
    with pytest.raises(BrepError, match="found") as caught:
        surfaces_of(broken)
    assert said in str(caught.value)


def test_a_text_that_is_not_understood_refuses_the_member(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_text(_text: str) -> tuple[()]:
        return surfaces_of("CASCADE Topology V9, ")  # type: ignore[return-value]

    monkeypatch.setattr(kernel, "surfaces_of", no_text)
    m = Small()
    slab = m.extruded(m.box(200, 20), 600.0)
    m.element(m.add(f"IFCBOOLEANRESULT(.UNION.,{slab},{slab})"))
    found = read(m.data, "m.ifc")
    assert found.parts == ()
    (said,) = [d.message for d in found.diagnostics if d.code == "ifc-geometry"]
    assert "not understood (found version 9; expected one of 1, 2, 3)" in said
