"""A plate cut as a solid by the events of its program alone, and the pieces that come free.

    sheet - what the torch sweeps, as wide as the kerf -> pieces; what reaches the sheet's edge is
    the frame that stays behind

All cuts of a torch go straight through, so that the solid is the plane shape over the thickness.
Marks take nothing.
"""

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

from msgspec import Struct
from shapely import LineString, Polygon, box, union_all
from shapely import Point as Place

from beamcam.controllers.events import Compensation, HeadMove, Move, Switch, TableEvent
from beamcam.errors import BeamcamError, Source
from beamcam.geometry.curves import Curve, Line, Point
from beamcam.geometry.polylines import polylines
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchRow, is_row_for
from beamcam.solid import NO_SOLID
from beamcam.solid.kernel import CHORD, facets

Shape = Any  #: of shapely
AROUND = 20.0  #: mm of sheet round all cuts
AT_ONCE = 500  #: chords of a path that are swept as one
HAIR = 0.01  #: mm of width of a cut whose kerf no one makes up for
PROCESSES = ("cut", "mark", "engrave", "spot")
ENDS = (2, 30)
_M_WORD = re.compile(r"\s*M0*(\d+)(?!\d)(.*)")
_ADDRESS = re.compile(r"([A-Z$])(?:\{(\w+)\}|(-?\d+(?:\.\d+)?))")


class Starting(Struct, frozen=True):
    """The M word that starts the tool of a process."""

    process: str
    number: int
    fixed: frozenset[tuple[str, float]]  #: its parameters that are always the same
    carried: tuple[tuple[str, str], ...]  #: letter and name of those that carry a figure

    def takes(self, switch: Switch) -> bool:
        """Whether a word of a program is this one."""
        letters = {letter for letter, _ in (*self.fixed, *self.carried)}
        return (
            switch.number == self.number
            and switch.words.keys() == letters
            and self.fixed <= {*switch.words.items()}
        )


class SweptStroke(Struct):
    """The moves of the head between on and off."""

    switch: Switch
    process: str
    side: str
    radius: float
    moves: list[HeadMove]


def starting_words(machine: Machine) -> tuple[Starting, ...]:
    """The words that start each tool, by the machine's templates.

    Of several M words it is the one that the file calls so, else M3 or M4, else one that it says
    nothing of; M7 to M9 only where there is no other.
    """
    startings = []
    for process in PROCESSES:
        several = []
        for line in getattr(machine.words, f"{process}_on"):
            match = _M_WORD.match(line)
            place = None if match is None else _place(int(match[1]), match[2], machine)
            if match is not None and place is not None:
                several.append((place, match))
        for _, match in sorted(several, key=lambda one: one[0])[:1]:
            addresses = _ADDRESS.findall(match[2])
            fixed = frozenset((a, float(value)) for a, name, value in addresses if not name)
            carried = tuple((a, name) for a, name, _ in addresses if name and name != "feed")
            startings.append(Starting(process, int(match[1]), fixed, carried))
    return tuple(startings)


def _place(number: int, carried: str, machine: Machine) -> int | None:
    """How likely an M word is to start a tool, 0 first; None of one that does something else."""
    words = {f"{letter}{float(value):g}" for letter, _, value in _ADDRESS.findall(carried) if value}
    for key, meaning in machine.codes.items():
        match = _M_WORD.match(key)
        if match and int(match[1]) == number and (not match[2] or match[2].strip() in words):
            return 0 if meaning in ("torch on", "cutting oxygen on") else None
    return 1 if number in (3, 4) else 3 if number in (7, 8, 9) else 2


def strokes_of(
    events: Sequence[TableEvent], machine: Machine, rows: Sequence[TorchRow], name: str
) -> list[SweptStroke]:
    """The strokes of a program whose sheet is worked by `rows`.

    Where one word starts several tools, power and feed say which.
    """
    known = starting_words(machine)
    strokes: list[SweptStroke] = []
    on: SweptStroke | None = None
    side, radius = "on", 0.0
    for event in events:
        if isinstance(event, Switch):
            starts = [one for one in known if one.takes(event)]
            if starts and on is None:
                on = SweptStroke(event, "|".join(s.process for s in starts), side, radius, [])
                strokes.append(on)
            elif not starts:  # any other word stops it, as does the end
                on = None
        elif isinstance(event, Compensation):
            side, radius = event.side, event.radius
        elif isinstance(event, Move) and on is not None:
            on.moves.append(event)
    for stroke in strokes:
        if "|" in stroke.process:
            stroke.process = _process(stroke, known, rows, name)
    return strokes


def _process(
    stroke: SweptStroke, known: Sequence[Starting], rows: Sequence[TorchRow], name: str
) -> str:
    """Of several processes with one word that whose row has the stroke's power and feed."""
    feeds = {move.feed_mm_min for move in stroke.moves if move.feed_mm_min > 0}
    fitting = set()
    for row in rows:
        words = next(
            (w for w in known if w.process == row.process and w.takes(stroke.switch)), None
        )
        if words is None:
            continue
        powers = [stroke.switch.words[a] for a, what in words.carried if what == "power"]
        if all(abs(p - row.power) <= 0.5 for p in powers) and (
            not feeds or min(abs(f - row.feed_mm_min) for f in feeds) <= 1e-3 * row.feed_mm_min
        ):
            fitting.add(row.process)
    if len(fitting) == 1:
        return fitting.pop()
    found = f"a stroke that may {' or '.join(sorted(fitting)) or 'do nothing that is known'}"
    raise BeamcamError(NO_SOLID.at(Source(name, stroke.switch.line), found=found))


def pieces_cut(strokes: Sequence[SweptStroke], kerf: float) -> list[Shape]:
    """The pieces that come free of the sheet, in X and Y of the table; cut-outs among them."""
    return left_of([shape for s in strokes if s.process == "cut" for shape in taken_by(s, kerf)])


def left_of(taken: Sequence[Shape]) -> list[Shape]:
    """The pieces that come free where something is taken out of a sheet that is larger."""
    gone = union_all(taken)
    if gone.is_empty:
        return []
    x0, y0, x1, y1 = gone.bounds
    sheet = box(x0 - AROUND, y0 - AROUND, x1 + AROUND, y1 + AROUND)
    left = sheet.difference(gone)
    edge = sheet.exterior
    return [one for one in getattr(left, "geoms", (left,)) if not one.intersects(edge)]


def taken_by(stroke: SweptStroke, kerf: float) -> Iterator[Shape]:
    """What the torch sweeps on a stroke: its path, as the controller keeps it off, by the kerf."""
    half = max(kerf, HAIR) / 2
    quarter = facets(half) // 4
    curves: list[Curve] = [m.curve or Line(m.start, m.end) for m in stroke.moves]
    if not curves:
        return
    drawn = polylines(curves, CHORD / 2)
    path = [stroke.moves[0].start]
    for first, last in pairwise(drawn.begins.tolist()):
        path += [(x, y) for x, y in drawn.points[first + 1 : last].tolist()]
    path = [path[0], *(b for a, b in pairwise(path) if a != b)]
    if len(path) < 2:
        yield from (Place(p).buffer(half, quad_segs=quarter) for p in path)
        return
    # A path that runs over itself many times is swept bit by bit: as one it takes gigabytes.
    lines = [LineString(path[k : k + AT_ONCE + 1]) for k in range(0, len(path) - 1, AT_ONCE)]
    if stroke.side != "on" and stroke.radius > 0.0:
        lines = _kept_off(path, stroke.radius if stroke.side == "left" else -stroke.radius)
    yield from (line.buffer(half, quad_segs=quarter) for line in lines if not line.is_empty)


def _kept_off(path: list[Point], left: float) -> list[Shape]:
    """Where the controller leads the tool beside a path, left of it or, below 0, right.

    Round corners that it passes outside, and no farther than it gets into those inside. A path that
    closes is a loop, with a lead before it and one behind it.
    """
    quarter = 4 * facets(abs(left))
    # The longest stretch that comes back to where it began, at the end of the path without one.
    begin = end = len(path) - 1
    seen: dict[Point, int] = {}
    for at, (x, y) in enumerate(path):
        first = seen.setdefault((round(x, 3), round(y, 3)), at)
        if at - first > max(end - begin, 2):
            begin, end = first, at
    lines = []
    for open_path in (path[: begin + 1], path[end:]):
        if len(open_path) > 1:
            line = LineString(open_path)
            lines.append(line.offset_curve(left, quad_segs=quarter, join_style="round"))
    if end > begin:
        ring = Polygon(path[begin : end + 1])
        grown = -left if ring.exterior.is_ccw else left
        # In the corner between a lead and the loop the tool turns where it is as far from both.
        near = ring.exterior.buffer(abs(left) - CHORD, quad_segs=quarter)
        lines = [line.difference(near) for line in lines]
        lines.append(ring.buffer(grown, quad_segs=quarter).boundary)
    return lines


def rows_for(torch: Torch, thickness: float, material: str) -> list[TorchRow]:
    """The rows of the cut chart for a sheet: of each process the first that is thick enough.

    Their feed is that for the sheet. The speeds and powers of colours and layers are rows of their
    own.
    """
    import numpy as np
    from msgspec.structs import replace

    rows: dict[str, TorchRow] = {}
    for row in torch.rows:
        if thickness <= row.up_to and is_row_for(row.material, material):
            rows.setdefault(row.process, row)
    if torch.between_rows == "interpolate":
        for process, row in rows.items():
            chart = {
                r.up_to: r.feed_mm_min for r in torch.rows
                if r.process == process
                and (r.material, r.amps, r.nozzle) == (row.material, row.amps, row.nozzle)
            }  # fmt: skip
            feed = float(np.interp(thickness, sorted(chart), [chart[k] for k in sorted(chart)]))
            rows[process] = replace(row, feed_mm_min=feed)
    more = [
        replace(
            rows[torch.colours[key]],
            feed_mm_min=own.speed or rows[torch.colours[key]].feed_mm_min,
            power=rows[torch.colours[key]].power if own.power is None else own.power,
        )
        for key, own in torch.settings.items()
        if torch.colours.get(key) in rows
    ]
    return [*rows.values(), *more]
