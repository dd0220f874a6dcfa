"""The unrolled surface of a round tube: what stays of it, and the ends of one that comes cut.

An end that the header has skew is a plane that touches x 0 or the length. Contours, slots and
cut-outs count on the outside; a hole is drawn as a drill through the axis makes it.
"""

from collections.abc import Iterator, Sequence
from math import asin, cos, hypot, inf, pi, sin

import numpy as np
from shapely import LineString, Polygon, bounds, box, intersection, union_all

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line, Point
from beamcam.model.part import Contour, Hole, Part
from beamcam.model.surface import Around
from beamcam.planning.coping import rules
from beamcam.planning.coping.box_corners import MEET
from beamcam.planning.coping.box_tube import Unrolled
from beamcam.planning.coping.ends import SectionEnd
from beamcam.planning.coping.regions import (
    OUTLINE_NOISE,
    Cut,
    Shape,
    off_edge,
    outline_on,
    sharp_corners,
    taken,
)
from beamcam.planning.coping.tube_ends import (
    denied,
    header_slopes,
    line_of,
    own_planes,
    several,
    within,
)
from beamcam.planning.coping.tube_pieces import BEYOND, EndLine, beyond_ends, opened
from beamcam.planning.coping.walls import PlannedWall

STEPS = 96  #: places round a hole
ROUND_STEPS = 721  #: places once round an end that is there


def header_planes(part: Part) -> Iterator[SectionEnd]:
    """The skew ends of a round tube by its header: planes that touch x 0 or the length outside."""
    radius = part.profile.height / 2
    for side in (-1, 1):
        web, flange = header_slopes(part, side)
        if web or flange:
            x = 0.0 if side < 0 else part.length
            yield SectionEnd(
                side, x + radius * (web + flange - side * hypot(web, flange)), web, flange
            )


def once_round(
    part: Part, features: Sequence[int], way: Around, there: Sequence[EndLine] = ()
) -> tuple[Unrolled, list[Diagnostic]]:
    """What stays of a round tube on one turn by some of its features, and what is wrong.

    `there` are the ends of a round piece that comes cut, beyond which it goes on.
    """
    round_it = way.turn
    wall = max(part.profile.thickness("v"), part.profile.flange_thickness)
    surface = PlannedWall("v", round_it, wall, -inf, inf, ())
    own = [f for f in map(part.features.__getitem__, features) if isinstance(f, Cut)]
    outer = [c for c in own if isinstance(c, Contour) and c.kind == "outer"]
    beyond = BEYOND if there else 0.0
    whole: Shape = box(-beyond, 0.0, part.length + beyond, round_it)
    planes = own_planes(part, features)
    skew = [wall * hypot(plane.by_y, plane.by_z) for plane in (*header_planes(part), *planes)]
    diagnostics: list[Diagnostic] = []
    if outer:
        strip = box(-part.length, 0.0, 2 * part.length, round_it)
        drawn = [outline_on(surface, c.curves, part.length / 2) for c in outer]
        open_seams = [
            off
            for contour in outer for side in contour.curves for edge in (0.0, round_it)
            if isinstance(side, Line)
            and (off := off_edge(side, edge, part.length / 2)) is not None
            and off > OUTLINE_NOISE
        ]  # fmt: skip
        if open_seams:
            diagnostics.append(rules.SEAM.at(outer[0].source, found=f"{max(open_seams):.2f}"))
        whole = union_all(drawn)
        if (far := beyond_ends(whole, there)[1]) > OUTLINE_NOISE:
            diagnostics.append(rules.SHORT.at(outer[0].source, face="v", found=f"{far:.3g}"))
        whole = opened(whole, there).intersection(strip)
        diagnostics += denied_ends(part, whole, way)
    else:
        planes += header_planes(part)
    shape = whole = within(whole, planes, way)
    corners: list[Point] = []
    for feature in own:
        if isinstance(feature, Contour):
            corners += sharp_corners(feature)
            if feature.kind == "outer":
                continue
        drawn_once = taken_round(feature, part)
        gone = several(opened(drawn_once, there), round_it, (-1, 0, 1))
        if not gone.intersects(whole) or beyond_ends(drawn_once, there)[0] >= 0.0:
            diagnostics.append(rules.OFF.at(feature.source, what="a hole or cut-out"))
        shape = shape.difference(gone)
    return Unrolled(shape, tuple(corners), {"v": max(skew, default=0.0)}), diagnostics


def taken_round(feature: Cut, part: Part) -> Shape:
    """What a feature takes of the unrolled surface.

    A hole is drawn as a drill makes it, square to the axis of the tube: at y from its middle along
    the section it meets the outside at R asin(y / R) of arc.
    """
    radius = part.profile.height / 2
    if not isinstance(feature, Hole):
        return taken(feature)
    r = min(feature.diameter / 2, radius)
    turns = [2 * pi * k / STEPS for k in range(STEPS)]
    return Polygon(
        [(feature.x + r * cos(t), feature.y + radius * asin(r * sin(t) / radius)) for t in turns]
    )


# --- ends -----------------------------------------------------------------------------------------


def denied_ends(part: Part, outline: Shape, way: Around) -> Iterator[Diagnostic]:
    """Errors for ends that the header has otherwise than the outline, on one turn."""
    for plane in header_planes(part):
        side, seen = plane.side, list[Point]()
        for x, u in line_of(plane, way)[1:-1].tolist():
            across = outline.intersection(LineString([(-2 * part.length, u), (3 * part.length, u)]))
            if not across.is_empty:
                seen.append((across.bounds[0 if side < 0 else 2], x))
        off = max((abs(drawn - x) for drawn, x in seen), default=0.0)
        if off > MEET + way.legs[0].patch.thickness * hypot(plane.by_y, plane.by_z):
            yield denied(part, (side, plane.by_y))


def end_round(part: Part, bare: Shape, side: int, way: Around) -> EndLine:
    """An end that is there once round: where the wall reaches farthest, and outside."""
    us = np.linspace(0.0, way.turn, ROUND_STEPS)
    across = [LineString([(-part.length, u), (2 * part.length, u)]) for u in us.tolist()]
    rows = [bounds(intersection(across, bare))[:, 0 if side < 0 else 2]]
    patch = way.legs[0].patch
    for plane in (*header_planes(part), *own_planes(part, range(len(part.features)))):
        if plane.side == side:
            _, ys, zs = np.array([patch.point(0.0, u) for u in us.tolist()]).T
            rows.append(plane.x(ys, zs))
    return EndLine(side, us, tuple(rows), -BEYOND if side < 0 else part.length + BEYOND)
