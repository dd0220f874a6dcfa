"""What the read-back found, beside what the plan and the job say.

What is left out, moved or for manual work has to be the same in both. Texts that are alike may
stand in for each other: a program does not say which of them is which, so that plan and read-back
may each share out their places by its own lights.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.head import HEAD_TEXT, head_faults, head_of
from beamcam.checks.request import LEDGER, TEXT_TOLD, UNCUT, UNCUT_TOLD
from beamcam.checks.request import LEFT_OUT as MISSING
from beamcam.checks.request import MANUAL_WORK as FOR_MANUAL_WORK
from beamcam.checks.request import TEXT_MOVED as MOVED
from beamcam.checks.rules import BAR_NEEDED, BAR_TOLD
from beamcam.errors import Diagnostic, Severity, Source
from beamcam.model.part import Part
from beamcam.model.plan import AnyPlan, Plan
from beamcam.model.request import Job
from beamcam.planning.left_out import TEXT_MOVED, left_out_sources, manual_work_sources
from beamcam.posts import Written, beginning, carries_head

TOLD_BAR = 0.001  #: mm that lengths of bars in messages are rounded to
TOLD_STEP = 0.1  #: mm that places and heights in messages are rounded to

Place = tuple[float, ...]  #: x, y and height


def other_than_planned(
    plan: AnyPlan, diagnostics: Iterable[Diagnostic], job: Job
) -> Iterator[Diagnostic]:
    """What the read-back found; what is not made only where the plan says otherwise.

    The features that it found missing, and that may be, are those that the plan left out by name;
    the marks that it found to be manual work are those on the plan's list; the contours with waste
    that no beam reaches are those that the plan reports; the bar that it needs where nobody gave
    its length is no longer than the plan's.
    """
    missing: list[tuple[str, Source]] = []
    refused = False
    moved: list[Diagnostic] = []
    for diagnostic in diagnostics:
        if diagnostic.code in (MISSING.code, FOR_MANUAL_WORK.code):
            missing.append((diagnostic.code, diagnostic.source))
        elif diagnostic.code == MOVED.code:
            moved.append(diagnostic)
        elif diagnostic.code == UNCUT.code:
            yield from _untold(plan, diagnostic)
        elif diagnostic.code == HEAD_TEXT.code:  # which was written for these very parts
            refused = True
            yield replace(diagnostic, severity=Severity.ERROR)
        elif diagnostic.code == BAR_NEEDED.code and isinstance(plan, Plan):
            if (
                float(diagnostic["found"])
                > plan.bar.length + job.machine.format.resolution + TOLD_BAR
            ):
                expected = f"{plan.bar.length:.3f}"
                yield BAR_TOLD.at(diagnostic.source, found=diagnostic["found"], expected=expected)
        else:
            refused = refused or diagnostic.severity is Severity.ERROR
            yield diagnostic
    if refused:  # what is missing may not have been looked for
        return
    hand = [*manual_work_sources(plan)]
    remarks = [diagnostic for diagnostic in plan.remarks if diagnostic.code == TEXT_MOVED.code]
    named = [(MISSING.code, source) for source in left_out_sources(plan)]
    named += [(FOR_MANUAL_WORK.code, source) for source in hand]
    if not (remarks or moved or missing or named):  # as of nearly every plan
        return
    alike = stand_ins(job.parts)
    yield from other_places(remarks, moved, alike, hand)
    lacking, planned = _of_the_first(missing, alike), _of_the_first(named, alike)
    for code, source in (lacking - planned) + (planned - lacking):
        one = code, source
        yield LEDGER.at(source, found=lacking[one], expected=planned[one])


def _of_the_first(
    missing: Iterable[tuple[str, Source]], alike: Mapping[Source, Source]
) -> Counter[tuple[str, Source]]:
    """What is missing, each text by the first of those that are alike."""
    return Counter((code, alike.get(source, source)) for code, source in missing)


def _untold(plan: AnyPlan, uncut: Diagnostic) -> Iterator[Diagnostic]:
    """An error for waste that stays in a corner of a contour, unless the plan reports it."""
    from beamcam.planning.contours.rules import LEFT

    diagnostics = [d for d in plan.remarks if d.code == LEFT.code]
    place = uncut["x"], uncut["y"]
    if not any(d.source == uncut.source or (d["x"], d["y"]) == place for d in diagnostics):
        yield UNCUT_TOLD.at(uncut.source, **dict(uncut.values))


def head_differences(
    job: Job, plan: AnyPlan, written: Written, diagnostics: Sequence[Diagnostic]
) -> Iterable[Diagnostic]:
    """Differences of a program's head from the job and from what its read-back said."""
    if not carries_head(job):
        return ()
    told_bar = isinstance(plan, Plan) and job.machine.saw is not None
    bar = plan.bar.length if isinstance(plan, Plan) and told_bar else None
    missing, manual_work = (
        sum(one.code == of.code for one in diagnostics) for of in (MISSING, FOR_MANUAL_WORK)
    )
    return head_faults(head_of(beginning(written)), job, bar, missing, manual_work)


# --- places of texts ------------------------------------------------------------------------------


class _LetteredAt(Struct, frozen=True):
    """The place and height that a message about a text gives it."""

    source: Source
    place: Place
    drawn_at: Place
    letters: str

    def __str__(self) -> str:
        x, y, height = self.place
        return f"at x {x:g}, y {y:g}, {height:g} mm high"

    def is_at(self, places: Iterable[Place]) -> bool:
        """Whether it is at one of some places, each rounded to `TOLD_STEP`."""
        return any(
            max(abs(a - b) for a, b in zip(self.place, place, strict=True)) <= 1.01 * TOLD_STEP
            for place in places
        )


def stand_ins(parts: Sequence[Part]) -> dict[Source, Source]:
    """For the source of each text that of the first which is alike.

    They have the same letters and face and stand at the same angle; on bars they are texts of one
    part, while on a sheet one part's may stand for another's.
    """
    looks: dict[Source, set[tuple[object, ...]]] = {}
    for part in parts:
        for one in part.texts:
            of = ("", "") if part.profile.code == "B" else (one.source.file, part.mark)
            look = *of, one.text, one.face, one.angle % 360.0
            looks.setdefault(one.source, set()).add(look)
    first: dict[object, Source] = {}
    return {source: first.setdefault(frozenset(each), source) for source, each in looks.items()}


def other_places(
    remarks: Iterable[Diagnostic], diagnostics: Iterable[Diagnostic],
    alike: Mapping[Source, Source], manual_work: Collection[Source],
) -> Iterator[Diagnostic]:  # fmt: skip
    """Texts that are found moved elsewhere than the plan tells, or of which it tells nothing.

    `manual_work` are the sources of marks that the plan left for manual work; which of several
    equal texts these are, a program does not tell either.
    """
    groups: dict[tuple[Source, str], tuple[list[_LetteredAt], list[_LetteredAt]]] = {}
    for which, messages in enumerate((remarks, diagnostics)):
        for diagnostic in messages:
            one = _lettered_at(diagnostic)
            group = alike.get(one.source, one.source), one.letters
            groups.setdefault(group, ([], []))[which].append(one)
    left = {alike.get(source, source) for source in manual_work}
    for (source, _), (planned, moved) in groups.items():
        yield from _differences(planned, moved, source in left)


def _differences(
    planned: Sequence[_LetteredAt], moved: Sequence[_LetteredAt], is_one_left: bool
) -> Iterator[Diagnostic]:
    """What differs of texts that are alike.

    Of a text that was moved to where the part has another of them, that other is found in place.
    """
    theirs, ours = {one.drawn_at for one in planned}, {one.drawn_at for one in moved}
    elsewhere = [one for one in moved if not one.is_at(each.place for each in planned)]
    untold = [one for one in planned if not one.is_at(each.place for each in moved)]
    if not elsewhere and not untold and theirs != ours and not is_one_left:
        elsewhere = [one for one in moved if one.drawn_at not in theirs]
        untold = [one for one in planned if one.drawn_at not in ours]
    else:
        elsewhere = [one for one in elsewhere if not one.is_at(ours - theirs - {one.drawn_at})]
        untold = [one for one in untold if not one.is_at(theirs - ours - {one.drawn_at})]
    for one in elsewhere:
        yield TEXT_TOLD.at(one.source, found=one, expected="elsewhere")
    for one in untold:
        yield TEXT_TOLD.at(one.source, found="elsewhere", expected=one)


def _lettered_at(diagnostic: Diagnostic) -> _LetteredAt:
    """The place of a text in a message, of a plan or of the read-back."""
    at, drawn_at = (
        tuple(float(diagnostic[f"{which}{name}"]) for name in ("x", "y", "height"))
        for which in ("", "wanted_")
    )
    return _LetteredAt(diagnostic.source, at, drawn_at, str(diagnostic["text"]))
