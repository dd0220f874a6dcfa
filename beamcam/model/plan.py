"""The plan: which tool makes which feature, where along the machine, in which order."""

from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Literal

from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Curve, Point
from beamcam.machine.stations import Tool
from beamcam.machine.torch import TorchRow
from beamcam.model.part import Face, Feature, Part, Profile

SKELETON = "skeleton"  #: source of the cuts through what is left of a sheet
HATCH = "hatch"  #: source of the lines of a hatch
FeatureRef = tuple[int, int]  #: index of the piece on the bar, index of its feature
Order = Literal["given", "best"]  #: of parts on a bar: as they were given, or as they nest best
AS_GIVEN = "as given"  #: how a part lies that was not turned
#: What may be left out of a program: codes of refusals by the kinds of work, without their "plan-".
SKIP_NAMES = (
    "tool", "countersink", "sink-depth", "thread-depth", "face", "reach", "stroke", "axis",
    "off-face", "slot", "cope", "cutout", "mark", "bevel", "other",
)  # fmt: skip
ALL_SKIPS = "all"  #: in place of the names of all kinds of features


class Piece(Struct, frozen=True):
    """One part laid on the bar."""

    part: Part  #: as it lies: turned, if it was turned
    start: float  #: bar x of the part's x 0
    given: int = 0  #: which of the parts that were handed in
    turn: str = AS_GIVEN  #: how it was turned to lie so
    place: Point = (0.0, 0.0)  #: on a table, of a part's x 0, y 0

    @property
    def end(self) -> float:
        return self.start + self.part.length


class Bar(Struct, frozen=True):
    """The account of a bar: its lengths add up to its own, `nested` taken off."""

    length: float
    front_trim: float
    parts: float
    kerfs: float
    remnant: float  #: what is left over behind the last cut and before the end trim
    nested: float = 0.0  #: by which parts that share a mitre overlap
    end_trim: float = 0.0

    @property
    def left(self) -> float:
        """The remnant of the bar after the last cut."""
        return self.remnant + self.end_trim

    @property
    def total(self) -> float:
        """The sum of the lengths."""
        return (
            self.front_trim + self.parts + self.kerfs - self.nested + self.remnant + self.end_trim
        )


class SawOp(Struct, frozen=True, gc=False):
    """One cut through the bar."""

    x: float  #: machine X, of the blade's middle on the pivot edge
    angle: float  #: degrees in the machine's own counting
    purpose: Literal["trim", "mitre", "parting", "common"]
    pieces: tuple[int, ...]  #: those that get an end by it
    source: Source
    tilt: float = 0.0  #: of the blade, degrees in the machine's own counting
    at: Literal["start", "end"] = "end"  #: of the first of `pieces`
    reasons: tuple[str, ...] = ()  #: codes of `planning.operations`


class DrillOp(Struct, frozen=True, gc=False):
    """One stroke of a spindle, or of two at once, with any tool that makes a round place."""

    x: float  #: machine X
    spindle: int  #: what the program calls the spindle, or the pair of them
    tool: Tool
    faces: tuple[Face, ...]
    y: float  #: on the face
    depth: float | None  #: of a drill's full diameter, of other tools' point; None is through
    features: tuple[FeatureRef, ...]
    reasons: tuple[str, ...]  #: why this tool, why merged: codes of `planning.operations`
    source: Source


class PathOp(Struct, frozen=True):
    """A tool that follows a path: a slot or a large hole milled, a line scribed."""

    x: float  #: machine X of the first point
    spindle: int
    tool: Tool
    faces: tuple[Face, ...]  #: one
    path: tuple[tuple[float, float], ...]  #: machine X and y on the face, two points at least
    depth: float | None  #: of the tool's point; None is through
    features: tuple[FeatureRef, ...]
    reasons: tuple[str, ...]
    source: Source

    @property
    def y(self) -> float:
        """y of the first point."""
        return self.path[0][1]


class StampedLetters(Struct, frozen=True):
    """A text as a stamp or printer gets it."""

    text: str
    height: float
    angle: float  #: degrees


class TextOp(Struct, frozen=True):
    """A text that a stamp or printer letters."""

    x: float  #: machine X
    spindle: int  #: what the program calls the unit on that face
    tool: Tool  #: the unit, its diameter the height
    faces: tuple[Face, ...]  #: one
    y: float  #: on the face
    text: StampedLetters
    features: tuple[FeatureRef, ...]
    reasons: tuple[str, ...]
    source: Source
    depth: float | None = None


SpindleOp = DrillOp | PathOp
WorkOp = DrillOp | PathOp | TextOp  #: on a feature
Operation = SawOp | WorkOp


class ToolLoad(Struct, frozen=True):
    """A tool put into a station."""

    before: int  #: index of the operation that needs it; 0 and no `out`: before the work
    spindle: str  #: name
    station: int  #: counted from 1
    tool: Tool
    out: Tool | None = None  #: what it takes the place of
    number: int = 0  #: what the program calls the spindle


#: Wording of outcomes by which nothing is made.
NOT_MADE = {"skipped": "left out", "listed": "left for manual work"}


class Outcome(Struct, frozen=True, gc=False):
    """The outcome of one feature."""

    feature: FeatureRef
    how: Literal["made", "merged", "duplicate", "listed", "skipped"]
    #: What makes it (a kind of tool, or saw), why it is on the list of manual work, or the code
    #: by which it was left out.
    by: str
    left: str = ""  #: why something of a feature that is made is on that list too

    @property
    def manual_work(self) -> str:
        """Why it is on the list of manual work, wholly or in part; "" if it is not."""
        return self.by if self.how == "listed" else self.left

    @property
    def is_left_out(self) -> bool:
        """Whether it was left out because `--allow-skips` names its kind.

        What the map takes away, and what is too small to be cut, needs no such name.
        """
        return self.how == "skipped" and self.by.removeprefix("plan-") in SKIP_NAMES


def unfinished(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Those of features that are not made, or not wholly; of nearly every plan none."""
    return [outcome for outcome in outcomes if outcome.how in NOT_MADE or outcome.left]


class OfPieces(Struct, frozen=True):
    """A plan of parts that lie on a bar or a sheet."""

    profile: Profile
    pieces: tuple[Piece, ...]

    def feature(self, ref: FeatureRef) -> Feature:
        """A feature of one of the pieces."""
        return self.pieces[ref[0]].part.features[ref[1]]


class Plan(OfPieces, frozen=True):
    """The work of one bar, in order."""

    bar: Bar
    operations: tuple[Operation, ...]
    outcomes: tuple[Outcome, ...]  #: one for every feature of every piece
    remarks: tuple[Diagnostic, ...] = ()
    reloads: tuple[ToolLoad, ...] = ()  #: changed manually during the work, in its order


class Pass(Struct, frozen=True, gc=False):
    """The work of the head between tool on and tool off."""

    lead_in: tuple[Curve, ...]  #: from the pierced hole to the contour
    curves: tuple[Curve, ...]  #: along it
    lead_out: tuple[Curve, ...]  #: the overcut beyond its start, and the way off it
    again: int = 0  #: how many curves of `lead_out` are the overcut


class ContourOp(Struct, frozen=True, gc=False):
    """A contour cut, marked or engraved, in one pass, or in several with bridges between them."""

    row: TorchRow  #: the process and how it runs
    passes: tuple[Pass, ...]  #: machine coordinates
    closed: bool
    depth: int  #: nesting depth: number of cut contours around it
    side: Literal["on", "left", "right"]  #: side of the controller's kerf compensation
    kerf: float  #: what is compensated, by whomever
    features: tuple[FeatureRef, ...]
    source: Source
    feed_share: float = 1.0  #: of the row's feed, all along it
    is_linked: bool = False  #: whether its lead-in comes from the contour before, the tool on

    @property
    def is_hatch(self) -> bool:
        """Whether it is a line of a hatch."""
        return self.source.where == HATCH and not self.closed

    @property
    def start(self) -> Point:
        """The first point at which the tool is started."""
        first = self.passes[0]
        return (first.lead_in or first.curves)[0].start

    @property
    def end(self) -> Point:
        """The last point at which the tool is stopped."""
        last = self.passes[-1]
        return (last.lead_out or last.curves)[-1].end


class SheetPlan(OfPieces, frozen=True):
    """The work on one sheet, in order; of one piece, or of those that share it."""

    shift: Point  #: machine coordinates of the drawing's x 0, y 0; each piece has its place
    thickness: float
    operations: tuple[ContourOp, ...]
    outcomes: tuple[Outcome, ...]  #: one for every feature
    remarks: tuple[Diagnostic, ...] = ()
    reloads: tuple[ToolLoad, ...] = ()  #: changed manually during the work, in its order
    notes: tuple[str, ...] = ()  #: for the operator
    min_bevel: float = 0.0  #: degrees; a smaller bevel counts as square


#: What a cut of a profile is: within a wall, from an edge, or at an end of it; far parts the piece.
CopeKind = Literal["inner", "notch", "near", "far"]


class CopeCut(Struct, frozen=True, gc=False):
    """A cut of a torch that goes round a profile, square to one of its walls or tilted along it.

    Where the torch is tilted, what it cuts goes on through the wall along the torch.
    """

    kind: CopeKind
    face: Face  #: that the torch looks at
    #: x of the part and y of the face where the torch points at, from where it pierces
    path: tuple[Point, ...]
    lead: int  #: how many of its segments lead to the contour
    thickness: float  #: that it cuts through along the torch, roots with their flange
    row: TorchRow
    features: tuple[FeatureRef, ...]
    source: Source
    root: bool = False  #: whether it takes the root behind a flange
    b_deg: float = 0.0  #: tilt of the torch towards X
    bevel: bool = False  #: whether it makes the bevel of an edge that a square cut makes too
    lower: bool = False  #: of the far side of its wall, before the square cut
    a_off_deg: float = 0.0  #: turn about the bar off that at which the torch looks at its face
    #: that turn and the tilt at each place of the path; empty where both stand still
    turns: tuple[tuple[float, float], ...] = ()
    lip: bool = False  #: whether it takes the lip below a flange


class CopePlan(OfPieces, frozen=True):
    """The work on one part that is cut from a bar by a torch going round it, in order."""

    bar: float  #: length that the part needs
    operations: tuple[CopeCut, ...]
    outcomes: tuple[Outcome, ...]  #: one for every feature
    remarks: tuple[Diagnostic, ...] = ()
    reloads: tuple[ToolLoad, ...] = ()  #: none: there is one torch
    min_bevel: float = 0.0  #: degrees; a smaller bevel counts as square
    usual_corners: bool = False  #: whether the machine's table says how round those of a tube are


AnyPlan = Plan | SheetPlan | CopePlan


def named_skips(words: Iterable[str]) -> tuple[str, ...]:
    """The kinds of features that are named, each once and in order; `all` names every kind."""
    names = set(words)
    if ALL_SKIPS in names:
        names = (names - {ALL_SKIPS}) | {*SKIP_NAMES}
    return tuple(sorted(names))


def left_out_sources(plan: AnyPlan) -> Iterator[Source]:
    """Source of each feature that was left out because `--allow-skips` names its kind."""
    left = unfinished(plan.outcomes)
    return (plan.feature(one.feature).source for one in left if one.is_left_out)


def left_out_kinds(plan: AnyPlan) -> Counter[str]:
    """How many features of each kind were left out because `--allow-skips` names it."""
    left = unfinished(plan.outcomes)
    return Counter(one.by.removeprefix("plan-") for one in left if one.is_left_out)


def manual_work_sources(plan: AnyPlan) -> Iterator[Source]:
    """Source of each mark that is left for manual work."""
    left = unfinished(plan.outcomes)
    return (plan.feature(one.feature).source for one in left if one.manual_work)


class StockUse(Struct, frozen=True):
    """What a program takes of a bar."""

    length: float  #: of the bar
    cuts: float  #: mm of kerfs and trims
    remnant: float


def stock_used(plan: AnyPlan, bar: float | None) -> StockUse | None:
    """What a plan takes of a `bar`, or of one as long as it needs; None where it is for a sheet."""
    match plan:
        case Plan(bar=used):
            cuts = used.front_trim + used.kerfs + used.end_trim - used.nested
            return StockUse(used.length, cuts, used.remnant)
        case CopePlan():
            length = plan.bar if bar is None else bar
            cuts = plan.bar - sum(piece.part.length for piece in plan.pieces)
            return StockUse(length, cuts, length - plan.bar)
    return None


class WorkTime(Struct, frozen=True):
    """Seconds of each operation in order of work, and of what is between and after them."""

    operations: tuple[float, ...]
    manual_changes_s: float = 0.0  #: tools put into stations manually during the work
    home_s: float = 0.0  #: from the last operation to where the next work begins

    @property
    def total_s(self) -> float:
        return sum(self.operations) + self.manual_changes_s + self.home_s


def clock(seconds: float) -> str:
    """A time as minutes and seconds, or hours where there are any."""
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d}:{whole % 60:02d} h"
