"""Arithmetic over the figures of section, hole and tool, as a line of a machine file."""

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

from beamcam.caches import cached
from beamcam.conversion import Keys, Text
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


# --- bodies ---------------------------------------------------------------------------------------

# The bodies of a machine that may strike each other, as boxes that its axes carry.


#: What a body's box may depend on: the section that is worked.
SECTION_NAMES = ("height", "width", "flange_thickness", "web_thickness")


class Body(Keys, frozen=True):
    """A box of the machine, placed as it stands when the axes that carry it stand at 0.

    x runs downstream along the bar from machine X 0, y across the web from its middle as Y of a
    program does, z downward from the top of the bar as Z does. An axis that carries the box is
    called by its name, with - before it where it moves the box the other way.
    """

    name: Text  #: in messages
    min: tuple[Formula, Formula, Formula]  #: minimum x, y and z
    max: tuple[Formula, Formula, Formula]  #: maximum x, y and z
    x: str = ""  #: axis that carries it along x; fixed in x if absent
    y: str = ""  #: axis that carries it along y
    z: str = ""  #: axis that carries it along z
    turn: str = ""  #: axis in degrees that turns it about the vertical, from x towards y
    pivot: tuple[Formula, Formula] | None = None  #: x and y that it turns about; 0 and 0 if absent

    @property
    def carriers(self) -> tuple[str, str, str, str]:
        """The axes along x, y and z and the turning one; "" where there is none."""
        return self.x, self.y, self.z, self.turn


def signed(carrier: str) -> tuple[str, int]:
    """The name of an axis that carries a body, and the sign of its motion."""
    return (carrier[1:], -1) if carrier.startswith("-") else (carrier, 1)


def body_faults(
    bodies: tuple[Body, ...], axes: frozenset[str]
) -> Iterator[tuple[str, object, str]]:
    """Each key of a body that contradicts another; `axes` are those of the machine."""
    names = [body.name for body in bodies]
    for index, body in enumerate(bodies):
        key = f"bodies.{index}"
        if names.index(body.name) != index:
            yield f"{key}.name", body.name, "a name once"
        for field, carrier in zip(("x", "y", "z", "turn"), body.carriers, strict=True):
            if carrier and signed(carrier)[0] not in axes:
                yield f"{key}.{field}", carrier, f"an axis: {', '.join(sorted(axes))}"
        for field, formulas in (("min", body.min), ("max", body.max), ("pivot", body.pivot or ())):
            for one in formulas:
                if not _is_of_section(one):
                    yield f"{key}.{field}", str(one), f"arithmetic over {', '.join(SECTION_NAMES)}"


def _is_of_section(formula: Formula) -> bool:
    from beamcam.geometry.expression import compile_expression

    try:
        compile_expression(formula, SECTION_NAMES)
    except ValueError:
        return False
    return True


def section_values(section: Mapping[str, float]) -> dict[str, float]:
    """The figures that a body may depend on; 0 for what is not known."""
    return {name: section.get(name, 0.0) for name in SECTION_NAMES}
