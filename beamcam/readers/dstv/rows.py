"""Rows of the smaller blocks: SI, KA, SC, TO, UE, PR, IN and planes."""

import re
from collections.abc import Callable, Iterator
from math import inf
from typing import Literal, TypeVar, cast

from msgspec import Struct

from beamcam.errors import Rule, Severity, Source
from beamcam.geometry.curves import unit_vector
from beamcam.model.part import (
    Bend,
    Camber,
    EndPlane,
    Feature,
    Hole,
    HoleKind,
    Plane,
    Profile,
    SectionPoint,
    Slot,
    TextMark,
)
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.blocks import (
    EDGES,
    Block,
    Log,
    RowError,
    numbers,
    required_number,
    tokenise,
)

Item = TypeVar("Item")
RowReader = Callable[[str, int, "RowPlace"], Item]  #: of a row, its line, and where it lies

FACE_LETTERS = frozenset("vouh")
CAPITALS = frozenset("VOUHS")  #: of faces and of reference letters
_FACES = FACE_LETTERS | frozenset("VOUH")


class RowPlace(Struct):
    """Face and reference letter of the rows of a block, each inherited from the row before."""

    log: Log
    profile: Profile
    face: str  #: "" where no row has named one; of a block on a plane its name, which stays
    edge: str = ""
    has_capital: bool = False  #: whether a capital is reported

    def take(self, tokens: list[str], line: int) -> list[str]:
        """`tokens` without the face that they may begin with.

        Where no row named one it is v on a plate; on other sections RowError is raised.
        """
        if tokens and tokens[0] in _FACES:
            letter = self.small(tokens[0], line)
            if len(self.face) < 2:
                self.face = letter
            return tokens[1:]
        found = " ".join(tokens)
        if found[:1].isalpha() or not (self.face or self.profile.code == "B"):
            self.log.add(rules.FACE, line, found=found)
            raise RowError(found)
        if not self.face:
            self.log.add(rules.FACE_ASSUMED, line)
            self.face = "v"
        return tokens

    def refer(self, letter: str, line: int) -> str:
        """The reference letter behind x as it is meant, which is noted."""
        letter = self.small(letter, line)
        if letter in EDGES:
            self.edge = letter
        elif letter in FACE_LETTERS:
            self.log.add(rules.EDGE, line, found=letter)
        else:
            raise RowError(letter)
        return letter

    def small(self, letter: str, line: int) -> str:
        """The letter of a face or a reference as it is meant, whose capital is reported."""
        if letter not in CAPITALS:
            return letter
        if not self.has_capital:
            self.log.add(rules.FACE_CASE, line, found=letter, read=letter.lower())
            self.has_capital = True
        return letter.lower()

    def corner(self, row: str, line: int, least: int = 0) -> tuple[float, str, float, list[str]]:
        """x, the letter behind it or "", y, and the tokens that follow, `least` or more.

        Raises RowError for a row that does not begin so.
        """
        tokens = self.take(tokenise(row), line)
        if len(tokens) < least + 2:
            raise RowError(row)
        x = required_number(tokens[0], line, self.log)
        letter = ""
        if tokens[1].isalpha():
            letter = self.refer(tokens.pop(1), line)
            if len(tokens) < least + 2:
                raise RowError(row)
        y = required_number(tokens[1], line, self.log)
        return x, letter, y, tokens[2:]


def rows_of(
    block: Block, place: RowPlace, read: RowReader[Item], rule: Rule
) -> Iterator[tuple[int, Item]]:
    """The line of each row, and what `read` makes of it.

    Rows that `read` has no explanation for (RowError) are reported by `rule`, unless an error says
    already what is wrong with them.
    """
    log = place.log
    for line, row in zip(block.numbers, block.rows, strict=True):
        before = len(log.diagnostics)
        try:
            item = read(row, line, place)
        except RowError:
            if not any(d.severity is Severity.ERROR for d in log.diagnostics[before:]):
                log.add(rule, line, found=row)
            continue
        yield line, item


def features_of(
    block: Block, place: RowPlace, read: RowReader[Item | None], rule: Rule
) -> list[Item]:
    """What `read` makes of the rows, whose lines are taken; rows that make nothing are not."""
    found = [(line, item) for line, item in rows_of(block, place, read, rule) if item is not None]
    place.log.taken += [line for line, _ in found]
    return [item for _, item in found]


_SI_TEXT_LIMIT = 40  # DSTV NC, page 12

# "  v  30.00u  134.44  0.00 025  pt56"   face, x + reference, y, angle, height + r or z, text
_SI_ROW = re.compile(
    r"([a-zA-Z])?\s*([+-]?[0-9.,]+)(?:\s*([a-zA-Z])\s*|\s+)([+-]?[0-9.,]+)\s+([+-]?[0-9.,]+)"
    r"(?:\s+([0-9]+(?:\.[0-9]+)?)([rz])?\s*(.*))?",
    re.ASCII,
)


def read_text(row: str, line: int, place: RowPlace) -> TextMark | None:
    """The text of a row of SI or Sn; None, with an error, if there is nothing to write."""
    log = place.log
    match = _SI_ROW.fullmatch(row)
    if match is None:
        raise RowError(row)
    face, x_text, edge, y_text, angle_text, height_text, option, text = match.groups()
    place.take([face or x_text], line)
    x, y, angle = numbers([x_text, y_text, angle_text], line, log)
    if edge is not None:
        place.refer(edge, line)
    if height_text is None or not text:
        log.add(rules.NO_MARKING, line, missing="height" if height_text is None else "text")
        return None
    height = required_number(height_text, line, log)
    if len(text) > _SI_TEXT_LIMIT:
        log.add(rules.TEXT_LONG, line, count=len(text), limit=_SI_TEXT_LIMIT)
    option_letter = cast(Literal["", "r", "z"], option or "")
    return TextMark(
        place.face, x, y, angle, height, text, Source(log.file, line), option_letter, place.edge
    )


def read_bend(row: str, line: int, place: RowPlace) -> Bend:
    """The bend of a row of KA."""
    # "  25.0 0.0 25.0 100.0 -90.0 15.0"   x1 y1 x2 y2 angle radius
    values = numbers(tokenise(row), line, place.log)
    if len(values) not in (5, 6):
        raise RowError(row)
    x1, y1, x2, y2, angle, *radius = values
    source = Source(place.log.file, line)
    return Bend((x1, y1), (x2, y2), angle, radius[0] if radius else None, source)


def read_camber(row: str, line: int, place: RowPlace) -> Camber:
    """The point of the camber line of a row of UE."""
    tokens = place.take(tokenise(row), line)
    if len(tokens) == 3 and tokens[1].isalpha():
        place.refer(tokens.pop(1), line)
    if len(tokens) != 2:
        raise RowError(row)
    x, y = numbers(tokens, line, place.log)
    return Camber(place.face, x, y, Source(place.log.file, line))


def read_end_planes(block: Block, log: Log) -> list[EndPlane]:
    """The cutting planes of block SC; six numbers each, on any lines."""
    planes: list[EndPlane] = []
    for line, (x, y, z, nx, ny, nz) in _groups(block, 6, 0, log, rules.ENDPLANE_FIELDS):
        if nx == ny == nz == 0.0:
            log.add(rules.ENDPLANE_FIELDS, line, found="a normal without length", count=1)
        else:
            planes.append(EndPlane((x, y, z), (nx, ny, nz), Source(log.file, line)))
    return planes


def read_plane(block: Block, name: str, log: Log) -> Plane | None:
    """The plane of a block En: three rows of three numbers, or all nine on fewer lines."""
    for _, (a, b, c, d, e, f, g, h, i) in _groups(block, 9, 1, log, rules.PLANE_FIELDS):
        return Plane(name, (a, b, c), (d, e, f), (g, h, i), Source(log.file, block.line))
    return None


def read_tolerance(block: Block, log: Log) -> tuple[float, float] | None:
    """Lower and upper deviation of the length (TO)."""
    for _, (least, greatest) in _groups(block, 2, 1, log, rules.TOLERANCE_FIELDS):
        return least, greatest
    return None


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
            values.extend((line, value) for value in numbers(tokenise(row), line, log))
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


def read_section_point(row: str, line: int, place: RowPlace) -> SectionPoint:
    """The corner of a special profile's cross-section of a row of PR."""
    # "  +   48.000   79.500   0.00"   side, y, z, radius
    values = numbers(tokenise(row[1:]), line, place.log)
    if row[0] not in "+-" or len(values) not in (2, 3):
        raise RowError(row)
    return SectionPoint("+" if row[0] == "+" else "-", values[0], values[1], [*values, 0.0][2])


def read_info(block: Block, log: Log) -> list[tuple[str, str]]:
    """Word and text of each line of block IN; the word is empty where there is no colon."""
    log.taken.extend(block.numbers)
    pairs = []
    for row in block.rows:
        word, colon, text = row.partition(":")
        pairs.append((word.strip(), text.strip()) if colon else ("", row))
    return pairs


# --- holes ----------------------------------------------------------------------------------------

WALL_NOISE = 0.01  #: mm that a depth of a wall is rounded by
# DSTV NC, page 10: the letter before the diameter.
_KINDS: dict[str, HoleKind] = {
    "g": "thread", "l": "left-thread", "m": "mark", "s": "countersink",
}  # fmt: skip


def read_hole(row: str, line: int, place: RowPlace) -> Hole | Slot | None:
    """The hole or slot of a row of BO or Bn, glued ones included; None, with an error, for no
    such.

    Raises RowError if no rule explains the row.
    """
    log = place.log
    x, _, y, rest = place.corner(row, line, least=1)
    kind: HoleKind = "through"
    if rest[0] in _KINDS:
        kind, rest = _KINDS[rest[0]], rest[1:]
    slotted = "l" in rest
    if slotted:
        at = rest.index("l")
        sizes, tail = numbers(rest[:at], line, log), rest[at + 1 :]
        if not 1 <= len(sizes) <= 2 or not 1 <= len(tail) <= 3:
            raise RowError(row)
        sizes = [*sizes, 0.0][:2] + numbers(tail, line, log)
    else:
        sizes = numbers(rest, line, log)
    if not 1 <= len(sizes) <= 5:
        raise RowError(row)
    diameter, depth, width, height, angle = [*sizes, 0.0, 0.0, 0.0, 0.0][:5]
    if diameter < 0 or depth < 0:
        log.add(rules.HOLE_DIAMETER, line, diameter=diameter, depth=depth)
        return None
    if kind == "through" and depth and _goes_through(place, depth):
        wall = place.profile.thickness(place.face)
        log.add(rules.HOLE_THROUGH, line, depth=depth, wall=wall)
        depth = 0.0
    if kind == "through":
        # DSTV NC, page 10: depth 0 means through; a diameter of 0 can only be a mark.
        is_mark = diameter == 0 and not (width or height)
        kind = "mark" if is_mark else "blind" if depth else "through"
    source = Source(log.file, line)
    if width or height:
        if not slotted:
            log.add(rules.SLOT_LETTER, line, width=width, height=height)
        # DSTV NC, page 11: x and y are of the first corner circle, the others may lie on either
        # side of it; width and height are between the circles' centres.
        cos_w, sin_w = unit_vector(angle)
        x += (width * cos_w - height * sin_w) / 2
        y += (width * sin_w + height * cos_w) / 2
        between = diameter, abs(width), abs(height), angle
        return Slot(place.face, x, y, *between, source, depth or None, kind, place.edge)
    if slotted:
        log.add(rules.SLOT_ROUND, line)
    cone = angle if kind == "countersink" else 0.0
    if angle and not cone:
        log.add(rules.HOLE_ANGLE, line, angle=angle)
    return Hole(place.face, x, y, diameter, source, depth or None, kind, cone or None, place.edge)


def _goes_through(place: RowPlace, depth: float) -> bool:
    """Whether a depth is that of the wall or more, and ends before the next wall of a tube."""
    profile = place.profile
    is_edge = profile.code == "B" and place.face in "ou"
    if place.face not in FACE_LETTERS or profile.code in ("RU", "SO") or is_edge:
        return False
    wall = profile.thickness(place.face)
    across = profile.width if place.face in "vh" and profile.code == "M" else profile.height
    most = across - wall if profile.code in ("M", "RO") else inf
    return 0.0 < wall <= depth + WALL_NOISE and depth < most - WALL_NOISE


#: Blocks of a feature a row: what reads a row, and the rule for one that nothing explains.
FEATURES: dict[str, tuple[RowReader[Feature | None], Rule]] = {
    "BO": (read_hole, rules.HOLE_FIELDS), "SI": (read_text, rules.TEXT_FIELDS),
    "KA": (read_bend, rules.BEND_FIELDS), "UE": (read_camber, rules.CAMBER_FIELDS),
}  # fmt: skip
