"""Round and slotted cutters that pierce walls squarely: holes, one for each wall."""

from math import atan2, cos, degrees, pi, radians, sin, sqrt

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.model.part import Hole, HoleKind, Slot
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.cutters import Box3, Cutter, HalfSpace, Prism
from beamcam.readers.ifc.ends import Trim
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.outline import Round, Slotted
from beamcam.readers.ifc.section import Section, Wall, walls_of
from beamcam.readers.ifc.space import dot, scale, size, unit

SQUARE = 2e-3  #: sine of the angle by which a hole may be off square, a tenth of a degree
THROUGH = 0.05  #: mm that a hole may fall short of the far surface
TOUCH = 0.02  #: mm into a wall that still counts as beside it
BITE = 0.1  #: share of a wall's thickness that a hole in the wall beside it may touch
WIDEST = 0.9  #: of a round section, that a hole across it may be
NEAR = 1e-3  #: mm between a hole and an edge that it does not cut open

Span = tuple[float, float]


class Drilled(Struct, frozen=True, gc=False):
    """Stock of holes: a section between two ends."""

    section: Section
    start: Trim
    end: Trim


def pierce(cutter: Cutter, box: Box3, into: Drilled, source: Source) -> list[Hole | Slot] | None:
    """The holes that a cutter, whose box is `box`, makes; None if it is none, or cuts an edge open.

    Raises Unreadable for a hole that is not square to its wall, or ends inside where no drill
    comes.
    """
    if not isinstance(cutter, Prism) or cutter.shape is None:
        return None
    place = source if cutter.where is None else replace(source, where=cutter.where)
    low, high = box
    start, end = into.start, into.end
    clear = low[0] > NEAR - start.least and high[0] < end.least - NEAR  # of all planes
    if into.section.code in ("RO", "RU"):
        return _radial(cutter, cutter.shape, into.section, place) if clear else None
    walls = walls_of(into.section)
    if not walls:
        return None  # a special section has no face that a hole could be on
    # The first planes are the stock's own, square ends.
    if high[0] <= start.planes[0].point[0] or low[0] >= end.planes[0].point[0]:
        return []
    found: list[Hole | Slot] = []
    for wall in walls:
        q, c = (2, 1) if wall.normal == "y" else (1, 2)
        c0, c1, q0, q1 = low[c], high[c], low[q], high[q]
        if (
            c1 - wall.low < TOUCH  # most walls are not touched at all
            or wall.high - c0 < TOUCH
            or c1 - c0 < TOUCH
            or q1 <= TOUCH
            or q0 >= wall.width - TOUCH
        ):
            continue
        lean = abs(wall.split(cutter.frame.z)[1]) / size(cutter.frame.z)
        if SQUARE <= lean < 1 - SQUARE * SQUARE / 2:
            angle = degrees(atan2(sqrt(1 - lean * lean), lean))
            raise Unreadable(f"a hole at {angle:.2f} degrees to face {wall.face}")
        if lean < SQUARE:
            bite = min(c1, wall.high) - max(c0, wall.low)
            if bite <= BITE * wall.thickness or _within_another(wall, box, into):
                continue
            return None  # it runs along inside the wall
        beyond = False if clear else _beyond((low[0], high[0]), (q0, q1), into, wall)
        if beyond:
            continue
        if beyond is None or q0 < NEAR or q1 > wall.width - NEAR:
            return None
        found.append(_drilled(cutter, cutter.shape, wall, (c0, c1), place))
    return found


def _within_another(wall: Wall, box: Box3, into: Drilled) -> bool:
    """Whether what a hole takes of a wall belongs to another one too, square to it."""
    section = into.section
    for other in walls_of(section):
        c, whole = (1, section.height) if other.normal == "y" else (2, section.width)
        low, high = max(box[0][c], 0.0), min(box[1][c], whole)
        if other.normal != wall.normal and (
            other.low - THROUGH <= low and high <= other.high + THROUGH
        ):
            return True
    return False


def _beyond(xs: Span, qs: Span, into: Drilled, wall: Wall) -> bool | None:
    """Whether a hole lies all beyond an end, where nothing is to drill; None if the end cuts it."""

    def x(end: HalfSpace, q: float) -> float:
        return end.x(wall.surface, q) if wall.normal == "y" else end.x(q, wall.surface)

    for side, edge, planes in (-1, xs[0], into.start.planes), (1, xs[1], into.end.planes):
        for plane in planes:
            slope = plane.slopes[wall.normal == "y"]
            nearest = qs[1] if (slope < 0) == (side > 0) else qs[0]
            if side * edge > side * x(plane, nearest) - NEAR:
                inner = xs[1] if side < 0 else xs[0]
                gone = (all(side * inner > side * x(e, q) - NEAR for q in qs) for e in planes)
                return any(gone) or None
    return False


def _drilled(
    cutter: Prism, shape: Round | Slotted, wall: Wall, reach: Span, source: Source
) -> Hole | Slot:
    face, depth = wall.face, None
    from_low, from_high = reach[0] <= wall.low + THROUGH, reach[1] >= wall.high - THROUGH
    if not (from_low and from_high):
        if not from_low and not from_high:
            raise Unreadable("a hollow inside the material")
        outside = from_high if wall.outer else from_low
        depth = reach[1] - wall.low if from_low else wall.high - reach[0]
        if not outside:
            if wall.face != "v":
                raise Unreadable(f"a blind hole from inside of face {wall.face}")
            face = "h"
    factor = size(cutter.frame.x)
    p = cutter.start(shape)
    q = p[2] if wall.normal == "y" else p[1]
    kind: HoleKind = "blind" if depth else "through"
    if isinstance(shape, Round):
        return Hole(face, p[0], q, shape.diameter * factor, source, depth, kind)
    turn = radians(shape.angle)
    way = cutter.frame.vector((cos(turn), sin(turn), 0.0))
    angle = round(degrees(atan2(wall.split(way)[0], way[0])), 7) % 180.0
    sizes = (shape.diameter * factor, shape.length * factor, 0.0, angle)
    return Slot(face, p[0], q, *sizes, source, depth, kind)


def _radial(
    cutter: Prism, shape: Round | Slotted, section: Section, source: Source
) -> list[Hole | Slot] | None:
    """Holes across a round section, unrolled: y runs round it from u over v, in mm of its skin."""
    if not isinstance(shape, Round):
        return None
    r = section.height / 2
    diameter = shape.diameter * size(cutter.frame.x)
    if diameter > WIDEST * 2 * r:
        return None  # a saddle
    along = unit(cutter.frame.z)
    if abs(along[0]) > SQUARE:
        return None
    start = cutter.start(shape)
    y, z = start[1] - r, start[2] - r
    if abs(y * along[2] - z * along[1]) > 0.05:
        if section.code == "RO":
            return None
        raise Unreadable("a hole beside the axis", rules.SOLID_CUT)
    first = y * along[1] + z * along[2]
    last = first + dot(cutter.frame.z, along)
    wall = section.web_thickness if section.code == "RO" else r
    found: list[Hole | Slot] = []
    for at in (-r, r):
        inside = at - (wall if at > 0 else -wall)
        low, high = min(at, inside), max(at, inside)
        if first <= low + THROUGH and last >= high - THROUGH:
            way = scale(along, 1.0 if at > 0 else -1.0)
            # 0 at the lowest line, a quarter of the round at v, half of it on top.
            angle = atan2(way[2], -way[1]) % (2 * pi)
            found.append(Hole("v", start[0], angle * r, diameter, source))
        elif min(last, high) - max(first, low) > TOUCH:
            rule = rules.ODD_CUT if section.code == "RO" else rules.SOLID_CUT
            raise Unreadable("a blind hole", rule)
    if section.code == "RU" and found:
        if len(found) == 1:
            raise Unreadable("a blind hole", rules.SOLID_CUT)
        found.pop()  # a solid bar is drilled from one side
    return found
