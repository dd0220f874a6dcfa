"""Openings of a plate that lie beside it, where a torch would cut the sheet."""

from collections.abc import Iterable, Iterator, Sequence
from math import cos, radians, sin

import numpy as np

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.asked_sheet import header_outline
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import Point
from beamcam.geometry.polylines import polylines
from beamcam.model.description import description
from beamcam.model.part import PLATE_FACES, Contour, Hole, Part, Slot

SAG = 0.05  #: mm from a chord to its curve
ROUND = 24  #: places on a circle that are looked at


def beside_faults(parts: Iterable[Part]) -> Iterator[Diagnostic]:
    """An error for each opening of a plate that has no place within an outline.

    A place lies within where a ray to the right crosses an outline an odd number of times.
    """
    for part in {id(part): part for part in parts}.values():
        openings = [(one, where) for one in part.features if (where := _places(one))]
        if not openings:
            continue
        outlines = [
            one.curves for one in part.features
            if isinstance(one, Contour) and one.kind == "outer" and one.process == "cut"
            and one.face in PLATE_FACES
        ]  # fmt: skip
        if not outlines and part.measures is None:
            outlines = [tuple(header_outline(part))]
        rings = [sides_of(one) for one in outlines]  # each by itself: one may be there twice
        for one, where in openings:
            if not any(crossed(at, sides) % 2 for sides in rings for at in where):
                yield rules.BESIDE.at(getattr(one, "source", part.source), what=description(one))


def _places(one: object) -> Sequence[Point]:
    """Places of an opening that is cut: its middle, and round it; none of anything else."""
    if isinstance(one, Contour):
        plain = one.layer is None and one.colour is None and one.closed
        if not plain or one.kind != "inner" or one.process != "cut" or one.face not in PLATE_FACES:
            return ()
        return [curve.point(t) for curve in one.curves for t in (0.0, 0.25, 0.5, 0.75)]
    if not isinstance(one, Hole | Slot) or one.kind == "mark" or one.face not in PLATE_FACES:
        return ()
    c, s, long, high = 1.0, 0.0, 0.0, 0.0
    if isinstance(one, Slot):
        c, s = cos(radians(one.angle)), sin(radians(one.angle))
        long, high = one.length / 2, one.height / 2
    turns = [radians(360.0 * k / ROUND) for k in range(ROUND)]
    r = one.diameter / 2
    middles = [
        (one.x + c * u - s * v, one.y + s * u + c * v) for u in (-long, long) for v in (-high, high)
    ]
    return [(one.x, one.y), *((x + r * cos(t), y + r * sin(t)) for x, y in middles for t in turns)]


def sides_of(curves: Sequence[Curve]) -> Floats:
    """The chords of a closed outline, (n, 2, 2)."""
    points = polylines(curves, SAG).points
    return np.stack((points, np.roll(points, -1, axis=0)), axis=1)


def crossed(at: Point, sides: Floats) -> int:
    """How many chords a ray from a place to the right crosses."""
    (x0, y0), (x1, y1) = sides[:, 0].T, sides[:, 1].T
    spans = (y0 > at[1]) != (y1 > at[1])
    share = (at[1] - y0[spans]) / (y1 - y0)[spans]
    return int(np.count_nonzero(x0[spans] + share * (x1 - x0)[spans] > at[0]))
