"""Heights of a torch whose program moves it up and down, and the control of its height by voltage.

traverse       clear of the sheet
touch, zero    before the first height that counts on them, and before each start if so asked
start          at the pierce height of the row, the height control off
down           at a feed to the cut height, before the first move along the contour
cut            at the cut height, the height control on; off in small holes and near corners
               where the file says so
stop           the height control off first, then the tool, then up
end            clear, and Z counts as it did before
"""

from math import inf, isnan, nan

import numpy as np

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.controller_state import Watch
from beamcam.controllers.events import Lift, Other, Output, Touch, Zero
from beamcam.controllers.moves import Moves
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchRow

SLACK = 0.001  #: mm, and half of what the program's numbers step by
SECONDS_PER_MINUTE = 60.0
SLOWER = 0.99  #: share of the row's feed below which a move is one in a small hole or at a corner


class HeightWatch(Watch):
    """The torch over the sheet while its program runs."""

    def __init__(self, moves: Moves, machine: Machine, torch: Torch, name: str) -> None:
        super().__init__(name)
        self._rapid, self._lines = moves.rapid.tolist(), moves.line
        self._feeds = np.where(moves.rapid, inf, moves.feed_mm_min)
        self._torch = torch
        self._follows = torch.z == "program"
        speeds = [axis.speed for axis in machine.axes if axis.moves == "Z"]
        self._fastest = min(speeds, default=inf) * SECONDS_PER_MINUTE
        self._slack = SLACK + machine.format.resolution / 2
        self._height = nan
        self._touched = torch.touch == "none"  #: since the torch was traversed, or ever
        self._zeroed = True  #: since it touched
        self._shifted = False  #: G92 holds
        self._row: TorchRow | None = None  #: of the stroke that is made
        self._moved = False  #: since the tool was started
        self._by_program = torch.thc == "program"
        self._thc = not self._by_program

    def _wrong_height(self, line: int, found: str, expected: str) -> None:
        self._wrong(rules.HEIGHT, line, found=found, expected=expected)

    def _wrong_thc(self, line: int, found: str, expected: str) -> None:
        self._wrong(rules.THC, line, found=found, expected=expected)

    def _off(self, height: float) -> bool:
        """Whether the torch stands elsewhere, or where nothing says."""
        return not abs(self._height - height) <= self._slack

    def moves(self, first: int, last: int) -> None:
        """The head is moved in X and Y at one height."""
        rapids = self._rapid[first:last]
        if True in rapids:
            self._touched = self._touched and self._torch.touch != "each"
            if self._follows and not self._height >= self._torch.clearance - self._slack:
                expected = f"{self._torch.clearance:g} mm or more (torch.clearance)"
                line = int(self._lines[first + rapids.index(True)])
                self._wrong_height(line, f"a traverse {_shown(self._height)}", expected)
        if self._row is None or False not in rapids:
            return
        line = int(self._lines[first + rapids.index(False)])
        height, process = self._row.cut_height, self._row.process
        if self._follows and height and self._off(height):
            self._wrong_height(
                line, f"a feed {_shown(self._height)}", f"{height:g} mm to {process}"
            )
        if process == "cut":
            is_wrong = not self._thc
            if not self._torch.thc_slow:
                feeds = self._feeds[first:last]
                slow = feeds < SLOWER * self._row.feed_mm_min
                is_wrong = bool((slow == self._thc)[np.isfinite(feeds)].any())
            if is_wrong:
                found = f"a cut with the height control {'on' if self._thc else 'off'}"
                expected = "it off in small holes and near corners" if self._thc else "it on"
                self._wrong_thc(line, found, expected)
        self._moved = True

    def starts(self, line: int, row: TorchRow, _: int) -> None:
        """A tool is started."""
        self._row, self._moved = row, False
        height = row.pierce_height or row.cut_height
        if self._follows and height and not self._touched:
            when = "since it was traversed" if self._torch.touch == "each" else "before"
            expected = f"the sheet touched {when} (torch.touch)"
            self._wrong_height(line, "a start without a touch", expected)
        elif self._follows and height and self._off(height):
            found = f"the tool started {_shown(self._height)}"
            self._wrong_height(line, found, f"{height:g} mm to {row.process}")
        if self._by_program and self._thc:
            found = "a start with the height control on"
            self._wrong_thc(line, found, "it off until the torch is at its height")

    def stops(self, line: int) -> None:
        """A tool is stopped."""
        self._row = None
        if self._by_program and self._thc:
            found = "the tool stopped with the height control on"
            self._wrong_thc(line, found, "that off before")

    def take(self, event: Other) -> None:
        """Anything but a move in X and Y."""
        if isinstance(event, Output) and event.name == "thc":
            row = self._row
            high = self._follows and row is not None and bool(row.cut_height)
            if (
                event.on
                and self._by_program
                and (row is None or (high and self._off(row.cut_height)))
            ):
                where = _shown(self._height) if row else "with the tool off"
                found = f"the height control on {where}"
                self._wrong_thc(event.line, found, "it on in a cut, at its height")
            self._thc = event.on
        elif isinstance(event, Zero):
            self._shifted, self._zeroed = event.shifted, True
        elif isinstance(event, Touch):
            self._height, self._touched, self._zeroed = event.height, True, False
            if self._row is not None:
                self._wrong_height(event.line, "a touch with the tool on", "it off")
            self._feed(event, "a touch")
        elif isinstance(event, Lift):
            self._lift(event)

    def _lift(self, event: Lift) -> None:
        """A move up or down."""
        self._height = event.end
        if not event.rapid:
            self._feed(event, "a move in Z")
        found = f"a move in Z to where the torch is {_shown(event.end)}"
        expected = ""
        if not self._zeroed:
            found, expected = "a height that counts from before the touch", "G92 behind the touch"
        elif isnan(event.end):
            expected = "a Z that counts from the sheet, or the machine's top (torch.top)"
        elif event.end < -self._slack:
            expected = "0 or more, as only a touch goes farther"
        elif self._row is not None:
            row = self._row
            least, most = sorted((row.cut_height, row.pierce_height or row.cut_height))
            if self._moved:
                found, expected = "a move in Z in mid contour", "the tool off before"
            elif event.rapid:
                found, expected = "a traverse in Z with the tool on", "a feed"
            elif not least - self._slack <= event.end <= most + self._slack:
                expected = f"{least:g} to {most:g} mm with the tool on"
        if expected:
            self._wrong_height(event.line, found, expected)

    def _feed(self, event: Lift | Touch, what: str) -> None:
        """Whether Z is fed, and no faster than its axis goes; a macro's feed is its own."""
        feed = event.feed_mm_min
        if feed <= 0.0 or feed > self._fastest:
            expected = f"up to {self._fastest:g} mm/min" if self._fastest < inf else "F before"
            self._wrong_height(event.line, f"{what} at a feed of {feed:g}", expected)

    def ends(self, line: int) -> None:
        """The program ends."""
        if self._follows and not self._height >= self._torch.clearance - self._slack:
            found = f"the end with the torch {_shown(self._height)}"
            self._wrong_height(line, found, f"{self._torch.clearance:g} mm or more")
        if self._shifted:
            expected = "G92.1 before, or every next program counts Z from there"
            self._wrong_height(line, "the end while G92 holds", expected)
        if self._thc == self._by_program:
            found = f"the end with the height control {'on' if self._thc else 'off'}"
            self._wrong_thc(line, found, "it as it was before")


def _shown(height: float) -> str:
    if isnan(height):
        return "at a height that nothing says"
    return "at the top of the axis" if height == inf else f"{height:g} mm over the sheet"
