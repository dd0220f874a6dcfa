"""Keys of a torch and of the table under it that contradict others, or with which no program could
be written and read back.
"""

import re
from collections import Counter
from collections.abc import Iterator
from math import sqrt

from msgspec.structs import fields

from beamcam.machine.faults import Fault, carries
from beamcam.machine.machine import Machine
from beamcam.machine.tables import DIALECTS, STEP_FORMS, TABLE_CONTROLLERS, TableDialect, Triggers
from beamcam.machine.torch import KERF_STEPS, Torch

#: Words that a machine with a torch cannot do without.
_TORCH_WORDS = ("traverse", "feed", "cut_on", "cut_off")
#: Words that come in pairs.
_PAIRS = (
    ("slow", "full"), ("arc_cw", "arc_ccw"), ("ellipse_cw", "ellipse_ccw"), ("left", "right"),
)  # fmt: skip
MIN_CROSS = 1.0  #: mm of a cross that marks a centre, if there is one
GAPS = 4.0  #: gaps that a cross is long at least, so that its lines are not closed


def torch_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a torch, or of a stepper table, that contradicts another."""
    yield from table_faults(machine)
    torch, words = machine.torch, machine.words
    if torch is None:
        return
    yield from _height_faults(machine, torch)
    yield from _path_faults(machine, torch)
    worded = machine.controller not in TABLE_CONTROLLERS
    for name in _TORCH_WORDS if worded else ():
        if not getattr(words, name):
            yield f"words.{name}", "a template, since there is a torch"
    for one, other in _PAIRS:
        if bool(getattr(words, one)) != bool(getattr(words, other)):
            yield f"words.{one}", f"both {one} and {other}, or neither"
    step = machine.format.resolution
    if torch.tolerance < step:
        yield "torch.tolerance", f"at least {step:g}, the step of its numbers"
    yield from _row_faults(machine, torch, worded)
    if torch.kerf_by == "machine" and not words.left:
        yield "torch.kerf_by", "none or offset, as there are no words for left"
    if torch.bevel == "head":
        yield "torch.bevel", "refuse or square, since no torch that tilts is known yet"
    if torch.drilled == "mark" and not torch.cross:
        yield "torch.cross", "the size of the cross that marks a centre for the drill"
    if 0.0 < torch.cross < (least := max(MIN_CROSS, GAPS * torch.gap)):
        yield "torch.cross", f"0, or at least {least:g} mm"
    if torch.drilled == "mark" and not any(row.process == "mark" for row in torch.rows):
        yield "torch.drilled", "refuse, as no row marks"
    if torch.drilled == "spot" and not (worded and words.spot_on and words.spot_off):
        yield "torch.drilled", "refuse or mark, as there are no words of spot_on"
    if torch.origin != "table" and not worded:
        yield "torch.origin", "table, from whose corner the controller counts"
    if torch.overscan and not (torch.laser_mode and carries(words.power, "power")):
        yield "torch.overscan", "0, or laser_mode and {power} in words.power"
    for key in ("hole_overcut", "hole_lead"):
        if getattr(torch, key) not in (None, "lead") and not worded:
            yield f"torch.{key}", "nothing, as the table does not run G-code"
    least = min((row.power for row in torch.rows), default=0.0)
    if torch.frame_power and not (torch.laser_mode and torch.frame_power < least):
        yield "torch.frame_power", f"0, or less than the {least:g} of its rows, in laser_mode"
    if torch.lead != "none" and not torch.lead_in:
        yield "torch.lead_in", "a length, since there is a lead"


def _row_faults(machine: Machine, torch: Torch, worded: bool) -> Iterator[Fault]:
    """Rows of a cut chart without their words, and processes without a row."""
    words, step = machine.words, machine.format.resolution
    for index, row in enumerate(torch.rows):
        if 0.0 < row.kerf < KERF_STEPS * step:
            expected = f"0, or at least {KERF_STEPS} steps of {step:g} mm, as programs are written"
            yield f"torch.rows.{index}.kerf", expected
        slow = "hole_feed_share" if row.slows_holes else "corner_share" if row.slows_corners else ""
        paces = words.pace or (words.slow and words.full) or carries(words.modal, "feed")
        if slow and not (worded and paces):
            expected = "1, as there are no words for another feed in a contour (`words.pace`)"
            yield f"torch.rows.{index}.{slow}", expected
    for process in {row.process for row in torch.rows}:
        for name in (f"{process}_on", f"{process}_off") if worded else ():
            if not getattr(words, name):
                yield f"words.{name}", f"a template, since there is a row for {process}"
    processes = [row.process for row in torch.rows]
    if "cut" not in processes:
        yield "torch.rows", "a row for cut" if processes else "a row for each process", processes
    for colour, meaning in torch.colours.items():
        if meaning != "ignore" and meaning not in processes:
            yield f"torch.colours.{colour}", "ignore, or what has a row in torch.rows", meaning


_LIFTING = ("linuxcnc", "grbl", "mach3")  #: controllers whose Z a table's program may move


def _height_faults(machine: Machine, torch: Torch) -> Iterator[Fault]:
    """Keys of a torch's height that contradict each other, or that nothing can keep."""
    meanings = set(machine.codes.values())
    by_program = torch.z == "program"
    if by_program and machine.controller not in _LIFTING:
        yield "torch.z", f"controller; {machine.controller} is not followed in Z"
    if by_program and not torch.clearance:
        yield "torch.clearance", "a height for traverses, as the program moves Z"
    if not by_program and torch.touch != "none":
        yield "torch.touch", "none, as the controller moves Z"
    if by_program and torch.touch != "none" and torch.top is None:
        expected = "Z of the machine at the top, as nothing else is known before the first touch"
        yield "torch.top", expected
    if not torch.thc_slow and not (machine.words.slow and machine.words.full):
        yield "torch.thc_slow", "true, as no words of slow and full switch the height control"
    if torch.thc == "program" and not meanings >= {"thc on", "thc off"}:
        yield "torch.thc", "controller, or words of codes that are thc on and thc off"
    for index, row in enumerate(torch.rows):
        key, most = f"torch.rows.{index}", max(row.cut_height, row.pierce_height)
        if by_program and row.process == "cut":
            if not row.cut_height:
                yield f"{key}.cut_height", "a height, as the program moves Z"
            elif row.cut_height >= torch.clearance or row.pierce_height > torch.clearance:
                yield "torch.clearance", f"more than {most:g} of {key}"
        if row.preheat_s and not meanings >= {"preheat on", "preheat off"}:
            expected = "0, or words of codes that are preheat on and preheat off"
            yield f"{key}.preheat_s", expected


MIN_ACCELERATION = 1.0  #: mm/s2, which programs say to 0.001


def _path_faults(machine: Machine, torch: Torch) -> Iterator[Fault]:
    """Each limit along a path that the axes contradict."""
    axes = {axis.moves: axis for axis in machine.axes}
    names = [axis.name for axis in machine.axes]
    if ("X" in axes) != ("Y" in axes):
        yield "axes", "an axis for X and one for Y", names
    if torch.z == "program" and "X" in axes and "Z" not in axes:
        yield "axes", "an axis for Z, as the program moves it (torch.z)", names
    if 0.0 < torch.acceleration < MIN_ACCELERATION:
        yield "torch.acceleration", f"at least {MIN_ACCELERATION:g} mm/s2"
    for name in ("X", "Y"):
        axis = axes.get(name)
        if axis is not None and torch.acceleration >= axis.acceleration:
            expected = f"less than the {axis.acceleration:g} of {axis.name}, for the curves"
            yield "torch.acceleration", expected
    needs = carries(machine.words.modal, "acceleration")
    if needs and not (torch.acceleration and "X" in axes):
        yield "words.modal", "torch.acceleration and axes X and Y for {acceleration}"


MIN_STEP = 0.0005  #: mm that a motor makes; a table has a row for each
SLOWEST_MM_S = 1.0 / 60.0  #: of a feed, as of all rows


def table_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a trigger program or a stepper table that cannot be."""
    triggers, stepper, torch = machine.triggers, machine.stepper, machine.torch
    if machine.controller in DIALECTS and triggers is None:
        yield "triggers", f"a table, since the controller is {machine.controller}"
    if machine.controller == "stepper" and stepper is None:
        yield "stepper", "a table, since the controller is stepper"
    if triggers is not None:
        yield from _trigger_faults(triggers, machine)
    if machine.controller == "stepper" and machine.suffix not in STEP_FORMS:
        yield "suffix", f"one of {', '.join(STEP_FORMS)}, the forms of its tables"
    if stepper is None:
        return
    if sorted(stepper.sequence) != ["00", "01", "10", "11"]:
        yield "stepper.sequence", "each of 00, 01, 10, 11 once"
    # A curve that is longer moves an axis by a step at least, in either direction.
    if torch is not None and torch.gap < (least := sqrt(2) * stepper.step):
        expected = f"{least:.4f} or more: the laser would be on while no motor makes a step"
        yield "torch.gap", f"{expected} of {stepper.step:g} mm"
    if stepper.step < MIN_STEP:
        expected = f"at least {MIN_STEP * stepper.steps_per_turn:g}, steps of {MIN_STEP:g} mm"
        yield "stepper.pitch", expected
    slowest = SLOWEST_MM_S / stepper.step
    if stepper.max_hz < slowest:
        yield "stepper.max_hz", f"at least {slowest:.3g}, for {60.0 * SLOWEST_MM_S:g} mm/min"


def _trigger_faults(triggers: Triggers, machine: Machine) -> Iterator[Fault]:
    """Each key of a trigger program that contradicts another, or that it cannot have."""
    windows = [("triggers", triggers.arrival_window, triggers.count)]
    if triggers.z is not None:
        windows.append(("triggers.z", triggers.z.arrival_window, triggers.z.count))
    for key, window, count in windows:
        if window < (least := triggers.least_window(count)):
            what = "a count" if triggers.counted == "floor" else "half a count"
            yield f"{key}.arrival_window", f"{what} of the encoder or more, {least:.4f} mm"
    if machine.torch is not None:
        yield from _work_faults(triggers, machine, machine.torch)
    if triggers.homing_slow_mm_s > triggers.homing_mm_s:
        yield "triggers.homing_slow_mm_s", f"at most homing_mm_s, {triggers.homing_mm_s:g}"
    # An arrival is seen in the second cycle at rest, once the lag has run down to a twentieth.
    least = 4 * triggers.cycle_s + 3 * triggers.following_lag_s
    if triggers.max_late_s < least:
        yield "triggers.max_late_s", f"{least:g} or more, 4 cycles and 3 times following_lag_s"
    dialect = DIALECTS.get(machine.controller, DIALECTS["simotion"])
    for name in (*triggers.all_axes, triggers.path_object, triggers.technology, *triggers.uses):
        if not _ST_NAME.fullmatch(name):
            yield "triggers.axes", "letters, digits and single _, a letter first", name
    for name, other in triggers.names.items():
        if name not in dialect.renamed:
            yield "triggers.names", f"one of {', '.join(dialect.renamed)}", name
        elif not all(_ST_NAME.fullmatch(word) for word in other.removeprefix("_").split(".")):
            yield f"triggers.names.{name}", "letters, digits and single _", other
    yield from _place_faults(triggers, dialect)
    defaults = {field.name: field.default for field in fields(Triggers)}
    for key in dialect.without:
        if getattr(triggers, key) != defaults[key]:
            yield f"triggers.{key}", f"no such key, as the controller is {machine.controller}"
    if triggers.path_objects and triggers.technology not in _PATH_PACKAGES:
        yield "triggers.package", f"{' or '.join(_PATH_PACKAGES)}, which have path objects"
    if triggers.z is not None and triggers.z.clearance >= triggers.z.home_height:
        yield "triggers.z.clearance", f"less than home_height, {triggers.z.home_height:g}"


def _work_faults(triggers: Triggers, machine: Machine, torch: Torch) -> Iterator[Fault]:
    """Tolerances, times of homing and rows that a trigger program cannot keep.

    Heights have to be below one another: cut, pierce, clearance, home. A row that does not know its
    heights is refused where it is used.
    """
    # Points are cut off to the decimals of both axes, and count as reached a little before.
    least = triggers.in_position / 2 + machine.format.resolution * sqrt(2)
    if torch.tolerance <= least:
        expected = f"more than {least:g}, which rounding and triggers.in_position take"
        yield "torch.tolerance", expected
    way = max(torch.length, torch.width) + triggers.overrun + 2 * triggers.back_off
    # Slowly off the switch by two windows from where it was seen, and against it again.
    slowly = 6 * triggers.homing_window / triggers.homing_slow_mm_s
    if (z := triggers.z) is not None:  # which homes first
        way += z.home_height + triggers.overrun + 2 * z.back_off
        slowly += 6 * triggers.lift_window / triggers.homing_slow_mm_s
    least = way / triggers.homing_mm_s + slowly
    if triggers.max_homing_s < least:
        expected = f"{least:g} or more for {way:g} mm at homing_mm_s and the slow approach"
        yield "triggers.max_homing_s", expected
    for row in torch.rows:
        if row.process not in triggers.outputs:
            yield "triggers.outputs", f"an output for {row.process}"
        for key in ("pierce_height", "cut_height") if z else ():
            if z is not None and getattr(row, key) > z.clearance:
                expected = f"at most triggers.z.clearance, {z.clearance:g}"
                yield f"torch.rows.{key}", expected, getattr(row, key)


def _place_faults(triggers: Triggers, dialect: TableDialect) -> Iterator[Fault]:
    """Inputs and outputs that are neither addresses nor names, or that stand for two things."""
    of_z = triggers.z.limits if triggers.z else ()
    optional = filter(None, (triggers.acknowledge, triggers.stop))
    inputs = (*triggers.limits, *of_z, triggers.start, *optional)
    outputs = (*triggers.outputs.values(), *filter(None, [triggers.fault_lamp]))
    for key, places, letter, kind in (
        ("limits", inputs, "I", "input such as %I0.0"),
        ("outputs", outputs, "Q", "output such as %Q62.0"),
    ):
        pattern = re.compile(f"%{letter}{dialect.address}")
        for place in places:
            if not (pattern.fullmatch(place) or _ST_NAME.fullmatch(place)):
                expected = f"an address of an {kind} or the name of a variable"
                yield f"triggers.{key}", expected, place
    for place in triggers.normally_closed:
        if place not in inputs:
            expected = f"one of the inputs {', '.join(inputs)}"
            yield "triggers.normally_closed", expected, place
    # %IX0.0 and %I0.0 are one place.
    used = Counter(_BIT.sub(r"\1", p.upper()) for p in (*inputs, *outputs, *triggers.all_axes))
    for place, count in used.items():
        if count > 1:
            yield "triggers", "each input, output and axis once", place


_BIT = re.compile(r"^(%[IQ])X")
_PATH_PACKAGES = ("PATH", "CAM_EXT")
_ST_NAME = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
