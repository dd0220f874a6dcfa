"""Cross-checks of a part that was read: does the file agree with itself?

Nothing here changes the part. Each check looks at two things that a file says twice: an end in the
header and in the contour, a hole and the material around it.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import atan2, degrees, hypot, inf, pi

from msgspec import Struct

from beamcam.geometry.curves import Arc, Box, Point, join_boxes
from beamcam.geometry.plane import box_around
from beamcam.model.part import (
    MIRRORED_FACES,
    Contour,
    EndPlane,
    Hole,
    Part,
    Profile,
    Slot,
    TextMark,
)
from beamcam.model.rounds import is_unrolled
from beamcam.model.section import STEEL_KG_MM3, WALLED, section_area, section_fault
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.blocks import Log
from beamcam.readers.dstv.contours import ContourRows

WEIGHT_SHARE = 0.05  #: of the section's, by which the header's weight may differ
LENGTH_TOLERANCE = 0.2  #: real files differ by up to 0.12
EDGE_TOLERANCE = 0.2  #: a hole's centre this far out of the material is still in it
ANGLE_TOLERANCE_DEG = 0.5  #: real headers hold angles such as 0.07 for square ends
LARGEST_MARK = 7.0  #: diameter; shops write punch marks as holes of 1, 2, 4, 5 or 7

#: Header line of each cut angle, counted from the line ST.
CUT_LINES = {"web_start": 17, "web_end": 18, "flange_start": 19, "flange_end": 20}


class _Outline(Struct):
    """An outer contour made ready for asking what lies inside."""

    points: list[Point]  #: corners, the first one again at the end
    box: Box
    arcs: list[Arc]

    @property
    def edges(self) -> Iterator[tuple[Point, Point]]:
        """Lines and the chords of arcs."""
        return pairwise(self.points)


def check(part: Part, contours: list[ContourRows], header: list[int], log: Log) -> None:
    """Add to the log what contradicts itself in `part`.

    `contours` are its contour rows and `header` the lines of the header's values.
    """
    outers = _outlines(part) if contours else {}
    for feature in part.features if contours else ():
        if isinstance(feature, Contour) and feature.kind != "outer" and feature.process == "cut":
            _check_circle(feature, log)
    if outers:
        _check_directions(contours, log)
        _check_extents(part, outers, header, log)
        _check_ends(part, outers, header, log)
        _check_end_planes(part, log)
    if part.profile.code == "B":
        _check_unrolled(part, header, log)
    _check_weight(part, header, log)
    _check_holes(part, outers, log)


def _check_weight(part: Part, header: list[int], log: Log) -> None:
    """The weight of a metre against the section's area; of plates each exporter counts another."""
    profile = part.profile
    if part.weight <= 0.0 or profile.code not in WALLED or section_fault(profile) is not None:
        return
    area = section_area(profile)
    weight = 0.0 if area is None else area * STEEL_KG_MM3 * 1000
    if weight > 0.0 and abs(part.weight - weight) > WEIGHT_SHARE * weight:
        name = profile.name or profile.code
        log.add(rules.WEIGHT_SECTION, header[14], found=part.weight, profile=name, expected=weight)


def _outline(contour: Contour) -> _Outline:
    curves = contour.curves
    points = [curve.start for curve in curves]
    arcs = [curve for curve in curves if isinstance(curve, Arc)]
    box = box_around(points)
    box = join_boxes([box, *(arc.bbox for arc in arcs)]) or box
    return _Outline([*points, points[0]], box, arcs)


def _check_directions(contours: list[ContourRows], log: Log) -> None:
    """Note outer contours that run otherwise in their numbers than the standard draws them."""
    for rows in contours:
        if rows.code == "A" and len(rows.face) == 1 and len(rows.points) > 2:
            area = rows.area
            mirrored = rows.face in MIRRORED_FACES
            if area > 0 if mirrored else area < 0:
                names = ("counter-clockwise", "clockwise")
                found, expected = names if mirrored else names[::-1]
                log.add(rules.DIRECTION, rows.line, face=rows.face, found=found, expected=expected)


def _check_extents(
    part: Part, outers: dict[str, list[_Outline]], header: list[int], log: Log
) -> None:
    """Length and height against what the contours measure."""
    whole = join_boxes(
        [o.box for face, outlines in outers.items() if len(face) == 1 for o in outlines]
    )
    if whole is None:
        return
    # A round plate may hang over x = 0: then its extent is its length.
    reach, extent = whole[2], whole[2] - whole[0]
    lengths = (part.length, part.saw_length if part.saw_length is not None else part.length)
    if all(abs(a - b) > LENGTH_TOLERANCE for a in lengths for b in (reach, extent)):
        log.add(rules.LENGTH_CONTOUR, header[8], length=part.length, reach=reach)
    web = join_boxes([outline.box for outline in outers.get("v", ())])
    given = _face_width(part.profile, "v")
    if web is not None and given > 0:
        height = web[3] - web[1]
        excess = height - given
        # A beam may be coped along its whole length, a plate may not be narrower than itself.
        if excess > LENGTH_TOLERANCE or (part.profile.code == "B" and excess < -LENGTH_TOLERANCE):
            log.add(rules.HEIGHT_CONTOUR, header[9], height=given, found=height)


def _outlines(part: Part) -> dict[str, list[_Outline]]:
    """The outer contours by their faces."""
    outers: dict[str, list[_Outline]] = {}
    for one in part.contours:
        if one.kind == "outer":
            outers.setdefault(one.face, []).append(_outline(one))
    return outers


def _check_ends(part: Part, outers: dict[str, list[_Outline]], header: list[int], log: Log) -> None:
    """Add the ends of which header and contour say different things."""
    for name, given, angle in _differing_ends(part, outers):
        # Some programs leave the header 0 and draw the cut; none was seen to do the reverse.
        rule = rules.CUT_ANGLE if abs(given) > ANGLE_TOLERANCE_DEG else rules.CUT_MISSING
        text = name.replace("_", " ") + " cut"
        log.add(rule, header[CUT_LINES[name] - 1], name=text, header=given, contour=angle + 0.0)


def denied_ends(part: Part) -> Iterator[tuple[str, float, float]]:
    """The cuts of a header that a contour denies: name, its angle and that of the contour."""
    for name, given, angle in _differing_ends(part, _outlines(part)):
        if abs(given) > ANGLE_TOLERANCE_DEG:
            yield name, given, angle


def _differing_ends(
    part: Part, outers: dict[str, list[_Outline]]
) -> Iterator[tuple[str, float, float]]:
    """The header's cut angles that differ from ends of v and u that are one straight edge.

    At either end the angle is atan2(x(lowest y) - x(highest y), y_high - y_low), the web's in v
    and the flange's in u. Ends that are coped, notched or round say nothing about the cut.
    """
    cuts = part.cuts
    for face, names in (("v", ("web_start", "web_end")), ("u", ("flange_start", "flange_end"))):
        outlines = outers.get(face, ())
        if len(outlines) != 1:
            continue
        for name, angle in zip(names, _end_angles(outlines[0]), strict=True):
            given: float = getattr(cuts, name)
            if angle is None or abs(angle - given) <= ANGLE_TOLERANCE_DEG:
                continue
            yield name, given, angle


def _end_angles(outline: _Outline) -> tuple[float | None, float | None]:
    """Angles in degrees of the start and end of an outline; None for one that is not an edge."""
    _, low, _, high = outline.box
    bottom = [x for x, y in outline.points if y == low]
    top = [x for x, y in outline.points if y == high]
    if not bottom or not top or low == high:
        return None, None
    angles: list[float | None] = []
    for pick in (min, max):
        x_low, x_high = pick(bottom), pick(top)
        ends = {(x_low, low), (x_high, high)}
        straight = any(a in ends and b in ends for a, b in outline.edges)
        angles.append(degrees(atan2(x_low - x_high, high - low)) if straight else None)
    return angles[0], angles[1]


def _check_end_planes(part: Part, log: Log) -> None:
    """Note cutting planes that the contour overrules."""
    for feature in part.features:
        if isinstance(feature, EndPlane):
            log.add(rules.ENDPLANE_OVERRULED, feature.source.line or 0)
            return


def _check_unrolled(part: Part, header: list[int], log: Log) -> None:
    """Note a plate that is the surface of a pipe."""
    width = part.profile.height
    if is_unrolled(part.profile):
        log.add(rules.UNROLLED, header[6], height=width, diameter=round(width / pi, 2))


def _check_circle(contour: Contour, log: Log) -> None:
    """Note a circle that is written as a contour."""
    first = contour.curves[0]
    if not isinstance(first, Arc) or not contour.closed:
        return
    sweep = 0.0
    for curve in contour.curves:
        if not isinstance(curve, Arc) or abs(curve.radius - first.radius) > 0.01:
            return
        if hypot(curve.centre[0] - first.centre[0], curve.centre[1] - first.centre[1]) > 0.05:
            return
        sweep += curve.sweep_deg
    if abs(abs(sweep) - 360) < 1:
        log.add(rules.CIRCLE_IN_IK, contour.source.line or 0, diameter=2 * first.radius)


def _check_holes(part: Part, outers: dict[str, list[_Outline]], log: Log) -> None:
    """Holes and texts in the air, holes that are there twice, those that are probably marks."""
    seen: dict[object, int] = {}
    regions: dict[str, _Region] = {}
    for feature in part.features:
        if type(feature) is Hole:
            _check_twice(feature, seen, log)
            if feature.diameter <= LARGEST_MARK and feature.kind in ("through", "blind"):
                log.add(rules.HOLE_SMALL, feature.source.line or 0, diameter=feature.diameter)
        elif type(feature) is not Slot and type(feature) is not TextMark:
            continue
        face, x, y = feature.face, feature.x, feature.y
        if face not in regions:
            regions[face] = _region(part, outers.get(face), face)
        (x0, y0, x1, y1), outlines = regions[face]
        inside = x0 <= x <= x1 and y0 <= y <= y1
        if inside and outlines and type(feature) is not TextMark:  # of a text the box is enough
            inside = any(_contains(outline, x, y) for outline in outlines)
        if not inside:
            _say_outside(feature, log)


def _say_outside(feature: Hole | Slot | TextMark, log: Log) -> None:
    line, place = feature.source.line or 0, {"x": feature.x, "y": feature.y, "face": feature.face}
    if type(feature) is TextMark:
        log.add(rules.TEXT_OUTSIDE, line, **place)
    else:
        what = "a hole" if type(feature) is Hole else "a slot"
        log.add(rules.HOLE_OUTSIDE, line, what=what, **place)


def _check_twice(hole: Hole, seen: dict[object, int], log: Log) -> None:
    """Note a hole that is `seen` already, by the line that it was first on."""
    line = hole.source.line or 0
    first = seen.setdefault((hole.face, hole.x, hole.y, hole.diameter, hole.kind, hole.depth), line)
    if first != line:
        place = {"x": hole.x, "y": hole.y, "diameter": hole.diameter}
        log.add(rules.HOLE_DUPLICATE, line, first=first, **place)


#: Where a face has material: a box around it, a little wider, and its outlines, none where the box
#: says it all.
_Region = tuple[Box, list[_Outline]]


def _region(part: Part, outlines: list[_Outline] | None, face: str) -> _Region:
    """The material of a face: its outlines, or the raw section where it has none."""
    if len(face) > 1:
        return (-inf, -inf, inf, inf), []  # the file gives no extent of a plane
    slack = EDGE_TOLERANCE
    if outlines is None:
        width = _face_width(part.profile, face) or inf
        return (-slack, -slack if width < inf else -inf, part.length + slack, width + slack), []
    x0, y0, x1, y1 = join_boxes([outline.box for outline in outlines]) or outlines[0].box
    return (x0 - slack, y0 - slack, x1 + slack, y1 + slack), outlines


def _face_width(profile: Profile, face: str) -> float:
    """Extent of a face across the part; round sections are unrolled in v (page 14)."""
    if profile.is_round:
        return pi * profile.height
    width = profile.face_width(face)
    if profile.code == "B" and face in ("o", "u"):  # the edge of a plate; its width is often 0
        return max(width, profile.web_thickness or 0.0)
    return width


def _contains(outline: _Outline, x: float, y: float) -> bool:
    """Whether a point lies inside an outline or within `EDGE_TOLERANCE` of its edge.

    A ray to the right crosses the boundary an odd number of times: first the polygon of the
    corners, then each arc turns the answer for what lies between it and its chord.
    """
    inside = False
    x0, y0 = outline.points[0]
    for x1, y1 in outline.points:
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
        x0, y0 = x1, y1
    for arc in outline.arcs:
        if hypot(x - arc.centre[0], y - arc.centre[1]) <= arc.radius:
            (x0, y0), (x1, y1) = arc.start, arc.end
            side = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
            # A counter-clockwise arc lies right of its chord.
            if (side < 0) == (arc.sweep_deg > 0):
                inside = not inside
    return inside or any(_distance(a, b, x, y) <= EDGE_TOLERANCE for a, b in outline.edges)


def _distance(a: Point, b: Point, x: float, y: float) -> float:
    """Distance of a point from the edge between `a` and `b`."""
    (x0, y0), (x1, y1) = a, b
    dx, dy = x1 - x0, y1 - y0
    square = dx * dx + dy * dy
    t = 0.0 if square == 0 else min(1.0, max(0.0, ((x - x0) * dx + (y - y0) * dy) / square))
    return hypot(x - x0 - t * dx, y - y0 - t * dy)
