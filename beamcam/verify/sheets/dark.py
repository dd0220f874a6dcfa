"""What of a cut is run with the arc out: what follows where its contour is closed, and no more."""

from collections.abc import Iterator, Sequence

import numpy as np

from beamcam.errors import Diagnostic, Source
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.work import SHOWN, Traced, Work


def dark_faults(work: Work, traced: Sequence[Traced], asked: bool) -> Iterator[Diagnostic]:
    """Cuts that are left dark before they are closed, or burn on behind that where they must not.

    `asked` says that the arc goes out where a cut is closed.
    """
    told = 0
    for t in traced:
        last = int(np.searchsorted(work.of_way, work.of_way[t.first], "right"))
        closed = t.closed and len(t.members) == 1
        beyond = last - t.last if closed and asked and work.process == "cut" else 0
        if t.stroke.dark == beyond:
            continue
        told += 1
        if told <= SHOWN:
            yield rules.DARK.at(
                Source(work.name, t.stroke.line), found=_shown(t.stroke.dark),
                expected=_shown(beyond), contour=work.contour_at(work.path.starts[t.first]),
            )  # fmt: skip


def _shown(moves: int) -> str:
    return f"the arc out on the last {moves} moves" if moves else "the arc on to the end"
