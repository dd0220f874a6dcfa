"""Path data, basic shapes and transforms."""

import re
from math import pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, EllipseArc, Line
from beamcam.geometry.plane import mapped
from beamcam.readers.svg.page import parse_transform
from beamcam.readers.svg.path import PathError, _numbers, decimals, parse_path
from tests.svg_text import box_of, codes, curves_of, length_of, read


def lines(d: str) -> list[list[tuple[float, float]]]:
    return [[p[0].start, *(c.end for c in p)] for p in parse_path(d) if p]


@pytest.mark.parametrize(
    ("d", "points"),
    [
        ("M0 0L10 0L10 5", [(0, 0), (10, 0), (10, 5)]),
        ("m0 0 10 0 0 5", [(0, 0), (10, 0), (10, 5)]),
        ("M1,1 L2,2,3,3", [(1, 1), (2, 2), (3, 3)]),
        ("M0 0H10V5h-10z", [(0, 0), (10, 0), (10, 5), (0, 5), (0, 0)]),
        ("M0 0h10 20", [(0, 0), (10, 0), (30, 0)]),
        ("M.5.5-1-1", [(0.5, 0.5), (-1, -1)]),
        ("M1e1 0l1E-1,0", [(10, 0), (10.1, 0)]),
        ("M0 0l5 0l0 0l0 5", [(0, 0), (5, 0), (5, 5)]),
        ("M0 0L5 5L0 0z", [(0, 0), (5, 5), (0, 0)]),
    ],
)
def test_lines(d: str, points: list[tuple[float, float]]) -> None:
    (found,) = lines(d)
    assert found == [pytest.approx(point) for point in points]


def test_a_subpath_after_z_counts_from_the_start_of_the_closed_one() -> None:
    first, second = lines("M10 10l5 0 0 5zm20 0l1 0")
    assert first[-1] == (10, 10)
    assert second == [(30, 10), (31, 10)]
    assert lines("M10 10l5 0 0 5zl3 0")[1] == [(10, 10), (13, 10)]


def test_points_of_no_length_are_counted() -> None:
    body = '<path d="M5 5m0 0zM1 1L2 1z M0 0"/><line x1="1" x2="1"/><circle r="0"/>'
    (said,) = read(body).diagnostics
    assert said.message == "found 5 paths of no length and left them out"
    assert length_of(body) == 2


def test_curves() -> None:
    (path,) = parse_path("M0 0c0,10 10,10 10,0s10-10 10,0Q25 5 30 0t10 0T50 5")
    assert path == (
        Bezier(((0, 0), (0, 10), (10, 10), (10, 0))),
        Bezier(((10, 0), (10, -10), (20, -10), (20, 0))),
        Bezier(((20, 0), (25, 5), (30, 0))),
        Bezier(((30, 0), (35, -5), (40, 0))),
        Bezier(((40, 0), (45, 5), (50, 5))),
    )
    (path,) = parse_path("M0 0S5 5 10 0T20 0")  # nothing to reflect
    assert path[0].points[1] == (0, 0)
    assert path[1].points[1] == (10, 0)


@pytest.mark.parametrize(
    ("flags", "centre", "sweep"),
    [("0 1", (0, 5), 90), ("1 0", (0, 5), -270), ("0 0", (5, 0), -90), ("1 1", (5, 0), 270)],
)
def test_arcs(flags: str, centre: tuple[float, float], sweep: float) -> None:
    (path,) = parse_path(f"M0 0A5 5 0 {flags} 5 5")
    (arc,) = path
    assert isinstance(arc, Arc)
    assert arc.centre == pytest.approx(centre, abs=1e-12)
    assert arc.sweep_deg == pytest.approx(sweep)
    assert arc.end == pytest.approx((5, 5))


def test_arcs_of_ellipses_glued_flags_and_small_radii() -> None:
    (path,) = parse_path("M0 0a10 5 90 0110 20")
    (arc,) = path
    assert isinstance(arc, EllipseArc)
    assert (arc.start, arc.end) == (pytest.approx((0, 0), abs=1e-12), pytest.approx((10, 20)))
    (grown,) = parse_path("M0 0A1 1 0 0 1 10 0")[0]
    assert (grown.radius, abs(grown.sweep_deg)) == (pytest.approx(5), pytest.approx(180))
    assert parse_path("M0 0A0 5 0 0 1 10 0")[0] == (Line((0, 0), (10, 0)),)
    assert parse_path("M1 1A5 5 0 0 1 1 1")[0] == ()


@pytest.mark.parametrize(
    ("d", "found", "expected"),
    [
        ("10 10", "10 10", "a command (M)"),
        ("L10 10", "L", "M before anything else"),
        ("z", "z", "M before anything else"),
        ("M0 0L1", "L1", "2 numbers, or a multiple of them"),
        ("M0 0L", "L", "2 numbers, or a multiple of them"),
        ("M0 0L1 2 3", "L1 2 3", "2 numbers, or a multiple of them"),
        ("M0 0 X 5 5", "X", "a number"),
        ("M0 0l5 ..5", ".", "a number"),
        ("M0 0c1 1 2 2 3", "c1 1 2 2 3", "6 numbers, or a multiple of them"),
        ("M0 0z5", "5", "a command after Z"),
        ("M0 0A5 5 0 2 1 9 9", "A5 5 0 2 1 9 9", "two radii, a turn, two flags, a point"),
    ],
)
def test_what_is_no_path(d: str, found: str, expected: str) -> None:
    with pytest.raises(PathError) as error:
        parse_path(d)
    assert (error.value.found, error.value.expected) == (found, expected)
    reading = read(f'<rect width="1" height="1"/>\n<path id="p1" d="{d}"/>')
    assert reading.refused
    assert str(reading.diagnostics[0]) == (
        f"a.svg:3:p1: error svg-path: found {found!r} in path data, expected {expected}"
    )
    assert len(reading.parts[0].features) == 1


# --- shapes ---------------------------------------------------------------------------------------


def test_shapes() -> None:
    assert length_of('<line x1="1" y1="2" x2="4" y2="6"/>') == 5
    assert length_of('<polyline points="0,0 3,4 "/>') == 5
    assert length_of('<polygon points="0,0 3,0 3-4 0-4"/>') == 14
    assert length_of('<polygon points=""/><line x2="1"/>') == 1
    assert curves_of('<circle cx="50" cy="20" r="5"/>') == (Arc((50, 80), 5, 0, -360),)
    (ellipse,) = curves_of('<ellipse cx="50" cy="20" rx="3" ry="5"/>')
    assert isinstance(ellipse, EllipseArc)
    assert ellipse.bbox == pytest.approx((47, 75, 53, 85))


def test_rectangles() -> None:
    assert length_of('<rect width="10" height="5"/>') == 30
    assert codes('<rect width="0" height="5"/><line x2="1"/>') == ["svg-empty-curves"]
    rounded = curves_of('<rect x="10" y="10" width="20" height="10" rx="2"/>')
    assert [type(c) for c in rounded] == [Line, Arc] * 4
    assert length_of('<rect width="20" height="10" ry="2"/>') == pytest.approx(60 - 16 + 4 * pi)
    pill = curves_of('<rect width="20" height="10" rx="50" ry="50"/>')
    assert pill[0].start == pytest.approx((10, 100))
    assert {type(c) for c in pill} == {EllipseArc}
    assert length_of('<rect width="10" height="10" rx="99"/>') == pytest.approx(10 * pi)
    assert read('<rect width="20" height="10" rx="2"/>').parts[0].features[0].closed


@pytest.mark.parametrize(
    ("body", "box"),
    [
        ('<rect width="10%" height="20%"/>', (0, 80, 10, 100)),
        ('<rect width="1in" height="10mm"/>', (0, 0, 96, 960 / 25.4)),
        ('<circle cx="50%" cy="50%" r="10%"/>', (40, 40, 60, 60)),
    ],
)
def test_lengths_with_units_inside(body: str, box: tuple[float, ...]) -> None:
    if "in" in body.split()[1]:  # units inside count 96 to an inch, here in a page of px
        found = box_of(body, 'width="100" height="100"', units="mm")
        assert (found[2] - found[0], found[3] - found[1]) == pytest.approx((box[2], box[3]))
    else:
        assert box_of(body) == pytest.approx(box)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ('<circle r="five"/>', "found r='five', expected a length"),
        ('<circle r="5em"/>', "found r='5em', expected a number or a length in mm, cm, in"),
        ('<rect width="-1" height="1"/>', "found width='-1', expected a length that is not neg"),
        ('<rect width="1" height="1" rx="-1"/>', "found rx='-1', expected a length that is not"),
        ('<polyline points="0 0 1"/>', "found points='0 0 1', expected pairs of numbers"),
        ('<polyline points="0 0 a b"/>', "found points='0 0 a b', expected numbers"),
        ('<svg width="5" height="5" viewBox="0 0"/>', "found viewBox='0 0', expected four numbers"),
        ('<svg width="5" height="5" viewBox="0 0 0 1"/>', "found viewBox='0 0 0 1', expected a wi"),
        (
            '<polyline points="0 0 inf 5"/>',
            "found points='0 0 inf 5', expected numbers of at most 1e+09",
        ),
        ('<use href="#a" x="far"/><line id="a"/>', "found x='far', expected a length"),
    ],
)
def test_numbers_that_are_none(body: str, said: str) -> None:
    reading = read(body)
    assert reading.diagnostics[0].code == "svg-number"
    assert reading.diagnostics[0].message.startswith(said)
    assert reading.refused


# --- transforms -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "image"),
    [
        ("matrix(1 2 3 4 5 6)", (1 * 7 + 3 * 8 + 5, 2 * 7 + 4 * 8 + 6)),
        ("translate(1,2)", (8, 10)),
        ("translate(1)", (8, 8)),
        ("scale(2)", (14, 16)),
        ("scale(2 3)", (14, 24)),
        ("rotate(90)", (-8, 7)),
        ("rotate(90 7 0)", (-1, 0)),
        ("skewX(45)", (15, 8)),
        ("skewY(45)", (7, 15)),
        ("translate(1) scale(2)", (15, 16)),
        (" scale(2),translate(1 0) ", (16, 16)),
        ("matrix(9.67366E-015 -1 1 0 0 0)", (8, -7)),
        ("", (7, 8)),
    ],
)
def test_transforms(text: str, image: tuple[float, float]) -> None:
    assert mapped(parse_transform(text), (7, 8)) == pytest.approx(image)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("turn(5)", "one of matrix, translate, scale, rotate, skewX, skewY with numbers"),
        ("scale(1 2 3)", "1 or 2 numbers in scale()"),
        ("matrix(1 2 3)", "6 numbers in matrix()"),
        ("scale(2", "one of matrix"),
        ("scale(nan)", "numbers of at most 1e+09"),
        ("scale(a)", "could not convert string to float"),
    ],
)
def test_what_is_no_transform(text: str, expected: str) -> None:
    reading = read(f'<g transform="{text}"><rect width="1" height="1"/></g>')
    assert reading.diagnostics[0].code == "svg-transform"
    assert f"found transform {text!r}, expected {expected}" in reading.diagnostics[0].message


def test_a_matrix_that_is_no_similarity_shapes_what_it_holds() -> None:
    # A rectangle of 3 x 6 mm, as CorelDRAW writes it.
    matrix = "matrix(9.67E-015 -0.365 0.7305 1.9E-014 50 50)"
    body = f'<rect transform="{matrix}" width="8.2134" height="8.2134"/>'
    assert length_of(body) == pytest.approx(2 * (0.365 + 0.7305) * 8.2134)
    (round_,) = curves_of('<circle r="10" transform="matrix(1 0 0 .5 50 50)"/>')
    assert isinstance(round_, EllipseArc)
    assert round_.length == pytest.approx(48.44224110273838)


def test_groups_add_their_transforms() -> None:
    body = '<g transform="translate(50 50)"><g transform="rotate(45)"><line x2="10"/></g></g>'
    (line,) = curves_of(body)
    assert line.end == pytest.approx((50 + 10 * sqrt(0.5), 50 - 10 * sqrt(0.5)))


def test_a_matrix_that_flattens_is_said() -> None:
    body = '<circle r="5" transform="scale(1 0)"/><line x2="3"/>'
    assert codes(body) == ["svg-flattened"]
    assert length_of(body) == 3


NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


@given(st.text("0123456789.-+eE, \n", max_size=30))
def test_numbers_set_apart_are_those_that_the_grammar_finds(text: str) -> None:
    rest = NUMBER.sub(" ", text).strip(" \n,")
    found = [float(number) for number in NUMBER.findall(text)]
    try:
        assert _numbers("H", text) == found
        assert not rest
    except PathError:
        assert rest or not found or max(map(abs, found)) > 1e9  # no length to go


@pytest.mark.parametrize(
    ("text", "least", "most"),
    [("", 0, 0), ("1 2.5,3.125", 0, 3), ("1.25 7.123456 2.5", 1, 6), ("1.5", 4, 4), ("2.", 0, 0)],
)
def test_the_most_digits_behind_a_point(text: str, least: int, most: int) -> None:
    assert decimals(text, least) == most
