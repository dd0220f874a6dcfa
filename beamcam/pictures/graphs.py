"""The picture of an encoder's resolution: the staircase about the corner that is read furthest off.

two axes, plan          each axis over time
+--+--+--+--+           |      __/
|  .--'--+  |  true     |   __/_|    true, and what is read
|__|  |  |  |  read     |__/_|
+--+--+--+--+           +---------
a square is a count
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import ceil, floor, log10

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Floats
from beamcam.motion.velocity_profile import VelocityProfile
from beamcam.pictures.scene import Circle, Point, Polyline, Scene, Shape, Text
from beamcam.pictures.views import SIDE, WIDTH, footing, head_height, heading
from beamcam.reports.velocity_profile import VelocityUnit
from beamcam.simulation.encoder import Encoder, Precision, precision, stair_times
from beamcam.simulation.trace import Trace

COUNTS = 8  #: shown on each side of the corner
SAMPLES = 16  #: of the true way from count to count
PLAN, GAP, LINE = 420.0, 96.0, 15.0
PLOT_WIDTH, PLOT_HEIGHT = WIDTH - 2 * SIDE - PLAN - GAP, 182.0


class Study(Struct, frozen=True):
    """A trace as an encoder reads it."""

    name: str  #: of the program
    sha256: str
    machine: str
    trace: Trace
    encoder: Encoder

    @property
    def precision(self) -> Precision:
        """Its figures."""
        return precision(self.trace, self.encoder)

    def figures(self) -> list[tuple[str, str]]:
        """What is lost, by name and value."""
        precision = self.precision
        largest = f"{precision.max_corner_error:.4f} mm, block {precision.worst_line}"
        mean = f"{precision.mean_corner_error:.4f} mm of {precision.corners} corners"
        return [
            ("one count", f"{precision.count:.4f} mm"),
            ("largest corner error", largest),
            ("mean corner error", mean),
            ("smallest step", f"{precision.smallest_step:.4f} mm"),
            ("moves below one count", f"{precision.lost_moves} of {precision.moves}"),
        ]


class _Window(Struct, frozen=True):
    """The surroundings of the worst corner, in two axes."""

    axes: tuple[int, int]
    names: tuple[str, str]
    corner: Floats  #: (2,) true
    read_corner: Floats
    time_s: Floats  #: (n,) of the true way
    true: Floats  #: (n, 2)
    stair_s: Floats  #: (m,) when what is read changes
    read: Floats  #: (m, 2) from that time on


def encoder_scene(study: Study) -> Scene:
    """The staircase about the worst corner, in plan and over time, and the study's figures."""
    encoder = study.encoder
    lines = [
        f"{study.name}: encoder of {encoder.shown}",
        f"{study.machine}; the corner that is read furthest off, a square is a count",
    ]
    top = head_height(lines) + 16.0
    shapes: list[Shape] = [*heading(lines)]
    window = _window(study)
    shapes += _plan(window, encoder.count, top)
    left = SIDE + PLAN + GAP
    for k in (0, 1):
        shapes += _over_time(window, k, left, top + k * (PLAN - PLOT_HEIGHT), is_last=k == 1)
    y = top + PLAN + 46.0
    x = SIDE
    for style, text in (("true", "true"), ("stair", "as the encoder reads it")):
        shapes.append(Polyline(f"{style} legend", ((x, y), (x + 22.0, y))))
        shapes.append(Text("label", (x + 28.0, y + 4.0), text))
        x += 90.0
    x += 90.0
    shapes.append(Circle("off legend", (x, y), 4.0))
    shapes.append(Text("label", (x + 10.0, y + 4.0), "corner, with the way to what is read"))
    for k, (name, value) in enumerate(study.figures()):
        shapes.append(Text("label", (SIDE, y + 26.0 + k * LINE), name))
        shapes.append(Text("label study", (SIDE + 170.0, y + 26.0 + k * LINE), value))
    y += 26.0 + LINE * len(study.figures())
    shapes += footing([f"{study.name}   sha-256 {study.sha256}"], y)
    about = (
        f"program {study.name} as an encoder of {encoder.shown} reads it; sha-256 {study.sha256}"
    )
    return Scene(f"{study.name}: encoder", about, WIDTH, y + 30.0, tuple(shapes))


def _window(study: Study) -> _Window:
    trace, encoder, precision = study.trace, study.encoder, study.precision
    # The two axes in mm that move most into the corner and out of it; the first ones of equals.
    knot = int(np.searchsorted(trace.time_s, precision.worst_time_s))
    moved = np.abs(np.diff(trace.positions[max(knot - 1, 0) : knot + 2], axis=0)).sum(axis=0)
    linear = [k for k, axis in enumerate(trace.axes) if axis.is_read]
    chosen = sorted(sorted(linear, key=lambda k: -moved[k])[:2])
    axes = chosen[0], chosen[-1]
    stairs = stair_times(trace, encoder)
    corner = trace.at([precision.worst_time_s])[0]
    near = np.all(np.abs((trace.at(stairs) - corner)[:, axes]) <= COUNTS * encoder.count, axis=1)
    at = int(np.searchsorted(stairs, precision.worst_time_s))
    far = np.flatnonzero(~near)
    first = int(far[far < at][-1]) + 1 if np.any(far < at) else 0
    last = int(far[far > at][0]) - 1 if np.any(far > at) else len(stairs) - 1
    own = stairs[first : last + 1]
    # Between two stairs the count stays, so that its middle tells what is read from the first on.
    middles = np.append((own[:-1] + own[1:]) / 2, own[-1])
    fine = np.unique(
        np.concatenate([np.linspace(a, b, SAMPLES) for a, b in pairwise(own)])
        if len(own) > 1
        else own
    )
    return _Window(
        axes, (trace.axes[axes[0]].name, trace.axes[axes[1]].name), corner[list(axes)],
        encoder.read(trace, corner[None])[0, axes], fine, trace.at(fine)[:, axes], own,
        encoder.read(trace, trace.at(middles))[:, axes],
    )  # fmt: skip


def _plan(window: _Window, count: float, top: float) -> Iterator[Shape]:
    """Both axes: the raster of counts, the true way and what is read of it."""
    scale = PLAN / (2 * COUNTS * count)
    low = window.corner - COUNTS * count

    def at(point: Sequence[float]) -> Point:
        x, y = point
        return SIDE + (x - low[0]) * scale, top + PLAN - (y - low[1]) * scale

    side = 2 * COUNTS * count
    for k in (0, 1):
        first = ceil(low[k] / count)
        for number_of in range(first, floor((low[k] + side) / count) + 1):
            ends = [low.copy(), low + side]
            ends[0][k] = ends[1][k] = number_of * count
            yield Polyline("grid", tuple(at(end.tolist()) for end in ends))
    yield Polyline("axis frame", _frame(SIDE, top, PLAN, PLAN), True)
    yield Polyline("true way", tuple(at(p) for p in window.true.tolist()), tip="true")
    yield Polyline("stair way", tuple(at(p) for p in window.read.tolist()), tip="as read")
    yield Polyline("off", (at(window.corner.tolist()), at(window.read_corner.tolist())))
    yield Circle("off corner", at(window.corner.tolist()), 4.0, "the corner")
    yield Text("label", (SIDE + PLAN / 2, top + PLAN + 16.0), window.names[0], 11.0, "middle")
    yield Text("label", (SIDE - 8.0, top + PLAN / 2), window.names[1], 11.0, "middle", 90.0)


def _over_time(window: _Window, k: int, left: float, top: float, is_last: bool) -> Iterator[Shape]:
    """One axis over time, true and as read."""
    t0, t1 = float(window.stair_s[0]), float(window.stair_s[-1])
    span = (t1 - t0) or 1.0
    low = float(min(window.true[:, k].min(), window.read[:, k].min()))
    high = float(max(window.true[:, k].max(), window.read[:, k].max()))
    room = (high - low) or 1.0

    def at(time: float, value: float) -> Point:
        y = top + PLOT_HEIGHT * (1.0 - (value - low) / room)
        return left + (time - t0) / span * PLOT_WIDTH, y

    values = [(value, at(t0, value)[1]) for value in ticks(low, low + room, 5)]
    times = [(time, at(time, low)[0]) for time in ticks(t0, t0 + span, 4)]
    yield from _grid(left, top, PLOT_WIDTH, PLOT_HEIGHT, values, times, is_last)
    yield Polyline("axis frame", _frame(left, top, PLOT_WIDTH, PLOT_HEIGHT), True)
    true = zip(window.time_s.tolist(), window.true[:, k].tolist(), strict=True)
    yield Polyline("true curve", tuple(at(t, v) for t, v in true), tip="true")
    stairs: list[Point] = []
    for t, v in zip(window.stair_s.tolist(), window.read[:, k].tolist(), strict=True):
        if stairs:
            stairs.append((at(t, v)[0], stairs[-1][1]))
        stairs.append(at(t, v))
    yield Polyline("stair curve", tuple(stairs), tip="as read")
    yield Text("label", (left, top - 5.0), f"{window.names[k]}, mm")
    if is_last:
        at_end = (left + PLOT_WIDTH / 2, top + PLOT_HEIGHT + 30.0)
        yield Text("label", at_end, "time, s", 11.0, "middle")


def _grid(
    left: float, top: float, wide: float, high: float, values: Sequence[tuple[float, float]],
    times: Sequence[tuple[float, float]], has_times: bool, tick: float = 0.0,
) -> Iterator[Shape]:  # fmt: skip
    """The lines of a graph at values and times, each with its place on the paper, and its ticks."""
    for value, y in values:
        yield Polyline("grid", ((left, y), (left + wide, y)))
        if tick:
            yield Polyline("axis tick", ((left - tick, y), (left, y)))
        place = (left - (7.0 if tick else 6.0), y + 4.0)
        yield Text("figure tick-label", place, number(value), 10.0, "end")
    for time, x in times:
        yield Polyline("grid", ((x, top), (x, top + high)))
        if tick:
            yield Polyline("axis tick", ((x, top + high), (x, top + high + tick)))
        if has_times:
            place = (x, top + high + (16.0 if tick else 14.0))
            yield Text("figure tick-label", place, number(time), 10.0, "middle")


def _frame(left: float, top: float, width: float, height: float) -> tuple[Point, ...]:
    right, bottom = left + width, top + height
    return (left, top), (right, top), (right, bottom), (left, bottom)


DRAWN_SAMPLES = 400  #: of a curve; the phases' ends come on top
ACROSS, PANEL, BETWEEN, LEFT, RIGHT, TOP = 900.0, 170.0, 34.0, 86.0, 24.0, 56.0
BOTTOM = 52.0


def profile_scene(profile: VelocityProfile, unit: VelocityUnit) -> Scene:
    """The three curves one above the other, with ticks, numbers and units."""
    t = sample_times(profile)
    x, v, a = profile.sample(t)
    shapes: list[Shape] = [Text("heading", (LEFT, 24.0), "velocity profile", 14.0)]
    for k, (style, label, values) in enumerate(
        zip(("position", "velocity", "acceleration"), unit.labels(),
            (x / unit.seconds, v, a), strict=True)
    ):  # fmt: skip
        shapes += _panel(style, label, t, values, TOP + k * (PANEL + BETWEEN), k == 2)
    height = TOP + 3 * PANEL + 2 * BETWEEN + BOTTOM
    at = ((LEFT + ACROSS - RIGHT) / 2, height - 12.0)
    shapes.append(Text("label", at, "time, s", 11.0, "middle"))
    about = f"velocity profile of {profile.duration_s:g} s"
    return Scene("velocity profile", about, ACROSS, height, tuple(shapes))


def sample_times(profile: VelocityProfile) -> Floats:
    """Times at which a curve is drawn: equal steps, and where phases begin and end."""
    edges = [e for p in profile.phases for e in (p.start_s, p.start_s + p.duration_s * (1 - 1e-12))]
    return np.unique(np.concatenate((np.linspace(0, profile.duration_s, DRAWN_SAMPLES), edges)))


def ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Round numbers from `low` to `high`, about so many: 1, 2 or 5 times a power of ten."""
    span = high - low
    if not span > 0.0:
        return [low]
    raw = span / count
    power = 10.0 ** floor(log10(raw))
    step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= raw * (1 - 1e-9))
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return [k * step for k in range(first, last + 1)]


def _panel(
    style: str, label: str, t: Floats, values: Floats, top: float, is_last: bool
) -> Iterator[Shape]:
    low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
    room = (high - low) or 1.0
    end = float(t[-1]) or 1.0
    wide = ACROSS - LEFT - RIGHT

    def at(time: float, value: float) -> tuple[float, float]:
        return LEFT + time / end * wide, top + PANEL * (1.0 - (value - low) / room)

    rows = [(value, at(0.0, value)[1]) for value in ticks(low, low + room)]
    times = [(time, at(time, 0.0)[0]) for time in ticks(0.0, end, 8)]
    yield from _grid(LEFT, top, wide, PANEL, rows, times, is_last, 4.0)
    yield Polyline("axis", (at(0.0, 0.0), at(end, 0.0)))
    yield Polyline("axis frame", _frame(LEFT, top, ACROSS - RIGHT - LEFT, PANEL), True)
    points = tuple([at(a, b) for a, b in zip(t.tolist(), values.tolist(), strict=True)])
    yield Polyline(f"{style} curve", points, tip=label)
    yield Text("label", (LEFT, top - 6.0), label)


def number(value: float) -> str:
    """A number with five significant digits, without exponent and without -0."""
    digits = 0 if value == 0.0 else max(0, 4 - floor(log10(abs(value))))
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text
