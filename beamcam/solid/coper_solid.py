"""A bar or a tube cut as a solid by the events of a coper's program alone.

    stock of the section - what the jet sweeps, pierced holes among it -> pieces

The jet goes from the tip along the torch, whose head is at X sin B, Y -sin A cos B, Z cos A cos B
of its tip. How wide and how deep it cuts says the row of the cut chart whose speed the cut has. A
tube turns below an upright torch, so that its wall is cut square to its surface; any other profile
that turns is seen by the torch as if it went round.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, dist, isfinite, radians, sin
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.controllers.events import BarEvent, Move, Place, Switch
from beamcam.errors import BeamcamError, Source
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow, is_row_for, material_said
from beamcam.model.part import Part
from beamcam.solid import NO_SOLID
from beamcam.solid.kernel import CHORD, Frame, facets, minus, outline, prism
from beamcam.solid.part_solid import part_solid
from beamcam.solid.sheet_solid import starting_words
from beamcam.solid.stock_solid import ALONG
from beamcam.solid.wrapped import Skin, skin_of, wrapped

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
    path: tuple[tuple[float, float], ...]
    heights: tuple[float, ...]  #: of the tip along the torch, from the part's axis or a tube's skin
    b_deg: float = 0.0  #: of the torch towards X


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
    unrolls = coper.unrolls(part.profile.code)
    if unrolls:
        skin = skin_of(part)[0]
        turned = [_over_tube(place, a_deg, coper, skin) for place, a_deg in places]
    else:
        axis = _axis_of(part) if coper.turns == "bar" else None
        turned = [_across_bar(place, a, places[0][1], coper, tilts[0], axis) for place, a in places]
    if any(one is None for one in turned) or max(tilts) - min(tilts) > STEADY_DEG:
        what = "a torch that is not square to its tube" if unrolls else (
            "a torch that turns as it cuts")  # fmt: skip
        raise BeamcamError(NO_SOLID.at(source, found=what))
    seen = [one for one in turned if one is not None]
    ways = [dist(a, b) for a, b in pairwise(seen)]
    minutes = [
        move.minutes or (way / move.feed_mm_min if move.feed_mm_min > 0.0 else 0.0)
        for move, way in zip(moves, ways, strict=True)
    ]
    speed = sum(ways) / sum(minutes) if sum(minutes) > 0.0 else 0.0
    row = _row_of(speed, rows, coper)
    if row is None or abs(row.feed_mm_min - speed) > SAME_SPEED * row.feed_mm_min:
        found = f"a cut at {speed:.0f} mm/min, the speed of no row of the chart"
        raise BeamcamError(NO_SOLID.at(source, found=found))
    path, heights = tuple((x, q) for x, q, _ in seen), tuple(h for *_, h in seen)
    return Burn(source.line or 0, row, places[0][1], path, heights, tilts[0])


def _row_of(speed: float, rows: Sequence[TorchRow], coper: Coper) -> TorchRow | None:
    """The row whose speed is nearest; of one between two, where the file has those, that for
    thicker steel, as deep as that speed goes: at a fillet that is deepest at the kerf's side."""
    row = min(rows, key=lambda one: abs(one.feed_mm_min - speed), default=None)
    if row is None or coper.between_rows != "interpolate":
        return row
    alike = sorted((one for one in rows if one.material == row.material), key=lambda o: -o.up_to)
    for slow, fast in pairwise(alike):
        off = min(abs(one.feed_mm_min / speed - 1.0) for one in (slow, fast))
        if slow.feed_mm_min < speed < fast.feed_mm_min and off > SAME_SPEED / 10:
            share = (fast.feed_mm_min - speed) / (fast.feed_mm_min - slow.feed_mm_min)
            deep = fast.up_to + share * (slow.up_to - fast.up_to)
            return replace(slow, feed_mm_min=speed, up_to=min(deep + slow.kerf, slow.up_to))
    return row


def _axis_of(part: Part) -> tuple[float, float]:
    """Y and Z of the line about which a profile turns, as it lies: the middle of its box."""
    high, wide = part.profile.height / 2, part.profile.width / 2
    return (wide, high) if part.profile.code == "T" else (high, wide)


def _across_bar(
    place: Place, a_deg: float, first_deg: float, coper: Coper, b_deg: float,
    axis: tuple[float, float] | None = None,
) -> Any:  # fmt: skip
    """x, the way across and the height of the tip of a torch that goes round, as it looks along
    itself; None if it turns.

    Over a bar that turns about an axis it stands upright, so that these are Y and Z, counted from
    that axis.
    """
    x, y, z = place
    if abs(a_deg - first_deg) > STEADY_DEG:
        return None
    a, b, x = radians(a_deg), radians(b_deg), x - coper.trim
    if axis is not None:
        on_y, on_z = axis
        return x, y + on_y * cos(a) + on_z * sin(a), z + on_z * cos(a) - on_y * sin(a)
    over = z * cos(a) - y * sin(a)
    along, high = x * cos(b) - over * sin(b), over * cos(b) + x * sin(b)
    return along, y * cos(a) + z * sin(a), high - coper.pivot


def _over_tube(place: Place, a_deg: float, coper: Coper, skin: Skin) -> Any:
    """x, the way round and the height of the tip over a tube; None if it is not square to it."""
    x, y, z = place
    u, high, beside = skin.place(y, z, a_deg)
    return None if abs(beside) > coper.tolerance / 2 else (x - coper.trim, u, high)


def taken_by(burn: Burn, coper: Coper, part: Part) -> "Manifold":
    """What a cut takes: the hole that is pierced, and the kerf behind the way down to the steel."""
    from shapely import LineString, Point, union_all

    row, half = burn.row, burn.row.kerf / 2
    quarter = facets(half) // 4
    ways = [LineString(way) for way in pairwise(burn.path[1:]) if way[0] != way[1]]
    shape = union_all([
        Point(burn.path[0]).buffer(row.pierce_radius, quad_segs=facets(row.pierce_radius) // 4),
        *(way.buffer(half, quad_segs=quarter) for way in ways),
    ])  # fmt: skip
    tips = burn.heights[1:] or burn.heights
    high = max(tips)
    low = min(tips) - coper.standoff(row.cut_height, burn.b_deg) - row.up_to
    if coper.unrolls(part.profile.code):  # beyond its depth by what chords lie within a circle
        return wrapped(shape, skin_of(part)[0], -high, CHORD - low)
    a, b = radians(burn.a_deg), radians(burn.b_deg)
    up, over = -sin(b), cos(b)  # of a wall's normal, along x as the torch sees it and along itself
    y = (-sin(a) * up, cos(a), -sin(a) * over, 0.0)
    z = (cos(a) * up, sin(a), cos(a) * over, 0.0)
    if part.profile.code == "T":  # on its side: Y is its z, Z its height less its y
        y, z = (-z[0], -z[1], -z[2], part.profile.height), y
    if part.profile.code == "C":  # on its lips: turned 180 degrees about its length
        y = (-y[0], -y[1], -y[2], part.profile.height)
        z = (-z[0], -z[1], -z[2], part.profile.width)
    frame: Frame = ((cos(b), 0.0, sin(b), 0.0), y, z)
    return prism(shape, low, high, frame)


def pieces_of(
    stock: "Manifold", burns: Sequence[Burn], coper: Coper, part: Part
) -> "list[Manifold]":
    """The pieces that a stock falls into, along x, what falls out of holes among them."""
    left = minus(stock, [taken_by(burn, coper, part) for burn in burns])
    pieces = [one for one in left.decompose() if one.volume() > DUST]
    return sorted(pieces, key=lambda one: one.bounding_box()[0] + one.bounding_box()[3])
