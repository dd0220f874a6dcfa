"""The order of work where the stop stands downstream: along machine X, and never back.

The bar runs against the stop, and the stop only gives way: X grows or stays. So the operations
stand in order of machine X, which is not the order of part x (a cut near the saw comes before a
hole that the drill behind it reaches later). Freedom is left only among operations at one X:

    X 1200   web d22, both flanges d14        X 1500   both flanges d14, web d14
             \\________ 1 change ________/               \\____ no change, 1 change

At each X every (spindle, drill) is worked off in one go, and the ones to begin and to end with
are chosen over the whole bar so that the number of changes is least: a shortest path over the
last (spindle, drill) of each X.
"""

from collections.abc import Iterable, Sequence
from itertools import groupby, pairwise

from beamcam.model.plan import DrillOp, Operation, SawOp

Setup = tuple[int, float]  #: spindle and drill diameter


def sort_along_x(operations: Iterable[Operation], resolution: float) -> tuple[Operation, ...]:
    """The operations in order of X, with the fewest changes of spindle and drill.

    X that the output cannot tell apart (`resolution`) count as one; cuts come before holes there.
    """

    def place(op: Operation) -> int:
        return round(op.x / resolution)

    ordered = sorted(operations, key=lambda op: (place(op), _rank(op)))
    stations = [list(group) for _, group in groupby(ordered, place)]
    drills = [[op for op in ops if isinstance(op, DrillOp)] for ops in stations]
    lasts = iter(_choose_lasts([_setups(ops) for ops in drills if ops]))
    result: list[Operation] = []
    current: Setup | None = None
    for ops, holes in zip(stations, drills, strict=True):
        result += [op for op in ops if isinstance(op, SawOp)]
        if holes:
            last = next(lasts)
            setups = _arrange(_setups(holes), current, last)
            for setup in setups:
                result += [op for op in holes if _setup(op) == setup]
            current = last
    return tuple(result)


def changes(operations: Iterable[Operation]) -> int:
    """How often spindle or drill change along `operations`."""
    setups = [_setup(op) for op in operations if isinstance(op, DrillOp)]
    return sum(a != b for a, b in pairwise(setups))


def _setup(op: DrillOp) -> Setup:
    return op.spindle, op.tool.diameter


def _setups(ops: Sequence[DrillOp]) -> list[Setup]:
    return sorted({_setup(op) for op in ops})


def _rank(op: Operation) -> tuple[object, ...]:
    if isinstance(op, SawOp):
        return (0, op.purpose != "parting", op.x, op.angle)
    return (1, op.spindle, op.tool.diameter, op.x, op.y, op.features)


def _arrange(setups: list[Setup], current: Setup | None, last: Setup) -> list[Setup]:
    """The setups of one X: `current` first if it is among them, `last` at the end."""
    first = [s for s in setups if s == current and s != last]
    return first + [s for s in setups if s != last and s not in first] + [last]


def _choose_lasts(stations: Sequence[list[Setup]]) -> list[Setup]:
    """The setup to end each X with, so that the sum of changes is least."""
    best: dict[Setup, tuple[int, tuple[Setup, ...]]] = {}
    for setups in stations:
        arriving = best or {(0, 0.0): (0, ())}
        best = {}
        for last in setups:
            options = (
                (cost + len(setups) - (current in setups and (current != last or len(setups) == 1)),
                 (*path, last))
                for current, (cost, path) in arriving.items()
            )  # fmt: skip
            best[last] = min(options)
    return list(min(best.values())[1]) if best else []
