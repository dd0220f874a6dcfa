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

from typing import Any, TypeVar

from msgspec import Struct

from beamcam.conversion import FUNCTIONS, Fault, compile_expression, converted, shown
from beamcam.errors import Diagnostic, ReadError, Rule, Source, error
from beamcam.geometry.approximation import curves_of_function, curves_of_way
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
from beamcam.model.part import MAX_NUMBER
from beamcam.model.part_forms import (
    ArcForm,
    BezierForm,
    CircleForm,
    CurveForm,
    EllipseForm,
    FunctionForm,
    SplineForm,
    TangentCircleForm,
    TangentForm,
)

Record = TypeVar("Record")

JSON_TYPE = error("json-type",
    "found {found}, expected {expected}",
    "A value is of another type than its key has.")  # fmt: skip
JSON_VALUE = error(
    "json-value", "found {found}, expected {expected}", "A value lies outside what its key allows."
)
JSON_KEY_MISSING = error("json-key-missing",
    "found no key {key!r}, expected {expected}",
    "Without the key the part is not known.")  # fmt: skip
JSON_KEY_UNKNOWN = error("json-key-unknown",
    "found key {key!r}, expected one of {expected}; nearest is {nearest!r}",
    "An unknown key could be a feature that would not be made, so it is refused.")  # fmt: skip

_SHOWN = 60  #: characters of a value that a message shows


def show(value: object) -> str:
    """`value` for a message, cut to a length that can be read."""
    text = shown(value)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


class JsonPlace(Struct, frozen=True):
    """A value of a file, for messages: its path is as `contours[2].curves[0].arc.radius`."""

    file: str
    path: str = ""

    def at(self, *steps: str | int) -> "JsonPlace":
        """The place of a key or index below."""
        path = self.path
        for step in steps:
            path += f"[{step}]" if isinstance(step, int) else f".{step}" if path else step
        return JsonPlace(self.file, path)

    def diagnostic(self, rule: Rule, /, **values: object) -> Diagnostic:
        return rule.at(Source(self.file, None, self.path or "$"), **values)

    def fault(self, rule: Rule, /, **values: object) -> ReadError:
        return ReadError(self.diagnostic(rule, **values))

    def wrong(self, found: object, expected: str) -> ReadError:
        """Message for a value out of the range of its key."""
        return self.fault(JSON_VALUE, found=show(found), expected=expected)


def record_of(value: object, record: type[Record], place: JsonPlace) -> Record:
    """The record for a value of `json.loads`. Raises ReadError at the key that is wrong."""
    try:
        return converted(value, record)
    except Fault as fault:
        raise ReadError(_diagnostic_of(fault, place.at(*fault.path))) from None


def _diagnostic_of(fault: Fault, place: JsonPlace) -> Diagnostic:
    if fault.kind == "missing":
        return place.diagnostic(JSON_KEY_MISSING, key=fault.path[-1], expected="it, it is required")
    if fault.kind == "unknown":
        from difflib import get_close_matches

        (nearest,) = get_close_matches(str(fault.found), fault.known, 1, 0.0)
        expected = ", ".join(fault.known)
        return place.diagnostic(
            JSON_KEY_UNKNOWN, key=fault.found, expected=expected, nearest=nearest
        )
    rule = JSON_TYPE if fault.kind == "type" else JSON_VALUE
    expected = _JSON_WORDS.get(fault.expected, fault.expected)
    return place.diagnostic(rule, found=show(fault.found), expected=expected)


_JSON_WORDS = {"a table": "an object {...}", "a list": "a list [...]"}


# --- function json --------------------------------------------------------------------------------

# Functions in the JSON form of a part: cams, gears, anything with a formula.
#
# `{"y": "20 + 5 * sin(x / 10)", "from": 0, "to": 62.8}` is the graph of a function of x, and
# `{"x": "30 * cos(t)", "y": "30 * sin(t)", "t": [0, "2 * pi"]}` the way of a point. The ends are
# numbers or arithmetic; `tolerance`, in mm, is how near the curves have to stay. Angles are
# radians.
#
# A part keeps the curves and not the text, so it is written as polynomials through nodes or as
# Bezier curves, to the last bit.


#: Distance in mm that the curves of a function may have from it, where the file does not say.
FUNCTION_TOLERANCE = 0.001

JSON_EXPRESSION = error("json-expression",
    "found {found}, expected {expected}",
    "The curve is the value of the expression at every place between its ends.")  # fmt: skip


def curves_of_function_form(form: FunctionForm, place: JsonPlace) -> tuple[Curve, ...]:
    """The curves of a function. Raises ReadError at the key that is wrong."""
    tolerance = FUNCTION_TOLERANCE if form.tolerance is None else form.tolerance
    try:
        if form.t is not None:
            if form.x is None:
                raise place.at("x").fault(JSON_KEY_MISSING, key="x", expected="x of t")
            for key, end in (("from", form.low), ("to", form.high)):
                if end is not None:
                    raise place.at(key).fault(
                        JSON_KEY_UNKNOWN, key=key, expected="x, y, t, tolerance", nearest="t"
                    )
            x, y = _arithmetic(form.x, "t", place.at("x")), _arithmetic(form.y, "t", place.at("y"))
            both = form.t or ()
            if len(both) != 2:
                raise place.at("t").wrong(f"{len(both)} values", "two ends [from, to]")
            low, high = (_number(end, place.at("t", k)) for k, end in enumerate(both))
            fit = curves_of_way(x, y, low, high, tolerance)
        elif form.x is not None:
            raise place.at("t").fault(JSON_KEY_MISSING, key="t", expected="both ends of a way")
        else:
            y, ends = _arithmetic(form.y, "x", place.at("y")), []
            for key, end in (("from", form.low), ("to", form.high)):
                if end is None:
                    expected = "an end of the graph"
                    raise place.at(key).fault(JSON_KEY_MISSING, key=key, expected=expected)
                ends.append(_number(end, place.at(key)))
            fit = curves_of_function(y, ends[0], ends[1], tolerance)
    except ReadError:
        raise
    except ValueError as error:
        raise place.fault(
            JSON_EXPRESSION, found=error, expected="a smooth curve from end to end"
        ) from None
    return fit.curves


def _arithmetic(text: str, variable: str, place: JsonPlace) -> str:
    try:
        compile_expression(text, (variable,))
    except ValueError as error:
        functions = " ".join(sorted(FUNCTIONS))
        expected = f"arithmetic of {variable}: numbers, pi, e, + - * / ^, parentheses, {functions}"
        raise place.fault(JSON_EXPRESSION, found=error, expected=expected) from None
    return text


def _number(value: float | str, place: JsonPlace) -> float:
    """A number, or arithmetic without a variable such as "2 * pi"."""
    if not isinstance(value, str):
        return value
    try:
        number = compile_expression(value, ())({})
    except (ArithmeticError, ValueError) as error:
        expected = 'arithmetic of numbers such as "2 * pi"'
        raise place.fault(JSON_EXPRESSION, found=error, expected=expected) from None
    if not abs(number) <= MAX_NUMBER:  # nan is above all
        raise place.wrong(number, f"a number between -{MAX_NUMBER:g} and {MAX_NUMBER:g}")
    return number


JSON_CURVE = error("json-curve",
    "found a {kind} without a shape ({found}); expected values that agree with each other",
    "The values of a curve contradict each other, so its shape is not known.")  # fmt: skip
JSON_NO_TANGENT = error("json-no-tangent",
    "found {found}; expected curves that a circle touches",
    "No circle touches the curves, or endlessly many do, so none is meant.")  # fmt: skip
JSON_TANGENT_CHOICE = error("json-tangent-choice",
    "found {count} circles that touch, {circles}; expected `near`, a point whose nearest centre is "
    "the one that is meant",
    "Which of several circles is meant only the drawing knows.")  # fmt: skip


def curve_to_json(curve: Curve) -> dict[str, Any]:
    """The JSON form of a curve."""
    match curve:
        case Line():
            return {"line": [list(curve.start), list(curve.end)]}
        case Arc():
            return {"arc": {
                "centre": list(curve.centre), "radius": curve.radius, "start": curve.start_deg,
                "sweep": curve.sweep_deg,
            }}  # fmt: skip
        case EllipseArc():
            return {"ellipse": {
                "centre": list(curve.centre), "axis": list(curve.axis), "ratio": curve.ratio,
                "start": curve.start_deg, "sweep": curve.sweep_deg,
            }}  # fmt: skip
        case Bezier():
            points = _lists(curve.points)
            if curve.weights is None:
                return {"bezier": points}
            return {"bezier": {"points": points, "weights": list(curve.weights)}}
        case BSpline():
            weights = None if curve.weights is None else list(curve.weights)
            return {"bspline": {
                "degree": curve.degree, "control": _lists(curve.control),
                "knots": list(curve.knots), "weights": weights,
            }}  # fmt: skip
        case NewtonCurve():
            return {"newton": _lists(curve.nodes)}


def _lists(points: tuple[tuple[float, float], ...]) -> list[list[float]]:
    return [list(point) for point in points]


def curves_of(form: CurveForm, place: JsonPlace) -> tuple[Curve, ...]:
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


def _curve(form: CurveForm, place: JsonPlace) -> Curve:
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


def _tangent_circle(form: TangentCircleForm, place: JsonPlace) -> Circle:
    """The circle that is meant of those that touch."""
    touched: list[Line | Arc] = []
    for k, one in enumerate(form.to):
        same = CurveForm(line=one.line, arc=one.arc, circle=one.circle)
        (curve,) = curves_of(same, place.at("to", k))
        assert isinstance(curve, Line | Arc)
        touched.append(curve)
    try:
        circles = tangent_circles(touched, form.radius)
    except NoTangentCircle as error:
        raise place.fault(JSON_NO_TANGENT, found=error) from None
    if form.near is None and len(circles) == 1:
        return circles[0]
    chosen = None if form.near is None else nearest_circle(circles, form.near)
    if chosen is None:
        shown = (f"({c.centre[0]:.3f}, {c.centre[1]:.3f}) radius {c.radius:.3f}" for c in circles)
        raise place.fault(JSON_TANGENT_CHOICE, count=len(circles), circles=", ".join(shown))
    return chosen


def _sweep(sweep: float, place: JsonPlace) -> float:
    if sweep == 0:
        raise place.at("sweep").wrong(sweep, "an angle from -360 to 360 that is not 0")
    return sweep
