"""The machine as data: limits, tools, words and formats. Every field is a key of the TOML file.

Lengths are mm and angles degrees. A `Formula` is arithmetic over the names in `FORMULA_NAMES`,
so that where a station measures from is a line of the machine file and not of the program.
"""

import re
from collections.abc import Iterable, Mapping
from math import inf, sqrt
from pathlib import PurePath
from typing import Annotated, Literal, TypeVar

from msgspec import Meta, Struct, field

from beamcam.conversion import Count, Keys, NotNegative, Positive, PositiveCount, Text
from beamcam.errors import Diagnostic
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.machine.coper import Coper
from beamcam.machine.stations import Drill, Formula, Marks, Pair, Saw, Spindle, ToolSet
from beamcam.machine.tables import Stepper, Triggers
from beamcam.machine.torch import Torch
from beamcam.machine.words import Words

#: No machine resolves a nanometre; the texts of all decimals are kept, of more they would not fit.
Decimals = Annotated[int, Meta(ge=0, le=6)]

Station = TypeVar("Station")
Stock = Literal["beam", "sheet", "profile"]
ALONG_SHARE = 0.5  #: of the acceleration of the axes, along a path where a file gives none


class NumberFormat(Keys, frozen=True):
    """Number and block format of the controller."""

    length_decimals: Decimals = 3  #: of lengths and feeds in a program
    angle_decimals: Decimals = 3  #: of angles
    feed_unit: Literal["mm/s", "mm/min"] = "mm/min"  #: of {feed}
    dwell_unit: Literal["s", "ms"] = "s"  #: of {pierce} and {preheat}, and of what G4 waits
    number_blocks: bool = False  #: N1, N2, ... before every block but % and comments

    @property
    def resolution(self) -> float:
        """The smallest length that the output can represent."""
        return 10.0**-self.length_decimals


class Layout(Keys, frozen=True):
    """Positions of the stations along the bar, and the bars that they take."""

    order: Literal["saw-drill", "drill-saw"]  #: which station the bar reaches first
    min_bar: NotNegative = 0.0  #: shortest bar that the stop or gripper can hold
    max_bar: float | None = None  #: longest bar that it takes; None has no limit
    default_bar: NotNegative = 0.0  #: taken where no length is given and the parts need too little
    front_trim: NotNegative = 0.0  #: bar x at which the first part starts
    end_trim: NotNegative = 0.0  #: at the bar's end, scrap
    #: at the bar's end, held by the gripper, out of the stations' reach
    dead_zone: NotNegative = 0.0
    min_part: NotNegative = 0.0  #: shortest part that does not fall between the rollers
    min_bar_left: NotNegative = 0.0  #: of the bar while its last part is worked; 0: nothing known
    min_remnant: NotNegative = 1000.0  #: a remnant of at least this length goes back to stock
    profiles: tuple[str, ...] = ("I", "U", "L", "M", "C", "T")  #: DSTV codes that it takes


class Times(Keys, frozen=True):
    """Times other than axis motion."""

    spindle_s: NotNegative = 0.0  #: to start and stop a spindle, each operation
    tool_change_s: NotNegative = 0.0  #: another tool of the spindle's own stations
    spindle_change_s: NotNegative = 0.0  #: another spindle
    manual_change_s: NotNegative = 0.0  #: manual tool change in a station
    saw_s: NotNegative = 0.0  #: to clamp, start and stop the saw, each cut
    text_s: NotNegative = 0.0  #: to stamp or print a text


class ControlledAxis(Keys, frozen=True):
    """An axis of the machine, in the order of the controller's registers.

    `moves` is the letter that moves it in a program, for the axis of a spindle together with
    `spindle`; `angle` is the saw's rotation and `saw` its stroke, which the saw word moves.
    """

    name: str  #: in traces, messages and the `bodies` that it carries
    #: letter that moves it in a program; angle is the saw's rotation, saw its stroke
    moves: Literal["X", "Y", "Z", "A", "B", "angle", "saw"]
    speed: Positive  #: maximum, mm/s or deg/s; the rate of rapid moves
    acceleration: Positive  #: mm/s2 or deg/s2
    spindle: int | None = None  #: number of the spindle that it belongs to
    min: float | None = None  #: None has no limit
    max: float | None = None  #: None has no limit
    park: float = 0.0  #: position at program start
    jerk: Positive | None = None  #: mm/s3 or deg/s3; None has no limit

    @property
    def limits(self) -> tuple[float, float]:
        """Minimum and maximum position, infinite where there is no limit."""
        return -inf if self.min is None else self.min, inf if self.max is None else self.max


#: What a body's box may depend on: the section that is worked.
SECTION_NAMES = ("height", "width", "flange_thickness", "web_thickness")


class MachineBox(Keys, frozen=True):
    """A box of the machine, placed as it stands when the axes that carry it stand at 0.

    x runs downstream along the bar from machine X 0, y across the web from its middle as Y of a
    program does, z downward from the top of the bar as Z does. An axis that carries the box is
    called by its name, with - before it where it moves the box the other way.
    """

    name: Text  #: in messages
    min: tuple[Formula, Formula, Formula]  #: minimum x, y and z
    max: tuple[Formula, Formula, Formula]  #: maximum x, y and z
    x: str = ""  #: axis that carries it along x; fixed in x if absent
    y: str = ""  #: axis that carries it along y
    z: str = ""  #: axis that carries it along z
    turn: str = ""  #: axis in degrees that turns it about the vertical, from x towards y
    pivot: tuple[Formula, Formula] | None = None  #: x and y that it turns about; 0 and 0 if absent

    @property
    def carriers(self) -> tuple[str, str, str, str]:
        """The axes along x, y and z and the turning one; "" where there is none."""
        return self.x, self.y, self.z, self.turn


def signed(carrier: str) -> tuple[str, int]:
    """The name of an axis that carries a body, and the sign of its motion."""
    return (carrier[1:], -1) if carrier.startswith("-") else (carrier, 1)


#: What a word of a line's own does: nothing, or of a G word a canned cycle of drilling, straight
#: down, with a dwell, drawn back for the chips or to break them, or the end of one.
CycleMeaning = Literal[
    "none", "drill-cycle", "drill-cycle-dwell", "drill-cycle-peck", "drill-cycle-chips", "end-cycle"
]
#: What a word of a table's own does besides nothing. `thc` is the control of the torch's height by
#: its voltage, `arc off` puts the arc out while the head runs on, `output` is anything else that
#: has to be off when the program ends. Words carry a number with `feed share` (percent; 0, and 100
#: or more, are all of it), `height` (mm over the sheet) and `material` (the number of a row);
#: `touch off` goes down to the sheet and counts Z from there.
TableMeaning = Literal[
    "torch on", "torch off", "cutting oxygen on", "cutting oxygen off", "preheat on",
    "preheat off", "thc on", "thc off", "arc on", "arc off", "output on", "output off",
    "feed share", "height", "touch off", "material",
]  # fmt: skip
CodeMeaning = Literal[CycleMeaning, TableMeaning]


class Modbus(Keys, frozen=True):
    """The registers of a controller: output k is axis k, in the order of `[[axes]]`.

    The same signed values are in the holding and the input registers.
    """

    values: Literal["int16", "int32", "float"] = "int16"  #: of one, two and two registers an axis
    scale: Positive = 1.0  #: mm or degrees of one count, of int16 and int32
    scales: tuple[Positive, ...] = ()  #: for each axis, where they differ
    word_order: Literal["high-first", "low-first"] = "high-first"  #: of two registers
    first: Count = 0  #: address of axis 0
    states: bool = True  #: spindle, diameter, turning, coolant, sawing and line follow the axes

    @property
    def words(self) -> int:
        """Registers of an axis."""
        return 1 if self.values == "int16" else 2

    def scale_of(self, axis: int) -> float:
        """mm or degrees of one count."""
        return self.scales[axis] if self.scales else self.scale


class MachineFile(Keys, frozen=True):
    """What a machine's file may say; the fields are its keys."""

    name: str  #: that of the file, if it gives none
    title: str  #: what it is, in lists of machines
    #: the family of its controller
    controller: Literal["codesys", "linuxcnc", "grbl", "mach3", "simotion", "plcopen", "stepper"]
    stock: Stock  #: what it works on; profile: coped all round
    format: NumberFormat
    words: Words = Words()
    suffix: str = ".gcode"  #: of its programs
    default_for: tuple[str, ...] = ()  #: suffixes of outputs for which it is taken; not inherited
    choice: PositiveCount = 1  #: place among those tried for such an output; not inherited
    layout: Layout | None = None
    saw: Saw | None = None
    drill: Drill | None = None
    spindles: tuple[Spindle, ...] = ()
    times: Times = Times()
    pairs: tuple[Pair, ...] = ()
    tools: tuple[ToolSet, ...] = ()
    axes: tuple[ControlledAxis, ...] = ()
    #: that may strike each other; empty: collisions are not checked
    bodies: tuple[MachineBox, ...] = ()
    modbus: Modbus = Modbus()
    torch: Torch | None = None
    coper: Coper | None = None
    marks: Marks = Marks()
    triggers: Triggers | None = None
    stepper: Stepper | None = None
    sections: Mapping[str, int] = field(default_factory=dict)  #: the program's section codes
    #: words that the controller of this machine takes besides those of its family, as "G81", "M77",
    #: "M64P2" (with what it carries), "o<probe>" (a call) or "#<holes>" (a value that is set)
    codes: Mapping[str, CodeMeaning] = field(default_factory=dict)
    #: all G and M words that it takes, as "G01"; empty: those of its family, codes and words
    allowed_codes: tuple[str, ...] = ()
    #: block that the controller runs before each program, as LinuxCNC's RS274NGC_STARTUP_CODE
    startup_code: str = ""


class Machine(MachineFile, frozen=True):
    """A machine: `beamcam machines show NAME` prints every value and where it comes from."""

    checksum: str = ""  #: of all that its file says, in the heads of its programs; no key of it
    #: on its files, such as keys of an older version; no key of it
    remarks: tuple[Diagnostic, ...] = ()

    def sections_of(self, number: float) -> tuple[str, ...]:
        """The DSTV codes that a section's number in a program may mean, of those it takes."""
        taken = self.sections if self.layout is None else self.layout.profiles
        return tuple(c for c, own in self.sections.items() if own == number and c in taken)

    def needed(self, station: Station | None, what: str) -> Station:
        """A station that a stage works with. Raises TypeError for a machine of another kind."""
        if station is None:
            raise TypeError(f"{self.name} has no {what}")
        return station


# A line without a saw takes parts that are cut; one without a drill saws them only. What the work
# asks of a station holds for these too, but for who would make a cut, or lay parts on a bar.
NO_SAW = Saw(
    kerf=0.0, min_angle=-90.0, max_angle=90.0, max_height=MAX_COORDINATE, max_width=MAX_COORDINATE,
    min_tilt=-90.0, max_tilt=90.0, compound=True,
)  # fmt: skip


NO_DRILL = Drill(x=0.0, max_height=MAX_COORDINATE, max_width=MAX_COORDINATE, fits=(), cutting=())


def saw_of(machine: Machine) -> Saw:
    """The saw of a machine, or one that cuts nothing."""
    return machine.saw or NO_SAW


def drill_of(machine: Machine) -> Drill:
    """The drill of a machine, or one that reaches nothing."""
    return machine.drill or NO_DRILL


def text_x(machine: Machine) -> float:
    """Machine X of a text at bar x 0, where a stamp or printer letters."""
    return drill_of(machine).x if machine.marks.x is None else machine.marks.x


class PathLimits(Struct, frozen=True):
    """Limits of a table's axes along a path of any direction, in mm and s; infinite where none are.

    Running up along the path and being turned across it share the acceleration of the axes: what
    the machine's file gives along the path, `a` of `A`, leaves sqrt(A^2 - a^2) across. Where it
    gives nothing, half is taken along, as LinuxCNC's planner does.
    """

    speed_x_mm_s: float
    speed_y_mm_s: float
    along_mm_s2: float
    straight_mm_s2: float  #: along a line, where nothing is turned
    across_mm_s2: float
    jerk_mm_s3: float
    corner: float  #: of a circle from a corner that is passed as fast; 0 stops at each

    @property
    def speed_mm_s(self) -> float:
        """The speed of the slower axis, which is possible in every direction."""
        return min(self.speed_x_mm_s, self.speed_y_mm_s)


def path_limits(machine: Machine) -> PathLimits | None:
    """The limits of a machine's path; None where its file has no axes X and Y."""
    axes = {axis.moves: axis for axis in machine.axes}
    torch = machine.torch
    if torch is None or "X" not in axes or "Y" not in axes:
        return None
    x, y = axes["X"], axes["Y"]
    whole = min(x.acceleration, y.acceleration)
    along = torch.acceleration or ALONG_SHARE * whole
    jerk = min(inf if axis.jerk is None else axis.jerk for axis in (x, y))
    across = sqrt(whole * whole - along * along)
    straight = torch.acceleration or whole
    return PathLimits(x.speed, y.speed, along, straight, across, jerk, torch.corner)


# --- G and M words --------------------------------------------------------------------------------

# Those that a machine's file gives a meaning, and all that its controller takes.
#
#     G81, M77           a word, whatever it carries
#     M64P2              a word with what tells it from its like
#     o<probe>           a call of a subroutine, LinuxCNC's
#     #<holes>           a value that is set by its name, LinuxCNC's
#     Z                  a letter of a table that beamcam does not follow


_CODE = re.compile(r"([GM])(\d{1,3})(\.\d)?")
CARRYING_CODE = re.compile(r"(M\d{1,3})([A-Z$])(-?\d{1,6}(?:\.\d{1,3})?)")
_IN_BRACES = re.compile(r"\{(\w+)")
#: M words that switch outputs, and the letter that says which.
_OUTPUTS = {
    **dict.fromkeys(("M10", "M11", "M62", "M63", "M64", "M65"), "P"), "M67": "E", "M68": "E",
}  # fmt: skip
#: Meanings that need a number with the word.
CARRYING = {"feed share": "E P Q", "height": "P Q", "material": "P Q"}
#: Letters that a table of X and Y may carry for axes and offsets that beamcam does not follow.
OTHER_LETTERS = frozenset("ABCUVWZHTKELD")


def plain_code(text: str) -> str | None:
    """A G or M word without leading zeros, `G01` as `G1`; None if it is none."""
    match = _CODE.fullmatch(text)
    if match is None or (match[1] == "M" and match[3]):
        return None
    return f"{match[1]}{int(match[2])}{match[3] or ''}"


def plain_key(text: str) -> str:
    """A key of `[codes]` as programs are looked at: `M064P02` as `M64P2`, any other as it is."""
    match = CARRYING_CODE.fullmatch(text)
    if match is not None:
        return f"{plain_code(match[1])}{match[2]}{float(match[3]):g}"
    return plain_code(text) or text


def names_in(words: Words, templates: Iterable[str]) -> frozenset[str]:
    """The names in braces that some templates carry."""
    lines = (line for template in templates for line in getattr(words, template))
    return frozenset(name for line in lines for name in _IN_BRACES.findall(line))


def meaning_of(
    codes: Mapping[str, CodeMeaning], code: str, values: Mapping[str, float]
) -> tuple[str, CodeMeaning] | None:
    """The key that explains a word with what it carries, and what it says; None if there is none.

    A key with what the word carries goes before one of the word alone.
    """
    for letter, value in values.items():
        key = f"{code}{letter}{value:g}"
        if key in codes:
            return key, codes[key]
    return (code, codes[code]) if code in codes else None


def key_for(code: str, values: Mapping[str, float]) -> str:
    """The key that would explain a word: with the number of its output, where it is one's."""
    letter = _OUTPUTS.get(code, "")
    return f"{code}{letter}{values[letter]:g}" if values.get(letter, -1.0) >= 0.0 else code


def shown_code(code: str) -> str:
    """A plain word as programs have it, `G1` as `G01`."""
    return f"{code[0]}0{code[1:]}" if len(code.partition(".")[0]) == 2 else code


# --- defaults -------------------------------------------------------------------------------------

ANY_SUFFIX = "*"

#: Stock and suffix of the output -> machines in the order in which they are tried, from the keys
#: `default_for` and `choice` of the shipped files. It stands here since reading all of them takes
#: longer than posting a small part; a test compares.
DEFAULTS: Mapping[tuple[Stock, str], tuple[str, ...]] = {
    ("beam", "*"): ("beamline", "beamline-pusher"),
    ("beam", ".gcode"): ("beamline", "beamline-pusher"),
    ("sheet", "*"): ("plate-linuxcnc", "plate-codesys", "plate-oxyfuel"),
    ("sheet", ".bin"): ("laser-stepper",), ("sheet", ".csv"): ("laser-stepper",),
    ("sheet", ".gcode"): ("plate-codesys",), ("sheet", ".h"): ("laser-stepper",),
    ("sheet", ".nc"): ("laser-grbl",), ("sheet", ".ngc"): ("plate-linuxcnc", "plate-oxyfuel"),
    ("sheet", ".st"): ("table-simotion",), ("sheet", ".steps"): ("laser-stepper",),
    ("sheet", ".tap"): ("plate-mach3",),
    ("profile", "*"): ("coper-linuxcnc", "coper-tilt-linuxcnc", "tube-linuxcnc"),
}  # fmt: skip

DEFAULT_MACHINE = DEFAULTS["beam", ANY_SUFFIX][0]


def default_machines(stock: Stock, output: str = "", flats: bool = False) -> tuple[str, ...]:
    """The machines for that stock where none is named, by the name of the output, in order.

    A torch that goes round profiles may make of bars what no line that saws and drills does, and
    such a line `flats` that no table makes.
    """
    names = DEFAULTS.get((stock, PurePath(output).suffix.lower()), DEFAULTS[stock, ANY_SUFFIX])
    other: Stock = "profile" if stock == "beam" else "beam"
    return (*names, *DEFAULTS[other, ANY_SUFFIX]) if flats or stock == "beam" else names


def is_of_sheets(program: str) -> bool:
    """Whether programs with that suffix are always of sheets."""
    suffix = PurePath(program).suffix.lower()
    return ("sheet", suffix) in DEFAULTS and ("beam", suffix) not in DEFAULTS
