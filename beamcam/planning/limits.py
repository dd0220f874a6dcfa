"""What the machine's axes do not come to, by `min` and `max` of its `[[axes]]`.

    across the bar and along a stroke    follow from section, hole and tool: asked of each part
    the saw's rotation                   follows from the end of a part: asked of each part
    X, the stop or the pusher            follows from where the part lies: asked of the whole bar

An axis stands at the number that is written, so places are rounded before they are compared.
"""

from collections.abc import Iterator, Sequence
from math import inf
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import BoundedCache, PerObject
from beamcam.errors import Diagnostic
from beamcam.machine.machine import ControlledAxis, Machine, Saw
from beamcam.model.part import Face, Feature, Part, Profile
from beamcam.model.plan import DrillOp, Operation, PathOp, Piece, SawOp
from beamcam.model.stroke import Strokes
from beamcam.planning import rules
from beamcam.planning.jobs import Job, Tooling
from beamcam.planning.strokes import named


class Beyond(NamedTuple):
    """An axis that would have to go where it cannot."""

    axis: ControlledAxis
    place: float
    face: Face


class Room(Struct, frozen=True):
    """How the spindles of a machine stand on a section, and what was found of their strokes."""

    strokes: Strokes
    known: BoundedCache[tuple[object, ...], Beyond | None]


_UNKNOWN = Beyond(ControlledAxis("", "X", 0.0, 0.0), 0.0, "v")  #: not looked at yet


def _no_rooms(_: Machine) -> BoundedCache[Profile, Room]:
    return BoundedCache("planning.sections")


_rooms = PerObject("planning.machines", _no_rooms)


def refuse_beyond(
    part: Part, machine: Machine, jobs: Sequence[Job]
) -> Iterator[tuple[int, Diagnostic]]:
    """The features of jobs for which a spindle's axis cannot go far enough, and why."""
    rooms = _rooms(machine)
    room = rooms.get(part.profile) or rooms.keep(
        part.profile, Room(Strokes(part.profile, machine), BoundedCache("planning.strokes"))
    )
    known = room.known
    for job in jobs:
        how = job.tooling
        if not job.path and known.get((how.faces, how.tools, how.depth, job.y), _UNKNOWN) is None:
            continue  # as nearly all are
        # Of a path both sides, since every formula is a straight line in y.
        for y in _min_and_greatest([y for _, y in job.path]) if job.path else (job.y,):
            key = how.faces, how.tools, how.depth, y
            beyond = known.get(key, _UNKNOWN)
            if beyond is _UNKNOWN:
                beyond = known.keep(key, _beyond(how, y, part, machine, room.strokes))
            if beyond is not None:
                for f in job.features:
                    yield f, _said(part.features[f], beyond)


def _beyond(
    how: Tooling, y: float, part: Part, machine: Machine, strokes: Strokes
) -> Beyond | None:
    """The first axis that does not come to all places of a stroke; None if all do."""
    faces = {strokes.spindles[face].number: face for face in how.faces}
    for tool in how.tools:
        op = DrillOp(0.0, how.spindle, tool, how.faces, y, how.depth, (), (), part.source)
        stroke = strokes(op, y)
        across, along = strokes.axes(op)
        places = {across: (stroke.across,), along: (stroke.start, stroke.near, stroke.bottom)}
        for axis in machine.axes:
            if axis.spindle not in faces or (axis.moves != across and axis.moves != along):
                continue
            for place in places[axis.moves]:
                if not _comes_to(place, axis, machine):
                    return Beyond(axis, place, faces[axis.spindle])
    return None


def _said(feature: Feature, beyond: Beyond) -> Diagnostic:
    return rules.AXIS.at(
        feature.source, what=named(feature), face=beyond.face, axis=beyond.axis.name,
        found=f"{beyond.place:.3f}", expected=_range(beyond.axis),
    )  # fmt: skip


def refuse_bar(
    operations: Sequence[Operation], pieces: Sequence[Piece], machine: Machine
) -> Iterator[Diagnostic]:
    """The operations that the bar cannot be brought to, and why."""
    for axis in machine.axes:
        if axis.moves != "X":
            continue
        # The ends of all together first: nearly every bar is within reach.
        xs = [op.x for op in operations]
        xs += [x for op in operations if type(op) is PathOp for x, _ in op.path]
        if all(_comes_to(x, axis, machine) for x in _min_and_greatest(xs)):
            continue
        for op in operations:
            if not _is_moved_by(axis, op, machine):
                continue
            for x in _xs(op):
                if not _comes_to(x, axis, machine):
                    yield rules.STOP.at(
                        op.source, what=_work(op, pieces), axis=axis.name, found=f"{x:.3f}",
                        expected=_range(axis),
                    )  # fmt: skip


def _xs(op: Operation) -> tuple[float, ...]:
    """X of an operation; of a path the least and the greatest."""
    return _min_and_greatest([x for x, _ in op.path]) if isinstance(op, PathOp) else (op.x,)


def _is_moved_by(axis: ControlledAxis, op: Operation, machine: Machine) -> bool:
    """Whether an operation needs an axis along the bar: the bar's own, or its spindle's."""
    if axis.spindle is None:
        return True
    return not isinstance(op, SawOp) and any(
        spindle.number == axis.spindle and spindle.face in op.faces for spindle in machine.spindles
    )


def _work(op: Operation, pieces: Sequence[Piece]) -> str:
    """An operation as messages call it."""
    if isinstance(op, SawOp):
        return f"a cut of {pieces[op.pieces[0]].part.mark}"
    piece, feature = op.features[0]
    part = pieces[piece].part
    return f"{named(part.features[feature])} on face {op.faces[0]} of {part.mark}"


def turning_saw(saw: Saw, machine: Machine) -> Saw:
    """The saw with those of its angles that its axis turns to."""
    for axis in machine.axes:
        if axis.moves == "angle" and axis.spindle is None:
            least, greatest = _limits(axis)
            if least > saw.min_angle or greatest < saw.max_angle:
                least, greatest = max(least, saw.min_angle), min(greatest, saw.max_angle)
                return replace(saw, min_angle=least, max_angle=greatest)
    return saw


def _comes_to(place: float, axis: ControlledAxis, machine: Machine) -> bool:
    least, greatest = _limits(axis)
    return least <= round(place, machine.format.length_decimals) <= greatest


def _limits(axis: ControlledAxis) -> tuple[float, float]:
    least = -inf if axis.min is None else axis.min
    return least, inf if axis.max is None else axis.max


def _range(axis: ControlledAxis) -> str:
    if axis.max is None:
        return f"at least {axis.min:g}"
    return f"at most {axis.max:g}" if axis.min is None else f"{axis.min:g} to {axis.max:g}"


def _min_and_greatest(values: Sequence[float]) -> tuple[float, float]:
    return min(values), max(values)
