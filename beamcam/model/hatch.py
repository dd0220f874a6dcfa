"""Lines that fill closed contours: the hatch of an engraved colour or layer."""

from collections.abc import Iterator
from itertools import pairwise
from math import ceil

from msgspec.structs import replace

from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point, unit_vector
from beamcam.machine.torch import LayerSettings, Torch
from beamcam.model.colour import key_of
from beamcam.model.part import Contour, Part
from beamcam.model.plan import HATCH

CHORD = 0.2  #: mm, of curves whose inside is filled
#: mm above a line of a hatch, where it is looked what lies inside: an edge may lie on the line.
ABOVE = 1e-7
MAX_CHORDS = 4096


def hatched(part: Part, torch: Torch) -> Part:
    """The part with the lines of its hatches behind its own features.

    What an odd number of closed contours of a look enclose is filled, by lines a distance apart
    that end half of it off the contours. The first lines lie half a distance inside.
    """
    rings = {
        key: [contour for contour in contours if is_closed(contour)]
        for key, contours in _hatched_looks(part, torch).items()
    }
    lines = [
        replace(of[0], kind="open", curves=(line,), closed=False, notches=(), bevels=(),
                source=replace(of[0].source, where=HATCH))
        for key, of in rings.items() if of for line in _lines(of, torch.settings[key])
    ]  # fmt: skip
    return replace(part, features=(*part.features, *lines)) if lines else part


def not_filled(part: Part, torch: Torch) -> Iterator[tuple[str, str]]:
    """Keys of hatches that fill nothing, and why."""
    for key, contours in _hatched_looks(part, torch).items():
        if torch.colours.get(key) == "cut":
            yield key, "what is cut out"
        elif not any(map(is_closed, contours)):
            yield key, "no closed contour"


def _hatched_looks(part: Part, torch: Torch) -> dict[str, list[Contour]]:
    by_look: dict[str, list[Contour]] = {}
    if not any(own.hatch for own in torch.settings.values()):
        return by_look
    for contour in part.contours:
        key = key_of(contour, torch.colours)
        if key is not None and key in torch.settings and torch.settings[key].hatch:
            by_look.setdefault(key, []).append(contour)
    return by_look


def is_filled_only(contour: Contour, torch: Torch) -> bool:
    """Whether a contour is filled and not followed, on a machine with settings of its colours."""
    key = key_of(contour, torch.colours)
    own = torch.settings.get(key) if key is not None else None
    return own is not None and bool(own.hatch) and not own.hatch_outline and is_closed(contour)


def is_closed(contour: Contour) -> bool:
    """Whether a contour ends where it begins."""
    return contour.curves[0].start == contour.curves[-1].end or contour.closed


def _lines(contours: list[Contour], own: LayerSettings) -> Iterator[Line]:
    distance = own.hatch or 0.0
    c, s = unit_vector(own.hatch_angle)
    edges: list[tuple[Point, Point]] = []
    for curve in (curve for contour in contours for curve in contour.curves):
        chords = min(MAX_CHORDS, max(16, ceil(curve.length / CHORD)))
        chords = 1 if isinstance(curve, Line) else chords
        points = [curve.point(k / chords) for k in range(chords + 1)]
        edges += pairwise([(c * x + s * y, c * y - s * x) for x, y in points])
    heights = [end[1] for edge in edges for end in edge]
    low, count = min(heights), int((max(heights) - min(heights)) / distance + 0.5)
    crossings: list[list[float]] = [[] for _ in range(count)]
    for (ax, ay), (bx, by) in edges:
        first = max(0, ceil((min(ay, by) - ABOVE - low) / distance - 0.5))
        for k in range(first, count):
            y = low + (k + 0.5) * distance
            if not min(ay, by) <= y + ABOVE < max(ay, by):
                break
            share = min(max((y - ay) / (by - ay), 0.0), 1.0)
            crossings[k].append(ax + (bx - ax) * share)
    for k, xs in enumerate(crossings):
        y = low + (k + 0.5) * distance
        xs.sort()
        for x0, x1 in zip(xs[::2], xs[1::2], strict=False):
            a, b = x0 + distance / 2, x1 - distance / 2
            if b - a > distance:
                yield Line((c * a - s * y, s * a + c * y), (c * b - s * y, s * b + c * y))
