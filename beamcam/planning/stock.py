"""The bar that parts are cut from, of those in store: the shortest that will do."""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.planning.operations.rules import BAR_LEFT
from beamcam.planning.rules import BAR_FULL, BAR_SHORT

Made = TypeVar("Made")


def from_store(
    make: Callable[[float | None], Made], lengths: Sequence[float], longest_part: float
) -> Made:
    """What `make` gives for the first of `lengths` (mm, rising) that is not too short.

    Without any it is asked for None, a bar as long as the parts need. Raises PlanError as `make`
    does; where all bars are too short, for the longest.
    """
    if not lengths:
        return make(None)
    *shorter, longest = lengths
    for length in shorter:
        if length < longest_part:
            continue
        try:
            return make(length)
        except PlanError as error:
            if not _is_too_short(error.diagnostics):
                raise
    return make(longest)


def _is_too_short(said: Iterable[Diagnostic]) -> bool:
    """Whether a longer bar would help."""
    return {d.code for d in errors_in(said)} <= {
        BAR_FULL.code,
        BAR_SHORT.code,
        BAR_LEFT.code,
    }
