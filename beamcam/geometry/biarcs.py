"""Cubics as lines and arcs, all of them together in arrays.

A cubic that is an arc in disguise becomes that arc. Others become pairs of arcs with one tangent at
their joint, in pieces that are halved until no sample lies farther off than the tolerance.
"""

from dataclasses import dataclass
from math import radians

import numpy as np

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.free_lengths import halved

#: Drawing programs draw no wider arc than this by one cubic.
WIDEST_KNOWN_DEG = 95.0

SAMPLES = 16
#: The greatest deviation is looked for at `SAMPLES` places; between them it may be this larger.
MARGIN = 1.1
#: Times the tolerance that an arc in disguise may be off, which has no joints to leave room for.
WHOLE = 2.0
MAX_HALVINGS = 16
#: A chord that an arc turns by less than this, in radians, is a line.
STRAIGHT = 1e-9

_T = (np.arange(SAMPLES) + 0.5) / SAMPLES
BASIS = np.stack([(1 - _T) ** 3, 3 * _T * (1 - _T) ** 2, 3 * _T**2 * (1 - _T), _T**3])


@dataclass(frozen=True, slots=True)
class LinesAndArcs:
    """Lines and arcs, one a row."""

    cubic: Counts  #: which cubic each stands for a stretch of
    begin: Floats  #: the parameter at which that stretch begins
    ends: Floats  #: (n, 4), start and end
    centre: Floats  #: (n, 2), of lines anything
    side: Floats  #: above 0 counter-clockwise, below 0 clockwise, 0 for a line
    single: Flags  #: whether an arc stands for the whole of its cubic, being that arc

    def sorted(self) -> "LinesAndArcs":
        """The same, as the cubics follow one another and each from its start to its end."""
        order = np.lexsort((self.begin, self.cubic))
        return LinesAndArcs(
            self.cubic[order], self.begin[order], self.ends[order],
            self.centre[order], self.side[order], self.single[order],
        )  # fmt: skip

    def curves(self) -> list[Line | Arc]:
        """The records; of an arc the radius is the mean of the distances of both its ends."""
        start, end = self.ends[:, :2] - self.centre, self.ends[:, 2:] - self.centre
        radius = (np.hypot(start[:, 0], start[:, 1]) + np.hypot(end[:, 0], end[:, 1])) / 2
        first, last = directions_deg(start), directions_deg(end)
        sign = np.where(self.side > 0, 1.0, -1.0)
        sweep = np.mod((last - first) * sign, 360.0)
        sweep = sign * np.where(sweep == 0.0, 360.0, sweep)
        arcs = np.column_stack((self.centre, radius, first, sweep)).tolist()
        return [
            Arc((x, y), r, a, b) if is_arc else Line((x0, y0), (x1, y1))
            for is_arc, (x, y, r, a, b), (x0, y0, x1, y1) in zip(
                (self.side != 0.0).tolist(), arcs, self.ends.tolist(), strict=True
            )
        ]


def directions_deg(vectors: Floats) -> Floats:
    """Angles of vectors (n, 2) in degrees, exact along the axes."""
    x, y = vectors[:, 0], vectors[:, 1]
    angles = np.degrees(np.arctan2(y, x))
    angles = np.where(y == 0.0, np.where(x >= 0.0, 0.0, 180.0), angles)
    return np.where((x == 0.0) & (y < 0.0), 270.0, angles)


def allowed_off(radius: Floats, sweep_rad: Floats, tolerance: float) -> Floats:
    """Permitted deviation of a cubic from the arc that replaces all of it.

    The tolerance; more for an arc no wider than drawing programs draw by one cubic, of radius r
    and sweep s. The usual cubic misses it by r 2/27 sin^6(s/4) / cos^2(s/4): one that is twice as
    far off, its coordinates being rounded, is taken for it up to `WHOLE` times the tolerance.
    """
    quarter = sweep_rad / 4
    known = radius * 4 / 27 * np.sin(quarter) ** 6 / np.cos(quarter) ** 2
    known = np.where(sweep_rad > radians(WIDEST_KNOWN_DEG), 0.0, known)
    return np.clip(MARGIN * MARGIN * known, tolerance, WHOLE * tolerance)


def fit_cubics(control: Floats, tolerance: float) -> LinesAndArcs:
    """Lines and arcs for cubics (n, 4, 2), in their order."""
    single, centre, side = _singles(control, tolerance)
    which = np.flatnonzero(single)
    curves = [
        LinesAndArcs(
            which, np.zeros(len(which)), control[which][:, (0, 3)].reshape(-1, 4),
            centre[which], side[which], np.ones(len(which), dtype=bool),
        )
    ]  # fmt: skip
    owner = np.flatnonzero(~single)
    control = control[owner]
    begin, size = np.zeros(len(owner)), np.ones(len(owner))
    for halving in range(MAX_HALVINGS + 1):
        if not len(control):
            break
        # Which cubics lie within the tolerance of their chord, controls between its ends.
        reach = tolerance / 8
        chord = control[:, 3] - control[:, 0]
        long = np.hypot(chord[:, 0], chord[:, 1])
        safe = np.where(long > 0.0, long, 1.0)
        unit = chord / safe[:, None]
        flat = np.ones(len(control), dtype=bool)
        for k in (1, 2):
            leg = control[:, k] - control[:, 0]
            along = _dot(unit, leg)
            away = np.abs(unit[:, 0] * leg[:, 1] - unit[:, 1] * leg[:, 0])
            flat &= (away <= reach) & (along >= -reach) & (along <= long + reach)
        if halving == MAX_HALVINGS:
            flat[:] = True
        good, joints, bends = _biarcs(control, tolerance)
        good &= ~flat
        moves = flat & (control[:, 0] != control[:, 3]).any(axis=1)
        curves.append(
            _strokes(owner[moves], begin[moves], control[moves, 0], control[moves, 3], None)
        )
        number, at, half = owner[good], begin[good], size[good] / 2
        start, joint, end = control[good, 0], joints[good], control[good, 3]
        curves.append(_strokes(number, at, start, joint, bends[good, 0]))
        curves.append(_strokes(number, at + half, joint, end, bends[good, 1]))
        rest = ~(flat | good)
        owner, begin, size = owner[rest], begin[rest], size[rest] / 2
        control = np.concatenate(halved(control[rest]))
        owner, size = np.concatenate((owner, owner)), np.concatenate((size, size))
        begin = np.concatenate((begin, begin + size[: len(begin)]))
    return LinesAndArcs(
        *(
            np.concatenate([getattr(part, name) for part in curves])
            for name in ("cubic", "begin", "ends", "centre", "side", "single")
        )
    ).sorted()


def _strokes(
    cubic: Counts, begin: Floats, start: Floats, end: Floats, bend: Floats | None
) -> LinesAndArcs:
    """Arcs of curvatures `bend` between points, below half a circle; lines where straight."""
    step = end - start
    chord = np.hypot(step[:, 0], step[:, 1])
    bend = np.zeros(len(cubic)) if bend is None else bend
    bent = np.abs(bend) * chord >= STRAIGHT
    radius = 1 / np.abs(np.where(bent, bend, 1.0))
    height = np.sqrt(np.maximum(0.0, radius * radius - (chord / 2) ** 2))
    side = np.where(bend > 0, 1.0, -1.0)
    unit = step / np.where(bent, chord, 1.0)[:, None]
    middle = (start + end) / 2
    centre = np.column_stack(
        (middle[:, 0] - side * height * unit[:, 1], middle[:, 1] + side * height * unit[:, 0])
    )
    return LinesAndArcs(
        cubic, begin, np.hstack((start, end)), centre, np.where(bent, side, 0.0),
        np.zeros(len(cubic), dtype=bool),
    )  # fmt: skip


def _dot(a: Floats, b: Floats) -> Floats:
    """The scalar product of vectors; numpy takes far longer to sum over an axis of two."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]


def _cross(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _biarcs(control: Floats, tolerance: float) -> tuple[Flags, Floats, Floats]:
    """For each cubic whether two arcs do, their joint (n, 2), and their curvatures (n, 2).

    Equal legs d: with v the chord, t the sum of both tangents and q = 2 (1 - t0.t1),
    d = v.v / (v.t + sqrt((v.t)^2 + q v.v)). Source: Bolton, "Biarc curves", 1975.
    """
    start, end = control[:, 0], control[:, 3]
    reach = np.max(np.abs(control - control[:, :1]), axis=(1, 2)) * 1e-9

    def direction(order: tuple[int, int, int, int]) -> Floats:
        tangents = np.zeros((len(control), 2))
        open_rows = np.ones(len(control), dtype=bool)
        for k in order[1:]:
            step = control[:, k] - control[:, order[0]]
            size = np.hypot(step[:, 0], step[:, 1])
            take = open_rows & (size > reach)
            tangents[take] = step[take] / size[take][:, None]
            open_rows &= ~take
        return tangents

    t0, t1 = direction((0, 1, 2, 3)), -direction((3, 2, 1, 0))
    v = end - start
    vv, vt = _dot(v, v), _dot(v, t0 + t1)
    q = 2 * (1 - _dot(t0, t1))
    with np.errstate(divide="ignore", invalid="ignore"):
        legs = vv / (vt + np.sqrt(vt * vt + q * vv))
        ahead = np.isfinite(legs) & (legs > 0.0) & (vt > 0.0)
        legs = np.where(ahead, legs, 0.0)
        joint = (start + legs[:, None] * t0 + end - legs[:, None] * t1) / 2
        one, two = joint - start, end - joint
        # Curvature of the arc that leaves p along t and ends in p + c: 2 cross(t, c) / c.c
        bend0 = 2 * _cross(t0, one) / _dot(one, one)
        bend1 = 2 * _cross(two, t1) / _dot(two, two)
        ahead &= (_dot(one, t0) > 0.0) & (_dot(two, t1) > 0.0)
        samples = np.einsum("ks,nkd->nsd", BASIS, control)
        # The chord from p is turned by half the sweep, so the joint's tangent is t0 mirrored.
        unit = one / np.hypot(one[:, 0], one[:, 1])[:, None]
        at_joint = 2 * _dot(unit, t0)[:, None] * unit - t0
        before = _dot(samples - joint[:, None], at_joint[:, None]) <= 0.0
        off0 = _off_circle(samples - start[:, None], t0, bend0)
        off1 = _off_circle(samples - end[:, None], t1, bend1)
        # A circle goes on behind both ends of an arc, and a hook there is on it too.
        behind = np.minimum(
            _dot(samples - start[:, None], t0[:, None]), _dot(end[:, None] - samples, t1[:, None])
        )
    worst = MARGIN * np.max(np.abs(np.where(before, off0, off1)), axis=1)
    worst = np.where(np.isfinite(worst), worst, np.inf)
    ahead &= np.min(behind, axis=1) >= -tolerance
    return ahead & (worst <= tolerance), joint, np.column_stack((bend0, bend1))


def _off_circle(u: Floats, tangent: Floats, bend: Floats) -> Floats:
    """Signed distance of points p + u (n, s, 2) from the circle through p with a tangent there.

    (k s - 2 a) / (1 + sqrt(1 - 2 a k + k^2 s)), a the offset to the left of the tangent, s = u.u:
    no centre is needed, so that a line is a circle as well.
    """
    a = tangent[:, None, 0] * u[..., 1] - tangent[:, None, 1] * u[..., 0]
    s = _dot(u, u)
    k = bend[:, None]
    return np.asarray((k * s - 2 * a) / (1 + np.sqrt(np.maximum(0.0, 1 - 2 * a * k + k * k * s))))


def _singles(control: Floats, tolerance: float) -> tuple[Flags, Floats, Floats]:
    """Which cubics are one arc, its centre (n, 2), and its side: above 0 counter-clockwise."""
    start, end = control[:, 0], control[:, 3]
    middle = (start + 3 * control[:, 1] + 3 * control[:, 2] + end) / 8
    u, w = middle - start, end - start
    area = 2 * _cross(u, w)
    uu, ww = _dot(u, u), _dot(w, w)
    with np.errstate(divide="ignore", invalid="ignore"):
        bent = np.abs(area) > 1e-9 * (uu + ww)
        rise = np.stack((w[:, 1] * uu - u[:, 1] * ww, u[:, 0] * ww - w[:, 0] * uu), axis=1)
        centre = start + rise / area[:, None]
        radius = np.hypot(*(start - centre).T)
        samples = np.einsum("ks,nkd->nsd", BASIS, control) - centre[:, None]
        off = MARGIN * np.max(
            np.abs(np.hypot(samples[..., 0], samples[..., 1]) - radius[:, None]), axis=1
        )
        turns = np.unwrap(np.arctan2(samples[..., 1], samples[..., 0]), axis=1)
        steps = np.diff(turns, axis=1) * np.where(area > 0, 1.0, -1.0)[:, None]
        sweep = np.abs(turns[:, -1] - turns[:, 0]) * SAMPLES / (SAMPLES - 1)
        good = bent & (off <= allowed_off(radius, sweep, tolerance)) & np.all(steps > 0.0, axis=1)
    return good, centre, area
