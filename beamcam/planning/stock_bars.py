"""Parts on as many bars of stock as they need, first fit.

    D. S. Johnson, Near-optimal bin packing algorithms, 1973: each part in the order given goes
    onto the first bar begun that has room for it. It never takes more than 17/10 of the minimum.

Bars begin as the longest in store; at the end each is the shortest that holds its parts.
"""

from collections.abc import Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError
from beamcam.machine.machine import Layout, Machine
from beamcam.machine.saw import Saw
from beamcam.model.part import Part
from beamcam.model.plan import Bar
from beamcam.planning.nesting import lay_on_bar
from beamcam.planning.operations.ends import Ends, ends_of


class StockBar(Struct, frozen=True):
    """A bar of stock with the parts that are cut from it."""

    pieces: tuple[int, ...]  #: indices of the parts, in their order along the bar
    starts: tuple[float, ...]  #: x of each on the bar, mm
    account: Bar


class Nesting(Struct, frozen=True):
    """All parts on bars, and why some are on none."""

    bars: tuple[StockBar, ...]
    refusals: tuple[Diagnostic, ...]


class _Begun(Struct):
    """A bar that parts are put on."""

    key: object
    pieces: list[int]


def first_fit(parts: Sequence[Part], machine: Machine, lengths: Sequence[float]) -> Nesting:
    """Bars for `parts`, those of one section and grade together, in the order given.

    `lengths` (mm) are those in store; without any there is one bar for each section and grade, as
    long as its parts need. Raises TypeError for a machine without saw and layout.
    """
    saw = machine.needed(machine.saw, "saw and layout")
    layout = machine.needed(machine.layout, "saw and layout")
    store = sorted(lengths)
    longest = store[-1] if store else None
    ends: dict[int, Ends] = {}
    bars: list[_Begun] = []
    refusals: list[Diagnostic] = []
    for index, part in enumerate(parts):
        try:
            ends[index] = ends_of(part, saw)[0]
            _laid((index,), parts, ends, layout, saw, longest)
        except PlanError as error:
            refusals += error.diagnostics
            continue
        _put(index, (part.profile, part.grade), bars, parts, ends, layout, saw, longest)
    made = tuple(_shortest(bar.pieces, parts, ends, layout, saw, store) for bar in bars)
    return Nesting(made, tuple(refusals))


def _put(
    index: int, key: object, bars: list[_Begun], parts: Sequence[Part], ends: dict[int, Ends],
    layout: Layout, saw: Saw, longest: float | None,
) -> None:  # fmt: skip
    """Put a part on the first bar that has room, or begin another."""
    for bar in bars:
        if bar.key == key:
            try:
                _laid((*bar.pieces, index), parts, ends, layout, saw, longest)
            except PlanError:
                continue
            bar.pieces.append(index)
            return
    bars.append(_Begun(key, [index]))


def _shortest(
    pieces: Sequence[int], parts: Sequence[Part], ends: dict[int, Ends], layout: Layout, saw: Saw,
    store: Sequence[float],
) -> StockBar:  # fmt: skip
    """The shortest bar in store that holds the pieces."""
    *shorter, last = store or (None,)
    for length in shorter:
        try:
            return _laid(pieces, parts, ends, layout, saw, length)
        except PlanError:
            continue
    return _laid(pieces, parts, ends, layout, saw, last)


def _laid(
    pieces: Sequence[int], parts: Sequence[Part], ends: dict[int, Ends], layout: Layout, saw: Saw,
    length: float | None,
) -> StockBar:  # fmt: skip
    """Some parts laid on one bar. Raises PlanError as `lay_on_bar` does."""
    chosen = [parts[i] for i in pieces]
    laid, _ = lay_on_bar(chosen, [ends[i] for i in pieces], layout, saw, length)
    return StockBar(tuple(pieces), laid.starts, laid.bar)
