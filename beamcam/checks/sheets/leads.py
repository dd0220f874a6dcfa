"""How each stroke is run: its leads, its direction, and what the beam takes of the part."""

from collections.abc import Sequence
from math import dist, pi

import numpy as np
import shapely

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.region import signed_areas
from beamcam.checks.sheets.tracing import Traced, is_in_kerf, on_contour
from beamcam.checks.sheets.work import SHOWN, Work
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Flags, Floats
from beamcam.geometry.curves import Arc

# --- pierces --------------------------------------------------------------------------------------

# Where the torch pierces: as far from the part as the hole that it burns is wide, if it can.
#
# Asked of programs that keep the kerf off and lead in by themselves: a controller's own
# compensation has a rule of its own for its entry, and stairs of steps do not tell how a path
# begins. There is room where the machine's lead, in all its length, would keep half a kerf off
# every contour where the program joins this one, and its far end the radius of that hole.
#
#           S   line: square to the path          .-  arc: a quarter circle, tangent to it
#           |                                    S
#         --C--->  path                        --C--->


ALONG = 33  #: corners of the line that stands for a lead


def pierce_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Strokes round a contour that pierce too near to one although there is room for a lead."""
    row = work.required.rows.get(work.process)
    rings = [
        t for t in traced if t.half_kerf and t.closed and not t.joined and not t.stroke.is_linked
    ]
    if row is None or not rings or not row.pierce_radius:
        return []
    contours = shapely.STRtree(work.contours)
    pierced = work.path.starts[[t.begin for t in rings]]
    away, nearest = _distances(contours, pierced)
    diagnostics: list[Diagnostic] = []
    near = row.pierce_radius - work.slack[nearest] - 2 * work.fine
    for k in np.flatnonzero(away < near).tolist():
        lead = _whole_lead(work, rings[k], contours)
        # A planner keeps off by a hair less; where that decides, either may be right.
        kept = work.half_kerf - work.fine
        blocked = contours.query(shapely.LineString(lead), "dwithin", distance=kept)
        far = row.pierce_radius + work.tolerance
        if len(blocked) or _distances(contours, lead[-1:])[0][0] < far:
            continue
        diagnostics.append(
            work.fault(
                rules.PIERCE, rings[k].stroke.line, pierced[k], found=f"{away[k]:.3f}",
                contour=work.contour(int(nearest[k])), expected=f"{row.pierce_radius:g}",
                lead=f"{work.torch.lead_in:g}",
            )
        )  # fmt: skip
    return diagnostics[:SHOWN]


def edge_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Open strokes beside a contour that begin on no path that was cut before.

    They are what is left of contours whose other edges are cut with those of another part.
    """
    diagnostics: list[Diagnostic] = []
    for t in traced:
        begin = work.path.starts[t.begin]
        is_rest = t.half_kerf and not (t.members or t.joined or t.closed)
        if is_rest and not is_in_kerf(work, begin, int(work.of_way[t.first])):
            contour = work.contour_at(begin)
            diagnostics.append(work.fault(rules.EDGE, t.stroke.line, begin, contour=contour))
    return diagnostics[:SHOWN]


def _distances(contours: shapely.STRtree, points: Floats) -> tuple[Floats, Floats]:
    """How far each point is from the nearest contour, and which one that is."""
    places = shapely.points(points)
    nearest = contours.nearest(places)
    return shapely.distance(places, contours.geometries[nearest]), nearest


def _whole_lead(work: Work, t: Traced, contours: shapely.STRtree) -> Floats:
    """Places of the machine's lead from where a stroke joins its contour to its far end, (n, 2)."""
    at = work.path.starts[t.first]
    ((tx, ty),) = work.path.elements.directions(work.path.first[[t.first]], np.zeros(1))
    place = shapely.Point(at)
    own = contours.geometries[contours.nearest(place)]
    if t.contour >= 0:  # that of another part may lie nearer
        own = shapely.get_exterior_ring(work.region.polygons[t.contour])
    foot = shapely.get_coordinates(shapely.shortest_line(place, own))[1]
    normal = np.array((-ty, tx))
    if np.dot(normal, at - foot) < 0.0:  # the waste is where the path keeps off to
        normal = -normal
    share, length = np.linspace(0.0, 1.0, ALONG)[:, None], work.torch.lead_in
    away: Floats = share * length * normal
    if work.torch.lead != "line":
        turn, back = share * pi / 2, np.array((-tx, -ty))
        away = length / (pi / 2) * ((1.0 - np.cos(turn)) * normal + np.sin(turn) * back)
    return np.asarray(at + away)


# --- small holes ----------------------------------------------------------------------------------

# Small holes: which strokes go round one, their feed, and how their leads begin.
#
# A round one is entered from its middle where the machine says so:
#
#         .-----.         from the middle M half a circle, tangent to the path at C
#        /   .-. \
#       C   /   M |       asked where that keeps half a kerf off all contours; what lies in the hole
#        \_/     /        may be in its way
#         `-----'


ROUND, ROUND_DEG = 1e-6, 1e-6  #: mm and degrees that the arcs of a round hole may be apart
ROUND_DOUBT = 2e-3  #: of the way round a hole, by which it may be a small one or not


def hole_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Strokes that run as in a small hole elsewhere, or in one as elsewhere."""
    diagnostics: list[Diagnostic] = []
    for t in traced:
        expected, found = t.small, t.stroke.in_hole
        if expected is None or found is None or expected == found or not t.stroke.row.slows_holes:
            continue
        share = f"{t.stroke.row.hole_feed_share * 100:g} %"
        feeds = {"found": share if found else "all", "expected": share if expected else "all"}
        contour = work.contour_at(work.path.starts[t.first])
        diagnostics.append(work.fault(rules.HOLE_FEED, t.stroke.line, contour=contour, **feeds))
    return diagnostics[:SHOWN]


def find_small(work: Work, traced: Sequence[Traced]) -> None:
    """Tell each stroke whether it goes round a small hole; None where it is as good as either."""
    if not any(s.row.hole_diameter for s in work.strokes):
        return
    for t in traced:
        row = t.stroke.row
        if t.contour < 0 or not row.hole_diameter:
            t.small = False
            continue
        around = float(shapely.length(work.region.polygons[t.contour]))
        limit, doubt = pi * row.hole_diameter, ROUND_DOUBT * around + 8 * work.tolerance
        is_hole = work.holes[t.contour]
        t.small = around < limit and bool(is_hole)
        if is_hole is None or (is_hole and abs(around - limit) <= doubt):
            t.small = None


def middle_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Small round holes that are not entered from their middle, by half a circle."""
    if work.torch.hole_lead != "middle" or not any(t.small for t in traced):
        return []
    contours = shapely.STRtree(work.contours)
    diagnostics: list[Diagnostic] = []
    for t in traced:
        if not t.small or t.joined:
            continue
        at = work.path.starts[t.first]
        circle = _circle(work, work.need.nearest_to(at)[1])
        if circle is None:
            continue
        middle = np.array(circle.centre) + np.array(work.shift)
        away = float(np.hypot(*(work.path.starts[t.begin] - middle)))
        # What of a short ring comes before its end again may have been traced as a lead.
        joins, length = work.path.ends[t.begin], float(work.path.lengths[t.begin])
        radius = float(np.hypot(*(joins - middle))) / 2
        (half_way,) = work.path.point(np.array([t.begin]), np.array([length / 2]))
        off = (
            2 * radius - np.hypot(*(at - middle)), (length - pi * radius) / 2,
            np.hypot(*(half_way - (joins + middle) / 2)) - radius,
        )  # fmt: skip
        smooth = all(abs(float(by)) <= 2 * work.tolerance for by in off)
        if away <= 2 * work.tolerance and smooth:
            continue
        half = np.linspace(0.0, np.pi, 65)[:, None]
        across = (at - middle) / 2
        ways = [
            middle + across + np.cos(half) * -across + side * np.sin(half) * across[::-1] * (-1, 1)
            for side in (-1.0, 1.0)
        ]
        kept = work.half_kerf - work.fine
        if all(len(contours.query(shapely.LineString(w), "dwithin", distance=kept)) for w in ways):
            continue
        is_off = away > 2 * work.tolerance
        found = f"{away:.3f} mm off its middle" if is_off else "another way from its middle"
        values = {"contour": work.contour_at(at), "found": found}
        diagnostics.append(work.fault(rules.HOLE_LEAD, t.stroke.line, **values))
    return diagnostics[:SHOWN]


def _circle(work: Work, way: int) -> Arc | None:
    """The first arc of a needed contour that is round all about; None of another."""
    need, process = work.required, work.process
    feature = need.features[process][way]
    own = [
        curve for curve, other in zip(need.curves[process], need.features[process], strict=True)
        if other == feature
    ]  # fmt: skip
    arcs = [curve for curve in own if isinstance(curve, Arc)]
    if len(arcs) < len(own) or abs(abs(sum(arc.sweep_deg for arc in arcs)) - 360.0) > ROUND_DEG:
        return None
    apart = max(dist(arc.centre, arcs[0].centre) + abs(arc.radius - arcs[0].radius) for arc in arcs)
    return arcs[0] if apart <= ROUND else None


# --- taken ----------------------------------------------------------------------------------------

# That is asked of the whole path, its leads too, and of every contour, not at samples: both are
# chords at most `fine` off (an eighth of the machine's tolerance), so that a beam is refused that
# takes more than the tolerance, the rounding of the program's numbers and 3 `fine`, in all 1.4
# times the tolerance and two steps of the last decimal. No buffer is drawn, so there are no
# quadrants of it to add an error.


def band_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Places where the beam cuts into the part."""
    keeps_off = np.array([t.half_kerf > 0.0 for t in traced])
    diagnostics = _bites(work, traced, keeps_off)
    places = work.path.starts[[t.first for t in traced]]
    for k in np.flatnonzero(keeps_off & work.region.in_part(places))[:SHOWN].tolist():
        # For a kerf that is less than what a path may be off, no side is judged.
        away, way = work.need.nearest_to(places[k])
        if away <= work.slack[way]:
            continue
        line, contour = traced[k].stroke.line, work.contour(way)
        diagnostics.append(work.fault(rules.SIDE, line, places[k], contour=contour))
    return diagnostics


def _bites(work: Work, traced: Sequence[Traced], keeps_off: Flags) -> list[Diagnostic]:
    """The first place of each stroke that is nearer to a closed contour than half a kerf."""
    closed = np.flatnonzero(work.region.closed & ~work.region.twins)
    strokes = np.flatnonzero(keeps_off)
    if not len(closed) or not len(strokes):
        return []
    contours = work.contours[closed]
    ways = work.path.lines(work.fine, work.of_way)[strokes]
    least = work.half_kerf - work.slack[closed] - 2 * work.fine
    a, b = shapely.STRtree(contours).query(ways, "dwithin", distance=float(least.max()))
    away = shapely.distance(ways[a], contours[b])
    hit = np.flatnonzero(away < least[b])
    _, firsts = np.unique(a[hit], return_index=True)
    is_ring = on_contour(work, traced)
    diagnostics = []
    for k in hit[firsts][:SHOWN].tolist():
        # The place on the path, and the line that leads there.
        near, _ = shapely.get_coordinates(shapely.shortest_line(ways[a[k]], contours[b[k]]))
        way = work.path.nearest_to(near)[1]
        diagnostics.append(
            work.fault(
                rules.BAND if is_ring[way] else rules.LEAD, int(work.moves.line[way]), near,
                found=f"{away[k]:.3f}", contour=work.contour(int(closed[b[k]])),
                expected=f"{work.half_kerf:g}",
            )
        )  # fmt: skip
    return diagnostics


# --- direction ------------------------------------------------------------------------------------

# In which direction contours are cut: as they are drawn, or with the material at one side.
#
# A swirling plasma bevels the side of its cut that is left of the head more than the right one: cut
# the other way round, the bevel is on the part.


MIN_WIDTH = 1e-3  #: mm, half of it on an average, of what a ring goes round


def direction_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Closed cuts that go round their contour the wrong way."""
    # A beam that the controller leads comes to its contour half a kerf behind the start.
    by_machine = work.torch.kerf_by == "machine"
    heads = [t for t in traced if t.contour >= 0 and (t.members or by_machine)]
    if work.process != "cut" or not heads:
        return []
    # With climb the waste is on the left: counter-clockwise where it lies inside.
    climbs = work.torch.direction == "climb"
    turned = [None if is_hole is None else is_hole == climbs for is_hole in work.holes]
    if work.torch.direction == "drawn":
        turned = _drawn_directions(work)
    # In which direction strokes go round a contour together; none of what has no inside.
    points, begins = work.path.outlines(work.fine)
    strokes = [head.members or [head] for head in heads]
    low, high = begins[np.array([(m.first, m.last) for some in strokes for m in some]).T]
    behind = np.cumsum(high - low)
    rows = np.arange(behind[-1]) + np.repeat(high - behind, high - low)
    first = np.cumsum([0, *map(len, strokes)])
    areas, lengths = signed_areas(points[rows], np.append(0, behind)[first])
    diagnostics = []
    for k in np.flatnonzero(np.abs(areas) > MIN_WIDTH * lengths).tolist():
        t, found = heads[k], bool(areas[k] > 0.0)
        expected = turned[t.contour]
        if expected is None or found == expected:
            continue
        diagnostics.append(
            work.fault(
                rules.DIRECTION, t.stroke.line, found=_shown(found), expected=_shown(expected),
                contour=work.contour(work.region.rings[t.contour][0][0]), how=work.torch.direction,
            )
        )  # fmt: skip
    return diagnostics[:SHOWN]


def _drawn_directions(work: Work) -> list[bool | None]:
    """Of each ring whether it is drawn counter-clockwise, if it is one feature with no other on it.

    Of curves that are joined, and of what is drawn twice, any direction is one that is drawn.
    """
    features, twins = work.required.features[work.process], np.flatnonzero(work.region.twins)
    low, high = work.need.boxes
    turned: list[bool | None] = []
    for ring, is_turned in zip(work.region.rings, work.region.anticlockwise.tolist(), strict=True):
        ways = [way for way, _ in ring]
        is_one = len({features[way] for way in ways}) == 1 and not any(back for _, back in ring)
        if is_one and len(twins):
            least, most = low[ways].min(axis=0), high[ways].max(axis=0)
            is_one = not np.all((high[twins] >= least) & (low[twins] <= most), axis=1).any()
        turned.append(is_turned if is_one else None)
    return turned


def _shown(is_anticlockwise: bool) -> str:
    return "counter-clockwise" if is_anticlockwise else "clockwise"
