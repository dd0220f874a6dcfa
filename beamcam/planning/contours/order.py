"""The order of contours: marks before cuts, inner before outer, and little travel between.

    greedy:  from where the head stands, the nearest contour whose inner ones are done
    2-opt:   a stretch of the tour is turned round where that shortens the way

             a   c   d   b              a   d   c   b
             o---o   o---o      ->      o---o   o---o      if |ad| + |cb| < |ac| + |db|

A stretch may be turned if no contour in it lies inside another one of it, since those two would
change places. The ways inside a stretch keep their lengths: open contours are turned with it.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from beamcam.geometry.plane import Point
from beamcam.planning.contours.join import Shape

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Counts = NDArray[np.int64]

WINDOW = 60  #: longest stretch that is turned round
PASSES = 6  #: over the whole tour; the third rarely gains one per cent


def order(shapes: Sequence[Shape], home: Point = (0.0, 0.0)) -> list[tuple[int, bool]]:
    """Each shape by its index, and whether it is followed backwards, in the order of work.

    Closed shapes are met at their first point and never turned here.
    """
    import numpy as np

    if not shapes:
        return []
    starts = np.array([s.curves[0].start for s in shapes])
    ends = np.array([s.curves[0].start if s.closed else s.curves[-1].end for s in shapes])
    parents = np.array([s.parent for s in shapes])
    marks = np.flatnonzero([s.process != "cut" for s in shapes])
    cuts = np.flatnonzero([s.process == "cut" for s in shapes])
    here = np.array(home)
    done: list[tuple[int, bool]] = []
    for stage in (marks, cuts):
        tour = _nearest(stage, starts, ends, parents, here)
        tour = _two_opt(tour, starts, ends, parents, here)
        done += tour
        if tour:
            last, turned = tour[-1]
            here = starts[last] if turned else ends[last]
    return done


def travel(tour: Sequence[tuple[int, bool]], shapes: Sequence[Shape], home: Point) -> float:
    """Length of the ways between the shapes of a tour, in its order."""
    from math import dist

    total, here = 0.0, home
    for index, turned in tour:
        shape = shapes[index]
        start = shape.curves[0].start
        end = start if shape.closed else shape.curves[-1].end
        total += dist(here, end if turned else start)
        here = start if turned else end
    return total


def _nearest(
    stage: "Counts", starts: "Floats", ends: "Floats", parents: "Counts", here: "Floats"
) -> list[tuple[int, bool]]:
    """The greedy tour; a contour waits until those inside it are done."""
    import numpy as np

    waiting = np.zeros(len(starts), dtype=np.int64)
    np.add.at(waiting, parents[stage][parents[stage] >= 0], 1)
    free = [int(i) for i in stage if waiting[i] == 0]
    tour: list[tuple[int, bool]] = []
    # Places of the free contours, both ends of each; rows of those done are moved to infinity.
    members = np.array(free, dtype=np.int64)
    places = np.stack((starts[members], ends[members])) if free else np.empty((2, 0, 2))
    left = len(free)
    while left:
        away = places - here
        squares = np.einsum("eij,eij->ei", away, away)
        which = int(np.argmin(squares))
        turned, row = divmod(which, len(members))
        index = int(members[row])
        tour.append((index, bool(turned)))
        here = starts[index] if turned else ends[index]
        places[:, row] = np.inf
        left -= 1
        parent = int(parents[index])
        if parent >= 0:
            waiting[parent] -= 1
            if waiting[parent] == 0:
                members = np.append(members, parent)
                added = np.stack((starts[parent], ends[parent]))[:, None]
                places = np.concatenate((places, added), axis=1)
                left += 1
        if left and len(members) > 2 * left + 32:
            kept = np.isfinite(places[0, :, 0])
            members, places = members[kept], places[:, kept]
    return tour


def _two_opt(
    tour: list[tuple[int, bool]],
    starts: "Floats",
    ends: "Floats",
    parents: "Counts",
    here: "Floats",
) -> list[tuple[int, bool]]:
    """The tour with stretches turned round while that shortens it."""
    import numpy as np

    count = len(tour)
    if count < 3:
        return tour
    nodes = np.array([index for index, _ in tour])
    turned = np.array([t for _, t in tour])
    enter = np.where(turned[:, None], ends[nodes], starts[nodes])
    leave = np.where(turned[:, None], starts[nodes], ends[nodes])
    # The last place of a contour right inside the one at each place; -1 where there is none.
    inner = _last_inner(nodes, parents)
    for _ in range(PASSES):
        improved = False
        for i in range(count - 1):
            stop = min(count, i + WINDOW)
            clash = np.flatnonzero(inner[i:stop] >= i)
            if len(clash):
                stop = i + int(clash[0])
            if stop - i < 2:
                continue
            before = here if i == 0 else leave[i - 1]
            gain = _lengths(enter[i] - before) - _lengths(leave[i + 1 : stop] - before)
            after = enter[i + 2 : stop + 1] if stop < count else enter[i + 2 :]
            open_end = stop - i - 1 - len(after)
            gain[: len(after)] += _lengths(after - leave[i + 1 : i + 1 + len(after)])
            gain[: len(after)] -= _lengths(after - enter[i])
            if open_end < 0:
                raise AssertionError("a stretch is longer than the tour")
            best = int(np.argmax(gain))
            if gain[best] <= 1e-9:
                continue
            j = i + 1 + best
            nodes[i : j + 1] = nodes[i : j + 1][::-1].copy()
            flipped = leave[i : j + 1][::-1].copy(), enter[i : j + 1][::-1].copy()
            enter[i : j + 1], leave[i : j + 1] = flipped
            turned[i : j + 1] = ~turned[i : j + 1][::-1].copy()
            inner = _last_inner(nodes, parents)
            improved = True
        if not improved:
            break
    return [(int(n), bool(t)) for n, t in zip(nodes, turned, strict=True)]


def _last_inner(nodes: "Counts", parents: "Counts") -> "Counts":
    import numpy as np

    places = np.full(len(parents), -1)
    known = np.full(len(parents), -1)
    known[nodes] = np.arange(len(nodes))
    has = nodes[parents[nodes] >= 0]
    np.maximum.at(places, parents[has], known[has])
    found: Counts = places[nodes]
    return found


def _lengths(vectors: "Floats") -> "Floats":
    import numpy as np

    found: Floats = np.hypot(vectors[..., 0], vectors[..., 1])
    return found
