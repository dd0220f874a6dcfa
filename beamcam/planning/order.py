r"""The order of work: along machine X, with minimum time for changes of spindle and tool.

Machine X says how far the bar has come: bar x of the work plus the station's place. It is not
the order of part x.

`saw-drill`, stop downstream. The bar runs against the stop, and the stop only gives way, so X
grows or stays. A cut near the saw comes before a hole that the drill behind it reaches later:

    bar ->   saw          drill     stop      X of a cut:  its x on the bar
    =========|==============|=====|           X of a hole: its x on the bar + the way saw to drill

`drill-saw`, pusher and gripper upstream. The bar could go back, but it need not: the drill stands
before the saw, so of each part every hole has a smaller X than the cut that parts it off. Along X
the cut is the last operation of each part, and the way forward is the least there can be, with no
way back (but for what a path needs: a slot is milled to and fro).

    pusher -> drill         saw               X of a hole: its x on the bar
    ===========|=============|===             X of a cut:  its x on the bar + the way drill to saw

So in both layouts the order is X, and freedom is left only among operations at one X:

    X 1200   web d22, both flanges d14        X 1500   both flanges d14, web d14
             \________ 1 change ________/               \____ no change, 1 change

At each X every setup (spindle and tool) is worked off in one go. What a change costs follows from
the machine's `[times]`: another spindle is chosen within half a second, another tool takes eight.
Each spindle keeps its tool meanwhile, so what a setup costs depends on what every spindle holds:

    web d22 -> flanges d14 -> web d22         two changes of spindle, the tools are there
    web d22 -> web d18     -> web d22         two changes of tool

The order is the cheapest path over all X, found exactly (R. Bellman, Dynamic programming, 1957): a
state is what is done at this X, which spindle is chosen and what each one holds. A tap has to wait
for its drill, a sink for its hole.

Assignment of tools to stations, and the tool changes during the work.

A spindle changes by itself among the tools of its stations. If the work needs more tools than
there are stations, tools are changed manually. Loading the stations before the work is
free; after that each load of a tool that is not there throws one out. The fewest loads come from
throwing out the tool that is needed again last, or never:

    L. A. Belady, A study of replacement algorithms for a virtual-storage computer,
    IBM Systems Journal 5 (1966): no other choice loads less often for a given order of work.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import pairwise
from operator import attrgetter, itemgetter

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import BoundedCache, PerObject
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine, Times
from beamcam.machine.stations import Drill, Tool, cutting_row, is_unnamed, turns_of
from beamcam.model.part import FACES, Hole
from beamcam.model.plan import (
    DrillOp,
    Operation,
    PathOp,
    Piece,
    SawOp,
    ToolLoad,
    WorkOp,
)
from beamcam.planning import rules

#: What has to be done before what, where it is one place on one face.
STAGES = {"drill": 0, "mill": 1, "countersink": 2, "tap": 3, "punch": 4, "scribe": 5,
          "stamp": 6, "printer": 6}  # fmt: skip
SAME_PLACE = 0.5  #: mm across; holes are not nearer to each other than this

_Tool = tuple[float, float, float, str]  #: diameter, point, pitch and hand
Setup = tuple[int, int, _Tool]  #: stage, spindle and tool
Station = dict[Setup, list[WorkOp]]  #: the operations at one X by their setup, the setups sorted
Held = tuple[int, ...]  #: number of the tool that the spindle of each of `FACES` holds; -1 for none
MOST_STATES = 48  #: that are followed from one X to the next; the cheapest
MOST_SETUPS = 8  #: setups at one X up to which all orders are tried; more are taken as sorted
CUT_RANK = {("mitre", "end"): 0, ("common", "end"): 0, ("parting", "end"): 1, ("trim", "start"): 2,
            ("mitre", "start"): 2}  # fmt: skip


def sort_along_x(
    cuts: Iterable[SawOp], strokes: Iterable[WorkOp], machine: Machine
) -> tuple[Operation, ...]:
    """The operations of a line in order of X, with minimum time for changes of spindle and tool.

    Of equal times the fewest changes count. X that the output cannot tell apart count as one; there
    the cuts come before the spindles if the bar reaches the saw first, else after them. Raises
    TypeError if the machine has no layout.
    """
    layout, resolution = machine.needed(machine.layout, "layout"), machine.format.resolution
    sawn: list[tuple[int, SawOp]] = []
    for cut in cuts:
        place = round(cut.x / resolution)
        # Where a tube's corner is round the X of a compound mitre counts on an edge beyond the
        # steel, and may exceed that of the cut that parts the piece off by a millimetre. A line
        # with a gripper saws the end first all the same, and goes back.
        if layout.order == "drill-saw" and sawn and sawn[-1][1].at == "end":
            place = max(place, sawn[-1][0])
        sawn.append((place, cut))
    sawn.sort(key=_sawn_in_order)
    placed = [
        (round(op.x / resolution), setup_of(op), op.x, op.y, op.features, k, op)
        for k, op in enumerate(strokes)
    ]
    stations: dict[int, Station] = {}
    for place, setup, _, _, _, _, stroke in sorted(placed):
        stations.setdefault(place, {}).setdefault(setup, []).append(stroke)
    setups = iter(_cheapest(stations.values(), machine.times))
    worked = [
        (place, op)
        for place, station in stations.items()
        for _ in station
        for op in station[next(setups)]
    ]
    both = [*sawn, *worked] if layout.order == "saw-drill" else [*worked, *sawn]
    both.sort(key=itemgetter(0))
    return tuple([op for _, op in both])


def _sawn_in_order(sawn: tuple[int, SawOp]) -> tuple[int, int, int, float, float]:
    """The cuts at one place: what ends a part, what parts it off, what starts the next."""
    place, op = sawn
    return place, CUT_RANK[op.purpose, op.at], op.pieces[0], op.x, op.angle


def changes(operations: Iterable[Operation]) -> int:
    """Number of spindle and tool changes along `operations`."""
    setups = [setup_of(op) for op in operations if not isinstance(op, SawOp)]
    return sum(a != b for a, b in pairwise(setups))


def travel(operations: Iterable[Operation], start: float = 0.0) -> tuple[float, float]:
    """How far the bar goes forward and back along `operations`, from X `start`; in mm."""
    forward = back = 0.0
    x = start
    for op in operations:
        for to in [p[0] for p in op.path] if isinstance(op, PathOp) else [op.x]:
            forward += max(0.0, to - x)
            back += max(0.0, x - to)
            x = to
    return forward, back


def setup_of(op: WorkOp) -> Setup:
    """Spindle and tool of an operation; going on to another one takes time."""
    tool = op.tool
    return STAGES[tool.kind], op.spindle, (tool.diameter, tool.point_deg, tool.pitch, tool.hand)


def waits_for(op: WorkOp, other: WorkOp) -> bool:
    """Whether an operation has to come after another one at the same X: a tap after its drill."""
    return (
        STAGES[other.tool.kind] < STAGES[op.tool.kind]
        and op.tool.kind not in ("punch", "scribe", "stamp", "printer")
        and any(face in other.faces for face in op.faces)
        and (
            abs(op.y - other.y) <= SAME_PLACE
            or any(feature in other.features for feature in op.features)
        )
    )


class _Path(Struct, frozen=True):
    """A sequence of setups so far."""

    cost: tuple[float, int]  #: seconds and changes
    done: int  #: of the setups at the last X, a bit each
    spindle: int
    held: Held
    last: Setup | None = None
    before: "_Path | None" = None


def _cheapest(stations: Collection[Station], times: Times) -> list[Setup]:
    """The setups of all X, one X after another, in the order that takes least for changes."""
    paths = [_Path((0.0, 0), 0, 0, (-1,) * len(FACES))]
    numbers: dict[tuple[int, _Tool], int] = {}  # of the tools, by their stage too
    for station in stations:
        setups: list[tuple[int, int, Setup, int, list[int]]] = []
        waiting = _prerequisites(station)
        for i, (setup, works) in enumerate(station.items()):
            stage, _, tool = setup
            number = numbers.setdefault((stage, tool), len(numbers))
            places = [FACES.index(face) for face in works[0].faces]
            setups.append((1 << i, waiting[i], setup, number, places))
        for before in range(len(setups)):
            cheapest: dict[tuple[int, int, Held], _Path] = {}
            for path in paths:
                done = path.done if before else 0
                for bit, needed, setup, number, places in setups:
                    if done & bit or needed & ~done:
                        continue
                    (seconds, changes), spindle, holds = path.cost, setup[1], [*path.held]
                    changes += path.last is not None and setup != path.last
                    if spindle != path.spindle:
                        seconds += times.spindle_change_s
                    for place in places:
                        holds[place] = number
                    held = tuple(holds)
                    if held != path.held:
                        seconds += times.tool_change_s
                    cost = seconds, changes
                    key = done | bit, spindle, held
                    known = cheapest.get(key)
                    if known is None or cost < known.cost:
                        cheapest[key] = _Path(cost, done | bit, spindle, held, setup, path)
            paths = list(cheapest.values())
        if len(paths) > 1:
            paths = sorted(paths, key=attrgetter("cost"))[:MOST_STATES]
    order: list[Setup] = []
    at: _Path | None = min(paths, key=attrgetter("cost"))
    while at is not None and at.last is not None:
        order.append(at.last)
        at = at.before
    return order[::-1]


def _prerequisites(station: Station) -> list[int]:
    """For each setup of one X those that have to be done before it, a bit each.

    One waits for nothing, and more than `MOST_SETUPS` are taken as they are sorted.
    """
    if not 1 < len(station) <= MOST_SETUPS:
        return [(1 << i) - 1 for i in range(len(station))]
    setups = list(station)
    return [
        sum(
            1 << j
            for j, b in enumerate(setups[:i])
            if b[0] < a[0] and any(waits_for(p, q) for p in station[a] for q in station[b])
        )
        for i, a in enumerate(setups)
    ]


def tool_loads(operations: Sequence[Operation], machine: Machine) -> tuple[ToolLoad, ...]:
    """Every load, those before the work first and the others in the order of work."""
    loads: list[ToolLoad] = []
    for spindle in machine.spindles:
        needs = [
            (index, op.tool)
            for index, op in enumerate(operations)
            if isinstance(op, (DrillOp, PathOp)) and spindle.face in op.faces
        ]
        held: list[Tool] = []
        for at, (index, tool) in enumerate(needs):
            if tool in held:
                continue
            before, station, out = 0, len(held), None
            if len(held) < spindle.stations:
                held.append(tool)
            else:
                later = [t for _, t in needs[at:]]
                again = [later.index(t) if t in later else len(later) for t in held]
                before, station = index, again.index(max(again))
                out, held[station] = held[station], tool
            loads.append(ToolLoad(before, spindle.name, station + 1, tool, out, spindle.number))
    return tuple(sorted(loads, key=lambda load: (load.out is not None, load.before)))


def reloads(
    operations: Sequence[Operation], machine: Machine, source: Source
) -> tuple[tuple[ToolLoad, ...], tuple[Diagnostic, ...]]:
    """The manual tool changes in order of work; and a warning for each spindle of theirs.

    An error instead where the machine has no word that stops the program for them.
    """
    # Tools come from one library, so there are no more tools than there are objects.
    objects = {id(op.tool) for op in operations if isinstance(op, (DrillOp, PathOp))}
    if len(objects) <= min((s.stations for s in machine.spindles), default=0):
        return (), ()
    loads = tuple(load for load in tool_loads(operations, machine) if load.out is not None)
    remarks = []
    rule = rules.MANUAL_CHANGE if machine.words.change else rules.NO_CHANGE_WORD
    for spindle in machine.spindles:
        changed = sum(load.spindle == spindle.name for load in loads)
        if changed:
            worked = [op for op in operations if isinstance(op, (DrillOp, PathOp))]
            remarks.append(rule.at(
                source, found=len({op.tool for op in worked if spindle.face in op.faces}),
                stations=spindle.stations, spindle=spindle.name, changes=changed,
                machine=machine.name,
            ))  # fmt: skip
    return loads, tuple(remarks)


TURNING = ("drill", "countersink", "mill")  #: tools whose edge wears by its speed
TOO_FAST = 1.2  #: times the speed of the data at which a tool is warned of

_known_of: PerObject[Machine, BoundedCache[object, tuple[Diagnostic, ...]]] = PerObject(
    "planning.machines", lambda _: BoundedCache("planning.remarks")
)


def cutting_remarks(
    pieces: Sequence[Piece], operations: Sequence[WorkOp], machine: Machine
) -> Iterator[Diagnostic]:
    """A note for a steel that no row names, a warning for each tool that turns too fast in it, a
    note for each diameter that no drill has."""
    if machine.drill is None:
        return
    used: dict[str, dict[int, Tool]] = {}
    sources: dict[str, Source] = {}
    for op in operations:
        part = pieces[op.features[0][0]].part
        if part.grade not in used:
            used[part.grade], sources[part.grade] = {}, part.source
        used[part.grade][id(op.tool)] = op.tool
    known = _known_of(machine)
    for grade, tools in used.items():
        key = grade, *tools.values()
        diagnostics = known.get(key)
        if diagnostics is None:
            own = tuple(_remarks(grade, tools.values(), machine, machine.drill))
            diagnostics = known.keep(key, own)
        for diagnostic in diagnostics:
            yield replace(diagnostic, source=sources[grade])
    # A note for each diameter that is drilled over or under, at the first such hole.
    most_off = machine.drill.same_tool_tolerance + 1e-9
    seen: set[tuple[float, int]] = set()
    for op in operations:
        if op.tool.kind != "drill":
            continue
        for p, f in op.features:
            hole = pieces[p].part.features[f]
            if not isinstance(hole, Hole) or hole.kind not in ("through", "blind"):
                continue
            off = op.tool.diameter - hole.diameter
            if abs(off) <= most_off or (hole.diameter, id(op.tool)) in seen:
                continue
            seen.add((hole.diameter, id(op.tool)))
            yield rules.DRILL_SIZE.at(
                hole.source, found=f"{hole.diameter:g}", size=f"{op.tool.diameter:g}",
                off=f"{abs(off):.3g}", way="over" if off > 0 else "under",
            )  # fmt: skip


def _remarks(
    grade: str, tools: Collection[Tool], machine: Machine, drill: Drill
) -> Iterator[Diagnostic]:
    words = (getattr(machine.words, kind) for kind in TURNING)
    if not any("{feed}" in line or "{speed}" in line for lines in words for line in lines):
        return  # the machine's programs do not contain the cutting data
    source = Source(machine.name)
    shown = grade or "unknown"
    if grade and is_unnamed(drill, grade):
        yield rules.UNNAMED_GRADE.at(source, found=shown, machine=machine.name)
    for tool in tools:
        if tool.kind not in TURNING:
            continue
        turns = turns_of(cutting_row(tool, drill, grade), tool)
        if turns * TOO_FAST < drill.min_speed_rpm:
            yield rules.CUTTING_SPEED.at(
                source, tool=tool.name, grade=shown, found=f"{drill.min_speed_rpm:g}",
                expected=f"{turns:.0f}",
            )  # fmt: skip
