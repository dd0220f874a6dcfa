"""Sections: where each face lies, how thick it is, what stands on it, and what it weighs.

DSTV, 7th edition, page 7: X along the part, Y up the web from the u end, Z across. v is looked at
from +Z, h from -Z, o from +Y, u from Y = 0. The web of U and C lies on the h side; of an L the v
leg lies along Y and the u leg stands along Z at Y = 0; the flange of a T lies along Y, its stem
along Z.
"""

from math import inf, pi

import pytest
import shapely
from msgspec.structs import replace

from beamcam.checks.bars.stations import lip_length
from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Line
from beamcam.model.part import FACES, MIRRORED_FACES, Contour, Hole, Part, Profile
from beamcam.model.rounds import as_seen, is_unrolled
from beamcam.model.section import (
    NO_PLATE,
    OTHER_SIDE,
    corners,
    free_edges,
    lip_of,
    measures_of,
    name_of,
    section_area,
    section_fault,
    walls_beside,
    weight_of,
)

SOURCE = Source("stranger.nc1", 1)
#: One of each kind, its flanges and its web never equally thick.
I300 = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
U200 = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
L150 = Profile("L", "L150X100", 150.0, 100.0, 12.0, 10.0, 13.0)
T120 = Profile("T", "T120X80", 120.0, 80.0, 9.0, 7.0, 8.0)
M120 = Profile("M", "RHS120X80", 120.0, 80.0, 6.0, 5.0, 10.0)
C175 = Profile("C", "C175X60", 175.0, 60.0, 2.0, 1.5, 3.0)
B10 = Profile("B", "PL10X200", 200.0, 0.0, 0.0, 10.0)
RO114 = Profile("RO", "CHS114.3X5", 114.3, 114.3, 0.0, 5.0)
EVERY = (I300, U200, L150, T120, M120, C175, B10, RO114)

#: Code: depth of v, o, u, h below the outermost steel on its side.
#: I (150 - 7.1) / 2; U 75 - 8.5; L 100 - 10; T 80 - 7, (120 - 9) / 2;
#: C 60 - 1.5; the rest lie outermost.
DEPTHS = {
    "I": (71.45, 0, 0, 71.45), "U": (66.5, 0, 0, 0), "L": (90, 0, 0, 0),
    "T": (73, 55.5, 55.5, 0),
    "M": (0, 0, 0, 0), "C": (58.5, 0, 0, 0), "B": (0, 0, 0, 0), "RO": (0, 0, 0, 0),
}  # fmt: skip
#: Code: thickness behind v, o, u, h.
THICKNESSES = {
    "I": (7.1, 10.7, 10.7, 7.1), "U": (8.5, 11.5, 11.5, 8.5), "L": (10, 12, 12, 10),
    "T": (7, 9, 9, 7), "M": (5, 6, 6, 5), "C": (1.5, 2, 2, 1.5), "B": (10, 10, 10, 10),
    "RO": (5, 0, 0, 5),
}  # fmt: skip
#: Code: extent of v, o, u, h across the part.
WIDTHS = {
    "I": (300, 150, 150, 300), "U": (200, 75, 75, 200), "L": (150, 100, 100, 150),
    "T": (120, 80, 80, 120), "M": (120, 80, 80, 120), "C": (175, 60, 60, 175),
}  # fmt: skip


@pytest.mark.parametrize("profile", EVERY, ids=lambda p: p.code)
def test_depth_thickness_and_width_of_each_face(profile: Profile) -> None:
    order = ("v", "o", "u", "h")
    assert tuple(map(profile.face_depth, order)) == pytest.approx(DEPTHS[profile.code])
    assert tuple(map(profile.thickness, order)) == pytest.approx(THICKNESSES[profile.code])
    if profile.code in WIDTHS:
        assert tuple(map(profile.face_width, order)) == WIDTHS[profile.code]


#: The steel as boxes of (z, y): from least to greatest.
DRAWN = {
    "I": [(71.45, 0, 78.55, 300), (0, 0, 150, 10.7), (0, 289.3, 150, 300)],
    "U": [(0, 0, 8.5, 200), (0, 0, 75, 11.5), (0, 188.5, 75, 200)],
    "L": [(0, 0, 10, 150), (0, 0, 100, 12)],
    "T": [(0, 0, 7, 120), (0, 55.5, 80, 64.5)],
    "M": [(0, 0, 5, 120), (75, 0, 80, 120), (0, 0, 80, 6), (0, 114, 80, 120)],
    "C": [(0, 0, 1.5, 175), (0, 0, 60, 2), (0, 173, 60, 175)],
}
#: Where a drill comes down on v and h (its y), and on o and u (its z), clear of other walls.
DRILLED = {
    "I": (100, 30), "U": (100, 40), "L": (100, 60), "T": (30, 40), "M": (60, 40), "C": (90, 30),
}  # fmt: skip


@pytest.mark.parametrize("profile", EVERY[:6], ids=lambda p: p.code)
def test_a_drill_meets_the_drawn_section_there(profile: Profile) -> None:
    """shapely says where a straight line first comes to steel, and how far it runs in it."""
    steel = shapely.union_all([shapely.box(*box) for box in DRAWN[profile.code]])
    least_z, least_y, greatest_z, greatest_y = steel.bounds
    y, z = DRILLED[profile.code]
    far = 1000.0
    ways = {
        "v": ((far, y), (-1, 0), greatest_z), "h": ((-far, y), (1, 0), least_z),
        "o": ((z, far), (0, -1), greatest_y), "u": ((z, -far), (0, 1), least_y),
    }  # fmt: skip
    for face, (start, way, outermost) in ways.items():
        if face in NO_PLATE.get(profile.code, ()):
            continue
        line = shapely.LineString(
            [start, (start[0] + 2 * far * way[0], start[1] + 2 * far * way[1])]
        )
        met = steel.intersection(line)
        runs = sorted(
            (shapely.Point(start).distance(shapely.Point(run.coords[0])), run.length)
            for run in getattr(met, "geoms", [met])
        )
        first = min(
            shapely.Point(start).distance(shapely.Point(c)) for c in shapely.get_coordinates(met)
        )
        to_outermost = abs(outermost - (start[0] if way[0] else start[1]))
        assert profile.face_depth(face) == pytest.approx(first - to_outermost), face
        assert profile.thickness(face) == pytest.approx(runs[0][1]), face


def test_faces_and_hands() -> None:
    """Page 8: v and u are right-handed seen from outside; o and h are seen mirrored."""
    assert set(FACES) == {"v", "o", "u", "h"}
    assert set(MIRRORED_FACES) == {"o", "h"}
    # Right-handed is: along x, then along the face's y, then out of the part, as X, Y and Z are.
    x = (1, 0, 0)
    along_y = {"v": (0, 1, 0), "h": (0, 1, 0), "o": (0, 0, 1), "u": (0, 0, 1)}
    outward = {"v": (0, 0, 1), "h": (0, 0, -1), "o": (0, 1, 0), "u": (0, -1, 0)}
    for face in FACES:
        (a, b, c), (d, e, f), (g, h, i) = x, along_y[face], outward[face]
        hand = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
        assert (hand < 0) == (face in MIRRORED_FACES), face


def test_the_other_side_of_a_plate() -> None:
    """A drill that comes down on v leaves by h; of an L's u leg the inside is seen from o."""
    for code in ("I", "U", "C", "B"):
        assert OTHER_SIDE[code] == {"v": "h", "h": "v"}
    for code in ("L", "T"):  # of a T's stem both sides are seen
        assert OTHER_SIDE[code] == {"v": "h", "h": "v", "o": "u", "u": "o"}
    assert "M" not in OTHER_SIDE  # behind its face lies the hollow
    assert NO_PLATE == {"L": ("o",)}


#: Walls that stand on a face: from, to, radius of their root. 289.3 = 300 - 10.7, 188.5 = 200 -
#: 11.5, 55.5 = (120 - 9) / 2; on a C's flange stands its lip; a tube's 10 is its outer radius,
#: 10 - 6 and 10 - 5 the inner ones.
WALLS = {
    ("I", "v"): [(0, 10.7, 15), (289.3, 300, 15)], ("I", "o"): [(71.45, 78.55, 15)],
    ("I", "u"): [(71.45, 78.55, 15)],
    ("U", "v"): [(0, 11.5, 11.5), (188.5, 200, 11.5)], ("U", "u"): [(0, 8.5, 11.5)],
    ("L", "v"): [(0, 12, 13)], ("L", "u"): [(0, 10, 13)], ("T", "v"): [(55.5, 64.5, 8)],
    ("M", "v"): [(0, 6, 4), (114, 120, 4)], ("M", "o"): [(0, 5, 5), (75, 80, 5)],
    ("C", "v"): [(0, 2, 3), (173, 175, 3)], ("C", "o"): [(0, 1.5, 3), (58.5, 60, 3)],
    ("T", "o"): [(0, 7, 8)], ("T", "u"): [(0, 7, 8)],
}  # fmt: skip


@pytest.mark.parametrize(("code", "face"), WALLS)
def test_walls_and_their_root_radius(code: str, face: str) -> None:
    (profile,) = (p for p in EVERY if p.code == code)
    found = [(w.least, w.greatest, w.radius) for w in walls_beside(profile, face)]
    assert found == [pytest.approx(wall) for wall in WALLS[code, face]]


def test_the_room_beside_a_root_fillet() -> None:
    """IPE300: flange to 10.7, fillet to 25.7. A hole of 22 at y 40 begins at 29, so 3.3 is left."""
    below, above = walls_beside(I300, "v")
    assert below.apart(29.0, 51.0) == pytest.approx(3.3)
    assert below.apart(20.0, 42.0) == pytest.approx(-5.7)
    assert above.apart(249.0, 271.0) == pytest.approx(289.3 - 15 - 271)
    # 9 into a fillet of 15: 15 - sqrt(225 - 81) = 3; at its end the whole radius.
    assert below.fillet_height(9.0) == pytest.approx(3.0)
    assert (below.fillet_height(0.0), below.fillet_height(15.0)) == (0.0, 15.0)


def test_how_long_the_lips_of_a_c_are() -> None:
    """By the length of its sheet, in the middle of it, and the weight of that.

    C175 of 1.5: web 175 - 9, flanges 2 (60 - 9), lips 2 (20 - 4.5), four bends of pi / 2 x 3.75.
    """
    sheet = 166.0 + 102.0 + 31.0 + 4 * 5.8904862
    for weight, lip in (
        (sheet * 1.5 * 7.85e-3, 20.0),
        ((sheet + 2 * 12.5) * 1.5 * 7.85e-3, 32.5),
        ((sheet - 2 * 8.1) * 1.5 * 7.85e-3, 36.0),  # 11.9 is no lip: the longest, 0.6 x 60
        (0.0, 36.0), (100.0, 36.0),
    ):  # fmt: skip
        part = Part("C", C175, 1000.0, SOURCE, weight=weight)
        assert lip_of(part) == pytest.approx(lip, abs=1e-5)
        assert lip_length(part) == pytest.approx(lip, abs=1e-5)
    for profile in (U200, I300, M120):
        part = Part("U", profile, 1000.0, SOURCE, weight=20.0)
        assert lip_of(part) == lip_length(part) == 0.0


def test_edges_corners_and_impossible_sections() -> None:
    assert free_edges(I300, "v") == (False, False)
    assert free_edges(I300, "o") == (True, True)
    assert free_edges(U200, "o") == (False, True)
    assert free_edges(L150, "v") == (False, True)
    assert set(corners(L150)) == {(0, 0), (150, 0), (0, 100), (150, 10), (12, 100)}
    assert set(corners(T120)) == {(0, 0), (120, 0), (0, 7), (120, 7), (55.5, 80), (64.5, 80)}
    assert set(corners(U200)) == {(0, 0), (200, 0), (0, 75), (200, 75)}
    # The round corner of 10 of a tube of 120 x 80 comes as far as 110 + 70 + 10 sqrt 2, and that of
    # a channel of 175 x 60, 3 inside and 1.5 thick, as 170.5 + 55.5 + 4.5 sqrt 2.
    assert max(y + z for y, z in corners(M120)) == pytest.approx(194.1421, abs=0.001)
    assert max(y + z for y, z in corners(C175)) == pytest.approx(232.3640, abs=0.001)
    assert all(section_fault(profile) is None for profile in EVERY)
    # Two flanges of 60 fill 120; one does not, of an angle.
    assert section_fault(Profile("I", "", 120, 80, 60, 5)) is not None
    assert section_fault(Profile("L", "", 120, 80, 60, 5)) is None
    assert section_fault(Profile("M", "", 120, 80, 5, 40)) is not None
    assert section_fault(Profile("U", "", 120, 80, 5, 40)) is None
    assert section_fault(Profile("U", "", 120, 80, 5, inf)) is not None


#: Name: cm2 and kg/m that EN 10365, EN 10056-1, EN 10210-2 and EN 10219-2 print.
PRINTED = {
    "IPE300": (53.8, 42.2), "HEB200": (78.1, 61.3), "HEA200": (53.8, 42.3), "IPE160": (20.1, 15.8),
    "UPE200": (29.0, 22.8), "L100X10": (19.2, 15.0), "L100X50X8": (11.4, 8.97),
}  # fmt: skip


@pytest.mark.parametrize("name", PRINTED)
def test_sections_of_the_standards(name: str) -> None:
    found = measures_of(name)
    assert found is not None
    code, sizes = found
    profile = Profile(code, name, *sizes)
    area, kg_m = PRINTED[name]
    assert section_area(profile) == pytest.approx(100 * area, rel=0.006)
    bar = Part("P", profile, 1000.0, SOURCE)
    assert weight_of(bar) == pytest.approx(kg_m, rel=0.006)


def test_measures_by_name() -> None:
    """EN 10365: IPE 300 is 300 x 150, flange 10.7, web 7.1, r 15; UPN 200 200 x 75, 11.5, 8.5."""
    assert measures_of("IPE 300") == ("I", (300, 150, 10.7, 7.1, 15))
    assert measures_of("HE 200 B") == ("I", (200, 200, 15, 9, 18))
    assert measures_of("UPN200") is not None
    assert measures_of("UPN200")[1][:4] == (200, 75, 11.5, 8.5)  # type: ignore[index]
    assert name_of(I300) == "IPE300"


def test_weights_worked_out_by_hand() -> None:
    # I: 2 x 150 x 10.7 + 278.6 x 7.1 + (4 - pi) x 15^2 = 3210 + 1978.06 + 193.14 = 5381.2 mm2
    assert section_area(I300) == pytest.approx(5381.20, abs=0.01)
    # 5381.2 mm2 x 4200 mm = 22.601 dm3, at 7.85 kg/dm3 177.42 kg
    assert weight_of(Part("P", I300, 4200.0, SOURCE)) == pytest.approx(177.418, abs=0.01)
    # U: 2 x 75 x 11.5 + 177 x 8.5 + (2 - pi / 2) x 11.5^2 = 1725 + 1504.5 + 56.76
    assert section_area(U200) == pytest.approx(3286.26, abs=0.01)
    # L: 150 x 10 + 90 x 12 + (1 - pi / 4) x 13^2 / 2 (the toes have half the root's radius)
    assert section_area(L150) == pytest.approx(2598.13, abs=0.01)
    # T: 120 x 7 + 73 x 9 + (2 - pi / 2) x 8^2
    assert section_area(T120) == pytest.approx(1524.47, abs=0.01)
    # M: 120 x 80 - 108 x 70 - (4 - pi) (10^2 - 4^2)
    assert section_area(M120) == pytest.approx(1967.89, abs=0.01)
    # RO: pi x (114.3 - 5) x 5; RU: pi x 10^2
    assert section_area(RO114) == pytest.approx(1716.88, abs=0.01)
    assert section_area(Profile("RU", "", 20, 20, 0, 0)) == pytest.approx(314.159, abs=0.001)
    # A plate of 300 x 200 x 10 is 0.6 dm3 and weighs 4.71 kg.
    assert weight_of(Part("P", B10, 300.0, SOURCE)) == pytest.approx(4.71)


def test_a_plate_weighs_what_its_cut_outs_leave() -> None:
    """400 x 200 x 10 less a round cut-out of 100: 80000 - 7853.98 = 72146.02 mm2, 5.6635 kg."""
    corners_of = [(0.0, 0.0), (400.0, 0.0), (400.0, 200.0), (0.0, 200.0)]
    outline = tuple(map(Line, corners_of, [*corners_of[1:], corners_of[0]]))
    hole = (Arc((200.0, 100.0), 50.0, 0.0, -360.0),)
    part = Part("P", B10, 400.0, SOURCE, features=(
        Contour("v", "outer", outline, SOURCE), Contour("v", "inner", hole, SOURCE),
    ))  # fmt: skip
    assert weight_of(part) == pytest.approx(5.66346, abs=1e-4)


def test_a_c_is_one_bent_sheet() -> None:
    """Flats of 188, 2 x 63 and 2 x 14 mm, four bends, their middle line at 4.75 mm."""
    profile = Profile("C", "", 200.0, 75.0, 2.5, 2.5, 3.5, 20.0)
    sheet = 188.0 + 2 * 63.0 + 2 * 14.0 + 4 * pi / 2 * 4.75
    assert section_area(profile) == pytest.approx(2.5 * sheet, abs=0.01)
    assert section_area(replace(profile, lip=None)) is None
    part = Part("C", profile, 1000.0, SOURCE, weight=1.0)  # which the section's own lips go before
    assert lip_of(part) == lip_length(part) == 20.0


@pytest.mark.parametrize("lip", [0.0, 5.9, 100.0])
def test_lips_that_no_c_has(lip: float) -> None:
    profile = Profile("C", "", 200.0, 75.0, 2.5, 2.5, 3.5, 20.0)
    assert section_fault(profile) is None
    assert "lips" in (section_fault(replace(profile, lip=lip)) or "")


@pytest.mark.parametrize(
    ("name", "width", "thick", "is_pipe"),
    [
        ("CHS88.9*5", 279.29, 5.0, True), ("PIPE4STD", 359.08, 6.02, True),
        ("O76.1*4", 239.08, 4.0, True), ("RO114.3", 359.08, 5.0, True),
        ("HSS5.563X0.258", 443.91, 6.1, True), ("HSS3-1/2X.250", 279.29, 5.92, True),
        ("PL10*31.4", 31.42, 10.0, False), ("FL12", 37.7, 12.0, False),
        ("PL20", 62.83, 20.0, False), ("FB60*8", 60.0, 8.0, False), ("PLATE", 359.08, 6.0, False),
        ("D101.6*5", 101.6, 5.0, False),
    ],
)  # fmt: skip
def test_a_plate_that_is_an_unrolled_pipe(
    name: str, width: float, thick: float, is_pipe: bool
) -> None:
    """By the circumference: 88.9 pi = 279.29, 114.3 pi = 359.08, 141.3 pi = 443.91 mm."""
    assert is_unrolled(Profile("B", name, width, 0.0, 0.0, thick)) is is_pipe
    assert not is_unrolled(Profile("M", name, width, width, thick, thick))


def test_what_is_on_a_round_is_seen_from_four_faces() -> None:
    """Page 14: y of v is the arc from the lowest line towards v; a quarter of it is 89.77 mm."""
    arcs = {"u": 0.0, "v": 89.77, "o": 179.54, "h": 269.31}
    holes = tuple(Hole("v", 100.0, y, 18.0, SOURCE) for y in arcs.values())
    seen = as_seen(Part("M", RO114, 1000.0, SOURCE, features=holes)).holes
    assert [(hole.face, hole.y) for hole in seen] == [(face, 57.15) for face in arcs]
