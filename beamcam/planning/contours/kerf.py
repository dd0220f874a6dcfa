"""Kerf compensation: contours offset by half a kerf, or left to the controller; their leads."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import dist, pi

import shapely
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line, join_boxes
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.narrow import (
    left_in,
    sharp_corners,
    told_near,
    told_of,
    too_near,
    uncompensated,
)
from beamcam.planning.contours.order import PLAIN
from beamcam.planning.contours.outline import Curves, Shape, stretch, waste_side
from beamcam.planning.contours.outline import ways as polylines_of
from beamcam.planning.contours.repeats import (
    Repeats,
    begun_off_common,
    contours_once,
    in_levels,
    with_joints,
)
from beamcam.planning.contours.tabs import stretches_of

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
    free = [k for k in which if not all(isinstance(c, Line | Arc) for c in shapes[k].curves)]
    if free:
        from beamcam.geometry.arc_fitting import fit_chains

        fits = fit_chains([shapes[k].curves for k in free], torch.tolerance * FIT_SHARE)
        for k, curves in zip(free, fits, strict=True):
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


ROUNDING = 1e-6  #: mm by which an overcut may be shorter

#: The share of a lead that is not asked for its distance, at the contour.
AT_CONTOUR = 0.1

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
    tree: shapely.STRtree,
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


def overcut_length(shape: Shape, torch: Torch) -> float:
    """The overcut that is asked of a contour: of its colour or layer, of small holes, or of all."""
    if shape.process != "cut" or not shape.is_ring:
        return 0.0
    own = torch.settings.get(shape.look, PLAIN).overcut
    if own is None and shape.is_small:
        own = torch.hole_overcut
    return torch.overcut if own is None else own


def overcut(shape: Shape, kerf: float, torch: Torch) -> Curves:
    """The stretch of a closed contour that is cut again at its end, none without an overcut.

    It is at most half of the way to the first bridge, or of the
    contour where there is none.
    """
    length = overcut_length(shape, torch)
    if not length:
        return ()
    first = stretches_of(shape, kerf, torch)[0]
    lengths = [curve.length for curve in first]
    return stretch(first, lengths, 0.0, min(length, sum(lengths) / 2))


def is_shortened(shape: Shape, kerf: float, torch: Torch) -> bool:
    """Whether a contour has too little room for its overcut."""
    length = overcut_length(shape, torch)
    if not length:
        return False
    first = stretches_of(shape, kerf, torch)[0]
    return sum(curve.length for curve in first) / 2 < length - ROUNDING


SAME_CIRCLE = 1e-4  #: mm that arcs of a round hole may be apart


def leads(
    curves: Curves, side: int, torch: Torch, share: float, over: Curves = ()
) -> tuple[Curves, Curves]:
    """Lead-in and lead-out of a closed contour on its waste side, `share` of the machine's length.

    The lead-out begins at the end of the overcut, `over`. A line comes square to the contour; an
    arc is a quarter circle that is tangent to it.

          |  line            .-  arc
          v                 (
        --o--->           --o--->
    """
    start, last = curves[0].start, (over or curves)[-1]
    return (
        _lead(start, curves[0].tangent(0.0), side, torch, torch.lead_in * share, False),
        _lead(last.end, last.tangent(1.0), side, torch, torch.lead_out * share, True),
    )


def from_middle(curves: Curves) -> Curves:
    """Lead-in of a round hole: half a circle from its middle, tangent to it; none of another."""
    first, *others = curves
    if not isinstance(first, Arc) or not all(_is_of(first, other) for other in others):
        return ()
    (x, y), (mx, my) = first.start, first.centre
    half = Arc(
        ((x + mx) / 2, (y + my) / 2), first.radius / 2, first.start_deg - 180.0,
        180.0 if first.sweep_deg > 0.0 else -180.0,
    )  # fmt: skip
    return (half,)


def _is_of(arc: Arc, other: Curve) -> bool:
    """Whether another curve lies on the circle of an arc."""
    return (
        isinstance(other, Arc)
        and dist(arc.centre, other.centre) <= SAME_CIRCLE
        and abs(arc.radius - other.radius) <= SAME_CIRCLE
    )


def _lead(
    at: Point, tangent: Point, side: int, torch: Torch, length: float, is_out: bool
) -> Curves:
    if torch.lead == "none" or length <= 0.0:
        return ()
    normal = (-side * tangent[1], side * tangent[0])
    if torch.lead == "line":
        far = (at[0] + length * normal[0], at[1] + length * normal[1])
        return (Line(at, far) if is_out else Line(far, at),)
    radius = length / (pi / 2)
    centre = (at[0] + radius * normal[0], at[1] + radius * normal[1])
    at_contour = direction_deg((-normal[0], -normal[1]))
    sweep = 90.0 * side
    return (Arc(centre, radius, at_contour if is_out else at_contour - sweep, sweep),)
