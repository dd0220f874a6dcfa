"""A hole checked against the finished part: the wall that it goes through after all cuts.

Along the part a wall ends at the two end planes. A hole lies wholly in it if its circle does on
both surfaces of the wall, so the plane that takes most counts:

          start plane  /           end plane
    v, h, o, u        / (  o  )   |           distance to the start, of the circle's edge:
                     /            |           (x - x_start(y)) / sqrt(1 + tan^2) - radius

Across it a wall ends at a free edge or at another wall, which may have a root fillet:

    u  |<- edge -> ( hole ) <- fillet -> )| web |( ...

"""

from collections.abc import Iterator, Sequence
from math import hypot, inf
from operator import attrgetter

from msgspec import Struct

from beamcam.caches import cached
from beamcam.errors import Diagnostic, Rule, error, warning
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Drill
from beamcam.model.description import named
from beamcam.model.part import Face, Hole, Part, Profile, Slot
from beamcam.model.section import Wall, free_edges, walls_beside
from beamcam.planning.axis_limits import fixed_faces
from beamcam.planning.operations.ends import Ends, wall_end

OFF_PART = error("plan-off-part",
    "found {what} at x {x}, y {y} on face {face} that reaches {out} mm beyond {where}; expected it "
    "wholly within the finished part",
    "A hole that an end cut or an edge cuts open is a mistake in the drawing, and the drill would "
    "run off. A hole in the wedge that a mitre cuts off is wasted.")  # fmt: skip
NEAR_EDGE = warning("plan-near-edge",
    "found {what} at x {x}, y {y} on face {face}, {apart} mm from {where}; expected at least "
    "{expected} mm",
    "So little steel bends or breaks out beside the drill "
    "(`drill.min_edge_distance`).")  # fmt: skip
WALL = error("plan-wall",
    "found {what} at x {x}, y {y} on face {face}; expected it clear of the wall from y {least} to "
    "{greatest}",
    "Another wall of the section stands there, and the drill would run into it.")  # fmt: skip
FILLET = error("plan-fillet",
    "found {what} at x {x}, y {y} on face {face} where the root fillet is {found} mm high; "
    "expected at most {expected} mm, {because}",
    "The fillet makes the wall thicker than the stroke is deep, or is in the drill's "
    "way.")  # fmt: skip
NEAR_FILLET = warning("plan-near-fillet",
    "found {what} at x {x}, y {y} on face {face}, {found}; expected at least {expected} mm from it",
    "A drill that meets the root fillet runs to one side "
    "(`drill.min_fillet_distance`).")  # fmt: skip
BLIND_DEPTH = error("plan-blind-depth",
    "found {what} of depth {found} at x {x}, y {y} on face {face}; expected at most {expected} mm, "
    "the thickness of the wall",
    "A blind hole ends in its wall. A depth of 0 is through.")  # fmt: skip
SHALLOW = error("plan-blind-shallow",
    "found {what} of depth {found} at x {x}, y {y} on face {face}; expected at least {expected} "
    "mm, which programs of the machine can say",
    "Nothing is left of such a depth in a program. A depth of 0 is through.")  # fmt: skip

TOLERANCE = 0.01  #: mm; files round to it, so a hole that is as near is tangent


class FaceEdges(Struct, frozen=True):
    """Walls and edges across the part on one face."""

    width: float
    walls: tuple[Wall, ...]
    free: tuple[bool, bool]  #: whether the wall ends at y 0, and at its width
    edge: str  #: in messages


class Border(Struct, frozen=True, gc=False):
    """A straight line at which the wall behind a face ends."""

    steel: float  #: between it and x 0, y 0 of the face
    per_x: float  #: and how much more for each mm of x
    per_y: float
    name: str  #: in messages


_name = attrgetter("name")


class FinishedPart:
    """The part after its end cuts, as far as it limits holes."""

    def __init__(self, part: Part, ends: Ends, machine: Machine, drill: Drill) -> None:
        self.part, self._ends, self._drill = part, ends, drill
        self._machine = machine
        self._across: dict[Face, FaceEdges] = {}
        self._borders: dict[Face, tuple[Border, ...]] = {}

    def across(self, face: Face) -> FaceEdges:
        """Walls and edges across the part on a face."""
        face_edges = self._across.get(face)
        if face_edges is None:
            face_edges = self._across[face] = _across(self.part.profile, face)
        return face_edges

    def steel(self, face: Face, points: Sequence[Point]) -> tuple[float, str]:
        """Steel between points and the nearest border of their wall, and which border that is.

        It is negative if a point is beyond. Of borders that are as near the first by name counts.
        """
        borders = self._borders.get(face)
        if borders is None:
            found = _borders(self.across(face), self._ends, face, self.part.profile)
            borders = self._borders[face] = tuple(sorted(found, key=_name))
        nearest, name = inf, ""
        for border in borders:
            for x, y in points:
                steel = border.steel + border.per_x * x + border.per_y * y
                if steel < nearest:
                    nearest, name = steel, border.name
        return nearest, name

    def judge(self, shape: Hole | Slot, middles: Sequence[Point]) -> list[Diagnostic]:
        """Errors and remarks on a hole or slot, errors first.

        `middles` are those of its corner circles, of a hole its own.
        """
        radius, drill = shape.diameter / 2, self._drill
        nearest, place = self.steel(shape.face, middles)
        left = nearest - radius
        if left < -TOLERANCE:
            return [_said(OFF_PART, shape, out=f"{-left:.3g}", where=place)]
        diagnostics: list[Diagnostic] = []
        ys = [y for _, y in middles]
        low, high = min(ys) - radius, max(ys) + radius
        for wall in self.across(shape.face).walls:
            apart = wall.apart(low, high)
            if apart < drill.min_fillet_distance - TOLERANCE:
                diagnostics.append(self._beside(shape, low, high, wall, apart))
        if shape.kind != "mark" and left < drill.min_edge_distance - TOLERANCE:
            apart_mm, expected = f"{max(left, 0.0):.3g}", f"{drill.min_edge_distance:g}"
            diagnostics.append(
                _said(NEAR_EDGE, shape, apart=apart_mm, where=place, expected=expected)
            )
        if shape.depth is not None:
            diagnostics += self._judge_depth(shape, shape.depth)
        return diagnostics

    def _judge_depth(self, shape: Hole | Slot, depth: float) -> Iterator[Diagnostic]:
        """Whether a blind hole is too shallow for the output, or deeper than its wall."""
        thickness = self.part.profile.thickness(shape.face)
        step = self._machine.format.resolution
        if depth < step and shape.kind != "mark":
            yield _said(SHALLOW, shape, found=f"{depth:g}", expected=f"{step:g}")
        if depth > thickness + TOLERANCE > TOLERANCE:
            yield _said(BLIND_DEPTH, shape, found=f"{depth:g}", expected=f"{thickness:g}")

    def _deeper(self, face: Face) -> float:
        """Overtravel of a through hole behind its wall; a fixed stroke passes everything."""
        return inf if face in fixed_faces(self._machine) else self._drill.breakthrough

    def _beside(
        self, shape: Hole | Slot, low: float, high: float, wall: Wall, apart: float
    ) -> Diagnostic:
        """The remark on a hole that is too near another wall, or in it."""
        if high > wall.least + TOLERANCE and low < wall.greatest - TOLERANCE:
            return _said(WALL, shape, least=f"{wall.least:g}", greatest=f"{wall.greatest:g}")
        high_mm = wall.fillet_height(-apart)
        profile = self.part.profile
        limit, because = self._drill.clearance, "the clearance of the rapid approach"
        is_outside = not profile.face_depth(shape.face)
        is_stem = profile.code == "T" and shape.face in ("o", "u")  # with fillets on both sides
        if is_outside or (is_stem and self._deeper(shape.face) < limit):
            limit, because = self._deeper(shape.face), "the breakthrough behind the wall"
        if high_mm > limit and shape.kind != "mark":
            return _said(
                FILLET, shape, found=f"{high_mm:.3g}", expected=f"{limit:g}", because=because
            )
        found = f"{-apart:.3g} mm into" if apart < 0 else f"{apart:.3g} mm from"
        expected = f"{self._drill.min_fillet_distance:g}"
        return _said(NEAR_FILLET, shape, found=f"{found} the root fillet", expected=expected)


def _said(rule: Rule, shape: Hole | Slot, **values: str) -> Diagnostic:
    """A message about a hole or slot."""
    return rule.at(
        shape.source, what=named(shape), x=f"{shape.x:g}", y=f"{shape.y:g}", face=shape.face,
        **values,
    )  # fmt: skip


@cached("planning.walls")
def _across(profile: Profile, face: Face) -> FaceEdges:
    """Walls and edges on a face."""
    return FaceEdges(
        profile.face_width(face), walls_beside(profile, face), free_edges(profile, face),
        f"the edge of face {face}",
    )  # fmt: skip


def _borders(across: FaceEdges, ends: Ends, face: Face, profile: Profile) -> Iterator[Border]:
    """The ends of the wall behind a face, each where it takes most, and its free edges."""
    start, end = (wall_end(each, face, profile) for each in ends)
    slant = hypot(1.0, start.slope)
    yield Border(-start.greatest / slant, 1 / slant, start.slope / slant, "the start of the part")
    slant = hypot(1.0, end.slope)
    yield Border(end.least / slant, -1 / slant, -end.slope / slant, "the end of the part")
    if across.free[0]:
        yield Border(0.0, 0.0, 1.0, across.edge)
    if across.free[1]:
        yield Border(across.width, 0.0, -1.0, across.edge)
