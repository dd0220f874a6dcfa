"""Functions in the JSON form of a part: cams, gears, anything with a formula.

`{"y": "20 + 5 * sin(x / 10)", "from": 0, "to": 62.8}` is the graph of a function of x, and
`{"x": "30 * cos(t)", "y": "30 * sin(t)", "t": [0, "2 * pi"]}` the way of a point. The ends are
numbers or arithmetic; `tolerance`, in mm, is how near the curves have to stay. Angles are radians.

A part keeps the curves and not the text, so it is written as polynomials through nodes or as Bezier
curves, to the last bit.
"""

from beamcam.errors import ReadError, Rule, Severity
from beamcam.geometry.approximation import Approximation, curves_of_function, curves_of_way
from beamcam.geometry.curves import Curve
from beamcam.geometry.expression import FUNCTIONS, compile_expression
from beamcam.model.json_object import JSON_KEY_MISSING, JSON_KEY_UNKNOWN, Place
from beamcam.model.part_forms import FunctionForm
from beamcam.model.quantities import MAX_NUMBER

#: Distance in mm that the curves of a function may have from it, where the file does not say.
FUNCTION_TOLERANCE = 0.001

JSON_EXPRESSION = Rule(
    "json-expression",
    Severity.ERROR,
    "found {found}, expected {expected}",
    "The curve is the value of the expression at every place between its ends.",
)


def curves_of_function_form(form: FunctionForm, place: Place) -> tuple[Curve, ...]:
    """The curves of a function. Raises ReadError at the key that is wrong."""
    tolerance = FUNCTION_TOLERANCE if form.tolerance is None else form.tolerance
    try:
        fit = _graph(form, tolerance, place) if form.t is None else _way(form, tolerance, place)
    except ReadError:
        raise
    except ValueError as error:
        raise place.fault(
            JSON_EXPRESSION, found=error, expected="a smooth curve from end to end"
        ) from None
    return fit.curves


def _graph(form: FunctionForm, tolerance: float, place: Place) -> Approximation:
    if form.x is not None:
        raise place.at("t").fault(JSON_KEY_MISSING, key="t", expected="both ends of a way")
    y = _arithmetic(form.y, "x", place.at("y"))
    low, high = (_end(end, place.at(key)) for key, end in (("from", form.low), ("to", form.high)))
    return curves_of_function(y, low, high, tolerance)


def _end(value: float | str | None, place: Place) -> float:
    if value is None:
        key = place.path.rpartition(".")[2]
        raise place.fault(JSON_KEY_MISSING, key=key, expected="an end of the graph")
    return _number(value, place)


def _way(form: FunctionForm, tolerance: float, place: Place) -> Approximation:
    if form.x is None:
        raise place.at("x").fault(JSON_KEY_MISSING, key="x", expected="x of t")
    for key, end in (("from", form.low), ("to", form.high)):
        if end is not None:
            raise place.at(key).fault(
                JSON_KEY_UNKNOWN, key=key, expected="x, y, t, tolerance", nearest="t"
            )
    x, y = _arithmetic(form.x, "t", place.at("x")), _arithmetic(form.y, "t", place.at("y"))
    ends = form.t or ()
    if len(ends) != 2:
        raise place.at("t").wrong(f"{len(ends)} values", "two ends [from, to]")
    low, high = (_number(end, place.at("t", k)) for k, end in enumerate(ends))
    return curves_of_way(x, y, low, high, tolerance)


def _arithmetic(text: str, variable: str, place: Place) -> str:
    """An expression, which is arithmetic of the variable."""
    try:
        compile_expression(text, (variable,))
    except ValueError as error:
        functions = " ".join(sorted(FUNCTIONS))
        expected = f"arithmetic of {variable}: numbers, pi, e, + - * / ^, parentheses, {functions}"
        raise place.fault(JSON_EXPRESSION, found=error, expected=expected) from None
    return text


def _number(value: float | str, place: Place) -> float:
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
