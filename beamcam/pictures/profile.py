"""The picture of a velocity profile: position, velocity and acceleration over time."""

from collections.abc import Iterator
from math import ceil, floor, log10

import numpy as np

from beamcam.geometry.array_types import Floats
from beamcam.geometry.velocity_profile import VelocityProfile
from beamcam.pictures.scene import Polyline, Scene, Shape, Text
from beamcam.report.velocity_profile import VelocityUnit

DRAWN_SAMPLES = 400  #: of a curve; the phases' ends come on top
WIDTH, PANEL, GAP, LEFT, RIGHT, TOP = 900.0, 170.0, 34.0, 86.0, 24.0, 56.0
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
        shapes += _panel(style, label, t, values, TOP + k * (PANEL + GAP), k == 2)
    height = TOP + 3 * PANEL + 2 * GAP + BOTTOM
    at = ((LEFT + WIDTH - RIGHT) / 2, height - 12.0)
    shapes.append(Text("label", at, "time, s", 11.0, "middle"))
    about = f"velocity profile of {profile.duration_s:g} s"
    return Scene("velocity profile", about, WIDTH, height, tuple(shapes))


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
    wide = WIDTH - LEFT - RIGHT

    def at(time: float, value: float) -> tuple[float, float]:
        return LEFT + time / end * wide, top + PANEL * (1.0 - (value - low) / room)

    for value in ticks(low, low + room):
        (x0, y), (x1, _) = at(0.0, value), at(end, value)
        yield Polyline("grid", ((x0, y), (x1, y)))
        yield Polyline("axis tick", ((x0 - 4.0, y), (x0, y)))
        yield Text("figure tick-label", (x0 - 7.0, y + 4.0), number(value), 10.0, "end")
    for time in ticks(0.0, end, 8):
        x, _ = at(time, 0.0)
        yield Polyline("grid", ((x, top), (x, top + PANEL)))
        yield Polyline("axis tick", ((x, top + PANEL), (x, top + PANEL + 4.0)))
        if is_last:
            yield Text("figure tick-label", (x, top + PANEL + 16.0), number(time), 10.0, "middle")
    yield Polyline("axis", (at(0.0, 0.0), at(end, 0.0)))
    box = ((LEFT, top), (WIDTH - RIGHT, top), (WIDTH - RIGHT, top + PANEL), (LEFT, top + PANEL))
    yield Polyline("axis frame", box, True)
    points = tuple([at(a, b) for a, b in zip(t.tolist(), values.tolist(), strict=True)])
    yield Polyline(f"{style} curve", points, tip=label)
    yield Text("label", (LEFT, top - 6.0), label)


def number(value: float) -> str:
    """A number with five significant digits, without exponent and without -0."""
    digits = 0 if value == 0.0 else max(0, 4 - floor(log10(abs(value))))
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text
