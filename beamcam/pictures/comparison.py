"""Two parts or two programs drawn over each other: what moved, what is new, what is gone."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import PurePath

import numpy as np
from msgspec.structs import replace

from beamcam.checks.bars.stations import Bore, MachinedPath, StampedText
from beamcam.comparison.bars import made_pairs
from beamcam.comparison.parts import part_pairs
from beamcam.geometry.array_types import Counts
from beamcam.geometry.curves import join_boxes
from beamcam.model.description import FACE_NAMES, end_lines, face_title, runs_down
from beamcam.model.part import Face, Part
from beamcam.pictures.bar_made import BarMade
from beamcam.pictures.features import feature_shapes, lettering
from beamcam.pictures.overlay import (
    Overlay,
    bore_words,
    called_on,
    changed_places,
    changed_sizes,
    compared_pairs,
    drawn_pair,
    feature_words,
    overlay_scene,
    program_names,
    rising,
)
from beamcam.pictures.part import face_of, faces_of, view_of
from beamcam.pictures.program import ReadProgram, bar_made
from beamcam.pictures.scene import Circle, PaperFrame, Polyline, Shape
from beamcam.pictures.views import View, figures, head_height, heading, laid_out, titles

ROUND = 1e-3  #: mm; ends of moves nearer than this are one


def compared_parts(a: Part, b: Part) -> Overlay:
    """The features of two parts over each other."""
    faces = [f for f in ("h", "o", "v", "u") if f in {*faces_of(a), *faces_of(b)}]
    pairs = list(part_pairs(a, b))
    views = tuple(
        replace(_joined(view_of(a, face), view_of(b, face)), places=changed_places(
            pair for pair in pairs if face_of(pair.a or pair.b) == face  # type: ignore[arg-type]
        ))
        for face in faces
    )  # fmt: skip
    files = [PurePath(part.source.file).name for part in (a, b)]
    lines = [f"{a.mark or 'A'} and {b.mark or 'B'}", f"A {files[0]}", f"B {files[1]}"]
    sizes = {
        str(face): changed_sizes(
            (p for p in pairs if face_of(p.a or p.b) == face),  # type: ignore[arg-type]
            feature_words,
        )
        for face in faces
    }
    views, paper, called = called_on(views, sizes, head_height(lines))
    drawn: list[Shape] = [*heading(lines), *titles(views, paper), *called]
    for view in views:
        frame = paper.frames[view.name]
        drawn += _stock(a, b, view.name, frame)
        for pair in rising(pairs):
            if face_of(pair.a or pair.b) == view.name:  # type: ignore[arg-type]
                drawn += drawn_pair(pair, partial(feature_shapes, frame=frame), frame)
        drawn += figures(view, paper, "mm")
    return compared_pairs(f"{a.mark} and {b.mark}", lines, drawn, paper, pairs)


def _joined(a: View, b: View) -> View:
    box = join_boxes([a.box, b.box])
    return replace(a, box=box or a.box, places=(), heights=())


def _stock(a: Part, b: Part, face: Face, frame: PaperFrame) -> Iterator[Polyline]:
    """The raw outlines of both, where the face is that of a bar."""
    if a.profile.code == "B" or face not in FACE_NAMES:
        return
    corners = []
    for part in (a, b):
        (p, q), (r, s) = end_lines(part, face)
        corners.append(frame.all((p, r, s, q)))
    if corners[0] == corners[1]:
        yield Polyline("same stock-outline", corners[0], True)
        return
    yield Polyline("gone stock-outline", corners[0], True, "stock of A")
    yield Polyline("new stock-outline", corners[1], True, "stock of B")


def compared_programs(a: ReadProgram, b: ReadProgram) -> Overlay:
    """Overlay of what two programs make. Raises VerifyError where one is not understood."""
    if a.machine.stock == "profile":
        from beamcam.pictures.coper_comparison import compared_copers

        return compared_copers(a, b)
    if a.machine.stock == "beam":
        return _compared_bars(bar_made(a), bar_made(b))
    return _compared_ways(a, b)


def _compared_bars(a: BarMade, b: BarMade) -> Overlay:
    used = {bore.face for made in (a.made, b.made) for bore in made.bores} | {"v"}
    used |= {path.face for made in (a.made, b.made) for path in made.paths}
    used |= {text.face for made in (a.made, b.made) for text in made.texts}
    faces = [f for f in ("h", "o", "v", "u") if f in used]
    end = max(a.end, b.end)
    width = max(1.0, *(m.profile.face_width(f) for m in (a, b) for f in faces))
    drill = a.machine.drill.x if a.machine.drill else 0.0
    pairs = list(made_pairs(a.made, b.made, a.machine.format.resolution))
    views = tuple(
        View(f, face_title(f, a.profile.code),
             (0.0, 0.0, end, max(a.profile.face_width(f), b.profile.face_width(f)) or width),
             changed_places((p for p in pairs if getattr(p.a or p.b, "face", "") == f), drill),
             down=runs_down(f))
        for f in faces
    )  # fmt: skip
    lines = program_names(a.name, a.sha256, b.name, b.sha256)
    sizes = {
        str(f): changed_sizes(
            (p for p in pairs if getattr(p.a or p.b, "face", "") == f), bore_words, drill
        )
        for f in faces
    }
    views, paper, called = called_on(views, sizes, head_height(lines))
    drawn: list[Shape] = [*heading(lines), *titles(views, paper), *called]
    for view in views:
        frame = paper.frames[view.name]
        size = frame.all(((0.0, 0.0), (end, 0.0), (end, view.box[3]), (0.0, view.box[3])))
        drawn.append(Polyline("same stock-outline", size, True))
        drawn += _cuts(a, b, view.name, frame)
        shifted = replace(frame, left=frame.left - drill * frame.scale)
        for pair in rising(pairs):
            thing = pair.a or pair.b
            if isinstance(thing, Bore | MachinedPath | StampedText) and thing.face == view.name:
                drawn += drawn_pair(pair, partial(_made_shapes, frame=shifted), shifted)
        drawn += figures(view, paper, "mm", -drill)
    return compared_pairs("two programs", lines, drawn, paper, pairs)


def _cuts(a: BarMade, b: BarMade, face: str, frame: PaperFrame) -> Iterator[Polyline]:
    """The cuts of both as they lie in a face."""
    ends = []
    for bar in (a, b):
        width = bar.profile.face_width(face)
        ends.append([
            frame.all(((bar.x_on(p, face, 0.0), 0.0), (bar.x_on(p, face, width), width)))
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


Move = tuple[tuple[int, int], tuple[int, int]]


def _compared_ways(a: ReadProgram, b: ReadProgram) -> Overlay:
    """The ways of two heads with a tool on, move by move."""
    from beamcam.simulation.program import simulate_program

    both: list[dict[Move, int]] = []
    for program in (a, b):
        trace = simulate_program(
            program.data, program.machine, program.name, program.style, program.parts
        ).trace
        on = np.array([bool(s.process) for s in trace.states])[trace.state]
        lines = trace.line[on]
        places = np.rint(trace.positions[:, :2] / ROUND).astype(np.int64)
        both.append(dict(_blocks(places[:-1][on], places[1:][on], lines)))
    first, second = both
    points = [p for way in both for move in way for p in move] or [(0, 0), (1, 1)]
    low, high = np.min(points, axis=0) * ROUND, np.max(points, axis=0) * ROUND
    box = (float(low[0]), float(low[1]), float(high[0]), max(float(high[1]), float(low[1]) + 1.0))
    lines_ = program_names(a.name, a.sha256, b.name, b.sha256)
    paper = laid_out((View("way", "", box),), head_height(lines_))
    frame = paper.frames["way"]
    same = [m for m in second if m in first]
    gone = [m for m in first if m not in second]
    new = [m for m in second if m not in first]
    drawn: list[Shape] = [*heading(lines_)]
    for style, moves, line_of in (("same", same, second), ("gone", gone, first),
                                  ("new", new, second)):  # fmt: skip
        drawn += _chains(style, moves, line_of, frame)
    scene = overlay_scene("two programs", lines_, drawn, paper, f"{len(gone)} gone, {len(new)} new")
    return Overlay(scene, len(same), 0, len(gone), len(new))


def _blocks(starts: Counts, ends: Counts, lines: Counts) -> Iterator[tuple[Move, int]]:
    """The straight moves of a way with their lines: intervals that go straight on are one.

    A stretch that is passed at several speeds has as many intervals; another program may pass it
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
            goes_on = end == (x0, y0) and number == line and _straight(begin, end, (x1, y1))
            if goes_on:
                end = (x1, y1)
                continue
            yield (begin, end), line
        begin, end, line = (x0, y0), (x1, y1), number
    if begin is not None:
        yield (begin, end), line


def _straight(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int]) -> bool:
    """Whether c lies straight on behind b, to a thousandth or two."""
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]
    return abs(ux * vy - uy * vx) <= 2.0 * max(abs(ux) + abs(uy), abs(vx) + abs(vy)) and (
        ux * vx + uy * vy > 0
    )


def _chains(
    style: str, moves: Sequence[Move], line_of: dict[Move, int], frame: PaperFrame
) -> Iterator[Polyline]:
    """Moves as chains, as long as each begins where the one before it ends."""
    run: list[tuple[int, int]] = []
    first = 0
    for start, end in moves:
        if run and run[-1] == start:
            run.append(end)
            continue
        if run:
            yield _chain(style, run, first, frame)
        run, first = [start, end], line_of[start, end]
    if run:
        yield _chain(style, run, first, frame)


def _chain(style: str, run: Sequence[tuple[int, int]], line: int, frame: PaperFrame) -> Polyline:
    points = frame.all([(x * ROUND, y * ROUND) for x, y in run])
    return Polyline(f"{style} way-of", points, False, f"line {line} of {'BA'[style == 'gone']}")
