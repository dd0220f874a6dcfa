"""Copes, notches, bevels, plates, pipes: what a cut leaves on which face."""

import pytest

from beamcam.model.part import Contour, EndPlane, Hole, Part, Slot
from beamcam.readers.ifc import Options, read
from tests.unit.readers.ifc.models import ORIGIN, Small

CUT = (1, 0, 0)


def only(m: Small, **options: bool) -> Part:
    found = read(m.data, "m.ifc", options=Options(**options))
    assert not found.refused, found.diagnostics
    (part,) = found.parts
    return part


def contours(part: Part) -> dict[tuple[str, str], Contour]:
    return {(f.face, f.kind): f for f in part.features if isinstance(f, Contour)}


def corners(contour: Contour) -> set[tuple[float, float]]:
    return {(round(c.start[0], 2) + 0.0, round(c.start[1], 2) + 0.0) for c in contour.curves}


def test_a_cope_shows_on_web_and_flange() -> None:
    """A block 100 long takes the top flange and 40 mm of the web at the end."""
    m = Small()
    block = m.extruded(m.box(200, 80), 100.0, m.step.axes((1900, 0, 150), CUT, (0, 1, 0)))
    part = only_with(m, block)
    found = contours(part)
    assert set(found) == {("v", "outer"), ("o", "outer")}
    assert corners(found["v", "outer"]) == {
        (0, 0), (2000, 0), (2000, 260), (1900, 260), (1900, 300), (0, 300)
    }  # fmt: skip
    assert corners(found["o", "outer"]) == {(0, 0), (1900, 0), (1900, 150), (0, 150)}
    assert part.length == pytest.approx(2000.0)
    assert part.cuts.web_end == 0.0


def only_with(m: Small, *cutters: str, length: float = 2000.0) -> Part:
    m.element(m.minus(m.extruded(m.ipe300(), length), *cutters))
    return only(m, kernel=True)


def test_a_rat_hole_keeps_its_radius() -> None:
    """A cylinder at the web's upper corner leaves an arc in the web's outline."""
    m = Small()
    part = only_with(m, m.hole((2000, -20, 130), (0, 1, 0), 50, 40))
    outline = contours(part)["v", "outer"]
    radii = [round(c.radius, 4) for c in outline.curves if hasattr(c, "radius")]
    assert radii
    assert set(radii) == {25.0}


def test_contours_run_as_dstv_has_them() -> None:
    """Outer ones counter-clockwise seen from outside: clockwise in the numbers of o."""
    from beamcam.geometry.curves import signed_area

    m = Small()
    block = m.extruded(m.box(200, 80), 100.0, m.step.axes((1900, 0, 150), CUT, (0, 1, 0)))
    found = contours(only_with(m, block))
    assert signed_area(found["v", "outer"].curves) > 0
    assert signed_area(found["o", "outer"].curves) < 0


def test_a_large_opening_is_an_inner_contour() -> None:
    m = Small()
    at = m.step.axes((1000, -20, 0), (0, 1, 0), (1, 0, 0))
    part = only_with(m, m.extruded(m.box(200, 120), 40.0, at))
    inner = contours(part)["v", "inner"]
    assert corners(inner) == {(900, 90), (1100, 90), (1100, 210), (900, 210)}


@pytest.mark.parametrize(
    ("normal", "web", "flange"),
    [
        ((1, 0, 0), 0.0, 0.0),
        ((0.8660254037844387, 0, 0.5), 30.0, 0.0),
        ((0.8660254037844387, 0.5, 0), 0.0, -30.0),
    ],
)
def test_end_angles_have_dstv_signs(
    normal: tuple[float, float, float], web: float, flange: float
) -> None:
    """Positive at the end: the bottom edge is the longest."""
    m = Small()
    part = only_with(m, m.half((1700, 0, 0), normal))
    assert part.cuts.web_end == pytest.approx(web, abs=1e-9)
    assert part.cuts.flange_end == pytest.approx(flange, abs=1e-9)
    assert contours(part) == {}


def test_a_compound_end_is_a_plane_too() -> None:
    m = Small()
    n = (0.8, 0.36, 0.48)
    part = only_with(m, m.half((1700, 0, 0), n))
    (plane,) = (f for f in part.features if isinstance(f, EndPlane))
    assert sum(v * v for v in plane.normal) == pytest.approx(1.0)
    assert plane.normal[0] == pytest.approx(0.8)
    assert part.cuts.web_end == pytest.approx(30.963757, abs=1e-5)


def test_a_box_across_the_end_is_a_saw_cut() -> None:
    """SkewedEnd of the AISC view: a prism that takes everything beyond a plane."""
    m = Small()
    wedge = m.polygon((1700, -400), (2600, -400), (2600, 400), (2100, 400))
    at = m.step.axes((0, 200, 0), (0, -1, 0), (1, 0, 0))
    part = only_with(m, m.extruded(wedge, 400.0, at))
    assert part.cuts.web_end == pytest.approx(-26.565051, abs=1e-5)
    assert contours(part) == {}
    assert part.length == pytest.approx(1975.0)


def test_a_plane_that_removes_nothing_changes_nothing() -> None:
    m = Small()
    part = only_with(m, m.half((2000, 0, 0), (1, 0, 0)), m.half((2400, 0, 0), (0.8, 0, 0.6)))
    assert part.length == 2000.0
    assert part.cuts.web_end == 0.0


def test_far_anchors_do_not_move_the_cut() -> None:
    """Planes are anchored half a million metres away by some exporters."""
    m = Small()
    c, s = 0.9396926207859084, 0.3420201433256687
    far = 4.5e8
    part = only_with(m, m.half((1700 - s * far, 0, c * far), (c, 0, s)))
    assert part.cuts.web_end == pytest.approx(20.0, abs=1e-6)
    assert part.length == pytest.approx(1700 + 150 * s / c, abs=0.01)


def test_a_blind_hole_has_its_depth() -> None:
    m = Small()
    m.element(m.minus(m.extruded(m.box(200, 30), 900.0), m.hole((300, 40, 5), (0, 0, 1), 20, 20)))
    (hole,) = (f for f in only(m).features if isinstance(f, Hole))
    assert hole.depth == pytest.approx(10.0)
    assert hole.kind == "blind"


def test_holes_of_a_pipe_are_unrolled() -> None:
    from math import pi

    m = Small()
    pipe = m.add(f"IFCCIRCLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},60.,5.)")
    m.element(m.minus(m.extruded(pipe, 1500.0), m.hole((400, -80, 0), (0, 1, 0), 14, 160)))
    part = only(m, kernel=True)
    assert (part.profile.code, part.profile.height, part.profile.web_thickness) == ("RO", 120, 5)
    holes = [f for f in part.features if isinstance(f, Hole)]
    assert [h.face for h in holes] == ["v", "v"]
    assert sorted(h.y for h in holes) == pytest.approx([30 * pi, 90 * pi])


def test_a_plate_with_hollows_lies_along_its_longer_side() -> None:
    m = Small()
    outer = m.add(f"IFCPOLYLINE(({','.join(m.step.point(*p) for p in RING)}))")
    hollow = m.add(f"IFCCIRCLE({m.flat},12.)")
    profile = m.add(f"IFCARBITRARYPROFILEDEFWITHVOIDS(.AREA.,'PL20',{outer},({hollow}))")
    m.element(m.extruded(profile, 20.0), "IFCPLATE")
    part = only(m, kernel=True)
    assert (part.profile.code, part.profile.web_thickness) == ("B", 20.0)
    assert (part.length, part.profile.height) == pytest.approx((400.0, 150.0))
    (hole,) = (f for f in part.features if isinstance(f, Hole))
    assert hole.diameter == pytest.approx(24.0)
    assert ("v", "outer") in contours(part)


RING = ((-75, -100), (75, -100), (75, 250), (25, 300), (-75, 300), (-75, -100))


def test_a_bolt_through_both_flanges_makes_two_holes() -> None:
    m = Small()
    m.element(m.extruded(m.ipe300(), 2000.0))
    m.bolt((300, 40, -170), (0, 0, 1), 20.0, 340.0)
    found = read(m.data, "m.ifc")
    holes = [f for f in found.parts[0].features if isinstance(f, Hole)]
    assert [(h.face, round(h.x, 3), round(h.y, 3), h.diameter) for h in holes] == [
        ("o", 300.0, 35.0, 22.0), ("u", 300.0, 35.0, 22.0)
    ]  # fmt: skip
    assert all(h.source.where != found.parts[0].guid for h in holes)
    assert read(m.data, "m.ifc", options=Options(bolts=False)).parts[0].features == ()
    wide = read(m.data, "m.ifc", options=Options(clearance=1.0)).parts[0]
    assert {h.diameter for h in wide.features if isinstance(h, Hole)} == {21.0}


@pytest.mark.parametrize(
    ("bolt", "hole"), [(12, 13), (16, 18), (20, 22), (24, 26), (30, 33), (19.05, 20.6375)]
)
def test_clearances_are_the_standards(bolt: float, hole: float) -> None:
    from beamcam.readers.ifc.bolts import hole_for

    assert hole_for(bolt, None) == pytest.approx(hole)


def special(m: Small) -> str:
    """A solid over a bent plate, which is no rolled form."""
    corners = ((0, 0), (60, 0), (60, 8), (8, 8), (8, 100), (-52, 100), (-52, 92), (0, 92))
    return m.extruded(m.polygon(*corners), 2000.0)


def test_a_special_section_is_sawn() -> None:
    m = Small()
    m.element(m.minus(special(m), m.half((1900, 0, 0), (0.8, 0.6, 0))))
    part = only(m)
    assert part.profile.code == "SO"
    assert max(abs(part.cuts.web_end), abs(part.cuts.flange_end)) == pytest.approx(36.87, abs=0.01)


def test_a_hole_in_a_special_section_is_refused_and_not_lost() -> None:
    m = Small()
    m.element(m.minus(special(m), m.hole((500, -20, 50), (0, 1, 0), 18.0, 60.0)))
    found = read(m.data, "m.ifc")
    assert found.parts == ()
    (said,) = [d for d in found.diagnostics if d.severity.value == "error"]
    assert said.code == "ifc-special-cut"


def test_a_pipe_may_have_holes_and_mitres() -> None:
    m = Small()
    pipe = m.extruded(m.add(f"IFCCIRCLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},50.,5.)"), 2000.0)
    mitre, hole = m.half((1900, 0, 0), (0.8, 0.6, 0)), m.hole((500, -80, 0), (0, 1, 0), 18.0, 160.0)
    m.element(m.minus(pipe, mitre, hole))
    part = only(m)
    assert part.profile.code == "RO"
    assert part.length == pytest.approx(1900 + 0.75 * 50)
    drilled = [f for f in part.features if isinstance(f, Hole)]
    assert [(h.x, h.diameter) for h in drilled] == [(500.0, 18.0)] * 2
    assert abs(drilled[0].y - drilled[1].y) == pytest.approx(50 * 3.14159265, abs=1e-3)


def test_fabrication_data_come_first() -> None:
    m = Small()
    e = m.element(m.extruded(m.ipe300(), 900.0), tag="ID-12", name="IPE300")
    m.material(e, "STEEL/S355J2")
    m.assembly(e, "A7")
    m.properties(e, "AISC_EM11_Pset_PieceIdentification", PieceMark="IFCLABEL('p12')")
    part = only(m)
    assert (part.mark, part.drawing, part.grade, part.profile.name) == (
        "p12", "A7", "S355J2", "IPE300"
    )  # fmt: skip
    assert part.weight == pytest.approx(42.2, abs=0.1)


def test_a_union_of_solids_is_read_by_the_kernel() -> None:
    m = Small()
    first = m.extruded(m.box(200, 20), 600.0)
    second = m.extruded(m.box(200, 20), 500.0, m.step.axes((600, 0, 0), CUT, (0, 1, 0)))
    m.element(m.add(f"IFCBOOLEANRESULT(.UNION.,{first},{second})"))
    part = only(m)
    assert (part.profile.code, part.length) == ("B", pytest.approx(1100.0))


def test_a_mapped_body_may_be_scaled() -> None:
    m = Small()
    solid = m.extruded(m.box(100, 10), 50.0)
    shape = m.add(f"IFCSHAPEREPRESENTATION({m.step.context},'Body','SweptSolid',({solid}))")
    source = m.add(f"IFCREPRESENTATIONMAP({m.step.world},{shape})")
    by = m.add(f"IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,{m.step.point(*ORIGIN)},10.,$)")
    m.element(m.add(f"IFCMAPPEDITEM({source},{by})"))
    part = only(m)
    assert sorted((part.length, part.profile.height)) == pytest.approx([500.0, 1000.0])


def test_slots_across_a_face_keep_their_angle() -> None:
    m = Small()
    profile = m.add(f"IFCROUNDEDRECTANGLEPROFILEDEF(.AREA.,$,{m.flat},62.,22.,11.)")
    at = m.step.axes((800, -20, 0), (0, 1, 0), (0.6, 0, 0.8))
    part = only_with(m, m.extruded(profile, 40.0, at))
    (slot,) = (f for f in part.features if isinstance(f, Slot))
    assert slot.angle == pytest.approx(53.130102, abs=1e-5)


def polygon_bound(m: Small, half_origin: tuple[float, float, float], x: float) -> str:
    """A square-cut half-space beyond z, kept to one end of the beam by a polygon."""
    plane = m.add(f"IFCPLANE({m.step.axes(half_origin, (0, 0, 1), CUT)})")
    ring = ((x, -200), (2400, -200), (2400, 200), (x, 200), (x, -200))
    line = m.add(f"IFCPOLYLINE(({','.join(m.step.point(*p) for p in ring)}))")
    return m.add(f"IFCPOLYGONALBOUNDEDHALFSPACE({plane},.F.,{m.step.world},{line})")


def test_a_bounded_half_space_is_a_cope() -> None:
    """Everything above 100 over the axis, beyond x 1850."""
    m = Small()
    part = only_with(m, polygon_bound(m, (0, 0, 100), 1850))
    found = contours(part)
    assert corners(found["v", "outer"]) == {
        (0, 0), (2000, 0), (2000, 250), (1850, 250), (1850, 300), (0, 300)
    }  # fmt: skip
    assert corners(found["o", "outer"]) == {(0, 0), (1850, 0), (1850, 150), (0, 150)}


def test_a_cut_that_is_itself_cut_leaves_an_island() -> None:
    """A cutter of two operands: the second gives back what the first would take."""
    m = Small()
    block = m.extruded(m.box(200, 80), 100.0, m.step.axes((1900, 0, 150), CUT, (0, 1, 0)))
    saved = m.extruded(m.box(200, 80), 40.0, m.step.axes((1960, 0, 150), CUT, (0, 1, 0)))
    part = only_with(m, m.minus(block, saved))
    found = contours(part)
    assert corners(found["v", "outer"]) == {
        (0, 0), (2000, 0), (2000, 300), (1960, 300), (1960, 260), (1900, 260), (1900, 300), (0, 300)
    }  # fmt: skip


def test_a_brep_may_be_the_cutter() -> None:
    m = Small()
    low, high = (1900.0, -100.0, 110.0), (2100.0, 100.0, 190.0)
    p = {
        (i, j, k): m.step.point((low, high)[i][0], (low, high)[j][1], (low, high)[k][2])
        for i in (0, 1) for j in (0, 1) for k in (0, 1)
    }  # fmt: skip
    faces = []
    for axis in range(3):
        for side in (0, 1):
            ring = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                key = [a, b]
                key.insert(axis, side)
                ring.append(p[key[0], key[1], key[2]])
            loop = m.add(f"IFCPOLYLOOP(({','.join(ring)}))")
            faces.append(m.add(f"IFCFACE(({m.add(f'IFCFACEOUTERBOUND({loop},.T.)')}))"))
    shell = m.add(f"IFCCLOSEDSHELL(({','.join(faces)}))")
    brep = m.add(f"IFCFACETEDBREP({shell})")
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), brep))
    found = contours(only(m))
    assert corners(found["v", "outer"]) == {
        (0, 0), (2000, 0), (2000, 260), (1900, 260), (1900, 300), (0, 300)
    }  # fmt: skip


def test_a_weld_preparation_is_a_bevel() -> None:
    """A wedge along the top flange's end leaves its upper edge back by its thickness."""
    m = Small()
    wedge = m.polygon((2000, 139.3), (2000, 151), (1988.3, 151))
    at = m.step.axes((0, 100, 0), (0, -1, 0), (1, 0, 0))
    part = only_with(m, m.extruded(wedge, 200.0, at))
    bevels = contours(part)["o", "outer"].bevels
    assert [round(b.angle, 1) for b in bevels] == [45.0]
    assert part.length == pytest.approx(2000.0)


def test_a_gusset_slot_is_open_at_the_end_of_a_tube() -> None:
    m = Small()
    tube = m.add(f"IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},100.,120.,8.,$,$)")
    slit = m.extruded(m.box(12, 200), 300.0, m.step.axes((800, 0, 0), CUT, (0, 1, 0)))
    m.element(m.minus(m.extruded(tube, 1000.0), slit))
    part = only(m, kernel=True)
    assert set(contours(part)) == {("o", "outer"), ("u", "outer")}
    assert (800.0, 44.0) in corners(contours(part)["o", "outer"])
    assert part.length == pytest.approx(1000.0)


def test_a_tee_cut_from_a_beam_is_a_tee() -> None:
    """A half-space along the axis takes the top flange: another section, told by its solid."""
    m = Small()
    profile = m.add(f"IFCISHAPEPROFILEDEF(.AREA.,$,{m.flat},150.,300.,7.1,10.7,$,$,$)")
    m.element(m.minus(m.extruded(profile, 2000.0), m.half((0, 0, 20), (0, 0, 1))))
    part = only(m)
    assert part.profile.code == "T"
    assert (part.profile.height, part.profile.width) == pytest.approx((150.0, 170.0), abs=0.01)
    assert part.length == pytest.approx(2000.0)


def test_a_flange_that_is_planed_thinner_is_refused() -> None:
    """A part has flanges of one thickness; five millimetres off the whole length are told."""
    m = Small()
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), m.half((0, 0, 145), (0, 0, 1))))
    found = read(m.data, "m.ifc", options=Options(kernel=True))
    assert found.parts == ()
    (said,) = [d for d in found.diagnostics if d.code == "ifc-unexplained"]
    assert "cm3 less on face o at x 0.0 to 2000.0" in said.message


def test_a_union_of_rolled_sections_is_read_by_the_kernel() -> None:
    """Three lengths of one beam end to end, drilled, as exporters break a beam into pieces."""
    m = Small()
    pieces = [
        m.extruded(m.ipe300(), 500.0, m.step.axes((x, 0, 0), CUT, (0, 1, 0)))
        for x in (0, 500, 1000)
    ]
    body = m.add(f"IFCBOOLEANRESULT(.UNION.,{pieces[0]},{pieces[1]})")
    body = m.add(f"IFCBOOLEANRESULT(.UNION.,{body},{pieces[2]})")
    m.element(m.minus(body, m.hole((700, -20, 0), (0, 1, 0), 22, 40)))
    part = only(m)
    assert part.profile.code == "I"
    assert part.length == pytest.approx(1500.0, abs=0.01)
    measured = (part.profile.height, part.profile.width, part.profile.flange_thickness)
    assert measured == pytest.approx((300.0, 150.0, 10.7), abs=0.05)
    (hole,) = (f for f in part.features if isinstance(f, Hole))
    assert hole.diameter == pytest.approx(22.0, abs=0.02)


def opening_of(part: Part) -> tuple[float, float]:
    """Length and height of the one opening of the web."""
    (found,) = (f for f in part.features if isinstance(f, Contour))
    assert (found.face, found.kind) == ("v", "inner")
    boxes = [c.bbox for c in found.curves]
    across = max(b[2] for b in boxes) - min(b[0] for b in boxes)
    return across, max(b[3] for b in boxes) - min(b[1] for b in boxes)


def test_a_circle_that_is_pushed_askew_is_no_round_hole() -> None:
    """It leans 30 degrees, and is pushed square through the web: an ellipse is left."""
    m = Small()
    at = m.step.axes((1000, -50, 0), (0.5, 0.75**0.5, 0), (0.75**0.5, -0.5, 0))
    way = m.step.direction(-0.5, 0, 0.75**0.5)
    askew = m.add(f"IFCEXTRUDEDAREASOLID({m.circle(40)},{at},{way},100.)")
    part = only_with(m, askew)
    assert opening_of(part) == pytest.approx((40 * 0.75**0.5, 40.0), abs=0.01)


@pytest.mark.parametrize("kind", ["extrusion", "cylinder"])
def test_a_circle_that_is_stretched_by_its_map_is_no_round_hole(kind: str) -> None:
    m = Small()
    hole = m.hole((0, -50, 0), (0, 1, 0), 40, 100)
    if kind == "cylinder":
        hole = m.add(
            f"IFCRIGHTCIRCULARCYLINDER({m.step.axes((0, -50, 0), (0, 1, 0), CUT)},100.,20.)"
        )
    shape = m.add(f"IFCSHAPEREPRESENTATION({m.step.context},'Body','SweptSolid',({hole}))")
    source = m.add(f"IFCREPRESENTATIONMAP({m.step.world},{shape})")
    by = m.add(
        "IFCCARTESIANTRANSFORMATIONOPERATOR3DNONUNIFORM"
        f"($,$,{m.step.point(1000, 0, 0)},1.5,$,1.,1.)"
    )
    stretched = m.add(f"IFCMAPPEDITEM({source},{by})")
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), stretched))
    # The kernel's own map does not take a circle that is stretched.
    assert opening_of(only(m, kernel=False)) == pytest.approx((60.0, 40.0), abs=0.01)


@pytest.mark.parametrize("second", ["equal", "deeper", "wider", "higher", "named"])
def test_members_of_one_form_are_read_once_and_others_are_not(second: str) -> None:
    """Two beams whose holes differ in one measure, or only in what their profiles are called."""
    m = Small()
    drilled = {"depth": 100.0, "diameter": 22.0, "z": 30.0}
    changed = {"deeper": {"depth": 50.0 + 2.0}, "wider": {"diameter": 26.0}, "higher": {"z": 40.0}}
    for tag, h in (("B1", drilled), ("B2", drilled | changed.get(second, {}))):
        profile = m.ipe300()
        if second == "named" and tag == "B2":
            profile = m.add(
                f"IFCISHAPEPROFILEDEF(.AREA.,'IPE300',{m.flat},150.,300.,7.1,10.7,15.,$,$)"
            )
        hole = m.hole((1000, -50, h["z"]), (0, 1, 0), h["diameter"], h["depth"])
        m.element(m.minus(m.extruded(profile, 2000.0), hole), tag=tag)
    first, other = read(m.data, "m.ifc").parts
    one, two = (next(f for f in p.features if isinstance(f, Hole)) for p in (first, other))
    assert (one.source.where, two.source.where) == (first.guid, other.guid)
    assert (two.diameter, two.y) == pytest.approx(
        (26.0 if second == "wider" else 22.0, 190.0 if second == "higher" else 180.0)
    )
    assert (other.profile.name, one.depth) == ("IPE300", None)
    assert (two.depth is None) == (second != "deeper")


def test_a_hole_may_be_pushed_along_its_axis_the_other_way() -> None:
    m = Small()
    at = m.step.axes((1000, 50, 0), (0, 1, 0), CUT)
    down = m.step.direction(0, 0, -1)
    part = only_with(m, m.add(f"IFCEXTRUDEDAREASOLID({m.circle(22)},{at},{down},100.)"))
    (hole,) = part.features
    assert isinstance(hole, Hole)
    assert (hole.face, hole.x, hole.y) == ("v", pytest.approx(1000.0), pytest.approx(150.0))


def test_equal_holes_beside_others_of_one_x_are_one() -> None:
    """Six holes one above another, each modelled twice."""
    m = Small()
    twice = [
        m.hole((1000 + off, -50, z), (0, 1, 0), 12, 100)
        for off in (0.0, 0.004)
        for z in range(-100, 80, 30)
    ]
    part = only_with(m, *twice)
    assert [f.y for f in part.features if isinstance(f, Hole)] == pytest.approx(
        [50.0, 80.0, 110.0, 140.0, 170.0, 200.0]
    )


@pytest.mark.parametrize(("inner", "code"), [("15.", "RO"), ("$", "RU")])
def test_a_disc_swept_along_a_line_is_a_pipe_or_a_rod(inner: str, code: str) -> None:
    m = Small()
    points = (m.step.point(0, 0, 0), m.step.point(2000, 0, 0), m.step.point(2600, 800, 0))
    line, kink = (m.add(f"IFCPOLYLINE(({','.join(points[:n])}))") for n in (2, 3))
    m.element(m.add(f"IFCSWEPTDISKSOLID({line},20.,{inner},$,$)"), tag="P1")
    m.element(m.add(f"IFCSWEPTDISKSOLID({kink},20.,{inner},$,$)"), tag="P2")
    found = read(m.data, "m.ifc", options=Options(kernel=True))
    (part,) = found.parts
    assert (part.mark, part.profile.code, part.length) == ("P1", code, pytest.approx(2000.0))
    assert part.profile.height == pytest.approx(40.0)
    assert [d.code for d in found.diagnostics] == ["ifc-curved", "ifc-ledger"]
