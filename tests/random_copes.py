"""Random parts for a coper: I, U, L, T, C with copes at their ends, notches, windows, holes."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import asin, atan, cos, degrees, radians, tan
from random import Random

from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.model.part import Bevel, Contour, EndCuts, Feature, Hole, Part, Profile, Slot

AT = Source("part.nc1")
SECTIONS = (
    Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0),
    Profile("I", "HEA240", 230.0, 240.0, 12.0, 7.5, 21.0),
    Profile("I", "IPE450", 450.0, 190.0, 14.6, 9.4, 21.0),
    Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
    Profile("U", "UPE300", 300.0, 100.0, 15.0, 9.5, 15.0),
    Profile("L", "L100*65*8", 100.0, 65.0, 8.0, 8.0, 10.0),
    Profile("L", "L150*15", 150.0, 150.0, 15.0, 15.0, 16.0),
)  # fmt: skip


#: Whose fillets are small beside the torch, so that a pass is deeper than they are.
SMALL_ROOTS = (
    Profile("I", "UB254*146*31", 251.4, 146.1, 8.6, 6.0, 7.6),
    Profile("I", "UB203*133*25", 203.2, 133.2, 7.8, 5.7, 7.6),
    Profile("U", "PFC200*75*23", 200.0, 75.0, 12.5, 6.0, 12.0),
)  # fmt: skip


TEES = (
    Profile("T", "T100", 100.0, 100.0, 11.0, 11.0, 11.0),
    Profile("T", "1/2 IPE300", 150.0, 150.0, 7.1, 10.7, 15.0),
    Profile("T", "1/2 HEA240", 240.0, 115.0, 7.5, 12.0, 21.0),
    Profile("T", "1/2 IPE450", 190.0, 225.0, 9.4, 14.6, 21.0),
)  # fmt: skip


CEES = (
    Profile("C", "C200*75*20*2.5", 200.0, 75.0, 2.5, 2.5, 3.5, 20.0),
    Profile("C", "C300*90*28*3", 300.0, 90.0, 3.0, 3.0, 4.0, 28.0),
    Profile("C", "C150*65*15*1.5", 150.0, 65.0, 1.5, 1.5, 0.0, 15.0),
    Profile("C", "C250*80*42*4", 250.0, 80.0, 4.0, 4.0, 6.0, 42.0),
)


def polygon(points: list[Point]) -> tuple[Curve, ...]:
    """A closed chain of lines."""
    ends = (*points[1:], points[0])
    return tuple(Line(a, b) for a, b in zip(points, ends, strict=True) if a != b)


def random_cope(seed: int, sections: Sequence[Profile] = SECTIONS, near: bool = False) -> Part:
    """A part whose copes cut web and flange at one x; `near` to the roots or well off them."""
    random = Random(seed)
    profile = random.choice(sections)
    length = round(random.uniform(500.0, 1500.0), 1)
    features: list[Feature] = []
    flanges = ("u",) if profile.code == "L" else ("o", "u")
    back = {
        (face, end): round(random.uniform(30.0, 120.0), 2) if random.random() < 0.4 else 0.0
        for face in flanges
        for end in (0, 1)
    }
    for face in flanges:
        features.append(_flange(profile, face, length, back, random))
    features.append(Contour("v", "outer", _web(profile, length, back, random, near), AT))
    features += _holes(profile, length, flanges, random)
    return Part(f"C{seed}", profile, length, AT, features=tuple(features), grade="S235JR")


def random_lipped(seed: int) -> Part:
    """A C with lips, as `random_cope`; with a flange that has no lip between its ends now and
    then."""
    part = random_cope(seed, CEES)
    if seed % 4 != 3:
        return part
    long, wide = part.length, part.profile.width
    tip = wide - 2 * (part.profile.web_thickness or 0.0) - part.profile.radius - 12.0
    bare = polygon([(0.0, 0.0), (long, 0.0), (long, tip), (0.0, tip)])
    others = tuple(f for f in part.features if isinstance(f, Hole) and f.face == "o")
    return replace(part, features=(*others, Contour("u", "outer", bare, AT)))


def random_mitre(seed: int, sections: Sequence[Profile] = (*SECTIONS, *TEES)) -> Part:
    """A part with skew ends by its header, some of them drawn on the web too, with some holes."""
    random = Random(seed)
    profile = random.choice(sections)
    length = round(random.uniform(1200.0, 1800.0), 1)
    angles: list[float] = []
    for _ in range(2):
        kind = random.choice(("web", "web", "flange", "both", "square"))
        angles += [
            round(random.uniform(5.0, 44.0) * random.choice((-1, 1)), 2)
            if kind in (which, "both") else 0.0
            for which in ("web", "flange")
        ]  # fmt: skip
    cuts = EndCuts(angles[0], angles[2], angles[1], angles[3])
    features: list[Feature] = []
    if profile.code != "T":
        low = profile.flange_thickness + profile.radius + 25.0
        features.append(Hole("v", round(length / 2 + 17.0, 1), low, 18.0, AT))
        if not (cuts.flange_start or cuts.flange_end) and random.random() < 0.5:
            features.append(Contour("v", "outer", _skew_web(profile, length, cuts), AT))
    return Part(
        f"M{seed}", profile, length, AT, cuts=cuts, features=tuple(features), grade="S235JR"
    )


def random_slant(seed: int, sections: Sequence[Profile] = SECTIONS) -> Part:
    """A part whose copes cross their roots on a slant: of the web at the upper flange, and of the
    lower flange, whose end leans over a web that ends square."""
    random = Random(seed)
    profile = random.choice([one for one in sections if one.code != "L"])
    high, wide = profile.height, profile.width
    web, flange = profile.web_thickness or 0.0, profile.flange_thickness
    length = round(random.uniform(600.0, 1200.0), 1)
    rise, lean = (
        tan(radians(random.choice((-1, 1)) * round(random.uniform(3.0, 27.0), 1)))
        for _ in range(2)
    )  # fmt: skip
    middle = round(high / 2, 1)
    first = round(random.uniform(60.0, 120.0) + max(0.0, -rise) * middle, 1)
    at = round(first + rise * (high - flange - middle), 3)  # of the web below the upper flange
    back = (wide - web) / 2 if profile.code == "I" else 0.0
    ends = length - max(0.0, lean) * wide, length - max(0.0, lean) * wide + lean * wide
    ends = ends[0] + length - max(ends), ends[1] + length - max(ends)
    end = round(ends[0] + lean * (back + (web if lean > 0.0 else 0.0)), 3)
    deep = flange + profile.radius + 32.0
    # A header has the angle of an end though one flange is coped back from it, or it has none.
    said = random.random() < 0.5
    cuts = EndCuts(flange_end=-degrees(atan(lean))) if said else EndCuts()
    return Part(f"S{seed}", profile, length, AT, grade="S235JR", cuts=cuts, features=(
        Contour("v", "outer", polygon([
            (0.0, 0.0), (end, 0.0), (end, high - deep), (end - 70.0, high - deep),
            (end - 70.0, high), (first + rise * (high - middle), high), (first, middle),
            (0.0, middle),
        ]), AT),
        Contour("o", "outer", polygon([
            (at, 0.0), (end - 70.0, 0.0), (end - 70.0, wide), (at, wide),
        ]), AT),
        Contour("u", "outer", polygon([
            (0.0, 0.0), (ends[0], 0.0), (ends[1], wide), (0.0, wide),
        ]), AT),
    ))  # fmt: skip


def random_stripped(seed: int) -> Part:
    """A part whose flanges are cut along the web, flush to it or in the fillet beside it: at one or
    both ends, on one or both sides, or between the ends; or with a hole over a fillet."""
    random = Random(seed)
    profile = random.choice((*SECTIONS, *TEES))
    is_tee = profile.code == "T"
    lying = Profile(  # a T as an I that has no upper flange
        "I", profile.name, profile.width, profile.height, profile.web_thickness or 0.0,
        profile.flange_thickness, profile.radius,
    ) if is_tee else profile  # fmt: skip
    length = round(random.uniform(500.0, 900.0), 1)
    faces = ("u",) if profile.code in ("L", "T") else ("o", "u")
    found = [one for face in faces for one in _stripped(lying, face, length, random)]
    features = tuple(_on_tee(one, profile, random) if is_tee else one for one in found)
    return Part(f"F{seed}", profile, length, AT, features=features, grade="S235JR")


def _stripped(profile: Profile, face: str, length: float, random: Random) -> Iterator[Feature]:
    """The outline of a flange that is cut along the web, with a hole now and then."""
    wide, web, radius = profile.width, profile.web_thickness or 0.0, profile.radius
    back = (wide - web) / 2 if profile.code == "I" else 0.0
    low, high = (
        round(random.choice((0.0, 0.0, random.uniform(0.5, radius + 3.0))), 2) for _ in range(2)
    )
    low, high = back - low, back + web + high
    first, last = (round(random.uniform(40.0, 140.0), 1) for _ in range(2))
    begin: list[Point] = [(0.0, wide), (0.0, 0.0)]
    end: list[Point] = [(length, 0.0), (length, wide)]
    between: list[Point] = []
    kind = random.choice(("far", "far", "near", "both", "pocket", "hole"))
    if kind in ("far", "both"):
        end = [(length, 0.0), (length, high), (length - last, high), (length - last, wide)]
        if back and random.random() < 0.5:
            end[:1] = [(length - last, 0.0), (length - last, low), (length, low)]
    if kind in ("near", "both"):
        begin = [(first, wide), (first, high), (0.0, high), (0.0, 0.0)]
    if kind == "pocket":
        between = [(last + 200.0, wide), (last + 200.0, high), (200.0, high), (200.0, wide)]
    if kind == "hole":
        size = random.choice((18.0, 22.0))
        if (y := round(high + size / 2, 2)) + size < wide:
            yield Hole("o" if face == "o" else "u", 300.0, y, size, AT)
    ring = polygon([*end, *between, *begin])
    yield Contour("o" if face == "o" else "u", "outer", ring, AT)


def random_bevel(seed: int) -> Part:
    """A part whose flanges, or legs, have bevels at their ends on the outside, with lands."""
    random = Random(seed)
    profile = random.choice(SECTIONS)
    length = round(random.uniform(500.0, 1200.0), 1)
    features: list[Feature] = []
    for face in ("u",) if profile.code == "L" else ("o", "u"):
        wide = profile.width
        curves = polygon([(0.0, 0.0), (length, 0.0), (length, wide), (0.0, wide)])
        if is_back := face == "o" and random.random() < 0.5:  # as files have it: clockwise
            curves = polygon([(0.0, 0.0), (0.0, wide), (length, wide), (length, 0.0)])
        land = round(random.uniform(0.0, 3.0), 1)
        angle = round(random.uniform(25.0, 44.0), 1)
        which = random.choice(((1,), (3,), (1, 3)))
        bevels = tuple(Bevel((curve + 1) % 4 if is_back else curve, angle, land) for curve in which)
        features.append(Contour(face, "outer", curves, AT, bevels=bevels))
    return Part(f"W{seed}", profile, length, AT, features=tuple(features), grade="S235JR")


def random_prepared_web(seed: int) -> Part:
    """A part whose web is coped at all flanges and has bevels at its ends: on the outside, on the
    far side or on both with a land between, drawn on v or h."""
    random = Random(seed)
    profile = random.choice([one for one in SECTIONS if one.code != "L"] + list(TEES))
    is_tee = profile.code == "T"
    if is_tee:  # as it lies: an I without an upper flange
        high, wide = profile.width, profile.height
    else:
        high, wide = profile.height, profile.width
    web = profile.web_thickness or 0.0
    length = round(random.uniform(500.0, 1200.0), 1)
    deep = round(profile.flange_thickness + profile.radius + random.uniform(34.0, 45.0), 1)
    back, top = round(random.uniform(40.0, 90.0), 1), high if is_tee else high - deep
    upper = [] if is_tee else [
        (length - back, top), (length - back, high), (back, high), (back, top)
    ]  # fmt: skip
    points = [
        (back, 0.0), (length - back, 0.0), (length - back, deep), (length, deep),
        (length, top), *upper, (0.0, top), (0.0, deep), (back, deep),
    ]  # fmt: skip
    bevels: list[Bevel] = []
    for curve in random.choice(((3,), (len(points) - 3,), (3, len(points) - 3))):
        angle, kind = round(random.uniform(25.0, 44.0), 1), random.choice("uulkk")
        split = round(random.uniform(0.35, 0.6) * web, 2)
        land = round(random.uniform(0.0, 2.0), 1)
        bevels += [Bevel(curve, angle, split + land)] if kind in "uk" else []
        bevels += [Bevel(curve, -angle, split)] if kind in "lk" else []
    drawn = Contour("v", "outer", polygon(points), AT, bevels=tuple(bevels))
    short = polygon([(back, 0.0), (length - back, 0.0), (length - back, wide), (back, wide)])
    flanges = [Contour(face, "outer", short, AT) for face in ("u" if is_tee else "ou")]
    features: list[Feature] = [drawn, *flanges]
    if is_tee:
        features = [_on_tee(feature, profile, random) for feature in features]
    elif random.random() < 0.3:
        features[0] = replace(drawn, face="h")
    return Part(f"K{seed}", profile, length, AT, features=tuple(features), grade="S235JR")


def random_shaped_bevel(seed: int) -> Part:
    """A part with bevels along its flanges or its free leg, at slanted, hollow and bulging ends of
    a web that is coped at all flanges, or at flanges that end skew; some round a corner."""
    random = Random(seed)
    angle, land = round(random.uniform(25.0, 44.0), 1), round(random.uniform(0.0, 2.0), 1)
    kind = random.choice(("along", "corner", "leg", "skew", "web", "web", "web"))
    length = round(random.uniform(500.0, 900.0), 1)
    profile = random.choice([one for one in SECTIONS if (one.code == "L") == (kind == "leg")])
    if kind == "web":
        return _shaped_web(f"F{seed}", profile, length, angle, random)
    high, wide = profile.height, profile.width
    features: list[Feature] = []
    cuts = EndCuts()
    if kind == "leg":
        ring = [(0.0, 0.0), (length, 0.0), (length, high), (0.0, high)]
        features.append(Contour("v", "outer", polygon(ring), AT, bevels=(Bevel(2, angle, land),)))
    elif kind == "corner":  # along the bar, round the corner and across it
        r = round(random.uniform(15.0, 25.0), 1)
        ring = [*polygon([(0.0, 0.0), (length - r, 0.0)])[:1], Arc((length - r, r), r, -90.0, 90.0)]
        for a, b in pairwise([(length, r), (length, wide), (0.0, wide), (0.0, 0.0)]):
            ring.append(Line(a, b))
        which = random.choice(((0, 1, 2), (1, 2), (0, 1)))
        bevels = tuple(Bevel(k, angle, land) for k in which)
        features.append(Contour("u", "outer", tuple(ring), AT, bevels=bevels))
    elif kind == "along":
        for face in ("o", "u"):
            which = random.choice(((0,), (0, 1), (0, 3), (2,)))
            ring = [(0.0, 0.0), (length, 0.0), (length, wide), (0.0, wide)]
            bevels = tuple(Bevel(k, angle, land) for k in which)
            features.append(Contour(face, "outer", polygon(ring), AT, bevels=bevels))
    else:
        lean = round(random.uniform(5.0, 25.0), 1) * random.choice((-1, 1))
        cuts = EndCuts(flange_end=lean)
        slope = tan(radians(lean))
        ends = [length + min(0.0, slope) * wide, length - max(0.0, slope) * wide]
        ring = [(0.0, 0.0), (ends[0], 0.0), (ends[1], wide), (0.0, wide)]
        for face in ("o", "u"):
            bevels = (Bevel(random.choice((1, 3)), angle, land),)
            features.append(Contour(face, "outer", polygon(ring), AT, bevels=bevels))
    return Part(
        f"F{seed}", profile, length, AT, cuts=cuts, features=tuple(features), grade="S235JR"
    )


def _shaped_web(mark: str, profile: Profile, length: float, angle: float, random: Random) -> Part:
    """A web that stands out between its flanges at the far end, which is slanted or round."""
    high, web = profile.height, profile.web_thickness or 0.0
    deep = round(profile.flange_thickness + profile.radius + random.uniform(34.0, 45.0), 1)
    back, half = length - round(random.uniform(90.0, 120.0), 1), (high - 2 * deep) / 2
    shape = random.choice(("slanted", "hollow", "bulging"))
    low, top = (length, deep), (length, high - deep)
    end: list[Curve] = [Line(low, top)]
    if shape == "slanted":
        by = round(random.uniform(-0.3, 0.3) * 2 * half, 2)
        low, top = (length - max(0.0, by), deep), (length + min(0.0, by), high - deep)
        end = [Line(low, top)]
    else:
        radius = round(half * random.uniform(1.5, 3.0), 1)
        turn = degrees(asin(half / radius))
        off = radius * cos(radians(turn))
        if shape == "hollow":
            arc = Arc((length + off, high / 2), radius, 180.0 + turn, -2 * turn)
        else:
            arc = Arc((length - radius, high / 2), radius, -turn, 2 * turn)
        end, low, top = [arc], arc.start, arc.end
    before = [(0.0, 0.0), (back, 0.0), (back, deep), low]
    behind = [top, (back, high - deep), (back, high), (0.0, high), (0.0, 0.0)]
    curves = [*(Line(a, b) for a, b in pairwise(before)), *end,
              *(Line(a, b) for a, b in pairwise(behind))]  # fmt: skip
    land, lower = round(random.uniform(0.0, 2.0), 1), random.choice("ulk")
    split = round(random.uniform(0.4, 0.6) * web, 2)
    bevels: list[Bevel] = []
    for k in range(3, 3 + len(end)):
        over = land + (split if lower == "k" else 0.0)
        bevels += [Bevel(k, angle, over)] if lower in "uk" else []
        bevels += [Bevel(k, -angle, split)] if lower in "lk" else []
    drawn = Contour("v", "outer", tuple(curves), AT, bevels=tuple(bevels))
    if random.random() < 0.3:
        drawn = replace(drawn, face="h")
    flange = polygon([(0.0, 0.0), (back, 0.0), (back, profile.width), (0.0, profile.width)])
    flanges = [Contour(face, "outer", flange, AT) for face in "ou"]
    return Part(mark, profile, length, AT, features=(drawn, *flanges), grade="S235JR")


def _skew_web(profile: Profile, length: float, cuts: EndCuts) -> tuple[Curve, ...]:
    """The outline of a web between ends that are skew in the view of it alone."""
    high = profile.height
    first, last = (tan(radians(angle)) * high for angle in (cuts.web_start, cuts.web_end))
    return polygon([
        (max(first, 0.0), 0.0), (length + min(last, 0.0), 0.0),
        (length - max(last, 0.0), high), (max(-first, 0.0), high),
    ])  # fmt: skip


def random_tee(seed: int, near: bool = False) -> Part:
    """A T whose copes cut stem and flange at one x, each plate drawn on either of its sides.

    It is drawn as it lies under a torch, as an I without an upper flange: what is at y of its
    flange is at height - y of v and h, what is at y of its web at y of o and u.
    """
    random = Random(seed)
    tee = random.choice(TEES)
    web, flange = tee.flange_thickness, tee.web_thickness or 0.0
    lying = Profile("I", tee.name, tee.width, tee.height, flange, web, tee.radius)
    length = round(random.uniform(500.0, 1500.0), 1)
    back = {
        ("u", end): round(random.uniform(30.0, 120.0), 2) if random.random() < 0.4 else 0.0
        for end in (0, 1)
    }
    drawn = (
        _flange(lying, "u", length, back, random),
        Contour("v", "outer", _web(lying, length, back, random, near), AT),
        *_tee_holes(lying, length, random),
    )
    features = tuple(_on_tee(feature, tee, random) for feature in drawn)
    return Part(f"T{seed}", tee, length, AT, features=features, grade="S235JR")


def _tee_holes(lying: Profile, length: float, random: Random) -> list[Feature]:
    """Holes and slots of the stem, holes of the flange."""
    found: list[Feature] = []
    low, high = lying.flange_thickness + lying.radius + 25.0, lying.height - 20.0
    for x in (180.0, 260.0, 340.0):
        y = round(random.uniform(low, high), 2)
        if high > low and random.random() < 0.6:
            found.append(Hole("v", x, y, random.choice((18.0, 22.0)), AT))
        elif high > low and random.random() < 0.6:
            found.append(Slot("v", x, y, 18.0, 20.0, 0.0, random.choice((0.0, 10.0)), AT))
    edge = lying.width / 2 - (lying.web_thickness or 0.0) / 2 - lying.radius
    if edge > 45.0:
        found.append(Hole("u", 220.0, random.choice((edge / 2, lying.width - edge / 2)), 18.0, AT))
    return found


def _on_tee(feature: Feature, tee: Profile, random: Random) -> Feature:
    """A feature of the lying section, on a face of the T."""
    assert isinstance(feature, Hole | Slot | Contour)
    is_flange = feature.face == "u"
    face = random.choice("vh" if is_flange else "ou")
    if isinstance(feature, Contour):
        curves = feature.curves
        if is_flange:
            curves = tuple(c.transformed(((1, 0, 0), (0, -1, tee.height))) for c in curves)
        if face in ("v", "o"):  # seen from the other side: the ring runs the other way
            curves = tuple(c.reversed() for c in reversed(curves))
        return replace(feature, face=face, curves=curves)
    return replace(feature, face=face, y=tee.height - feature.y if is_flange else feature.y)


def _flange(
    profile: Profile, face: str, length: float, back: dict[tuple[str, int], float], random: Random
) -> Contour:
    """A flange between its copes, square over the web, perhaps with a corner or a notch taken."""
    wide, first, last = profile.width, back[face, 0], length - back[face, 1]
    points: list[Point] = [(first, 0.0), (last, 0.0), (last, wide), (first, wide)]
    tip = wide / 2 - profile.radius - (profile.web_thickness or 0.0) / 2 - 8.0
    if profile.code != "I":
        tip = wide - profile.radius - (profile.web_thickness or 0.0) - 8.0
    if random.random() < 0.4 and tip > 15.0:
        deep = round(random.uniform(0.3, 0.9) * tip, 2)
        along = round(random.uniform(20.0, 60.0), 2)
        points[2:3] = [(last, wide - deep), (last - along, wide)]
    if random.random() < 0.3 and tip > 25.0:
        deep = round(random.uniform(15.0, tip), 2)
        x = round(random.uniform(first + 100.0, last - 160.0), 2)
        points[-1:-1] = [
            (x + 60.0, wide), (x + 60.0, wide - deep), (x, wide - deep), (x, wide)
        ]  # fmt: skip
    return Contour(face, "outer", polygon(points), AT)


def _web(
    profile: Profile, length: float, back: dict[tuple[str, int], float], random: Random,
    near: bool = False,
) -> tuple[Curve, ...]:  # fmt: skip
    """The web's outline with the copes; their corners are sharp or have a radius."""
    high, root = profile.height, profile.flange_thickness + profile.radius + 12.0
    radius = random.choice((0.0, 10.0, 13.0, 16.0))
    deep = root + 20.0 + round(random.uniform(0.0, 10.0), 2)
    if near:
        deep, radius = deep - 32.0 + random.choice((0.0, 4.0, 8.0)), random.choice((0.0, 0.0, 5.0))
    curves: list[Curve] = []
    here: Point | None = None

    def to(point: Point) -> None:
        nonlocal here
        if here is not None and here != point:
            curves.append(Line(here, point))
        here = point

    def corner(middle: Point, first: float, start: Point, end: Point) -> None:
        """A re-entrant corner: clockwise on a ring that runs the other way."""
        nonlocal here
        if not radius:
            return
        to(start)
        curves.append(Arc(middle, radius, first, -90.0))
        here = end

    u0, u1 = back["u", 0], length - back["u", 1]
    o0, o1 = back.get(("o", 0), 0.0), length - back.get(("o", 1), 0.0)
    to((u0, 0.0))
    to((u1, 0.0))
    if u1 < length:
        corner((u1 + radius, deep - radius), 180.0, (u1, deep - radius), (u1 + radius, deep))
        to((u1, deep)) if not radius else None
        to((length, deep))
    if o1 < length:
        to((length, high - deep))
        corner(
            (o1 + radius, high - deep + radius), 270.0, (o1 + radius, high - deep),
            (o1, high - deep + radius),
        )  # fmt: skip
        to((o1, high - deep)) if not radius else None
    to((o1, high))
    to((o0, high))
    if o0 > 0.0:
        corner(
            (o0 - radius, high - deep + radius), 0.0, (o0, high - deep + radius),
            (o0 - radius, high - deep),
        )  # fmt: skip
        to((o0, high - deep)) if not radius else None
        to((0.0, high - deep))
    if u0 > 0.0:
        to((0.0, deep))
        corner((u0 - radius, deep - radius), 90.0, (u0 - radius, deep), (u0, deep - radius))
        to((u0, deep)) if not radius else None
    to((u0, 0.0))
    return tuple(curves)


def _holes(
    profile: Profile, length: float, flanges: tuple[str, ...], random: Random
) -> list[Feature]:
    """Holes, slots and a window of the web, holes of the flanges."""
    found: list[Feature] = []
    web, radius = profile.web_thickness or 0.0, profile.radius
    low = profile.flange_thickness + radius + 25.0
    high = profile.height - (25.0 if profile.code == "L" else low)
    places = [x for x in (180.0, 260.0, 340.0, 420.0) if x < length - 150.0]
    for x in places:
        y = round(random.uniform(low, high), 2) if high > low else low
        diameter = random.choice((18.0, 22.0, 26.0))
        face = random.choice(("v", "h"))
        if random.random() < 0.5:
            found.append(Hole(face, x, y, diameter, AT))
        elif random.random() < 0.5:
            found.append(Slot(face, x, y, 18.0, 20.0, 0.0, random.choice((0.0, 10.0)), AT))
        elif high - low > 60.0 and x == places[-1]:
            box = [(x, low), (x + 70.0, low), (x + 70.0, high), (x, high)]
            found.append(Contour("v", "inner", polygon(box), AT))
    for face in flanges:
        tip = (profile.width + web) / 2 + radius if profile.code == "I" else web + radius
        y = round((tip + profile.width) / 2, 2)
        if profile.width - tip > 50.0 and random.random() < 0.6:
            found.append(Hole(face, 220.0, y, 18.0, AT))
    return found
