"""Two programs of copers drawn over each other, on the faces of the section or unrolled tube."""

from collections.abc import Iterator, Sequence
from functools import partial
from math import pi

from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.coping.strokes import TorchStroke
from beamcam.checks.coping.tube import tube_section
from beamcam.comparison.pairing import ThingPair
from beamcam.comparison.statements import is_closed, stroke_pairs
from beamcam.geometry.curves import join_boxes
from beamcam.machine.coper import Coper
from beamcam.model.part import Face, Part
from beamcam.model.rounds import rolled
from beamcam.pictures.coper import face_view, faces_of, on_views, part_of, strokes_of
from beamcam.pictures.overlay import (
    Overlay,
    called_on,
    changed_places,
    changed_sizes,
    compared_pairs,
    drawn_pair,
    program_names,
    rising,
)
from beamcam.pictures.program import ReadProgram, coper_program
from beamcam.pictures.scene import PaperFrame, Pieces, Polyline, Shape
from beamcam.pictures.views import View, figures, head_height, heading, titles
from beamcam.recovery.rings import drilled_of, round_of

WITHIN = 0.05  #: mm of a circle that a cut is called a hole by


class _Side(Struct, frozen=True):
    """One of the two programs."""

    part: Part  #: as its head has it
    cuts: list[TorchStroke]
    coper: Coper
    turn: float | None  #: mm round a tube


def compared_copers(a: ReadProgram, b: ReadProgram) -> Overlay:
    """Overlay of the cuts of two programs.

    Raises VerifyError for one that is not understood, is wrong by itself, or names no section of
    the catalogue.
    """
    sides = (_side(a), _side(b))
    pairs = list(stroke_pairs(sides[0].cuts, sides[1].cuts, a.machine.format.resolution))
    by_face = {
        face: [p for p in pairs if _face(p) == face]
        for side in sides for face in faces_of(side.part, side.turn is not None)
    }  # fmt: skip
    lines = program_names(a.name, a.sha256, b.name, b.sha256)
    sizes = {
        face: changed_sizes(own, partial(_words, sides), radius_of=_reach)
        for face, own in by_face.items()
    }
    plain = [_view(sides, face, own) for face, own in by_face.items()]
    views, paper, called = called_on(plain, sizes, head_height(lines))
    drawn: list[Shape] = [*heading(lines), *titles(views, paper), *called]
    for view in views:
        frame = paper.frames[view.name]
        drawn += _stock(sides, view, frame)
        for pair in rising(by_face[view.name]):
            drawn += drawn_pair(pair, partial(_shapes, frame=frame), frame)
        drawn += figures(view, paper, "mm")
    return compared_pairs("two programs", lines, drawn, paper, pairs)


def _side(program: ReadProgram) -> _Side:
    own = coper_program(program)
    part = part_of(own)
    coper = program.machine.needed(program.machine.coper, "coper")
    is_tube = coper.unrolls(part.profile.code)
    turn = tube_section(rolled(part), coper).turn if is_tube else None
    return _Side(part, on_views(strokes_of(own, part), is_tube), coper, turn)


def _face(pair: ThingPair) -> str:
    thing = pair.a or pair.b
    assert isinstance(thing, TorchStroke)
    return thing.face


def _view(sides: Sequence[_Side], face: Face, pairs: Sequence[ThingPair]) -> View:
    """A face as wide as both have it, with where along x they differ."""
    first, second = (face_view(s.part, face, s.cuts, s.coper) for s in sides)
    box = join_boxes([first.box, second.box]) or first.box
    return replace(first, box=box, places=changed_places(pairs), heights=())


def _stock(sides: Sequence[_Side], view: View, frame: PaperFrame) -> Iterator[Shape]:
    """The face of both parts, from x 0 to their ends."""
    outlines = []
    for side in sides:
        end = side.part.length
        high = side.part.profile.face_width(view.name) if side.turn is None else side.turn
        outlines.append(frame.all(((0.0, 0.0), (end, 0.0), (end, high), (0.0, high))))
    if outlines[0] == outlines[1]:
        yield Polyline("same stock-outline", outlines[0], True)
        return
    yield Polyline("gone stock-outline", outlines[0], True, "part of A")
    yield Polyline("new stock-outline", outlines[1], True, "part of B")


def _shapes(cut: TorchStroke, frame: PaperFrame) -> Iterator[Shape]:
    tip = f"cut on face {cut.face} at {cut.row.feed_mm_min:g} mm/min"
    yield Polyline("trail", frame.all(cut.points), False, tip, cut.line)


def _reach(cut: object) -> float:
    """How far a cut goes up from its middle."""
    ys = [y for _, y in cut.points[1:]] if isinstance(cut, TorchStroke) else [0.0]
    return (max(ys) - min(ys)) / 2


def _words(sides: Sequence[_Side], cut: object) -> Pieces:
    """The size of what falls out of a wall; nothing of a cut that ends elsewhere."""
    from shapely import Polygon

    if not isinstance(cut, TorchStroke) or not is_closed(cut):
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
