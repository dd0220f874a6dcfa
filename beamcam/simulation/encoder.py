"""What an encoder shows of a trace: the staircase of its counts, and what is lost by it.

true   ____/      an encoder shows the count that the axis has passed last, so that the true
read  __|-'       point lies within a count above what is read: in a square of that side;
                  centred, it lies within half a count on either side
"""

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Floats
from beamcam.simulation.trace import Trace, share_of

ROUNDING = 1e-9  #: of a count; an axis that stands on a count is at it
BISECTIONS = 48
MIN_MOVE = 1e-6  #: mm; less is rounding
MIN_TURN = 1e-9  #: how far the cosine between two ways is below 1; less is rounding


class Encoder(Struct, frozen=True):
    """An encoder on each axis that is measured in mm."""

    pulses_per_turn: int
    travel_per_turn: float  #: mm
    quadrature: bool = False  #: whether each pulse is four counts
    centred: bool = False  #: whether the nearest count is read, instead of the one below

    @property
    def counts_per_turn(self) -> int:
        """Counts of a turn."""
        return self.pulses_per_turn * (4 if self.quadrature else 1)

    @property
    def count(self) -> float:
        """mm of a count."""
        return self.travel_per_turn / self.counts_per_turn

    @property
    def shown(self) -> str:
        """What it is, for people."""
        text = f"{self.counts_per_turn} counts in {self.travel_per_turn:g} mm"
        if self.quadrature:
            text += f" (quadrature of {self.pulses_per_turn})"
        return f"{text}, the nearest count read" if self.centred else text

    def counts(self, positions: Floats) -> Floats:
        """Positions in counts, so that what is read is the whole count below."""
        return positions / self.count + (0.5 if self.centred else 0.0)

    def read(self, trace: Trace, positions: Floats) -> Floats:
        """What is read of positions (times, axes); axes that are not measured in mm are true."""
        counted = np.floor(self.counts(positions) + ROUNDING) * self.count
        return np.where(np.array([axis.is_read for axis in trace.axes]), counted, positions)


class Precision(Struct, frozen=True):
    """Precision of an encoder for one program, from its resolution."""

    count: float  #: mm
    max_corner_error: float  #: mm between a corner of the path and what is read there
    mean_corner_error: float
    corners: int
    worst_line: int  #: of the program, where the corner that is furthest off ends; 0 without one
    worst_time_s: float  #: when that corner is passed
    smallest_step: float  #: mm, of what a straight piece of the path moves an axis
    lost_moves: int  #: moves of an axis shorter than a count
    moves: int


def stair_times(trace: Trace, encoder: Encoder) -> Floats:
    """The knots of a trace, and each time at which an axis passes from count to count."""
    times = [trace.time_s]
    for k, axis in enumerate(trace.axes):
        if axis.is_read:
            times.append(_crossings(trace, encoder.counts(trace.positions[:, k])))
    return np.unique(np.concatenate(times))


def _crossings(trace: Trace, counts: Floats) -> Floats:
    """When an axis whose position is read in counts passes a whole one."""
    start, way = counts[:-1], np.diff(counts)
    least, most = np.minimum(counts[:-1], counts[1:]), np.maximum(counts[:-1], counts[1:])
    first = np.ceil(least - ROUNDING)
    number = np.maximum(0, np.floor(most + ROUNDING) - first + 1).astype(np.int64)
    number[way == 0.0] = 0
    interval = np.repeat(np.arange(len(way)), number)
    whole = (
        first[interval] + np.arange(len(interval)) - np.repeat(np.cumsum(number) - number, number)
    )
    share = np.clip((whole - start[interval]) / way[interval], 0.0, 1.0)
    # The share of the time at which each share of the way is done, by bisection.
    low, high = np.zeros_like(share), np.ones_like(share)
    slopes = trace.slopes[interval]
    for _ in range(BISECTIONS):
        u = (low + high) / 2
        behind = share_of(u, slopes[:, 0], slopes[:, 1]) < share
        low, high = np.where(behind, u, low), np.where(behind, high, u)
    passed: Floats = trace.time_s[interval] + high * np.diff(trace.time_s)[interval]
    return passed


def precision(trace: Trace, encoder: Encoder) -> Precision:
    """The study of a trace, over its axes in mm."""
    linear = [k for k, axis in enumerate(trace.axes) if axis.is_read]
    at = trace.positions[:, linear]
    ways = np.diff(at, axis=0)
    going = np.flatnonzero(np.any(np.abs(ways) > MIN_MOVE, axis=1))
    unit = ways[going] / np.sqrt(np.sum(ways[going] ** 2, axis=1))[:, None]
    turned = np.sum(unit[:-1] * unit[1:], axis=1) < 1.0 - MIN_TURN
    blocks = trace.line[going]
    begins = np.flatnonzero(np.append(True, turned | (np.diff(blocks) != 0)))
    moves = np.add.reduceat(ways[going], begins) if len(going) else ways
    moved = np.abs(moves[np.abs(moves) > MIN_MOVE])
    corners = going[:-1][turned] + 1
    read = encoder.read(trace, trace.positions)[:, linear]
    errors = np.sqrt(np.sum((at - read)[corners] ** 2, axis=1))
    worst = int(corners[errors.argmax()]) if len(corners) else 0
    return Precision(
        encoder.count, float(errors.max(initial=0.0)),
        float(errors.mean()) if len(errors) else 0.0, len(corners),
        int(trace.line[worst - 1]) if len(corners) else 0, float(trace.time_s[worst]),
        float(moved.min()) if len(moved) else 0.0, int((moved < encoder.count).sum()), len(moved),
    )  # fmt: skip
