"""What a machine's file rules out, whatever was planned: sections, mitres, and holes without steel.

section      one that the machine takes, no larger than its stations
cut          a turned blade reaches less far across
hole         in the finished part, clear of its other walls and of other holes
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from math import dist, hypot, inf
from operator import attrgetter

from msgspec import Struct

from beamcam.checks import rules
from beamcam.checks.bars.pieces import Ends, LaidPart, RequiredEnd
from beamcam.checks.bars.stations import Cut, MachinedFeatures, lip_length, wall_between
from beamcam.checks.bars.targets import (
    PLAIN_KINDS,
    THREADS,
    RequiredPocket,
    RequiredRound,
    Target,
    slot_corners,
)
from beamcam.checks.bars.tools import EPSILON
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Layout, Machine
from beamcam.machine.stations import Saw
from beamcam.model.part import Face, Hole, Part, Profile
from beamcam.model.section import Wall, walls_beside

TANGENT = 0.011  #: mm; holes are given to 0.01, so that those which touch may be off by it
THROUGH = ("through", *THREADS)  #: kinds of hole that go through the wall where no depth is given


class CornerCircles(Struct, frozen=True, gc=False):
    """The circles that a hole or slot of a part has at its corners."""

    feature: int
    face: Face
    what: str
    centres: tuple[tuple[float, float], ...]
    radius: float
    low: float  #: the least y of the circles
    high: float  #: and their greatest
    through: bool
    source: Source
    hole: Hole | None  #: None of a slot


def shape_of(target: Target) -> CornerCircles | None:
    """The circles of what was made; None of a line, and of a slot's end, which is in the slot."""
    if isinstance(target, RequiredRound):
        if target.optional:
            return None
        hole, what, y = target.kind.hole, target.kind.what, target.y
        radius = hole.diameter / 2
        through = hole.depth is None and hole.kind in THROUGH
        return CornerCircles(
            target.feature, target.face, what, ((target.x, y),), radius, y - radius, y + radius,
            through, hole.source, hole,
        )  # fmt: skip
    if not isinstance(target, RequiredPocket):
        return None
    source, centres = target.source, tuple(slot_corners(target.slot))
    ys, radius = [y for _, y in centres], source.diameter / 2
    return CornerCircles(
        target.feature, target.face, target.what, centres, radius, min(ys) - radius,
        max(ys) + radius, source.depth is None, source.source,
        source if isinstance(source, Hole) else None,
    )  # fmt: skip


def section_faults(profile: Profile, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """A section that the machine does not take, or that is larger than a station of it."""
    layout = machine.layout
    taken = layout.profiles if layout is not None else ()
    if taken and not (profile.code in taken and profile.code in machine.sections):
        expected = f"one of {', '.join(taken)}"
        yield rules.STOCK.at(Source(name), found=profile.code, expected=expected)
    yield from size_faults(profile, machine, name)


def size_faults(profile: Profile, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """A section that is larger than a station of the machine."""
    for what, station in (("saw", machine.saw), ("drill", machine.drill)):
        if station is None:
            continue
        most = station.max_height, station.max_width
        if profile.height > most[0] or profile.width > most[1]:
            found = f"{profile.height:g} x {profile.width:g} mm"
            expected = f"at most {most[0]:g} x {most[1]:g} mm (height x width) at the {what}"
            yield rules.STOCK.at(Source(name), found=found, expected=expected)


def reach_faults(
    cuts: Iterable[Cut], profile: Profile, machine: Machine, name: str
) -> Iterator[Diagnostic]:
    """Cuts whose blade does not reach across the section at their angle."""
    saw = machine.saw
    if saw is None or not saw.max_sections:
        return
    for cut in cuts:
        off = abs(cut.angle - saw.zero_angle)
        rows = [row for row in saw.max_sections if off <= row.max_angle + 1e-6]
        near = min(rows, key=attrgetter("max_angle"), default=None)
        widest = near or max(saw.max_sections, key=attrgetter("max_angle"))
        if profile.height > widest.max_height or profile.width > widest.max_width:
            yield rules.SAW_REACH.at(
                Source(name, cut.line), angle=f"{cut.angle:g}",
                found=f"{profile.height:g} x {profile.width:g}",
                expected=f"{widest.max_height:g} x {widest.max_width:g}",
            )  # fmt: skip


class FaceBounds(Struct, frozen=True, gc=False):
    """What bounds the holes of one face of a part."""

    width: float
    walls: tuple[Wall, ...]  #: that stand on the wall behind the face
    sunk: bool  #: whether the face lies behind the outermost steel
    #: Each surface of the wall at each end: the end, x at y 0, the lean along y, and its slant.
    ends: tuple[tuple[RequiredEnd, float, float, float], ...]


def _bounds_of(face: Face, profile: Profile, ends: Ends) -> FaceBounds:
    limits = []
    for end in ends:
        lean, through = end.tan_web, end.tan_flange
        if face in ("o", "u"):
            lean, through = through, lean
        slant = hypot(1.0, lean)
        surfaces = wall_between(profile, face) if through else (0.0,)  # both are one
        limits += [(end, end.x_0 - across * through, lean, slant) for across in surfaces]
    return FaceBounds(
        profile.face_width(face), walls_beside(profile, face), profile.face_depth(face) != 0.0,
        tuple(limits),
    )  # fmt: skip


def steel_faults(
    shapes: Collection[CornerCircles], part: Part, ends: Ends, machine: Machine
) -> Iterator[Diagnostic]:
    """Holes and slots of a part, made as it has them, that have no steel all round."""
    step = machine.format.resolution + TANGENT
    profile, lip = part.profile, lip_length(part)
    faces = {face: _bounds_of(face, profile, ends) for face in {shape.face for shape in shapes}}
    for shape in shapes:
        low, high, bounds = shape.low, shape.high, faces[shape.face]
        found = _beyond_end(shape, bounds, step) or _beyond_edge(shape, bounds.width, step)
        # A wall that the tool would run into: behind the face, or before it beside a sunk one.
        if not found and (shape.through or bounds.sunk):
            for wall in bounds.walls:
                if high > wall.least + step and low < wall.greatest - step:
                    found = f"in the wall from y {wall.least:g} to {wall.greatest:g}"
                    break
        if found:
            yield _no_steel(shape, part.mark, found, "steel all round it")
        elif lip and shape.face == "v" and (low < lip - step or high > profile.height - lip + step):
            yield _no_steel(shape, part.mark, f"behind a lip of {lip:.3g} mm", "room for the tool")
    for one, other in _overlapping(shapes, machine, step):
        yield _no_steel(other, part.mark, *_apart(one, other))


def bore_faults(
    made: MachinedFeatures, section: Profile, machine: Machine, name: str
) -> Iterator[Diagnostic]:
    """Holes of a program that have no steel all round, on a section as far as that says it.

    How thick the walls are a program does not say; a hole over the middle of one is in it. Holes
    that a mill joins are a slot.
    """
    step = machine.format.resolution + TANGENT
    shapes = [
        CornerCircles(
            k, bore.face, f"hole of {bore.diameter:g}", ((bore.x, bore.y),), bore.diameter / 2,
            bore.y - bore.diameter / 2, bore.y + bore.diameter / 2, False, source,
            Hole(bore.face, bore.x, bore.y, bore.diameter, source),
        )
        for k, bore in enumerate(made.bores) if bore.kind == "drill"
        for source in [Source(name, bore.line)]
    ]  # fmt: skip
    for shape in shapes:
        width = section.face_width(shape.face)
        found = width and _beyond_edge(shape, width, step)
        for wall in walls_beside(section, shape.face):
            middle = (wall.least + wall.greatest) / 2
            if abs(shape.centres[0][1] - middle) < shape.radius - step and not found:
                found = f"over the wall at y {middle:g}"
        if found:
            yield _no_steel(shape, "the bar", found, "steel all round it")
    for one, other in _overlapping(shapes, machine, step):
        # What a path that comes by both their middles joins is a slot.
        if not any(
            all(
                hole.face == path.face
                and min(dist(point, hole.centres[0]) for point in path.points) <= hole.radius + step
                for hole in (one, other)
            )
            for path in made.paths
        ):
            yield _no_steel(other, "the bar", *_apart(one, other))


def _overlapping(
    shapes: Collection[CornerCircles], machine: Machine, step: float
) -> Iterator[tuple[CornerCircles, CornerCircles]]:
    """Holes that meet, of two that are not one work about one middle."""
    near = machine.drill.merge_tolerance if machine.drill else 0.0
    for one, other in _side_by_side(shapes):
        if one.hole is None or other.hole is None:
            continue
        apart = dist(one.centres[0], other.centres[0])
        if apart < one.radius + other.radius - step and not (
            apart <= near + 1e-9 and _is_one_work(one.hole, other.hole)
        ):
            yield one, other


def _apart(one: CornerCircles, other: CornerCircles) -> tuple[str, str]:
    """How far two holes are apart, and how far they have to be."""
    apart = dist(one.centres[0], other.centres[0])
    expected = f"at least {one.radius + other.radius:g} mm between their middles"
    return f"{apart:.3g} mm from the {one.what}", expected


def _no_steel(shape: CornerCircles, mark: str, found: str, expected: str) -> Diagnostic:
    x, y = shape.centres[0]
    return rules.HOLE_STEEL.at(
        shape.source, what=shape.what, face=shape.face, mark=mark, x=f"{x:g}", y=f"{y:g}",
        found=found, expected=expected,
    )  # fmt: skip


def _side_by_side(
    shapes: Collection[CornerCircles],
) -> list[tuple[CornerCircles, CornerCircles]]:
    """Two holes of a face that may touch, in their order: those as near along the part."""
    holes = [
        (shape.face, shape.centres[0][0], k, shape)
        for k, shape in enumerate(shapes) if shape.hole is not None
    ]  # fmt: skip
    holes.sort()
    widest = max([shape.radius for shape in shapes], default=0.0)
    pairs = []
    for place, (face, x, k, one) in enumerate(holes, 1):
        farthest = x + one.radius + widest
        for at in range(place, len(holes)):
            other_face, other_x, i, other = holes[at]
            if other_face != face or other_x > farthest:
                break
            pairs.append((k, i, one, other) if k < i else (i, k, other, one))
    pairs.sort()
    return [(one, other) for _, _, one, other in pairs]


def _beyond_end(shape: CornerCircles, bounds: FaceBounds, step: float) -> str:
    """By how much the circles reach beyond an end of the part, on either side of their wall."""
    for end, x_0, lean, slant in bounds.ends:
        for x, y in shape.centres:
            beyond = end.side * (x - x_0 + y * lean) / slant + shape.radius
            if beyond > step:
                return f"{beyond:.3g} mm beyond the {end.name} of the part"
    return ""


def _beyond_edge(shape: CornerCircles, width: float, step: float) -> str:
    """By how much the circles reach beyond an edge of a face of a width."""
    out = max(-shape.low, shape.high - width)
    return f"{out:.3g} mm beyond the edge of the face" if out > step else ""


def _is_one_work(one: Hole, other: Hole) -> bool:
    """Whether two holes about one middle are a sink, a thread or a stepped hole."""
    small, large = sorted((one, other), key=lambda hole: hole.diameter)
    if "countersink" in (one.kind, other.kind) or "mark" in (one.kind, other.kind):
        return True
    if large.kind in THREADS:
        return small.kind in PLAIN_KINDS
    deeper = large.depth is not None and (small.depth is None or small.depth > large.depth)
    return deeper and small.diameter < large.diameter


# --- bar limits -----------------------------------------------------------------------------------

# What the machine can hold of a bar: its size, both its ends, and the parts that come off it.
#
# | front trim |# part 1 ####|kerf|# part 2 ####|kerf|   remnant   | end trim | dead zone |
# bar x 0                                            last cut ends                     length


def bar_faults(
    laid: Sequence[LaidPart], machine: Machine, saw: Saw, bar: float | None, name: str
) -> Iterator[Diagnostic]:
    """What of the parts on a bar the machine cannot hold, and the bar needed where it is unknown.

    `bar` is the length of the bar. On a line without a saw the part is the bar.
    """
    layout, source = machine.layout, Source(name)
    if layout is None or not laid:
        return
    if machine.saw is None:
        yield from _size_faults(laid[0].part.length, layout.min_bar, layout, EPSILON, name)
        return
    # Places of parts are worked out from figures that are rounded.
    slack = machine.format.resolution + EPSILON
    for part in {id(one.part): one.part for one in laid}.values():  # each once
        if part.length < layout.min_part - EPSILON:
            found, expected = f"{part.length:.3f}", f"{layout.min_part:g}"
            yield rules.PART_SHORT.at(part.source, mark=part.mark, found=found, expected=expected)
    first = min(laid, key=lambda one: one.start)
    if first.start < layout.front_trim - slack:
        found, expected = f"{first.start:.3f}", f"{layout.front_trim:g}"
        yield rules.BAR_START.at(source, mark=first.part.mark, found=found, expected=expected)
    trim = layout.end_trim + layout.dead_zone
    ends = max(one.start + one.part.length + one.ends[1].kerf(saw) for one in laid)
    if bar is None:
        yield from _size_faults(ends + trim, 0.0, layout, slack, name)
        if trim:
            yield rules.BAR_NEEDED.at(source, found=f"{ends + trim:.3f}", trim=f"{trim:g}")
        return
    yield from _size_faults(bar, layout.min_bar, layout, EPSILON, name)
    if ends > bar - trim + slack:
        found, expected = f"{ends:.3f}", f"{bar - trim:.3f}"
        yield rules.BAR_END.at(source, found=found, expected=expected, trim=f"{trim:g}")
    last = max(laid, key=lambda one: one.start)
    if bar - last.start < layout.min_bar_left - slack:
        found, expected = f"{bar - last.start:.3f}", f"{layout.min_bar_left:g}"
        yield rules.BAR_LEFT.at(source, found=found, mark=last.part.mark, expected=expected)


def _size_faults(
    bar: float, least: float, layout: Layout, slack: float, name: str
) -> Iterator[Diagnostic]:
    """A bar that is too short or too long for the machine."""
    greatest = inf if layout.max_bar is None else layout.max_bar
    if not least - slack <= bar <= greatest + slack:
        yield rules.BAR_SIZE.at(
            Source(name), found=f"{bar:.3f}", least=f"{layout.min_bar:g}", greatest=f"{greatest:g}"
        )
