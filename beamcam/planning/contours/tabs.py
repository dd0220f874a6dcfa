"""Bridges that hold a part in its sheet: pieces of a closed contour that are not cut.

What holds is the steel between both ends of the cut, so their distance counts: over a corner, and
round a bend, more of the contour is left than the bridge is wide.

start                                        e: the even place of a bridge
  |----x---------------x---------------x---- x: its middle, moved off a corner by a quarter of
       e             corner e                   the distance of two bridges at most

Nor is one where the cut along what is left of another contour begins or ends: it would be cut.
"""

from collections.abc import Sequence
from math import acos, degrees, dist

import shapely

from beamcam.geometry.curves import Arc, parameter_at
from beamcam.geometry.plane import Point, dot
from beamcam.machine.torch import CORNER_DEG, Torch
from beamcam.planning.contours.outline import Curves, Shape, stretch, ways

ROUNDING = 1e-9
#: Of the contour a bridge takes at most so much, by its width; a tooth is not left whole.
MOST_ALONG = 1.75
NEARLY = 1e-6  #: mm, that a bridge may be narrower
STEP = 0.125  #: by a bridge's width, from one place to the next that is tried for it
#: The corner of a mitre lies so far beyond that of the contour at most, by the kerf.
MITRE = 1.25
JOINT = 0.01  #: mm that chords may be off where places are looked for along a contour


def needs_tabs(shape: Shape, torch: Torch) -> bool:
    """Whether a contour is asked to have bridges."""
    is_meant = torch.inner_tabs or not shape.is_hole
    return bool(torch.tabs) and shape.process == "cut" and shape.is_ring and is_meant


def pieces_of(shape: Shape, kerf: float, torch: Torch) -> tuple[Curves, ...]:
    """The pieces of a contour between its bridges, one if it has none.

    The bridges lie at equal distances, the first half of that from the start; one that is too near
    to a corner, would take more of the contour than `MOST_ALONG` allows, or may take one of its
    joints, is moved to the nearest place that does not, if there is one within a quarter of these
    distances. It takes a joint where all places that are clear of corners do, or where none is and
    the even one does.
    A contour that has not four times as much length as its bridges gets fewer of them, or none.
    """
    curves, joints, width = shape.curves, shape.joints, torch.tab_width + kerf
    tabs = torch.tabs if needs_tabs(shape, torch) else 0
    if not tabs:
        return (curves,)
    clear = torch.min_tab_to_corner and torch.min_tab_to_corner + MITRE * kerf
    lengths = [c.length for c in curves]
    total = sum(lengths)
    while tabs and total < 4 * tabs * width:
        tabs -= 1
    if not tabs:
        return (curves,)
    corners = [(place, width / 2 + clear) for place in _corners(curves, lengths, kerf) if clear]
    along: list[float] = []
    if joints:
        (line,) = ways([curves], JOINT)
        at_line = shapely.line_locate_point(line, shapely.points(joints))
        along = (total / line.length * at_line).tolist()
    # Round a bend a bridge takes more of the contour than on a straight side.
    near, far = (
        [(at, off) for at in along] for off in (width / 2, MOST_ALONG * width / 2 + kerf / 2)
    )
    cuts: list[tuple[float, float]] = []
    begin = 0.0
    for k in range(tabs):
        even, most = total * (k + 0.5) / tabs, total / (4 * tabs)
        middle = even
        for off in ([], near, far):
            place = _clear_place(even, [*corners, *off], most)
            middle = middle if place is None else place
        low, high = _bridge(curves, lengths, middle, width, even - most, even + most)
        cuts.append((begin, low))
        begin = high
    cuts.append((begin, total))
    return tuple(stretch(curves, lengths, a, b) for a, b in cuts)


def joint_in_bridge(shape: Shape, kerf: float, torch: Torch) -> Point | None:
    """A place in a bridge of a contour where what is left of another begins or ends."""
    if not (shape.joints and needs_tabs(shape, torch)):
        return None
    whole, *cut = ways([shape.curves, *pieces_of(shape, kerf, torch)], JOINT)
    places = shapely.points(shape.joints)
    off = shapely.distance(shapely.union_all(cut), places) - shapely.distance(whole, places)
    worst = int(off.argmax())
    return shape.joints[worst] if off[worst] > torch.tolerance else None


def place_at(curves: Curves, lengths: Sequence[float], length: float) -> Point:
    """The place so far along a chain, which is no longer than that and no shorter than 0."""
    for curve, own in zip(curves, lengths, strict=True):
        if length <= own:
            return curve.point(parameter_at(curve, length))
        length -= own
    return curves[-1].end


def _bridge(
    curves: Curves, lengths: Sequence[float], middle: float, width: float, least: float, most: float
) -> tuple[float, float]:
    """Where the bridge nearest to `middle` begins and ends along a contour, between two limits.

    As long as it is wide at `middle` where there is no place for it.
    """
    step = STEP * width
    places = [middle]
    for k in range(1, int((most - least) / step) + 1):
        places += [p for p in (middle - k * step, middle + k * step) if least <= p <= most]
    for place in places:
        half = width / 2
        while 2 * half <= MOST_ALONG * width:
            low, high = place - half, place + half
            missing = width - dist(place_at(curves, lengths, low), place_at(curves, lengths, high))
            if missing <= NEARLY:
                return low, high
            half += missing / 2  # both ends move apart by that at most
    return middle - width / 2, middle + width / 2


def _corners(curves: Curves, lengths: Sequence[float], kerf: float) -> list[float]:
    """Where a closed contour turns at once, along it; what lies at its start counts at its end too.

    In a contour that is moved, what was a corner may be an arc of half the kerf, whose ends count.
    """
    corners: list[float] = []
    place = 0.0
    for k, curve in enumerate(curves):
        turn = max(-1.0, min(1.0, dot(curves[k - 1].tangent(1.0), curve.tangent(0.0))))
        if degrees(acos(turn)) > CORNER_DEG:
            corners += [place] if k else [0.0, sum(lengths)]
        if isinstance(curve, Arc) and curve.radius < kerf and abs(curve.sweep_deg) > CORNER_DEG:
            corners += [place, place + lengths[k]]
        place += lengths[k]
    return sorted(corners)


def _clear_place(even: float, taken: Sequence[tuple[float, float]], most: float) -> float | None:
    """The place nearest to `even`, at most so far from it, that is clear of all that is taken.

    Those are places and how far they reach. None without one.
    """
    near = [(place, reach) for place, reach in taken if abs(place - even) <= most + reach]
    places = [even, *(place + side * reach for place, reach in near for side in (-1.0, 1.0))]
    for place in sorted(places, key=lambda p: abs(p - even)):
        if abs(place - even) > most:
            break
        if all(abs(place - other) >= reach - ROUNDING for other, reach in near):
            return place
    return None
