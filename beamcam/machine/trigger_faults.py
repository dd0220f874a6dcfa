"""Checks of the keys of a trigger program."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from math import sqrt

from msgspec.structs import fields

from beamcam.machine.dialects import DIALECTS, Dialect
from beamcam.machine.machine import Machine
from beamcam.machine.tables import HeightAxis, Triggers
from beamcam.machine.torch import TorchRow

Fault = tuple[str, object, str]  #: dotted key, what was found, what was expected

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


def _place_faults(triggers: Triggers, dialect: Dialect) -> Iterator[Fault]:
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


def _st_name_faults(triggers: Triggers, dialect: Dialect) -> Iterator[Fault]:
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
