"""Playback data of a program: the trace, the cell and the times of its events, as JSON.

Numbers of the trace are whole and count from the one before, so that a long one stays short:

    t   microseconds that an interval takes
    p   for each axis thousandths of mm or degrees that it moves; `[0, n]` stands for n zeros
    s   slopes of the share of the way at both ends, in thousandths, `0` where both are 1000
    l   lines of the program, each as the difference to the one before
    o   runs of intervals in one state: state, how many
"""

import json
from typing import Any

import numpy as np
from msgspec.structs import replace

from beamcam.geometry.array_types import Counts
from beamcam.geometry.plane import unit_vector
from beamcam.machine.machine import Machine, text_x
from beamcam.machine.stations import Formula, Spindle
from beamcam.model.part import Profile
from beamcam.pictures.bar_made import BarMade, DrawnPiece
from beamcam.pictures.features import section_outlines
from beamcam.pictures.table import TableMade, speed_classes
from beamcam.plain_text import json_text
from beamcam.simulation.trace import Trace, runs

MICROSECONDS = 1e6
STEP = 1e-3  #: of positions in a page, mm or degrees
NO_SECTION = Profile("B", "", 0.0, 0.0, 0.0, None)
#: Height and width that are drawn, dashed, where nothing says the section.
ASSUMED = (300.0, 100.0)


def trace_data(trace: Trace) -> dict[str, Any]:
    """A trace for a page; positions are right to half a thousandth."""
    times = np.rint(trace.time_s * MICROSECONDS).astype(np.int64)
    places = np.rint(trace.positions / STEP).astype(np.int64)
    slopes = np.rint(trace.slopes * 1000).astype(np.int64)
    return {
        "axes": [{"name": a.name, "unit": a.unit, "min": a.min, "max": a.max} for a in trace.axes],
        "start": places[0].tolist(),
        "t": np.diff(times).tolist(),
        "p": [_squeezed(column) for column in np.diff(places, axis=0).T],
        "s": [0 if pair == [1000, 1000] else pair for pair in slopes.tolist()],
        "l": np.diff(trace.line, prepend=0).tolist(),
        "o": [[int(trace.state[a]), b - a] for a, b in runs(trace.state)],
        "states": [
            {name: getattr(state, name) for name in state.__struct_fields__}
            for state in trace.states
        ],
    }


def _squeezed(column: Counts) -> list[Any]:
    """Numbers with runs of zeros as `[0, n]`."""
    values: list[Any] = []
    zeros = 0
    for value in [*column.tolist(), None]:
        if value == 0:
            zeros += 1
            continue
        if zeros:
            values.append([0, zeros] if zeros > 1 else 0)
            zeros = 0
        if value is not None:
            values.append(value)
    return values


def cell_data(machine: Machine, profile: Profile, end: float) -> dict[str, Any]:
    """The stations of a cell for a page, about a bar of that section that ends at bar x `end`."""
    drill_x = machine.drill.x if machine.drill else 0.0
    saw = machine.saw
    is_known = profile.height > 0.0 and profile.width > 0.0
    if not is_known:
        height, width = profile.height or ASSUMED[0], profile.width or ASSUMED[1]
        profile = replace(profile, height=height, width=width)
    return {
        "kind": "bar",
        "section": {
            "height": profile.height, "width": profile.width, "assumed": not is_known,
            "outlines": section_outlines(profile) or [
                ((0.0, 0.0), (profile.width, 0.0), (profile.width, profile.height),
                 (0.0, profile.height))],
        },
        "bar": end,
        "drill": -drill_x,
        "saw": {
            "x": -(saw.x if saw else 0.0),
            "square": saw.zero_angle if saw else 0.0, "sign": saw.angle_sign if saw else 1,
            "pivot": saw.pivot if saw else "o",
            "rotation": _axis(machine, "angle", None), "stroke": _axis(machine, "saw", None),
        },
        "stop": _axis(machine, "X", None),
        "spindles": [_spindle(machine, spindle, profile) for spindle in machine.spindles],
    }  # fmt: skip


def bar_made_data(bar: BarMade) -> dict[str, Any]:
    """A bar's program without its times."""
    machine, made, profile = bar.machine, bar.made, bar.profile
    drill_x = machine.drill.x if machine.drill else 0.0
    trails: list[tuple[Any, Any, float]] = [(t, t.points, drill_x) for t in made.paths]
    for text in made.texts:  # the line that its characters stand on
        long = machine.marks.pitch * text.height * len(text.text)
        c, s = unit_vector(text.angle)
        x = text.x - text_x(machine)
        trails.append((text, ((x, text.y), (x + long * c, text.y + long * s)), 0.0))
    return {
        **cell_data(machine, profile, bar.end),
        "pieces": [_piece(bar, piece) for piece in bar.pieces()],
        "cuts": [
            {"line": p.cut.line, "x": [_rounded(bar.x_on(p, f, y)) for f in "vuo"
             for y in (0.0, profile.face_width(f))]}
            for p in bar.saw_planes
        ],
        "bores": [
            {"line": b.line, "face": b.face, "x": _rounded(b.x - drill_x), "y": b.y,
             "d": b.diameter} for b in made.bores
        ],
        "trails": [
            {"line": t.line, "face": t.face, "points": [[_rounded(x - off), _rounded(y)]
                                                        for x, y in points]}
            for t, points, off in trails
        ],
    }  # fmt: skip


def _rounded(value: float) -> float:
    return round(value, 3)


def _axis(machine: Machine, moves: str, spindle: int | None) -> int | None:
    axes: list[tuple[str, int | None]] = [(a.moves, a.spindle) for a in machine.axes]
    return axes.index((moves, spindle)) if (moves, spindle) in axes else None


def _piece(bar: BarMade, piece: DrawnPiece) -> dict[str, Any]:
    """A piece of the bar by its eight corners: both ends on the edges of the section."""
    height, width = bar.profile.height, bar.profile.width
    corners = [(y, z) for y in (0.0, height) for z in (0.0, width)]
    saw = bar.machine.saw
    lift = height if saw is not None and saw.pivot == "o" else 0.0

    def end(plane: Any, otherwise: float, side: int) -> list[float]:
        if plane is None:
            return [_rounded(otherwise)] * 4
        return [_rounded(plane.along(y - lift, z) + side * plane.half_kerf) for y, z in corners]

    return {
        "kind": piece.kind, "mark": piece.mark, "start": end(piece.start, 0.0, 1),
        "end": end(piece.end, bar.end, -1),
    }  # fmt: skip


def _spindle(machine: Machine, spindle: Spindle, profile: Profile) -> dict[str, Any]:
    """How a spindle's axes stand to the face that it works on: place = first + axis * factor."""
    face = spindle.face
    values = {
        "height": profile.height, "width": profile.width, "y": 0.0, "depth": 0.0, "tip": 0.0,
        "flange_thickness": profile.flange_thickness, "web_thickness": profile.web_thickness or 0.0,
        "thickness": 0.0, "face_depth": 0.0, "clearance": 0.0,
    }  # fmt: skip
    y0, ky = _inverse(spindle.across.position, values, "y")
    d0, kd = _inverse(spindle.stroke.bottom, values, "depth")
    return {
        "number": spindle.number, "name": spindle.name, "face": face,
        "across": _axis(machine, spindle.across.axis, spindle.number),
        "stroke": _axis(machine, spindle.stroke.axis, spindle.number),
        "y": [y0, ky], "depth": [d0, kd],
        "numbers": [spindle.number, *(p.number for p in machine.pairs if face in p.faces)],
    }  # fmt: skip


def _inverse(formula: Formula, values: dict[str, float], name: str) -> tuple[float, float]:
    """The inverse of a linear formula of an axis position."""
    zero = formula(values)
    slope = formula(values | {name: 1.0}) - zero
    return (-zero / slope, 1.0 / slope) if slope else (0.0, 0.0)


def playback_data(made: BarMade | TableMade, trace: Trace) -> dict[str, Any]:
    """A program for a page: what moves, and the trace; of a table the colours of its speeds."""
    if isinstance(made, BarMade):
        return {**bar_made_data(made), "trace": trace_data(trace)}
    trace, speeds = made.trace, made.speeds_mm_s
    on = np.array([bool(state.process) for state in trace.states])[trace.state]
    fastest = float(speeds[on].max(initial=0.0)) or 1.0
    classes = speed_classes(speeds, fastest)
    return {
        "kind": "table",
        "trace": trace_data(trace),
        "fastest": fastest,
        "colours": [[int(classes[a]), b - a] for a, b in runs(classes)],
    }


def path_data(table: TableMade) -> list[list[list[float]]]:
    """The way of the head with a tool on: for each start of a tool its corners, in mm."""
    places = np.round(table.trace.positions[:, :2], 3)
    return [places[first : last + 1].tolist() for first, last, _ in table.strokes]


def as_script(data: object) -> str:
    """Data as JSON that may stand within a script of a page, odd characters spelled out."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    return json_text(text).replace("<", "\\u003c")
