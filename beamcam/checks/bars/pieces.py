"""The ends of parts, the pieces of a bar between its cuts, and which part each of them is.

    | trim |# piece 1 ######/ wedge | piece 2 ####|  rest

A cut is a slab as thick as the blade. Between two of them that follow each other along the bar lies
a piece of steel, which is a part if both its ends are those of the part. X counts on the pivot
edge of the saw; the plane of a cut is x = x_0 - y tan(web) - z tan(flange), in DSTV's angles.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import atan, atan2, cos, degrees, hypot, nan, radians, tan
from typing import Literal

from msgspec import Struct

from beamcam.checks.bars.orientations import orientations
from beamcam.checks.bars.stations import Cut
from beamcam.geometry.curves import Line
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Saw
from beamcam.model.part import Contour, Face, Part, Profile
from beamcam.model.section import corners

# --- part ends ------------------------------------------------------------------------------------

# End planes of a part, and the outlines that they account for.
#
# Computed from the part alone, and not by the planner. Both ends follow DSTV's formula, of the web
# in y and of the flange in z (across, from the h side):
#
#     angle = atan2(x(lowest) - x(highest), height)      so      x = c - y tan(web) - z tan(flange)
#
# and touch x = 0 and x = length at their furthest points.


OUTLINE_TOLERANCE = 1.0  #: mm that exporters leave between outline and header
ANGLE_TOLERANCE_DEG = 0.2  #: between header and outline, and between a bevel and its mitre


class RequiredEnd(Struct, frozen=True, gc=False):
    """The plane of one end of a part."""

    side: int  #: -1 start, +1 end: on which side of it the waste lies
    web: float  #: degrees, DSTV's web angle
    flange: float  #: and its flange angle; both 0 is square
    x_0: float  #: x on the part at y = 0, z = 0
    tan_web: float = 0.0
    tan_flange: float = 0.0

    @property
    def name(self) -> Literal["start", "end"]:
        return "start" if self.side < 0 else "end"

    @property
    def square(self) -> bool:
        return not self.web and not self.flange

    def x(self, y: float, z: float = 0.0) -> float:
        return self.x_0 - y * self.tan_web - z * self.tan_flange

    def at_wall(self, face: Face, q: float, wall: tuple[float, float]) -> tuple[float, float]:
        """x at which it leaves both surfaces of the wall behind a face, at the face's y `q`."""
        if face in ("o", "u"):
            return self.x(wall[0], q), self.x(wall[1], q)
        return self.x(q, wall[0]), self.x(q, wall[1])

    def kerf(self, saw: Saw) -> float:
        """Length of bar that its cut takes: the blade's thickness, along the bar if it is so."""
        if self.square or saw.kerf_along != "normal":
            return saw.kerf
        return saw.kerf * hypot(1.0, self.tan_web, self.tan_flange)

    def blade(self, saw: Saw, height: float) -> float:
        """The part's x of the blade's centre, on the saw's pivot edge."""
        return self.x(height if saw.pivot == "o" else 0.0) + self.side * self.kerf(saw) / 2

    def saw_angles(self, saw: Saw) -> tuple[float, float]:
        """Angle and tilt in the machine's counting.

        A blade turned by w and then tilted by t has the normal (cos t cos w, cos t sin w, sin t),
        which has to be along (1, tan w, tan f), so tan t = tan f cos w.
        """
        if not self.flange:
            return saw.zero_angle + saw.angle_sign * self.web, 0.0
        tilt = degrees(atan(self.tan_flange * cos(radians(self.web))))
        return saw.zero_angle + saw.angle_sign * self.web, saw.tilt_sign * tilt + 0.0


Ends = tuple[RequiredEnd, RequiredEnd]  #: start and end


def ends_of(part: Part, saw: Saw) -> Ends:
    """Start and end of a part: by the header's angles, by the outlines where they are 0."""
    cuts, least = part.cuts, saw.min_mitre
    webs, flanges = (cuts.web_start, cuts.web_end), (cuts.flange_start, cuts.flange_end)
    if Contour in map(type, part.features):
        webs = _with_drawn(webs, part, ("v",), least)
        faces: tuple[Face, ...] = ("u",) if part.profile.code == "L" else ("o", "u")
        flanges = _with_drawn(flanges, part, faces, least)
    ends = []
    for side, web, flange in ((-1, webs[0], flanges[0]), (1, webs[1], flanges[1])):
        web = web if abs(web) >= least else 0.0
        flange = flange if abs(flange) >= least else 0.0
        x_0, t, s = 0.0 if side < 0 else part.length, 0.0, 0.0
        if web or flange:
            # x(y, z) runs through the outermost corner, which lies on x = 0 or x = length.
            t, s = tan(radians(web)), tan(radians(flange))
            leans = [y * t + z * s for y, z in corners(part.profile, part.section)]
            x_0 += max(leans) if side < 0 else min(leans)
        ends.append(RequiredEnd(side, web, flange, x_0, t, s))
    return ends[0], ends[1]


def _with_drawn(
    angles: tuple[float, float], part: Part, faces: Sequence[Face], least: float
) -> tuple[float, float]:
    """The header's angles of start and end; where they are 0 those that the outlines of one or two
    faces agree on."""
    if min(map(abs, angles)) >= least:
        return angles
    drawn = zip(*(_drawn(part, face) for face in faces), strict=True)
    agreed = (own[0] if max(own) - min(own) <= ANGLE_TOLERANCE_DEG else 0.0 for own in drawn)
    start, end = (a if abs(a) >= least else d for a, d in zip(angles, agreed, strict=True))
    return start, end


def _drawn(part: Part, face: Face) -> tuple[float, float]:
    """Angles of start and end as an outline has them; 0 where either is not a straight line."""
    outlines = [
        f for f in part.features if isinstance(f, Contour) and f.face == face and f.kind == "outer"
    ]
    if len(outlines) != 1 or not all(isinstance(c, Line) for c in outlines[0].curves):
        return 0.0, 0.0
    points = [c.start for c in outlines[0].curves]
    ys = [y for _, y in points]
    low, high = min(ys), max(ys)
    if high - low < OUTLINE_TOLERANCE:
        return 0.0, 0.0
    bottom = [x for x, y in points if y <= low + OUTLINE_TOLERANCE]
    top = [x for x, y in points if y >= high - OUTLINE_TOLERANCE]
    within = [p for p in points if low + OUTLINE_TOLERANCE < p[1] < high - OUTLINE_TOLERANCE]
    ends = (
        (min(bottom), min(top), [p for p in within if p[0] < part.length / 2]),
        (max(bottom), max(top), [p for p in within if p[0] > part.length / 2]),
    )
    for x_low, x_high, between in ends:
        for x, y in between:
            if abs(x - x_low - (x_high - x_low) * (y - low) / (high - low)) > OUTLINE_TOLERANCE:
                return 0.0, 0.0  # what is not sawn says nothing of the saw
    start, end = (degrees(atan2(a - b, high - low)) for a, b, _ in ends)
    return (
        start if abs(start) > ANGLE_TOLERANCE_DEG else 0.0,
        end if abs(end) > ANGLE_TOLERANCE_DEG else 0.0,
    )


# --- pieces ---------------------------------------------------------------------------------------


class CutPlane(Struct, frozen=True, gc=False):
    """Position of a cut in the bar: the middle of its slab."""

    cut: Cut
    web_deg: float  #: DSTV's angles
    flange_deg: float
    at_pivot: float  #: bar x on the pivot edge
    tan_web: float
    tan_flange: float
    half_kerf: float  #: along the bar

    def along(self, rise: float, z: float) -> float:
        """Bar x at a place of the section, `rise` above the pivot edge."""
        return self.at_pivot - rise * self.tan_web - z * self.tan_flange


class SawnPiece(Struct, frozen=True, gc=False):
    """The steel between two cuts."""

    start: CutPlane
    end: CutPlane


def planes(cuts: Sequence[Cut], saw: Saw, profile: Profile) -> list[CutPlane]:
    """The planes of the cuts in their order along the bar, by the middle of the section.

    A blade turned by w and then tilted by t has the normal (cos t cos w, cos t sin w, sin t),
    which is along (1, tan w, tan f), so tan f = tan t / cos w.
    """
    planes = []
    for cut in cuts:
        at, web = cut.x - saw.x, saw.angle_sign * (cut.angle - saw.zero_angle) + 0.0
        tan_web, tan_flange, kerf = 0.0, 0.0, saw.kerf
        if web or cut.tilt:
            tan_web = tan(radians(web))
            tan_flange = tan(radians(saw.tilt_sign * cut.tilt)) / cos(radians(web))
            if saw.kerf_along == "normal":
                kerf *= hypot(1.0, tan_web, tan_flange)
        flange = degrees(atan(tan_flange))
        planes.append(CutPlane(cut, web, flange, at, tan_web, tan_flange, kerf / 2))
    rise = (-0.5 if saw.pivot == "o" else 0.5) * profile.height
    planes.sort(key=lambda p: (p.along(rise, profile.width / 2), p.cut.line))
    return planes


def pieces(cuts: Sequence[CutPlane], bar: float | None = None) -> list[SawnPiece]:
    """The pieces between ordered planes, and before the end of a bar of known length.

    The bar's own end counts as a cut of line 0.
    """
    pieces = [SawnPiece(a, b) for a, b in pairwise(cuts)]
    if bar is not None and cuts:
        end = CutPlane(Cut(0, bar, nan, 0.0), 0.0, 0.0, bar, 0.0, 0.0, 0.0)
        pieces.append(SawnPiece(cuts[-1], end))
    return pieces


def overlapping(cuts: Sequence[CutPlane]) -> bool:
    """Whether a cut is made a second time, on what the blade has taken already."""
    return any(
        a.web_deg == b.web_deg
        and a.flange_deg == b.flange_deg
        and b.at_pivot - a.at_pivot < a.half_kerf
        for a, b in pairwise(cuts)
    )


# --- layout ---------------------------------------------------------------------------------------

# Which part each piece of the bar is: by its ends, and where those do not tell, by what is in it.
#
# With the order given the parts follow each other along the bar as they were named. Left free, each
# piece is the part that fits it best; turned ones may stand in any of their eight ways.


class LaidPart(Struct, frozen=True, gc=False):
    """A part on the bar."""

    part: Part
    given: int  #: index among the required parts
    ends: Ends
    start: float  #: bar x of its x 0
    piece: SawnPiece | None  #: None where its ends are not as they should be


#: How unlike a part is to what is there, if it lies so.
Faults = Callable[[LaidPart], tuple[int, int]]


def lay_out(
    pieces: Sequence[SawnPiece], parts: Sequence[Part], machine: Machine, saw: Saw, free: bool,
    turn: bool, faults: Faults,
) -> list[LaidPart]:  # fmt: skip
    """The parts that pieces are, from one end of the bar to the other.

    Those of which no piece has the ends are missing. `free` leaves the order to the program.
    """
    ways: dict[int, list[tuple[Part, Ends]]] = {}  #: by the identity of a part, how it may lie
    for part in parts:
        if id(part) not in ways:
            turned = orientations(part) if turn else [part]
            ways[id(part)] = [(way, ends_of(way, saw)) for way in turned]
    waiting = [*range(len(parts))]
    laid: list[LaidPart] = []
    for piece in pieces:
        choices: dict[int, int] = {}  #: each part that waits, several times or once
        for given in waiting if free else waiting[:1]:
            choices.setdefault(id(parts[given]), given)
        fitting = []
        for identity, given in choices.items():
            for part, ends in ways[identity]:
                start = _start_of(piece, part, ends, machine, saw)
                if start is not None:
                    fitting.append(LaidPart(part, given, ends, start, piece))
        if fitting:
            laid.append(min(fitting, key=faults) if len(fitting) > 1 else fitting[0])
            waiting.remove(laid[-1].given)
    return laid


def _start_of(piece: SawnPiece, part: Part, ends: Ends, machine: Machine, saw: Saw) -> float | None:
    """Bar x at which a part starts that has a piece's ends; None if it has others."""
    first, last = ends
    if not (is_of(piece.start, first, machine, saw) and is_of(piece.end, last, machine, saw)):
        return None
    height = part.profile.height
    start = piece.start.at_pivot - first.blade(saw, height)
    by_end = piece.end.at_pivot - last.blade(saw, height)
    if not piece.end.cut.line:
        by_end = piece.end.at_pivot - part.length
    return start if abs(start - by_end) <= machine.format.resolution + 1e-6 else None


def is_of(plane: CutPlane, end: RequiredEnd, machine: Machine, saw: Saw) -> bool:
    """Whether a cut has the angles of an end, to what the output can tell apart."""
    if not plane.cut.line:  # the end of the bar
        return end.square
    slack = 0.5 * 10.0**-machine.format.angle_decimals + 1e-6
    angle, tilt = end.saw_angles(saw)
    return abs(plane.cut.angle - angle) <= slack and abs(plane.cut.tilt - tilt) <= slack


def wedge_cuts(
    laid: Sequence[LaidPart], cuts: Sequence[CutPlane], machine: Machine, saw: Saw,
    bar: float | None,
) -> set[int] | None:  # fmt: skip
    """The lines of the square cuts that remove the wedge behind each skew end.

    None where one is missing. None is needed behind an end that is the next part's start too, and
    where the bar ends with the part; where the next part starts square, the cut that gives it its
    start is the one.
    """
    numbers: set[int] = set()
    place = {plane.cut.line: i for i, plane in enumerate(cuts)}
    for index, one in enumerate(laid):
        end = one.piece.end if one.piece is not None else None
        if end is None or one.ends[1].square:
            continue
        following = laid[index + 1] if index + 1 < len(laid) else None
        at = place[end.cut.line] + 1
        if following is not None and following.piece is not None:
            start = following.piece.start
            if start is end:
                continue
            if following.ends[0].square and start is cuts[at]:
                numbers.add(start.cut.line)
                continue
        x = one.start + one.part.length + one.ends[1].kerf(saw) / 2
        if at >= len(cuts) and following is None:
            # Nothing of the bar is left behind its last cut; of one of unknown length it may be.
            behind = x + one.ends[1].kerf(saw) / 2 + machine.format.resolution
            if bar is None or bar <= behind:
                continue
        square = RequiredEnd(1, 0.0, 0.0, 0.0)
        if at >= len(cuts) or not is_of(cuts[at], square, machine, saw):
            return None
        if abs(cuts[at].at_pivot - x) > machine.format.resolution + 1e-6:
            return None
        numbers.add(cuts[at].cut.line)
    return numbers
