"""What of a cut is run with the arc out: what follows where its contour is closed, and no more."""

from collections.abc import Iterator, Sequence

import numpy as np

from beamcam.errors import Diagnostic, Source
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.overcut import asked_overcut
from beamcam.verify.sheets.work import SHOWN, Traced, Work


def dark_faults(work: Work, traced: Sequence[Traced], asked: bool) -> Iterator[Diagnostic]:
    """Cuts that are left dark before they are closed, or burn on behind that where they must not.

    `asked` says that the arc goes out where a cut with an overcut is closed.
    """
    told, by_machine = 0, work.torch.kerf_by == "machine"
    for t in traced:
        last = int(np.searchsorted(work.of_way, work.of_way[t.first], "right"))
        closed = t.closed and len(t.members) == 1
        closed = closed and bool((by_machine and t.half_kerf) or asked_overcut(work, t, t.over))
        due = closed and asked and work.process == "cut"
        dark, beyond = t.stroke.dark, last - t.last if due else 0
        if dark == beyond and bool(dark) == due:
            continue
        if due and dark and _closes(work, t, last - dark):
            continue
        told += 1
        if told <= SHOWN:
            expected = _shown(beyond) if beyond or not due else "the arc out where it is closed"
            yield rules.DARK.at(
                Source(work.name, t.stroke.line), found=_shown(dark),
                expected=expected, contour=work.contour_at(work.path.starts[t.first]),
            )  # fmt: skip


def _closes(work: Work, t: Traced, way: int) -> bool:
    """Whether the path comes back to where a stroke joins its contour as `way` begins.

    What comes along the contour for no longer than a lead may be one, or the contour's beginning.
    """
    first = int(np.searchsorted(work.of_way, work.of_way[t.first]))
    if not t.first < way < t.last:
        return False
    away = work.path.starts[first : t.first] - work.path.starts[way]
    return bool((np.hypot(*away.T) <= work.meeting).any())


def _shown(moves: int) -> str:
    return f"the arc out on the last {moves} moves" if moves else "the arc on to the end"
