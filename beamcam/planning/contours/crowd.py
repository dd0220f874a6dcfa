"""Curves that run over one place again and again, refused before anything is compared with all."""

from collections.abc import Sequence

from beamcam.errors import PlanError
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import ways
from beamcam.planning.contours.shape import Shape

#: Times that a contour may be passed on an average. Hatching of 0.02 mm passes a place of 0.1 mm
#: five times; work that takes every pair of curves on one place grows with the square of it.
MAX_PASSES = 64
MAX_ASKED = 1000  #: stretches of which the neighbours are counted


def refuse_crowds(shapes: Sequence[Shape], tolerance: float) -> None:
    """Raise PlanError for shapes that pass most of their places more than `MAX_PASSES` times.

    The passes of a place are the lengths of all stretches no farther than `tolerance` from it,
    each no longer than that place, by its length.
    """
    import numpy as np
    import shapely

    lines = ways([shape.curves for shape in shapes], tolerance / 4)
    points, owner = shapely.get_coordinates(lines, return_index=True)
    along = owner[1:] == owner[:-1]
    starts, ends, owner = points[:-1][along], points[1:][along], owner[1:][along]
    stretches = shapely.linestrings(np.stack((starts, ends), axis=1))
    every = -(-len(stretches) // MAX_ASKED)
    asked = np.arange(0, len(stretches), max(every, 1))
    middles = shapely.points((starts[asked] + ends[asked]) / 2)
    place, near = shapely.STRtree(stretches).query(middles, "dwithin", distance=tolerance)
    lengths = np.minimum(np.hypot(*(ends - starts).T), 2 * tolerance)
    passes = np.bincount(place, lengths[near], len(asked)) / (2 * tolerance)
    if len(asked) and passes.mean() > MAX_PASSES:
        worst = int(np.argmax(passes))
        x, y = shapely.get_coordinates(middles[worst])[0].tolist()
        raise PlanError(
            rules.CROWDED.at(
                shapes[int(owner[asked[worst]])].source,
                found=f"{passes[worst]:.0f}",
                reach=f"{tolerance:g}",
                x=f"{x:.3f}",
                y=f"{y:.3f}",
                expected=MAX_PASSES,
            )
        )
