"""Where a table's torch stands over the sheet, as far as its program says it.

    height   of the tip over the sheet, whatever Z is called there
    zero     the height at which Z is 0

A touch tells the height without a Z, G92 then calls it one; both together tell where Z counts from.
"""

from math import inf, isnan, nan

from beamcam.controllers.events import Lift, Touch, Zero
from beamcam.machine.torch import Torch


class Heights:
    """The state of Z between two blocks of a program that moves it."""

    def __init__(self, torch: Torch) -> None:
        self._known = 0.0 if torch.touch == "none" else nan  #: zero as the program begins
        self._touch_height, self._top = torch.touch_height, torch.top
        self._clearance = torch.clearance
        self.height = nan
        self._zero = self._known

    def lift(self, line: int, rapid: bool, z: float, absolute: bool, feed_mm_min: float) -> Lift:
        """The move to a Z, or by it."""
        end = self._zero + z if absolute else self.height + z
        return self._go(line, rapid, end, feed_mm_min)

    def to(self, line: int, height: float) -> Lift:
        """The move of a macro to a height over the sheet."""
        return self._go(line, False, height, nan)

    def to_machine_z(self, line: int, rapid: bool, z: float, feed_mm_min: float) -> Lift:
        """The move to a Z of the machine's own, whose top is all that is known of it."""
        at_top = self._top is not None and z >= self._top
        return self._go(line, rapid, inf if at_top else nan, feed_mm_min)

    def _go(self, line: int, rapid: bool, end: float, feed_mm_min: float) -> Lift:
        start, self.height = self.height, end
        return Lift(line, rapid, start, end, feed_mm_min)

    def touch(self, line: int, feed_mm_min: float) -> Touch:
        """The torch down to the sheet; what Z is there is not known yet."""
        self.height = self._touch_height
        return Touch(line, self.height, feed_mm_min)

    def count_from(self, line: int, z: float, shifted: bool) -> Zero:
        """The place where the torch stands is called `z`."""
        self._zero = self.height - z
        return Zero(line, shifted)

    def touch_off(self, line: int) -> tuple[Touch, Zero, Lift]:
        """A macro that touches the sheet, counts Z from there, and stands on it."""
        touch = self.touch(line, nan)
        zero = self.count_from(line, self.height, False)
        return touch, zero, self.to(line, 0.0)

    def take_back(self, line: int) -> Zero:
        """Z counts again as it did when the program began."""
        self._zero = self._known
        return Zero(line, False)

    @property
    def is_clear(self) -> bool:
        """Whether the torch stands where it may be moved in X and Y."""
        return not isnan(self.height) and self.height >= self._clearance
