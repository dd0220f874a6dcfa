"""The settings of colours and layers: whether the machine can follow them, and their order."""

from collections.abc import Iterable, Iterator, Sequence

from beamcam.errors import Diagnostic
from beamcam.machine.faults import TABLE_CONTROLLERS
from beamcam.machine.machine import Machine
from beamcam.machine.torch import LayerSettings, Torch
from beamcam.model.plan import HATCH
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.outline import Shape

PLAIN = LayerSettings()


def rank(shape: Shape, torch: Torch) -> int:
    """The place in the order of work that the settings of a contour give it; 0 without any."""
    return torch.settings.get(shape.look, PLAIN).order


def refuse_settings(
    curves: Iterable[AssignedCurve], torch: Torch, machine: Machine
) -> list[Diagnostic]:
    """An error for each colour or layer in use with a power that the machine cannot follow."""
    if not torch.settings:
        return []
    first = {(w.look, w.process): w for w in reversed(list(curves)) if w.look}
    return [
        rules.LOOK_SETTING.at(
            w.source, key=f"map.{look}.power", found=f"{power:g}", why=why
        )
        for (look, process), w in sorted(first.items())
        if (power := torch.settings[look].power) is not None
        and (why := _why_no_power(machine, process))
    ]  # fmt: skip


def _why_no_power(machine: Machine, process: str) -> str | None:
    """Why a machine cannot run a process at a power; None if it can."""
    if machine.controller in TABLE_CONTROLLERS:
        return f"the tool of {machine.name} is on or off"
    words = getattr(machine.words, f"{process}_on")
    if any("{power}" in line for line in words):
        return None
    return f"words.{process}_on of {machine.name} has no {{power}}"


def refuse_overcuts(curves: Iterable[AssignedCurve], torch: Torch) -> Iterator[Diagnostic]:
    """An error for each colour or layer with an overcut that is not cut."""
    for look, process, w in {(w.look, w.process): (w.look, w.process, w) for w in curves}.values():
        if process != "cut" and torch.settings.get(look, PLAIN).overcut is not None:
            yield rules.LOOK_OVERCUT.at(w.source, key=look, found=process)


def is_one_way(shape: Shape, torch: Torch) -> bool:
    """Whether a shape is a line of a hatch that is followed as it is drawn."""
    own = torch.settings.get(shape.look, PLAIN)
    return own.hatch_one_way and shape.source.where == HATCH


def refuse_order(shapes: Sequence[Shape], torch: Torch) -> Iterator[Diagnostic]:
    """An error for the first contour whose turn is after one around it, or a mark's after a cut."""
    if not any(own.order for own in torch.settings.values()):
        return
    cuts = [shape for shape in shapes if shape.process == "cut"]
    earliest = min(cuts, key=lambda s: rank(s, torch), default=None)
    for shape in shapes:
        before = shapes[shape.parent] if shape.parent >= 0 else None
        if shape.process != "cut":
            before = earliest
        if before is not None and rank(before, torch) < rank(shape, torch):
            yield rules.LOOK_ORDER.at(
                shape.source, key=shape.look, found=rank(shape, torch), process=shape.process,
                other=before.source, expected=rank(before, torch),
            )  # fmt: skip
            return
