"""The faces of a rectangular tube, from what stays of its unrolled surface.

    x  |      |   |      Over a corner a line is x(t), t the angle round it. The faces beside it
  v    | corner | o      get lines whose sum is that, x = a + b - edge: those of a plane where one
       |      |   |      goes through the line, else all of it is the first face's. What ends in a
                         corner is seen square to the face from which it comes.

An end that is a plane, cut where the wall reaches farthest, is given by its angles.
"""

from collections.abc import Mapping, Sequence
from math import atan, degrees, pi
from typing import Any

import numpy as np
from msgspec import Struct

from beamcam.checks.coping.section import TubeSection, areas_of, pieces_of
from beamcam.controllers import cell_events
from beamcam.controllers.events import Move
from beamcam.geometry.array_types import Floats
from beamcam.machine.machine import Machine
from beamcam.model.part import EndCuts, Face, Profile
from beamcam.recovery.recovered import plain
from beamcam.recovery.rings import DECIMALS, PLACE

Shape = Any  #: of shapely

LEVELS = 65  #: places across a corner; a planner's 33 are every second of them
FAR = 1e5
SEAM = 1e-5  #: mm by which shapes of a face and of the corner beside it lie over each other
STEADY_DEG = 1e-3  #: of a face that is on top
LEAST_DEG = 0.2  #: of an end; less is square
#: The faces beside each corner on the way round, and whether it is at the greatest y of each.
CORNERS: tuple[tuple[Face, bool, Face, bool], ...] = (
    ("u", True, "v", False), ("v", True, "o", True), ("o", False, "h", True),
    ("h", False, "u", False),
)  # fmt: skip
FACES: tuple[Face, ...] = ("u", "v", "o", "h")


class Faces(Struct, frozen=True):
    """What stays of each face, and the angles of the ends, which are square on the faces then."""

    steel: Mapping[Face, Shape]
    cuts: EndCuts
    lost: str = ""  #: the corner in which a line ends or turns back


def corner_radius(text: str, machine: Machine, profile: Profile) -> float:
    """The outer radius of the corners that a program goes round; 0 where it does not say it.

    While a face is on top the tip goes as far as its flat reaches: half the face less the radius.
    """
    events, _ = cell_events(text, machine)
    most = {0: 0.0, 1: 0.0}
    for move in (e for e in events if isinstance(e, Move) and e.minutes > 0.0):
        a_deg = move.a_deg[1]
        if abs(a_deg - 90.0 * round(a_deg / 90.0)) <= STEADY_DEG:
            odd = round(a_deg / 90.0) % 2
            most[odd] = max(most[odd], abs(move.end[1]))
    radii = [profile.height / 2 - most[0], profile.width / 2 - most[1]]
    return plain(radii[0], PLACE, DECIMALS) if abs(radii[0] - radii[1]) <= 2 * PLACE else 0.0


def faces_of(surface: Shape, profile: Profile, within: float) -> Faces:
    """What stays of each face, from what stays of the surface on the turn before 0 and two more."""
    from shapely import box, union_all

    section = TubeSection(profile, profile.radius)
    r, arc = section.radius, section.radius * pi / 2
    low, _, high, _ = surface.bounds
    cuts = _planes(surface, section, profile, within)
    shapes: dict[Face, list[Shape]] = {face: [] for face in FACES}
    for face in FACES:
        wide = profile.face_width(face)
        first, last = sorted(section.around(face, y) for y in (r, wide - r))
        rising = section.around(face, wide - r) > section.around(face, r)
        flat = surface.intersection(box(-FAR, first, FAR, last))
        shapes[face].append(_mapped(flat, lambda s, a=first, b=last, up=rising, r=r: (
            r + (s - a) if up else r + (b - s))))  # fmt: skip
    gone: dict[Face, list[Shape]] = {face: [] for face in FACES}
    for k, (a, a_high, b, b_high) in enumerate(CORNERS):
        first = section.corner(k)
        steel = areas_of(surface.intersection(box(-FAR, first, FAR, first + arc)))
        seen = {
            a: _view(profile.face_width(a), a_high, lambda s, c=first: np.sin((s - c) / r), r),
            b: _view(profile.face_width(b), b_high, lambda s, c=first: np.cos((s - c) / r), r),
        }
        for one in pieces_of(box(low - 1.0, first, high + 1.0, first + arc).difference(steel)):
            at_a, at_b = one.bounds[1] <= first + PLACE, one.bounds[3] >= first + arc - PLACE
            if at_a and at_b:
                continue
            middle = (one.bounds[1] + one.bounds[3]) / 2
            face = a if at_a or (not at_b and middle < first + arc / 2) else b
            gone[face].append(_mapped(one, seen[face]).buffer(SEAM, join_style="mitre"))
            steel = union_all([steel, one.buffer(PLACE)])
        lines = _lines(steel, first, arc)
        if lines is None:
            return Faces({}, EndCuts(), f"{a} and {b}")
        for face, bands in zip((a, b), _split(lines, r, within), strict=True):
            at_high = a_high if face == a else b_high
            shapes[face].append(_band(bands, profile.face_width(face), at_high))
    faces: dict[Face, Shape] = {}
    for face in FACES:
        shape = union_all([one.buffer(SEAM / 10, join_style="mitre") for one in shapes[face]])
        shape = shape.difference(union_all(gone[face])) if gone[face] else shape
        strip = box(-FAR, 0.0, FAR, profile.face_width(face))
        faces[face] = areas_of(shape.intersection(strip))
    return Faces(faces, cuts)


def _mapped(shape: Shape, y_of: Any) -> Shape:
    """A shape of the surface with y of a face in place of s."""
    from shapely import make_valid, transform

    return make_valid(transform(shape, lambda at: np.column_stack((at[:, 0], y_of(at[:, 1])))))


def _view(wide: float, at_high: bool, into: Any, r: float) -> Any:
    """y of a place in a corner as a face sees it, `into` of the radius beyond its flat."""
    return lambda s: (wide - r + r * into(s)) if at_high else r - r * into(s)


def _lines(steel: Shape, first: float, arc: float) -> Floats | None:
    """x of the lines that cross a corner at its places, along the part; None where one ends."""
    from shapely import LineString

    rows = []
    for k in range(LEVELS):
        s = first + arc * min(max(k / (LEVELS - 1), 1e-7), 1 - 1e-7)
        cut = steel.intersection(LineString([(-FAR, s), (FAR, s)]))
        pieces = [one for one in pieces_of(cut) if one.length > PLACE]
        rows.append(sorted(x for one in pieces for x in (one.bounds[0], one.bounds[2])))
    return np.array(rows) if len({len(row) for row in rows}) == 1 else None


def _split(lines: Floats, r: float, within: float) -> tuple[tuple[Floats, Floats], ...]:
    """The lines of the faces before and behind a corner: how far off the edge, and x there."""
    turns = np.linspace(0.0, pi / 2, LEVELS)
    off_a, off_b = r * (1 - np.sin(turns)), r * (1 - np.cos(turns))
    system = np.column_stack((np.ones(LEVELS), off_a, off_b))
    of_a, of_b = np.empty_like(lines), np.empty_like(lines)
    for k in range(lines.shape[1]):
        x = lines[:, k]
        steady = float(np.median(x))
        if np.abs(x - steady).max() <= PLACE:
            of_a[:, k] = of_b[:, k] = steady
            continue
        (edge, by_a, by_b), *_ = np.linalg.lstsq(system, x, rcond=None)
        if np.abs(system @ (edge, by_a, by_b) - x).max() <= within / 2:
            of_a[:, k], of_b[:, k] = edge + by_a * off_a, edge + by_b * off_b
        else:
            of_a[:, k], of_b[:, k] = x, x[-1]
    return (off_a, of_a), (off_b[::-1], of_b[::-1])


def _band(lines: tuple[Floats, Floats], wide: float, at_high: bool) -> Shape:
    """What stays of a face beside an edge, between lines from its flat to the edge."""
    from shapely import Polygon, union_all

    off, xs = lines
    ys = wide - off if at_high else off
    return union_all([
        Polygon([*zip(xs[:, k], ys, strict=True), *zip(xs[::-1, k + 1], ys[::-1], strict=True)])
        .buffer(0)
        for k in range(0, xs.shape[1], 2)
    ])  # fmt: skip


def _planes(surface: Shape, section: TubeSection, profile: Profile, within: float) -> EndCuts:
    """The angles of ends that are planes from 0 to the part's length; none where one is not."""
    from shapely import LineString

    def end(s: float) -> float:
        """x where the surface ends at a place round it."""
        cut = surface.intersection(LineString([(-FAR, s), (FAR, s)]))
        return float(cut.bounds[0 if pick is min else 2])

    angles = []
    for pick in (min, max):
        slopes = []  # in the views of v and u
        for face in ("v", "o"):
            low, high = section.radius + 0.1, profile.face_width(face) - section.radius - 0.1
            rise = end(section.around(face, low)) - end(section.around(face, high))
            slopes.append(rise / (high - low))
        by_y, by_z = (0.0 if abs(by) <= np.tan(np.radians(LEAST_DEG)) else by for by in slopes)
        off = []
        for s in map(float, np.linspace(-section.turn / 2, section.turn / 2, 200)):
            off.append(end(s) - pick(-by_y * y - by_z * z for y, z in _through(section, s)))
        if np.ptp(off) > 2 * within:
            return EndCuts()
        angles.append([plain(degrees(atan(by)), 2e-3, DECIMALS) for by in (by_y, by_z)])
    (web_start, flange_start), (web_end, flange_end) = angles
    return EndCuts(web_start, web_end, flange_start, flange_end)


def _through(section: TubeSection, s: float) -> Sequence[tuple[float, float]]:
    """Y and Z from the axis on the outside and the inside of the wall at a place of the surface."""
    r, borders = section.radius, [0.0, section.flat_z]
    for flat in (2 * section.flat_y, 2 * section.flat_z, 2 * section.flat_y, section.flat_z):
        borders += [borders[-1] + r * pi / 2, borders[-1] + r * pi / 2 + flat]
    y, z = section.flat_y, section.flat_z
    s %= section.turn
    turned = np.interp(s, borders, np.array([0, 0, 1, 1, 2, 2, 3, 3, 4, 4]) * pi / 2)
    at_y = np.interp(s, borders, [-y, -y, -y, y, y, y, y, -y, -y, -y])
    at_z = np.interp(s, borders, [0.0, z, z, z, z, -z, -z, -z, -z, 0.0])
    return [
        (float(at_y - q * np.cos(turned)), float(at_z + q * np.sin(turned)))
        for q in (r, r - section.wall)
    ]
