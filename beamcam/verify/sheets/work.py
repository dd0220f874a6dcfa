"""The strokes of one process and the curves that they should follow."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import BSpline, Curve
from beamcam.machine.machine import Torch, TorchProcess
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.elements import Counts, Floats
from beamcam.verify.sheets.gaps import widest_gap
from beamcam.verify.sheets.moves import Moves
from beamcam.verify.sheets.need import Need
from beamcam.verify.sheets.splines import spans_of
from beamcam.verify.sheets.strokes import Stroke, Strokes
from beamcam.verify.sheets.ways import Ways

Flags = npt.NDArray[np.bool_]

SPACING = 4.0  #: mm between samples
MITRE = 2.5  #: how far from a corner a path may pass it, by half the kerf
#: Cubics that stand for circles miss them by 2.7e-4 of the radius; a path may be the true circle.
CIRCLE_SHARE = 3.5e-4
SHOWN = 5  #: of one kind of fault


class Traced(Struct):
    """A stroke whose leads are known."""

    stroke: Stroke
    first: int  #: of its ways along the contour
    last: int  #: behind the last of them
    half_kerf: float  #: that the path keeps off the contour
    closed: bool
    middle: tuple[float, float]  #: a place on the path
    path: Ways
    fine: float  #: what chords may be off
    ring: list[tuple[int, int]]  #: ways that go round an inside together; none if it is open
    box: tuple[float, float, float, float]  #: around the ring
    group: int  #: line of the first stroke of its contour
    inside: object = None  #: polygon of the ring, made when it is asked for


class Work(Struct, frozen=True):
    """One process: what is needed, what is followed, and how near that has to be."""

    process: TorchProcess
    strokes: Sequence[Stroke]
    moves: Moves  #: those of the strokes, one behind the other
    need: Ways
    path: Ways
    of_way: Counts  #: the stroke of each way of the path
    torch: Torch
    step: float  #: of the program's numbers
    fine: float  #: what chords may be off
    tolerance: float
    free: Floats  #: what each needed curve may be off besides
    shift: tuple[float, float]
    name: str

    @property
    def offset(self) -> bool:
        """Whether paths may keep off their contours by half a kerf."""
        return self.torch.kerf_by == "offset" and self.process == "cut"

    @property
    def bridged(self) -> bool:
        """Whether contours may have bridges."""
        return bool(self.torch.tabs) and self.process == "cut"

    def most_half_kerf(self) -> float:
        """The greatest that a stroke may keep off its contour."""
        return max(s.row.kerf / 2 for s in self.strokes) if self.offset else 0.0

    def most(self, length: float) -> float:
        """What a lead may measure at most."""
        return length * 1.001 + 8 * self.step

    def tab_width(self, half_kerf: float) -> float:
        """How far apart the strokes on both sides of a bridge may be."""
        return self.torch.tab_width + 2 * half_kerf + 2 * self.tolerance

    def extra(self, line: int, place: Floats, away: str, expected: str) -> Diagnostic:
        """That a path follows nothing."""
        x, y = place.tolist()
        return rules.EXTRA.at(
            Source(self.name, line), x=f"{x:.3f}", y=f"{y:.3f}", away=away,
            process=self.process, expected=expected,
        )  # fmt: skip

    def missing(self, place: Floats) -> Diagnostic:
        """That nothing follows a contour."""
        x, y = (place - np.array(self.shift)).tolist()
        return rules.MISSING.at(
            Source(self.name), process=self.process, x=f"{x:.3f}", y=f"{y:.3f}",
            machine_x=f"{place[0]:.3f}", machine_y=f"{place[1]:.3f}",
        )  # fmt: skip


def work_of(
    process: TorchProcess,
    strokes: Strokes,
    need: Need,
    step: float,
    torch: Torch,
    shift: tuple[float, float],
    name: str,
) -> Work:
    """The strokes of a process among all, and the curves that it needs."""
    mine = [s for s in strokes.each if s.process == process]
    counts = np.array([s.last - s.first for s in mine], dtype=np.int64)
    moves = strokes.moves
    if len(mine) < len(strokes.each):
        spans = [np.arange(s.first, s.last) for s in mine]
        moves = moves.take(np.concatenate([np.zeros(0, dtype=np.int64), *spans]))
    fine = torch.tolerance / 8
    curves = need.curves.get(process, [])
    ways = need.ways(process, fine).moved(shift)
    shares = np.zeros(len(curves))
    shares[ways.rest] = [_share(curves[k]) for k in ways.rest.tolist()]
    # What joining ends may move is allowed where there is something to join.
    tolerance = torch.tolerance + 2 * step + fine + _loose(ways, torch.gap)
    return Work(
        process, mine, moves, ways, Ways.of_moves(moves, fine),
        np.repeat(np.arange(len(mine)), counts), torch, step, fine, tolerance,
        shares * np.minimum(ways.lengths, 1e6), shift, name,
    )  # fmt: skip


def _share(curve: Curve) -> float:
    """What of its length a free curve may be off, as the circle that it stands for."""
    return CIRCLE_SHARE / (spans_of(curve) if isinstance(curve, BSpline) else 1)


def _loose(need: Ways, gap: float) -> float:
    """The widest gap between two ends that had to be joined."""
    opened = np.flatnonzero(np.hypot(*(need.ends - need.starts).T) > 1e-9)
    starts, ends = need.starts[opened], need.ends[opened]
    # Where one ends as the next begins, the place is known already.
    apart = np.any(ends != np.roll(starts, -1, axis=0), axis=1)
    return widest_gap(np.concatenate((starts, ends[apart])), gap)
