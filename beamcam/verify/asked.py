"""The programs of a request against the request itself: each piece once, from the stock there is.

Counted from the parts and quantities as they were asked for; which share of them a program holds is
the planner's word, and is only believed where all shares together are the request.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise

from beamcam.errors import Diagnostic, Source, error
from beamcam.model.request import Job, Request

SLACK = 1e-6  #: mm between a bar in store and the one that a program is for

PIECES = error("verify-pieces",
    "found {found} of {mark} in the programs of this job; expected {expected}",
    "The pieces of all bars or sheets are counted against the quantities that were asked for. It "
    "is a fault of beamcam; send in the part.")  # fmt: skip
PIECE_ORDER = error("verify-piece-order",
    "found {found} behind {before} in a program; expected the order in which they were given",
    "Pieces go onto bars and sheets in the order of the inputs. It is a fault of beamcam; send in "
    "the parts.")  # fmt: skip
STOCK_BAR = error("verify-stock-bar",
    "found a program for a bar of {found}; expected {expected}",
    "A bar that is not in store cannot be loaded. It is a fault of beamcam; send in the "
    "part.")  # fmt: skip
RULES = (PIECES, PIECE_ORDER, STOCK_BAR)


def pieces_asked(request: Request) -> Counter[int]:
    """How many pieces of each part the programs have to make, by its place in the request.

    A line without a saw is fed one cut piece at a time and runs the program for each of them.
    """
    quantity, machine = request.quantity, request.machine
    alone = quantity is None or (machine.stock == "beam" and machine.saw is None)
    wanted: Counter[int] = Counter()
    for place, part in enumerate(request.parts):
        wanted[place] = 1 if alone else part.quantity if quantity == "file" else int(quantity or 0)
    return wanted


def job_faults(request: Request, jobs: Sequence[Job]) -> tuple[Diagnostic, ...]:
    """What the programs of a request make too often or too seldom, in another order, or from a bar
    that is not in store."""
    return (
        *_count_faults(request, jobs), *_order_faults(request, jobs), *_bar_faults(request, jobs),
    )  # fmt: skip


def _count_faults(request: Request, jobs: Sequence[Job]) -> Iterator[Diagnostic]:
    wanted = pieces_asked(request)
    made = Counter(place for job in jobs for place in job.pieces)
    for place in sorted(wanted.keys() | made.keys()):
        if made[place] != wanted[place]:
            known = 0 <= place < len(request.parts)
            part = request.parts[place] if known else None
            yield PIECES.at(
                part.source if part else Source(request.name), found=made[place],
                mark=(part.mark if part else "") or "a part", expected=wanted[place],
            )  # fmt: skip


def _order_faults(request: Request, jobs: Sequence[Job]) -> Iterator[Diagnostic]:
    for job in jobs:
        for before, after in pairwise(job.pieces):
            if after < before:
                first, then = request.parts[before], request.parts[after]
                yield PIECE_ORDER.at(then.source, found=then.mark, before=first.mark)


def _bar_faults(request: Request, jobs: Sequence[Job]) -> Iterator[Diagnostic]:
    stock, remnants = request.stock, [*request.remnants]
    sawn = request.machine.saw is not None  # a part that comes in cut is a bar by itself
    for job in jobs:
        if job.bar is None and not (stock and sawn):
            continue
        once = None if job.bar is None else _of_length(remnants, job.bar)
        if once is not None:
            remnants.remove(once)  # which is there once
        elif job.bar is None or _of_length(stock, job.bar) is None:
            found = "any length" if job.bar is None else f"{job.bar:g} mm"
            there = [*stock, *remnants]
            expected = " or ".join(f"{length:g} mm" for length in there) or "one of any length"
            yield STOCK_BAR.at(Source(request.name), found=found, expected=expected)


def _of_length(there: Sequence[float], bar: float) -> float | None:
    """The first of the lengths that a bar has; None if none is as long."""
    return next((length for length in there if abs(bar - length) <= SLACK), None)
