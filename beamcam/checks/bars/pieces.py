"""The pieces of a bar between its cuts.

    | trim |# piece 1 ######/ wedge | piece 2 ####|  rest

A cut is a slab as thick as the blade. Between two of them that follow each other along the bar lies
a piece of steel, which is a part if both its ends are those of the part. X counts on the pivot
edge of the saw; the plane of a cut is x = x_0 - y tan(web) - z tan(flange), in DSTV's angles.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise, product
from math import atan, atan2, cos, degrees, hypot, nan, radians, sin, tan

from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.bars.cuts import RequiredEnd, ends_of
from beamcam.checks.bars.stations import Cut
from beamcam.geometry.curves import Matrix, Point
from beamcam.geometry.plane import mapped
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Saw
from beamcam.model.part import (
    Contour,
    EndCuts,
    EndPlane,
    Face,
    Feature,
    Hole,
    Part,
    Profile,
    Slot,
    TextMark,
    Vector,
)


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
    """The planes of the cuts in their order along the bar, by the middle of the section."""
    rise = (-0.5 if saw.pivot == "o" else 0.5) * profile.height
    planes = [_plane(cut, saw) for cut in cuts]
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


def _plane(cut: Cut, saw: Saw) -> CutPlane:
    """The plane of a cut.

    A blade turned by w and then tilted by t has the normal (cos t cos w, cos t sin w, sin t),
    which is along (1, tan w, tan f), so tan f = tan t / cos w.
    """
    at = cut.x - saw.x
    web = saw.angle_sign * (cut.angle - saw.zero_angle)
    if not web and not cut.tilt:
        return CutPlane(cut, 0.0, 0.0, at, 0.0, 0.0, saw.kerf / 2)
    tan_web = tan(radians(web))
    tan_flange = tan(radians(saw.tilt_sign * cut.tilt)) / cos(radians(web))
    kerf = saw.kerf * hypot(1.0, tan_web, tan_flange) if saw.kerf_along == "normal" else saw.kerf
    return CutPlane(cut, web, degrees(atan(tan_flange)), at, tan_web, tan_flange, kerf / 2)


# --- layout ---------------------------------------------------------------------------------------

# Which part each piece of the bar is: by its ends, and where those do not tell, by what is in it.
#
# With the order given the parts follow each other along the bar as they were named. Left free, each
# piece is the part that fits it best; turned ones may stand in any of their eight ways.


class Candidate(Struct, frozen=True, gc=False):
    """A possible orientation of a part on the bar."""

    part: Part
    given: int  #: index among the required parts
    ends: tuple[RequiredEnd, RequiredEnd]


class LaidPart(Struct, frozen=True, gc=False):
    """A part found on the bar."""

    part: Part
    given: int
    ends: tuple[RequiredEnd, RequiredEnd]
    start: float  #: bar x of its x 0
    piece: SawnPiece | None  #: None where its ends are not as they should be


#: By the identity of a part: how it may lie, each way with its ends.
Ways = dict[int, list[tuple[Part, tuple[RequiredEnd, RequiredEnd]]]]
#: How unlike a part is to what is there if it starts at a bar x.
Faults = Callable[[Candidate, float], tuple[int, int]]


def lay_out(
    pieces: Sequence[SawnPiece], parts: Sequence[Part], machine: Machine, saw: Saw, free: bool,
    turn: bool, faults: Faults,
) -> list[LaidPart]:  # fmt: skip
    """The parts that pieces are, from one end of the bar to the other.

    Those of which no piece has the ends are missing. `free` leaves the order to the program.
    """
    ways: Ways = {}
    waiting = [_candidates(part, i, saw, turn, ways) for i, part in enumerate(parts)]
    laid: list[LaidPart] = []
    for piece in pieces:
        if not waiting:
            break
        choices = waiting if free else waiting[:1]
        fitting = [
            (candidate, start)
            for candidate in _distinct(choices)
            if (start := start_of(piece, candidate, machine, saw)) is not None
        ]
        if not fitting:
            continue
        best = fitting[0]
        if len(fitting) > 1:
            best = min(fitting, key=lambda one: faults(one[0], one[1]))
        candidate, start = best
        laid.append(LaidPart(candidate.part, candidate.given, candidate.ends, start, piece))
        waiting = [c for c in waiting if c[0].given != candidate.given]
    return laid


def _candidates(part: Part, given: int, saw: Saw, turn: bool, known: Ways) -> list[Candidate]:
    """The possible orientations of a part."""
    if id(part) not in known:
        ways = orientations(part) if turn else [part]
        known[id(part)] = [(way, ends_of(way, saw)) for way in ways]
    return [Candidate(way, given, ends) for way, ends in known[id(part)]]


def _distinct(choices: Sequence[Sequence[Candidate]]) -> list[Candidate]:
    """The candidates, each part that is there several times once."""
    seen: set[int] = set()
    kept = []
    for ways in choices:
        for way in ways:
            if id(way.part) not in seen:
                seen.add(id(way.part))
                kept.append(way)
    return kept


def start_of(piece: SawnPiece, candidate: Candidate, machine: Machine, saw: Saw) -> float | None:
    """Bar x at which a part starts that has a piece's ends; None if it has others."""
    first, last = candidate.ends
    if not (is_of(piece.start, first, machine, saw) and is_of(piece.end, last, machine, saw)):
        return None
    height = candidate.part.profile.height
    start = piece.start.at_pivot - first.blade(saw, height)
    by_end = piece.end.at_pivot - last.blade(saw, height)
    if not piece.end.cut.line:
        by_end = piece.end.at_pivot - candidate.part.length
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
        if at >= len(cuts) and following is None and _ends_with(bar, x, one, machine, saw):
            continue
        square = RequiredEnd(1, 0.0, 0.0, 0.0)
        if at >= len(cuts) or not is_of(cuts[at], square, machine, saw):
            return None
        if abs(cuts[at].at_pivot - x) > machine.format.resolution + 1e-6:
            return None
        numbers.add(cuts[at].cut.line)
    return numbers


def _ends_with(bar: float | None, x: float, last: LaidPart, machine: Machine, saw: Saw) -> bool:
    """Whether nothing of a bar is left behind its last cut; of one of unknown length it may be."""
    return bar is None or bar <= x + last.ends[1].kerf(saw) / 2 + machine.format.resolution


# --- orientations ---------------------------------------------------------------------------------

# A part in the machine's axes, in each possible orientation on the rollers.
#
# Section axes are DSTV's (7th edition, page 7): X along the part, Y up the web from the u side, Z
# across from the h side. Eight rotations keep the bar along X: the signed exchanges of Y and Z, X
# reversed where the exchange alone would mirror the part. Every place is put into these axes,
# rotated about the middle of the section's box, and read off the face that it comes to lie on.

Rotation = tuple[Vector, Vector, Vector]  #: rows of the matrix

AS_IT_IS: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

#: Normals of the faces that look out of a part, in section axes.
NORMALS: dict[Face, Vector] = {
    "v": (0.0, 0.0, 1.0), "h": (0.0, 0.0, -1.0), "o": (0.0, 1.0, 0.0), "u": (0.0, -1.0, 0.0),
}  # fmt: skip
_FACES = {normal: face for face, normal in NORMALS.items()}


def rotations() -> Iterator[Rotation]:
    """The eight rotations that map the bar's axis to itself."""
    for swap, y, z in product((False, True), (1.0, -1.0), (1.0, -1.0)):
        x = y * z * (-1.0 if swap else 1.0)  # so that the determinant is +1
        if swap:
            yield (x, 0.0, 0.0), (0.0, 0.0, y), (0.0, z, 0.0)
        else:
            yield (x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)


ROTATIONS = tuple(rotations())


def orientations(part: Part) -> Iterator[Part]:
    """The part as given, and in every other orientation that its section allows."""
    yield part
    for rotation in ROTATIONS:
        if rotation != AS_IT_IS and _lies_alike(part.profile, rotation):
            yield rotated(part, rotation)


def _lies_alike(profile: Profile, rotation: Rotation) -> bool:
    """Whether a section rests on the rollers as its kind does, after a rotation.

    A U or C lies on its web, its trough up, a T on its flange, an angle on its two legs.
    """
    _, (_, y, _), (_, _, z) = rotation
    swapped = y == 0.0
    match profile.code:
        case "M":
            return True
        case "I" | "B":
            return not swapped
        case "U" | "C" | "T" | "RO" | "RU":
            return z == 1.0
        case "L":
            return swapped and rotation[1][2] == rotation[2][1] == 1.0
    return False


def rotated(part: Part, rotation: Rotation) -> Part:
    """The part after a rotation; bends and cambers, which no bar's program makes, as they are."""
    return replace(
        part,
        profile=_profile(part.profile, rotation),
        cuts=_cuts(part.cuts, rotation),
        features=tuple(_feature(f, part, rotation) for f in part.features),
    )


def _profile(profile: Profile, rotation: Rotation) -> Profile:
    if rotation[1][1] != 0.0:
        return profile
    web = profile.web_thickness
    return replace(
        profile,
        height=profile.width,
        width=profile.height,
        flange_thickness=profile.flange_thickness if web is None else web,
        web_thickness=None if web is None else profile.flange_thickness,
    )


def _cuts(cuts: EndCuts, rotation: Rotation) -> EndCuts:
    """The angles of the end planes, whose normals are (1, tan web, tan flange)."""
    ends: dict[bool, tuple[float, float]] = {}
    for at_start, web, flange in (
        (True, cuts.web_start, cuts.flange_start),
        (False, cuts.web_end, cuts.flange_end),
    ):
        x, y, z = _apply(rotation, (1.0, tan(radians(web)), tan(radians(flange))))
        # A leading end that looks back afterwards is the trailing one.
        ends[at_start ^ (x < 0)] = (degrees(atan2(y / x, 1.0)), degrees(atan2(z / x, 1.0)))
    (web_start, flange_start), (web_end, flange_end) = ends[True], ends[False]
    return EndCuts(web_start + 0.0, web_end + 0.0, flange_start + 0.0, flange_end + 0.0)


def _feature(feature: Feature, part: Part, rotation: Rotation) -> Feature:
    if isinstance(feature, EndPlane):
        normal = _apply(rotation, feature.normal)
        return replace(feature, point=_point(feature.point, part, rotation), normal=normal)
    if not isinstance(feature, Hole | Slot | Contour | TextMark) or feature.face not in NORMALS:
        return feature
    face, matrix = _map(feature.face, part, rotation)
    if isinstance(feature, Contour):
        return replace(
            feature, face=face, curves=tuple(c.transformed(matrix) for c in feature.curves)
        )
    x, y = mapped(matrix, (feature.x, feature.y))
    if isinstance(feature, Hole):
        return replace(feature, face=face, x=x, y=y)
    turn = radians(feature.angle)
    (a, b, _), (d, e, _) = matrix
    along = a * cos(turn) + b * sin(turn), d * cos(turn) + e * sin(turn)
    return replace(feature, face=face, x=x, y=y, angle=degrees(atan2(along[1], along[0])))


def _map(face: Face, part: Part, rotation: Rotation) -> tuple[Face, Matrix]:
    """The face after the rotation, and the map of the coordinates to that face."""
    after = _FACES[_apply(rotation, NORMALS[face])]

    def place(x: float, y: float) -> Point:
        at = (x, y, 0.0) if face in ("v", "h") else (x, 0.0, y)
        px, py, pz = _point(at, part, rotation)
        return px, py if after in ("v", "h") else pz

    (x0, y0), (x1, y1), (x2, y2) = place(0.0, 0.0), place(1.0, 0.0), place(0.0, 1.0)
    return after, ((round(x1 - x0), round(x2 - x0), x0), (round(y1 - y0), round(y2 - y0), y0))


def _point(at: Vector, part: Part, rotation: Rotation) -> Vector:
    """Where a place of the part is after the rotation about the middle of its box."""
    profile = part.profile
    middle = (part.length / 2, profile.height / 2, profile.width / 2)
    (mx, my, mz), (dx, dy, dz) = middle, (abs(c) for c in _apply(rotation, middle))
    x, y, z = _apply(rotation, (at[0] - mx, at[1] - my, at[2] - mz))
    return x + dx, y + dy, z + dz


def _apply(rotation: Rotation, v: Vector) -> Vector:
    x, y, z = (r[0] * v[0] + r[1] * v[1] + r[2] * v[2] + 0.0 for r in rotation)
    return x, y, z
