"""Work time, from the words and the speeds of the machine file.

Each operation is gone through block by block as its words will be written, on the model of the
cell by which a finished program is simulated, so that both give the same times:

    M40 K2 L22           choose: another spindle, another tool
    G00 X1098.56 Y20     the slowest of the axes that move
    M03, G01 .. F, M05   the spindle runs up, the stroke at its feed, the spindle stops

Where the operator goes meanwhile is not in it.
"""

import re
from collections.abc import Mapping, Sequence
from math import hypot, isnan, nan
from typing import Literal, cast

from msgspec import Struct
from msgspec.structs import replace

from beamcam.machine.machine import ControlledAxis, Machine, drill_of, saw_of
from beamcam.machine.stations import Drill, speed_and_feed
from beamcam.model.cell_motion import SECONDS_PER_MINUTE, CellMotion, StrokeGeometry
from beamcam.model.cycles import (
    BREAK_CHIPS,
    DRILL,
    DRILL_AND_DWELL,
    DRILLING,
    PECK,
    clear_place,
    cycle_moves,
)
from beamcam.model.plan import Operation, PathOp, Piece, Plan, SawOp, SpindleOp, TextOp, WorkTime
from beamcam.planning.order import tool_loads

Moves = Literal["X", "Y", "Z", "angle", "saw"]
UNKNOWN_MM_S2 = 1000.0  #: of an axis that the machine's file does not have
_COMMAND = re.compile(r"\s*([GM])0*(\d+)")
_WORD = re.compile(r"\b([A-Z])(?:\{(\w+)\}|(-?\d+(?:\.\d*)?))")
_NUMBERS = ("G", "M", "N")
_CYCLES = {
    "drill-cycle": DRILL, "drill-cycle-dwell": DRILL_AND_DWELL,
    "drill-cycle-peck": PECK, "drill-cycle-chips": BREAK_CHIPS,
}  # fmt: skip
_RUNS = {3: True, 4: True, 5: False}  #: M words of the controller that start and stop a spindle


class TemplateLine(Struct, frozen=True):
    """A line of a template."""

    command: str  #: "G", "M" or "" where there is none
    number: int
    names: Mapping[str, str]  #: letter, and the placeholder in its braces
    fixed: Mapping[str, float]  #: letter and number

    def words(self, values: Mapping[str, float]) -> dict[str, float]:
        """The letters and their numbers, where placeholders have `values`."""
        stated = {letter: values[name] for letter, name in self.names.items() if name in values}
        return {**self.fixed, **stated}


def blocks_of(template: Sequence[str]) -> tuple[TemplateLine, ...]:
    """The lines of a template, taken apart."""
    blocks = []
    for line in template:
        match = _COMMAND.match(line)
        words = [w for w in _WORD.findall(line) if w[1] or w[0] not in _NUMBERS]
        blocks.append(
            TemplateLine(
                match[1] if match else "",
                int(match[2]) if match else -1,
                {letter: name for letter, name, _ in words if name},
                {letter: float(number) for letter, name, number in words if not name},
            )
        )
    return tuple(blocks)


def work_time(plan: Plan, machine: Machine) -> WorkTime:
    """Work time of a plan on its machine."""
    clock = _CellClock(plan.pieces, machine)
    seconds = tuple(clock.seconds(op) for op in plan.operations)
    reloads = sum(load.out is not None for load in tool_loads(plan.operations, machine))
    return WorkTime(seconds, reloads * machine.times.manual_change_s)


def with_axes(machine: Machine, drill: Drill) -> Machine:
    """The machine with usual axes in place of those that its file does not have."""
    needed: list[tuple[str, int | None]] = [("X", None)]
    if machine.saw is not None:
        needed += [("angle", None), ("saw", None)]
    for spindle in machine.spindles:
        needed += [(spindle.across.axis, spindle.number), (spindle.stroke.axis, spindle.number)]
    known = {(axis.moves, axis.spindle) for axis in machine.axes}
    missing = [key for key in needed if key not in known]
    if not missing:
        return machine
    rapid = drill.max_feed_mm_min / SECONDS_PER_MINUTE
    usual = tuple(
        ControlledAxis("", cast("Moves", moves), rapid, UNKNOWN_MM_S2, spindle)
        for moves, spindle in missing
    )
    return replace(machine, axes=(*machine.axes, *usual))


class _CellClock:
    """The state of the machine during the operations."""

    def __init__(self, pieces: Sequence[Piece], machine: Machine) -> None:
        profile = pieces[0].part.profile
        self._machine, self._saw, self._drill = machine, saw_of(machine), drill_of(machine)
        # What a program does not say of the section its simulation does not know either.
        machine = with_axes(machine, self._drill)
        header = " ".join(machine.words.header)
        height_alone = "{height}" in header and "{width}" not in header
        self._cell = CellMotion(machine, profile.height if height_alone else profile.width)
        self._grades = [piece.part.grade for piece in pieces]
        self._strokes = StrokeGeometry(profile, machine)
        self._words: dict[str, tuple[TemplateLine, ...]] = {}
        #: The canned cycle that each G word of the machine's controller stands for.
        self._cycles = {
            int(code[1:]): _CYCLES[meaning]
            for code, meaning in machine.codes.items()
            if meaning in _CYCLES
        }
        #: Whether the header says that cycles draw back no further than R (G99 of RS274).
        self._back_to_approach = False
        if machine.controller == "linuxcnc":
            self._cycles = {number: number for number in DRILLING}
            self._back_to_approach = re.findall(r"\bG9[89]\b", header)[-1:] == ["G99"]
        self._place = {"X": nan, "Y": nan, "Z": nan}
        self._rapid, self._feed_mm_min = True, 0.0

    def seconds(self, op: Operation) -> float:
        """Time of the next operation."""
        if isinstance(op, SawOp):
            feed = self._saw.feed_mm_min
            return self._run("saw", {"x": op.x, "angle": op.angle, "tilt": op.tilt, "feed": feed})
        if isinstance(op, TextOp):
            template = getattr(self._machine.words, op.tool.kind)
            before = blocks_of([line for line in template if "{string}" not in line])
            way = sum(self._block(block, {"x": op.x}, op.tool.kind) for block in before)
            return way + self._machine.times.text_s
        kind = op.tool.kind
        _, feed_mm_min = speed_and_feed(op.tool, self._drill, self._grades[op.features[0][0]])
        values = {
            "spindle": op.spindle, "tool": 0.0, "diameter": op.tool.diameter, "feed": feed_mm_min,
            "peck": op.tool.max_peck,
        }  # fmt: skip
        if not isinstance(op, PathOp):
            return self._run(kind, values | self._places(op, op.x, op.y), kind)
        total = 0.0
        for index, (x, y) in enumerate(op.path):
            values |= self._places(op, x, y)
            total += self._run(f"{kind}_to" if index else kind, values, kind)
        return total + self._run(f"{kind}_end", values, kind)

    def _places(self, op: SpindleOp, x: float, y: float) -> dict[str, float]:
        retract, approach, bottom = self._strokes.places(op, y)
        return {
            "x": x, "y": retract[0], "z": retract[1], "near_y": approach[0], "near_z": approach[1],
            "bottom_y": bottom[0], "bottom_z": bottom[1],
        }  # fmt: skip

    def _run(self, name: str, values: Mapping[str, float], kind: str = "") -> float:
        blocks = self._words.get(name)
        if blocks is None:
            blocks = self._words[name] = blocks_of(getattr(self._machine.words, name))
        return sum(self._block(block, values, kind) for block in blocks)

    def _block(self, block: TemplateLine, values: Mapping[str, float], kind: str) -> float:
        stated = {name: values[name] for name in block.names.values() if name in values}
        if block.command == "M":
            if "angle" in stated:
                legs = self._cell.cut(stated["angle"], stated.get("tilt", 0.0), stated.get("feed"))
                return sum(leg.duration_s for leg, _ in legs)
            if "spindle" in stated or "tool" in stated:
                # A number of a tool says its size, and stands alone where there is one spindle.
                known = values if "tool" in stated else stated
                return self._cell.choose(int(values["spindle"]), kind, known.get("diameter", 0.0))
            if block.number in _RUNS:
                return self._cell.switch(_RUNS[block.number])
            return 0.0
        if block.command == "G":
            if block.number in self._cycles:
                cycle = self._cycles[block.number]
                words = block.words(values)
                self._feed_mm_min = words.get("F", self._feed_mm_min)
                at = self._place["X"], self._place["Y"], self._place["Z"]
                place = words.get("X", at[0]), words.get("Y", at[1])
                approach, bottom = words["R"], words["Z"]
                clear = clear_place(at[2], approach, bottom, self._back_to_approach)
                seconds = words.get("P", 0.0) if cycle == DRILL_AND_DWELL else 0.0
                peck = words.get("Q", 0.0)
                for rapid, end in cycle_moves(
                    at, place, bottom, approach, clear, at[2], cycle, peck
                ):
                    self._rapid = rapid
                    to = {letter: v for letter, v in zip("XYZ", end, strict=True) if not isnan(v)}
                    seconds += self._go(to)
                return seconds
            if block.number not in (0, 1):
                return 0.0
            self._rapid = block.number == 0
        if "feed" in stated:
            self._feed_mm_min = stated["feed"]
        words = block.words(values)
        return self._go({letter: words[letter] for letter in "XYZ" if letter in words})

    def _go(self, to: Mapping[str, float]) -> float:
        gone = [to[letter] - self._place[letter] for letter in to]
        way = hypot(*(d for d in gone if not isnan(d)))
        self._place |= to
        return self._cell.move(to, way, None if self._rapid else self._feed_mm_min).duration_s
