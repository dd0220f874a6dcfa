"""Solids of parts against volumes, centroids and boxes worked by hand."""

import sys
from math import pi, radians, tan
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from beamcam.errors import BeamcamError, Source
from beamcam.geometry.curves import Arc, Line
from beamcam.model.part import (
    Bevel,
    Contour,
    EndCuts,
    EndPlane,
    Feature,
    Hole,
    Part,
    Profile,
    SectionPoint,
    Slot,
)
from beamcam.model.section import corners, section_area
from beamcam.solid.kernel import corners as corners_of_steel
from beamcam.solid.part_solid import part_solid
from beamcam.solid.stock_solid import Margins, stock_solid

SRC = Source("hand.nc1", 1)
IPE = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
UPE = Profile("U", "UPE200", 200.0, 80.0, 11.0, 6.0, 13.0)
ANGLE = Profile("L", "L100X60X8", 100.0, 60.0, 8.0, 8.0, 0.0)
TEE = Profile("T", "T80", 80.0, 60.0, 9.0, 7.0, 0.0)
LIPPED = Profile("C", "C200", 200.0, 65.0, 2.0, 2.0, 0.0)
TUBE = Profile("M", "RHS120X80X5", 120.0, 80.0, 5.0, 5.0, 10.0)
PIPE = Profile("RO", "CHS100X5", 100.0, 100.0, 5.0, 5.0)
ROUND = Profile("RU", "D60", 60.0, 60.0, 0.0, 0.0)
PLATE = Profile("B", "PL12", 200.0, 0.0, 0.0, 12.0)
FACETS = 2e-3  #: of a circle's area, for its chords


def part(profile: Profile, *features: Feature, length: float = 1000.0, **more: Any) -> Part:
    return Part("P", profile, length, SRC, features=features, **more)


def hole(face: str, x: float, y: float, d: float, **more: Any) -> Hole:
    return Hole(face, x, y, d, SRC, **more)


def taken(whole: Profile, *features: Feature, **more: Any) -> float:
    return stock_solid(part(whole)).volume() - part_solid(part(whole, *features, **more)).volume()


def centre_taken(whole: Profile, feature: Feature) -> tuple[float, float, float]:
    """Centre of what a feature takes."""
    return centroid(stock_solid(part(whole)) - part_solid(part(whole, feature)))


def centroid(body: Any) -> tuple[float, float, float]:
    mesh = body.to_mesh64()
    a, b, c = (mesh.vert_properties[mesh.tri_verts[:, k], :3] for k in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    x, y, z = (volumes[:, None] * (a + b + c) / 4).sum(axis=0) / volumes.sum()
    return float(x), float(y), float(z)


def box(body: Any) -> tuple[float, ...]:
    return tuple(round(value, 6) + 0.0 for value in body.bounding_box())


@pytest.mark.parametrize(
    ("profile", "area", "middle"),
    [
        # Two flanges 150 x 10.7, web 278.6 x 7.1, four spandrels of radius 15.
        (IPE, 2 * 1605.0 + 1978.06 + 4 * (1 - pi / 4) * 225.0, (150.0, 75.0)),
        # Legs 100 x 8 and 52 x 8: y = (800 x 50 + 416 x 4) / 1216, z = (800 x 4 + 416 x 34) / 1216.
        (ANGLE, 1216.0, (34.2632, 14.2632)),
        # Flange 80 x 7 at z 3.5, stem 53 x 9 at z 33.5.
        (TEE, 560.0 + 477.0, (40.0, (560 * 3.5 + 477 * 33.5) / 1037)),
        # Web 200 x 2 at z 1, two flanges 63 x 2 at z 33.5.
        (LIPPED, 652.0, (100.0, (400 * 1 + 252 * 33.5) / 652)),
        (TUBE, 9600.0 - 7700.0 - 4 * (1 - pi / 4) * (100.0 - 25.0), (60.0, 40.0)),
        (PIPE, pi * (50.0**2 - 45.0**2), (50.0, 50.0)),
        (ROUND, pi * 900.0, (30.0, 30.0)),
        (PLATE, 2400.0, (100.0, 6.0)),
    ],
    ids=lambda value: value.code if isinstance(value, Profile) else "",
)
def test_a_bar_is_its_section_over_its_length(
    profile: Profile, area: float, middle: tuple[float, float]
) -> None:
    body = part_solid(part(profile))
    assert body.volume() == pytest.approx(area * 1000, rel=FACETS)
    assert centroid(body) == pytest.approx((500.0, *middle), abs=0.01)
    width = {"B": 12.0}.get(profile.code, profile.width)
    assert box(body) == (0.0, 0.0, 0.0, 1000.0, profile.height, width)


@pytest.mark.parametrize(
    "profile",
    [IPE, UPE, ANGLE, TEE, replace(LIPPED, radius=3.0), TUBE, PIPE, ROUND, PLATE],
    ids=lambda p: p.code,
)
def test_skew_ends_touch_the_steel_that_the_model_says(profile: Profile) -> None:
    for y, z in ((1.0, 0.3), (-0.2, 1.0), (-1.0, -0.7), (0.5, -1.0)):
        solid = max(y * a + z * b for a, b in corners_of_steel(part(profile)))
        model = max(y * a + z * b for a, b in corners(profile))
        assert solid == pytest.approx(model, abs=0.02)


@pytest.mark.parametrize("profile", [IPE, UPE, TUBE, PIPE, TEE], ids=lambda p: p.code)
def test_areas_are_those_of_part_lists(profile: Profile) -> None:
    area = section_area(profile)
    assert area is not None
    assert part_solid(part(profile)).volume() == pytest.approx(area * 1000, rel=FACETS)


def test_the_web_of_a_channel_is_on_the_h_side_and_its_flanges_towards_v() -> None:
    # Web 178 x 6 at z 3, two flanges 80 x 11 at z 40, two spandrels at the web.
    body = part_solid(part(replace(UPE, radius=0.0)))
    z = (178 * 6 * 3 + 2 * 880 * 40) / (178 * 6 + 2 * 880)
    assert centroid(body) == pytest.approx((500.0, 100.0, z), abs=1e-6)


@pytest.mark.parametrize(
    ("profile", "face", "y", "wall", "middle"),
    [
        (IPE, "v", 100.0, 7.1, (400.0, 100.0, 75.0)),
        (IPE, "h", 100.0, 7.1, (400.0, 100.0, 75.0)),
        (IPE, "o", 30.0, 10.7, (400.0, 294.65, 30.0)),
        (IPE, "u", 30.0, 10.7, (400.0, 5.35, 30.0)),
        (UPE, "v", 60.0, 6.0, (400.0, 60.0, 3.0)),
        (UPE, "o", 50.0, 11.0, (400.0, 194.5, 50.0)),
        (ANGLE, "v", 70.0, 8.0, (400.0, 70.0, 4.0)),
        (ANGLE, "u", 40.0, 8.0, (400.0, 4.0, 40.0)),
        (TEE, "v", 15.0, 7.0, (400.0, 15.0, 3.5)),
        (TEE, "o", 40.0, 9.0, (400.0, 40.0, 40.0)),
        (LIPPED, "u", 40.0, 2.0, (400.0, 1.0, 40.0)),
        (TUBE, "v", 60.0, 5.0, (400.0, 60.0, 77.5)),
        (TUBE, "h", 60.0, 5.0, (400.0, 60.0, 2.5)),
        (TUBE, "o", 40.0, 5.0, (400.0, 117.5, 40.0)),
        (PLATE, "v", 60.0, 12.0, (400.0, 60.0, 6.0)),
    ],
    ids=lambda value: value.code if isinstance(value, Profile) else str(value),
)
def test_a_hole_goes_through_the_wall_of_its_face(
    profile: Profile, face: str, y: float, wall: float, middle: tuple[float, float, float]
) -> None:
    one = hole(face, 400.0, y, 14.0)
    assert taken(profile, one) == pytest.approx(pi * 49 * wall, rel=FACETS)
    assert centre_taken(profile, one) == pytest.approx(middle, abs=1e-4)


@pytest.mark.parametrize(
    ("profile", "face", "y", "middle"),
    [
        # 4 deep from the face: of the web from v and from h, of a flange from outside.
        (IPE, "v", 100.0, (400.0, 100.0, 78.55 - 2)),
        (IPE, "h", 100.0, (400.0, 100.0, 71.45 + 2)),
        (IPE, "o", 30.0, (400.0, 298.0, 30.0)),
        (IPE, "u", 30.0, (400.0, 2.0, 30.0)),
        (UPE, "v", 60.0, (400.0, 60.0, 4.0)),
        (ANGLE, "v", 70.0, (400.0, 70.0, 6.0)),
        (PLATE, "v", 60.0, (400.0, 60.0, 10.0)),
        (PLATE, "h", 60.0, (400.0, 60.0, 2.0)),
    ],
    ids=lambda value: value.code if isinstance(value, Profile) else str(value),
)
def test_a_blind_hole_is_as_deep_as_it_says_from_its_face(
    profile: Profile, face: str, y: float, middle: tuple[float, float, float]
) -> None:
    one = hole(face, 400.0, y, 14.0, depth=4.0, kind="blind")
    assert taken(profile, one) == pytest.approx(pi * 49 * 4, rel=FACETS)
    assert centre_taken(profile, one) == pytest.approx(middle, abs=1e-4)


def test_a_hole_takes_the_root_fillets_in_its_way() -> None:
    # Beside the web the spandrels before and behind it, but not the flange.
    near = taken(IPE, hole("v", 400.0, 10.7 + 8.0, 14.0))
    away = taken(IPE, hole("v", 400.0, 100.0, 14.0))
    assert away + 500 < near < away + 2 * pi * 49 * 15


def test_a_hole_of_a_tube_goes_through_one_wall() -> None:
    both = taken(TUBE, hole("v", 400.0, 60.0, 14.0), hole("h", 400.0, 60.0, 14.0))
    assert both == pytest.approx(2 * pi * 49 * 5, rel=FACETS)


def test_countersinks() -> None:
    through = hole("v", 400.0, 60.0, 10.0)
    pilot = pi * 25 * 12
    cone = hole("v", 400.0, 60.0, 20.0, kind="countersink", angle=90.0)
    # A cone 10 deep and 20 wide, less the pilot's 5 deep cylinder and cone below.
    ring = pi * 100 * 10 / 3 - (pi * 25 * 5 + pi * 25 * 5 / 3)
    assert taken(PLATE, through, cone) == pytest.approx(pilot + ring, rel=FACETS)
    flat = hole("v", 400.0, 60.0, 20.0, kind="countersink", depth=3.0)
    assert taken(PLATE, through, flat) == pytest.approx(pilot + pi * 75 * 3, rel=FACETS)
    deep = replace(cone, depth=7.0)  # alone it would be 5 deep: a cylinder of 2 above it
    assert taken(PLATE, through, deep) == pytest.approx(pilot + ring + pi * 75 * 2, rel=FACETS)


def test_a_thread_is_its_core() -> None:
    one = hole("v", 400.0, 60.0, 16.0, kind="thread")
    core = 16 - 1.0825 * 2.0
    assert taken(PLATE, one) == pytest.approx(pi * core**2 / 4 * 12, rel=FACETS)


def test_slots_and_pockets() -> None:
    slot = Slot("v", 400.0, 60.0, 14.0, 30.0, 0.0, 90.0, SRC)
    assert taken(PLATE, slot) == pytest.approx((pi * 49 + 30 * 14) * 12, rel=FACETS)
    body = stock_solid(part(PLATE)) - part_solid(part(PLATE, slot))
    assert box(body) == (393.0, 38.0, 0.0, 407.0, 82.0, 12.0)
    pocket = Slot("v", 400.0, 60.0, 10.0, 30.0, 20.0, 0.0, SRC, depth=5.0)
    area = 40 * 30 - (4 - pi) * 25
    assert taken(PLATE, pocket) == pytest.approx(area * 5, rel=FACETS)


def test_a_mark_takes_nothing() -> None:
    assert taken(IPE, hole("v", 400.0, 100.0, 0.0, kind="mark")) == 0.0
    line = Contour("v", "open", (Line((100.0, 100.0), (200.0, 100.0)),), SRC, "mark", False)
    assert taken(IPE, line) == 0.0


@pytest.mark.parametrize(
    ("cuts", "off"),
    [
        # A wedge of half the height's square times the tangent, through all of the bar: the top
        # edge is the longest at a start of + degrees, the bottom edge at an end of + degrees.
        (EndCuts(web_start=30.0), (0.0, 1.0)),
        (EndCuts(web_start=-30.0), (0.0, -1.0)),
        (EndCuts(web_end=30.0), (1000.0, 1.0)),
        (EndCuts(web_end=-30.0), (1000.0, -1.0)),
    ],
)
def test_mitres_of_a_plain_bar(cuts: EndCuts, off: tuple[float, float]) -> None:
    body = part_solid(part(PLATE, cuts=cuts))
    wedge = 200.0**2 * tan(radians(30)) / 2 * 12
    assert body.volume() == pytest.approx(200 * 1000 * 12 - wedge)
    assert box(body) == (0.0, 0.0, 0.0, 1000.0, 200.0, 12.0)
    end, up = off
    # The wedge's centre: a third of its height off the edge that is cut short.
    short_is_top = (up < 0) if end == 0.0 else (up > 0)
    y = 200 * 2 / 3 if short_is_top else 200 / 3
    x = abs(end - 200 * tan(radians(30)) / 3)
    gone = stock_solid(part(PLATE)) - body
    assert centroid(gone) == pytest.approx((x, y, 6.0))


def test_a_flange_angle_leans_across() -> None:
    # In the view of u: + at the start where the far edge, at z 150, is the longest.
    body = part_solid(part(replace(IPE, radius=0.0), cuts=EndCuts(flange_start=20.0)))
    gone = stock_solid(part(replace(IPE, radius=0.0))) - body
    lean = tan(radians(20))
    flanges = 2 * 10.7 * 150**2 / 2 * lean
    # The web stands at z 75: of each of its fibres as much is gone as the plane leaves there.
    web = 278.6 * 7.1 * 75 * lean
    assert gone.volume() == pytest.approx(flanges + web, rel=1e-6)
    assert box(gone)[3] == pytest.approx(150 * lean)
    x, _, z = centroid(gone)
    assert z < 75.0
    assert x < 75 * lean


def test_an_end_plane_of_its_own() -> None:
    # Normal (1, 0, 1) through x 990, z 0: of the plate's end 10 at the bottom, 22 at the top.
    plane = EndPlane((990.0, 0.0, 0.0), (1.0, 0.0, 1.0), SRC)
    assert taken(PLATE, plane) == pytest.approx(200 * 12 * 16)


def test_a_cope_of_a_beam_is_of_the_walls_that_it_is_drawn_on() -> None:
    web = Contour("v", "outer", _closed(
        (0, 0), (1000, 0), (1000, 300), (100, 300), (100, 250), (0, 250)), SRC)  # fmt: skip
    plain = replace(IPE, radius=0.0)
    web_only = taken(plain, web)
    assert web_only == pytest.approx(100 * 50 * 7.1)
    top = Contour("o", "outer", _closed((100, 0), (1000, 0), (1000, 150), (100, 150)), SRC)
    assert taken(plain, web, top) == pytest.approx(web_only + 100 * 10.7 * (150 - 7.1))


def test_an_outline_of_one_flange_is_no_end_of_the_other() -> None:
    skew = Contour("u", "outer", _closed((0, 0), (1000, 0), (940, 80), (0, 80)), SRC)
    body = part_solid(part(UPE, skew))
    # A triangle 60 x 80 of the lower flange, its root fillet with it; the upper flange stays.
    sharp = taken(replace(UPE, radius=0.0), skew)
    assert sharp == pytest.approx(60.0 * 80.0 / 2 * 11.0, rel=1e-6)
    assert sharp < taken(UPE, skew) < sharp + 60.0 * UPE.radius**2 * (1.0 - pi / 4)
    assert box(body)[3] == 1000.0
    both = skew, replace(skew, face="o")
    assert taken(UPE, *both) > 2 * 60.0 * 80.0 / 2 * 11.0


def test_a_cut_as_narrow_as_a_saw_goes_through_a_flange() -> None:
    """What two outlines leave between them is no rounding of an exporter."""
    halves = (
        Contour("o", "outer", _closed((0, 0), (500, 0), (500, 150), (0, 150)), SRC),
        Contour("o", "outer", _closed((501, 0), (1000, 0), (1000, 150), (501, 150)), SRC),
    )
    assert taken(IPE, *halves) == pytest.approx(150.0 * 10.7, rel=1e-6)


def test_margins_part_the_least_steel_from_the_most() -> None:
    """A skin off all surfaces, and ends with planes of their own as others."""
    skew = EndPlane((950.0, 0.0, 0.0), (1.0, 0.2, 0.1), SRC)
    least, drawn, most = (
        part_solid(part(TUBE, skew), Margins(skin=off, end=off)) for off in (0.1, 0.0, -0.1)
    )
    for less, more in ((least, drawn), (drawn, most)):
        assert (less - more).volume() == pytest.approx(0.0, abs=1e-6)
    skins = drawn.surface_area() * 0.1
    assert (drawn - least).volume() == pytest.approx(skins, rel=0.05)
    assert (most - drawn).volume() == pytest.approx(skins, rel=0.05)


def test_a_plate_is_what_its_outlines_enclose() -> None:
    outer = Contour("v", "outer", _closed((0, 0), (300, 0), (300, 100), (0, 200)), SRC)
    circle = (Arc((100.0, 80.0), 20.0, 0.0, 360.0),)
    inner = Contour("v", "inner", circle, SRC)
    body = part_solid(part(PLATE, outer, inner, length=300.0))
    assert body.volume() == pytest.approx((45000 - pi * 400) * 12, rel=FACETS)
    assert box(body) == (0.0, 0.0, 0.0, 300.0, 200.0, 12.0)


def test_a_bevel_takes_a_wedge_from_its_surface_to_its_land() -> None:
    chain = _closed((0, 0), (300, 0), (300, 200), (0, 200))
    # Where it ends counts from the far side; 12 mm thick, 8 of them are taken.
    for angle, end, z in ((45.0, 4.0, 12 - 8 / 3), (-45.0, 8.0, 8 / 3)):
        outer = Contour("v", "outer", chain, SRC, bevels=(Bevel(1, angle, end),))
        square = Contour("v", "outer", chain, SRC)
        gone = part_solid(part(PLATE, square, length=300.0)) - part_solid(
            part(PLATE, outer, length=300.0)
        )
        assert gone.volume() == pytest.approx(200 * 8 * 8 / 2)
        assert centroid(gone) == pytest.approx((300 - 8 / 3, 100.0, z))


def test_a_hole_of_a_pipe_is_radial() -> None:
    quarter = pi * 100 / 4
    for turns, (y, z) in enumerate([(0.0, 50.0), (50.0, 100.0), (100.0, 50.0), (50.0, 0.0)]):
        one = hole("v", 400.0, turns * quarter, 10.0)
        x, cy, cz = centre_taken(PIPE, one)
        assert x == pytest.approx(400.0)
        assert (cy - 50, cz - 50) == pytest.approx(((y - 50) * 0.95, (z - 50) * 0.95), abs=0.3)
        assert taken(PIPE, one) == pytest.approx(pi * 25 * 5, rel=0.02)


def test_a_special_section_is_its_outline() -> None:
    places = ((0, 0), (0, 60), (20, 60), (20, 20), (60, 20), (60, 0))
    section = tuple(SectionPoint("+", float(y), float(z)) for y, z in places)
    body = part_solid(part(Profile("SO", "X", 60.0, 60.0, 0.0, 0.0), section=section))
    assert body.volume() == pytest.approx(2000 * 1000)


def test_a_mirrored_part_is_another_solid() -> None:
    """No turn lays it on the drawn one: 24 ways to lay a box into itself are tried."""
    one = part_solid(part(ANGLE, hole("v", 60.0, 60.0, 20.0), length=200.0))
    other = one.mirror((1, 0, 0)).translate((200, 0, 0))
    assert one.volume() == pytest.approx(other.volume())
    assert all((one - laid).volume() > 1000 for laid in _turned(other))
    assert any((one - laid).volume() < 1e-3 for laid in _turned(one))


def test_margins_make_voids_larger_and_smaller() -> None:
    blind = hole("v", 400.0, 60.0, 14.0, depth=5.0, kind="blind")
    drawn = part(PLATE, blind)
    larger = part_solid(drawn, Margins(radius=lambda d: 1.0, depth=0.5, end=2.0))
    smaller = part_solid(drawn, Margins(radius=lambda d: -1.0, depth=-0.5, end=-2.0))
    assert larger.volume() == pytest.approx(996 * 2400 - pi * 64 * 5.5, rel=1e-5)
    assert smaller.volume() == pytest.approx(1004 * 2400 - pi * 36 * 4.5, rel=1e-5)
    pointed = part_solid(drawn, Margins(point_deg=90.0))
    assert part_solid(drawn).volume() - pointed.volume() == pytest.approx(pi * 49 * 7 / 3, rel=0.01)


@pytest.mark.parametrize(
    ("bad", "found"),
    [
        (part(replace(IPE, web_thickness=None)), "a web thickness of 0 mm"),
        (
            part(Profile("SO", "X1", 60.0, 60.0, 0.0, 0.0)),
            "a special section X1 without its outline",
        ),
        (part(PLATE, hole("o", 10.0, 6.0, 5.0)), "a hole on face o"),
        (part(IPE, hole("E1", 10.0, 6.0, 5.0)), "a hole on face E1"),
    ],
    ids=lambda value: "" if isinstance(value, Part) else str(value),
)
def test_what_has_no_solid_says_why(bad: Part, found: str) -> None:
    with pytest.raises(BeamcamError, match=f"solid-none: found {found}; expected"):
        part_solid(bad)


def test_without_the_kernel_one_line_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    with pytest.raises(BeamcamError) as refused:
        part_solid(part(IPE))
    (said,) = refused.value.diagnostics
    assert said.code == "solid-kernel"
    assert "pip install manifold3d" in said.message


def _closed(*points: tuple[float, float]) -> tuple[Line, ...]:
    places = [(float(x), float(y)) for x, y in points]
    return tuple(map(Line, places, [*places[1:], places[0]]))


def _turned(body: Any) -> list[Any]:
    """A body in the 24 turns of a cube about its box's middle, at the first one's corner."""
    low = np.array(body.bounding_box()[:3])
    found = []
    for i in range(3):
        for up in (1, -1):
            for j in range(3):
                for across in (1, -1):
                    if i == j:
                        continue
                    a, b = np.zeros(3), np.zeros(3)
                    a[i], b[j] = up, across
                    matrix = np.column_stack([a, b, np.cross(a, b)])
                    one = body.transform(np.column_stack([matrix, np.zeros(3)]))
                    found.append(one.translate(tuple(low - np.array(one.bounding_box()[:3]))))
    assert len(found) == 24
    return found
