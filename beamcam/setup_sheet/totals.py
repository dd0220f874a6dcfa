"""How long a program works and how long it travels: by tool, and for a table by length too."""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct

from beamcam.pictures.table import TableMade
from beamcam.setup_sheet.operations import Operation
from beamcam.simulate.trace import Trace


class Total(Struct, frozen=True):
    """A row of the times."""

    what: str  #: a tool, a process, or travel
    count: int | None  #: of operations or paths
    work_s: float  #: in the steel, or with the tool on
    seconds: float  #: with the way to each of them
    length: float | None = None  #: of a table's way


def bar_totals(operations: Sequence[Operation], trace: Trace) -> tuple[Total, ...]:
    """The times of a bar's tools: at work is the block that feeds or saws."""
    lasts = np.diff(trace.time_s)
    rows: dict[str, list[Operation]] = {}
    for op in operations:
        rows.setdefault(op.tool or "saw", []).append(op)
    found = [
        Total(
            tool, len(ops), float(lasts[np.isin(trace.line, [op.line for op in ops])].sum()),
            sum(op.seconds for op in ops),
        )
        for tool, ops in rows.items()
    ]  # fmt: skip
    work = sum(row.work_s for row in found)
    travel = Total("travel and changes", None, 0.0, trace.duration_s - work)
    return (*found, travel, Total("together", len(operations), work, trace.duration_s))


def table_totals(table: TableMade) -> tuple[Total, ...]:
    """Times and lengths of a table by process, and of the ways between with nothing on."""
    return tuple(_table(table))


def _table(table: TableMade) -> Iterator[Total]:
    trace = table.trace
    lasts = np.diff(trace.time_s)
    ways = np.hypot(*np.diff(trace.positions[:, :2], axis=0).T)
    process = [state.process for state in trace.states]
    of = np.array([process[k] for k in trace.state.tolist()], dtype=object)
    for name in dict.fromkeys(p for _, _, p in table.strokes):
        own = of == name
        count = sum(p == name for _, _, p in table.strokes)
        on = float(lasts[own].sum())
        yield Total(name, count, on, on, float(ways[own].sum()))
    off = of == ""
    yield Total("travel", None, 0.0, float(lasts[off].sum()), float(ways[off].sum()))
    on = float(lasts[~off].sum())
    yield Total("together", len(table.strokes), on, trace.duration_s, float(ways.sum()))
