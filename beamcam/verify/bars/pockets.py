"""The paths that a program leads tools along, against the slots and lines of the parts."""

from collections.abc import Iterator, Sequence
from math import cos, radians, sin

from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Part, Profile
from beamcam.verify import rules
from beamcam.verify.bars.depths import DepthRange, path_reach
from beamcam.verify.bars.holes import NEAR, wrong_depth
from beamcam.verify.bars.machined_features import MachinedPath
from beamcam.verify.bars.paths import line_error, pocket_error
from beamcam.verify.bars.shop import Shop
from beamcam.verify.bars.targets import Course, Pocket


class Led(Struct, frozen=True, gc=False):
    """A pocket or line of a part on the bar."""

    part: int
    target: Pocket | Course
    from_x: float  #: machine X of the part's x 0


def check_paths(
    paths: Sequence[MachinedPath], wanted: Sequence[Led], parts: Sequence[Part], shop: Shop,
    profile: Profile, name: str,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Faults of the paths: each pocket and line once, by the path that fits it best."""
    allowed = _allowed(shop)
    left = list(paths)
    for want in wanted:
        target, mark = want.target, parts[want.part].mark
        path = _meant(left, want, allowed)
        if path is None:
            yield rules.NOT_MADE.at(target.source.source, found=f"the {target.what}", mark=mark)
            continue
        left.remove(path)
        off = _off(path, want)
        if off > allowed:
            yield rules.PATH.at(
                Source(name, path.line), what=f"the {target.what}", mark=mark,
                found=f"{off:.3f}", expected=f"{allowed:g}",
            )  # fmt: skip
        yield from _tool_and_depth(path, target, mark, shop, profile, Source(name, path.line))
    for path in left:
        x, y = path.points[0]
        yield rules.PATH_EXTRA.at(
            Source(name, path.line), kind=path.kind, face=path.face, x=f"{x:g}", y=f"{y:g}"
        )


def is_led(
    paths: Sequence[MachinedPath], target: Pocket | Course, from_x: float, shop: Shop
) -> bool:
    """Whether there is a path that makes a pocket or line."""
    want = Led(0, target, from_x)
    path = _meant(paths, want, _allowed(shop))
    return path is not None and _off(path, want) <= _allowed(shop)


def _allowed(shop: Shop) -> float:
    """Permitted deviation of a path."""
    return shop.drill.path_tolerance + 2 * shop.machine.format.resolution


def _off(path: MachinedPath, want: Led) -> float:
    """Deviation of the pocket or line that a path makes."""
    points = [(x - want.from_x, y) for x, y in path.points]
    if isinstance(want.target, Pocket):
        return pocket_error(want.target, points, path.diameter)
    return line_error(want.target.curves, points)


def _meant(paths: Sequence[MachinedPath], want: Led, allowed: float) -> MachinedPath | None:
    """The path that makes a pocket or line, or else the one that may have been meant for it.

    The nearest come first, of those about one middle the one of its size.
    """
    kind = "mill" if isinstance(want.target, Pocket) else "scribe"
    near = [
        (apart, unlike, path.line, path)
        for path in paths
        if path.kind == kind and path.face == want.target.face
        for apart, unlike in [_apart(path, want.target, want.from_x)]
        if apart <= NEAR
    ]
    near.sort(key=lambda n: (n[0] + n[1], n[2]))
    if len(near) > 1:
        right = (n[3] for n in near if _off(n[3], want) <= allowed)
        return next(right, near[0][3])
    return near[0][3] if near else None


def _apart(path: MachinedPath, target: Pocket | Course, from_x: float) -> tuple[float, float]:
    """How far the middles of a path and of what it may be meant for are apart, and their sizes."""
    if isinstance(target, Pocket):
        c, s = abs(cos(radians(target.angle))), abs(sin(radians(target.angle)))
        round_about = target.diameter - path.diameter
        own_x, own_y = target.x, target.y
        own_width = c * target.length + s * target.height + round_about
        own_height = s * target.length + c * target.height + round_about
    else:
        boxes = [curve.bbox for curve in target.curves]
        corners = [(b[0], b[1]) for b in boxes] + [(b[2], b[3]) for b in boxes]
        own_x, own_y, own_width, own_height = _box(corners)
    x, y, width, height = _box(path.points)
    apart = abs(x - from_x - own_x) + abs(y - own_y)
    return apart, abs(width - own_width) + abs(height - own_height)


def _box(points: Sequence[tuple[float, float]]) -> tuple[float, float, float, float]:
    """The middle of points, their width and their height."""
    xs, ys = [x for x, _ in points], [y for _, y in points]
    x0, x1, y0, y1 = min(xs), max(xs), min(ys), max(ys)
    return (x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0


def _tool_and_depth(
    path: MachinedPath,
    target: Pocket | Course,
    mark: str,
    shop: Shop,
    profile: Profile,
    source: Source,
) -> Iterator[Diagnostic]:
    """Faults of the tool and the depth of a path."""
    x, y = (target.x, target.y) if isinstance(target, Pocket) else target.curves[0].start
    described: dict[str, object] = {
        "what": target.what, "face": target.face, "mark": mark, "x": f"{x:g}", "y": f"{y:g}",
    }  # fmt: skip
    sizes = shop.sizes(path.kind, target.face)
    if path.diameter not in sizes:
        shown = ", ".join(f"{d:g}" for d in sizes)
        found = f"a {path.kind} {path.diameter:g}"
        yield rules.TOOL.at(source, found=found, expected=f"one of {shown}", **described)
        return
    if isinstance(target, Pocket):
        reach = path_reach(target.depth, profile.thickness(target.face), shop)
    else:
        reach = DepthRange(shop.drill.mark_depth, shop.drill.mark_depth)
    slack = shop.machine.format.resolution + 1e-6
    depths = path.min_depth, path.max_depth
    if depths[0] < reach.least - slack or depths[1] > reach.greatest + slack:
        yield wrong_depth(depths, reach, 0.0, slack, source, described)
