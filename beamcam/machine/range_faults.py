"""Keys out of the range in which programs can be written and read back.

A feed that rounds to 0 in the numbers of a program, or a cross that is shorter than the gap that is
closed, would make programs that the read-back refuses.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from math import sqrt
from string import Formatter

from msgspec.structs import fields

from beamcam.conversion import nearest
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Drill
from beamcam.machine.tables import DIALECTS, HeightAxis, TableDialect, Triggers
from beamcam.machine.torch import Torch, TorchRow
from beamcam.machine.words import PART_NAMES, WORD_NAMES

Fault = tuple[str, object, str]  #: dotted key, what was found, what was expected

#: mm that ends may gape, a path be off and two holes lie apart that are one: beyond that a hole is
#: no hole any more.
MAX_SLACK = 1.0
#: mm/min; feeds are written to 0.001 mm/s or mm/min, so that each is within 3 % of the machine's.
MIN_FEED_MM_MIN = 1.0
MIN_ACCELERATION = 1.0  #: mm/s2, which programs say to 0.001
MIN_FEED_PER_TURN = 0.001  #: mm
MIN_PATH_TOLERANCE = 0.001  #: mm of chords from their curve, finer than a mill cuts
MIN_SPEED_RPM = 1.0  #: which programs say to 1
MIN_CROSS = 1.0  #: mm of a cross that marks a centre, if there is one
MIN_STEP = 0.0005  #: mm that a motor makes; a table has a row for each
GAPS = 4.0  #: gaps that a cross is long at least, so that its lines are not closed


def range_faults(machine: Machine) -> Iterator[Fault]:
    """Each number that programs cannot say, or that leaves nothing of the work."""
    if machine.saw is not None:
        yield from _feed("saw.feed_mm_min", machine.saw.feed_mm_min)
    if machine.drill is not None:
        yield from _of_drill(machine.drill)
        for name, found, expected in slack_faults(machine.drill):
            yield f"drill.{name}", found, expected
    if machine.torch is not None:
        yield from _of_torch(machine.torch)
    if machine.stepper is not None and machine.stepper.step < MIN_STEP:
        expected = (
            f"at least {MIN_STEP * machine.stepper.steps_per_turn:g}, steps of {MIN_STEP:g} mm"
        )
        yield "stepper.pitch", machine.stepper.pitch, expected
    if machine.stepper is not None:
        slowest = MIN_FEED_MM_MIN / 60.0 / machine.stepper.step
        if machine.stepper.max_hz < slowest:
            expected = f"at least {slowest:.3g}, for {MIN_FEED_MM_MIN:g} mm/min"
            yield "stepper.max_hz", machine.stepper.max_hz, expected


def _feed(key: str, found: float) -> Iterator[Fault]:
    if found < MIN_FEED_MM_MIN:
        yield key, found, f"at least {MIN_FEED_MM_MIN:g} mm/min"


def _of_drill(drill: Drill) -> Iterator[Fault]:
    if drill.min_speed_rpm < MIN_SPEED_RPM:
        yield "drill.min_speed_rpm", drill.min_speed_rpm, f"at least {MIN_SPEED_RPM:g}"
    if drill.max_speed_rpm < drill.min_speed_rpm:
        yield "drill.max_speed_rpm", drill.max_speed_rpm, "at least drill.min_speed_rpm"
    yield from _feed("drill.max_feed_mm_min", drill.max_feed_mm_min)
    for index, row in enumerate(drill.cutting):
        key = f"drill.cutting.{index}.feed_per_turn"
        if row.feed_per_turn < MIN_FEED_PER_TURN:
            yield key, row.feed_per_turn, f"at least {MIN_FEED_PER_TURN:g} mm"
        if row.feed_per_turn * drill.min_speed_rpm < MIN_FEED_MM_MIN:
            expected = f"{MIN_FEED_MM_MIN / row.feed_per_turn:.3g} or more, for a feed of 1 mm/min"
            yield "drill.min_speed_rpm", drill.min_speed_rpm, f"{expected} by {key}"


def slack_faults(drill: Drill) -> Iterator[Fault]:
    """Each tolerance with which a hole would be no hole any more, by its name in a drill."""
    for name in (
        "merge_tolerance", "same_tool_tolerance", "duplicate_tolerance", "sink_tolerance",
        "path_tolerance",
    ):  # fmt: skip
        if (found := getattr(drill, name)) > MAX_SLACK:
            yield name, found, f"at most {MAX_SLACK:g} mm"
    if drill.path_tolerance < MIN_PATH_TOLERANCE:
        yield "path_tolerance", drill.path_tolerance, f"at least {MIN_PATH_TOLERANCE:g} mm"


def _of_torch(torch: Torch) -> Iterator[Fault]:
    for name, value in (("gap", torch.gap), ("tolerance", torch.tolerance)):
        if value > MAX_SLACK:
            yield f"torch.{name}", value, f"at most {MAX_SLACK:g} mm"
    if 0.0 < torch.acceleration < MIN_ACCELERATION:
        yield "torch.acceleration", torch.acceleration, f"at least {MIN_ACCELERATION:g} mm/s2"
    for index, row in enumerate(torch.rows):
        yield from _feed(f"torch.rows.{index}.feed_mm_min", row.feed_mm_min)
    if 0.0 < torch.cross < (least := max(MIN_CROSS, GAPS * torch.gap)):
        yield "torch.cross", torch.cross, f"0, or at least {least:g} mm"


# --- templates ------------------------------------------------------------------------------------

# Checks of the templates of a program's blocks.


#: How a value may be set in a template; a greater width would fill the memory with blanks.
_FIELD_FORM = re.compile(r"[^{}]?[<>^]?[0-9]{0,2}")
_COMMENT = re.compile(r"\([^()]*\)")
#: What the head of a program cannot say, by what it is for.
_NOT_SAID = {
    "beam": frozenset[str](),
    "sheet": frozenset({"section", "width", "height"}),
    "profile": frozenset({"section"}),
}


def template_faults(machine: Machine) -> Iterator[Fault]:
    """Each template that names what it cannot, or gives a value a form that it must not have.

    Decimals are those of [format], so that a program is read back as it was rounded.
    """
    for key, names in WORD_NAMES.items():
        if key == "header":
            names = names - _NOT_SAID[machine.stock]
        elif machine.stock == "sheet":
            names = names - {"z", "a", "inverse"} if key in ("traverse", "feed") else names
        template = getattr(machine.words, key)
        for line in (template,) if isinstance(template, str) else template:
            for found, expected in _line_faults(line, names):
                yield f"words.{key}", found, expected
            if machine.stock != "beam" and key != "header":
                yield from _outside_comments(f"words.{key}", line)


def _outside_comments(key: str, line: str) -> Iterator[Fault]:
    """Data of a part that would be a figure of a table's program: nothing says which is right."""
    for _, name, _, _ in Formatter().parse(_COMMENT.sub("", line)):
        if name in PART_NAMES:
            yield key, "{" + name + "}", "it in a comment, between ( and )"


def _line_faults(line: str, names: frozenset[str]) -> Iterator[tuple[str, str]]:
    try:
        fields = [field for field in Formatter().parse(line) if field[1] is not None]
    except ValueError as error:
        yield line, f"a template: {error}"
        return
    for _, name, form, conversion in fields:
        if name not in names:
            yield "{" + str(name) + "}", nearest(str(name), names)
        elif conversion or not _FIELD_FORM.fullmatch(form or ""):
            yield line, "{" + name + "}, or with a width of two digits, such as {" + name + ":>8}"


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
        yield from _height_faults(triggers.z, torch.rows if torch else ())


def _height_faults(z: HeightAxis, rows: Sequence[TorchRow]) -> Iterator[Fault]:
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
