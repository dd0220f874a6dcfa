r"""Programs of cutting tables read back and compared with the sheet that they should make.

Written from the controllers' documentation and the machine file; nothing is shared with planning,
motion or the emitters.

    text -> events (controllers) -> strokes -> compared with the contours

    waste            *  pierce                  r  half the kerf
                     :  lead
    - - - - - - - - -o- - - - -     - - - -     path of the beam's middle, r off its contour; it
         |r            over         bridge      is on its curve if that is open or marked
    ______________________________________      contour
    part      \    /
               \  /  rest of waste: the beam does not come into the corner

region     closed contours, as `joining` has them, part the sheet into part and waste (`region`)
tracing    a stroke without its leads goes round one closed contour, by itself or with others and
           bridges between (`tracing`); all else is asked of that contour
areas      the beam takes nothing of the part, its leads neither (`leads`); what it does not reach
           is a corner of the waste (`areas`)
paths      each path runs along a contour but for its leads, and each stretch of a contour has a
           path, and one only, but for bridges (`paths`)
tabs       the bridges are as many and as wide as asked, at places that hold the part (`tabs`)
overcut    a stroke goes on beyond its start as far as asked; open ones end where contours do
leads      the torch pierces where it does no harm, small holes in their middle
direction  a closed cut goes round as it is drawn, or with the material at the right side
settings   each is worked as its colour or layer asks, and in that order (`settings`)
order      no contour is cut after one around it, none marked after a cut

A controller that keeps off the contour by itself changes nothing but the path (`compensation`).
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import shapely
from msgspec.structs import replace

from beamcam.checks.job import head_of, part_faults, stock_faults
from beamcam.checks.sheets import leads, marks, rules
from beamcam.checks.sheets.asked_sheet import rows_of, thickness_of
from beamcam.checks.sheets.compensation import beam_of
from beamcam.checks.sheets.controller_state import Outputs, radius_faults
from beamcam.checks.sheets.heights import HeightWatch
from beamcam.checks.sheets.need import Need, need_of, shift_of
from beamcam.checks.sheets.overcut import dark_faults, overcut_faults
from beamcam.checks.sheets.paths import cover, follow
from beamcam.checks.sheets.region import Region
from beamcam.checks.sheets.remainder import link_faults, passes_folded, unchained
from beamcam.checks.sheets.required_layout import SKELETON, as_one
from beamcam.checks.sheets.settings import setting_faults
from beamcam.checks.sheets.strokes import Strokes, is_far, strokes_of
from beamcam.checks.sheets.tabs import tab_faults
from beamcam.checks.sheets.tracing import Traced
from beamcam.checks.sheets.work import SHOWN, Work, with_own_rows, work_of
from beamcam.controllers import table_run
from beamcam.controllers.events import Lift, Touch, Zero
from beamcam.controllers.moves import Moves, TableRun
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.part import Part, TextMark


def verify_sheet(
    text: str, parts: Sequence[Part], machine: Machine, skips: Collection[str] = (),
    name: str = "program", head: str = "",
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """All faults of a program, by itself and against the part of its sheet.

    `skips` are the kinds of features that may be missing, as `--allow-skips` names them; `head` is
    the text whose head has to say where sound parts lie, if one has to. Nothing comes back for a
    program that makes exactly the part. Raises TypeError for a machine without a torch.
    """
    torch = machine.needed(machine.torch, "torch")
    done, diagnostics = table_run(text, machine, name)
    diagnostics = [*diagnostics, *radius_faults(done.moves, machine, torch, name)]
    if errors_in(diagnostics) or not parts:
        return tuple(diagnostics)
    given, sheet = machine, as_one(parts, machine, skips)
    part, machine = sheet.part, sheet.machine
    torch, diagnostics = machine.torch or torch, [*diagnostics, *sheet.diagnostics]
    rows = rows_of(part, torch)
    torch = torch.by(next((row for row in rows if row.process == "cut"), None))
    machine = machine if torch is machine.torch else replace(machine, torch=torch)
    strokes, more = strokes_of(done, machine, torch, rows, name)
    diagnostics += more
    diagnostics += switching_faults(done, strokes, machine, torch, name)
    if is_far(strokes.moves, torch):
        return tuple(diagnostics)
    if any(row.passes > 1 for row in rows):
        strokes = passes_folded(strokes, rows)
    need = need_of(part, machine, torch, skips)
    shift = shift_of(need, torch)
    strokes = with_own_rows(strokes, need, torch, shift)
    if torch.chain_cuts:
        strokes, links = unchained(strokes, torch, machine.format.resolution)
        diagnostics += link_faults(links, strokes, need, torch, shift, name)
    places = sheet.places or ([shift] if need.curves else [])
    diagnostics += compare_part(strokes, need, part, machine, torch, name)
    add_contours(diagnostics, done.moves, need, shift, torch.tolerance / 8)
    return with_head_faults(diagnostics, head, parts, places, given, skips, name)


def switching_faults(
    run: TableRun, strokes: Strokes, machine: Machine, torch: Torch, name: str
) -> list[Diagnostic]:
    """What is wrong with where the torch stands, what holds it there, and with its outputs."""
    watches: list[HeightWatch | Outputs] = [Outputs(machine, name)]
    in_z = any(
        isinstance(event, Lift | Touch | Zero) or getattr(event, "name", "") == "thc"
        for _, event in run.others
    )
    if in_z or torch.z == "program" or torch.thc == "program" or not torch.thc_slow:
        watches.insert(0, HeightWatch(run.moves, machine, torch, name))
    starts = {stroke.on: stroke for stroke in strokes.each}
    stops = {stroke.off for stroke in strokes.each}
    for watch in watches:
        done, line = 0, 1
        for place, (before, event) in enumerate(run.others):
            if before > done:
                watch.moves(done, before)
            done, line = before, event.line
            if place in starts:
                watch.starts(line, starts[place].row, starts[place].tool)
            elif place in stops:
                watch.stops(line)
            watch.take(event)
        if len(run.moves) > done:
            watch.moves(done, len(run.moves))
        watch.ends(line)
    return [one for watch in watches for one in watch.diagnostics]


def compare_part(
    strokes: Strokes, need: Need, part: Part, machine: Machine, torch: Torch, name: str,
    stepped: bool = False,
) -> list[Diagnostic]:  # fmt: skip
    """All differences of the strokes from a part with its texts, and what its need says itself."""
    if need.spots or any(stroke.process == "spot" for stroke in strokes.each):
        step = machine.format.resolution
        near = torch.tolerance + 2 * step
        need.diagnostics += marks.spot_faults(strokes, need, shift_of(need, torch), near, name)
        strokes = marks.without_spots(strokes)
    if any(isinstance(feature, TextMark) for feature in part.features):
        marks.add_texts(need, part, machine, torch, strokes)
    if not need.curves and not strokes.each:
        return need.diagnostics
    shift = shift_of(need, torch)
    diagnostics: list[Diagnostic] = []
    traced: list[Traced] = []
    works: dict[TorchProcess, Work] = {}
    if torch.kerf_by == "machine":
        strokes, diagnostics = beam_of(strokes, name)
        if diagnostics:
            return need.diagnostics + diagnostics
    processes = dict.fromkeys([*need.curves, *(s.process for s in strokes.each)])
    for process in processes:
        work = work_of(
            process, strokes, need, machine.format.resolution, torch, shift, name, stepped
        )
        works[process] = work
        mine, more = _compared(work)
        diagnostics += [*more, *dark_faults(work, mine, bool(machine.words.close))]
        traced += mine
        if any(own.hatch_one_way for own in torch.settings.values()) and process in need.curves:
            diagnostics += marks.one_way_faults(work)
        if torch.overscan and not stepped:
            diagnostics += marks.overscan_faults(work)
    if torch.settings or any(row.passes > 1 for row in need.rows.values()):
        diagnostics += setting_faults(works, traced, name)
    if any(own.hatch for own in torch.settings.values()):
        diagnostics += marks.hatch_faults(need, torch, name)
    diagnostics += order_faults(sorted(traced, key=lambda t: t.stroke.line), works, name)
    return need.diagnostics + diagnostics


def _compared(work: Work) -> tuple[Sequence[Traced], list[Diagnostic]]:
    """Missing, extra, repeated, open and wrong-side paths of one process."""
    if not work.need.count:
        line, place = work.strokes[0].line, work.moves.start[0]
        values = {"away": "on no contour", "expected": f"nothing to {work.process}"}
        return [], [work.fault(rules.EXTRA, line, place, **values)]
    if not work.strokes:
        which = np.flatnonzero(~work.small)
        return [], [work.missing(k, work.need.starts[k]) for k in which[:1].tolist()]
    traced, diagnostics = follow(work)
    leads.find_small(work, traced)
    diagnostics += cover(work, traced)
    diagnostics += overcut_faults(work, traced)
    diagnostics += leads.direction_faults(work, traced)
    diagnostics += leads.hole_faults(work, traced)
    if work.bridged:
        diagnostics += tab_faults(work, traced)
    if work.half_kerf:
        diagnostics += leads.band_faults(work, traced)
    with_leads = work.torch.lead != "none" and work.torch.kerf_by == "offset"
    if work.half_kerf and with_leads and not work.stepped:
        diagnostics += leads.pierce_faults(work, traced)
        diagnostics += leads.middle_faults(work, traced)
        diagnostics += leads.edge_faults(work, traced)
    return traced, diagnostics


# --- order ----------------------------------------------------------------------------------------

# In which order contours are cut: marks first, and what lies in a contour before it.


TOUCHING = 0.01  #: mm by which a contour may leave the one around it
AT_ONCE = 64  #: rings that are looked at together


def order_faults(
    traced: Sequence[Traced], works: Mapping[TorchProcess, Work], name: str
) -> list[Diagnostic]:
    """Marks behind cuts, and what lies in a contour that was cut before, in the program's order."""

    def fault(t: Traced, found: str, before: str) -> Diagnostic:
        return rules.ORDER.at(Source(name, t.stroke.line), found=found, before=before)

    diagnostics: list[Diagnostic] = []
    first_cut = next((t for t in traced if t.stroke.process == "cut"), None)
    for t in traced:
        if first_cut and t.stroke.process != "cut" and t.stroke.line > first_cut.stroke.line:
            found = f"work to {t.stroke.process} {_contour(works, t)}"
            diagnostics.append(fault(t, found, f"the cut on line {first_cut.stroke.line}"))
            break
    if (behind := _behind_skeleton(traced, works)) is not None:
        cut, part = behind
        before = f"the cut through the skeleton on line {cut.stroke.line}"
        diagnostics.append(fault(part, _contour(works, part), before))
    # An open cut has no inside, and lies in none.
    cuts = [t for t in traced if t.stroke.process == "cut" and t.contour >= 0]
    # What is left of a contour may be cut piece by piece: it holds what lies in it until the last.
    last = {t.contour: t for t in cuts if not (t.closed or t.joined)}
    cuts = [t for t in cuts if t.closed or t.joined or t is last[t.contour]]
    pairs = inside_of_earlier([t.contour for t in cuts], works["cut"].region) if cuts else []
    for a, b in pairs:
        before = f"{_contour(works, cuts[b])} around it, cut on line {cuts[b].stroke.line}"
        diagnostics.append(fault(cuts[a], _contour(works, cuts[a]), before))
    return diagnostics[:SHOWN]


def _behind_skeleton(
    traced: Sequence[Traced], works: Mapping[TorchProcess, Work]
) -> tuple[Traced, Traced] | None:
    """A cut through the skeleton, and a part behind it, which hangs in that; None without any."""
    work = works.get("cut")
    if work is None or not work.torch.skeleton_cuts or not work.need.count:
        return None
    for t in traced:
        if t.stroke.process == "cut" and not t.half_kerf and not t.closed:
            path = (work.path.starts[t.first] + work.path.ends[t.last - 1]) / 2
            _, way = work.need.nearest_to(path)
            later = [
                o for o in traced if o.stroke.line > t.stroke.line and (o.half_kerf or o.closed)
            ]
            if later and work.required.source("cut", way).where == SKELETON:
                return t, later[0]
    return None


def _contour(works: Mapping[TorchProcess, Work], t: Traced) -> str:
    work = works[t.stroke.process]
    if t.contour >= 0:
        return f"the contour of {work.contour(work.region.rings[t.contour][0][0])}"
    return f"the contour of {work.contour_at(work.path.starts[t.first])}"


def inside_of_earlier(contours: Sequence[int], region: Region) -> list[tuple[int, int]]:
    """Pairs of a cut and an earlier one that it lies inside of; `contours` are those of the cuts.

    It may touch that. One that lies on it all round has the same inside, and either may be first.
    Boxes are looked at first: in most programs no contour is in the box of an earlier one. That is
    done for some at a time, so that it takes no more memory the more of them lie above one another.
    """
    polygons = region.polygons[np.array(contours, dtype=np.int64)]
    x0, y0, x1, y1 = shapely.bounds(polygons).reshape(-1, 4).T
    tree = shapely.STRtree(shapely.points((x0 + x1) / 2, (y0 + y1) / 2))
    pairs: list[tuple[int, int]] = []
    for low in range(0, len(contours), AT_ONCE):
        some = slice(low, low + AT_ONCE)
        outer, inner = tree.query(shapely.box(x0[some], y0[some], x1[some], y1[some]))
        outer += low
        later = inner > outer
        for b in sorted(set(outer[later].tolist())):
            own = inner[later & (outer == b)]
            own = own[shapely.covers(shapely.buffer(polygons[b], TOUCHING), polygons[own])]
            same = shapely.covers(shapely.buffer(polygons[own], TOUCHING), polygons[b])
            pairs += [(a, b) for a in own[~same].tolist()]
    return sorted(pairs)


# --- messages -------------------------------------------------------------------------------------


#: Rules that know a line of the program only.
NAMELESS = {
    rule.code for rule in (rules.FEED, rules.RAMP, rules.TOOL, rules.RAPID, rules.IDLE, rules.AREA,
                           rules.COMPENSATION)
}  # fmt: skip


def add_contours(
    diagnostics: list[Diagnostic], moves: Moves, need: Need, shift: Point, fine: float
) -> None:
    """Add the nearest contour to the messages of `NAMELESS`.

    The place of a block that does not move is the end of the next move.
    """
    if not need.curves or not len(moves):
        return
    toolpaths = {process: need.toolpaths(process, fine) for process in need.curves}
    lines = np.maximum.accumulate(moves.line)
    for k, one in enumerate(diagnostics):
        if one.code in NAMELESS and one.source.line is not None:
            row = min(int(np.searchsorted(lines, one.source.line)), len(lines) - 1)
            place = moves.end[row] - np.array(shift)
            _, way, process = min((*toolpaths[p].nearest_to(place), p) for p in toolpaths)
            contour = f", beside the contour of {need.source(process, way)}"
            diagnostics[k] = replace(one, message=one.message + contour)


def with_head_faults(
    diagnostics: Sequence[Diagnostic], head: str, parts: Sequence[Part], places: Sequence[Point],
    machine: Machine, skips: Collection[str], name: str,
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """The faults of a program; of a sound one all differences of its head from the parts as they
    have to lie.

    `places` are those of their x 0, y 0; without them that of a part that is alone is worked out.
    """
    job_head = head_of(head) if head and not errors_in(diagnostics) else None
    if job_head is None or machine.torch is None:
        return tuple(diagnostics)
    thickness = float(thickness_of(parts[0], machine.torch))
    at: Sequence[tuple[float, ...]] = places
    if not places:
        need = need_of(parts[0], machine, machine.torch, skips)
        at = [shift_of(need, machine.torch)]
        if (
            not need.curves and job_head.parts
        ):  # texts alone are found wherever the program has them
            at = [job_head.parts[0].at]
    lie = [*zip(parts, at, strict=True)]
    return (
        *diagnostics, *stock_faults(job_head, parts, thickness, machine, name),
        *part_faults(job_head, lie, machine.torch.tolerance, False, name),
    )  # fmt: skip
