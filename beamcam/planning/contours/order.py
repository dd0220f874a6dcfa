"""The order of contours: marks before cuts, inner before outer, with short traverses.

First the nearest contour each time (`nearest`), then stretches of the tour turned round where that
shortens the way (`two_opt`).
"""

from collections.abc import Sequence

import numpy as np

from beamcam.geometry.plane import Point
from beamcam.planning.contours.nearest import nearest_first
from beamcam.planning.contours.shape import Shape
from beamcam.planning.contours.two_opt import turn_stretches

Tour = list[tuple[int, bool]]


def order(
    shapes: Sequence[Shape],
    home: Point = (0.0, 0.0),
    ranks: Sequence[int] = (),
    fixed: Sequence[bool] = (),
) -> Tour:
    """Each shape by its index, and whether it is followed backwards, in the order of work.

    Those of lower `ranks` come first, whatever they are, then those of lower levels; those that are
    `fixed` are never turned.

    Closed shapes are met at their first point; which way round they go is not said here.
    """
    starts = [s.curves[0].start for s in shapes]
    ends = [
        start if s.closed or is_fixed else s.curves[-1].end
        for s, start, is_fixed in zip(shapes, starts, fixed or [False] * len(shapes), strict=True)
    ]
    parents = [s.parent for s in shapes]
    ranks = ranks or [0] * len(shapes)
    stages: dict[tuple[int, bool, int], list[int]] = {}
    for k, (rank, shape) in enumerate(zip(ranks, shapes, strict=True)):
        stages.setdefault((rank, shape.process == "cut", shape.level), []).append(k)
    here = home
    done: Tour = []
    for _, stage in sorted(stages.items()):
        own = set(stage)
        within = [parent if parent in own else -1 for parent in parents]
        tour = nearest_first(stage, starts, ends, within, here)
        tour = turn_stretches(
            tour,
            np.array(starts, dtype=float),
            np.array(ends, dtype=float),
            np.array(within),
            here,
        )
        done += tour
        if tour:
            last, turned = tour[-1]
            here = starts[last] if turned else ends[last]
    return done
