"""Contours as polygons and polylines, for questions that need no exact curve."""

from collections.abc import Sequence
from math import acos, degrees, dist
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from beamcam.errors import Source
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line, parameter_at
from beamcam.geometry.plane import Point, dot
from beamcam.machine.torch import CORNER_DEG, Torch, TorchProcess

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from beamcam.geometry.array_types import Floats

Curves = tuple[Curve, ...]


def reversed_chain(curves: Sequence[Curve]) -> Curves:
    """The chain followed backwards."""
    return tuple([c.reversed() for c in reversed(curves)])


def waste_side(area: float, is_hole: bool) -> int:
    """1 if what falls out lies left of a closed contour of that signed area, -1 if right."""
    return 1 if (area > 0.0) == is_hole else -1


def is_turned(area: float, is_hole: bool, torch: Torch) -> bool:
    """Whether a closed contour of that signed area has to be followed backwards.

    Climb keeps the remaining material on the right of the head, as the swirl of a plasma torch
    wants it: outer contours clockwise, holes counter-clockwise.
    """
    if torch.direction == "drawn":
        return False
    is_counterclockwise = is_hole if torch.direction == "climb" else not is_hole
    return (area > 0.0) != is_counterclockwise


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
    lines = [k for k in which if isinstance(curves[k], Line)]
    longest = max(lines or which, key=lambda k: _size(curves[k]))
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
                piece = piece.split(parameter_at(piece, b))[0]
            if a > 0.0:
                piece = piece.split(parameter_at(piece, a))[1]
            found.append(piece)
        done += length
    return tuple(found)


def place_at(curves: Curves, lengths: Sequence[float], length: float) -> Point:
    """The place so far along a chain, which is no longer than that and no shorter than 0."""
    for curve, own in zip(curves, lengths, strict=True):
        if length <= own:
            return curve.point(parameter_at(curve, length))
        length -= own
    return curves[-1].end


#: Points of chains, and the chain of each.
Drawn = tuple["Floats", "NDArray[np.int64]"]


def outlines(chains: Sequence[Sequence[Curve]], tolerance: float) -> "NDArray[Any]":
    """The polygon of each closed chain, an array of shapely polygons."""
    return rings_of(*points_of(chains, tolerance), len(chains))


def rings_of(points: "Floats", owner: "NDArray[np.int64]", count: int) -> "NDArray[Any]":
    """Polygons by their points, of which each has the number of its polygon, below `count`."""
    import numpy as np
    import shapely

    # A ring needs four points: chains of two curves that flatten to chords get their ends again.
    counts = np.bincount(owner, minlength=count)
    short = np.flatnonzero(counts < 4)
    if len(short):
        more = np.repeat(short, 4 - counts[short])
        last = np.cumsum(counts) - 1
        owner = np.concatenate((owner, more))
        points = np.concatenate((points, points[last[more]]))
        order = np.argsort(owner, kind="stable")
        points, owner = points[order], owner[order]
    rings: NDArray[Any] = shapely.polygons(shapely.linearrings(points, indices=owner))
    return rings


def ways(chains: Sequence[Sequence[Curve]], tolerance: float) -> "NDArray[Any]":
    """The polyline of each chain, an array of shapely lines."""
    import shapely

    points, owner = points_of(chains, tolerance)
    found: NDArray[Any] = shapely.linestrings(points, indices=owner)
    return found


def signed_areas(rings: "NDArray[Any]") -> "Floats":
    """The areas of polygons, above 0 for those that run counter-clockwise.

    By the corners about the first one of each: asked which way a ring runs, GEOS looks at its
    highest corner only, and is wrong where that is double but for the last digit.
    """
    import numpy as np
    import shapely

    points, owner = shapely.get_coordinates(rings, return_index=True)
    counts = np.bincount(owner, minlength=len(rings))
    points -= points[np.repeat(np.cumsum(counts) - counts, counts)]
    (x0, y0), (x1, y1) = points[:-1].T, points[1:].T
    # From the last corner of a ring to the first of the next one, which is its own 0, 0.
    return np.bincount(owner[:-1], (x0 * y1 - x1 * y0) / 2, len(rings)).astype(np.float64)


def invalid(rings: "NDArray[Any]") -> list[int]:
    """The numbers of the rings that meet themselves, ascending."""
    import numpy as np
    import shapely

    return np.flatnonzero(~shapely.is_valid(rings)).tolist()


def valid(rings: "NDArray[Any]", bad: Sequence[int]) -> "NDArray[Any]":
    """The rings, those that are `bad` taken apart."""
    import shapely

    if not bad:
        return rings
    found = rings.copy()
    found[bad] = shapely.make_valid(rings[bad])
    return found


def points_of(chains: Sequence[Sequence[Curve]], tolerance: float) -> Drawn:
    """Points of all chains, and the chain of each."""
    import numpy as np

    from beamcam.geometry.polylines import polylines

    drawn = polylines([curve for chain in chains for curve in chain], tolerance)
    chain_of = np.repeat(np.arange(len(chains)), [len(chain) for chain in chains])
    return drawn.points, np.repeat(chain_of, np.diff(drawn.begins))


# --- shape ----------------------------------------------------------------------------------------

# A contour that one process follows.


class Shape(Struct, frozen=True, gc=False):
    """A contour that one process follows, and where it lies among the cut ones.

    The part is the set of points that an odd number of closed cut contours enclose, contours
    that are drawn twice counted once. So a contour of even depth is an outline, whose waste lies
    outside of it, and one of odd depth a hole, whose waste lies inside.
    """

    process: TorchProcess
    curves: tuple[Curve, ...]
    closed: bool
    features: tuple[int, ...]  #: ascending; `assign_process.OUTLINE` may be among them
    source: Source
    depth: int = 0  #: nesting depth: number of cut contours around it
    parent: int = -1  #: the innermost of them, by its index; -1 for none
    look: str = ""  #: key of the settings that it is worked with
    level: int = 0  #: of common cuts: after those of lower levels, on which it begins and ends
    is_begun: bool = False  #: whether it has to begin where it does
    is_small: bool = False  #: a small hole, by the row that it is cut with
    area: float = 0.0  #: inside of a closed cut, mm2, above 0 if it runs counter-clockwise
    joints: tuple[Point, ...] = ()  #: where what is left of other contours begins and ends on it

    @property
    def is_ring(self) -> bool:
        """Whether it has an inside, as an offset needs one."""
        return self.closed and self.area != 0.0

    @property
    def is_hole(self) -> bool:
        return self.depth % 2 == 1


def entity(source: Source) -> str:
    """Name of another entity of the same file in messages: its handle, line or element."""
    if source.where is not None:
        return source.where
    return f"line {source.line}" if source.line is not None else source.file


# --- tabs -----------------------------------------------------------------------------------------

# Bridges that hold a part in its sheet: stretches of a closed contour that are not cut.
#
# What holds is the steel between both ends of the cut, so their distance counts: over a corner, and
# round a bend, more of the contour is left than the bridge is wide.
#
# start                                        e: the even place of a bridge
#   |----x---------------x---------------x---- x: its middle, moved off a corner by a quarter of
#        e             corner e                   the distance of two bridges at most
#
# Nor is one where the cut along what is left of another contour begins or ends: it would be cut.


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


def stretches_of(shape: Shape, kerf: float, torch: Torch) -> tuple[Curves, ...]:
    """The stretches of a contour between its bridges, one if it has none."""
    if not needs_tabs(shape, torch):
        return (shape.curves,)
    clear = torch.min_tab_to_corner and torch.min_tab_to_corner + MITRE * kerf
    return bridged(shape.curves, torch.tabs, torch.tab_width + kerf, clear, kerf, shape.joints)


def bridged(
    curves: Curves, tabs: int, width: float, clear: float = 0.0, kerf: float = 0.0,
    joints: Sequence[Point] = (),
) -> tuple[Curves, ...]:  # fmt: skip
    """The stretches of a closed contour between `tabs` bridges, whose ends are `width` mm apart.

    The bridges lie at equal distances, the first half of that from the start; one that is nearer
    to a corner than `clear`, would take more of the contour than `MOST_ALONG` allows, or may take
    one of the `joints`, is moved to the nearest place that does not, if there is one within a
    quarter of these distances. It takes a joint where all places that are clear of corners do, or
    where none is and the even one does.
    A contour that has not four times as much length as its bridges gets fewer of them, or none.
    """
    lengths = [c.length for c in curves]
    total = sum(lengths)
    while tabs and total < 4 * tabs * width:
        tabs -= 1
    if not tabs:
        return (curves,)
    corners = [(place, width / 2 + clear) for place in _corners(curves, lengths, kerf) if clear]
    along = _along(curves, joints)
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
    import shapely

    whole, *cut = ways([shape.curves, *stretches_of(shape, kerf, torch)], JOINT)
    places = shapely.points(shape.joints)
    off = shapely.distance(shapely.union_all(cut), places) - shapely.distance(whole, places)
    worst = int(off.argmax())
    return shape.joints[worst] if off[worst] > torch.tolerance else None


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
        half = _half(curves, lengths, place, width)
        if half is not None:
            return place - half, place + half
    return middle - width / 2, middle + width / 2


def _half(curves: Curves, lengths: Sequence[float], middle: float, width: float) -> float | None:
    """How far along a contour the ends of a bridge lie from its middle; None if too far."""
    half = width / 2
    while 2 * half <= MOST_ALONG * width:
        a, b = (place_at(curves, lengths, middle + side * half) for side in (-1.0, 1.0))
        missing = width - dist(a, b)
        if missing <= NEARLY:
            return half
        half += missing / 2  # both ends move apart by that at most
    return None


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


def _along(curves: Curves, joints: Sequence[Point]) -> list[float]:
    """How far along a closed contour some places on it lie."""
    if not joints:
        return []
    import shapely

    (line,) = ways([curves], JOINT)
    share = sum(curve.length for curve in curves) / line.length
    return [share * at for at in shapely.line_locate_point(line, shapely.points(joints)).tolist()]


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
