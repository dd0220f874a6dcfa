"""Checks of what one table of a machine file names in another: spindles, faces, axes, processes."""

from collections.abc import Iterator, Set
from typing import get_args

from beamcam.machine.bodies import signed
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchProcess

Fault = tuple[str, object, str]  #: dotted key, what was found, what was expected

ACROSS = ("Y", "Z")  #: letters of a spindle's axes
OF_SAW = ("angle", "saw")  #: what only a saw has an axis for


def reference_faults(machine: Machine, left_behind: Set[str] = frozenset()) -> Iterator[Fault]:
    """Each key that names an entry of another table that is not there.

    Axes of a base stay in their registers where a file over it takes their station away:
    `left_behind` has `spindles` or `saw` for them.
    """
    yield from _axis_faults(machine, left_behind)
    yield from _tool_faults(machine)
    yield from _carrier_faults(machine)
    yield from _look_faults(machine)
    if machine.triggers is not None:
        for process, place in machine.triggers.outputs.items():
            if process not in get_args(TorchProcess):
                expected = f"one of {', '.join(get_args(TorchProcess))}"
                yield f"triggers.outputs.{process}", place, expected


def _axis_faults(machine: Machine, left_behind: Set[str]) -> Iterator[Fault]:
    numbers = {spindle.number for spindle in machine.spindles}
    known = ", ".join(map(str, sorted(numbers))) or "none, there are no spindles"
    names: set[str] = set()
    for index, axis in enumerate(machine.axes):
        key = f"axes.{index}"
        if axis.name in names:
            yield f"{key}.name", axis.name, "a name once"
        names.add(axis.name)
        if axis.spindle is None:
            if axis.moves in ACROSS and machine.stock == "beam":
                yield f"{key}.spindle", None, f"the number of a spindle: {known}"
            if axis.moves in OF_SAW and machine.saw is None and "saw" not in left_behind:
                yield f"{key}.moves", axis.moves, "another motion, or a [saw] table for it"
        elif axis.spindle not in numbers and "spindles" not in left_behind:
            yield f"{key}.spindle", axis.spindle, f"the number of a spindle: {known}"
        elif axis.moves not in ACROSS:
            yield f"{key}.moves", axis.moves, f"{' or '.join(ACROSS)}, which move a spindle"


def _tool_faults(machine: Machine) -> Iterator[Fault]:
    faces = {spindle.face for spindle in machine.spindles}
    for index, tools in enumerate(machine.tools):
        if machine.spindles and not faces.intersection(tools.faces):
            expected = f"a face that has a spindle: {', '.join(sorted(faces))}"
            yield f"tools.{index}.faces", list(tools.faces), expected


def _carrier_faults(machine: Machine) -> Iterator[Fault]:
    """Bodies that an axis in degrees carries along, or one in millimetres turns."""
    turning = {axis.name for axis in machine.axes if axis.moves == "angle"}
    for index, body in enumerate(machine.bodies):
        for field, carrier in zip(("x", "y", "z"), body.carriers, strict=False):
            if signed(carrier)[0] in turning:
                yield f"bodies.{index}.{field}", carrier, "an axis in millimetres"
        if body.turn and signed(body.turn)[0] not in turning:
            yield f"bodies.{index}.turn", body.turn, "an axis in degrees, which moves the angle"


def _look_faults(machine: Machine) -> Iterator[Fault]:
    torch = machine.torch
    if torch is None:
        return
    for name in torch.settings:
        if name not in torch.colours:
            known = ", ".join(torch.colours)
            yield f"torch.settings.{name}", name, f"a key of torch.colours: {known}"
