"""Arithmetic over the figures of section, hole and tool, as a line of a machine file."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from beamcam.caches import cached
from beamcam.errors import MachineError, Source
from beamcam.geometry.expression import Expression, compile_expression
from beamcam.machine import rules

FORMULA_NAMES = frozenset(
    {
        "height",  # of the section
        "width",
        "flange_thickness",
        "web_thickness",
        "thickness",  # of the material that is drilled
        "face_depth",  # how far the face lies below the outermost material on its side
        "y",  # of the hole on its face
        "depth",  # of the drill's full diameter: the hole's own, or thickness and breakthrough
        "tip",  # length of the drill's point
        "clearance",
    }
)


class Formula(str):
    """A number that depends on the section or the hole, written as arithmetic."""

    __slots__ = ()

    def __call__(self, values: Mapping[str, float]) -> float:
        """The number for a section and a hole. Raises MachineError where there is none."""
        try:
            number = _compiled(self)(values)
        except (ArithmeticError, ValueError) as error:
            raise _without_value(self, values, str(error)) from None
        if not isfinite(number):
            raise _without_value(self, values, "not finite")
        return number


class NoValueError(MachineError):
    """A formula that has no value for a section and a hole."""

    def __init__(self, formula: str, expected: str) -> None:
        self.formula, self.expected = formula, expected
        source = Source("machine")
        super().__init__(
            rules.WRONG_VALUE.at(source, key="spindles", found=repr(formula), expected=expected)
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.formula, self.expected)


def _without_value(formula: Formula, values: Mapping[str, float], why: str) -> NoValueError:
    given = ", ".join(f"{name} {value:g}" for name, value in sorted(values.items()))
    return NoValueError(str(formula), f"arithmetic that has a value for {given} ({why})")


def as_formula(kind: type, value: object) -> Formula:
    """The formula in a value of a machine file. Raises ValueError."""
    if kind is not Formula or not isinstance(value, str | int | float) or value is True:
        raise ValueError("arithmetic as a text")
    formula = Formula(value)
    try:
        _compiled(formula)
    except ValueError as error:
        raise ValueError(f"arithmetic: {error}") from error
    return formula


@cached("machine.formula")
def _compiled(text: str) -> Expression:
    return compile_expression(text, FORMULA_NAMES)
