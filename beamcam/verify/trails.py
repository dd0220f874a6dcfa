"""Which path makes which pocket or line to mark, and what is wrong with it."""

from collections.abc import Iterator, Sequence
from math import cos, inf, radians, sin

from beamcam.errors import Diagnostic
from beamcam.verify import rules
from beamcam.verify.depths import Reach, path_reach
from beamcam.verify.made import Trail
from beamcam.verify.needs import Course, Pocket
from beamcam.verify.paths import line_error, pocket_error
from beamcam.verify.placing import NEAR
from beamcam.verify.strokes import Task, off_feed, off_reach


def judge_paths(
    trails: Sequence[Trail], wanted: Sequence[Pocket | Course], task: Task
) -> Iterator[Diagnostic]:
    """What is wrong with the paths: each pocket and line once, by the path that fits it best."""
    drill_x, resolution = task.rack.drill.x, task.machine.format.resolution
    allowed = task.rack.drill.path_tolerance + 2 * resolution
    left = list(trails)
    for need in wanted:
        kind = "mill" if isinstance(need, Pocket) else "scribe"
        from_x = drill_x + task.starts[need.part]
        # The nearest path is meant, of those about one middle the one of its size; measuring it
        # point by point is the dear part.
        near = [
            (*_apart(trail, need, from_x), trail.line, trail)
            for trail in left
            if trail.kind == kind and trail.face == need.face
        ]
        mark = task.parts[need.part].mark
        what = need.what if isinstance(need, Pocket) else "line to mark"
        apart, _, _, trail = min(
            near, key=lambda n: (n[0] + n[1], n[2]), default=(inf, inf, 0, None)
        )
        if trail is None or apart > NEAR:
            yield rules.NOT_MADE.at(need.source.source, found=f"the {what}", mark=mark)
            continue
        off = _error(need, [(x - from_x, y) for x, y in trail.points], trail)
        left.remove(trail)
        if off > allowed:
            yield rules.PATH.at(
                task.at(trail.line), what=f"the {what}", mark=mark, found=f"{off:.3f}",
                expected=f"{allowed:g}",
            )  # fmt: skip
        yield from _trail(trail, need, what, task)
    for trail in left:
        x, y = trail.points[0]
        yield rules.PATH_EXTRA.at(
            task.at(trail.line), kind=trail.kind, face=trail.face, x=f"{x:g}", y=f"{y:g}"
        )


def _apart(trail: Trail, need: Pocket | Course, from_x: float) -> tuple[float, float]:
    """How far the middles of a path and of what it may be meant for are apart, and their sizes."""
    if isinstance(need, Pocket):
        c, s = abs(cos(radians(need.angle))), abs(sin(radians(need.angle)))
        round_about = need.diameter - trail.diameter
        own_x, own_y = need.x, need.y
        own_width = c * need.length + s * need.height + round_about
        own_height = s * need.length + c * need.height + round_about
    else:
        boxes = [curve.bbox for curve in need.curves]
        corners = [(b[0], b[1]) for b in boxes] + [(b[2], b[3]) for b in boxes]
        own_x, own_y, own_width, own_height = _box(corners)
    x, y, width, height = _box(trail.points)
    apart = abs(x - from_x - own_x) + abs(y - own_y)
    return apart, abs(width - own_width) + abs(height - own_height)


def _box(points: Sequence[tuple[float, float]]) -> tuple[float, float, float, float]:
    """The middle of points, their width and their height."""
    xs, ys = [x for x, _ in points], [y for _, y in points]
    x0, x1, y0, y1 = min(xs), max(xs), min(ys), max(ys)
    return (x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0


def _error(need: Pocket | Course, points: Sequence[tuple[float, float]], trail: Trail) -> float:
    if isinstance(need, Pocket):
        return pocket_error(need, points, trail.diameter)
    return line_error(need.curves, points)


def _trail(trail: Trail, need: Pocket | Course, what: str, task: Task) -> Iterator[Diagnostic]:
    """What is wrong with the tool, the depth and the feed of a path."""
    part = task.parts[need.part]
    x, y = (need.x, need.y) if isinstance(need, Pocket) else need.curves[0].start
    described: dict[str, object] = {
        "what": what, "face": need.face, "mark": part.mark, "x": f"{x:g}", "y": f"{y:g}",
    }  # fmt: skip
    sizes = sorted(task.rack.sizes(trail.kind, need.face))
    if trail.diameter not in sizes:
        shown = ", ".join(f"{d:g}" for d in sizes)
        yield rules.TOOL.at(
            task.at(trail.line), found=f"a {trail.kind} {trail.diameter:g}",
            expected=f"one of {shown}", **described,
        )  # fmt: skip
        return
    if isinstance(need, Pocket):
        reach = path_reach(need.depth, part.profile.thickness(need.face), task.rack)
    else:
        reach = Reach(task.rack.drill.mark_depth, task.rack.drill.mark_depth)
    yield from off_reach(trail.least_depth, trail.greatest_depth, reach, described, trail, task)
    yield from off_feed(trail, part.grade, task)
