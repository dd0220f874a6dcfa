"""Bars whose parts lie as they are given, or each turned on the rollers as is best."""

from collections.abc import Collection, Sequence

from beamcam.errors import PlanError
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import Order, Plan
from beamcam.planning.beam import plan_bar
from beamcam.planning.stock import is_too_short


def plan_oriented(
    parts: Sequence[Part],
    machine: Machine,
    bar: float | None = None,
    skips: Collection[str] = (),
    order: Order = "given",
    turn: bool = False,
) -> Plan:
    """The plan of `plan_bar`; with `turn`, of the parts in the orientations that are best.

    Raises PlanError as `plan_bar` does; without `turn`, with the turn that would help.
    """
    if turn:
        from beamcam.planning.turn_choice import plan_turned

        return plan_turned(parts, machine, bar, skips, order)
    try:
        return plan_bar(parts, machine, bar, skips, order)
    except PlanError as error:
        if is_too_short(error.diagnostics):
            raise
        from beamcam.planning.turn_choice import turns_that_help

        raise PlanError([*error.diagnostics, *turns_that_help(parts, machine, skips)]) from error
