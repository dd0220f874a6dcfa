"""G-code lines formatted from arrays, against a loop over f-strings.

    python benchmarks/gcode_numbers.py [LINES]

Prints lines a second of processor time of both, best of five in turns, and their ratio; and the
same for arcs, whose lines have four numbers. Both texts are compared.
"""

from collections.abc import Callable
from time import process_time

import numpy as np
from script import arguments, at_least, start

from beamcam.emitters.cutting import lines
from beamcam.emitters.gcode import number

RUNS = 5
DECIMALS = 3
TEMPLATES = {"lines": "G1 X{x} Y{y}", "arcs": "G2 X{x} Y{y} I{i} J{j}"}


def by_loop(names: str, columns: dict[str, list[float]]) -> str:
    """The lines by f-strings, with the zeros that they do not need."""
    rows = zip(*(columns[name] for name in names), strict=True)
    if names == "xy":
        return "".join([f"G1 X{x:.3f} Y{y:.3f}\n" for x, y in rows])
    return "".join([f"G2 X{x:.3f} Y{y:.3f} I{i:.3f} J{j:.3f}\n" for x, y, i, j in rows])


def seconds(work: Callable[[], object]) -> float:
    """Processor time of one run."""
    start = process_time()
    work()
    return process_time() - start


def main() -> None:
    """Runs both and prints the table."""
    parser = arguments(__doc__)
    parser.add_argument("lines", nargs="?", type=at_least(1), default=1_000_000)
    count: int = parser.parse_args().lines
    random = np.random.default_rng(1)
    for kind, template in TEMPLATES.items():
        names = "xy" if kind == "lines" else "xyij"
        columns = {name: np.round(random.uniform(-200, 3000, count), DECIMALS) for name in names}
        listed = {name: values.tolist() for name, values in columns.items()}
        bulk = loop = float("inf")
        for _ in range(RUNS):
            bulk = min(bulk, seconds(lambda c=columns, t=template: lines(t, c, DECIMALS)))  # type: ignore[misc]
            loop = min(loop, seconds(lambda c=listed, n=names: by_loop(n, c)))  # type: ignore[misc]
        text = lines(template, columns, DECIMALS).splitlines()
        for k in range(0, count, max(1, count // 1000)):
            values = {name: number(listed[name][k], DECIMALS) for name in names}
            assert text[k] == template.format_map(values)
        print(
            f"{kind}: {count / bulk / 1e6:6.2f} million a second from arrays, "
            f"{count / loop / 1e6:5.2f} by f-strings: {loop / bulk:.1f} times as many"
        )


if __name__ == "__main__":
    start(main)
