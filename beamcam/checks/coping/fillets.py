"""Strokes on a flange that run along its web, by the steel of the section between both.

A jet that stays beside the web goes through flange and fillet, and behind them through air. How
much steel that is, is measured on the section itself, at the side of the kerf towards the web.
"""

from shapely import LineString, box

from beamcam.checks.coping.section import CoperSection, line_of, pieces_of
from beamcam.checks.coping.strokes import TorchStroke

FLUSH = 0.1  #: mm that a kerf may reach over the surface of a web along it and be beside it
STRAIGHT = 0.1  #: mm that a way through a root may be off straight
OFF = 0.02  #: mm that a kerf's side may be off by figures of a program and by chords


def beside_web(stroke: TorchStroke, section: CoperSection) -> tuple[float, float] | None:
    """The least and the most steel of a flange and the fillet on it, where a stroke does not go
    straight through the whole root; None where it does, or keeps clear of web and fillets."""
    if stroke.face == "v" or section.code == "C" or stroke.is_tilted:
        return None
    back, front = section.root(stroke.face)
    half, middle = stroke.row.kerf / 2, (section.back + section.front) / 2
    ys = [y for _, y in stroke.points[1:]]
    if min(ys) < middle < max(ys):
        whole = section.flange + section.radius
        return None if _is_straight(stroke, section) else (whole, whole)
    if max(ys) <= middle:
        side, zs = max(ys) + half, (-OFF, OFF)
        reached = side > back
    else:
        side, zs = min(ys) - half, (OFF, -OFF)
        reached = side < front
    if not reached:
        return None
    least, most = (  # of flange and fillet; at the web all of the fillet
        section.flange + section.radius if section.back <= side + z <= section.front
        else section.steel_through(stroke.face, side + z)
        for z in zs
    )  # fmt: skip
    return least, most


def _is_straight(stroke: TorchStroke, section: CoperSection) -> bool:
    """Whether a stroke goes on straight lines alone over the web and the half of its fillets that
    is thick, but for where a contour turns beside that."""
    thick = section.radius / 2 - 1.0
    low = max(section.back - thick, STRAIGHT)
    high = min(section.front + thick, section.wide - STRAIGHT)
    ways = line_of(stroke.points[1:]).intersection(box(-1e6, low, 1e6, high))
    for way in pieces_of(ways):
        _, y0, _, y1 = way.bounds
        chord = LineString([way.coords[0], way.coords[-1]])
        if y1 - y0 < high - low - STRAIGHT or way.hausdorff_distance(chord) > STRAIGHT:
            return False
    return True
