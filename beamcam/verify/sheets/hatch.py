"""Check that the lines of a hatch are those that fill its contours, each in its place.

What an odd number of closed contours of a look enclose is drawn as polygons and cut by lines a
distance apart, the first half of it above the lowest point of the contours:

    required   every piece of a cut line that is longer than two distances, without half a distance
               at both ends
    allowed    nothing else; a piece that is as long as that but for the slack may be there or not

Nothing of this is taken from `model.hatch`, by which the lines are made.
"""

from collections.abc import Iterator, Sequence
from itertools import groupby
from math import cos, radians, sin

import numpy as np
import shapely
from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Curve, Line
from beamcam.machine.torch import LookSettings, Torch, TorchProcess
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.need import Need
from beamcam.verify.sheets.work import SHOWN, Work

CHORD = 0.1  #: mm
SLACK = 0.05  #: mm that an end may be elsewhere, where lines run flat into a contour
#: mm from a line, where it is looked what lies above and below an edge on it, or one so near that
#: chords in place of the curve may lie on its other side.
ASIDE = (0.0, 1e-6, -1e-6, 0.01, -0.01)
HATCH = "hatch"  #: where the input's reader says that a line of a hatch is


Spans = tuple[float, float]  #: where a piece of a line begins and ends along x


class _Fault(Struct, frozen=True):
    what: str
    place: tuple[float, float]  #: where the lines lie along x


class _Filled(Struct):
    """The filled area of one look, and its lines; both turned so that these lie along x."""

    rings: list[Floats]
    lines: list[Floats]


def hatch_faults(need: Need, torch: Torch, name: str) -> list[Diagnostic]:
    """Hatches with a line too few or too many, or one that is elsewhere than it has to be."""
    said: list[Diagnostic] = []
    keys = {look: process for process in need.curves for look in need.looks[process]}
    for key in dict.fromkeys([*keys, *need.filled]):
        own = torch.settings.get(key)
        if own is None or own.hatch is None:
            continue
        for fault in _faults(_filled(need, keys.get(key), key, own), own.hatch):
            c, s = cos(radians(own.hatch_angle)), sin(radians(own.hatch_angle))
            (x, y) = fault.place
            said.append(
                rules.HATCH.at(
                    Source(name), key=key, found=fault.what, x=f"{c * x - s * y:.3f}",
                    y=f"{s * x + c * y:.3f}", expected=f"{own.hatch:g}",
                    angle=f"{own.hatch_angle:g}",
                )
            )  # fmt: skip
            break
    return said


def overscan_faults(work: Work) -> Iterator[Diagnostic]:
    """Lines of a hatch without their overscan, and other strokes with one."""
    over = work.torch.overscan if work.torch.laser_mode else 0.0
    if not over or not work.strokes or not work.need.count:
        return
    firsts = np.searchsorted(work.of_way, np.arange(len(work.strokes)))
    middles = (work.path.starts[firsts] + work.path.ends[firsts]) / 2
    _, nearest = work.need.nearest(middles, work.tolerance)
    told = 0
    for stroke, way, (x, y) in zip(work.strokes, nearest.tolist(), middles.tolist(), strict=True):
        is_line = work.asked.source(work.process, way).where == HATCH
        expected = over if is_line else 0.0
        if max(abs(found - expected) for found in stroke.overscan) <= 2 * work.tolerance:
            continue
        told += 1
        if told <= SHOWN:
            before, behind = stroke.overscan
            yield rules.OVERSCAN.at(
                Source(work.name, stroke.line), x=f"{x:.3f}", y=f"{y:.3f}",
                found=f"{before:.3f} and {behind:.3f}", expected=f"{expected:g}",
            )  # fmt: skip


def _faults(filled: _Filled, distance: float) -> Iterator[_Fault]:
    """Where lines differ from those that fill the area.

    Where an edge lies on a line or grazes it, that may fill what is above it, what is below it, or
    both.
    """
    if not filled.rings:
        return
    low = float(np.concatenate(filled.rings)[:, 1].min())
    found: dict[int, list[Spans]] = {}
    for line in filled.lines:
        (x0, y), (x1, y1) = line[0].tolist(), line[-1].tolist()
        k = round((y - low) / distance - 0.5)
        expected = low + (k + 0.5) * distance
        if abs(y - y1) > SLACK / 10 or abs(y - expected) > SLACK / 10:
            yield _Fault("a line between those that fill it, or at another angle", (x0, y))
        else:
            span = min(x0, x1) - distance / 2, max(x0, x1) + distance / 2
            found.setdefault(k, []).append(span)
    wrong: dict[int, _Fault] | None = None
    for aside in ASIDE:
        pieces = _pieces(filled.rings, distance, aside)
        still: dict[int, _Fault] = {}
        for k in sorted({*found, *pieces} if wrong is None else wrong):
            y = low + (k + 0.5) * distance
            fault = _line_fault(found.get(k, []), pieces.get(k, []), distance, y)
            if fault is not None:
                still[k] = fault if wrong is None else wrong[k]
        wrong = still
        if not wrong:
            return
    yield from (wrong or {}).values()


def _line_fault(
    found: Sequence[Spans], pieces: Sequence[Spans], distance: float, y: float
) -> _Fault | None:
    """Where what is found of one line differs from the pieces that it should have."""
    slack = max(SLACK, distance / 4)
    left = list(pieces)
    for a, b in found:
        fits = [span for span in left if max(abs(span[0] - a), abs(span[1] - b)) <= slack]
        if not fits:
            return _Fault("a line that ends elsewhere, or is there twice", (a, y))
        left.remove(fits[0])
    for a, b in left:
        if b - a > 2 * distance + 2 * slack:
            return _Fault("no line", ((a + b) / 2, y))
    return None


def _pieces(rings: list[Floats], distance: float, aside: float) -> dict[int, list[Spans]]:
    """The pieces of each line in the area, by the number of the line; lines are `aside` higher."""
    inside: shapely.Geometry = shapely.Polygon()
    for ring in rings:
        inside = shapely.symmetric_difference(inside, shapely.make_valid(shapely.Polygon(ring)))
    points = np.concatenate(rings)
    (x0, low), (x1, high) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    count = int((high - low) / distance + 0.5) + 1
    ys = low + (np.arange(count) + 0.5) * distance + aside
    ends = np.stack((np.full(count, x0 - 1), ys, np.full(count, x1 + 1), ys), axis=1)
    cut = shapely.intersection(shapely.linestrings(ends.reshape(-1, 2, 2)), inside)
    parts, number = shapely.get_parts(cut, return_index=True)
    found: dict[int, list[Spans]] = {}
    for (a, _, b, _), k in zip(shapely.bounds(parts).tolist(), number.tolist(), strict=True):
        found.setdefault(k, []).append((a, b))
    return found


def _filled(need: Need, process: TorchProcess | None, key: str, own: LookSettings) -> _Filled:
    """The closed contours and the lines of a look, turned."""
    filled = _Filled([], [])
    c, s = cos(radians(own.hatch_angle)), sin(radians(own.hatch_angle))

    def turned(points: list[tuple[float, float]]) -> Floats:
        found: Floats = np.array(points) @ np.array([[c, -s], [s, c]])
        return found

    for contour in need.filled.get(key, []):
        filled.rings.append(turned([p for curve in contour.curves for p in _points(curve)]))
    if process is None:
        return filled
    rows = zip(need.features[process], need.looks[process], need.curves[process], strict=True)
    for feature, group in groupby(rows, key=lambda row: row[0]):
        mine = [curve for _, look, curve in group if look == key]
        if not mine:
            continue
        points = [p for curve in mine for p in _points(curve)]
        if need.sources[feature].where == HATCH:
            filled.lines.append(turned(points))
        elif len(points) > 3 and mine[0].start == mine[-1].end:
            filled.rings.append(turned(points))
    return filled


def _points(curve: Curve) -> list[tuple[float, float]]:
    count = 1 if isinstance(curve, Line) else max(16, int(curve.length / CHORD))
    return [curve.point(k / count) for k in range(count + 1)]


def one_way_faults(work: Work) -> list[Diagnostic]:
    """The first line of a hatch that is followed backwards where all are to run one way."""
    torch, need = work.torch, work.need
    every = [
        k for k, (look, feature) in enumerate(
            zip(work.asked.looks[work.process], work.asked.features[work.process], strict=True)
        )
        if look in torch.settings and torch.settings[look].hatch_one_way
        and work.asked.sources[feature].where == HATCH
    ]  # fmt: skip
    if not every or not work.strokes:
        return []
    ways = np.array(every)
    points = need.point(ways, need.lengths[ways] / 2)
    pairs = work.path.near(points, float(work.slack.max(initial=0.0)))
    legs = work.path.elements.directions(pairs.element, np.zeros(len(pairs.element)))
    angles = [torch.settings[work.asked.looks[work.process][k]].hatch_angle for k in every]
    turns = np.radians(angles)[pairs.point]
    along = legs[:, 0] * np.cos(turns) + legs[:, 1] * np.sin(turns)
    # What crosses a line is not part of it.
    back = np.flatnonzero(along < -0.99)
    if not len(back):
        return []
    k = int(back[0])
    way = int(work.path.owner[pairs.element[k]])
    x, y = points[pairs.point[k]].tolist()
    line = int(work.moves.line[way])
    key = work.asked.looks[work.process][every[int(pairs.point[k])]]
    return [rules.HATCH_WAY.at(Source(work.name, line), key=key, x=f"{x:.3f}", y=f"{y:.3f}")]
