"""Curves to contours: what lies twice taken away, ends joined, and what lies inside what."""

from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.chains import Chains, join_curves
from beamcam.geometry.curves import Curve
from beamcam.machine.machine import Torch, TorchProcess
from beamcam.planning.contours import rules
from beamcam.planning.contours.gather import Wanted
from beamcam.planning.contours.outline import outlines

Floats = NDArray[np.float64]

#: A closed chain whose ends are nearer than this needs no joining.
SAME_POINT = 1e-9


class Shape(Struct, frozen=True):
    """A contour that one process follows, and where it lies among the cut ones."""

    process: TorchProcess
    curves: tuple[Curve, ...]
    closed: bool
    features: tuple[int, ...]  #: ascending; `gather.OUTLINE` may be among them
    source: Source
    depth: int = 0  #: how many cut contours lie around it
    parent: int = -1  #: the innermost of them, by its index; -1 for none
    area: float = 0.0  #: inside of a closed cut, mm2, above 0 if it runs counter-clockwise


def join(wanted: Sequence[Wanted], torch: Torch) -> tuple[list[Shape], list[Diagnostic]]:
    """The contours, in the order in which their first curves were given, and remarks.

    A feature whose curves close stays as it is drawn; all others are joined end to end, each
    process for itself.
    """
    shapes: list[tuple[int, Shape]] = []
    said: list[Diagnostic] = []
    loose: dict[TorchProcess, list[int]] = defaultdict(list)
    ends = CurveTable([w.curve for w in wanted]).ends
    for begin, end, closed in _features(wanted, ends):
        first = wanted[begin]
        if closed:
            curves = tuple([w.curve for w in wanted[begin:end]])
            shape = Shape(first.process, curves, True, (first.feature,), first.source)
            shapes.append((begin, shape))
        else:
            loose[first.process] += range(begin, end)
    for process, indices in loose.items():
        chains = join_curves([wanted[i].curve for i in indices], torch.gap, ends=ends[indices])
        for chain in chains.chains:
            members = [indices[m] for m in chain.members if m >= 0]
            source = wanted[members[0]].source
            features = tuple(sorted({wanted[m].feature for m in members}))
            shapes.append(
                (min(members), Shape(process, chain.curves, chain.closed, features, source))
            )
        if process == "cut":
            said += _remarks(chains, [wanted[i].source for i in indices], torch)
    shapes.sort(key=lambda entry: entry[0])
    return [shape for _, shape in shapes], said


def _features(wanted: Sequence[Wanted], places: Floats) -> Iterator[tuple[int, int, bool]]:
    """For each feature where its curves begin and end, and whether they are one closed chain:
    they follow one another and end where they begin. `places` are the ends of all, (n, 4)."""
    features = np.array([w.feature for w in wanted])
    begins = np.flatnonzero(np.concatenate(([True], features[1:] != features[:-1])))
    ends = np.append(begins[1:], len(wanted))
    before = np.arange(len(wanted)) - 1
    before[begins] = ends - 1
    gaps = np.abs(places[:, :2] - places[before, 2:]).max(axis=1) > SAME_POINT
    is_open = np.logical_or.reduceat(gaps, begins)
    yield from zip(begins.tolist(), ends.tolist(), (~is_open).tolist(), strict=True)


def _remarks(chains: Chains, sources: Sequence[Source], torch: Torch) -> list[Diagnostic]:
    said = [
        rules.JUNCTION.at(
            sources[junction.members[0]],
            found=len(junction.members),
            x=f"{junction.point[0]:.3f}",
            y=f"{junction.point[1]:.3f}",
        )
        for junction in chains.junctions
    ]
    said += (
        rules.GAP.at(
            sources[gap.members[0]],
            found=f"{gap.width:.4f}",
            x=f"{gap.start[0]:.3f}",
            y=f"{gap.start[1]:.3f}",
            expected=f"{torch.gap:g}",
        )
        for gap in chains.gaps
    )
    return said


def nest(shapes: Sequence[Shape], tolerance: float) -> tuple[list[Shape], list[Diagnostic]]:
    """The shapes with their area, depth and parent, and the closed ones that cross themselves.

    A contour lies in another of greater area that a point inside it lies in. Contours that touch
    are told apart by that, those that cross are not.
    """
    import shapely

    closed = [i for i, s in enumerate(shapes) if s.closed and s.process == "cut"]
    found = list(shapes)
    if not closed:
        return found, []
    rings = outlines([shapes[i].curves for i in closed], tolerance)
    signed = shapely.area(rings) * np.where(shapely.is_ccw(shapely.get_exterior_ring(rings)), 1, -1)
    areas = np.abs(signed)
    tree = shapely.STRtree(rings)
    simple = shapely.is_valid(rings)
    insides = rings.copy()
    insides[~simple] = shapely.make_valid(rings[~simple])
    points = list(shapely.point_on_surface(insides))
    asked = list(closed)
    own_area = list(areas)
    for i, shape in enumerate(shapes):
        if shape.process == "cut" and not shape.closed:
            points.append(shapely.Point(shape.curves[0].point(0.5)))
            asked.append(i)
            own_area.append(0.0)
    inner, outer = tree.query(points, predicate="within")
    around: dict[int, list[int]] = defaultdict(list)
    for a, b in zip(inner.tolist(), outer.tolist(), strict=True):
        if asked[a] != closed[b] and own_area[a] < areas[b]:
            around[asked[a]].append(b)
    for i, area in zip(asked, [*signed.tolist(), *[0.0] * (len(asked) - len(closed))], strict=True):
        rings_around = around[i]
        parent = closed[min(rings_around, key=lambda b: (areas[b], b))] if rings_around else -1
        found[i] = replace(shapes[i], area=area, depth=len(rings_around), parent=parent)
    said = []
    for k in np.flatnonzero(~simple).tolist():
        # Ends that were joined may cross by a hair; that changes no inside worth speaking of.
        whole = insides[k].area
        if abs(whole - areas[k]) <= tolerance * shapely.length(rings[k]):
            continue
        # "Self-intersection[12.5 40]"
        reason = shapely.is_valid_reason(rings[k])
        x, _, y = reason.partition("[")[2].rstrip("]").partition(" ")
        said.append(rules.CROSSING.at(shapes[closed[k]].source, x=x, y=y))
    return found, said
