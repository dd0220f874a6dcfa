"""Kerf compensation: contours offset by half a kerf, or left to the controller; their leads."""

from collections.abc import Iterator, Sequence
from math import cos, dist, pi

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.arrays import CurveTable, unit_vectors
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Line, join_boxes
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.left_waste import (
    REPORTED,
    Left,
    left_diagnostics,
    left_in,
    uncompensated,
)
from beamcam.planning.contours.order import PLAIN
from beamcam.planning.contours.outline import Curves, Shape, entity, waste_side
from beamcam.planning.contours.outline import ways as polylines_of

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
        k for k, shape in enumerate(shapes)
        if kerfs[k] or (by_machine and shape.process == "cut" and shape.closed)
    ]  # fmt: skip
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
    wide = [n for n in near if n.width >= kerfs[n.shape] - torch.tolerance]
    rounded = {k for n in wide for k in (n.shape, n.other) if kerfs[k]}
    if rounded and not by_machine:
        for k, path in _moved(offset_shapes, sorted(rounded), kerfs, torch, [], mitre_limit=0.0):
            paths[k] = path
        near = too_near(shapes, paths, kerfs, torch)
    for n in near:
        own, other = shapes[n.shape].source, entity(shapes[n.other].source)
        widths = {"found": f"{n.width:.3f}", "kerf": f"{kerfs[n.shape]:g}"}
        diagnostics.append(rules.NEAR.at(own, other=other, **widths, **rules.at_place(n.place)))
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
            x0, y0, x1, y1 = join_boxes([c.bbox for c in shape.curves]) or (0.0, 0.0, 0.0, 0.0)
            size = f"{x1 - x0:.3g} x {y1 - y0:.3g}"
            diagnostics.append(rules.VANISHED.at(shape.source, found=size, kerf=f"{kerf:g}"))
            yield k, None
            continue
        area, ring = max(zip(offset.areas, offset.chains, strict=True), key=lambda one: abs(one[0]))
        if torch.kerf_by == "machine" and not offset.exact:
            diagnostics.append(uncompensated(shape, kerf))
        path = replace(shape, curves=ring, area=area)
        others = [chain for chain in offset.chains if chain is not ring]
        left = sharp if offset.exact else left_in(shape, path, kerf, torch.tolerance, others)
        if left:
            diagnostics += left_diagnostics(shape, left, kerf)
        yield k, path


class Near(Struct, frozen=True):
    """A contour that the cut along another one enters."""

    shape: int  #: that is cut
    other: int
    width: float  #: of the waste between both, where it is least
    place: Point


def too_near(
    shapes: Sequence[Shape], paths: Sequence[Shape | None], kerfs: Sequence[float], torch: Torch
) -> list[Near]:
    """The contours that cuts along others enter, each pair once.

    `paths` are those of the beam's middle along the shapes, `kerfs` the widths of the cuts.
    """
    moved = [k for k, kerf in enumerate(kerfs) if kerf and paths[k] is not None]
    fence = [k for k, s in enumerate(shapes) if s.process == "cut" and s.closed]
    if not moved or len(fence) < 2:
        return []
    fine = torch.tolerance / 4
    lines = polylines_of([shapes[k].curves for k in fence], fine)
    middles = polylines_of([path.curves for k in moved if (path := paths[k])], fine)
    radius = max(kerfs) / 2
    near, hit = shapely.STRtree(lines).query(middles, "dwithin", distance=radius - torch.tolerance)
    of_shape = dict(zip(fence, lines.tolist(), strict=True))
    pairs: dict[tuple[int, int], Near] = {}
    for a, b in sorted(zip(near.tolist(), hit.tolist(), strict=True)):
        k, other = moved[a], fence[b]
        pair = min(k, other), max(k, other)
        if k != other and pair not in pairs:
            shortest = shapely.shortest_line(of_shape[k], lines[b])
            x, y = shapely.get_coordinates(shortest).mean(axis=0).tolist()
            pairs[pair] = Near(k, other, shortest.length, (x, y))
    return list(pairs.values())


def sharp_corners(shapes: Sequence[Shape], kerfs: Sequence[float]) -> list[list[Left]]:
    """Material that the beam leaves in the corners of each contour that point into the part.

    Between walls at an angle `a` a disc of radius r touches both and stays r (1 / sin(a / 2) - 1)
    off the corner.
    """
    table = CurveTable([curve for shape in shapes for curve in shape.curves])
    sizes = np.array([len(shape.curves) for shape in shapes], dtype=np.int64)
    begins = np.cumsum(sizes) - sizes
    owner = np.repeat(np.arange(len(shapes)), sizes)
    following = np.arange(len(table.curves)) + 1
    following[begins + sizes - 1] = begins
    # Directions of lines and arcs at their ends and at their starts.
    a, starts = np.zeros((len(table.curves), 2)), np.zeros((len(table.curves), 2))
    step, arcs = table.lines[:, 2:] - table.lines[:, :2], table.arcs
    unit = step / np.maximum(np.hypot(step[:, 0], step[:, 1]), 1e-300)[:, None]
    a[table.where(Line)] = starts[table.where(Line)] = unit
    quarter = np.where(arcs[:, 4] > 0.0, 90.0, -90.0)
    starts[table.where(Arc)] = unit_vectors(arcs[:, 3] + quarter)
    a[table.where(Arc)] = unit_vectors(arcs[:, 3] + arcs[:, 4] + quarter)
    b = starts[following]
    turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.sum(a * b, axis=1))
    # On a ring that runs counter-clockwise the waste of a hole lies left, that of an outline right.
    left = np.array([1.0 if (s.area > 0.0) == s.is_hole else -1.0 for s in shapes])
    inward = np.clip(turn * left[owner], 0.0, pi - 1e-6)
    depth = np.array(kerfs)[owner] / 2 * (1 / np.cos(inward / 2) - 1)
    corners: list[list[Left]] = [[] for _ in shapes]
    for k in np.flatnonzero(depth > REPORTED * np.array(kerfs)[owner]).tolist():
        x, y = table.ends[k, 2:].tolist()
        width = kerfs[owner[k]] * cos((pi - float(inward[k])) / 2)
        corners[owner[k]].append(Left((x, y), width, float(depth[k]), True))
    return [sorted(one, key=lambda left: -left.depth) for one in corners]


# --- leads ----------------------------------------------------------------------------------------

# Leads that stay in the waste: shortened, or left out, where a contour is too narrow for them.

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
    ways_out: dict[int, Curves] = {}
    short: set[int] = set()
    if torch.hole_lead == "middle":
        small = (k for k in which if ways[k].is_small)
        round_ones = {k: curves for k in small if (curves := from_middle(ways[k].curves))}
        kept = _clear_of(tree, round_ones, False, torch.tolerance, clearance, 0.0)
        ways_in |= {k: round_ones[k] for k in kept}
    # Each for itself, so that a way out without room does not shorten the way in.
    for those, is_out, far in (
        (ways_in, False, max(pierce_radius, off_path)), (ways_in, False, off_path),
        (ways_out, True, off_path),
    ):  # fmt: skip
        for share in SHARES:
            tried = {
                k: _lead(ways[k].curves, overs[k], sides[k], torch, share, is_out)
                for k in which
                if k not in those
            }
            kept = _clear_of(tree, tried, is_out, torch.tolerance, clearance, far)
            if share == SHARES[0]:
                short |= tried.keys() - kept
            those |= {k: tried[k] for k in kept}
    both = {k: (ways_in.get(k, ()), ways_out.get(k, ())) for k in which}
    if not short:
        return both, []
    first = ways[min(short)].source
    return both, [rules.NO_LEAD.at(first, count=len(short), found=f"{torch.lead_in:g}")]


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


SAME_CIRCLE = 1e-4  #: mm that arcs of a round hole may be apart


def from_middle(curves: Curves) -> Curves:
    """Lead-in of a round hole: half a circle from its middle, tangent to it; none of another."""
    first, *others = curves
    if not isinstance(first, Arc) or not all(
        isinstance(other, Arc) and dist(first.centre, other.centre) <= SAME_CIRCLE
        and abs(first.radius - other.radius) <= SAME_CIRCLE
        for other in others
    ):  # fmt: skip
        return ()
    (x, y), (mx, my) = first.start, first.centre
    half = Arc(
        ((x + mx) / 2, (y + my) / 2), first.radius / 2, first.start_deg - 180.0,
        180.0 if first.sweep_deg > 0.0 else -180.0,
    )  # fmt: skip
    return (half,)


def _lead(
    curves: Curves, over: Curves, side: int, torch: Torch, share: float, is_out: bool
) -> Curves:
    """Lead-in or lead-out of a closed contour on its waste side, `share` of the machine's length.

    The lead-out begins at the end of the overcut, `over`. A line comes square to the contour; an
    arc is a quarter circle that is tangent to it.

          |  line            .-  arc
          v                 (
        --o--->           --o--->
    """
    curve, t = ((over or curves)[-1], 1.0) if is_out else (curves[0], 0.0)
    at, tangent = (curve.end if is_out else curve.start), curve.tangent(t)
    length = share * (torch.lead_out if is_out else torch.lead_in)
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
