"""The laser's path compared with the part: stroke by stroke, and then as a whole."""

from collections.abc import Collection, Iterator
from math import cbrt, sqrt
from typing import NamedTuple

import numpy as np
import shapely
from msgspec.structs import replace

from beamcam.checks.polylines import DrawnPath, compare_polylines
from beamcam.checks.sheets.asked_sheet import rows_of, rows_on
from beamcam.checks.sheets.marks import text_process
from beamcam.checks.sheets.need import Need, need_of, shift_of
from beamcam.checks.sheets.toolpaths import Toolpaths
from beamcam.checks.sheets.work import widest_joint
from beamcam.checks.steps import rules
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchProcess
from beamcam.model.part import Part

CORNER = 3.0  #: half kerfs that a path may be off a corner that it goes around
SECONDS_PER_MINUTE = 60.0
MOST_MEASURED = 100  #: points of a stroke that are too far off its curves
SPEED_SLACK = 1e-3  #: mm/s
COARSE = 2.0  #: steps by which stairs of steps are smoothed for their length
#: Permitted share below the maximum frequency of motors, for the rounding of times.
BELOW_GREATEST = 0.02


class Seen(NamedTuple):
    """A speed, and the line that it was seen at."""

    mm_s: float
    line: int


class Rest(NamedTuple):
    """A time without a step of either motor, and its place in steps."""

    seconds: float
    place: tuple[int, int]


class StrokeTimes(NamedTuple):
    """How long a stroke takes, and where it rests."""

    waited_s: float  #: before the head moves
    lasted_s: float  #: under way
    stayed_s: float = 0.0  #: behind its last step
    stood: Rest | None = None  #: the longest time without a step at a steady speed
    longest: Rest | None = None  #: the longest time without a step


class Observed(NamedTuple):
    """The speeds of the head in a stroke, and its times, as far as they are known."""

    fastest: Seen
    slowest: Seen | None = None
    times: StrokeTimes | None = None
    passes: int = 1
    path: bytes = b""  #: the same of strokes whose places are the same, one by one


class _StrokeDeviation:
    """What is drawn between on and off, and how far it is off the curves of each process.

    What is within the band of one process alone was not measured and counts as 0.
    """

    def __init__(self, line: int, processes: Collection[TorchProcess]) -> None:
        self.line = line
        self.away = dict.fromkeys(processes, 0.0)
        self.worst: dict[TorchProcess, tuple[float, float]] = {}
        self.pieces: list[Floats] = []
        self.last: Floats = np.zeros((0, 2))  #: the place that was passed last

    def middles(self, points: Floats) -> Floats:
        """The first place of a stroke, and the middles of its steps: stairs become straight."""
        places = np.concatenate((self.last, points))
        moved = np.append(True, (places[1:] != places[:-1]).any(axis=1))
        places = places[moved]
        begins = places[: 1 - len(self.last)]
        self.last = places[-1:]
        times: Floats = np.concatenate((begins, (places[1:] + places[:-1]) / 2))
        return times

    def measure(self, process: TorchProcess, track: "_Track", points: Floats) -> None:
        """How far points are off the curves of a process, unless some were too far before.

        Of the points that are too far a few are measured: the farthest of them is reported.
        """
        if self.away[process] > track.most:
            return
        away = track.toolpaths.nearest_of(track.toolpaths.near(points, track.most), len(points))[0]
        lost = np.flatnonzero(np.isinf(away))
        if len(lost):
            points = points[lost[:: len(lost) // MOST_MEASURED + 1]]
            away = track.toolpaths.nearest(points)[0]
        k = int(np.argmax(away))
        if away[k] >= self.away[process]:
            self.away[process] = float(away[k])
            self.worst[process] = float(points[k, 0]), float(points[k, 1])


class _Track:
    """The curves of a process, and the band in which a path may be.

    The ends and corners of the band are cut straight, so that nothing in it is farther off than
    `most`. To check whether a point is in it takes a fiftieth of measuring how far it is off.
    """

    def __init__(self, toolpaths: Toolpaths, most: float, fine: float) -> None:
        self.toolpaths, self.most = toolpaths, most
        lines = [
            shapely.LineString(toolpaths.outline(k, k + 1, fine)) for k in range(toolpaths.count)
        ]
        # One by one: the buffer of all at once takes the square of curves that lie on each other.
        self.band = shapely.union_all(shapely.buffer(lines, most, quad_segs=4))
        shapely.prepare(self.band)


class OutlineCheck:
    """The strokes of a table against the curves of a part; without one they are not compared.

    `rounding` is what a table may be off its path by: half a step along both axes, or the decimals
    of a velocity table. Paths of single steps are simplified by `simplify`.
    """

    def __init__(
        self, part: Part | None, machine: Machine, skips: Collection[str], rounding: float,
        simplify: float, name: str,
    ) -> None:  # fmt: skip
        torch = machine.needed(machine.torch, "torch")
        #: with the rows for the part's sheet, and with no other sheet's
        self.torch = torch if part is None else replace(torch, rows=tuple(rows_on(part, torch)))
        self.part, self.machine = part, replace(machine, torch=self.torch)
        self.skips, self.name = skips, name
        self.rounding, self.simplify = rounding, simplify
        self.diagnostics: list[Diagnostic] = []
        self.drawn: list[DrawnPath] = []
        self._path = b""  #: of the stroke before
        #: whether anything is followed more than once
        self.counts_passes = part is not None and any(
            row.passes > 1 for row in rows_of(part, self.torch)
        )
        self.tracks: dict[TorchProcess, _Track] = {}
        self.feeds: dict[TorchProcess, list[float]] = {}  #: mm/min; then of colours and layers
        self.pierce_s: dict[TorchProcess, float] = {}
        self.need = Need()
        self._stroke: _StrokeDeviation | None = None
        #: the process of texts, whose strokes are found when all are known; None without texts
        self.letters: TorchProcess | None = None
        if part is None:
            return
        torch = self.torch
        if any(part.texts) and machine.marks.text == "make" and machine.marks.unit != "none":
            self.letters = text_process(machine)
        rows = rows_of(part, torch)
        for row in rows:
            self.pierce_s.setdefault(row.process, row.pierce_s)
            feeds = self.feeds.setdefault(row.process, [])
            if row.feed_mm_min not in feeds:
                feeds.append(row.feed_mm_min)
        need = self.need = need_of(part, self.machine, torch, skips)
        shift, fine = shift_of(need, torch), torch.tolerance / 8
        for process, curves in need.curves.items():
            toolpaths = Toolpaths(list(curves), fine).moved(shift)
            # How far a path may be from its curves: that is for telling strokes apart; what they
            # leave of the part is compared as a whole.
            reach = 0.0
            if process == "cut":
                kerfs = [row.kerf for row in rows if row.process == process]
                kerf = max(kerfs, default=0.0) if torch.kerf_by == "offset" else 0.0
                leads = 0.0 if torch.lead == "none" else max(torch.lead_in, torch.lead_out)
                reach = CORNER * kerf / 2 + leads
            most = rounding + torch.tolerance + reach + widest_joint(toolpaths, torch.gap)
            self.tracks[process] = _Track(toolpaths, most, fine)

    def begin(self, line: int) -> None:
        """The laser is switched on."""
        self._stroke = _StrokeDeviation(line, self.tracks)

    def draw(self, points: Floats, corners: Floats | None = None) -> None:
        """The head passes some points (n, 2) with the laser on.

        `corners` are those that the path is made of, if it is known.
        """
        stroke = self._stroke
        if self.part is None or stroke is None:
            return
        inside = []
        for process, track in self.tracks.items():
            off = ~shapely.contains_xy(track.band, points)
            if off.any():
                stroke.measure(process, track, points[off])
            else:
                inside.append(process)
        if len(inside) > 1:  # near the curves of several: it matters how near
            for process in inside:
                stroke.measure(process, self.tracks[process], points)
        if corners is not None:
            stroke.pieces.append(corners)
        elif len(middles := stroke.middles(points)):
            stroke.pieces.append(simple(middles, self.simplify))

    def end(self, seen: Observed) -> None:
        """The laser is switched off.

        The table does not say which process a stroke is of: it is that whose curves it is on.
        """
        stroke, self._stroke = self._stroke, None
        if self.part is None or stroke is None:
            return
        process = min(
            stroke.away, key=lambda p: (stroke.away[p] > self.tracks[p].most, stroke.away[p]),
            default=None,
        )  # fmt: skip
        if self.letters and (process is None or stroke.away[process] > self.tracks[process].most):
            process = self.letters
        points = np.concatenate((*stroke.pieces, stroke.last))
        source = Source(self.name, stroke.line)
        if (points == points[0]).all():
            found = f"the laser on and the head at rest{self._beside(points[0], process)}"
            diagnostic = rules.LASER.at(source, found=found, expected="a stroke")
        elif process is None:
            diagnostic = rules.PLACE.at(source, x="any", y="any", expected="the laser off")
        elif process != self.letters and stroke.away[process] > (most := self.tracks[process].most):
            worst = stroke.worst[process]
            x, y = (f"{v:.2f}" for v in worst)
            off, beside = f"{stroke.away[process]:.4f}", self._beside(np.array(worst), process)
            expected = f"it within {most:.4f} mm of the path, not {off} mm off it{beside}"
            diagnostic = rules.PLACE.at(source, x=x, y=y, expected=expected)
        elif process not in self.feeds:
            found, expected = f"{seen.fastest.mm_s:.2f}", "a sheet that the machine has a speed for"
            diagnostic = rules.SPEED.at(source, found=found, process=process, expected=expected)
        else:
            self._add(process, source, seen, points)
            return
        self.diagnostics.append(diagnostic)

    def _add(self, process: TorchProcess, source: Source, seen: Observed, points: Floats) -> None:
        """A stroke with the speeds that it may be of, and what is wrong with its times.

        One that repeats the stroke before it is another pass of that.
        """
        if seen.times is not None:
            self.diagnostics += self._rests(process, source, seen.times, points)
        wrong = {
            feed: [*self._speeds(process, feed, seen, points[0]),
                   *self._pace(process, feed, source, seen, points)]
            for feed in self.feeds[process]
        }  # fmt: skip
        feeds = tuple([feed for feed, diagnostics in wrong.items() if not diagnostics])
        if not feeds:
            of_contour = self.feeds[process][0]  #: that is nearest to its start
            if process in self.tracks:
                nearest = self.tracks[process].toolpaths.nearest_to(points[0])[1]
                own = self.torch.settings.get(self.need.looks[process][nearest])
                if own is not None and own.speed is not None:
                    of_contour = own.speed
            self.diagnostics += wrong[of_contour]
        last = self.drawn[-1] if self.drawn else None
        both = [feed for feed in last.feeds_mm_min if feed in feeds] if last else []
        if last and both and seen.path and (seen.path, process) == (self._path, last.process):
            passes = last.passes + seen.passes
            self.drawn[-1] = replace(last, passes=passes, feeds_mm_min=tuple(both))
        else:
            places = [(float(x), float(y)) for x, y in points]
            self.drawn.append(DrawnPath(process, places, feeds, seen.passes))
        self._path = seen.path

    def nearest(self, place: Floats) -> str:
        """The contour of the input that is nearest to a place, for the end of a message."""
        if not self.tracks:
            return ""
        process = min(self.tracks, key=lambda p: self.tracks[p].toolpaths.nearest_to(place)[0])
        return self._beside(place, process)

    def _beside(self, place: Floats, process: TorchProcess | None) -> str:
        """The contour of the input that a stroke at a place is beside; letters have none."""
        if process not in self.tracks:
            return ""
        nearest = self.tracks[process].toolpaths.nearest_to(place)[1]
        return f", beside the contour of {self.need.source(process, nearest)}"

    def _speeds(
        self, process: TorchProcess, feed_mm_min: float, seen: Observed, place: Floats
    ) -> Iterator[Diagnostic]:
        """Whether a stroke, which passes `place`, is faster or slower than it has to be."""
        speed = feed_mm_min / SECONDS_PER_MINUTE
        fastest, slowest = seen.fastest, seen.slowest
        speeds = [(fastest, fastest.mm_s > speed + SPEED_SLACK, "at most")]
        if slowest is not None:
            speeds.append((slowest, slowest.mm_s < speed - SPEED_SLACK, "at least"))
        for one, is_wrong, how in speeds:
            if is_wrong:
                expected = f"{how} {speed:g} mm/s{self._beside(place, process)}"
                at = Source(self.name, one.line)
                found = f"{one.mm_s:.2f}"
                yield rules.SPEED.at(at, found=found, process=process, expected=expected)

    def _rests(
        self, process: TorchProcess, source: Source, times: StrokeTimes, points: Floats
    ) -> Iterator[Diagnostic]:
        """Whether the laser pierces before the head moves, and rests nowhere else.

        The first step of a ramp, and the last one, take their time; in a corner both do.
        """
        pierce_s = self.pierce_s[process]
        stepper = self.machine.needed(self.machine.stepper, "stepping motors")
        way = sqrt(2.0) * stepper.step
        slowest = min(self.feeds[process]) / SECONDS_PER_MINUTE
        ramp_s = cbrt(6 * way / stepper.jerk) + sqrt(2 * way / stepper.acceleration)
        ramp_s += way / slowest
        rests = [
            (times.waited_s, pierce_s - 1e-6, pierce_s + ramp_s, f"{pierce_s:g} s",
             "behind the start of the laser", points[0]),
            (times.stayed_s, 0.0, ramp_s, "it off at once", "behind the last step", points[-1]),
        ]  # fmt: skip
        for rest, most, where in (
            (times.longest, 2 * ramp_s, "in a stroke"), (times.stood, 0.0, "at a steady speed")
        ):  # fmt: skip
            if rest is not None:
                place = np.array(rest.place) * stepper.step
                rests.append((rest.seconds, 0.0, most, "none", where, place))
        for seconds, least, most, expected, where, place in rests:
            if not least <= seconds <= most:
                yield rules.LASER.at(
                    source, found=f"a wait of {seconds:.3f} s {where} with the laser on",
                    expected=f"{expected}{self._beside(place, process)}",
                )  # fmt: skip

    def _pace(
        self, process: TorchProcess, feed_mm_min: float, source: Source, seen: Observed,
        points: Floats,
    ) -> Iterator[Diagnostic]:  # fmt: skip
        """Whether the head takes longer for its way than it has to.

        It may come to rest at every corner, which takes as long again as one ramp of its speed.
        """
        if seen.times is None:
            return
        stepper = self.machine.needed(self.machine.stepper, "stepping motors")
        greatest = stepper.step * stepper.max_hz * (1.0 - BELOW_GREATEST)
        speed = min(feed_mm_min / SECONDS_PER_MINUTE, greatest)
        ramp_s = speed / stepper.acceleration + stepper.acceleration / stepper.jerk
        corners = simple(points, COARSE * stepper.step)
        way = float(np.hypot(*np.diff(corners, axis=0).T).sum())
        longest_s = way / speed + len(corners) * ramp_s
        if seen.times.lasted_s > longest_s:
            found = f"{way / seen.times.lasted_s:.2f}"
            expected = f"about {speed:g} mm/s{self._beside(points[0], process)}"
            yield rules.SPEED.at(source, found=found, process=process, expected=expected)

    def compare(self) -> list[Diagnostic]:
        """All differences of the strokes from the part."""
        if self.part is None or self.diagnostics:
            return self.diagnostics
        slack = self.rounding + self.simplify
        return compare_polylines(
            self.drawn, self.part, self.machine, self.skips, slack, self.name, self.simplify > 0.0
        )


def simple(points: Floats, slack: float) -> Floats:
    """The corners of a path, which miss none of its points by more than `slack`."""
    if len(points) < 2:
        return points
    line = shapely.LineString(points).simplify(slack, preserve_topology=False)
    corners: Floats = shapely.get_coordinates(line)
    return corners
