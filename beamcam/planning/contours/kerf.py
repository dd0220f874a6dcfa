"""Kerf compensation: contours offset by half a kerf, or left to the controller.

Contours that share edges with others, which are cut once: where they begin, and in which order.

 ____________
|     |     |    1 is cut as a ring, begun on an edge that it has for itself. What is left of
|  1  |  2  |    2 begins and ends on that: the torch pierces in a kerf that is open, and the
|_____|_____|    part hangs in the sheet by it until its end.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import shapely
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.arrays import CurveTable, overlapping
from beamcam.geometry.curves import Curve, join_boxes
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.entry import from_middle, leads, uncompensated, waste_side
from beamcam.planning.contours.narrow import left_in, sharp_corners, told_near, told_of, too_near
from beamcam.planning.contours.outline import Shape, from_longest
from beamcam.planning.contours.outline import ways as outlines
from beamcam.planning.contours.outline import ways as polylines_of
from beamcam.planning.contours.repeats import Repeats, contours_once

if TYPE_CHECKING:
    from shapely import STRtree


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
    chains = [shapes[k].curves for k in runs]
    ends = [shapely.Point(p) for chain in chains for p in (chain[0].start, chain[-1].end)]
    before: list[dict[int, int]] = [{} for _ in shapes]  #: by how many levels others are lower
    near = tree.query(ends, "dwithin", distance=torch.gap).T.tolist() if ends else []
    for end, other in near:
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


def with_joints(shapes: Sequence[Shape], torch: Torch) -> list[Shape]:
    """The shapes with the places where the rests of others begin and end on them."""
    rests = [s.curves for s in shapes if s.process == "cut" and not s.closed]
    ends = [end for curves in rests for end in (curves[0].start, curves[-1].end)]
    joints: list[list[Point]] = [[] for _ in shapes]
    if ends:
        tree = shapely.STRtree(polylines_of([s.curves for s in shapes], torch.tolerance / 4))
        near = tree.query(shapely.points(ends), "dwithin", distance=torch.gap)
        for end, k in near.T.tolist():
            joints[k].append(ends[end])
    return [replace(s, joints=tuple(own)) for s, own in zip(shapes, joints, strict=True)]


#: Mitre limit of corners, in half kerfs.
MITRE_LIMIT = 2.5

#: What of the machine's tolerance the fitting of arcs may take; the offset and the rounding of
#: coordinates take the rest.
FIT_SHARE = 0.4


def compensated(
    shapes: Sequence[Shape], kerfs: Sequence[float], torch: Torch
) -> tuple[list[Shape], list[Diagnostic]]:
    """The toolpaths along the shapes, one for each, and remarks on them.

    `kerfs` gives the kerf to compensate for each shape, 0 for none. By offset the contours lie
    half of it away from the part: outwards, in a hole inwards. A controller that keeps off by
    itself gets lines and arcs. What cannot be cut is an error: a contour without room for the
    kerf, one that the cut of another enters, and one that a controller cannot keep off.
    """
    offset_shapes = list(shapes)
    by_machine = torch.kerf_by == "machine"
    which = [
        k
        for k, (shape, kerf) in enumerate(zip(shapes, kerfs, strict=True))
        if kerf or (by_machine and shape.process == "cut" and shape.closed)
    ]
    if not which:
        return offset_shapes, []
    from beamcam.geometry.arc_fitting import fit_chains

    fits = fit_chains([shapes[k].curves for k in which], torch.tolerance * FIT_SHARE)
    for k, curves in zip(which, fits, strict=True):
        offset_shapes[k] = replace(shapes[k], curves=curves)
    kept_off = [k for k in which if kerfs[k]]
    diagnostics: list[Diagnostic] = []
    paths: list[Shape | None] = list(shapes)
    for k, path in _moved(offset_shapes, kept_off, kerfs, torch, diagnostics):
        paths[k] = path
    near = too_near(shapes, paths, kerfs, torch)
    # There may be room for the kerf, but not for a mitre that stands out from it.
    rounded = {
        k
        for n in near
        if n.width >= kerfs[n.shape] - torch.tolerance
        for k in (n.shape, n.other)
        if kerfs[k]
    }
    if rounded and not by_machine:
        for k, path in _moved(offset_shapes, sorted(rounded), kerfs, torch, [], mitre_limit=0.0):
            paths[k] = path
        near = too_near(shapes, paths, kerfs, torch)
    diagnostics += [told_near(shapes, n, kerfs[n.shape]) for n in near]
    if not by_machine:
        for k in kept_off:
            offset_shapes[k] = paths[k] or offset_shapes[k]
    return offset_shapes, diagnostics


def _moved(
    shapes: Sequence[Shape],
    which: Sequence[int],
    kerfs: Sequence[float],
    torch: Torch,
    diagnostics: list[Diagnostic],
    mitre_limit: float = MITRE_LIMIT,
) -> Iterator[tuple[int, Shape | None]]:
    """Those of the shapes half a kerf away from the part; None for one without room for the kerf.

    A notch narrower than the kerf closes up and leaves a ring, a hole with a narrow neck falls
    into several: what the greatest of them does not reach is reported.
    """
    from beamcam.geometry.offset import Vanished, offset_chains

    some = [shapes[k] for k in which]
    widths = [kerfs[k] for k in which]
    amounts = [-w / 2 if s.is_hole else w / 2 for s, w in zip(some, widths, strict=True)]
    fit = torch.tolerance * FIT_SHARE
    moved = offset_chains([s.curves for s in some], amounts, fit, mitre_limit)
    for k, offset, sharp in zip(which, moved, sharp_corners(some, widths), strict=True):
        shape, kerf = shapes[k], kerfs[k]
        if isinstance(offset, Vanished):
            diagnostics.append(_no_room(shape, kerf))
            yield k, None
            continue
        area, ring = max(zip(offset.areas, offset.chains, strict=True), key=lambda one: abs(one[0]))
        if torch.kerf_by == "machine" and not offset.exact:
            diagnostics.append(uncompensated(shape, kerf))
        path = replace(shape, curves=ring, area=area)
        others = [chain for chain in offset.chains if chain is not ring]
        left = sharp if offset.exact else left_in(shape, path, kerf, torch.tolerance, others)
        diagnostics += told_of(shape, left, kerf)
        yield k, path


def common_cuts(
    paths: Sequence[Shape], kerfs: Sequence[float], torch: Torch, share: bool
) -> tuple[list[Shape], list[float], list[Diagnostic]]:
    """The toolpaths and their kerfs, with edges shared by two contours cut once.

    That is an edge of both if no kerf is kept off, else the middle between two that are a kerf
    apart. A contour of which nothing is left is made by the first one that it lies on.
    Without a kerf nothing is looked for unless contours `share` edges.
    """
    if torch.kerf_by == "machine" or not (share or any(kerfs)):
        return list(paths), list(kerfs), []
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
        shapes = with_joints(shapes, torch)
    return shapes, [kerfs[k] for k, _ in cuts], list(repeats.remarks())


def _no_room(shape: Shape, kerf: float) -> Diagnostic:
    box = join_boxes([c.bbox for c in shape.curves]) or (0.0, 0.0, 0.0, 0.0)
    size = f"{box[2] - box[0]:.3g} x {box[3] - box[1]:.3g}"
    return rules.VANISHED.at(shape.source, found=size, kerf=f"{kerf:g}")


# --- leads ----------------------------------------------------------------------------------------

# Leads that stay in the waste: shortened, or left out, where a contour is too narrow for them.


#: The share of a lead that is not asked for its distance, at the contour.
AT_CONTOUR = 0.1

Curves = tuple[Curve, ...]
Lead = tuple[Curves, Curves]  #: in and out
NO_LEADS: Lead = ((), ())

#: The shares of the machine's lengths that are tried, longest first.
SHARES = (1.0, 0.6, 0.35, 0.2, 0.1)

#: How far off its path a lead ends at least, in tolerances: one of the path's radius lies on it.
OFF_PATH = 4.0


def leads_of(
    ways: Sequence[Shape],
    overs: Sequence[Curves],
    torch: Torch,
    half_kerf: float,
    pierce_radius: float,
    contours: Sequence[Shape],
) -> tuple[dict[int, Lead], list[Diagnostic]]:
    """The lead-ins and lead-outs of the shapes that need them and have room, and a remark.

    The torch pierces at least `pierce_radius` from every contour. Where no lead-in begins as far
    off, it is as long as there is room for.
    """
    import shapely

    if torch.lead == "none":
        return {}, []
    which = [k for k, s in enumerate(ways) if s.process == "cut" and s.is_ring]
    sides = {k: waste_side(ways[k].area, ways[k].depth % 2 == 1) for k in which}
    # With a kerf the part's own contours must stay untouched, without one the ways as well.
    # What chords and rounding take of half a kerf is less than half of the tolerance.
    clearance = max(0.0, half_kerf - torch.tolerance / 2)
    fence = [s.curves for s in contours if s.process == "cut"]
    tree = shapely.STRtree(polylines_of(fence, torch.tolerance / 4))
    off_path = half_kerf + OFF_PATH * torch.tolerance if half_kerf else 0.0
    ways_in: dict[int, Curves] = {}
    suggestions: dict[int, Curves] = {}
    short: set[int] = set()
    if torch.hole_lead == "middle":
        small = {k: from_middle(ways[k].curves) for k in which if ways[k].is_small}
        round_ones = {k: curves for k, curves in small.items() if curves}
        kept = _clear_of(tree, round_ones, False, torch.tolerance, clearance, 0.0)
        ways_in |= {k: round_ones[k] for k in kept}
    # Each for itself, so that a way out without room does not shorten the way in.
    for found, is_out, far in (
        (ways_in, False, max(pierce_radius, off_path)), (ways_in, False, off_path),
        (suggestions, True, off_path),
    ):  # fmt: skip
        for share in SHARES:
            tried = {
                k: leads(ways[k].curves, sides[k], torch, share, overs[k])[is_out]
                for k in which
                if k not in found
            }
            kept = _clear_of(tree, tried, is_out, torch.tolerance, clearance, far)
            if share == SHARES[0]:
                short |= tried.keys() - kept
            found |= {k: tried[k] for k in kept}
    led = {k: (ways_in.get(k, ()), suggestions.get(k, ())) for k in which}
    if not short:
        return led, []
    first = ways[min(short)].source
    return led, [rules.NO_LEAD.at(first, count=len(short), found=f"{torch.lead_in:g}")]


def _clear_of(
    tree: "STRtree",
    tried: dict[int, Curves],
    is_out: bool,
    tolerance: float,
    clearance: float,
    far: float,
) -> set[int]:
    """Those whose leads keep `clearance` from every contour of a tree, and their ends `far`.

    A lead is one line or arc. What of it is nearest to its contour touches that where there is no
    kerf, and is not asked.
    """
    import shapely

    owners, away, ends = [], [], []
    for k, curves in tried.items():
        for curve in curves if is_out else (c.reversed() for c in curves):
            share = AT_CONTOUR
            if clearance > 0.0:  # no farther than to where it would enter the part
                share = min(share, clearance / curve.length)
            owners.append(k)
            away.append((curve.split(share)[1],))
            ends.append(curve.end)
    if not owners:
        return set(tried)
    lines = polylines_of(away, tolerance / 4)
    if clearance > 0.0:
        hit = tree.query(lines, "dwithin", distance=clearance)[0].tolist()
    else:
        hit = tree.query(lines, "intersects")[0].tolist()
    if far > 0.0:
        apart = far - tolerance / 2
        hit += tree.query(shapely.points(ends), "dwithin", distance=apart)[0].tolist()
    return set(tried) - {owners[h] for h in hit}
