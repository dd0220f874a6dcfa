"""Prints how long step tables take, against numpy's own work on as many rows.

The measure is what numpy needs for a cumulative sum, a sort and `tofile` of as many numbers. A
table is timed from the planned motion to the file; planning the motion is printed beside it. All
take turns, so that whatever else the machine does meets each of them, and processor time counts.

    python benchmarks/steps.py [MILLIONS]
"""

import tempfile
import time
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from script import arguments, start

from beamcam.checks.steps import verify_table
from beamcam.emitters.step_table import as_bytes, as_text
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.machine import load
from beamcam.model.program import StepRows, StepTable
from beamcam.motion import steps
from beamcam.motion.densify import DensifyRules, densify
from beamcam.motion.steps import Way, events

ROUNDS = 15


def rings(turns: int) -> list[Way]:
    """Rounded rectangles of 300 x 200 mm, cut one after another at 20 mm/s."""
    ring: tuple[Curve, ...] = (
        Line((60.0, 50.0), (340.0, 50.0)), Arc((340.0, 60.0), 10.0, -90.0, 90.0),
        Line((350.0, 60.0), (350.0, 240.0)), Arc((340.0, 240.0), 10.0, 0.0, 90.0),
        Line((340.0, 250.0), (60.0, 250.0)), Arc((60.0, 240.0), 10.0, 90.0, 90.0),
        Line((50.0, 240.0), (50.0, 60.0)), Arc((60.0, 60.0), 10.0, 180.0, 90.0),
    )  # fmt: skip
    points = densify(ring * turns, DensifyRules(0.005)).points
    return [Way(points, 20.0, True, 0.0)]


def best(*works: Callable[[], object]) -> list[float]:
    """The shortest processor time of each of some works that take turns, in seconds."""
    found: list[list[float]] = [[] for _ in works]
    for _ in range(ROUNDS):
        for times, work in zip(found, works, strict=True):
            begun = time.process_time()
            work()
            times.append(time.process_time() - begun)
    return [min(times) for times in found]


def written(path: Path, pieces: Iterator[bytes]) -> None:
    with path.open("wb") as file:
        for piece in pieces:
            file.write(piece)


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("millions", nargs="?", type=float, default=1.0, help="of rows; default 1")
    millions: float = parser.parse_args().millions
    stepper = load("laser-stepper").stepper
    if stepper is None:
        raise TypeError("laser-stepper has no stepping motors")
    job = rings(max(1, round(millions * 10)))
    begun = time.process_time()
    planned = [steps.plan_way(way, stepper) for way in job]
    planning = time.process_time() - begun
    real = steps.plan_way
    steps.plan_way = lambda way, _: planned[job.index(way)]
    table = StepTable(
        "rings",
        stepper.step,
        stepper.sequence,
        lambda: steps.step_rows(job, stepper),
        lambda: iter(()),
    )
    count = sum(len(rows.time_us) for rows in table.rows())
    numbers = np.random.default_rng(1).random(count)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"

        def numpy_work() -> None:
            np.cumsum(numbers)
            np.sort(numbers).tofile(out)

        ready = list(table.rows())
        kept = StepTable(
            "rings", stepper.step, stepper.sequence, lambda: iter(ready), lambda: iter(())
        )
        base, binary, text, form = best(
            numpy_work,
            lambda: written(out, as_bytes(table)),
            lambda: written(out, as_text(table)),
            lambda: written(out, as_text(kept)),
        )
    print(f"{count} rows; the motion was planned in {planning:.3f} s")
    print(f"numpy: cumsum, sort, tofile     {base:.3f} s")
    print(f"binary table                    {binary:.3f} s, {binary / base:.2f} times numpy; aim 2")
    print(f"text table                      {text:.3f} s, {count / text / 1e6:.1f} million rows/s")
    print(f"text of rows that are there     {form:.3f} s, {count / form / 1e6:.1f} million rows/s")
    steps.plan_way = real
    for turns in (10, 40, 160):
        print(f"memory of {memory(turns, stepper)}")
    for turns in (1, 4, 16):
        print(f"memory of reading back {memory_of_reading(turns)}")


def memory_of_reading(turns: int) -> str:
    """What reading a table back takes; rings with the ways from the corner and to it."""
    machine = load("laser-stepper")
    if machine.stepper is None:
        raise TypeError("laser-stepper has no stepping motors")
    stepper, (ring,) = machine.stepper, rings(turns)
    home, start = np.zeros(2), ring.points[0]
    out, back = (Way(np.array(way), 80.0, False, 0.0) for way in ((home, start), (start, home)))
    job = [out, ring, back]
    table = StepTable(
        "rings", stepper.step, stepper.sequence, lambda: steps.step_rows(job, stepper),
        lambda: iter(()),
    )  # fmt: skip
    pieces = list(as_bytes(table))
    tracemalloc.start()
    said = verify_table(".bin", pieces, [], machine)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    if said:
        raise ValueError(f"the rings are refused: {said[0]}")
    return f"{sum(map(len, pieces)) // 4:9} rows: {peak / 1e6:.1f} MB"


def memory(turns: int, stepper: object) -> str:
    """What the making of a table takes, beside the plan of its motion."""
    from beamcam.machine.tables import Stepper

    assert isinstance(stepper, Stepper)
    points = np.array([[0.0, 0.0], [700.0, 400.0]] * turns)
    path = steps.plan_way(Way(points, 50.0, True, 0.0), stepper)
    words = steps._Words(stepper)

    def rows() -> Iterator[StepRows]:
        for x, y in events(path, stepper):
            yield words.rows(x, y, 0, True)

    table = StepTable("zigzag", stepper.step, stepper.sequence, rows, lambda: iter(()))
    tracemalloc.start()
    size = sum(len(piece) for piece in as_bytes(table))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return f"{size // 4:9} rows: {peak / 1e6:.1f} MB"


if __name__ == "__main__":
    start(main)
