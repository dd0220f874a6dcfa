"""The operations of a program with their figures and times, as they follow one another."""

from collections.abc import Sequence
from itertools import accumulate, pairwise

import numpy as np
from msgspec import Struct

from beamcam.checks.bars.stations import Bore, Cut, MachinedPath, StampedText, Thing
from beamcam.geometry.array_types import Counts, Flags
from beamcam.pictures.bar import order_numbers
from beamcam.pictures.bar_made import BarMade
from beamcam.pictures.features import SteelDepths
from beamcam.pictures.table import SECONDS_PER_MINUTE, TableMade
from beamcam.simulation.trace import Trace

MIN_MOVE = 1e-6


class SheetOperation(Struct, frozen=True):
    """One operation of a program."""

    number: int
    line: int  #: of the program, where its work is
    what: str
    tool: str
    faces: tuple[str, ...]
    x: float  #: machine X
    y: float | None  #: on the face, or machine Y of a table
    depth: float | None  #: in the steel; None where it goes through, or for a cut
    feed_mm_min: float | None
    speed_rpm: float | None
    seconds: float  #: from the end of the operation before
    length: float | None = None  #: of a way along a contour
    is_through: bool = False  #: whether it goes through the wall


def operations_of(bar: BarMade, trace: Trace) -> tuple[SheetOperation, ...]:
    """The cuts and strokes of a bar; a stroke of two spindles is one."""
    numbers = order_numbers(bar.made)
    rows: dict[int, list[Thing]] = {}
    for op in bar.made.order:
        rows.setdefault(op.line, []).append(op)
    ends, depths = _ends(trace, list(rows)), bar.depths
    operations, begin = [], 0.0
    for (line, ops), end in zip(rows.items(), ends, strict=True):
        operations.append(_operation(numbers[line], ops, end - begin, depths))
        begin = end
    return tuple(operations)


def _operation(
    number: int, ops: Sequence[Thing], seconds: float, depths: SteelDepths
) -> SheetOperation:
    op = ops[0]
    faces = tuple(o.face for o in ops if not isinstance(o, Cut))
    x, y = op.points[0] if isinstance(op, MachinedPath) else (op.x, getattr(op, "y", None))
    feed = speed = length = depth = None
    is_through = False
    if isinstance(op, Cut):
        tilt = f", tilt {op.tilt:g}" if op.tilt else ""
        what, tool, feed = f"saw cut {op.angle:g}\N{DEGREE SIGN}{tilt}", "", op.feed_mm_min
    elif isinstance(op, StampedText):
        what, tool = f"{op.kind} {op.text!r}, {op.height:g} high", op.kind
    else:
        what = tool = f"{op.kind} {op.diameter:g}"
        depth, feed = depths.of(op), op.feed_mm_min
        is_through = depth is None
        if isinstance(op, Bore):
            speed = op.speed_rpm
        else:
            what += " path"
            length = sum(float(np.hypot(b[0] - a[0], b[1] - a[1])) for a, b in pairwise(op.points))
    return SheetOperation(
        number, op.line, what, tool, faces, x, y, depth, feed or None, speed or None, seconds,
        length, is_through,
    )  # fmt: skip


def _ends(trace: Trace, lines: Sequence[int]) -> list[float]:
    """When each operation is over, whose work stands in a line: its tool is back.

    It is where, behind the work, another axis begins to move than did in it, or another tool is
    chosen; the last one ends with the program.
    """
    if not len(trace.line):
        return [0.0] * len(lines)
    moves = np.abs(np.diff(trace.positions, axis=0)) > MIN_MOVE
    setups = [(s.spindle, s.diameter) for s in trace.states]
    ends = []
    for k, line in enumerate(lines):
        own = np.flatnonzero(trace.line == line)
        if k + 1 == len(lines) or not len(own):
            ends.append(trace.duration_s if k + 1 == len(lines) else 0.0)
            continue
        used: Flags = np.any(moves[own], axis=0)
        at = int(own[-1]) + 1
        setup = setups[int(trace.state[own[-1]])]
        while at < len(trace.line):
            state, before = (trace.states[int(trace.state[k])] for k in (at, at - 1))
            is_other = (moves[at] & ~used).any() or setups[int(trace.state[at])] != setup
            if is_other or (state.sawing and not before.sawing):
                break
            at += 1
        ends.append(float(trace.time_s[at]))
    return list(accumulate(ends, max))


def table_operations(table: TableMade) -> tuple[SheetOperation, ...]:
    """The paths of a table's program, each with the way to it."""
    trace = table.trace
    speeds = table.speeds_mm_s
    ways = np.hypot(*np.diff(trace.positions[:, :2], axis=0).T)
    operations, begin = [], 0.0
    for number, (first, last, process) in enumerate(table.strokes, 1):
        moving: Counts = first + np.flatnonzero(ways[first:last] > MIN_MOVE)
        x, y = trace.positions[first, :2].tolist()
        fastest = float(speeds[moving].max(initial=0.0)) * SECONDS_PER_MINUTE
        end = float(trace.time_s[last])
        line = int(trace.line[moving[0]] if len(moving) else trace.line[first])
        operations.append(
            SheetOperation(number, line, process, process, (), x, y, None, fastest or None, None,
                      end - begin, float(ways[first:last].sum()))
        )  # fmt: skip
        begin = end
    return tuple(operations)
