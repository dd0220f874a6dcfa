"""Keys of a torch and of the table under it that contradict others, or that leave the range in
which programs can be written and read back.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from math import sqrt

from msgspec.structs import fields

from beamcam.machine.faults import MAX_SLACK, MIN_FEED_MM_MIN, Fault, carries, feed_faults
from beamcam.machine.machine import Machine
from beamcam.machine.tables import (
    DIALECTS,
    STEP_FORMS,
    TABLE_CONTROLLERS,
    HeightAxis,
    TableDialect,
    Triggers,
)
from beamcam.machine.torch import KERF_STEPS, Torch, TorchRow

#: Words that a machine with a torch cannot do without.
_TORCH_WORDS = ("traverse", "feed", "cut_on", "cut_off")


def torch_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a torch that contradicts another."""
    torch, words = machine.torch, machine.words
    if torch is None:
        return
    yield from table_faults(machine)
    yield from _height_faults(machine, torch)
    yield from path_faults(machine, torch)
    worded = machine.controller not in TABLE_CONTROLLERS
    for name in _TORCH_WORDS if worded else ():
        if not getattr(words, name):
            yield f"words.{name}", [], "a template, since there is a torch"
    for one, other in (
        ("slow", "full"),
        ("arc_cw", "arc_ccw"),
        ("ellipse_cw", "ellipse_ccw"),
        ("left", "right"),
    ):
        if bool(getattr(words, one)) != bool(getattr(words, other)):
            yield f"words.{one}", list(getattr(words, one)), f"both {one} and {other}, or neither"
    step = machine.format.resolution
    if torch.tolerance < step:
        expected = f"at least {step:g}, the step of its numbers"
        yield "torch.tolerance", torch.tolerance, expected
    yield from _row_faults(machine, torch, worded)
    if torch.kerf_by == "machine" and not words.left:
        yield "torch.kerf_by", torch.kerf_by, "none or offset, as there are no words for left"
    if torch.bevel == "head":
        expected = "refuse or square, since no torch that tilts is known yet"
        yield "torch.bevel", torch.bevel, expected
    if torch.drilled == "mark" and not torch.cross:
        yield "torch.cross", torch.cross, "the size of the cross that marks a centre for the drill"
    if torch.drilled == "mark" and not any(row.process == "mark" for row in torch.rows):
        yield "torch.drilled", torch.drilled, "refuse, as no row marks"
    if torch.drilled == "spot" and not (worded and words.spot_on and words.spot_off):
        yield "torch.drilled", torch.drilled, "refuse or mark, as there are no words of spot_on"
    if torch.origin != "table" and not worded:
        yield "torch.origin", torch.origin, "table, from whose corner the controller counts"
    if torch.overscan and not (torch.laser_mode and carries(words.power, "power")):
        expected = "0, or laser_mode and {power} in words.power"
        yield "torch.overscan", torch.overscan, expected
    for key, asked in (("hole_overcut", torch.hole_overcut), ("hole_lead", torch.hole_lead)):
        if asked not in (None, "lead") and not worded:
            yield f"torch.{key}", asked, "nothing, as the table does not run G-code"
    least = min((row.power for row in torch.rows), default=0.0)
    if torch.frame_power and not (torch.laser_mode and torch.frame_power < least):
        expected = f"0, or less than the {least:g} of its rows, in laser_mode"
        yield "torch.frame_power", torch.frame_power, expected
    if torch.lead != "none" and not torch.lead_in:
        yield "torch.lead_in", torch.lead_in, "a length, since there is a lead"


def _row_faults(machine: Machine, torch: Torch, worded: bool) -> Iterator[Fault]:
    """Rows of a cut chart without their words, and processes without a row."""
    words, step = machine.words, machine.format.resolution
    for index, row in enumerate(torch.rows):
        if 0.0 < row.kerf < KERF_STEPS * step:
            expected = f"0, or at least {KERF_STEPS} steps of {step:g} mm, as programs are written"
            yield f"torch.rows.{index}.kerf", row.kerf, expected
        slow = "hole_feed_share" if row.slows_holes else "corner_share" if row.slows_corners else ""
        paces = words.pace or (words.slow and words.full) or carries(words.modal, "feed")
        if slow and not (worded and paces):
            expected = "1, as there are no words for another feed in a contour (`words.pace`)"
            yield f"torch.rows.{index}.{slow}", getattr(row, slow), expected
    if not torch.rows:
        yield "torch.rows", [], "a row for each process"
    for process in {row.process for row in torch.rows}:
        for name in (f"{process}_on", f"{process}_off") if worded else ():
            if not getattr(words, name):
                yield f"words.{name}", [], f"a template, since there is a row for {process}"
    if not any(row.process == "cut" for row in torch.rows):
        yield "torch.rows", [row.process for row in torch.rows], "a row for cut"
    for colour, meaning in torch.colours.items():
        if meaning != "ignore" and not any(row.process == meaning for row in torch.rows):
            yield f"torch.colours.{colour}", meaning, "ignore, or what has a row in torch.rows"


_LIFTING = ("linuxcnc", "grbl", "mach3")  #: controllers whose Z a table's program may move


def _height_faults(machine: Machine, torch: Torch) -> Iterator[Fault]:
    """Keys of a torch's height that contradict each other, or that nothing can keep."""
    meanings = set(machine.codes.values())
    by_program = torch.z == "program"
    if by_program and machine.controller not in _LIFTING:
        expected = f"controller; {machine.controller} is not followed in Z"
        yield "torch.z", torch.z, expected
    if by_program and not torch.clearance:
        yield "torch.clearance", torch.clearance, "a height for traverses, as the program moves Z"
    if not by_program and torch.touch != "none":
        yield "torch.touch", torch.touch, "none, as the controller moves Z"
    if by_program and torch.touch != "none" and torch.top is None:
        expected = "Z of the machine at the top, as nothing else is known before the first touch"
        yield "torch.top", torch.top, expected
    if not torch.thc_slow and not (machine.words.slow and machine.words.full):
        expected = "true, as no words of slow and full switch the height control"
        yield "torch.thc_slow", torch.thc_slow, expected
    if torch.thc == "program" and not meanings >= {"thc on", "thc off"}:
        expected = "controller, or words of codes that are thc on and thc off"
        yield "torch.thc", torch.thc, expected
    for index, row in enumerate(torch.rows):
        key = f"torch.rows.{index}"
        if by_program and row.process == "cut":
            if not row.cut_height:
                yield f"{key}.cut_height", row.cut_height, "a height, as the program moves Z"
            elif row.cut_height >= torch.clearance or row.pierce_height > torch.clearance:
                found = max(row.cut_height, row.pierce_height)
                yield "torch.clearance", torch.clearance, f"more than {found:g} of {key}"
        if row.preheat_s and not meanings >= {"preheat on", "preheat off"}:
            expected = "0, or words of codes that are preheat on and preheat off"
            yield f"{key}.preheat_s", row.preheat_s, expected


def path_faults(machine: Machine, torch: Torch) -> Iterator[Fault]:
    """Each limit along a path that the axes contradict."""
    axes = {axis.moves: axis for axis in machine.axes}
    if ("X" in axes) != ("Y" in axes):
        yield "axes", [axis.name for axis in machine.axes], "an axis for X and one for Y"
    if torch.z == "program" and "X" in axes and "Z" not in axes:
        names = [axis.name for axis in machine.axes]
        yield "axes", names, "an axis for Z, as the program moves it (torch.z)"
    for name in ("X", "Y"):
        axis = axes.get(name)
        if axis is not None and torch.acceleration >= axis.acceleration:
            expected = f"less than the {axis.acceleration:g} of {axis.name}, for the curves"
            yield "torch.acceleration", torch.acceleration, expected
    needs = carries(machine.words.modal, "acceleration")
    if needs and not (torch.acceleration and "X" in axes):
        names = list(machine.words.modal)
        yield "words.modal", names, "torch.acceleration and axes X and Y for {acceleration}"


def table_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a trigger program or a stepper table that cannot be."""
    triggers, stepper = machine.triggers, machine.stepper
    if machine.controller in DIALECTS and triggers is None:
        yield "triggers", None, f"a table, since the controller is {machine.controller}"
    if machine.controller == "stepper" and stepper is None:
        yield "stepper", None, "a table, since the controller is stepper"
    if triggers is not None:
        yield from trigger_faults(triggers, machine)
    if stepper is not None and sorted(stepper.sequence) != ["00", "01", "10", "11"]:
        yield "stepper.sequence", list(stepper.sequence), "each of 00, 01, 10, 11 once"
    if machine.controller == "stepper" and machine.suffix not in STEP_FORMS:
        yield "suffix", machine.suffix, f"one of {', '.join(STEP_FORMS)}, the forms of its tables"
    torch = machine.torch
    # A curve that is longer moves an axis by a step at least, in either direction.
    if stepper is not None and torch is not None and torch.gap < (least := sqrt(2) * stepper.step):
        expected = f"{least:.4f} or more: the laser would be on while no motor makes a step"
        yield "torch.gap", torch.gap, f"{expected} of {stepper.step:g} mm"


MIN_ACCELERATION = 1.0  #: mm/s2, which programs say to 0.001


MIN_CROSS = 1.0  #: mm of a cross that marks a centre, if there is one


MIN_STEP = 0.0005  #: mm that a motor makes; a table has a row for each
GAPS = 4.0  #: gaps that a cross is long at least, so that its lines are not closed


def table_range_faults(machine: Machine) -> Iterator[Fault]:
    """Each number of a torch or a stepper that programs cannot say."""
    torch, stepper = machine.torch, machine.stepper
    if torch is not None:
        for name, value in (("gap", torch.gap), ("tolerance", torch.tolerance)):
            if value > MAX_SLACK:
                yield f"torch.{name}", value, f"at most {MAX_SLACK:g} mm"
        if 0.0 < torch.acceleration < MIN_ACCELERATION:
            yield "torch.acceleration", torch.acceleration, f"at least {MIN_ACCELERATION:g} mm/s2"
        for index, row in enumerate(torch.rows):
            yield from feed_faults(f"torch.rows.{index}.feed_mm_min", row.feed_mm_min)
        if 0.0 < torch.cross < (least := max(MIN_CROSS, GAPS * torch.gap)):
            yield "torch.cross", torch.cross, f"0, or at least {least:g} mm"
    if stepper is not None:
        if stepper.step < MIN_STEP:
            expected = f"at least {MIN_STEP * stepper.steps_per_turn:g}, steps of {MIN_STEP:g} mm"
            yield "stepper.pitch", stepper.pitch, expected
        slowest = MIN_FEED_MM_MIN / 60.0 / stepper.step
        if stepper.max_hz < slowest:
            expected = f"at least {slowest:.3g}, for {MIN_FEED_MM_MIN:g} mm/min"
            yield "stepper.max_hz", stepper.max_hz, expected


MIN_CYCLE_S = 0.0005  #: no task of such a controller comes round sooner


def trigger_faults(triggers: Triggers, machine: Machine) -> Iterator[Fault]:
    """Each key of a trigger program that contradicts another, or that it cannot have."""
    if triggers.cycle_s < MIN_CYCLE_S:
        yield "triggers.cycle_s", triggers.cycle_s, f"at least {MIN_CYCLE_S:g} s"
    windows = [("triggers", triggers.arrival_window, triggers.count)]
    if triggers.z is not None:
        windows.append(("triggers.z", triggers.z.arrival_window, triggers.z.count))
    for key, window, count in windows:
        if window < (least := triggers.least_window(count)):
            what = "a count" if triggers.counted == "floor" else "half a count"
            expected = f"{what} of the encoder or more, {least:.4f} mm"
            yield f"{key}.arrival_window", window, expected
    torch = machine.torch
    # Points are cut off to the decimals of both axes, and count as reached a little before.
    least = triggers.in_position / 2 + machine.format.resolution * sqrt(2)
    if torch is not None and torch.tolerance <= least:
        expected = f"more than {least:g}, which rounding and triggers.in_position take"
        yield "torch.tolerance", torch.tolerance, expected
    if torch is not None:
        way = max(torch.length, torch.width) + triggers.overrun + 2 * triggers.back_off
        # Slowly off the switch by two windows from where it was seen, and against it again.
        slowly = 6 * triggers.homing_window / triggers.homing_slow_mm_s
        if (z := triggers.z) is not None:  # which homes first
            way += z.home_height + triggers.overrun + 2 * z.back_off
            slowly += 6 * triggers.lift_window / triggers.homing_slow_mm_s
        least = way / triggers.homing_mm_s + slowly
        if triggers.max_homing_s < least:
            expected = f"{least:g} or more for {way:g} mm at homing_mm_s and the slow approach"
            yield "triggers.max_homing_s", triggers.max_homing_s, expected
    if triggers.homing_slow_mm_s > triggers.homing_mm_s:
        expected = f"at most homing_mm_s, {triggers.homing_mm_s:g}"
        yield "triggers.homing_slow_mm_s", triggers.homing_slow_mm_s, expected
    # An arrival is seen in the second cycle at rest, once the lag has run down to a twentieth.
    least = 4 * triggers.cycle_s + 3 * triggers.following_lag_s
    if triggers.max_late_s < least:
        expected = f"{least:g} or more, 4 cycles and 3 times following_lag_s"
        yield "triggers.max_late_s", triggers.max_late_s, expected
    dialect = DIALECTS.get(machine.controller, DIALECTS["simotion"])
    yield from _st_name_faults(triggers, dialect)
    yield from _place_faults(triggers, dialect)
    defaults = {field.name: field.default for field in fields(Triggers)}
    for key in dialect.without:
        if (found := getattr(triggers, key)) != defaults[key]:
            expected = f"no such key, as the controller is {machine.controller}"
            yield f"triggers.{key}", found, expected
    if triggers.path_objects and triggers.technology not in _PATH_PACKAGES:
        expected = f"{' or '.join(_PATH_PACKAGES)}, which have path objects"
        yield "triggers.package", triggers.package, expected
    for row in torch.rows if torch else ():
        if row.process not in triggers.outputs:
            yield "triggers.outputs", dict(triggers.outputs), f"an output for {row.process}"
    if triggers.z is not None:
        yield from _lift_faults(triggers.z, torch.rows if torch else ())


def _lift_faults(z: HeightAxis, rows: Sequence[TorchRow]) -> Iterator[Fault]:
    """Heights that are not below one another as they have to be: cut, pierce, clearance, home.

    A row that does not know its heights is refused where it is used.
    """
    if z.clearance >= z.home_height:
        expected = f"less than home_height, {z.home_height:g}"
        yield "triggers.z.clearance", z.clearance, expected
    for row in rows:
        for key, height in (("pierce_height", row.pierce_height), ("cut_height", row.cut_height)):
            if height > z.clearance:
                expected = f"at most triggers.z.clearance, {z.clearance:g}"
                yield f"torch.rows.{key}", height, expected


def _place_faults(triggers: Triggers, dialect: TableDialect) -> Iterator[Fault]:
    """Inputs and outputs that are neither addresses nor names, or that stand for two things."""
    optional = filter(None, (triggers.acknowledge, triggers.stop))
    of_z = triggers.z.limits if triggers.z else ()
    inputs = (*triggers.limits, *of_z, triggers.start, *optional)
    outputs = (*triggers.outputs.values(), *filter(None, [triggers.fault_lamp]))
    for key, places, letter, kind in (
        ("limits", inputs, "I", "input such as %I0.0"),
        ("outputs", outputs, "Q", "output such as %Q62.0"),
    ):
        pattern = re.compile(f"%{letter}{dialect.address}")
        for place in places:
            if not (pattern.fullmatch(place) or _ST_NAME.fullmatch(place)):
                yield f"triggers.{key}", place, f"an address of an {kind} or the name of a variable"
    for place in triggers.normally_closed:
        if place not in inputs:
            yield "triggers.normally_closed", place, f"one of the inputs {', '.join(inputs)}"
    # %IX0.0 and %I0.0 are one place.
    used = Counter(_BIT.sub(r"\1", p.upper()) for p in (*inputs, *outputs, *triggers.all_axes))
    for place, count in used.items():
        if count > 1:
            yield "triggers", place, "each input, output and axis once"


def _st_name_faults(triggers: Triggers, dialect: TableDialect) -> Iterator[Fault]:
    for name in (*triggers.all_axes, triggers.path_object, triggers.technology, *triggers.uses):
        if not _ST_NAME.fullmatch(name):
            yield "triggers.axes", name, "letters, digits and single _, a letter first"
    for name, other in triggers.names.items():
        if name not in dialect.renamed:
            yield "triggers.names", name, f"one of {', '.join(dialect.renamed)}"
        elif not all(_ST_NAME.fullmatch(word) for word in other.removeprefix("_").split(".")):
            yield f"triggers.names.{name}", other, "letters, digits and single _"


_BIT = re.compile(r"^(%[IQ])X")
_PATH_PACKAGES = ("PATH", "CAM_EXT")
_ST_NAME = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
