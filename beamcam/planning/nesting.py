"""Parts laid on a bar, and the cuts between them.

    bar x 0                                                                        bar's length
    | front trim |# part 1 ######/|kerf|# part 2 ####|kerf| remnant, dead zone  | end trim |
                 start           end  start

A part's square start is made by the cut that parts it from what lies before it; a skew start or
end gets a mitre of its own, and the square parting cut at the part's greatest x removes the wedge.
Two parts that share an angle need neither wedge nor parting cut: one common cut makes both ends,
and the parts overlap along the bar.

    # part 1 ######/|kerf|    # part 2          # part 1 ######/ /# part 2
    # part 1 #####/ |kerf|  /## part 2          # part 1 #####/ /## part 2
    # part 1 ####/  |kerf| /### part 2          # part 1 ####/ /### part 2
         mitre, parting, mitre                       one common cut

Cuts that stand close are in an order that a machine can follow along X: the mitre that ends a
part, the parting cut behind it, the mitre that starts the next. So a parting cut never stands
before the middle of the mitre that it follows.

A line without a saw gets parts that come in cut: each is a bar by itself.

The order in which parts lie may be free. For each two parts the length that a common cut saves is
known, so the best order is the path through all parts that saves most: exact for few parts
(M. Held, R. M. Karp, A dynamic programming approach to sequencing problems, 1962), and for many a
greedy path, part by part.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise, permutations
from typing import Literal

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError, Rule, Source
from beamcam.machine.machine import Layout, Machine, saw_of
from beamcam.machine.stations import Saw
from beamcam.model.part import Part, Profile
from beamcam.model.plan import Bar, Order, Piece, SawOp
from beamcam.planning import rules
from beamcam.planning.operations.finished_part import Ends, SawnEnd
from beamcam.planning.operations.work import PartWork, saw_angles

EXACT_ORDER = 9  #: parts whose best order is searched for among all
SAME_ANGLE_DEG = 0.01  #: ends that differ by no more share a cut


class BarLayout(Struct, frozen=True):
    """Where parts lie on a bar."""

    starts: tuple[float, ...]  #: x on the bar, mm
    shared: tuple[bool, ...]  #: of each but the last: whether one cut ends it and starts the next
    bar: Bar


class BarRow(Struct, frozen=True):
    """Parts one behind the other from the front of a bar: what the next one has to know."""

    start: float  #: x of the last part on the bar, mm
    last: float  #: its length
    end: SawnEnd
    parts: float  #: sum of the lengths of all
    kerfs: float  #: sum of the kerfs between them
    nested: float  #: by how much they overlap


class LaidParts(Struct, frozen=True):
    """The pieces on one bar, and the work on each."""

    pieces: tuple[Piece, ...]
    works: tuple[PartWork, ...]
    shared: tuple[bool, ...]  #: of each piece but the last, as in `BarLayout`
    bar: Bar
    remarks: tuple[Diagnostic, ...]


def lay(
    works: Sequence[PartWork], machine: Machine, order: Order, length: float | None
) -> LaidParts:
    """The parts laid on a bar of `length`, as they are given or as they nest best.

    Raises PlanError as `lay_on_bar` and, for a line without a saw, `lay_cut_part` do.
    """
    given = list(range(len(works)))
    remarks: tuple[Diagnostic, ...] = ()
    if order == "best" and len(works) > 1:
        given, remarks = best_order(
            [w.part for w in works], [w.ends for w in works], saw_of(machine)
        )
        works = [works[i] for i in given]
    parts = [work.part for work in works]
    if machine.saw is None:
        laid, diagnostics = lay_cut_part(parts, machine)
    else:
        ends = [work.ends for work in works]
        layout = machine.needed(machine.layout, "layout")
        laid, diagnostics = lay_on_bar(parts, ends, layout, machine.saw, length)
    pieces = tuple(map(Piece, parts, laid.starts, given))
    return LaidParts(pieces, tuple(works), laid.shared, laid.bar, remarks + diagnostics)


def lay_on_bar(
    parts: Sequence[Part], ends: Sequence[Ends], layout: Layout, saw: Saw, length: float | None
) -> tuple[BarLayout, tuple[Diagnostic, ...]]:
    """The parts in the order given, where they lie; and remarks about the remnant.

    `length` is the stock bar's; None takes as much as the parts need, or the machine's usual bar
    where that is less than it can hold. Raises PlanError if the parts do not fit, or if the bar or
    a part is shorter or longer than the machine can hold.
    """
    refusals = [
        rules.PART_SHORT.at(p.source, found=f"{p.length:.3f}", expected=f"{layout.min_part:g}")
        for p in parts
        if p.length < layout.min_part
    ]
    if refusals:
        raise PlanError(refusals)
    row = row_of(parts[0], ends[0], layout)
    starts, shared = [row.start], []
    for part, own in zip(parts[1:], ends[1:], strict=True):
        shared.append(share_cut(row.end, own[0], saw))
        row = row_with(row, part, own, saw)
        starts.append(row.start)
    bar = bar_of(row, layout, length, parts[0].source)
    remarks: tuple[Diagnostic, ...] = ()
    if length is not None and bar.remnant >= layout.min_remnant:
        remarks = (rules.REMNANT.at(parts[0].source, found=f"{bar.remnant:.3f}"),)
    return BarLayout(tuple(starts), tuple(shared), bar), remarks


def lay_cut_part(
    parts: Sequence[Part], machine: Machine
) -> tuple[BarLayout, tuple[Diagnostic, ...]]:
    """The only part, which comes in cut and is a bar by itself; and a remark.

    Raises PlanError for several parts, and for one that the machine cannot hold.
    """
    layout = machine.needed(machine.layout, "layout")
    first = parts[0]
    if len(parts) > 1:
        raise PlanError(rules.NO_SAW.at(first.source, found=len(parts), machine=machine.name))
    length, shown = first.length, f"{first.length:.3f}"
    if length < layout.min_bar:
        expected = f"{layout.min_bar:g}"
        raise PlanError(rules.BAR_SHORT.at(first.source, found=shown, expected=expected))
    if layout.max_bar is not None and length > layout.max_bar:
        expected = f"{layout.max_bar:g}"
        raise PlanError(rules.BAR_LONG.at(first.source, found=shown, expected=expected))
    account = Bar(length, 0.0, length, 0.0, 0.0)
    remark = rules.COMES_CUT.at(first.source, found=shown, machine=machine.name)
    return BarLayout((0.0,), (), account), (remark,)


def share_cut(end: SawnEnd, start: SawnEnd, saw: Saw) -> bool:
    """Whether one skew cut can end a part and start the next."""
    return (
        saw.common_cuts
        and not end.is_square
        and abs(end.web_deg - start.web_deg) <= SAME_ANGLE_DEG
        and abs(end.flange_deg - start.flange_deg) <= SAME_ANGLE_DEG
    )


def row_of(part: Part, ends: Ends, layout: Layout) -> BarRow:
    """A part by itself at the front of a bar."""
    return BarRow(layout.front_trim, part.length, ends[1], part.length, 0.0, 0.0)


def row_with(row: BarRow, part: Part, ends: Ends, saw: Saw) -> BarRow:
    """The row with a part behind its last."""
    here, there = row.end, ends[0]
    kerf = max(here.kerf, there.kerf)
    start = row.start + row.last + kerf
    nested = row.nested
    if share_cut(here, there, saw):
        nested_start = row.start + here.x0 + kerf - there.x0
        nested += start - nested_start
        start = nested_start
    return BarRow(start, part.length, ends[1], row.parts + part.length, row.kerfs + kerf, nested)


def bar_of(row: BarRow, layout: Layout, length: float | None, source: Source) -> Bar:
    """The account of a bar that holds a row. Raises PlanError as `lay_on_bar` does."""
    kerfs = row.kerfs + row.end.kerf
    used = layout.front_trim + row.parts + kerfs - row.nested + layout.end_trim
    needed, held = used + layout.dead_zone, row.start + layout.min_bar_left

    def refused(rule: Rule, found: float, expected: float) -> PlanError:
        shown = f"{expected:.3f}" if rule is rules.BAR_FULL else f"{expected:g}"
        return PlanError(rule.at(source, found=f"{found:.3f}", expected=shown))

    if length is not None and needed > length + 1e-6:
        raise refused(rules.BAR_FULL, needed, length)
    whole = needed if length is None else length
    if length is None and needed < layout.min_bar:
        whole = max(needed, layout.default_bar)
    if whole < layout.min_bar:
        raise refused(rules.BAR_SHORT, whole, layout.min_bar)
    if length is None:
        whole = max(whole, held)
    elif held > length + 1e-6:
        raise refused(rules.BAR_LEFT, length - row.start, layout.min_bar_left)
    if layout.max_bar is not None and whole > layout.max_bar:
        raise refused(rules.BAR_LONG, whole, layout.max_bar)
    remnant = max(0.0, whole - used)
    return Bar(whole, layout.front_trim, row.parts, kerfs, remnant, row.nested, layout.end_trim)


NOTHING_LEFT = 1e-6  #: mm
#: Explanations of cuts: stable code and text.
CUT_REASONS = {
    "cut-trim": "the bar's front is sawn square, since no cut comes before it",
    "cut-mitre-start": "the part starts skew",
    "cut-mitre-end": "the part ends skew",
    "cut-common": "two parts share the angle, so one cut ends the one and starts the other",
    "cut-parting": "parts the piece from the bar, behind its square end",
    "cut-parting-both": "parts the piece from the bar and gives the next one its square start",
    "cut-wedge": "takes the wedge of the mitre off the bar",
}


def cuts_of(
    pieces: Sequence[Piece], ends: Sequence[Ends], shared: Sequence[bool], saw: Saw, bar: Bar
) -> Iterator[SawOp]:
    """The cuts that give every piece its ends, the blade always on the waste side.

    `shared` says of each piece but the last whether one cut ends it and starts the next. Behind a
    skew end at the end of the bar nothing is left to be squared.
    """
    common = (False, *shared, False)
    for index, (piece, (start, end)) in enumerate(zip(pieces, ends, strict=True)):
        source, shares_start, shares_end = piece.part.source, common[index], common[index + 1]
        if index == 0 and start.is_square:
            x = saw.x + piece.start - saw.kerf / 2
            yield SawOp(x, saw.zero_angle, "trim", (0,), source, 0.0, "start", ("cut-trim",))
        elif not start.is_square and not shares_start:
            yield _skew(piece, (index,), start, saw, "mitre")
        following = ends[index + 1][0] if index + 1 < len(pieces) else None
        if shares_end:
            yield _skew(piece, (index, index + 1), end, saw, "common")
            continue
        if not end.is_square:
            yield _skew(piece, (index,), end, saw, "mitre")
        if following is not None and following.is_square:
            # It makes the next part's square start too, which lies further on behind a mitre.
            x = saw.x + pieces[index + 1].start - saw.kerf / 2
            both = (index, index + 1)
            yield SawOp(
                x, saw.zero_angle, "parting", both, source, 0.0, "end", ("cut-parting-both",)
            )
        elif end.is_square or following is not None or bar.left > NOTHING_LEFT:
            x = saw.x + piece.end + end.kerf / 2
            reason = "cut-parting" if end.is_square else "cut-wedge"
            yield SawOp(x, saw.zero_angle, "parting", (index,), source, 0.0, "end", (reason,))


def _skew(
    piece: Piece, pieces: tuple[int, ...], end: SawnEnd, saw: Saw,
    purpose: Literal["mitre", "common"],
) -> SawOp:  # fmt: skip
    """The cut of a skew end, half a kerf on the waste side of it."""
    profile = piece.part.profile
    edge = end.x(*pivot_edge(saw, profile))
    side = -0.5 if end.at == "start" else 0.5
    x = saw.x + piece.start + edge + side * end.kerf
    angle, tilt = saw_angles(end, saw)
    reason = "cut-common" if purpose == "common" else f"cut-mitre-{end.at}"
    return SawOp(x, angle, purpose, pieces, piece.part.source, tilt, end.at, (reason,))


def pivot_edge(saw: Saw, profile: Profile) -> tuple[float, float]:
    """y and z of the line on which the machine counts a cut's X: on the side the bar lies on."""
    return (profile.height if saw.pivot == "o" else 0.0), 0.0


def best_order(
    parts: Sequence[Part], ends: Sequence[Ends], saw: Saw
) -> tuple[list[int], tuple[Diagnostic, ...]]:
    """The order of parts that saves most of the bar by common cuts, as indices; and a remark.

    Of orders that save as much the one nearest to the given order, by its indices, comes out of
    up to `EXACT_ORDER` parts.
    """
    count = len(parts)
    saves = [[0.0] * count for _ in parts]
    for i, j in permutations(range(count), 2):
        end, start = ends[i][1], ends[j][0]
        if share_cut(end, start, saw):
            # As in lay_on_bar: by x0 - length of the end, less x0 of the start, they overlap.
            saves[i][j] = parts[i].length - end.x0 + start.x0
    order = _exact(saves) if count <= EXACT_ORDER else _greedy(saves)
    gain, as_given = (sum(saves[a][b] for a, b in pairwise(some)) for some in (order, range(count)))
    gain -= as_given
    if gain <= 1e-9:
        return list(range(count)), ()
    shown = " ".join(parts[i].mark for i in order)
    reason = f"{gain:.1f} mm less bar than as given"
    return order, (rules.ORDER.at(parts[0].source, found=shown, reason=reason),)


def _exact(saves: Sequence[Sequence[float]]) -> list[int]:
    """The path through all parts that saves most, by Held and Karp."""
    count = len(saves)
    best: dict[tuple[int, int], tuple[float, tuple[int, ...]]] = {
        (1 << i, i): (0.0, (i,)) for i in range(count)
    }
    for mask in range(1, 1 << count):
        for last in range(count):
            if (mask, last) not in best:
                continue
            cost, path = best[mask, last]
            for after in range(count):
                if mask >> after & 1:
                    continue
                key = mask | 1 << after, after
                saved = (cost - saves[last][after], (*path, after))
                if key not in best or saved < best[key]:
                    best[key] = saved
    full = (1 << count) - 1
    return list(min(best[full, last] for last in range(count))[1])


def _greedy(saves: Sequence[Sequence[float]]) -> list[int]:
    """A path that joins, of all parts not yet joined, the two that save most, again and again."""
    count = len(saves)
    path_of = [[i] for i in range(count)]
    pairs = sorted(
        (-saves[i][j], i, j) for i in range(count) for j in range(count) if saves[i][j] > 0
    )
    for _, i, j in pairs:
        before, after = path_of[i], path_of[j]
        if before[-1] == i and after[0] == j and before is not after:
            before += after
            for k in after:
                path_of[k] = before
    return [k for i in range(count) if path_of[i][0] == i for k in path_of[i]]
