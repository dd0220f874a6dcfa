"""The stations of a line: its saw, its drill with the spindles, and what letters."""

from collections.abc import Mapping
from typing import Literal

from msgspec import field

from beamcam.conversion import Count, Keys, NotNegative, Positive, PositiveCount
from beamcam.machine.formula import Formula
from beamcam.machine.tools import ToolKind

# --- saw ------------------------------------------------------------------------------------------

# The saw of a line.


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
    square: float = 0.0  #: what a square cut is called: 0 or 90
    angle_sign: Literal[-1, 1] = 1  #: of DSTV's web angle in the machine's counting
    feed_mm_min: Positive = 2500.0  #: of the blade
    #: an end nearer to square than this is sawn square, degrees of web or flange
    min_mitre: float = 0.2
    min_tilt: float = 0.0  #: of the blade out of the vertical, for flange angles
    max_tilt: float = 0.0  #: 0 and 0: the blade does not tilt
    tilt_sign: Literal[-1, 1] = 1  #: of DSTV's flange angle in the machine's counting
    compound: bool = False  #: whether it may turn and tilt in one cut
    common_cuts: bool = False  #: whether one cut may end a part and start the next
    max_sections: tuple[SawSection, ...] = ()  #: by angle; empty: only the maximum is known


# --- drill ----------------------------------------------------------------------------------------

# The drilling station of a line, and its spindles.


Axis = Literal["Y", "Z"]


class Across(Keys, frozen=True):
    """The axis that sets a spindle across the bar."""

    axis: Axis  #: of the program; X is that of the bar
    position: Formula  #: of the tool for the y of a hole


class StrokeAxis(Keys, frozen=True):
    """The axis that drives a spindle into the material."""

    axis: Axis  #: of the program; the other one
    start: Formula  #: free of the section, where the spindle may travel
    bottom: Formula  #: end of the stroke
    near: Formula | None = None  #: where the rapid approach ends; `start` if not given


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
    feed_per_turn: Positive  #: mm
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
    merge_tolerance: NotNegative = 0.1  #: flange holes nearer than this are one operation
    clearance: NotNegative = 5.0  #: between tool and surface where the feed begins
    breakthrough: NotNegative = 2.0  #: of the drill's full diameter beyond the far side
    min_speed_rpm: Positive = 150.0  #: of a spindle
    max_speed_rpm: Positive = 2500.0  #: of a spindle
    max_feed_mm_min: Positive = 20000.0  #: of a tool
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
    unit: MarkingUnit = "none"  #: what letters
    height_of: Literal["capital", "body"] = "capital"  #: what the height of a text is that of
    min_height: Positive = 3.0  #: of a capital; of a stamp its least of `heights` counts
    min_distance: NotNegative = 3.0  #: of letters from holes, edges and ends
    spacing: Positive = 1.0  #: from letter to letter; 1 as the font has it
    replace: Mapping[str, str] = field(default_factory=dict)  #: for characters that a font lacks
    characters: str = ""  #: that a stamp or printer has
    heights: tuple[Positive, ...] = ()  #: that it has; empty: any
    pitch: Positive = 0.8  #: from character to character, as a share of the height
    angles: tuple[float, ...] = (0.0,)  #: degrees at which it letters
    #: faces that it comes to, and what {face} calls the unit there
    faces: Mapping[str, int] = field(default_factory=dict)
    x: float | None = None  #: machine X of a text at bar x 0; None is where the drill stands

    @property
    def is_told(self) -> bool:
        """Whether a stamp or a printer letters, which is told its texts."""
        return self.unit in TOLD_UNITS
