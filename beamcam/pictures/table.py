"""The picture of a table's program: the path of the head, coloured by its speed.

Drawn from the trace that the simulator makes of what was read back: where a tool is switched on
stands a numbered circle, leads lie on a broad band, ways with no tool on are dashed. A small
picture in the upper right corner shows where the path lies within the limits of the machine.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.curves import Line
from beamcam.machine.machine import Machine
from beamcam.machine.torch import ORIGINS
from beamcam.pictures.scene import (
    MM_PER_INCH,
    SPEED_COLOURS,
    Circle,
    Labels,
    PaperFrame,
    Polyline,
    Scene,
    Shape,
    Text,
    Unit,
    shown,
)
from beamcam.pictures.views import (
    SIDE,
    TITLE,
    WIDTH,
    View,
    figures,
    footing,
    head_height,
    heading,
    laid_out,
    measured,
)
from beamcam.recovery.paths import ring_of
from beamcam.simulation.trace import Trace, runs

SECONDS_PER_MINUTE = 60.0
MIN_MOVE = 1e-6
MAX_RINGS = 4000  #: moves of a stroke in which leads are looked for
MAX_NUMBERS = 400  #: strokes that are numbered
PIERCE = 2.2  #: radius of the circle where a tool starts
SHARE = 0.3  #: of the length or width of a sheet that a path takes, for the sheet to be shown
MARGIN = 0.08  #: of the path's size round it, where it is shown alone
TABLE_SIDE = 62.0  #: of the picture of the whole table
TABLE_HEAD = 84.0  #: least height of a heading that it stands in
Box = tuple[float, float, float, float]  #: least X and Y, greatest X and Y


class TableMade(Struct, frozen=True):
    """Data of a table's program."""

    trace: Trace
    machine: Machine
    name: str
    sha256: str
    kerf_offset: float = 0.0  #: mm that the controller keeps off the path itself

    @property
    def strokes(self) -> list[tuple[int, int, str]]:
        """First interval, the one behind the last, and process of each start of a tool."""
        process = [state.process for state in self.trace.states]
        state = self.trace.state
        each = [(a, b, process[int(state[a])]) for a, b in runs(state)]
        return [stroke for stroke in each if stroke[2]]

    @property
    def speeds_mm_s(self) -> Floats:
        """Mean speed of the block that each interval belongs to; 0 where nothing moves."""
        trace = self.trace
        ways = np.hypot(*np.diff(trace.positions[:, :2], axis=0).T)
        moving = ways > MIN_MOVE
        opens = np.append(True, (np.diff(trace.line) != 0) | (np.diff(trace.state) != 0))
        block = np.cumsum(opens[: len(ways)]) - 1
        lasts = np.bincount(block, np.diff(trace.time_s) * moving)[block] if len(block) else ways
        ways = np.bincount(block, ways)[block] * moving if len(block) else ways
        speeds: Floats = np.divide(ways, lasts, out=np.zeros_like(ways), where=lasts > 0.0)
        return speeds


def table_scene(table: TableMade, unit: Unit = "mm") -> Scene:
    """The way of the head over the table."""
    trace, strokes = table.trace, table.strokes
    places = trace.positions[:, :2]
    low, high = places.min(axis=0), places.max(axis=0)
    box = (float(low[0]), float(low[1]), max(float(high[0]), float(low[0]) + 1.0),
           max(float(high[1]), float(low[1]) + 1.0))  # fmt: skip
    seconds = round(trace.duration_s)
    took = f"{seconds // 60} min {seconds % 60:02d} s"
    lines = [table.name, f"{table.machine.name}, {len(strokes)} paths, {took}"]
    limits = _limits(trace)
    sheet = sheet_of(table.machine)
    framed = _frame_of(box, sheet)
    least = TABLE_HEAD if limits else 0.0
    view = View("table", "", framed, tuple(_steps(framed, 0)), tuple(_steps(framed, 1)))
    (view,), y = laid_out((view,), max(head_height(lines) - 8.0, least - TITLE))
    frame = view.frame
    speeds = table.speeds_mm_s
    on = np.zeros(len(trace.line), dtype=bool)
    for a, b, _ in strokes:
        on[a:b] = True
    fastest = float(speeds[on].max(initial=0.0)) or 1.0
    colours = speed_classes(speeds, fastest)
    drawn: list[Shape] = [*heading(lines)]
    if limits:
        drawn += _overview(table.machine, limits, box, unit)
    drawn += _ground(framed, sheet, box, frame)
    drawn += figures(view, unit)
    drawn += _path(trace, strokes, on, colours, frame)
    drawn += _pierces(trace, strokes, frame)
    # A bar of a round length at the right.
    per_unit = 1.0 if unit == "mm" else MM_PER_INCH
    length = _step((framed[2] - framed[0]) / per_unit) * per_unit
    right = WIDTH - SIDE
    drawn += measured((right - length * frame.scale, y), (right, y), length, unit)
    used = sorted({int(k) for k in colours[on & (speeds > 0.0)]})
    has_leads = any(shape.classes == "lead" for shape in drawn)
    drawn += _legend(fastest, used, has_leads, y + 24.0)
    x0, y0, x1, y1 = (shown(v, unit) for v in box)
    notes = [f"path X {x0} to {x1}, Y {y0} to {y1} {unit}",
             f"{table.name}   sha-256 {table.sha256}"]  # fmt: skip
    if table.kerf_offset:
        offset = shown(table.kerf_offset, unit)
        notes.append(f"path as programmed; the controller keeps {offset} {unit} off it (G41, G42)")
    drawn += footing(notes, y + 38.0)
    about = (
        f"program {table.name} as interpreted: {len(strokes)} paths, "
        f"{trace.duration_s:.1f} s; sha-256 {table.sha256}"
    )
    return Scene(table.name, about, WIDTH, y + 84.0, tuple(drawn))


def sheet_of(machine: Machine) -> Box | None:
    """The sheet as it lies about X 0, Y 0: the whole table where none was named; None without.

    Of an origin in the work the sheet lies with its own such point there.
    """
    torch = machine.torch
    if torch is None:
        return None
    u, v = ORIGINS.get(torch.origin, (0.0, 0.0))
    x, y = -u * torch.length, -v * torch.width
    return x, y, x + torch.length, y + torch.width


def _frame_of(box: Box, sheet: Box | None) -> Box:
    """What the picture shows: the sheet with all of the path, or of a large one what is worked.

    A path that takes but a corner of its sheet would be a speck; the small picture of the whole
    table shows where it lies.
    """
    grown = [v + k * MARGIN * max(box[2] - box[0], box[3] - box[1])
             for v, k in zip(box, (-1, -1, 1, 1), strict=True)]  # fmt: skip
    if sheet is None:
        return grown[0], grown[1], grown[2], grown[3]
    share = max(
        (box[2] - box[0]) / (sheet[2] - sheet[0]), (box[3] - box[1]) / (sheet[3] - sheet[1])
    )
    if share >= SHARE:
        return (min(sheet[0], box[0]), min(sheet[1], box[1]), max(sheet[2], box[2]),
                max(sheet[3], box[3]))  # fmt: skip
    # As far as the sheet goes, unless the path leaves it.
    x0, y0 = (min(max(grown[k], sheet[k]), box[k]) for k in (0, 1))
    x1, y1 = (max(min(grown[k], sheet[k]), box[k]) for k in (2, 3))
    return x0, y0, x1, y1


def _step(length: float) -> float:
    """A round step of a grid, of which a length has about ten."""
    power: float = 10.0 ** np.floor(np.log10(length / 10.0))
    return next(power * k for k in (1, 2, 5, 10) if power * k >= length / 12.0)


def _steps(box: Box, axis: int) -> list[float]:
    """The lines of the grid across an axis."""
    step = _step(max(box[2] - box[0], box[3] - box[1]))
    first, last = np.ceil(box[axis] / step - 1e-9), np.floor(box[axis + 2] / step + 1e-9)
    return [round(k * step, 6) for k in range(int(first), int(last) + 1)]


def _ground(framed: Box, sheet: Box | None, box: Box, frame: PaperFrame) -> Iterator[Shape]:
    """The sheet, the grid, the axes through X 0 and Y 0."""
    yield Polyline("face table", frame.all(_corners(framed)), True)
    for x in _steps(framed, 0):
        yield Polyline("grid", frame.all(((x, framed[1]), (x, framed[3]))))
    for y in _steps(framed, 1):
        yield Polyline("grid", frame.all(((framed[0], y), (framed[2], y))))
    if sheet is not None:
        seen = [max(framed[0], sheet[0]), max(framed[1], sheet[1]), min(framed[2], sheet[2]),
                min(framed[3], sheet[3])]  # fmt: skip
        for k in range(4):
            across = ((seen[k], seen[1]), (seen[k], seen[3]))
            ends = across if k % 2 == 0 else ((seen[0], seen[k]), (seen[2], seen[k]))
            if seen[k] == sheet[k]:
                yield Polyline("datum sheet-edge", frame.all(ends), False, "edge of the sheet")
    if framed[0] <= 0.0 <= framed[2] and framed[1] <= 0.0 <= framed[3]:
        (x, y), long = frame.at(0.0, 0.0), 40.0
        for (dx, dy), name in (((1, 0), "X"), ((0, -1), "Y")):
            tip = (x + dx * long, y + dy * long)
            wings = [(tip[0] - 7 * dx + k * 4 * dy, tip[1] - 7 * dy + k * 4 * dx) for k in (1, -1)]
            yield Polyline("axis", ((x, y), tip, wings[0], tip, wings[1]))
            yield Text("heading", (tip[0] + 4 * dx + 3, tip[1] + 4 * dy - 3), name, 11.0)


def _limits(trace: Trace) -> Box | None:
    """How far the axes go; None where the machine's file does not say it of each."""
    x, y = trace.axes[:2]
    if x.min is None or x.max is None or y.min is None or y.max is None:
        return None
    return x.min, y.min, x.max, y.max


def _overview(machine: Machine, limits: Box, box: Box, unit: Unit) -> Iterator[Shape]:
    """The table as far as its axes go, and in it the box of the path; red where it leaves it."""
    inside = all(a <= b for a, b in zip(limits[:2], box[:2], strict=True))
    inside = inside and all(a >= b for a, b in zip(limits[2:], box[2:], strict=True))
    low_x, low_y = (min(limits[k], box[k]) for k in (0, 1))
    high_x, high_y = (max(limits[k], box[k]) for k in (2, 3))
    scale = TABLE_SIDE / max(high_y - low_y, (high_x - low_x) / 3)
    left = WIDTH - SIDE - (high_x - low_x) * scale
    frame = PaperFrame(scale, left - low_x * scale, 14.0 + high_y * scale)
    (x0, y0, x1, y1), shape = (shown(v, unit) for v in limits), frame.all(_corners(limits))
    yield Polyline("face limits", shape, True, "the limits of the axes")
    style = "cut-edge work" if inside else "off work"
    yield Polyline(style, frame.all(_corners(box)), True, "the box of the path")
    lines = [f"X {x0} to {x1}, Y {y0} to {y1} {unit}"]
    if machine.torch is not None:
        torch = machine.torch
        lines.insert(0, f"table {shown(torch.length, unit)} x {shown(torch.width, unit)} {unit}")
    if not inside:
        lines.append("the path leaves it")
    for k, text in enumerate(lines):
        yield Text("label", (left - 8.0, 24.0 + 14.0 * k), text, 10.0, "end")


def _corners(box: Box) -> tuple[tuple[float, float], ...]:
    return (box[0], box[1]), (box[2], box[1]), (box[2], box[3]), (box[0], box[3])


def speed_classes(speeds: Floats, fastest: float) -> Counts:
    """The colour of each speed, 0 to 7 in equal steps up to the fastest with a tool on."""
    count = len(SPEED_COLOURS)
    classes: Floats = np.clip(np.ceil(speeds / fastest * count - 1e-6) - 1, 0, count - 1)
    return classes.astype(np.int64)


def _drawn(
    trace: Trace, first: int, last: int, frame: PaperFrame
) -> tuple[tuple[float, float], ...]:
    """The corners of some intervals; those that do not turn the way are left out."""
    points = trace.positions[first : last + 1, :2]
    step = np.diff(points, axis=0)
    moves = np.hypot(step[:, 0], step[:, 1]) > MIN_MOVE
    points = np.concatenate((points[:1], points[1:][moves]))
    step = np.diff(points, axis=0)
    if len(step) > 1:
        length = np.hypot(step[:, 0], step[:, 1])
        turn = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]
        same = np.sum(step[:-1] * step[1:], axis=1) > 0.0
        straight = same & (np.abs(turn) <= 1e-6 * length[:-1] * length[1:])
        points = points[np.concatenate(([True], ~straight, [True]))]
    return frame.all(points.tolist())


def _path(
    trace: Trace, strokes: Sequence[tuple[int, int, str]], on: Flags, colours: Counts,
    frame: PaperFrame,
) -> Iterator[Polyline]:  # fmt: skip
    """Rapid moves, leads, and the strokes in pieces of one colour."""
    rapids = [("rapid", a, b) for a, b in runs(on.astype(np.int64)) if not on[a]]
    leads = [
        ("lead", a, b) for first, last, process in strokes
        if process not in ("mark", "engrave", "spot")  # a letter may begin beside a ring, as a 9
        for a, b in lead_moves(trace, first, last, 0.02) if b > a
    ]  # fmt: skip
    for style, a, b in (*rapids, *leads):
        points = _drawn(trace, a, b, frame)
        if len(points) > 1:
            yield Polyline(style, points, line=int(trace.line[a]))
    ways = np.hypot(*np.diff(trace.positions[:, :2], axis=0).T)
    for first, last, process in strokes:
        moving = (first + np.flatnonzero(ways[first:last] > MIN_MOVE)).tolist()
        for a, b in runs(colours[moving]):
            line = int(trace.line[moving[a]])
            points = _drawn(trace, moving[a], moving[b - 1] + 1, frame)
            yield Polyline(f"speed-{colours[moving[a]]} by-{process}", points, line=line)


def lead_moves(trace: Trace, first: int, last: int, near: float) -> list[tuple[int, int]]:
    """The intervals of a stroke before, between and behind the contours that close in it."""
    points = trace.positions[first : last + 1, :2].tolist()
    moves = [k for k in range(last - first) if points[k] != points[k + 1]]
    if not moves or len(moves) > MAX_RINGS:
        return []
    ring = ring_of([Line(tuple(points[k]), tuple(points[k + 1])) for k in moves], near, near)
    if ring is None:
        return []
    around = (first, first + moves[ring[0]]), (first + moves[ring[1] - 1] + 1, last)
    return [leads for a, b in around for leads in lead_moves(trace, a, b, near) or [(a, b)]]


def _pierces(
    trace: Trace, strokes: Sequence[tuple[int, int, str]], frame: PaperFrame
) -> Iterator[Shape]:
    """The starts of a tool, each with its number where there is room for it."""
    places = [frame.at(*trace.positions[first, :2].tolist()) for first, _, _ in strokes]
    labels = Labels()
    few = len(strokes) <= MAX_NUMBERS
    for x, y in places if few else ():
        labels.block((x - PIERCE, y - PIERCE, x + PIERCE, y + PIERCE))
    for number, (at, (first, _, process)) in enumerate(zip(places, strokes, strict=True), 1):
        line = int(trace.line[first])
        yield Circle(
            f"pierce by-{process}", at, PIERCE, f"{number}: {process}" if few else "", line
        )
        free = labels.place(at, PIERCE, str(number), 9.0, rings=1) if few else None
        if free is not None:
            yield Text("number order", free, str(number), 9.0, line=line)


def _legend(fastest: float, used: Sequence[int], has_leads: bool, y: float) -> Iterator[Shape]:
    x = SIDE
    yield Text("label", (x, y + 4.0), "mm/min up to")
    x += 80.0
    for k in used:
        yield Polyline(f"speed-{k} legend", ((x, y), (x + 16.0, y)))
        value = fastest * SECONDS_PER_MINUTE * (k + 1) / len(SPEED_COLOURS)
        yield Text("figure", (x + 19.0, y + 4.0), f"{value:.0f}")
        x += 58.0
    rows = [("rapid", "no tool on"), *([("lead", "lead, overcut")] if has_leads else [])]
    for style, text in rows:
        yield Polyline(f"{style} legend", ((x, y), (x + 16.0, y)))
        yield Text("label", (x + 20.0, y + 4.0), text)
        x += 34.0 + 7.0 * len(text)
    yield Circle("pierce legend", (x + 3.0, y), 2.2)
    yield Text("label", (x + 10.0, y + 4.0), "start of a tool")
