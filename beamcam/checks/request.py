"""The programs of a request against the request itself: each piece once, from the stock there is.

Counted from the parts and quantities as they were asked for; which share of them a program holds is
the planner's word, and is only believed where all shares together are the request.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import pairwise

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source, error, warning
from beamcam.machine.machine import Machine
from beamcam.model.description import description
from beamcam.model.part import Feature, Part, TextMark
from beamcam.model.request import Job, Request, policy_on

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


def pieces_asked(request: Request) -> Counter[int]:
    """How many pieces of each part the programs have to make, by its place in the request.

    A line without a saw is fed one cut piece at a time and runs the program for each of them.
    """
    quantity, machine = request.quantity, request.machine
    alone = quantity is None or (machine.stock == "beam" and machine.saw is None)
    counts: Counter[int] = Counter()
    for place, part in enumerate(request.parts):
        counts[place] = 1 if alone else part.quantity if quantity == "file" else int(quantity or 0)
    return counts


def job_faults(request: Request, jobs: Sequence[Job]) -> tuple[Diagnostic, ...]:
    """What the programs of a request make too often or too seldom, in another order, or from a bar
    that is not in store."""
    return (
        *_count_faults(request, jobs), *_order_faults(request, jobs), *_bar_faults(request, jobs),
    )  # fmt: skip


def _count_faults(request: Request, jobs: Sequence[Job]) -> Iterator[Diagnostic]:
    counts = pieces_asked(request)
    made = Counter(place for job in jobs for place in job.pieces)
    for place in sorted(counts.keys() | made.keys()):
        if made[place] != counts[place]:
            known = 0 <= place < len(request.parts)
            part = request.parts[place] if known else None
            yield PIECES.at(
                part.source if part else Source(request.name), found=made[place],
                mark=(part.mark if part else "") or "a part", expected=counts[place],
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


LEFT_OUT = warning("verify-left-out",
    "found nothing that makes the {what} of {mark}; it may be left out, and is not made",
    "The machine cannot make it and its kind is allowed to be missing, by `--allow-skips` or the "
    "head of the program. It has to be made manually or on another machine.")  # fmt: skip
LEDGER = error("verify-ledger",
    "found {found} feature(s) missing from the program; expected {expected}, as planned",
    "What is missing from a program has to be what the plan left out by name, and nothing else. It "
    "is a fault of beamcam; send in the part.")  # fmt: skip
TEXT_TOLD = error("verify-text-told",
    "found a text lettered {found}; expected it {expected}, as planned",
    "The plan reports where a text is moved or made smaller, the read-back finds it in the "
    "program, and both have to agree. It is a fault of beamcam; send in the part.")  # fmt: skip


def left_out(part: Part, features: Iterable[int]) -> Iterator[Diagnostic]:
    """A warning for each of the features of a part, by their indices, that a program leaves out."""
    for index in sorted(features):
        feature = part.features[index]
        yield LEFT_OUT.at(feature.source, what=description(feature), mark=part.mark)


# --- by hand --------------------------------------------------------------------------------------

# Marks that a program leaves for manual work or makes elsewhere, reported one by one.


MANUAL_WORK = warning("verify-by-hand",
    "found nothing that makes the {what} of {mark}; it is left for manual work, as {machine} says",
    "`[marks]` in the machine's file says which kinds of marks are made by the machine, and which "
    "are left for manual work.")  # fmt: skip
TEXT_MOVED = warning("verify-text-moved",
    "found the text {text!r} at x {x}, y {y}, {height} mm high; at x {wanted_x}, y {wanted_y}, "
    "{wanted_height} mm high it would not be clear",
    "A text that would stand on an edge or over a hole is moved, or made smaller.")  # fmt: skip


def is_manual_work(feature: Feature, machine: Machine) -> bool:
    """Whether a feature is not the machine's work."""
    policy = policy_on(feature, machine.marks)
    if policy == "make" and isinstance(feature, TextMark):
        return machine.marks.unit == "none"
    return policy == "list"


def left_to_manual_work(part: Part, machine: Machine) -> Iterator[Diagnostic]:
    """A warning for each feature of a part that is not the machine's work."""
    for feature in part.features:
        if is_manual_work(feature, machine):
            yield manual_work(feature, part, machine)


def manual_work(feature: Feature, part: Part, machine: Machine) -> Diagnostic:
    """The remark that a feature is left for manual work."""
    return MANUAL_WORK.at(
        feature.source, what=description(feature), mark=part.mark, machine=machine.name
    )


# --- uncut ----------------------------------------------------------------------------------------

# Waste of sheets that no beam reaches, and that stays on the part.


UNCUT = warning("verify-sheet-left",
    "found {found} mm of waste in a corner at x {x}, y {y} that the beam does not reach; it stays "
    "on the part",
    "A round beam stops before a sharp corner. Where that matters, the place is finished by "
    "hand.")  # fmt: skip
UNCUT_TOLD = error("verify-sheet-untold",
    "found {found} mm of waste in a corner at x {x}, y {y} that the beam does not reach; expected "
    "it to be reported by the plan",
    "The plan reports what stays on a part, the read-back finds it in the program, and both have "
    "to agree. It is a fault of beamcam; send in the part.")  # fmt: skip


REST = error("verify-rest",
    "found {found} in the rest of the part; expected {expected}",
    "What a program leaves out has to be what the next machine gets, and nothing else, or it is "
    "made twice or never. It is a fault of beamcam; send in the part.")  # fmt: skip
NOWHERE = Source("")


def rest_faults(part: Part, rest: Part, missing: Collection[int]) -> Iterator[Diagnostic]:
    """All differences of a rest, as it was read again, from what a program leaves of a part.

    `missing` are the features that the program does not make. Of both parts the figures have to be
    rounded as the format of the rest does.
    """
    source = rest.source
    for name in ("mark", "profile", "length", "quantity", "grade"):
        found, expected = getattr(rest, name), getattr(part, name)
        if found != expected:
            yield REST.at(source, found=f"{name} {found}", expected=str(expected))
    if rest.made is None:
        yield REST.at(source, found="a whole part", expected="one whose ends are there")
        return
    to_make = [f for k, f in enumerate(part.features) if k in missing]
    there = [*(part.made or ()), *(f for k, f in enumerate(part.features) if k not in missing)]
    for found_ones, expected_text, how in (
        (rest.features, to_make, "to be made"), (rest.made, there, "as made")
    ):  # fmt: skip
        have, want = Counter(map(_bare, found_ones)), Counter(map(_bare, expected_text))
        for feature in have - want:
            yield REST.at(source, found=f"{description(feature)} {how}", expected="none")
        for feature in want - have:
            yield REST.at(source, found=f"nothing {how} for it", expected=description(feature))


def _bare(feature: Feature) -> Feature:
    """A feature wherever it stands in its file."""
    return replace(feature, source=NOWHERE)
