"""Checks of a machine's stations and tools that involve several keys."""

from collections.abc import Iterator
from math import sqrt

from beamcam.machine.machine import Machine
from beamcam.machine.range_faults import Fault, trigger_faults
from beamcam.machine.stations import FLAT_DEG, Saw, Spindle, ToolSet, inch_size
from beamcam.machine.tables import DIALECTS, STEP_FORMS
from beamcam.machine.torch import Torch
from beamcam.machine.words import body_faults

#: Kinds of tools whose speed or feed comes from `drill.cutting`.
TURNING = ("drill", "tap", "countersink", "mill", "punch", "scribe")
#: Kinds of tools that follow a path, for which the bar has to move forward and back.
ALONG_A_PATH = ("mill", "scribe")


def tool_faults(machine: Machine) -> Iterator[Fault]:
    """Each key that contradicts another."""
    saw, drill, layout = machine.saw, machine.drill, machine.layout
    if saw and drill and layout:
        if layout.order == "saw-drill" and drill.x < saw.x:
            yield "drill.x", drill.x, "at least saw.x, since the bar reaches the saw first"
        if layout.order == "drill-saw" and drill.x > saw.x:
            yield "drill.x", drill.x, "at most saw.x, since the bar reaches the drill first"
    if saw and saw.min_angle > saw.max_angle:
        yield "saw.min_angle", saw.min_angle, "at most saw.max_angle"
    if saw and saw.min_tilt > saw.max_tilt:
        yield "saw.min_tilt", saw.min_tilt, "at most saw.max_tilt"
    if saw and saw.min_tilt != saw.max_tilt and not _names(machine.words.saw, "tilt"):
        yield "words.saw", list(machine.words.saw), "a word with {tilt}, since the blade tilts"
    if saw:
        yield from _square_faults(saw, machine)
    if drill is None and machine.stock == "beam" and machine.tools:
        yield "tools", len(machine.tools), "none, or a [drill] table for them"
    for index, axis in enumerate(machine.axes):
        if axis.min is not None and axis.max is not None and axis.min > axis.max:
            yield f"axes.{index}.min", axis.min, "at most max"
    for index, tools in enumerate(machine.tools):
        yield from _set_faults(f"tools.{index}", tools)
        for word in words_of(tools.kind):
            if not getattr(machine.words, word):
                yield f"words.{word}", [], f"a template, since there are tools of kind {tools.kind}"
        if tools.kind in ALONG_A_PATH and layout and layout.order == "saw-drill":
            yield f"tools.{index}.kind", tools.kind, "a tool for strokes, since X only grows"
        if (
            tools.kind in TURNING
            and drill
            and not any(row.kind == tools.kind for row in drill.cutting)
        ):
            yield "drill.cutting", tools.kind, f"a row with kind = {tools.kind!r}"


def _square_faults(saw: Saw, machine: Machine) -> Iterator[Fault]:
    """Each limit that keeps the saw from a square cut, which every bar needs."""
    for key, limit, square in (
        ("min_angle", saw.min_angle, saw.zero_angle), ("min_tilt", saw.min_tilt, 0.0),
    ):  # fmt: skip
        if limit > square:
            yield f"saw.{key}", limit, f"at most {square:g}, the square cut"
    for key, limit, square in (
        ("max_angle", saw.max_angle, saw.zero_angle), ("max_tilt", saw.max_tilt, 0.0),
    ):  # fmt: skip
        if limit < square:
            yield f"saw.{key}", limit, f"at least {square:g}, the square cut"
    for index, axis in enumerate(machine.axes):
        if axis.moves == "angle" and axis.spindle is None:
            if axis.min is not None and axis.min > saw.zero_angle:
                yield f"axes.{index}.min", axis.min, f"at most {saw.zero_angle:g}, the square cut"
            if axis.max is not None and axis.max < saw.zero_angle:
                yield f"axes.{index}.max", axis.max, f"at least {saw.zero_angle:g}, the square cut"


#: Controllers that run a saw and drilling line; a cutting table may have any.
_OF_LINES = ("codesys", "linuxcnc")


def number_faults(machine: Machine) -> Iterator[Fault]:
    """A controller of another kind of machine, tools without a number or a peck of their words."""
    if machine.stock == "beam" and machine.controller not in _OF_LINES:
        yield "controller", machine.controller, f"{' or '.join(_OF_LINES)}, which run a line"
    for index, tools in enumerate(machine.tools):
        key = f"tools.{index}.numbers"
        if tools.numbers and len(tools.numbers) != len(tools.sizes):
            yield key, list(tools.numbers), f"{len(tools.sizes)}, one for each diameter"
        if not tools.numbers and _names(getattr(machine.words, tools.kind), "tool"):
            yield key, [], f"one for each diameter, since words.{tools.kind} has {{tool}}"
        yield from _peck_faults(f"tools.{index}.max_peck", tools, machine)
    numbers = [number for tools in machine.tools for number in tools.numbers]
    if len(numbers) != len(set(numbers)):
        yield "tools", sorted(n for n in set(numbers) if numbers.count(n) > 1), "a number once"


def _peck_faults(key: str, tools: ToolSet, machine: Machine) -> Iterator[Fault]:
    """A depth fed at a time that the words do not write, and one that they lack."""
    pecks = _names(getattr(machine.words, tools.kind), "peck")
    if tools.max_peck and tools.kind != "drill":
        yield key, tools.max_peck, "no such key, only drills are drawn back on their way"
    elif tools.max_peck and not pecks:
        expected = f"a word with {{peck}} in words.{tools.kind}, which feeds to the depth at once"
        yield key, tools.max_peck, expected
    elif pecks and not tools.max_peck:
        yield key, tools.max_peck, f"a depth above 0, since words.{tools.kind} has {{peck}}"


def _names(template: tuple[str, ...], name: str) -> bool:
    return any("{" + name + "}" in line for line in template)


def words_of(kind: str) -> tuple[str, ...]:
    """The templates of a kind of tool, in the order of its work."""
    return (kind, f"{kind}_to", f"{kind}_end") if kind in ALONG_A_PATH else (kind,)


def _set_faults(key: str, tools: ToolSet) -> Iterator[Fault]:
    for index, text in enumerate(tools.inches):
        try:
            inch_size(text)
        except ValueError:
            yield f"{key}.inches.{index}", text, "inches such as '13/16' or '1 1/16'"
            return
    if not all(size > 0 for size in tools.sizes):
        yield f"{key}.diameters", list(tools.sizes), "diameters above 0"
    if not tools.sizes:
        yield f"{key}.diameters", [], "at least one diameter"
    if tools.point_deg > FLAT_DEG:
        yield f"{key}.point_deg", tools.point_deg, "at most 180, which is flat"
    if tools.kind == "tap":
        for name, values in (("pitches", tools.pitches), ("pre_drills", tools.pre_drills)):
            if len(values) != len(tools.sizes):
                yield f"{key}.{name}", list(values), f"{len(tools.sizes)}, one for each diameter"
            elif not all(value > 0 for value in values):
                yield f"{key}.{name}", list(values), "sizes above 0"
        for size, before in zip(tools.sizes, tools.pre_drills, strict=False):
            if before >= size:
                yield f"{key}.pre_drills", before, f"less than the thread's {size:g}"


#: of a program's numbers that a kerf takes at least, so that half of it is a figure
KERF_STEPS = 10
#: Words that a machine with a torch cannot do without.
_TORCH_WORDS = ("traverse", "feed", "cut_on", "cut_off")


#: Controllers driven by a table or a chain of triggers, which have no words.
TABLE_CONTROLLERS = (*DIALECTS, "stepper")


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
    if torch.overscan and not (torch.laser_mode and _names(words.power, "power")):
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
        paces = words.pace or (words.slow and words.full) or _names(words.modal, "feed")
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
    needs = _names(machine.words.modal, "acceleration")
    if needs and not (torch.acceleration and "X" in axes):
        names = list(machine.words.modal)
        yield "words.modal", names, "torch.acceleration and axes X and Y for {acceleration}"


def spindle_faults(machine: Machine) -> Iterator[Fault]:
    """Spindles that lack a drill or their own axis, and pairs that lack a spindle."""
    faces = {spindle.face for spindle in machine.spindles}
    for index, pair in enumerate(machine.pairs):
        if not faces.issuperset(pair.faces):
            yield f"pairs.{index}.faces", list(pair.faces), "faces that have a spindle"
    for index, spindle in enumerate(machine.spindles):
        if spindle.across.axis == spindle.stroke.axis:
            yield f"spindles.{index}.stroke.axis", spindle.stroke.axis, "another axis"
        if not _follows_y(spindle):
            expected = "arithmetic with y, so that each y of a face has its own place"
            yield f"spindles.{index}.across.position", str(spindle.across.position), expected
        elif machine.drill is None:
            yield f"spindles.{index}", spindle.name, "a [drill] table for it"
        elif _drawn_back(machine, spindle) < 0.0:
            expected = "a place outside of the bar, where the tool is drawn back"
            yield f"spindles.{index}.stroke.retract", spindle.stroke.retract, expected


def _follows_y(spindle: Spindle) -> bool:
    """Whether a spindle moves across with the holes' y, by as much at every place."""
    bar = {**_SAMPLE_BAR, "depth": 10.0, "tip": 5.0, "clearance": 5.0}
    places = [spindle.across.position({**bar, "y": y}) for y in (10.0, 11.0, 111.0)]
    per_mm = places[1] - places[0]
    return per_mm != 0.0 and abs(places[2] - places[1] - 100.0 * per_mm) < 1e-6


#: A bar on which a spindle has to stand clear; nothing lies beside the face.
_SAMPLE_BAR = {
    "height": 200.0, "width": 100.0, "flange_thickness": 10.0, "web_thickness": 6.0,
    "thickness": 10.0, "face_depth": 0.0, "y": 50.0, "depth": 0.0, "tip": 0.0,
}  # fmt: skip


def _drawn_back(machine: Machine, spindle: Spindle) -> float:
    """Clearance of the tool from the bar between two strokes, in mm; negative inside the bar."""
    values = {**_SAMPLE_BAR, "clearance": machine.drill.clearance if machine.drill else 0.0}
    start, surface = spindle.stroke.retract(values), spindle.stroke.bottom(values)
    deeper = spindle.stroke.bottom({**values, "depth": 1.0})
    if deeper == surface:  # a fixed stroke, from 0 on the bar
        return -start if surface >= start else start
    return surface - start if deeper > surface else start - surface


def pair_faults(machine: Machine) -> Iterator[Fault]:
    """Each formula of a pair's second spindle that is another than the first one's.

    A pair has one block for both, with one place across and one stroke.
    """
    spindles: dict[str, int] = {s.face: index for index, s in enumerate(machine.spindles)}
    for pair in machine.pairs:
        first, index = (spindles[face] for face in pair.faces)
        theirs = _moved_by(machine.spindles[first])
        for key, found in _moved_by(machine.spindles[index]).items():
            if found != theirs[key]:
                expected = f"{theirs[key]!r} as the other spindle of {pair.name!r} has, or no pair"
                yield f"spindles.{index}.{key}", found, expected


def _moved_by(spindle: Spindle) -> dict[str, str]:
    """The axes and formulas of a spindle, by their keys."""
    across, stroke = spindle.across, spindle.stroke
    return {
        "across.axis": across.axis, "across.position": across.position, "stroke.axis": stroke.axis,
        "stroke.retract": stroke.retract, "stroke.approach": stroke.approach or stroke.retract,
        "stroke.bottom": stroke.bottom,
    }  # fmt: skip


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


def view_faults(machine: Machine) -> Iterator[Fault]:
    """Keys of what is seen of a machine, its bodies and its registers, that contradict others."""
    names = frozenset(axis.name for axis in machine.axes)
    if not names and machine.stock == "sheet":
        lifts = machine.torch is not None and machine.torch.z == "program"
        letters = "XYZ" if lifts else "XY"
        names = frozenset(machine.triggers.all_axes if machine.triggers else letters)
    yield from body_faults(machine.bodies, names)
    modbus, count = machine.modbus, len(names)
    if modbus.scales and len(modbus.scales) != count:
        yield "modbus.scales", len(modbus.scales), f"{count}, one for each axis"
    if modbus.first + count * modbus.words + 6 > 65536:
        yield "modbus.first", modbus.first, "an address whose registers end by 65535"
