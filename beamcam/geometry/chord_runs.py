"""Arcs and longer lines for runs of short chords, as drawing programs write curves.

    p0 - p1 - p2 - ... - pn      an arc from p0 to pn is taken for them where no corner lies farther
                                 from it than the tolerance, and no chord comes nearer to its
                                 centre than the radius less the tolerance

so that neither strays from the other by more. What a run cannot be given stays as it is drawn.
"""

from collections.abc import Iterator, Sequence
from itertools import repeat
from typing import Any

import numpy as np

from beamcam.geometry.array_types import Floats
from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.offset import longest_arc, longest_line
from beamcam.geometry.plane import Point

LONGEST = 3.0  #: mm of a chord
LEAST_RUN = 8  #: chords
LEAST_ARC = 4  #: chords that an arc stands for
SAME_POINT = 1e-9
ROUNDING = 1e-6  #: share of a distance
#: No chord of a run turns it by more than this: a square is not a circle.
MOST_SWEEP_DEG = 350.0
MOST_TURN = 0.8  #: the least cosine between neighbouring chords of an arc


def refit_runs(chains: Sequence[Sequence[Curve]], tolerance: float) -> list[tuple[Curve, ...]]:
    """Chains whose runs of short chords are arcs and lines within `tolerance` of them.

    They go through the ends of each run. A run comes back as it is where it would not be half as
    long; without one the chain itself does.
    """
    pieces = [list(_pieces(chain)) for chain in chains]
    runs = [piece for chain in pieces for piece in chain if _is_run(piece)]
    drawn = [np.array([run[0].start, *(line.end for line in run)]) for run in runs]
    fits = iter(map(_refit, runs, drawn, kept_chords(drawn, tolerance), repeat(tolerance)))
    refitted: list[tuple[Curve, ...]] = []
    for chain, own in zip(chains, pieces, strict=True):
        found = [curve for piece in own for curve in (next(fits) if _is_run(piece) else piece)]
        refitted.append(tuple(chain) if len(found) == len(chain) else tuple(found))
    return refitted


def _pieces(curves: Sequence[Curve]) -> Iterator[list[Any]]:
    """A chain in its runs of short chords, and in all other curves one by one."""
    run: list[Line] = []
    for curve in curves:
        short = curve if isinstance(curve, Line) and curve.length <= LONGEST else None
        if run and (short is None or not _goes_on(run[-1], short)):
            yield run
            run = []
        if short is None:
            yield [curve]
        else:
            run.append(short)
    if run:
        yield run


def _is_run(piece: Sequence[Curve]) -> bool:
    return len(piece) >= LEAST_RUN


def arcs_and_lines(points: Sequence[Point], tolerance: float) -> list[Line | Arc]:
    """Curves from the first of some places to the last, through ends of theirs.

    Arcs within `tolerance` of LEAST_ARC chords at least and of both sides, whatever the length of
    those chords; each other chord is a line by itself.
    """
    places = np.array(points)
    curves: list[Line | Arc] = []
    at = 0
    while at + 1 < len(points):
        arc, reach = longest_arc(places, at, LEAST_ARC, lambda run: _arc_over(run, tolerance))
        if arc is None:
            reach = at + 1
            curves.append(Line(points[at], points[reach]))
        else:
            curves.append(arc)
        at = reach
    return curves


def _goes_on(before: Line, line: Line) -> bool:
    (x0, y0), (x1, y1) = before.end, line.start
    return abs(x1 - x0) <= SAME_POINT and abs(y1 - y0) <= SAME_POINT


def _refit(
    run: Sequence[Line], points: Floats, kept: Sequence[bool], tolerance: float
) -> Sequence[Curve]:
    fitted: list[Curve] = []
    at = 0
    while at < len(run):
        arc, reach = None, at
        if not kept[at]:
            arc, reach = longest_arc(points, at, LEAST_ARC, lambda run: _arc_over(run, tolerance))
        if arc is not None:
            fitted.append(arc)
        else:
            reach = at + 1
            if not kept[at]:
                reach = longest_line(points, at, lambda run: _is_straight(run, tolerance))
            line = run[at] if reach == at + 1 else Line(run[at].start, run[reach - 1].end)
            fitted.append(line)
        if 2 * len(fitted) > len(run):
            return run
        at = reach
    return fitted


def kept_chords(runs: Sequence[Floats], tolerance: float) -> list[list[bool]]:
    """Of runs by their points, which chords stay: no arc and no line begins at their start.

    An arc over LEAST_ARC chords turns gently at each of the corners between them, a line over two
    has the corner between them within the tolerance.
    """
    if not runs:
        return []
    points = np.concatenate(runs)
    begins = np.cumsum([len(run) for run in runs])[:-1]
    way = np.diff(points, axis=0)
    size = np.hypot(way[:, 0], way[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        sharp = (way[1:] * way[:-1]).sum(axis=1) / (size[1:] * size[:-1]) < MOST_TURN
    over = way[1:] + way[:-1]
    across = np.abs(way[:-1, 0] * over[:, 1] - way[:-1, 1] * over[:, 0])
    # What rounding leaves of a distance is left to `_is_straight`.
    bent = across > (1 + ROUNDING) * tolerance * np.hypot(over[:, 0], over[:, 1])
    # From one run to the next nothing goes on.
    sharp[begins - 2] = bent[begins - 2] = True
    no_arc, no_line = np.ones((2, len(way)), dtype=bool)
    no_arc[: 1 - LEAST_ARC] = np.lib.stride_tricks.sliding_window_view(sharp, LEAST_ARC - 1).any(1)
    no_line[:-1] = bent
    return [kept[:-1].tolist() for kept in np.split(np.append(no_arc & no_line, True), begins)]


def _arc_over(points: Floats, tolerance: float) -> Arc | None:
    """The arc from the first place to the last that all chords are within the tolerance of."""
    first, middle, last = ((x, y) for x, y in points[[0, len(points) // 2, -1]].tolist())
    arc = arc_by_points(first, middle, last)
    if arc is None or abs(arc.sweep_deg) > MOST_SWEEP_DEG:
        return None
    out = points - np.array(arc.centre)
    away = np.hypot(out[:, 0], out[:, 1])
    if np.abs(away - arc.radius).max() > tolerance:
        return None
    way = np.diff(points, axis=0)
    size = np.hypot(way[:, 0], way[:, 1])
    if not size.min() > 0.0:
        return None
    # Corners follow one another round the centre, never back.
    side = 1.0 if arc.sweep_deg > 0.0 else -1.0
    moment = side * (out[:-1, 0] * way[:, 1] - out[:-1, 1] * way[:, 0])
    if moment.min() <= 0.0 or (moment / size).min() < arc.radius - tolerance:
        return None
    turn = (way[1:] * way[:-1]).sum(axis=1) / (size[1:] * size[:-1])
    return arc if turn.min() >= MOST_TURN else None


def _is_straight(points: Floats, tolerance: float) -> bool:
    chord = points[-1] - points[0]
    size = float(np.hypot(*chord))
    if not size > 0.0:
        return False
    steps = np.diff(points, axis=0) @ chord
    out = points - points[0]
    across = np.abs(out[:, 0] * chord[1] - out[:, 1] * chord[0])
    return bool(steps.min() > 0.0 and across.max() <= tolerance * size)
