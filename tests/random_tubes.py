"""Random round tubes: slots, windows and holes, also across the seam; ends that are no planes."""

from math import cos, pi, tau
from random import Random

from beamcam.errors import Source
from beamcam.geometry.curves import Arc
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, Feature, Hole, Part, Profile, Slot
from tests.random_copes import polygon

AT = Source("tube.nc1")
SECTIONS = (
    Profile("RO", "CHS168.3*8", 168.3, 168.3, 0.0, 8.0),
    Profile("RO", "CHS88.9*5", 88.9, 88.9, 0.0, 5.0),
    Profile("RO", "CHS273*12.5", 273.0, 273.0, 12.5, 12.5),
)  # fmt: skip


def random_tube(seed: int) -> Part:
    """A tube with up to four cut-outs."""
    random = Random(seed)
    profile = random.choice(SECTIONS)
    turn, length = pi * profile.height, round(random.uniform(400.0, 900.0), 1)
    features: list[Feature] = []
    if random.random() < 0.6:
        features.append(_ends(turn, length, random))
    for x in (150.0, 220.0, 290.0)[: random.randrange(4)]:
        u = round(random.uniform(0.0, turn), 2)
        kind = random.randrange(3)
        if kind == 0:
            features.append(Hole("v", x, u, random.choice((18.0, 22.0, 30.0)), AT))
        elif kind == 1:
            turned = random.choice((0.0, 90.0, 30.0))
            features.append(Slot("v", x, u, 18.0, 14.0, 0.0, turned, AT))
        else:
            box = [(x, u), (x + 40.0, u), (x + 40.0, u + 36.0), (x, u + 36.0)]
            features.append(Contour("v", "inner", polygon(box), AT))
    return Part(f"T{seed}", profile, length, AT, features=tuple(features), grade="S235JR")


def random_slotted(seed: int) -> Part:
    """A tube with slots for gussets, drawn sharp and narrower than two radii of a torch: one open
    to an end, its floor square or skew, and one that is closed; some across the seam."""
    random = Random(seed)
    profile = random.choice(SECTIONS)
    turn, length = pi * profile.height, round(random.uniform(400.0, 600.0), 1)
    wide, deep = (round(random.uniform(*most), 1) for most in ((8.0, 21.0), (40.0, 120.0)))
    skew = random.choice((0.0, round(random.uniform(-0.4, 0.4) * wide, 1)))
    u = round(random.uniform(0.0, turn - wide), 1)
    ends = [(0.0, 0.0), (length, 0.0), (length, turn), (0.0, turn), (0.0, u + wide),
            (deep + skew, u + wide), (deep, u), (0.0, u)]  # fmt: skip
    features: list[Feature] = [Contour("v", "outer", polygon(ends), AT)]
    across, u = round(random.uniform(14.0, 21.0), 1), round(random.uniform(0.0, turn), 1)
    closed = [(200.0, u), (290.0, u), (290.0, u + across), (200.0, u + across)]
    features.append(Contour("v", "inner", polygon(closed), AT))
    return Part(f"S{seed}", profile, length, AT, features=tuple(features), grade="S235JR")


def _ends(turn: float, length: float, random: Random) -> Contour:
    """An outline whose ends run as a mitre does, or as a saddle, or square."""
    waves = [random.choice((0, 1, 2)) for _ in range(2)]
    deep = [random.uniform(5.0, 20.0) * (wave > 0) for wave in waves]
    count = 144

    def x(end: int, k: int) -> float:
        off = deep[end] * (1.0 - cos(waves[end] * tau * k / count))
        return off if end == 0 else length - off

    points: list[Point] = [(x(1, k), turn * k / count) for k in range(count + 1)]
    points += [(x(0, k), turn * k / count) for k in range(count, -1, -1)]
    return Contour("v", "outer", polygon(points), AT)


def window(x: float, u: float, along: float, across: float) -> Contour:
    """A cut-out with round corners of 12 mm."""
    r = 12.0
    arcs = []
    for k, (cx, cu) in enumerate(((along, across), (0.0, across), (0.0, 0.0), (along, 0.0))):
        middle = x + (cx - r if cx else r), u + (cu - r if cu else r)
        arcs.append(Arc(middle, r, 90.0 * k, 90.0))
    curves = []
    for k, arc in enumerate(arcs):
        after = arcs[(k + 1) % 4]
        curves += [arc, *polygon([arc.end, after.start])[:1]]
    return Contour("v", "inner", tuple(curves), AT)
