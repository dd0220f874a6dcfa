"""Holes and slots: block BO, and Bn on planes."""

from beamcam.errors import Source
from beamcam.geometry.curves import unit_vector
from beamcam.model.part import Hole, HoleKind, Slot
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.place import Place
from beamcam.readers.dstv.tokens import RowError, numbers

Sizes = tuple[float, float, float, float, float]  #: diameter, depth, width, height, angle

# DSTV NC, page 10: the letter before the diameter.
_KINDS: dict[str, HoleKind] = {
    "g": "thread",
    "l": "left-thread",
    "m": "mark",
    "s": "countersink",
}


def read_hole(row: str, line: int, place: Place) -> Hole | Slot | None:
    """The hole or slot of a row of BO or Bn, glued ones included; None, with an error, for no
    such."""
    return _drilled(place, line, *_hole_fields(row, line, place))


def _hole_fields(row: str, line: int, place: Place) -> tuple[float, float, HoleKind, Sizes, bool]:
    """x, y, kind, sizes, and whether the row has the letter of a slot.

    Raises RowError if no rule explains the row.
    """
    log = place.log
    x, _, y, rest = place.corner(row, line, least=1)
    kind: HoleKind = "through"
    if rest[0] in _KINDS:
        kind, rest = _KINDS[rest[0]], rest[1:]
    slotted = "l" in rest
    at = rest.index("l") if slotted else len(rest)
    sizes = numbers(rest[:at], line, log)
    if slotted:
        tail = rest[at + 1 :]
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
        # DSTV NC, page 10: depth 0 means through; a diameter of 0 can only be a mark.
        kind = "mark" if diameter == 0 else "blind" if depth else "through"
    if slotted:
        log.add(rules.SLOT_ROUND, line)
    cone = angle if kind == "countersink" else 0.0
    if angle and not cone:
        log.add(rules.HOLE_ANGLE, line, angle=angle)
    return Hole(place.face, x, y, diameter, source, depth or None, kind, cone or None, place.edge)


def _slot(place: Place, line: int, x: float, y: float, kind: HoleKind, sizes: Sizes) -> Slot:
    """The slot whose first corner circle is at x, y; the others may lie on either side of it.

    Width and height are between the circles' centres. DSTV NC, page 11.
    """
    diameter, depth, width, height, angle = sizes
    if kind == "through" and depth:
        kind = "blind"
    cos_w, sin_w = unit_vector(angle)
    x += (width * cos_w - height * sin_w) / 2
    y += (width * sin_w + height * cos_w) / 2
    source = Source(place.log.file, line)
    width, height = abs(width), abs(height)
    return Slot(
        place.face, x, y, diameter, width, height, angle, source, depth or None, kind, place.edge
    )
