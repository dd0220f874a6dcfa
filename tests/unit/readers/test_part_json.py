"""The JSON form of parts as people write it, and what is said when they err."""

import json
from math import cos, pi, sin, sqrt

import pytest

from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line, NewtonCurve, signed_area
from beamcam.model import curve_json
from beamcam.model.part import Contour, Part, Profile
from beamcam.model.part_json import part_to_json, write
from beamcam.readers import part_json
from beamcam.readers.part_json import looks_like, read
from tests.conftest import rules_of

PROFILE = {"code": "B", "name": "PL10", "height": 200, "web_thickness": 10}


def part_with(**keys):
    return {"schema": "beamcam/part/1", "mark": "P1", "profile": PROFILE, "length": 300, **keys}


def read_value(value):
    return read(json.dumps(value).encode(), "part.json")


def curves_of(*curves, kind="open", face="v"):
    reading = read_value(part_with(contours=[{"kind": kind, "face": face, "curves": [*curves]}]))
    assert reading.diagnostics == (), reading.diagnostics
    (contour,) = reading.parts[0].contours
    return contour


def test_least_part():
    (part,) = read_value({"mark": "P1", "profile": PROFILE, "length": 300}).parts
    assert part == Part("P1", Profile("B", "PL10", 200, 0, 0, 10), 300, Source("part.json"))


def test_features_by_hand():
    value = part_with(
        holes=[{"x": 10, "y": 20, "diameter": 18}, {"x": 1, "y": 2, "diameter": 6, "depth": 4}],
        slots=[{"face": "v", "x": 100, "y": 50, "diameter": 18, "length": 30}],
        texts=[{"x": 5, "y": 5, "height": 10, "text": "P1"}],
        bends=[{"start": [0, 100], "end": [300, 100], "angle": 90}],
        planes=[
            {"name": "E1", "origin": [0, 0, 0], "along_x": [100, 0, 0], "along_y": [0, 100, 0]}
        ],
    )
    (part,) = read_value(value).parts
    a, b, slot, text, bend = part.features
    assert (a.face, a.kind, a.depth, b.kind, b.depth) == ("v", "through", None, "blind", 4)
    assert (slot.length, slot.height, slot.angle) == (30, 0, 0)
    assert (text.text, text.angle, bend.radius) == ("P1", 0, None)
    assert a.source == Source("part.json", None, "holes[0]")


def test_order_of_features_is_kept_by_their_number():
    value = part_with(
        holes=[{"x": 1, "y": 1, "diameter": 5, "feature": 1}, {"x": 9, "y": 9, "diameter": 5}],
        texts=[{"x": 5, "y": 5, "height": 10, "text": "first", "feature": 0}],
    )
    (part,) = read_value(value).parts
    assert [type(f).__name__ for f in part.features] == ["TextMark", "Hole", "Hole"]
    assert part.features[2].x == 9


def test_polygon_runs_as_its_kind_asks():
    square = {"polygon": [[0, 0], [0, 10], [10, 10], [10, 0]]}
    for kind, face, positive in (
        ("outer", "v", True),
        ("inner", "v", False),
        ("outer", "o", False),
        ("inner", "h", True),
    ):
        contour = curves_of(square, kind=kind, face=face)
        assert contour.closed
        assert len(contour.curves) == 4
        assert (signed_area(contour.curves) > 0) == positive


def test_circle():
    contour = curves_of({"circle": {"centre": [5, 6], "radius": 2}}, kind="inner")
    assert contour.curves == (Arc((5, 6), 2, 360, -360),)
    assert contour.closed


def test_tangent_arc():
    (left,) = curves_of(
        {"tangent_arc": {"from": [0, 0], "to": [10, 10], "radius": 10, "side": "left"}}
    ).curves
    (right,) = curves_of(
        {"tangent_arc": {"from": [0, 0], "to": [10, 10], "radius": 10, "side": "right"}}
    ).curves
    assert left.centre == pytest.approx((0, 10))
    assert left.sweep_deg == pytest.approx(90)
    assert right.centre == pytest.approx((10, 0))
    assert right.sweep_deg == pytest.approx(-90)


CURVES = (
    Line((0.1, 0.2), (1 / 3, 5.0)),
    Arc((0.0, 1e-7), 2.5, 30.0, -300.0),
    EllipseArc((1.0, 2.0), (3.0, 0.1), 0.3, 10.0, 90.0),
    Bezier(((0.0, 0.0), (1.0, 2.0), (3.0, 1 / 7))),
    Bezier(((0.0, 0.0), (1.0, 2.0), (3.0, 1.0)), (1.0, 0.5, 1.0)),
    BSpline(2, ((0.0, 0.0), (1.0, 2.0), (3.0, 1.0)), (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)),
    BSpline(1, ((0.0, 0.0), (1.0, 2.0), (3.0, 1.0)), (0.0, 0.0, 0.3, 1.0, 1.0), (1.0, 2.0, 0.1)),
    NewtonCurve(((0.0, 0.0), (1.0, 2.0), (2.0, 1.0))),
)


@pytest.mark.parametrize("curve", CURVES, ids=lambda curve: type(curve).__name__)
def test_curves_come_back_to_the_last_bit(curve):
    part = Part(
        "P1",
        Profile("B", "", 200, 0, 0, None),
        300,
        Source("a.dxf"),
        features=(
            Contour("v", "open", (curve,), Source("a.dxf", None, "2F"), closed=False, layer="0"),
        ),
    )
    assert read(write(part).encode(), "b.json").parts == (part,)


def test_sums():
    line = Line((0.0, 0.0), (100.0, 0.0))
    contours = tuple(
        Contour("v", "open", (curve,), Source("a"), closed=False)
        for curve in (line, line.reversed(), line, Line((0.0, 0.0), (0.0, 30.0)))
    )
    part = Part("", Profile("B", "", 1, 0, 0, None), 100, Source("a"), features=contours)
    value = part_to_json(part)
    assert value["path_length"] == 330
    assert value["duplicate_length"] == 200
    assert value["bbox"] == [0, 0, 100, 30]
    assert value["contours"][0]["length"] == 100
    assert value["contours"][3]["bbox"] == [0, 0, 0, 30]
    assert part_to_json(Part("", part.profile, 1, Source("a")))["bbox"] is None


def test_looks_like():
    assert looks_like(b'\xef\xbb\xbf {"schema": "beamcam/part/1"}')
    assert looks_like(json.dumps(part_with()).encode())
    assert not looks_like(b'{"type": "FeatureCollection"}')
    assert not looks_like(b"ST\nEN\n")


FLAWED = [
    (b"{", "json-syntax", 1, None),
    (b'{"mark": NaN}', "json-syntax", None, None),
    (b"\xff\xfe", "json-syntax", None, None),
    (b"[" * 100_000, "json-syntax", None, None),
    (b'{"mark": "a", "mark": "b"}', "json-key-twice", None, None),
    ([], "json-type", None, "$"),
    (part_with(schema="beamcam/part/9"), "json-schema", None, "schema"),
    ({"mark": "P1", "length": 3}, "json-key-missing", None, "profile"),
    (part_with(lenght=3), "json-key-unknown", None, "lenght"),
    (part_with(mark=5), "json-type", None, "mark"),
    (part_with(quantity=1.5), "json-type", None, "quantity"),
    (part_with(quantity=True), "json-type", None, "quantity"),
    (part_with(length=0), "json-value", None, "length"),
    (part_with(length=10**400), "json-value", None, "length"),
    (part_with(length="3"), "json-type", None, "length"),
    (part_with(profile={**PROFILE, "code": "Q"}), "json-value", None, "profile.code"),
    (part_with(profile={**PROFILE, "colour": 1}), "json-key-unknown", None, "profile.colour"),
    (part_with(holes={}), "json-type", None, "holes"),
    (part_with(holes=[{"x": 1, "y": 2}]), "json-key-missing", None, "holes[0].diameter"),
    (
        part_with(holes=[{"x": 1, "y": 2, "diameter": -1}]),
        *("json-value", None, "holes[0].diameter"),
    ),
    (
        part_with(holes=[{"face": "W", "x": 1, "y": 2, "diameter": 1}]),
        *("json-face", None, "holes[0].face"),
    ),
    (part_with(notes=[1]), "json-type", None, "notes[0]"),
    (part_with(info=[["a"]]), "json-type", None, "info[0]"),
    (part_with(tolerance=[1]), "json-type", None, "tolerance"),
    (part_with(contours=[{"kind": "open"}]), "json-value", None, "contours[0].curves"),
    (part_with(contours=[{"curves": []}]), "json-key-missing", None, "contours[0].kind"),
]


def flawed_curve(**curve):
    return part_with(contours=[{"kind": "open", "curves": [curve]}])


AT = "contours[0].curves[0]"
FLAWED_CURVES = [
    ({"lines": []}, "json-key-unknown", AT + ".lines"),
    ({}, "json-value", AT),
    ({"line": [[0, 0]]}, "json-value", AT + ".line"),
    ({"line": [[0, 0], [1, 1], [2, 2]]}, "json-value", AT + ".line"),
    ({"line": [[0, 0], [1, "a"]]}, "json-type", AT + ".line[1][1]"),
    ({"line": [[0, 0], [1]]}, "json-type", AT + ".line[1]"),
    ({"line": [[0, 0], [1, 1]], "newton": [[0, 0], [1, 1]]}, "json-key-unknown", AT + ".newton"),
    ({"bezier": {"points": [[0, 0], ["a", 1]]}}, "json-type", AT + ".bezier.points[1][0]"),
    ({"bezier": {"point": [[0, 0], [1, 1]]}}, "json-key-unknown", AT + ".bezier.point"),
    ({"bezier": [[0, 0], [1, "a"]]}, "json-type", AT + ".bezier[1][1]"),
    ({"function": {"x": "t", "y": "t", "t": [0, 1], "from": 0}}, "json-key-unknown",
     AT + ".function.from"),
    ({"function": {"y": "x", "x": "x", "from": 0, "to": 1}}, "json-key-missing",
     AT + ".function.t"),
    ({"function": {"y": "x", "from": 0, "to": "1e99"}}, "json-value", AT + ".function.to"),
    ({"polygon": [[0, 0], [1, 1]]}, "json-value", AT + ".polygon"),
    ({"circle": {"centre": [0, 0], "radius": 0}}, "json-value", AT + ".circle.radius"),
    (
        {"arc": {"centre": [0, 0], "radius": 1, "start": 0, "sweep": 0}},
        *("json-value", AT + ".arc.sweep"),
    ),
    (
        {"ellipse": {"centre": [0, 0], "axis": [0, 0], "ratio": 1}},
        *("json-value", AT + ".ellipse.axis"),
    ),
    (
        {"ellipse": {"centre": [0, 0], "axis": [1, 0], "ratio": 2}},
        *("json-value", AT + ".ellipse.ratio"),
    ),
    (
        {"tangent_arc": {"from": [0, 0], "to": [10, 0], "radius": 2, "side": "left"}},
        *("json-curve", AT + ".tangent_arc"),
    ),
    ({"tangent_circle": {"to": [{"line": [[0, 0], [9, 0]]}, {"line": [[0, 4], [9, 4]]}],
                         "radius": 2}},
     "json-no-tangent", AT + ".tangent_circle"),
    ({"tangent_circle": {"to": [{"line": [[0, 0], [9, 0]]}], "radius": 2}},
     "json-no-tangent", AT + ".tangent_circle"),
    ({"tangent_circle": {"to": [{"line": [[0, 0], [9, 0]]}, {"line": [[0, 0], [0, 9]]}],
                         "radius": 2}},
     "json-tangent-choice", AT + ".tangent_circle"),
    ({"tangent_circle": {"to": [{"line": [[0, 0], [9, 0]]}, {"line": [[0, 0], [0, 9]]}],
                         "radius": 2, "near": [0, 0]}},
     "json-tangent-choice", AT + ".tangent_circle"),
    ({"tangent_circle": {"to": [{"line": [[0, 0], [9, 0]]}, {"newton": [[0, 0], [0, 9]]}],
                         "radius": 2}},
     "json-key-unknown", AT + ".tangent_circle.to[1].newton"),
    ({"tangent_circle": {"to": [{"line": [[0, 0], [9, 0]]}, {}], "radius": 2}},
     "json-value", AT + ".tangent_circle.to[1]"),
    (
        {"tangent_arc": {"from": [0, 0], "to": [10, 0], "radius": 20, "side": "up"}},
        *("json-value", AT + ".tangent_arc.side"),
    ),
    (
        {"bspline": {"degree": 2, "control": [[0, 0], [1, 1], [2, 2]], "knots": [0, 1]}},
        *("json-curve", AT + ".bspline"),
    ),
    ({"newton": [[0, 0]]}, "json-value", AT + ".newton"),
    ({"newton": [[0, 0], [1, 1], [1, 1]]}, "json-curve", AT + ".newton"),
    ({"newton": [[0, 0], [1e8, 0], [1e8, 1e-9]]}, "json-curve", AT + ".newton"),
    ({"newton": [[x, x % 2] for x in range(30_000)]}, "json-curve", AT + ".newton"),
    ({"function": {"y": "x"}}, "json-key-missing", AT + ".function.from"),
    ({"function": {"y": "x", "from": 0}}, "json-key-missing", AT + ".function.to"),
    ({"function": {"from": 0, "to": 1}}, "json-key-missing", AT + ".function.y"),
    ({"function": {"y": 5, "from": 0, "to": 1}}, "json-type", AT + ".function.y"),
    ({"function": {"y": "x +", "from": 0, "to": 1}}, "json-expression", AT + ".function.y"),
    ({"function": {"y": "t", "from": 0, "to": 1}}, "json-expression", AT + ".function.y"),
    ({"function": {"y": "x", "from": "pi /", "to": 1}}, "json-expression", AT + ".function.from"),
    ({"function": {"y": "x", "from": 0, "to": "1 / 0"}}, "json-expression", AT + ".function.to"),
    ({"function": {"y": "x", "from": 0, "to": True}}, "json-type", AT + ".function.to"),
    ({"function": {"y": "x", "from": 0, "to": 1, "step": 1}}, "json-key-unknown",
     AT + ".function.step"),
    ({"function": {"y": "x", "from": 1, "to": 1}}, "json-expression", AT + ".function"),
    ({"function": {"y": "1 / x", "from": 0, "to": 1}}, "json-expression", AT + ".function"),
    ({"function": {"y": "x", "from": 0, "to": 1, "tolerance": 0}}, "json-value",
     AT + ".function.tolerance"),
    ({"function": {"y": "t", "t": [0, 1]}}, "json-key-missing", AT + ".function.x"),
    ({"function": {"x": "x", "y": "t", "t": [0, 1]}}, "json-expression", AT + ".function.x"),
    ({"function": {"x": "t", "y": "t", "t": [0]}}, "json-value", AT + ".function.t"),
    ({"function": {"x": "t", "y": "t", "t": [0, None]}}, "json-type", AT + ".function.t[1]"),
    ({"function": {"x": "1", "y": "2", "t": [0, 1]}}, "json-expression", AT + ".function"),
    ({"function": {"x": "(t - 1e308) * t", "y": "t", "t": [0, 1]}}, "json-expression",
     AT + ".function"),
]  # fmt: skip


@pytest.mark.parametrize(("value", "code", "line", "where"), FLAWED)
def test_flaws(value, code, line, where):
    reading = read(value, "p.json") if isinstance(value, bytes) else read_value(value)
    (diagnostic,) = reading.diagnostics
    assert (diagnostic.code, diagnostic.source.line, diagnostic.source.where) == (code, line, where)
    assert reading.parts == ()
    assert reading.refused


@pytest.mark.parametrize(("curve", "code", "where"), FLAWED_CURVES)
def test_flawed_curves(curve, code, where):
    (diagnostic,) = read_value(flawed_curve(**curve)).diagnostics
    assert (diagnostic.code, diagnostic.source.where) == (code, where)


def test_flawed_bevel():
    contour = {
        "kind": "open",
        "curves": [{"line": [[0, 0], [1, 1]]}],
        "bevels": [{"curve": 1, "angle": 30, "land": 0}],
    }
    (diagnostic,) = read_value(part_with(contours=[contour])).diagnostics
    assert str(diagnostic) == (
        "part.json:contours[0].bevels[0].curve: error json-index: "
        "found 1, expected the index of one of 1 curves"
    )


def test_unknown_key_names_the_nearest():
    (diagnostic,) = read_value(part_with(holes=[{"x": 1, "y": 1, "diamter": 5}])).diagnostics
    assert diagnostic.code == "json-key-unknown"
    assert diagnostic.message.endswith("nearest is 'diameter'")
    (diagnostic,) = read_value(
        part_with(holes=[{"x": 1, "y": 1, "diameter": 5, "dept": 3}])
    ).diagnostics
    assert "'dept'" in diagnostic.message
    assert diagnostic.message.endswith("nearest is 'depth'")


def test_every_code_is_met():
    met = {code for _, code, *_ in FLAWED} | {code for _, code, _ in FLAWED_CURVES}
    assert {rule.code for rule in rules_of(part_json, curve_json)} == met | {"json-index"}


LINE_X = {"line": [[0, 0], [10, 0]]}
LINE_Y = {"line": [[0, 0], [0, 10]]}
#: Two curves and a radius, or three; a point nearby; the centre and radius that follow by hand.
TANGENT_CIRCLES = [
    ([LINE_X, LINE_Y], 3, [9, 9], (3, 3, 3)),
    ([LINE_X, LINE_Y], 3, [-1, 9], (-3, 3, 3)),
    # 5 above the line and 5 outside a circle of 3 about (0, 10): 8^2 - 5^2 = 39 off to the side
    ([LINE_X, {"circle": {"centre": [0, 10], "radius": 3}}], 5, [7, 5], (sqrt(39), 5, 5)),
    # circles of 4 about (0, 0) and (6, 0), from outside with radius 1: centres 5 off both
    ([{"circle": {"centre": [0, 0], "radius": 4}},
      {"arc": {"centre": [6, 0], "radius": 4, "start": 10, "sweep": -40}}], 1, [3, 9], (3, 4, 1)),
    # the circle in a triangle of sides 3, 4 and 5, and the one outside its long side
    ([LINE_X, LINE_Y, {"line": [[4, 0], [0, 3]]}], None, [1, 1], (1, 1, 1)),
    ([LINE_X, LINE_Y, {"line": [[4, 0], [0, 3]]}], None, [5, 5], (6, 6, 6)),
    # the only one of its kind needs no point
    ([LINE_X, {"circle": {"centre": [0, 10], "radius": 2}}], 4, None, (0, 4, 4)),
]  # fmt: skip


@pytest.mark.parametrize(("touched", "radius", "near", "expected"), TANGENT_CIRCLES)
def test_tangent_circles(touched, radius, near, expected):
    said = {"to": touched, "radius": radius, "near": near}
    contour = curves_of({"tangent_circle": {k: v for k, v in said.items() if v}}, kind="inner")
    (circle,) = contour.curves
    assert (*circle.centre, circle.radius) == pytest.approx(expected)
    assert abs(circle.sweep_deg) == 360
    assert signed_area(contour.curves) < 0
    assert contour.closed


def test_all_tangent_circles_are_named():
    curve = {"tangent_circle": {"to": [LINE_X, LINE_Y], "radius": 2}}
    (diagnostic,) = read_value(flawed_curve(**curve)).diagnostics
    assert diagnostic.message.startswith(
        "found 4 circles that touch, (-2.000, -2.000) radius 2.000, (-2.000, 2.000) radius 2.000, "
        "(2.000, -2.000) radius 2.000, (2.000, 2.000) radius 2.000; expected `near`"
    )


#: Curves that no circle touches, or endlessly many, and what the message calls the case.
DEGENERATE = [
    ([LINE_X, {"line": [[20, 0], [30, 0]]}], 2, "the same line twice"),
    ([LINE_X, {"line": [[0, 4], [1, 4]]}], 2, "parallel lines a diameter apart"),
    ([LINE_X, {"line": [[0, 4], [1, 4]]}], 3, "parallel lines, between which no circle of"),
    ([LINE_X, {"line": [[5, 5], [5, 5]]}], 3, "a line without a length"),
    ([{"circle": {"centre": [0, 0], "radius": r}} for r in (2, 2)], 1, "the same circle twice"),
    ([{"circle": {"centre": [0, 0], "radius": r}} for r in (2, 4)], 1, "with endlessly many betw"),
    ([{"circle": {"centre": [0, 0], "radius": r}} for r in (2, 4)], 9, "concentric circles, betw"),
    ([LINE_X, {"circle": {"centre": [0, 90], "radius": 2}}], 5, "too far apart"),
    ([LINE_X, {"line": [[0, 4], [1, 4]]}, {"line": [[0, 9], [1, 9]]}], None, "parallel lines, be"),
    ([LINE_X, LINE_Y, {"line": [[0, 0], [1, 9]]}], None, "three lines through one point"),
    ([{"circle": {"centre": [0, 0], "radius": r}} for r in (1, 2, 4)], None, "concentric circles"),
    ([LINE_X, *({"circle": {"centre": [0, r], "radius": r}} for r in (1, 2))], None,
     "at one point"),
    ([{"circle": {"centre": [0, 0], "radius": r}} for r in (1, 9)] + [{"line": [[30, 0], [30, 1]]}],
     None, "within or across each other"),
    ([LINE_X, LINE_Y], None, "2 curves without a radius, where there have to be 3"),
    ([LINE_X, LINE_Y, LINE_X], 2, "3 curves with a radius, where there have to be 2"),
]  # fmt: skip


@pytest.mark.parametrize(("touched", "radius", "name"), DEGENERATE)
def test_degenerate_tangents_are_refused_by_name(touched, radius, name):
    said = {"to": touched} if radius is None else {"to": touched, "radius": radius}
    (diagnostic,) = read_value(flawed_curve(tangent_circle=said)).diagnostics
    assert diagnostic.code == "json-no-tangent"
    assert name in diagnostic.message


def test_a_function_is_followed():
    (contour,) = (
        read_value(flawed_curve(function={"y": "20 + 5 * sin(x / 10)", "from": 0, "to": "20 * pi"}))
        .parts[0]
        .contours
    )
    assert contour.curves[0].start == (0, 20)
    assert contour.curves[-1].end == pytest.approx((20 * pi, 20))
    for curve in contour.curves:
        for k in range(11):
            x, y = curve.point(k / 10)
            assert y == pytest.approx(20 + 5 * sin(x / 10), abs=5e-4)


def test_a_coarse_function_has_fewer_curves():
    fine = curves_of({"function": {"y": "9 * sin(x)", "from": 0, "to": 9}})
    coarse = curves_of({"function": {"y": "9 * sin(x)", "from": 0, "to": 9, "tolerance": 0.1}})
    assert len(coarse.curves) < len(fine.curves)


#: The flank of a gear with a base circle of 20 mm.
INVOLUTE = {
    "x": "20 * (cos(t) + t * sin(t))", "y": "20 * (sin(t) - t * cos(t))", "t": [0.2, 1],
}  # fmt: skip


def test_the_flank_of_a_gear():
    contour = curves_of({"function": INVOLUTE})
    for curve in contour.curves:
        for k in range(11):
            x, y = curve.point(k / 10)
            # Where r is the distance to the centre, t^2 = (r / 20)^2 - 1 on an involute.
            t = sqrt((x * x + y * y) / 400 - 1)
            assert x == pytest.approx(20 * (cos(t) + t * sin(t)), abs=1e-3)
            assert y == pytest.approx(20 * (sin(t) - t * cos(t)), abs=1e-3)


def test_a_closed_way_runs_as_its_kind_asks():
    way = {"x": "9 * cos(t)", "y": "4 * sin(t)", "t": [0, "2 * pi"]}
    for kind, positive in (("outer", True), ("inner", False)):
        contour = curves_of({"function": way}, kind=kind)
        assert contour.closed
        assert (signed_area(contour.curves) > 0) == positive
        assert abs(signed_area(contour.curves)) == pytest.approx(36 * pi, rel=1e-4)


def test_half_a_character_is_replaced_wherever_it_is():
    data = json.dumps(part_with(notes=["a\ud800b"], grade="\ud83d\ude00")).encode()
    (part,) = read(data, "p.json").parts
    assert part.notes == ("a\ufffdb",)
    assert part.grade == "\U0001f600"
    (said,) = read(data.replace(b'"notes"', b'"\\ud800"'), "p.json").diagnostics
    assert said.code == "json-key-unknown"


def test_what_a_function_became_is_kept_to_the_last_bit():
    (part,) = read_value(flawed_curve(function=INVOLUTE)).parts
    (again,) = read(write(part).encode(), "part.json").parts
    assert [c.curves for c in again.contours] == [c.curves for c in part.contours]


def test_the_message_of_an_expression():
    (said,) = read_value(flawed_curve(function={"y": "sinus(x)", "from": 0, "to": 1})).diagnostics
    assert str(said).startswith(
        "part.json:contours[0].curves[0].function.y: error json-expression: found 'sinus(x)' is "
        "not understood; names known here: x, expected arithmetic of x: numbers, pi, e, + - * / ^"
    )
    (said,) = read_value(flawed_curve(function={"y": "log(x)", "from": 0, "to": 1})).diagnostics
    assert said.message == (
        "found 'log(x)' has no value at x = 0: math domain error, expected a smooth curve from end "
        "to end"
    )


def test_a_polynomial_that_swings_is_told():
    runge = [[x * 10, 20 / (1 + x * x)] for x in range(-5, 6)]
    reading = read_value(flawed_curve(newton=runge))
    (said,) = reading.diagnostics
    assert said.severity.value == "warning"
    assert str(said) == (
        "part.json:contours[0]: warning polynomial-oscillates: found that the polynomial through "
        "11 nodes leaves them by 38.003 near (-47.004, 39.179); expected at most 5 nodes"
    )
    assert len(reading.parts) == 1
    assert read_value(flawed_curve(newton=runge[::3])).diagnostics == ()


def test_a_polynomial_whose_digits_are_lost_is_refused():
    zigzag = [[x, (-1) ** x] for x in range(26)]
    (said,) = read_value(flawed_curve(newton=zigzag)).diagnostics
    assert said.code == "polynomial-lost"
    assert said.message.startswith("found a polynomial through 26 nodes that misses them by ")
    assert said.message.endswith("expected at most 1e-06 mm; take fewer nodes")
