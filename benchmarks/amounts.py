"""What a piece, a hole, a place on a bar and a label cost, at 1,000 of them and at 10,000.

    python benchmarks/amounts.py

Processor time of the work alone, without the start of a process; a cost that grows with the count
would show as a second figure that is larger than the first.
"""

import random
import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from beamcam.api.shop_lists import labels, lists
from beamcam.errors import Source
from beamcam.machine import load
from beamcam.model.part import Hole, Part, Profile, Slot
from beamcam.pipeline import post
from beamcam.planning.stock import first_fit
from benchmarks.script import arguments, start

COUNTS = (1_000, 10_000)
KINDS = 100  #: of pieces that differ
IPE300 = Profile("I", "IPE300", 300, 150, 10.7, 7.1, 15)
SOURCE = Source("benchmark")


def kinds(count: int, each: int) -> list[Part]:
    """Beams of random lengths, so many of each."""
    chance = random.Random(36)
    return [
        Part(f"B{k}", IPE300, chance.uniform(400, 6000), SOURCE, quantity=each)
        for k in range(count)
    ]


def nesting(count: int) -> Callable[[], object]:
    pieces = [part for part in kinds(KINDS, 1) for _ in range(count // KINDS)]
    machine = load("beamline")
    return lambda: first_fit(pieces, machine, (6000.0, 12000.0))


def listing(count: int) -> Callable[[], object]:
    parts = kinds(KINDS, count // KINDS)
    return lambda: lists(parts, lengths=(6000.0, 12000.0))


def labelling(count: int) -> Callable[[], object]:
    parts = kinds(KINDS, count // KINDS)
    return lambda: labels(parts)


def holes(count: int) -> Callable[[], object]:
    """Rows of ten holes of 6 mm over a bar of 12 m, planned, posted and read back."""
    step = 11_900 / (count // 10)
    part = Part(
        "B", IPE300, 12_000.0, SOURCE,
        features=tuple(
            Hole("v", 50 + (k // 10) * step, 45 + 23 * (k % 10), 6.0, SOURCE) for k in range(count)
        ),
    )  # fmt: skip
    return lambda: list(post((part,), load("beamline-pusher")).pieces())


def left_out(count: int) -> Callable[[], object]:
    """Rows of holes of 3 mm, for which the line has no drill, left out as it is allowed."""
    step = 11_900 / (count // 10)
    small = (
        Hole("v", 50 + (k // 10) * step, 45 + 23 * (k % 10), 3.0, SOURCE) for k in range(count - 10)
    )
    drilled = Hole("v", 20.0, 150.0, 18.0, SOURCE)
    part = Part("B", IPE300, 12_000.0, SOURCE, features=(*small, drilled))
    return lambda: list(post((part,), load("beamline"), skips=("tool",)).pieces())


def slots(count: int) -> Callable[[], object]:
    """As `holes`, a tenth of them: slots of 18 x 30 mm in rows of five, milled."""
    step = 11_800 / (count // 50)
    part = Part(
        "B", IPE300, 12_000.0, SOURCE,
        features=tuple(
            Slot("v", 80 + (k // 5) * step, 60 + 45 * (k % 5), 18.0, 12.0, 0.0, 0.0, SOURCE)
            for k in range(count // 10)
        ),
    )  # fmt: skip
    return lambda: list(post((part,), load("beamline-pusher")).pieces())


WORK: dict[str, tuple[Callable[[int], Callable[[], object]], int]] = {
    "places on bars": (nesting, 1),
    "rows of lists": (listing, 1),
    "labels": (labelling, 1),
    "holes posted": (holes, 1),
    "holes left out": (left_out, 1),
    "slots posted": (slots, 10),
}


def main() -> None:
    arguments(__doc__).parse_args()
    print(f"{'microseconds each':20}" + "".join(f"{count:>12,}" for count in COUNTS))
    for name, (prepare, share) in WORK.items():
        costs = []
        for count in COUNTS:
            work = prepare(count)
            work()
            begun = time.process_time()
            work()
            costs.append(1e6 * (time.process_time() - begun) / (count // share))
        print(f"{name:20}" + "".join(f"{cost:>12.0f}" for cost in costs))


if __name__ == "__main__":
    start(main)
