"""Whether each contour is worked as its colour or layer asks: speed, power, passes and order."""

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import Struct

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.grid import Pairs
from beamcam.checks.sheets.paths import aligned
from beamcam.checks.sheets.toolpaths import Samples, kept_samples
from beamcam.checks.sheets.tracing import Traced, on_contour
from beamcam.checks.sheets.work import SHOWN, SPACING, Work
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.machine.torch import LayerSettings, TorchProcess

PLAIN = LayerSettings()

Settings = tuple[float, float, int]  #: mm/min, power, passes


class OrderPlace(Struct, frozen=True):
    """The place in the order that the contours of a stroke ask for; several may lie on one."""

    line: int
    lowest: int
    highest: int


def look_faults(
    works: Mapping[TorchProcess, Work], traced: Sequence[Traced], name: str
) -> list[Diagnostic]:
    """Strokes whose settings or place in the order differ from their colour or layer."""
    diagnostics: list[Diagnostic] = []
    turns: list[OrderPlace] = []
    for process, work in works.items():
        faults, more = _settings_faults(work, [t for t in traced if t.stroke.process == process])
        diagnostics += faults
        turns += more
    return diagnostics + _turn_faults(turns, name)


def _settings_faults(
    work: Work, traced: Sequence[Traced]
) -> tuple[list[Diagnostic], list[OrderPlace]]:
    """Strokes with other settings than their contour requires, and the turn of each stroke."""
    row = work.asked.rows.get(work.process)
    if not work.need.count or not traced or row is None:
        return [], []
    owns = [work.torch.settings.get(k, PLAIN) for k in work.asked.looks[work.process]]
    settings = [
        (
            row.feed_mm_min if own.speed is None else own.speed,
            row.power if own.power is None else own.power,
            row.passes if own.passes is None else own.passes,
        )
        for own in owns
    ]
    samples = work.path.samples(SPACING)
    samples = kept_samples(samples, on_contour(work, traced)[samples[2]])
    points, stroke = work.path.elements.places(*samples[:2]), work.of_way[samples[2]]
    pairs = _followed(work, samples, points)
    near = work.need.owner[pairs.element]
    diagnostics: list[Diagnostic] = []
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
        fits = np.isin(near, [w for w in ways if settings[w] in likewise])
        wrong = np.flatnonzero(mine & ~np.isin(pairs.point, pairs.point[mine & fits]))
        for k in wrong[:1].tolist():
            diagnostics.append(
                _other(work, one.line, own, settings[near[k]], work.contour(int(near[k])))
            )
        orders = [owns[w].order for w in ways]
        turns.append(OrderPlace(one.line, min(orders), max(orders)))
    return diagnostics[:SHOWN], turns


def _followed(work: Work, samples: Samples, points: Floats) -> Pairs:
    """The samples of the path and what they are near; what they cross only if nothing else is."""
    most = float(work.slack.max(initial=0.0))
    pairs = work.need.near(points, work.half_kerf + most)
    along = aligned(work.path, samples, work.need, pairs, most)
    runs_along = np.zeros(len(points), dtype=bool)
    runs_along[pairs.point[along]] = True
    return pairs.kept(along | ~runs_along[pairs.point])


def _other(work: Work, line: int, found: Settings, expected: Settings, contour: str) -> Diagnostic:
    return rules.SETTINGS.at(
        Source(work.name, line), contour=contour, process=work.process,
        found=_setting_shown(found), expected=_setting_shown(expected),
    )  # fmt: skip


def _setting_shown(settings: Settings) -> str:
    speed, power, passes = settings
    return f"{speed:g} mm/min, power {power:g}, {passes} passes"


def _turn_faults(turns: Sequence[OrderPlace], name: str) -> list[Diagnostic]:
    """The first stroke whose contours ask for a place in the order that is over by then."""
    reached = 0
    for turn in sorted(turns, key=lambda t: t.line):
        if turn.highest < reached:
            return [rules.TURN.at(Source(name, turn.line), found=turn.highest, expected=reached)]
        reached = max(reached, turn.lowest)
    return []
