"""Round bars and tubes as spindles and a saw see them: from v, o, h and u, not unrolled; and the
plates that are pipes, unrolled.

DSTV, 7th edition, page 14: all of a round section is in v, unrolled from its lowest line: y counts
the arc. A quarter of the way round is the middle of v, half of it that of o.
"""

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import atan2, cos, degrees, pi

from msgspec.structs import replace

from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, Face, Feature, Hole, Part, Profile, Slot, TextMark

#: Middles of the faces by quarters of the way round.
QUARTERS: tuple[Face, ...] = ("u", "v", "o", "h")
SQUARE = 0.1  #: mm that a hole may be off the middle of a face; files round to 0.01
DRAWN = 1.0  #: mm that an outline may be off the tube's circumference, as widths are rounded
PLANE = 0.3  #: mm that an outline may be off the plane of its end


def as_seen(part: Part) -> Part:
    """A round part with its features on the faces they are seen on.

    Those that no face shows become cut-outs, which no bar line makes: `unseen` has them.
    """
    size = part.profile
    wall = max(size.flange_thickness, size.web_thickness or 0.0)
    wall = size.height if size.code == "RU" else wall
    return replace(
        part, profile=replace(size, flange_thickness=wall, web_thickness=wall),
        features=tuple(_seen(f, part) or _cut_out(f) for f in part.features),
    )  # fmt: skip


def unseen(part: Part) -> Iterator[Feature]:
    """What is seen square from no face of a round part, whose features are unrolled."""
    yield from (f for f in part.features if _seen(f, part) is None)


def with_sawn_ends(part: Part) -> Part:
    """A round part with what its outline says of plane ends as the angles of its ends; any other
    as it is.

    An outline of the unrolled surface says where its outside ends, and not that its wall is cut
    square to it.
    """
    if not part.profile.is_round:
        return part
    seen = as_seen(part)
    holes = tuple(
        _cut_out(f) if isinstance(f, Hole | Slot) and _seen(f, part) is None else f
        for f in part.features
    )
    part = replace(part, features=holes) if holes else part
    outlines = [
        (f, seen.features[k]) for k, f in enumerate(part.features)
        if isinstance(f, Contour) and f.kind == "outer" and f.process == "cut"
    ]  # fmt: skip
    if len(outlines) != 1:
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


# --- pipes ----------------------------------------------------------------------------------------

# Pipes that are written as plates: the unrolled surface, as wide as the pipe is round.
#
# Exporters of DSTV do so (Tekla: "Unroll round tubes"), with the pipe's name: CHS88.9*5, O76.1*4.
# Cut or sawn flat such a part is no pipe, so all machines have to know it.


#: Names that only a pipe has, whatever the width.
_CALLED = re.compile(r"\s*(PIPE|CHS|TUBE)", re.IGNORECASE)
#: A size in a name: 168.3, 6, .25, 1-1/2 or 3/4.
_SIZE = re.compile(r"(?:([0-9]+)[- ])?([0-9]+)/([0-9]+)|([0-9]+(?:\.[0-9]+)?|\.[0-9]+)")
SLACK = 0.5  #: mm between a diameter in a name and that of the width
#: mm where the name has no wall: widths have two decimals, and no flat is a diameter in its name
#: times pi wide.
_ALONE = 0.03
_WALL = 0.1  #: share of the wall by which that of the name is off: US tubes are drawn 7 % thinner
INCH = 25.4
#: Outside diameter of pipes by their nominal size, both in inches (ASME B36.10M, table 1).
NOMINAL = {
    0.125: 0.405, 0.25: 0.54, 0.375: 0.675, 0.5: 0.84, 0.75: 1.05, 1.0: 1.315, 1.25: 1.66,
    1.5: 1.9, 2.0: 2.375, 2.5: 2.875, 3.0: 3.5, 3.5: 4.0, 4.0: 4.5, 5.0: 5.563, 6.0: 6.625,
    8.0: 8.625, 10.0: 10.75, 12.0: 12.75,
}  # fmt: skip


def is_unrolled(profile: Profile) -> bool:
    """Whether a plate is the surface of a pipe: by its name, or by the name's sizes and its width.

    Of any other name the first size is a diameter whose circumference the plate is wide, and the
    second, where there is one, the wall (mm or inches). A flat is never so wide as pi times a size
    in its name: that is its own width or its thickness.
    """
    if profile.code != "B":
        return False
    if _CALLED.match(profile.name):
        return True
    sizes, wall = _sizes(profile.name), profile.web_thickness or 0.0
    across = profile.height / pi
    if not sizes or not 2.0 * wall < across:
        return False
    for unit in (1.0, INCH):
        off = abs(unit * sizes[0] - across)
        walled = len(sizes) > 1 and abs(unit * sizes[1] - wall) <= _WALL * wall
        if off <= (SLACK if walled else _ALONE):
            return True
    return False


def rolled(part: Part) -> Part:
    """A plate that is the surface of a pipe as the tube whose circumference is its width.

    Any other part comes back as it is. What is on face v stays unrolled, as of a tube.
    """
    plate = part.profile
    if not is_unrolled(plate):
        return part
    across, wall = plate.height / pi, plate.web_thickness or 0.0
    return replace(part, profile=Profile("RO", plate.name, across, across, wall, wall))


def named_diameters(name: str) -> tuple[float, ...]:
    """The diameters that a pipe's name may mean, in mm; none where it has no size.

    The first size is a diameter in mm or in inches, or a nominal one: PIPE1-1/2SCH40 is 1.9 inches
    wide.
    """
    sizes = _sizes(name)
    if not sizes or not sizes[0]:
        return ()
    inches = (sizes[0], NOMINAL.get(sizes[0], sizes[0]))
    return (sizes[0], *(INCH * one for one in inches))


def _sizes(name: str) -> list[float]:
    """The sizes in a name, a mixed number as one."""
    return [
        float(whole) if whole else float(more or 0) + float(over) / float(under)
        for more, over, under, whole in _SIZE.findall(name)
        if whole or float(under)
    ]
