"""Step tables read back: the motors followed step by step, and the path compared with the sheet.

Reads the text and the binary form, piece by piece. Nothing is shared with motion or emitters.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import pairwise
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from beamcam.errors import Diagnostic, Rule, Severity, Source, errors_in
from beamcam.machine.machine import Machine, TorchProcess
from beamcam.machine.tables import Stepper
from beamcam.model.part import Part

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
FeatureRef = tuple[int, int]

_E = Severity.ERROR

ROW = Rule(
    "steps-row",
    _E,
    "found {found}; expected {expected}",
    "The micro-controller would stop there, or read something else.",
)
WORD = Rule(
    "steps-word",
    _E,
    "found word {found} of {axis} behind {before}; expected a neighbour in the sequence {sequence}",
    "A motor that is told to jump loses its place.",
)
TIME = Rule(
    "steps-time",
    _E,
    "found {found}; expected {expected}",
    "Rows are sent in the order of their times.",
)
FREQUENCY = Rule(
    "steps-frequency",
    _E,
    "found steps of {axis} {found} us apart; expected at least {expected} us",
    "A motor that is asked for more steps than it can do loses its place.",
)
ACCELERATION = Rule(
    "steps-acceleration",
    _E,
    "found {axis} at {found} mm/s2; expected at most {expected} mm/s2",
    "A motor cannot jump to another speed.",
)
LASER = Rule(
    "steps-laser",
    _E,
    "found {found}; expected {expected}",
    "The laser starts and ends in the shielded corner, switched off.",
)
PLACE = Rule(
    "steps-place",
    _E,
    "found the head at X {x}, Y {y}; expected {expected}",
    "The head would be somewhere else than the drawing.",
)

RULES = (ROW, WORD, TIME, FREQUENCY, ACCELERATION, LASER, PLACE)

_MAGIC = b"BCSTEPS1"
_HEAD_BYTES = 32
_ROW_BYTES = 21  #: 12 digits, 3 commas, 2 + 2 + 1 bits and the end of the line
WINDOW_US = 20_000  #: over which accelerations are looked at
SIMPLIFY = 0.75  #: steps that a path may be simplified by before it is compared as a whole
SHOWN = 5


class Rows:
    """Some rows as they stand in a table."""

    __slots__ = ("first", "laser", "time_us", "x", "y")

    def __init__(self, first: int, time_us: Ints, x: Ints, y: Ints, laser: Ints) -> None:
        self.first = first  #: line of the first of them
        self.time_us, self.x, self.y, self.laser = time_us, x, y, laser


class TableFault(Exception):
    """A table that cannot be read."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(str(diagnostic))
        self.diagnostic = diagnostic


def read_rows(pieces: Iterable[bytes], name: str) -> Iterator[Rows]:
    """The rows of a table, text or binary. Raises TableFault."""
    stream = iter(pieces)
    head = next(stream, b"")
    if head.startswith(_MAGIC):
        yield from _binary(head, stream, name)
    else:
        yield from _text(head, stream, name)


def _fault(name: str, line: int | None, found: str, expected: str) -> TableFault:
    return TableFault(ROW.at(Source(name, line), found=found, expected=expected))


def _binary(head: bytes, stream: Iterator[bytes], name: str) -> Iterator[Rows]:
    rest = head[_HEAD_BYTES:]
    clock, first = 0, 1
    while True:
        whole = len(rest) // 4 * 4
        packed = np.frombuffer(rest[:whole], dtype="<u4").astype(np.int64)
        if whole:
            time = clock + np.cumsum(packed >> 5)
            clock = int(time[-1])
            yield Rows(first, time, packed & 3, packed >> 2 & 3, packed >> 4 & 1)
            first += len(packed)
        piece = next(stream, None)
        if piece is None:
            if len(rest) > whole:
                raise _fault(name, None, f"{len(rest) - whole} bytes at the end", "rows of 4")
            return
        rest = rest[whole:] + piece


def _text(head: bytes, stream: Iterator[bytes], name: str) -> Iterator[Rows]:
    rest = head
    line = 1
    while True:  # comments and the names of the columns
        begin, newline, more = rest.partition(b"\n")
        if not newline:
            piece = next(stream, None)
            if piece is None:
                raise _fault(name, line, "no rows", "time_us,x,y,laser")
            rest += piece
            continue
        rest, line = more, line + 1
        if begin == b"time_us,x,y,laser":
            break
        if not begin.startswith(b"#"):
            raise _fault(name, line - 1, begin[:40].decode("ascii", "replace"), "time_us,x,y,laser")
    width = _ROW_BYTES
    while True:
        whole = len(rest) // width * width
        if whole:
            rows = _text_rows(rest[:whole], width, line, name)
            yield rows
            line += len(rows.x)
        piece = next(stream, None)
        if piece is None:
            if len(rest) > whole:
                found = rest[whole:].decode("ascii", "replace")
                raise _fault(name, line, repr(found), "rows of 20 signs")
            return
        rest = rest[whole:] + piece


def _text_rows(data: bytes, width: int, line: int, name: str) -> Rows:
    signs = np.frombuffer(data, dtype=np.uint8).reshape(-1, width)
    fixed = (signs[:, [12, 15, 18]] == ord(",")).all(axis=1) & (signs[:, 20] == ord("\n"))
    figures = signs[:, [*range(12), 13, 14, 16, 17, 19]].astype(np.int64) - ord("0")
    good = fixed & (figures >= 0).all(axis=1) & (figures[:, :12] <= 9).all(axis=1)
    good &= (figures[:, 12:] <= 1).all(axis=1)
    if not good.all():
        bad = int(np.argmin(good))
        found = signs[bad].tobytes().decode("ascii", "replace")
        raise _fault(name, line + bad, repr(found), "as 000000001234,01,10,1")
    time = figures[:, :12] @ (10 ** np.arange(11, -1, -1))
    x, y = 2 * figures[:, 12] + figures[:, 13], 2 * figures[:, 14] + figures[:, 15]
    return Rows(line, time, x, y, figures[:, 16])


class _Axis:
    """One motor: where it stands, and when it stepped last."""

    def __init__(self, name: str, stepper: Stepper) -> None:
        forward = [int(word, 2) for word in stepper.sequence]
        sign = -1 if name in stepper.reversed_axes else 1
        self.name, self.sequence = name, " ".join(stepper.sequence)
        self.phase = np.zeros(4, dtype=np.int64)
        self.phase[forward] = np.arange(4)
        self.sign = sign
        self.place = 0
        self.last_phase = 0
        self.last_us = -(10**12)
        self.least_us = int(1e6 / stepper.greatest_hz)

    def follow(self, rows: Rows, words: Ints, name: str) -> tuple[Ints, list[Diagnostic]]:
        """The places behind each row, and what is wrong with the steps."""
        said = []
        phase = self.phase[words]
        turn = (np.diff(phase, prepend=self.last_phase)) & 3
        if (turn == 2).any():
            k = int(np.argmax(turn == 2))
            before = words[k - 1] if k else np.flatnonzero(self.phase == self.last_phase)[0]
            said.append(
                WORD.at(
                    Source(name, rows.first + k), found=f"{int(words[k]):02b}", axis=self.name,
                    before=f"{int(before):02b}", sequence=self.sequence,
                )
            )  # fmt: skip
        moves = np.where(turn == 3, -1, turn) * self.sign
        places: Ints = self.place + np.cumsum(moves)
        steps = np.flatnonzero(turn)
        if len(steps):
            apart = np.diff(rows.time_us[steps], prepend=self.last_us)
            if int(apart.min()) < self.least_us:
                k = int(np.argmin(apart))
                said.append(
                    FREQUENCY.at(
                        Source(name, rows.first + int(steps[k])), axis=self.name,
                        found=int(apart[k]), expected=self.least_us,
                    )
                )  # fmt: skip
            self.last_us = int(rows.time_us[steps[-1]])
        self.last_phase, self.place = int(phase[-1]), int(places[-1])
        return places, said


class _Table:
    """A table that is followed from its first row to its last."""

    def __init__(self, machine: Machine, name: str) -> None:
        if machine.stepper is None or machine.torch is None:
            raise TypeError(f"{machine.name} has no stepping motors")
        self.stepper, self.torch, self.name = machine.stepper, machine.torch, name
        self.axes = (_Axis("X", self.stepper), _Axis("Y", self.stepper))
        self.said: list[Diagnostic] = []
        self.strokes: list[list[Ints]] = []
        self.samples: list[NDArray[np.int64]] = []
        self.laser = 0
        self.clock_us = 0
        self.here = (0, 0)
        self._next_us = 0

    def say(self, found: Iterable[Diagnostic]) -> None:
        for one in found:
            if sum(d.code == one.code for d in self.said) < SHOWN:
                self.said.append(one)

    def follow(self, rows: Rows) -> None:
        """Take some rows."""
        source = Source(self.name, rows.first)
        if int(rows.time_us[0]) < self.clock_us or (np.diff(rows.time_us) < 0).any():
            self.say([TIME.at(source, found="a time before the last one", expected="a later one")])
        places = []
        for axis, words in zip(self.axes, (rows.x, rows.y), strict=True):
            at, said = axis.follow(rows, words, self.name)
            places.append(at)
            self.say(said)
        at_xy = np.stack(places, axis=1)
        self._switches(rows, at_xy)
        self._area(rows, at_xy)
        self._sample(rows, at_xy)
        self.clock_us, self.here = int(rows.time_us[-1]), (int(at_xy[-1, 0]), int(at_xy[-1, 1]))

    def _switches(self, rows: Rows, places: Ints) -> None:
        """Cut the rows where the laser is switched, and keep the places where it is on."""
        before = np.append(self.laser, rows.laser[:-1])
        changes = np.flatnonzero(rows.laser != before)
        start = np.concatenate(([self.here], places[:-1]))
        if (places[changes] != start[changes]).any():
            source = Source(self.name, rows.first)
            found = "a step in the row that switches the laser"
            self.say([LASER.at(source, found=found, expected="the head at rest")])
        edges = [0, *changes.tolist(), len(rows.laser)]
        for a, b in pairwise(edges):
            if b > a and rows.laser[a]:
                if a in changes or not self.strokes:
                    self.strokes.append([])
                self.strokes[-1].append(places[a:b])
        self.laser = int(rows.laser[-1])

    def _area(self, rows: Rows, places: Ints) -> None:
        limits = np.array([self.torch.length, self.torch.width]) / self.stepper.step + 1
        outside = ((places < -1) | (places > limits)).any(axis=1)
        if outside.any():
            k = int(np.argmax(outside))
            x, y = (f"{v * self.stepper.step:.2f}" for v in places[k].tolist())
            expected = f"it between 0, 0 and {self.torch.length:g}, {self.torch.width:g}"
            source = Source(self.name, rows.first + k)
            self.say([PLACE.at(source, x=x, y=y, expected=expected)])

    def _sample(self, rows: Rows, places: Ints) -> None:
        """Places at every multiple of the window."""
        times = np.arange(self._next_us, int(rows.time_us[-1]) + 1, WINDOW_US)
        if len(times):
            k = np.searchsorted(rows.time_us, times, side="right") - 1
            known = np.concatenate((places, [self.here]))
            self.samples.append(known[k])
            self._next_us = int(times[-1]) + WINDOW_US

    def finish(self) -> None:
        """What can be said at the end only."""
        end = Source(self.name)
        if self.laser:
            self.say([LASER.at(end, found="the laser on at the end", expected="it off")])
        if self.here != (0, 0):
            x, y = (f"{v * self.stepper.step:.2f}" for v in self.here)
            self.say([PLACE.at(end, x=x, y=y, expected="it in the corner at the end")])
        self._accelerations()

    def _accelerations(self) -> None:
        """Second differences of places against what the axes can do.

        A motor stands half a step off its path, and the path up to `corner` off one that keeps
        the acceleration, so that each of the three places may be off by both.
        """
        if not self.samples:
            return
        places = np.concatenate([*self.samples, [self.here, self.here]]) * self.stepper.step
        window_s = WINDOW_US / 1e6
        second = np.abs(np.diff(places, n=2, axis=0))
        if not len(second):
            return
        slack = 4 * (self.stepper.step / 2 + self.stepper.corner)
        greatest = self.stepper.acceleration * window_s**2 + slack
        for k, axis in enumerate("XY"):
            worst = float(second[:, k].max())
            if worst > greatest:
                found = f"{worst / window_s**2:.0f}"
                expected = f"{self.stepper.acceleration:g}"
                self.say(
                    [ACCELERATION.at(Source(self.name), axis=axis, found=found, expected=expected)]
                )


def verify_steps(
    table: str | Iterable[bytes],
    parts: Sequence[Part],
    machine: Machine,
    skipped: Collection[FeatureRef] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with a step table, by itself and against its part.

    `table` is its text, or the bytes of either form piece by piece.
    """
    pieces = (table.encode("ascii", "replace"),) if isinstance(table, str) else table
    followed = _Table(machine, name)
    try:
        for rows in read_rows(pieces, name):
            followed.follow(rows)
    except TableFault as fault:
        return (*followed.said, fault.diagnostic)
    followed.finish()
    said = followed.said
    if errors_in(said) or not parts:
        return tuple(said)
    (part,) = parts
    step = followed.stepper.step
    strokes: list[Floats] = [
        np.asarray(np.concatenate(places) * step, dtype=np.float64) for places in followed.strokes
    ]
    said += _compared(strokes, part, machine, skipped, name)
    return tuple(said)


def _compared(
    strokes: Sequence[Floats],
    part: Part,
    machine: Machine,
    skipped: Collection[FeatureRef],
    name: str,
) -> list[Diagnostic]:
    import shapely

    from beamcam.geometry.curves import Curve
    from beamcam.verify.polylines import compare_polylines
    from beamcam.verify.sheets.need import need_of, shift_of
    from beamcam.verify.sheets.ways import Ways

    torch, stepper = machine.torch, machine.stepper
    assert torch is not None
    assert stepper is not None
    need = need_of(part, torch, {feature for _, feature in skipped})
    processes: list[TorchProcess] = []
    tracks: dict[TorchProcess, Ways] = {}
    for process, curves in need.curves.items():
        listed: list[Curve] = list(curves)
        tracks[process] = Ways(listed, torch.tolerance / 8, shift_of(need, torch))
    greatest = stepper.step * sqrt(0.5) + torch.tolerance
    for points in strokes:
        # The table does not say which process a stroke is of: it is that whose curves it is on.
        away = {p: track.nearest(points)[0] for p, track in tracks.items()}
        if not away:
            return [PLACE.at(Source(name), x="any", y="any", expected="the laser off")]
        process = min(away, key=lambda p: float(away[p].max()))
        worst = int(np.argmax(away[process]))
        if away[process][worst] > greatest:
            x, y = (f"{v:.2f}" for v in points[worst].tolist())
            off = f"{float(away[process][worst]):.4f}"
            expected = f"it within {greatest:.4f} mm of the path, not {off} mm off"
            return [PLACE.at(Source(name), x=x, y=y, expected=expected)]
        processes.append(process)
    simple = []
    for process, points in zip(processes, strokes, strict=True):
        line = shapely.LineString(points) if len(points) > 1 else None
        if line is not None:
            smooth = line.simplify(SIMPLIFY * stepper.step, preserve_topology=False)
            simple.append((process, [(float(x), float(y)) for x, y in smooth.coords]))
    slack = stepper.step * (sqrt(0.5) + SIMPLIFY)
    return compare_polylines(simple, part, machine, skipped, slack, name)
