"""One program per bar: all parts on one bar, or the required quantity on several."""

from collections.abc import Sequence
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine.machine import Machine
from beamcam.model.part import Part

Quantity = Literal["file"] | int | None  #: as in the part's file, a number, or not given


class BarJob(Struct, frozen=True):
    """The parts of one program, and the bars that it may be cut from."""

    parts: tuple[Part, ...]
    lengths: tuple[float, ...]  #: mm, rising; none: as long as the parts need


def wanted(part: Part, quantity: Quantity) -> int:
    """Quantity of a part: that of its file, unless a number is given."""
    return quantity if isinstance(quantity, int) else part.quantity


def repeated(parts: Sequence[Part], quantity: Quantity) -> tuple[Part, ...]:
    """Each part as often as it is wanted, one after the other, each a piece by itself."""
    return tuple(
        piece for part in parts for piece in (replace(part, quantity=1),) * wanted(part, quantity)
    )


def bar_jobs(
    parts: Sequence[Part], machine: Machine, quantity: Quantity, lengths: tuple[float, ...]
) -> tuple[BarJob, ...]:
    """The jobs that make `parts`, bar by bar.

    Without a quantity all go onto one bar. Raises PlanError for a part that fits on no bar.
    """
    if quantity is None:
        return (BarJob(tuple(parts), lengths),)
    if machine.saw is None:  # each is a bar by itself, and its program is run so often
        return tuple(BarJob((part,), ()) for part in parts)
    from beamcam.planning.stock_bars import first_fit

    pieces = repeated(parts, quantity)
    nesting = first_fit(pieces, machine, lengths)
    if nesting.refusals:
        raise PlanError(dict.fromkeys(nesting.refusals))
    return tuple(
        BarJob(tuple(pieces[i] for i in bar.pieces), (bar.account.length,) if lengths else ())
        for bar in nesting.bars
    )


def numbered(name: str, count: int) -> tuple[str, ...]:
    """The names of `count` programs: job.gcode, or job-1.gcode, job-2.gcode, ..."""
    if count == 1:
        return (name,)
    stem, dot, suffix = name.rpartition(".")
    if not stem:
        stem, dot, suffix = name, "", ""
    return tuple(f"{stem}-{number}{dot}{suffix}" for number in range(1, count + 1))
