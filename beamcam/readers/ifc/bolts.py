"""Holes from bolts, for models whose solids have none.

A bolt is an axis from its head along its shank. It drills a wall that its axis crosses squarely,
within the wall's outline, if the shank reaches through. The hole is wider than the bolt by the
clearance of the bolt's standard.
"""

from collections.abc import Sequence
from math import acos, degrees

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Hole, Part, Slot
from beamcam.model.request import Options
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.body import body_representation, mapping, pushed
from beamcam.readers.ifc.entities import NOT_WELL_FORMED, Entity, Model, Unreadable
from beamcam.readers.ifc.finish import Shaped, sorted_holes
from beamcam.readers.ifc.section import Wall, walls_of
from beamcam.readers.ifc.space import Frame, Vec, add, dot, scale, size, sub, unit
from beamcam.solid.kernel import prism
from beamcam.solid.kernel import walls as solid_walls
from beamcam.solid.part_solid import part_solid

SQUARE_DEG = 1.0  #: by which a bolt may be off square to its wall and still be drilled square
NEAR_DEG = 30.0  #: a bolt that leans more than this does not clamp the wall
REACH = 0.5  #: mm that a shank may fall short of a surface
NEAR = 1e-3  #: mm of steel round a hole
AIR = 0.5  #: mm3 of a hole that lie in no steel; less is rounding
IN_LINE = 0.05  #: mm within which two bolts make one hole
INCH = 25.4


class Bolt(Struct, frozen=True):
    """A bolt in the world: its axis from under the head, and the diameter of its shank."""

    guid: str
    head: Vec
    along: Vec  #: unit vector
    length: float
    diameter: float


def bolts_of(model: Model) -> tuple[list[Bolt], list[str]]:
    """The bolts of a model, and the GlobalIds of fasteners in which no shank can be read.

    Those are nuts, washers and weld symbols, but also bolts of a form that is not understood.
    """
    found: list[Bolt] = []
    without: list[str] = []
    for element in model.file.by_type("IfcMechanicalFastener"):
        try:
            bolt = _bolt(model, element)
        except (Unreadable, *NOT_WELL_FORMED):
            bolt = None
        if bolt is None:
            without.append(element.guid)
        else:
            found.append(bolt)
    return found, without


def _bolt(model: Model, element: Entity) -> Bolt | None:
    frame = model.placement(element.ObjectPlacement)
    nominal = getattr(element, "NominalDiameter", None)
    items = body_representation(element).Items if element.Representation else ()
    axes = [axis for item in items for axis in _axes(model, item, frame)]
    if not axes:
        return None
    # The shank is the longest piece; the head is wider and shorter.
    o, along, radius = max(axes, key=lambda axis: size(axis[1]))
    length, diameter = size(along), nominal * model.mm if nominal else 2 * radius
    if length <= 0 or diameter <= 0:
        return None
    return Bolt(element.guid, o, unit(along), length, diameter)


def _axes(model: Model, item: Entity, frame: Frame) -> list[tuple[Vec, Vec, float]]:
    """Axes of the round extrusions, or of the lines that stand for a bolt."""
    if item.is_a("IfcMappedItem"):
        inner, source = mapping(model, item, frame)
        return [axis for one in source for axis in _axes(model, one, inner)]
    if item.is_a("IfcBooleanResult"):
        return [*_axes(model, item.FirstOperand, frame), *_axes(model, item.SecondOperand, frame)]
    if item.is_a() == "IfcExtrudedAreaSolid":
        profile = item.SweptArea
        if not profile.is_a("IfcCircleProfileDef"):
            return []
        position = frame.times(model.axes(item.Position))
        along = pushed(model, position, item.ExtrudedDirection, item.Depth)
        at = position.point(model.axes(profile.Position).o)
        return [(at, along, profile.Radius * model.mm)]
    line, radius = item, 0.0
    if item.is_a("IfcSweptDiskSolid"):
        line, radius = item.Directrix, item.Radius * model.mm
    if not line.is_a("IfcPolyline"):
        return []
    points = [frame.point(model.point(p)) for p in line.Points]
    return [(points[0], sub(points[-1], points[0]), radius)]


def hole_for(diameter: float, clearance: float | None) -> float:
    """The diameter of the hole for a bolt, in mm.

    EN 1090-2, table 11, normal round holes: 1 mm up to M14, 2 mm up to M24, 3 mm above. Inch
    bolts by AISC 360, table J3.3: 1/16 in up to 7/8 in, 1/8 in above.
    """
    if clearance is not None:
        return diameter + clearance
    sixteenths = diameter / INCH * 16
    if abs(sixteenths - round(sixteenths)) < 0.01 and abs(diameter - round(diameter)) > 0.01:
        return diameter + (INCH / 16 if diameter < 23 else INCH / 8)
    return diameter + (1.0 if diameter < 15 else 2.0 if diameter < 26 else 3.0)


def drill_bolt_holes(
    model: Model, members: Sequence[tuple[Entity, Part, Shaped]], options: Options, name: str
) -> tuple[list[Part], list[Diagnostic]]:
    """The parts in order, those without holes drilled where bolts go through, and remarks.

    A member with a bolt off square is not among them, unless it is forced.
    """
    bolts, without = bolts_of(model)
    parts: list[Part] = []
    said: list[Diagnostic] = []
    for element, part, shaped in members:
        drilled: Part | None = part
        if bolts and walls_of(shaped.section) and not _holes_of(part):
            drilled, remarks = _drilled(model, bolts, element, part, shaped, options, name)
            said += remarks
        if drilled is not None:
            parts.append(drilled)
    source = Source(name)
    if without:
        some = ", ".join(without[:3]) + (", ..." if len(without) > 3 else "")
        said.append(rules.BOLT_SHANK.at(source, found=len(without), which=some))
    if bolts or without:  # every fastener is in one of three numbers
        used = {hole.source.where for part in parts for hole in _holes_of(part)}
        drilled_by = sum(b.guid in used for b in bolts)
        counts = {"drilled": drilled_by, "idle": len(bolts) - drilled_by, "without": len(without)}
        said.append(rules.BOLTS.at(source, found=len(bolts) + len(without), **counts))
    return parts, said


def _holes_of(part: Part) -> list[Hole | Slot]:
    return [f for f in part.features if isinstance(f, (Hole, Slot))]


def _drilled(
    model: Model,
    bolts: Sequence[Bolt],
    element: Entity,
    part: Part,
    shaped: Shaped,
    options: Options,
    name: str,
) -> tuple[Part | None, list[Diagnostic]]:
    """A part with the holes of the bolts that go through it, and remarks; None if it is refused."""
    try:
        world = model.placement(element.ObjectPlacement).times(shaped.frame)
    except (Unreadable, *NOT_WELL_FORMED) as reason:
        return None, [rules.GEOMETRY.at(part.source, found=reason)]
    holes, skew = _through_member(bolts, world, part, shaped, options, name)
    holes, in_air = _in_steel(holes, part)
    said = []
    for face in dict.fromkeys(h.face for h in in_air):
        some = [f"x {h.x:.1f} y {h.y:.1f}" for h in in_air if h.face == face]
        places = ", ".join(some[:3]) + (", ..." if len(some) > 3 else "")
        said.append(rules.BOLT_AIR.at(part.source, found=len(some), face=face, places=places))
    said += map(rules.forced, skew) if options.force else skew
    if skew and not options.force:
        return None, said
    if holes:
        drilled = sorted_holes(holes)
        through = {h.source.where for h in holes}
        sizes = ", ".join(f"{d:g}" for d in sorted({round(h.diameter, 3) for h in holes}))
        counts = {"found": len(through), "made": len(drilled)}
        said.append(rules.BOLT_HOLES.at(part.source, **counts, sizes=sizes))
        part = replace(part, features=(*part.features, *drilled))
    return part, said


def _through_member(
    bolts: Sequence[Bolt], world: Frame, part: Part, shaped: Shaped, options: Options, name: str
) -> tuple[list[Hole], list[Diagnostic]]:
    """The holes of bolts through a member whose axes lie in `world`, and which bolts lean."""
    holes: list[Hole] = []
    skew: list[Diagnostic] = []
    for bolt in bolts:
        head = _near_head(bolt, world, part, shaped)
        if head is None:
            continue
        along = (dot(bolt.along, world.x), dot(bolt.along, world.y), dot(bolt.along, world.z))
        for wall in walls_of(shaped.section):
            lean = degrees(acos(min(1.0, abs(dot(along, wall.direction)))))
            at = _crossing(head, along, bolt, wall, part) if lean < NEAR_DEG else None
            if at is None:
                continue
            if lean > SQUARE_DEG:
                texts = {"angle": f"{lean:.1f}", "face": wall.face}
                skew.append(rules.BOLT_SKEW.at(part.source, found=bolt.guid, **texts))
                continue
            diameter = round(hole_for(bolt.diameter, options.clearance), 6)
            hole = Hole(wall.face, *at, diameter, Source(name, where=bolt.guid))
            same = (h for h in holes if h.face == hole.face)
            if all(max(abs(hole.x - h.x), abs(hole.y - h.y)) >= IN_LINE for h in same):
                holes.append(hole)
    return holes, skew


def _near_head(bolt: Bolt, world: Frame, part: Part, shaped: Shaped) -> Vec | None:
    """The head of a bolt in the coordinates of a member; None if it does not reach the member."""
    off = sub(bolt.head, world.o)
    sides = part.length, shaped.section.height, shaped.section.width
    head = []
    for axis, side in zip((world.x, world.y, world.z), sides, strict=True):
        head.append(dot(off, axis))
        if not -bolt.length <= head[-1] <= side + bolt.length:
            return None
    return head[0], head[1], head[2]


def _in_steel(holes: Sequence[Hole], part: Part) -> tuple[list[Hole], list[Hole]]:
    """The holes whose circles lie within what the cuts leave of their walls, and the others."""
    if not holes:
        return [], []
    from shapely import Point

    solid, walls = part_solid(part), solid_walls(part.profile)
    steel: list[Hole] = []
    air: list[Hole] = []
    for hole in holes:
        wall = walls[hole.face]
        circle = Point(hole.x, hole.y).buffer(hole.diameter / 2 + NEAR)
        bore = prism(circle, 0.0, wall.thickness, wall.frame)
        (air if (bore - solid).volume() > AIR else steel).append(hole)
    return steel, air


def _crossing(
    head: Vec, along: Vec, bolt: Bolt, wall: Wall, part: Part
) -> tuple[float, float] | None:
    """x and q where a shank goes through a wall; None if it does not go through."""
    _, c0 = wall.split(head)
    _, rate = wall.split(along)
    near, far = sorted(((wall.low - c0) / rate, (wall.high - c0) / rate))
    if near < -REACH or far > bolt.length + REACH:
        return None
    p = add(head, scale(along, (near + far) / 2))
    q = wall.split(p)[0]
    r = bolt.diameter / 2
    return (p[0], q) if r < q < wall.width - r and r < p[0] < part.length - r else None
