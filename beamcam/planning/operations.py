"""The jobs of all pieces as operations at machine X, each with the tool that it is settled on."""

from collections.abc import Iterator, Sequence

from beamcam.machine.machine import Drill, Tool
from beamcam.model.plan import DrillOp, FeatureRef, PathOp, Piece, SpindleOp
from beamcam.planning.tools import Tools, settle
from beamcam.planning.work import Job, Work


def spindle_operations(
    pieces: Sequence[Piece], works: Sequence[Work], drill: Drill
) -> Iterator[SpindleOp]:
    """One operation for each job, piece by piece."""
    several = {job.tools for work in works for job in work.jobs if len(job.tools) > 1}
    settled: dict[Tools, Tool] = {}
    if several:
        alone = {job.tools for work in works for job in work.jobs if len(job.tools) == 1}
        settled = settle(several | alone)
    for index, (piece, work) in enumerate(zip(pieces, works, strict=True)):
        offset = drill.x + piece.start
        for job in work.jobs:
            x, y, spindle, tools, faces, depth, diameter, made, reasons, source, relative = job
            tool = tools[0] if len(tools) == 1 else settled[tools]
            if diameter:
                reasons = (drill_reason(tool, job), *reasons)
            features: tuple[FeatureRef, ...] = ((index, made[0]),)
            if len(made) > 1:
                features = tuple([(index, f) for f in made])
            if relative:
                path = tuple((offset + a, b) for a, b in relative)
                yield PathOp(
                    path[0][0], spindle, tool, faces, path, depth, features, reasons, source
                )
            else:
                yield DrillOp(offset + x, spindle, tool, faces, y, depth, features, reasons, source)


def drill_reason(tool: Tool, job: Job) -> str:
    """Why a plain hole gets this drill."""
    if abs(tool.diameter - job.diameter) <= 1e-9:
        return "drill-exact"
    return "drill-nearest" if tool == job.tools[0] else "drill-twin"
