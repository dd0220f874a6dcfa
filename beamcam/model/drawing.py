"""Contents of a drawing other than its contours, and the extent of curves.

Filled shapes and curves on hidden layers are no features, since nothing is cut along them; they
are kept so that their lengths can be given when somebody asks.
"""

from collections.abc import Iterable

from msgspec import Struct

from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, Line
from beamcam.geometry.plane import Box, Point, box_around, join_boxes
from beamcam.model.lengths import total_length


class Measures(Struct, frozen=True):
    """Contents of a drawing that are not features of the part."""

    filled: tuple[Curve, ...] = ()  #: outlines of shapes with a fill and no stroke
    hidden: tuple[Curve, ...] = ()  #: curves on layers that are off, frozen or not plotting
    not_cut: tuple[tuple[str, int], ...] = ()  #: entities that are no curves, by name: how many
    grid: float | None = None  #: what coordinates are rounded to, if the file shows it
    lettered: tuple[tuple[str, int], ...] = ()  #: layers whose texts are marked, and how many

    @property
    def filled_length(self) -> float:
        """Length of `filled`."""
        return total_length(self.filled)

    @property
    def hidden_length(self) -> float:
        """Length of `hidden`."""
        return total_length(self.hidden)


def extent(curves: Iterable[Curve]) -> Box | None:
    """The bounding box of all curves; None if there are none.

    An arc lies inside the box around its circle and a free curve inside the hull of its control
    points. So on each side those are measured that may reach beyond all others, outermost first.
    """
    points: list[Point] = []
    bent: list[tuple[Box, Arc | Bezier | BSpline]] = []
    for curve in curves:
        if isinstance(curve, Line):
            points += (curve.start, curve.end)
        elif isinstance(curve, Arc):
            (x, y), r = curve.centre, curve.radius
            bent.append(((x - r, y - r, x + r, y + r), curve))
        elif isinstance(curve, Bezier | BSpline):
            control = curve.points if isinstance(curve, Bezier) else curve.control
            bent.append((box_around(control), curve))
        else:
            x0, y0, x1, y1 = curve.bbox
            points += ((x0, y0), (x1, y1))
    if not points and bent:
        x0, y0, x1, y1 = bent[0][1].bbox
        points += ((x0, y0), (x1, y1))
    box = box_around(points) if points else None
    for side, sign in enumerate((-1, -1, 1, 1)):
        for hull, curve in sorted(bent, key=lambda row: -sign * row[0][side]):
            if box is None or sign * hull[side] <= sign * box[side]:
                break
            box = join_boxes([box, curve.bbox])
    return box
