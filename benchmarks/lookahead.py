"""Prints how the time of the look-ahead grows with the segments, on rough and smooth paths.

python benchmarks/lookahead.py
"""

import time

import numpy as np
from script import arguments, start

from beamcam.geometry.curves import Arc
from beamcam.motion.densify import DensifyRules, densify
from beamcam.motion.lookahead import LookAheadRules, plan_speeds
from beamcam.motion.velocity_profile import AxisLimits


def main() -> None:
    arguments(__doc__).parse_args()
    axis = AxisLimits(200.0, 1000.0, 20_000.0)
    rules = LookAheadRules((axis, axis))
    dice = np.random.default_rng(1)
    print(f"{'path':8} {'segments':>9} {'seconds':>8} {'us/segment':>11} {'motion s':>10}")
    for count in (1_000, 10_000, 100_000, 1_000_000):
        walk = np.cumsum(dice.normal(size=(count + 1, 2)) * 5, axis=0)
        # A circle with so many sides, rounded to 0.0001 mm.
        tolerance = 20.0 * count * (1 - np.cos(np.pi / count))
        circle = densify((Arc((0.0, 0.0), 20.0 * count, 0.0, 360.0),), DensifyRules(tolerance))
        for name, points in (("walk", walk), ("circle", np.round(circle.points, 4))):
            begun = time.perf_counter()
            path = plan_speeds(points, 100.0, rules)
            spent = time.perf_counter() - begun
            segments = len(path.lengths)
            print(
                f"{name:8} {segments:9} {spent:8.2f} {spent / segments * 1e6:11.1f} "
                f"{path.duration_s:10.1f}"
            )


if __name__ == "__main__":
    start(main)
