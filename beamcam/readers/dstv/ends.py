"""Which counts where header and contour of a file describe different ends: as it was asked for."""

from typing import Literal

from msgspec.structs import replace

from beamcam.geometry.curves import Line, Point
from beamcam.model.description import end_lines
from beamcam.model.part import Contour, Part
from beamcam.model.rounds import is_unrolled
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.blocks import Log
from beamcam.readers.dstv.lint import CUT_LINES, denied_ends

Ends = Literal["contour", "header"]

AT_EDGE = 0.5  #: mm off an edge of its face that a corner of an end may lie
LEVEL = 1e-3  #: slope of a side that runs along an edge


def with_ends(part: Part, ends: Ends, header: list[int], log: Log) -> Part:
    """A part whose ends agree: by its contours the angles of the header are theirs, by the header
    the sides of the contours at that end are its. Each that is settled so is told.

    Where the header counts the part stays as it is if an outline does not end in a side from edge
    to edge, between two along the edges, or is unrolled.
    """
    denied = [*denied_ends(part)]
    if not denied:
        return part
    if ends == "contour":
        cuts = {name: angle + 0.0 for name, _, angle in denied}
        settled = replace(part, cuts=replace(part.cuts, **cuts))
    else:
        moved = part
        for at in {name.partition("_")[2]: 0 for name, _, _ in denied}:
            moved = _moved(moved, at == "end")
        settled = moved
        if is_unrolled(part.profile) or [*denied_ends(settled)]:
            return part
    for name, given, angle in denied:
        text = name.replace("_", " ") + " cut"
        log.add(
            rules.CUT_SETTLED, header[CUT_LINES[name] - 1], name=text, header=given, contour=angle,
            ends=ends,
        )  # fmt: skip
    return replace(settled, ends_by=ends)


def _moved(part: Part, at_end: bool) -> Part:
    """The part with the sides of its outlines at one end on the plane of the header there."""
    features = [
        _at_header(one, part, at_end)
        if isinstance(one, Contour) and one.kind == "outer" and one.process == "cut" else one
        for one in part.features
    ]  # fmt: skip
    return replace(part, features=tuple(features))


def _at_header(contour: Contour, part: Part, at_end: bool) -> Contour:
    """An outline whose side at one end is that of the header; itself if it has none there."""
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
