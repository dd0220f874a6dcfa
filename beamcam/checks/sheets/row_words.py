"""The M words that start and stop the tool of a row, as the machine's templates have them."""

from collections.abc import Callable, Iterable
from itertools import dropwhile, takewhile

from msgspec import Struct

from beamcam.controllers.dialect import tool_words
from beamcam.controllers.events import Pause, Said, Switch, TableEvent, ToolOffset
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow
from beamcam.model.description import PART_DATA


class RowWords(Struct, frozen=True):
    """The M words of one row: what starts its tool and what stops it."""

    row: TorchRow
    on: tuple[Said, ...]
    off: tuple[Said, ...]
    pierce_s: float
    tool: int  #: of the controller's table, whose places they choose; 0 is the torch
    stop_s: float  #: that it stays on for, the head at rest, before it is stopped


def words_of(row: TorchRow, machine: Machine, parse: Callable[[str], list[TableEvent]]) -> RowWords:
    """The words of a row, read from the machine's templates by the controller's own rules.

    Programs write powers, seconds and feeds to three decimals.
    """

    second = 0.001 if machine.format.dwell_unit == "ms" else 1.0

    def events(template: tuple[str, ...]) -> list[TableEvent]:
        lines = [
            line.format(
                power=f"{row.power:.3f}",
                pierce=f"{row.pierce_s / second:.3f}",
                preheat=f"{row.preheat_s / second:.3f}",
                feed="1",
                pierce_height=f"{row.pierce_height:.3f}",
                cut_height=f"{row.cut_height:.3f}",
                amps=f"{row.amps:.3f}",
                volts=f"{row.volts:.3f}",
                number=str(row.number),
                clearance="0",
                touch_height="0",
                **PART_DATA,  # in comments only, as the machine's file is checked
            )
            for line in template
        ]
        return parse("\n".join(lines))

    on = events(getattr(machine.words, f"{row.process}_on"))
    off = events(getattr(machine.words, f"{row.process}_off"))
    chosen = events(getattr(machine.words, f"choose_{row.process}"))
    starts = tool_words((e for e in on if isinstance(e, Switch)), True)
    stops = tool_words((e for e in off if isinstance(e, Switch)), False)
    return RowWords(
        row,
        tuple(e.said for e in starts),
        tuple(e.said for e in stops),
        _seconds(dropwhile(lambda e: e not in starts, on)),
        next((e.number for e in reversed(chosen) if isinstance(e, ToolOffset)), 0),
        _seconds(takewhile(lambda e: e not in stops, off)),
    )


def _seconds(events: Iterable[TableEvent]) -> float:
    return sum(event.seconds for event in events if isinstance(event, Pause))
