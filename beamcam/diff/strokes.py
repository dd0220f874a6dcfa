"""What torches cut of a profile, each cut with its like in another program."""

from collections.abc import Iterator, Sequence
from math import dist

from beamcam.diff.pairing import Pair, moved, paired
from beamcam.verify.coping.strokes import Stroke

CLOSED = 0.02  #: mm between the ends of a closed cut
MOST_OPEN = 2  #: places that no closed cut has


def stroke_pairs(a: Sequence[Stroke], b: Sequence[Stroke], resolution: float) -> Iterator[Pair]:
    """The cuts of two programs face by face, those that are closed and the others.

    Places nearer than `resolution` are one.
    """
    step = resolution / 2 + 1e-9
    for face, closed in sorted({_sort(stroke) for stroke in (*a, *b)}):
        old, new = ([s for s in strokes if _sort(s) == (face, closed)] for strokes in (a, b))
        yield from paired(old, new, stroke_place, lambda x, y: _changes(x, y, step))


def _sort(stroke: Stroke) -> tuple[str, bool]:
    return stroke.face, is_closed(stroke)


def is_closed(stroke: Stroke) -> bool:
    """Whether a cut behind its lead comes back to where it began."""
    ring = stroke.points[1:]
    return len(ring) > MOST_OPEN and dist(ring[0], ring[-1]) <= CLOSED


def stroke_place(stroke: Stroke) -> tuple[float, float]:
    """The middle of a cut without its lead."""
    xs, ys = zip(*(stroke.points[1:] or stroke.points), strict=True)
    return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2


def _changes(a: Stroke, b: Stroke, step: float) -> list[str]:
    (ax, ay), (bx, by) = stroke_place(a), stroke_place(b)
    changes = moved(bx - ax, by - ay, step)
    if len(a.points) != len(b.points) or any(
        abs((p - ax) - (r - bx)) > 2 * step or abs((q - ay) - (t - by)) > 2 * step
        for (p, q), (r, t) in zip(a.points, b.points, strict=True)
    ):
        changes.append("another course")
    if a.b_deg != b.b_deg:
        changes.append(f"tilt {a.b_deg:.6g} to {b.b_deg:.6g} degrees")
    if a.row.feed_mm_min != b.row.feed_mm_min:
        changes.append(f"feed {a.row.feed_mm_min:.6g} to {b.row.feed_mm_min:.6g} mm/min")
    return changes
