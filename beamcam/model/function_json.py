"""Functions in the JSON form of a part: cams, gears, anything with a formula.

`{"y": "20 + 5 * sin(x / 10)", "from": 0, "to": 62.8}` is the graph of a function of x, and
`{"x": "30 * cos(t)", "y": "30 * sin(t)", "t": [0, "2 * pi"]}` the way of a point. The ends are
numbers or arithmetic; `tolerance`, in mm, is how near the curves have to stay. Angles are radians.

A part keeps the curves and not the text, so it is written as polynomials through nodes or as Bezier
curves, to the last bit.
"""

from beamcam.errors import Rule, Severity
from beamcam.geometry.approximation import Fit, curves_of_function, curves_of_way
from beamcam.geometry.curves import Curve
from beamcam.geometry.expression import FUNCTIONS, compile_expression
from beamcam.model.json_object import JSON_TYPE, JSON_VALUE, JsonObject, show

#: Distance in mm that the curves of a function may have from it, where the file does not say.
FUNCTION_TOLERANCE = 0.001

JSON_EXPRESSION = Rule(
    "json-expression",
    Severity.ERROR,
    "found {found}, expected {expected}",
    "The curve is the value of the expression at every place between its ends.",
)


def curves_of_text(fields: JsonObject) -> tuple[Curve, ...]:
    """The curves of a function. Raises ReadError at the key that is wrong."""
    tolerance = fields.positive("tolerance") if "tolerance" in fields else FUNCTION_TOLERANCE
    fields.ignore(("tolerance",))
    try:
        fit = _way(fields, tolerance) if "t" in fields else _graph(fields, tolerance)
    except ValueError as error:
        raise fields.fault(
            JSON_EXPRESSION, "", found=error, expected="a smooth curve from end to end"
        ) from None
    fields.finish()
    return fit.curves


def _graph(fields: JsonObject, tolerance: float) -> Fit:
    y = _text(fields, "y", "x")
    return curves_of_function(y, _end(fields, "from"), _end(fields, "to"), tolerance)


def _way(fields: JsonObject, tolerance: float) -> Fit:
    x, y = _text(fields, "x", "t"), _text(fields, "y", "t")
    ends = fields.items("t")
    if len(ends) != 2:
        expected = "two ends [from, to]"
        raise fields.fault(JSON_VALUE, "t", found=f"{len(ends)} values", expected=expected)
    low, high = (_number(fields, f"t[{k}]", value) for k, value in enumerate(ends))
    return curves_of_way(x, y, low, high, tolerance)


def _text(fields: JsonObject, key: str, variable: str) -> str:
    """The expression under a key, which is arithmetic of the variable."""
    text = fields.text(key)
    try:
        compile_expression(text, (variable,))
    except ValueError as error:
        functions = " ".join(sorted(FUNCTIONS))
        expected = f"arithmetic of {variable}: numbers, pi, e, + - * / ^, parentheses, {functions}"
        raise fields.fault(JSON_EXPRESSION, key, found=error, expected=expected) from None
    return text


def _end(fields: JsonObject, key: str) -> float:
    value = fields.raw(key)
    return _number(fields, key, value) if key in fields else fields.number(key)


def _number(fields: JsonObject, key: str, value: object) -> float:
    """A number, or arithmetic without a variable such as "2 * pi"."""
    if not isinstance(value, str):
        if isinstance(value, int | float) and not isinstance(value, bool):
            return fields.as_number(value, key)
        expected = 'a number, or arithmetic such as "2 * pi"'
        raise fields.fault(JSON_TYPE, key, found=show(value), expected=expected)
    try:
        number = compile_expression(value, ())({})
    except (ArithmeticError, ValueError) as error:
        expected = 'arithmetic of numbers such as "2 * pi"'
        raise fields.fault(JSON_EXPRESSION, key, found=error, expected=expected) from None
    return fields.as_number(number, key)
