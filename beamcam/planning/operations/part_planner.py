"""Planning state of one part on one line: the limits of its work, and the results so far."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import inf
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Severity, error, note, warning
from beamcam.machine.machine import Layout, Machine, drill_of, saw_of
from beamcam.machine.stations import Drill, Saw
from beamcam.model.description import named
from beamcam.model.part import Face, Feature, Hole, Part, Profile, Slot
from beamcam.model.plan import Plan, WorkOp
from beamcam.model.section import NO_PLATE, OTHER_SIDE, lip_of
from beamcam.planning.axis_limits import travel_on
from beamcam.planning.operations.finished_part import Ends, FinishedPart
from beamcam.planning.operations.tools import (
    Found,
    Said,
    Settled,
    ToolLibrary,
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


Reached = Mapping[Face, SpindleReach]


def _clear_between(profile: Profile, face: Face) -> tuple[float, float]:
    """Range of y in which a tool reaches a face; unbounded where no flange is beside it."""
    if profile.code == "T" and face in ("o", "u"):  # its stem, over the flange
        return profile.web_thickness or 0.0, inf
    if face != "v" or profile.code not in ("I", "U", "C", "L"):
        return -inf, inf
    flange = profile.flange_thickness
    return flange, (inf if profile.code == "L" else profile.height - flange)


def reached_on(machine: Machine, part: Part) -> Reached:
    """The faces of a part that the machine's spindles reach: between the lips of a C too."""
    profile, out, lip = part.profile, NO_PLATE.get(part.profile.code, ()), lip_of(part)
    reached: dict[str, SpindleReach] = {
        s.face: SpindleReach(s.number, profile.face_width(s.face), *_clear_between(profile, s.face))
        for s in machine.spindles
        if s.face not in out
    }
    if "v" in reached and lip and lip > reached["v"].least:
        greatest = profile.height - lip
        reached["v"] = replace(reached["v"], least=lip, greatest=greatest, wall="lip")
    return reached


def refuse_face(shape: Hole | Slot, what: str, reached: Reached) -> Diagnostic:
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


class BarLine(Struct, frozen=True):
    """The machine data used in planning a bar."""

    machine: Machine
    saw: Saw
    drill: Drill
    layout: Layout
    library: ToolLibrary


def line_of(machine: Machine) -> BarLine:
    """The line of a machine. Raises TypeError if it has no layout."""
    layout = machine.needed(machine.layout, "layout")
    return BarLine(machine, saw_of(machine), drill_of(machine), layout, library_of(machine))


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

    def __init__(self, part: Part, ends: Ends, line: BarLine) -> None:
        self.part, self.ends, self.line = part, ends, line
        self.machine, self.library = line.machine, line.library
        self.finished = FinishedPart(part, ends, line.machine, line.drill)
        self.reached = reached_on(line.machine, part)
        self.travel = travel_on(line.machine, part.profile)
        #: Features that can be made, by kind of work, each on the face that it is made from.
        self.accepted: defaultdict[str, list[tuple[int, Any]]] = defaultdict(list)
        self.behind: set[int] = set()  #: features that are made from the other side of their wall
        self.steps: list[WorkingStep] = []
        self.told: list[Said] = []  #: remarks about features
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
        self.told.append((f, diagnostic))
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
                self.told.append(each)

    def refuse(self, found: Iterable[Said]) -> None:
        """Refuse features for what outweighs all that was found before, and drop their steps."""
        refused = dict(found)
        if refused:
            self.refused |= refused
            self.steps = [step for step in self.steps if refused.keys().isdisjoint(step.features)]

    def refuse_repeats(self) -> None:
        """Refuse the repeats of refused features too."""
        for f, each in [*self.settled.items()]:
            if each.like in self.refused:
                self.refused[f] = self.refused[each.like]
            if f in self.refused:
                del self.settled[f]

    @property
    def holes(self) -> Iterator[tuple[int, Hole]]:
        """The holes that are made, each once."""
        return (each for each in self.accepted["hole"] if each[0] not in self.settled)

    @property
    def remarks(self) -> Iterator[Diagnostic]:
        """Remarks on the features that are not refused."""
        return (diagnostic for f, diagnostic in self.told if f not in self.refused)


# --- kind -----------------------------------------------------------------------------------------

# The interface of a kind of work on a bar.
#
# Each is a `WorkKind` at the end of its section in a module of this package, and a row of
# `work.KINDS`. Messages that are errors refuse a feature, by the first of them; it may then be left
# out if its code is allowed by name.


Numbered = tuple[int, Any]  #: index of a feature, and the feature


def nothing(*_: Any) -> Iterator[Any]:
    """Of a kind that has nothing to say."""
    return iter(())


class WorkKind(Struct, frozen=True):
    """One kind of work."""

    name: str
    #: What the machine lacks for a feature; None if it has everything.
    needs: Callable[[Any, PartPlanner], Diagnostic | None]
    #: What is wrong with the place of a feature on the finished part, or odd.
    refusals: Callable[[Any, PartPlanner], Iterable[Diagnostic]] = nothing
    #: The steps of all its features of a part together.
    steps: Callable[[Sequence[Numbered], PartPlanner], Iterable[Found]] = nothing
    reasons: Mapping[str, str] = {}  #: explanations of its steps: stable code and text
    #: What might have been done instead of an operation, and why it was not.
    rejected: Callable[[WorkOp, Plan, Machine], Iterator[str]] = nothing
