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
    diagnostics: Sequence[Diagnostic], operations: Sequence[TableOperation], part: Part,
    machine: Machine, skips: Collection[str],
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """The messages; to those about an operation the contour nearest to its end is added."""
    from beamcam.checks.sheets.need import need_of, shift_of

    torch = machine.torch
    ends = {operation.line: (operation.x, operation.y) for operation in operations}
    placed = list(diagnostics)
    which = [k for k, one in enumerate(placed) if one.source.line in ends]
    if torch is None or not which:
        return tuple(placed)
    need = need_of(part, machine, torch, skips)
    shift, fine = shift_of(need, torch), torch.tolerance / 8
    toolpaths = {process: need.toolpaths(process, fine).moved(shift) for process in need.curves}
    for k in which if toolpaths else ():
        place = np.array(ends[placed[k].source.line or 0])
        _, way, process = min((*toolpaths[p].nearest_to(place), p) for p in toolpaths)
        contour = f", beside the contour of {need.source(process, way)}"
        placed[k] = replace(placed[k], message=placed[k].message + contour)
    return tuple(placed)


Place = tuple[float, float]

LINE, ARC, LIFT = 0, 7, 8
SLACK = 1e-6  #: a unit of the last of the six decimals that numbers are written with
LONGEST_ARC = 1.1  #: times its two chords; the runtime allows for no more time


class TableStroke(Struct):
    """The work of the head between tool on and tool off."""

    process: TorchProcess
    line: int
    points: list[Place] = field(default_factory=list)
    feeds_mm_min: tuple[float, ...] = ()  #: the speeds of the sheet that it may be of
    moves: list[TableOperation] = field(default_factory=list)
    rows: list[TorchRow] = field(default_factory=list)  #: those that it may be of


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
        self.line = 1  #: of the operation that is executed

    def follow(self) -> None:
        """All operations, from the corner of the work area and back to it."""
        for op in self.job.operations:
            self.line = op.line
            if op.kind != LIFT and not self._is_at(op.height):
                found = f"another height, {op.height:g} mm, for a line or a switch"
                self.say(rules.HEIGHT, found, f"{self.height:g} mm")
            if op.kind in (LINE, ARC):
                self._move(op)
                continue
            self._judge()
            if op.kind == LIFT:
                self._lift(op)
            else:
                self._switch(op)
        self._judge()
        if self.on is not None:
            self.say(rules.TOOL, "a tool on at the end", "off")
        if self.here != (0.0, 0.0):
            found = f"the end at X {self.here[0]:.3f}, Y {self.here[1]:.3f}"
            self.say(rules.RUN, found, "both axes at 0")
        if not self._is_at(self.home):
            found = f"the end at a height of {self.height:g} mm"
            self.say(rules.HEIGHT, found, f"{self.home:g} mm")

    def say(
        self, rule: Rule, found: str, expected: str, line: int | None = None, **values: object
    ) -> None:
        """Add a message about an operation, unless there are many of the kind already."""
        source = Source(self.name, self.line if line is None else line)
        add_few(self.diagnostics, rule.at(source, found=found, expected=expected, **values))

    # -- tools ------------------------------------------------------------------------------

    def _check_rest(self, op: TableOperation, what: str) -> None:
        """Report an operation whose X or Y are others than where the head stands."""
        if (op.x, op.y) != self.here or (op.via or self.here) != self.here:
            expected = f"X {self.here[0]:g}, Y {self.here[1]:g}"
            self.say(rules.STRAIGHT, f"X {op.x:g}, Y {op.y:g}", expected, what=what)

    def _switch(self, op: TableOperation) -> None:
        if not LINE < op.kind < ARC:
            greatest = ARC if self.triggers.z is None else LIFT
            self.say(rules.COMMAND, f"kind {op.kind}", f"0 to {greatest}")
            return
        self._check_rest(op, "switch")
        if op.speed != 0.0:
            self.say(rules.SPEED, f"{op.speed:g}", "0", what="switch")
        process = cast("TorchProcess", PROCESSES[(op.kind - 1) // 2])
        if op.kind % 2:
            self._start(process)
        elif self.on is None or self.on.process != process:
            self.say(rules.TOOL, f"the end of {process}", "it started")
        else:
            self.on = None

    def _start(self, process: TorchProcess) -> None:
        if self.on is not None:
            self.say(rules.TOOL, "two tools on", "one")
        rows = self.rows.get(process, [])
        if not rows or process not in self.triggers.outputs:
            self.say(rules.TOOL, f"the tool to {process}", "a tool that the sheet needs")
        waits = self.job.pierce_s[process]
        least = min((row.pierce_s for row in rows), default=0.0)
        if waits < least - SLACK:
            found = f"a wait of {waits:.3f} s behind the start of the tool"
            self.say(rules.TOOL, found, f"{least:g} s")
        feeds = dict.fromkeys(row.feed_mm_min for row in rows)
        self.on = TableStroke(process, self.line, [self.here], tuple(feeds), rows=rows)
        self.strokes.append(self.on)
        if self.triggers.z is not None and rows:
            self._check_height("the tool on", "pierce_height", self.on)

    # -- heights ----------------------------------------------------------------------------

    def _is_at(self, height: float) -> bool:
        return abs(self.height - height) <= SLACK

    def _check_height(self, what: str, key: str, on: TableStroke) -> None:
        """Report a height that none of the tool's rows has, and keep the rows that have it."""
        known = [row for row in on.rows if self._is_at(getattr(row, key))]
        if not known:
            heights = dict.fromkeys(f"{getattr(row, key):g} mm" for row in on.rows)
            found = f"{what} at a height of {self.height:g} mm"
            self.say(rules.HEIGHT, found, f"{key} {' or '.join(heights)}")
        on.rows = known or on.rows

    def _lift(self, op: TableOperation) -> None:
        """Up or down: with the tool on once, behind its start, from pierce to cut height."""
        z = self.triggers.z
        if z is None:
            self.say(rules.COMMAND, f"kind {LIFT}", f"0 to {ARC}")
            return
        self._check_rest(op, "lift")
        if self._is_at(op.height):
            self.say(rules.COMMAND, "a lift without length", "a way")
        if abs(op.speed - z.speed_mm_s) > SLACK:
            self.say(rules.SPEED, f"{op.speed:g}", f"{z.speed_mm_s:g}", what="lift")
        if not 0.0 < op.height <= self.home + SLACK:
            self.say(rules.HEIGHT, f"{z.axis} to {op.height:g} mm", f"above 0 to {self.home:g}")
        self.height = op.height
        if self.on is not None and self.on.moves:
            found = f"a lift to {op.height:g} mm with the tool on"
            self.say(rules.HEIGHT, found, "the tool off before it")
        elif self.on is not None and self.on.rows:
            self._check_height("the tool on", "cut_height", self.on)

    # -- motion -----------------------------------------------------------------------------

    def _move(self, op: TableOperation) -> None:
        end, z, on = (op.x, op.y), self.triggers.z, self.on
        if z is not None and on is not None:
            if not on.moves and on.rows:
                self._check_height("a cut", "cut_height", on)
        elif z is not None and not self._is_at(z.clearance):
            found = f"a way with the tool off at a height of {self.height:g} mm"
            self.say(rules.HEIGHT, found, f"{z.clearance:g} mm")
        slack = self.torch.tolerance
        ends = zip(self.triggers.axes, end, (self.torch.length, self.torch.width), strict=True)
        for axis, place, length in ends:
            if not -slack <= place <= length + slack:
                self.say(rules.COMMAND, f"{axis} to {place:g}", f"0 to {length:g}")
        points = [self.here, end]
        if op.kind == ARC:
            points = self._arc(op)
        if end == self.here:
            self.say(rules.COMMAND, "a line without length", "a way")
        else:
            # Moves of one speed, one after another, are judged together.
            what = on.process if on is not None else "traverse"
            if self.run and (self.run[0].speed, self.what) != (op.speed, what):
                self._judge()
            self.run.append(op)
            self.what, self.shortest = what, min(self.shortest, dist(self.here, end))
        if on is not None:
            on.points += points[1:]
            on.moves.append(op)
        self.here = end

    def _arc(self, op: TableOperation) -> list[Place]:
        end = op.x, op.y
        if not self.triggers.path_objects or op.via is None:
            self.say(rules.COMMAND, "an arc", "a line, without path objects")
            return [self.here, end]
        points = circle_points(self.here, op.via, end)
        if not points:
            self.say(rules.COMMAND, "a circle through points in a line (alarm 50002)", "an arc")
            return [self.here, end]
        chords = dist(self.here, op.via) + dist(op.via, end)
        length = sum(dist(a, b) for a, b in pairwise(points))
        if length > LONGEST_ARC * chords:
            found = f"an arc {length / chords:.3f} times as long as its chords"
            self.say(rules.COMMAND, found, f"at most {LONGEST_ARC} times")
        return points

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
            self.say(rules.SPEED, f"{op.speed:g}", expected, op.line, what=self.what)
        if on is not None:
            on.feeds_mm_min = fits or programmed
        self.run, self.shortest = [], inf


def _is_of(speed: float, programmed: float, by_cycles: float) -> bool:
    """Whether a run of moves has a speed in mm/s, or the one that its cycles allow.

    A run that is not slowed has a greater one by its cycles than is programmed.
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
        operations = unread(text, diagnostics)
        return with_contours(diagnostics, operations, parts[0], machine, skips)
    execution = Execution(job, machine, rows_of(parts[0], torch) if parts else torch.rows, name)
    if parts and triggers.z is not None:
        thickness = thickness_of(parts[0], torch)
        if abs(job.thickness - thickness) > SLACK:
            found, line = f"a sheet of {job.thickness:g} mm", job.thickness_line
            execution.say(rules.HEIGHT, found, f"{thickness:g} mm", line)
    execution.follow()
    diagnostics = [*trial(machine), *execution.diagnostics]
    if not parts:
        return tuple(diagnostics)
    if errors_in(diagnostics):
        return with_contours(diagnostics, job.operations, parts[0], machine, skips)
    from beamcam.checks.polylines import compare_polylines
    from beamcam.checks.sheets.compare import with_head_faults
    from beamcam.checks.sheets.required_layout import as_one

    sheet = as_one(parts, machine, skips)
    drawn = _drawn(execution.strokes, any(row.passes > 1 for row in rows_of(sheet.part, torch)))
    more = compare_polylines(drawn, sheet.part, sheet.machine, skips, triggers.in_position, name)
    return with_head_faults(
        (*diagnostics, *sheet.diagnostics, *more), head, parts, sheet.places, machine, skips, name
    )


def _drawn(strokes: Sequence[TableStroke], counts_passes: bool) -> list[DrawnPath]:
    """What the head draws; a stroke by the same operations as the one before is another pass."""
    drawn: list[DrawnPath] = []
    before: object = None
    for stroke in strokes:
        moves = [(m.kind, m.x, m.y, m.speed, m.via) for m in stroke.moves]
        work = stroke.process, stroke.points[0], moves
        if counts_passes and work == before:
            drawn[-1] = replace(drawn[-1], passes=drawn[-1].passes + 1)
        else:
            drawn.append(DrawnPath(stroke.process, stroke.points, stroke.feeds_mm_min))
        before = work
    return drawn
