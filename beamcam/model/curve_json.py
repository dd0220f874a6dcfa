"""The JSON form of curves: each an object of one key that says what it is.

As written: `{"line": [[x0, y0], [x1, y1]]}`, `{"arc": {"centre", "radius", "start", "sweep"}}`,
`{"ellipse": {"centre", "axis", "ratio", "start", "sweep"}}`, `{"bezier": [[x, y], ...]}` (with
weights `{"bezier": {"points", "weights"}}`), `{"bspline": {"degree", "control", "knots",
"weights"}}`, `{"newton": [[x, y], ...]}`. By hand also `{"polygon": [[x, y], ...]}`, `{"circle":
{"centre", "radius"}}` and `{"tangent_arc": {"from", "to", "radius", "side"}}`: the arc of at most
180 degrees through two tangency points, its centre left or right of the way from one to the other.

A formula is `{"function": {"y": "20 + 5 * sin(x / 10)", "from": 0, "to": 62.8}}`, a graph, or
`{"function": {"x": "30 * cos(t)", "y": "30 * sin(t)", "t": [0, "2 * pi"]}}`, a way.
"""

from typing import Any

from beamcam.errors import ReadError, Rule, Severity
from beamcam.geometry.curves import (
    Arc,
    Bezier,
    BSpline,
    Curve,
    EllipseArc,
    Line,
    NewtonCurve,
    arc_through,
)
from beamcam.geometry.newton import newton_through
from beamcam.model.function_json import curves_of_text
from beamcam.model.json_object import JSON_VALUE, JsonObject, show

CURVE_KINDS = (
    *("line", "arc", "ellipse", "bezier", "bspline", "newton"),
    *("polygon", "circle", "tangent_arc", "function"),
)

JSON_CURVE = Rule(
    "json-curve",
    Severity.ERROR,
    "found a {kind} without a shape ({found}); expected values that agree with each other",
    "The values of a curve contradict each other, so its shape is not known.",
)


def curve_to_json(curve: Curve) -> dict[str, Any]:
    """The JSON form of a curve."""
    match curve:
        case Line():
            return {"line": [list(curve.start), list(curve.end)]}
        case Arc():
            return {
                "arc": {
                    "centre": list(curve.centre),
                    "radius": curve.radius,
                    "start": curve.start_deg,
                    "sweep": curve.sweep_deg,
                }
            }
        case EllipseArc():
            return {
                "ellipse": {
                    "centre": list(curve.centre),
                    "axis": list(curve.axis),
                    "ratio": curve.ratio,
                    "start": curve.start_deg,
                    "sweep": curve.sweep_deg,
                }
            }
        case Bezier():
            points = _lists(curve.points)
            if curve.weights is None:
                return {"bezier": points}
            return {"bezier": {"points": points, "weights": list(curve.weights)}}
        case BSpline():
            weights = None if curve.weights is None else list(curve.weights)
            return {
                "bspline": {
                    "degree": curve.degree,
                    "control": _lists(curve.control),
                    "knots": list(curve.knots),
                    "weights": weights,
                }
            }
        case NewtonCurve():
            return {"newton": _lists(curve.nodes)}


def _lists(points: tuple[tuple[float, float], ...]) -> list[list[float]]:
    return [list(point) for point in points]


def curves_from_json(item: JsonObject) -> tuple[Curve, ...]:
    """The curve of one object, or those of a polygon or a function. Raises ReadError."""
    kind = next((key for key in CURVE_KINDS if key in item), None)
    if kind is None:
        expected = "one of " + " ".join(CURVE_KINDS)
        item.ignore(CURVE_KINDS)
        item.finish()  # a misspelt key has a better message
        raise item.fault(JSON_VALUE, "", found="no curve", expected=expected)
    if kind == "polygon":
        points = item.points(kind, 3)
        if points[0] == points[-1]:
            points = points[:-1]
        return tuple(map(Line, points, (*points[1:], points[0])))
    if kind == "function":
        return curves_of_text(item.child(kind))
    try:
        return (_curve(item, kind),)
    except ReadError:
        raise
    except ValueError as error:
        raise item.fault(JSON_CURVE, kind, kind=kind, found=error) from None


def _curve(item: JsonObject, kind: str) -> Curve:
    """The curve under the key `kind`. Raises ReadError, or ValueError of the curve's own."""
    if kind == "line":
        points = item.points(kind)
        if len(points) != 2:
            raise item.fault(JSON_VALUE, kind, found=f"{len(points)} points", expected="2 points")
        return Line(*points)
    if kind == "newton":
        return newton_through(item.points(kind))
    if kind == "bezier" and isinstance(item.raw(kind), list):
        return Bezier(item.points(kind))
    fields = item.child(kind)
    curve = _curve_of_fields(fields, kind)
    fields.finish()
    return curve


def _curve_of_fields(fields: JsonObject, kind: str) -> Curve:
    match kind:
        case "bezier":
            return Bezier(fields.points("points"), _weights(fields))
        case "bspline":
            degree, control = fields.integer("degree"), fields.points("control")
            return BSpline(degree, control, fields.numbers("knots"), _weights(fields))
        case "tangent_arc":
            start, end = fields.point("from"), fields.point("to")
            radius = fields.positive("radius")
            left = fields.choice("side", ("left", "right")) == "left"
            return arc_through(start, end, radius if left else -radius)
        case "circle":
            return Arc(fields.point("centre"), fields.positive("radius"), 0.0, 360.0)
    centre = fields.point("centre")
    if kind == "arc":
        radius = fields.positive("radius")
        return Arc(centre, radius, fields.number("start"), _sweep(fields))
    axis, ratio = fields.point("axis"), fields.positive("ratio")
    if axis == (0.0, 0.0):
        raise fields.fault(JSON_VALUE, "axis", found=show(axis), expected="an axis of some length")
    if ratio > 1:
        raise fields.fault(JSON_VALUE, "ratio", found=show(ratio), expected="a number up to 1")
    return EllipseArc(centre, axis, ratio, fields.number("start", 0.0), _sweep(fields, 360.0))


def _sweep(fields: JsonObject, default: float | None = None) -> float:
    sweep = fields.number("sweep", default)
    if sweep == 0 or abs(sweep) > 360:
        expected = "an angle from -360 to 360 that is not 0"
        raise fields.fault(JSON_VALUE, "sweep", found=show(sweep), expected=expected)
    return sweep


def _weights(fields: JsonObject) -> tuple[float, ...] | None:
    return None if fields.raw("weights") is None else fields.numbers("weights")
