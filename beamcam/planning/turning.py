"""A part turned on the rollers: the eight rotations that keep it along the bar, and no mirror.

Section axes are DSTV's (7th edition, page 7): X along the part, Y up the web from the u side, Z
across from the h side. A rotation that keeps the bar's axis maps the section's box to itself; it
is one of the eight signed exchanges of Y and Z, and the part is turned end for end exactly where
that exchange alone would mirror it, so that the determinant of the whole is always +1:

      o                u                 o                u              quarter turns
    h   v            v   h             v   h            h   v            likewise, with
      u                o                 u                o              v o h u for h v ...
    as given      about X 180        about Y 180      about Z 180
    X ->          X ->               X <-             X <-

A mirrored part is another part: no sequence of these turns gives it.
"""

from math import isclose
from typing import TypeVar

from msgspec import Struct
from msgspec.structs import asdict, replace

from beamcam.geometry.curves import Matrix
from beamcam.geometry.plane import mapped
from beamcam.model.part import (
    Bend,
    Camber,
    Contour,
    EndCuts,
    EndPlane,
    Face,
    Feature,
    Hole,
    Part,
    Plane,
    Profile,
    Slot,
    TextMark,
    Vector,
)
from beamcam.model.plan import AS_GIVEN


class Turn(Struct, frozen=True):
    """One of the eight rotations: where the section's axes go, and which end leads."""

    name: str
    swap: bool  #: whether Y and Z are exchanged, after the reversals
    reverse_y: bool  #: y becomes height - y
    reverse_z: bool  #: z becomes width - z

    @property
    def reverse_x(self) -> bool:
        """Whether x becomes length - x: where the section's map alone would mirror the part."""
        return self.swap ^ self.reverse_y ^ self.reverse_z

    @property
    def matrix(self) -> tuple[Vector, Vector, Vector]:
        """The rotation's matrix."""
        x, y, z = (-1.0 if r else 1.0 for r in (self.reverse_x, self.reverse_y, self.reverse_z))
        if self.swap:
            return (x, 0.0, 0.0), (0.0, 0.0, z), (0.0, y, 0.0)
        return (x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)


TURNS = (
    Turn(AS_GIVEN, False, False, False),
    Turn("turned 180 about its length", False, True, True),
    Turn("turned end for end", False, True, False),
    Turn("turned over, end for end", False, False, True),
    Turn("turned 90 about its length", True, True, False),
    Turn("turned 270 about its length", True, False, True),
    Turn("turned end for end and 90", True, False, False),
    Turn("turned end for end and 270", True, True, True),
)

#: Section codes and the turns of which each lies on the rollers as its DSTV axes have it; a section
#: of another code lies as given only.
_LIES: dict[str, frozenset[tuple[bool, bool, bool]]] = {
    code: frozenset(turns)
    for code, turns in {
        "I": [(False, a, b) for a in (False, True) for b in (False, True)],
        "B": [(False, a, b) for a in (False, True) for b in (False, True)],
        "M": [(s, a, b) for s in (False, True) for a in (False, True) for b in (False, True)],
        "U": [(False, False, False), (False, True, False)],
        "C": [(False, False, False), (False, True, False)],
        "T": [(False, False, False), (False, True, False)],
        "L": [(False, False, False), (True, False, False)],
        "RO": [(False, False, False), (False, True, False)],
        "RU": [(False, False, False), (False, True, False)],
    }.items()
}
_AS_GIVEN = frozenset({(False, False, False)})


def lies(profile: Profile, turn: Turn) -> bool:
    """Whether the turned section rests on the rollers as required for its kind.

    A U lies on its web with the trough up, an angle on its two legs, a T on its flange.
    """
    return (turn.swap, turn.reverse_y, turn.reverse_z) in _LIES.get(profile.code, _AS_GIVEN)


def turned(part: Part, turn: Turn) -> Part:
    """The same part in the machine's axes after a turn, features in order."""
    if turn.name == AS_GIVEN:
        return part
    mapper = _Mapper(part, turn)
    return replace(
        part,
        profile=mapper.profile(),
        cuts=mapper.cuts(),
        cut_lines=None if part.cut_lines is None else mapper.angles(part.cut_lines),
        features=tuple(mapper.feature(f) for f in part.features),
        planes=tuple(mapper.plane(p) for p in part.planes),
        section=tuple(
            replace(p, y=y, z=z)
            for p in part.section
            for _, y, z in (mapper.point((0.0, p.y, p.z)),)
        ),
    )


def alike(a: Part, b: Part, tolerance: float = 1e-6) -> bool:
    """Whether two parts are the same piece of steel in the same orientation.

    Only what is made counts: length, section, end cuts and features, in any order.
    """
    if a.profile.code != b.profile.code or len(a.features) != len(b.features):
        return False
    mine, theirs = _figures(a), _figures(b)
    return len(mine) == len(theirs) and all(
        p == q
        if isinstance(p, str) or isinstance(q, str)
        else isclose(p, q, rel_tol=0, abs_tol=tolerance)
        for p, q in zip(mine, theirs, strict=True)
    )


def _figures(part: Part) -> list[float | str]:
    """The numbers and words that say what a part is, in an order of their own."""
    p, c = part.profile, part.cuts
    size = [p.height, p.width, p.flange_thickness, p.web_thickness or 0.0]
    cuts = [c.web_start, c.web_end, c.flange_start, c.flange_end]
    rows = sorted(
        (_row(f) for f in part.features),
        key=lambda row: [(v, 0.0) if isinstance(v, str) else ("", round(v, 4)) for v in row],
    )
    return [part.length, *size, *cuts, *(value for row in rows for value in row)]


def _row(feature: Feature) -> list[float | str]:
    row: list[float | str] = [type(feature).__name__]
    if isinstance(feature, Contour):
        points = sorted(c.point(t) for c in feature.curves for t in (0.0, 0.5))
        bevels = sorted(v for b in feature.bevels for v in (b.angle, b.land))
        row += feature.face, feature.kind, feature.process
        return [*row, *(value for point in points for value in point), *bevels]
    turn = 360.0
    if isinstance(feature, Slot):
        turn = 90.0 if feature.length == feature.height else 180.0
    for name, value in asdict(feature).items():
        if name == "angle" and not isinstance(feature, Bend):
            row.append((value or 0.0) % turn)
        elif name not in ("source", "edge", "option"):
            row += value if isinstance(value, tuple) else [-1.0 if value is None else value]
    return row


Value = TypeVar("Value", float, int)


class _Mapper:
    """Maps everything of one part by one turn; it holds no more than those two."""

    def __init__(self, part: Part, turn: Turn) -> None:
        self._part, self._turn = part, turn
        profile = part.profile
        self._box = (part.length, profile.height, profile.width)
        self._faces = {
            face: self._face(axis, high)
            for face, axis, high in (
                ("v", 2, True), ("h", 2, False), ("o", 1, True), ("u", 1, False),
            )
        }  # fmt: skip

    def _face(self, axis: int, high: bool) -> tuple[Face, Matrix]:
        """The face after the turn, and the map of its coordinates (x, y of web; x, z of flange)."""
        turn, other = self._turn, 3 - axis
        reverse = (turn.reverse_x, turn.reverse_y, turn.reverse_z)
        stays_high = high ^ reverse[axis]
        to_axis = other if turn.swap else axis
        face = {(2, True): "v", (2, False): "h", (1, True): "o", (1, False): "u"}[
            to_axis, stays_high
        ]
        x = (-1.0, 0.0, self._box[0]) if reverse[0] else (1.0, 0.0, 0.0)
        q = (0.0, -1.0, self._box[other]) if reverse[other] else (0.0, 1.0, 0.0)
        return face, (x, q)

    def point(self, at: Vector) -> Vector:
        """A place in space."""
        reverse = (self._turn.reverse_x, self._turn.reverse_y, self._turn.reverse_z)
        x, y, z = (
            size - value if back else value
            for value, size, back in zip(at, self._box, reverse, strict=True)
        )
        return (x, z, y) if self._turn.swap else (x, y, z)

    def vector(self, along: Vector) -> Vector:
        """A direction in space."""
        return tuple(  # type: ignore[return-value]
            sum(m * v for m, v in zip(row, along, strict=True)) + 0.0 for row in self._turn.matrix
        )

    def profile(self) -> Profile:
        profile = self._part.profile
        if not self._turn.swap:
            return profile
        web = profile.web_thickness
        return replace(
            profile,
            height=profile.width,
            width=profile.height,
            flange_thickness=profile.flange_thickness if web is None else web,
            web_thickness=None if web is None else profile.flange_thickness,
        )

    def angles(self, four: tuple[Value, Value, Value, Value]) -> tuple[Value, Value, Value, Value]:
        """Values of web and flange, at start and end, in the order that they have then."""
        if self._turn.reverse_x:
            four = (four[1], four[0], four[3], four[2])
        return (four[2], four[3], four[0], four[1]) if self._turn.swap else four

    def cuts(self) -> EndCuts:
        """The angles as they are seen then: a slope changes its sign with x and with y."""
        cuts, turn = self._part.cuts, self._turn
        web = -1.0 if turn.reverse_x ^ turn.reverse_y else 1.0
        flange = -1.0 if turn.reverse_x ^ turn.reverse_z else 1.0
        four = (
            web * cuts.web_start + 0.0, web * cuts.web_end + 0.0,
            flange * cuts.flange_start + 0.0, flange * cuts.flange_end + 0.0,
        )  # fmt: skip
        return EndCuts(*self.angles(four))

    def feature(self, feature: Feature) -> Feature:
        match feature:
            case Hole() | Slot() | TextMark() | Camber():
                face, matrix = self._on(feature.face)
                x, y = mapped(matrix, (feature.x, feature.y))
                if isinstance(feature, Camber):
                    return replace(feature, face=face, x=x, y=y)
                angle = feature.angle
                if isinstance(feature, Slot | TextMark):
                    angle = self._angle(feature.face, feature.angle)
                return replace(feature, face=face, x=x, y=y, angle=angle, edge=self._edge(feature))
            case Contour():
                face, matrix = self._on(feature.face)
                return replace(
                    feature,
                    face=face,
                    curves=tuple(curve.transformed(matrix) for curve in feature.curves),
                    notches=tuple(
                        replace(n, corner=mapped(matrix, n.corner)) for n in feature.notches
                    ),
                    edge=self._edge(feature),
                )
            case Bend():
                # Both ends of the line are on face v, or h once it lies upside down.
                _, matrix = self._on("v")
                sign = -1.0 if self._turn.reverse_z else 1.0
                start, end = (mapped(matrix, p) for p in (feature.start, feature.end))
                return replace(feature, start=start, end=end, angle=sign * feature.angle)
            case EndPlane():
                return replace(
                    feature, point=self.point(feature.point), normal=self.vector(feature.normal)
                )

    def plane(self, plane: Plane) -> Plane:
        """A plane of its own turns with the part; what lies on it keeps its numbers."""
        return replace(
            plane,
            origin=self.point(plane.origin),
            along_x=self.point(plane.along_x),
            along_y=self.point(plane.along_y),
        )

    def _on(self, face: Face) -> tuple[Face, Matrix]:
        """The face after the turn and the map of its coordinates; own planes keep theirs."""
        return self._faces.get(face, (face, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))))

    def _angle(self, face: Face, angle: float) -> float:
        """An angle in the face's numbers."""
        _, ((along, _, _), (_, across, _)) = self._on(face)
        if along == across:
            return angle if along > 0 else (angle + 180.0 if angle <= 0 else angle - 180.0)
        return -angle + 0.0 if along > 0 else 180.0 - angle

    def _edge(self, feature: Hole | Slot | Contour | TextMark) -> str:
        """The edge that rolling tolerances count from, seen in the face's numbers."""
        _, (_, (_, across, _)) = self._on(feature.face)
        return {"u": "o", "o": "u"}.get(feature.edge, feature.edge) if across < 0 else feature.edge
