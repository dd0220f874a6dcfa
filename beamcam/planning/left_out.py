"""What a program does not make of its parts, or makes otherwise than by cutting, reported by name.

Nothing that a part has is missing from a program without a word: what was left out because
`--allow-skips` names its kind, or is left for manual work, is a warning at the feature. The list of
manual work (`manual_list.py`) has a row for each.
"""

from collections import Counter
from collections.abc import Iterable, Iterator

from beamcam.errors import Diagnostic, Source, error, note, warning
from beamcam.machine.stations import Marks
from beamcam.machine.torch import Torch
from beamcam.model.description import description
from beamcam.model.part import Bend, Camber, Contour, Feature, TextMark
from beamcam.model.plan import AnyPlan, Outcome, SheetPlan, unfinished
from beamcam.model.request import mark_kind, policy_on
from beamcam.planning import rules

#: What may be left out of a program: codes of refusals by the kinds of work, without their "plan-".
SKIP_NAMES = (
    "tool", "countersink", "sink-depth", "thread-depth", "face", "reach", "stroke", "axis",
    "off-face", "slot", "cope", "cutout", "mark", "bevel", "other",
)  # fmt: skip
ALL_SKIPS = "all"  #: in place of the names of all kinds of features


def named_skips(words: Iterable[str]) -> tuple[str, ...]:
    """The kinds of features that are named, each once and in order; `all` names every kind."""
    names = set(words)
    if ALL_SKIPS in names:
        names = (names - {ALL_SKIPS}) | {*SKIP_NAMES}
    return tuple(sorted(names))


TEXT_MOVED = warning("plan-text-moved",
    "the text {text!r} is lettered at x {x}, y {y}, {height} mm high; found no room {distance} mm "
    "clear at x {wanted_x}, y {wanted_y}, {wanted_height} mm high",
    "Letters on an edge or over a hole cannot be read. `marks.min_distance` and `marks.min_height` "
    "of the machine file say how much room is kept, and how small letters may be.")  # fmt: skip
TEXT_SIGN = warning("plan-text-sign",
    "found {sign!r} in the text {text!r}; expected a character of {has}, {other!r} is written",
    "`marks.replace` of the machine file says what is written for a character that no letter of "
    "the font, or of the stamp or printer, stands for.")  # fmt: skip
TEXT_HEIGHT = note("plan-text-height",
    "found the text {text!r} {found} mm high; it is lettered {height} mm high, the nearest of the "
    "machine's",
    "`marks.heights` of the machine file says in which heights its stamp or printer "
    "letters.")  # fmt: skip
TEXT_SEARCH = error("plan-text-search",
    "found no end of the search for a place of the text {text!r} on face {face} in {most} steps; "
    'expected room where the part has it, fewer texts, or text = "list" in [marks]',
    "A text is moved to the nearest place that is clear. Among hundreds of texts or holes that may "
    "take for good; so that none is left out that has a place, the part is refused.")  # fmt: skip

#: Why a mark is left for manual work, by its name in the ledger.
BY_POLICY, NO_UNIT = "marks", "no-unit"
NO_ROOM, TOO_SMALL, BLANK, FACE = "no-room", "too-small", "blank", "face"
CHARACTERS, ANGLE, HEIGHT = "characters", "angle", "height"
NOT_MOVED = "not-moved"
#: Of features that are only begun by the machine.
DRILL, BEVEL, ROOT, BEND, CAMBER = "drill", "bevel", "root", "bend", "camber"
REASONS = {
    BY_POLICY: "the machine file leaves such marks for manual work",
    NO_UNIT: "the machine has no unit that letters",
    NO_ROOM: "there is no room for it on its face",
    TOO_SMALL: "the machine does not letter so small",
    BLANK: "none of its characters can be seen",
    FACE: "the lettering unit does not reach that face",
    CHARACTERS: "the machine has no characters for it",
    ANGLE: "the machine does not letter at that angle",
    NOT_MOVED: "it is not clear of edges and holes there, and the machine moves no text",
    HEIGHT: "the machine does not letter at that height, which is binding",
    DRILL: "the torch cannot make it and marks its centre for the drill",
    BEVEL: "the torch cuts square what is bevelled or skew through the wall",
    ROOT: "the torch leaves steel at a root, where it does not reach",
    BEND: "the machine makes the blank, and does not bend",
    CAMBER: "the machine makes the straight beam, and does not camber it",
}


def listed_by(feature: Feature, marks: Marks) -> str | None:
    """Why a mark is manual work wherever it is; None if it is not."""
    policy = policy_on(feature, marks)
    if policy == "make" and isinstance(feature, TextMark) and marks.unit == "none":
        return NO_UNIT
    if policy != "list":
        return None
    if isinstance(feature, Camber):
        return CAMBER
    return BEND if isinstance(feature, Bend) else BY_POLICY


def refuse_mark(feature: Feature, marks: Marks) -> Diagnostic | None:
    """Why a mark is refused whatever the machine could do; None if it is not."""
    if policy_on(feature, marks) != "refuse":
        return None
    why = f'marks.{mark_kind(feature)} of the machine file is "refuse"'
    face = getattr(feature, "face", "")
    return rules.MARK.at(feature.source, found=_named(feature), face=face, why=why)


def _named(feature: Feature) -> str:
    match feature:
        case TextMark():
            return f"the text {feature.text!r}"
        case Contour():
            return f"{sum(curve.length for curve in feature.curves):g} mm of line"
        case _:
            return "a centre punch"


LEFT_OUT = warning("plan-left-out",
    "found {what}, which the machine cannot make; left out, as --allow-skips {kind} allows",
    "The part is not finished when the program ends: what is left out has to be made manually or "
    "on another machine. `--exit-left-out` gives it an exit status of its own.")  # fmt: skip
MANUAL_WORK = warning("plan-by-hand",
    "found {what}; {why}; it is on the list of manual work",
    "The part is posted without the mark, which has to be made manually. The list of manual work "
    "is written beside the program; `[marks]` in a machine file says what becomes of each kind of "
    "mark.")  # fmt: skip


def told(plan: AnyPlan, torch: Torch | None) -> Iterator[Diagnostic]:
    """A warning for each feature that was left out, and remarks on each look that is not cut.

    Nor is it taken for granted that lines with gaps are to be cut, and closed contours not.
    """
    left = unfinished(plan.outcomes)
    skipped = [outcome for outcome in left if _is_by_name(outcome)]
    # A part that is on the bar several times is reported once.
    yield from dict.fromkeys(_left_out(plan, outcome) for outcome in skipped)
    listed = [outcome for outcome in left if outcome.manual_work]
    yield from dict.fromkeys(_manual_work(plan, outcome) for outcome in listed)
    if isinstance(plan, SheetPlan) and torch is not None:
        from beamcam.planning.map_keys import map_remarks

        yield from map_remarks(plan, torch)


def left_out_sources(plan: AnyPlan) -> Iterator[Source]:
    """Source of each feature that was left out because `--allow-skips` names its kind."""
    for outcome in unfinished(plan.outcomes):
        if _is_by_name(outcome):
            piece, index = outcome.feature
            yield plan.pieces[piece].part.features[index].source


def left_out_kinds(plan: AnyPlan) -> Counter[str]:
    """How many features of each kind were left out because `--allow-skips` names it."""
    left = unfinished(plan.outcomes)
    return Counter(one.by.removeprefix("plan-") for one in left if _is_by_name(one))


def manual_work_sources(plan: AnyPlan) -> Iterator[Source]:
    """Source of each mark that is left for manual work."""
    for outcome in unfinished(plan.outcomes):
        if outcome.manual_work:
            piece, index = outcome.feature
            yield plan.pieces[piece].part.features[index].source


def _is_by_name(outcome: Outcome) -> bool:
    """Whether a feature was left out because `--allow-skips` names its kind.

    What is mapped away, or too small to be cut, nobody has to name; other messages report it.
    """
    return outcome.how == "skipped" and outcome.by.removeprefix("plan-") in SKIP_NAMES


def _left_out(plan: AnyPlan, outcome: Outcome) -> Diagnostic:
    piece, index = outcome.feature
    feature = plan.pieces[piece].part.features[index]
    kind = outcome.by.removeprefix("plan-")
    return LEFT_OUT.at(feature.source, what=description(feature), kind=kind)


def _manual_work(plan: AnyPlan, outcome: Outcome) -> Diagnostic:
    piece, index = outcome.feature
    feature = plan.pieces[piece].part.features[index]
    return MANUAL_WORK.at(
        feature.source, what=description(feature), why=REASONS[outcome.manual_work]
    )
