"""Values of a file as a record, checked by msgspec against the record's own types.

msgspec stops at the first fault and says what it expected. `Fault` adds what it leaves out: the key
of a table's row, the value that was found, the words that may stand there, the nearest known key.
"""

from math import isfinite
from threading import Lock
from typing import Annotated, Any, TypeVar

from msgspec import Meta, Struct, ValidationError, convert

from beamcam.conversion.diagnosis import Fault, Hook, Path, nearest

__all__ = [
    "MAX_NUMBER",
    "Count",
    "Fault",
    "Keys",
    "NotNegative",
    "Positive",
    "PositiveCount",
    "Text",
    "converted",
    "nearest",
]  # fmt: skip

Record = TypeVar("Record")

Text = Annotated[str, Meta(min_length=1)]
Positive = Annotated[float, Meta(gt=0)]
NotNegative = Annotated[float, Meta(ge=0)]
Count = Annotated[int, Meta(ge=0)]
PositiveCount = Annotated[int, Meta(ge=1)]


class Keys(Struct, frozen=True, forbid_unknown_fields=True):
    """A record whose fields are the keys of a table, and all that it may have."""


#: msgspec works out what it knows of a type at its first use, and lets another thread take the half
#: of it: the process ends with a segmentation fault.
_ONE_AT_A_TIME = Lock()
#: No length in mm is greater, 10,000 km; squares and sums of such stay numbers.
MAX_NUMBER = 1e10
MOST_BITS = 63  #: of a whole number; no machine counts further


def converted(value: object, record: type[Record], hook: Hook | None = None) -> Record:
    """`value`, as a parser of TOML or JSON gives it, as a record. Raises Fault."""
    with _ONE_AT_A_TIME:
        try:
            result = convert(value, record, dec_hook=hook)
        except ValidationError as error:
            from beamcam.conversion.diagnosis import fault_of

            raise fault_of(str(error), value, record, hook) from None
    odd = _odd_number(value)
    if odd is not None:
        raise odd
    return result


def _odd_number(value: object) -> Fault | None:
    """The first number that is not finite, or too large to reckon with."""
    waiting: list[tuple[Path, Any]] = [((), value)]
    while waiting:
        path, holder = waiting.pop()
        for key, item in holder.items() if isinstance(holder, dict) else enumerate(holder):
            if isinstance(item, float):
                if not isfinite(item):
                    return Fault("value", (*path, key), item, "a finite number")
            elif isinstance(item, dict | list):
                waiting.append(((*path, key), item))
            elif isinstance(item, int) and item.bit_length() > MOST_BITS:
                return Fault("value", (*path, key), item, "a number of at most 18 digits")
            if isinstance(item, int | float) and abs(item) > MAX_NUMBER:
                expected = f"a number between -{MAX_NUMBER:g} and {MAX_NUMBER:g}"
                return Fault("value", (*path, key), item, expected)
    return None
