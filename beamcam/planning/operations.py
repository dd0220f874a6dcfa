"""The jobs of all pieces as operations at machine X, each with the tool that it is settled on."""

from collections.abc import Iterator, Sequence

from beamcam.machine.machine import Drill, Tool
from beamcam.model.plan import DrillOp, PathOp, Piece, SpindleOp
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
            tool = job.tools[0] if len(job.tools) == 1 else settled[job.tools]
            reasons = job.reasons
            if job.diameter:
                reasons = (drill_reason(tool, job), *reasons)
            features = tuple([(index, f) for f in job.features])
            if job.path:
                path = tuple((offset + x, y) for x, y in job.path)
                yield PathOp(
                    path[0][0], job.spindle, tool, job.faces, path, job.depth, features, reasons,
                    job.source,
                )  # fmt: skip
            else:
                yield DrillOp(
                    offset + job.x, job.spindle, tool, job.faces, job.y, job.depth, features,
                    reasons, job.source,
                )  # fmt: skip


def drill_reason(tool: Tool, job: Job) -> str:
    """Why a plain hole gets this drill."""
    if abs(tool.diameter - job.diameter) <= 1e-9:
        return "drill-exact"
    return "drill-nearest" if tool == job.tools[0] else "drill-twin"
