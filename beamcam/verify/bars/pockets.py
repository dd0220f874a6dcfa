"""The paths that a program leads tools along, against the slots and lines of the parts."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
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
from beamcam.verify.bars.walls import wall_thickness

Box = tuple[float, float, float, float]  #: the middle, the width and the height


class Led(Struct, frozen=True, gc=False):
    """A pocket or line of a part on the bar."""

    part: int
    target: Pocket | Course
    from_x: float  #: machine X of the part's x 0


class CheckedPaths(Struct, frozen=True):
    """What was found of the paths of a program."""

    said: tuple[Diagnostic, ...]
    taken: tuple[tuple[MachinedPath, Led], ...]  #: each path with what it is taken for


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
    paths: Sequence[MachinedPath], wanted: Sequence[Led], parts: Sequence[Part], shop: Shop,
    profile: Profile, name: str,
) -> CheckedPaths:  # fmt: skip
    """Faults of the paths: each pocket and line once, by the path that fits it best."""
    allowed = _allowed(shop)
    left, said = PathsAlong(paths), list[Diagnostic]()
    taken: list[tuple[MachinedPath, Led]] = []
    for want in wanted:
        target, mark = want.target, parts[want.part].mark
        path = _meant(left, want, allowed)
        if path is None:
            said.append(
                rules.NOT_MADE.at(target.source.source, found=f"the {target.what}", mark=mark)
            )
            continue
        left.remove(path)
        taken.append((path, want))
        off = _off(path, want)
        if off > allowed:
            said.append(rules.PATH.at(
                Source(name, path.line), what=f"the {target.what}", mark=mark,
                found=f"{off:.3f}", expected=f"{allowed:g}",
            ))  # fmt: skip
        said += _tool_and_depth(path, target, mark, shop, profile, Source(name, path.line))
    for path in left.rest:
        x, y = path.points[0]
        said.append(rules.PATH_EXTRA.at(
            Source(name, path.line), kind=path.kind, face=path.face, x=f"{x:g}", y=f"{y:g}"
        ))  # fmt: skip
    return CheckedPaths(tuple(said), tuple(taken))


def is_led(paths: PathsAlong, target: Pocket | Course, from_x: float, shop: Shop) -> bool:
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


def _meant(paths: PathsAlong, want: Led, allowed: float) -> MachinedPath | None:
    """The path that makes a pocket or line, or else the one that may have been meant for it.

    The nearest come first, of those about one middle the one of its size.
    """
    kind = "mill" if isinstance(want.target, Pocket) else "scribe"
    target = want.target
    own = _box_of(target)
    near = [
        (apart, unlike, path.line, path)
        for path, box in paths.near(want.from_x + own[0])
        if path.kind == kind and path.face == target.face
        for apart, unlike in [_apart(box, path.diameter, target, own, want.from_x)]
        if apart <= NEAR
    ]
    near.sort(key=lambda n: (n[0] + n[1], n[2]))
    if len(near) > 1:
        right = (n[3] for n in near if _off(n[3], want) <= allowed)
        return next(right, near[0][3])
    return near[0][3] if near else None


def _apart(
    box: Box, mill: float, target: Pocket | Course, own: Box, from_x: float
) -> tuple[float, float]:
    """How far the middles of a path and of what it may be meant for are apart, and their sizes."""
    own_x, own_y, own_width, own_height = own
    round_about = target.diameter - mill if isinstance(target, Pocket) else 0.0
    x, y, width, height = box
    apart = abs(x - from_x - own_x) + abs(y - own_y)
    unlike = abs(width - own_width - round_about) + abs(height - own_height - round_about)
    return apart, unlike


def _box_of(target: Pocket | Course) -> Box:
    """The middle of a line or a pocket on its part, and its size; of a pocket that of the core."""
    if isinstance(target, Pocket):
        c, s = abs(cos(radians(target.angle))), abs(sin(radians(target.angle)))
        width, height = target.length, target.height
        return target.x, target.y, c * width + s * height, s * width + c * height
    boxes = [curve.bbox for curve in target.curves]
    return _box([(b[0], b[1]) for b in boxes] + [(b[2], b[3]) for b in boxes])


def _box(points: Sequence[tuple[float, float]]) -> Box:
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
        reach = path_reach(target.depth, wall_thickness(profile, target.face), shop)
    else:
        reach = DepthRange(shop.drill.mark_depth, shop.drill.mark_depth)
    slack = shop.machine.format.resolution + 1e-6
    depths = path.min_depth, path.max_depth
    if depths[0] < reach.least - slack or depths[1] > reach.greatest + slack:
        yield wrong_depth(depths, reach, 0.0, slack, source, described)
