"""Sections by their outline, in any position, and the catalogue's names for them."""

import itertools
from math import cos, pi, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import Severity
from beamcam.model.part import Profile
from beamcam.model.section import name_of, plain_name, sections
from beamcam.readers.ifc import Options, read
from beamcam.readers.ifc.marks import named
from beamcam.readers.ifc.outline import Chain, Round, Slotted, shape_of, with_arcs
from beamcam.readers.ifc.profiles import points_chain, rounded_box
from beamcam.readers.ifc.section import classify
from tests.conftest import examples
from tests.property.ifc_builder import Member, bore_polygon, section_polygon
from tests.property.ifc_cuts import Bar, angle_corners
from tests.unit.readers.ifc.models import Small

SIZES = {
    "I": (300.0, 150.0, 10.7, 7.1),
    "U": (200.0, 80.0, 11.0, 6.0),
    "L": (120.0, 80.0, 10.0, 10.0),
    "T": (150.0, 170.0, 7.1, 10.7),
    "M": (200.0, 100.0, 6.0, 6.0),
    "B": (180.0, 12.0, 0.0, 12.0),
}


def turned(chain: Chain, angle: float, mirror: bool, shift: tuple[float, float]) -> Chain:
    c, s = cos(radians(angle)), sin(radians(angle))
    flip = -1.0 if mirror else 1.0
    return tuple(k.transformed(((c * flip, -s, shift[0]), (s * flip, c, shift[1]))) for k in chain)


@settings(max_examples=examples(80), deadline=None)
@given(
    st.sampled_from(sorted(SIZES)),
    st.floats(0, 360),
    st.booleans(),
    st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)),
    st.integers(0, 11),
)
def test_a_section_is_told_in_any_position(
    code: str, angle: float, mirror: bool, shift: tuple[float, float], first: int
) -> None:
    member = Member(code, SIZES[code], 1000.0, ((0, 0), (0, 0)), ())
    points = section_polygon(member)
    k = first % len(points)
    outer = turned(points_chain(points[k:] + points[:k]), angle, mirror, shift)
    bore = bore_polygon(member)
    inner = (turned(points_chain(bore), angle, mirror, shift),) if bore else ()
    found = classify(outer, inner)
    assert found is not None
    assert found.code == code
    measured = (found.height, found.width, found.flange_thickness, found.web_thickness)
    assert measured == pytest.approx(SIZES[code], abs=1e-6)
    # Y and Z are square to each other and the zero point is a corner of the section's box.
    assert found.y[0] * found.z[0] + found.y[1] * found.z[1] == pytest.approx(0, abs=1e-9)
    box = [
        ((p[0] - found.origin[0]) * d[0] + (p[1] - found.origin[1]) * d[1])
        for curve in outer
        for p in [curve.start]
        for d in [found.y]
    ]
    assert min(box) == pytest.approx(0, abs=1e-6)
    assert max(box) == pytest.approx(found.height, abs=1e-6)


@settings(max_examples=examples(60), deadline=None)
@given(st.integers(12, 40), st.floats(5, 200), st.floats(0, 6))
def test_a_polygon_on_a_circle_is_the_circle(n: int, d: float, start: float) -> None:
    points = [
        (
            d / 2 * cos(start + 6.283185307179586 * i / n),
            d / 2 * sin(start + 6.283185307179586 * i / n),
        )
        for i in range(n)
    ]
    found = shape_of(points_chain(points))
    assert isinstance(found, Round)
    assert found.diameter == pytest.approx(d, abs=1e-6)


@pytest.mark.parametrize("n", [3, 4, 6, 8, 11])
def test_a_polygon_of_few_corners_is_no_hole(n: int) -> None:
    points = [(cos(6.283185307 * i / n) * 30, sin(6.283185307 * i / n) * 30) for i in range(n)]
    assert shape_of(points_chain(points)) is None


@settings(max_examples=examples(60), deadline=None)
@given(st.floats(20, 200), st.floats(6, 19), st.floats(0, 179.9))
def test_slots_are_told_as_drawn_and_as_polygons(x: float, d: float, angle: float) -> None:
    drawn = turned(rounded_box(x + d, d, d / 2), angle, False, (12.0, -7.0))
    found = shape_of(drawn)
    assert isinstance(found, Slotted)
    assert (found.length, found.diameter) == pytest.approx((x, d), abs=1e-6)
    assert min(abs(found.angle - angle), abs(abs(found.angle - angle) - 180)) < 1e-6
    points = [c.point(i / 9) for c in drawn for i in range(9 if hasattr(c, "radius") else 1)]
    again = shape_of(with_arcs(points_chain(points)))
    assert isinstance(again, Slotted)
    assert again.diameter == pytest.approx(d, abs=0.01)


def test_every_section_has_its_own_name_back() -> None:
    for name, (code, (h, b, tf, tw, r)) in sections().items():
        again = name_of(Profile(code, "", h, b, tf, tw, r))
        assert again is not None
        assert sections()[again][1][:4] == (h, b, tf, tw), name


def test_measures_keep_their_order() -> None:
    """Height, width and thicknesses grow from size to size within a series."""
    for series in ("IPE", "HEA", "HEB", "UPE"):
        rows = [
            sizes
            for name, (_, sizes) in sections().items()
            if name.startswith(series) and name[len(series) :].isdigit()
        ]
        assert len(rows) >= 14
        for small, large in itertools.pairwise(rows):
            assert all(a <= b for a, b in zip(small, large, strict=True)), (series, small, large)


@pytest.mark.parametrize(
    ("spelled", "plain"),
    [("HE 200 B", "HEB200"), ("heb-200", "HEB200"), ("L 100*100*10", "L100X100X10")],
)
def test_spellings_of_a_name(spelled: str, plain: str) -> None:
    assert plain_name(spelled) == plain


def test_a_name_stands_unless_the_measures_deny_it() -> None:
    heb280 = Profile("I", "", 280.0, 280.0, 18.0, 10.5, 24.0)
    assert named(heb280, ["HEB220"]) == ("HEB280", ["HEB220"])
    assert named(heb280, ["HE280B"]) == ("HE280B", [])
    assert named(heb280, [""]) == ("HEB280", [])
    assert named(heb280, ["my beam"]) == ("my beam", [])
    assert named(heb280, ["HE280B", "HEB220"]) == ("HE280B", ["HEB220"])
    odd = Profile("I", "", 281.0, 280.0, 18.0, 10.5, 24.0)
    assert named(odd, [""]) == ("I281x280x10.5x18", [])
    assert name_of(Profile("I", "", 280.25, 280.0, 18.0, 10.5)) == "HEB280"


@settings(max_examples=examples(40), deadline=None)
@given(
    st.floats(60.0, 250.0), st.floats(50.0, 200.0), st.floats(5.0, 14.0), st.floats(5.0, 14.0),
    st.floats(5.0, 12.0), st.integers(12, 180),
)  # fmt: skip
def test_an_angle_is_read_whatever_the_steps_of_its_fillet(
    height: float, width: float, flange: float, web: float, radius: float, chords: int
) -> None:
    """Its legs may be of two thicknesses; steps of half a degree are no straight lines."""
    bar = Bar("L", 1000.0, (height, width, flange, web, radius))
    found = classify(points_chain([(z, y) for y, z in angle_corners(bar, chords)]))
    assert found is not None
    assert found.code == "L"
    sizes = (found.height, found.width, found.flange_thickness, found.web_thickness, found.radius)
    expected = bar.sizes if height >= width else (width, height, web, flange, radius)
    assert sizes == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(("flange", "said"), [
    ("1.E201", "flanges of 1e+201 mm in a height of 300 mm"), ("150.", "flanges of 150 mm"),
    ("0.", "a flange thickness of 0 mm"),
])  # fmt: skip
def test_a_section_that_cannot_be_is_refused(flange: str, said: str) -> None:
    m = Small()
    sizes = f"150.,300.,7.1,{flange},$,$,$"
    m.element(m.extruded(m.add(f"IFCISHAPEPROFILEDEF(.AREA.,$,{m.flat},{sizes})"), 2000.0))
    found = read(m.data, "m.ifc", options=Options(kernel=False))
    assert not found.parts
    (error,) = [d for d in found.diagnostics if d.severity is Severity.ERROR]
    assert error.code == "ifc-section"
    assert said in error.message


@pytest.mark.parametrize(("fillet", "edge"), [("$", "$"), ("6.", "$"), ("6.", "2.")])
def test_a_z_has_flanges_from_the_back_of_its_web(fillet: str, edge: str) -> None:
    """As the standard draws it, also for the kernel."""
    m = Small()
    sizes = f"200.,75.,3.,4.,{fillet},{edge}"
    m.element(m.extruded(m.add(f"IFCZSHAPEPROFILEDEF(.AREA.,$,{m.flat},{sizes})"), 2000.0))
    found = read(m.data, "m.ifc", options=Options(kernel=True))
    (part,) = found.parts
    assert part.profile.code == "SO"
    assert (part.profile.height, part.profile.width) == pytest.approx((200.0, 147.0))
    area = 2 * 75 * 4 + (200 - 8) * 3
    area += (1 - pi / 4) * 2 * (36 * (fillet != "$") - 4 * (edge != "$"))
    assert part.weight == pytest.approx(area * 7.85e-3, rel=1e-6)
    assert [d.code for d in found.diagnostics] == ["ifc-ledger"]


PIPE, TUBE = Profile("RO", "", 152.4, 152.4, 4.0, 4.0), Profile("M", "", 200.0, 100.0, 8.0, 8.0)
EQUAL, FLAT = Profile("L", "", 100.0, 100.0, 10.0, 10.0), Profile("B", "", 150.0, 0.0, 0.0, 20.0)


@pytest.mark.parametrize(
    ("profile", "label", "wrong"),
    [
        (PIPE, "K152,4/12,5", True),
        (PIPE, "K152,4/4,0", False),
        (PIPE, "CHS 168.3x4", True),
        (PIPE, "O152.4*4", False),
        (PIPE, "K152,4", False),
        (TUBE, "RHS200/100/8", False),
        (TUBE, "RHS100*200*8", False),
        (TUBE, "RHS200*100*10", True),
        (TUBE, "SHS200*8", True),
        (TUBE, "Q200/100/8,0", False),
        (TUBE, "Q200/100/6,0", True),
        (PIPE, "TUBO152.4X4", False),
        (PIPE, "TUBO152.4X3", True),
        (PIPE, "Q235", False),
        (TUBE, "HSS8x4x.3125", False),
        (EQUAL, "L100/10", False),
        (EQUAL, "L100x100x12,5", True),
        (EQUAL, "L4x4x3/8", False),
        (FLAT, "PL20*200", False),
        (FLAT, "FL150/20", False),
        (FLAT, "FL150/12", True),
    ],
)
def test_a_name_that_is_made_of_measures_is_compared(
    profile: Profile, label: str, wrong: bool
) -> None:
    assert named(profile, [label])[1] == [label] * wrong
