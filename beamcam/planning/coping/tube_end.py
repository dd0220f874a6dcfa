"""The skew ends of a round tube on its unrolled surface, and what square cuts leave of bevels.

  x |   /\\            A plane through a tube meets the outside of its wall along a sine of u, and
____|_ /  \\ _____     the inside along one that is as much lower as its radius is smaller. The
    | /    \\          torch cuts square to the surface where the wall reaches farthest, outside
    |/      \\__       on one half of the way round and inside on the other.
"""

from collections.abc import Iterator
from math import atan2, ceil, hypot, pi, radians, sqrt, tan
from typing import Literal

import numpy as np

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Point
from beamcam.model.part import Contour, Part
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping.regions import CHORD, Shape

SKEW_DEG = 0.2  #: of an end; less is noise of a header
MEET = 1.0  #: mm that an outline may be off the plane of the header and mean it


def slopes(part: Part, side: int) -> tuple[float, float]:
    """tan of the angles that the header has for an end, of the web and of the flange."""
    cuts = part.cuts
    both = (cuts.web_start, cuts.flange_start) if side < 0 else (cuts.web_end, cuts.flange_end)
    web, flange = (tan(radians(deg)) if abs(deg) > SKEW_DEG else 0.0 for deg in both)
    return web, flange


def skew_of(part: Part) -> float:
    """mm that square cuts of skew ends leave at the inside of a round tube, at most."""
    wall = max(part.profile.thickness("v"), part.profile.flange_thickness)
    return max(wall * hypot(*slopes(part, side)) for side in (-1, 1))


def wedge_of(contour: Contour, wall: float, least_deg: float) -> float:
    """mm that a square cut leaves before the farther surface of its bevelled edges, at most."""
    return max(
        (
            max(0.0, wall - bevel.land) * tan(radians(min(abs(bevel.angle), 89.0)))
            for bevel in contour.bevels
            if abs(bevel.angle) >= least_deg
        ),
        default=0.0,
    )


def end_line(part: Part, side: int) -> Floats:
    """Rows of (x, u) once round, along which an end by the header is cut."""
    radius = part.profile.height / 2
    wall = max(part.profile.thickness("v"), part.profile.flange_thickness)
    web, flange = slopes(part, side)
    reach = radius * hypot(web, flange)
    count = max(8, ceil(2 * pi / sqrt(4 * CHORD / reach))) if reach else 1
    first = atan2(web, flange)  # where outside and inside are at one x, and half a turn on
    turns = {0.0, 2 * pi, first % (2 * pi), (first + pi) % (2 * pi)}
    at = np.array(sorted(turns | {2 * pi * k / count for k in range(count)}))
    # x = c - Y tan(web) - Z tan(flange) from the axis, at u = 0 its lowest line
    traces = [r * (web * np.cos(at) - flange * np.sin(at)) for r in (radius, radius - wall)]
    x = reach + np.minimum(*traces) if side < 0 else part.length - reach + np.maximum(*traces)
    return np.column_stack((x, radius * at))


def between_ends(part: Part) -> Shape:
    """A tube without an outline, between its ends, on one turn."""
    from shapely import Polygon

    near, far = (end_line(part, side) for side in (-1, 1))
    return Polygon([*near.tolist(), *far[::-1].tolist()])


def denied_ends(part: Part, outline: Shape) -> Iterator[Diagnostic]:
    """Errors for ends that the header has otherwise than the outline, on one turn."""
    from shapely import LineString

    for side in (-1, 1):
        web, _ = slopes(part, side)
        if not any(slopes(part, side)):
            continue
        lines = end_line(part, side)
        seen: list[Point] = []
        for x, u in lines[1:-1].tolist():
            across = outline.intersection(LineString([(-2 * part.length, u), (3 * part.length, u)]))
            if not across.is_empty:
                seen.append((across.bounds[0 if side < 0 else 2], x))
        off = max((abs(drawn - x) for drawn, x in seen), default=0.0)
        if off > MEET + skew_of(part):
            at: Literal["start", "end"] = "start" if side < 0 else "end"
            kind: Literal["web", "flange"] = "web" if web else "flange"
            angle = getattr(part.cuts, f"{kind}_{at}")
            yield bar_rules.CUT_DENIED.at(
                part.cut_source(kind, at), kind=kind, found=f"{angle:g}", end=at,
                expected="another line",
            )  # fmt: skip
