"""What the torch of a coper does: each stroke from pierce to end, and what is wrong on its way."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import cos, hypot, isfinite, pi, radians, sin, tan
from typing import Any

from msgspec import Struct

from beamcam.checks.coping import rules
from beamcam.checks.coping.chart import CoperJob
from beamcam.checks.coping.section import (
    ARC,
    CoperSection,
    jet_of,
    kerf_of,
    line_of,
    narrowed,
    pieces_of,
)
from beamcam.controllers import cell_events
from beamcam.controllers.events import (
    BarEvent,
    Blending,
    Compensation,
    Move,
    Pause,
    Place,
    Said,
    Switch,
)
from beamcam.errors import Diagnostic, Source, add_few
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow

ANGLES = {-90.0: "o", 0.0: "v", 90.0: "u"}  #: what the torch looks at, by A
ANGLE_SLACK_DEG = 0.01
TINY = 1e-12  #: of the square of a lean
HEIGHT_SLACK = 0.02  #: mm
MIDDLE_SLACK = 0.05  #: mm of height on the way of a block on which the torch or the bar turns
AT_END = 0.01  #: mm from the ends of a path
TIME_SLACK_S = 0.0006
LONGEST_PAUSE_S = 60.0  #: with the torch off
ENDS = (2, 30)
#: What words of a torch are filled with to see which M words they are.
_FIGURES = {
    "height": "200", "width": "100", "feed": "1000", "power": "0", "pierce": "1",
    "pierce_height": "1", "cut_height": "1",
}  # fmt: skip


class TorchStroke(Struct, frozen=True):
    """What is cut between torch on and torch off, square to one wall or tilted off its normal."""

    line: int
    face: str
    #: x of the part and y of the face, where the torch points at
    points: tuple[Point, ...]
    places: tuple[Point, ...]  #: Y and Z of the tip
    row: TorchRow
    b_deg: float = 0.0  #: tilt of the torch towards X, where it starts
    #: how far the head is over along x and y of the face, by mm of height, at each of `points`;
    #: empty where the torch looks square at the face but for a tilt that stands still
    leans: tuple[Point, ...] = ()

    def at(self, depth: float) -> tuple[Point, ...]:
        """Where it goes through a plane so far below the face."""
        if self.leans:
            return tuple(
                (x - depth * lx, y - depth * ly)
                for (x, y), (lx, ly) in zip(self.points, self.leans, strict=True)
            )
        back = depth * tan(radians(self.b_deg))
        return tuple((x - back, y) for x, y in self.points)

    @property
    def is_tilted(self) -> bool:
        return bool(self.b_deg or self.leans)

    @property
    def across(self) -> tuple[float, float]:
        """Its least and its greatest y."""
        ys = [y for _, y in self.points]
        return min(ys), max(ys)

    @property
    def share(self) -> float:
        """The cosine of its angle to the wall's normal; along B how much narrower the wall is."""
        if self.leans:
            return 1.0 / hypot(1.0, *self.leans[0])
        return cos(radians(self.b_deg))

    def jet(self, depth: float) -> Any:
        """What the jet takes so far below the face, as wide as its kerf square to itself."""
        import numpy as np
        from shapely import convex_hull, linestrings, union_all
        from shapely.affinity import affine_transform

        points, half = self.at(depth), self.row.kerf / 2
        if not self.leans:
            return jet_of(points, half, self.share)
        if len({*self.leans}) == 1:
            seen = [stretched(place, self.leans[0], False) for place in points]
            kerf = kerf_of(seen, half)
            return affine_transform(kerf, [*_stretch(self.leans[0], True), 0.0, 0.0])
        leans, turns = np.array(self.leans), 2 * pi * np.arange(4 * ARC) / (4 * ARC)
        far = np.square(leans).sum(axis=1)
        longer = (np.sqrt(1.0 + far) - 1.0) / np.maximum(far, TINY)  # 0 where it stands square
        ring = half * np.column_stack((np.cos(turns), np.sin(turns)))
        more = longer[:, None, None] * (leans @ ring.T)[:, :, None] * leans[:, None, :]
        rounds = np.array(points)[:, None, :] + ring + more
        both = np.concatenate((rounds[:-1], rounds[1:]), axis=1)
        return union_all(convex_hull(linestrings(both)))

    def pierced(self, depth: float) -> Any:
        """What piercing takes there."""
        from shapely import Point as Place
        from shapely import Polygon

        (x, y), radius = self.at(depth)[0], self.row.pierce_radius
        if self.leans:
            turns = (2 * pi * k / (4 * ARC) for k in range(4 * ARC))
            round_it = ((radius * cos(t), radius * sin(t)) for t in turns)
            oval = (stretched(place, self.leans[0], True) for place in round_it)
            return Polygon([(x + dx, y + dy) for dx, dy in oval])
        share = self.share
        return narrowed(Place(x * share, y).buffer(radius, ARC), 1.0 / share)


def stretched(place: Point, lean: Point, longer: bool) -> Point:
    """A place as long along a lean as a surface cuts a round jet that leans so; or back again."""
    (x, y), (xx, xy, yx, yy) = place, _stretch(lean, longer)
    return x * xx + y * xy, x * yx + y * yy


def _stretch(lean: Point, longer: bool) -> tuple[float, float, float, float]:
    """The matrix of `stretched`, row by row."""
    lx, ly = lean
    long = hypot(1.0, lx, ly)
    by = ((long if longer else 1.0 / long) - 1.0) / (lx * lx + ly * ly or 1.0)
    return 1.0 + by * lx * lx, by * lx * ly, by * lx * ly, 1.0 + by * ly * ly


def through_root(
    face: str, section: CoperSection, strokes: Sequence[TorchStroke]
) -> list[TorchStroke]:
    """The strokes on a flange that go through the whole of its root."""
    back, front = section.root(face)
    there = (stroke for stroke in strokes if stroke.face == face)
    return [one for one in there if one.across[0] <= back and one.across[1] >= front]


def in_air(points: Sequence[Point], steel: Any, row: TorchRow, coper: Coper) -> Point | None:
    """A place of a path in air, but just beyond the edges where it begins and ends; or None.

    Where its lead begins on an edge it goes on beside that edge to the contour.
    """
    path = line_of(points)
    ends = [line_of([points[k]]) for k in (0, -1)]
    for air in pieces_of(path.difference(steel.buffer(row.kerf / 4))):
        at_end = any(air.distance(end) <= AT_END for end in ends)
        if air.length > (coper.over + 3 * row.kerf if at_end else row.kerf):
            x, y = air.representative_point().coords[0]
            return x, y
    return None


class TipMove(Struct, frozen=True, gc=False):
    """A move of the tip, in machine coordinates, with A at both ends."""

    line: int
    start: Place
    end: Place
    a_deg: tuple[float, float]
    b_deg: tuple[float, float] = (0.0, 0.0)


class TorchFollower(ABC):
    """Follows the events of a program."""

    turning = False  #: whether A may turn with the torch on, which is upright then

    def __init__(self, job: CoperJob) -> None:
        self.diagnostics: list[Diagnostic] = []
        self.strokes: list[TorchStroke] = []
        self.ways: list[TipMove] = []
        machine, coper = job.machine, job.coper
        self._job, self._coper = job, coper
        self._on_words, self._off_words = (_switches(machine, w) for w in ("cut_on", "cut_off"))
        self._on_at: int | None = None  #: line of the word that started it
        self._waited = 0.0
        self._moves: list[Move[Place]] = []  #: since it was started
        self._is_placed = False  #: whether any place of the tip is known yet
        #: by the place of its figure among X, Y, Z, A and B
        self._limited = [("XYZAB".index(axis.moves), *axis.limits, axis.name)
                         for axis in machine.axes if axis.moves in "XYZAB"]  # fmt: skip
        self._a_deg: float | None = None
        self._tilts = coper.tilt > 0.0
        #: the M words that say a measured height or width, each by its number and its letters
        self._measuring = {
            name: [(number, *(letter for letter, _ in said))
                   for number, said in _switches(machine, f"measured_{name}")]
            for name in ("height", "width")
        }  # fmt: skip
        self._measured: dict[str, list[float]] = {name: [] for name in self._measuring}

    def follow(self, events: Sequence[BarEvent]) -> None:
        """All events of a program, in order."""
        for event in events:
            match event:
                case Move():
                    self._move(event)
                case Switch():
                    self._switch(event)
                case Pause():
                    self._pause(event)
                case Blending():
                    if not event.distance <= self._coper.tolerance / 2:
                        self._wrong(
                            event.line, f"corners passed {event.distance:g} mm off the path",
                            f"at most {self._coper.tolerance / 2:g} mm",
                        )  # fmt: skip
                case Compensation():
                    if event.side != "on":
                        self._wrong(event.line, "kerf compensation", "none, paths keep it off")
                case _:
                    self._wrong(event.line, type(event).__name__, "no such word of a coper")
        if self._on_at is not None:
            self._wrong(self._on_at, "the torch left on", "it off at the end")
        for (name, figures), size in zip(self._measured.items(), self.sizes, strict=True):
            if self._measuring[name] and len(figures) != 1:
                found = f"{len(figures)} figures of the bar's {name}"
                expected = "one, by the words of the machine file"
                self._say(rules.MEASURED.at(self._job.at(), found=found, expected=expected))
            for figure in figures:
                if abs(figure - size) > self._coper.rolled:
                    self._say(rules.MEASURED.at(
                        self._job.at(), found=f"a {name} of {figure:g} mm",
                        expected=f"{size:g} mm, {self._coper.rolled:g} mm more or less",
                    ))  # fmt: skip

    @property
    @abstractmethod
    def sizes(self) -> tuple[float, float]:
        """The height and the width of the bar by its section."""

    def _wrong(self, line: int, found: str, expected: str) -> None:
        self._say(rules.TORCH.at(self._job.at(line), found=found, expected=expected))

    def _say(self, diagnostic: Diagnostic) -> None:
        add_few(self.diagnostics, diagnostic)

    def _switch(self, event: Switch) -> None:
        if event.said in self._on_words:
            if self._on_at is not None:
                self._wrong(event.line, "the torch started twice", "it off before")
            if not self._is_placed or self._a_deg is None:
                self._wrong(event.line, "the torch started nowhere", "a place and A before")
            self._on_at, self._waited, self._moves = event.line, 0.0, []
        elif event.said in self._off_words:
            if self._on_at is not None:
                self._end(self._on_at)
            self._on_at = None
        elif names := [
            name for name, carriers in self._measuring.items()
            if (event.number, *sorted(event.words)) in carriers
        ]:  # fmt: skip
            if self._on_at is not None or self.strokes:
                self._wrong(event.line, f"{event} behind a cut", "it in the head")
            self._measured[names[0]] += event.words.values()
        elif event.number not in ENDS:
            self._wrong(event.line, str(event), "the words of cut_on and cut_off, and no others")

    def _pause(self, event: Pause) -> None:
        if self._on_at is None:
            if event.seconds > LONGEST_PAUSE_S:
                self._wrong(event.line, f"a wait of {event.seconds:g} s", "a minute at most")
        elif self._moves:
            self._wrong(event.line, "a wait on the way of a cut", "none, the torch burns on")
        else:
            self._waited += event.seconds

    def _move(self, move: Move[Place]) -> None:
        is_on = self._on_at is not None
        if move.curve is not None:
            self._wrong(move.line, "a curve", "straight moves")
        if is_on and move.rapid:
            self._wrong(move.line, "a rapid move with the torch on", "one at the feed")
        if not is_on and not move.rapid:
            self._wrong(move.line, "a move at the feed with the torch off", "a rapid one")
        self._limits(move)
        a_before, a_deg = move.a_deg
        tilts = move.b_deg if self._tilts else (0.0, 0.0)
        if not isfinite(sum(move.end) + a_deg + tilts[1]):
            if is_on:
                self._wrong(move.line, "a cut from or to nowhere", "X, Y, Z, A and B before")
            elif self._is_placed or isfinite(sum(move.end) + a_deg):
                self._wrong(move.line, "a move of a torch that may be tilted", "B before")
            self._a_deg = a_deg if isfinite(a_deg) else None
            return
        may_turn = self.turning or (self._tilts and move.minutes > 0.0)
        if is_on and not may_turn and a_before != a_deg:
            self._say(rules.ANGLE.at(self._job.at(move.line), found=f"{a_deg:g}, turning"))
        if is_on and not may_turn and tilts[0] != tilts[1]:
            found, expected = f"{tilts[1]:g}, turning", f"{self._coper.tilt:g}"
            self._say(rules.TILT.at(self._job.at(move.line), found=found, expected=expected))
        if self._is_placed and isfinite(sum(move.start) + a_before + tilts[0]):
            self.ways.append(TipMove(move.line, move.start, move.end, move.a_deg, tilts))
        if is_on:
            self._moves.append(move)
        self._is_placed, self._a_deg = True, a_deg

    def _tip_of(self, place: Place, a_deg: float, b_deg: float = 0.0) -> Place:
        """Where the tip is: what the program says, or a pivot's length below the axes."""
        return below(place, self._coper.pivot, a_deg, b_deg)

    def _as_written(self, a_deg: float) -> float:
        """A in the unit of the program and of its axis."""
        return a_deg

    def _limits(self, move: Move[Place]) -> None:
        figures = (*move.end, self._as_written(move.a_deg[1]), move.b_deg[1])
        for place, least, most, axis in self._limited:
            found = figures[place]
            if not least <= found <= most and isfinite(found):
                self._say(rules.LIMIT.at(
                    self._job.at(move.line), axis=axis, found=f"{found:g}",
                    least=f"{least:g}", most=f"{most:g}",
                ))  # fmt: skip

    def _end(self, line: int) -> None:
        """A stroke that is whole."""
        moves = [m for m in self._moves if isfinite(sum((*m.start, *m.end, *m.a_deg)))]
        if moves:
            self._take(line, moves)
        else:
            self._wrong(line, "the torch started and stopped in one place", "a cut between")

    @abstractmethod
    def _take(self, line: int, moves: Sequence[Move[Place]]) -> None:
        """Adds the stroke of some moves, and says what is wrong with it."""

    def _heights(
        self, source: Source, face: str, row: TorchRow, ends: Sequence[float],
        between: Sequence[float],
    ) -> None:  # fmt: skip
        """Says where the torch does not wait as long as its row asks for, and where its tip is not
        as high over the steel: at the `ends` of moves, the first of which is where it pierces, and
        `between` them as it cuts."""
        if abs(self._waited - row.pierce_s) > TIME_SLACK_S:
            found = f"{self._waited:g}"
            self._say(rules.PIERCE.at(source, found=found, expected=f"{row.pierce_s:g}"))
        off = max(between, key=lambda one: abs(one - row.cut_height), default=row.cut_height)
        for over, height, most, does in (
            (ends[:1], row.pierce_height, HEIGHT_SLACK, "pierces"),
            (ends[1:], row.cut_height, HEIGHT_SLACK, "cuts"),
            ((off,), row.cut_height, MIDDLE_SLACK, "cuts on its way"),
        ):
            if (found_at := next((h for h in over if abs(h - height) > most), None)) is not None:
                self._say(rules.HEIGHT.at(
                    source, found=f"{found_at:.3f}", face=face, does=does, expected=f"{height:g}"
                ))  # fmt: skip


def below(place: Place, far: float, a_deg: float, b_deg: float) -> Place:
    """A place so far from another along the torch, away from its head.

    The head is at X sin B, Y -sin A cos B, Z cos A cos B of its tip.
    """
    (x, y, z), a, b = place, radians(a_deg), radians(b_deg)
    across = far * cos(b)
    return x - far * sin(b), y + across * sin(a), z - across * cos(a)


def _switches(machine: Machine, word: str) -> frozenset[Said]:
    """The M words that a template of the machine file is made of."""
    text = "\n".join(line.format_map(_Filled(_FIGURES)) for line in getattr(machine.words, word))
    events, _ = cell_events(text + "\n", machine, "")
    return frozenset(event.said for event in events if isinstance(event, Switch))


class _Filled(dict[str, str]):
    """Figures of a template; what is known of a part stands in comments, and is left empty."""

    def __missing__(self, _: str) -> str:
        return ""
