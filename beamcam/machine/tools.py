"""The tools of a line: each by itself, and the sets that a machine file lists."""

from collections.abc import Iterable
from math import radians, tan
from typing import Literal

from msgspec import Struct

from beamcam.conversion import Keys, NotNegative, Positive

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


FLAT_DEG = 180.0


MM_PER_INCH = 25.4


class ToolSet(Keys, frozen=True):
    """Tools of one kind in the diameters that the shop has."""

    kind: ToolKind  #: of all of them
    diameters: tuple[float, ...] = ()  #: each is a tool
    inches: tuple[str, ...] = ()  #: more of them, as "13/16" or "1 1/16"
    point_deg: Positive = 118.0  #: angle of the point or the cone; 180 is flat
    faces: tuple[Literal["v", "o", "u", "h"], ...] = ("v", "o", "u", "h")  #: of spindles
    pitches: tuple[float, ...] = ()  #: of taps, one for each diameter
    pre_drills: tuple[float, ...] = ()  #: of taps, the drill before each of them
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
        return round(float(sum(Fraction(word) for word in text.split())) * MM_PER_INCH, 6)
    except (ValueError, ArithmeticError) as error:
        raise ValueError(f"{text!r} is no size in inches") from error
