"""The surface of a profile: places by hand, laws, and the section that solids are made of."""

from math import atan2, cos, hypot, pi, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import Point, Polygon
from shapely.affinity import rotate, translate

from beamcam.errors import Source
from beamcam.model.part import Part, Profile
from beamcam.model.surface import Patch, around, patch_of, surface_of
from beamcam.solid.kernel import outline

IPE300 = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
UPN200 = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
L100 = Profile("L", "L100x65x8", 100.0, 65.0, 8.0, 8.0, 10.0)
#: On its side: a stem of 130 x 7 in the middle of a flange of 150 x 10.
TEE = Profile("T", "T", 130.0, 150.0, 10.0, 7.0, 12.0)
RHS = Profile("M", "RHS120x80x5", 120.0, 80.0, 5.0, 5.0, 10.0)
CHS = Profile("RO", "CHS100x5", 100.0, 100.0, 0.0, 5.0)
SECTIONS = (IPE300, UPN200, L100, RHS, CHS)
PATCHES = [(p, patch) for p in SECTIONS for patch in surface_of(p)]


@pytest.mark.parametrize(
    ("profile", "name", "u", "place", "a_deg"),
    [
        (IPE300, "v", 100.0, (100.0, 78.55), 0.0),  # (150 + 7.1) / 2
        (IPE300, "h", 100.0, (100.0, 71.45), 180.0),
        (IPE300, "o", 30.0, (300.0, 30.0), -90.0),
        (IPE300, "u", 30.0, (0.0, 30.0), 90.0),
        (UPN200, "v", 50.0, (50.0, 8.5), 0.0),
        (UPN200, "o", 70.0, (200.0, 70.0), -90.0),
        (L100, "v", 99.0, (99.0, 8.0), 0.0),
        (L100, "u", 60.0, (0.0, 60.0), 90.0),
        (TEE, "v", 120.0, (120.0, 78.5), 0.0),
        (TEE, "u", 30.0, (0.0, 30.0), 90.0),
        (RHS, "v", 60.0, (60.0, 80.0), 0.0),
        (RHS, "u-v", 0.0, (0.0, 70.0), 90.0),
        (RHS, "u-v", 5.0 * pi, (10.0, 80.0), 0.0),
        (RHS, "v-o", 2.5 * pi, (110.0 + 10 * cos(pi / 4), 70.0 + 10 * cos(pi / 4)), -45.0),
        (RHS, "h-u", 5.0 * pi, (0.0, 10.0), 90.0),
        (CHS, "v", 0.0, (0.0, 50.0), 90.0),
        (CHS, "v", 25.0 * pi, (50.0, 100.0), 0.0),
        (CHS, "v", 50.0 * pi, (100.0, 50.0), -90.0),
        (CHS, "v", 75.0 * pi, (50.0, 0.0), 180.0),
    ],
)
def test_places_worked_by_hand(
    profile: Profile, name: str, u: float, place: tuple[float, float], a_deg: float
) -> None:
    patch = patch_of(surface_of(profile), name)
    assert patch is not None
    assert patch.point(7.0, u) == pytest.approx((7.0, *place))
    assert (patch.a_deg(u) - a_deg) % 360.0 == pytest.approx(0.0, abs=1e-9)


def test_sections_without_such_a_surface_have_none() -> None:
    assert surface_of(Profile("B", "PL10", 100.0, 0.0, 0.0, 10.0)) == ()
    assert patch_of(surface_of(L100), "o") is None
    assert patch_of(surface_of(TEE), "o") is None
    assert [p.name for p in surface_of(Profile("M", "RHS", 50.0, 50.0, 4.0, 4.0))] == list("uvoh")


@given(st.sampled_from(PATCHES), st.floats(0.0, 0.999), st.floats(-1e4, 1e4))
def test_a_place_on_the_steel_is_found_again(
    of: tuple[Profile, Patch], share: float, x: float
) -> None:
    _, patch = of
    u = patch.low + share * (patch.high - patch.low)
    there = patch.point(x, u)
    assert there[0] == x
    y, z = there[1] - patch.origin[0], there[2] - patch.origin[1]
    again = y * patch.along[0] + z * patch.along[1]
    if patch.radius:
        again = (atan2(z, -y) - patch.first_rad) % (2 * pi) * patch.radius
    assert again == pytest.approx(u, abs=1e-6)


@given(st.sampled_from(PATCHES), st.floats(0.01, 0.99))
def test_the_normal_is_square_to_the_surface_and_where_the_torch_looks_from(
    of: tuple[Profile, Patch], share: float
) -> None:
    _, patch = of
    u, du = patch.low + share * (patch.high - patch.low), 1e-4
    y, z = patch.normal(u)
    (_, ya, za), (_, yb, zb) = patch.point(0.0, u - du), patch.point(0.0, u + du)
    assert y * (yb - ya) + z * (zb - za) == pytest.approx(0.0, abs=1e-9)
    assert ((yb - ya) ** 2 + (zb - za) ** 2) ** 0.5 == pytest.approx(2 * du, rel=1e-4)
    a = radians(patch.a_deg(u))
    assert (-sin(a), cos(a)) == pytest.approx((y, z))


@given(st.sampled_from(PATCHES), st.floats(0.02, 0.98))
def test_steel_lies_behind_it_as_thick_as_it_says(of: tuple[Profile, Patch], share: float) -> None:
    profile, patch = of
    section: Polygon = outline(Part("P", profile, 100.0, Source("part")))
    u = patch.low + share * (patch.high - patch.low)
    _, y, z = patch.point(0.0, u)
    ny, nz = patch.normal(u)

    def is_steel(depth: float) -> bool:
        return bool(section.contains(Point(y - depth * ny, z - depth * nz)))

    assert is_steel(0.05)
    assert is_steel(patch.thickness - 0.05)
    if is_free(profile, patch, u):
        assert not is_steel(-0.05)
        assert not is_steel(patch.thickness + 0.05)


def is_free(profile: Profile, patch: Patch, u: float) -> bool:
    """Whether no other wall, and no fillet, stands on the wall there, before or behind it."""
    if profile.code == "RO":
        return True
    if profile.code == "M":
        wall = profile.flange_thickness
        reach = max(profile.radius, wall)
        return "-" not in patch.name and patch.low + reach < u < patch.high - reach
    h, b, r = profile.height, profile.width, profile.radius
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    if patch.name in ("v", "h"):
        return flange + r < u and (profile.code == "L" or u < h - flange - r)
    low, high = ((b - web) / 2, (b + web) / 2) if profile.code == "I" else (0.0, web)
    return u > high + r or u < low - r


# --- once round -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("s", "a_deg", "y", "z"),
    [
        (0.0, 90.0, 0.0, 60.0),  # the middle of u on top, 60 from the axis
        (30.0, 90.0, 30.0, 60.0),
        (30.0 + 5 * pi, 0.0, -50.0, 40.0),  # the lower end of v
        (80.0 + 5 * pi, 0.0, 0.0, 40.0),
        (130.0 + 10 * pi, -90.0, -30.0, 60.0),  # o, where it begins behind v
        (160.0 + 10 * pi, -90.0, 0.0, 60.0),
        (240.0 + 15 * pi, -180.0, 0.0, 40.0),
        (320.0 + 20 * pi, -270.0, 0.0, 60.0),  # u again, a turn on
        (-30.0 - 5 * pi, 180.0, 50.0, 40.0),
    ],
)
def test_where_a_place_comes_on_top_by_hand(s: float, a_deg: float, y: float, z: float) -> None:
    way = around(RHS)
    assert way.turn == pytest.approx(320.0 + 20 * pi)
    assert way.pose(s) == pytest.approx((a_deg, y, z), abs=1e-9)
    assert way.half_diagonal == pytest.approx((50**2 + 30**2) ** 0.5 + 10)


@given(st.sampled_from((RHS, CHS)), st.floats(-900.0, 900.0))
def test_a_place_on_top_is_the_highest_of_the_section_and_moves_evenly(
    profile: Profile, s: float
) -> None:
    """Turned by -A the section reaches no higher, and a step of s is a step on it."""
    way = around(profile)
    a_deg, y, z = way.pose(s)
    shape = outline(Part("P", profile, 1000.0, Source("p.nc1")))
    turned = rotate(translate(shape, -way.axis[0], -way.axis[1]), -a_deg, origin=(0.0, 0.0))
    assert turned.bounds[3] == pytest.approx(z, abs=0.02)
    assert turned.exterior.distance(Point(y, z)) < 0.02
    after_deg, y2, z2 = way.pose(s + 0.01)
    spin = radians(after_deg - a_deg)
    on = y2 * cos(spin) - z2 * sin(spin), y2 * sin(spin) + z2 * cos(spin)
    assert hypot(on[0] - y, on[1] - z) == pytest.approx(0.01, abs=1e-5)


def test_faces_on_the_way_round_meet_amid_their_corners() -> None:
    way = around(RHS)
    corner = 30.0 + 2.5 * pi
    places = (0.0, corner - 0.1, corner + 0.1, 160.0 + 10 * pi, 240.0 + 15 * pi, -corner + 0.1)
    assert [way.face_at(s) for s in places] == ["u", "u", "v", "o", "h", "u"]
    assert around(CHS).face_at(300.0) == "v"
    with pytest.raises(ValueError, match="expected a tube"):
        around(IPE300)
