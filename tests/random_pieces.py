"""Random tubes whose ends are there, square or skew, with outlines that are open to the near one:
slots, notches, copes over corners, windows that reach the end; beside them holes."""

from collections.abc import Callable
from math import cos, pi, radians, sin, tan
from random import Random

from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, EndCuts, Face, Feature, Hole, Part, Profile
from beamcam.model.section import corners
from tests.random_boxes import AT, CORNERS, outline
from tests.random_boxes import SECTIONS as BOXES
from tests.random_copes import polygon
from tests.random_tubes import SECTIONS as ROUND

BESIDE = 6.0  #: mm between two bites, at least
Bite = tuple[float, float, list[Point]]  #: from and to which place across, what is taken between


def random_open(seed: int) -> Part:
    """A round tube or a rectangular one with up to three outlines at its near end."""
    random = Random(seed)
    length = round(random.uniform(650.0, 800.0), 1)
    skew = EndCuts()
    if random.random() < 0.4:
        angle = random.choice((-30.0, 15.0, 40.0))
        skew = EndCuts(web_start=angle) if random.random() < 0.5 else EndCuts(flange_start=angle)
    if random.random() < 0.5:
        profile = random.choice(ROUND)
        far, turn = profile.height * 0.9 + 130.0, pi * profile.height
        length += far
        features = [_round_outline(profile, length, skew, random)]
        holes: list[Feature] = [
            Hole("v", far + 60.0 * k, round(random.uniform(0.0, turn), 1), 22.0, AT)
            for k in range(random.randrange(3))
        ]  # fmt: skip
    else:
        profile = random.choice(BOXES)
        features = _box_outlines(profile, length, skew, random)
        far = max(profile.height, profile.width) * 0.9 + 130.0
        holes = [
            Hole(face, far + 60.0 * k, profile.face_width(face) / 2, 18.0, AT)
            for k, face in enumerate(random.sample(("v", "o", "u", "h"), random.randrange(3)))
        ]  # fmt: skip
    made = tuple(holes[::2])
    features = [*features, *holes[1::2]]
    return Part(
        f"P{seed}", profile, length, AT, features=tuple(features), made=made, grade="S235JR",
        cuts=skew,
    )  # fmt: skip


def end_of(profile: Profile, cuts: EndCuts) -> Callable[[float, float], float]:
    """x of the near end by y and z of the section, as the header has it."""
    web, flange = tan(radians(cuts.web_start)), tan(radians(cuts.flange_start))
    if profile.code == "RO":
        r = profile.height / 2
        return lambda y, z: (r - y if web > 0 else -r - y) * web * (1 if web else 0) + (
            (r - z) if flange > 0 else (-r - z)) * flange  # fmt: skip
    reach = max(web * y + flange * z for y, z in corners(profile))
    return lambda y, z: reach - web * y - flange * z


def _bite(random: Random, low: float, high: float, x: Callable[[float], float]) -> Bite:
    """What is taken between two places across an end: a slot, a notch with a slanting side, a round
    one, or one with a slanting floor."""
    deep = random.uniform(15.0, 70.0)
    a, b = x(low), x(high)
    kind = random.randrange(4)
    floor = max(a, b) + deep
    if kind == 0:
        return low, high, [(floor, low), (floor, high)]
    if kind == 1 and high - low > 14.0:
        lean = random.uniform(0.2, 0.6) * min(high - low - 10.0, deep)
        return low, high, [(floor, low + lean), (floor, high)]
    if kind == 2 and high - low > 20.0:
        r, turns = (high - low) / 2, range(1, 24)
        base = max(a, b) + 5.0
        ring = [(base + r * sin(pi * k / 24), low + r - r * cos(pi * k / 24)) for k in turns]
        return low, high, [(base, low), *ring, (base, high)]
    return low, high, [(floor + random.uniform(0.0, 6.0), low), (floor, high)]


def _round_outline(profile: Profile, length: float, cuts: EndCuts, random: Random) -> Contour:
    turn, r = pi * profile.height, profile.height / 2
    at = end_of(profile, cuts)

    def x(u: float) -> float:
        return at(-r * cos(u / r), r * sin(u / r))

    places = sorted(random.uniform(0.0, turn) for _ in range(2 * random.randrange(1, 3)))
    bites = [
        _bite(random, a, b, x) for a, b in zip(places[::2], places[1::2], strict=True)
        if b - a > 7.0 and a > BESIDE and b < turn - BESIDE
    ]  # fmt: skip
    if len(bites) > 1 and bites[1][0] - bites[0][1] < BESIDE:
        bites.pop()
    across = [turn * k / 180 for k in range(181)]
    near = _with_bites([(x(u), u) for u in across], bites, x)
    return Contour("v", "outer", polygon([*near[::-1], (length, 0.0), (length, turn)]), AT)


def _with_bites(line: list[Point], bites: list[Bite], x: Callable[[float], float]) -> list[Point]:
    """A line along an end, rising across, less some bites."""
    for low, high, ring in bites:
        before = [p for p in line if p[1] < low - 0.5]
        after = [p for p in line if p[1] > high + 0.5]
        line = [*before, (x(low), low), *ring, (x(high), high), *after]
    return line


def _box_outlines(
    profile: Profile, length: float, cuts: EndCuts, random: Random
) -> list[Feature]:  # fmt: skip
    """The outlines of some faces: bites within their flats, and one over a corner or a cope of one
    whole side."""
    at = end_of(profile, cuts)
    h, b, r = profile.height, profile.width, profile.radius
    lines: dict[Face, Callable[[float], float]] = {
        "v": lambda y: at(y, b), "h": lambda y: at(y, 0.0),
        "o": lambda z: at(h, z), "u": lambda z: at(0.0, z),
    }  # fmt: skip
    bites: dict[Face, list[Bite]] = {}
    taken: set[Face] = set()
    if random.random() < 0.6:
        a, a_high, c, c_high = random.choice(CORNERS)
        edge = lines[a](profile.face_width(a) if a_high else 0.0)
        floor = edge + random.uniform(20.0, 60.0)
        for face, high, lean in ((a, a_high, random.choice((0.0, 4.0))), (c, c_high, 0.0)):
            wide, into = profile.face_width(face), r + random.uniform(4.0, 15.0)
            deep = floor + max(0.0, lines[face](wide - into if high else into) - edge)
            if high:
                bites[face] = [(wide - into, wide, [(deep + lean, wide - into), (floor, wide)])]
            else:
                bites[face] = [(0.0, into, [(floor, 0.0), (deep + lean, into)])]
        taken |= {a, c}
    for face in random.sample(("v", "o", "u", "h"), random.randrange(3)):
        wide = profile.face_width(face)
        low = round(random.uniform(r + 1.0, wide - r - 20.0), 2)
        high = round(min(low + random.uniform(8.0, 40.0), wide - r - 1.0), 2)
        if face not in taken and high - low > 7.0:
            bites.setdefault(face, []).append(_bite(random, low, high, lines[face]))
            taken.add(face)
    found: list[Feature] = []
    for face, some in bites.items():
        wide, x = profile.face_width(face), lines[face]
        near = _with_bites([(x(0.0), 0.0), (x(wide), wide)], some, x)
        # What begins or ends at an edge leaves no end there.
        if some[0][0] == 0.0:
            near = near[near.index(some[0][2][0]) :]
        if some[0][1] == wide:
            near = near[: near.index(some[0][2][-1]) + 1]
        ring = [(length, 0.0), (length, wide), *near[::-1]]
        found.append(outline(face, ring))
    if "v" in bites and "h" not in bites:  # which has that of v else
        found.append(outline("h", [(length, 0.0), (length, h), (lines["h"](h), h),
                                   (lines["h"](0.0), 0.0)]))  # fmt: skip
    if "h" in bites and "v" not in bites:
        found.append(outline("v", [(length, 0.0), (length, h), (lines["v"](h), h),
                                   (lines["v"](0.0), 0.0)]))  # fmt: skip
    if not found:  # a window that the end cuts
        y = profile.height / 2
        low = lines["v"](y) - 5.0
        found.append(outline("v", [(low, y - 6.0), (low + 60.0, y - 6.0), (low + 60.0, y + 6.0),
                                   (low, y + 6.0)], "inner"))  # fmt: skip
    return found
