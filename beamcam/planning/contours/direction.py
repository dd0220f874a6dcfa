"""Direction and start point of a contour, and stretches of it."""

from collections.abc import Sequence
from math import dist

from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch

Curves = tuple[Curve, ...]


def reversed_chain(curves: Sequence[Curve]) -> Curves:
    """The chain followed backwards."""
    return tuple([c.reversed() for c in reversed(curves)])


def is_turned(area: float, is_hole: bool, torch: Torch) -> bool:
    """Whether a closed contour of that signed area has to be followed backwards.

    Climb keeps the remaining material on the right of the head, as the swirl of a plasma torch
    wants it: outer contours clockwise, holes counter-clockwise.
    """
    if torch.direction == "drawn":
        return False
    wanted = is_hole if torch.direction == "climb" else not is_hole
    return (area > 0.0) != wanted


def begun(curves: Curves, torch: Torch, here: Point, is_pierced: bool = True) -> Curves:
    """A closed contour from where the machine begins it, the head being at `here`.

    What is only marked is not pierced: no line of it is divided.
    """
    if torch.start == "drawn":
        return curves
    if torch.start == "straight" and is_pierced:
        return from_longest(curves, range(len(curves)))
    if len(curves) == 1:
        (curve,) = curves
        if isinstance(curve, Arc) and here != curve.centre:
            toward = (here[0] - curve.centre[0], here[1] - curve.centre[1])
            return (Arc(curve.centre, curve.radius, direction_deg(toward), curve.sweep_deg),)
        return curves
    nearest = min(range(len(curves)), key=lambda k: dist(curves[k].start, here))
    return (*curves[nearest:], *curves[:nearest])


def from_longest(curves: Curves, which: Sequence[int]) -> Curves:
    """A closed contour from the middle of the longest line among some of its curves.

    Of the longest curve where none of them is a line.
    """
    longest = max(which, key=lambda k: (isinstance(curves[k], Line), _size(curves[k])))
    first, last = curves[longest].split(0.5)
    return (last, *curves[longest + 1 :], *curves[:longest], first)


def _size(curve: Curve) -> float:
    """Length of a line, distance of its ends of any other curve, to a millionth.

    So the first of equal ones is taken, whatever the last digits of their ends are.
    """
    return round(dist(curve.start, curve.end), 6)


def stretch(curves: Curves, lengths: Sequence[float], low: float, high: float) -> Curves:
    """The part of a chain between two lengths along it."""
    found: list[Curve] = []
    done = 0.0
    for curve, length in zip(curves, lengths, strict=True):
        a, b = max(low - done, 0.0), min(high - done, length)
        if b - a > 1e-9:
            piece = curve
            if b < length:
                piece = piece.split(_parameter(piece, b))[0]
            if a > 0.0:
                piece = piece.split(_parameter(piece, a))[1]
            found.append(piece)
        done += length
    return tuple(found)


def place_at(curves: Curves, lengths: Sequence[float], length: float) -> Point:
    """The place so far along a chain, which is no longer than that and no shorter than 0."""
    for curve, own in zip(curves, lengths, strict=True):
        if length <= own:
            return curve.point(_parameter(curve, length))
        length -= own
    return curves[-1].end


def _parameter(curve: Curve, length: float) -> float:
    """Parameter at arc length `length`, by bisection for curves of uneven speed."""
    if isinstance(curve, Line | Arc):
        return length / curve.length
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = (low + high) / 2
        if curve.split(middle)[0].length < length:
            low = middle
        else:
            high = middle
    return (low + high) / 2
