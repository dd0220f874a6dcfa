"""Texts of a drawing that are to be lettered: those on layers that are mapped to a mark."""

from collections.abc import Iterator
from math import atan2, cos, degrees, hypot, radians, sin
from typing import Any

from beamcam.errors import Source
from beamcam.geometry.lettering import glyph_of, spelled
from beamcam.model.part import TextMark
from beamcam.readers.dxf.frame import Frame

KINDS = ("TEXT", "MTEXT")
LINE_SPACING = 5 / 3  #: of MTEXT, as a share of its height. Source: DXF reference, group 44
#: Up to the baseline from where a text is held, in heights: baseline, bottom, middle, top.
_FEET = (0.0, 1 / 3, -0.5, -1.0)


def text_marks(entity: Any, frame: Frame, source: Source) -> Iterator[TextMark]:
    """The lines of a text, each from where its baseline begins."""
    if entity.dxftype() == "TEXT":
        lines, across, up = [entity.plain_text()], *_held(entity)
        at = entity.dxf.insert if (across, up) == (0.0, 0.0) else entity.dxf.align_point
        height, turn = entity.dxf.height, entity.dxf.get("rotation", 0.0)
    else:
        lines = entity.plain_text().split("\n")
        place = entity.dxf.get("attachment_point", 1) - 1
        across, row = (place % 3) / 2, place // 3
        height, turn = entity.dxf.char_height, entity.get_rotation()
        below = (len(lines) - 1) * LINE_SPACING
        up = (-1.0, below / 2 - 0.5, below)[row]
        at = entity.dxf.insert
    c, s = cos(radians(turn)), sin(radians(turn))
    ux, uy = frame.vector((c, s, 0.0))
    scale = hypot(ux, uy)
    for number, line in enumerate(lines):
        if not line.strip():
            continue
        begin, foot = -across * _width(line) * height, (up - number * LINE_SPACING) * height
        x, y = frame.point((at[0] + begin * c - foot * s, at[1] + begin * s + foot * c, at[2]))
        yield TextMark("v", x, y, degrees(atan2(uy, ux)), height * scale, line.strip(), source)


def _held(text: Any) -> tuple[float, float]:
    """Alignment point of a TEXT: as a share of its length, and above its baseline in heights."""
    across = (0.0, 0.5, 1.0, 0.0, 0.5, 0.0)[text.dxf.get("halign", 0)]
    if text.dxf.get("halign", 0) == 4:  # by its middle
        return 0.5, -0.5
    return across, _FEET[text.dxf.get("valign", 0)]


def _width(line: str) -> float:
    """Length of a line of text in heights."""
    glyphs = (glyph_of(sign) for sign in spelled(line, {}).text)
    return sum(glyph.advance for glyph in glyphs if glyph is not None)
