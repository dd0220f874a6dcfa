"""Contours in order of work, each with its kerf side, its leads and its bridges.

shapes -> half a kerf off the part -> in order -> turned and begun -> with leads -> bridged
"""

from collections.abc import Iterator, Sequence
from math import ceil, dist, pi
from typing import Literal

from msgspec.structs import replace

from beamcam.errors import Diagnostic, errors_in
from beamcam.geometry.arrays import CurveTable, overlapping
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.model.lengths import total_length
from beamcam.model.plan import HATCH, SKELETON, ContourOp, Pass
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import OUTLINE
from beamcam.planning.contours.chain import Way, chained
from beamcam.planning.contours.entry import entries
from beamcam.planning.contours.kerf import NO_LEADS, Lead, compensated, leads_of, overcut_length
from beamcam.planning.contours.order import order, rank
from beamcam.planning.contours.outline import (
    Curves,
    Shape,
    begun,
    is_turned,
    reversed_chain,
    stretch,
    waste_side,
)
from beamcam.planning.contours.plate import SheetMaterial, moved
from beamcam.planning.contours.repeats import common_cuts
from beamcam.planning.contours.tabs import joint_in_bridge, needs_tabs, pieces_of

LAST = 1 << 20  #: level of what is cut when all parts are
SHOWN_OPEN = 10  #: open contours are named one by one up to so many
MOST_GAP = 2.0  #: mm between ends that may be meant to meet


def operations_of(
    shapes: Sequence[Shape], material: SheetMaterial, torch: Torch, shift: Point, share: bool
) -> tuple[tuple[ContourOp, ...], list[Diagnostic]]:
    """The work on the shapes, moved by `shift`, and remarks; no work if one is an error.

    `share` says that contours share edges, which are cut once.
    """
    kerfs = [material.kerf(s.process) if s.is_ring else 0.0 for s in shapes]
    shapes = [_as_drawn(shape, material) for shape in shapes]
    ready, diagnostics = compensated(shapes, kerfs, torch)
    diagnostics += _open_cuts(shapes, 0.0 if torch.allow_open else material.kerf("cut"))
    if errors_in(diagnostics):
        return (), diagnostics
    fence = moved(shapes, shift) if any(kerfs) else None
    ready = moved(ready, shift)
    # Without a kerf nothing is looked for unless contours share edges.
    if torch.kerf_by != "machine" and (share or any(kerfs)):
        table = CurveTable([curve for shape in ready for curve in shape.curves])
        if overlapping(table, [shape.process for shape in ready for _ in shape.curves]):
            ready, kerfs, common = common_cuts(ready, kerfs, torch)
            diagnostics += common
    ways = [(shape, kerfs[k]) for k, shape in _in_order(ready, kerfs, torch)]
    links: dict[int, Line] = {}
    if torch.chain_cuts and torch.kerf_by == "offset":
        rows = [material.row_for(shape.process, shape.look) for shape, _ in ways]
        ways, links = chained(ways, rows, torch, fence or ready)
    leads, more = _with_leads(ways, material, torch, fence or ready)
    diagnostics += more
    contour_ops = [
        _operation(shape, kerf, material, torch, lead, links.get(k), k + 1 in links)
        for k, (shape, kerf, lead) in enumerate(leads)
    ]
    if torch.tabs:
        short = sum(
            len(op.passes) != (torch.tabs + 1) * op.row.passes
            for op, (shape, _) in zip(contour_ops, ways, strict=True)
            if needs_tabs(shape, torch)
        )
        if short:
            diagnostics.append(rules.NO_TABS.at(ways[0][0].source, count=short, found=torch.tabs))
        for shape, kerf, _ in leads:
            if (joint := joint_in_bridge(shape, kerf, torch)) is not None:
                place = rules.at_place((joint[0] - shift[0], joint[1] - shift[1]))
                width = f"{torch.tab_width:g}"
                diagnostics.append(rules.TAB_JOINT.at(shape.source, found=width, **place))
    short_over = [
        shape for k, (shape, kerf, _) in enumerate(leads)
        if k + 1 not in links and (length := overcut_length(shape, torch))
        and total_length(pieces_of(shape, kerf, torch)[0]) / 2 < length - ROUNDING
    ]  # fmt: skip
    if short_over:
        first, length = short_over[0], overcut_length(short_over[0], torch)
        diagnostics.append(
            rules.OVERCUT.at(first.source, count=len(short_over), found=f"{length:g}")
        )
    return tuple(contour_ops), diagnostics


def _as_drawn(shape: Shape, material: SheetMaterial) -> Shape:
    """A contour with what has to be known of it as it is drawn: its level, and small holes."""
    if shape.source.where == SKELETON:
        shape = replace(shape, level=LAST)
    if shape.process == "cut" and shape.is_ring and shape.is_hole:
        row = material.row_for("cut", shape.look)
        if row is not None and row.hole_diameter:
            is_small = total_length(shape.curves) < pi * row.hole_diameter
            return replace(shape, is_small=True) if is_small else shape
    return shape


def _with_leads(
    ways: Sequence[Way], material: SheetMaterial, torch: Torch, fence: Sequence[Shape]
) -> tuple[list[tuple[Shape, float, Lead]], list[Diagnostic]]:
    """The toolpaths with their leads, and a remark on shortened ones.

    By offset; where the controller keeps off, from their entries, with errors for those without.
    """
    shapes, kerfs = [shape for shape, _ in ways], [kerf for _, kerf in ways]
    if torch.kerf_by != "machine":
        half = max(kerfs, default=0.0) / 2 if torch.kerf_by == "offset" else 0.0
        overs = [overcut(shape, own, torch) for shape, own in ways]
        row = material.row("cut")
        far = row.pierce_radius if row else 0.0
        leads, diagnostics = leads_of(shapes, overs, torch, half, far, fence)
        return [(*way, leads.get(k, NO_LEADS)) for k, way in enumerate(ways)], diagnostics
    begun_at, diagnostics = entries(shapes, kerfs, torch, fence)
    entered: list[tuple[Shape, float, Lead]] = [(*way, NO_LEADS) for way in ways]
    for k, (curves, lead) in begun_at.items():
        entered[k] = replace(shapes[k], curves=curves), kerfs[k], lead
    if torch.tabs and begun_at:
        diagnostics.append(rules.MACHINE_TABS.at(ways[0][0].source, found=torch.tabs))
    return entered, diagnostics


def _in_order(
    shapes: Sequence[Shape], kerfs: Sequence[float], torch: Torch
) -> Iterator[tuple[int, Shape]]:
    """The shapes by index in order of work, each with its direction and its start.

    Those that the controller compensates get their start with their entry.
    """
    here: Point = (0.0, 0.0)
    # Lines of a hatch may be followed as they are drawn alone.
    one_way = {key for key, own in torch.settings.items() if own.hatch_one_way}
    fixed = [s.process == "spot" or (s.look in one_way and s.source.where == HATCH) for s in shapes]
    # The outlines of a chain follow one another when all that lies in them is cut.
    last = [bool(torch.chain_cuts) and s.process == "cut" and s.depth == 0 for s in shapes]
    ranks = [2 * rank(s, torch) + is_last for s, is_last in zip(shapes, last, strict=True)]
    for index, turned in order(shapes, ranks=ranks, fixed=fixed):
        shape = shapes[index]
        if shape.closed:
            if shape.process == "cut" and is_turned(shape.area, shape.is_hole, torch):
                shape = replace(shape, curves=reversed_chain(shape.curves), area=-shape.area)
            is_pierced = shape.process == "cut" and not (
                torch.kerf_by == "machine" and kerfs[index]
            )
            if not shape.is_begun:
                shape = replace(shape, curves=begun(shape.curves, torch, here, is_pierced))
        elif turned and not fixed[index]:
            shape = replace(shape, curves=reversed_chain(shape.curves))
        yield index, shape
        here = shape.curves[-1].end


def _operation(
    shape: Shape, kerf: float, material: SheetMaterial, torch: Torch, lead: Lead, link: Line | None,
    goes_on: bool,
) -> ContourOp:  # fmt: skip
    """The operation of one contour, with as many bridges as there is room for.

    A `link` leads to it from the contour before with the torch on; one that `goes_on` to the next
    has no way off.
    """
    lead = (link,) if link else lead[0], () if goes_on else lead[1]
    row = material.row_for(shape.process, shape.look)
    if row is None:
        raise AssertionError("a process without a row was let through")
    side: Literal["on", "left", "right"] = "on"
    pieces = pieces_of(shape, kerf, torch)
    if torch.kerf_by == "machine" and kerf:
        side = "left" if waste_side(shape.area, shape.is_hole) > 0 else "right"
    over = () if goes_on or side != "on" else overcut(shape, kerf, torch)
    again = len(over) if side == "on" else len(lead[1])
    beyond, last = (*over, *lead[1]), len(pieces) - 1
    passes = tuple([
        Pass(() if k else lead[0], curves, *((beyond, again) if k == last else ((), 0)))
        for k, curves in enumerate(pieces) for _ in range(row.passes)
    ])  # fmt: skip
    features = tuple([(0, f) for f in shape.features if f != OUTLINE])
    return ContourOp(
        row, passes, shape.closed, shape.depth, side, kerf, features, shape.source,
        row.hole_feed_share if shape.is_small else 1.0, link is not None,
    )  # fmt: skip


def _open_cuts(shapes: Sequence[Shape], kerf: float) -> Iterator[Diagnostic]:
    """Open contours to cut: errors where a kerf is compensated and they are not asked for."""
    opened = [
        s for s in shapes if s.process == "cut" and not s.closed and s.source.where != SKELETON
    ]
    for shape in opened[:SHOWN_OPEN]:
        ends = shape.curves[0].start, shape.curves[-1].end
        apart = dist(*ends)
        (x0, y0), (x1, y1) = ((f"{x:.3f}", f"{y:.3f}") for x, y in ends)
        places = {"x0": x0, "y0": y0, "x1": x1, "y1": y1}
        if kerf:
            how = "--allow-open cuts it on its line"
            if apart <= MOST_GAP:
                how = f"--gap {ceil(apart * 100) / 100:g} joins its ends, {how}"
            yield rules.OPEN_KERF.at(
                shape.source, apart=f"{apart:.3f}", kerf=f"{kerf:g}", how=how, **places
            )
        else:
            yield rules.OPEN_CUT.at(shape.source, apart=f"{apart:.3f}", **places)
    if len(opened) > SHOWN_OPEN:
        yield rules.MORE_OPEN.at(opened[SHOWN_OPEN].source, found=len(opened) - SHOWN_OPEN)


ROUNDING = 1e-6  #: mm by which an overcut may be shorter


def overcut(shape: Shape, kerf: float, torch: Torch) -> Curves:
    """What of a closed contour is cut again at its end, none without an overcut.

    It is at most half of the way to the first bridge, or of the
    contour where there is none.
    """
    length = overcut_length(shape, torch)
    if not length:
        return ()
    first = pieces_of(shape, kerf, torch)[0]
    lengths = [curve.length for curve in first]
    return stretch(first, lengths, 0.0, min(length, sum(lengths) / 2))
