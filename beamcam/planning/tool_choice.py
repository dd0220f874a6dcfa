"""The jobs of all pieces as operations at machine X, each with the tool that it is settled on."""

from collections.abc import Iterator, Mapping, Sequence

from beamcam.machine.machine import Drill, Tool
from beamcam.model.plan import DrillOp, FeatureRef, PathOp, Piece, SpindleOp
from beamcam.planning.jobs import Tooling
from beamcam.planning.tools import Tools, settle
from beamcam.planning.work import Work


def spindle_operations(
    pieces: Sequence[Piece], works: Sequence[Work], drill: Drill
) -> Iterator[SpindleOp]:
    """One operation for each job, piece by piece."""
    chosen = _choose_tools({id(j.tooling): j.tooling for work in works for j in work.jobs})
    for index, (piece, work) in enumerate(zip(pieces, works, strict=True)):
        offset = drill.x + piece.start
        for job in work.jobs:
            how = job.tooling
            tool, reasons = chosen[id(how)]
            features: tuple[FeatureRef, ...] = ((index, job.features[0]),)
            if len(job.features) > 1:
                features = tuple([(index, f) for f in job.features])
            if job.path:
                path = tuple((offset + x, y) for x, y in job.path)
                yield PathOp(
                    path[0][0], how.spindle, tool, how.faces, path, how.depth, features, reasons,
                    job.source,
                )  # fmt: skip
            else:
                yield DrillOp(
                    offset + job.x, how.spindle, tool, how.faces, job.y, how.depth, features,
                    reasons, job.source,
                )  # fmt: skip


def _choose_tools(
    toolings: Mapping[int, Tooling],
) -> dict[int, tuple[Tool, tuple[str, ...]]]:
    """The tool of each tooling and the reasons for it."""
    settled: dict[Tools, Tool] = {}
    if any(len(how.tools) > 1 for how in toolings.values()):
        settled = settle({how.tools for how in toolings.values()})
    chosen = {}
    for key, how in toolings.items():
        tool = how.tools[0] if len(how.tools) == 1 else settled[how.tools]
        reasons = (drill_reason(tool, how), *how.reasons) if how.diameter else how.reasons
        chosen[key] = tool, reasons
    return chosen


def drill_reason(tool: Tool, how: Tooling) -> str:
    """Why a plain hole gets this drill."""
    if abs(tool.diameter - how.diameter) <= 1e-9:
        return "drill-exact"
    return "drill-nearest" if tool == how.tools[0] else "drill-twin"
