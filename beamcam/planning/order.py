"""The order of work: along machine X, with as few changes of spindle and tool as there can be.

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
             \\________ 1 change ________/               \\____ no change, 1 change

At each X every setup (spindle and tool) is worked off in one go, which takes one change less than
there are setups, whatever their order; so only the first and the last one matter. The last ones
are chosen over the whole bar: a shortest path over the last setup of each X, where a step costs
one less if the setup that is still in the machine may come first. May, because a tap has to wait
for its drill: the first setup waits for none at that X, and none waits for the last.
"""

from collections.abc import Iterable, Sequence
from itertools import chain, pairwise
from operator import attrgetter
from typing import Literal

from beamcam.model.plan import Operation, PathOp, SawOp, SpindleOp

#: What has to be done before what, where it is one place on one face.
STAGES = {"drill": 0, "mill": 1, "countersink": 2, "tap": 3, "punch": 4, "scribe": 5}
SAME_PLACE = 0.5  #: mm across; holes are not nearer to each other than this

Setup = tuple[int, int, float, float, float, str]
#: stage and spindle, diameter, point, pitch and hand of the tool
Station = tuple[list[Setup], list[Setup], list[Setup]]
#: all setups of one X, those that may come first and those that may come last
CUT_RANK = {("mitre", "end"): 0, ("common", "end"): 0, ("parting", "end"): 1, ("trim", "start"): 2,
            ("mitre", "start"): 2}  # fmt: skip


def sort_along_x(
    operations: Iterable[Operation],
    resolution: float,
    layout: Literal["saw-drill", "drill-saw"] = "saw-drill",
) -> tuple[Operation, ...]:
    """The operations in order of X, with the fewest changes of spindle and tool.

    X that the output cannot tell apart (`resolution`) count as one. There the cuts come before
    the spindles if the bar reaches the saw first, else after them.
    """
    operations = tuple(operations)
    at = [round(op.x / resolution) for op in operations]
    if len(set(at)) == len(at):  # one at each X, and nothing to choose
        return tuple([op for _, op in sorted(zip(at, operations, strict=True))])
    cuts: dict[int, list[SawOp]] = {}
    strokes: dict[int, list[SpindleOp]] = {}
    for place, op in zip(at, operations, strict=True):
        if op.__class__ is SawOp:
            cuts.setdefault(place, []).append(op)
        elif place in strokes:
            strokes[place].append(op)  # type: ignore[arg-type]
        else:
            strokes[place] = [op]  # type: ignore[list-item]
    places = sorted(strokes)
    worked = dict(zip(places, _work_off([strokes[p] for p in places]), strict=True))
    if not cuts:
        return tuple(chain.from_iterable(worked.values()))
    result: list[Operation] = []
    for place in sorted({*cuts, *strokes}):
        spindles = worked.get(place, ())
        if place not in cuts:
            result += spindles
            continue
        sawn = sorted(cuts[place], key=_cut_rank)
        result += (*sawn, *spindles) if layout == "saw-drill" else (*spindles, *sawn)
    return tuple(result)


def changes(operations: Iterable[Operation]) -> int:
    """How often spindle or tool change along `operations`."""
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


def setup_of(op: SpindleOp) -> Setup:
    """Spindle and tool of an operation, as what a change is a change of."""
    tool = op.tool
    return STAGES[tool.kind], op.spindle, tool.diameter, tool.point_deg, tool.pitch, tool.hand


def waits_for(op: SpindleOp, other: SpindleOp) -> bool:
    """Whether an operation has to come after another one at the same X: a tap after its drill."""
    return (
        STAGES[other.tool.kind] < STAGES[op.tool.kind]
        and op.tool.kind not in ("punch", "scribe")
        and any(face in other.faces for face in op.faces)
        and (
            abs(op.y - other.y) <= SAME_PLACE
            or any(feature in other.features for feature in op.features)
        )
    )


def _cut_rank(op: SawOp) -> tuple[int, int, float, float]:
    """Cuts at one X: what ends a part, what parts it off, what starts the next."""
    return CUT_RANK[op.purpose, op.at], op.pieces[0], op.x, op.angle


def _work_off(stations: Sequence[list[SpindleOp]]) -> list[list[SpindleOp]]:
    """The operations of each X in the best order."""
    if all(map(_is_one_setup, stations)):
        return [sorted(ops, key=_place) if len(ops) > 1 else ops for ops in stations]
    setups: dict[tuple[int, int], Setup] = {}  # by spindle and the tool's object
    by_setup: list[dict[Setup, list[SpindleOp]]] = []
    for ops in stations:
        groups: dict[Setup, list[SpindleOp]] = {}
        for op in ops:
            key = op.spindle, id(op.tool)
            setup = setups.get(key)
            if setup is None:
                setup = setups[key] = setup_of(op)
            if setup in groups:
                groups[setup].append(op)
            else:
                groups[setup] = [op]
        by_setup.append(groups)
    choices = [_freedom(groups) for groups in by_setup]
    result, current = [], None
    for groups, choice, last in zip(by_setup, choices, _choose_lasts(choices), strict=True):
        if len(groups) == 1:
            worked = groups[last]
            result.append(sorted(worked, key=_place) if len(worked) > 1 else worked)
        else:
            result.append(
                [
                    op
                    for setup in _arrange(choice, current, last)
                    for op in sorted(groups[setup], key=_place)
                ]
            )
        current = last
    return result


def _is_one_setup(ops: Sequence[SpindleOp]) -> bool:
    """Whether all operations of one X are done with one spindle and tool."""
    if len(ops) == 1:
        return True
    spindle, tool = ops[0].spindle, ops[0].tool
    return all(op.spindle == spindle and op.tool is tool for op in ops)


_place = attrgetter("x", "y", "features")


def _freedom(groups: dict[Setup, list[SpindleOp]]) -> Station:
    """The setups of one X, those that wait for none of them, and those that none waits for."""
    setups = sorted(groups) if len(groups) > 1 else list(groups)
    if setups[0][0] == setups[-1][0]:  # one stage: nothing waits
        return setups, setups, setups
    waiting = {
        (a, b)
        for a in setups
        for b in setups
        if b[0] < a[0] and any(waits_for(p, q) for p in groups[a] for q in groups[b])
    }
    first = [s for s in setups if all(a != s for a, _ in waiting)]
    last = [s for s in setups if all(b != s for _, b in waiting)]
    return setups, first, last


def _arrange(station: Station, current: Setup | None, last: Setup) -> list[Setup]:
    """The setups of one X: `current` first if it may be, `last` at the end, by stages between."""
    setups, firsts, _ = station
    first = [s for s in firsts if s == current and s != last]
    return first + [s for s in setups if s != last and s not in first] + [last]


def _choose_lasts(stations: Sequence[Station]) -> list[Setup]:
    """The setup to end each X with, so that the sum of changes is least."""
    if not stations:
        return []
    costs: dict[Setup | None, int] = {None: 0}
    steps: list[dict[Setup, Setup | None]] = []
    for setups, firsts, lasts in stations:
        count = len(setups)
        # Arriving with a setup that may be first saves a change, unless it has to be the last
        # too; one that cannot be used costs the same whichever it is, so the cheapest counts.
        cheapest = min(costs, key=lambda s: (costs[s], s or ()))
        reached: dict[Setup | None, int] = {}
        step: dict[Setup, Setup | None] = {}
        for last in lasts:
            best, origin = costs[cheapest] + count, cheapest
            for current in firsts if count > 1 else setups:
                if (current != last or count == 1) and current in costs:
                    cost = costs[current] + count - 1
                    if cost < best:
                        best, origin = cost, current
            reached[last], step[last] = best, origin
        costs = reached
        steps.append(step)
    at: Setup | None = min(costs, key=lambda s: (costs[s], s or ()))
    path: list[Setup] = []
    for step in reversed(steps):
        if at is None:
            raise AssertionError("the path over the stations is broken")
        path.append(at)
        at = step[at]
    return path[::-1]
