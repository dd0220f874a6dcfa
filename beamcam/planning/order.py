"""The order of work: along machine X, with minimum time for changes of spindle and tool.

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

At each X every setup (spindle and tool) is worked off in one go. What a change costs follows from
the machine's `[times]`: another spindle is chosen within half a second, another tool takes eight.
Each spindle keeps its tool meanwhile, so what a setup costs depends on what every spindle holds:

    web d22 -> flanges d14 -> web d22         two changes of spindle, the tools are there
    web d22 -> web d18     -> web d22         two changes of tool

The order is the cheapest path over all X, found exactly (R. Bellman, Dynamic programming, 1957): a
state is what is done at this X, which spindle is chosen and what each one holds. A tap has to wait
for its drill, a sink for its hole.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from operator import attrgetter, itemgetter
from typing import Literal, NamedTuple

from beamcam.machine.machine import Times
from beamcam.model.part import Face
from beamcam.model.plan import Operation, PathOp, SawOp, WorkOp

#: What has to be done before what, where it is one place on one face.
STAGES = {"drill": 0, "mill": 1, "countersink": 2, "tap": 3, "punch": 4, "scribe": 5,
          "stamp": 6, "printer": 6}  # fmt: skip
SAME_PLACE = 0.5  #: mm across; holes are not nearer to each other than this

Setup = tuple[int, int, float, float, float, str]
#: stage and spindle, diameter, point, pitch and hand of the tool
Held = tuple[tuple[Face, Setup], ...]  #: the tool that the spindle of each face holds
ALIKE = Times(tool_change_s=1.0, spindle_change_s=1.0)
MOST_STATES = 48  #: that are followed from one X to the next; the cheapest
MOST_SETUPS = 8  #: setups at one X up to which all orders are tried; more are taken as sorted
CUT_RANK = {("mitre", "end"): 0, ("common", "end"): 0, ("parting", "end"): 1, ("trim", "start"): 2,
            ("mitre", "start"): 2}  # fmt: skip


def sort_along_x(
    operations: Iterable[Operation],
    resolution: float,
    layout: Literal["saw-drill", "drill-saw"] = "saw-drill",
    times: Times | None = None,
) -> tuple[Operation, ...]:
    """The operations in order of X, with minimum time for changes of spindle and tool.

    Without `times` a tool and a spindle take the same, and of equal times the fewest changes count.

    X that the output cannot tell apart (`resolution`) count as one. There the cuts come before
    the spindles if the bar reaches the saw first, else after them.
    """
    operations = tuple(operations)
    at = [round(op.x / resolution) for op in operations]
    cuts: dict[int, list[SawOp]] = {}
    strokes: dict[int, list[WorkOp]] = {}
    for place, op in zip(at, operations, strict=True):
        if op.__class__ is SawOp:
            cuts.setdefault(place, []).append(op)
        else:
            strokes.setdefault(place, []).append(op)  # type: ignore[arg-type]
    places = sorted(strokes)
    worked = dict(zip(places, _work_off([strokes[p] for p in places], times or ALIKE), strict=True))
    result: list[Operation] = []
    for place in sorted({*cuts, *strokes}):
        spindles, sawn = worked.get(place, ()), sorted(cuts.get(place, ()), key=_cut_rank)
        result += (*sawn, *spindles) if layout == "saw-drill" else (*spindles, *sawn)
    return tuple(result)


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
    """Spindle and tool of an operation, as what a change is a change of."""
    tool = op.tool
    return STAGES[tool.kind], op.spindle, tool.diameter, tool.point_deg, tool.pitch, tool.hand


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


def _cut_rank(op: SawOp) -> tuple[int, int, float, float]:
    """Cuts at one X: what ends a part, what parts it off, what starts the next."""
    return CUT_RANK[op.purpose, op.at], op.pieces[0], op.x, op.angle


def _work_off(stations: Sequence[list[WorkOp]], times: Times) -> list[list[WorkOp]]:
    """The operations of each X in the best order."""
    groups = [_by_setup(ops) for ops in stations]
    worked: list[list[WorkOp]] = []
    setups = iter(_cheapest(groups, times))
    for group in groups:
        worked.append([op for _ in group for op in sorted(group[next(setups)], key=_place)])
    return worked


def _by_setup(ops: Sequence[WorkOp]) -> dict[Setup, list[WorkOp]]:
    """The operations of one X by their setup, the setups sorted."""
    found: dict[Setup, list[WorkOp]] = {}
    for op in ops:
        found.setdefault(setup_of(op), []).append(op)
    return dict(sorted(found.items()))


_place = attrgetter("x", "y", "features")


class _Path(NamedTuple):
    """A sequence of setups so far."""

    seconds: float
    changes: int
    done: int  #: of the setups at this X, a bit each
    spindle: int
    held: Held
    last: Setup | None
    before: "_Path | None"


def _cheapest(groups: Sequence[dict[Setup, list[WorkOp]]], times: Times) -> list[Setup]:
    """The setups of all X, one X after another, in the order that takes least for changes."""
    paths = [_Path(0.0, 0, 0, 0, (), None, None)]
    for group in groups:
        setups = list(group)
        waiting = _prerequisites(group)
        if len(setups) > MOST_SETUPS:
            waiting = [(1 << i) - 1 for i in range(len(setups))]  # as they are sorted
        for _ in setups:
            found: dict[tuple[int, int, Held], _Path] = {}
            for path in paths:
                for i, setup in enumerate(setups):
                    if path.done >> i & 1 or waiting[i] & ~path.done:
                        continue
                    after = _step(path, i, setup, group[setup][0].faces, times)
                    key = after.done, after.spindle, after.held
                    known = found.get(key)
                    if known is None or after[:2] < known[:2]:
                        found[key] = after
            paths = list(found.values())
        paths = [path._replace(done=0) for path in sorted(paths, key=_cost)[:MOST_STATES]]
    order: list[Setup] = []
    at: _Path | None = min(paths, key=_cost)
    while at is not None and at.last is not None:
        order.append(at.last)
        at = at.before
    return order[::-1]


_cost = itemgetter(0, 1)


def _step(path: _Path, i: int, setup: Setup, faces: tuple[Face, ...], times: Times) -> _Path:
    """The path with one more setup."""
    seconds, changes, held = path.seconds, path.changes, path.held
    spindle, tool = setup[1], (setup[0], 0, *setup[2:])
    if setup != path.last and path.last is not None:
        changes += 1
    if spindle != path.spindle:
        seconds += times.spindle_change_s
    holding = dict(held)
    if any(holding.get(face) != tool for face in faces):
        seconds += times.tool_change_s
        held = tuple(sorted({**holding, **dict.fromkeys(faces, tool)}.items()))
    return _Path(seconds, changes, path.done | 1 << i, spindle, held, setup, path)


def _prerequisites(group: dict[Setup, list[WorkOp]]) -> list[int]:
    """For each setup of one X those that have to be done before it, a bit each."""
    setups = list(group)
    return [
        sum(
            1 << j
            for j, b in enumerate(setups)
            if b[0] < a[0] and any(waits_for(p, q) for p in group[a] for q in group[b])
        )
        for a in setups
    ]
