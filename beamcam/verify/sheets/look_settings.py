"""Whether each contour is worked as its colour or layer asks: speed, power, passes and order."""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.machine.torch import LookSettings, TorchRow
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.alignment import aligned
from beamcam.verify.sheets.grid import Pairs
from beamcam.verify.sheets.paths import on_contour
from beamcam.verify.sheets.toolpaths import Samples, kept_samples
from beamcam.verify.sheets.work import SHOWN, SPACING, Traced, Work

PLAIN = LookSettings()

Settings = tuple[float, float, int]  #: mm/min, power, passes


class OrderPlace(Struct, frozen=True):
    """The place in the order that the contours of a stroke ask for; several may lie on one."""

    line: int
    lowest: int
    highest: int


def settings_faults(
    work: Work, traced: Sequence[Traced]
) -> tuple[list[Diagnostic], list[OrderPlace]]:
    """Strokes with other settings than their contour requires, and the turn of each stroke."""
    row = work.asked.rows.get(work.process)
    if not work.need.count or not traced or row is None:
        return [], []
    owns = [work.torch.settings.get(k, PLAIN) for k in work.asked.looks[work.process]]
    asked = [_asked(row, own) for own in owns]
    samples = work.path.samples(SPACING)
    samples = kept_samples(samples, on_contour(work, traced)[samples[2]])
    points, stroke = work.path.elements.places(*samples[:2]), work.of_way[samples[2]]
    pairs = _followed(work, samples, points)
    near = work.need.owner[pairs.element]
    said: list[Diagnostic] = []
    turns: list[OrderPlace] = []
    for number, one in enumerate(work.strokes):
        mine = stroke[pairs.point] == number
        ways = np.unique(near[mine]).tolist()
        if not ways:
            continue
        own = one.row.feed_mm_min, one.row.power, one.passes
        # The strokes of a table may leave it open of which of two speeds they are.
        rows = (one.row, *one.alike) if work.stepped else (one.row,)
        likewise = {(row.feed_mm_min, row.power, one.passes) for row in rows}
        fits = np.isin(near, [w for w in ways if asked[w] in likewise])
        wrong = np.flatnonzero(mine & ~np.isin(pairs.point, pairs.point[mine & fits]))
        for k in wrong[:1].tolist():
            said.append(_other(work, one.line, own, asked[near[k]], work.contour(int(near[k]))))
        orders = [owns[w].order for w in ways]
        turns.append(OrderPlace(one.line, min(orders), max(orders)))
    return said[:SHOWN], turns


def _followed(work: Work, samples: Samples, points: Floats) -> Pairs:
    """The samples of the path and what they are near; what they cross only if nothing else is."""
    most = float(work.slack.max(initial=0.0))
    pairs = work.need.near(points, work.half_kerf + most)
    along = aligned(work.path, samples, work.need, pairs, most)
    runs_along = np.zeros(len(points), dtype=bool)
    runs_along[pairs.point[along]] = True
    return pairs.kept(along | ~runs_along[pairs.point])


def _asked(row: TorchRow, own: LookSettings) -> Settings:
    return (
        row.feed_mm_min if own.speed is None else own.speed,
        row.power if own.power is None else own.power,
        row.passes if own.passes is None else own.passes,
    )


def _other(work: Work, line: int, found: Settings, expected: Settings, contour: str) -> Diagnostic:
    return rules.SETTINGS.at(
        Source(work.name, line), contour=contour, process=work.process,
        found=_shown(found), expected=_shown(expected),
    )  # fmt: skip


def _shown(settings: Settings) -> str:
    speed, power, passes = settings
    return f"{speed:g} mm/min, power {power:g}, {passes} passes"


def turn_faults(turns: Sequence[OrderPlace], name: str) -> list[Diagnostic]:
    """The first stroke whose contours ask for a place in the order that is over by then."""
    reached = 0
    for turn in sorted(turns, key=lambda t: t.line):
        if turn.highest < reached:
            return [rules.TURN.at(Source(name, turn.line), found=turn.highest, expected=reached)]
        reached = max(reached, turn.lowest)
    return []
