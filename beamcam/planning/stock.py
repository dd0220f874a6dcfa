"""The bars that parts are cut from: of those in store the shortest that will do.

Parts on as many bars of stock as they need, first fit.

    D. S. Johnson, Near-optimal bin packing algorithms, 1973: each part in the order given goes
    onto the first bar begun that has room for it. It never takes more than 17/10 of the minimum.

Remnants come first, the shortest before the others, each once. Other bars begin as the longest in
store; at the end each is the shortest that holds its parts. The first bar with room is looked for
in a tournament tree, so that n parts take n log n steps: a job has tens of thousands.
"""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from math import floor, inf

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source
from beamcam.machine.machine import Layout, Machine
from beamcam.machine.stations import Saw
from beamcam.model.part import Part
from beamcam.model.plan import Bar
from beamcam.model.request import LotKey, Remnant, Request, Share, taken_by
from beamcam.planning import rules
from beamcam.planning.nesting import SAME_ANGLE_DEG, BarRow, bar_of, lay_on_bar, row_of, row_with
from beamcam.planning.operations.finished_part import Ends, SawnEnd, ends_of

SLACK = 1e-3  #: mm by which a bar may seem fuller than it is; the account of the bar decides


class StockBar(Struct, frozen=True):
    """A bar of stock with the parts that are cut from it."""

    pieces: tuple[int, ...]  #: indices of the parts, in their order along the bar
    starts: tuple[float, ...]  #: x of each on the bar, mm
    account: Bar
    is_remnant: bool = False


class Nesting(Struct, frozen=True):
    """All parts on bars, and why some are on none."""

    bars: tuple[StockBar, ...]
    refusals: tuple[Diagnostic, ...]


class Rooms:
    """Rooms in the order in which they were added, and the first that is large enough.

    A tournament tree: each node holds the greatest room below it, so that a room is added,
    changed and found in log n steps.
    """

    def __init__(self) -> None:
        self._leaves, self._count = 1, 0
        self._tree = [-inf, -inf]

    def add(self, room: float) -> None:
        """A room behind the others."""
        if self._count == self._leaves:
            known = self._tree[self._leaves :]
            self._leaves *= 2
            self._tree = [-inf] * self._leaves + known + [-inf] * len(known)
            for node in range(self._leaves - 1, 0, -1):
                self._tree[node] = max(self._tree[2 * node], self._tree[2 * node + 1])
        self._count += 1
        self.change(self._count - 1, room)

    def change(self, index: int, room: float) -> None:
        """What a room is from now on."""
        node, tree = self._leaves + index, self._tree
        tree[node] = room
        while node := node // 2:
            tree[node] = max(tree[2 * node], tree[2 * node + 1])

    def first(self, need: float, begin: int) -> int | None:
        """Index of the first room of at least `need`, from `begin` on; None if there is none."""
        if begin >= self._count:
            return None
        node, tree = self._leaves + begin, self._tree
        while tree[node] < need:
            while node % 2:  # a right one: nothing is left below what holds it
                node //= 2
            if not node:
                return None
            node += 1
        while node < self._leaves:
            node *= 2
            node += tree[node] < need
        return node - self._leaves


class _Sort(Struct, frozen=True):
    """A part as it is laid, whatever its quantity."""

    part: Part
    ends: Ends
    alone: BarRow
    need: float  #: length of bar that it takes at least behind any other, mm


class _Begun(Struct):
    """A bar that parts are put on."""

    pieces: list[int]
    row: BarRow | None  #: None of a remnant that nothing is on yet
    longest: float | None  #: that it may be, mm
    is_remnant: bool = False


def first_fit(
    parts: Sequence[Part], machine: Machine, lengths: Sequence[float],
    remnants: Sequence[float] = (),
) -> Nesting:  # fmt: skip
    """Bars for `parts`, those of one section and grade together, in the order given.

    `lengths` (mm) are those in store; without any there is one bar for each section and grade, as
    long as its parts need. Each of the `remnants` (mm) is there once, of the section and grade of
    the parts. Raises TypeError for a machine without saw and layout, ValueError for remnants of
    parts of several.
    """
    saw = machine.needed(machine.saw, "saw and layout")
    layout = machine.needed(machine.layout, "saw and layout")
    store = sorted(lengths)
    longest = store[-1] if store else None
    most = None if longest is None else max((longest, *remnants))
    sorts, refused = _sorts(parts, layout, saw, most)
    refusals: list[Diagnostic] = []
    bars: list[_Begun] = []
    of_section: dict[object, tuple[list[_Begun], Rooms]] = {}
    if remnants:
        kinds = {(part.profile, part.grade) for part in parts}
        if len(kinds) > 1:
            raise ValueError("remnants of several sections or grades")
        bars += (_Begun([], None, length, True) for length in sorted(remnants))
        rooms = Rooms()
        for bar in bars:
            rooms.add(bar.longest or 0.0)
        of_section = {kind: ([*bars], rooms) for kind in kinds}
    for index, part in enumerate(parts):
        if id(part) in refused:
            refusals += refused[id(part)]
            continue
        sort = sorts[id(part)]
        own, rooms = of_section.setdefault((part.profile, part.grade), ([], Rooms()))
        if not _put(index, sort, own, rooms, layout, saw):
            try:
                bar_of(sort.alone, layout, longest, part.source)
            except PlanError as error:  # which only a remnant would hold
                refusals += error.diagnostics
                continue
            own.append(_Begun([index], sort.alone, longest))
            bars.append(own[-1])
            rooms.add(_room(sort.alone, layout, longest))
    made = tuple(
        _shortest(bar, [sorts[id(parts[i])] for i in bar.pieces], layout, saw, store)
        for bar in bars
        if bar.pieces
    )
    return Nesting(made, tuple(refusals))


def _sorts(
    parts: Sequence[Part], layout: Layout, saw: Saw, longest: float | None
) -> tuple[dict[int, _Sort], dict[int, tuple[Diagnostic, ...]]]:
    """What is known of each part before it is laid, and why some cannot be, by identity."""
    laid: dict[int, tuple[Part, Ends]] = {}
    refused: dict[int, tuple[Diagnostic, ...]] = {}
    for part in {id(part): part for part in parts}.values():
        try:
            ends = ends_of(part, saw)[0]
            lay_on_bar([part], [ends], layout, saw, longest)
        except PlanError as error:
            refused[id(part)] = error.diagnostics
        else:
            laid[id(part)] = part, ends
    # By the angles of ends the length of bar that a common cut behind one saves at most.
    saved: dict[tuple[int, int], float] = {}
    for part, (_, end) in laid.values():
        if saw.common_cuts and not end.is_square:
            cell = _cell(end)
            saved[cell] = max(saved.get(cell, -inf), part.length - end.x0)
    sorts = {}
    for key, (part, ends) in laid.items():
        start, end = ends
        need = part.length + end.kerf + layout.end_trim + layout.dead_zone
        need = max(need, layout.min_bar_left) + start.kerf
        if saved:
            web, flange = _cell(start)
            near = [(web + i, flange + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
            need -= max(0.0, start.x0 + max(saved.get(cell, -inf) for cell in near))
        sorts[key] = _Sort(part, ends, row_of(part, ends, layout), need)
    return sorts, refused


def _cell(end: SawnEnd) -> tuple[int, int]:
    """The angles of an end, rounded so that those which share a cut are neighbours."""
    width = 2 * SAME_ANGLE_DEG
    return floor(end.web_deg / width), floor(end.flange_deg / width)


def _room(row: BarRow, layout: Layout, longest: float | None) -> float:
    """Length of bar behind the last part, mm; without a store as much as the machine can hold."""
    whole = inf if layout.max_bar is None else layout.max_bar
    return (whole if longest is None else longest) - row.start - row.last + SLACK


def _put(
    index: int, sort: _Sort, bars: Sequence[_Begun], rooms: Rooms, layout: Layout, saw: Saw
) -> bool:
    """Put a part on the first bar that has room, and whether there is one."""
    at = rooms.first(sort.need, 0)
    while at is not None:
        bar = bars[at]
        row = sort.alone if bar.row is None else row_with(bar.row, sort.part, sort.ends, saw)
        try:
            bar_of(row, layout, bar.longest, sort.part.source)
        except PlanError:
            at = rooms.first(sort.need, at + 1)
            continue
        bar.pieces.append(index)
        bar.row = row
        rooms.change(at, _room(row, layout, bar.longest))
        return True
    return False


def _shortest(
    bar: _Begun, chosen: Sequence[_Sort], layout: Layout, saw: Saw, store: Sequence[float]
) -> StockBar:
    parts, ends = [sort.part for sort in chosen], [sort.ends for sort in chosen]
    if bar.row is None:
        raise AssertionError("a bar without parts")
    last = bar.longest if bar.is_remnant else None
    for last in () if bar.is_remnant else store:
        with suppress(PlanError):
            bar_of(bar.row, layout, last, parts[0].source)
            break
    laid, _ = lay_on_bar(parts, ends, layout, saw, last)
    return StockBar(tuple(bar.pieces), laid.starts, laid.bar, bar.is_remnant)


def bar_shares(request: Request, pieces: Sequence[int]) -> tuple[Share, ...]:
    """The share of each bar that a saw cuts, first fit. Raises PlanError for what is on none."""
    machine = request.machine
    single = [taken_by(machine, replace(part, quantity=1)) for part in request.parts]
    nesting = first_fit(
        [single[place] for place in pieces], machine, request.stock, request.remnants
    )
    if nesting.refusals:
        raise PlanError(dict.fromkeys(nesting.refusals))
    return tuple(
        Share(
            tuple(pieces[i] for i in bar.pieces),
            (bar.account.length,) if request.stock or bar.is_remnant else (),
        )
        for bar in nesting.bars
    )


def remnants_of(
    remnants: Sequence[Remnant], lots: Iterable[LotKey]
) -> dict[LotKey, tuple[float, ...]]:
    """The lengths of the remnants of each lot of bars, rising.

    Raises PlanError for a remnant that may be of several lots.
    """
    lengths: dict[LotKey, list[float]] = {}
    names = {lot: getattr(lot[1], "name", "") or getattr(lot[1], "code", "") for lot in lots}
    for remnant in remnants:
        fitting = [
            lot
            for lot, name in names.items()
            if (not remnant.section or _plain(remnant.section) == _plain(name))
            and (not remnant.grade or _plain(remnant.grade) == _plain(lot[2]))
        ]
        if len(fitting) > 1:
            shown = (f"{names[lot]}/{lot[2]}" if lot[2] else names[lot] for lot in fitting)
            expected = " or ".join(f"{lot}={remnant.length:g}" for lot in shown)
            diagnostic = rules.REMNANT_OF.at(Source("--remnant"), found=remnant, expected=expected)
            raise PlanError(diagnostic)
        for lot in fitting:
            lengths.setdefault(lot, []).append(remnant.length)
    return {lot: tuple(sorted(some)) for lot, some in lengths.items()}


def _plain(text: str) -> str:
    return text.replace(" ", "").casefold()
