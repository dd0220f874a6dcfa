"""Curves that lie on others, taken away before anything is cut twice."""

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.near import near_pairs
from beamcam.planning.contours import rules
from beamcam.planning.contours.gather import Wanted

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Counts = NDArray[np.int64]

#: Curves nearer than this lie on the same place; exports round to 1e-4 and finer.
SAME_PLACE = 1e-3


def without_repeats(
    wanted: Sequence[Wanted], curves: CurveTable
) -> tuple[list[Wanted], dict[int, int], list[Diagnostic]]:
    """What is wanted without what lies on others of the same process, and what became of it.

    `curves` are those of `wanted`. The second value says for each feature that lost all its curves
    which feature stands for it.
    """
    doubtful = suspects(curves, [w.process for w in wanted])
    if not doubtful:
        return list(wanted), {}, []
    from beamcam.geometry.cleaning import remove_repetitions
    from beamcam.model.lengths import total_length

    keep: dict[int, Wanted] = dict(enumerate(wanted))
    stands: dict[int, int] = {}
    gone: list[int] = []
    for process in sorted({wanted[i].process for i in doubtful}):
        asked = [i for i in doubtful if wanted[i].process == process]
        cleaned = remove_repetitions([wanted[i].curve for i in asked], SAME_PLACE)
        for k, curve in zip(cleaned.indices, cleaned.curves, strict=True):
            if curve is not wanted[asked[k]].curve:
                keep[asked[k]] = replace(wanted[asked[k]], curve=curve)
        for removed in cleaned.removed:
            del keep[asked[removed.index]]
            gone.append(asked[removed.index])
            stands[wanted[asked[removed.index]].feature] = wanted[asked[removed.into]].feature
    left = Counter(w.feature for w in keep.values())
    said: list[Diagnostic] = []
    if gone:
        length = total_length(wanted[i].curve for i in gone)
        said.append(
            rules.OVERLAP.at(wanted[min(gone)].source, count=len(gone), found=f"{length:.3f}")
        )
    stands = {f: into for f, into in stands.items() if not left[f]}
    return [keep[i] for i in sorted(keep)], _resolved(stands), said


def _resolved(stands: dict[int, int]) -> dict[int, int]:
    """Each feature that is gone, and the one at the end of its chain of replacements."""
    found = {}
    for feature, into in stands.items():
        seen = {feature}
        while into in stands and into not in seen:
            seen.add(into)
            into = stands[into]
        found[feature] = into
    return found


def suspects(curves: CurveTable, processes: Sequence[str]) -> list[int]:
    """Indices of the curves that may lie on another one of the same process, ascending.

    Lines have to be collinear, arcs on one circle, and other curves to have the same ends.
    """
    import numpy as np

    lines, arcs, others = curves.where(Line), curves.where(Arc), np.array(curves.free(), dtype=int)
    ends = curves.ends[others]
    pairs = [
        lines[np.array(_collinear(curves.lines))],
        arcs[np.array(_concentric(curves.arcs))],
        others[np.array(near_pairs((ends[:, :2] + ends[:, 2:]) / 2, SAME_PLACE))],
    ]
    first, second = np.concatenate(pairs, axis=1).tolist()
    alike = {(a, b) for a, b in zip(first, second, strict=True) if processes[a] == processes[b]}
    return sorted({k for pair in alike for k in pair})


def _concentric(arcs: "NDArray[np.float64]") -> "tuple[Counts, Counts]":
    """Pairs of arcs (n, 5) on one circle."""
    import numpy as np

    a, b = near_pairs(arcs[:, :2], SAME_PLACE)
    near = np.abs(arcs[a, 2] - arcs[b, 2]) <= SAME_PLACE
    return a[near], b[near]


def _collinear(ends: "NDArray[np.float64]") -> "tuple[Counts, Counts]":
    """Pairs of lines (n, 4) that lie on one line and overlap by more than `SAME_PLACE`."""
    import numpy as np
    import shapely

    if len(ends) < 2:
        none = np.empty(0, dtype=np.int64)
        return none, none
    low = np.minimum(ends[:, :2], ends[:, 2:])
    high = np.maximum(ends[:, :2], ends[:, 2:])
    boxes = shapely.box(
        low[:, 0] - SAME_PLACE, low[:, 1] - SAME_PLACE,
        high[:, 0] + SAME_PLACE, high[:, 1] + SAME_PLACE,
    )  # fmt: skip
    a, b = shapely.STRtree(boxes).query(boxes)
    a, b = a[a < b], b[a < b]
    lengths = np.hypot(*(ends[:, 2:] - ends[:, :2]).T)
    # The longer of both gives the direction.
    swap = lengths[b] > lengths[a]
    long, short = np.where(swap, b, a), np.where(swap, a, b)
    real = lengths[long] > SAME_PLACE
    long, short = long[real], short[real]
    unit = (ends[long, 2:] - ends[long, :2]) / lengths[long][:, None]
    away, along = [], []
    for part in (ends[short, :2], ends[short, 2:]):
        rest = part - ends[long, :2]
        away.append(np.abs(unit[:, 0] * rest[:, 1] - unit[:, 1] * rest[:, 0]))
        along.append(np.sum(unit * rest, axis=1))
    shared = np.minimum(np.maximum(*along), lengths[long]) - np.maximum(np.minimum(*along), 0.0)
    same = (np.maximum(*away) <= SAME_PLACE) & (shared > SAME_PLACE)
    return long[same], short[same]
