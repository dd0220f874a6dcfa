"""A hole checked against the finished part: the wall that it goes through after all cuts.

Along the part a wall ends at the two end planes. A hole lies wholly in it if its circle does on
both surfaces of the wall, so the plane that takes most counts:

          start plane  /           end plane
    v, h, o, u        / (  o  )   |           distance to the start, of the circle's edge:
                     /            |           (x - x_start(y)) / sqrt(1 + tan^2) - radius

Across it a wall ends at a free edge or at another wall, which may have a root fillet:

    u  |<- edge -> ( hole ) <- fillet -> )| web |( ...

"""

from collections.abc import Iterator
from math import hypot, inf

from msgspec import Struct

from beamcam.caches import BoundedCache, PerObject
from beamcam.errors import Diagnostic, Rule, Severity
from beamcam.machine.drill import Drill
from beamcam.machine.machine import Machine
from beamcam.model.part import Face, Hole, Part, Profile, Slot
from beamcam.model.section import Wall, free_edges, walls_beside
from beamcam.planning.axis_limits import fixed_faces
from beamcam.planning.operations.ends import Ends, wall_end

_E, _W = Severity.ERROR, Severity.WARNING

OFF_PART = Rule(
    "plan-off-part",
    _E,
    "found {what} at x {x}, y {y} on face {face} that reaches {out} mm beyond {where}; "
    "expected it wholly within the finished part",
    "A hole that an end cut or an edge cuts open is a mistake in the drawing, and the drill would "
    "run off. A hole in the wedge that a mitre cuts off is wasted.",
)
NEAR_EDGE = Rule(
    "plan-near-edge",
    _W,
    "found {what} at x {x}, y {y} on face {face}, {apart} mm from {where}; "
    "expected at least {expected} mm",
    "So little steel bends or breaks out beside the drill (`drill.min_edge_distance`).",
)
WALL = Rule(
    "plan-wall",
    _E,
    "found {what} at x {x}, y {y} on face {face}; "
    "expected it clear of the wall from y {least} to {greatest}",
    "Another wall of the section stands there, and the drill would run into it.",
)
FILLET = Rule(
    "plan-fillet",
    _E,
    "found {what} at x {x}, y {y} on face {face} where the root fillet is {found} mm high; "
    "expected at most {expected} mm, {because}",
    "The fillet makes the wall thicker than the stroke is deep, or is in the drill's way.",
)
NEAR_FILLET = Rule(
    "plan-near-fillet",
    _W,
    "found {what} at x {x}, y {y} on face {face}, {found}; expected at least {expected} mm from it",
    "A drill that meets the root fillet runs to one side (`drill.min_fillet_distance`).",
)
BLIND_DEPTH = Rule(
    "plan-blind-depth",
    _E,
    "found {what} of depth {found} at x {x}, y {y} on face {face}; "
    "expected at most {expected} mm, the thickness of the wall",
    "A blind hole ends in its wall. A depth of 0 is through.",
)
SHALLOW = Rule(
    "plan-blind-shallow",
    _E,
    "found {what} of depth {found} at x {x}, y {y} on face {face}; "
    "expected at least {expected} mm, which programs of the machine can say",
    "Nothing is left of such a depth in a program. A depth of 0 is through.",
)
RULES = (OFF_PART, NEAR_EDGE, WALL, FILLET, NEAR_FILLET, BLIND_DEPTH, SHALLOW)

TOLERANCE = 0.01  #: mm; files round to it, so a hole that is as near is tangent
OUTSIDE = ("o", "u", "h")  #: faces that a tool comes to from outside the section


class Across(Struct, frozen=True):
    """Walls and edges across the part on one face."""

    width: float
    walls: tuple[Wall, ...]
    free: tuple[bool, bool]  #: whether the wall ends at y 0, and at its width


class Along(Struct, frozen=True):
    """Ends of the wall behind one face, along the part: x = x0 - y * slope at either end."""

    start_x0: float
    start_slope: float
    end_x0: float
    end_slope: float
    start_slant: float  #: sqrt(1 + slope^2)
    end_slant: float

    def clear(self, x: float, y: float, radius: float) -> tuple[float, float]:
        """Steel between a circle and the start, and the end; negative if it is beyond."""
        start = (x - self.start_x0 + y * self.start_slope) / self.start_slant - radius
        end = (self.end_x0 - y * self.end_slope - x) / self.end_slant - radius
        return start, end


_walls: PerObject[Machine, BoundedCache[tuple[Profile, Face], Across]] = PerObject(
    "planning.machines", lambda _: BoundedCache("planning.walls")
)


class FinishedPart:
    """The part after its end cuts, as far as it limits holes."""

    def __init__(self, part: Part, ends: Ends, machine: Machine, drill: Drill) -> None:
        self.part, self._ends, self._drill = part, ends, drill
        self._machine = machine
        self._across: dict[Face, Across] = {}
        self._along: dict[Face, Along] = {}

    def across(self, face: Face) -> Across:
        """Walls and edges across the part on a face."""
        found = self._across.get(face)
        if found is None:
            known, key = _walls(self._machine), (self.part.profile, face)
            found = known.get(key) or known.keep(key, _across(*key))
            self._across[face] = found
        return found

    def along(self, face: Face) -> Along:
        """Ends of the wall behind a face."""
        found = self._along.get(face)
        if found is None:
            found = self._along[face] = _along(self._ends, face, self.part.profile)
        return found

    def judge(
        self, what: str, shape: Hole | Slot, circles: tuple[tuple[float, float], ...]
    ) -> Iterator[Diagnostic]:
        """Errors and remarks on a hole or slot, errors first.

        `circles` are the middles of its corner circles, of a hole its own.
        """
        radius, face = shape.diameter / 2, shape.face
        where = {"what": what, "x": f"{shape.x:g}", "y": f"{shape.y:g}", "face": face}
        across = self.across(face)
        low, high = min(y for _, y in circles) - radius, max(y for _, y in circles) + radius
        clear = [self.along(face).clear(x, y, radius) for x, y in circles]
        steel = [
            (min(s for s, _ in clear), "the start of the part"),
            (min(e for _, e in clear), "the end of the part"),
        ]
        for is_free, left in zip(across.free, (low, across.width - high), strict=True):
            if is_free:
                steel.append((left, f"the edge of face {face}"))
        left, place = min(steel)
        if left < -TOLERANCE:
            yield OFF_PART.at(shape.source, out=f"{-left:.3g}", where=place, **where)
            return
        for wall in across.walls:
            yield from self._beside(shape, low, high, wall, where)
        if shape.kind != "mark" and left < self._drill.min_edge_distance - TOLERANCE:
            yield NEAR_EDGE.at(
                shape.source, apart=f"{max(left, 0.0):.3g}", where=place,
                expected=f"{self._drill.min_edge_distance:g}", **where,
            )  # fmt: skip
        thickness = self.part.profile.thickness(face)
        step = self._machine.format.resolution
        if shape.depth is not None and shape.depth < step and shape.kind != "mark":
            yield SHALLOW.at(shape.source, found=f"{shape.depth:g}", expected=f"{step:g}", **where)
        if shape.depth is not None and shape.depth > thickness + TOLERANCE > TOLERANCE:
            yield BLIND_DEPTH.at(
                shape.source, found=f"{shape.depth:g}", expected=f"{thickness:g}", **where
            )

    def _deeper(self, face: Face) -> float:
        """Overtravel of a through hole behind its wall; a fixed stroke passes everything."""
        return inf if face in fixed_faces(self._machine) else self._drill.breakthrough

    def _beside(
        self, shape: Hole | Slot, low: float, high: float, wall: Wall, where: dict[str, str]
    ) -> Iterator[Diagnostic]:
        """Remarks on a hole and another wall beside it."""
        if high > wall.least + TOLERANCE and low < wall.greatest - TOLERANCE:
            yield WALL.at(
                shape.source, least=f"{wall.least:g}", greatest=f"{wall.greatest:g}", **where
            )
            return
        below = low < wall.least
        apart = (wall.least - wall.radius - high) if below else low - (wall.greatest + wall.radius)
        if apart >= self._drill.min_fillet_distance - TOLERANCE:
            return
        high_mm = wall.fillet_height(-apart)
        outside = shape.face in OUTSIDE or self.part.profile.code == "M"
        limit, because = self._drill.clearance, "the clearance of the rapid approach"
        if outside:
            limit, because = self._deeper(shape.face), "the breakthrough behind the wall"
        if high_mm > limit and shape.kind != "mark":
            yield FILLET.at(
                shape.source,
                found=f"{high_mm:.3g}",
                expected=f"{limit:g}",
                because=because,
                **where,
            )
            return
        found = f"{-apart:.3g} mm into" if apart < 0 else f"{apart:.3g} mm from"
        yield NEAR_FILLET.at(
            shape.source, found=f"{found} the root fillet",
            expected=f"{self._drill.min_fillet_distance:g}", **where,
        )  # fmt: skip


def _across(profile: Profile, face: Face) -> Across:
    """Walls and edges on a face."""
    return Across(profile.face_width(face), walls_beside(profile, face), free_edges(profile, face))


def _along(ends: Ends, face: Face, profile: Profile) -> Along:
    """The ends of the wall behind a face, each by the surface on which it takes most."""
    start, end = (wall_end(each, face, profile) for each in ends)
    return Along(
        start.greatest, start.slope, end.least, end.slope,
        hypot(1.0, start.slope), hypot(1.0, end.slope),
    )  # fmt: skip
