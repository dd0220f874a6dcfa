"""Areas against polygons drawn by shapely, and weights against what real offices write."""

from math import pi

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from beamcam.errors import Source
from beamcam.model.part import Part, Profile, SectionPoint
from beamcam.model.section import measures_of, section_area, weight_of
from beamcam.pipeline import read_file
from tests.conftest import CORPUS

SOURCE = Source("test")


def profile(code: str, h: float, b: float, tf: float, tw: float, r: float) -> Profile:
    return Profile(code, "test", h, b, tf, tw, r)  # type: ignore[arg-type]


def fillet(x: float, y: float, r: float, dx: int, dy: int) -> shapely.Geometry:
    """What a root fillet fills in the corner at x, y that opens to dx, dy."""
    square = shapely.box(*sorted((x, x + dx * r)), *sorted((y, y + dy * r)))
    square = shapely.box(min(x, x + dx * r), min(y, y + dy * r), max(x, x + dx * r),
                         max(y, y + dy * r))  # fmt: skip
    return square.difference(shapely.Point(x + dx * r, y + dy * r).buffer(r, quad_segs=256))


@given(st.floats(80, 900), st.floats(40, 400), st.floats(4, 16), st.floats(3, 12), st.floats(1, 18))
def test_rolled_sections_are_their_plates_and_fillets(
    h: float, b: float, tf: float, tw: float, r: float
) -> None:
    web = shapely.box(b / 2 - tw / 2, 0, b / 2 + tw / 2, h)
    flanges = [shapely.box(0, 0, b, tf), shapely.box(0, h - tf, b, h)]
    inner = [(s, y, dy) for s in (-1, 1) for y, dy in ((tf, 1), (h - tf, -1))]
    roots = [fillet(b / 2 + s * tw / 2, y, r, s, dy) for s, y, dy in inner]
    drawn = shapely.union_all([web, *flanges, *roots]).area
    assert section_area(profile("I", h, b, tf, tw, r)) == pytest.approx(drawn, rel=1e-4)
    web = shapely.box(0, 0, tw, h)
    drawn = shapely.union_all(
        [web, *flanges, fillet(tw, tf, r, 1, 1), fillet(tw, h - tf, r, 1, -1)]
    ).area
    assert section_area(profile("U", h, b, tf, tw, r)) == pytest.approx(drawn, rel=1e-4)


@given(st.floats(40, 400), st.floats(40, 300), st.floats(2, 16))
def test_a_hollow_section_is_one_rounded_box_in_another(h: float, b: float, t: float) -> None:
    outer = shapely.box(2 * t, 2 * t, b - 2 * t, h - 2 * t)
    inner = shapely.box(2 * t, 2 * t, b - 2 * t, h - 2 * t).buffer(t, quad_segs=256)
    area = outer.buffer(2 * t, quad_segs=256).area - inner.area
    if h > 4 * t and b > 4 * t:
        assert section_area(profile("M", h, b, t, t, 2 * t)) == pytest.approx(area, rel=1e-4)


@pytest.mark.parametrize(("name", "kg_m"), [
    ("IPE300", 42.2), ("HEB200", 61.3), ("HEA200", 42.3), ("UPE200", 22.8), ("L100X10", 15.0),
    ("L100X50X8", 8.99),
])  # fmt: skip
def test_the_tables_of_the_standards(name: str, kg_m: float) -> None:
    """kg/m as EN 10365 and EN 10056-1 print them."""
    found = measures_of(name)
    assert found is not None
    code, sizes = found
    area = section_area(profile(code, *sizes))
    assert area is not None
    assert area * 7850e-6 == pytest.approx(kg_m, rel=0.01)


def test_rounds_plates_and_outlines() -> None:
    assert section_area(profile("RU", 20, 20, 0, 0, 0)) == pytest.approx(pi * 100)
    assert section_area(profile("RO", 100, 100, 5, 5, 0)) == pytest.approx(pi * (2500 - 2025))
    assert section_area(profile("C", 175, 60, 1.5, 1.5, 3)) is None
    corners = ((0, 0), (100, 0), (100, 50), (0, 50))
    hole = ((10, 10), (90, 10), (90, 40), (10, 40))
    outline = (*(SectionPoint("+", *c) for c in corners), *(SectionPoint("-", *c) for c in hole))
    assert section_area(profile("SO", 100, 50, 0, 0, 0), outline) == 100 * 50 - 80 * 30
    plate = Part("P", profile("B", 200, 0, 0, 10, 0), 300.0, SOURCE)
    assert weight_of(plate) == pytest.approx(200 * 300 * 10 * 7850e-9)
    purlin = Part("Z", profile("C", 175, 60, 1.5, 1.5, 3), 1000.0, SOURCE, weight=4.4)
    assert weight_of(purlin) == pytest.approx(4.4)
    assert weight_of(Part("Z", profile("C", 175, 60, 1.5, 1.5, 3), 1000.0, SOURCE)) is None


@pytest.mark.third_party
def test_what_offices_write_in_their_headers() -> None:
    """The kg/m of real files, which come from the tables of their programs."""
    seen = 0
    for path in sorted((CORPUS / "dstv").rglob("*")):
        if path.suffix.lower() not in (".nc", ".nc1"):
            continue
        for part in read_file(str(path)).parts:
            area = section_area(part.profile, part.section)
            if part.profile.code in ("I", "U", "L", "M") and part.weight > 1 and area:
                assert area * 7850e-6 == pytest.approx(part.weight, rel=0.04), path
                seen += 1
    assert seen >= 5
