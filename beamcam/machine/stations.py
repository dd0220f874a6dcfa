"""The stations of a line: its saw, its drill with the spindles, and what letters; and the formulas
that say where a spindle stands.
"""

from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from math import inf, isfinite, pi, radians, tan
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct, field

from beamcam.caches import cached
from beamcam.conversion import (
    Count,
    Expression,
    Keys,
    NotNegative,
    Positive,
    PositiveCount,
    compile_expression,
)
from beamcam.errors import MachineError, Source
from beamcam.machine.torch import ChordSlack, Feed, Slack
from beamcam.machine.words import WRONG_VALUE

FORMULA_NAMES = frozenset(
    {
        "height",  # of the section
        "width",
        "flange_thickness",
        "web_thickness",
        "thickness",  # of the material that is drilled
        "face_depth",  # how far the face lies below the outermost material on its side
        "y",  # of the hole on its face
        "depth",  # of the drill's full diameter: the hole's own, or thickness and breakthrough
        "tip",  # length of the drill's point
        "clearance",
    }
)


class Formula(str):
    """A number that depends on the section or the hole, written as arithmetic."""

    __slots__ = ()

    def __call__(self, values: Mapping[str, float]) -> float:
        """The number for a section and a hole. Raises MachineError where there is none."""
        try:
            number = _compiled(self)(values)
            if not isfinite(number):
                raise ValueError("not finite")
        except (ArithmeticError, ValueError) as error:
            given = ", ".join(f"{name} {value:g}" for name, value in sorted(values.items()))
            expected = f"arithmetic that has a value for {given} ({error})"
            raise NoValueError(str(self), expected) from None
        return number


class NoValueError(MachineError):
    """A formula that has no value for a section and a hole."""

    def __init__(self, formula: str, expected: str) -> None:
        self.formula, self.expected = formula, expected
        found = repr(formula)
        diagnostic = WRONG_VALUE.at(
            Source("machine"), key="spindles", found=found, expected=expected
        )
        super().__init__(diagnostic)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.formula, self.expected)


def as_formula(kind: type, value: object) -> Formula:
    """The formula in a value of a machine file. Raises ValueError."""
    if kind is not Formula or not isinstance(value, str | int | float) or value is True:
        raise ValueError("arithmetic as a text")
    formula = Formula(value)
    try:
        _compiled(formula)
    except ValueError as error:
        raise ValueError(f"arithmetic: {error}") from error
    return formula


@cached("machine.formula")
def _compiled(text: str) -> Expression:
    return compile_expression(text, FORMULA_NAMES)


FLAT_DEG = 180.0  #: of the point of a tool that is flat
ToolKind = Literal["drill", "tap", "countersink", "mill", "punch", "scribe"]
UnitKind = Literal["stamp", "printer"]  #: what letters by itself and is not a tool of a spindle
ToolMaterial = Literal["hss", "carbide"]


class Tool(Struct, frozen=True, cache_hash=True):
    """A tool that a spindle can take, or a unit that letters."""

    kind: ToolKind | UnitKind
    diameter: float
    point_deg: float = 118.0  #: angle of a drill's point or a countersink's cone; 180 is flat
    pitch: float = 0.0  #: of a tap
    hand: Literal["right", "left"] = "right"  #: of a tap
    tool_material: ToolMaterial = "hss"
    max_peck: float = 0.0  #: depth that a drill is fed at a time; 0 to the bottom at once

    @property
    def name(self) -> str:
        """The shop's name for it."""
        if self.kind == "tap":
            left = " left" if self.hand == "left" else ""
            return f"tap M{self.diameter:g} x {self.pitch:g}{left}"
        if self.kind == "countersink":
            return f"countersink {self.diameter:g} at {self.point_deg:g} deg"
        return f"{self.kind} {self.diameter:g}"

    @property
    def tip(self) -> float:
        """Length of the point: radius / tan(half the point angle); 0 of a flat one."""
        if self.point_deg >= FLAT_DEG:
            return 0.0
        return self.diameter / 2 / tan(radians(self.point_deg) / 2)


MM_PER_INCH = 25.4


class ToolSet(Keys, frozen=True):
    """Tools of one kind in the diameters that the shop has."""

    kind: ToolKind  #: of all of them
    diameters: tuple[Positive, ...] = ()  #: each is a tool
    inches: tuple[str, ...] = ()  #: more of them, as "13/16" or "1 1/16"
    #: angle of the point or the cone; 180 is flat
    point_deg: Annotated[float, Meta(gt=0, le=FLAT_DEG)] = 118.0
    faces: tuple[Literal["v", "o", "u", "h"], ...] = ("v", "o", "u", "h")  #: of spindles
    pitches: tuple[Positive, ...] = ()  #: of taps, one for each diameter
    pre_drills: tuple[Positive, ...] = ()  #: of taps, the drill before each of them
    hand: Literal["right", "left"] = "right"  #: of taps
    largest_hole: NotNegative = 0.0  #: of mills: largest that may be milled as a circle
    tool_material: ToolMaterial = "hss"  #: high-speed steel or cemented carbide
    max_peck: NotNegative = 0.0  #: depth that a drill is fed at a time, {peck}; 0: all at once
    numbers: tuple[int, ...] = ()  #: what {tool} of the words calls them, one for each size

    @property
    def sizes(self) -> tuple[float, ...]:
        """All diameters in mm, the inch sizes behind the metric ones."""
        return self.diameters + tuple(inch_size(text) for text in self.inches)


#: Kind and size of a tool -> what the machine calls it.
ToolNumbers = dict[tuple[str, float], int]


def tool_numbers(sets: Iterable[ToolSet]) -> ToolNumbers:
    """The numbers of the tools that have some."""
    return {
        (tools.kind, size): number
        for tools in sets
        for size, number in zip(tools.sizes, tools.numbers, strict=False)
    }


def inch_size(text: str) -> float:
    """Millimetres of an inch size such as "13/16" or "1 1/16". Raises ValueError."""
    from fractions import Fraction

    try:
        size = round(float(sum(Fraction(word) for word in text.split())) * MM_PER_INCH, 6)
    except (ValueError, ArithmeticError):
        size = 0.0
    if size <= 0.0:
        raise ValueError(f"{text!r} is no size in inches")
    return size


# --- saw ------------------------------------------------------------------------------------------


class SawSection(Keys, frozen=True):
    """The largest section that the blade reaches across, up to an angle off the square cut."""

    max_angle: NotNegative  #: degrees off the square cut, to either side
    max_height: Positive  #: of a section at that angle
    max_width: Positive  #: of a section at that angle


class Saw(Keys, frozen=True):
    """The saw: its position, its range and its angle convention."""

    kerf: NotNegative  #: width of its cut
    min_angle: float  #: of the mitre, in the machine's own counting
    max_angle: float  #: of the mitre
    max_height: Positive  #: of the largest section
    max_width: Positive  #: of the largest section
    x: float = 0.0  #: machine X of a cut at bar x 0
    kerf_along: Literal["normal", "x"] = "normal"  #: across the blade, or along the bar
    pivot: Literal["o", "u"] = "o"  #: the edge of the web on which X is counted
    zero_angle: float = 0.0  #: what a square cut is called: 0 or 90
    angle_sign: Literal[-1, 1] = 1  #: of DSTV's web angle in the machine's counting
    feed_mm_min: Feed = 2500.0  #: of the blade
    #: an end nearer to square than this is sawn square, degrees of web or flange
    min_mitre: float = 0.2
    min_tilt: float = 0.0  #: of the blade out of the vertical, for flange angles
    max_tilt: float = 0.0  #: 0 and 0: the blade does not tilt
    tilt_sign: Literal[-1, 1] = 1  #: of DSTV's flange angle in the machine's counting
    compound: bool = False  #: whether it may turn and tilt in one cut
    common_cuts: bool = False  #: whether one cut may end a part and start the next
    max_sections: tuple[SawSection, ...] = ()  #: by angle; empty: only the maximum is known


# --- drill ----------------------------------------------------------------------------------------

Axis = Literal["Y", "Z"]


class Across(Keys, frozen=True):
    """The axis that sets a spindle across the bar."""

    axis: Axis  #: of the program; X is that of the bar
    position: Formula  #: of the tool for the y of a hole


class StrokeAxis(Keys, frozen=True):
    """The axis that drives a spindle into the material."""

    axis: Axis  #: of the program; the other one
    retract: Formula  #: free of the section, where the spindle may travel
    bottom: Formula  #: end of the stroke
    approach: Formula | None = None  #: where the rapid approach ends; `retract` if not given


class Spindle(Keys, frozen=True):
    """A drilling spindle: the face that it reaches, its axes and its stations."""

    name: str  #: in messages and plans
    number: Count  #: what the program calls it
    face: Literal["v", "o", "u", "h"]  #: that it reaches
    across: Across
    stroke: StrokeAxis
    stations: PositiveCount = 1  #: tools in its magazine


class Pair(Keys, frozen=True):
    """Two spindles that can drill at once."""

    name: str  #: in messages and plans
    number: Count  #: what the program calls it
    faces: tuple[str, str]  #: of its spindles


class Fit(Keys, frozen=True):
    """How far a drill may differ from its hole, for holes up to a diameter."""

    up_to: Positive  #: diameter of the hole
    plus: NotNegative  #: the drill may be larger by this
    minus: NotNegative  #: or smaller by this


class Cutting(Keys, frozen=True):
    """Speed and feed of a tool, for diameters up to a limit. The first row that fits counts."""

    up_to: Positive  #: diameter of the tool
    speed_m_min: Positive  #: at the drill's edge
    feed_per_turn: Annotated[float, Meta(ge=0.001, extra={"unit": "mm"})]  #: mm
    grade: str = "*"  #: steel grades of the row, as shell patterns separated by |
    kind: ToolKind = "drill"  #: of tool
    tool_material: Literal["*", "hss", "carbide"] = "*"  #: kind of tool the row applies to


class Drill(Keys, frozen=True):
    """The drilling station."""

    x: float  #: machine X of a hole at bar x 0
    max_height: Positive  #: of the largest section
    max_width: Positive  #: of the largest section
    fits: tuple[Fit, ...]
    cutting: tuple[Cutting, ...]
    never_under: bool = False  #: whether no drill may be smaller than its hole, whatever fits say
    merge_tolerance: Slack = 0.1  #: flange holes nearer than this are one operation
    clearance: NotNegative = 5.0  #: between tool and surface where the feed begins
    breakthrough: NotNegative = 2.0  #: of the drill's full diameter beyond the far side
    min_speed_rpm: Annotated[float, Meta(ge=1)] = 150.0  #: of a spindle; programs say it to 1
    max_speed_rpm: Positive = 2500.0  #: of a spindle
    max_feed_mm_min: Feed = 20000.0  #: of a tool
    #: tools that differ by no more are one: 20.64 and 13/16 in
    same_tool_tolerance: Slack = 0.02
    duplicate_tolerance: Slack = 0.01  #: holes of one face nearer than this are one hole
    slots: Literal["mill", "drill-mill"] = "drill-mill"  #: whether its ends are drilled first
    runout_pitches: NotNegative = 3.0  #: of a tap's drill below a blind thread
    sink_tolerance: Slack = 0.2  #: of a countersink's depth against its diameter
    path_tolerance: ChordSlack = 0.02  #: of the chords of a milled or scribed curve
    mark_depth: NotNegative = 0.3  #: of a scribed line
    punch_depth: NotNegative = 1.0  #: of a centre punch that the part gives no depth
    min_edge_distance: NotNegative = 0.0  #: steel from a hole to an edge, an end or another hole
    min_fillet_distance: float = 0.0  #: from a hole to where the root fillet begins


#: How a kind of mark is made: by the machine, manually from the list, or refused.
Policy = Literal["make", "list", "refuse"]
#: What letters: a needle or milling point, a torch at low power or a laser, each of which draws the
#: strokes of a single-line font; or a stamp or a printer, which is told the text.
MarkingUnit = Literal["none", "scribe", "plasma", "laser", "stamp", "printer"]
#: Units that are told a text by a word of the program and draw no strokes.
TOLD_UNITS = ("stamp", "printer")


class Marks(Keys, frozen=True):
    """What becomes of texts (DSTV: SI), centre points (BO of diameter 0) and lines (KO, PU).

    Points and lines that cannot be made though they are to be are refused, as they locate other
    parts. A text without room goes on the list of manual work.
    """

    text: Policy = "list"  #: texts; list: left for manual work
    points: Policy = "make"  #: centre points
    contours: Policy = "make"  #: lines to scribe or to punch
    bends: Literal["list", "refuse"] = "refuse"  #: of a plate; list: its blank is made
    cambers: Literal["list", "refuse"] = "list"  #: of a beam; list: it is made straight
    unit: MarkingUnit = "none"  #: what letters
    height_of: Literal["capital", "body"] = "capital"  #: what the height of a text is that of
    min_height: Positive = 3.0  #: of a capital; of a stamp its least of `heights` counts
    min_distance: NotNegative = 3.0  #: of letters from holes, edges and ends
    spacing: Positive = 1.0  #: from letter to letter; 1 as the font has it
    replace: Mapping[str, str] = field(default_factory=dict)  #: for characters that a font lacks
    characters: str = ""  #: that a stamp or printer has
    heights: tuple[Positive, ...] = ()  #: that it has; empty: any
    pitch: Positive = 0.8  #: from character to character, as a share of the height
    angles: Annotated[tuple[float, ...], Meta(min_length=1)] = (
        0.0,
    )  #: degrees at which it letters
    #: faces that it comes to, and what {face} calls the unit there
    faces: Mapping[str, int] = field(default_factory=dict)
    x: float | None = None  #: machine X of a text at bar x 0; None is where the drill stands

    @property
    def is_told(self) -> bool:
        """Whether a stamp or a printer letters, which is told its texts."""
        return self.unit in TOLD_UNITS


ANY_GRADE = "*"  #: of the rows for what no other row names


def speed_and_feed(tool: Tool, drill: Drill, grade: str) -> tuple[float, float]:
    """Spindle speed in rpm and feed in mm/min of a tool, within the machine's limits.

    n = 1000 v / (pi d), v the cutting speed in m/min; feed = n * feed per turn, of a tap
    n * pitch. A punch or scribe does not turn: its row's speed is its feed in m/min.
    """
    row = cutting_row(tool, drill, grade)
    if tool.kind in ("punch", "scribe"):
        return 0.0, min(1000 * row.speed_m_min, drill.max_feed_mm_min)
    speed = min(max(turns_of(row, tool), drill.min_speed_rpm), drill.max_speed_rpm)
    if tool.kind == "tap":
        # A tap has to follow its pitch, so a limit of the feed lowers the speed.
        speed = min(speed, drill.max_feed_mm_min / tool.pitch)
        return speed, speed * tool.pitch
    return speed, min(speed * row.feed_per_turn, drill.max_feed_mm_min)


def turns_of(row: Cutting, tool: Tool) -> float:
    """The speed in rpm that a row asks for, whatever the spindle's limits; of a point infinite."""
    return 1000 * row.speed_m_min / (pi * tool.diameter) if tool.diameter else inf


def cutting_row(tool: Tool, drill: Drill, grade: str) -> Cutting:
    """The first row that fits kind, material and diameter of a tool and the steel's grade.

    The last row of the kind counts for anything beyond.
    """
    rows = [row for row in drill.cutting if row.kind == tool.kind]
    for row in rows:
        fits = tool.diameter <= row.up_to and row.tool_material in ("*", tool.tool_material)
        if fits and names_grade(row, grade):
            return row
    return rows[-1]


def names_grade(row: Cutting, grade: str) -> bool:
    """Whether one of a row's patterns is that of a steel's grade; case counts for nothing."""
    patterns = row.grade.upper().split("|")
    return any(fnmatchcase(grade.upper(), pattern.strip()) for pattern in patterns)


def is_unnamed(drill: Drill, grade: str) -> bool:
    """Whether drills have rows by grade, and none of them names this one."""
    rows = [row for row in drill.cutting if row.kind == "drill" and row.grade != ANY_GRADE]
    return bool(rows) and not any(names_grade(row, grade) for row in rows)
