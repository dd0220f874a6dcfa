"""The machine as data: limits, tools, words and formats. Every field stands in a TOML file.

Lengths are mm and angles degrees. A `Formula` is arithmetic over the names in `FORMULA_NAMES`,
so that where a station measures from is a line of the machine file and not of the program.
"""

from collections.abc import Mapping
from fractions import Fraction
from math import isfinite, radians, tan
from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from beamcam.caches import cached
from beamcam.conversion import Count, Keys, NotNegative, Positive, PositiveCount
from beamcam.errors import Diagnostic, MachineError, Source
from beamcam.geometry.expression import Expression, compile_expression
from beamcam.machine import rules
from beamcam.machine.marking import Marks
from beamcam.machine.tables import Stepper, Triggers
from beamcam.machine.words import Words

Axis = Literal["X", "Y", "Z"]

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

    def check(self) -> None:
        """Raises ValueError if the text is no arithmetic over `FORMULA_NAMES`."""
        _compiled(self)

    def __call__(self, values: Mapping[str, float]) -> float:
        """The number for a section and a hole. Raises MachineError where there is none."""
        try:
            number = _compiled(self)(values)
        except (ArithmeticError, ValueError) as error:
            raise _without_value(self, values, str(error)) from None
        if not isfinite(number):
            raise _without_value(self, values, "not finite")
        return number


def _without_value(formula: Formula, values: Mapping[str, float], why: str) -> MachineError:
    given = ", ".join(f"{name} {value:g}" for name, value in sorted(values.items()))
    expected = f"arithmetic that has a value for {given} ({why})"
    said = rules.WRONG_VALUE.at(
        Source("machine"), key="spindles", found=repr(str(formula)), expected=expected
    )
    return MachineError(said)


def as_formula(kind: type, value: object) -> Formula:
    """The formula in a value of a machine file. Raises ValueError."""
    if kind is not Formula or not isinstance(value, str | int | float) or value is True:
        raise ValueError("arithmetic as a text")
    formula = Formula(value)
    try:
        formula.check()
    except ValueError as error:
        raise ValueError(f"arithmetic: {error}") from error
    return formula


@cached("machine.formula")
def _compiled(text: str) -> Expression:
    return compile_expression(text, FORMULA_NAMES)


#: No machine resolves a nanometre; the texts of all decimals are kept, of more they would not fit.
Decimals = Annotated[int, Meta(ge=0, le=6)]


class NumberFormat(Keys, frozen=True):
    """How the controller's numbers and blocks are written."""

    length_decimals: Decimals = 3
    angle_decimals: Decimals = 3
    feed_unit: Literal["mm/s", "mm/min"] = "mm/min"
    number_blocks: bool = False  #: N1, N2, ... before every block but % and comments

    @property
    def resolution(self) -> float:
        """The smallest length that the output can tell apart."""
        return 10.0**-self.length_decimals


class Layout(Keys, frozen=True):
    """How the stations stand along the bar, and what bars they take."""

    order: Literal["saw-drill", "drill-saw"]  #: which station the bar reaches first
    min_bar: NotNegative = 0.0  #: shortest bar that the stop or gripper can hold
    max_bar: float | None = None
    default_bar: NotNegative = 0.0  #: taken where no length is given and the parts need too little
    front_trim: NotNegative = 0.0  #: bar x at which the first part starts
    end_trim: NotNegative = 0.0  #: at the bar's end, scrap
    dead_zone: NotNegative = (
        0.0  #: at the bar's end, held by the gripper, out of the stations' reach
    )
    min_part: NotNegative = 0.0  #: shortest part that does not fall between the rollers
    min_bar_left: NotNegative = 0.0  #: of the bar while its last part is worked; 0: nothing known
    min_remnant: NotNegative = 1000.0  #: a rest at least as long goes back to the store
    profiles: tuple[str, ...] = ("I", "U", "L", "M", "C", "T")  #: DSTV codes that it takes


class SawSection(Keys, frozen=True):
    """The largest section that the blade reaches across, up to an angle off the square cut."""

    max_angle: NotNegative  #: degrees off the square cut, to either side
    max_height: Positive
    max_width: Positive


class Saw(Keys, frozen=True):
    """The saw: where it stands, what it cuts and how its angles are counted."""

    kerf: NotNegative
    min_angle: float  #: of the mitre, in the machine's own counting
    max_angle: float
    max_height: Positive
    max_width: Positive
    x: float = 0.0  #: machine X of a cut at bar x 0
    kerf_along: Literal["normal", "x"] = "normal"  #: across the blade, or along the bar
    pivot: Literal["o", "u"] = "o"  #: the edge of the web on which X is counted
    square: float = 0.0  #: what a square cut is called: 0 or 90
    angle_sign: Literal[-1, 1] = 1  #: of DSTV's web angle in the machine's counting
    feed_mm_min: Positive = 2500.0
    min_mitre: float = 0.1  #: an end nearer to square than this is sawn square, in degrees
    min_tilt: float = 0.0  #: of the blade out of the vertical, for flange angles
    max_tilt: float = 0.0  #: 0 and 0: the blade does not tilt
    tilt_sign: Literal[-1, 1] = 1  #: of DSTV's flange angle in the machine's counting
    compound: bool = False  #: whether it may turn and tilt in one cut
    common_cuts: bool = False  #: whether one cut may end a part and start the next
    max_sections: tuple[SawSection, ...] = ()  #: by angle; empty: nothing known but the greatest


ToolKind = Literal["drill", "tap", "countersink", "mill", "punch", "scribe"]


ToolMaterial = Literal["hss", "carbide"]


class Tool(Struct, frozen=True, cache_hash=True):
    """A tool that a spindle can take."""

    kind: ToolKind
    diameter: float
    point_deg: float = 118.0  #: angle of a drill's point or a countersink's cone; 180 is flat
    pitch: float = 0.0  #: of a tap
    hand: Literal["right", "left"] = "right"  #: of a tap
    tool_material: ToolMaterial = "hss"

    @property
    def name(self) -> str:
        """What the shop calls it."""
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


FLAT_DEG = 180.0
MM_PER_INCH = 25.4


class ToolSet(Keys, frozen=True):
    """Tools of one kind in the diameters that the shop has."""

    kind: ToolKind
    diameters: tuple[float, ...] = ()
    inches: tuple[str, ...] = ()  #: more of them, as "13/16" or "1 1/16"
    point_deg: Positive = 118.0
    faces: tuple[Literal["v", "o", "u", "h"], ...] = ("v", "o", "u", "h")  #: whose spindles take it
    pitches: tuple[float, ...] = ()  #: of taps, one for each diameter
    pre_drills: tuple[float, ...] = ()  #: of taps, the drill before each of them
    hand: Literal["right", "left"] = "right"
    largest_hole: NotNegative = 0.0  #: of mills: largest that may be milled as a circle
    tool_material: ToolMaterial = "hss"  #: high-speed steel or cemented carbide

    @property
    def sizes(self) -> tuple[float, ...]:
        """All diameters in mm, the inch sizes behind the metric ones."""
        return self.diameters + tuple(inch_size(text) for text in self.inches)


def inch_size(text: str) -> float:
    """Millimetres of an inch size such as "13/16" or "1 1/16". Raises ValueError."""
    try:
        total = sum(Fraction(word) for word in text.split())
        return round(float(total) * MM_PER_INCH, 6)
    except (ValueError, ArithmeticError) as error:
        raise ValueError(f"{text!r} is no size in inches") from error


class Across(Keys, frozen=True):
    """The axis that sets a spindle across the bar."""

    axis: Axis
    position: Formula


class Stroke(Keys, frozen=True):
    """The axis that drives a spindle into the material."""

    axis: Axis
    start: Formula  #: free of the section, where the spindle may travel
    bottom: Formula  #: end of the stroke
    near: Formula | None = None  #: where the rapid approach ends; `start` if not given


class Spindle(Keys, frozen=True):
    """A drilling spindle: the face that it reaches, its axes and its stations."""

    name: str
    number: Count  #: what the program calls it
    face: Literal["v", "o", "u", "h"]
    across: Across
    stroke: Stroke
    stations: PositiveCount = 1


class Pair(Keys, frozen=True):
    """Two spindles that can drill at once."""

    name: str
    number: Count
    faces: tuple[str, str]


class Fit(Keys, frozen=True):
    """How far a drill may differ from its hole, for holes up to a diameter."""

    up_to: Positive
    plus: NotNegative  #: the drill may be larger by this
    minus: NotNegative  #: or smaller by this


class Cutting(Keys, frozen=True):
    """Speed and feed of a tool, for diameters up to a limit. The first row that fits counts."""

    up_to: Positive
    speed_m_min: Positive  #: at the drill's edge
    feed_per_turn: Positive  #: mm
    grade: str = "*"  #: steel grades the row is for, as shell patterns set off by |
    kind: ToolKind = "drill"
    tool_material: Literal["*", "hss", "carbide"] = "*"  #: of the tools the row is for


class Drill(Keys, frozen=True):
    """The drilling station."""

    x: float  #: machine X of a hole at bar x 0
    max_height: Positive
    max_width: Positive
    fits: tuple[Fit, ...]
    cutting: tuple[Cutting, ...]
    merge_tolerance: NotNegative = 0.1  #: flange holes nearer than this are one operation
    clearance: NotNegative = 5.0  #: between tool and surface where the feed begins
    breakthrough: NotNegative = 2.0  #: of the drill's full diameter beyond the far side
    min_speed_rpm: Positive = 150.0
    max_speed_rpm: Positive = 2500.0
    max_feed_mm_min: Positive = 20000.0
    twin: NotNegative = 0.02  #: tools that differ by no more are one: 20.64 and 13/16 in
    duplicate_tolerance: NotNegative = 0.01  #: holes of one face nearer than this are one hole
    slots: Literal["mill", "drill-mill"] = "drill-mill"  #: whether its ends are drilled first
    runout_pitches: NotNegative = 3.0  #: of a tap's drill below a blind thread
    sink_tolerance: NotNegative = 0.2  #: of a countersink's depth against its diameter
    path_tolerance: NotNegative = 0.02  #: of the chords of a milled or scribed curve
    mark_depth: NotNegative = 0.3  #: of a scribed line
    punch_depth: NotNegative = 1.0  #: of a centre punch that the part gives no depth
    min_edge_distance: NotNegative = 0.0  #: steel from a hole to an edge, an end or another hole
    min_fillet_distance: float = 0.0  #: from a hole to where the root fillet begins


class Times(Keys, frozen=True):
    """What takes time besides the axes."""

    spindle_s: NotNegative = 0.0  #: to start and stop a spindle, each operation
    tool_change_s: NotNegative = 0.0  #: another tool of the spindle's own stations
    spindle_change_s: NotNegative = 0.0  #: another spindle
    reload_s: NotNegative = 0.0  #: another tool into a station, by hand
    saw_s: NotNegative = 0.0  #: to clamp, start and stop the saw, each cut


class ControlledAxis(Keys, frozen=True):
    """An axis of the machine, in the order of the controller's registers.

    `moves` is the letter that moves it in a program, for the axis of a spindle together with
    `spindle`; `angle` is the saw's rotation and `saw` its stroke, which the saw word moves.
    """

    name: str
    moves: Literal["X", "Y", "Z", "angle", "saw"]
    speed: Positive  #: greatest, mm/s or deg/s; rapid moves run at it
    acceleration: Positive  #: mm/s2 or deg/s2
    spindle: int | None = None  #: number of the spindle that it belongs to
    min: float | None = None  #: None has no limit
    max: float | None = None
    park: float = 0.0  #: where it stands when a program begins
    jerk: Positive | None = None  #: mm/s3 or deg/s3; None has no limit


TorchProcess = Literal["cut", "mark", "engrave"]


class TorchRow(Keys, frozen=True):
    """How a process runs on one material up to a thickness."""

    process: TorchProcess
    up_to: Positive  #: thickness of the sheet
    feed_mm_min: Positive
    material: str = "*"  #: grade of the sheet, as a shell pattern
    power: NotNegative = 0.0  #: what the words call {power}
    pierce_s: NotNegative = 0.0  #: between the tool's start and the first move
    kerf: NotNegative = 0.0


class Torch(Keys, frozen=True):
    """The head of a machine that follows contours: a torch, a laser, an engraver.

    A sheet lies with its lower left corner at X 0, Y 0.
    """

    length: Positive  #: of the work area, along X
    width: Positive  #: along Y
    rows: tuple[TorchRow, ...]
    colours: Mapping[str, Literal["cut", "mark", "engrave", "ignore"]]  #: of lines, or their layers
    thickness: Positive | None = None  #: of a sheet that does not say; without it the job has to
    material: str = ""  #: of a sheet that does not say
    place: Literal["corner", "drawn"] = "corner"  #: moved to the corner, or left where it is drawn
    margin: NotNegative = 0.0  #: between the corner and the part
    tolerance: Positive = 0.01  #: greatest distance of the path from the contour
    gap: Positive = 0.01  #: ends of curves as near as this belong together
    kerf_by: Literal["none", "offset", "machine"] = "none"  #: who keeps half a kerf off the contour
    lead: Literal["none", "line", "arc"] = "none"  #: the way from the pierced hole to the contour
    lead_in: NotNegative = 0.0
    lead_out: NotNegative = 0.0
    start: Literal["nearest", "drawn", "straight"] = "nearest"  #: straight: away from corners
    direction: Literal["drawn", "climb", "conventional"] = "drawn"  #: climb: material at the right
    tabs: Count = 0  #: bridges that hold a part in the sheet
    tab_width: Positive = 1.0
    min_hole: NotNegative = 0.0  #: smallest diameter that can be cut
    cross: NotNegative = 0.0  #: size of the cross that marks a centre; 0 marks none
    min_radius: Positive = 0.01  #: smallest arc that the controller takes
    max_radius: Positive = 10000.0  #: an arc beyond is written as lines
    arc_limit: Positive = 0.005  #: radii at both ends of an arc may differ by this
    traverse_mm_min: Positive = 20000.0  #: of the head with its tool off, for times
    acceleration: NotNegative = 0.0  #: along the path, to run up and to brake, mm/s2; 0: not known
    corner: NotNegative = 0.0  #: distance from a corner of a circle passed as fast; 0 stops there


class MachineFile(Keys, frozen=True):
    """What a machine's file may say; the fields are its keys."""

    name: str
    title: str
    controller: Literal["codesys", "linuxcnc", "grbl", "simotion", "stepper"]
    stock: Literal["beam", "sheet"]
    format: NumberFormat
    words: Words = Words()
    suffix: str = ".gcode"
    default_for: tuple[str, ...] = ()  #: suffixes of outputs for which it is taken; not inherited
    layout: Layout | None = None
    saw: Saw | None = None
    drill: Drill | None = None
    spindles: tuple[Spindle, ...] = ()
    times: Times = Times()
    pairs: tuple[Pair, ...] = ()
    tools: tuple[ToolSet, ...] = ()
    axes: tuple[ControlledAxis, ...] = ()
    torch: Torch | None = None
    marks: Marks = Marks()
    triggers: Triggers | None = None
    stepper: Stepper | None = None
    sections: Mapping[str, int] = field(default_factory=dict)  #: the program's section codes


class Machine(MachineFile, frozen=True):
    """A machine: `beamcam machines show NAME` prints every value and where it comes from."""

    checksum: str = ""  #: of all that its file says, in the heads of its programs; no key of it
    remarks: tuple[
        Diagnostic, ...
    ] = ()  #: on its files, such as keys of an older version; no key of it
