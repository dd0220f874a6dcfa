"""What a drawing holds beside its contours, and the extent of curves.

Filled shapes and curves on hidden layers are no features, since nothing is cut along them; they
are kept so that their lengths can be told when somebody asks.
"""

from collections.abc import Iterable

from msgspec import Struct

from beamcam.geometry.curves import Bezier, BSpline, Curve
from beamcam.geometry.plane import Box, Point, box_around
from beamcam.model.lengths import total_length


class Measures(Struct, frozen=True):
    """What was seen in a drawing and becomes no feature of the part."""

    filled: tuple[Curve, ...] = ()  #: outlines of shapes with a fill and no stroke
    hidden: tuple[Curve, ...] = ()  #: curves on layers that are off, frozen or not plotting
    not_cut: tuple[tuple[str, int], ...] = ()  #: entities that are no curves, by name: how many
    grid: float | None = None  #: what coordinates are rounded to, if the file shows it

    @property
    def filled_length(self) -> float:
        """Length of `filled`."""
        return total_length(self.filled)

    @property
    def hidden_length(self) -> float:
        """Length of `hidden`."""
        return total_length(self.hidden)


def extent(curves: Iterable[Curve]) -> Box | None:
    """The least box around all curves; None if there are none.

    A free curve lies inside the hull of its control points, so that its turning points are
    looked for only where the hull reaches beyond the box that is known already.
    """
    box: Box | None = None
    free: list[Bezier | BSpline] = []
    for curve in curves:
        if isinstance(curve, Bezier | BSpline):
            free.append(curve)
            ends = curve_ends(curve)
            box = _joined(box, box_around(ends))
        else:
            box = _joined(box, curve.bbox)
    for curve in free:
        assert box is not None
        hull = box_around(curve.points if isinstance(curve, Bezier) else curve.control)
        if _joined(box, hull) != box:
            box = _joined(box, curve.bbox)
    return box


def curve_ends(curve: Curve) -> tuple[Point, Point]:
    """Start and end; those of a clamped spline without taking it apart."""
    if isinstance(curve, BSpline):
        degree, knots = curve.degree, curve.knots
        if knots[1] == knots[degree] and knots[-2] == knots[-1 - degree]:
            return curve.control[0], curve.control[-1]
    return curve.start, curve.end


def _joined(first: Box | None, second: Box) -> Box:
    if first is None:
        return second
    return (
        min(first[0], second[0]),
        min(first[1], second[1]),
        max(first[2], second[2]),
        max(first[3], second[3]),
    )
