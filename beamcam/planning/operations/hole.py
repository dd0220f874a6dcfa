"""A hole: drilled, drilled and tapped, sunk, punched or milled; one stroke for both flanges.

holes on their faces -> each once -> pairs of the two flanges -> toolings -> steps; sinks last,
since each stands on the hole that it sinks.
"""

from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import floor
from operator import itemgetter

from beamcam.caches import PerObject
from beamcam.errors import Diagnostic, warning
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Drill
from beamcam.model.description import named
from beamcam.model.part import Face, Hole
from beamcam.planning.axis_limits import refuse_steps
from beamcam.planning.operations.finished_part import TOLERANCE
from beamcam.planning.operations.part_planner import (
    ROUNDING,
    Group,
    PartPlanner,
    Placed,
    WorkKind,
    judge_pairs,
    refuse_face,
    refuse_many_pairs,
    refuse_place,
    refuse_too_near,
    runs,
)
from beamcam.planning.operations.slot import pocket_path
from beamcam.planning.operations.tools import (
    Found,
    HoleWork,
    Settled,
    WorkingStep,
    toolings_of,
)

DUPLICATE = warning("plan-duplicate",
    "found a hole of diameter {found} on face {face} at x {x}, y {y} a second time; it is drilled "
    "once, for {first}",
    "Some exporters write a hole of two bolted plates, or of both sides of a web, "
    "twice.")  # fmt: skip
BLIND_POINT = warning("plan-blind-point",
    "found {what} of depth {found} at x {x}, y {y} on face {face}; its point comes {out} mm "
    "through the wall of {expected} mm",
    "The depth counts to the full diameter, and the drill's point goes beyond it.")  # fmt: skip
REASONS = {
    "drill-exact": "a drill of exactly the diameter",
    "drill-nearest": "no drill of exactly the diameter; the nearest one within the tolerance",
    "drill-twin": "as good as the drill of exactly the diameter, and used for another hole already",
    "drill-before-tap": "the drill that the thread's table asks for",
    "tap-thread": "the tap of the thread's diameter",
    "sink-cone": "the cone alone reaches the outer diameter",
    "sink-deep": "the cone stands below the surface, so the tool has the sink's own diameter",
    "sink-flat": "a flat counterbore of the sink's own diameter",
    "punch-mark": "a centre punch",
    "mill-circle": "larger than any drill; a mill is led round",
    "merge-pair": "the same hole on both flanges: both spindles at once",
    "from-behind": "through the one plate that the face behind shares",
}
SUNK = ("through", "blind", "thread", "left-thread")  #: kinds of holes that a sink stands on


# Duplicate holes, and flange holes that two spindles drill in one stroke.
#
# Two holes of one face that are the same in every figure are one hole that was written twice; it
# is drilled once, and the second is listed. Two holes on the two faces of a pair of spindles are
# one stroke if both are there with the same x, y, diameter, depth, kind and cone: 49.95 and 50.00
# are the same place, since that is what two exports of one model leave (`merge_tolerance`).
#
# The holes are walked in order of x, so that each looks only at those a tolerance further on.


_NEAR = (-1, 0, 1)


def drop_duplicates(holes: Group, tolerance: float) -> tuple[Group, dict[int, Placed]]:
    """Of `holes`, sorted, each once; and for the index of each dropped one which it repeats.

    Of holes that are the same the first of the part's features stays.
    """
    repeats: dict[int, Placed] = {}
    limit = tolerance + ROUNDING
    width = 2 * limit  # of a cell: holes that are the same lie in neighbours
    kept: defaultdict[tuple[int, int], list[Placed]] = defaultdict(list)
    for run in runs(holes, limit):
        if len(run) == 1:
            continue
        for placed in sorted(run, key=itemgetter(1)):
            x, f, hole = placed
            column, row = floor(x / width), floor(hole.y / width)
            cells = [kept.get((column + i, row + j), ()) for i in _NEAR for j in _NEAR]
            like = [p for cell in cells for p in cell if _is_same(p[2], hole, limit)]
            if like:
                repeats[f] = min(like, key=itemgetter(1))
            else:
                kept[column, row].append(placed)
    if not repeats:
        return holes, repeats
    return tuple([p for p in holes if p[1] not in repeats]), dict(sorted(repeats.items()))


def _is_same(a: Hole, b: Hole, limit: float) -> bool:
    """Whether two holes are on one face and the same in every figure."""
    return (
        a.face == b.face
        and abs(a.y - b.y) <= limit
        and abs(a.x - b.x) <= limit
        and a.diameter == b.diameter
        and (a.kind, a.depth, a.angle) == (b.kind, b.depth, b.angle)
    )


def alike(a: Hole, b: Hole, limit: float) -> bool:
    """Whether two holes are the same but for face and place."""
    deep = a.depth is b.depth
    if a.depth is not None and b.depth is not None:
        deep = abs(a.depth - b.depth) <= limit
    same = a.kind == b.kind and (a.angle or 0.0) == (b.angle or 0.0)
    return deep and same and abs(a.diameter - b.diameter) <= limit


def merge_pairs(holes: Group, partners: Mapping[Face, Face], drill: Drill) -> Iterator[Group]:
    """The holes, sorted, one by one, or two that are the same on a face and its partner.

    Each hole finds at most one partner, the nearest.
    """
    for run in runs(holes, drill.merge_tolerance + ROUNDING):
        if len(run) == 1:
            yield run
            continue
        taken: set[int] = set()
        for i, placed in enumerate(run):
            _, f, hole = placed
            if f in taken:
                continue
            face = partners.get(hole.face)
            partner = None if face is None else _partner(run, i, face, taken, drill)
            if partner is None:
                yield (placed,)
            else:
                taken.add(partner[1])
                yield (placed, partner) if hole.face < partner[2].face else (partner, placed)


def _partner(
    holes: Group, i: int, face: Face, taken: Collection[int], drill: Drill
) -> Placed | None:
    """The nearest hole behind `holes[i]` that is the same on `face` and has no partner yet."""
    reach, limit = drill.merge_tolerance + ROUNDING, drill.same_tool_tolerance + ROUNDING
    x, _, hole = holes[i]
    best: tuple[float, int] | None = None
    partner: Placed | None = None
    for j in range(i + 1, len(holes)):
        other_x, f, other = holes[j]
        dx = other_x - x
        if dx > reach:
            break
        if other.face != face or f in taken:
            continue
        dy = abs(other.y - hole.y)
        if dy <= reach and alike(hole, other, limit):
            rank = dx + dy, f
            if best is None or rank < best:
                best, partner = rank, holes[j]
    return partner


def _needs(hole: Hole, planner: PartPlanner) -> Diagnostic | None:
    """A spindle on its face; which tools it takes follows with its partner on the other flange."""
    if hole.face in planner.reached:
        return None
    return refuse_face(hole, f"{hole.kind} hole", planner.reached)


def _refusals(hole: Hole, planner: PartPlanner) -> Iterable[Diagnostic]:
    off = refuse_place(hole, hole.x, hole.y, planner.part, planner.reached[hole.face])
    if off is not None:
        return (off,)
    return planner.finished.judge(hole)


#: The faces that a pair of spindles drills at once, each with the other one.
partner_faces: PerObject[Machine, dict[Face, Face]] = PerObject(
    "planning.partner_faces",
    lambda machine: {a: b for p in machine.pairs for a, b in (p.faces, p.faces[::-1])},
)


def _steps(holes: Sequence[tuple[int, Hole]], planner: PartPlanner) -> list[Found]:
    drill = planner.library.drill
    placed = tuple(sorted((hole.x, f, hole) for f, hole in holes))
    kept, repeats = drop_duplicates(placed, drill.duplicate_tolerance)
    if diagnostics := list(refuse_many_pairs(kept, drill)):
        return [*diagnostics]
    steps: list[Found] = []
    for f, (_, like, first) in repeats.items():
        hole = planner.part.features[f]
        assert isinstance(hole, Hole)
        diagnostic = DUPLICATE.at(
            hole.source, found=f"{hole.diameter:g}", face=hole.face, x=f"{hole.x:g}",
            y=f"{hole.y:g}", first=first.source,
        )  # fmt: skip
        steps += [Settled(f, "duplicate", DUPLICATE.code, like), (f, diagnostic)]
    sinks: list[Group] = []
    is_tee = planner.part.profile.code == "T"  # o and u are one plate there: the tips would meet
    partners = {} if is_tee else partner_faces(planner.machine)
    for group in merge_pairs(kept, partners, drill):
        if group[0][2].kind == "countersink":
            sinks.append(group)
        else:
            steps += _make(group, planner)
    # A sink stands on its hole, wherever a merge has put that one; those of a pair are made one by
    # one if their holes differ in size or place.
    pilots = _pilots(kept, drill) if sinks else {}
    places = {
        f: (step.x, step.y)
        for step in (steps if sinks else ())
        if isinstance(step, WorkingStep)
        for f in step.features
    }
    for group in sinks:
        below = [pilots.get(f) for _, f, _ in group]
        at = [places.get(p[1]) if p else None for p in below]
        sizes = [p[2].diameter if p and a else None for p, a in zip(below, at, strict=True)]
        if len(set(zip(sizes, at, strict=True))) == 1:
            steps += _make(group, planner, sizes[0], at[0])
            continue
        for one, size, place in zip(group, sizes, at, strict=True):
            steps += _make((one,), planner, size, place)
    steps += refuse_too_near(kept, planner.machine.format.resolution, drill)
    steps += judge_pairs(kept, drill)
    return steps


def _make(
    group: Group, planner: PartPlanner, pilot: float | None = None, place: Point | None = None
) -> list[Found]:
    """The steps of a hole or a pair; a pair without a tool, or out of reach of a spindle, is two.

    `pilot` is the diameter of the hole that a countersink sinks, and `place` where that stands.
    """
    x, f, hole = group[0]
    y, why = hole.y, tuple[str, ...]()
    features: tuple[int, ...] = (f,)
    faces: tuple[Face, ...] = (hole.face,)
    diameters: tuple[float, ...] = (hole.diameter,)
    if len(group) == 2:
        other_x, other_f, other = group[1]
        x, y, features = (x + other_x) / 2, (y + other.y) / 2, (f, other_f)
        faces, why = (hole.face, other.face), ("merge-pair",)
        if other.diameter != hole.diameter:
            diameters = (hole.diameter, other.diameter)
    if f in planner.behind:
        why = (*why, "from-behind")
    if place is not None:
        x, y = place
    thickness = planner.part.profile.thickness(hole.face)
    work = HoleWork(
        hole.kind, diameters, hole.depth, hole.angle, faces, thickness, planner.number(faces), why,
        pilot,
    )  # fmt: skip
    toolings = toolings_of(planner.library, work)
    if not isinstance(toolings, tuple):
        if len(group) == 2:
            return _one_by_one(group, planner, pilot, place)
        values = {"x": f"{x:g}", "y": f"{y:g}", **toolings.values}
        return [(f, toolings.rule.at(hole.source, **values))]
    steps = []
    for tooling in toolings:
        path: tuple[Point, ...] = ()
        if tooling.ring:
            mill, tolerance = tooling.tools[0].diameter, planner.library.drill.path_tolerance
            is_blind = tooling.depth is not None
            path = pocket_path((x, y), (0.0, 0.0), 0.0, tooling.ring, mill, tolerance, is_blind)
        steps.append(WorkingStep(x, y, tooling, features, hole.source, path))
    if len(group) == 2 and any(refuse_steps(planner.part.features, steps, planner.travel)):
        return _one_by_one(group, planner, pilot, place)
    made: list[Found] = [*steps]
    drill = toolings[0].tools[0]
    is_blind = hole.depth is not None and drill.kind == "drill" and thickness > 0
    for _, f, hole in group if is_blind else ():
        out = (hole.depth or 0.0) + drill.tip - thickness
        if hole.depth is None or hole.kind != "blind" or hole.depth > thickness + TOLERANCE:
            continue
        if out > TOLERANCE:  # the point comes through
            diagnostic = BLIND_POINT.at(
                hole.source, what=named(hole), found=f"{hole.depth:g}", x=f"{hole.x:g}",
                y=f"{hole.y:g}", face=hole.face, out=f"{out:.3g}", expected=f"{thickness:g}",
            )  # fmt: skip
            made.append((f, diagnostic))
    return made


def _one_by_one(
    group: Group, planner: PartPlanner, pilot: float | None, place: Point | None
) -> list[Found]:
    """The steps of two holes that one stroke of both spindles does not make."""
    return [step for one in group for step in _make((one,), planner, pilot, place)]


def _pilots(holes: Group, drill: Drill) -> dict[int, Placed]:
    """For each countersink the hole that it sinks: of its face and place, the widest below it."""
    pilots = {}
    limit = drill.merge_tolerance
    along = [x for x, _, _ in holes]
    for x, f, sink in holes:
        if sink.kind != "countersink":
            continue
        begin = bisect_left(along, x - limit - ROUNDING)
        end = bisect_right(along, x + limit + ROUNDING)
        below = [
            placed
            for placed in holes[begin:end]
            for hole in (placed[2],)
            if hole.kind in SUNK
            and hole.face == sink.face
            and max(abs(hole.x - sink.x), abs(hole.y - sink.y)) <= limit
            and hole.diameter < sink.diameter
        ]
        if below:
            pilots[f] = max(below, key=lambda placed: (placed[2].diameter, placed[1]))
    return pilots


HOLE = WorkKind("hole", _needs, _refusals, _steps, REASONS)
