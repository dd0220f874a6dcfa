"""DSTV text by the book, and what the format cannot hold."""

from math import hypot

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import BeamcamError, Source
from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line, NewtonCurve
from beamcam.model.part import Bevel, Contour, FileComment, Hole, Part, Plane, Profile, TextMark
from beamcam.readers.dstv import read
from beamcam.writers import dstv_rows
from beamcam.writers.dstv import write
from beamcam.writers.dstv_rows import format_number
from tests.conftest import rules_of

HERE = Source("a.ifc", None, "0Lt8gR")
PLATE = Part("P1", Profile("B", "PL10*200", 200, 0, 0, 10), 300, HERE)


def contour(*curves, kind="open", process="punch", closed=False, **fields):
    return Contour("v", kind, curves, HERE, process, closed, **fields)


def with_feature(feature):
    return replace(PLATE, features=(feature,))


@settings(deadline=None)
@given(st.floats(-1e9, 1e9))
def test_numbers(value):
    text = format_number(value)
    assert abs(float(text) - value) <= 5.1e-7 + abs(value) * 1e-15
    assert "e" not in text
    assert len(text.partition(".")[2]) in range(2, 7)
    assert float(text) != 0 or not text.startswith("-")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0.00"),
        (-0.0, "0.00"),
        (-1e-9, "0.00"),
        (1.5, "1.50"),
        (1.125, "1.125"),
        (1e7, "10000000.00"),
        (1 / 3, "0.333333"),
    ],
)
def test_number_examples(value, text):
    assert format_number(value) == text


def test_part_without_header_texts():
    lines = write(PLATE).splitlines()
    assert lines[0] == "ST"
    assert len(lines) == 26
    assert all(line.startswith("  ") for line in lines[1:25])
    assert lines[25] == "EN"
    assert [line.strip() for line in lines[1:9]] == ["-", "-", "-", "P1", "-", "1", "PL10*200", "B"]
    assert read(write(PLATE).encode(), "p.nc1").diagnostics == ()


def test_a_row_without_reference_begins_a_block():
    holes = tuple(Hole("v", x, 20, 18, HERE, edge=edge) for x, edge in ((10, "s"), (20, "")))
    text = write(replace(PLATE, features=holes))
    assert text.count("BO\n") == 2
    (part,) = read(text.encode(), "p.nc1").parts
    assert [f.edge for f in part.features] == ["s", ""]


def test_faces_have_blocks_of_their_own():
    holes = tuple(Hole(face, 10, 20, 18, HERE, edge="s") for face in "vvou")
    assert write(replace(PLATE, features=holes)).count("BO\n") == 3


def test_arcs_beyond_half_a_circle_become_several():
    circle = contour(Arc((50, 50), 20, 0, -360), kind="inner", process="cut", closed=True)
    (part,) = read(write(with_feature(circle)).encode(), "p.nc1").parts
    (found,) = part.contours
    assert [(c.radius, c.sweep_deg) for c in found.curves] == [(20, -180), (20, -180)]
    arc = contour(Arc((50, 50), 20, 0, 270), bevels=(Bevel(0, 30, 2),))
    (part,) = read(write(with_feature(arc)).encode(), "p.nc1").parts
    (found,) = part.contours
    assert [c.sweep_deg for c in found.curves] == pytest.approx([135, 135])
    assert [b.curve for b in found.bevels] == [0, 1]


@pytest.mark.parametrize("sweep", [177.9, -179.5, 179.99])
def test_an_arc_that_would_be_read_as_a_half_circle_becomes_two(sweep):
    arc = Arc((50, 50), 50, 10, sweep)
    (part,) = read(write(with_feature(contour(arc))).encode(), "p.nc1").parts
    (found,) = part.contours
    assert sum(c.sweep_deg for c in found.curves) == pytest.approx(sweep, abs=1e-4)
    assert all(c.centre == pytest.approx((50, 50), abs=1e-4) for c in found.curves)
    half = Arc((50, 50), 50, 10, 180)
    (part,) = read(write(with_feature(contour(half))).encode(), "p.nc1").parts
    (found,) = part.contours
    assert len(found.curves) == 1


@pytest.mark.parametrize("face", ["v", "h"])
def test_contours_that_run_the_wrong_way_are_turned(face):
    corners = [(0.0, 0.0), (100.0, 0.0), (100.0, 50.0), (0.0, 50.0)]
    if face == "v":
        corners.reverse()
    curves = tuple(map(Line, corners, [*corners[1:], corners[0]]))
    wrong = Contour(face, "outer", curves, HERE, bevels=(Bevel(0, 30, 2),))
    (part,) = read(write(with_feature(wrong)).encode(), "p.nc1").parts
    (found,) = part.contours
    assert found.curves == tuple(curve.reversed() for curve in reversed(curves))
    assert found.bevels == (Bevel(3, 30, 2),)


FREE = (
    EllipseArc((50.0, 50.0), (30.0, 5.0), 0.4, 10.0, 250.0),
    Bezier(((0.0, 0.0), (10.0, 40.0), (50.0, -40.0), (60.0, 0.0))),
    Bezier(((0.0, 0.0), (10.0, 40.0), (60.0, 0.0)), (1.0, 3.0, 1.0)),
    BSpline(2, ((0.0, 0.0), (10.0, 20.0), (30.0, 10.0), (40.0, 0.0)), (0, 0, 0, 0.4, 1, 1, 1)),
    NewtonCurve(((0.0, 0.0), (10.0, 20.0), (20.0, 10.0))),
)


@pytest.mark.parametrize("curve", FREE, ids=lambda curve: type(curve).__name__)
@pytest.mark.parametrize("tolerance", [0.5, 0.01])
def test_free_curves_need_a_tolerance_and_keep_it(curve, tolerance):
    part = with_feature(contour(curve))
    with pytest.raises(BeamcamError) as error:
        write(part)
    assert [d.code for d in error.value.diagnostics] == ["dstv-write-curve"]
    assert "0Lt8gR" in str(error.value)
    (again,) = read(write(part, tolerance).encode(), "p.nc1").parts
    (found,) = again.contours
    assert found.curves[0].start == pytest.approx(curve.start)
    assert found.curves[-1].end == pytest.approx(curve.end)
    for k in range(401):
        point = curve.point(k / 400)
        assert min(distance(point, line) for line in found.curves) <= tolerance + 1e-6


def distance(point, line):
    (x0, y0), (x1, y1) = line.start, line.end
    dx, dy = x1 - x0, y1 - y0
    t = ((point[0] - x0) * dx + (point[1] - y0) * dy) / (dx * dx + dy * dy)
    t = min(1.0, max(0.0, t))
    return hypot(point[0] - x0 - t * dx, point[1] - y0 - t * dy)


def text_mark(text):
    return with_feature(TextMark("v", 1, 2, 0, 10, text, HERE))


SOMEWHERE = ((0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0), HERE)
LINE = Line((0.0, 0.0), (9.0, 0.0))

REFUSED = [
    (replace(PLATE, mark="two\nlines"), "dstv-write-text"),
    (replace(PLATE, order="**"), "dstv-write-text"),
    (replace(PLATE, notes=("\x1a",)), "dstv-write-text"),
    (replace(PLATE, info=(("", "a:b"),)), "dstv-write-text"),
    (replace(PLATE, info=(("a:b", "c"),)), "dstv-write-text"),
    (replace(PLATE, info=(("", "BO"),)), "dstv-write-text"),
    (replace(PLATE, comments=(FileComment("a\nb", "end"),)), "dstv-write-text"),
    (text_mark(""), "dstv-write-text"),
    (text_mark("a\rb"), "dstv-write-text"),
    (with_feature(contour(LINE, process="cut")), "dstv-write-contour"),
    (with_feature(contour(LINE, process="engrave")), "dstv-write-contour"),
    (
        with_feature(contour(LINE, bevels=tuple(Bevel(0, a, 1) for a in (10, 20, 30)))),
        "dstv-write-bevels",
    ),
    (with_feature(Hole("E1", 1, 2, 3, HERE)), "dstv-write-face"),
    (with_feature(Hole("front", 1, 2, 3, HERE)), "dstv-write-face"),
    (replace(PLATE, planes=(Plane("slope", *SOMEWHERE),)), "dstv-write-face"),
    (
        replace(
            PLATE,
            planes=(Plane("E1", *SOMEWHERE), Plane("E2", *SOMEWHERE), Plane("E1#2", *SOMEWHERE)),
            features=(Hole("E1#2", 1, 2, 3, HERE), Hole("E1", 1, 2, 3, HERE)),
        ),
        "dstv-write-plane",
    ),
    (replace(PLATE, comments=(FileComment("x", "feature:7"),)), "dstv-write-comment"),
    (replace(PLATE, comments=(FileComment("x", "nowhere"),)), "dstv-write-comment"),
]


@pytest.mark.parametrize(("part", "code"), REFUSED)
def test_what_the_format_cannot_hold(part, code):
    with pytest.raises(BeamcamError) as error:
        write(part)
    assert [d.code for d in error.value.diagnostics] == [code]
    assert "expected" in str(error.value)


def test_every_code_is_met():
    assert {rule.code for rule in rules_of(dstv_rows)} == {code for _, code in REFUSED} | {
        "dstv-write-curve"
    }
