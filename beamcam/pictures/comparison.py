"""Two parts or two programs drawn over each other: what moved, what is new, what is gone."""

from collections.abc import Iterator, Sequence
from functools import partial
from math import pi
from pathlib import PurePath
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.bars.stations import Bore, MachinedPath, StampedText
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.checks.coping.tube import tube_section
from beamcam.comparison.bars import made_pairs
from beamcam.comparison.pairing import ThingPair
from beamcam.comparison.parts import part_pairs
from beamcam.comparison.statements import is_closed, stroke_pairs
from beamcam.geometry.array_types import Counts
from beamcam.geometry.curves import join_boxes
from beamcam.machine.coper import Coper
from beamcam.model.description import FACE_NAMES, end_lines, face_title, runs_down
from beamcam.model.part import Hole, Part, Slot
from beamcam.model.rounds import rolled
from beamcam.pictures import ReadProgram
from beamcam.pictures import coper as coper_picture
from beamcam.pictures.bar_made import BarMade
from beamcam.pictures.callouts import hole_words, slot_words
from beamcam.pictures.features import feature_shapes, lettering
from beamcam.pictures.overlay import Overlay, faces_overlay, outlines, overlay_scene
from beamcam.pictures.part import face_of, faces_of, view_of
from beamcam.pictures.program import bar_made
from beamcam.pictures.scene import Circle, PaperFrame, Pieces, Polyline, Shape
from beamcam.pictures.views import FACES_DOWN, View, head_height, heading, laid_out
from beamcam.recovery.rings import drilled_of, round_of

ROUND = 1e-3  #: mm; ends of moves nearer than this are one
WITHIN = 0.05  #: mm of a circle that a cut is called a hole by


def _joined(a: View, b: View) -> View:
    """A face as wide as both have it."""
    return replace(a, box=join_boxes([a.box, b.box]) or a.box)


def compared_parts(a: Part, b: Part) -> Overlay:
    """The features of two parts over each other."""
    pairs = list(part_pairs(a, b))
    faces = [f for f in FACES_DOWN if f in {*faces_of(a), *faces_of(b)}]
    on_face: dict[str, list[ThingPair]] = {
        f: [p for p in pairs if face_of(p.a or p.b) == f] for f in faces
    }

    def stock(view: View) -> Iterator[Polyline]:
        if a.profile.code != "B" and view.name in FACE_NAMES:
            corners = []
            for part in (a, b):
                (p, q), (r, s) = end_lines(part, view.name)
                corners.append(view.frame.all((p, r, s, q)))
            yield from outlines(corners[0], corners[1], "stock")

    files = [PurePath(part.source.file).name for part in (a, b)]
    lines = [f"{a.mark or 'A'} and {b.mark or 'B'}", f"A {files[0]}", f"B {files[1]}"]
    views = [_joined(view_of(a, face), view_of(b, face)) for face in faces]
    return faces_overlay(
        f"{a.mark} and {b.mark}", lines, views, pairs, on_face, _feature_words, feature_shapes,
        stock,
    )  # fmt: skip


def _feature_words(feature: Any) -> Pieces:
    """The size of a hole or a slot as a drawing says it; nothing of other features."""
    if isinstance(feature, Hole):
        return hole_words(feature)
    return slot_words(feature) if isinstance(feature, Slot) else ()


def compared_programs(a: ReadProgram, b: ReadProgram) -> Overlay:
    """Overlay of what two programs make. Raises VerifyError where one is not understood."""
    lines = ["two programs", *(f"{side} {one.name}   sha-256 {one.sha256}"
                               for side, one in (("A", a), ("B", b)))]  # fmt: skip
    if a.machine.stock == "profile":
        return _compared_copers(a, b, lines)
    if a.machine.stock == "beam":
        return _compared_bars(bar_made(a), bar_made(b), lines)
    return _compared_ways(a, b, lines)


# --- bars -----------------------------------------------------------------------------------------


def _compared_bars(a: BarMade, b: BarMade, lines: Sequence[str]) -> Overlay:
    made = [things for bar in (a.made, b.made) for things in (bar.bores, bar.paths, bar.texts)]
    used = {thing.face for things in made for thing in things} | {"v"}
    faces = [f for f in FACES_DOWN if f in used]
    end = max(a.end, b.end)
    width = max(1.0, *(m.profile.face_width(f) for m in (a, b) for f in faces))
    drill = a.machine.drill.x if a.machine.drill else 0.0
    pairs = list(made_pairs(a.made, b.made, a.machine.format.resolution))
    on_face: dict[str, list[ThingPair]] = {
        f: [p for p in pairs if getattr(p.a or p.b, "face", "") == f] for f in faces
    }
    views = [
        View(f, face_title(f, a.profile.code),
             (0.0, 0.0, end, max(a.profile.face_width(f), b.profile.face_width(f)) or width),
             down=runs_down(f))
        for f in faces
    ]  # fmt: skip

    def stock(view: View) -> Iterator[Polyline]:
        size = ((0.0, 0.0), (end, 0.0), (end, view.box[3]), (0.0, view.box[3]))
        yield Polyline("same stock-outline", view.frame.all(size), True)
        yield from _cuts(a, b, view)

    return faces_overlay(
        "two programs", lines, views, pairs, on_face, _bore_words, _made_shapes, stock, drill
    )


def _bore_words(thing: Any) -> Pieces:
    """What a stroke makes; nothing of paths and texts."""
    if not isinstance(thing, Bore):
        return ()
    return ("" if thing.kind == "drill" else f"{thing.kind} ", "Ø", thing.diameter)


def _cuts(a: BarMade, b: BarMade, view: View) -> Iterator[Polyline]:
    """The cuts of both as they lie in a face."""
    ends = []
    for bar in (a, b):
        width = bar.profile.face_width(view.name)
        ends.append([
            view.frame.all([(bar.x_on(p, view.name, y), y) for y in (0.0, width)])
            for p in bar.saw_planes
        ])  # fmt: skip
    for style, own, other in (("gone", ends[0], ends[1]), ("new", ends[1], ends[0])):
        for line in own:
            if line not in other:
                yield Polyline(f"{style} cut-of", line, False, f"cut of {'AB'[style == 'new']}")
            elif style == "new":
                yield Polyline("same cut-of", line)


def _made_shapes(thing: Bore | MachinedPath | StampedText, frame: PaperFrame) -> Iterator[Shape]:
    if isinstance(thing, Bore):
        radius = max(thing.diameter / 2 * frame.scale, 1.2)
        tip = f"{thing.kind} {thing.diameter:g} at machine x {thing.x:g}, y {thing.y:g}"
        yield Circle("hole", frame.at(thing.x, thing.y), radius, tip, thing.line)
    elif isinstance(thing, StampedText):
        yield lettering("text", thing, frame, line=thing.line)
    else:
        yield Polyline("trail", frame.all(thing.points), False, thing.kind, thing.line)


# --- copers ---------------------------------------------------------------------------------------


class _Side(Struct, frozen=True):
    """One of the two programs."""

    part: Part  #: as its head has it
    cuts: list[TorchStroke]
    coper: Coper
    turn: float | None  #: mm round a tube


def _compared_copers(a: ReadProgram, b: ReadProgram, lines: Sequence[str]) -> Overlay:
    """Overlay of the cuts of two programs, on the faces of the section or unrolled tube."""
    sides = (_side(a), _side(b))
    pairs = list(stroke_pairs(sides[0].cuts, sides[1].cuts, a.machine.format.resolution))
    on_face: dict[str, list[ThingPair]] = {}
    views = []
    for side in sides:
        for face in coper_picture.faces_of(side.part, side.turn is not None):
            if face not in on_face:
                on_face[face] = [p for p in pairs if getattr(p.a or p.b, "face", "") == face]
                views.append(_joined(*(
                    coper_picture.face_view(s.part, face, s.cuts, s.coper) for s in sides
                )))  # fmt: skip

    def stock(view: View) -> Iterator[Shape]:
        both = []
        for side in sides:
            end = side.part.length
            high = side.part.profile.face_width(view.name) if side.turn is None else side.turn
            both.append(view.frame.all(((0.0, 0.0), (end, 0.0), (end, high), (0.0, high))))
        yield from outlines(both[0], both[1], "part")

    return faces_overlay(
        "two programs", lines, views, pairs, on_face, partial(_cut_words, sides), _cut_shapes,
        stock, radius=_reach,
    )  # fmt: skip


def _side(program: ReadProgram) -> _Side:
    part = coper_picture.part_of(program)
    coper = program.machine.needed(program.machine.coper, "coper")
    is_tube = coper.unrolls(part.profile.code)
    turn = tube_section(rolled(part), coper).turn if is_tube else None
    cuts = coper_picture.on_views(coper_picture.strokes_of(program, part), is_tube)
    return _Side(part, cuts, coper, turn)


def _cut_shapes(cut: TorchStroke, frame: PaperFrame) -> Iterator[Shape]:
    tip = f"cut on face {cut.face} at {cut.row.feed_mm_min:g} mm/min"
    yield Polyline("trail", frame.all(cut.points), False, tip, cut.line)


def _reach(cut: TorchStroke) -> float:
    """How far a cut goes up from its middle."""
    ys = [y for _, y in cut.points[1:]]
    return (max(ys) - min(ys)) / 2


def _cut_words(sides: Sequence[_Side], cut: TorchStroke | None) -> Pieces:
    """The size of what falls out of a wall; nothing of a cut that ends elsewhere."""
    from shapely import Polygon

    if cut is None or not is_closed(cut):
        return ()
    own = sides[0] if any(cut is one for one in sides[0].cuts) else sides[1]
    opening = Polygon(cut.points[1:]).buffer(cut.row.kerf / 2)
    ring = list(opening.exterior.coords)[:-1]
    if own.turn is None or own.part.profile.code == "M":
        circle = round_of(ring, WITHIN)
    else:
        circle = drilled_of(ring, own.turn / (2 * pi), WITHIN)
    if circle is not None:
        return ("Ø", round(circle[2], 1))
    left, low, right, high = opening.bounds
    return (round(right - left, 1), " x ", round(high - low, 1))


# --- tables ---------------------------------------------------------------------------------------

Move = tuple[tuple[int, int], tuple[int, int]]


def _compared_ways(a: ReadProgram, b: ReadProgram, lines: Sequence[str]) -> Overlay:
    """The ways of two heads with a tool on, move by move."""
    from beamcam.simulation.program import simulate_program

    both: list[dict[Move, int]] = []
    for program in (a, b):
        trace = simulate_program(
            program.data, program.machine, program.name, program.style, program.parts
        ).trace
        on = np.array([bool(s.process) for s in trace.states])[trace.state]
        places = np.rint(trace.positions[:, :2] / ROUND).astype(np.int64)
        both.append(dict(_blocks(places[:-1][on], places[1:][on], trace.line[on])))
    first, second = both
    points = [p for way in both for move in way for p in move] or [(0, 0), (1, 1)]
    low, high = np.min(points, axis=0) * ROUND, np.max(points, axis=0) * ROUND
    box = (float(low[0]), float(low[1]), float(high[0]), max(float(high[1]), float(low[1]) + 1.0))
    (view,), bottom = laid_out((View("way", "", box),), head_height(lines))
    same = [m for m in second if m in first]
    gone = [m for m in first if m not in second]
    new = [m for m in second if m not in first]
    drawn: list[Shape] = [*heading(lines)]
    for style, moves, line_of in (("same", same, second), ("gone", gone, first),
                                  ("new", new, second)):  # fmt: skip
        drawn += _chains(style, moves, line_of, view.frame)
    scene = overlay_scene("two programs", drawn, bottom, f"{len(gone)} gone, {len(new)} new")
    return Overlay(scene, len(same), 0, len(gone), len(new))


def _blocks(starts: Counts, ends: Counts, lines: Counts) -> Iterator[tuple[Move, int]]:
    """The straight moves of a way with their lines: intervals that go straight on are one.

    A line that is passed at several speeds has as many intervals; another program may pass it
    at others.
    """
    begin: tuple[int, int] | None = None
    end: tuple[int, int] = (0, 0)
    line = 0
    rows = zip(starts.tolist(), ends.tolist(), lines.tolist(), strict=True)
    for (x0, y0), (x1, y1), number in rows:
        if (x0, y0) == (x1, y1):
            continue
        if begin is not None:
            # Straight on, to a thousandth or two.
            ux, uy, vx, vy = end[0] - begin[0], end[1] - begin[1], x1 - x0, y1 - y0
            off = abs(ux * vy - uy * vx)
            is_straight = off <= 2.0 * max(abs(ux) + abs(uy), abs(vx) + abs(vy))
            is_straight = is_straight and ux * vx + uy * vy > 0
            if end == (x0, y0) and number == line and is_straight:
                end = (x1, y1)
                continue
            yield (begin, end), line
        begin, end, line = (x0, y0), (x1, y1), number
    if begin is not None:
        yield (begin, end), line


def _chains(
    style: str, moves: Sequence[Move], line_of: dict[Move, int], frame: PaperFrame
) -> Iterator[Polyline]:
    """Moves as chains, as long as each begins where the one before it ends."""
    runs: list[tuple[int, list[tuple[int, int]]]] = []  #: each with its first line
    for start, end in moves:
        if runs and runs[-1][1][-1] == start:
            runs[-1][1].append(end)
        else:
            runs.append((line_of[start, end], [start, end]))
    for line, run in runs:
        points = frame.all([(x * ROUND, y * ROUND) for x, y in run])
        yield Polyline(f"{style} way-of", points, False, f"line {line} of {'BA'[style == 'gone']}")
