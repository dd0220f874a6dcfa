"""The BREP text of the kernel: exact cylinders, and what is said of other texts."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc
from beamcam.model.part import Hole, Part, Slot
from beamcam.readers.ifc import kernel, read
from beamcam.readers.ifc.brep import BrepError, surfaces_of
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
    found = build_both(model, element)
    upright = [c for c in found.shell.cylinders if abs(c.axis[2]) == 1.0]
    assert {round(c.radius, 9) for c in found.shell.cylinders} == {11.0}
    assert (100.0, 30.0) in {tuple(round(v, 9) for v in c.frame.o[:2]) for c in upright}
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
    built = build_both(model, element)
    points, cylinders = built.shell.points, built.shell.cylinders
    assert {round(c.radius, 9) for c in cylinders} == {22.0, 30.0}
    on = {22.0: 0, 30.0: 0}
    for one in cylinders:
        reach = [size(cross(sub(p, one.frame.o), one.axis)) for p in points]
        on[round(one.radius, 9)] += sum(abs(r - one.radius) < 1e-7 for r in reach)
    assert min(on.values()) >= 6


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
    ("surface", "cylinders"),
    [
        (f"1 {AXES}", 0),
        (f"2 {AXES} 0.5", 1),
        (f"3 {AXES} 0.5 0.25", 0),
        (f"6 0 0 1\n2 {AXES} 0.5", 1),
        ("6 0 0 1\n1 0 0 0 1 0 0", 0),
        (f"10 0 1 0 1\n2 {AXES} 0.5", 1),
    ],
)
def test_surfaces_of_every_version(surface: str, cylinders: int, version: int) -> None:
    found, others = surfaces_of(text(surface, version=version))
    assert ([c.radius for c in found], others) == ([500.0] * cylinders, ())


@pytest.mark.parametrize(
    ("surface", "name"),
    [
        (f"4 {AXES} 1", "sphere"),
        (f"5 {AXES} 2 1", "torus"),
        (f"6 0 0.6 0.8\n2 {AXES} 0.5", "extruded curve"),
        (f"6 0 0 1\n3 {AXES} 2 1", "extruded curve"),
        ("7 0 0 0 0 0 1\n3 0 0 0", "surface of revolution"),
        ("8 0 0 1 1\n0 0 0 1 0 0\n0 1 0 1 1 0", "Bezier surface"),
        ("9 0 0 0 0 1 1 2 2 2 2\n0 0 0 1 0 0\n0 1 0 1 1 0\n0 2\n1 2", "B-spline surface"),
    ],
)
def test_other_surfaces_are_named(surface: str, name: str) -> None:
    assert surfaces_of(text(surface))[1] == (name,)


def test_a_cylinder_is_given_wherever_its_face_may_be() -> None:
    """A quarter turn about z, then 1 along x: also where the matrices' product says."""
    turn, step = "1\n0 -1 0 0\n1 0 0 0\n0 0 1 0", "1\n1 0 0 1\n0 1 0 0\n0 0 1 0"
    surface = "2 3 0 0 0 0 1 1 0 0 0 1 0 0.5"

    def at(places: str) -> set[tuple[float, ...]]:
        found, _ = surfaces_of(text(surface, places, 0, 3))
        assert all(dot(c.axis, (0, 0, 1)) == 1.0 for c in found)
        return {tuple(round(v, 6) + 0.0 for v in c.frame.o) for c in found}

    assert at("0") == {(3000.0, 0.0, 0.0)}
    both = at(f"2\n{turn}\n{step}")
    assert both >= {(1000.0, 3000.0, 0.0), (0.0, 4000.0, 0.0)}
    assert (1000.0, 4000.0, 0.0) in at(f"3\n{turn}\n{step}\n2  1 1 2 1 0") - {(3000.0, 0.0, 0.0)}
    assert (0.0, 0.0, 0.0) in at(f"3\n{turn}\n{step}\n2  2 -3 0")  # three steps back


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        ("no solid", "found 'no solid'"),
        ("CASCADE Topology V2, \nLocations 0\nCurves 0", "found no table"),
        (text(f"1 {AXES}", "1\n1\n1 0 0"), "found a table that does not hold"),
        (text(f"1 {AXES}", "1\n2 7 1 0"), "found a table that does not hold"),
        (text("2 0 0 x 0 0 1 1 0 0 0 1 0 1"), "could not convert"),
    ],
)
def test_what_is_no_brep_is_said(broken: str, said: str) -> None:
    with pytest.raises(BrepError, match="found") as caught:
        surfaces_of(broken)
    assert said in str(caught.value)


def test_a_text_that_is_not_understood_refuses_the_member(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_text(_text: str) -> tuple[()]:
        return surfaces_of("CASCADE")  # type: ignore[return-value]

    monkeypatch.setattr(kernel, "surfaces_of", no_text)
    m = Small()
    slab = m.extruded(m.box(200, 20), 600.0)
    m.element(m.add(f"IFCBOOLEANRESULT(.UNION.,{slab},{slab})"))
    found = read(m.data, "m.ifc")
    assert found.parts == ()
    (said,) = [d.message for d in found.diagnostics if d.code == "ifc-geometry"]
    assert "not understood (found 'CASCADE'; expected 'CASCADE Topology V')" in said
