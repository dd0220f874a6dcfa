"""Whether a path makes a pocket, or follows a line.

A mill of radius m leaves a pocket if its path never leaves the pocket drawn in by m, and if every
point of the outline lies within m of the path; a blind pocket has to be cleared inside as well.
Both are measured on points so close that what lies between them cannot matter.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import ceil, cos, dist, hypot, pi, radians, sin, sqrt

from msgspec import Struct

from beamcam.checks import rules
from beamcam.checks.bars.holes import NEAR, DepthRange, wrong_depth
from beamcam.checks.bars.stations import (
    Bore,
    MachinedFeatures,
    MachinedPath,
    in_stem,
    wall_thickness,
)
from beamcam.checks.bars.targets import MarkingPath, RequiredPocket
from beamcam.checks.bars.tools import ToolCatalogue, too_early
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Curve, Point
from beamcam.model.part import Part, Profile, Slot

STEP = 1.0  #: mm between the points that are measured, where a line is not too tight for it
FLAT = 0.001  #: mm between a line and the chords that it is measured by
MOST_CHORDS = 4096


def pocket_error(pocket: Slot, path: Sequence[Point], mill: float) -> float:
    """Deviation of the pocket that a path makes, in mm, on the part's x and y.

    The greater of what is cut beyond the outline and what of it is left standing.
    """
    c, s = cos(radians(pocket.angle)), sin(radians(pocket.angle))
    own = [
        (c * (x - pocket.x) + s * (y - pocket.y), c * (y - pocket.y) - s * (x - pocket.x))
        for x, y in path
    ]
    half_x, half_y = pocket.length / 2, pocket.height / 2
    radius, cutter = pocket.diameter / 2, mill / 2
    # From the rectangle of the corner circles' centres.
    off = max(hypot(max(abs(x) - half_x, 0.0), max(abs(y) - half_y, 0.0)) for x, y in own)
    left = max(
        distance_to(p, own) - cutter
        for p in _to_clear(half_x, half_y, radius, cutter, pocket.depth is not None)
    )
    return max(off + cutter - radius, left, 0.0)


def _to_clear(
    half_x: float, half_y: float, radius: float, cutter: float, blind: bool
) -> Iterator[Point]:
    """Points of the outline; of a blind pocket those inside too."""
    insets = [radius]
    if blind:
        depth = radius + max(half_x, half_y)
        count = max(1, ceil(depth / max(cutter / 2, STEP)))
        insets += [radius - depth * (i + 1) / count for i in range(count)]
    for inset in insets:
        yield from _outline(
            max(0.0, half_x + min(inset, 0.0)), max(0.0, half_y + min(inset, 0.0)), max(inset, 0.0)
        )


def _outline(half_x: float, half_y: float, radius: float) -> Iterator[Point]:
    """Points of a rectangle with round corners about 0, 0."""
    corners = [(half_x, half_y), (-half_x, half_y), (-half_x, -half_y), (half_x, -half_y)]
    count = max(1, ceil(radius * pi / 2 / STEP))
    points = [
        (x + radius * cos(pi / 2 * (quarter + i / count)),
         y + radius * sin(pi / 2 * (quarter + i / count)))
        for quarter, (x, y) in enumerate(corners)
        for i in range(count + 1)
    ]  # fmt: skip
    for a, b in pairwise([*points, points[0]]):
        yield a
        steps = ceil(dist(a, b) / (2 * STEP))
        for i in range(1, steps):
            yield a[0] + (b[0] - a[0]) * i / steps, a[1] + (b[1] - a[1]) * i / steps


def line_error(curves: Sequence[Curve], path: Sequence[Point]) -> float:
    """Maximum distance between a path and a chain of curves, in mm.

    Measured both ways, and at both ends, whichever way round the path is gone.
    """
    drawn = [curves[0].start]
    for curve in curves:
        drawn += _points(curve)[1:]
    off = max(distance_to(p, path) for p in drawn)
    middles = [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in pairwise(path)]
    back = max(distance_to(p, drawn) for p in (*path, *middles))
    (a, b), (c, d) = (drawn[0], drawn[-1]), (path[0], path[-1])
    ends = min(max(dist(a, c), dist(b, d)), max(dist(a, d), dist(b, c)))
    return max(off, back, ends)


def _points(curve: Curve) -> list[Point]:
    """Points of a curve, so close that its chords lie within `FLAT` of it."""
    count = max(4, min(400, ceil(curve.length / STEP)))
    while True:
        points = [curve.point(i / count) for i in range(count + 1)]
        middles = (curve.point((i + 0.5) / count) for i in range(count))
        pairs = zip(middles, pairwise(points), strict=True)
        if count >= MOST_CHORDS or all(distance_to(m, chord) <= FLAT for m, chord in pairs):
            return points
        count *= 2


def distance_to(point: Point, path: Sequence[Point]) -> float:
    """Distance of a point from a polyline."""
    x, y = point
    ax, ay = path[0]
    best = (ax - x) ** 2 + (ay - y) ** 2
    for bx, by in path:
        dx, dy, px, py = bx - ax, by - ay, x - ax, y - ay
        along = px * dx + py * dy
        square = dx * dx + dy * dy
        if along >= square:  # nearest to the segment's end, or it has no length
            off = (bx - x) ** 2 + (by - y) ** 2
        elif along > 0.0:
            off = (px * dy - py * dx) ** 2 / square
        else:
            off = px * px + py * py
        if off < best:
            best = off
        ax, ay = bx, by
    return sqrt(best)


# --- pockets --------------------------------------------------------------------------------------

# The paths that a program leads tools along, against the slots and lines of the parts.


Box = tuple[float, float, float, float]  #: the middle, the width and the height


class RequiredPath(Struct, frozen=True, gc=False):
    """A pocket or line of a part on the bar."""

    part: int
    target: RequiredPocket | MarkingPath
    from_x: float  #: machine X of the part's x 0


class PathsAlong:
    """Paths in order of their middles along the bar, so that each is compared with a few others."""

    def __init__(self, paths: Sequence[MachinedPath]) -> None:
        self._rest = {id(path): path for path in paths}
        rows = [(_box(path.points), path) for path in paths]
        self._rows = sorted(rows, key=lambda row: row[0][0])
        self._along = [box[0] for box, _ in self._rows]

    def near(self, x: float) -> Iterator[tuple[MachinedPath, Box]]:
        """The paths that are left with a middle within `NEAR` of x, and their boxes."""
        begin = bisect_left(self._along, x - NEAR - 1e-6)
        for box, path in self._rows[begin : bisect_right(self._along, x + NEAR + 1e-6)]:
            if id(path) in self._rest:
                yield path, box

    def remove(self, path: MachinedPath) -> None:
        """Take a path away."""
        del self._rest[id(path)]

    @property
    def rest(self) -> Iterable[MachinedPath]:
        """Those that are left, in their order."""
        return self._rest.values()


def check_paths(
    made: MachinedFeatures, required_paths: Sequence[RequiredPath], parts: Sequence[Part],
    tools: ToolCatalogue, profile: Profile, name: str,
) -> tuple[list[Diagnostic], list[tuple[MachinedPath, RequiredPath]]]:  # fmt: skip
    """Faults of the paths: each pocket and line once, by the path that fits it best.

    Also each path with what it is taken for.
    """
    allowed = _allowed(tools)
    left, diagnostics = PathsAlong(made.paths), list[Diagnostic]()
    taken: list[tuple[MachinedPath, RequiredPath]] = []
    for required in required_paths:
        target, mark = required.target, parts[required.part].mark
        path = _meant(left, required, allowed)
        if path is None:
            diagnostics.append(
                rules.NOT_MADE.at(target.source.source, found=f"the {target.what}", mark=mark)
            )
            continue
        left.remove(path)
        taken.append((path, required))
        off = _off(path, required)
        if off > allowed:
            diagnostics.append(rules.PATH.at(
                Source(name, path.line), what=f"the {target.what}", mark=mark,
                found=f"{off:.3f}", expected=f"{allowed:g}",
            ))  # fmt: skip
        diagnostics += _tool_and_depth(path, target, mark, tools, profile, Source(name, path.line))
        if isinstance(target, MarkingPath) and in_stem(target.curves, profile, target.face):
            x, y = target.curves[0].start
            diagnostics.append(rules.HOLE_STEEL.at(
                target.source.source, what=target.what, face=target.face, mark=mark, x=f"{x:g}",
                y=f"{y:g}", found="in the stem", expected="it clear of the stem",
            ))  # fmt: skip
    for path in left.rest:
        x, y = path.points[0]
        diagnostics.append(rules.PATH_EXTRA.at(
            Source(name, path.line), kind=path.kind, face=path.face, x=f"{x:g}", y=f"{y:g}"
        ))  # fmt: skip
    diagnostics += _entry_faults(made, taken, tools, name)
    return diagnostics, taken


def is_followed(
    paths: PathsAlong, target: RequiredPocket | MarkingPath, from_x: float, tools: ToolCatalogue
) -> bool:
    """Whether there is a path that makes a pocket or line."""
    required = RequiredPath(0, target, from_x)
    path = _meant(paths, required, _allowed(tools))
    return path is not None and _off(path, required) <= _allowed(tools)


def _allowed(tools: ToolCatalogue) -> float:
    """Permitted deviation of a path."""
    return tools.drill.path_tolerance + 2 * tools.machine.format.resolution


def _off(path: MachinedPath, required: RequiredPath) -> float:
    """Deviation of the pocket or line that a path makes."""
    points = [(x - required.from_x, y) for x, y in path.points]
    if isinstance(required.target, RequiredPocket):
        return pocket_error(required.target.slot, points, path.diameter)
    return line_error(required.target.curves, points)


def _meant(paths: PathsAlong, required: RequiredPath, allowed: float) -> MachinedPath | None:
    """The path that makes a pocket or line, or else the one that may have been meant for it.

    The nearest come first, of those about one middle the one of its size.
    """
    target, from_x = required.target, required.from_x
    if isinstance(target, RequiredPocket):
        kind, slot, diameter = "mill", target.slot, target.slot.diameter
        c, s = abs(cos(radians(slot.angle))), abs(sin(radians(slot.angle)))
        x, y, width = slot.x, slot.y, c * slot.length + s * slot.height
        height = s * slot.length + c * slot.height
    else:
        kind, diameter, boxes = "scribe", 0.0, [curve.bbox for curve in target.curves]
        ends = [(b[0], b[1]) for b in boxes] + [(b[2], b[3]) for b in boxes]
        x, y, width, height = _box(ends)
    near = []
    for path, box in paths.near(from_x + x):
        apart = abs(box[0] - from_x - x) + abs(box[1] - y)
        if path.kind == kind and path.face == target.face and apart <= NEAR:
            beyond = diameter - path.diameter if kind == "mill" else 0.0
            unlike = abs(box[2] - width - beyond) + abs(box[3] - height - beyond)
            near.append((apart + unlike, path.line, path))
    near.sort(key=lambda n: n[:2])
    if len(near) > 1:
        right = (path for _, _, path in near if _off(path, required) <= allowed)
        return next(right, near[0][2])
    return near[0][2] if near else None


def _box(points: Sequence[tuple[float, float]]) -> Box:
    """The middle of points, their width and their height."""
    xs, ys = [x for x, _ in points], [y for _, y in points]
    x0, x1, y0, y1 = min(xs), max(xs), min(ys), max(ys)
    return (x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0


def _tool_and_depth(
    path: MachinedPath, target: RequiredPocket | MarkingPath, mark: str, tools: ToolCatalogue,
    profile: Profile, source: Source,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Faults of the tool and the depth of a path."""
    if isinstance(target, RequiredPocket):
        (x, y), depth = (target.slot.x, target.slot.y), target.slot.depth
        thickness = wall_thickness(profile, target.face)
        reach = DepthRange(thickness, thickness + tools.drill.breakthrough)
    else:
        (x, y), depth = target.curves[0].start, tools.drill.mark_depth
    if depth is not None:
        reach = DepthRange(depth, depth)
    described: dict[str, object] = {
        "what": target.what, "face": target.face, "mark": mark, "x": f"{x:g}", "y": f"{y:g}",
    }  # fmt: skip
    sizes = tools.sizes(path.kind, target.face)
    if path.diameter not in sizes:
        shown = ", ".join(f"{d:g}" for d in sizes)
        found = f"a {path.kind} {path.diameter:g}"
        yield rules.TOOL.at(source, found=found, expected=f"one of {shown}", **described)
        return
    slack = tools.machine.format.resolution + 1e-6
    depths = path.min_depth, path.max_depth
    if depths[0] < reach.least - slack or depths[1] > reach.greatest + slack:
        yield wrong_depth(depths, reach, 0.0, slack, source, described)


# --- entries --------------------------------------------------------------------------------------


def _entry_faults(
    made: MachinedFeatures, taken: Iterable[tuple[MachinedPath, RequiredPath]],
    tools: ToolCatalogue, name: str,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Slots whose mill goes down into the full steel, where the machine drills their ends."""
    slack = 2 * tools.machine.format.resolution + 1e-6
    for path, required in taken:
        target = required.target
        if isinstance(target, MarkingPath) or not tools.drills_ends(target.source, target.face):
            continue
        before = made.order[: made.order.index(path)]
        free = path.diameter / 2 - slack
        if not any(
            isinstance(bore, Bore) and bore.kind == "drill" and bore.face == path.face
            and dist(path.points[0], (bore.x, bore.y)) + free <= bore.diameter / 2
            for bore in before
        ):  # fmt: skip
            yield too_early(path, "into the full steel", "the hole at its end first", name)
