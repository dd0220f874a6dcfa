"""Laws of the DXF reader: what a file says in another way is the same drawing."""

import io
import random
from itertools import pairwise
from math import degrees, hypot, radians
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import Diagnostic
from beamcam.model.lengths import total_length
from beamcam.model.part import extent
from beamcam.readers import dxf
from tests.conftest import examples
from tests.dxf_text import arc, block, circle, curves_of, drawing, insert, line, polyline, spline

SAMPLES = sorted((Path(__file__).parents[2] / "samples").rglob("*.dxf"))

numbers = st.integers(-200_000, 200_000).map(lambda n: n / 1000)
points = st.tuples(numbers, numbers)
angles = st.integers(0, 359)
radii = st.integers(1, 100_000).map(lambda n: n / 1000)
bulges = st.sampled_from([0.0, 0.0, 0.5, -0.5, 1.0, -2.0, 0.1])
vertices = st.tuples(numbers, numbers, bulges)

shapes = st.one_of(
    st.builds(lambda a, b: line(*a, *b), points, points.map(lambda p: (p[0], p[1] + 500))),
    st.builds(lambda c, r: circle(*c, r), points, radii),
    st.builds(lambda c, r, a, s: arc(*c, r, a, (a + s) % 360), points, radii, angles, angles),
    st.builds(
        polyline,
        st.lists(vertices, min_size=2, max_size=6, unique_by=lambda v: v[:2]),
        st.booleans(),
    ),
    st.builds(
        lambda control: spline(control, [0, 0, 0, 0, 1, 2, 2, 2, 2]),
        st.lists(points, min_size=5, max_size=5, unique=True),
    ),
)
drawings = st.lists(shapes, min_size=1, max_size=4).map("".join)


def close(box: tuple[float, ...] | None):
    assert box is not None
    return pytest.approx(box, abs=1e-6)


@settings(max_examples=examples(40), deadline=None)
@given(drawings, st.sampled_from([(1, 25.4), (2, 304.8), (5, 10.0), (6, 1000.0)]))
def test_another_unit_scales_the_drawing(shapes: str, unit: tuple[int, float]) -> None:
    code, mm = unit
    plain, scaled = curves_of(drawing(shapes)), curves_of(drawing(shapes, units=code))
    assert [type(c) for c in plain] == [type(c) for c in scaled]
    assert total_length(scaled) == pytest.approx(mm * total_length(plain), rel=1e-9)


@settings(max_examples=examples(40), deadline=None)
@given(drawings, points, angles, st.sampled_from([1.0, 2.5]), st.booleans())
def test_an_insert_that_keeps_shapes_keeps_kinds_and_lengths(
    shapes: str, at: tuple[float, float], turn: float, scale: float, mirror: bool
) -> None:
    side = -scale if mirror else scale
    place = insert("B", *at, (41, side), (42, scale), (43, 1), (50, turn))
    plain = curves_of(drawing(shapes))
    placed = curves_of(drawing(place, blocks=block("B", shapes)))
    assert [type(c) for c in plain] == [type(c) for c in placed]
    assert total_length(placed) == pytest.approx(scale * total_length(plain), rel=1e-9)


@settings(max_examples=examples(40), deadline=None)
@given(drawings)
def test_seen_from_behind_twice_is_seen_from_the_front(shapes: str) -> None:
    behind = ((41, 1), (42, 1), (43, 1), (210, 0), (220, 0), (230, -1))
    inner = block("A", shapes) + block("B", insert("A", 0, 0, *behind))
    plain = curves_of(drawing(shapes))
    again = curves_of(drawing(insert("B", 0, 0, *behind), blocks=inner))
    for a, b in zip(plain, again, strict=True):
        assert a.start == pytest.approx(b.start, abs=1e-9)
        assert a.end == pytest.approx(b.end, abs=1e-9)
    assert extent(plain) == close(extent(again))


@settings(max_examples=examples(40), deadline=None)
@given(drawings, st.floats(0.2, 5), st.floats(0.2, 5))
def test_uneven_scales_agree_with_flattening(shapes: str, sx: float, sy: float) -> None:
    place = insert("B", 3, 4, (41, sx), (42, sy), (43, 1))
    placed = curves_of(drawing(place, blocks=block("B", shapes)))
    plain = curves_of(drawing(shapes))
    for before, after in zip(plain, placed, strict=True):
        for t in (0.0, 1.0):
            x, y = before.point(t)
            assert after.point(t) == pytest.approx((3 + sx * x, 4 + sy * y), abs=1e-6)


@settings(max_examples=examples(40), deadline=None)
@given(vertices, points.map(lambda p: (p[0] + 500, p[1])))
def test_a_bulge_is_the_tangent_of_a_quarter_of_its_sweep(
    first: tuple[float, float, float], second: tuple[float, float]
) -> None:
    from ezdxf.math import bulge_center, bulge_radius

    (curve,) = curves_of(drawing(polyline([first, second], False)))
    assert curve.start == pytest.approx(first[:2], abs=1e-6)
    assert curve.end == pytest.approx(second, abs=1e-6)
    if first[2]:
        centre = bulge_center(first[:2], second, first[2])
        assert curve.centre == pytest.approx((centre.x, centre.y), abs=1e-6)
        assert curve.radius == pytest.approx(bulge_radius(first[:2], second, first[2]))


@settings(max_examples=examples(30), deadline=None)
@given(drawings)
def test_lengths_are_those_that_ezdxf_flattens_to(shapes: str) -> None:
    import ezdxf

    document = ezdxf.read(io.StringIO(drawing(shapes).decode()))
    expected = 0.0
    for entity in document.modelspace():
        parts = entity.virtual_entities() if entity.dxftype() == "LWPOLYLINE" else [entity]
        for part in parts:
            if part.dxftype() == "LINE":
                expected += part.dxf.start.distance(part.dxf.end)
            elif part.dxftype() == "SPLINE":
                flat = list(part.flattening(1e-4))
                expected += sum(a.distance(b) for a, b in pairwise(flat))
            else:
                sweep = 360.0
                if part.dxftype() == "ARC":
                    sweep = (part.dxf.end_angle - part.dxf.start_angle) % 360 or 360.0
                expected += radians(sweep) * part.dxf.radius
    assert total_length(curves_of(drawing(shapes))) == pytest.approx(expected, rel=1e-5, abs=1e-3)


def test_a_sweep_in_degrees_is_what_the_chord_says() -> None:
    (curve,) = curves_of(drawing(polyline([(0, 0, 0.3), (10, 0)], False)))
    rise = hypot(*(a - b for a, b in zip(curve.point(0.5), (5, 0), strict=True)))
    assert rise == pytest.approx(0.3 * 5)
    assert degrees(curve.length / curve.radius) == pytest.approx(curve.sweep_deg)


@settings(max_examples=examples(200), deadline=None)
@given(st.sampled_from(SAMPLES), st.randoms(use_true_random=False))
def test_no_damage_makes_the_reader_raise(path: Path, dice: random.Random) -> None:
    """Lines of a file are lost, doubled, swapped or overwritten: a reading or a refusal."""
    rows = path.read_bytes().split(b"\n")
    for _ in range(dice.randint(1, 4)):
        i, j = dice.randrange(len(rows)), dice.randrange(len(rows))
        match dice.randrange(5):
            case 0:
                del rows[i : i + dice.randint(1, 3)]
            case 1:
                rows.insert(i, rows[j])
            case 2:
                rows[i], rows[j] = rows[j], rows[i]
            case 3:
                rows[i] = dice.choice([b"", b"-1", b"nan", b"1e400", b"0", b"ENDSEC", b"\xff"])
            case _:
                rows = rows[: i + 1]
        rows = rows or [b""]
    reading = dxf.read(b"\n".join(rows), "a.dxf")
    assert all(isinstance(d, Diagnostic) for d in reading.diagnostics)
    assert reading.parts or reading.refused


@settings(max_examples=examples(30), deadline=None)
@given(st.sampled_from([p for p in SAMPLES if "bad" not in p.parts]))
def test_reading_twice_says_the_same(path: Path) -> None:
    data = path.read_bytes()
    assert dxf.read(data, "a.dxf") == dxf.read(data, "a.dxf")
