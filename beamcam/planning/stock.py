"""The bar that parts are cut from: its section, and of those in store the shortest that will do."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeVar

from beamcam.errors import Diagnostic, PlanError, Source, errors_in
from beamcam.model.part import Part
from beamcam.model.section import section_fault
from beamcam.planning import rules
from beamcam.planning.operations.line import BarLine

Made = TypeVar("Made")


def from_store(
    make: Callable[[float | None], Made], lengths: Sequence[float], longest_part: float
) -> Made:
    """What `make` gives for the first of `lengths` (mm, rising) that is not too short.

    Without any it is asked for None, a bar as long as the parts need. Raises PlanError as `make`
    does; where all bars are too short, for the longest.
    """
    if not lengths:
        return make(None)
    *shorter, longest = lengths
    for length in shorter:
        if length < longest_part:
            continue
        try:
            return make(length)
        except PlanError as error:
            if not is_too_short(error.diagnostics):
                raise
    return make(longest)


def is_too_short(said: Iterable[Diagnostic]) -> bool:
    """Whether a longer bar is all that would help."""
    return {d.code for d in errors_in(said)} <= {
        rules.BAR_FULL.code,
        rules.BAR_SHORT.code,
        rules.BAR_LEFT.code,
    }


def refuse_stock(parts: Sequence[Part], line: BarLine) -> Iterator[Diagnostic]:
    """Errors for sections that the machine does not take, or that differ on one bar."""
    machine, layout = line.machine, line.layout
    if not parts:
        yield rules.NO_PARTS.at(Source(machine.name))
        return
    profile = parts[0].profile
    for part in parts:
        mine = part.profile
        if mine.code not in layout.profiles or mine.code not in machine.sections:
            yield rules.STOCK.at(
                part.source, found=mine.code, machine=machine.name,
                expected=", ".join(layout.profiles),
            )  # fmt: skip
        elif mine is not profile and mine != profile:
            yield rules.MIXED_PROFILES.at(part.source, found=mine.name, expected=profile.name)
        fault = section_fault(mine)
        if fault is not None:
            yield rules.SECTION_SHAPE.at(part.source, found=fault, code=mine.code)
    stations = (("saw", line.saw), ("drill", line.drill))
    for part in parts:
        height, width = part.profile.height, part.profile.width
        for station, size in stations:
            if height > size.max_height or width > size.max_width:
                yield rules.SECTION_SIZE.at(
                    part.source, found=f"{height:g} x {width:g}", station=station,
                    expected=f"{size.max_height:g} x {size.max_width:g}",
                )  # fmt: skip
