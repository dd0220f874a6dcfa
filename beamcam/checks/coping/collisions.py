"""The torch and its holder against the bar, wherever a program takes them.

| holder |          The bar is the whole section along all of X, whatever was cut off
|__    __|          already. The torch is a box across the bar, from its tip outwards,
   |  |             and the holder a wider one behind it.
   |__|  tip
- - - - - - -       A torch that is all beyond a line square to it, which the section does
  section           not reach, is clear of it. What is not is looked at by its shape.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import isfinite

import numpy as np
from shapely import convex_hull, distance, multipoints

from beamcam.checks.coping import rules
from beamcam.checks.coping.section import CoperSection, TubeSection
from beamcam.checks.coping.strokes import TipMove
from beamcam.controllers.events import BarEvent, Move
from beamcam.errors import MAX_OF_A_PROGRAM, Diagnostic, Source
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.coper import Coper

TURN_STEP_DEG = 3.0
HOLDER = 400.0  #: mm that it reaches outwards
SLACK = 0.03  #: mm: of figures as programs have them, and of a fillet's chords


def collision_faults(
    ways: Sequence[TipMove], section: CoperSection | TubeSection, coper: Coper, name: str
) -> Iterator[Diagnostic]:
    """The first place of each move at which the torch comes nearer to the bar than it may."""
    if not ways:
        return
    numbers, before, after = _steps(ways, coper, section.axis)
    swept = np.concatenate((_boxes(before, coper), _boxes(after, coper)), axis=2)
    turned = np.radians((before[:, 2] + after[:, 2]) / 2)
    out = np.column_stack((-np.sin(turned), np.cos(turned)))
    least = coper.play - SLACK
    beyond = np.einsum("nbkc,nc->nbk", swept, out).min(axis=2) - section.reach_along(out)[:, None]
    close = beyond < least
    if not close.any():
        return
    corners = swept[close]
    each = np.repeat(np.arange(len(corners)), corners.shape[1])
    hulls = convex_hull(multipoints(corners.reshape(-1, 2), indices=each))
    near = np.full(close.shape, np.inf)
    near[close] = distance(section.steel, hulls)
    gaps = near.min(axis=1)
    lines: set[int] = set()
    for step in np.flatnonzero(gaps < least).tolist():
        line = ways[numbers[step]].line
        if line not in lines and len(lines) < MAX_OF_A_PROGRAM:
            lines.add(line)
            y, z, a, _ = after[step].tolist()
            yield rules.COLLISION.at(
                Source(name, line), found=f"{gaps[step]:.2f}", a=f"{a:g}", y=f"{y:.1f}",
                z=f"{z:.1f}", expected=f"{coper.play:g}",
            )  # fmt: skip


def turned_unseen(
    events: Iterable[BarEvent], section: CoperSection | TubeSection, coper: Coper, name: str
) -> Iterator[Diagnostic]:
    """A first turn of a bar, from wherever it was, below a torch that its corners may meet.

    Where the torch is before a program says it is not known.
    """
    least = section.reach + coper.play - SLACK
    for event in events:
        if isinstance(event, Move) and isfinite(event.a_deg[1]):
            _, y, z = event.end
            if not isfinite(event.a_deg[0]) and z < least:
                yield rules.COLLISION.at(
                    Source(name, event.line), found=f"{max(z - section.reach, 0.0):.2f}",
                    a=f"{event.a_deg[1]:g}", y=f"{y:.1f}", z=f"{z:.1f}", expected=f"{coper.play:g}",
                )  # fmt: skip
            return


def _steps(
    ways: Sequence[TipMove], coper: Coper, axis: tuple[float, float]
) -> tuple[list[int], Floats, Floats]:
    """Steps of the moves, on each of which the torch turns little: the number of the first way of
    each, and Y, Z, A and B of the tip where it begins and ends, seen from the bar, which turns
    about an axis at (Y, Z) if it does."""
    numbers, starts, ends = _runs(ways)
    turns = np.abs(ends[:, 2:] - starts[:, 2:]).max(axis=1)
    counts = np.where(turns > 0.0, turns // TURN_STEP_DEG + 1, 1).astype(int)
    run = np.repeat(np.arange(len(counts)), counts)
    step = np.arange(len(run)) - np.repeat(np.cumsum(counts) - counts, counts)

    def at(share: Floats) -> Floats:
        y, z, a_deg, b_deg = (starts[run] + share[:, None] * (ends - starts)[run]).T
        c, s = np.cos(np.radians(a_deg)), np.sin(np.radians(a_deg))
        if coper.turns == "bar":
            y, z = axis[0] + y * c - z * s, axis[1] + y * s + z * c
        down = coper.pivot * np.cos(np.radians(b_deg))
        return np.column_stack((y + down * s, z - down * c, a_deg, b_deg))

    return numbers[run].tolist(), at(step / counts[run]), at((step + 1) / counts[run])


def _runs(ways: Sequence[TipMove]) -> tuple[Counts, Floats, Floats]:
    """The moves across the bar, those that follow one another along Y or along Z as one: the number
    of its first way, and Y, Z, A and B of its start and its end.

    What the torch sweeps on such moves is what it sweeps from the least place to the greatest.
    """
    rows = np.array([(*way.start[1:], *way.end[1:], *way.a_deg, *way.b_deg) for way in ways])
    starts, ends = rows[:, (0, 1, 4, 6)], rows[:, (2, 3, 5, 7)]
    stands = starts == ends
    along = stands[:, 2] & stands[:, 3] & (stands[:, 0] | stands[:, 1])
    kinds = np.column_stack((np.where(stands[:, 1], 1.0, 2.0), starts[:, 2:]))
    joins = along[1:] & along[:-1] & (kinds[1:] == kinds[:-1]).all(axis=1)
    first = np.flatnonzero(np.concatenate(([True], ~joins)))
    low = np.minimum.reduceat(np.minimum(starts, ends), first)
    high = np.maximum.reduceat(np.maximum(starts, ends), first)
    straight = along[first][:, None]
    return first, np.where(straight, low, starts[first]), np.where(straight, high, ends[first])


def _boxes(places: Floats, coper: Coper) -> Floats:
    """The corners (Y, Z) of the torch and of its holder at places (Y, Z, A, B) of the tip, an array
    of places, boxes, corners and axes.

    One that is tilted along the bar is as wide as before; its lower edges go down by half its width
    times sin(B).
    """
    a, b = np.radians(places[:, 2]), np.abs(np.radians(places[:, 3]))
    s, c = np.sin(a), np.cos(a)
    torch, holder = coper.torch_width / 2, coper.head_width / 2
    long = coper.torch_length * np.cos(b)
    tip, back, far = -torch * np.sin(b), long - holder * np.sin(b), long + HOLDER
    along = np.stack((tip, tip, long, long, back, back, far, far), axis=1)
    across = np.array((-torch, torch, torch, -torch, -holder, holder, holder, -holder))
    y = places[:, :1] - s[:, None] * along + c[:, None] * across
    z = places[:, 1:2] + c[:, None] * along + s[:, None] * across
    return np.stack((y, z), axis=2).reshape(-1, 2, 4, 2)
