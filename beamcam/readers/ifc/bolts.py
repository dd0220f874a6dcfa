"""Holes from bolts, for models whose solids have none.

A bolt is an axis from its head along its shank. It drills a wall that its axis crosses squarely,
within the wall's outline, if the shank reaches through. The hole is wider than the bolt by the
clearance of the bolt's standard.
"""

from collections.abc import Iterator, Sequence
from math import acos, degrees
from typing import Any

from msgspec import Struct
from msgspec.structs import replace
from shapely import Point as ShapelyPoint

from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.model.part import Hole, Part
from beamcam.model.request import Options
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.body import body_representation, mapping, pushed
from beamcam.readers.ifc.entities import NOT_WELL_FORMED, Entity, Model, Unreadable
from beamcam.readers.ifc.finish import Shaped, in_order
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
    bolts, without = list[Bolt](), list[str]()
    for element in model.file.by_type("IfcMechanicalFastener"):
        try:
            bolts.append(_bolt(model, element))
        except (Unreadable, *NOT_WELL_FORMED):
            without.append(element.guid)
    return bolts, without


def _bolt(model: Model, element: Entity) -> Bolt:
    """The bolt that a fastener is. Raises Unreadable, or for one that is not well formed."""
    frame = model.placement(element.ObjectPlacement)
    nominal = getattr(element, "NominalDiameter", None)
    items = body_representation(element).Items if element.Representation else ()
    axes = [axis for item in items for axis in _axes(model, item, frame)]
    if not axes:
        raise Unreadable("a fastener without a shank")
    # The shank is the longest piece; the head is wider and shorter.
    o, along, radius = max(axes, key=lambda axis: size(axis[1]))
    length, diameter = size(along), nominal * model.mm if nominal else 2 * radius
    if length <= 0 or diameter <= 0:
        raise Unreadable("a shank of no size")
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
    parts, diagnostics = list[Part](), list[Diagnostic]()
    for element, part, shaped in members:
        remarks: list[Diagnostic] = []
        if bolts and walls_of(shaped.section) and not any((*part.holes, *part.slots)):
            try:
                world = model.placement(element.ObjectPlacement).times(shaped.frame)
            except (Unreadable, *NOT_WELL_FORMED) as reason:
                remarks = [rules.GEOMETRY.at(part.source, found=reason)]
            else:
                part, remarks = _drilled(bolts, world, part, shaped, options, name)
        diagnostics += remarks
        if not errors_in(remarks):
            parts.append(part)
    source = Source(name)
    if without:
        diagnostics.append(rules.BOLT_SHANK.at(source, found=len(without), which=_some(without)))
    if bolts or without:  # every fastener is in one of three numbers
        used = {hole.source.where for part in parts for hole in part.holes}
        drilled = sum(b.guid in used for b in bolts)
        counts = {"drilled": drilled, "idle": len(bolts) - drilled, "without": len(without)}
        diagnostics.append(rules.BOLTS.at(source, found=len(bolts) + len(without), **counts))
    return parts, diagnostics


def _some(texts: Sequence[str]) -> str:
    return ", ".join((*texts[:3], *("...",) * (len(texts) > 3)))


def _drilled(
    bolts: Sequence[Bolt], world: Frame, part: Part, shaped: Shaped, options: Options, name: str
) -> tuple[Part, list[Diagnostic]]:
    """A part with the holes of the bolts that go through it, and remarks.

    `world` is where its member's axes lie.
    """
    holes, diagnostics = list[Hole](), list[Diagnostic]()
    for bolt, wall, (x, q), lean in _crossings(bolts, world, part, shaped):
        if lean > SQUARE_DEG:
            texts = {"angle": f"{lean:.1f}", "face": wall.face}
            diagnostics.append(rules.BOLT_SKEW.at(part.source, found=bolt.guid, **texts))
            continue
        diameter = round(hole_for(bolt.diameter, options.clearance), 6)
        same = (h for h in holes if h.face == wall.face)
        if all(max(abs(x - h.x), abs(q - h.y)) >= IN_LINE for h in same):
            holes.append(Hole(wall.face, x, q, diameter, Source(name, where=bolt.guid)))
    skew = [*map(rules.forced, diagnostics)] if options.force else diagnostics
    solid = part_solid(part) if holes else None
    in_air = [hole for hole in holes if not _is_in(solid, hole, part)]
    drilled = [hole for hole in holes if hole not in in_air]
    diagnostics = []
    for face in dict.fromkeys(h.face for h in in_air):
        places = [f"x {h.x:.1f} y {h.y:.1f}" for h in in_air if h.face == face]
        texts = {"face": face, "places": _some(places)}
        diagnostics.append(rules.BOLT_AIR.at(part.source, found=len(places), **texts))
    diagnostics += skew
    if drilled and (options.force or not skew):
        through = {h.source.where for h in drilled}
        sizes = ", ".join(f"{d:g}" for d in sorted({round(h.diameter, 3) for h in drilled}))
        counts = {"found": len(through), "made": len(once := in_order(drilled))}
        diagnostics.append(rules.BOLT_HOLES.at(part.source, **counts, sizes=sizes))
        part = replace(part, features=(*part.features, *once))
    return part, diagnostics


def _crossings(
    bolts: Sequence[Bolt], world: Frame, part: Part, shaped: Shaped
) -> Iterator[tuple[Bolt, Wall, tuple[float, float], float]]:
    """The bolts that go through a wall, where they do (x and q), and how far they lean, degrees."""
    sides = part.length, shaped.section.height, shaped.section.width
    into = world.inverse()
    for bolt in bolts:
        head, r = into.vector(sub(bolt.head, world.o)), bolt.diameter / 2
        if any(not -bolt.length <= h <= s + bolt.length for h, s in zip(head, sides, strict=True)):
            continue
        along = into.vector(bolt.along)
        for wall in walls_of(shaped.section):
            lean = degrees(acos(min(1.0, abs(dot(along, wall.direction)))))
            if lean >= NEAR_DEG:
                continue
            (_, c), (_, rate) = wall.split(head), wall.split(along)
            near, far = sorted(((wall.low - c) / rate, (wall.high - c) / rate))
            x, y, z = add(head, scale(along, (near + far) / 2))
            q = wall.split((x, y, z))[0]
            through = near >= -REACH and far <= bolt.length + REACH
            if through and r < q < wall.width - r and r < x < part.length - r:
                yield bolt, wall, (x, q), lean


def _is_in(solid: Any, hole: Hole, part: Part) -> bool:
    """Whether a hole's circle lies within what the cuts leave of its wall."""
    wall = solid_walls(part.profile)[hole.face]
    circle = ShapelyPoint(hole.x, hole.y).buffer(hole.diameter / 2 + NEAR)
    bore = prism(circle, 0.0, wall.thickness, wall.frame)
    return bool((bore - solid).volume() <= AIR)
