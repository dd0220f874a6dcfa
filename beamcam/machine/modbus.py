"""How a controller publishes its axis positions over Modbus TCP."""

from collections.abc import Iterator
from typing import Literal

from beamcam.conversion import Count, Keys, Positive


class Modbus(Keys, frozen=True):
    """The registers of a controller: output k is axis k, in the order of `[[axes]]`.

    The same signed values are in the holding and the input registers.
    """

    values: Literal["int16", "int32", "float"] = "int16"  #: of one, two and two registers an axis
    scale: Positive = 1.0  #: mm or degrees of one count, of int16 and int32
    scales: tuple[Positive, ...] = ()  #: for each axis, where they differ
    word_order: Literal["high-first", "low-first"] = "high-first"  #: of two registers
    first: Count = 0  #: address of axis 0
    states: bool = True  #: spindle, diameter, turning, coolant, sawing and line follow the axes

    @property
    def words(self) -> int:
        """Registers of an axis."""
        return 1 if self.values == "int16" else 2

    def scale_of(self, axis: int) -> float:
        """mm or degrees of one count."""
        return self.scales[axis] if self.scales else self.scale


def modbus_faults(modbus: Modbus, axes: int) -> Iterator[tuple[str, object, str]]:
    """Scales that are not one for each axis, registers beyond the last address."""
    if modbus.scales and len(modbus.scales) != axes:
        yield "modbus.scales", len(modbus.scales), f"{axes}, one for each axis"
    if modbus.first + axes * modbus.words + 6 > 65536:
        yield "modbus.first", modbus.first, "an address whose registers end by 65535"
