"""Minimum radii of curves, which limit the speed along them."""

from math import cos, hypot, inf, radians, sin

from beamcam.geometry.plane import Point, cross


def min_radius_of_parabola(start: Point, vertex: Point, end: Point) -> float:
    """Minimum radius of the parabola whose tangent at `vertex` is parallel to its chord.

    As a quadratic Bezier curve with the legs p and q its velocity is twice w = p + t (q - p) and
    its curvature p x q / (2 |w|^3): greatest where w is shortest, at the place of the segment
    from p to q that is nearest to the origin. inf for a straight line.
    """
    control = 2 * vertex[0] - (start[0] + end[0]) / 2, 2 * vertex[1] - (start[1] + end[1]) / 2
    px, py = control[0] - start[0], control[1] - start[1]
    dx, dy = end[0] - control[0] - px, end[1] - control[1] - py
    turn = abs(cross((px, py), (dx, dy)))
    if turn == 0.0:
        return inf
    t = min(1.0, max(0.0, -(px * dx + py * dy) / (dx * dx + dy * dy)))
    return 2.0 * hypot(px + t * dx, py + t * dy) ** 3 / turn


def min_radius_of_ellipse(on_it: Point, angle_deg: float, ratio: float) -> float:
    """Minimum radius of an ellipse through a point relative to its centre: b^2 / a.

    `angle_deg` is the direction of its main axis, `ratio` is b / a.
    """
    c, s = cos(radians(angle_deg)), sin(radians(angle_deg))
    major = hypot(c * on_it[0] + s * on_it[1], (c * on_it[1] - s * on_it[0]) / ratio)
    return major * ratio * ratio
