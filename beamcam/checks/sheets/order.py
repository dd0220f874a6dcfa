"""In which order contours are cut: marks first, and what lies in a contour before it."""

from collections.abc import Mapping, Sequence

import numpy as np
import shapely
from msgspec import Struct

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.controller_state import SKELETON
from beamcam.checks.sheets.grid import Pairs
from beamcam.checks.sheets.joining import Chain
from beamcam.checks.sheets.paths import aligned
from beamcam.checks.sheets.region import Region, signed_areas
from beamcam.checks.sheets.toolpaths import Samples, kept_samples
from beamcam.checks.sheets.tracing import Traced, on_contour
from beamcam.checks.sheets.work import SHOWN, SPACING, Work
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.torch import LayerSettings, TorchProcess

TOUCHING = 0.01  #: mm by which a contour may leave the one around it
AT_ONCE = 64  #: rings that are looked at together


def order_faults(
    traced: Sequence[Traced], works: Mapping[TorchProcess, Work], name: str
) -> list[Diagnostic]:
    """Marks behind cuts, and what lies in a contour that was cut before, in the program's order."""
    diagnostics: list[Diagnostic] = []
    first_cut = next((t for t in traced if t.stroke.process == "cut"), None)
    for t in traced:
        if first_cut and t.stroke.process != "cut" and t.stroke.line > first_cut.stroke.line:
            diagnostics.append(
                rules.ORDER.at(
                    Source(name, t.stroke.line),
                    found=f"work to {t.stroke.process} {_contour(works, t)}",
                    before=f"the cut on line {first_cut.stroke.line}",
                )
            )
            break
    diagnostics += _before_skeleton(traced, works, name)
    # An open cut has no inside, and lies in none.
    cuts = [t for t in traced if t.stroke.process == "cut" and t.contour >= 0]
    # What is left of a contour may be cut piece by piece: it holds what lies in it until the last.
    last = {t.contour: t for t in cuts if not (t.closed or t.joined)}
    cuts = [t for t in cuts if t.closed or t.joined or t is last[t.contour]]
    pairs = inside_of_earlier([t.contour for t in cuts], works["cut"].region) if cuts else []
    for a, b in pairs:
        diagnostics.append(
            rules.ORDER.at(
                Source(name, cuts[a].stroke.line), found=_contour(works, cuts[a]),
                before=f"{_contour(works, cuts[b])} around it, cut on line {cuts[b].stroke.line}",
            )
        )  # fmt: skip
    return diagnostics[:SHOWN]


def _before_skeleton(
    traced: Sequence[Traced], works: Mapping[TorchProcess, Work], name: str
) -> list[Diagnostic]:
    """Parts that are cut behind a cut through the skeleton, which they hang in."""
    work = works.get("cut")
    if work is None or not work.torch.skeleton_cuts or not work.need.count:
        return []
    skeleton = [t for t in traced if t.stroke.process == "cut" and not t.half_kerf and not t.closed]
    for t in skeleton:
        path = (work.path.starts[t.first] + work.path.ends[t.last - 1]) / 2
        _, way = work.need.nearest_to(path)
        behind = [o for o in traced if o.stroke.line > t.stroke.line and (o.half_kerf or o.closed)]
        if work.asked.source("cut", way).where == SKELETON and behind:
            return [
                rules.ORDER.at(
                    Source(name, behind[0].stroke.line), found=_contour(works, behind[0]),
                    before=f"the cut through the skeleton on line {t.stroke.line}",
                )
            ]  # fmt: skip
    return []


def _contour(works: Mapping[TorchProcess, Work], t: Traced) -> str:
    work = works[t.stroke.process]
    if t.contour >= 0:
        return f"the contour of {work.contour(work.region.rings[t.contour][0][0])}"
    return f"the contour of {work.contour_at(work.path.starts[t.first])}"


def inside_of_earlier(contours: Sequence[int], region: Region) -> list[tuple[int, int]]:
    """Pairs of a cut and an earlier one that it lies inside of; `contours` are those of the cuts.

    It may touch that. One that lies on it all round has the same inside, and either may be first.
    Boxes are looked at first: in most programs no contour is in the box of an earlier one. That is
    done for some at a time, so that it takes no more memory the more of them lie above one another.
    """
    polygons = region.polygons[np.array(contours, dtype=np.int64)]
    x0, y0, x1, y1 = shapely.bounds(polygons).reshape(-1, 4).T
    tree = shapely.STRtree(shapely.points((x0 + x1) / 2, (y0 + y1) / 2))
    pairs: list[tuple[int, int]] = []
    for low in range(0, len(contours), AT_ONCE):
        some = slice(low, low + AT_ONCE)
        outer, inner = tree.query(shapely.box(x0[some], y0[some], x1[some], y1[some]))
        outer += low
        later = inner > outer
        for b in sorted(set(outer[later].tolist())):
            own = inner[later & (outer == b)]
            own = own[shapely.covers(shapely.buffer(polygons[b], TOUCHING), polygons[own])]
            same = shapely.covers(shapely.buffer(polygons[own], TOUCHING), polygons[b])
            pairs += [(a, b) for a in own[~same].tolist()]
    return sorted(pairs)


# --- direction ------------------------------------------------------------------------------------

# In which direction contours are cut: as they are drawn, or with the material at one side.
#
# A swirling plasma bevels the side of its cut that is left of the head more than the right one: cut
# the other way round, the bevel is on the part.


MIN_WIDTH = 1e-3  #: mm, half of it on an average, of what a ring goes round


def direction_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Closed cuts that go round their contour the wrong way."""
    # A beam that the controller leads comes to its contour half a kerf behind the start.
    led = work.torch.kerf_by == "machine"
    heads = [t for t in traced if t.contour >= 0 and (t.members or led)]
    if work.process != "cut" or not heads:
        return []
    asked = _asked(work)
    diagnostics = []
    for t, found in zip(heads, _turns(work, heads), strict=True):
        wanted = asked[t.contour]
        if wanted is None or found is None or found == wanted:
            continue
        diagnostics.append(
            rules.DIRECTION.at(
                Source(work.name, t.stroke.line), found=_shown(found), expected=_shown(wanted),
                contour=work.contour(work.region.rings[t.contour][0][0]), how=work.torch.direction,
            )
        )  # fmt: skip
    return diagnostics[:SHOWN]


def _shown(is_anticlockwise: bool) -> str:
    return "counter-clockwise" if is_anticlockwise else "clockwise"


def _asked(work: Work) -> list[bool | None]:
    """Of each ring whether it is to be followed counter-clockwise; None if that is left open."""
    if work.torch.direction == "drawn":
        turned = work.region.anticlockwise.tolist()
        twins = np.flatnonzero(work.region.twins)
        return [
            is_turned if _is_one_feature(work, ring, twins) else None
            for ring, is_turned in zip(work.region.rings, turned, strict=True)
        ]
    # With climb the waste is on the left: counter-clockwise where it lies inside.
    climbs = work.torch.direction == "climb"
    return [None if is_hole is None else is_hole == climbs for is_hole in work.holes]


def _is_one_feature(work: Work, ring: Chain, twins: Counts) -> bool:
    """Whether a ring is one feature as it is drawn, and no other curve lies on it.

    Of curves that are joined, and of what is drawn twice, any direction is one that is drawn.
    """
    features, ways = work.asked.features[work.process], [way for way, _ in ring]
    own = features[ways[0]]
    if any(back or features[way] != own for way, back in ring):
        return False
    if not len(twins):
        return True
    low, high = work.need.boxes
    least, most = low[ways].min(axis=0), high[ways].max(axis=0)
    beside = np.all((high[twins] >= least) & (low[twins] <= most), axis=1)
    return not beside.any()


def _turns(work: Work, heads: Sequence[Traced]) -> list[bool | None]:
    """Which strokes that go round a contour together do so counter-clockwise.

    None of what has no inside.
    """
    points, begins = work.path.outlines(work.fine)
    members = [(m.first, m.last) for head in heads for m in head.members or [head]]
    low, high = begins[np.array(members).T]
    behind = np.cumsum(high - low)
    rows = np.arange(behind[-1]) + np.repeat(high - behind, high - low)
    first = np.cumsum([0, *(len(head.members or [head]) for head in heads)])
    areas, lengths = signed_areas(points[rows], np.append(0, behind)[first])
    wide = np.abs(areas) > MIN_WIDTH * lengths
    return [
        turned if is_wide else None
        for turned, is_wide in zip((areas > 0.0).tolist(), wide.tolist(), strict=True)
    ]


# --- look settings --------------------------------------------------------------------------------

# Whether each contour is worked as its colour or layer asks: speed, power, passes and order.


PLAIN = LayerSettings()

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


def turn_faults(turns: Sequence[OrderPlace], name: str) -> list[Diagnostic]:
    """The first stroke whose contours ask for a place in the order that is over by then."""
    reached = 0
    for turn in sorted(turns, key=lambda t: t.line):
        if turn.highest < reached:
            return [rules.TURN.at(Source(name, turn.line), found=turn.highest, expected=reached)]
        reached = max(reached, turn.lowest)
    return []
