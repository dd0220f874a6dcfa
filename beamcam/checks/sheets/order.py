"""In which order contours are cut: marks first, and what lies in a contour before it."""

from collections.abc import Mapping, Sequence

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.areas import waste_sides
from beamcam.checks.sheets.controller_state import SKELETON
from beamcam.checks.sheets.grid import Pairs
from beamcam.checks.sheets.joining import Chain
from beamcam.checks.sheets.paths import aligned, on_contour
from beamcam.checks.sheets.region import signed_areas
from beamcam.checks.sheets.toolpaths import Samples, kept_samples
from beamcam.checks.sheets.work import MITRE, SHOWN, SPACING, Traced, Work
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
            )  # fmt: skip
            break
    diagnostics += _before_skeleton(traced, works, name)
    # An open cut has no inside, and lies in none.
    cuts = [t for t in traced if t.stroke.process == "cut" and t.goes_round]
    for a, b in _inside_of_earlier(cuts):
        if cuts[a].group != cuts[b].group:
            diagnostics.append(
                rules.ORDER.at(
                    Source(name, cuts[a].stroke.line), found=_contour(works, cuts[a]),
                    before=f"{_contour(works, cuts[b])} around it, cut on line "
                    f"{cuts[b].stroke.line}",
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
        behind = [
            o for o in traced
            if o.stroke.line > t.stroke.line and (o.half_kerf or o.closed)
        ]  # fmt: skip
        if work.asked.source("cut", way).where == SKELETON and behind:
            return [
                rules.ORDER.at(
                    Source(name, behind[0].stroke.line), found=_contour(works, behind[0]),
                    before=f"the cut through the skeleton on line {t.stroke.line}",
                )
            ]  # fmt: skip
    return []


def _contour(works: Mapping[TorchProcess, Work], t: Traced) -> str:
    return f"the contour of {works[t.stroke.process].contour_at(np.array(t.middle))}"


def _inside_of_earlier(cuts: Sequence[Traced]) -> list[tuple[int, int]]:
    """Pairs of a cut and an earlier one whose ring it lies in.

    Boxes are looked at first: in most programs no contour is in the box of an earlier one. That is
    done for some rings at a time, so that it takes no more memory the more of them lie above one
    another.
    """
    rings = [k for k, t in enumerate(cuts) if t.ring or t.contour is not None]
    tree = shapely.STRtree(shapely.points(np.array([t.middle for t in cuts]).reshape(-1, 2)))
    pairs: list[tuple[int, int]] = []
    for low in range(0, len(rings), AT_ONCE):
        some = np.array(rings[low : low + AT_ONCE])
        boxes = shapely.box(*np.array([cuts[k].box for k in some]).T)
        number, inner = tree.query(boxes)
        later = inner > some[number]
        found, starts = np.unique(some[number[later]], return_index=True)
        for ring, own in zip(found.tolist(), np.split(inner[later], starts)[1:], strict=True):
            pairs += _within(cuts, own.tolist(), ring)
    return sorted(pairs)


def _within(cuts: Sequence[Traced], inner: list[int], ring: int) -> list[tuple[int, int]]:
    """Those of some cuts that lie in the ring of one, with it.

    They may touch it. One that lies on it all round has the same inside, and either may be first.
    """
    polygon = cuts[ring].inside()
    if polygon is None:
        return []
    wider = shapely.buffer(polygon, TOUCHING)
    inside = shapely.contains_xy(wider, np.array([cuts[k].middle for k in inner]))
    return [
        (k, ring)
        for k, is_in in zip(inner, inside.tolist(), strict=True)
        if is_in
        and shapely.covers(wider, shapely.multipoints(cuts[k].corners()))
        and not (
            (own := cuts[k].inside()) is not None
            and shapely.covers(shapely.buffer(own, TOUCHING), polygon)
        )
    ]


# --- direction ------------------------------------------------------------------------------------

# In which direction contours are cut: as they are drawn, or with the material at one side.
#
# A swirling plasma bevels the side of its cut that is left of the head more than the right one: cut
# the other way round, the bevel is on the part.


ASKED = 8  #: places of a stroke where it is asked which contour it follows
MIN_WIDTH = 1e-3  #: mm, half of it on an average, of what a ring goes round


def direction_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Closed cuts that go round their contour the wrong way."""
    # A beam that the controller leads comes to its contour half a kerf behind the start.
    led = work.torch.kerf_by == "machine"
    heads = [t for t in traced if t.members or (led and t.contour is not None)]
    if work.process != "cut" or not heads or not work.need.count:
        return []
    if work.region is None:
        work = replace(work, region=work.asked.region(work.torch).moved(work.shift))
    assert work.region is not None
    asked = _asked(work)
    diagnostics = []
    rows = zip(heads, _rings_of(work, heads).tolist(), _turns(work, heads), strict=True)
    for t, ring, found in rows:
        wanted = asked[ring] if ring >= 0 else None
        if wanted is None or found is None or found == wanted:
            continue
        diagnostics.append(
            rules.DIRECTION.at(
                Source(work.name, t.stroke.line), found=_shown(found), expected=_shown(wanted),
                contour=work.contour(work.region.rings[ring][0][0]), how=work.torch.direction,
            )
        )  # fmt: skip
    return diagnostics[:SHOWN]


def _shown(is_anticlockwise: bool) -> str:
    return "counter-clockwise" if is_anticlockwise else "clockwise"


def _asked(work: Work) -> list[bool | None]:
    """Of each ring whether it is to be followed counter-clockwise; None if that is left open."""
    assert work.region is not None
    rings, polygons = work.region.rings, work.region.polygons
    turned = work.region.anticlockwise.tolist()
    # Of contours that cross, neither lies inside of the other.
    clear = shapely.is_valid(polygons)
    one, other = np.flatnonzero(clear)[shapely.STRtree(polygons[clear]).query(polygons[clear])]
    one, other = one[one < other], other[one < other]
    crossing = shapely.intersects(*(shapely.get_exterior_ring(polygons[k]) for k in (one, other)))
    one, other = one[crossing], other[crossing]
    crossing = shapely.overlaps(polygons[one], polygons[other])
    clear[one[crossing]] = clear[other[crossing]] = False
    way = work.torch.direction
    sides = waste_sides(work) if way != "drawn" else np.zeros(0)
    directions: list[bool | None] = []
    for ring, is_turned, is_clear in zip(rings, turned, clear.tolist(), strict=True):
        if way == "drawn":
            directions.append(is_turned if _is_one_feature(work, ring) else None)
            continue
        first, back = ring[0]
        waste_left = bool((sides[first] > 0.0) != back)
        # With climb the waste is on the left: counter-clockwise where it lies inside.
        is_hole = waste_left == is_turned
        directions.append(is_hole == (way == "climb") if is_clear and sides[first] else None)
    return directions


def _is_one_feature(work: Work, ring: Chain) -> bool:
    """Whether a ring is one feature as it is drawn, and no other curve lies on it.

    Of curves that are joined, and of what is drawn twice, any direction is one that is drawn.
    """
    assert work.region is not None
    ways = np.array([way for way, _ in ring])
    features = np.array(work.asked.features[work.process])
    own = features[ways[0]]
    if any(back for _, back in ring) or (features[ways] != own).any():
        return False
    twins = np.flatnonzero(work.region.twins)
    if not len(twins):
        return True
    low, high = work.need.boxes
    least, most = low[ways].min(axis=0), high[ways].max(axis=0)
    beside = np.all((high[twins] >= least) & (low[twins] <= most), axis=1)
    return not beside.any()


def _rings_of(work: Work, heads: Sequence[Traced]) -> Counts:
    """The ring that each stroke follows at most of the places where it is asked; -1 for none."""
    assert work.region is not None
    ring_of = work.region.ring_of
    ends = np.array([(t.first, t.last - 1) for t in heads])
    ways = np.linspace(ends[:, 0], ends[:, 1], ASKED, axis=1).astype(np.int64)
    owner, column = np.nonzero(np.diff(ways, axis=1, prepend=-1))
    every = ways[owner, column]
    places = work.path.point(every, work.path.lengths[every] / 2)
    most = float(work.slack.max(initial=0.0))
    reaches = (work.half_kerf + most, MITRE * work.half_kerf + 2 * most)
    away, nearest, _ = work.need.nearest_within(places, reaches, ring_of >= 0)
    rings = np.where(np.isfinite(away), ring_of[nearest], -1)
    near, found = rings >= 0, np.full(len(heads), -1)
    count = max(len(work.region.rings), 1)
    pairs, times = np.unique(owner[near] * count + rings[near], return_counts=True)
    ruling = 2 * times > np.bincount(owner, minlength=len(heads))[pairs // count]
    found[pairs[ruling] // count] = pairs[ruling] % count
    return found


def _turns(work: Work, heads: Sequence[Traced]) -> list[bool | None]:
    """Which strokes that go round a contour together do so counter-clockwise.

    None of what has no inside.
    """
    points, begins = work.path.outlines(work.fine)
    members = [(m.first, m.last) for head in heads for m in head.members or [head]]
    rows = [np.arange(begins[first], begins[last]) for first, last in members]
    first = np.cumsum([0, *(len(head.members or [head]) for head in heads)])
    ends = np.cumsum([0, *map(len, rows)])[first]
    areas, lengths = signed_areas(points[np.concatenate(rows)], ends)
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
