"""Keys out of the range in which programs can be written and read back.

A feed that rounds to 0 in the numbers of a program, or a cross that is shorter than the gap that is
closed, would make programs that the read-back refuses.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from math import hypot, sqrt
from string import Formatter

from msgspec.structs import fields

from beamcam.conversion import nearest
from beamcam.machine.coper import TUBES, Coper
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
MOST_TILT_DEG = 60.0  #: farther over, the torch lies on the steel


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


def coper_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a coper that contradicts another."""
    coper, words = machine.coper, machine.words
    if coper is None:
        return
    if machine.stock != "profile":
        yield "coper", machine.stock, "no such table, or stock = 'profile'"
    if machine.controller != "linuxcnc":
        yield "controller", machine.controller, "linuxcnc, which runs a torch round a profile"
    for name in ("turn", "traverse", "feed", "cut_on", "cut_off"):
        if not getattr(words, name):
            yield f"words.{name}", [], "a template, since there is a coper"
    for name in ("height", "width"):
        template = getattr(words, f"measured_{name}")
        if template and sum(line.count("{" + name) for line in template) != 1:
            yield f"words.measured_{name}", list(template), f"{{{name}}} once"
    round_bar = coper.turns == "bar"
    for name in ("a", "inverse"):
        if any("{" + name in line for line in words.feed) != round_bar:
            expected = f"{{{name}}} where coper.turns is bar, and nowhere else"
            yield "words.feed", list(words.feed), expected
    if not {*coper.profiles} <= (
        allowed := {"I", "U", "L", "T", *(TUBES if round_bar else ("C",))}
    ):
        expected = f"some of {', '.join(sorted(allowed))} where coper.turns is {coper.turns}"
        yield "coper.profiles", list(coper.profiles), expected
    yield from _tilt_faults(machine, coper)
    yield from _fixed_faults(machine, coper)
    for k, zone in enumerate(coper.supports):
        if zone.min >= zone.max:
            yield f"coper.supports.{k}.max", zone.max, f"more than min, {zone.min:g}"
    if coper.a_unit == "mm" and {*coper.profiles} != {"RO"}:
        yield "coper.a_unit", "mm", "deg, as only round tubes (RO) turn evenly with their surface"
    if coper.corners and "M" not in coper.profiles:
        yield "coper.corners", len(coper.corners), "none where coper.profiles has no M"
    if coper.corner and "M" not in coper.profiles:
        yield "coper.corner", coper.corner, "none where coper.profiles has no M"
    if coper.lip and "C" not in coper.profiles:
        yield "coper.lip", coper.lip, "none where coper.profiles has no C"
    yield from _reach_faults(machine, coper)
    if coper.tcp == bool(coper.pivot):
        expected = "0 where tcp is true, and above 0 where it is false"
        yield "coper.pivot", coper.pivot, expected
    if not any(row.process == "cut" for row in coper.rows):
        yield "coper.rows", [row.process for row in coper.rows], "a row for cut"
    for index, row in enumerate(coper.rows):
        yield from _row_faults(f"coper.rows.{index}", row, coper)
    feeds = [(row.feed_mm_min, row.material) for row in coper.rows]
    for index, feed in enumerate(feeds):
        if feeds.index(feed) != index:
            expected = "another feed for each thickness, which is told by it"
            yield f"coper.rows.{index}.feed_mm_min", feed[0], expected
    if coper.between_rows == "interpolate":
        for index, row in enumerate(coper.rows):
            slower = [o.feed_mm_min for o in coper.rows
                      if o.material == row.material and o.up_to < row.up_to]  # fmt: skip
            if slower and row.feed_mm_min >= min(slower):
                expected = "a feed below those of thinner steel, as between_rows is interpolate"
                yield f"coper.rows.{index}.feed_mm_min", row.feed_mm_min, expected
    step = machine.format.resolution
    if not 4 * step <= coper.tolerance <= 1.0:
        expected = f"{4 * step:g} to 1 mm, four steps of its numbers at least"
        yield "coper.tolerance", coper.tolerance, expected
    if coper.head_width < coper.torch_width:
        yield "coper.head_width", coper.head_width, "at least torch_width"


def _tilt_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """A torch that tilts without an axis or a word for it, or the other way round."""
    if coper.tilt and (coper.turns == "bar" or coper.tilt > MOST_TILT_DEG):
        expected = f"at most {MOST_TILT_DEG:g}, and 0 where coper.turns is bar"
        yield "coper.tilt", coper.tilt, expected
    if any("{b}" in line for line in machine.words.turn) != bool(coper.tilt):
        expected = "{b} where coper.tilt is above 0, and nowhere else"
        yield "words.turn", list(machine.words.turn), expected
    axes = [(k, axis) for k, axis in enumerate(machine.axes) if axis.moves == "B"]
    if bool(axes) != bool(coper.tilt):
        yield "axes", len(machine.axes), "one that moves B where coper.tilt is above 0, else none"
    for k, axis in axes:
        if axis.limits[0] > -coper.tilt or axis.limits[1] < coper.tilt:
            yield f"axes.{k}.max", axis.max, f"-{coper.tilt:g} to {coper.tilt:g} at least"


def _fixed_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """A torch without Y over sections that are square to it beside their axis too, or with words
    for Y."""
    if coper.y == "follows":
        return
    if coper.turns == "torch" or {*coper.profiles} != {"RO"}:
        expected = "RO alone, and turns = 'bar', where coper.y is fixed"
        yield "coper.profiles", list(coper.profiles), expected
    for name in ("turn", "traverse", "feed"):
        if any("{y}" in line for line in getattr(machine.words, name)):
            expected = "no {y} where coper.y is fixed"
            yield f"words.{name}", list(getattr(machine.words, name)), expected
    for k, axis in enumerate(machine.axes):
        if axis.moves == "Y":
            yield f"axes.{k}.moves", "Y", "no such axis where coper.y is fixed"


def _reach_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """Axes that do not come to the corners of the bars that turn below the torch, or to the webs
    between their flanges."""
    if coper.turns == "torch" or {*coper.profiles} == {"RO"}:
        return
    half, long = coper.max_width / 2, hypot(coper.max_height, coper.max_width) / 2
    wide, low, what = max(half, coper.max_height / 2), 0.0, "rectangular tubes"
    if not {*coper.profiles} <= {*TUBES}:
        beyond = coper.over + max((row.kerf for row in coper.rows), default=0.0)
        wide, low = wide + beyond, -half
        what = "walls that turn; else coper.profiles without I, U, L and T"
    for name, least, most in (("Y", -wide, wide), ("Z", low, long + coper.clearance)):
        for k, axis in enumerate(machine.axes):
            if axis.moves == name and (axis.limits[0] > least or axis.limits[1] < most):
                end = "max" if axis.limits[1] < most else "min"
                expected = f"{least:g} to {most:.4g} at least, for {what}"
                yield f"axes.{k}.{end}", getattr(axis, end), expected


def _row_faults(key: str, row: TorchRow, coper: Coper) -> Iterator[Fault]:
    if row.process != "cut":
        yield f"{key}.process", row.process, "cut, as a coper does nothing else"
    for name in ("kerf", "cut_height", "pierce_height", "pierce_s"):
        if not getattr(row, name):
            yield f"{key}.{name}", 0.0, "a figure above 0, as the torch goes round the steel by it"
    if row.cut_height <= coper.play:
        yield f"{key}.cut_height", row.cut_height, f"more than play, {coper.play:g} mm"
    if row.pierce_height < row.cut_height:
        yield f"{key}.pierce_height", row.pierce_height, "at least cut_height"
    if row.passes != 1:
        yield f"{key}.passes", row.passes, "1, as a torch cuts through at once"
    if coper.corner_radius < row.kerf / 2:
        expected = f"at least {row.kerf / 2:g}, half the kerf of the widest row"
        yield "coper.corner_radius", coper.corner_radius, expected
    if coper.lead < row.pierce_radius:
        yield "coper.lead", coper.lead, f"at least {row.pierce_radius:g}, what piercing burns"
    if coper.trim < 2 * (coper.lead + row.kerf):
        expected = f"at least {2 * (coper.lead + row.kerf):g}, for leads and kerfs"
        yield "coper.trim", coper.trim, expected


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
