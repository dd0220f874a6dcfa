"""The rows of the cut chart that may run on a part's sheet, and the words that say each.

Of words those count that start and stop a tool, M words, as the machine's templates have them.
"""

from collections.abc import Callable, Iterable
from itertools import dropwhile, takewhile

from msgspec import Struct
from msgspec.structs import replace

from beamcam.controllers.dialect import tool_words
from beamcam.controllers.events import Pause, Said, Switch, TableEvent, ToolOffset
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess, TorchRow, is_row_for, material_said
from beamcam.model.description import PART_DATA
from beamcam.model.part import Part


def thickness_of(part: Part, torch: Torch) -> float:
    """Of the part's sheet in mm, what the machine's file takes where it does not say; 0 unknown."""
    own = part.profile.web_thickness
    return own if own is not None else torch.thickness or 0.0


def rows_of(part: Part, torch: Torch) -> list[TorchRow]:
    """The rows that may run on the part's sheet: of each process, then of colours and layers."""
    rows = rows_on(part, torch)
    looked = [
        replace(
            row,
            feed_mm_min=row.feed_mm_min if own.speed is None else own.speed,
            power=row.power if own.power is None else own.power,
            passes=row.passes if own.passes is None else own.passes,
        )
        for key, own in torch.settings.items()
        for row in rows
        if torch.colours.get(key) == row.process
    ]
    return [*rows, *looked]


def _at_feed(row: TorchRow, torch: Torch, thickness: float) -> TorchRow:
    """A row at the feed that the chart has for a thickness, where the file says it lies between."""
    if torch.between_rows != "interpolate":
        return row
    alike = [
        r for r in torch.rows
        if (r.process, r.material, r.amps, r.nozzle)
        == (row.process, row.material, row.amps, row.nozzle)
    ]  # fmt: skip
    thinner = [r for r in alike if r.up_to <= thickness]
    if not thinner or row.up_to == thickness:
        return row
    below = max(thinner, key=lambda r: r.up_to)
    share = (thickness - below.up_to) / (row.up_to - below.up_to)
    feed = below.feed_mm_min + share * (row.feed_mm_min - below.feed_mm_min)
    return replace(row, feed_mm_min=feed)


def rows_on(part: Part, torch: Torch) -> list[TorchRow]:
    """The row of each process on the part's sheet, as the machine's file has it."""
    thickness = thickness_of(part, torch)
    material = material_said(part.grade, torch.material)
    rows: dict[TorchProcess, TorchRow] = {}
    for row in torch.rows:
        if 0.0 < thickness <= row.up_to and is_row_for(row.material, material):
            rows.setdefault(row.process, _at_feed(row, torch, thickness))
    if torch.drilled == "spot" and "cut" in rows:
        rows.setdefault("spot", rows["cut"].spotting())
    return list(rows.values())


# --- words ---------------------------------------------------------------------------------------


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
