"""A velocity profile as a table, as an SVG drawing and as a PNG picture."""

import itertools
import struct
import zlib
from math import floor, log10

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.array_types import Floats
from beamcam.geometry.velocity_profile import Profile

#: Samples of a drawn curve; the phases' ends come on top.
DRAWN_SAMPLES = 400


class Unit(Struct, frozen=True):
    """What velocities are counted in; positions come as velocity times its seconds."""

    name: str
    seconds: float  #: in which a velocity of 1 makes a way of 1
    way: str  #: unit of positions

    def labels(self) -> tuple[str, str, str]:
        """Names of the curves of position, velocity and acceleration."""
        return f"position, {self.way}", f"velocity, {self.name}", f"acceleration, {self.name}/s"


RPM = Unit("rpm", 60.0, "revolutions")
MM_S = Unit("mm/s", 1.0, "mm")
UNITS = {unit.name: unit for unit in (RPM, MM_S)}


class Encoder(Struct, frozen=True):
    """What a pulse counter on the shaft shows."""

    pulses: int  #: a revolution
    travel: float | None = None  #: way of one revolution; None where velocities are rpm already

    def __post_init__(self) -> None:
        if self.pulses <= 0 or (self.travel is not None and not self.travel > 0.0):
            raise ValueError(f"an encoder needs pulses and travel above 0, found {self!r}")

    def rpm(self, velocity: Floats) -> Floats:
        """Revolutions a minute."""
        return velocity * 1.0 if self.travel is None else velocity / self.travel * 60.0

    def hz(self, velocity: Floats) -> Floats:
        """Pulses a second: rpm = Hz 60 / pulses."""
        return self.rpm(velocity) * self.pulses / 60.0


class ProfileTable(Struct, frozen=True):
    """Rows of numbers under the names of their columns."""

    columns: tuple[str, ...]
    rows: Floats  #: (n, number of columns)


def profile_table(
    profile: Profile, step_s: float, encoder: Encoder | None = None, unit: Unit = MM_S
) -> ProfileTable:
    """Time, position, velocity and acceleration every `step_s`, the end always included; with
    an encoder its frequency and speed too.

    Raises ValueError if the step is not above 0.
    """
    if not step_s > 0.0:
        raise ValueError(f"the step of a table must be above 0 s, found {step_s:g}")
    count = floor(profile.duration_s / step_s * (1 + 1e-12))
    t = np.arange(count + 1) * step_s
    if profile.duration_s - t[-1] > 1e-9 * step_s:
        t = np.append(t, profile.duration_s)
    else:
        t[-1] = profile.duration_s
    x, v, a = profile.sample(t)
    columns, names = [t, x / unit.seconds, v, a], ["t_s", "position", "velocity", "acceleration"]
    if encoder is not None:
        columns += [encoder.hz(v), encoder.rpm(v)]
        names += ["encoder_hz", "encoder_rpm"]
    return ProfileTable(tuple(names), np.column_stack(columns))


class _Panel(Struct, frozen=True):
    """One of the three curves, scaled to its place in the picture."""

    name: str
    low: float
    high: float
    top: float
    bottom: float
    points: Floats  #: (n, 2), picture coordinates, y down


def _panels(
    profile: Profile, width: float, height: float, margin: float, unit: Unit
) -> list[_Panel]:
    edges = [e for p in profile.phases for e in (p.start_s, p.start_s + p.duration_s * (1 - 1e-12))]
    t = np.unique(np.concatenate((np.linspace(0, profile.duration_s, DRAWN_SAMPLES), edges)))
    found = []
    each = (height - margin) / 3
    right = (width - 2 * margin) / (profile.duration_s or 1.0)
    x, v, a = profile.sample(t)
    curves = (x / unit.seconds, v, a)
    for k, (name, values) in enumerate(zip(unit.labels(), curves, strict=True)):
        low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
        top, bottom = margin / 2 + k * each, margin / 2 + (k + 1) * each - margin / 2
        scale = (bottom - top) / ((high - low) or 1.0)
        points = np.column_stack((margin + t * right, bottom - (values - low) * scale))
        found.append(_Panel(name, low, high, top, bottom, points))
    return found


def _number(value: float) -> str:
    """A number with five significant digits, without exponent and without -0."""
    digits = 0 if value == 0.0 else max(0, 4 - floor(log10(abs(value))))
    text = f"{value:.{digits}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def profile_svg(profile: Profile, width: int = 800, height: int = 600, unit: Unit = MM_S) -> str:
    """A drawing of position, velocity and acceleration over time, one above the other."""
    margin = 60.0
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for panel, colour in zip(
        _panels(profile, width, height, margin, unit),
        ("#1b7837", "#2166ac", "#b2182b"),
        strict=True,
    ):
        zero = panel.bottom + panel.low * (panel.bottom - panel.top) / (
            (panel.high - panel.low) or 1.0
        )
        d = " ".join(f"{x:.2f},{y:.2f}" for x, y in panel.points.tolist())
        lines += [
            f'<rect x="{margin:.0f}" y="{panel.top:.2f}" width="{width - 2 * margin:.0f}" '
            f'height="{panel.bottom - panel.top:.2f}" fill="none" stroke="#999999"/>',
            f'<line x1="{margin:.0f}" y1="{zero:.2f}" x2="{width - margin:.0f}" y2="{zero:.2f}" '
            'stroke="#cccccc"/>',
            f'<polyline points="{d}" fill="none" stroke="{colour}" stroke-width="1.5"/>',
            f'<text x="{margin + 6:.0f}" y="{panel.top + 14:.2f}">{panel.name}</text>',
            f'<text x="{margin - 4:.0f}" y="{panel.top + 10:.2f}" text-anchor="end">'
            f"{_number(panel.high)}</text>",
            f'<text x="{margin - 4:.0f}" y="{panel.bottom:.2f}" text-anchor="end">'
            f"{_number(panel.low)}</text>",
        ]
    lines += [
        f'<text x="{width - margin:.0f}" y="{height - 12}" text-anchor="end">'
        f"{_number(profile.duration_s)} s</text>",
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def profile_png(profile: Profile, width: int = 800, height: int = 600) -> bytes:
    """The same three curves as a PNG picture, without text."""
    picture = np.full((height, width, 3), 255, dtype=np.uint8)
    for panel, colour in zip(
        _panels(profile, width, height, 30.0, MM_S),
        ((27, 120, 55), (33, 102, 172), (178, 24, 43)),
        strict=True,
    ):
        left, right = 30.0, width - 30.0
        corners = [(left, panel.top), (right, panel.top), (right, panel.bottom)]
        corners += [(left, panel.bottom), (left, panel.top)]
        _stroke(picture, np.array(corners), (153, 153, 153))
        _stroke(picture, panel.points, colour)
    return encode_png(picture)


def _stroke(picture: NDArray[np.uint8], points: Floats, colour: tuple[int, int, int]) -> None:
    """Draws a line of one pixel: as many places between two points as there are pixels."""
    height, width, _ = picture.shape
    for a, b in itertools.pairwise(points):
        count = int(np.ceil(np.max(np.abs(b - a)))) + 1
        places = a + np.linspace(0.0, 1.0, count + 1)[:, None] * (b - a)
        column, row = np.rint(places).astype(int).T
        picture[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)] = colour


def encode_png(picture: NDArray[np.uint8]) -> bytes:
    """A PNG file of an array (height, width, 3). Source: PNG specification, second edition."""
    height, width, _ = picture.shape

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    # Each row of pixels follows a 0, the filter "none".
    rows = np.concatenate((np.zeros((height, 1), np.uint8), picture.reshape(height, -1)), axis=1)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9))
        + chunk(b"IEND", b"")
    )
