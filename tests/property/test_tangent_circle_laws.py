"""Laws of circles that touch two curves with a radius, or three."""

from itertools import permutations
from math import cos, dist, hypot, pi, radians, sin

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.tangent_circles import NoTangentCircle, nearest_circle, tangent_circles
from tests.conftest import examples

ours = settings(max_examples=examples(300), deadline=None)
coordinates = st.integers(-2000, 2000).map(lambda n: n / 10)
points = st.tuples(coordinates, coordinates)
sizes = st.integers(5, 1500).map(lambda n: n / 10)
turns = st.integers(0, 719).map(lambda n: n / 2)  # degrees


@st.composite
def lines(draw):
    start, angle, length = draw(points), radians(draw(turns)), draw(sizes)
    return Line(start, (start[0] + length * cos(angle), start[1] + length * sin(angle)))


circles = st.builds(Arc, points, sizes, turns, st.sampled_from([360.0, 90.0, -30.0]))
curves = lines() | circles


@st.composite
def touching(draw, centre, radius):
    """A curve that touches a circle: a line, or a circle outside, around or within it."""
    angle = radians(draw(turns))
    ux, uy = cos(angle), sin(angle)
    at = centre[0] + radius * ux, centre[1] + radius * uy
    kind = draw(st.sampled_from(["line", "outside", "around", "within"]))
    if kind == "line":
        before, behind = draw(sizes), draw(sizes)
        return Line((at[0] + before * uy, at[1] - before * ux),
                    (at[0] - behind * uy, at[1] + behind * ux))  # fmt: skip
    other = radius * draw(st.integers(2, 8)) / 10 if kind == "within" else draw(sizes)
    other += radius if kind == "around" else 0.0
    along = radius + other if kind == "outside" else radius - other
    return Arc((centre[0] + along * ux, centre[1] + along * uy), other, 0.0, 360.0)


def off(circle, curve):
    """How far a circle is from touching a line or the circle of an arc."""
    if isinstance(curve, Line):
        (ax, ay), (bx, by), (x, y) = curve.start, curve.end, circle.centre
        area = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        return abs(abs(area) / hypot(bx - ax, by - ay) - circle.radius)
    apart = dist(circle.centre, curve.centre)
    ways = curve.radius + circle.radius, abs(curve.radius - circle.radius)
    return min(abs(apart - way) for way in ways)


def found(given_curves, radius=None):
    try:
        return tangent_circles(given_curves, radius)
    except NoTangentCircle:
        return ()


def same(a, b, slack):
    return dist(a.centre, b.centre) <= slack and abs(a.radius - b.radius) <= slack


@ours
@given(curves, curves, sizes)
def test_every_circle_of_a_radius_touches_both(a, b, radius):
    circles_ = found([a, b], radius)
    assert len(circles_) <= 8
    for circle in circles_:
        assert circle.radius == radius
        assert off(circle, a) <= 1e-5
        assert off(circle, b) <= 1e-5


@ours
@given(curves, curves, curves)
def test_every_circle_touches_all_three(a, b, c):
    circles_ = found([a, b, c])
    assert len(circles_) <= 8
    for circle in circles_:
        assert max(off(circle, curve) for curve in (a, b, c)) <= 1e-5 * max(1, circle.radius / 1e3)


@ours
@given(st.data(), points, sizes)
def test_a_circle_is_found_again_from_two_curves_that_touch_it(data, centre, radius):
    pair = [data.draw(touching(centre, radius)) for _ in range(2)]
    _assume_apart(pair, centre, radius)
    slack = 1e-4 * max(_reach(pair), 1.0)
    assert any(dist(circle.centre, centre) <= slack for circle in tangent_circles(pair, radius))


@ours
@given(st.data(), points, sizes)
def test_a_circle_is_found_again_from_three_curves_that_touch_it(data, centre, radius):
    three = [data.draw(touching(centre, radius)) for _ in range(3)]
    _assume_apart(three, centre, radius)
    slack = 1e-4 * max(_reach(three), 1.0)
    assert any(
        dist(circle.centre, centre) <= slack and abs(circle.radius - radius) <= slack
        for circle in tangent_circles(three)
    )


def _assume_apart(given_curves, centre, radius):
    """That the points where they touch stand off from each other, and no two of them are parallel
    lines: what comes close to that loses digits."""
    at = []
    for curve in given_curves:
        if isinstance(curve, Line):
            (ax, ay), (bx, by) = curve.start, curve.end
            along = (centre[0] - ax) * (bx - ax) + (centre[1] - ay) * (by - ay)
            along /= (bx - ax) ** 2 + (by - ay) ** 2
            at.append((ax + along * (bx - ax), ay + along * (by - ay)))
        else:
            x, y = curve.centre[0] - centre[0], curve.centre[1] - centre[1]
            outward = 1 if dist(curve.centre, centre) > curve.radius else (
                1 if curve.radius < radius else -1)  # fmt: skip
            size = outward * radius / hypot(x, y)
            at.append((centre[0] + size * x, centre[1] + size * y))
    for k, a in enumerate(at):
        for b in at[:k]:
            assume(radius * 0.05 < dist(a, b) < radius * 1.99)


def _reach(given_curves):
    return max(
        max(abs(v) for v in (*c.start, *c.end)) if isinstance(c, Line)
        else max(map(abs, c.centre)) + c.radius
        for c in given_curves
    )  # fmt: skip


@ours
@given(curves, curves, curves)
def test_their_order_does_not_matter(a, b, c):
    first = found([a, b, c])
    assume(all(circle.radius < 1e4 for circle in first))
    for order in permutations((a, b, c)):
        again = found(list(order))
        assert len(again) == len(first)
        for circle in first:
            assert any(same(circle, one, 1e-4) for one in again)


@ours
@given(curves, curves, sizes, points)
def test_the_circle_that_is_meant_is_the_nearest(a, b, radius, near):
    circles_ = found([a, b], radius)
    assume(circles_)
    chosen = nearest_circle(circles_, near)
    distances = sorted(dist(circle.centre, near) for circle in circles_)
    if chosen is None:
        assert distances[1] - distances[0] < 1e-5
    else:
        assert dist(chosen.centre, near) == distances[0]


@ours
@given(lines(), sizes, st.integers(1, 9))
def test_parallel_lines_are_a_band_or_nothing(line, radius, tenths):
    (ax, ay), (bx, by) = line.start, line.end
    size = hypot(bx - ax, by - ay)
    normal = (ay - by) / size, (bx - ax) / size

    def moved(by_):
        shift = by_ * normal[0], by_ * normal[1]
        return Line((ax + shift[0], ay + shift[1]), (bx + shift[0], by + shift[1]))

    with pytest.raises(NoTangentCircle, match="parallel lines a diameter apart"):
        tangent_circles([line, moved(2 * radius)], radius)
    with pytest.raises(NoTangentCircle, match="parallel lines, between which"):
        tangent_circles([line, moved(2 * radius * (1 + tenths / 10))], radius)
    with pytest.raises(NoTangentCircle, match="the same line twice"):
        tangent_circles([line, line.reversed()], radius)


@ours
@given(points, turns, sizes, sizes)
def test_a_line_across_parallels_has_a_circle_on_each_side(at, turn, gap, slant):
    """By hand: the centres lie midway, half the gap off the third."""
    ux, uy = cos(radians(turn)), sin(radians(turn))
    beyond = at[0] - gap * uy, at[1] + gap * ux
    third = Line(at, (beyond[0] + slant * ux, beyond[1] + slant * uy))
    first = Line(at, (at[0] + ux, at[1] + uy))
    second = Line(beyond, (beyond[0] + ux, beyond[1] + uy))
    both = tangent_circles([first, second, third])
    assert [circle.radius for circle in both] == pytest.approx([gap / 2] * 2)
    # Their centres stand apart along the parallels by 2 r / sin of the crossing angle.
    assert dist(both[0].centre, both[1].centre) == pytest.approx(hypot(gap, slant), rel=1e-6)


def test_three_coins():
    """Three circles of radius 1 that touch: Soddy's circles, radius 2 / sqrt(3) -+ 1."""
    coins = [Arc((2 * cos(a) / 3**0.5, 2 * sin(a) / 3**0.5), 1.0, 0, 360)
             for a in (0, 2 * pi / 3, 4 * pi / 3)]  # fmt: skip
    inner, outer = tangent_circles(coins)
    assert (inner.radius, outer.radius) == pytest.approx((2 / 3**0.5 - 1, 2 / 3**0.5 + 1))
    assert (*inner.centre, *outer.centre) == pytest.approx((0, 0, 0, 0), abs=1e-9)
