"""Points of spans, many at a time.

Spans that have few points each are drawn together: their numbers are repeated for each point.
"""

import itertools
from collections import defaultdict
from math import comb

import numpy as np
from msgspec import Struct, field

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.plane import Point
from beamcam.motion.spans import ArcSpan


class Spans(Struct):
    """All pieces of a path, by their numbers along it, and the spans that each is drawn in."""

    steps: list[list[int]] = field(default_factory=list)  #: of the spans of each piece
    arcs: list[tuple[int, ArcSpan]] = field(default_factory=list)
    lines: list[tuple[int, tuple[float, float]]] = field(default_factory=list)
    #: (degree, with weights) -> (number, control points and steps of its spans, end) of each
    free: dict[tuple[int, bool], list[tuple[int, Floats, Counts, Point]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    deviation: float = 0.0


def draw(start: tuple[float, float], spans: Spans) -> Floats:
    """The points of all spans, array (sum of steps + 1, 2)."""
    ends = np.cumsum([sum(own) for own in spans.steps])
    begins = np.append(0, ends[:-1])
    points = np.empty((int(ends[-1]) + 1, 2))
    points[0] = start
    if spans.lines:
        which = np.array([k for k, _ in spans.lines])
        points[ends[which]] = [end for _, end in spans.lines]
    if spans.arcs:
        _draw_arcs(points, begins, spans.arcs)
    for (degree, weighted), pieces in spans.free.items():
        starts = np.concatenate([begins[k] + np.cumsum(n) - n for k, _, n, _ in pieces])
        control = np.concatenate([c for _, c, _, _ in pieces])
        steps = np.concatenate([n for _, _, n, _ in pieces])
        _draw_free(points, starts, control, steps, degree, weighted)
        # Dividing by a weight costs a bit; the ends of the curves are exact.
        points[[ends[k] for k, *_ in pieces]] = [end for *_, end in pieces]
    return points


#: Arcs with as many steps as this are drawn one by one, shorter ones together: that is where the
#: cost of a numpy call and the cost of repeating an arc's numbers for each point meet.
LONG_SPAN = 40

#: So many points are drawn together: enough to hide the cost of the calls, few enough to stay
#: in the processor's cache.
CHUNK = 1 << 14


def _draw_arcs(points: Floats, begins: Counts, arcs: list[tuple[int, ArcSpan]]) -> None:
    short = []
    for k, span in arcs:
        if span.steps < LONG_SPAN:
            short.append((k, span))
            continue
        _draw_long_arc(points[begins[k] + 1 : begins[k] + span.steps + 1], span)
    if short:
        numbers = np.array([k for k, _ in short])
        steps = np.array([span.steps for _, span in short])
        table = np.array(
            [(np.radians(a.start_deg), np.radians(a.sweep_deg) / a.steps,
              a.centre[0], a.u[0], a.v[0], a.centre[1], a.u[1], a.v[1]) for _, a in short]
        ).T  # fmt: skip
        which, index = _numbered(steps)
        start, step, cx, ux, vx, cy, uy, vy = (row[which] for row in table)
        angle = start + step * index
        c, s = np.cos(angle), np.sin(angle)
        at = begins[numbers][which] + index
        points[at, 0] = cx + ux * c + vx * s
        points[at, 1] = cy + uy * c + vy * s
    last = [begins[k] + span.steps for k, span in arcs]
    points[last] = [span.end for _, span in arcs]


def _draw_long_arc(block: Floats, span: ArcSpan) -> None:
    """Fills `block` with the points of one arc, by turning one short row of them.

    Rows of about sqrt(n) points differ by a turn of u and v, so sine and cosine are needed for
    2 sqrt(n) angles instead of n; each point is one turn away from them, so that errors do not
    add up.
    """
    n = span.steps
    step = np.radians(span.sweep_deg) / n
    width = int(np.ceil(np.sqrt(n)))
    rows = -(-n // width)
    within = np.arange(1, width + 1) * step
    base = np.arange(rows) * (width * step) + np.radians(span.start_deg)
    c, s = np.cos(within), np.sin(within)
    cb, sb = np.cos(base)[:, None], np.sin(base)[:, None]
    for i in (0, 1):
        # u cos(b + w) + v sin(b + w), regrouped by cos(w) and sin(w)
        grid = (span.u[i] * cb + span.v[i] * sb) * c
        grid += (span.v[i] * cb - span.u[i] * sb) * s
        grid += span.centre[i]
        block[:, i] = grid.reshape(-1)[:n]


def _numbered(steps: Counts) -> tuple[Counts, Counts]:
    """For spans of so many steps: the span and the number, from 1, of each of their points."""
    which = np.repeat(np.arange(len(steps)), steps)
    before = np.cumsum(steps) - steps
    return which, np.arange(1, len(which) + 1) - before[which]


def _draw_free(
    points: Floats, begins: Counts, control: Floats, steps: Counts, degree: int, weighted: bool
) -> None:
    """Draws spans of Bezier curves (m, d + 1, 3), by Horner's scheme in powers of the parameter.

    Powers are safe here: the control points of a span lie close together, and are taken from
    its start.
    """
    origin = control[:, :1, :2] / control[:, :1, 2:]
    about = control.copy()
    about[..., :2] -= origin * control[..., 2:]
    powers = np.einsum("pi,mic->pcm", _to_powers(degree), about)
    for low, high in _batches(steps):
        which, index = _numbered(steps[low:high])
        which += low
        t = index / steps[which]
        at = begins[which] + index
        scale = 1.0 / _horner(powers[:, 2, which], t) if weighted else 1.0
        for i in (0, 1):
            points[at, i] = _horner(powers[:, i, which], t) * scale + origin[which, 0, i]
    points[begins + steps] = control[:, -1, :2] / control[:, -1, 2:]


def _horner(coefficients: Floats, t: Floats) -> Floats:
    """The polynomial c0 + c1 t + ..., coefficients along the first axis."""
    total: Floats = coefficients[-1] * t
    for c in coefficients[-2:0:-1]:
        total += c
        total *= t
    total += coefficients[0]
    return total


def _batches(steps: Counts) -> list[tuple[int, int]]:
    """Ranges of spans with about `CHUNK` points together; none for no spans."""
    if not len(steps):
        return []
    reach = np.cumsum(steps) // CHUNK
    edges = [0, *(np.flatnonzero(np.diff(reach)) + 1).tolist(), len(steps)]
    return list(itertools.pairwise(edges))


def _to_powers(degree: int) -> Floats:
    """Matrix from Bernstein coefficients to those of 1, t, t^2, ..."""
    n = range(degree + 1)
    return np.array([[(-1.0) ** (p - i) * comb(degree, p) * comb(p, i) for i in n] for p in n])
