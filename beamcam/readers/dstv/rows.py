"""Rows of the blocks that are not contours: BO, SI, KA, SC, TO, UE, PR, IN and planes."""

import re
from typing import Literal, cast

from beamcam.errors import Rule, Severity, Source
from beamcam.geometry.curves import unit_vector
from beamcam.model.part import (
    Bend,
    Camber,
    EndPlane,
    Hole,
    HoleKind,
    Plane,
    SectionPoint,
    Slot,
    TextMark,
)
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.tokens import (
    EDGES,
    LARGEST,
    Block,
    Log,
    RowError,
    number,
    numbers,
    plain_numbers,
    tokenise,
)

_FACE_LETTERS = frozenset("vouh")
_NO_SLOT = (["0.0"] * 2, ["0.00"] * 3, ["0.00"] * 2, ["0.0"] * 3)  #: columns without the letter l

Sizes = tuple[float, float, float, float, float]  #: diameter, depth, width, height, angle
_SI_TEXT_LIMIT = 40  # DSTV NC, page 12

# DSTV NC, page 10: the letter before the diameter.
_KINDS: dict[str, HoleKind] = {
    "g": "thread",
    "l": "left-thread",
    "m": "mark",
    "s": "countersink",
}

# "  v  30.00u  134.44  0.00 025  pt56"   face, x + reference, y, angle, height + r or z, text
_SI_ROW = re.compile(
    r"([a-zA-Z])?\s*([+-]?[0-9.,]+)(?:\s*([a-zA-Z])\s*|\s+)([+-]?[0-9.,]+)\s+([+-]?[0-9.,]+)"
    r"(?:\s+([0-9]+(?:\.[0-9]+)?)([rz])?\s*(.*))?",
    re.ASCII,
)


class Place:
    """Face and reference letter of the rows of a block, each inherited from the row before."""

    __slots__ = ("edge", "face", "fixed", "log", "plate")

    def __init__(self, log: Log, plane: str | None, plate: bool) -> None:
        self.log = log
        self.fixed = plane is not None
        self.face = plane or ""
        self.edge = ""
        self.plate = plate

    def take(self, tokens: list[str], line: int) -> list[str]:
        """`tokens` without the face that they may begin with. Raises RowError if none is known."""
        if tokens and tokens[0] in _FACE_LETTERS:
            if not self.fixed:
                self.face = tokens[0]
            return tokens[1:]
        self.need(line, " ".join(tokens))
        return tokens

    def need(self, line: int, found: str) -> None:
        """Assume v on a plate where no row named a face. Raises RowError on other sections."""
        if self.face and not found[:1].isalpha():
            return
        if not self.plate or found[:1].isalpha():
            self.log.add(rules.FACE, line, found=found)
            raise RowError(found)
        self.log.add(rules.FACE_ASSUMED, line)
        self.face = "v"

    def refer(self, letter: str, line: int) -> None:
        """Note the reference letter behind x."""
        if letter in EDGES:
            self.edge = letter
        elif letter in _FACE_LETTERS:
            self.log.add(rules.EDGE, line, found=letter)
        else:
            raise RowError(letter)


def read_holes(block: Block, place: Place) -> list[Hole | Slot]:
    """The holes and slots of a block BO or Bn."""
    features: list[Hole | Slot] = []
    log = place.log
    taken = log.taken
    for line, row in zip(block.numbers, block.rows, strict=True):
        # "  v   300.00s   50.00   18.00   0.00"   face, x + reference, y, diameter, depth
        # "  v   115.58s   46.80   31.78   0.00l   0.00   6.40   0.00"   ... a slot's b, h, angle
        tokens = row.split()
        first = 0
        if tokens[0] in _FACE_LETTERS:
            first = 1
            if not place.fixed:
                place.face = tokens[0]
        slotted = False
        try:
            x_text = tokens[first]
            edge = x_text[-1]
            x = float(x_text[:-1] if edge in EDGES else x_text)
            sizes = tokens[first + 1 :]
            if len(sizes) > 3:
                slotted = sizes[2][-1] == "l"
                if slotted:
                    sizes[2] = sizes[2][:-1]
                elif sizes[3:] not in _NO_SLOT:
                    raise RowError(row)
            values = [float(size) for size in sizes]
            y, diameter, *more = values
            if not (place.face and -LARGEST < x + sum(values) < LARGEST):
                raise RowError(row)
            if "_" in row or (len(more) != 4 if slotted else len(more) > 3):
                raise RowError(row)
        except (ValueError, IndexError):
            feature = _hole(row, line, place)
        else:
            if edge in EDGES:
                place.edge = edge
            depth, width, height, angle, *_ = (*more, 0.0, 0.0, 0.0, 0.0)
            feature = _drilled(
                place, line, x, y, "through", (diameter, depth, width, height, angle), slotted
            )
        if feature is not None:
            features.append(feature)
            taken.append(line)
    return features


def _hole(row: str, line: int, place: Place) -> Hole | Slot | None:
    """The hole or slot of any row of BO, glued ones included; None, with an error, for no such."""
    before = len(place.log.diagnostics)
    try:
        x, y, kind, sizes, slotted = _hole_fields(row, line, place)
    except RowError:
        if not _said_error(place.log, before):
            place.log.add(rules.HOLE_FIELDS, line, found=row)
        return None
    return _drilled(place, line, x, y, kind, sizes, slotted)


def _said_error(log: Log, before: int) -> bool:
    """Whether an error was added to the log behind its first `before` diagnostics."""
    return any(d.severity is Severity.ERROR for d in log.diagnostics[before:])


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
        if kind == "through" and depth:
            kind = "blind"
        cx, cy = slot_centre(x, y, width, height, angle)
        return Slot(
            place.face,
            cx,
            cy,
            diameter,
            width,
            height,
            angle,
            source,
            depth or None,
            kind,
            place.edge,
        )
    if kind == "through":
        # DSTV NC, page 10: depth 0 means through; a diameter of 0 can only be a mark.
        kind = "mark" if diameter == 0 else "blind" if depth else kind
    if slotted:
        log.add(rules.SLOT_ROUND, line)
    cone = None
    if angle:
        if kind == "countersink":
            cone = angle
        else:
            log.add(rules.HOLE_ANGLE, line, angle=angle)
    return Hole(place.face, x, y, diameter, source, depth or None, kind, cone, place.edge)


def slot_centre(
    x: float, y: float, width: float, height: float, angle_deg: float
) -> tuple[float, float]:
    """Centre of a slot whose first corner circle is at x, y; sizes are between circle centres.

    DSTV NC, page 11: x and y are those of the first corner circle.
    """
    cos_w, sin_w = unit_vector(angle_deg)
    return x + (width * cos_w - height * sin_w) / 2, y + (width * sin_w + height * cos_w) / 2


def read_texts(block: Block, place: Place) -> list[TextMark]:
    """The text marks of a block SI or Sn."""
    features: list[TextMark] = []
    log = place.log
    for line, row in zip(block.numbers, block.rows, strict=True):
        before = len(log.diagnostics)
        try:
            mark = _text_mark(row, line, place)
        except RowError:
            if not _said_error(log, before):
                log.add(rules.TEXT_FIELDS, line, found=row)
            continue
        if mark is not None:
            features.append(mark)
            log.taken.append(line)
    return features


def _text_mark(row: str, line: int, place: Place) -> TextMark | None:
    log = place.log
    match = _SI_ROW.fullmatch(row)
    if match is None:
        raise RowError(row)
    face, x_text, edge, y_text, angle_text, height_text, option, text = match.groups()
    if face is None:
        place.need(line, x_text)
    else:
        place.take([face], line)
    x, y, angle = numbers([x_text, y_text, angle_text], line, log)
    if edge is not None:
        place.refer(edge, line)
    if height_text is None or not text:
        log.add(rules.NO_MARKING, line, missing="height" if height_text is None else "text")
        return None
    height = number(height_text, line, log)
    if height is None:
        raise RowError(row)
    if len(text) > _SI_TEXT_LIMIT:
        log.add(rules.TEXT_LONG, line, count=len(text), limit=_SI_TEXT_LIMIT)
    option_letter = cast(Literal["", "r", "z"], option or "")
    return TextMark(
        place.face, x, y, angle, height, text, Source(log.file, line), option_letter, place.edge
    )


def read_bends(block: Block, log: Log) -> list[Bend]:
    """The bends of block KA."""
    features: list[Bend] = []
    for line, row in zip(block.numbers, block.rows, strict=True):
        # "  25.0 0.0 25.0 100.0 -90.0 15.0"   x1 y1 x2 y2 angle radius
        try:
            values = plain_numbers(row, line, log)
            if len(values) not in (5, 6):
                raise RowError(row)
        except RowError:
            log.add(rules.BEND_FIELDS, line, found=row)
            continue
        x1, y1, x2, y2, angle = values[:5]
        radius = values[5] if len(values) == 6 else None
        source = Source(log.file, line)
        features.append(Bend((x1, y1), (x2, y2), angle, radius, source))
        log.taken.append(line)
    return features


def read_cambers(block: Block, place: Place) -> list[Camber]:
    """The points of the camber line of block UE."""
    features: list[Camber] = []
    log = place.log
    for line, row in zip(block.numbers, block.rows, strict=True):
        before = len(log.diagnostics)
        try:
            tokens = place.take(tokenise(row), line)
            if len(tokens) == 3 and tokens[1].isalpha():
                place.refer(tokens.pop(1), line)
            if len(tokens) != 2:
                raise RowError(row)
            x, y = numbers(tokens, line, log)
        except RowError:
            if not _said_error(log, before):
                log.add(rules.CAMBER_FIELDS, line, found=row)
            continue
        features.append(Camber(place.face, x, y, Source(log.file, line)))
        log.taken.append(line)
    return features


def read_end_planes(block: Block, log: Log) -> list[EndPlane]:
    """The cutting planes of block SC; six numbers each, on any lines."""
    features: list[EndPlane] = []
    for line, values in _groups(block, 6, 0, log, rules.ENDPLANE_FIELDS):
        x, y, z, nx, ny, nz = values
        if nx == ny == nz == 0.0:
            found = "a normal without length"
            log.add(rules.ENDPLANE_FIELDS, line, found=found, count=1)
            continue
        features.append(EndPlane((x, y, z), (nx, ny, nz), Source(log.file, line)))
    return features


def read_plane(block: Block, name: str, log: Log) -> Plane | None:
    """The plane of a block En: three rows of three numbers, or all nine on fewer lines."""
    groups = _groups(block, 9, 1, log, rules.PLANE_FIELDS)
    if not groups:
        return None
    a, b, c, d, e, f, g, h, i = groups[0][1]
    return Plane(name, (a, b, c), (d, e, f), (g, h, i), Source(log.file, block.line))


def read_tolerance(block: Block, log: Log) -> tuple[float, float] | None:
    """Least and greatest deviation of the length (TO)."""
    groups = _groups(block, 2, 1, log, rules.TOLERANCE_FIELDS)
    if not groups:
        return None
    least, greatest = groups[0][1]
    return least, greatest


def _groups(
    block: Block, size: int, count: int, log: Log, rule: Rule
) -> list[tuple[int, list[float]]]:
    """The numbers of a block by `size`, each group with its first line.

    Numbers count and lines do not, since some programs join the three rows of a plane. `count`
    groups are expected, any number if it is 0. Otherwise there are none, and one error that says
    how many rows that leaves out.
    """
    values: list[tuple[int, float]] = []
    wrong: tuple[int, str] | None = None
    for line, row in zip(block.numbers, block.rows, strict=True):
        try:
            values.extend((line, value) for value in plain_numbers(row, line, log))
        except RowError:
            wrong = wrong or (line, row)
    if wrong is None and (len(values) % size or (count and len(values) != size * count)):
        wrong = block.numbers[0] if block.numbers else block.line, f"{len(values)} numbers"
    if wrong is not None:
        log.add(rule, wrong[0], found=wrong[1], count=len(block.rows))
        log.left_out.extend(block.numbers)
        return []
    log.taken.extend(block.numbers)
    groups = [values[i : i + size] for i in range(0, len(values), size)]
    return [(group[0][0], [value for _, value in group]) for group in groups]


def read_section(block: Block, log: Log, points: list[SectionPoint]) -> None:
    """Append the corners of a special profile's cross-section (PR) to `points`."""
    for line, row in zip(block.numbers, block.rows, strict=True):
        # "  +   48.000   79.500   0.00"   side, y, z, radius
        try:
            values = plain_numbers(row[1:], line, log)
            if row[0] not in "+-" or len(values) not in (2, 3):
                raise RowError(row)
        except RowError:
            log.add(rules.SECTION_FIELDS, line, found=row)
            continue
        side: Literal["+", "-"] = "+" if row[0] == "+" else "-"
        points.append(SectionPoint(side, values[0], values[1], [*values, 0.0][2]))
        log.taken.append(line)


def read_info(block: Block, log: Log) -> list[tuple[str, str]]:
    """Word and text of each line of block IN; the word is empty where there is no colon."""
    log.taken.extend(block.numbers)
    pairs = []
    for row in block.rows:
        word, colon, text = row.partition(":")
        pairs.append((word.strip(), text.strip()) if colon else ("", row))
    return pairs
