"""Planning state of one part on one line: the limits of its work, and the results so far."""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import dist, hypot, inf
from operator import itemgetter
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Severity, error, note, warning
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Drill
from beamcam.model.description import named
from beamcam.model.part import Face, Feature, Hole, Part, Slot
from beamcam.model.section import NO_PLATE, OTHER_SIDE, lip_of
from beamcam.planning.axis_limits import travel_on
from beamcam.planning.operations.finished_part import NEAR_EDGE, TOLERANCE, Ends, FinishedPart
from beamcam.planning.operations.tools import (
    Found,
    Said,
    Settled,
    WorkingStep,
    library_of,
)
from beamcam.planning.rules import NO_SPINDLE

OFF_FACE = error("plan-off-face",
    "found a hole at x {x}, y {y} on face {face}; expected it within {length} x {width} mm",
    "A hole beyond its face is a mistake of the exporter; the drill would meet no "
    "steel.")  # fmt: skip
IN_THE_WAY = error("plan-reach",
    "found {what} at y {y} on face {face}; expected y from {least} to {greatest}, the {wall} is in "
    "the tool's way",
    "A tool that comes to the web between the flanges needs room beside them, and beside the lips "
    "of a C, which are as long as its weight per metre says, or 0.6 of the "
    "flange.")  # fmt: skip


class SpindleReach(Struct, frozen=True):
    """Reach of a spindle on a face of a section."""

    spindle: int  #: number
    width: float  #: of the face
    least: float  #: y between which nothing is in the tool's way
    greatest: float
    wall: str = "flange"  #: that is in its way beyond


def reached_on(machine: Machine, part: Part) -> dict[Face, SpindleReach]:
    """The faces of a part that the machine's spindles reach: between the lips of a C too."""
    profile, lip, reached = part.profile, lip_of(part), dict[Face, SpindleReach]()
    for spindle in machine.spindles:
        face = spindle.face
        least, greatest, wall = -inf, inf, "flange"
        if profile.code == "T" and face in ("o", "u"):  # its stem, over the flange
            least = profile.web_thickness or 0.0
        elif face == "v" and profile.code in ("I", "U", "C", "L"):
            least = profile.flange_thickness
            if lip > least:
                least, wall = lip, "lip"
            greatest = inf if profile.code == "L" else profile.height - least
        if face not in NO_PLATE.get(profile.code, ()):
            width = profile.face_width(face)
            reached[face] = SpindleReach(spindle.number, width, least, greatest, wall)
    return reached


def refuse_face(shape: Hole | Slot, what: str, reached: Mapping[Face, SpindleReach]) -> Diagnostic:
    """That no spindle comes to the face of a hole or slot."""
    expected = f"one of {', '.join(reached)}" if reached else "none, as the machine has no spindle"
    return NO_SPINDLE.at(shape.source, kind=what, found=shape.face, expected=expected)


def refuse_place(
    shape: Hole | Slot, x: float, y: float, part: Part, reach: SpindleReach
) -> Diagnostic | None:
    """Why a tool does not come to a circle of a hole or slot, about x and y; None if it does."""
    if not (0 <= x <= part.length and 0 <= y <= reach.width):
        return OFF_FACE.at(
            shape.source, x=f"{x:g}", y=f"{y:g}", face=shape.face, length=f"{part.length:g}",
            width=f"{reach.width:g}",
        )  # fmt: skip
    radius = shape.diameter / 2
    if not reach.least <= y - radius or not y + radius <= reach.greatest:
        return IN_THE_WAY.at(
            shape.source, what=f"a hole of diameter {shape.diameter:g}", y=f"{y:g}",
            face=shape.face, least=f"{reach.least + radius:g}",
            greatest=f"{min(reach.greatest, reach.width) - radius:g}", wall=reach.wall,
        )  # fmt: skip
    return None


# --- holes beside each other ----------------------------------------------------------------------

# Those of one wall that break into each other, or leave too little steel between them. They are
# walked in order of x, so that each looks only at those that may still touch it.


Placed = tuple[float, int, Hole]  #: x, index of the feature, and the hole: they sort along the part
Group = tuple[Placed, ...]
ROUNDING = 1e-9


def runs(holes: Group, limit: float) -> Iterator[Group]:
    """All holes, together those that lie within `limit` of the one before along x."""
    start = 0
    before = holes[0][0] if holes else 0.0
    for i, (x, _, _) in enumerate(holes):
        if x - before > limit:
            yield holes[start:i]
            start = i
        before = x
    if holes:
        yield holes[start:]


OVERLAP = error("plan-hole-overlap",
    "found {what} at x {x}, y {y} on face {face}, {apart} mm from {other} of {first}; expected at "
    "least {expected} mm between their middles",
    "A drill that breaks into another hole runs off or breaks. Two diameters at one place may be a "
    "stepped hole, of which the wider one is blind.")  # fmt: skip
TOO_NEAR = error("plan-too-near",
    "found a hole of diameter {found} on face {face} at x {x}, y {y}, {apart} mm from that of "
    "{first}; expected the same place, or one more than {expected} mm away",
    "Holes closer than the program's decimals can distinguish are one hole that was drawn twice, "
    "not quite at the same place.")  # fmt: skip
MANY_PAIRS = error("plan-hole-crowd",
    "found {found} pairs of holes that stand within {reach} mm of each other along the part, most "
    "of them about this one; expected at most {expected}",
    "So many holes do not stand beside each other on a wall: they are a drawing that was written "
    "again and again. Nothing else is said of them.")  # fmt: skip
#: that are compared; 20,000 holes of 18 mm all over a bar of 12 m have 1 of 2
MOST_PAIRS = 2_000_000
THREADS = ("thread", "left-thread")


def refuse_many_pairs(holes: Group, drill: Drill) -> Iterator[Said]:
    """The hole with most others behind it, where comparing each two of them would take minutes.

    The pairs are counted and not looked at.
    """
    if len(holes) * (len(holes) - 1) <= 2 * MOST_PAIRS:
        return  # were all of them beside each other
    of_face: dict[Face, list[Placed]] = defaultdict(list)
    for placed in holes:
        of_face[placed[2].face].append(placed)
    for group in of_face.values():
        reach = max(hole.diameter for _, _, hole in group) + drill.min_edge_distance
        along = [x for x, _, _ in group]
        counts = [bisect_right(along, x + reach) - i - 1 for i, x in enumerate(along)]
        if sum(counts) > MOST_PAIRS:
            _, f, hole = group[counts.index(max(counts))]
            yield (
                f,
                MANY_PAIRS.at(
                    hole.source, found=sum(counts), reach=f"{reach:g}", expected=MOST_PAIRS
                ),
            )


def judge_pairs(holes: Group, drill: Drill) -> Iterator[Said]:
    """For each hole that is too near an earlier one of the part its index, and what to say."""
    if len(holes) < 2:
        return
    steel = drill.min_edge_distance
    overlapping: set[int] = set()  # the first error about a hole is the one that refuses it
    furthest = max(hole.diameter for _, _, hole in holes) / 2 + steel
    for i, (x, f, hole) in enumerate(holes):
        face, y, radius = hole.face, hole.y, hole.diameter / 2
        reach = x + radius + furthest
        for j in range(i + 1, len(holes)):
            other_x, other_f, other = holes[j]
            if other_x >= reach:
                break
            if other.face != face:
                continue
            room = radius + other.diameter / 2
            dy = other.y - y
            if -room - steel < dy < room + steel:
                apart = hypot(other_x - x, dy)
                if apart < room + steel - TOLERANCE and max(f, other_f) not in overlapping:
                    pair = (holes[i], holes[j]) if f < other_f else (holes[j], holes[i])
                    for refusal in _judge_pair(*pair, apart, room, drill):
                        yield refusal
                        if refusal[1].severity is Severity.ERROR:
                            overlapping.add(refusal[0])


def _judge_pair(
    first: Placed, second: Placed, apart: float, room: float, drill: Drill
) -> Iterator[Said]:
    """Remarks on two holes, at the second of them."""
    (_, _, one), (_, f, hole) = first, second
    if apart <= drill.merge_tolerance and _is_one_work(one, hole):
        return
    values = {"what": named(hole), "x": f"{hole.x:g}", "y": f"{hole.y:g}", "face": hole.face}
    if apart < room - TOLERANCE:
        yield f, OVERLAP.at(
            hole.source, other=named(one), first=one.source, apart=f"{apart:.3g}",
            expected=f"{room:g}", **values,
        )  # fmt: skip
    elif "mark" not in (one.kind, hole.kind):
        yield f, NEAR_EDGE.at(
            hole.source, apart=f"{max(apart - room, 0.0):.3g}",
            where=f"{named(one)} of {one.source}",
            expected=f"{drill.min_edge_distance:g}", **values,
        )  # fmt: skip


def _is_one_work(one: Hole, other: Hole) -> bool:
    """Whether two holes about one middle are meant: a sink, a thread's drill, a stepped hole."""
    if "countersink" in (one.kind, other.kind):
        return True
    small, wide = sorted((one, other), key=lambda hole: hole.diameter)
    if small.diameter == wide.diameter:
        return False
    if wide.kind in THREADS:
        return small.kind in ("through", "blind")
    return wide.depth is not None and (small.depth is None or small.depth > wide.depth)


def refuse_too_near(holes: Group, resolution: float, drill: Drill) -> Iterator[Said]:
    """Of `holes`, sorted, those beside one of the same size that a program cannot tell apart.

    Each is refused for the first such one before it among the part's features. Written places are
    off by up to one `resolution` (a hole's, and that of the cut which the part starts at), so that
    of two places less than two of them apart either may be meant. Holes at the very same place are
    told apart by their depths.
    """
    if 2 * resolution <= drill.duplicate_tolerance:
        return  # what is as near as that is one hole, and there once
    limit = 2 * resolution + ROUNDING
    for run in runs(holes, limit):
        if len(run) == 1:
            continue
        seen: list[Hole] = []
        for _, f, hole in sorted(run, key=itemgetter(1)):
            for first in seen:
                off = max(abs(first.x - hole.x), abs(first.y - hole.y))
                alike = (first.face, first.diameter) == (hole.face, hole.diameter)
                if alike and 0.0 < off <= limit:
                    apart = dist((hole.x, hole.y), (first.x, first.y))
                    yield f, TOO_NEAR.at(
                        hole.source, found=f"{hole.diameter:g}", face=hole.face, x=f"{hole.x:g}",
                        y=f"{hole.y:g}", apart=f"{apart:.3g}", first=first.source,
                        expected=f"{2 * resolution:g}",
                    )  # fmt: skip
                    break
            seen.append(hole)


FROM_BEHIND = note("plan-from-behind",
    "found {what} at x {x}, y {y} on face {face}; it is made from face {other}",
    "A through hole is the same from either side of its wall, and no spindle reaches that "
    "face.")  # fmt: skip
ANGLE_FACE = warning("plan-angle-face",
    "found {what} at x {x}, y {y} on face {face} of an angle, which has faces v and u; it is made "
    "on face {other}",
    "An angle has one flange, whose outside is u. Exporters that take the section for a channel "
    "write its other side as o.")  # fmt: skip


class PartPlanner:
    """The one thing of planning that changes while it is looked at: the account of a part."""

    def __init__(self, part: Part, ends: Ends, machine: Machine) -> None:
        self.part, self.ends, self.machine = part, ends, machine
        self.library = library_of(machine)
        self.finished = FinishedPart(part, ends, machine)
        self.reached = reached_on(machine, part)
        self.travel = travel_on(machine, part.profile)
        #: Features that can be made, by kind of work, each on the face that it is made from.
        self.accepted: defaultdict[str, list[tuple[int, Any]]] = defaultdict(list)
        self.behind: set[int] = set()  #: features that are made from the other side of their wall
        self.steps: list[WorkingStep] = []
        self.remarks: list[Said] = []  #: remarks about features
        self.refused: dict[int, Diagnostic] = {}
        self.settled: dict[int, Settled] = {}

    def on_reached_face(self, f: int, feature: Feature) -> Feature:
        """A feature, or for a through hole that no spindle reaches the same on the other side."""
        if not isinstance(feature, (Hole, Slot)) or feature.face in self.reached:
            return feature
        face = OTHER_SIDE.get(self.part.profile.code, {}).get(feature.face, feature.face)
        if feature.depth is not None or feature.kind != "through" or face not in self.reached:
            return feature
        self.behind.add(f)
        is_angle = self.part.profile.code == "L" and feature.face == "o"
        diagnostic = (ANGLE_FACE if is_angle else FROM_BEHIND).at(
            feature.source, what=named(feature), x=f"{feature.x:g}", y=f"{feature.y:g}",
            face=feature.face, other=face,
        )  # fmt: skip
        self.remarks.append((f, diagnostic))
        return replace(feature, face=face)

    def number(self, faces: tuple[Face, ...]) -> int:
        """The program's number of a face's spindle, or of a pair of spindles."""
        if len(faces) == 1:
            return self.reached[faces[0]].spindle
        return next(p.number for p in self.machine.pairs if set(p.faces) == set(faces))

    def take(self, steps: Iterable[Found]) -> None:
        """Keep steps and remarks; of several errors about a feature the first refuses it."""
        for each in steps:
            if isinstance(each, WorkingStep):
                self.steps.append(each)
            elif isinstance(each, Settled):
                self.settled[each.feature] = each
            elif each[1].severity is Severity.ERROR:
                self.refused.setdefault(*each)
            else:
                self.remarks.append(each)

    @property
    def holes(self) -> Iterator[tuple[int, Hole]]:
        """The holes that are made, each once."""
        return (each for each in self.accepted["hole"] if each[0] not in self.settled)


Numbered = tuple[int, Any]  #: index of a feature, and the feature


def nothing(*_: Any) -> Iterator[Any]:
    """Of a kind that has nothing to say."""
    return iter(())


class WorkKind(Struct, frozen=True):
    """The interface of a kind of work on a bar: a row of `work.KINDS`.

    Messages that are errors refuse a feature, by the first of them; it may then be left out if its
    code is allowed by name.
    """

    name: str
    #: What the machine does not have for a feature; None if it has everything.
    needs: Callable[[Any, PartPlanner], Diagnostic | None]
    #: What is wrong with the place of a feature on the finished part, or odd.
    refusals: Callable[[Any, PartPlanner], Iterable[Diagnostic]] = nothing
    #: The steps of all its features of a part together.
    steps: Callable[[Sequence[Numbered], PartPlanner], Iterable[Found]] = nothing
    reasons: Mapping[str, str] = {}  #: explanations of its steps: stable code and text
