"""Free curves that run over themselves, such as a formula that goes round more than once."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import pi, tau

import numpy as np

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.cubics import cubics_of
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
AT_ONCE = 1000  #: chords that are asked about
MAX_PAIRS = 2_000_000  #: hundreds of rounds on one place are refused without comparing each pair


def told(wanted: Sequence[AssignedCurve], which: Sequence[int]) -> Iterator[Diagnostic]:
    """An error for each feature to cut whose free curves run over themselves in one direction."""
    features: dict[int, list[int]] = {}
    for k in which:
        if wanted[k].process == "cut":
            features.setdefault(wanted[k].feature, []).append(k)
    numbers = list(features)
    going = may_go_round([[wanted[k].curve for k in some] for some in features.values()])
    features = {numbers[n]: features[numbers[n]] for n in sorted(going)}
    if not features:
        return
    starts, steps, owner = chords_of([wanted[k].curve for some in features.values() for k in some])
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


def may_go_round(chains: Sequence[Sequence[Curve]]) -> set[int]:
    """The numbers of the chains whose directions may fill a whole circle.

    The directions of a cubic lie between those of the sides of its control polygon, where none of
    these turns by more than a right angle.
    """
    control, owner, odd = cubics_of([curve for chain in chains for curve in chain])
    chain_of = np.repeat(np.arange(len(chains)), [len(chain) for chain in chains])
    sides = np.diff(control, axis=1).reshape(-1, 2)
    chain = np.repeat(chain_of[owner], 3)
    long = np.any(sides != 0.0, axis=1)
    sides, chain = sides[long], chain[long]
    ahead = np.unwrap(np.arctan2(*sides.T[::-1]))
    sharp = (np.abs(np.diff(ahead)) > pi / 2) & (chain[1:] == chain[:-1])
    first = np.flatnonzero(np.diff(chain, prepend=-1))
    turned = np.maximum.reduceat(ahead, first) - np.minimum.reduceat(ahead, first)
    going = (chain_of[odd], chain[1:][sharp], chain[first][turned > TURNED_RAD])
    return set(np.concatenate(going).tolist())


def chords_of(curves: Sequence[Curve]) -> tuple[Floats, Floats, Counts]:
    """Where the chords of curves begin, how far each goes, (n, 2) each, and the curve of each."""
    drawn = polylines(curves, FINE)
    steps = np.diff(drawn.points, axis=0)
    inner = np.hypot(*steps.T) > 0.0
    inner[drawn.begins[1:-1] - 1] = False  # from one curve to the next
    owner = np.searchsorted(drawn.begins, np.flatnonzero(inner), "right") - 1
    return drawn.points[:-1][inner], steps[inner], owner


def _again(starts: Floats, steps: Floats) -> Flags:
    """Which chords lie on others that are followed before them, in the same direction.

    Of a curve with more than `MAX_PAIRS` chords on one another it may be those that come first.
    """
    import shapely

    along = np.cumsum(np.hypot(*steps.T))
    chords = shapely.STRtree(shapely.linestrings(np.stack((starts, starts + steps), axis=1)))
    middles = shapely.points(starts + steps / 2)
    found, pairs = np.zeros(len(steps), dtype=bool), 0
    for first in range(0, len(steps), AT_ONCE):
        own, other = chords.query(middles[first : first + AT_ONCE], "dwithin", distance=2 * FINE)
        own += first
        before = (along[own] - along[other] > MIN_LENGTH) & (
            np.sum(steps[own] * steps[other], axis=1) > 0.0
        )
        found[own[before]] = True
        pairs += len(own)
        if pairs > MAX_PAIRS and np.hypot(*steps[found].T).sum() > MIN_LENGTH:
            break
    return found
