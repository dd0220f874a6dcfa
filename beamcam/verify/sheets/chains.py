"""Strokes that go round several parts, taken apart at the links between them.

pierce, lead    outline     link      outline     lead-out
    . . . . .==============- - - - -==============. . . .
             first stroke            second stroke

Found in the path alone: a stroke that has come back to a corner which it passed, and goes on by one
straight move to a place from which it comes back again. A link lies in waste: nearer to no contour
than half a kerf, and to nothing that is cut before or later than by a whole one, but for the two
contours at its ends.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic, Source
from beamcam.machine.torch import Torch
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.need import Need
from beamcam.verify.sheets.strokes import HeadStroke, Strokes

LONGER = 1.001  #: by which a link may be longer than asked, as its ends are rounded
CLOSED = 0.25  #: share of a link behind each of its ends where the cut there is still open


class Link(Struct, frozen=True):
    """The way from one part to the next, with the tool on."""

    line: int  #: of the program
    start: tuple[float, float]
    end: tuple[float, float]
    before: int  #: the stroke that it leaves; the next is the one that it leads to


def unchained(strokes: Strokes, torch: Torch, step: float) -> tuple[Strokes, list[Link]]:
    """The strokes of single parts, and the links between them, where the machine's file has any."""
    if not torch.chain_cuts:
        return strokes, []
    each: list[HeadStroke] = []
    links: list[Link] = []
    kept = np.ones(len(strokes.moves), dtype=bool)
    for one in strokes.each:
        ends = _links(strokes.moves, one, step) if one.process == "cut" else []
        bounds = [one.first, *(k for at in ends for k in (at, at + 1)), one.last]
        for number, (first, last) in enumerate(zip(bounds[::2], bounds[1::2], strict=True)):
            line = one.line if not number else int(strokes.moves.line[first])
            each.append(
                replace(
                    one, line=line, first=first, last=last, is_linked=number > 0,
                    goes_on=number < len(ends), dark=0 if number < len(ends) else one.dark,
                )
            )  # fmt: skip
            if number < len(ends):
                kept[last] = False
                start, end = (strokes.moves.start[last].tolist(), strokes.moves.end[last].tolist())
                line = int(strokes.moves.line[last])
                links.append(Link(line, tuple(start), tuple(end), len(each) - 1))
    if not links:
        return strokes, []
    place = np.concatenate(([0], np.cumsum(kept)))
    moved = [replace(s, first=int(place[s.first]), last=int(place[s.last])) for s in each]
    return Strokes(moved, strokes.moves.take(np.flatnonzero(kept))), links


def _links(moves: Moves, stroke: HeadStroke, step: float) -> list[int]:
    """The moves of a stroke that lead from a ring which has closed to the next one."""
    own = range(stroke.first, stroke.last)
    corners = [moves.start[own.start].tolist(), *moves.end[own.start : own.stop].tolist()]
    cells = [(round(x / (2 * step)), round(y / (2 * step))) for x, y in corners]
    again = {cell: k for k, cell in enumerate(cells)}  # the last time that each is passed
    found: list[int] = []
    passed: dict[tuple[int, int], int] = {}
    for k, cell in enumerate(cells[:-1]):
        is_back = cell in passed
        passed[cell] = k
        begins = cells[k + 1]
        leads_on = begins not in passed and again[begins] > k + 1 and not moves.is_arc[own[k]]
        if is_back and leads_on:
            found.append(own[k])
    return found


def link_faults(
    links: Sequence[Link],
    strokes: Strokes,
    need: Need,
    torch: Torch,
    shift: tuple[float, float],
    name: str,
) -> Iterator[Diagnostic]:
    """Links that are too long, touch a part, or run into what is cut."""
    if not links:
        return
    fine = torch.tolerance / 8
    kerf = max((one.row.kerf for one in strokes.each if one.process == "cut"), default=0.0)
    points, begins = need.toolpaths("cut", fine).moved(shift).outlines(fine)
    owner = np.repeat(np.arange(len(begins) - 1), np.diff(begins))
    parts = shapely.STRtree(shapely.linestrings(points, indices=owner))
    paths = [_way(strokes.moves, one) for one in strokes.each]
    tree = shapely.STRtree(paths)
    slack = torch.tolerance + 2 * fine
    for link in links:
        line = shapely.LineString([link.start, link.end])
        ends = (link.before, link.before + 1)
        inner = shapely.LineString(
            [line.interpolate(at, normalized=True) for at in (CLOSED, 1 - CLOSED)]
        )
        others = {*tree.query(line, "dwithin", distance=kerf - slack).tolist()} - {*ends}
        crossed = [k for k in ends if inner.intersects(paths[k])]
        found = expected = ""
        if line.length > torch.chain_cuts * LONGER:
            found, expected = f"{line.length:.3f} mm long", f"at most {torch.chain_cuts:g} mm"
        elif len(parts.query(line, "dwithin", distance=kerf / 2 - slack)):
            found, expected = f"nearer to a contour than {kerf / 2:g} mm", "it in waste"
        elif others or crossed:
            other = strokes.each[min(others or crossed)].line
            found, expected = f"across the cut of line {other}", "metal all along it"
        if found:
            (x0, y0), (x1, y1) = link.start, link.end
            yield rules.LINK.at(
                Source(name, link.line), x0=f"{x0:.3f}", y0=f"{y0:.3f}", x1=f"{x1:.3f}",
                y1=f"{y1:.3f}", found=found, expected=expected,
            )  # fmt: skip


def _way(moves: Moves, stroke: HeadStroke) -> shapely.LineString:
    """The corners of a stroke, and the middles of its arcs."""
    own = slice(stroke.first, stroke.last)
    places = [moves.start[stroke.first].tolist()]
    for end, is_arc, (x, y, radius, first, sweep) in zip(
        moves.end[own].tolist(), moves.is_arc[own].tolist(), moves.arcs[own].tolist(), strict=True
    ):
        if is_arc:
            turns = np.radians(first + sweep * np.linspace(0.0, 1.0, 33)[1:-1])
            places += np.column_stack(
                (x + radius * np.cos(turns), y + radius * np.sin(turns))
            ).tolist()
        places.append(end)
    return shapely.LineString(places)
