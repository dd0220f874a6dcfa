"""The JSON form of curves: each an object of one key that says what it is.

As written: `{"line": [[x0, y0], [x1, y1]]}`, `{"arc": {"centre", "radius", "start", "sweep"}}`,
`{"ellipse": {"centre", "axis", "ratio", "start", "sweep"}}`, `{"bezier": [[x, y], ...]}` (with
weights `{"bezier": {"points", "weights"}}`), `{"bspline": {"degree", "control", "knots",
"weights"}}`, `{"newton": [[x, y], ...]}`. By hand also `{"polygon": [[x, y], ...]}`, `{"circle":
{"centre", "radius"}}` and `{"tangent_arc": {"from", "to", "radius", "side"}}`: the arc of at most
180 degrees through two tangency points, its centre left or right of the way from one to the other.
`{"tangent_circle": {"to": [curve, curve], "radius", "near": [x, y]}}` is the circle that touches
two curves, and without a radius the one that touches three.

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
from beamcam.geometry.tangent_circles import (
    Circle,
    NoTangentCircle,
    nearest_circle,
    tangent_circles,
)
from beamcam.model.function_json import curves_of_function_form
from beamcam.model.json_object import JSON_KEY_UNKNOWN, Place
from beamcam.model.part_forms import (
    ArcForm,
    BezierForm,
    CircleForm,
    CurveForm,
    EllipseForm,
    SplineForm,
    TangentCircleForm,
    TangentForm,
    TouchedForm,
)

JSON_CURVE = Rule(
    "json-curve",
    Severity.ERROR,
    "found a {kind} without a shape ({found}); expected values that agree with each other",
    "The values of a curve contradict each other, so its shape is not known.",
)
JSON_NO_TANGENT = Rule(
    "json-no-tangent",
    Severity.ERROR,
    "found {found}; expected curves that a circle touches",
    "No circle touches the curves, or endlessly many do, so none is meant.",
)
JSON_TANGENT_CHOICE = Rule(
    "json-tangent-choice",
    Severity.ERROR,
    "found {count} circles that touch, {circles}; expected `near`, a point whose nearest centre is "
    "the one that is meant",
    "Which of several circles is meant only the drawing knows.",
)
CURVE_RULES = (JSON_CURVE, JSON_NO_TANGENT, JSON_TANGENT_CHOICE)


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


def curves_of(form: CurveForm, place: Place) -> tuple[Curve, ...]:
    """The curve of one object, or those of a polygon or a function. Raises ReadError."""
    kinds = [kind for kind in form.__struct_fields__ if getattr(form, kind) is not None]
    if not kinds:
        raise place.wrong("no curve", "one of " + " ".join(form.__struct_fields__))
    if len(kinds) > 1:
        raise place.at(kinds[1]).fault(
            JSON_KEY_UNKNOWN, key=kinds[1], expected=f"{kinds[0]} alone", nearest=kinds[0]
        )
    place = place.at(kinds[0])
    if form.polygon is not None:
        points = form.polygon[:-1] if form.polygon[0] == form.polygon[-1] else form.polygon
        return tuple(map(Line, points, (*points[1:], points[0])))
    if form.function is not None:
        return curves_of_function_form(form.function, place)
    try:
        return (_curve(form, place),)
    except ReadError:
        raise
    except ValueError as error:
        raise place.fault(JSON_CURVE, kind=kinds[0], found=error) from None


def _curve(form: CurveForm, place: Place) -> Curve:
    """The curve of a form. Raises ReadError, or ValueError of the curve's own."""
    match form:
        case CurveForm(line=tuple(points)):
            if len(points) != 2:
                raise place.wrong(f"{len(points)} points", "2 points")
            return Line(*points)
        case CurveForm(arc=ArcForm() as arc):
            return Arc(arc.centre, arc.radius, arc.start, _sweep(arc.sweep, place))
        case CurveForm(ellipse=EllipseForm() as ellipse):
            if ellipse.axis == (0.0, 0.0):
                raise place.at("axis").wrong(ellipse.axis, "an axis of some length")
            sweep = _sweep(ellipse.sweep, place)
            return EllipseArc(ellipse.centre, ellipse.axis, ellipse.ratio, ellipse.start, sweep)
        case CurveForm(bezier=BezierForm() as bezier):
            return Bezier(bezier.points, bezier.weights)
        case CurveForm(bezier=tuple(points)):
            return Bezier(points)
        case CurveForm(bspline=SplineForm() as spline):
            return BSpline(spline.degree, spline.control, spline.knots, spline.weights)
        case CurveForm(newton=tuple(nodes)):
            return newton_through(nodes)
        case CurveForm(circle=CircleForm() as circle):
            return Arc(circle.centre, circle.radius, 0.0, 360.0)
        case CurveForm(tangent_arc=TangentForm() as tangent):
            radius = tangent.radius if tangent.side == "left" else -tangent.radius
            return arc_through(tangent.start, tangent.end, radius)
        case CurveForm(tangent_circle=TangentCircleForm() as tangents):
            touching = _tangent_circle(tangents, place)
            return Arc(touching.centre, touching.radius, 0.0, 360.0)
    raise AssertionError("a form of one kind")


def _tangent_circle(form: TangentCircleForm, place: Place) -> Circle:
    """The circle that is meant of those that touch."""
    touched = [_touched(one, place.at("to", k)) for k, one in enumerate(form.to)]
    try:
        found = tangent_circles(touched, form.radius)
    except NoTangentCircle as error:
        raise place.fault(JSON_NO_TANGENT, found=error) from None
    if form.near is None and len(found) == 1:
        return found[0]
    chosen = None if form.near is None else nearest_circle(found, form.near)
    if chosen is None:
        circles = ", ".join(
            f"({c.centre[0]:.3f}, {c.centre[1]:.3f}) radius {c.radius:.3f}" for c in found
        )
        raise place.fault(JSON_TANGENT_CHOICE, count=len(found), circles=circles)
    return chosen


def _touched(form: TouchedForm, place: Place) -> Line | Arc:
    """The curve that a circle touches."""
    same = CurveForm(line=form.line, arc=form.arc, circle=form.circle)
    (curve,) = curves_of(same, place)
    assert isinstance(curve, Line | Arc)
    return curve


def _sweep(sweep: float, place: Place) -> float:
    if sweep == 0:
        raise place.at("sweep").wrong(sweep, "an angle from -360 to 360 that is not 0")
    return sweep
