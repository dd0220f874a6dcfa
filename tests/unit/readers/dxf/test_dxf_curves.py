"""Each kind of entity gives its exact curve, where it is shown."""

from math import pi, sqrt

import pytest

from beamcam.geometry.curves import Arc, BSpline, EllipseArc, Line
from beamcam.readers import dxf
from tests.dxf_text import (
    arc,
    block,
    box_of,
    circle,
    codes,
    curves_of,
    drawing,
    entity,
    insert,
    length_of,
    line,
    polyline,
    spline,
    tags,
)

BEHIND = ((210, 0), (220, 0), (230, -1))
UPRIGHT = ((210, 1), (220, 0), (230, 0))


def only(entities: str, **options: object):
    (curve,) = curves_of(drawing(entities), **options)
    return curve


def test_lines_arcs_and_circles_come_as_they_are() -> None:
    assert only(line(1, 2, 3, 4)) == Line((1, 2), (3, 4))
    assert only(circle(1, 2, 3)) == Arc((1, 2), 3, 0, 360)
    assert only(arc(1, 2, 3, 30, 90)) == Arc((1, 2), 3, 30, 60)
    assert only(arc(1, 2, 3, 350, 10)) == Arc((1, 2), 3, 350, 20)
    assert only(arc(1, 2, 3, 0, 360)) == Arc((1, 2), 3, 0, 360)


def test_seen_from_behind_x_is_mirrored() -> None:
    mirrored = only(arc(10, 0, 5, 0, 90, *BEHIND))
    assert isinstance(mirrored, Arc)
    assert mirrored.start == pytest.approx((-15, 0), abs=1e-12)
    assert mirrored.end == pytest.approx((-10, 5), abs=1e-12)
    assert mirrored.sweep_deg == -90
    assert box_of(drawing(polyline([(50, 0), (60, 0)], False, *BEHIND))) == (-60, 0, -50, 0)
    # A line is given in the coordinates of the world, whatever its extrusion.
    assert only(line(1, 0, 2, 0)) == Line((1, 0), (2, 0))


@pytest.mark.parametrize(
    ("bulge", "centre", "sweep"),
    [
        (1.0, (5, 0), 180),
        (-1.0, (5, 0), -180),
        (sqrt(2) - 1, (5, 5), 90),
        (sqrt(2) + 1, (5, -5), 270),
    ],
)
def test_bulges(bulge: float, centre: tuple[float, float], sweep: float) -> None:
    curve = only(polyline([(0, 0, bulge), (10, 0)], False))
    assert isinstance(curve, Arc)
    assert curve.centre == pytest.approx(centre, abs=1e-12)
    assert curve.sweep_deg == pytest.approx(sweep)
    assert curve.start == pytest.approx((0, 0), abs=1e-12)
    assert curve.end == pytest.approx((10, 0), abs=1e-12)


def test_a_flat_bulge_is_a_line_and_double_vertices_vanish() -> None:
    assert only(polyline([(0, 0, 1e-12), (10, 0)], False)) == Line((0, 0), (10, 0))
    assert curves_of(drawing(polyline([(0, 0), (0, 0), (5, 0), (5, 0)], False))) == (
        Line((0, 0), (5, 0)),
    )


def test_a_closed_polyline_of_two_arcs_is_a_circle() -> None:
    data = drawing(polyline([(0, 0, 1), (10, 0, 1)]))
    assert length_of(data) == pytest.approx(10 * pi)
    (contour,) = dxf.read(data, "a.dxf").parts[0].contours
    assert (contour.closed, contour.kind, len(contour.curves)) == (True, "outer", 2)


def vertices(points: list[tuple[float, float, float]], *flags: int) -> str:
    return "".join(
        tags((0, "VERTEX"), (8, "0"), (10, x), (20, y), (30, z), (70, flag))
        for (x, y, z), flag in zip(points, flags, strict=True)
    ) + tags((0, "SEQEND"), (8, "0"))


def test_old_polylines_flat_and_in_space() -> None:
    head = tags((0, "POLYLINE"), (8, "0"), (66, 1), (70, 8), (10, 0), (20, 0), (30, 0))
    points = [(0.0, 0.0, 0.0), (30.0, 0.0, 5.0), (30.0, 40.0, 0.0)]
    space = drawing(head + vertices(points, 32, 32, 32), version="AC1009", units=4)
    assert length_of(space) == 70
    head = head.replace("70\n8\n", "70\n5\n", 1)  # closed, with a fitted spline
    frame = [(0.0, 0.0, 0.0), (99.0, 99.0, 0.0), (30.0, 0.0, 0.0), (30.0, 40.0, 0.0)]
    fitted = drawing(head + vertices(frame, 8, 16, 8, 8), version="AC1009", units=4)
    assert length_of(fitted) == 120


def test_a_mesh_is_no_curve() -> None:
    head = tags((0, "POLYLINE"), (8, "0"), (66, 1), (70, 16), (10, 0), (20, 0), (30, 0), (71, 2))
    head += tags((72, 2))
    mesh = head + vertices([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], 64, 64, 64, 64)
    data = drawing(mesh + line(0, 0, 1, 0).replace("5\nAB\n", ""), version="AC1009")
    assert codes(data) == ["dxf-not-cut"]
    assert dict(dxf.read(data, "a.dxf").parts[0].measures.not_cut) == {"POLYLINE": 1}


def ellipse(ratio: float, start: float, end: float, major=(10.0, 0.0), up=1) -> str:
    own = ((10, 1), (20, 2), (30, 0), (11, major[0]), (21, major[1]), (31, 0), (210, 0), (220, 0))
    own += ((230, up), (40, ratio), (41, start), (42, end))
    return entity("ELLIPSE", "AcDbEllipse", *own)


def test_ellipses() -> None:
    assert only(ellipse(0.5, 0, 2 * pi)) == EllipseArc((1, 2), (10, 0), 0.5, 0, 360)
    half = only(ellipse(0.5, 0, pi))
    assert half.end == pytest.approx((-9, 2))
    assert half.point(0.5) == pytest.approx((1, 7))
    assert only(ellipse(0.5, 0, pi, up=-1)).point(0.5) == pytest.approx((1, -3))
    # Corel's circles are ellipses of ratio 1.
    assert only(ellipse(1.0, 0, 2 * pi)) == Arc((1, 2), 10, 0, 360)
    quarter = only(ellipse(1.0, 0, pi / 2, major=(0.0, 10.0)))
    assert isinstance(quarter, Arc)
    assert (quarter.start, quarter.end) == (pytest.approx((1, 12)), pytest.approx((-9, 2)))


def test_splines() -> None:
    bezier = only(spline([(0, 0), (0, 10), (10, 10), (10, 0)], [0, 0, 0, 0, 1, 1, 1, 1]))
    assert bezier.point(0.5) == (5, 7.5)
    root = sqrt(0.5)
    quarter = only(spline([(0, 0), (10, 0), (10, 10)], [0, 0, 0, 1, 1, 1], 2, (1, root, 1)))
    assert isinstance(quarter, BSpline)
    assert quarter.length == pytest.approx(5 * pi)


def test_a_periodic_spline_is_drawn_over_its_inner_knots() -> None:
    square = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    data = drawing(spline([*square, *square[:3]], list(range(11))))
    (contour,) = dxf.read(data, "a.dxf").parts[0].contours
    assert contour.closed
    assert all(0 < x < 10 for x in box_of(data))


def test_a_spline_that_tears_at_a_knot_is_two() -> None:
    points = [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0), (5.0, 0.0), (6.0, 2.0), (7.0, 0.0)]
    data = drawing(spline(points, [0, 0, 0, 1, 1, 1, 2, 2, 2], 2))
    first, second = dxf.read(data, "a.dxf").parts[0].contours
    assert (first.curves[0].end, second.curves[0].start) == ((2, 0), (5, 0))


def test_a_spline_by_fit_points_is_flagged() -> None:
    data = drawing(spline([], [], fit=((0, 0), (5, 5), (10, 0))))
    assert codes(data) == ["dxf-fit-spline"]
    assert "3 fit points only" in dxf.read(data, "a.dxf").diagnostics[0].message
    (curve,) = curves_of(data)
    assert (curve.start, curve.end) == (pytest.approx((0, 0)), pytest.approx((10, 0)))


def test_curves_of_no_length_are_counted() -> None:
    empty = line(1, 1, 1, 1) + circle(0, 0, 0) + circle(0, 0, -1) + polyline([(0, 0)])
    data = drawing(empty + line(0, 0, 1, 0))
    (said,) = dxf.read(data, "a.dxf").diagnostics
    assert str(said) == (
        "a.dxf: note dxf-empty-curves: found 2 CIRCLE, 1 LINE, 1 LWPOLYLINE of no length and left "
        "them out"
    )
    assert len(curves_of(data)) == 1


def test_heights_are_projected_and_said() -> None:
    flat = tags((0, "LINE"), (8, "0"), (10, 0), (20, 0), (30, 0), (11, 30), (21, 0), (31, 40))
    data = drawing(flat, version="AC1009")
    (said,) = dxf.read(data, "a.dxf").diagnostics
    assert said.code == "dxf-not-flat"
    assert said.message.startswith("found heights from 0 to 40 mm")
    assert length_of(data) == 30
    assert codes(drawing(flat.replace("\n40\n", "\n1e-7\n"), version="AC1009")) == []


def test_what_stands_upright_is_left_out_and_said() -> None:
    data = drawing(circle(0, 0, 5, *UPRIGHT) + line(0, 0, 1, 0))
    (said,) = dxf.read(data, "a.dxf").diagnostics
    assert (said.code, "1 CIRCLE" in said.message) == ("dxf-edge-on", True)
    slanting = drawing(circle(0, 0, 5, (210, 0), (220, 0.6), (230, 0.8)))
    (curve,) = curves_of(slanting)
    assert isinstance(curve, EllipseArc)
    assert (curve.major, curve.minor) == (pytest.approx(5), pytest.approx(4))


def test_numbers_that_make_no_curve_refuse_the_file() -> None:
    for bad in (
        spline([(0, 0), (1, 1), (2, 0), (3, 0)], [0, 0, 0, 0, 1, 1, 1]),
        spline([(0, 0), (10, 0), (10, 10)], [0, 0, 0, 1, 1, 1], 2, (1, -1, 1)),
        spline([(0, 0), (1, 1), (2, 0), (3, 0)], [0, 0, 0, 0, 0, 0, 0, 0]),
        line(0, 0, float("nan"), 1),
        circle(float("inf"), 0, 1),
    ):
        reading = dxf.read(drawing(bad + line(0, 0, 1, 0)), "a.dxf")
        assert [d.code for d in reading.diagnostics] == ["dxf-entity"]
        assert reading.diagnostics[0].source.where == "AB"
        assert len(reading.parts[0].features) == 1


# --- blocks ---------------------------------------------------------------------------------------


def test_an_insert_moves_turns_scales_and_mirrors() -> None:
    shape = block("B", line(0, 0, 10, 0) + circle(10, 0, 2))
    places = insert("B", 100, 50, (41, -2), (42, 2), (43, 1), (50, 90))
    straight, round_ = curves_of(drawing(places, blocks=shape))
    assert straight.end == pytest.approx((100, 30))
    assert isinstance(round_, Arc)
    assert (round_.centre, round_.radius) == (pytest.approx((100, 30)), pytest.approx(4))


def test_a_circle_scaled_unevenly_is_an_ellipse_and_bulges_too() -> None:
    shape = block("B", circle(0, 0, 5) + polyline([(0, 0, 1), (10, 0)], False))
    circle_, bulge = curves_of(drawing(insert("B", 0, 0, (41, 2), (42, 1)), blocks=shape))
    assert circle_ == EllipseArc((0, 0), (10, 0), 0.5, 0, 360)
    assert isinstance(bulge, EllipseArc)
    assert bulge.point(0.5) == pytest.approx((10, -5))


def test_a_z_scale_of_0_changes_nothing() -> None:
    shape = block("B", circle(0, 0, 5))
    assert curves_of(drawing(insert("B", 1, 2, (43, 0)), blocks=shape)) == (Arc((1, 2), 5, 0, 360),)


def test_arrays_of_inserts() -> None:
    shape = block("B", circle(0, 0, 1))
    grid = insert("B", 5, 5, (50, 90), (70, 3), (71, 2), (44, 10), (45, 20))
    data = drawing(grid, blocks=shape)
    centres = {(round(c.centre[0]), round(c.centre[1])) for c in curves_of(data)}
    assert centres == {(5 - 20 * row, 5 + 10 * column) for row in (0, 1) for column in (0, 1, 2)}


def test_blocks_in_blocks() -> None:
    inner = block("INNER", circle(1, 0, 1))
    outer = block("OUTER", insert("INNER", 10, 0) + insert("INNER", 0, 10, (41, -1), (42, 1)))
    first, second = curves_of(drawing(insert("OUTER", 100, 0), blocks=inner + outer))
    assert first.centre == pytest.approx((111, 0))
    assert second.centre == pytest.approx((99, 10))


def test_a_block_inside_itself_refuses_the_file() -> None:
    shape = block("A", insert("B")) + block("B", insert("a"))
    reading = dxf.read(drawing(line(0, 0, 1, 0) + insert("A"), blocks=shape), "a.dxf")
    assert [d.code for d in reading.diagnostics] == ["dxf-block-cycle"]
    assert "found block 'a' inside itself" in reading.diagnostics[0].message


def test_a_missing_block_is_named() -> None:
    reading = dxf.read(drawing(line(0, 0, 1, 0) + insert("GONE")), "a.dxf")
    assert [str(d) for d in reading.diagnostics] == [
        "a.dxf:AB: warning dxf-block-missing: found an insert of block 'GONE', which the file "
        "does not hold"
    ]


def test_an_array_without_end_refuses_the_file() -> None:
    grid = insert("B", 0, 0, (70, 30000), (71, 30000), (44, 1), (45, 1))
    data = drawing(grid, blocks=block("B", circle(0, 0, 1)))
    (said,) = dxf.read(data, "a.dxf").diagnostics
    assert said.message == "found 900000000 copies of blocks, expected at most 20000"


def test_blocks_that_multiply_each_other_refuse_the_file() -> None:
    blocks = block("B0", circle(0, 0, 1))
    for level in range(1, 9):
        blocks += block(f"B{level}", insert(f"B{level - 1}") * 10)
    assert codes(drawing(insert("B8"), blocks=blocks)) == ["dxf-block-count"]
