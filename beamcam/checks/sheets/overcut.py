"""How far closed cuts go on beyond their start, and where open ones end."""

from collections.abc import Sequence
from math import dist, hypot, inf, pi, sqrt

import numpy as np
import shapely

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.toolpaths import Toolpaths
from beamcam.checks.sheets.tracing import Traced
from beamcam.checks.sheets.work import SHOWN, Work
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.torch import LayerSettings

PLAIN = LayerSettings()
#: An overcut that the controller leads stays on the first curve, by this share of it at least.
STAYS = 0.4
SHORTEST = 0.2  #: share of a line that leads out, by which it leaves its contour if not along it
LEAD_SHARE = 0.4  #: share of a lead that lies along the contour, if it is not only tangent to it
CORNER_SPAN, CORNER_RAD = 0.2, 0.35  #: mm on both sides of a corner, and what it turns at least
Limits = tuple[float, float, float]  #: mm beyond the start: found, least, most


def overcut_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Closed cuts that run over their start by less or more than their overcut."""
    if work.process != "cut":
        return []
    # Where stairs of steps come back to their start is known by the distance of ends that meet.
    slack = (4 if work.stepped else 2) * work.tolerance
    by_machine = work.torch.kerf_by == "machine"
    diagnostics = []
    path, opened = work.path, [t for t in traced if not (t.members or t.joined or t.closed)]
    # Those that come by the place where they began once more.
    first = np.array([t.first for t in opened], dtype=np.int64)
    pairs = path.near(path.starts[first], work.tolerance)
    first = first[pairs.point]
    again = path.at(pairs.element, pairs.along) - path.begins[first] > 4 * work.tolerance
    again &= work.of_way[path.owner[pairs.element]] == work.of_way[first]
    passing = set(first[again].tolist())
    for t in traced:
        if by_machine and t.half_kerf:
            limits = _beside(work, t)
        elif t.members:
            limits, last = _along(work, t), t.members[-1]
            if last.beyond > work.most_lead + slack:
                away = f"{last.beyond:.3f} mm beyond its contour"
                expected = f"at most {work.most_lead:.3f} mm to lead out"
                line, place = int(work.moves.line[last.end - 1]), path.ends[last.end - 1]
                diagnostics.append(
                    work.fault(rules.EXTRA, line, place, away=away, expected=expected)
                )
        elif t.first in passing and (over := _retraced(work, t)):
            required = required_overcut(work, t, over)
            limits = over, required, required
        else:
            continue
        found, least, most = limits
        if not least - slack <= found <= most + slack:
            shown = {"found": f"{found:.3f}", "expected": f"{least:.3f}"}
            contour = work.contour_at(path.starts[t.first])
            diagnostics.append(work.fault(rules.OVERCUT, t.stroke.line, contour=contour, **shown))
    return diagnostics[:SHOWN]


def _along(work: Work, t: Traced) -> Limits:
    """How far a ring runs over its start, and its overcut: at most half of the way to a bridge.

    A line there and back again is not a ring.
    """
    lead = _lead_along(work, t)
    over = sum(other.over for other in t.members) - lead
    first = float(work.path.lengths[t.first : t.last].sum())
    if len(t.members) > 1:
        first += t.over - lead
    required = required_overcut(work, t, over, first / 2)
    if t.contour < 0 or not (over or required):
        return over, 0.0, 0.0
    return over, required, required + _along_leads(work, t.members[-1])


def _along_leads(work: Work, t: Traced) -> float:
    """How far the leads of a stroke that ends a ring may lie along its contour."""
    torch, path = work.torch, work.path
    if torch.lead == "none":
        return 0.0
    if torch.lead == "line":
        # From an inner corner a line leads out along the contour.
        beside = 2 * work.tolerance if work.stepped else 0.0
        return beside if t.beyond > SHORTEST * torch.lead_out else torch.lead_out
    # A quarter of a circle is off its tangent by the tolerance after sqrt(2 radius tolerance).
    if work.stepped:
        radii = torch.lead_in / (pi / 2), torch.lead_out / (pi / 2)
        return sum(sqrt(2 * radius * work.tolerance) + 3 * work.tolerance for radius in radii)
    if t.last >= t.end:
        return 0.0
    chord = hypot(*(path.ends[t.last] - path.starts[t.last]))
    if chord < (1.0 - 1e-9) * float(path.lengths[t.last]):
        return 0.0  # an arc, of which no place is on the contour
    return 2 * sqrt(2 * torch.lead_out * work.tolerance)  # the chord there may go on as far


def _lead_along(work: Work, t: Traced) -> float:
    """How far a stroke of steps comes along its contour: not an overcut, up to its first corner.

    From an inner corner a line leads in along the contour. Of paths with known corners that is no
    part of what runs along the ring; see `tracing._overs`.
    """
    if not work.stepped or t.before <= LEAD_SHARE * work.most_in:
        return 0.0
    path = work.path
    begin = float(path.begins[t.begin])
    lead = float(path.begins[t.first]) - begin
    along = np.arange(CORNER_SPAN, lead + CORNER_SPAN, CORNER_SPAN / 8)
    places = _places(work, begin + along)
    back = places - _places(work, begin + along - CORNER_SPAN)
    forth = _places(work, begin + along + CORNER_SPAN) - places
    turn = np.abs(
        np.arctan2(back[:, 0] * forth[:, 1] - back[:, 1] * forth[:, 0], (back * forth).sum(axis=1))
    )
    if not len(turn) or turn.max() < CORNER_RAD:
        return 0.0
    return t.before - max(0.0, lead - float(along[int(np.argmax(turn))]))


def _places(work: Work, at: Floats) -> Floats:
    """Places so far along all ways of the path."""
    way = np.searchsorted(work.path.begins, at, "right") - 1
    return work.path.point(way, at - work.path.begins[way])


def _retraced(work: Work, t: Traced) -> float:
    """How far a stroke that does not end where it began has gone on along its own first curves."""
    path = work.path
    if path.first[t.first] == path.last[t.last - 1]:
        return 0.0  # one line or arc
    begin = path.begins[t.first]
    length = float(path.begins[t.last - 1] + path.lengths[t.last - 1] - begin)
    places = np.array([path.starts[t.first], path.ends[t.last - 1]])
    pairs = path.near(places, work.tolerance)
    at = path.at(pairs.element, pairs.along) - begin
    mine = (work.of_way[path.owner[pairs.element]] == work.of_way[t.first]) & (at >= 0.0)
    again, ends = at[mine & (pairs.point == 0)], at[mine & (pairs.point == 1)]
    lengths = []
    for place in again[again > 4 * work.tolerance]:
        fits = np.abs(length - place - ends) <= 2 * work.tolerance
        for over in ends[fits & (ends > 2 * work.tolerance)].tolist():
            # Not their ends alone: it follows its first curves again from that place on.
            steps, way = over * np.linspace(0.125, 0.875, 7), np.full(7, t.first)
            off = path.point(way, steps) - path.point(way, place + steps)
            if (np.hypot(*off.T) <= 2 * work.tolerance).all():
                lengths.append(over)
    over = min(lengths, default=0.0)
    # The part itself may have more than one curve a little behind the start.
    beside = work.need.near(_places(work, np.array([begin + over / 2])), work.tolerance)
    drawn = np.sort(work.need.at(beside.element, beside.along))
    return 0.0 if (np.diff(drawn) > 8 * work.tolerance).any() else over


def required_overcut(work: Work, t: Traced, found: float, most: float = inf) -> float:
    """The overcut of a contour: that of its colour or layer, of small holes, or the machine's.

    It is no longer than `most`. Where a hole may be a small one or not, the one of both that is
    nearer to what was found.
    """
    torch = work.torch
    if t.stroke.goes_on:
        return 0.0  # the torch goes on to the next part where the contour closes
    if any(own.overcut is not None for own in torch.settings.values()):
        _, way = work.need.nearest_to(work.path.starts[t.first])
        own = torch.settings.get(work.required.looks[work.process][way], PLAIN).overcut
        if own is not None:
            return min(own, most)
    usual = min(torch.overcut, most)
    small = usual if torch.hole_overcut is None else min(torch.hole_overcut, most)
    if t.small is None:
        return min((small, usual), key=lambda over: abs(over - found))
    return small if t.small else usual


def _beside(work: Work, t: Traced) -> Limits:
    """How far a beam that the controller leads runs over its start, and within which limits.

    It comes to the contour half a kerf behind the start, and runs at least up to there. The overcut
    of a programmed arc is longer or shorter on the arc beside it.
    """
    path = work.path
    end = path.ends[t.last - 1]
    pairs = path.near(end.reshape(1, 2), work.tolerance)
    # A lead that runs so close to the contour that it was traced as part of it is still a lead.
    start = min(t.first + (t.first == t.begin), t.last - 1)
    at = path.at(pairs.element, pairs.along) - path.begins[start]
    mine = (work.of_way[path.owner[pairs.element]] == work.of_way[t.first]) & (at >= 0.0)
    found = float(np.min(at[mine], initial=np.inf))
    length = float(path.lengths[start : t.last].sum())
    found = 0.0 if found > length - 2 * work.tolerance else found
    room = STAYS * float(path.lengths[start]) - 3 * t.half_kerf
    required = required_overcut(work, t, found)
    least = min(required, max(0.0, room))
    radius = float(path.elements.arcs[path.first[[start]][0], 2])
    share = min(0.5, t.half_kerf / radius) if radius else 0.0
    return found, least * (1 - share), required * (1 + 2 * share) + 2 * t.half_kerf


# --- ends -----------------------------------------------------------------------------------------

# Strokes that begin or end in the middle of a contour.


#: Contours that leave a place in directions as near as this lie on one another there.
SAME_DIRECTION_DEG = 2.0
ROUNDING = 1e-9
End = tuple[Sequence[float], float]  #: where a contour ends, and in which direction it goes on

#: Tolerances along a path behind which it is elsewhere.
APART = 8.0


def end_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Ends of strokes in the middle of a contour, with nothing there or the start of another cut.

    Where the beam keeps off a contour, what is left of that says whether it closes. An edge that
    two contours share, or one has twice, is cut once: what is left ends on a third cut, or
    elsewhere on its own. With bridges the last of several cuts ends where the first began.
    """
    opened = [t for t in traced if not (t.closed or t.joined)]
    if not opened:
        return []
    path = work.path
    ways = np.array([way for t in opened for way in (t.first, t.last - 1)])
    stops = np.tile([False, True], len(opened))
    places = np.where(stops[:, None], path.ends[ways], path.starts[ways])
    touching = _touching(work, ways, places)
    once, looks = work.process == "cut" and not work.bridged, work.required.looks[work.process]
    on_line = np.array([not t.half_kerf for t in opened for _ in range(2)])
    counts = np.full(len(ways), 2)
    counts[on_line] = _directions(work.need, places[on_line], work.tolerance, work.torch.gap)
    diagnostics: list[Diagnostic] = []
    for k in np.flatnonzero(counts == 2).tolist():
        t, place = opened[k // 2], places[k]

        others = touching[k]
        if not others and on_line[k] and not work.on_kept_off(place.reshape(1, 2))[0]:
            what, line = "ends" if stops[k] else "begins", int(work.moves.line[ways[k]])
            contour = work.contour_at(place)
            diagnostics.append(work.fault(rules.OPEN, line, place, what=what, contour=contour))
        elif once and len(others) == 1:
            (other, is_end), *_ = others
            pairs = work.need.near(place.reshape(1, 2), t.half_kerf + work.tolerance)
            settings = {looks[way] for way in work.need.owner[pairs.element].tolist()}
            if is_end and other < work.of_way[t.first] and len(settings) <= 1:
                contour = work.contour_at(place)
                diagnostics.append(work.fault(rules.RESTART, t.stroke.line, place, contour=contour))
    return diagnostics[:SHOWN]


def _touching(work: Work, ways: Counts, places: Floats) -> list[set[tuple[int, bool]]]:
    """Other strokes at each end of some, and whether these end there; its own too, if elsewhere."""
    path, reach = work.path, 2 * work.tolerance
    low, high = np.full(len(work.strokes), -np.inf), np.full(len(work.strokes), np.inf)
    own = work.of_way[ways]
    low[own[::2]] = path.begins[ways[::2]]
    high[own[1::2]] = path.begins[ways[1::2]] + path.lengths[ways[1::2]]
    here = np.where(np.arange(len(ways)) % 2, high[own], low[own])
    pairs = path.near(places, reach)
    at, stroke = path.at(pairs.element, pairs.along), work.of_way[path.owner[pairs.element]]
    is_end = np.minimum(at - low[stroke], high[stroke] - at) <= 2 * reach
    is_other = stroke != own[pairs.point]
    is_other |= np.abs(at - here[pairs.point]) > APART * work.tolerance
    found: list[set[tuple[int, bool]]] = [set() for _ in places]
    columns = (pairs.point, stroke, is_end & (stroke != own[pairs.point]))
    for k in np.flatnonzero(is_other).tolist():
        point, other, ends = (column[k] for column in columns)
        found[int(point)].add((int(other), bool(ends)))
    return found


def _directions(need: Toolpaths, places: Floats, reach: float, gap: float) -> list[int]:
    """In how many directions contours go on from where they end at each place; 2 within one.

    A path may miss its end by `reach`. Ends farther apart than `gap` do not belong together,
    though both are within reach of the path's.
    """
    opened = np.flatnonzero(np.hypot(*(need.ends - need.starts).T) > 1e-9)
    corners = np.concatenate((need.starts[opened], need.ends[opened]))
    tree = shapely.STRtree(shapely.points(corners))
    place, which = tree.query(shapely.points(places), "dwithin", distance=reach)
    way, lengths = np.tile(opened, 2)[which], np.tile(need.lengths[opened], 2)[which]
    near = np.minimum(lengths / 2, 20 * reach)
    inner = need.point(way, np.where(which < len(opened), near, lengths - near))
    x, y = (inner - corners[which]).T
    beside: list[list[End]] = [[] for _ in places]
    columns = (place.tolist(), corners[which].tolist(), np.degrees(np.arctan2(y, x)).tolist())
    for k, corner, angle in zip(*columns, strict=True):
        beside[k].append((corner, angle))
    counts = []
    for at, ends in zip(places.tolist(), beside, strict=True):
        nearest = min((end for end, _ in ends), key=lambda end: dist(end, at), default=at)
        apart: list[float] = []
        for end, angle in ends:
            if dist(end, nearest) <= gap + ROUNDING and all(
                abs((angle - a + 180.0) % 360.0 - 180.0) > SAME_DIRECTION_DEG for a in apart
            ):
                apart.append(angle)
        counts.append(len(apart) if ends else 2)
    return counts


# --- dark -----------------------------------------------------------------------------------------

# What of a cut is run with the arc out: what follows where its contour is closed, and no more.


def dark_faults(work: Work, traced: Sequence[Traced], goes_out: bool) -> list[Diagnostic]:
    """Cuts that are left dark before they are closed, or burn on behind that where they must not.

    `goes_out` says that the arc does so where a cut with an overcut is closed.
    """
    by_machine = work.torch.kerf_by == "machine"
    diagnostics: list[Diagnostic] = []
    for t in traced:
        closed = t.closed and len(t.members) == 1
        closed = closed and bool((by_machine and t.half_kerf) or required_overcut(work, t, t.over))
        due = closed and goes_out and work.process == "cut"
        dark, beyond = t.stroke.dark, t.end - t.last if due else 0
        if dark == beyond and bool(dark) == due:
            continue
        # The path may come back to where it joins its contour: what comes along that for no longer
        # than a lead may be one, or the contour's beginning.
        way = t.end - dark
        if due and dark and t.first < way < t.last:
            away = work.path.starts[t.begin : t.first] - work.path.starts[way]
            if (np.hypot(*away.T) <= work.meeting).any():
                continue
        expected = _shown(beyond) if beyond or not due else "the arc out where it is closed"
        values = {"found": _shown(dark), "expected": expected}
        contour = work.contour_at(work.path.starts[t.first])
        diagnostics.append(work.fault(rules.DARK, t.stroke.line, contour=contour, **values))
    return diagnostics[:SHOWN]


def _shown(moves: int) -> str:
    return f"the arc out on the last {moves} moves" if moves else "the arc on to the end"
