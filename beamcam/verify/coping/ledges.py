"""What a web keeps along a flange at a hole that reaches it: the torch does not come there.

A hole right under a flange that stays, at its end, is cut up to a ledge; that is as high as the
torch over the web keeps off the flange, or as deep as the pass cuts that takes the root with it.
"""

from collections.abc import Iterator, Sequence
from typing import Any

from beamcam.geometry.plane import Point
from beamcam.verify.coping.section import Section, pieces_of

Shape = Any  #: of shapely

ABOVE = 0.1  #: mm that a ledge is higher than what is cut with the flange
SHORT = 1.0  #: mm; a shorter gap between web and flange is none
FAR = 1e5


def ledges_of(
    web: Shape, flange: Shape, face: str, section: Section, height: float, skew: Sequence[bool]
) -> Iterator[tuple[Shape, list[Point]]]:
    """The ledges of a web along a flange, `height` mm from the flange's outside, and where they end
    in the web's contour; none where the start or the end is skew."""
    from shapely import LineString, box, get_coordinates

    low, high = section.web_ends
    top = section.high - height - ABOVE if face == "o" else height + ABOVE
    inner = high - 0.05 if face == "o" else low + 0.05
    middle = (section.back + section.front) / 2
    line = LineString([(-FAR, inner), (FAR, inner)])
    stays = flange.intersection(LineString([(-FAR, middle), (FAR, middle)]))
    band = (top, section.high) if face == "o" else (0.0, top)
    for one in pieces_of(stays):
        first, _, last, _ = one.bounds
        over = line.intersection(box(first, inner - 1.0, last, inner + 1.0))
        for gap in pieces_of(over.difference(web)):
            x0, _, x1, _ = gap.bounds
            is_first, is_last = abs(x0 - first) < 0.1, abs(x1 - last) < 0.1
            at_end = (is_first and not skew[0]) != (is_last and not skew[1])
            amid = section.high - section.flange / 2 if face == "o" else section.flange / 2
            own = LineString([(x0, amid), (x1, amid)]).difference(web)
            # A web that is not drawn in the flange's own thickness has no flange there.
            if x1 - x0 <= SHORT or not at_end or own.length > SHORT:
                continue
            missing = box(first, band[0], last, band[1]).difference(web)
            for piece in pieces_of(missing):
                if piece.geom_type == "Polygon" and piece.intersects(gap):
                    edge = piece.boundary.intersection(LineString([(-FAR, top), (FAR, top)]))
                    places: Sequence[Any] = get_coordinates(edge).tolist()
                    yield piece.buffer(1e-3, join_style="mitre"), [(x, y) for x, y in places]
