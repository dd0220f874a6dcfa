"""The strokes of one process and the curves that they should follow."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.gaps import widest_gap
from beamcam.verify.sheets.need import Need
from beamcam.verify.sheets.strokes import Stroke, Strokes
from beamcam.verify.sheets.ways import Ways

if TYPE_CHECKING:
    from shapely import Polygon

    from beamcam.verify.sheets.region import Region

SPACING = 4.0  #: mm between samples
MITRE = 2.5  #: how far from a corner a path may pass it, by half the kerf
SHOWN = 5  #: of one kind of fault


class Traced(Struct):
    """A stroke whose leads are known, and what it goes round."""

    stroke: Stroke
    first: int  #: of its ways along the contour
    last: int  #: behind the last of them
    half_kerf: float  #: that the path keeps off the contour
    closed: bool
    path: Ways
    fine: float  #: what chords may be off
    ring: list[tuple[int, int]]  #: ways that go round an inside together; none if it is open
    middle: tuple[float, float]  #: a place on the contour
    box: tuple[float, float, float, float]  #: around the ring
    group: int  #: of strokes of one contour
    goes_round: bool  #: by itself, or with others and the bridges between them
    contour: "Polygon | None" = None  #: inside of the closed contour that it keeps off

    def inside(self) -> "Polygon | None":
        """The polygon that it goes round; None of less than a triangle, or if another has it."""
        import shapely

        if self.contour is not None or not self.ring:
            return self.contour
        points = np.concatenate([self.path.outline(a, b, self.fine) for a, b in self.ring])
        return shapely.make_valid(shapely.Polygon(points)) if len(points) > 3 else None

    def corners(self) -> Floats:
        """Places of the contour, (n, 2); chords between them are at most `fine` off."""
        import shapely

        if self.contour is None:
            return self.path.outline(self.first, self.last, self.fine)
        found: Floats = shapely.get_coordinates(self.contour)
        return found


class Work(Struct, frozen=True):
    """One process: what is needed, what is followed, and how near that has to be."""

    process: TorchProcess
    strokes: Sequence[Stroke]
    moves: Moves  #: those of the strokes, one behind the other
    need: Ways
    asked: Need  #: the curves that `need` is made of, and where the input has them
    path: Ways
    of_way: Counts  #: the stroke of each way of the path
    torch: Torch
    step: float  #: of the program's numbers
    fine: float  #: what chords may be off
    tolerance: float
    slack: Floats  #: what each needed curve may be off: the tolerance and what joining may move
    half_kerf: float  #: of the beam, that keeps off closed contours; 0 stays on them
    region: "Region | None"  #: of a beam that keeps off
    small: Flags  #: needed curves that are too small to be cut
    shift: tuple[float, float]
    name: str

    @property
    def beside(self) -> Flags:
        """The required curves with kerf compensation."""
        return np.zeros(self.need.count, dtype=bool) if self.region is None else self.region.closed

    def on_kept_off(self, points: Floats) -> Flags:
        """Points that lie on a contour which the beam keeps off.

        What is open there is drawn twice, or ends on the contour.
        """
        found = np.zeros(len(points), dtype=bool)
        if self.half_kerf:
            pairs = self.need.near(points, self.torch.gap)
            found[pairs.point[self.beside[self.need.owner[pairs.element]]]] = True
        return found

    @property
    def bridged(self) -> bool:
        """Whether contours may have bridges."""
        return bool(self.torch.tabs) and self.process == "cut"

    def most(self, length: float) -> float:
        """Maximum length of a lead; the controller takes up half a kerf along it."""
        taken_up = 2 * self.half_kerf if self.torch.kerf_by == "machine" else 0.0
        return length * 1.001 + 8 * self.step + taken_up

    def tab_width(self, half_kerf: float) -> float:
        """How far apart the strokes on both sides of a bridge may be."""
        return self.torch.tab_width + 2 * half_kerf + 2 * self.tolerance

    def contour(self, way: int) -> str:
        """Source of a required curve."""
        return str(self.asked.source(self.process, way))

    def contour_at(self, place: Floats) -> str:
        """Source of the required curve nearest to a place."""
        return self.contour(self.need.nearest_to(place)[1])

    def extra(self, line: int, place: Floats, away: str, expected: str) -> Diagnostic:
        """That a path follows nothing."""
        x, y = place.tolist()
        source = Source(self.name, line)
        return rules.EXTRA.at(source, x=f"{x:.3f}", y=f"{y:.3f}", away=away, expected=expected)

    def missing(self, way: int, place: Floats) -> Diagnostic:
        """That nothing follows a contour."""
        x, y = (place - np.array(self.shift)).tolist()
        return rules.MISSING.at(
            Source(self.name), process=self.process, contour=self.contour(way),
            x=f"{x:.3f}", y=f"{y:.3f}", machine_x=f"{place[0]:.3f}", machine_y=f"{place[1]:.3f}",
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
    half_kerf = _half_kerf(process, mine, torch)
    region = None
    tolerance = torch.tolerance + 2 * step + fine
    # What joining ends may move is allowed where there is something to join.
    if half_kerf and len(curves):
        from beamcam.verify.sheets.region import region_of

        features = np.array(need.features[process])
        region = region_of(ways, features, torch.gap, fine)
        joined = region.apart
    else:
        tolerance += _loose(ways, torch.gap)
        joined = np.zeros(len(curves))
    slack = tolerance + joined
    return Work(
        process, mine, moves, ways, need, Ways.of_moves(moves, fine),
        np.repeat(np.arange(len(mine)), counts), torch, step, fine, tolerance,
        slack, half_kerf, region, _small(ways, torch.gap), shift, name,
    )  # fmt: skip


def _small(ways: Ways, gap: float) -> Flags:
    """Curves no larger than the gap that is closed between two ends."""
    if not (ways.lengths <= 4 * gap).any():
        return np.zeros(ways.count, dtype=bool)
    from beamcam.verify.sheets.region import small_ways

    return small_ways(ways, gap)


def _half_kerf(process: TorchProcess, strokes: Sequence[Stroke], torch: Torch) -> float:
    """Half the compensated kerf of a process on closed contours."""
    if process != "cut" or torch.kerf_by == "none":
        return 0.0
    return max((s.row.kerf / 2 for s in strokes), default=0.0)


def _loose(need: Ways, gap: float) -> float:
    """The widest gap between two ends that had to be joined."""
    opened = np.flatnonzero(np.hypot(*(need.ends - need.starts).T) > 1e-9)
    starts, ends = need.starts[opened], need.ends[opened]
    # Where one ends as the next begins, the place is known already.
    apart = np.any(ends != np.roll(starts, -1, axis=0), axis=1)
    return widest_gap(np.concatenate((starts, ends[apart])), gap)
