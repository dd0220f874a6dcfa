"""Tools available to a spindle: limited by its stations, and changed at stops.

What is put in before the program starts is not written down; it is taken to be the tools that the
program needs first. At each stop a tool comes in, for one that is needed last of all: if even so a
tool is chosen that cannot be there, the program has forgotten to stop for it.
"""

from collections.abc import Iterator, Sequence

from msgspec import Struct

Tool = tuple[str, float]  #: kind and diameter


class Chosen(Struct, frozen=True, gc=False):
    """A tool selected for a spindle."""

    line: int
    spindle: int  #: or the number of a pair of them
    tool: Tool


class Changed(Struct, frozen=True, gc=False):
    """A stop for a manual tool change; None where the word does not name the tool."""

    line: int
    spindle: int | None
    diameter: float | None


def wrong_changes(own: Sequence[Chosen | Changed], stations: int) -> Iterator[Chosen | Changed]:
    """Selections of tools that cannot be in a spindle's stations yet, and stops without need.

    `own` are the tools that the spindle is commanded to take and the stops for them,
    in their order.
    """
    loaded: set[Tool] = set()
    started = False  #: whether all stations have had their first tool
    for at, one in enumerate(own):
        if isinstance(one, Chosen):
            if one.tool in loaded:
                continue
            if started or len(loaded) >= stations:
                yield one
                started = True
                _make_room(loaded, own[at:], stations)
            loaded.add(one.tool)
            continue
        new = _meant(one, own[at:], loaded)
        if new is None:
            if one.spindle is not None:
                yield one
            continue
        started = started or len(loaded) >= stations
        _make_room(loaded, own[at:], stations)
        loaded.add(new)


def _meant(change: Changed, rest: Sequence[Chosen | Changed], loaded: set[Tool]) -> Tool | None:
    """The tool that a stop brings: the next one that is needed and not there."""
    for one in rest:
        if isinstance(one, Changed) or one.tool in loaded:
            continue
        if change.diameter is None or abs(one.tool[1] - change.diameter) < 0.001:
            return one.tool
    return None


def _make_room(loaded: set[Tool], rest: Sequence[Chosen | Changed], stations: int) -> None:
    """Take out what is needed last of all, if every station is taken."""
    if len(loaded) < stations:
        return
    next_use: dict[Tool, int] = {}
    for at, one in enumerate(rest):
        if isinstance(one, Chosen):
            next_use.setdefault(one.tool, at)
    loaded.discard(max(sorted(loaded), key=lambda tool: next_use.get(tool, len(rest))))
