"""The texts of a part on a bar, found in the paths of a program's scribe."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, pi, sin

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line, Point
from beamcam.model.marks import policy_on
from beamcam.model.part import Face, Hole, Part, Profile, Slot, TextMark
from beamcam.model.section import OTHER_SIDE
from beamcam.verify.bars.ability import is_within
from beamcam.verify.bars.made import Trail
from beamcam.verify.bars.part_ends import End
from beamcam.verify.bars.shop import Shop
from beamcam.verify.bars.stations import choices_of, stroke_values
from beamcam.verify.bars.targets import Course, slot_corners
from beamcam.verify.by_hand import by_hand, is_by_hand
from beamcam.verify.lettering import (
    Drawn,
    Segment,
    Steel,
    Wanted,
    box_of,
    has_place,
    judge,
    steel_within,
    wanted,
)

SPARE = 1.5  #: mm by which a place is surely within the reach of an axis
CHORDS = 48  #: of a hole


def texts_of(
    part: Part, ends: tuple[End, End], trails: Sequence[Trail], from_x: float, shop: Shop
) -> tuple[list[Course], list[Diagnostic]]:
    """The strokes of a part's texts where a program letters them, and what is wrong with them.

    One that it does not letter is needed where the part has it, unless it can stand nowhere: then
    it is left to the hand.
    """
    courses: list[Course] = []
    said: list[Diagnostic] = []
    texts: dict[Face, list[tuple[int, TextMark]]] = {}
    for f, feature in enumerate(part.features):
        if (
            isinstance(feature, TextMark)
            and policy_on(feature, shop.machine.marks) == "make"
            and not is_by_hand(feature, shop.machine)
        ):
            texts.setdefault(feature.face, []).append((f, feature))
    for face, group in texts.items():
        if shop.works_on(face, part) and any(shop.of("scribe", face)):
            found, more = _on_face(face, group, part, ends, trails, from_x, shop)
            courses += found
            said += more
        else:
            said += (by_hand(feature, part, shop.machine) for _, feature in group)
    return courses, said


def _on_face(
    face: Face, texts: Sequence[tuple[int, TextMark]], part: Part, ends: tuple[End, End],
    trails: Sequence[Trail], from_x: float, shop: Shop,
) -> tuple[list[Course], list[Diagnostic]]:  # fmt: skip
    marks = shop.machine.marks
    steel = _steel(face, part, ends, _sides(face, part))
    bounds = _within_axes(face, part, shop)
    sure = None if bounds is None else _steel(face, part, ends, bounds)
    pieces = [
        ((a[0] - from_x, a[1]), (b[0] - from_x, b[1]))
        for trail in trails
        if trail.kind == "scribe" and trail.face == face
        for a, b in pairwise(trail.points)
    ]
    drawn = Drawn(pieces, shop.drill.path_tolerance + 2 * shop.machine.format.resolution)
    asked = [(f, wanted(feature, marks)) for f, feature in texts]
    found = {f: drawn.find(text, marks) for f, text in asked}
    boxes = {
        f: box_of(text, there.x, there.y, there.height)
        for f, text in asked
        if (there := found[f]) is not None
    }
    courses: list[Course] = []
    said: list[Diagnostic] = []
    for f, text in asked:
        others = [box for g, box in boxes.items() if g != f]
        one, feature = found[f], text.feature
        if one is not None:
            said += judge(text, one, steel, others, marks, sure or steel)
            courses += _strokes(f, text, one.x, one.y, one.height)
        elif sure is not None and has_place(text, sure, others, marks):
            courses += _strokes(f, text, feature.x, feature.y, text.height)
        else:
            said.append(by_hand(feature, part, shop.machine))
    return courses, said


def _strokes(f: int, text: Wanted, x: float, y: float, height: float) -> Iterator[Course]:
    for pieces in text.strokes(x, y, height):
        lines = tuple(Line(a, b) for a, b in pieces)
        what = f"stroke of the text {text.text!r}"
        yield Course(f, text.feature.face, lines, text.feature, what)


def _sides(face: Face, part: Part) -> tuple[float, float]:
    """Range of y that is free for a scribe, between edges, flanges and their fillets."""
    profile = part.profile
    width = profile.face_width(face)
    if face != "v" or profile.code not in ("I", "U", "C", "L"):
        return 0.0, width
    beside = profile.flange_thickness + profile.radius
    return beside, (width if profile.code == "L" else width - beside)


def _within_axes(face: Face, part: Part, shop: Shop) -> tuple[float, float] | None:
    """y that a spindle's axes come to with something to spare; None if they come to none."""
    (spindle,) = (s for s in shop.machine.spindles if s.face == face)
    station = choices_of(shop.machine, part.profile)[spindle.number].stations[0]
    values = stroke_values(shop.machine, part.profile, face)
    values |= {"depth": shop.drill.mark_depth, "tip": 0.0}
    low, high = _sides(face, part)
    steps = [low + k * (high - low) / 256 for k in range(257)]
    ys = [y for y in steps if is_within(values | {"y": y}, spindle, station, shop.machine)]
    if not ys or ys[-1] - ys[0] <= 2 * SPARE:
        return None
    spare = (high - low) / 256 + SPARE
    return (
        low if ys[0] == low else ys[0] + spare,
        high if ys[-1] == steps[-1] else ys[-1] - spare,
    )


def _steel(face: Face, part: Part, ends: tuple[End, End], sides: tuple[float, float]) -> Steel:
    """The steel of a face between two y, its holes taken out."""
    low, high = sides
    corners: list[Point] = []
    # Where an end is skew through the wall, the surface counts that leaves less.
    corners += ((max(_ends_at(ends[0], face, part.profile, y)), y) for y in (high, low))
    corners += ((min(_ends_at(ends[1], face, part.profile, y)), y) for y in (low, high))
    pieces: list[Segment] = [*pairwise([*corners, corners[0]])]
    behind = OTHER_SIDE.get(part.profile.code, {}).get(face)
    for feature in part.features:
        if isinstance(feature, (Hole, Slot)) and feature.face in (face, behind):
            pieces += pairwise(_rim(feature))
    return steel_within(pieces)


def _ends_at(end: End, face: Face, profile: Profile, q: float) -> tuple[float, float]:
    """x at which an end leaves both surfaces of the wall behind a face, at its coordinate q."""
    height, width = profile.height, profile.width
    web, flange = profile.web_thickness or 0.0, profile.flange_thickness
    if face in ("o", "u"):
        ys = (height - flange, height) if face == "o" else (0.0, flange)
        return end.x(ys[0], q), end.x(ys[1], q)
    if profile.code in ("M", "SO", "RO", "RU"):
        near = width - web if face == "v" else 0.0
    else:
        near = (width - web) / 2 if profile.code == "I" else 0.0
    return end.x(q, near), end.x(q, near + web)


def _rim(hole: Hole | Slot) -> list[Point]:
    """Points round a hole; round a slot those of its box."""
    radius = hole.diameter / 2
    if isinstance(hole, Hole):
        steps = [2 * pi * k / CHORDS for k in range(CHORDS)]
        rim = [(hole.x + radius * cos(t), hole.y + radius * sin(t)) for t in steps]
        return [*rim, rim[0]]
    box = Slot(
        hole.face, hole.x, hole.y, 0.0, hole.length + hole.diameter, hole.height + hole.diameter,
        hole.angle, hole.source,
    )  # fmt: skip
    a, b, c, d = slot_corners(box)
    return [a, b, d, c, a]
