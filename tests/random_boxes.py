"""Random rectangular tubes: holes, slots and windows, also over corners; skew ends and copes."""

from math import radians, tan
from random import Random

from beamcam.errors import Source
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, EndCuts, Face, Feature, Hole, Part, Profile, Slot
from tests.random_copes import polygon

AT = Source("box.nc1")
SECTIONS = (
    Profile("M", "RHS120*80*5", 120.0, 80.0, 5.0, 5.0, 10.0),
    Profile("M", "SHS100*6", 100.0, 100.0, 6.0, 6.0, 12.0),
    Profile("M", "RHS100*150*8", 100.0, 150.0, 8.0, 8.0, 14.0),
    Profile("M", "RHS200*100*10", 200.0, 100.0, 10.0, 10.0, 25.0),
)  # fmt: skip
#: Corners: the faces beside each, and whether it is at the greatest y of each.
CORNERS: tuple[tuple[Face, bool, Face, bool], ...] = (
    ("u", True, "v", False), ("v", True, "o", True), ("o", False, "h", True),
    ("h", False, "u", False),
)  # fmt: skip


def random_box(seed: int) -> Part:
    """A rectangular tube with up to four cut-outs."""
    random = Random(seed)
    profile = random.choice(SECTIONS)
    length = round(random.uniform(500.0, 900.0), 1)
    features: list[Feature] = []
    cuts = EndCuts()
    ends = random.randrange(4)
    if ends == 1:  # only in the header
        cuts = EndCuts(*(random.choice((0.0, round(random.uniform(-40.0, 40.0), 2)))
                         for _ in range(4)))  # fmt: skip
    elif ends == 2:
        features += mitred(
            profile, length, random.choice((-30.0, 20.0, 45.0)), random.random() < 0.5
        )
    elif ends == 3:
        features += coped(profile, length, random)
    for x in (200.0, 270.0, 340.0)[: random.randrange(4)]:
        features += _cut_out(profile, x, random)
    return Part(
        f"B{seed}", profile, length, AT, features=tuple(features), grade="S235JR", cuts=cuts
    )


def _cut_out(profile: Profile, x: float, random: Random) -> list[Feature]:
    face: Face = random.choice(("v", "o", "u", "h"))
    r = profile.radius
    low, high = r + 12.0, profile.face_width(face) - r - 12.0
    y = round(random.uniform(low, high), 2)
    match random.randrange(4):
        case 0:
            return [Hole(face, x, y, random.choice((14.0, 18.0, 22.0)), AT)]
        case 1:
            return [Slot(face, x, y, 16.0, 20.0, 0.0, 0.0, AT)]
        case 2:
            return [outline(face, [(x, low - 8.0), (x + 30.0, low - 8.0),
                                   (x + 30.0, low + 14.0), (x, low + 14.0)], "inner")]  # fmt: skip
        case _:
            return over_corner(profile, random.randrange(4), x, 34.0, random.choice((0.0, 3.0)))


def over_corner(
    profile: Profile, corner: int, x: float, along: float, lean: float
) -> list[Feature]:
    """A window over a corner: 15 mm of both flats, its sides leaning by so much on the first."""
    a, a_high, b, b_high = CORNERS[corner]
    deep = profile.radius + 15.0

    def drawn(face: Face, high: bool, lean: float) -> Contour:
        edge = profile.face_width(face) if high else 0.0
        far = edge - deep if high else deep
        return outline(face, [(x, edge), (x + along, edge), (x + along + lean, far),
                              (x - lean, far)], "inner")  # fmt: skip

    return [drawn(a, a_high, lean), drawn(b, b_high, 0.0)]


def outline(face: Face, points: list[Point], kind: str = "outer") -> Contour:
    """A contour of straight lines."""
    return Contour(face, kind, polygon(points), AT)  # type: ignore[arg-type]


def mitred(profile: Profile, length: float, angle: float, by_web: bool) -> list[Feature]:
    """The outlines of all faces with a skew far end, as its outside has it."""
    size = profile.height if by_web else profile.width
    slope = tan(radians(angle))
    ends = [length + min(0.0, slope * size) - slope * at for at in (0.0, size)]
    found: list[Feature] = []
    for face in ("v", "h", "o", "u"):
        wide = profile.face_width(face)
        xs = ends if (face in "vh") == by_web else [ends[1 if face in "vo" else 0]] * 2
        found.append(outline(face, [(0.0, 0.0), (xs[0], 0.0), (xs[1], wide), (0.0, wide)]))
    return found


def coped(profile: Profile, length: float, random: Random) -> list[Feature]:
    """Outlines that leave of the far end the lower half."""
    back = length - random.choice((40.0, 70.0))
    half = profile.height * 0.6
    side = [(0.0, 0.0), (length, 0.0), (length, half), (back, half), (back, profile.height),
            (0.0, profile.height)]  # fmt: skip
    b = profile.width
    return [
        outline("v", side), outline("h", side),
        outline("o", [(0.0, 0.0), (back, 0.0), (back, b), (0.0, b)]),
        outline("u", [(0.0, 0.0), (length, 0.0), (length, b), (0.0, b)]),
    ]  # fmt: skip
