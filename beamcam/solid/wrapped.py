"""Shapes on the unrolled outside of a round section, as solids that go into its wall.

   _____              u is the arc from the lowest line towards v, x runs along the axis;
 /       \\     v      depth counts inwards from the surface, square to it.
|    +    |
 \\ _____ /
     u = 0
"""

from collections.abc import Iterator, Sequence
from functools import partial
from math import acos, ceil, pi, radians
from typing import TYPE_CHECKING, Any

import numpy as np

from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Curve, Line
from beamcam.model.part import Contour, Part, Slot
from beamcam.solid.cutters import OUTLINE_NOISE, slot_shape
from beamcam.solid.kernel import CHORD, FREE, extruded, kernel, no_solid
from beamcam.solid.stock_solid import Margins, Shape, is_cut, shape_of

if TYPE_CHECKING:
    from manifold3d import Manifold

STRIP_RAD = radians(6.0)
LAP = 1e-3  #: mm by which strips of one shape lie over each other, so that none comes apart


def round_wall(part: Part) -> tuple[float, float]:
    """Radius and wall of a round tube. Raises BeamcamError where it is none."""
    profile = part.profile
    wall = profile.flange_thickness or profile.web_thickness or 0.0
    if profile.code != "RO" or not 0.0 < wall <= profile.height / 2:
        raise no_solid(part, f"a contour or slot round {profile.name}")
    return profile.height / 2, wall


def wrapped(shape: Shape, radius: float, low: float, high: float) -> "Manifold":
    """A shape in (x, u) of the surface as a solid from one depth to another.

    It is made of strips along x, whose sides lie where they should; between them an edge is off by
    their angle's third power, 0.003 mm at 136 mm. They begin in the air in front of the surface, so
    that their chords do not come below it.
    """
    from shapely import clip_by_rect

    m = kernel()
    if shape.is_empty:
        return m.Manifold()
    x0, u0, x1, u1 = shape.bounds
    air = acos(min(1.0, (radius + FREE / 2) / max(radius - low, radius + FREE / 2)))
    step = radius * min(STRIP_RAD, 2 * max(air, STRIP_RAD / 10))
    count = max(1, ceil((u1 - u0) / step))

    def bent(points: Any) -> Floats:
        x, u, out = points.T
        at = u / radius
        from_axis = radius + out
        return np.column_stack(
            (x, radius - from_axis * np.cos(at), radius + from_axis * np.sin(at))
        )

    strips = []
    for k in range(count):
        first, last = (u0 + (u1 - u0) * (k + one) / count for one in (0, 1))
        strip = clip_by_rect(shape, x0 - 1.0, first - LAP, x1 + 1.0, last + LAP)
        strips.append(extruded(strip, -high, -low).warp_batch(bent))
    return m.Manifold.batch_boolean(strips, m.OpType.Add)


def outline_gone(part: Part, margin: float = 0.0) -> Shape:
    """What the outlines of a tube leave out of its surface, in (x, u) of one turn; all of it stays
    without one."""
    from shapely import Polygon, box, transform

    radius, _ = round_wall(part)
    turn = 2 * pi * radius
    outlines = [one for one in part.contours if one.kind == "outer" and is_cut(one)]
    gone = box(-FREE, 0.0, part.length + FREE, turn) if outlines else Polygon()
    for one in outlines:
        steel = transform(shape_of(one.curves), partial(_on_seam, one.curves, turn))
        gone = gone.difference(steel.buffer(0))
    if margin and outlines:
        gone = all_round(gone, turn).buffer(margin, join_style="mitre")
        gone = gone.intersection(box(-FREE, 0.0, part.length + FREE, turn))
    return gone


def _on_seam(curves: Sequence[Curve], turn: float, points: Any) -> Any:
    """Corners of an outline, the ends of its sides along the seam on it."""
    points = points.copy()
    for side in curves:
        if isinstance(side, Line):
            for seam in (0.0, turn):
                ends = np.array([side.start, side.end])
                rise, run = np.ptp(ends[:, 1]), np.ptp(ends[:, 0])
                if abs(ends[:, 1] - seam).max() <= OUTLINE_NOISE and rise <= 0.02 * run:
                    for end in ends:
                        points[np.hypot(*(points - end).T) < CHORD, 1] = seam
    return points


def all_round(shape: Shape, turn: float) -> Shape:
    """A shape of one turn on that turn, the one before it and the one behind it."""
    from shapely import union_all
    from shapely.affinity import translate

    return union_all([translate(shape, 0.0, k * turn) for k in (-1, 0, 1)])


def round_cutters(feature: Slot | Contour, part: Part, margins: Margins) -> Iterator["Manifold"]:
    """What a slot or a contour takes of a tube, square to its surface; bevels are not there."""
    if feature.face != "v":
        raise no_solid(part, f"a {type(feature).__name__.lower()} on face {feature.face}")
    radius, wall = round_wall(part)
    depth = wall + FREE
    if isinstance(feature, Slot):
        shape = slot_shape(feature, margins.radius(feature.diameter))
        depth = depth if feature.depth is None else feature.depth + margins.depth
    elif feature.kind == "outer":
        if feature is not next(c for c in part.contours if c.kind == "outer" and is_cut(c)):
            return  # all of them take the same
        shape = outline_gone(part, margins.outline)
    else:
        shape = shape_of(feature.curves).buffer(margins.outline, join_style="mitre")
    yield wrapped(shape, radius, -FREE, min(depth, 0.999 * radius))
