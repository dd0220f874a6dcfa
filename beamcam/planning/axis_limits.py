"""Positions out of the axes' travel, by `min` and `max` of `[[axes]]`.

    across the bar and along a stroke    follow from section, hole and tool: checked for each part
    the saw's rotation                   follows from the end of a part: checked for each part
    X, the stop or the pusher            follows from where the part lies: checked for the whole bar

An axis stands at the number that is written, so places are rounded before they are compared.

A spindle's `bottom` follows the depth of the hole, or the machine has one stroke for all of them,
which does not fit every hole:

    bottom = "depth + tip"      as deep as it has to be
    bottom = 150                to 150 mm, whatever the section: web holes of a HE 400 B lie deeper
"""

import re
from collections.abc import Iterator, Sequence
from math import inf

from msgspec import Struct

from beamcam.caches import BoundedCache, PerObject, PerObjectAndKey
from beamcam.errors import Diagnostic, Source, error
from beamcam.machine.machine import ControlledAxis, Machine, drill_of
from beamcam.model.cell_motion import StrokeGeometry
from beamcam.model.description import named
from beamcam.model.part import Face, Feature, Profile
from beamcam.model.plan import DrillOp, Operation, PathOp, Piece, SawOp, TextOp
from beamcam.planning.operations.tools import Said, Tooling, WorkingStep

STROKE = error("plan-stroke",
    "found a stroke to {found} mm below face {face}, the same for every hole; expected {expected} "
    "mm for {what}",
    "A stroke that is the same for every hole fits no blind hole, and through ones of small "
    "sections alone. A machine file whose `bottom` follows `depth` has no such limit.")  # fmt: skip
AXIS = error("plan-axis",
    "found {what} on face {face} that takes the {axis} to {found}; expected {expected}",
    "The axis does not reach that place across the bar, or that depth. `--allow-skips axis` leaves "
    "the feature to another machine.")  # fmt: skip
STOP = error("plan-stop",
    "found {what} that takes the {axis} to {found}; expected {expected}",
    "The position of a part on the bar decides how far the bar has to move; with a longer front "
    "trim, another order or a shorter bar it may be within reach.")  # fmt: skip


class Beyond(Struct, frozen=True):
    """An axis that would have to go where it cannot."""

    axis: ControlledAxis
    place: float
    face: Face


class SpindleTravel(Struct, frozen=True):
    """The spindles of a machine on one section: their strokes, and the axes' travel."""

    machine: Machine
    profile: Profile
    strokes: StrokeGeometry
    known: BoundedCache[tuple[object, ...], Beyond | None]  #: by tooling and place across


travel_on: PerObjectAndKey[Machine, Profile, SpindleTravel] = PerObjectAndKey(
    "planning.machines", "planning.sections",
    lambda machine, profile: SpindleTravel(
        machine, profile, StrokeGeometry(profile, machine), BoundedCache("planning.strokes")
    ),
)  # fmt: skip
_UNKNOWN = Beyond(ControlledAxis("", "X", 0.0, 0.0), 0.0, "v")  #: not looked at yet
_TRIAL = Source("")  #: of a stroke that is tried; no message names it


def refuse_steps(
    features: Sequence[Feature], steps: Sequence[WorkingStep], travel: SpindleTravel
) -> Iterator[Said]:
    """The features of steps that the axes of the spindles do not make, and why."""
    known = travel.known
    for step in steps:
        if step.text is not None:
            continue  # no spindle's axis takes part
        how = step.tooling
        # Of a path both sides, since every formula is a straight line in y.
        ys = [y for _, y in step.path] if step.path else (step.y,)
        for y in (min(ys), max(ys)) if step.path else ys:
            key = how.faces, how.tools, how.depth, y
            beyond = known.get(key, _UNKNOWN)
            if beyond is _UNKNOWN:
                beyond = known.keep(key, _beyond(how, y, travel))
            if beyond is None:
                continue
            for f in step.features:
                yield f, AXIS.at(
                    features[f].source, what=named(features[f]), face=beyond.face,
                    axis=beyond.axis.name, found=f"{beyond.place:.3f}",
                    expected=_range(beyond.axis),
                )  # fmt: skip
    if fixed_faces(travel.machine):
        # Drills and taps may go on behind the far side, other tools as far as the breakthrough.
        faces = fixed_faces(travel.machine)
        resolution = travel.machine.format.resolution
        for step in steps:
            how, tool = step.tooling, step.tooling.tools[0]
            for face in faces.intersection(how.faces) if step.text is None else ():
                op = DrillOp(step.x, 0, tool, (face,), step.y, how.depth, (), (), _TRIAL)
                stroke = travel.strokes(op, op.y)
                way = 1.0 if stroke.bottom >= stroke.retract else -1.0
                reach = way * stroke.bottom - travel.profile.face_depth(face)
                tip = tool.tip if tool.kind == "drill" else 0.0
                least = tip + (travel.profile.thickness(face) if op.depth is None else op.depth)
                greatest = least
                if op.depth is None:
                    goes_on = tool.kind in ("drill", "tap")
                    greatest += inf if goes_on else drill_of(travel.machine).breakthrough
                if least - resolution <= reach <= greatest + resolution:
                    continue
                expected = f"{least:.3f}" if least == greatest else f"at least {least:.3f}"
                for f in step.features:
                    yield f, STROKE.at(
                        features[f].source, what=named(features[f]), face=face,
                        found=f"{reach:.3f}", expected=expected,
                    )  # fmt: skip


def within_axes(
    how: Tooling, sides: tuple[float, float], travel: SpindleTravel
) -> tuple[float, float] | None:
    """Those y between two sides of a face to which the axes bring a tool; None if there are none.

    They are looked for in steps of a millimetre.
    """
    low, high = sides
    count = int(high - low)
    ys = [*(low + k for k in range(count + 1)), high]
    reached = [y for y in ys if _beyond(how, y, travel) is None]
    return (min(reached), max(reached)) if len(reached) > 1 else None


def _beyond(how: Tooling, y: float, travel: SpindleTravel) -> Beyond | None:
    """The first axis that does not come to all places of a stroke; None if all do."""
    machine, strokes = travel.machine, travel.strokes
    faces = {strokes.spindles[face].number: face for face in how.faces}
    for tool in how.tools:
        op = DrillOp(0.0, how.spindle, tool, how.faces, y, how.depth, (), (), _TRIAL)
        stroke = strokes(op, y)
        across, along = strokes.axes(op)
        places = {across: (stroke.across,), along: (stroke.retract, stroke.approach, stroke.bottom)}
        for axis in machine.axes:
            if axis.spindle not in faces or (axis.moves != across and axis.moves != along):
                continue
            least, greatest = axis.limits
            for place in places[axis.moves]:
                if not least <= round(place, machine.format.length_decimals) <= greatest:
                    return Beyond(axis, place, faces[axis.spindle])
    return None


def refuse_bar(
    operations: Sequence[Operation], pieces: Sequence[Piece], machine: Machine
) -> Iterator[Diagnostic]:
    """The operations that the bar cannot be brought to, and why."""
    for axis in machine.axes:
        if axis.moves != "X":
            continue
        # The bar's own axis takes part in every operation, that of a spindle in its strokes.
        faces = {spindle.face for spindle in machine.spindles if spindle.number == axis.spindle}
        (least, greatest), decimals = axis.limits, machine.format.length_decimals
        for op in operations:
            if axis.spindle is not None and (
                isinstance(op, SawOp | TextOp) or faces.isdisjoint(op.faces)
            ):
                continue
            xs = [x for x, _ in op.path] if type(op) is PathOp else [op.x]
            for x in (min(xs), max(xs)) if len(xs) > 1 else xs:
                if least <= round(x, decimals) <= greatest:
                    continue
                if isinstance(op, SawOp):
                    what = f"a cut of {pieces[op.pieces[0]].part.mark}"
                else:
                    part = pieces[op.features[0][0]].part
                    what = f"{named(part.features[op.features[0][1]])} on face {op.faces[0]}"
                    what += f" of {part.mark}"
                yield STOP.at(
                    op.source, what=what, axis=axis.name, found=f"{x:.3f}", expected=_range(axis)
                )


def _range(axis: ControlledAxis) -> str:
    if axis.max is None:
        return f"at least {axis.min:g}"
    return f"at most {axis.max:g}" if axis.min is None else f"{axis.min:g} to {axis.max:g}"


_DEPTH = re.compile(r"\bdepth\b")


#: The faces of the spindles whose stroke does not follow the depth.
fixed_faces: PerObject[Machine, frozenset[Face]] = PerObject(
    "planning.fixed_faces",
    lambda machine: frozenset(
        s.face for s in machine.spindles if not _DEPTH.search(s.stroke.bottom)
    ),
)
