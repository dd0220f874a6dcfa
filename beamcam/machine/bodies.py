"""The bodies of a machine that may strike each other, as boxes that its axes carry."""

from collections.abc import Iterator

from beamcam.conversion import Keys, Text, compile_expression
from beamcam.machine.stations import Formula

#: What a body's box may depend on: the section that is worked.
SECTION_NAMES = ("height", "width", "flange_thickness", "web_thickness")


class MachineBox(Keys, frozen=True):
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
    bodies: tuple[MachineBox, ...], axes: frozenset[str]
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
    try:
        compile_expression(formula, SECTION_NAMES)
    except ValueError:
        return False
    return True
