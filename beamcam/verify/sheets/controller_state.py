"""What holds in a table's controller while its tools are on: compensation, blending, ramps.

Compensation is switched on where a stroke begins and off where it ends: a controller refuses it
twice, and a traverse beside the path starts the next stroke elsewhere. How far corners may be
passed, and how the head runs up and brakes, is said before the first stroke.
"""

from collections.abc import Iterator
from math import inf

from beamcam.controllers.events import Acceleration, Blending, Compensation, Side
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.ability import told_limits

SLACK = 1e-3  #: share of an acceleration
BLENDED_SLACK = 1e-6  #: mm

Setting = Compensation | Blending | Acceleration


class ControllerState:
    """The settings of a controller while its program runs; moves are counted from the first."""

    def __init__(self, machine: Machine, torch: Torch, name: str) -> None:
        self.side: Side = "on"
        self.radius = 0.0
        self.limits = told_limits(machine)
        self._name = name
        self._kerf_by, self._corner = torch.kerf_by, torch.corner
        self._blends = machine.controller == "linuxcnc"
        self._blended: int | None = None  #: moves before it was first said
        self._ramps: set[bool] = set()
        self._ramped: int | None = None  #: moves before both ramps were given
        self._beside_since = -1  #: moves before compensation was switched on

    def _fault(self, rule: Rule, line: int, found: str, expected: str) -> Diagnostic:
        return rule.at(Source(self._name, line), found=found, expected=expected)

    def take(self, event: Setting, before: int, is_on: bool, ended: int) -> Iterator[Diagnostic]:
        """What is wrong with a setting; `before` moves of it, the last stroke ended at `ended`."""
        if isinstance(event, Blending):
            self._blended = before if self._blended is None else self._blended
            yield from self._blending(event.line, event.distance)
        elif isinstance(event, Acceleration):
            yield from self._ramp(event, before)
        else:
            yield from self._compensation(event, before, is_on, ended)

    def _compensation(
        self, event: Compensation, before: int, is_on: bool, ended: int
    ) -> Iterator[Diagnostic]:
        found = ""
        if is_on:
            found, expected = "compensation with the tool on", "it before"
        elif event.side != "on" and self._kerf_by != "machine":
            # The path keeps half a kerf off already, or none is asked for.
            found = f"compensation by {event.radius:g} mm to the {event.side}"
            expected = f"none, as torch.kerf_by is {self._kerf_by!r}"
        elif event.side != "on" and self.side != "on":
            found, expected = "compensation that is on already", "it off behind each stroke"
        elif event.side == "on" and self.side != "on" and before != ended:
            found, expected = "a traverse with compensation", "it off behind the stroke"
        self.side, self.radius, self._beside_since = event.side, event.radius, before
        if found:
            yield self._fault(rules.TOOL, event.line, found, expected)

    def starts(self, line: int, before: int) -> Iterator[Diagnostic]:
        """What is wrong when a tool starts behind so many moves."""
        if self.side != "on" and before != self._beside_since:
            expected = "it on where the stroke begins"
            yield self._fault(rules.TOOL, line, "a traverse with compensation", expected)

    def ends(self, line: int) -> Iterator[Diagnostic]:
        """What is wrong when the program ends."""
        if self.side != "on":
            expected = "it off behind the last stroke"
            yield self._fault(rules.TOOL, line, "the end with compensation", expected)

    def _blending(self, line: int, distance: float) -> Iterator[Diagnostic]:
        """Whether the controller passes corners as the machine's file says."""
        if abs(distance - self._corner) > BLENDED_SLACK:
            on, off = ("G64 P", "G61") if self._blends else ("G52 D", "G50")
            asked = f"{on}{self._corner:g}" if self._corner else off
            found = f"{distance:g} mm" if distance < inf else "any distance"
            expected = f"{asked}, as torch.corner is {self._corner:g}"
            yield self._fault(rules.CORNER, line, found, expected)

    def _ramp(self, event: Acceleration, before: int) -> Iterator[Diagnostic]:
        self._ramps.add(event.braking)
        if self._ramped is None and len(self._ramps) == 2:
            self._ramped = before
        allowed = self.limits.along_mm_s2 if self.limits is not None else 0.0
        if abs(event.mm_s2 - allowed) > SLACK * allowed:
            expected = f"{allowed:g} mm/s2" if allowed else "none, the machine has no limit"
            what = "to brake" if event.braking else "to run up"
            yield self._fault(rules.RAMP, event.line, f"{event.mm_s2:g} mm/s2 {what}", expected)

    def unsaid(self, line: int, before: int) -> Iterator[Diagnostic]:
        """What was not said before the first move with a tool on, which stands on a line."""
        if self._blends and (self._blended is None or self._blended > before):
            yield from self._blending(line, inf)
        if self.limits is not None and (self._ramped is None or self._ramped > before):
            expected = f"{self.limits.along_mm_s2:g} mm/s2 to run up and to brake"
            yield self._fault(rules.RAMP, line, "no E word before the first move", expected)
