"""Holes and slots: block BO, and Bn on planes."""

import re
from collections.abc import Iterable
from itertools import repeat

from beamcam.errors import Source
from beamcam.geometry.curves import unit_vector
from beamcam.model.part import Hole, HoleKind, Slot
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.place import FACE_LETTERS, Place, said_error
from beamcam.readers.dstv.tokens import EDGES, LARGEST, Block, RowError, numbers, tokenise

_NO_SLOT: tuple[list[str], ...] = (
    [],
    ["0.0"] * 2,
    ["0.00"] * 3,
    ["0.00"] * 2,
    ["0.0"] * 3,
)  #: columns behind a depth without l

Sizes = tuple[float, float, float, float, float]  #: diameter, depth, width, height, angle

# DSTV NC, page 10: the letter before the diameter.
_KINDS: dict[str, HoleKind] = {
    "g": "thread",
    "l": "left-thread",
    "m": "mark",
    "s": "countersink",
}


# "  v   300.00s   50.00   18.00   0.00"   the rows of a block if all of them are as plain as this;
# what may be a number is one if float says so, and twelve characters are below LARGEST.
_PLAIN = re.compile(
    r"^([vouh]) ++([-+.0-9]{1,12}+)([uos]) ++([-+.0-9]{1,12}+) ++([.0-9]{1,12}+)"
    r"(?: ++([.0-9]{1,12}+))?$",
    re.MULTILINE,
)


def read_holes(block: Block, place: Place) -> list[Hole | Slot]:
    """The holes and slots of a block BO or Bn."""
    log = place.log
    features: list[Hole | Slot] = []
    try:
        features += _plain_holes(block, place)
    except ValueError:
        pass  # the rows are not all that plain, and are read one by one
    else:
        log.taken += block.numbers
        return features
    for line, row in zip(block.numbers, block.rows, strict=True):
        tokens = row.split()
        if tokens[0] in FACE_LETTERS:
            if not place.fixed:
                place.face = tokens[0]
            del tokens[0]
        try:
            feature: Hole | Slot | None = _plain_hole(tokens, line, place)
        except (ValueError, IndexError):
            feature = _hole(row, line, place)
        if feature is not None:
            features.append(feature)
            log.taken.append(line)
    return features


def _plain_holes(block: Block, place: Place) -> list[Hole]:
    """The holes of a block whose rows are all as most programs write them, column by column.

    Raises ValueError for any other block, which says nothing about its being right.
    """
    rows = [] if place.fixed else _PLAIN.findall("\n".join(block.rows))
    if not rows or len(rows) != len(block.rows):
        raise ValueError
    faces, xs, edges, ys, sizes, deeps = zip(*rows, strict=True)
    diameters = [*map(float, sizes)]
    depths: Iterable[float | None] = repeat(None)
    kinds: Iterable[HoleKind] = repeat("through")
    if any(deeps) or 0.0 in diameters:
        depths = [float(deep or 0) or None for deep in deeps]
        kinds = map(_kind, diameters, depths)
    sources = map(Source, repeat(place.log.file), block.numbers)
    holes = [
        *map(Hole, faces, map(float, xs), map(float, ys), diameters, sources, depths, kinds,
             repeat(None), edges)
    ]  # fmt: skip
    place.face, place.edge = faces[-1], edges[-1]
    return holes


def _plain_hole(tokens: list[str], line: int, place: Place) -> Hole | Slot:
    """The hole or slot of a row as most programs write it, `tokens` being what follows the face.

    Raises ValueError or IndexError for any other row, which says nothing about its being right.
    """
    # "  v   300.00s   50.00   18.00   0.00"   face, x + reference, y, diameter, depth
    # "  v   115.58s   46.80   31.78   0.00l   0.00   6.40   0.00"   ... a slot's b, h, angle
    text = tokens[0]
    edge = text[-1]
    if edge in EDGES:
        x = float(text[:-1])
    else:
        x, edge = float(text), place.edge
    y, diameter = float(tokens[1]), float(tokens[2])
    depth = 0.0
    sizes = None
    if len(tokens) > 3:
        text = tokens[3]
        if text[-1] == "l":
            depth = float(text[:-1])
            width, height, angle = map(float, tokens[4:])
            sizes = (diameter, depth, width, height, angle)
        elif tokens[4:] in _NO_SLOT:
            depth = float(text)
        else:
            raise RowError(text)
    total = x + y + (sum(sizes) if sizes else diameter + depth)
    if not -LARGEST < total < LARGEST or diameter < 0 or depth < 0 or not place.face:
        raise RowError(text)
    if "_" in "".join(tokens):
        raise RowError(text)
    place.edge = edge
    if sizes is not None:
        if not (sizes[2] or sizes[3]):
            raise RowError(text)
        return _slot(place, line, x, y, "through", sizes)
    source = Source(place.log.file, line)
    kind = _kind(diameter, depth)
    return Hole(place.face, x, y, diameter, source, depth or None, kind, None, edge)


def _kind(diameter: float, depth: float | None) -> HoleKind:
    """Meaning of a row without a letter before its diameter.

    DSTV NC, page 10: depth 0 means through; a diameter of 0 can only be a mark.
    """
    return "mark" if diameter == 0 else "blind" if depth else "through"


def _hole(row: str, line: int, place: Place) -> Hole | Slot | None:
    """The hole or slot of any row of BO, glued ones included; None, with an error, for no such."""
    before = len(place.log.diagnostics)
    try:
        x, y, kind, sizes, slotted = _hole_fields(row, line, place)
    except RowError:
        if not said_error(place.log, before):
            place.log.add(rules.HOLE_FIELDS, line, found=row)
        return None
    return _drilled(place, line, x, y, kind, sizes, slotted)


def _hole_fields(row: str, line: int, place: Place) -> tuple[float, float, HoleKind, Sizes, bool]:
    """x, y, kind, sizes, and whether the row has the letter of a slot.

    Raises RowError if no rule explains the row.
    """
    log = place.log
    tokens = place.take(tokenise(row), line)
    if len(tokens) < 3:
        raise RowError(row)
    (x,) = numbers(tokens[:1], line, log)
    rest = tokens[1:]
    if rest[0].isalpha():
        place.refer(rest[0], line)
        rest = rest[1:]
    if len(rest) < 2:
        raise RowError(row)
    (y,) = numbers(rest[:1], line, log)
    rest = rest[1:]
    kind: HoleKind = "through"
    if rest[0] in _KINDS:
        kind, rest = _KINDS[rest[0]], rest[1:]
    slotted = "l" in rest
    head, tail = (rest[: rest.index("l")], rest[rest.index("l") + 1 :]) if slotted else (rest, [])
    sizes = numbers(head, line, log)
    if slotted:
        if not 1 <= len(sizes) <= 2 or not 1 <= len(tail) <= 3:
            raise RowError(row)
        sizes = [*sizes, 0.0][:2] + numbers(tail, line, log)
    if not 1 <= len(sizes) <= 5:
        raise RowError(row)
    diameter, depth, width, height, angle, *_ = (*sizes, 0.0, 0.0, 0.0, 0.0)
    return x, y, kind, (diameter, depth, width, height, angle), slotted


def _drilled(
    place: Place, line: int, x: float, y: float, kind: HoleKind, sizes: Sizes, slotted: bool
) -> Hole | Slot | None:
    """The hole or slot that the values of a row mean; None, with an error, if it cannot be."""
    diameter, depth, width, height, angle = sizes
    log = place.log
    if diameter < 0 or depth < 0:
        log.add(rules.HOLE_DIAMETER, line, diameter=diameter, depth=depth)
        return None
    source = Source(log.file, line)
    if width or height:
        if not slotted:
            log.add(rules.SLOT_LETTER, line, width=width, height=height)
        return _slot(place, line, x, y, kind, sizes)
    if kind == "through":
        kind = _kind(diameter, depth)
    if slotted:
        log.add(rules.SLOT_ROUND, line)
    cone = None
    if angle:
        if kind == "countersink":
            cone = angle
        else:
            log.add(rules.HOLE_ANGLE, line, angle=angle)
    return Hole(place.face, x, y, diameter, source, depth or None, kind, cone, place.edge)


def _slot(place: Place, line: int, x: float, y: float, kind: HoleKind, sizes: Sizes) -> Slot:
    """The slot whose first corner circle is at x, y; the others may lie on either side of it."""
    diameter, depth, width, height, angle = sizes
    if kind == "through" and depth:
        kind = "blind"
    cx, cy = slot_centre(x, y, width, height, angle)
    source = Source(place.log.file, line)
    width, height = abs(width), abs(height)
    return Slot(
        place.face, cx, cy, diameter, width, height, angle, source, depth or None, kind, place.edge
    )


def slot_centre(
    x: float, y: float, width: float, height: float, angle_deg: float
) -> tuple[float, float]:
    """Centre of a slot whose first corner circle is at x, y; sizes are between circle centres.

    DSTV NC, page 11: x and y are those of the first corner circle.
    """
    cos_w, sin_w = unit_vector(angle_deg)
    return x + (width * cos_w - height * sin_w) / 2, y + (width * sin_w + height * cos_w) / 2
