"""Where a path is near a corner, so that the tool moves slower there.

    distance   corner   distance
-----|---------->*
                 |         A corner is a place where the path turns by more than the row's
                 |         `corner_angle`; what of the path is no farther from it than
                 v         `corner_distance`, before and behind it, is near it.
                 -
                 |
"""

from collections.abc import Sequence
from itertools import accumulate
from math import acos, degrees

from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import dot
from beamcam.machine.torch import TorchRow

SHORT = 0.05  #: mm of a curve that is part of a corner
#: mm: no move is made shorter than this by where it begins to be near a corner.
SHORTEST = 0.02
HALVINGS = 40  #: of a curve whose length is no multiple of its parameter


def near_corners(curves: Sequence[Curve], row: TorchRow) -> tuple[list[Curve], list[bool]]:
    """A chain divided where it begins and ends to be near a corner, and which of it is near one."""
    chain = [curve for curve in curves if curve.length > 0.0]
    if not row.slows_corners or not chain:
        return list(curves), [False] * len(curves)
    lengths = [curve.length for curve in chain]
    begins = [0.0, *accumulate(lengths)]
    corners = _corners(chain, lengths, begins, row.corner_angle)
    reach = row.corner_distance
    cuts = sorted(place + side * reach for place in corners for side in (-1.0, 1.0))
    found: list[Curve] = []
    near: list[bool] = []
    for curve, begin, length in zip(chain, begins, lengths, strict=False):
        last = 0.0
        for cut in (*(c - begin for c in cuts if c < begin + length), length):
            if cut < length and not last + SHORTEST < cut < length - SHORTEST:
                continue
            if cut > length:
                break
            middle = begin + (last + cut) / 2
            near.append(any(abs(middle - place) < reach for place in corners))
            found.append(curve if last == 0.0 and cut == length else _part(curve, last, cut))
            last = cut
            if cut == length:
                break
    return found, near


def _corners(
    chain: Sequence[Curve], lengths: Sequence[float], begins: Sequence[float], angle: float
) -> list[float]:
    """Where a chain turns by more than an angle, at once or over curves shorter than `SHORT`."""
    found: list[float] = []
    before = None
    for k, curve in enumerate(chain):
        if before is not None and _turn_deg(chain[before], curve) > angle:
            found.append(begins[before + 1])
        if before is None or lengths[k] >= SHORT:
            before = k
    return found


def _turn_deg(one: Curve, other: Curve) -> float:
    turn = dot(one.tangent(1.0), other.tangent(0.0))
    return degrees(acos(max(-1.0, min(1.0, turn))))


def _part(curve: Curve, first: float, last: float) -> Curve:
    """The part of a curve between two lengths along it."""
    if last < curve.length:
        curve = curve.split(_share(curve, last))[0]
    return curve.split(_share(curve, first))[1] if first > 0.0 else curve


def _share(curve: Curve, length: float) -> float:
    """The parameter of a place so far along a curve."""
    if isinstance(curve, Line | Arc):
        return length / curve.length
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if curve.split(middle)[0].length < length:
            low = middle
        else:
            high = middle
    return (low + high) / 2
