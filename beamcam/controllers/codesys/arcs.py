"""What CODESYS makes of an arc: the arc, another arc, or without a word a straight line.

With I and J the centre has to lie on the bisector of the chord; up to 10 % beside it the
controller moves it there, beyond that it drives a line. With R it takes the arc below 180
degrees, and a line where R is less than half the chord. Start on end is a full circle. Source:
CODESYS online help, G2/G3. Lengths in mm, angles in degrees.
"""

from math import dist, hypot, sqrt

from beamcam.geometry.plane import Point

CENTRE_SHARE = 0.1  #: how far off the bisector the controller still mends a centre, by the radius


def arc_fault(start: Point, end: Point, centre: Point, resolution: float) -> str | None:
    """The fault of an arc about `centre` as written; None if there is none.

    `resolution` is the step of the numbers: start, end and centre may each be half of it off in
    x and in y, which is sqrt(2) / 2 of it, and the centre counts in both radii; so honest radii
    differ by up to 4 sqrt(2) / 2 of it, and no more.
    """
    radius = dist(start, centre)
    if radius <= resolution:
        return f"of radius {radius:.4g}"
    if start == end:
        return None
    difference = abs(radius - dist(end, centre))
    if difference > 2 * sqrt(2) * resolution + 1e-9:
        return f"whose radii at start and end differ by {difference:.4g}"
    off = _off_bisector(start, end, centre)
    if off > CENTRE_SHARE * radius:
        return f"whose centre lies {off:.4g} beside the bisector of its chord"
    return None


def _off_bisector(start: Point, end: Point, centre: Point) -> float:
    """Distance of a centre from the perpendicular bisector of start and end."""
    (x0, y0), (x1, y1), (cx, cy) = start, end, centre
    chord = hypot(x1 - x0, y1 - y0)
    along = (cx - (x0 + x1) / 2) * (x1 - x0) + (cy - (y0 + y1) / 2) * (y1 - y0)
    return abs(along) / chord


def radius_fault(start: Point, end: Point, radius: float) -> str | None:
    """The fault of an arc by R; None if there is none."""
    chord = dist(start, end)
    if radius <= 0:
        return f"of radius {radius:.4g}"
    if chord == 0:
        return "by R whose end is its start"
    if radius < chord / 2:
        return f"of radius {radius:.4g} over a chord of {chord:.4g}"
    return None


def radius_centre(start: Point, end: Point, radius: float, clockwise: bool) -> Point:
    """Centre of the arc below 180 degrees from start to end with `radius`.

    Raises ValueError where `radius_fault` has something to say.
    """
    fault = radius_fault(start, end, radius)
    if fault:
        raise ValueError(f"an arc {fault}")
    (x0, y0), (x1, y1) = start, end
    chord = dist(start, end)
    height = sqrt(max(0.0, radius * radius - chord * chord / 4))
    side = -1.0 if clockwise else 1.0  # left of the chord for a counter-clockwise short arc
    return (
        (x0 + x1) / 2 - side * height * (y1 - y0) / chord,
        (y0 + y1) / 2 + side * height * (x1 - x0) / chord,
    )
