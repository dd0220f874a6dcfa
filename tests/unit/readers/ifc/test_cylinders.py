"""The cylinders of the kernel's solids, by its facets and their normals."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc
from beamcam.model.part import Hole, Part, Slot
from beamcam.readers.ifc.kernel import Built, built
from tests.conftest import examples
from tests.unit.readers.ifc.models import Small, opened
from tests.unit.readers.ifc.test_features import contours, only

CUT = (1, 0, 0)


def two_plates(m: Small, *cutters: str) -> Part:
    """A plate 1100 x 200 x 20 of two solids, which only the kernel reads."""
    first = m.extruded(m.box(200, 20), 600.0)
    second = m.extruded(m.box(200, 20), 500.0, m.step.axes((600, 0, 0), CUT, (0, 1, 0)))
    m.element(m.minus(m.add(f"IFCBOOLEANRESULT(.UNION.,{first},{second})"), *cutters))
    return only(m)


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
    found = built(model, element, {})
    upright = [c for c in found.shell.cylinders if abs(c.axis[2]) == 1.0]
    assert {round(c.radius, 9) for c in found.shell.cylinders} == {11.0}
    assert (100.0, 30.0) in {tuple(round(v, 9) for v in c.point[:2]) for c in upright}
    assert found.others == ()


def test_the_corners_of_all_facets_lie_on_the_surfaces() -> None:
    """In one place, of a solid that is mirrored and twice as large as well."""
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
    found = built(model, element, {})
    points, cylinders = found.shell.points, found.shell.cylinders
    assert {round(c.radius, 9) for c in cylinders} == {22.0, 30.0}
    on = {22.0: 0, 30.0: 0}
    for one in cylinders:
        on[round(one.radius, 9)] += int((one.off(points) < 1e-7).sum())
    assert min(on.values()) >= 6


def test_a_short_arc_keeps_its_radius() -> None:
    """The radius is the cylinder's own, though a facet or two stand for it."""
    m = Small()
    part = two_plates(m, m.hole((500, 395, -50), (0, 0, 1), 600, 100))
    arcs = [c for c in contours(part)["v", "outer"].curves if isinstance(c, Arc)]
    assert [a.radius for a in arcs] == [pytest.approx(300.0, abs=1e-9)]


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


def solid(m: Small, item: str) -> Built:
    m.element(item)
    model = opened(m.data)
    return built(model, *model.file.by_type("IfcBeam"), {})


def test_the_kernels_cylinders_are_given_once_each_and_cones_are_not_told() -> None:
    m = Small()
    at = m.step.axes((300, 0, 0), (0, 0, 1), (1, 0, 0))
    cone = m.add(f"IFCRIGHTCIRCULARCONE({at},50.,30.)")
    rod = m.extruded(m.add(f"IFCCIRCLEPROFILEDEF(.AREA.,$,{m.flat},20.)"), 600.0)
    found = solid(m, m.minus(rod, cone))
    assert [round(c.radius, 9) for c in found.shell.cylinders] == [20.0]
    assert found.others == ()


@pytest.mark.parametrize("profile", ["IFCELLIPSEPROFILEDEF(.AREA.,$,{0},40.,20.)"])
def test_a_curved_surface_of_another_form_is_told(profile: str) -> None:
    m = Small()
    found = solid(m, m.extruded(m.add(profile.format(m.flat)), 600.0))
    assert found.shell.cylinders == ()
    assert found.others == ("a curved surface of another form",)


def test_a_sphere_is_told() -> None:
    m = Small()
    at = m.step.axes((300, 0, 0), (0, 0, 1), (1, 0, 0))
    found = solid(m, m.minus(m.extruded(m.box(200, 20), 600.0), m.add(f"IFCSPHERE({at},30.)")))
    assert found.others == ("a curved surface of another form",)
