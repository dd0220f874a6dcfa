"""Duplicates in a drawing, removed before anything is cut twice.

Loose curves before they are joined; what lies on another contour when contours are known.
"""

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import dist

import shapely
from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.arrays import SAME_PLACE, CurveTable, overlapping
from beamcam.geometry.curves import Curve, signed_area
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.model.lengths import total_length
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.outline import Shape, entity, from_longest, ways


class Repeats(Struct):
    """Duplicates that are cut once."""

    stands: dict[int, int] = field(default_factory=dict)  #: a feature and the one it lies on
    gone: list[Source] = field(default_factory=list)  #: curves and contours that are not cut
    gone_length: float = 0.0
    common: list[Source] = field(default_factory=list)  #: contours that share an edge
    common_length: float = 0.0
    refusals: list[Diagnostic] = field(default_factory=list)
    share: bool = False  #: whether contours that stay whole share an edge

    def remarks(self) -> Iterator[Diagnostic]:
        """One for all that is not cut again, one for all shared edges."""
        if self.gone:
            length = f"{self.gone_length:.3f}"
            yield rules.OVERLAP.at(self.gone[0], count=len(self.gone), found=length)
        if self.common:
            length = f"{self.common_length:.3f}"
            yield rules.COMMON.at(self.common[0], count=len(self.common), found=length)

    def resolved(self, made: Collection[int]) -> dict[int, int]:
        """Each feature that is not made, and the one at the end of its chain of replacements."""
        resolved = {}
        for feature, into in self.stands.items():
            seen = {feature}
            while into not in made and into in self.stands and into not in seen:
                seen.add(into)
                into = self.stands[into]
            if feature not in made:
                resolved[feature] = into
        return resolved


def loose_once(curves: Sequence[AssignedCurve], repeats: Repeats) -> list[AssignedCurve]:
    """Loose curves of one process without those that lie on others among them."""
    pairs = overlapping(CurveTable([w.curve for w in curves]), [w.process for w in curves])
    if not pairs:
        return list(curves)
    from beamcam.geometry.cleaning import remove_repetitions

    doubtful = sorted({k for pair in pairs for k in pair})
    others = sorted(set(range(len(curves))).difference(doubtful))
    cleaned = remove_repetitions(
        [curves[k].curve for k in doubtful], SAME_PLACE, [curves[k].curve for k in others]
    )
    keep = {k: curves[k] for k in others}
    for n, curve in zip(cleaned.indices, cleaned.curves, strict=True):
        keep[doubtful[n]] = replace(curves[doubtful[n]], curve=curve)
    for removed in cleaned.removed:
        gone, into = curves[doubtful[removed.index]], curves[doubtful[removed.into]]
        repeats.stands[gone.feature] = into.feature
        repeats.gone.append(gone.source)
        repeats.gone_length += gone.curve.length
    return [keep[k] for k in sorted(keep)]


def contours_once(
    shapes: Sequence[Shape], gap: float, repeats: Repeats, kerf: float | None = None
) -> list[list[Shape]]:
    """What is left of each contour without pieces that lie on others of the same process.

    Of two that lie on one another the closed one stays, or else the first. Remainders up to
    `gap` are dropped. Two closed ones that share an edge and are not the same, and one that lies
    on itself, stay whole if the `kerf` is given, and are refused if it is not 0.
    """
    once = _unequal(shapes, repeats)
    curves = [curve for k in once for curve in shapes[k].curves]
    owners = [k for k in once for _ in shapes[k].curves]
    covers: defaultdict[int, list[int]] = defaultdict(list)
    for a, b in overlapping(CurveTable(curves), [shapes[k].process for k in owners]):
        first, second = sorted((a, b), key=lambda c: (not shapes[owners[c]].closed, owners[c]))
        covers[second].append(first)
    lying = {owners[c] for c in covers}
    kept: list[list[Shape]] = [[] for _ in shapes]
    begin = 0
    for k in once:
        shape = shapes[k]
        own = range(begin, begin + len(shape.curves))
        begin += len(shape.curves)
        if k in lying:
            on = [[(curves[o], shapes[owners[o]]) for o in covers.get(c, ())] for c in own]
            kept[k] = _rest(shape, on, gap, repeats, kerf)
        else:
            kept[k] = [shape]
    return kept


def _unequal(shapes: Sequence[Shape], repeats: Repeats) -> list[int]:
    """Indices of the contours without repeats: of equal ones, the first."""
    first: dict[tuple[str, bool, tuple[Curve, ...]], Shape] = {}
    once = []
    for k, shape in enumerate(shapes):
        stands_for = first.setdefault((shape.process, shape.closed, shape.curves), shape)
        if stands_for is shape:
            once.append(k)
            continue
        repeats.gone.append(shape.source)
        repeats.gone_length += total_length(shape.curves)
        repeats.stands.update(dict.fromkeys(shape.features, stands_for.features[0]))
    return once


def _rest(
    shape: Shape, on: Sequence[Sequence[tuple[Curve, Shape]]], gap: float, repeats: Repeats,
    kerf: float | None,
) -> list[Shape]:  # fmt: skip
    """What is to be cut of a contour of which each curve may lie `on` others."""
    from beamcam.geometry.cleaning import uncovered

    rests = [
        uncovered(curve, [other for other, _ in others], SAME_PLACE)
        for curve, others in zip(shape.curves, on, strict=True)
    ]
    lost = total_length(shape.curves) - total_length(curve for rest in rests for curve in rest)
    if lost <= SAME_PLACE:
        return [shape]
    at = next(k for k, curve in enumerate(shape.curves) if on[k] and rests[k] != (curve,))
    stands_for = on[at][0][1]
    runs = [run for run in _runs(rests, shape.closed) if total_length(run) > gap]
    # It is the same as one closed contour that it lies on all round, and that has its area.
    common = set.intersection(*({id(other) for _, other in others} for others in on))
    other = next((other for _, other in on[0] if id(other) in common), None)
    is_same = (
        other is not None
        and other.closed
        and (
            abs(abs(signed_area(shape.curves)) - abs(signed_area(other.curves)))
            <= SAME_PLACE * total_length(shape.curves)
        )
    )
    is_common = shape.closed and (bool(runs) or stands_for is shape or not is_same)
    if is_common and kerf is not None:
        if kerf and shape.process == "cut":
            name = "itself" if shape is stands_for else entity(stands_for.source)
            values = {"found": f"{lost:.3f}", "other": name, "kerf": f"{kerf:g}"}
            place = rules.at_place(shape.curves[at].point(0.5))
            repeats.refusals.append(rules.SHARED.at(shape.source, **values, **place))
        repeats.share = True
        return [shape]
    if is_common:
        repeats.common.append(shape.source)
        repeats.common_length += lost
    else:
        repeats.gone.append(shape.source)
        repeats.gone_length += lost
    if not runs:
        repeats.stands.update(dict.fromkeys(shape.features, stands_for.features[0]))
    return [replace(shape, curves=run, closed=False) for run in runs]


def _runs(rests: Sequence[tuple[Curve, ...]], closed: bool) -> list[tuple[Curve, ...]]:
    """What is left of a chain as chains of curves that follow one another."""
    runs: list[list[Curve]] = []
    for curve in (curve for rest in rests for curve in rest):
        if runs and dist(runs[-1][-1].end, curve.start) <= SAME_PLACE:
            runs[-1].append(curve)
        else:
            runs.append([curve])
    if closed and len(runs) > 1 and dist(runs[-1][-1].end, runs[0][0].start) <= SAME_PLACE:
        runs[0] = [*runs.pop(), *runs[0]]
    return [tuple(run) for run in runs]


# --- common edges ---------------------------------------------------------------------------------

# Contours that share edges with others, which are cut once: where they begin, in which order.
#
#  ____________
# |     |     |    1 is cut as a ring, begun on an edge that it has for itself. What is left of
# |  1  |  2  |    2 begins and ends on that: the torch pierces in a kerf that is open, and the
# |_____|_____|    part hangs in the sheet by it until its end.


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
    common: defaultdict[int, set[int]] = defaultdict(set)
    for pair in overlapping(CurveTable(curves), [paths[k].process for k, _ in owners]):
        for k, n in (owners[number] for number in pair):
            common[k].add(n)
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
    before: list[dict[int, int]] = [{} for _ in shapes]  #: by how many levels others are lower
    for run, other, _ in _ends_on(shapes, torch):
        if other < run and shapes[other].process == "cut":
            before[run][other] = 1
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


def _ends_on(shapes: Sequence[Shape], torch: Torch) -> Iterator[tuple[int, int, Point]]:
    """Open cuts, the shapes that each begins or ends on, and where."""
    runs = [k for k, s in enumerate(shapes) if s.process == "cut" and not s.closed]
    chains = [shapes[k].curves for k in runs]
    ends = [end for curves in chains for end in (curves[0].start, curves[-1].end)]
    if ends:
        tree = shapely.STRtree(ways([s.curves for s in shapes], torch.tolerance / 4))
        near = tree.query(shapely.points(ends), "dwithin", distance=torch.gap)
        yield from ((runs[end // 2], k, ends[end]) for end, k in near.T.tolist())


def common_cuts(
    paths: Sequence[Shape], kerfs: Sequence[float], torch: Torch
) -> tuple[list[Shape], list[float], list[Diagnostic]]:
    """The toolpaths and their kerfs, with edges shared by two contours cut once.

    That is an edge of both if no kerf is kept off, else the middle between two that are a kerf
    apart. A contour of which nothing is left is made by the first one that it lies on.
    """
    repeats = Repeats()
    once = contours_once(paths, torch.gap, repeats)
    if not repeats.common:
        return list(paths), list(kerfs), []
    cuts = [(k, shape) for k, rest in enumerate(once) for shape in rest]
    of_feature = {f: n for n, (_, shape) in reversed(list(enumerate(cuts))) for f in shape.features}
    first = {k: n for n, (k, _) in reversed(list(enumerate(cuts)))}
    more: defaultdict[int, list[int]] = defaultdict(list)
    for feature, into in repeats.resolved(of_feature).items():
        more[of_feature[into]].append(feature)
    shapes = [
        replace(
            shape,
            parent=first.get(shape.parent, -1),
            features=tuple(sorted((*shape.features, *more[n]))),
        )
        for n, (_, shape) in enumerate(cuts)
    ]
    if any(kerfs):
        shapes = in_levels(begun_off_common(shapes, paths, first, torch), torch)
    if torch.tabs:
        joints: list[list[Point]] = [[] for _ in shapes]
        for _, other, place in _ends_on(shapes, torch):
            joints[other].append(place)
        both = zip(shapes, joints, strict=True)
        shapes = [replace(shape, joints=tuple(places)) for shape, places in both]
    return shapes, [kerfs[k] for k, _ in cuts], list(repeats.remarks())
