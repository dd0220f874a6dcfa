"""The cylinders in OpenCASCADE's BREP text of a solid, in mm: facets lose the radius of a hole.

ifcopenshell gives facets, or this text ("BRep Format", dox/specification/brep_format.md), in which
a surface stands on a line of its own, by a type and its numbers. Which of the text's locations a
face has does not matter: each cylinder is given at all of them, and only those count on which the
corners of facets lie. That these do is the law of tests/unit/readers/ifc/test_brep.py.
"""

import re
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.readers.ifc.space import IDENTITY, Frame, Vec, cross, size, unit

METRES = Frame(x=(1e3, 0.0, 0.0), y=(0.0, 1e3, 0.0), z=(0.0, 0.0, 1e3))  #: the kernel's unit
#: Type and count of words of a cylinder's line, and of the circle's that an extrusion has.
ROUND = ("2", 14)
STRAIGHT = 1e-12  #: between an extrusion and its circle's axis, from rounding
OTHERS = {
    ("4", 14): "sphere", ("5", 15): "torus", ("7", 7): "surface of revolution",
    ("8", 5): "Bezier surface", ("9", 11): "B-spline surface",
}  # fmt: skip


class BrepError(ValueError):
    """A text that is not a BREP; says what was found and what was expected."""


class Cylinder(Struct, frozen=True):
    """A cylinder about the z of a frame."""

    frame: Frame
    radius: float

    @property
    def axis(self) -> Vec:
        """The unit vector along it."""
        return unit(self.frame.z)

    def off(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """How many mm points (n, 3) lie off it."""
        across = np.cross(points - np.array(self.frame.o), np.array(self.axis))
        off: NDArray[np.float64] = np.abs(np.linalg.norm(across, axis=1) - self.radius)
        return off

    def moved(self, by: Frame) -> "Cylinder":
        """The cylinder elsewhere; its radius grows as the frame does."""
        grown = size(by.vector(self.frame.x)) / size(self.frame.x)
        return Cylinder(by.times(self.frame), self.radius * grown)


def surfaces_of(text: str) -> tuple[tuple[Cylinder, ...], tuple[str, ...]]:
    """The cylinders that faces of a BREP text in metres may lie on, in mm, and its other surfaces.

    Those are the names of what facets alone stand for. Raises BrepError.
    """
    head, *tables = re.split(r"(?m)^(Locations|Curve2ds|Surfaces|Triangulations) \d+\s*$", text)
    if "CASCADE Topology V" not in head:
        raise BrepError(f"found {head.strip()[:40]!r}; expected 'CASCADE Topology V'")
    named = dict(zip(tables[::2], tables[1::2], strict=True))
    if "Locations" not in named or "Surfaces" not in named:
        raise BrepError("found no table of locations or surfaces; expected both")
    lines = [line.split() for line in named["Surfaces"].splitlines()]
    try:
        places = _locations(iter(named["Locations"].split()))
        rounds = [[float(w) for w in line[1:]] for line in lines if (*line[:1], len(line)) == ROUND]
    except (IndexError, StopIteration, ValueError) as fault:
        raise BrepError(f"found a table that does not hold ({fault})") from fault
    local = [
        Cylinder(Frame(*(tuple(n[i : i + 3]) for i in (0, 6, 9, 3))), n[12])  # type: ignore[arg-type]
        for n in rounds
    ]
    everywhere = {METRES.times(a.times(b)) for a in places for b in places}
    others = {OTHERS[key] for line in lines if (key := (*line[:1], len(line))) in OTHERS}
    others |= {"extruded curve" for one, line in pairwise(lines) if _is_of_no_arc(one, line)}
    return tuple(c.moved(place) for c in local for place in everywhere), tuple(sorted(others))


def _is_of_no_arc(extrusion: list[str], curve: list[str]) -> bool:
    """Whether two lines are an extrusion neither of a line nor of a circle along its axis."""
    if extrusion[:1] != ["6"] or len(extrusion) != 4 or curve[0] == "1":
        return False
    along, axis = ([float(w) for w in words] for words in (extrusion[1:], curve[4:7]))
    x, y, z = cross((along[0], along[1], along[2]), (axis[0], axis[1], axis[2]))
    return curve[0] != "2" or max(abs(x), abs(y), abs(z)) > STRAIGHT


def _locations(words: Iterator[str]) -> list[Frame]:
    """The locations by their numbers, of which 0 is none at all."""
    frames = [IDENTITY]
    for kind in words:
        if kind == "1":
            m = [float(next(words)) for _ in range(12)]
            frames.append(Frame(*((m[i], m[4 + i], m[8 + i]) for i in (3, 0, 1, 2))))
            continue
        place = IDENTITY
        while number := int(next(words)):
            one, power = frames[number], int(next(words))
            for _ in range(abs(power)):  # each is put to the left of those before it
                place = (one if power > 0 else one.inverse()).times(place)
        frames.append(place)
    return frames
