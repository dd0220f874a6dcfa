"""Contours that share edges with others, which are cut once: where they begin, and in which order.

 ____________
|     |     |    1 is cut as a ring, begun on an edge that it has for itself. What is left of
|  1  |  2  |    2 begins and ends on that: the torch pierces in a kerf that is open, and the
|_____|_____|    part hangs in the sheet by it until its end.
"""

from collections.abc import Mapping, Sequence

import shapely
from msgspec.structs import replace

from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.overlapping import overlapping
from beamcam.machine.torch import Torch
from beamcam.planning.contours.direction import from_longest
from beamcam.planning.contours.outline import Shape
from beamcam.planning.contours.outline import ways as outlines


def begun_off_common(
    shapes: Sequence[Shape], paths: Sequence[Shape], first: Mapping[int, int], torch: Torch
) -> list[Shape]:
    """The shapes, the rings among them begun on the longest edge that they share with no other.

    `paths` are all contours before their edges were taken for common, `first` the shape of each.
    """
    found = list(shapes)
    if torch.start == "drawn":
        return found
    curves = [curve for path in paths for curve in path.curves]
    owners = [(k, n) for k, path in enumerate(paths) for n in range(len(path.curves))]
    pairs = overlapping(CurveTable(curves), [paths[k].process for k, _ in owners])
    common: dict[int, set[int]] = {}
    for pair in pairs:
        for number in pair:
            k, n = owners[number]
            common.setdefault(k, set()).add(n)
    for k, shared in common.items():
        at = first.get(k, -1)
        if at < 0 or not shapes[at].closed or shapes[at].curves != paths[k].curves:
            continue
        own = [n for n in range(len(paths[k].curves)) if n not in shared]
        if own:
            begun = from_longest(shapes[at].curves, own)
            found[at] = replace(shapes[at], curves=begun, is_begun=True)
    return found


def in_levels(shapes: Sequence[Shape], torch: Torch) -> list[Shape]:
    """The shapes with their levels: what begins or ends on others comes after those.

    What lies around a shape comes no earlier than that.
    """
    tree = shapely.STRtree(outlines([s.curves for s in shapes], torch.tolerance / 4))
    runs = [k for k, s in enumerate(shapes) if s.process == "cut" and not s.closed]
    ends = [shapely.Point(p) for k in runs for p in _ends(shapes[k])]
    before: list[dict[int, int]] = [{} for _ in shapes]  #: by how many levels others are lower
    for end, other in tree.query(ends, "dwithin", distance=torch.gap).T.tolist():
        if other < runs[end // 2] and shapes[other].process == "cut":
            before[runs[end // 2]][other] = 1
    for k, shape in enumerate(shapes):
        if shape.parent >= 0:
            before[shape.parent].setdefault(k, 0)
    levels = [0] * len(shapes)
    for _ in shapes:
        higher = [max((levels[b] + up for b, up in own.items()), default=0) for own in before]
        if higher == levels:
            break
        levels = higher
    return [replace(s, level=max(level, s.level)) for s, level in zip(shapes, levels, strict=True)]


def _ends(shape: Shape) -> tuple[tuple[float, float], tuple[float, float]]:
    return shape.curves[0].start, shape.curves[-1].end
