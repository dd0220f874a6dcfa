"""Strokes that are the same for every hole, and the holes that they do not fit.

A spindle's `bottom` follows the depth of the hole, or the machine has one stroke for all of them:

    bottom = "depth + tip"      as deep as it has to be
    bottom = 150                to 150 mm, whatever the section: web holes of a HE 400 B lie deeper
"""

import re
from collections.abc import Iterator, Sequence

from beamcam.caches import PerObject
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Drill, Machine
from beamcam.model.part import Face, Feature, Hole, Part, Slot
from beamcam.model.plan import DrillOp
from beamcam.model.stroke import Strokes
from beamcam.planning import rules
from beamcam.planning.jobs import Job

_DEPTH = re.compile(r"\bdepth\b")


def _fixed_faces(machine: Machine) -> frozenset[Face]:
    """The faces of the spindles whose stroke does not follow the depth."""
    return frozenset(s.face for s in machine.spindles if not _DEPTH.search(s.stroke.bottom))


fixed_faces = PerObject("planning.fixed_faces", _fixed_faces)


def refuse_strokes(
    part: Part, machine: Machine, drill: Drill, jobs: Sequence[Job]
) -> Iterator[tuple[int, Diagnostic]]:
    """The features of jobs that a fixed stroke does not make, and why."""
    strokes = Strokes(part.profile, machine)
    resolution = machine.format.resolution
    for job in jobs:
        how = job.tooling
        for face in fixed_faces(machine).intersection(how.faces):
            op = DrillOp(job.x, 0, how.tools[0], (face,), job.y, how.depth, (), (), part.source)
            reach = _reach(op, part, strokes)
            least, greatest = _wanted(op, part, drill)
            if least - resolution <= reach <= greatest + resolution:
                continue
            for f in job.features:
                feature = part.features[f]
                expected = f"{least:.3f}" if least == greatest else f"at least {least:.3f}"
                yield f, rules.STROKE.at(
                    feature.source, what=named(feature), face=face, found=f"{reach:.3f}",
                    expected=expected,
                )  # fmt: skip


def _reach(op: DrillOp, part: Part, strokes: Strokes) -> float:
    """How deep the tool's point comes behind the surface of its face."""
    stroke = strokes(op, op.y)
    way = 1.0 if stroke.bottom >= stroke.start else -1.0
    return way * stroke.bottom - part.profile.face_depth(op.faces[0])


def _wanted(op: DrillOp, part: Part, drill: Drill) -> tuple[float, float]:
    """How deep it has to come, and may at most; drills and taps may go on behind the far side."""
    kind = op.tool.kind
    tip = op.tool.tip if kind == "drill" else 0.0
    if op.depth is not None:
        return op.depth + tip, op.depth + tip
    through = part.profile.thickness(op.faces[0]) + tip
    return through, float("inf") if kind in ("drill", "tap") else through + drill.breakthrough


def named(feature: Feature) -> str:
    """A feature that a spindle makes, as messages call it."""
    match feature:
        case Hole():
            return f"a hole of diameter {feature.diameter:g}"
        case Slot():
            return f"a slot of width {feature.diameter:g}"
        case _:
            return "a line to mark"
