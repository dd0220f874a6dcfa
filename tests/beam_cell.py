"""The beam cell, told by somebody who knows the cell and nothing of beamcam.

    program of a bar  ->  strokes and paths on the faces of the section, cuts along the bar

A stop (or a pusher) moves the bar along X; three spindles drill it and a saw cuts it:

    M40 K1 | K2 | K3 | K13 L d     left flange (o), web (v), right flange (u), both flanges
    G01 X Y Z                      the chosen spindle's place and stroke
    M42 K angle [L tilt]           the saw, on the annex M41

The web's spindle lies across at Y = height / 2 - y and strokes along Z, those of the flanges at
Z = 188.6 - y and along Y. A stroke counts from the outermost steel on the spindle's side. A drill's
point of 118 degrees goes beyond its full diameter by radius / tan 59. Nothing of beamcam is used.
"""

import re
from math import atan, cos, degrees, hypot, radians, tan
from typing import NamedTuple

Point = tuple[float, float]
FACES = {1: "o", 2: "v", 3: "u", 13: "ou"}
KINDS = {
    "M40": "drill",
    "M45": "tap",
    "M47": "sink",
    "M48": "punch",
    "M49": "mill",
    "M50": "scribe",
}
SWITCHES = ("M03", "M04", "M05", "M08", "M09", "G90", "M30")
TAN_59 = 1.6642794823505180
FLANGE_Z = 188.6


class Section(NamedTuple):
    """Header lines 8 to 14 of a DSTV file, but for the name."""

    code: str
    height: float
    width: float
    flange: float
    web: float
    radius: float

    def below(self, face: str) -> float:
        """How far a face lies below the outermost steel on its side."""
        if face != "v":  # the stem of a T stands in the middle of its flange
            return (self.height - self.flange) / 2 if self.code == "T" else 0.0
        least = {"I": (self.width - self.web) / 2, "M": 0.0, "B": 0.0}
        return least.get(self.code, self.width - self.web)

    def wall(self, face: str) -> float:
        """Thickness of the steel behind a face."""
        return self.web if face == "v" else self.flange

    @property
    def outer_radius(self) -> float:
        """Of the round corners; a tube's header has it, a lipped channel's the inner one."""
        return {"M": self.radius, "C": self.radius + self.web}.get(self.code, 0.0)

    def edges(self) -> list[Point]:
        """Places (y, z) of steel at both edges of the side on which the bar lies."""
        r, h = self.outer_radius, self.height
        return [(0.0, r), (r, 0.0), (h - r, 0.0), (h, r)]

    def reach(self, up: float, across: float) -> float:
        """The greatest up * y + across * z where there is steel.

        The toes of an angle and of a T are as thick as their legs; corners may be round.
        """
        h, b, flange, web = self[1:5]
        outer = self.outer_radius
        if self.code == "L":
            boxes = [(0.0, h, 0.0, web), (0.0, flange, 0.0, b)]
        elif self.code == "T":
            boxes = [(0.0, h, 0.0, web), ((h - flange) / 2, (h + flange) / 2, 0.0, b)]
        else:
            boxes = [(outer, h - outer, outer, b - outer)]
        ends = [up * y + across * z for box in boxes for y in box[:2] for z in box[2:]]
        return max(ends) + outer * hypot(up, across)


class Cell(NamedTuple):
    """One of the shipped cells."""

    drill_x: float  #: machine X of a hole at bar x 0
    saw_x: float
    kerf: float
    square: float  #: what the saw calls a square cut
    kerf_along_bar: bool  #: whether the kerf is counted along the bar, or across the blade
    pivot_at_top: bool  #: whether a cut's X counts on the edge of o, or on that of u
    saw_word: str
    strokes_fixed: bool
    one_way: bool  #: whether a stop holds the bar, and only gives way
    codes: dict[str, int]
    digits: float  #: half of the last digit of a length

    def kerf_x(self, web_deg: float, flange_deg: float) -> float:
        """Width of a cut along the bar."""
        a, b = tan(radians(web_deg)), tan(radians(flange_deg))
        return self.kerf * (1.0 if self.kerf_along_bar else (1.0 + a * a + b * b) ** 0.5)


_BEAMLINE = Cell(
    778.56, 0.0, 4.04, 0.0, False, True, "M42", False, True, {"I": 1, "U": 2, "L": 3}, 0.0005
)
CELLS = {
    "beamline": _BEAMLINE,
    "beamline-annex": _BEAMLINE._replace(
        kerf_along_bar=True, saw_word="M41", strokes_fixed=True, codes={"I": 1, "U": 3}, digits=0.05
    ),
    "beamline-pusher": Cell(
        0.0, 1250.0, 1.6, 90.0, False, False, "M42", False, False,
        {"I": 1, "U": 2, "L": 3, "M": 4, "C": 5, "T": 6, "B": 9}, 0.0005,
    ),
}  # fmt: skip


class Stroke(NamedTuple):
    """A tool in the steel, at one place or along a path."""

    kind: str
    face: str
    diameter: float
    places: tuple[Point, ...]  #: x on the bar, y on the face
    depth: float  #: of the full diameter of a drill, of the point of any other tool
    pitch: float
    line: int  #: of the program


class Cut(NamedTuple):
    """A cut of the saw."""

    x: float  #: along the bar, of the blade's middle on the edge on which the cell counts it
    web_deg: float  #: positive where x falls as y grows
    tilt_deg: float
    line: int


class CellError(Exception):
    """A word that the cell does not know, or that makes no sense."""


def run(program: str, name: str, section: Section) -> tuple[list[Stroke], list[Cut]]:
    """What the program makes of a bar of that section. Raises CellError."""
    cell, strokes, cuts = CELLS[name], list[Stroke](), list[Cut]()
    at = {"X": 0.0, "Y": 0.0, "Z": 0.0}
    tool: tuple[str, str, float] | None = None
    pitch = 0.0
    number = 0
    way: list[tuple[float, float, float]] = []  # X, Y and Z of feeds into the steel

    def finish() -> None:
        if tool is None or not way:
            way.clear()
            return
        kind, faces, diameter = tool
        for face in faces:
            places = tuple(
                (x - cell.drill_x, section.height / 2 - y if face == "v" else FLANGE_Z - z)
                for x, y, z in way
            )
            depth = max(z if face == "v" else y for _, y, z in way)
            if not cell.strokes_fixed:
                depth -= section.below(face)
                depth -= diameter / 2 / TAN_59 if kind == "drill" else 0.0
            strokes.append(Stroke(kind, face, diameter, places, depth, pitch, number))
        way.clear()

    for number, line in enumerate(program.splitlines(), start=1):
        words = [w for w in line.split() if not re.fullmatch(r"N\d+", w)]
        if not words or words[0].startswith(("%", "(")):
            continue
        code, values = words[0], {w[0]: float(w[1:]) for w in words[1:]}
        if code in ("G00", "G01"):
            start = dict(at)
            at |= {letter: values[letter] for letter in values if letter in at}
            if cell.one_way and at["X"] < start["X"]:
                raise CellError(f"the stop goes back: {line}")
            axis = "Z" if tool and tool[1] == "v" else "Y"
            deep = section.below(tool[1]) if tool and not cell.strokes_fixed else 0.0
            if tool and code == "G01" and at[axis] > deep + 1e-6:
                way.append((at["X"], at["Y"], at["Z"]))
            elif tool and start[axis] > deep + 1e-6:
                finish()
            elif code == "G00" and tool and at[axis] > deep + 1e-6:
                raise CellError(f"rapid into the steel: {line}")
        elif code in KINDS:
            finish()
            tool, pitch = (KINDS[code], FACES[int(values["K"])], values["L"]), 0.0
        elif code == "M46":
            pitch = values["K"]
        elif code == cell.saw_word:
            finish()
            tool = None
            turned = values["K"] - cell.square
            cuts.append(Cut(at["X"] - cell.saw_x, turned, values.get("L", 0.0), number))
        elif code == "M44":
            size = section.height if cell.strokes_fixed else section.width
            if (values["K"], values["L"]) != (size, section.height):
                raise CellError(f"another section: {line}")
        elif code == "M43":
            if values["K"] != cell.codes[section.code]:
                raise CellError(f"another kind of section: {line}")
        elif code not in (*SWITCHES, "M06"):
            raise CellError(f"unknown: {line}")
    finish()
    return strokes, cuts


def end_x(section: Section, length: float, web_deg: float, flange_deg: float, last: bool,
          y: float, z: float) -> float:  # fmt: skip
    """x of a part's first or last plane: a corner of the section lies at 0, or at the length.

    DSTV: an angle is atan2(x at the lowest y - x at the highest y, height), at either end.
    """
    a, b = tan(radians(web_deg)), tan(radians(flange_deg))
    at_zero = length - section.reach(-a, -b) if last else section.reach(a, b)
    return at_zero - y * a - z * b


def tilt_of(web_deg: float, flange_deg: float) -> float:
    """Tilt of a blade that is turned by the web's angle and cuts the flange at its own."""
    return degrees(atan(tan(radians(flange_deg)) * cos(radians(web_deg))))
