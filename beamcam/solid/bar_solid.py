"""A bar machined as a solid by the events of its program alone, and the pieces that are left.

    stock of the section - what each tool sweeps - a slab for each saw cut -> pieces along the bar

Drills are cylinders with their points, along their own spindle's axis; mills are led from place to
place. Punches, scribes, taps and letters take nothing that a solid would show.
"""

from collections.abc import Iterable, Sequence
from math import cos, hypot, isnan, nan, radians, sin
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace

from beamcam.controllers.dialect import dialect_of
from beamcam.controllers.events import BarEvent, Move, Switch
from beamcam.errors import BeamcamError, Source
from beamcam.machine.machine import Machine
from beamcam.machine.stations import FORMULA_NAMES, Saw, Spindle
from beamcam.model.part import Part, Profile
from beamcam.solid import NO_MACHINE
from beamcam.solid.kernel import (
    CHORD,
    FREE,
    Wall,
    drill_profile,
    kernel,
    minus,
    moved,
    outline,
    prism,
    turned,
    walls,
)
from beamcam.solid.stock_solid import ALONG

if TYPE_CHECKING:
    from manifold3d import Manifold

# --- spindle --------------------------------------------------------------------------------------

# A spindle over a section: from the program's Y and Z to a place and a depth in a wall.
#
#     across = a + b y                 of the tool's axis, by the machine's formula
#     stroke = surface + way depth     of the tool's point; depth counts from the wall's surface
#
# Both are straight lines, so that two values of each formula give them. Where a stroke does not
# follow the depth, its axis counts from the outermost steel on the spindle's side.


AXES = {"X": 0, "Y": 1, "Z": 2}


class ToolPoint(Struct, frozen=True):
    """Where the point of a tool is: bar x and y on the face, and its depth in the wall."""

    x: float
    y: float
    depth: float


class Reach(Struct, frozen=True):
    """One spindle over one section."""

    number: int
    face: str
    wall: Wall
    front: float  #: how far the outermost steel on its side stands before the wall
    across: int  #: index of its axes in X, Y, Z
    stroke: int
    across_at: float
    across_per_y: float
    surface: float
    surface_per_y: float
    way: float

    def tip(self, bar_x: float, place: tuple[float, float, float]) -> ToolPoint:
        """The point of its tool for a place of the program's axes."""
        y = (place[self.across] - self.across_at) / self.across_per_y
        depth = self.way * (place[self.stroke] - self.surface - self.surface_per_y * y)
        return ToolPoint(bar_x, y, depth)


def reaches(machine: Machine, profile: Profile) -> dict[int, tuple[Reach, ...]]:
    """The spindles that each number of the program chooses, where the section has their wall."""
    sides = walls(profile)
    if profile.is_round:  # the four lines that spindles stand square to
        d, thick = profile.height, max(profile.flange_thickness, profile.web_thickness or 0.0)
        sides = {
            "v": Wall("z", d, -1, thick, d), "h": Wall("z", 0.0, 1, thick, d),
            "o": Wall("y", d, -1, thick, d), "u": Wall("y", 0.0, 1, thick, d),
        }  # fmt: skip
    reaches_of: dict[str, Reach] = {
        s.face: _reach(s, machine, profile, sides[s.face])
        for s in machine.spindles
        if s.face in sides
    }
    chosen: dict[int, tuple[Reach, ...]] = {
        s.number: (reaches_of[s.face],) for s in machine.spindles if s.face in reaches_of
    }
    for pair in machine.pairs:
        if all(face in reaches_of for face in pair.faces):
            chosen[pair.number] = tuple(reaches_of[face] for face in pair.faces)
    return chosen


def _reach(spindle: Spindle, machine: Machine, profile: Profile, wall: Wall) -> Reach:
    size = profile.height if wall.normal == "y" else profile.width
    if profile.code == "B":
        size = wall.thickness
    front = size - wall.surface if wall.inward < 0 else wall.surface
    values = dict.fromkeys(FORMULA_NAMES, 0.0) | {
        "height": profile.height, "width": profile.width,
        "flange_thickness": profile.flange_thickness, "web_thickness": profile.web_thickness or 0.0,
        "thickness": wall.thickness, "face_depth": front,
        "clearance": machine.drill.clearance if machine.drill else nan,
    }  # fmt: skip
    position, bottom = spindle.across.position, spindle.stroke.bottom
    at, per_y = position(values), position(values | {"y": 1.0}) - position(values)
    surface, deeper = bottom(values), bottom(values | {"depth": 1.0})
    slope = bottom(values | {"y": 1.0}) - surface
    way = 1.0 if deeper >= surface else -1.0
    if deeper == surface:  # it strokes a fixed way
        way = 1.0 if surface >= spindle.stroke.retract(values) else -1.0
        surface, slope = way * front, 0.0
    return Reach(
        spindle.number, spindle.face, wall, front, AXES[spindle.across.axis],
        AXES[spindle.stroke.axis], at, per_y, surface, slope, way,
    )  # fmt: skip


#: mm of bar behind the last event, where its length is not known: longer than any part, so that the
#: rest is taken for none.
BEYOND = 20_000.0
REMOVING = ("drill", "countersink", "mill")  #: tools whose work a solid shows
DUST = 1.0  #: mm3; smaller pieces are chips


class Slab(Struct, frozen=True):
    """What one saw cut takes: everything between two planes."""

    line: int
    at: float  #: bar x of its middle, on the pivot edge of the web, at the h side
    normal: tuple[float, float, float]  #: of its planes, of length 1
    thickness: float  #: along the normal


class Sweep(Struct, frozen=True):
    """What a tool sweeps between two places of its point."""

    line: int
    reach: Reach
    kind: str
    diameter: float
    start: ToolPoint
    end: ToolPoint


class BarWork(Struct, frozen=True):
    """What a program does to its bar."""

    slabs: tuple[Slab, ...]
    sweeps: tuple[Sweep, ...]
    section: dict[str, float]  #: what it says of its bar


def lying(part: Part, sizes: dict[str, float]) -> Part:
    """A part whose section lies as a program's words have it: angles and tubes also on the side."""
    p = part.profile
    size = sizes.get("height", p.height), sizes.get("width", p.width)
    if size == (p.height, p.width) or size != (p.width, p.height) or p.code not in ("L", "M"):
        return part
    other = replace(
        p, height=p.width, width=p.height, web_thickness=p.flange_thickness,
        flange_thickness=p.web_thickness or 0.0,
    )  # fmt: skip
    return replace(part, profile=other)


def said_of_section(events: Iterable[BarEvent], machine: Machine) -> dict[str, float]:
    """Height, width and number of the section by a program's own words."""
    words = dialect_of(machine).m_words
    sizes: dict[str, float] = {}
    for event in events:
        if isinstance(event, Switch) and event.number in words:
            word = words[event.number]
            if word.role == "section":
                sizes |= {name: event.words[at] for at, name in word.fields if at in event.words}
    return sizes


def work_of(events: Iterable[BarEvent], machine: Machine, part: Part) -> BarWork:
    """Cuts and sweeps of a program, on a bar of a part's section."""
    drill, saw = machine.drill, machine.saw
    if drill is None or saw is None:
        raise BeamcamError(
            NO_MACHINE.at(Source(machine.name), found=f"{machine.name} without saw or drill")
        )
    dialect = dialect_of(machine)
    slabs: list[Slab] = []
    chosen = reaches(machine, part.profile)
    tool: tuple[str, float] | None = None
    spindles: tuple[Reach, ...] = ()
    tips: dict[int, ToolPoint] = {}
    sweeps: list[Sweep] = []
    x = nan
    for event in events:
        if isinstance(event, Switch) and event.number in dialect.m_words:
            word = dialect.m_words[event.number]
            values = {name: event.words[at] for at, name in word.fields if at in event.words}
            if word.role == "saw" and not isnan(x):
                angles = values["angle"], values.get("tilt", 0.0)
                slabs.append(_slab(event.line, x - saw.x, angles, saw, part.profile.height))
            elif word.role == "choose":
                number = values.get("spindle", dialect.only_spindle)
                spindles = chosen.get(int(number), ()) if number is not None else ()
                kind = word.cycle.kind if word.cycle else "drill"
                tool = dialect.numbered.get(
                    int(values.get("tool", -1)), (kind, dialect.size(values.get("diameter", 0.0)))
                )
        elif isinstance(event, Move):
            x = event.end[0]
            for reach in spindles:
                tip = reach.tip(x - drill.x, event.end)
                before = tips.get(reach.number, tip)
                tips[reach.number] = tip
                is_placed = not isnan(tip.x + tip.y + tip.depth)
                if tool is not None and tool[0] in REMOVING and is_placed:
                    _swept(sweeps, Sweep(event.line, reach, *tool, before, tip))
    return BarWork(tuple(slabs), tuple(sweeps), said_of_section(events, machine))


def _swept(sweeps: list[Sweep], one: Sweep) -> None:
    """Add a sweep, unless it is before the bar or only deeper or shallower than the last one."""
    start, end = one.start, one.end
    if max(start.depth, end.depth) <= -one.reach.front:
        return
    if isnan(start.x + start.y + start.depth):
        one = replace(one, start=end)
    last = sweeps[-1] if sweeps else None
    straight_in = (start.x, start.y) == (end.x, end.y)
    if straight_in:
        deepest = end if end.depth >= start.depth else start
        one = replace(one, start=deepest, end=deepest)
        for at in range(len(sweeps) - 1, max(-1, len(sweeps) - 5), -1):
            last = sweeps[at]
            same = (last.reach.number, last.kind, last.diameter) == (
                one.reach.number, one.kind, one.diameter
            )  # fmt: skip
            if same and last.start == last.end and (last.end.x, last.end.y) == (end.x, end.y):
                if deepest.depth > last.end.depth:
                    sweeps[at] = one
                return
    sweeps.append(one)


def _slab(line: int, at: float, angles: tuple[float, float], saw: Saw, height: float) -> Slab:
    """A cut by the saw's own angles, of the mitre and of the tilt.

    A blade turned by w and then tilted by t has the normal (cos t cos w, cos t sin w, sin t); with
    DSTV's signs a mitre runs as x = c - y tan w. X counts on the pivot edge of the web.
    """
    angle, tilt = angles
    w, t = radians(saw.angle_sign * (angle - saw.zero_angle)), radians(saw.tilt_sign * tilt)
    normal = cos(t) * cos(w), cos(t) * sin(w), sin(t)
    pivot = height if saw.pivot == "o" else 0.0
    thickness = saw.kerf * (1.0 if saw.kerf_along == "normal" else normal[0])
    # Along the bar, where the plane through the pivot edge meets y = 0, z = 0.
    return Slab(line, at + pivot * normal[1] / normal[0], normal, thickness)


def bar_pieces(
    work: BarWork, part: Part, machine: Machine, bar: float | None = None,
    points: dict[tuple[str, float], float] | None = None, chord: float = CHORD,
    lines: dict[int, int] | None = None,
) -> "list[Manifold]":  # fmt: skip
    """The pieces of the bar between its cuts, along x; chips and what is no steel any more are out.

    `part` gives the section. `points` are the angles of tools' points by kind and diameter. Where
    the length of the bar is not known, it goes on behind the last cut. `chord` is how far the
    polygons of tools may lie within their circles. `lines` is filled with the line that took what
    is missing, by the kernel's number of the body that took it.
    """
    p = part.profile
    ends = [s.at for s in work.slabs] + [s.end.x for s in work.sweeps]
    over = p.height + p.width
    length = bar if bar is not None else max(ends, default=0.0) + over + BEYOND
    points = points or {}
    body = prism(outline(part), 0.0, length, ALONG)
    reach = hypot(p.height, p.width, p.web_thickness or 0.0)
    # What is taken twice counts once, for the line that takes it first.
    sweeps = {replace(one, line=0): one for one in reversed(work.sweeps)}.values()
    slabs = {replace(one, line=0): one for one in reversed(work.slabs)}.values()
    taken = [(sweep.line, _body(sweep, points, reach, chord)) for sweep in reversed(sweeps)]
    taken += [(slab.line, _slab_body(slab, over)) for slab in reversed(slabs)]
    if lines is not None:
        taken = [(line, one.as_original()) for line, one in taken]
        lines |= {one.original_id(): line for line, one in taken}
    left = minus(body, [one for _, one in taken])
    pieces = [one for one in left.decompose() if one.volume() > DUST]
    pieces.sort(key=lambda one: one.bounding_box()[0] + one.bounding_box()[3])
    return pieces


def _slab_body(slab: Slab, over: float) -> "Manifold":
    nx, ny, nz = slab.normal
    # Two directions in the plane: up the web, and square to it.
    flat = hypot(nx, ny)
    up = (-ny / flat, nx / flat, 0.0)
    side = (ny * up[2] - nz * up[1], nz * up[0] - nx * up[2], nx * up[1] - ny * up[0])
    size = 20.0 * over / max(nx, 0.05)
    frame = tuple((slab.normal[k], up[k], side[k], slab.at if k == 0 else 0.0) for k in range(3))
    cube = kernel().Manifold.cube((slab.thickness, size, size), True)
    return cube.transform(frame)


def _body(
    sweep: Sweep, points: dict[tuple[str, float], float], reach: float, chord: float
) -> "Manifold":
    """What a tool takes: from the air before the bar to its point, at both places and between."""
    radius = sweep.diameter / 2
    point = points.get((sweep.kind, sweep.diameter), 180.0)
    bodies = []
    for tip in dict.fromkeys((sweep.start, sweep.end)):
        air = min(-sweep.reach.front, tip.depth) - FREE - radius
        full = tip.depth - drill_profile(radius, air, 0.0, point)[-1][1]  # without its point
        profile = drill_profile(radius, full - FREE if full <= air else air, full, point)
        frame = moved(sweep.reach.wall.frame, tip.x, tip.y)
        bodies.append(turned(profile, frame, chord))
    return kernel().Manifold.batch_hull(bodies) if len(bodies) > 1 else bodies[0]


def points_of(machine: Machine, parts: Sequence[Part]) -> dict[tuple[str, float], float]:
    """Angles of the tools' points by kind and diameter.

    Of two countersinks of one diameter, which a program does not tell apart, the one that has the
    cone of the parts' sinks.
    """
    angles = {h.angle or 180.0 for part in parts for h in part.holes if h.kind == "countersink"}
    points: dict[tuple[str, float], float] = {}
    for tools in machine.tools:
        for size in tools.sizes:
            if (tools.kind, size) not in points or tools.point_deg in angles:
                points[tools.kind, size] = tools.point_deg
    return points
