"""The strokes of a program: the work of the head between tool on and tool off.

The words that start and stop a tool are the machine's own, filled with the figures of a row; a
program that says anything else, or moves as it should not, is reported.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.asked_sheet import RowWords, words_of
from beamcam.checks.sheets.controller_state import ControllerState, Setting, Watch
from beamcam.checks.sheets.feeds import expected_feeds, near_corners
from beamcam.controllers.dialect import IDLE_SWITCHES, SHEET_END, STOPS
from beamcam.controllers.events import (
    Other,
    Output,
    Pause,
    Said,
    Side,
    Switch,
)
from beamcam.controllers.moves import Moves, TableRun
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.curves import Arc
from beamcam.machine.machine import Machine, key_for
from beamcam.machine.torch import Torch, TorchProcess, TorchRow

ENDS = (2, 30)
_TURNING = (3, 4, 5)  #: M words of a spindle or a tool
FEED_SLACK = 1e-3
LOWERED_SLACK = 5e-3  #: of a feed that follows from a curve whose numbers are rounded
FEED_ROUNDING = 0.0006  #: of a feed as it is written, whatever its unit
FAR = 10.0  #: times length and width of the table
PAUSE_SLACK_S = 1e-6
STRAIGHT_ON = 0.9999  #: cosine of a move that goes on in the direction of another


class HeadStroke(Struct):
    """One way of the head with its tool on: some of the moves that belong to it."""

    line: int
    row: TorchRow
    side: Side
    radius: float  #: that the controller keeps off the path
    first: int  #: of its moves
    last: int  #: behind the last of them
    on: int = -1  #: place of the word that starts its tool among the events that are no moves
    off: int = -1  #: of the one that stops it
    dark: int = 0  #: of its last moves, made with the arc out
    tool: int = 0  #: of the controller's table, whose places the words of the row choose
    passes: int = 1
    waits_s: float = 0.0  #: that the controller waits by itself until it is through
    alike: tuple[TorchRow, ...] = ()  #: rows that its words and its feed stand for as well
    overscan: tuple[float, float] = (0.0, 0.0)  #: mm dark before and behind, in its direction
    in_hole: bool | None = None  #: whether its feed is that of a small hole; None: of either
    is_linked: bool = False  #: whether the tool is on already as it begins, by a chain of parts
    goes_on: bool = False  #: whether the tool stays on as it ends

    @property
    def process(self) -> TorchProcess:
        return self.row.process


class Strokes(Struct, frozen=True):
    """The strokes of a program and their moves, one after the other."""

    each: list[HeadStroke]
    moves: Moves

    def kept(self, each: Sequence[HeadStroke], which: Flags) -> "Strokes":
        """Some strokes of these moves, with some of the moves alone."""
        place = np.concatenate(([0], np.cumsum(which))).tolist()
        moved = [replace(s, first=place[s.first], last=place[s.last]) for s in each]
        return Strokes(moved, self.moves.take(np.flatnonzero(which)))


class _Started(Struct):
    """A stroke while its program runs."""

    stroke: HeadStroke
    rows: list[RowWords]  #: that its words stand for
    pauses: list[tuple[int, float]]  #: moves before each, and seconds
    dark_from: int | None = None  #: the move from which on the arc is out


def strokes_of(
    run: TableRun, machine: Machine, torch: Torch, rows: Iterable[TorchRow], name: str
) -> tuple[Strokes, list[Diagnostic]]:
    """The strokes of a program, of a sheet worked with `rows`, and what is wrong between them."""
    head = _Head([words_of(row, machine, torch) for row in rows], machine, torch, name)
    for place, (before, event) in enumerate(run.others):
        head.take(place, before, event)
    head.finish(run)
    head.check_places(run.moves, torch, torch.tolerance + machine.format.resolution / 2)
    return head.strokes(run.moves), sorted(head.diagnostics, key=lambda one: one.source.line or 0)


def is_far(moves: Moves, torch: Torch) -> bool:
    """Whether moves, which are told, lie so far off the table that nothing is compared."""
    middle = np.array([torch.length, torch.width]) / 2
    places = np.concatenate((moves.start, moves.end, moves.arcs[:, :2]))
    reach = np.abs(places - middle).max(initial=0.0)
    return bool(reach > FAR * (torch.length + torch.width))


class _Head(Watch):
    """The state of the head while a program runs; strokes count all moves of the program."""

    def __init__(self, known: list[RowWords], machine: Machine, torch: Torch, name: str) -> None:
        super().__init__(name)
        self._state = ControllerState(machine, torch, name, self.diagnostics)
        self._known = known
        self._starting: dict[Said, list[RowWords]] = {}
        for words in known:
            for said in words.on:
                self._starting.setdefault(said, []).append(words)
        self._torch = torch
        self._step = machine.format.resolution
        per_minute = 60.0 if machine.format.feed_unit == "mm/s" else 1.0
        self._feed_step = FEED_ROUNDING * per_minute  #: mm/min
        self._started: list[_Started] = []
        self._place = -1
        self._on = False

    def take(self, place: int, before: int, event: Other) -> None:
        """Anything but a move, with its place among such and the number of moves before it."""
        self._place = place
        if isinstance(event, Switch):
            self._switch(before, event)
        elif isinstance(event, Pause):
            if self._on:
                self._started[-1].pauses.append((before, event.seconds))
        elif isinstance(event, Output) and event.name == "arc" and self._on:
            self._started[-1].dark_from = None if event.on else before
        elif isinstance(event, Setting):
            ended = self._started[-1].stroke.last if self._started else 0
            self._state.take(event, before, self._on, ended)

    def _switch(self, before: int, event: Switch) -> None:
        if event.number in ENDS:
            if self._on:
                self._wrong(SHEET_END, event.line, found="the end with the tool on")
                self._stop(before)
            self._state.ends(event.line)
            return
        said = event.said
        starts = self._starting.get(said)
        all_off = event.number == 5 and event.words.get("$") == -1  # every spindle there is
        ended = self._started[-1].rows if self._on else []
        ended = [w for w in ended if all_off or said in w.off]
        if ended:  # of the rows that are started by one word those that this one stops
            self._started[-1].rows = ended
            self._stop(before)
        elif starts is not None and not self._on:
            self._on = True
            state = self._state
            state.starts(event.line, before)
            row = starts[0].row
            stroke = HeadStroke(
                event.line, row, state.side, state.radius, before, before, self._place
            )
            self._started.append(_Started(stroke, starts, []))
        elif any(said in w.off for w in self._known):
            if self._on:
                expected = "the word that stops the tool that is on"
                self._wrong(rules.TOOL, event.line, found=str(event), expected=expected)
        elif event.number in IDLE_SWITCHES or ((all_off or event.number in STOPS) and not self._on):
            return
        elif not self._on and event.number not in _TURNING and not event.does:
            expected = f"codes.{key_for(f'M{event.number}', event.words)} in the machine file, "
            expected += 'with what it does, or "none"'
            found = f"{event}, which beamcam does not know"
            self._wrong(rules.TOOL, event.line, found=found, expected=expected)
        else:
            words = " or ".join(str(Switch(0, n, dict(w))) for n, w in self._starting)
            expected = f"{words} on this sheet, the other tool off"
            self._wrong(rules.TOOL, event.line, found=str(event), expected=expected)

    def _stop(self, before: int) -> None:
        stroke = self._started[-1].stroke
        stroke.last, stroke.off = before, self._place
        self._on = False

    def finish(self, run: TableRun) -> None:
        """The end of the program."""
        if self._on:
            self._stop(len(run.moves))
            lines = [event.line for _, event in run.others[-1:]]
            last = max([*lines, *run.moves.line[-1:].tolist()], default=0)
            self._wrong(SHEET_END, last, found="the end with the tool on")

    def check_places(self, moves: Moves, torch: Torch, slack: float) -> None:
        """Says which moves leave the table by more than a path may lie off its curve."""
        low, high = np.array(torch.area[:2]) - slack, np.array(torch.area[2:]) + slack
        outside = ~np.all((moves.end >= low) & (moves.end <= high), axis=1)
        middle, radius = moves.arcs[:, :2], moves.arcs[:, 2:3]
        far = moves.is_arc & ~np.all((middle - radius >= low) & (middle + radius <= high), axis=1)
        for k in np.flatnonzero(outside | far).tolist():
            x, y = moves.end[k].tolist()
            if not outside[k]:
                # Where the arc is farthest from what lies between both corners.
                cx, cy, *shape = moves.arcs[k].tolist()
                left, bottom, right, top = Arc((cx, cy), *shape).bbox
                most, (x, y) = max(
                    (low[0] - left, (left, cy)), (low[1] - bottom, (cx, bottom)),
                    (right - high[0], (right, cy)), (top - high[1], (cx, top)),
                )  # fmt: skip
                if most <= 0.0:
                    continue
            self._wrong(
                rules.AREA, int(moves.line[k]), x=f"{x:g}", y=f"{y:g}",
                length=f"{torch.length:g}", width=f"{torch.width:g}",
            )  # fmt: skip

    def strokes(self, moves: Moves) -> Strokes:
        """The strokes with the moves that are theirs, and what is wrong with how they are made."""
        owner = np.full(len(moves), -1)
        for number, one in enumerate(self._started):
            owner[one.stroke.first : one.stroke.last] = number
        on = owner >= 0
        dark = self._overscanned(moves, on)
        for rule, wrong in (
            (rules.IDLE, ~on & ~moves.rapid & ~dark),
            (rules.RAPID, on & moves.rapid),
        ):
            for k in np.flatnonzero(wrong).tolist():
                x, y = moves.end[k].tolist()
                self._wrong(rule, int(moves.line[k]), x=f"{x:g}", y=f"{y:g}")
        rows = np.flatnonzero(on & ~moves.rapid)
        counts = np.bincount(owner[rows], minlength=len(self._started))
        lasts = np.cumsum(counts)
        each = []
        for one, first, last in zip(
            self._started, (lasts - counts).tolist(), lasts.tolist(), strict=True
        ):
            stroke = one.stroke
            if first == last:
                found = "a tool that is started and not moved"
                self._wrong(rules.TOOL, stroke.line, found=found, expected="a contour")
            else:
                self._settle(one, moves, rows[first:last])
                stroke.first, stroke.last = first, last
                if one.dark_from is not None:
                    stroke.dark = int((rows[first:last] >= one.dark_from).sum())
                each.append(stroke)
        if len(rows):
            self._state.unsaid(int(moves.line[rows[0]]), int(rows[0]))
        kept = moves if len(rows) == len(moves) else moves.take(rows)
        self._check_feeds(kept, owner[rows])
        return Strokes(each, kept)

    def _overscanned(self, moves: Moves, on: Flags) -> Flags:
        """The moves that go on dark before and behind a stroke of one line, in its direction.

        In laser mode; each stroke is told how far.
        """
        dark = np.zeros(len(moves), dtype=bool)
        if not (self._torch.laser_mode and self._torch.overscan):
            return dark
        way = moves.end - moves.start
        lengths = np.hypot(way[:, 0], way[:, 1])
        for one in self._started:
            first, last = one.stroke.first, one.stroke.last
            if last - first != 1 or moves.is_arc[first] or not lengths[first]:
                continue
            told = []
            for at in (first - 1, last):
                inside = 0 <= at < len(moves) and not moves.rapid[at] and not on[at]
                length = float(lengths[at]) if inside else 0.0
                if length and not moves.is_arc[at]:
                    cosine = float(way[at] @ way[first]) / (length * float(lengths[first]))
                    dark[at] = cosine > STRAIGHT_ON
                told.append(length if dark[at : at + 1].any() else 0.0)
            one.stroke.overscan = told[0], told[1]
        return dark

    def _settle(self, one: _Started, moves: Moves, own: Counts) -> None:
        """The row of a stroke, and whether it waits before its first move as long as that says.

        Of several rows that its words stand for it is that of the nearest feed.
        """
        if len(one.rows) > 1:
            fed = float(moves.feed_mm_min[own].max())

            def off_feed(words: RowWords) -> float:
                """How far the feed is from that of a row, in a small hole or elsewhere."""
                row = words.row
                shares = (1.0, row.hole_feed_share) if row.slows_holes else (1.0,)
                return min(abs(row.feed_mm_min * share - fed) for share in shares)

            one.rows = sorted(one.rows, key=off_feed)
        words, *others = one.rows
        one.stroke.waits_s = 0.0 if words.pierce_s else words.row.pierce_s
        feed, row = words.row.feed_mm_min, int(own[0])
        one.stroke.row, one.stroke.tool = words.row, words.tool
        one.stroke.alike = tuple([w.row for w in others if w.row.feed_mm_min == feed])
        last = int(own[-1])
        before = sum(seconds for moved, seconds in one.pauses if moved <= row)
        behind = sum(seconds for moved, seconds in one.pauses if moved > last)
        on_the_way = sum(seconds for moved, seconds in one.pauses if row < moved <= last)
        for k, pause, due, what in (
            (row, before, words.pierce_s, " to pierce"), (last, on_the_way, 0.0, " in mid contour"),
            (last, behind, words.stop_s, " before the tool is off"),
        ):  # fmt: skip
            if abs(pause - due) > PAUSE_SLACK_S:
                self._wrong(
                    rules.TOOL, int(moves.line[k]), found=f"a pause of {pause:g} s",
                    expected=f"{due:g} s{what}",
                )  # fmt: skip

    def _check_feeds(self, moves: Moves, owner: Counts) -> None:
        """Whether each move has the feed of its row, or the one that the axes can follow.

        Near corners and in small holes that is a share of it; which contours are small holes is
        looked at when these are known.
        """
        rows = [one.stroke.row for one in self._started]
        full = np.array([row.feed_mm_min for row in rows])[owner] if rows else np.zeros(0)
        feeds, fits = self._fit(moves, full)
        wrong = ~fits
        for number, row in enumerate(rows):
            if row.slows_holes or row.slows_corners:
                own = np.flatnonzero(owner == number)
                feeds[own], wrong[own] = self._slowed(moves.take(own), row, number)
        for k in np.flatnonzero(wrong):
            self._wrong(
                rules.FEED, int(moves.line[k]), found=f"{moves.feed_mm_min[k]:g}",
                process=rows[owner[k]].process, expected=f"{feeds[k]:g}",
            )  # fmt: skip

    def _fit(self, moves: Moves, full: Floats) -> tuple[Floats, Flags]:
        """The feed of each move, `full` where the axes can follow it, and whether it has that."""
        feeds = full.copy()
        if self._state.limits is not None:
            feeds = expected_feeds(moves, full, self._state.limits)
        slack = np.where(feeds < full, LOWERED_SLACK, FEED_SLACK) * feeds + self._feed_step
        return feeds, np.abs(moves.feed_mm_min - feeds) <= slack

    def _slowed(self, moves: Moves, row: TorchRow, number: int) -> tuple[Floats, Flags]:
        """The feeds of the moves of a stroke, and which are wrong: by the likelier of its feeds."""
        row_feed = np.full(len(moves), row.feed_mm_min)
        is_near, is_far = np.zeros(len(moves), dtype=bool), np.ones(len(moves), dtype=bool)
        if row.slows_corners:
            is_near, is_far = near_corners(moves, row, self._step)
        options = []
        for share in (1.0, row.hole_feed_share) if row.slows_holes else (1.0,):
            fast, is_fast = self._fit(moves, row_feed * share)
            slow, is_slow = self._fit(moves, row_feed * min(share, row.corner_share))
            wrong = (is_near & ~is_slow) | (is_far & ~is_fast) | ~(is_slow | is_fast)
            options.append((np.where(is_near, slow, fast), wrong))
        stroke = self._started[number].stroke
        counts = [int(wrong.sum()) for _, wrong in options]
        if len(options) > 1 and counts[0] != counts[1]:
            stroke.in_hole = counts[1] < counts[0]
        return options[int(bool(stroke.in_hole))]
