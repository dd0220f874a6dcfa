"""Free curves that run over themselves, such as a formula that goes round more than once."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import tau

import numpy as np

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.curves import Curve
from beamcam.geometry.polylines import polylines
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import AssignedCurve

#: Chords stand for the curves so near to them, in mm.
FINE = 1e-3
#: Length in mm over which places of a curve lie on one another where it only crosses itself.
MIN_LENGTH = 0.5
#: A curve that goes over itself the same way has turned by a whole circle in between.
TURNED_RAD = 1.01 * tau


def told(wanted: Sequence[AssignedCurve], which: Sequence[int]) -> Iterator[Diagnostic]:
    """An error for each feature to cut whose free curves run over themselves in one direction."""
    features: dict[int, list[int]] = {}
    for k in which:
        if wanted[k].process == "cut":
            features.setdefault(wanted[k].feature, []).append(k)
    if not features:
        return
    starts, steps, owner = _chords([wanted[k].curve for some in features.values() for k in some])
    ends = np.cumsum([len(some) for some in features.values()])
    bounds = np.searchsorted(owner, [0, *ends.tolist()]).tolist()
    ahead = np.unwrap(np.arctan2(*steps.T[::-1]))
    for some, (low, high) in zip(features.values(), pairwise(bounds), strict=True):
        if high > low and np.ptp(ahead[low:high]) > TURNED_RAD:
            own = steps[low:high]
            again = _again(starts[low:high], own)
            if (found := float(np.hypot(*own[again].T).sum())) > MIN_LENGTH:
                x, y = starts[low:high][int(np.argmax(again))].tolist()
                yield rules.RUNS_OVER.at(
                    wanted[some[0]].source, found=f"{found:.3f}", x=f"{x:.3f}", y=f"{y:.3f}"
                )


def _chords(curves: Sequence[Curve]) -> tuple[Floats, Floats, Counts]:
    """Where the chords of curves begin, how far each goes, (n, 2) each, and the curve of each."""
    drawn = polylines(curves, FINE)
    steps = np.diff(drawn.points, axis=0)
    inner = np.hypot(*steps.T) > 0.0
    inner[drawn.begins[1:-1] - 1] = False  # from one curve to the next
    owner = np.searchsorted(drawn.begins, np.flatnonzero(inner), "right") - 1
    return drawn.points[:-1][inner], steps[inner], owner


def _again(starts: Floats, steps: Floats) -> Flags:
    """Which chords lie on others that are followed before them, in the same direction."""
    import shapely

    along = np.cumsum(np.hypot(*steps.T))
    chords = shapely.linestrings(np.stack((starts, starts + steps), axis=1))
    own, other = shapely.STRtree(chords).query(
        shapely.points(starts + steps / 2), "dwithin", distance=2 * FINE
    )
    before = (along[own] - along[other] > MIN_LENGTH) & (
        np.sum(steps[own] * steps[other], axis=1) > 0.0
    )
    found = np.zeros(len(steps), dtype=bool)
    found[own[before]] = True
    return found
