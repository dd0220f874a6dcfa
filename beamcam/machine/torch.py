"""The head of a machine that follows contours.

What a grade is made of, so that rows of a cut chart may name a material.

    S355J2, A36, 1.0038, MS        mild steel: unalloyed structural steel up to S460
    1.4301, X5CrNi18-10, 304       stainless steel
    EN AW-5754, AlMg3, 6082        aluminium
    NA, unknown, <unnamed>, -      nothing: what offices write where they know no grade

A grade that is none of these is a material of its own: a row has to name it. High-strength steels
(S500 and above) are alloyed, and have rows of their own.
"""

import re
from collections.abc import Mapping
from fnmatch import fnmatchcase
from typing import Annotated, Literal

from msgspec import Meta, field
from msgspec.structs import replace

from beamcam.conversion import Count, Keys, NotNegative, Positive, PositiveCount

MILD_STEEL, STAINLESS, ALUMINIUM = "mild steel", "stainless steel", "aluminium"

#: By EN 10025, 10346, 10027-2, 10111, 10130, 10088 and 573, DIN 17100, BS 4360, ASTM, CSA, JIS, KS,
#: GB, GOST 27772, IS 2062 and AS/NZS 3678; spaces do not count.
_GRADES = (
    (MILD_STEEL,
     r"(METAL)?(MILD|STRUCTURAL|CARBON)?STEEL(\d+MPA)?|STAHL|BAUSTAHL|MS|CS"
     r"|S(185|195|235|275|355|420|450|460)\D.*|S(185|195|235|275|355|420|450|460)"
     r"|S(220|250|280|320|350|390|550)GD.*|SSC400"
     r"|R?S?ST(33|37|44|50|52|60|70).*|(RST|UST)\d\d.*|FE(310|360|430|490|510).*|E(24|28|36).*"
     r"|A(36|53|106|252|283|500|501|516|529|572|588|709|847|913|992|1011|1085)(\D.*)?"
     r"|A(572|588|709|913)(36|42|50|55|60|65)W?|Q(195|215|235|275|345|355|390|420|460).*"
     r"|(SS|SHN|SRT|SPSR|SM|SN|STKR?N?)(275|330|355|400|490|520).*|BC[RP]\d{3}"
     r"|[CС](235|245|255|275|285|345|355|375|390|440)([KКBБПCС].*|\d?)|[CС][TТ]3.*|09[GГ]2[CСS].*"
     r"|(C|E|G|GR|MR|AR|HA)?(250|300|350)(A|B|BR|C|[LS]\d+|PLUS.*|WT?|AT?|LA)?|C450(L0)?|E410|IS2062"
     r"|YST(240|310|355)|(44|50|55)(W|A|WT|AT)|(GR)?(43|50)[A-D]|P(235|265|355)GH|D[CD]0[1-6].*"
     r"|1\.0\d{3}.*|C10|C15|C22|GR\.?(36|42|50|B|C).*"),
    (STAINLESS,
     r"STAINLESS(STEEL)?|INOX|EDELSTAHL|V[24]A|1\.4\d{3}.*|X\d+CR.*|(AISI|SUS|TP|SS)?(3(01|03|04|09|10"
     r"|16|17|21|47)|4(09|10|20|30|40))(L|LN|H|TI|S)?"),
    (ALUMINIUM,
     r"ALU(MINI?UM)?|ENAW.*|AL(MG|SI|CU|ZN|99|9).*|3\.\d{4}.*|[1-7]0\d\d(-?[HTOF]\d*)?"
     r"|(5[0-9]|6[0-9]|7[0-9])\d\d(-?[HTOF]\d*)?"),
)  # fmt: skip
_NOTHING = re.compile(
    r"N\.?/?A\.?|NONE|NIL|NULL|UNKNOWN|UNDEFINED|<?UNNAMED>?|DEFAULT|TBD|[?.X*/]*"
)
_STANDARDS = re.compile(r"[\s_-]|ASTM|CSA|G40\.2[01]M?|EN10025\d?|AS(/NZS)?367\d(\.1)?")
_MATCHERS = tuple((name, re.compile(pattern)) for name, pattern in _GRADES)


def material_of(grade: str) -> str:
    """What a grade is made of; the grade itself, without its case, if that is not known."""
    plain = _plain(grade)
    return next((name for name, pattern in _MATCHERS if pattern.fullmatch(plain)), grade.casefold())


def material_said(grade: str, otherwise: str) -> str:
    """The grade of a part, or what a sheet is made of otherwise where that says nothing."""
    return otherwise if _NOTHING.fullmatch(_plain(grade)) else grade


def _plain(grade: str) -> str:
    """A grade in capitals, without blanks and the standard that it is of."""
    bare = _STANDARDS.sub("", grade.upper())
    return bare.removeprefix("IS2062") or bare


def is_row_for(material: str, grade: str) -> bool:
    """Whether a row of a cut chart is for sheets of a grade.

    `material` is that of the row: a grade as a shell pattern, or a material. A sheet of which
    nothing is known is of any.
    """
    if not grade or fnmatchcase(grade.upper(), material.upper()):
        return True
    return material_of(grade) == material_of(material)


Degrees = Annotated[float, Meta(ge=-360, le=360)]
Share = Annotated[float, Meta(gt=0, le=1)]
#: Feeds are written to 0.001 mm/s or mm/min, so that each is within 3 % of the machine's.
Feed = Annotated[float, Meta(ge=1, extra={"unit": "mm/min"})]
#: That ends may gape, a path be off and two holes lie apart that are one: beyond that a hole is no
#: hole any more.
Slack = Annotated[float, Meta(ge=0, le=1, extra={"unit": "mm"})]
PathSlack = Annotated[float, Meta(gt=0, le=1, extra={"unit": "mm"})]
#: Of chords from their curve; less is finer than a mill cuts.
ChordSlack = Annotated[float, Meta(ge=0.001, le=1, extra={"unit": "mm"})]
TorchProcess = Literal["cut", "mark", "engrave", "spot"]


#: of a program's numbers that a kerf takes at least, so that half of it is a figure
KERF_STEPS = 10


class TorchRow(Keys, frozen=True):
    """Parameters of a process on one material, up to a thickness."""

    process: TorchProcess  #: that the row is for
    up_to: Positive  #: thickness of the sheet
    feed_mm_min: Feed  #: along the contour
    material: str = "*"  #: of the sheet: mild steel, a grade ...; or a shell pattern of grades
    power: NotNegative = 0.0  #: what the words call {power}
    pierce_s: NotNegative = 0.0  #: between the tool's start and the first move
    kerf: NotNegative = 0.0  #: width of the cut
    pierce_width: NotNegative = 0.0  #: of the hole that piercing burns; 0: twice the kerf
    preheat_s: NotNegative = 0.0  #: of the flame at the place before it pierces
    min_hole: NotNegative = 0.0  #: smallest diameter that it cuts; 0: as `torch` says
    lead_in: NotNegative = 0.0  #: length of its lead-in; 0: as `torch` says
    pierce_height: NotNegative = 0.0  #: of the torch over the sheet as it pierces; 0: not known
    cut_height: NotNegative = 0.0  #: of the torch over the sheet as it cuts; 0: not known
    amps: NotNegative = 0.0  #: current of a plasma torch; 0: not known
    volts: NotNegative = 0.0  #: of its arc at the height of the cut; 0: not known
    nozzle: str = ""  #: nozzle or gas that the row is for
    number: Count = 0  #: of the row in the controller's own table of materials; 0: none
    passes: PositiveCount = 1  #: how often a contour is followed
    #: inner contours whose way round is shorter than that of a circle so wide are small holes
    hole_diameter: NotNegative = 0.0
    hole_feed_share: Share = 1.0  #: of the feed, in small holes
    corner_angle: Annotated[float, Meta(ge=0, le=180)] = 45.0  #: what a corner turns more than
    corner_distance: NotNegative = 0.0  #: along the path, before and behind a corner
    corner_share: Share = 1.0  #: of the feed, within that distance

    @property
    def slows_corners(self) -> bool:
        return self.corner_share < 1.0 and self.corner_distance > 0.0

    @property
    def slows_holes(self) -> bool:
        return self.hole_feed_share < 1.0 and self.hole_diameter > 0.0

    def spotting(self) -> "TorchRow":
        """The row by which the torch spots where no row says how: as it begins a cut."""
        return replace(self, process="spot", passes=1, hole_diameter=0.0, corner_distance=0.0)

    @property
    def pierce_radius(self) -> float:
        """How far from the part it pierces where there is room, in mm."""
        return self.pierce_width / 2 or self.kerf


class LayerSettings(Keys, frozen=True):
    """How the lines of one colour or layer are worked, over the row of their process."""

    speed: Positive | None = None  #: mm/min
    power: NotNegative | None = None  #: what the words call {power}
    passes: PositiveCount | None = None  #: how often its contours are followed
    order: Count = 0  #: place in the order of work, lower ones first
    hatch: Positive | None = None  #: closed contours are filled by lines so far apart
    hatch_angle: Degrees = 0.0  #: of these lines
    hatch_one_way: bool = False  #: all lines of a hatch in its angle; otherwise the nearest first
    hatch_outline: bool = True  #: whether contours that are filled are followed besides
    overcut: NotNegative | None = None  #: over that of the machine, of closed contours to cut

    def given(self) -> tuple[str, ...]:
        """The keys that say something."""
        default = LayerSettings()
        return tuple(k for k in self.__struct_fields__ if getattr(self, k) != getattr(default, k))


OTHERS = "*"  #: key of `colours` for all lines that no key before it names
CORNER_DEG = 20.0  #: what a corner turns more than, for bridges: `min_tab_to_corner`
#: Origin of the work as a share of its length and width, from its lower left corner.
ORIGINS = {
    "lower-left": (0.0, 0.0), "lower-right": (1.0, 0.0), "upper-left": (0.0, 1.0),
    "upper-right": (1.0, 1.0), "centre": (0.5, 0.5),
}  # fmt: skip


class Torch(Keys, frozen=True):
    """The head of a machine that follows contours: a torch, a laser, an engraver.

    A sheet lies with its lower left corner at X 0, Y 0.
    """

    length: Positive  #: of the work area, along X
    width: Positive  #: along Y
    rows: tuple[TorchRow, ...]
    #: of lines, or their layers; "*" is all that no key before it names
    colours: Mapping[str, Literal["cut", "mark", "engrave", "ignore"]]
    #: keys of `colours` that are certain: of others it is asked whether lines with gaps are cuts,
    #: and marks that close are none; names of layers are, and what a job maps itself
    settled: tuple[str, ...] = ()
    #: at which feed a sheet between two rows is worked: that of the row for thicker ones, or one in
    #: between
    between_rows: Literal["row above", "interpolate"] = "row above"
    more_rows: tuple[TorchRow, ...] = ()  #: added to the rows of a base, by their thickness
    settings: Mapping[str, LayerSettings] = field(default_factory=dict)  #: by keys of `colours`
    thickness: Positive | None = None  #: of a sheet that does not say; without it the job has to
    material: str = ""  #: of a sheet that does not say
    place: Literal["corner", "drawn"] = "corner"  #: moved to the corner, or left where it is drawn
    margin: NotNegative = 0.0  #: between the corner and the part
    #: where X 0, Y 0 is: at the corner of the table, or at that point of the work
    origin: Literal["table", "lower-left", "lower-right", "upper-left", "upper-right", "centre"] = (
        "table"
    )
    mirror: Literal["none", "x", "y"] = "none"  #: x: left for right; y: top for bottom
    rotate: Degrees = 0.0  #: of the part about its middle, degrees, counter-clockwise
    copies: tuple[PositiveCount, PositiveCount] = (1, 1)  #: of the part, along X and along Y
    tolerance: PathSlack = 0.01  #: maximum deviation of the path from the contour
    gap: PathSlack = 0.01  #: ends of curves as near as this belong together
    #: whether open lines may be cut where kerf is compensated: they have no side that a part is on
    allow_open: bool = False
    kerf_by: Literal["none", "offset", "machine"] = "none"  #: kerf compensation
    lead: Literal["none", "line", "arc"] = "none"  #: lead-in: from the pierce point to the contour
    lead_in: NotNegative = 0.0  #: length of the lead-in
    lead_out: NotNegative = 0.0  #: of the lead-out
    start: Literal["nearest", "drawn", "straight"] = "nearest"  #: straight: away from corners
    direction: Literal["drawn", "climb", "conventional"] = "drawn"  #: climb: material at the right
    tabs: Count = 0  #: bridges that hold a part in the sheet
    inner_tabs: bool = False  #: whether inner contours have as many
    tab_width: Positive = 1.0  #: of a bridge, from one end of the cut to the other
    #: between a bridge and a corner of its contour, where a place is near that has it; a corner is
    #: a turn of more than 20 degrees
    min_tab_to_corner: NotNegative = 0.0
    overcut: NotNegative = 0.0  #: how far a closed cut goes on along its contour beyond its start
    hole_overcut: NotNegative | None = None  #: that of small holes (`hole_diameter` of their row)
    #: lead-in of small holes that are round: as `lead` says, or half a circle from their middle
    hole_lead: Literal["lead", "middle"] = "lead"
    min_hole: NotNegative = 0.0  #: smallest diameter that can be cut
    min_hole_share: NotNegative = 0.0  #: smallest diameter that can be cut, by the thickness
    #: Holes and slots that the torch cannot make (smaller ones, threads, countersinks, blind ones):
    #: refused, or their centres marked for the drill, by a cross or by a spot of the torch where it
    #: stands, and listed for manual work. Centre points of the part are marked likewise.
    drilled: Literal["refuse", "mark", "spot"] = "refuse"
    #: Bevels: refused, or the outline cut square and each edge listed for manual work. No
    #: machine has a head that tilts yet.
    bevel: Literal["refuse", "square", "head"] = "refuse"
    min_bevel: NotNegative = 0.0  #: degrees; an edge with a smaller bevel is cut square
    unrolled: bool = False  #: whether a pipe that is written as a plate is cut flat
    spacing: NotNegative = 10.0  #: between the boxes of parts or copies that share a sheet
    #: whether parts and copies lie a kerf apart instead: straight edges side by side are cut once
    common_cuts: bool = False
    #: mm, the longest way from the outline of one part to that of the next with the torch on; 0:
    #: each is pierced
    chain_cuts: NotNegative = 0.0
    #: whether what is left of a sheet of several parts is cut between their rows, last of all
    skeleton_cuts: bool = False
    cross: NotNegative = 0.0  #: size of the cross that marks a centre; 0 marks none
    min_radius: Positive = 0.01  #: smallest arc that the controller takes
    max_radius: Positive = 10000.0  #: an arc beyond is written as lines
    arc_limit: Positive = 0.005  #: radii at both ends of an arc may differ by this
    traverse_mm_min: Positive = 20000.0  #: of the head with its tool off, for times
    frame_mm_min: Positive = 6000.0  #: of the head round the work, its tool off: `post --frame`
    #: of a laser as it goes round the work, too low to mark it; 0: the tool is off
    frame_power: NotNegative = 0.0
    acceleration: NotNegative = 0.0  #: along the path, to run up and to brake, mm/s2; 0: not known
    #: whether the tool works in feeds alone, with the last S, and traverses are dark ($32 of grbl)
    laser_mode: bool = False
    #: in laser mode, how far the head goes on dark, at its feed, before and behind lines of a hatch
    overscan: NotNegative = 0.0
    corner: NotNegative = 0.0  #: distance from a corner of a circle passed as fast; 0 stops there
    z: Literal["controller", "program"] = "controller"  #: which of them moves the torch up and down
    #: which of them holds the torch at its height by the voltage of the arc: the controller by
    #: itself, or the program, which switches that on in each cut
    thc: Literal["controller", "program"] = "controller"
    thc_slow: bool = True  #: whether it is held there in small holes and near corners too
    clearance: NotNegative = 0.0  #: lowest height over the sheet for traverses, of z = "program"
    #: when the program has the torch touch the sheet: never, as Z counts from it already; before
    #: the first start; before each
    touch: Literal["none", "once", "each"] = "none"
    #: of the torch over the sheet where it has touched it; below 0, as far as the axis goes on
    #: until the probe trips
    touch_height: Annotated[float, Meta(ge=-50, le=0)] = 0.0
    top: float | None = None  #: Z of the machine (G53) where the torch is clear of everything

    def by(self, row: TorchRow | None) -> "Torch":
        """The torch as it works a sheet that is cut by a row: with its own hole and lead-in."""
        if row is None or not (row.min_hole or row.lead_in):
            return self
        return replace(
            self,
            min_hole=row.min_hole or self.min_hole,
            min_hole_share=0.0 if row.min_hole else self.min_hole_share,
            lead_in=row.lead_in or self.lead_in,
        )

    @property
    def area(self) -> tuple[float, float, float, float]:
        """Work area of the head: minimum X and Y, maximum X and Y.

        An origin in the work may be anywhere on the table, and leads go round it on all sides.
        """
        if self.origin in ORIGINS:
            return -self.length, -self.width, self.length, self.width
        return 0.0, 0.0, self.length, self.width
