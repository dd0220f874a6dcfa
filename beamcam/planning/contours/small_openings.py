"""Round openings and slots of drawings that are too small for the torch."""

from collections.abc import Collection, Sequence
from itertools import pairwise

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point, between, distance, dot, join_boxes
from beamcam.machine.torch import Torch
from beamcam.model.part import Part
from beamcam.planning import rules as bar_rules
from beamcam.planning.contours.ability import min_hole
from beamcam.planning.contours.assign_process import Assigned, cross_at, spot
from beamcam.planning.contours.outline import Shape, points_of
from beamcam.planning.left_out import DRILL

SAME_SIZE = 1e-6  #: mm, that an opening may be below the least by its last digits


def drill_small_openings(
    shapes: Sequence[Shape], part: Part, torch: Torch, skips: Collection[str], assigned: Assigned
) -> tuple[list[Shape], list[Shape]]:
    """The shapes but for round openings and slots of a drawing that are too small for the torch,
    and the crosses that mark them.

    They are what such a hole or slot of a part is: their drill start points are marked and they are
    listed, or they are refused, or left out; `assigned` records it. What lies within one as round,
    as a countersink or a thread, goes with it.
    """
    thickness = part.profile.web_thickness or torch.thickness or 0.0
    least = min_hole(torch, thickness)
    crosses, small = list[Shape](), set[int]()
    for k in sorted(range(len(shapes)), key=lambda k: shapes[k].depth):
        shape = shapes[k]
        if shape.process != "cut" or not (shape.is_hole or shape.parent in small):
            continue
        opening = _round_ended(shape, least, torch.tolerance) if shape.closed else None
        if opening is None:
            continue
        small.add(k)
        if torch.drilled != "refuse":
            assigned.listed.update(dict.fromkeys(shape.features, DRILL))
            if torch.drilled == "spot":
                spot(opening.centres, shape.features, assigned)
            else:
                crosses += (
                    Shape("mark", (line,), False, shape.features, shape.source)
                    for centre in opening.centres for line in cross_at(centre, torch.cross)
                )  # fmt: skip
            continue
        diagnostic = _too_small(shape.source, opening, least, thickness)
        if diagnostic.code.removeprefix("plan-") in skips:
            assigned.skipped.update(dict.fromkeys(shape.features, diagnostic.code))
        else:
            assigned.refusals.append(diagnostic)
    return _without(shapes, small), crosses


class _Opening(Struct, frozen=True):
    """A contour that is a circle or a slot, whatever curves draw it."""

    centres: tuple[Point, ...]  #: of a circle one, of a slot those of its round ends
    width: float
    length: float  #: of a circle its diameter


def _round_ended(shape: Shape, least: float, tolerance: float) -> _Opening | None:
    """A contour as a circle or a slot that is narrower than `least`; None if it is none."""
    lines = [curve for curve in shape.curves if isinstance(curve, Line)]
    along = max(lines, key=lambda line: line.length).tangent(0.0) if lines else (1.0, 0.0)
    (c, s), corners = along, points_of([shape.curves], tolerance / 4)[0].tolist()
    level = [curve.transformed(((c, s, 0.0), (-s, c, 0.0))) for curve in shape.curves]
    x0, y0, x1, y1 = join_boxes([curve.bbox for curve in level]) or (0.0,) * 4
    length, width = x1 - x0, y1 - y0
    if abs(length - width) <= 2 * tolerance:
        length = width = (length + width) / 2
    if width > length or width >= least - SAME_SIZE:
        return None
    centre, middle, reach = (x0 + x1) / 2, (y0 + y1) / 2, (length - width) / 2
    ends = [
        (c * u - s * middle, s * u + c * middle)
        for u in dict.fromkeys((centre - reach, centre + reach))
    ]
    places = [*corners, *(between(a, b, 0.5) for a, b in pairwise(corners))]
    if max(abs(_from_line(place, ends) - width / 2) for place in places) > tolerance:
        return None
    return _Opening(tuple(ends), width, length)


def _from_line(place: Point, ends: Sequence[Point]) -> float:
    """How far a place is from a line between two ends, or from a point."""
    (x0, y0), (x1, y1) = ends[0], ends[-1]
    way = x1 - x0, y1 - y0
    size = dot(way, way)
    share = dot(way, (place[0] - x0, place[1] - y0)) / size if size else 0.0
    return distance(place, between(ends[0], ends[-1], min(max(share, 0.0), 1.0)))


def _too_small(source: Source, opening: _Opening, least: float, thickness: float) -> Diagnostic:
    if len(opening.centres) > 1:
        return bar_rules.SLOT.at(
            source, found=f"{opening.length:.4g} x {opening.width:.4g}", face="v",
            expected=f"one at least {least:g} wide in a sheet of {thickness:g} mm",
        )  # fmt: skip
    return bar_rules.NO_TOOL.at(
        source, kind="through", found=f"{opening.width:.4g}", face="v",
        expected=f"at least {least:g} in a sheet of {thickness:g} mm",
    )  # fmt: skip


def _without(shapes: Sequence[Shape], some: Collection[int]) -> list[Shape]:
    """The shapes but for some, each parent by its new index."""
    left = [k for k in range(len(shapes)) if k not in some]
    place = {k: number for number, k in enumerate(left)}
    return [replace(shapes[k], parent=place.get(shapes[k].parent, -1)) for k in left]
