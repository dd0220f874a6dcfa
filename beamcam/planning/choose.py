"""How a part lies, and in which order parts lie on a bar, where the planner may choose.

Each of the eight turns of a part is tried. One is out if the section does not lie so on the
rollers or if the machine cannot make something of the part that way; of the others the one is
taken that needs the least time, and as given if that is as good.

Parts that share the angle of a mitre lie side by side, since one cut makes both ends and no wedge
is lost. For each two parts the length that is saved is known, so the best order is the path
through all parts that saves most: exact for few parts (M. Held, R. M. Karp, A dynamic programming
approach to sequencing problems, 1962), and for many a greedy path, part by part.
"""

from collections.abc import Collection, Sequence
from itertools import pairwise

from msgspec import Struct

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine, Saw
from beamcam.model.part import Part
from beamcam.model.plan import AS_GIVEN, Operation, Piece
from beamcam.planning import rules
from beamcam.planning.bar import Ends, cuts_of, share_cut
from beamcam.planning.ends import End
from beamcam.planning.order import sort_along_x
from beamcam.planning.times import time_of
from beamcam.planning.tool_choice import spindle_operations
from beamcam.planning.tools import rack_of
from beamcam.planning.turning import TURNS, Turn, lies, turn_between, turned
from beamcam.planning.work import Work, work_on

EXACT_ORDER = 9  #: parts whose best order is searched for among all
MIN_GAIN_S = 1.0  #: a turn that gains less is not worth the lifting


class Trial(Struct, frozen=True):
    """One of the eight ways that a part may lie, and what came of it."""

    turn: Turn
    part: Part
    seconds: float | None  #: of its work alone; None if it is out
    because: str  #: why it is out, or ""


class Choice(Struct, frozen=True):
    """How a part shall lie."""

    part: Part
    turn: str
    remarks: tuple[Diagnostic, ...]


def try_turns(part: Part, machine: Machine, skips: Collection[str]) -> tuple[Trial, ...]:
    """All eight ways that a part may lie, in the order of `TURNS`."""
    trials: list[Trial] = []
    for turn in TURNS:
        if not lies(part.profile, turn):
            because = f"a {part.profile.code} does not lie so on the rollers"
            trials.append(Trial(turn, part, None, because))
            continue
        lying = turned(part, turn)
        same = next((t for t in trials if t.seconds is not None and _is_same(t.part, lying)), None)
        if same is not None:
            trials.append(Trial(turn, lying, None, f"no different from {same.turn.name!r}"))
            continue
        work = _work(lying, machine, skips)
        # What would be left out by leave is better made, if the part lies another way.
        out = [*work.refusals, *work.skipped.values()]
        if work.refusals:
            trials.append(Trial(turn, lying, None, f"{out[0].code}: {out[0].message}"))
        else:
            seconds = _seconds(lying, work, machine) + SKIP_WEIGHT_S * len(work.skipped)
            trials.append(Trial(turn, lying, seconds, ""))
    return tuple(trials)


SKIP_WEIGHT_S = 1e6  #: so that a way that leaves nothing out is always the better one


def _is_same(a: Part, b: Part) -> bool:
    """Whether two parts are one piece of steel and lie the same way."""
    found = turn_between(a, b)
    return found is not None and found.name == AS_GIVEN


def _work(part: Part, machine: Machine, skips: Collection[str]) -> Work:
    if machine.saw is None:
        raise TypeError(f"{machine.name} has no saw")
    return work_on(part, machine, machine.saw, rack_of(machine), skips)


def _seconds(part: Part, work: Work, machine: Machine) -> float:
    """Time of the work on a part alone."""
    saw, drill, layout = machine.saw, machine.drill, machine.layout
    if saw is None or drill is None or layout is None:
        raise TypeError(f"{machine.name} has no saw, drill and layout")
    pieces = (Piece(part, layout.front_trim),)
    operations: list[Operation] = [
        *cuts_of(pieces, [work.ends], saw), *spindle_operations(pieces, [work], drill)
    ]  # fmt: skip
    ordered = sort_along_x(operations, machine.format.resolution, layout.order, machine.times)
    return time_of(ordered, part.profile, (part.grade,), machine).total_s


def choose_turns(
    parts: Sequence[Part], machine: Machine, skips: Collection[str]
) -> tuple[Choice, ...]:
    """How each of the parts on one bar shall lie.

    A bar lies one way for all of them: if the best turns would set it on its web for one part and
    on its flange for another, all lie as given or all are set on the other side.
    """
    trials = {id(part): try_turns(part, machine, skips) for part in parts}
    for allowed in ((False, True), (False,), (True,)):
        choices = {id(p): _choose(p, [t for t in trials[id(p)] if t.turn.swap in allowed])
                   for p in parts}  # fmt: skip
        made = [choices[id(p)] for p in parts]
        found = [c for c in made if c is not None]
        if len(found) == len(made) and len({c.part.profile for c in found}) == 1:
            return tuple(found)
    return tuple(Choice(part, AS_GIVEN, ()) for part in parts)


def _choose(part: Part, trials: Sequence[Trial]) -> Choice | None:
    """The best of some of the ways; None if the part can be made in none of them."""
    made = [t for t in trials if t.seconds is not None]
    if not made:
        return None
    best = min(made, key=lambda t: (round((t.seconds or 0.0) / MIN_GAIN_S), TURNS.index(t.turn)))
    given = trials[0]
    if given.turn is not TURNS[0]:
        reason = "as the other parts on the bar have to lie"
    elif given.seconds is None:
        reason = f"as given it cannot be made ({given.because.partition(':')[0]})"
    else:
        gain = given.seconds - (best.seconds or 0.0)
        if best is given or gain < MIN_GAIN_S:
            return Choice(part, AS_GIVEN, ())
        reason = f"{gain:.1f} s less than as given"
        if gain >= SKIP_WEIGHT_S / 2:
            reason = "so nothing has to be left out"
    said = rules.TURNED.at(part.source, found=best.turn.name, reason=reason)
    return Choice(best.part, best.turn.name, (said,))


def turn_that_helps(
    parts: Sequence[Part], machine: Machine, skips: Collection[str]
) -> tuple[Diagnostic, ...]:
    """For each part that cannot be made as given, the turn that would help, if one does."""
    said = []
    for part in {id(p): p for p in parts}.values():
        trials = try_turns(part, machine, skips)
        if trials[0].seconds is None:
            helping = next((t for t in trials if t.seconds is not None), None)
            if helping is not None:
                said.append(rules.TURN_HELPS.at(part.source, found=helping.turn.name))
    return tuple(said)


def best_order(
    parts: Sequence[Part], ends: Sequence[Ends], saw: Saw
) -> tuple[list[int], tuple[Diagnostic, ...]]:
    """The order of parts that saves most of the bar by common cuts, as indices; and a remark.

    Of orders that save as much the one nearest to the given order, by its indices, comes out of
    up to `EXACT_ORDER` parts.
    """
    count = len(parts)

    def saved(i: int, j: int) -> float:
        return _saved(parts[i], ends[i][1], ends[j][0], saw) if i != j else 0.0

    saves = [[saved(i, j) for j in range(count)] for i in range(count)]
    order = _exact(saves) if count <= EXACT_ORDER else _greedy(saves)
    gain = _total(order, saves) - _total(list(range(count)), saves)
    if gain <= 1e-9:
        return list(range(count)), ()
    shown = " ".join(parts[i].mark for i in order)
    reason = f"{gain:.1f} mm less bar than as given"
    return order, (rules.ORDER.at(parts[0].source, found=shown, reason=reason),)


def _saved(part: Part, end: End, start: End, saw: Saw) -> float:
    """Length of bar that two ends side by side need less by a common cut; 0 if they share none."""
    if not share_cut(end, start, saw):
        return 0.0
    # As in bar.lay_on_bar: by x0 - length of the end, less x0 of the start, they overlap.
    return part.length - end.x0 + start.x0


def _total(order: Sequence[int], saves: Sequence[Sequence[float]]) -> float:
    return sum(saves[a][b] for a, b in pairwise(order))


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
                found = (cost - saves[last][after], (*path, after))
                if key not in best or found < best[key]:
                    best[key] = found
    full = (1 << count) - 1
    return list(min(best[full, last] for last in range(count))[1])


def _greedy(saves: Sequence[Sequence[float]]) -> list[int]:
    """A path that joins, of all parts not yet joined, the two that save most, again and again."""
    count = len(saves)
    after: dict[int, int] = {}
    before: dict[int, int] = {}
    chain = list(range(count))

    def head(i: int) -> int:
        while chain[i] != i:
            i = chain[i]
        return i

    pairs = sorted(
        (-saves[i][j], i, j) for i in range(count) for j in range(count) if saves[i][j] > 0
    )
    for _, i, j in pairs:
        if i not in after and j not in before and head(i) != head(j):
            after[i], before[j] = j, i
            chain[head(j)] = head(i)
    order: list[int] = []
    for i in range(count):
        if i not in before:
            while True:
                order.append(i)
                if i not in after:
                    break
                i = after[i]
    return order
