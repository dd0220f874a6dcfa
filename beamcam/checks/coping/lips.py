"""Strokes through the lips of a C: from side to side of each, and in the plane of its end.

How deep they are follows from their feeds, as of every stroke; a lip is cut by those alone.
"""

from collections.abc import Iterator, Sequence
from math import atan, cos, radians, tan

from beamcam.checks.coping import rules
from beamcam.checks.coping.section import CoperSection, line_of, pieces_of
from beamcam.checks.coping.skew import SkewEnd
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.errors import Diagnostic, Source

ALONG_LIP = 4.0  #: mm along the bar by mm across it that a cut through a lip goes, at most
SURE = 0.01  #: mm that figures may be off


def lip_faults(
    stroke: TorchStroke, made: Sequence[SkewEnd], section: CoperSection, slack: float,
    source: Source,
) -> Iterator[Diagnostic]:  # fmt: skip
    """A stroke on a flange that, behind its lead, does not go through a lip from side to side, or
    whose torch does not lie in the plane of its end all along the lip."""
    from shapely import box

    run = line_of(stroke.points[1:]).intersection(box(-1e6, 0.0, 1e6, section.bend - SURE))
    crossing = [one.bounds for one in pieces_of(run)]
    if not crossing:
        return
    for x0, y0, x1, y1 in crossing:
        along = x1 - x0 > ALONG_LIP * section.bend + stroke.row.kerf
        if along or y0 > SURE or y1 < section.bend - 2 * SURE:
            yield rules.PLACE.at(
                source, y=f"{y0:g}", face=stroke.face, least=f"{section.bend:g}",
                most=f"{section.wide:g}",
            )  # fmt: skip
            return
    x0, y0, x1, y1 = run.bounds
    wanted, side = 0.0, 1
    for end in made:
        at, more = end.on(stroke.face, section, 0.0)
        long, near = cos(atan(more)), stroke.row.kerf / 2 / stroke.share + slack
        if all(abs(x - at - more * y) * long <= near for x, y in stroke.points[1:-1]):
            wanted, side = end.on(stroke.face, section, 1.0)[0] - at, end.side
    off = side * section.lip * (-tan(radians(stroke.b_deg)) - wanted)
    if abs(off) <= slack:
        return
    place = {"face": stroke.face, "x": f"{(x0 + x1) / 2:.1f}", "y": f"{(y0 + y1) / 2:.1f}"}
    if off > 0.0:
        yield rules.LEFT.at(source, found=f"{off:.2f}", **place)
    else:
        yield rules.HURT.at(source, found=f"{-off:.2f}", expected=f"{slack:.2f}", **place)
