"""Curves that lie on others, taken away before anything is cut twice."""

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.arrays import arc_rows, by_kind, ends_of, line_rows
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.near import near_pairs
from beamcam.planning.contours import rules
from beamcam.planning.contours.gather import Wanted

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Pairs = NDArray[np.int64]

#: Curves nearer than this lie on the same place; exports round to 1e-4 and finer.
SAME_PLACE = 1e-3


def without_repeats(
    wanted: Sequence[Wanted],
) -> tuple[list[Wanted], dict[int, int], list[Diagnostic]]:
    """The curves without those that lie on others of the same process, and what became of it.

    The second value says for each feature that lost all its curves which feature stands for it.
    """
    from beamcam.geometry.cleaning import remove_repetitions
    from beamcam.model.lengths import total_length

    keep: dict[int, Wanted] = dict(enumerate(wanted))
    stands: dict[int, int] = {}
    gone: list[int] = []
    for process in sorted({w.process for w in wanted}):
        mine = [i for i, w in enumerate(wanted) if w.process == process]
        asked = [mine[k] for k in suspects([wanted[i].curve for i in mine])]
        if not asked:
            continue
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


def suspects(curves: Sequence[Curve]) -> list[int]:
    """Indices of the curves that may lie on another one, ascending.

    Lines have to be collinear, arcs on one circle, and other curves to have the same ends.
    """
    import numpy as np

    kinds = by_kind(curves)
    lines, arcs = kinds.get(Line, []), kinds.get(Arc, [])
    others = sorted(k for kind, which in kinds.items() if kind not in (Line, Arc) for k in which)
    found: set[int] = set()
    if len(lines) > 1:
        found |= {lines[k] for k in np.unique(_collinear(line_rows(curves, lines))).tolist()}
    if len(arcs) > 1:
        # Circles near one another are points near one another in centre and radius.
        circles = arc_rows(curves, arcs)
        a, b = near_pairs(circles[:, :2], SAME_PLACE)
        near = np.abs(circles[a, 2] - circles[b, 2]) <= SAME_PLACE
        found |= {arcs[k] for k in np.unique((a[near], b[near])).tolist()}
    if len(others) > 1:
        ends = ends_of([curves[k] for k in others])
        a, b = near_pairs((ends[:, :2] + ends[:, 2:]) / 2, SAME_PLACE)
        found |= {others[k] for k in np.unique((a, b)).tolist()}
    return sorted(found)


def _collinear(ends: "NDArray[np.float64]") -> "Pairs":
    """Pairs of lines (n, 4) that lie on one line and overlap by more than `SAME_PLACE`."""
    import numpy as np
    import shapely

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
    found: Pairs = np.stack((long[same], short[same]))
    return found
