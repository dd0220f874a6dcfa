"""A bar or a tube cut as a solid by the events of a coper's program alone.

    stock of the section - what the jet sweeps, pierced holes among it -> pieces

The jet goes from the tip along the torch, whose head is at X sin B, Y -sin A cos B, Z cos A cos B
of its tip. How wide and how deep it cuts says the row of the cut chart whose speed the cut has. A
tube turns below an upright torch, so that its wall is cut square to its surface; any other profile
that turns is seen by the torch as if it went round.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import acos, cos, degrees, dist, isfinite, pi, radians, sin
from typing import TYPE_CHECKING

import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.controllers.events import BarEvent, Move, Place, Switch
from beamcam.errors import BeamcamError, Source
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow, is_row_for, material_said
from beamcam.model.part import Part
from beamcam.solid import NO_SOLID
from beamcam.solid.kernel import CHORD, Frame, Row, facets, kernel, minus, outline, prism
from beamcam.solid.part_solid import part_solid
from beamcam.solid.sheet_solid import starting_words
from beamcam.solid.stock_solid import ALONG
from beamcam.solid.wrapped import skin_of, wrapped

if TYPE_CHECKING:
    from manifold3d import Manifold

SAME_SPEED = 0.05  #: share by which a cut may differ from the speed of its row
STEADY_DEG = 1e-6  #: by which a torch may turn as it cuts
DUST = 1.0  #: mm3; smaller pieces are chips


class Burn(Struct, frozen=True):
    """What is cut from the start of the torch to its stop."""

    line: int
    row: TorchRow
    a_deg: float  #: of the torch; of a tube, which turns, that of its first place
    #: x of the part and across, or round a tube; of a tilted torch as it looks along itself
    path: tuple[Point, ...]
    heights: tuple[float, ...]  #: of the tip along the torch, from the part's axis or a tube's skin
    b_deg: float = 0.0  #: of the torch towards X
    #: tip, A and B of a torch that turns as it cuts, X from the part's start
    poses: tuple[tuple[Place, float, float], ...] = ()


def stock_of(part: Part, coper: Coper, bar: float | None) -> "Manifold":
    """What a program begins with, in the part's axes: a bar, or a piece with all that is there."""
    if part.made is not None:
        return part_solid(replace(part, features=part.made, made=None))
    length = bar if bar is not None else part.length + 2 * coper.trim + coper.chuck
    return prism(outline(part), -coper.trim, length - coper.trim, ALONG)


def burns_of(
    events: Sequence[BarEvent], machine: Machine, coper: Coper, part: Part, name: str
) -> Iterator[Burn]:
    """The cuts of a program.

    Raises BeamcamError where one begins nowhere, has the speed of no row, or where the torch turns
    on the way, or does not stand square to the surface of its tube.
    """
    known = [one for one in starting_words(machine) if one.process == "cut"]
    material = material_said(part.grade, coper.material)
    rows = [row for row in coper.rows if is_row_for(row.material, material)]
    line, moves = 0, list[Move[Place]]()
    for event in (*events, Switch(0, 2, {})):
        if isinstance(event, Move) and line:
            moves.append(event)
        elif isinstance(event, Switch):
            if moves:
                yield _burn(Source(name, line), moves, coper, rows, part)
            line = event.line if any(one.takes(event) for one in known) else 0
            moves = []


def _burn(
    source: Source, moves: Sequence[Move[Place]], coper: Coper, rows: Sequence[TorchRow], part: Part
) -> Burn:
    """A cut by its moves; its speed, which says its row, is that of all of them together."""
    places = [(moves[0].start, moves[0].a_deg[0]), *((m.end, m.a_deg[1]) for m in moves)]
    tilts = [b for m in moves for b in m.b_deg] if coper.tilt else [0.0]
    if not all(isfinite(a_deg) and all(map(isfinite, place)) for place, a_deg in places) or not all(
        map(isfinite, tilts)
    ):
        raise BeamcamError(NO_SOLID.at(source, found="a cut from or to nowhere"))
    if coper.turns == "torch" and (max(tilts) - min(tilts) > STEADY_DEG or any(
        abs(a_deg - places[0][1]) > STEADY_DEG for _, a_deg in places
    )):  # fmt: skip
        return _turning(source, moves, coper, rows)
    if coper.unrolls(part.profile.code):
        skin, seen = skin_of(part)[0], []
        for (x, y, z), a_deg in places:
            u, high, beside = skin.place(y, z, a_deg)
            if abs(beside) > coper.tolerance / 2:
                found = "a torch that is not square to its tube"
                raise BeamcamError(NO_SOLID.at(source, found=found))
            seen.append((x - coper.trim, u, high))
    elif any(abs(a_deg - places[0][1]) > STEADY_DEG for _, a_deg in places):
        raise BeamcamError(NO_SOLID.at(source, found="a torch that turns as it cuts"))
    else:
        seen = [_across_bar(place, a_deg, coper, tilts[0], part) for place, a_deg in places]
    ways = [dist(a, b) for a, b in pairwise(seen)]
    minutes = [
        move.minutes or (way / move.feed_mm_min if move.feed_mm_min > 0.0 else 0.0)
        for move, way in zip(moves, ways, strict=True)
    ]
    speed = sum(ways) / sum(minutes) if sum(minutes) > 0.0 else 0.0
    row = _row_of(source, speed, rows, coper)
    path, heights = tuple((x, q) for x, q, _ in seen), tuple(h for *_, h in seen)
    return Burn(source.line or 0, row, places[0][1], path, heights, tilts[0])


def _row_of(source: Source, speed: float, rows: Sequence[TorchRow], coper: Coper) -> TorchRow:
    """The row whose speed is nearest; of one between two, where the file has those, that for
    thicker steel, as deep as that speed goes: at a fillet that is deepest at the kerf's side.

    Raises BeamcamError where none is near.
    """
    row = min(rows, key=lambda one: abs(one.feed_mm_min - speed), default=None)
    alike = [one for one in rows if row is not None and one.material == row.material]
    alike = alike if coper.between_rows == "interpolate" else []
    for slow, fast in pairwise(sorted(alike, key=lambda one: -one.up_to)):
        off = min(abs(one.feed_mm_min / speed - 1.0) for one in (slow, fast))
        if slow.feed_mm_min < speed < fast.feed_mm_min and off > SAME_SPEED / 10:
            share = (fast.feed_mm_min - speed) / (fast.feed_mm_min - slow.feed_mm_min)
            deep = fast.up_to + share * (slow.up_to - fast.up_to)
            return replace(slow, feed_mm_min=speed, up_to=min(deep + slow.kerf, slow.up_to))
    if row is None or abs(row.feed_mm_min - speed) > SAME_SPEED * row.feed_mm_min:
        found = f"a cut at {speed:.0f} mm/min, the speed of no row of the chart"
        raise BeamcamError(NO_SOLID.at(source, found=found))
    return row


def _turning(
    source: Source, moves: Sequence[Move[Place]], coper: Coper, rows: Sequence[TorchRow]
) -> Burn:
    """A cut on which the torch turns, in inverse time; the way down to the steel says its row."""
    if not coper.tilt or any(
        not move.minutes and (move.a_deg[0] != move.a_deg[1] or move.b_deg[0] != move.b_deg[1])
        for move in moves
    ):
        raise BeamcamError(NO_SOLID.at(source, found="a torch that turns as it cuts"))
    row = _row_of(source, moves[0].feed_mm_min, rows, coper)
    poses: list[tuple[Place, float, float]] = []
    for move in moves:
        for share in (0.0, 0.5, 1.0):
            x, y, z = (a + share * (b - a) for a, b in zip(move.start, move.end, strict=True))
            a_deg, b_deg = (a + share * (b - a) for a, b in (move.a_deg, move.b_deg))
            (ux, uy, uz), down = _way(a_deg, b_deg), coper.pivot
            tip = x - coper.trim - down * ux, y - down * uy, z - down * uz
            poses.append((tip, a_deg, b_deg))
    path, heights = tuple((x, y) for (x, y, _), _, _ in poses), tuple(z for (*_, z), _, _ in poses)
    return Burn(source.line or 0, row, poses[0][1], path, heights, poses[0][2], tuple(poses[2:]))


def _way(a_deg: float, b_deg: float) -> Place:
    """The way from the tip of a torch to its head, of length 1."""
    a, b = radians(a_deg), radians(b_deg)
    return sin(b), -sin(a) * cos(b), cos(a) * cos(b)


def _swept(burn: Burn, coper: Coper) -> "Manifold":
    """What a jet takes that turns: between one place and the next the hull of both. It is as deep
    from the wall's surface on, whatever its angle to that."""
    m, row = kernel(), burn.row

    def round_at(pose: tuple[Place, float, float], radius: float) -> list[Place]:
        tip, a_deg, b_deg = pose
        way = _way(a_deg, b_deg)
        out = _way(90.0 * round(a_deg / 90.0), 0.0)  # of the wall
        share = sum(a * b for a, b in zip(way, out, strict=True))
        deep = coper.standoff(row.cut_height, degrees(acos(share))) + row.up_to
        aside = (0.0, cos(radians(a_deg)), sin(radians(a_deg)))  # square to the way
        over = (
            way[1] * aside[2] - way[2] * aside[1], way[2] * aside[0] - way[0] * aside[2],
            way[0] * aside[1] - way[1] * aside[0],
        )  # fmt: skip
        count = facets(radius)
        found = []
        for k in range(count):
            c, s = radius * cos(2 * pi * k / count), radius * sin(2 * pi * k / count)
            beside = [c * aside[i] + s * over[i] for i in range(3)]
            down = deep + sum(a * b for a, b in zip(beside, out, strict=True)) / share
            x, y, z = (tip[i] + beside[i] for i in range(3))
            found.append((x, y, z))
            found.append((x - down * way[0], y - down * way[1], z - down * way[2]))
        return found

    rounds = [round_at(pose, row.kerf / 2) for pose in burn.poses]
    bodies = [m.Manifold.hull_points([*a, *b]) for a, b in pairwise(rounds) if a != b]
    bodies.append(m.Manifold.hull_points(round_at(burn.poses[0], row.pierce_radius)))
    return m.Manifold.batch_boolean(bodies, m.OpType.Add)


def _across_bar(place: Place, a_deg: float, coper: Coper, b_deg: float, part: Part) -> Place:
    """x, the way across and the height of the tip of a torch that goes round, as it looks along
    itself.

    Over a bar that turns it stands upright, so that these are Y and Z, counted from the axis that
    the bar turns about: the middle of its box, as it lies.
    """
    x, y, z = place
    a, b, x = radians(a_deg), radians(b_deg), x - coper.trim
    if coper.turns == "bar":
        on_y, on_z = part.profile.height / 2, part.profile.width / 2
        if part.profile.code == "T":
            on_y, on_z = on_z, on_y
        return x, y + on_y * cos(a) + on_z * sin(a), z + on_z * cos(a) - on_y * sin(a)
    over = z * cos(a) - y * sin(a)
    along, high = x * cos(b) - over * sin(b), over * cos(b) + x * sin(b)
    return along, y * cos(a) + z * sin(a), high - coper.pivot


def taken_by(burn: Burn, coper: Coper, part: Part) -> "Manifold":
    """What a cut takes: the hole that is pierced, and the kerf behind the way down to the steel."""
    size = part.profile
    along_x: Row = (1.0, 0.0, 0.0, 0.0)
    lies: Frame = (along_x, (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    if size.code == "T":  # on its side: Y is its z, Z its height less its y
        lies = (along_x, (0.0, 0.0, -1.0, size.height), (0.0, 1.0, 0.0, 0.0))
    elif size.code == "C":  # on its lips: turned 180 degrees about its length
        lies = (along_x, (0.0, -1.0, 0.0, size.height), (0.0, 0.0, -1.0, size.width))
    if burn.poses:
        return _swept(burn, coper).transform(lies)
    row, half, hole = burn.row, burn.row.kerf / 2, burn.row.pierce_radius
    quarter = facets(half) // 4
    ways = [shapely.LineString(way) for way in pairwise(burn.path[1:]) if way[0] != way[1]]
    shape = shapely.union_all([
        shapely.Point(burn.path[0]).buffer(hole, quad_segs=facets(hole) // 4),
        *(way.buffer(half, quad_segs=quarter) for way in ways),
    ])  # fmt: skip
    tips = burn.heights[1:] or burn.heights
    high = max(tips)
    off = burn.a_deg - 90.0 * round(burn.a_deg / 90.0) if coper.turns == "torch" else 0.0
    leaning = degrees(acos(cos(radians(off)) * cos(radians(burn.b_deg))))
    # Beyond its depth by what chords lie within a circle, and so that it goes through what is as
    # thick as its row is for.
    low = min(tips) - coper.standoff(row.cut_height, leaning) - row.up_to - CHORD
    if coper.unrolls(part.profile.code):
        return wrapped(shape, skin_of(part)[0], -high, -low)
    a, b = radians(burn.a_deg), radians(burn.b_deg)
    up, over = -sin(b), cos(b)  # of a wall's normal, along x as the torch sees it and along itself
    y = (-sin(a) * up, cos(a), -sin(a) * over, 0.0)
    z = (cos(a) * up, sin(a), cos(a) * over, 0.0)
    return prism(shape, low, high, ((cos(b), 0.0, sin(b), 0.0), y, z)).transform(lies)


def pieces_of(
    stock: "Manifold", burns: Sequence[Burn], coper: Coper, part: Part
) -> "list[Manifold]":
    """The pieces that a stock falls into, along x, what falls out of holes among them."""
    left = minus(stock, [taken_by(burn, coper, part) for burn in burns])
    pieces = [one for one in left.decompose() if one.volume() > DUST]
    return sorted(pieces, key=lambda one: one.bounding_box()[0] + one.bounding_box()[3])
