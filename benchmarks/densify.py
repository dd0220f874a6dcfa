"""Prints points a second of the densifier, its lead over a plain loop, and its memory.

python benchmarks/densify.py
"""

import random
import time
import tracemalloc
from collections.abc import Callable, Sequence
from itertools import pairwise
from math import ceil, cos, hypot, inf, pi, radians, sin

from script import arguments, start

from beamcam.geometry.curves import Arc, Bezier, Curve, EllipseArc, NewtonCurve
from beamcam.geometry.newton import divided_differences
from beamcam.motion.densify import DensifyRules, densify
from beamcam.motion.spans import chord_step_rad

TOLERANCE = 1e-5


def random_paths(count: int) -> dict[str, list[tuple[Curve, ...]]]:
    """Paths of one curve or of ten, the same on every run."""
    dice = random.Random(7)

    def place() -> tuple[float, float]:
        return dice.uniform(-500, 500), dice.uniform(-500, 500)

    def axis() -> tuple[float, float]:
        size, turn = dice.uniform(50, 500), dice.uniform(0, 2 * pi)
        return size * cos(turn), size * sin(turn)

    def polynomials(pieces: int) -> tuple[Curve, ...]:
        nodes = [(100.0 * k, dice.uniform(-100, 100)) for k in range(4 * pieces + 1)]
        return tuple(NewtonCurve(tuple(nodes[4 * k : 4 * k + 5])) for k in range(pieces))

    def cubics(pieces: int) -> tuple[Curve, ...]:
        ends = [place() for _ in range(pieces + 1)]
        return tuple(Bezier((a, place(), place(), b)) for a, b in pairwise(ends))

    return {
        "arcs": [
            (Arc(place(), dice.uniform(50, 500), dice.uniform(0, 360), 360.0),)
            for _ in range(count)
        ],
        "ellipses": [
            (EllipseArc(place(), axis(), dice.uniform(0.2, 1), 0.0, 360.0),) for _ in range(count)
        ],
        "cubics": [cubics(10) for _ in range(count // 10)],
        "polynomials": [polynomials(10) for _ in range(count // 10)],
    }


def plain_loop(curve: Curve, count: int) -> tuple[list[tuple[float, float]], float, float]:
    """The same result as a straightforward program computes it: the same number of points, and
    the least and the greatest step between them, which the speed depends on."""
    points = []
    if isinstance(curve, Arc):
        start, sweep = radians(curve.start_deg), radians(curve.sweep_deg)
        for k in range(count):
            angle = start + sweep * k / (count - 1)
            x = curve.centre[0] + curve.radius * cos(angle)
            y = curve.centre[1] + curve.radius * sin(angle)
            points.append((x, y))
    elif isinstance(curve, EllipseArc):
        (ax, ay), ratio = curve.axis, curve.ratio
        for k in range(count):
            angle = 2 * pi * k / (count - 1)
            c, s = cos(angle), ratio * sin(angle)
            x, y = curve.centre[0] + c * ax - s * ay, curve.centre[1] + c * ay + s * ax
            points.append((x, y))
    elif isinstance(curve, Bezier):
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = curve.points
        for k in range(count):
            t = k / (count - 1)
            s = 1 - t
            p, q, u, v = s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t
            x = p * ax + q * bx + u * cx + v * dx
            y = p * ay + q * by + u * cy + v * dy
            points.append((x, y))
    elif isinstance(curve, NewtonCurve):
        nodes = [x for x, _ in curve.nodes]
        c0, *rest = divided_differences(nodes, [y for _, y in curve.nodes])
        for k in range(count):
            x = nodes[0] + (nodes[-1] - nodes[0]) * k / (count - 1)
            y, product = c0, 1.0
            for c, node in zip(rest, nodes, strict=False):
                product *= x - node
                y += c * product
            points.append((x, y))
    least, greatest = inf, 0.0
    for (x0, y0), (x1, y1) in pairwise(points):
        step = hypot(x1 - x0, y1 - y0)
        least, greatest = min(least, step), max(greatest, step)
    return points, least, greatest


def seconds(action: Callable[[], object]) -> float:
    """Least time of three runs."""
    best = float("inf")
    for _ in range(3):
        begun = time.perf_counter()
        action()
        best = min(best, time.perf_counter() - begun)
    return best


def run(paths: Sequence[tuple[Curve, ...]], rules: DensifyRules) -> int:
    return sum(len(densify(path, rules).points) for path in paths)


def main() -> None:
    arguments(__doc__).parse_args()
    rules = DensifyRules(TOLERANCE)
    print(f"tolerance {TOLERANCE} mm, one core")
    print(f"{'curves':12} {'points':>9} {'points/s':>12} {'plain loop/s':>12} {'ratio':>7}")
    whole_points, whole_time, whole_plain = 0, 0.0, 0.0
    for name, paths in random_paths(200).items():
        points = run(paths, rules)
        fast = seconds(lambda paths=paths: run(paths, rules))
        counts = [len(densify(path, rules).points) for path in paths]
        few = list(zip(paths, counts, strict=True))[:40]
        begun = time.perf_counter()
        for path, count in few:
            for curve in path:
                plain_loop(curve, ceil(count / len(path)))
        plain = (time.perf_counter() - begun) * points / sum(count for _, count in few)
        print(
            f"{name:12} {points:9} {points / fast:12.3g} {points / plain:12.3g} {plain / fast:7.1f}"
        )
        whole_points, whole_time = whole_points + points, whole_time + fast
        whole_plain += plain
    print(
        f"{'all':12} {whole_points:9} {whole_points / whole_time:12.3g} "
        f"{whole_points / whole_plain:12.3g} {whole_plain / whole_time:7.1f}"
    )
    full = DensifyRules(TOLERANCE, speed_mm_s=20.0, cycle_s=0.002)
    paths = random_paths(200)["arcs"]
    points, spent = run(paths, full), seconds(lambda: run(paths, full))
    print(f"arcs with cycle rule: {points / spent:.3g} points/s")
    step = chord_step_rad(100.0, TOLERANCE)
    print(f"circle of radius 100: {ceil(2 * pi / step)} steps")
    print(f"{'points':>9} {'peak MB':>8} {'bytes/point':>12}")
    for tolerance in (1e-6, 1e-8, 1e-10):
        tracemalloc.start()
        circle = (Arc((0.0, 0.0), 1000.0, 0.0, 360.0),)
        count = len(densify(circle, DensifyRules(tolerance + 1e-10)).points)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        print(f"{count:9} {peak / 1e6:8.1f} {peak / count:12.1f}")


if __name__ == "__main__":
    start(main)
