"""Trigger programs of either dialect verified: what their operations do, compared with the part.

text -> operations (controllers/simotion) -> strokes and faults -> compared with the contours

The runtime starts each operation at rest, when the one before it has arrived, so that the tool
follows the lines and arcs of its operations; see `trial` for the proof.
"""

import re
from collections.abc import Collection, Sequence
from itertools import pairwise
from math import dist, inf
from typing import cast

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.checks.polylines import DrawnPath
from beamcam.controllers.simotion import rules
from beamcam.controllers.simotion.axes import circle_points
from beamcam.controllers.simotion.job import JobRead, TableOperation, read_program
from beamcam.controllers.simotion.trial import trial
from beamcam.errors import Diagnostic, Rule, Source, add_few, errors_in
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import PROCESSES
from beamcam.machine.torch import TorchProcess, TorchRow
from beamcam.model.part import Part

#: Where the head goes, as the operations of a chain say it.
_GOES_TO = re.compile(r"x := LREAL#(-?[\d.]+), y := LREAL#(-?[\d.]+)")
BLOCK = 10  #: lines of a program in which the operation is that a line belongs to


def unread(text: str, diagnostics: Sequence[Diagnostic]) -> list[TableOperation]:
    """For messages about lines that cannot be read the operation there, or the one before it."""
    lines = text.splitlines()
    operations = []
    for line in {one.source.line for one in diagnostics if one.source.line}:
        near = [lines[line - 1 : line + 1], lines[max(line - BLOCK, 0) : line][::-1]]
        places = (_GOES_TO.search(row) for rows in near for row in rows)
        if (place := next(filter(None, places), None)) is not None:
            operations.append(TableOperation(line, 0, float(place[1]), float(place[2]), 0.0, None))
    return operations


def with_contours(
    said: Sequence[Diagnostic], operations: Sequence[TableOperation], part: Part, machine: Machine,
    skips: Collection[str],
) -> list[Diagnostic]:  # fmt: skip
    """The messages; to those about an operation the contour nearest to its end is added."""
    from beamcam.checks.sheets.need import need_of, shift_of
    from beamcam.checks.sheets.toolpaths import Toolpaths

    torch = machine.torch
    ends = {operation.line: (operation.x, operation.y) for operation in operations}
    diagnostics = list(said)
    which = [k for k, one in enumerate(diagnostics) if one.source.line in ends]
    if torch is None or not which:
        return diagnostics
    need = need_of(part, machine, torch, skips)
    shift, fine = shift_of(need, torch), torch.tolerance / 8
    toolpaths = {process: Toolpaths(curves, fine, shift) for process, curves in need.curves.items()}
    for k in which if toolpaths else ():
        place = np.array(ends[diagnostics[k].source.line or 0])
        _, way, process = min((*toolpaths[p].nearest_to(place), p) for p in toolpaths)
        contour = f", beside the contour of {need.source(process, way)}"
        diagnostics[k] = replace(diagnostics[k], message=diagnostics[k].message + contour)
    return diagnostics


Place = tuple[float, float]

LINE, ARC, LIFT = 0, 7, 8
SLACK = 1e-6  #: a unit of the last of the six decimals that numbers are written with
LONGEST_ARC = 1.1  #: times its two chords; the runtime allows for no more time


class TableStroke(Struct):
    """The work of the head between tool on and tool off."""

    process: TorchProcess
    line: int
    points: list[Place] = field(default_factory=list)
    feeds_mm_min: tuple[float, ...] = ()  #: the speeds asked of the sheet that it may be of
    moves: list[TableOperation] = field(default_factory=list)
    rows: list[TorchRow] = field(default_factory=list)  #: those that it may be of

    def repeats(self, other: "TableStroke") -> bool:
        """Whether a stroke is made by the same operations as another."""
        said = [
            (s.process, s.points[0], [(m.kind, m.x, m.y, m.speed, m.via) for m in s.moves])
            for s in (self, other)
        ]
        return said[0] == said[1]


class Execution:
    """A trigger program executed: its operations followed one by one, from rest to rest.

    `rows` are those that run on the part's sheet, or all of the machine where no part is known.
    """

    def __init__(self, job: JobRead, machine: Machine, rows: Sequence[TorchRow], name: str) -> None:
        self.job, self.name = job, name
        self.triggers = machine.needed(machine.triggers, "trigger program")
        self.torch = machine.needed(machine.torch, "torch")
        self.rows: dict[str, list[TorchRow]] = {}
        for row in rows:
            self.rows.setdefault(row.process, []).append(row)
        self.diagnostics: list[Diagnostic] = []
        self.strokes: list[TableStroke] = []
        self.here: Place = (0.0, 0.0)
        self.home = self.triggers.home_over(job.thickness)
        self.height = self.home  #: of the torch over the sheet
        self.on: TableStroke | None = None
        self.run: list[TableOperation] = []  #: the last moves of one speed
        self.what, self.shortest = "traverse", inf

    def follow(self) -> None:
        """All operations, from the corner of the work area and back to it."""
        for operation in self.job.operations:
            if operation.kind != LIFT and not self._is_at(operation.height):
                found = f"another height, {operation.height:g} mm, for a line or a switch"
                self.say(rules.HEIGHT, operation.line, found=found, expected=f"{self.height:g} mm")
            if operation.kind in (LINE, ARC):
                self._move(operation)
                continue
            self._judge()
            if operation.kind == LIFT:
                self._lift(operation)
            else:
                self._switch(operation)
        self._judge()
        last = self.job.operations[-1].line if self.job.operations else 1
        if self.on is not None:
            self.say(rules.TOOL, last, found="a tool on at the end", expected="off")
        if self.here != (0.0, 0.0):
            found = f"the end at X {self.here[0]:.3f}, Y {self.here[1]:.3f}"
            self.say(rules.RUN, last, found=found, expected="both axes at 0")
        if not self._is_at(self.home):
            found, expected = f"the end at a height of {self.height:g} mm", f"{self.home:g} mm"
            self.say(rules.HEIGHT, last, found=found, expected=expected)

    def lie_on(self, thickness: float) -> None:
        """Note a thickness of the sheet in the program that is not the part's."""
        if abs(self.job.thickness - thickness) > SLACK:
            found, expected = f"a sheet of {self.job.thickness:g} mm", f"{thickness:g} mm"
            line = self.job.thickness_line
            self.say(rules.HEIGHT, line, found=found, expected=expected)

    def say(self, rule: Rule, line: int, **values: object) -> None:
        """Add a message, unless there are many of the kind already."""
        add_few(self.diagnostics, rule.at(Source(self.name, line), **values))

    # -- tools ------------------------------------------------------------------------------

    def _rests(self, op: TableOperation, what: str) -> None:
        """Note where X or Y of an operation are others than where the head stands."""
        if (op.x, op.y) != self.here or (op.via or self.here) != self.here:
            found, expected = f"X {op.x:g}, Y {op.y:g}", f"X {self.here[0]:g}, Y {self.here[1]:g}"
            self.say(rules.STRAIGHT, op.line, what=what, found=found, expected=expected)

    def _switch(self, op: TableOperation) -> None:
        if not LINE < op.kind < ARC:
            expected = f"0 to {ARC if self.triggers.z is None else LIFT}"
            self.say(rules.COMMAND, op.line, found=f"kind {op.kind}", expected=expected)
            return
        self._rests(op, "switch")
        if op.speed != 0.0:
            self.say(rules.SPEED, op.line, found=f"{op.speed:g}", what="switch", expected="0")
        process = cast("TorchProcess", PROCESSES[(op.kind - 1) // 2])
        if op.kind % 2:
            self._start(process, op.line)
        elif self.on is None or self.on.process != process:
            self.say(rules.TOOL, op.line, found=f"the end of {process}", expected="it started")
        else:
            self.on = None

    def _start(self, process: TorchProcess, line: int) -> None:
        if self.on is not None:
            self.say(rules.TOOL, line, found="two tools on", expected="one")
        rows = self.rows.get(process, [])
        if not rows or process not in self.triggers.outputs:
            found = f"the tool to {process}"
            self.say(rules.TOOL, line, found=found, expected="a tool that the sheet needs")
        waits = self.job.pierce_s[process]
        least = min((row.pierce_s for row in rows), default=0.0)
        if waits < least - SLACK:
            found = f"a wait of {waits:.3f} s behind the start of the tool"
            self.say(rules.TOOL, line, found=found, expected=f"{least:g} s")
        feeds = dict.fromkeys(row.feed_mm_min for row in rows)
        self.on = TableStroke(process, line, [self.here], tuple(feeds), rows=rows)
        self.strokes.append(self.on)
        if self.triggers.z is not None and rows:
            self._at_heights(line, "the tool on", "pierce_height", self.on)

    # -- heights ----------------------------------------------------------------------------

    def _is_at(self, height: float) -> bool:
        return abs(self.height - height) <= SLACK

    def _at_heights(self, line: int, what: str, key: str, on: TableStroke) -> None:
        """Note a height that none of the tool's rows has, and keep the rows that have it."""
        known = [row for row in on.rows if self._is_at(getattr(row, key))]
        if not known:
            heights = dict.fromkeys(f"{getattr(row, key):g} mm" for row in on.rows)
            found = f"{what} at a height of {self.height:g} mm"
            expected = f"{key} {' or '.join(heights)}"
            self.say(rules.HEIGHT, line, found=found, expected=expected)
        on.rows = known or on.rows

    def _lift(self, op: TableOperation) -> None:
        """Up or down: with the tool on once, behind its start, from pierce to cut height."""
        z = self.triggers.z
        if z is None:
            self.say(rules.COMMAND, op.line, found=f"kind {LIFT}", expected=f"0 to {ARC}")
            return
        self._rests(op, "lift")
        if self._is_at(op.height):
            self.say(rules.COMMAND, op.line, found="a lift without length", expected="a way")
        if abs(op.speed - z.speed_mm_s) > SLACK:
            expected = f"{z.speed_mm_s:g}"
            self.say(rules.SPEED, op.line, found=f"{op.speed:g}", what="lift", expected=expected)
        if not 0.0 < op.height <= self.home + SLACK:
            found, expected = f"{z.axis} to {op.height:g} mm", f"above 0 to {self.home:g}"
            self.say(rules.HEIGHT, op.line, found=found, expected=expected)
        self.height = op.height
        if self.on is not None and self.on.moves:
            found = f"a lift to {op.height:g} mm with the tool on"
            self.say(rules.HEIGHT, op.line, found=found, expected="the tool off before it")
        elif self.on is not None and self.on.rows:
            self._at_heights(op.line, "the tool on", "cut_height", self.on)

    def _moves_at(self, op: TableOperation) -> None:
        """Note a way of X and Y elsewhere than at the clearance, or at the height to cut."""
        z = self.triggers.z
        if z is None:
            return
        if self.on is not None:
            if not self.on.moves and self.on.rows:
                self._at_heights(op.line, "a cut", "cut_height", self.on)
        elif not self._is_at(z.clearance):
            found = f"a way with the tool off at a height of {self.height:g} mm"
            self.say(rules.HEIGHT, op.line, found=found, expected=f"{z.clearance:g} mm")

    # -- motion -----------------------------------------------------------------------------

    def _move(self, op: TableOperation) -> None:
        end = op.x, op.y
        self._moves_at(op)
        slack = self.torch.tolerance
        ends = zip(self.triggers.axes, end, (self.torch.length, self.torch.width), strict=True)
        for axis, place, length in ends:
            if not -slack <= place <= length + slack:
                found, expected = f"{axis} to {place:g}", f"0 to {length:g}"
                self.say(rules.COMMAND, op.line, found=found, expected=expected)
        points = [self.here, end]
        if op.kind == ARC:
            points = self._arc(op)
        if end == self.here:
            self.say(rules.COMMAND, op.line, found="a line without length", expected="a way")
        else:
            self._speed(op, dist(self.here, end))
        if self.on is not None:
            self.on.points += points[1:]
            self.on.moves.append(op)
        self.here = end

    def _arc(self, op: TableOperation) -> list[Place]:
        end = op.x, op.y
        if not self.triggers.path_objects or op.via is None:
            self.say(
                rules.COMMAND, op.line, found="an arc", expected="a line, without path objects"
            )
            return [self.here, end]
        points = circle_points(self.here, op.via, end)
        if not points:
            found = "a circle through points in a line (alarm 50002)"
            self.say(rules.COMMAND, op.line, found=found, expected="an arc")
            return [self.here, end]
        chords = dist(self.here, op.via) + dist(op.via, end)
        length = sum(dist(a, b) for a, b in pairwise(points))
        if length > LONGEST_ARC * chords:
            found = f"an arc {length / chords:.3f} times as long as its chords"
            self.say(rules.COMMAND, op.line, found=found, expected=f"at most {LONGEST_ARC} times")
        return points

    def _speed(self, op: TableOperation, way: float) -> None:
        """Note a move; moves of one speed, one after another, are judged together."""
        what = self.on.process if self.on is not None else "traverse"
        if self.run and (self.run[0].speed, self.what) != (op.speed, what):
            self._judge()
        self.run.append(op)
        self.what, self.shortest = what, min(self.shortest, way)

    def _judge(self) -> None:
        """Within the speeds of the tool; chords of a curve may take the time of their cycles.

        All chords of a curve have the speed that its shortest one allows. What a sheet is worked
        at by several speeds has one of them in each stroke.
        """
        if not self.run:
            return
        op, t, on = self.run[0], self.triggers, self.on
        programmed = (t.traverse_mm_s * 60.0,) if on is None else on.feeds_mm_min or (0.0,)
        cycles = self.shortest / (t.cycles_per_chord * t.cycle_s)
        fits = tuple([feed for feed in programmed if _is_of(op.speed, feed / 60.0, cycles)])
        if not fits:
            feeds = [feed / 60.0 for feed in programmed]
            expected = f"above 0 and at most {max(feeds):g}"
            if 0.0 < op.speed <= max(feeds) + SLACK:
                expected = " or ".join(f"{min(feed, cycles):g}" for feed in sorted(feeds))
            self.say(rules.SPEED, op.line, found=f"{op.speed:g}", what=self.what, expected=expected)
        if on is not None:
            on.feeds_mm_min = fits or programmed
        self.run, self.shortest = [], inf


def _is_of(speed: float, programmed: float, by_cycles: float) -> bool:
    """Whether a run of moves has a speed in mm/s, or the one that its cycles allow.

    A run that is not slowed has a greater one by its cycles than is asked.
    """
    return speed > 0.0 and min(programmed, by_cycles) - SLACK <= speed <= programmed + SLACK


def verify_triggers(
    text: str, parts: Sequence[Part], machine: Machine, skips: Collection[str] = (),
    name: str = "program", head: str = "",
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """All faults of a trigger program, by itself and against its part.

    `head` is the text whose head has to say where sound parts lie, if one has to. Nothing comes
    back for a program that makes exactly the part.
    """
    from beamcam.checks.sheets.asked_sheet import rows_of, thickness_of

    torch = machine.needed(machine.torch, "trigger program")
    triggers = machine.needed(machine.triggers, "trigger program")
    job, diagnostics = read_program(text, machine, name)
    if job is None:
        if not parts:
            return tuple(diagnostics)

        return tuple(
            with_contours(diagnostics, unread(text, diagnostics), parts[0], machine, skips)
        )
    execution = Execution(job, machine, rows_of(parts[0], torch) if parts else torch.rows, name)
    if parts and triggers.z is not None:
        execution.lie_on(thickness_of(parts[0], torch))
    execution.follow()
    diagnostics = [*trial(machine), *execution.diagnostics]
    if not parts:
        return tuple(diagnostics)
    if errors_in(diagnostics):
        return tuple(with_contours(diagnostics, job.operations, parts[0], machine, skips))
    from beamcam.checks.polylines import compare_polylines
    from beamcam.checks.sheets.compare import with_told
    from beamcam.checks.sheets.shared_sheet import as_one

    sheet = as_one(parts, machine, skips)
    ways = _ways(execution.strokes, any(row.passes > 1 for row in rows_of(sheet.part, torch)))
    more = compare_polylines(ways, sheet.part, sheet.machine, skips, triggers.in_position, name)
    return with_told(
        (*diagnostics, *sheet.diagnostics, *more), head, parts, sheet.places, machine, skips, name
    )


def _ways(strokes: Sequence[TableStroke], counts_passes: bool) -> list[DrawnPath]:
    """What the head draws; a stroke that repeats the one before it is another pass of that."""
    ways: list[DrawnPath] = []
    for k, stroke in enumerate(strokes):
        if counts_passes and k and stroke.repeats(strokes[k - 1]):
            ways[-1] = replace(ways[-1], passes=ways[-1].passes + 1)
        else:
            ways.append(DrawnPath(stroke.process, stroke.points, stroke.feeds_mm_min))
    return ways
