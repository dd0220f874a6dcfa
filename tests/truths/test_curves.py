"""Curves: which way an arc turns, what it encloses, what becomes of it, by hand and by shapely."""

from math import pi

import pytest
import shapely

from beamcam import readers
from beamcam.controllers.interpreter import arc_of, sweep_of
from beamcam.errors import Source
from beamcam.geometry.conics import arc_between, arc_by_points, arc_through, direction_deg
from beamcam.geometry.curves import (
    Arc,
    Bezier,
    BSpline,
    Curve,
    EllipseArc,
    Line,
    signed_area,
    unit_vector,
)
from beamcam.geometry.newton import newton_through
from beamcam.geometry.offset import Offset, offset_chains
from beamcam.geometry.plane import cross, determinant, mapped
from beamcam.machine import load
from beamcam.machine.torch import LayerSettings
from beamcam.model.hatch import hatched
from beamcam.model.lengths import duplicate_length, total_length
from beamcam.model.part import Contour, Part, Profile, moved_curve
from beamcam.motion.speeds import min_radius_of_ellipse, min_radius_of_parabola
from tests.dxf_text import drawing, tags

SOURCE = Source("stranger.nc1", 1)
QUARTER = Arc((10.0, 20.0), 5.0, 0.0, 90.0)


def near(point: tuple[float, float]) -> object:
    return pytest.approx(point, abs=1e-9)


def test_an_arc_turns_to_the_left() -> None:
    """From east (15, 20) by 90 degrees to north (10, 25); halfway 5 x 0.7071 in both."""
    assert (QUARTER.start, QUARTER.end) == (near((15, 20)), near((10, 25)))
    assert QUARTER.point(0.5) == near((13.535533906, 23.535533906))
    assert QUARTER.length == pytest.approx(7.853981634)
    assert QUARTER.tangent(0.0) == near((0, 1))
    back = QUARTER.reversed()
    assert (back.start, back.end) == (near((10, 25)), near((15, 20)))
    assert back.tangent(0.0) == near((1, 0))
    assert Arc((0.0, 0.0), 5.0, 0.0, -90.0).end == near((0, -5))
    assert Arc((0.0, 0.0), 5.0, 0.0, 270.0).bbox == pytest.approx((-5, -5, 5, 5))
    assert QUARTER.bbox == pytest.approx((10, 20, 15, 25))


def test_directions() -> None:
    assert [unit_vector(a) for a in (0, 90, 180, 270)] == [(1, 0), (0, 1), (-1, 0), (0, -1)]
    assert unit_vector(30) == near((0.866025403784, 0.5))
    assert [direction_deg(v) for v in ((1, 0), (0, 2), (-3, 0), (0, -1))] == [0, 90, 180, 270]
    assert direction_deg((1.0, 1.0)) == pytest.approx(45)
    # Y lies left of X.
    assert cross((1.0, 0.0), (0.0, 1.0)) == 1.0


def test_the_sign_of_a_radius() -> None:
    """DSTV: positive is counter-clockwise, which bulges to the right of the way.

    From (100, 0) up to (100, 100) with a radius of 50: by (150, 50), or with -50 by (50, 50).
    """
    assert arc_through((100.0, 0.0), (100.0, 100.0), 50.0).point(0.5) == near((150, 50))
    assert arc_through((100.0, 0.0), (100.0, 100.0), -50.0).point(0.5) == near((50, 50))
    # A quarter of 50 from (50, 0) to (0, 50): about the origin, or about (50, 50).
    assert arc_through((50.0, 0.0), (0.0, 50.0), 50.0).centre == near((0, 0))
    assert arc_through((50.0, 0.0), (0.0, 50.0), -50.0).centre == near((50, 50))


AK = """ST
  1
  1
  1
  P
  S235JR
  1
  PL10*100
  B
  150.00
  100.00
  0.00
  0.00
  10.00
  0.00
  78.5
  1.0
  0.000
  0.000
  0.000
  0.000




AK
  v 0.00u 0.00 0.00
  100.00 0.00 {radius}
  100.00 100.00 0.00
  0.00 100.00 0.00
  0.00 0.00 0.00
EN
"""


@pytest.mark.parametrize(
    ("radius", "area"),
    # 100 x 100, and half a disc of 50 (3926.99) more or less.
    [("50.00", 13926.990817), ("-50.00", 6073.009183)],
)
def test_a_bulge_of_a_dstv_contour(radius: str, area: float) -> None:
    (part,) = readers.read(AK.format(radius=radius).encode(), "p.nc1").parts
    (contour,) = part.contours
    assert abs(signed_area(contour.curves)) == pytest.approx(area, abs=1e-5)
    drawn = shapely.Polygon([c.point(k / 256) for c in contour.curves for k in range(256)])
    assert drawn.area == pytest.approx(area, rel=1e-4)


def test_a_bulge_of_a_dxf_polyline() -> None:
    """Bulge is tan of a quarter of the angle, positive counter-clockwise: 1 is half a circle.

    From (0, 0) to (100, 0) it hangs below: by (50, -50).
    """
    entity = tags((0, "LWPOLYLINE"), (8, "0"), (100, "AcDbEntity"), (100, "AcDbPolyline"), (90, 2),
                  (70, 0), (10, 0.0), (20, 0.0), (42, 1.0), (10, 100.0), (20, 0.0))  # fmt: skip
    (part,) = readers.read(drawing(entity), "p.dxf").parts
    (curve,) = [c for contour in part.contours for c in contour.curves]
    assert {curve.start, curve.end} == {(0.0, 0.0), (100.0, 0.0)}
    assert curve.point(0.5) == near((50, -50))


def test_g2_and_g3() -> None:
    """DIN 66025: G02 is clockwise. From (10, 0) to (0, 10) about 0: three quarters, or one."""
    start, end, centre = (10.0, 0.0), (0.0, 10.0), (0.0, 0.0)
    assert sweep_of(start, end, centre, clockwise=True) == pytest.approx(-270)
    assert sweep_of(start, end, centre, clockwise=False) == pytest.approx(90)
    assert sweep_of(start, start, centre, clockwise=True) == -360
    assert arc_of(start, end, centre, clockwise=True).point(0.5) == near(
        (-7.0710678119, -7.0710678119)
    )


def test_arcs_by_centre_and_by_points() -> None:
    assert arc_between((5.0, 0.0), (0.0, 5.0), (0.0, 0.0), 1.0).sweep_deg == pytest.approx(90)
    assert arc_between((5.0, 0.0), (0.0, 5.0), (0.0, 0.0), -1.0).sweep_deg == pytest.approx(-270)
    found = arc_by_points((5.0, 0.0), (0.0, 5.0), (-5.0, 0.0))
    assert found is not None
    assert (found.centre, found.radius, found.sweep_deg) == (near((0, 0)), 5.0, pytest.approx(180))
    assert arc_by_points((0.0, 0.0), (1.0, 1.0), (2.0, 2.0)) is None


def test_areas_are_positive_to_the_left() -> None:
    square = tuple(map(Line, [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)],
                       [(10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0)]))  # fmt: skip
    assert signed_area(square) == 100.0
    assert signed_area(tuple(c.reversed() for c in reversed(square))) == -100.0
    assert signed_area((Arc((3.0, 4.0), 2.0, 0.0, 360.0),)) == pytest.approx(4 * pi)
    # A quarter of a disc of 6, and what is left of it behind its chord: 9 pi, 9 pi - 18.
    bend = Arc((0.0, 0.0), 6.0, 0.0, 90.0)
    legs = (Line((0.0, 6.0), (0.0, 0.0)), Line((0.0, 0.0), (6.0, 0.0)))
    assert signed_area((bend, *legs)) == pytest.approx(28.274334)
    assert signed_area((bend, Line((0.0, 6.0), (6.0, 0.0)))) == pytest.approx(10.274334)
    # An ellipse of 10 by 4: pi x 10 x 4.
    assert signed_area((EllipseArc((0.0, 0.0), (10.0, 0.0), 0.4, 0.0, 360.0),)) == pytest.approx(
        125.663706
    )
    # Under the cubic of these points lies 0.6 of a square of 10.
    bow = (
        Bezier(((0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0))),
        Line((10.0, 0.0), (0.0, 0.0)),
    )
    drawn = shapely.Polygon([bow[0].point(k / 2000) for k in range(2001)])
    assert signed_area(bow) == pytest.approx(-drawn.area, rel=1e-5)
    assert signed_area(bow) == pytest.approx(-60.0)


def test_a_mirrored_arc_turns_the_other_way() -> None:
    """Left for right: from west (-15, 20) clockwise to north (-10, 25)."""
    mirror = ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    assert determinant(mirror) == -1.0
    image = QUARTER.transformed(mirror)
    assert (image.start, image.end) == (near((-15, 20)), near((-10, 25)))
    assert isinstance(image, Arc)
    assert image.sweep_deg == -90.0
    # A quarter turn to the left takes (15, 20) to (-20, 15).
    turn = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
    assert QUARTER.transformed(turn).start == near((-20, 15))
    assert mapped(((2.0, 0.0, 3.0), (0.0, 2.0, 4.0)), (1.0, 1.0)) == (5.0, 6.0)
    # Twice as wide as high it is an ellipse by (5 + 10 cos 45, 5 sin 45) of the centre.
    wide = Arc((0.0, 0.0), 5.0, 0.0, 90.0).transformed(((2.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    assert isinstance(wide, EllipseArc)
    assert wide.point(0.5) == near((7.0710678119, 3.5355339059))
    assert moved_curve(QUARTER, (1.0, -2.0)).start == near((16, 18))


def test_free_curves() -> None:
    cubic = Bezier(((0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0)))
    assert cubic.point(0.5) == near((5, 7.5))  # 3 / 8 of 10 twice
    assert cubic.point(0.25) == near((1.5625, 5.625))
    quarter = Bezier(((5.0, 0.0), (5.0, 5.0), (0.0, 5.0)), (1.0, 0.7071067811865476, 1.0))
    assert quarter.point(0.5) == near((3.5355339059, 3.5355339059))
    corners = ((0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0))
    spline = BSpline(2, corners, (0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0))
    assert spline.point(0.5) == near((5, 10))  # the middle of the middle side
    assert total_length([cubic, quarter]) == pytest.approx(20.0 + 7.853981634, abs=1e-6)


def test_a_polynomial_passes_through_all_its_nodes() -> None:
    """x 10, 40, 60, 90 with y 11, 22, 20, 5: by the divided differences 11/30,
    -7/750 and 1/60000.
    """
    nodes = ((10.0, 11.0), (40.0, 22.0), (60.0, 20.0), (90.0, 5.0))
    curve = newton_through(nodes)
    for x, y in nodes:
        assert curve.point((x - 10) / 80) == near((x, y))
    # 40 x 11/30; 40 x 10 x -7/750; 40 x 10 x -10 / 60000
    assert curve.point(0.5) == near((50, 11 + 14.666666667 - 3.733333333 - 0.066666667))


def test_the_sharpest_bend() -> None:
    """y = x2 from -1 to 1: radius 1/2 in its vertex; of an ellipse b2 / a: 4 x 4 / 10."""
    assert min_radius_of_parabola((-1.0, 1.0), (0.0, 0.0), (1.0, 1.0)) == pytest.approx(0.5)
    assert min_radius_of_ellipse((10.0, 0.0), 0.0, 0.4) == pytest.approx(1.6)
    assert min_radius_of_ellipse((0.0, 10.0), 90.0, 0.4) == pytest.approx(1.6)


def ring(points: list[tuple[float, float]]) -> tuple[Curve, ...]:
    return tuple(map(Line, points, [*points[1:], points[0]]))


#: A corner plate, counter-clockwise, and a disc.
CORNER = [(0.0, 0.0), (100.0, 0.0), (100.0, 40.0), (40.0, 40.0), (40.0, 90.0), (0.0, 90.0)]


@pytest.mark.parametrize("amount", [0.75, -0.75, 5.0, -5.0])
def test_a_contour_beside_itself(amount: float) -> None:
    """shapely's band of a ring, with mitres: out is positive, whichever way the ring runs."""
    wanted = shapely.Polygon(CORNER).buffer(amount, join_style="mitre", mitre_limit=10)
    for points in (CORNER, CORNER[::-1]):
        (moved,) = offset_chains([ring(points)], [amount])
        assert isinstance(moved, Offset)
        (chain,) = moved.chains
        got = shapely.Polygon([c.point(k / 64) for c in chain for k in range(64)])
        rounded = shapely.Polygon(CORNER).buffer(amount, quad_segs=64)
        assert min(
            got.symmetric_difference(wanted).area, got.symmetric_difference(rounded).area
        ) < 0.5 * abs(amount)
    (disc,) = offset_chains([(Arc((10.0, 10.0), 20.0, 0.0, 360.0),)], [amount])
    assert isinstance(disc, Offset)
    assert total_length(disc.chains[0]) == pytest.approx(2 * pi * (20 + amount))


def test_what_is_drawn_twice() -> None:
    """Of 0 to 60 and 40 to 100 on one line 20 lie twice; of two equal circles of 5 one: 31.416."""
    lines = [Line((0.0, 0.0), (60.0, 0.0)), Line((100.0, 0.0), (40.0, 0.0))]
    assert duplicate_length(lines) == pytest.approx(20)
    circles = [Arc((0.0, 0.0), 5.0, 0.0, 360.0), Arc((0.0, 0.0), 5.0, 90.0, -360.0)]
    assert duplicate_length(circles) == pytest.approx(31.4159265)


@pytest.mark.parametrize(("angle", "count"), [(0.0, 10), (90.0, 20)])
def test_a_hatch(angle: float, count: int) -> None:
    """A box of 20 x 10 with lines 1 apart: the first half a line inside, ends half a line off."""
    box = Contour("v", "outer", ring([(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)]), SOURCE,
                  "engrave", colour="#000000")  # fmt: skip
    part = Part("P", Profile("B", "", 10.0, 0.0, 0.0, 3.0), 20.0, SOURCE, features=(box,))
    torch = load("laser-grbl").torch
    assert torch is not None
    from msgspec.structs import replace

    look = LayerSettings(hatch=1.0, hatch_angle=angle)
    filled = hatched(part, replace(torch, settings={"black": look}))
    lines = [c.curves[0] for c in filled.contours if c.kind == "open"]
    assert len(lines) == count
    places = sorted(line.start[1 if angle == 0.0 else 0] for line in lines)
    assert places == pytest.approx([k + 0.5 for k in range(count)])
    for line in lines:
        assert sorted(p[0 if angle == 0.0 else 1] for p in (line.start, line.end)) == pytest.approx(
            [0.5, (20 if angle == 0.0 else 10) - 0.5]
        )
