"""Arithmetic as text, and that nothing but arithmetic is understood."""

import math

import pytest

from beamcam.conversion import FUNCTIONS, compile_expression


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("height / 2 - y", 170.0),
        ("-y + +3", -17.0),
        ("2 ^ 3 ** 1", 8.0),
        ("2 * pi", 2 * math.pi),
        ("max(y, height, 3) + sqrt(16)", 384.0),
        ("degrees(atan2(1, 1))", 45.0),
        (" 1e3 ", 1000.0),
    ],
)
def test_value(text: str, value: float) -> None:
    compiled = compile_expression(text, ("height", "y"))
    assert compiled({"height": 380.0, "y": 20.0}) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text",
    ["", "1 +", "x", "y.real", "[y]", "y if y else 1", "'a'", "True", "__import__('os')",
     "max(y, key=3)", "(lambda: 1)()", "y < 1", "y % 2", "(" * 500 + "y" + ")" * 500, "y\x00",
     "1" + "0" * 400, "sin()", "sin(y, y)", "max(y)", "atan2(y)", "sin(*y)", "y" + "+y" * 300],
)  # fmt: skip
def test_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"no arithmetic|not understood|takes|nested|characters"):
        compile_expression(text, ("y",))


def test_no_value() -> None:
    with pytest.raises(ArithmeticError):
        compile_expression("1 / y", ("y",))({"y": 0.0})
    with pytest.raises(ValueError, match="math domain"):
        compile_expression("sqrt(y)", ("y",))({"y": -1.0})


def test_every_function_is_callable() -> None:
    for name in FUNCTIONS:
        count = 2 if name in ("min", "max", "atan2", "hypot") else 1
        compiled = compile_expression(f"{name}({', '.join(['0.5'] * count)})", ())
        assert math.isfinite(compiled({}))
