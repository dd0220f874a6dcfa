"""Round and slotted cutters that pierce walls squarely: holes, one for each wall."""

from collections.abc import Sequence
from math import atan2, cos, degrees, pi, sin

from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.model.part import Hole, Slot
from beamcam.readers.ifc.cutters import Cutter, Prism
from beamcam.readers.ifc.ends import End
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.finish import slot
from beamcam.readers.ifc.outline import Round, Slotted
from beamcam.readers.ifc.section import Section
from beamcam.readers.ifc.space import dot, scale, size, unit
from beamcam.readers.ifc.walls import Wall

SQUARE = 2e-3  #: sine of the angle by which a hole may be off square, a tenth of a degree
THROUGH = 0.05  #: mm that a hole may fall short of the far surface
TOUCH = 0.02  #: mm into a wall that still counts as beside it

Ends = tuple[Sequence[End], Sequence[End]]


def pierce(
    cutter: Cutter, section: Section, walls: Sequence[Wall], ends: Ends, source: Source
) -> list[Hole | Slot] | None:
    """The holes that a cutter makes; None if it is no hole, or cuts an edge open.

    Raises Unreadable for a hole that is not square to its wall, or ends inside where no drill
    comes.
    """
    if not isinstance(cutter, Prism) or cutter.shape is None:
        return None
    place = replace(source, where=cutter.where or source.where)
    if section.code in ("RO", "RU"):
        return _radial(cutter, cutter.shape, section, place)
    if not walls:
        return None  # a special section has no face that a hole could be on
    found: list[Hole | Slot] = []
    for wall in walls:
        made = _through_wall(cutter, cutter.shape, wall, section, ends, place)
        if made == "open":
            return None
        if not isinstance(made, str) and made is not None:
            found.append(made)
    return found


def _through_wall(
    cutter: Prism,
    shape: Round | Slotted,
    wall: Wall,
    section: Section,
    ends: Ends,
    source: Source,
) -> Hole | Slot | str | None:
    """The hole in one wall; None beside it, "open" where it is not whole."""
    low, high = cutter.box
    q0, c0 = wall.split(low)
    q1, c1 = wall.split(high)
    if c1 - wall.low < TOUCH or wall.high - c0 < TOUCH:  # most walls are not touched at all
        return None
    deep = min(c1, wall.high) - max(c0, wall.low)
    if deep < TOUCH or q1 <= TOUCH or q0 >= wall.width - TOUCH:
        return None
    stock = ends[0][0].c, ends[1][0].c  # the first planes are the stock's own, square ends
    if high[0] <= stock[0] or low[0] >= stock[1]:
        return None
    along = unit(cutter.frame.z)
    lean = abs(dot(along, wall.direction))
    if lean < SQUARE:  # it runs along inside the wall
        return "open"
    if lean < 1 - SQUARE * SQUARE / 2:
        angle = degrees(atan2((1 - lean * lean) ** 0.5, lean))
        raise Unreadable(f"a hole at {angle:.2f} degrees to face {wall.face}")
    for side, edge, planes in ((-1, low[0], ends[0]), (1, high[0], ends[1])):
        for plane in planes:
            slope = plane.b if wall.normal == "y" else plane.a
            q = q1 if (slope < 0) == (side > 0) else q0  # where the plane comes nearest
            if side * edge > side * plane.x(*_yz(wall, q, wall.surface)) - 1e-3:
                return _beyond(side, (low[0], high[0]), (q0, q1), planes, wall)
    if q0 < 1e-3 or q1 > wall.width - 1e-3:
        return "open"
    factor = size(cutter.frame.x)
    return _drilled(cutter, shape, factor, wall, section, (c0, c1), source)


def _beyond(
    side: int, xs: tuple[float, float], qs: tuple[float, float], planes: Sequence[End], wall: Wall
) -> str | None:
    """Whether a hole lies all beyond an end, where there is nothing to drill."""
    inner = xs[1] if side < 0 else xs[0]
    for e in planes:
        if all(side * inner > side * e.x(*_yz(wall, q, wall.surface)) - 1e-3 for q in qs):
            return None
    return "open"


def _yz(wall: Wall, q: float, c: float) -> tuple[float, float]:
    return (c, q) if wall.normal == "y" else (q, c)


def _drilled(
    cutter: Prism,
    shape: Round | Slotted,
    factor: float,
    wall: Wall,
    section: Section,
    reach: tuple[float, float],
    source: Source,
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
    p = cutter.frame.point((*shape.centre, 0.0))
    q = wall.split(p)[0]
    if isinstance(shape, Round):
        return Hole(
            face, p[0], q, shape.diameter * factor, source, depth, "blind" if depth else "through"
        )
    turn = shape.angle * pi / 180

    way = cutter.frame.vector((cos(turn), sin(turn), 0.0))
    angle = degrees(atan2(wall.split(way)[0], way[0])) % 180.0
    placed = Slotted(
        (p[0], q),
        shape.diameter * factor,
        shape.length * factor,
        shape.height * factor,
        0.0 if angle < 1e-7 or angle > 180 - 1e-7 else angle,
    )
    made = slot(wall, placed, source, depth)
    return replace(made, face=face, kind="blind" if depth else "through")


def _radial(
    cutter: Prism, shape: Round | Slotted, section: Section, source: Source
) -> list[Hole | Slot] | None:
    """Holes across a round section, unrolled: y runs round it from u over v, in mm of its skin."""
    if not isinstance(shape, Round):
        return None
    r = section.height / 2
    diameter = shape.diameter * size(cutter.frame.x)
    along = unit(cutter.frame.z)
    if abs(along[0]) > SQUARE:
        return None
    start = cutter.frame.point((*shape.centre, 0.0))
    y, z = start[1] - r, start[2] - r
    if abs(y * along[2] - z * along[1]) > 0.05:
        raise Unreadable("a hole beside the axis of a round section")
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
            raise Unreadable("a blind hole in a round section")
    if section.code == "RU" and len(found) == 2:
        found.pop()  # a solid bar is drilled from one side
    return found
