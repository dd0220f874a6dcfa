"""Events of a program: one vocabulary for all controllers.

    Move          tool, bar or head go straight or along a curve, in rapid or at a feed
    Switch        an M word: something starts, stops, is chosen, cuts, or the program ends
    Pause         a dwell
    Compensation  from here on the controller keeps beside the contour
    Acceleration  from here on the head runs up or brakes at another acceleration
    Blending      from here on corners may be passed at some distance
    Lettering     a unit stamps or prints a text
    Lift          the torch goes up or down over the sheet
    Touch         the torch goes down until it touches the sheet
    Zero          from here on Z counts from elsewhere, or as it did before
    Output        something of the machine is switched: height control, preheat, an output
    FeedShare     from here on the head moves at a share of the feed that is programmed
    ToolOffset    from here on places are those of another tool of the head
    Material      the controller takes the cutting data of a row

Every run of `post` makes thousands of them, and a drawing tens of thousands. Coordinates are mm,
feeds mm/min; a coordinate that no block has named yet is not a number (nan). A controller that has
more (outputs that are switched on the way) adds its event here, so that those who follow a program
learn one set of words.

Where a table's torch stands over the sheet, as far as its program says it.

    height   of the tip over the sheet, whatever Z is called there
    zero     the height at which Z is 0

A touch tells the height without a Z, G92 then calls it one; both together tell where Z counts from.
"""

from collections.abc import Iterable
from math import degrees, inf, isnan, nan
from typing import Generic, Literal, TypeVar

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.machine.torch import Torch

Curve = Arc | Bezier | EllipseArc
Place = tuple[float, float, float]  #: X, Y, Z
Where = TypeVar("Where", Point, Place)
Side = Literal["on", "left", "right"]


class Move(Struct, Generic[Where], frozen=True, gc=False):
    """A move: of a cell or a coper in X, Y and Z, of the head of a table in X and Y."""

    line: int
    rapid: bool
    start: Where
    end: Where
    feed_mm_min: float  #: 0 without an F before it
    own_feed: bool = False  #: whether the feed is in its own block
    curve: Curve | None = None  #: in X and Y; None for a straight one
    minutes: float = 0.0  #: that it takes, in inverse time (G93); 0 where a feed holds
    a_deg: tuple[float, float] = (nan, nan)  #: A at its start and end, where the machine has it
    b_deg: tuple[float, float] = (nan, nan)  #: B likewise


class _Event(Struct, frozen=True, gc=False):
    """What happens at a line of a program."""

    line: int


class Switch(_Event, frozen=True, gc=False):
    """An M word."""

    number: int
    words: dict[str, float]  #: its parameters by letter
    does: str = ""  #: what `[codes]` says of it: "torch on", "cutting oxygen off"; else nothing

    @property
    def said(self) -> "Said":
        """The word by itself, wherever it stands."""
        return self.number, tuple(sorted(self.words.items()))

    def __str__(self) -> str:
        return " ".join([f"M{self.number}", *(f"{k}{v:g}" for k, v in sorted(self.words.items()))])


Said = tuple[int, tuple[tuple[str, float], ...]]  #: number of an M word, and its parameters


class Pause(_Event, frozen=True, gc=False):
    """A dwell."""

    seconds: float


class Compensation(_Event, frozen=True, gc=False):
    """From here on the controller keeps beside the contour, by a radius."""

    side: Side
    radius: float


class Acceleration(_Event, frozen=True, gc=False):
    """From here on the head runs up, or brakes, at an acceleration in mm/s2."""

    braking: bool
    mm_s2: float


class Blending(_Event, frozen=True, gc=False):
    """From here on the controller may pass corners so far off the path to keep its speed."""

    distance: float  #: mm; 0 follows the path exactly, inf is without a limit


class Lettering(_Event, frozen=True, gc=False):
    """A text that a stamp or printer is told."""

    kind: str  #: of the unit
    text: str
    values: dict[str, float]  #: what the word carries, by the names of the machine's file


class Lift(_Event, frozen=True, gc=False):
    """A move of the torch in Z alone, by its heights over the sheet.

    A height is nan where nothing says it, and inf at the top of the axis, clear of everything.
    """

    rapid: bool
    start: float
    end: float
    feed_mm_min: float


class Touch(_Event, frozen=True, gc=False):
    """The torch goes down until it touches the sheet, and stands there."""

    height: float  #: of its tip, below 0, as far as the axis goes on until the probe trips
    feed_mm_min: float


class Zero(_Event, frozen=True, gc=False):
    """From here on Z counts from elsewhere."""

    shifted: bool  #: whether it has to be taken back: what G92 sets would hold for the next program


class Output(_Event, frozen=True, gc=False):
    """Something of the machine besides its tool is switched."""

    name: str  #: "thc", "preheat", or the word that switches it, without what says on or off
    on: bool
    with_move: bool = False  #: when the next move begins, so that it needs one


class FeedShare(_Event, frozen=True, gc=False):
    """From here on the head moves at a share of the feed that is programmed."""

    share: float  #: 1 is all of it


class ToolOffset(_Event, frozen=True, gc=False):
    """From here on places are those of a tool of the head that stands beside the torch."""

    number: int  #: in the controller's table of tools; 0 is the torch


class Material(_Event, frozen=True, gc=False):
    """The controller takes the cutting data of a row."""

    values: dict[str, float]  #: "number", or figures by the names of a machine's row


#: All but moves.
Other = (
    Switch | Pause | Compensation | Acceleration | Blending | Lettering | Lift | Touch | Zero
    | Output | FeedShare | ToolOffset | Material
)  # fmt: skip
HeadMove = Move[Point]
BarEvent = Move[Place] | Other
TableEvent = HeadMove | Other


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
        return self.to(line, rapid, end, feed_mm_min)

    def to_machine_z(self, line: int, rapid: bool, z: float, feed_mm_min: float) -> Lift:
        """The move to a Z of the machine's own, whose top is all that is known of it."""
        at_top = self._top is not None and z >= self._top
        return self.to(line, rapid, inf if at_top else nan, feed_mm_min)

    def to(self, line: int, rapid: bool, end: float, feed_mm_min: float) -> Lift:
        """The move to a height over the sheet."""
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
        return touch, zero, self.to(line, False, 0.0, nan)

    def take_back(self, line: int) -> Zero:
        """Z counts again as it did when the program began."""
        self._zero = self._known
        return Zero(line, False)

    @property
    def is_clear(self) -> bool:
        """Whether the torch stands where it may be moved in X and Y."""
        return not isnan(self.height) and self.height >= self._clearance


# --- tubes that turn below their torch, where A is not in degrees or Y is fixed -------------------


def in_degrees(events: Iterable[BarEvent], coper: Coper, diameter: float) -> list[BarEvent]:
    """Events whose A is in degrees, of a machine on which it may count mm of the surface.

    There A is the arc u of the place on top, from the lowest line of the tube towards face v;
    turned by A degrees the place at 90 - A from that line is on top. A torch without Y is over the
    axis, Y 0.
    """
    if coper.a_unit == "deg" and coper.y == "follows":
        return [*events]
    turned: list[BarEvent] = []
    for event in events:
        if isinstance(event, Move) and coper.a_unit == "mm":
            first, last = (90.0 - degrees(2 * a / diameter) for a in event.a_deg)
            event = replace(event, a_deg=(first, last))
        if isinstance(event, Move) and coper.y == "fixed":
            (x0, y0, z0), (x1, y1, z1) = event.start, event.end
            y0, y1 = (0.0 if isnan(y) else y for y in (y0, y1))
            event = replace(event, start=(x0, y0, z0), end=(x1, y1, z1))
        turned.append(event)
    return turned
