"""The turn of a part on the rollers, where the planner may choose.

Each of the eight turns of a part is tried. One is out if the section does not lie so on the
rollers or if the machine cannot make something of the part that way; of the others the one is
taken that needs the least time, and as given if that is as good.
"""

from collections.abc import Collection, Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic
from beamcam.model.part import Part
from beamcam.model.plan import AS_GIVEN, Piece
from beamcam.planning import rules
from beamcam.planning.operations.line import BarLine
from beamcam.planning.operations.work import PartWork, operations_on, work_on
from beamcam.planning.order import sort_along_x
from beamcam.planning.stock import refuse_size
from beamcam.planning.times import time_of
from beamcam.planning.turning import TURNS, Turn, alike, lies, turned

MIN_GAIN_S = 1.0  #: a turn that gains less is not worth the lifting


class Trial(Struct, frozen=True):
    """One of a part's eight orientations, and its result."""

    turn: Turn
    part: Part
    seconds: float | None  #: of its work alone; None if it is out
    because: str  #: why it is out, or ""


class Orientation(Struct, frozen=True):
    """The chosen orientation of a part."""

    part: Part
    turn: str
    remarks: tuple[Diagnostic, ...]


def try_turns(part: Part, line: BarLine, skips: Collection[str]) -> tuple[Trial, ...]:
    """All eight orientations of a part, in the order of `TURNS`."""
    trials: list[Trial] = []
    for turn in TURNS:
        if not lies(part.profile, turn):
            because = f"a {part.profile.code} does not lie so on the rollers"
            trials.append(Trial(turn, part, None, because))
            continue
        lying = turned(part, turn)
        same = next((t for t in trials if t.seconds is not None and alike(t.part, lying)), None)
        if same is not None:
            trials.append(Trial(turn, lying, None, f"no different from {same.turn.name!r}"))
            continue
        too_large = next(refuse_size(lying, line), None)
        if too_large is not None:
            trials.append(Trial(turn, lying, None, f"{too_large.code}: {too_large.message}"))
            continue
        work = work_on(lying, line, skips)
        # What `--allow-skips` would leave out is better made, in another orientation.
        out = [*work.refusals, *work.skipped.values()]
        if work.refusals:
            trials.append(Trial(turn, lying, None, f"{out[0].code}: {out[0].message}"))
        else:
            seconds = _seconds(work, line) + SKIP_WEIGHT_S * len(work.skipped)
            trials.append(Trial(turn, lying, seconds, ""))
    return tuple(trials)


SKIP_WEIGHT_S = 1e6  #: so that an orientation that leaves nothing out is always preferred


def _seconds(work: PartWork, line: BarLine) -> float:
    """Time of the work on a part alone."""
    pieces = (Piece(work.part, line.layout.front_trim),)
    ordered = sort_along_x(*operations_on(pieces, (work,), line), line.machine)
    return time_of(ordered, pieces, line.machine).total_s


def choose_turns(
    parts: Sequence[Part], line: BarLine, skips: Collection[str]
) -> tuple[Orientation, ...]:
    """The orientation of each part on one bar.

    A bar lies one way for all of them: if the best turns would set it on its web for one part and
    on its flange for another, all lie as given or all are set on the other side.
    """
    trials = {id(part): try_turns(part, line, skips) for part in parts}
    for allowed in ((False, True), (False,), (True,)):
        choices = {id(p): _choose(p, [t for t in trials[id(p)] if t.turn.swap in allowed])
                   for p in parts}  # fmt: skip
        made = [choices[id(p)] for p in parts]
        found = [c for c in made if c is not None]
        if len(found) == len(made) and len({c.part.profile for c in found}) == 1:
            return tuple(found)
    return tuple(Orientation(part, AS_GIVEN, ()) for part in parts)


def _choose(part: Part, trials: Sequence[Trial]) -> Orientation | None:
    """The best of some orientations; None if the part can be made in none of them."""
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
            return Orientation(part, AS_GIVEN, ())
        reason = f"{gain:.1f} s less than as given"
        if gain >= SKIP_WEIGHT_S / 2:
            reason = "so nothing has to be left out"
    said = rules.TURNED.at(part.source, found=best.turn.name, reason=reason)
    return Orientation(best.part, best.turn.name, (said,))


def turn_that_helps(
    parts: Sequence[Part], line: BarLine, skips: Collection[str]
) -> tuple[Diagnostic, ...]:
    """For each part that cannot be made as given, the turn that would help, if one does."""
    said = []
    for part in {id(p): p for p in parts}.values():
        trials = try_turns(part, line, skips)
        if trials[0].seconds is None:
            helping = next((t for t in trials if t.seconds is not None), None)
            if helping is not None:
                said.append(rules.TURN_HELPS.at(part.source, found=helping.turn.name))
    return tuple(said)
