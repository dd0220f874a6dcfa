"""Round bars and tubes as spindles and a saw see them: from v, o, h and u, not unrolled.

DSTV, 7th edition, page 14: all of a round section is in v, unrolled from its lowest line: y counts
the arc. A quarter of the way round is the middle of v, half of it that of o.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import atan2, cos, degrees, pi

from msgspec.structs import replace

from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, Face, Feature, Hole, Part, Slot, TextMark

#: Middles of the faces by quarters of the way round.
QUARTERS: tuple[Face, ...] = ("u", "v", "o", "h")
SQUARE = 0.1  #: mm that a hole may be off the middle of a face; files round to 0.01
DRAWN = 1.0  #: mm that an outline may be off the tube's circumference, as widths are rounded
PLANE = 0.3  #: mm that an outline may be off the plane of its end


def as_seen(part: Part) -> Part:
    """A round part with its features on the faces they are seen on; any other as it is.

    Those that no face shows become cut-outs, which no bar line makes: `unseen` has them.
    """
    if part.profile.code not in ("RO", "RU"):
        return part
    size = part.profile
    wall = max(size.flange_thickness, size.web_thickness or 0.0)
    wall = size.height if size.code == "RU" else wall
    return replace(
        part, profile=replace(size, flange_thickness=wall, web_thickness=wall),
        features=tuple(_seen(f, part) or _cut_out(f) for f in part.features),
    )  # fmt: skip


def unseen(part: Part) -> Iterator[Feature]:
    """What is seen square from no face of a round part, whose features are unrolled."""
    if part.profile.code in ("RO", "RU"):
        yield from (f for f in part.features if _seen(f, part) is None)


def with_sawn_ends(part: Part) -> Part:
    """A round part with what its outline says of plane ends as the angles of its ends.

    An outline of the unrolled surface says where its outside ends, and not that its wall is cut
    square to it.
    """
    seen = as_seen(part)
    holes = tuple(
        _cut_out(f) if isinstance(f, Hole | Slot) and _seen(f, part) is None else f
        for f in (part.features if seen is not part else ())
    )
    part = replace(part, features=holes) if holes else part
    outlines = [
        (f, seen.features[k]) for k, f in enumerate(part.features)
        if isinstance(f, Contour) and f.kind == "outer" and f.process == "cut"
    ]  # fmt: skip
    if len(outlines) != 1 or part.profile.code not in ("RO", "RU"):
        return part
    ((given, outline),) = outlines
    if not isinstance(outline, Contour) or len(outline.curves) != 4:
        return part
    places = [curve.start for curve in outline.curves]
    low, high = ([x for x, y in places if (y > part.profile.height / 2) == up] for up in (0, 1))
    if len(low) != 2 or len(high) != 2:
        return part
    ends = zip(sorted(low), sorted(high), strict=True)
    start, end = (degrees(atan2(a - b, part.profile.height)) for a, b in ends)
    cuts = part.cuts
    cuts = replace(cuts, web_start=cuts.web_start or start, web_end=cuts.web_end or end)
    return replace(part, cuts=cuts, features=tuple(f for f in part.features if f is not given))


def _cut_out(feature: Feature) -> Feature:
    """A contour or hole that is not seen square, as a contour to be cut out."""
    if isinstance(feature, Contour):
        return replace(feature, kind="inner", process="cut")
    if isinstance(feature, Hole | Slot):
        circle = Arc((feature.x, feature.y), feature.diameter / 2, 0.0, 360.0)
        return Contour(feature.face, "inner", (circle,), feature.source)
    return feature


def _seen(feature: Feature, part: Part) -> Feature | None:
    radius = part.profile.height / 2
    if isinstance(feature, Hole | Slot | TextMark):
        if isinstance(feature, Slot) and (feature.height or feature.angle % 180.0):
            return None  # one across the tube is bent
        y = feature.y % (2 * pi * radius)
        if isinstance(feature, TextMark):
            face: Face = "v" if y <= pi * radius else "h"
            return replace(feature, face=face, y=radius * (1 - cos(y / radius)))
        quarter = round(y / (pi / 2 * radius))
        if feature.face != "v" or abs(y - quarter * pi / 2 * radius) > SQUARE:
            return None
        return replace(feature, face=QUARTERS[quarter % 4], y=radius)
    if not isinstance(feature, Contour):
        return feature
    if feature.kind == "outer" and feature.process == "cut":
        return _outline(feature, part)
    straight = all(isinstance(c, Line) for c in feature.curves)
    along = straight and all(
        abs(y - pi / 2 * radius) <= SQUARE for c in feature.curves for y in (c.start[1], c.end[1])
    )
    if feature.face != "v" or feature.kind == "inner" or not along:
        return None
    lines = [Line((c.start[0], radius), (c.end[0], radius)) for c in feature.curves]
    return replace(feature, curves=tuple(lines))


def _outline(outline: Contour, part: Part) -> Contour | None:
    """The outline of a tube between two planes as v shows it; None of any other."""
    across = part.profile.height
    round_mm = pi * across
    points = [curve.start for curve in outline.curves]
    straight = all(isinstance(curve, Line) for curve in outline.curves)
    if outline.face != "v" or outline.bevels or not straight or not outline.closed:
        return None
    sides = [
        k
        for k, (a, b) in enumerate(zip(points, (*points[1:], points[0]), strict=True))
        if abs(a[1] - b[1]) <= DRAWN and min(a[1], round_mm - a[1]) <= DRAWN
        and abs(a[0] - b[0]) > part.length / 2
    ]  # fmt: skip
    tall = max(y for _, y in points) - min(y for _, y in points)
    if abs(tall - across) <= DRAWN:
        return outline  # drawn as it is seen, not unrolled
    if len(sides) != 2:
        return None
    first, second = sides
    chains = points[first + 1 : second + 1], [*points[second + 1 :], *points[: first + 1]]
    ends = [_plane(sorted(chain, key=lambda p: p[1]), chain, across) for chain in chains]
    if ends[0] is None or ends[1] is None:
        return None
    (a, b), (c, d) = sorted(((x, top) for x, top in (ends[0], ends[1])), key=sum)
    corners = (a, 0.0), (c, 0.0), (d, across), (b, across)
    curves = [Line(p, q) for p, q in zip(corners, (*corners[1:], corners[0]), strict=True)]
    return replace(outline, curves=tuple(curves))


def _plane(rising: Sequence[Point], drawn: Sequence[Point], across: float) -> Point | None:
    """x of an end at the lowest line and on top, where it is one plane that leans in v alone."""
    radius = across / 2
    if [*drawn] not in ([*rising], [*reversed(rising)]):
        return None
    (low, at_low), (high, at_high) = rising[0], rising[-1]
    if at_low > DRAWN or at_high < 2 * pi * radius - DRAWN or abs(low - high) > PLANE:
        return None
    share = at_high / (2 * pi)  # of the width as it is drawn
    places = [
        (a[0] + k / 4 * (b[0] - a[0]), a[1] + k / 4 * (b[1] - a[1]))
        for a, b in pairwise(rising)
        for k in range(5)
    ]
    top = min(places, key=lambda p: abs(p[1] - pi * share))[0]
    if any(abs(x - low - (top - low) * (1 - cos(y / share)) / 2) > PLANE for x, y in places):
        return None
    return low, top
