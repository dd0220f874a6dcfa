"""Random parts for the beam cell as DSTV files, each with the figures that it was written from."""

from collections.abc import Iterator
from math import hypot
from random import Random
from typing import NamedTuple

from tests.beam_cell import Section

SECTIONS = {
    "I": (Section("I", 300.0, 150.0, 10.7, 7.1, 15.0), Section("I", 200.0, 200.0, 15.0, 9.0, 18.0),
          Section("I", 450.0, 190.0, 14.6, 9.4, 21.0)),
    "U": (Section("U", 200.0, 75.0, 11.5, 8.5, 11.5), Section("U", 300.0, 100.0, 16.0, 10.0, 16.0)),
    "L": (Section("L", 150.0, 100.0, 12.0, 10.0, 12.0),
          Section("L", 120.0, 120.0, 11.0, 13.0, 13.0)),
    "M": (Section("M", 200.0, 120.0, 8.0, 8.0, 12.0),),
    "C": (Section("C", 220.0, 90.0, 4.0, 4.0, 4.0),),  # its lips are LIP long
    "T": (Section("T", 180.0, 100.0, 12.0, 10.0, 8.0),),
}  # fmt: skip
TAKEN = {"beamline": "IUL", "beamline-annex": "IU", "beamline-pusher": "IULMCT"}
LIP = 20.0
DRILLED = (11.0, 13.0, 14.0, 18.0, 22.0, 26.0)
THREADS = {12.0: (1.75, 10.2), 16.0: (2.0, 14.0), 20.0: (2.5, 17.5)}


def weight(section: Section) -> float:
    """Kilograms a metre as the header of a C has them, which says its lips; 1 of any other.

    Web, flanges and lips between the bends, whose outside is 8, and four bends of 6 in the middle.
    """
    if section.code != "C":
        return 1.0
    middle = (220.0 - 16.0) + 2 * (90.0 - 16.0) + 2 * (LIP - 8.0) + 4 * 9.42477796076938
    return middle * 4.0 * 7.85e-3


class Feature(NamedTuple):
    """A row of a part: a hole, or a slot that is `length` longer than it is wide."""

    kind: str  #: hole, thread, sink, point, slot or line
    face: str
    x: float
    y: float
    diameter: float
    depth: float | None = None  #: None is through
    length: float = 0.0  #: of a slot between its centres, of a line along x

    def row(self) -> str:
        """As DSTV writes it; a slot stands at its first centre."""
        place = f"  {self.face} {self.x:9.2f}u {self.y:9.2f}"
        size = {"thread": "g", "sink": "s"}.get(self.kind, "") + f"{self.diameter:.2f}"
        depth = 0.0 if self.depth is None else self.depth
        if self.kind == "slot":
            return f"{place} {size} 0.00l {self.length:.2f} 0.00 0.00"
        if self.kind == "sink":
            return f"{place} {size} {depth:.2f} 0.00 0.00 90.00"
        return f"{place} {size} {depth:.2f}"


class Bar(NamedTuple):
    """A part of a bar."""

    section: Section
    length: float
    ends: tuple[float, float, float, float]  #: web start, web end, flange start, flange end
    features: tuple[Feature, ...]

    def file(self, mark: str) -> str:
        """The part as a DSTV file."""
        s = self.section
        stock = s.height, s.width, s.flange, s.web, s.radius, weight(s), 1.0
        sizes = (self.length, *stock, *self.ends)
        head = ["ST", "  1", "  1", "  1", f"  {mark}", "  S235JR", "  1", f"  {s.code}-STOCK",
                f"  {s.code}", *(f"  {size:.3f}" for size in sizes), "", "", "", ""]  # fmt: skip
        lines = [f for f in self.features if f.kind == "line"]
        holes = [f for f in self.features if f.kind != "line"]
        body = ["BO", *(f.row() for f in holes)] if holes else []
        for f in lines:
            body += ["KO", f"  {f.face} {f.x:.2f}u {f.y:.2f} 0.00",
                     f"  {f.x + f.length:.2f} {f.y:.2f} 0.00"]  # fmt: skip
        return "\n".join([*head, *body, "EN", ""])


def room(section: Section, face: str, random: Random) -> tuple[float, float] | None:
    """y between which a wall is free of other walls and their fillets; None if a face has none."""
    web, flange, radius = section.web, section.flange, section.radius
    size, wall = (section.height, flange) if face == "v" else (section.width, web)
    first, last = wall + radius, size - wall - radius
    match section.code:
        case "I" if face != "v":
            middle = size / 2
            beside = wall / 2 + radius
            return (0.0, middle - beside) if random.random() < 0.5 else (middle + beside, size)
        case "T":
            return (0.0, (size - flange) / 2 - radius) if face == "v" else (first, size)
        case "L":
            return None if face == "o" else (first, size)
        case "U" | "C" if face != "v":
            return first, size - 20.0 * (section.code == "C")
        case "C":
            return LIP + 0.01, size - LIP - 0.01
    return first, last


def random_bar(name: str, random: Random) -> tuple[Bar, ...]:
    """One to three parts of one section for a cell."""
    section = random.choice(SECTIONS[random.choice(TAKEN[name])])
    return tuple(_part(name, section, random) for _ in range(random.choice((1, 1, 2, 3))))


def _part(name: str, section: Section, random: Random) -> Bar:
    turns = random.random() < 0.6
    web = [random.choice((0.0, 5.0, -12.5, 18.0, 30.0, -25.25)) * turns for _ in range(2)]
    flange = [0.0, 0.0]
    if name == "beamline-pusher" and section.code in "IUM" and random.random() < 0.4:
        flange = [random.choice((0.0, 10.0, 22.5)) for _ in range(2)]
    length = round(random.uniform(1800, 3200), 1)
    kept: list[Feature] = []
    for feature in _features(name, section, length, random):
        reach = feature.diameter / 2 + feature.length
        if all(
            f.face != feature.face
            or hypot(f.x - feature.x, f.y - feature.y) > reach + f.diameter / 2 + f.length + 30.0
            for f in kept
        ):
            kept += _with_drill(feature)
    return Bar(section, length, (*web, *flange), tuple(kept))  # type: ignore[arg-type]


def _with_drill(feature: Feature) -> list[Feature]:
    """A sink stands on a through hole."""
    if feature.kind != "sink":
        return [feature]
    return [Feature("hole", feature.face, feature.x, feature.y, 11.0), feature]


def _features(name: str, section: Section, length: float, random: Random) -> Iterator[Feature]:
    kinds = ["hole"] * 6
    if name != "beamline-annex":
        kinds += ["blind"]
    if name == "beamline-pusher":
        kinds += ["thread", "sink", "point", "slot", "line"]
    for _ in range(random.randint(2, 10)):
        kind, face = random.choice(kinds), random.choice("vvou")
        between = room(section, face, random)
        diameter = random.choice(DRILLED)
        if kind == "thread":
            diameter = random.choice(tuple(THREADS))
        elif kind in ("sink", "point", "line"):
            diameter = 20.0 if kind == "sink" else 0.0
        elif kind == "slot":
            diameter = random.choice((18.0, 22.0))
        if between is None or between[1] - between[0] < diameter + 8.0:
            continue
        side = diameter / 2 + 4.0
        y = round(random.uniform(between[0] + side, between[1] - side), 2)
        # A skew end takes up to tan 30 of 450 and tan 22.5 of 200 off the length.
        x = round(random.uniform(380, length - 480), 2)
        wall = section.wall(face)
        if kind == "blind":
            yield Feature("hole", face, x, y, 14.0, round(wall * 0.4, 2))
        elif kind == "sink":
            # A cone of 90 degrees from 20 down to the hole of 11 is 4.5 deep.
            yield Feature(
                "sink", face, x, y, 20.0, random.choice((None, 4.5)) if wall > 5.0 else None
            )
        else:
            away = {"slot": round(random.uniform(10, 40), 2), "line": 60.0}.get(kind, 0.0)
            yield Feature(kind, face, x, y, diameter, None, away)
