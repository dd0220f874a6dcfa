"""Cross-checks of a part that was read: does the file agree with itself?

Each looks at two things that a file says twice: an end in the header and in the contour, a hole and
the material around it. `check` changes nothing of the part; `with_ends` has ends as the user says.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import atan2, degrees, hypot, inf, pi
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Arc, Box, Line, Point, join_boxes
from beamcam.geometry.plane import box_around, distance
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
    for rows in contours if outers else ():
        # How the standard draws them: clockwise in the numbers of o and h.
        if rows.code == "A" and len(rows.face) == 1 and len(rows.points) > 2:
            mirrored = rows.face in MIRRORED_FACES
            if rows.area > 0 if mirrored else rows.area < 0:
                names = ("counter-clockwise", "clockwise")
                found, expected = names if mirrored else names[::-1]
                log.add(rules.DIRECTION, rows.line, face=rows.face, found=found, expected=expected)
    if outers:
        _check_extents(part, outers, header, log)
        for name, given, angle in _differing_ends(part, outers):
            # Some programs leave the header 0 and draw the cut; none was seen to do the reverse.
            rule = rules.CUT_ANGLE if abs(given) > ANGLE_TOLERANCE_DEG else rules.CUT_MISSING
            text = name.replace("_", " ") + " cut"
            log.add(rule, header[CUT_LINES[name] - 1], name=text, header=given, contour=angle + 0.0)
        if plane := next((f for f in part.features if isinstance(f, EndPlane)), None):
            log.add(rules.ENDPLANE_OVERRULED, plane.source.line or 0)
    width = part.profile.height
    if part.profile.code == "B" and is_unrolled(part.profile):
        log.add(rules.UNROLLED, header[6], height=width, diameter=round(width / pi, 2))
    _check_weight(part, header, log)
    _check_holes(part, outers, log)


def _check_weight(part: Part, header: list[int], log: Log) -> None:
    """The weight of a metre against the section's area; of plates each exporter counts another."""
    profile = part.profile
    if part.weight <= 0.0 or profile.code not in WALLED or section_fault(profile) is not None:
        return
    weight = (section_area(profile) or 0.0) * STEEL_KG_MM3 * 1000
    if weight > 0.0 and abs(part.weight - weight) > WEIGHT_SHARE * weight:
        name = profile.name or profile.code
        log.add(rules.WEIGHT_SECTION, header[14], found=part.weight, profile=name, expected=weight)


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
            points = [curve.start for curve in one.curves]
            arcs = [curve for curve in one.curves if isinstance(curve, Arc)]
            box = box_around(points)
            box = join_boxes([box, *(arc.bbox for arc in arcs)]) or box
            outers.setdefault(one.face, []).append(_Outline([*points, points[0]], box, arcs))
    return outers


def _denied_ends(part: Part) -> Iterator[tuple[str, float, float]]:
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
            if angle is not None and abs(angle - given) > ANGLE_TOLERANCE_DEG:
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


def _check_circle(contour: Contour, log: Log) -> None:
    """Note a circle that is written as a contour."""
    first = contour.curves[0]
    if not isinstance(first, Arc) or not contour.closed:
        return
    sweep = 0.0
    for curve in contour.curves:
        if not isinstance(curve, Arc) or abs(curve.radius - first.radius) > 0.01:
            return
        if distance(curve.centre, first.centre) > 0.05:
            return
        sweep += curve.sweep_deg
    if abs(abs(sweep) - 360) < 1:
        log.add(rules.CIRCLE_IN_IK, contour.source.line or 0, diameter=2 * first.radius)


def _check_holes(part: Part, outers: dict[str, list[_Outline]], log: Log) -> None:
    """Holes and texts in the air, holes that are there twice, those that are probably marks."""
    first_lines: dict[object, int] = {}
    regions: dict[str, tuple[Box, list[_Outline]]] = {}
    for feature in part.features:
        kind = type(feature)
        if (
            type(feature) is not Hole
            and type(feature) is not Slot
            and type(feature) is not TextMark
        ):
            continue
        face, x, y, line = feature.face, feature.x, feature.y, feature.source.line or 0
        if type(feature) is Hole:
            size, key = (
                feature.diameter,
                (face, x, y, feature.diameter, feature.kind, feature.depth),
            )
            if (first := first_lines.setdefault(key, line)) != line:
                log.add(rules.HOLE_DUPLICATE, line, first=first, x=x, y=y, diameter=size)
            if size <= LARGEST_MARK and feature.kind in ("through", "blind"):
                log.add(rules.HOLE_SMALL, line, diameter=size)
        if face not in regions:
            regions[face] = _region(part, outers.get(face), face)
        (x0, y0, x1, y1), outlines = regions[face]
        inside = x0 <= x <= x1 and y0 <= y <= y1
        if kind is TextMark:  # of a text the box is enough
            if not inside:
                log.add(rules.TEXT_OUTSIDE, line, x=x, y=y, face=face)
        elif not inside or (outlines and not any(_contains(one, x, y) for one in outlines)):
            what = "a hole" if kind is Hole else "a slot"
            log.add(rules.HOLE_OUTSIDE, line, what=what, x=x, y=y, face=face)


def _region(part: Part, outlines: list[_Outline] | None, face: str) -> tuple[Box, list[_Outline]]:
    """A box around the material of a face, a little wider, and its outlines; of one without these
    the box of the raw section."""
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
    if inside:
        return True
    for (x0, y0), (x1, y1) in outline.edges:
        dx, dy = x1 - x0, y1 - y0
        square, along = dx * dx + dy * dy, (x - x0) * dx + (y - y0) * dy
        t = min(1.0, max(0.0, along / square)) if square else 0.0
        if hypot(x - x0 - t * dx, y - y0 - t * dy) <= EDGE_TOLERANCE:
            return True
    return False


# --- ends ----------------------------------------------------------------------------------------

# Which counts where header and contour of a file describe different ends: as the user says.


Ends = Literal["contour", "header"]
AT_EDGE = 0.5  #: mm off an edge of its face that a corner of an end may lie
LEVEL = 1e-3  #: slope of a side that runs along an edge


def with_ends(part: Part, ends: Ends, header: list[int], log: Log) -> Part:
    """A part whose ends agree: by its contours the angles of the header are theirs, by the header
    the sides of the contours at that end are its. Each that is settled so is reported.

    Where the header counts the part stays as it is if an outline does not end in a side from edge
    to edge, between two along the edges, or is unrolled.
    """
    denied = [*_denied_ends(part)]
    if not denied:
        return part
    settled = part
    if ends == "contour":
        cuts = {name: angle + 0.0 for name, _, angle in denied}
        settled = replace(part, cuts=replace(part.cuts, **cuts))
    else:
        for at in {name.partition("_")[2]: 0 for name, _, _ in denied}:
            features = [
                _at_header(one, settled, at == "end")
                if isinstance(one, Contour) and one.kind == "outer" and one.process == "cut"
                else one
                for one in settled.features
            ]
            settled = replace(settled, features=tuple(features))
        if is_unrolled(part.profile) or [*_denied_ends(settled)]:
            return part
    for name, given, angle in denied:
        text = name.replace("_", " ") + " cut"
        log.add(
            rules.CUT_SETTLED, header[CUT_LINES[name] - 1], name=text, header=given, contour=angle,
            ends=ends,
        )  # fmt: skip
    return replace(settled, ends_by=ends)


def _at_header(contour: Contour, part: Part, at_end: bool) -> Contour:
    """An outline whose side at one end is that of the header; itself if it has none there."""
    from beamcam.model.description import end_lines

    if contour.face not in ("v", "h", "o", "u") or not all(
        isinstance(curve, Line) for curve in contour.curves
    ):
        return contour
    corners = [curve.start for curve in contour.curves]
    width = part.profile.face_width(contour.face)
    (low_x, _), (high_x, _) = end_lines(part, contour.face)[at_end]
    pick = max if at_end else min
    moved: dict[int, Point] = {}
    for y, x in ((0.0, low_x), (width, high_x)):
        on_edge = [k for k, corner in enumerate(corners) if abs(corner[1] - y) <= AT_EDGE]
        if not on_edge:
            return contour
        last = pick(on_edge, key=lambda k: corners[k][0])
        moved[last] = (x, corners[last][1])
    (a, b), count = moved, len(corners)
    if abs(a - b) not in (1, count - 1):
        return contour
    for k, other in ((a, b), (b, a)):  # the sides beside the end run along the edges
        beside = corners[k - 1 if (k + 1) % count == other else (k + 1) % count]
        if abs(beside[1] - corners[k][1]) > LEVEL * abs(beside[0] - corners[k][0]):
            return contour
    ring = [moved.get(k, corner) for k, corner in enumerate(corners)]
    sides = tuple(Line(p, q) for p, q in zip(ring, [*ring[1:], ring[0]], strict=True))
    return replace(contour, curves=sides)
