"""Accessories that no bar is: rods and straps bent about one axis and another, as Breps.

A model of a building has hundreds; each is refused, which may not take longer than reading it.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, sin
from random import Random

from tests.property.ifc_builder import Pair, Step, Vec

Stand = tuple[Vec, Vec, Vec]  #: a place on the middle line, and the two axes of the ring there
Ring = list[Pair]
BEND_STEPS = 14
ACROSS: Vec = (0.0, 0.0, 1.0)


def _along(o: Vec, *terms: tuple[float, Vec]) -> Vec:
    x, y, z = (o[i] + sum(by * way[i] for by, way in terms) for i in range(3))
    return x, y, z


def _bend(
    o: Vec, ahead: Vec, towards: Vec, radius: float, turn: float
) -> list[tuple[Vec, Vec, Vec]]:
    """Places of an arc, with the directions ahead and towards its centre."""
    out = []
    for k in range(BEND_STEPS + 1):
        s, c = sin(turn * k / BEND_STEPS), cos(turn * k / BEND_STEPS)
        at = _along(o, (radius * s, ahead), (radius * (1 - c), towards))
        out.append((at, _along((0, 0, 0), (c, ahead), (s, towards)),
                    _along((0, 0, 0), (c, towards), (-s, ahead))))  # fmt: skip
    return out


def _hull(stands: Sequence[Stand], ring: Ring) -> list[list[Vec]]:
    """The faces of a ring that is carried along: both ends, and a quadrangle each side and step."""
    rings = [[_along(o, (a, u), (b, v)) for a, b in ring] for o, u, v in stands]
    faces = [rings[0][::-1], rings[-1]]
    for one, other in pairwise(rings):
        faces += [[one[i - 1], one[i], other[i], other[i - 1]] for i in range(len(ring))]
    return faces


def bent(random: Random) -> list[list[Vec]]:
    """The faces of a hooked rod, or of a strap that is bent both ways."""
    is_rod = random.random() < 0.5
    if is_rod:
        r = random.choice((8.0, 10.0, 12.0))
        ring = [(r * cos(2 * pi * k / 24), r * sin(2 * pi * k / 24)) for k in range(24)]
        radius, turn, length = 3 * r, random.choice((pi / 2, pi)), 350.0
    else:
        t, b = random.choice((5.0, 8.0, 10.0)), random.choice((60.0, 80.0))
        ring = [(-t / 2, -b / 2), (t / 2, -b / 2), (t / 2, b / 2), (-t / 2, b / 2)]
        radius, turn, length = 2 * t, random.choice((0.5, 0.8, 1.2)), 150.0
    places = _bend((length, 0, 0), (1, 0, 0), (0, 1, 0), radius, turn)
    end, ahead, towards = places[-1]
    tip = _along(end, (100.0, ahead))
    stands: list[Stand] = [((0, 0, 0), (0, 1, 0), ACROSS)]
    stands += [(o, u, ACROSS) for o, _, u in places]
    stands.append((tip, towards, ACROSS))
    if not is_rod:
        stands += [(o, towards, v) for o, _, v in _bend(tip, ahead, ACROSS, 60.0, 0.6)[1:]]
    return _hull(stands, ring)


def add_bent(step: Step, placement: str, faces: list[list[Vec]], mark: str) -> None:
    """Write an accessory."""
    points: dict[Vec, str] = {}
    made = []
    for face in faces:
        for p in face:
            if p not in points:
                points[p] = step.point(*(round(c, 4) for c in p))
        loop = step.add(f"IFCPOLYLOOP(({','.join(points[p] for p in face)}))")
        bound = step.add(f"IFCFACEOUTERBOUND({loop},.T.)")
        made.append(step.add(f"IFCFACE(({bound}))"))
    shell = step.add(f"IFCCLOSEDSHELL(({','.join(made)}))")
    brep = step.add(f"IFCFACETEDBREP({shell})")
    shape = step.add(f"IFCSHAPEREPRESENTATION({step.context},'Body','Brep',({brep}))")
    product = step.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")
    last = "" if step.schema == "IFC2X3" else ",$"
    step.add(
        f"IFCDISCRETEACCESSORY('{step.guid()}',{step.owner},'STRAP',$,$,{placement},{product},"
        f"'{mark}'{last})"
    )
