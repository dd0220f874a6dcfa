"""A part as one machine leaves it to the next: what is to be made, and what is there.

The ends are there, as the saw or torch of the first machine made them: the header says how.
"""

from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic, error
from beamcam.machine.machine import Machine
from beamcam.model.part import EndCuts, FileComment, Part
from beamcam.model.plan import NOT_MADE, AnyPlan
from beamcam.planning.operations.finished_part import ends_of

BEGUN = error("plan-begun",
    "found a part that another machine has begun; expected a whole one, {machine} makes its ends",
    "What a machine leaves goes to one that takes pieces whose ends are there: a coper, or a "
    "line without a saw.")  # fmt: skip


def refuse_begun(parts: Sequence[Part], machine: Machine) -> Iterator[Diagnostic]:
    """An error for each part that another machine has begun, of a machine that makes the ends."""
    if machine.coper is not None or (machine.stock == "beam" and machine.saw is None):
        return
    for part in parts:
        if part.made is not None:
            yield BEGUN.at(part.source, machine=machine.name)


def begun_part(part: Part, plan: AnyPlan, machine: Machine) -> Part:
    """The part as the next machine gets it, by the plan of a program that makes no other.

    Its features are those that the plan leaves out or leaves for manual work, in their order.
    Comments that stood before one that is made are left out. Raises PlanError as `ends_of` does.
    """
    left = [one.feature[1] for one in plan.outcomes if not one.feature[0] and one.how in NOT_MADE]
    there = [f for k, f in enumerate(part.features) if k not in left]
    cuts = part.cuts
    if machine.saw is not None:
        (start, end), _ = ends_of(part, machine.saw)
        cuts = EndCuts(start.web_deg, end.web_deg, start.flange_deg, end.flange_deg)
    comments: list[FileComment] = []
    for comment in part.comments:
        words = comment.before.split(":")
        at = words.index("feature") + 1 if "feature" in words else 0
        if not at:
            comments.append(comment)
        elif int(words[at]) in left:
            words[at] = str(left.index(int(words[at])))
            comments.append(replace(comment, before=":".join(words)))
    return replace(
        part, cuts=cuts, cut_lines=None, comments=tuple(comments),
        features=tuple(part.features[k] for k in left), made=(*(part.made or ()), *there),
    )  # fmt: skip
