"""Speeds at which a table of steps works a sheet: of processes, and of colours and layers."""

from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets.asked_sheet import rows_of, rows_on
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.part import Part


class ProcessData(Struct, frozen=True):
    """How a process has to run on a sheet."""

    feeds: tuple[float, ...]  #: mm/min: of the process, then of the colours and layers
    pierce_s: float


class Seen(NamedTuple):
    """A speed, and the line that it was seen at."""

    mm_s: float
    line: int


class Rest(NamedTuple):
    """A time without a step of either motor, and its place in steps."""

    seconds: float
    place: tuple[int, int]


class StrokeTimes(NamedTuple):
    """How long a stroke takes, and where it rests."""

    waited_s: float  #: before the head moves
    lasted_s: float  #: under way
    stayed_s: float = 0.0  #: behind its last step
    stood: "Rest | None" = None  #: the longest time without a step at a steady speed
    longest: "Rest | None" = None  #: the longest time without a step


class Observed(NamedTuple):
    """The speeds of the head in a stroke, and its times, as far as they are known."""

    fastest: Seen
    slowest: Seen | None = None
    times: StrokeTimes | None = None
    passes: int = 1
    path: bytes = b""  #: the same of strokes whose places are the same, one by one


def with_speeds(part: Part, torch: Torch) -> Torch:
    """The table with the rows for the part's sheet, and with no other sheet's."""
    return replace(torch, rows=tuple(rows_on(part, torch)))


def process_data(part: Part, torch: Torch) -> dict[TorchProcess, ProcessData]:
    """The data of each process by a table `with_speeds` of the part's sheet."""
    data: dict[TorchProcess, ProcessData] = {}
    for row in rows_of(part, torch):
        known = data.get(row.process, ProcessData((), row.pierce_s))
        feeds = dict.fromkeys((*known.feeds, row.feed_mm_min))
        data[row.process] = replace(known, feeds=tuple(feeds))
    return data
