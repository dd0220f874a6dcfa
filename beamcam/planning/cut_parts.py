"""Parts that come in cut, for a line without a saw: each is a bar by itself."""

from collections.abc import Sequence

from beamcam.errors import Diagnostic, PlanError
from beamcam.model.part import Part
from beamcam.model.plan import Bar
from beamcam.planning import rules
from beamcam.planning.operations.line import BarLine


def lay_cut_part(
    parts: Sequence[Part], line: BarLine
) -> tuple[tuple[tuple[float, ...], Bar], tuple[Diagnostic, ...]]:
    """The start of the only part, its account as a bar, and remarks.

    Raises PlanError for several parts, and for one that the machine cannot hold.
    """
    layout, machine = line.layout, line.machine
    first = parts[0]
    if len(parts) > 1:
        raise PlanError(rules.NO_SAW.at(first.source, found=len(parts), machine=machine.name))
    length = first.length
    if length < layout.min_bar:
        said = rules.BAR_SHORT.at(
            first.source, found=f"{length:.3f}", expected=f"{layout.min_bar:g}"
        )
        raise PlanError(said)
    if layout.max_bar is not None and length > layout.max_bar:
        said = rules.BAR_LONG.at(
            first.source, found=f"{length:.3f}", expected=f"{layout.max_bar:g}"
        )
        raise PlanError(said)
    account = Bar(length, 0.0, length, 0.0, 0.0)
    remark = rules.COMES_CUT.at(first.source, found=f"{length:.3f}", machine=machine.name)
    return ((0.0,), account), (remark,)
