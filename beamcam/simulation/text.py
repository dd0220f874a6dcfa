"""A trace as CSV and as JSON: a row for each moment."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from msgspec.structs import asdict

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.simulation.encoder import Encoder, precision, stair_times
from beamcam.simulation.trace import State, Trace, TraceRow, trace_rows

DECIMALS = 3  #: of positions
CELL = ("spindle", "diameter", "turning", "coolant", "sawing")  #: states of a cell
TABLE = ("process",)  #: of a cutting table


def columns(trace: Trace, machine: Machine, encoder: Encoder | None = None) -> tuple[str, ...]:
    """The names of the columns: time, axes, what the encoder reads of them, states, block."""
    names = [axis.name for axis in trace.axes]
    read = [f"{axis.name} read" for axis in trace.axes if axis.is_read] if encoder else []
    return ("time_s", *names, *read, *_states(machine), "line")


def table_rows(
    trace: Trace, machine: Machine, every_s: float | None = None, encoder: Encoder | None = None
) -> Iterator[tuple[Any, ...]]:
    """The cells of each row. By event, an encoder has a row for each count that it passes."""
    names = _states(machine)
    for row, read in _read_rows(trace, every_s, encoder):
        states = (getattr(row.state, name) for name in names)
        places = (round(place, DECIMALS) + 0.0 for place in (*row.positions, *read))
        yield (round(row.time_s, 6), *places, *states, row.line)


def _read_rows(
    trace: Trace, every_s: float | None, encoder: Encoder | None
) -> Iterator[tuple[TraceRow, Sequence[float]]]:
    """Each row with what the encoder reads of the axes in mm."""
    if encoder is None:
        yield from ((row, ()) for row in trace_rows(trace, every_s))
        return
    linear = [k for k, axis in enumerate(trace.axes) if axis.is_read]
    if every_s is not None:
        for row in trace_rows(trace, every_s):
            yield row, encoder.read(trace, np.array([row.positions]))[0, linear].tolist()
        return
    times = stair_times(trace, encoder)
    # Between two rows the count stays, so that its middle shows what is read from the first on.
    middles = np.append((times[:-1] + times[1:]) / 2, times[-1])
    read = encoder.read(trace, trace.at(middles))[:, linear].tolist()
    rows = zip(
        times.tolist(), trace.interval(times).tolist(), trace.at(times).tolist(), read, strict=True
    )
    for time_s, k, at, text in rows:
        line = int(trace.line[k]) if len(trace.line) else 0
        state = trace.states[int(trace.state[k])] if len(trace.line) else State()
        yield TraceRow(time_s, line, tuple(at), state), text


def csv_text(
    trace: Trace, machine: Machine, every_s: float | None = None, encoder: Encoder | None = None
) -> str:
    """The rows as CSV, times in seconds with four decimals, switches as 0 and 1."""
    names = columns(trace, machine, encoder)
    lines = [",".join(name.replace(",", " ") for name in names)]
    last = len(names) - len(_states(machine)) - 1
    for time_s, *cells in table_rows(trace, machine, every_s, encoder):
        places = [f"{place:.{DECIMALS}f}" for place in cells[: last - 1]]
        lines.append(",".join([f"{time_s:.4f}", *places, *map(_cell, cells[last - 1 :])]))
    return "\n".join(lines) + "\n"


def json_data(
    trace: Trace, machine: Machine, every_s: float | None, encoder: Encoder | None,
    warnings: Iterable[Diagnostic],
) -> dict[str, Any]:  # fmt: skip
    """The trace as one record: the axes with their limits, the warnings, columns and rows."""
    data: dict[str, Any] = {
        "machine": machine.name,
        "duration_s": round(trace.duration_s, 6),
        "axes": [
            {"name": axis.name, "unit": axis.unit, "min": axis.min, "max": axis.max}
            for axis in trace.axes
        ],
        "warnings": [
            {"code": diagnostic.code, "line": diagnostic.source.line, "message": diagnostic.message}
            for diagnostic in warnings
        ],
    }
    if encoder is not None:
        data["encoder"] = {
            **asdict(encoder), "counts_per_turn": encoder.counts_per_turn,
            **asdict(precision(trace, encoder)),
        }  # fmt: skip
    data["columns"] = list(columns(trace, machine, encoder))
    data["rows"] = [list(row) for row in table_rows(trace, machine, every_s, encoder)]
    return data


def _states(machine: Machine) -> tuple[str, ...]:
    return CELL if machine.stock == "beam" else TABLE


def _cell(value: Any) -> str:
    """A state or the block: switches as 0 and 1, diameters without zeros behind."""
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:g}" if isinstance(value, float) else str(value)
