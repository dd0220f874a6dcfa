"""Whether each contour is worked as its colour or layer asks: speed, power, passes and order."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.asked_sheet import with_settings
from beamcam.checks.sheets.paths import aligned
from beamcam.checks.sheets.toolpaths import kept_samples
from beamcam.checks.sheets.tracing import Traced, on_contour
from beamcam.checks.sheets.work import SHOWN, SPACING, Work
from beamcam.errors import Diagnostic, Source
from beamcam.machine.torch import LayerSettings, TorchProcess

PLAIN = LayerSettings()

Settings = tuple[float, float, int]  #: mm/min, power, passes
#: Line of a stroke, and the lowest and highest place in the order that its contours ask for.
Order = tuple[int, int, int]


def setting_faults(
    works: Mapping[TorchProcess, Work], traced: Sequence[Traced], name: str
) -> Iterator[Diagnostic]:
    """Strokes whose settings or place in the order differ from their colour or layer."""
    orders: list[Order] = []
    for process, work in works.items():
        yield from _setting_faults(work, [t for t in traced if t.stroke.process == process], orders)
    reached = 0
    for line, lowest, highest in sorted(orders, key=lambda order: order[0]):
        if highest < reached:
            yield rules.TURN.at(Source(name, line), found=highest, expected=reached)
            return
        reached = max(reached, lowest)


def _setting_faults(work: Work, traced: Sequence[Traced], orders: list[Order]) -> list[Diagnostic]:
    """Strokes with other settings than their contours have; adds the order of each stroke."""
    row = work.required.rows.get(work.process)
    if not work.need.count or not traced or row is None:
        return []
    looks = work.required.looks[work.process]
    owns = {k: work.torch.settings.get(k, PLAIN) for k in set(looks)}
    row_of = {k: with_settings(row, owns[k]) for k in owns}
    settings: list[Settings] = [
        (one.feed_mm_min, one.power, one.passes) for one in map(row_of.__getitem__, looks)
    ]
    samples = work.path.samples(SPACING)
    samples = kept_samples(samples, on_contour(work, traced)[samples[2]])
    points, stroke = work.path.elements.places(*samples[:2]), work.of_way[samples[2]]
    pairs = work.need.near(points, work.half_kerf + work.most_slack)
    # What the path only crosses counts where there is nothing else.
    along = aligned(work.path, samples, work.need, pairs, work.most_slack)
    runs_along = np.zeros(len(points), dtype=bool)
    runs_along[pairs.point[along]] = True
    pairs = pairs.kept(along | ~runs_along[pairs.point])
    near = work.need.owner[pairs.element]
    diagnostics: list[Diagnostic] = []
    for number, one in enumerate(work.strokes):
        mine = stroke[pairs.point] == number
        ways = np.unique(near[mine]).tolist()
        if not ways:
            continue
        # The strokes of a table may leave it open of which of two speeds they are.
        rows = (one.row, *one.alike) if work.stepped else (one.row,)
        likewise = {(row.feed_mm_min, row.power, one.passes) for row in rows}
        fits = np.isin(near, [w for w in ways if settings[w] in likewise])
        wrong = np.flatnonzero(mine & ~np.isin(pairs.point, pairs.point[mine & fits]))
        for k in wrong[:1].tolist():
            own = one.row.feed_mm_min, one.row.power, one.passes
            diagnostics.append(
                work.fault(
                    rules.SETTINGS, one.line, contour=work.contour(int(near[k])),
                    process=work.process, found=_shown(own), expected=_shown(settings[near[k]]),
                )
            )  # fmt: skip
        places = [owns[looks[w]].order for w in ways]
        orders.append((one.line, min(places), max(places)))
    return diagnostics[:SHOWN]


def _shown(settings: Settings) -> str:
    speed, power, passes = settings
    return f"{speed:g} mm/min, power {power:g}, {passes} passes"
