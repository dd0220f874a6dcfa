r"""Small holes: which strokes go round one, their feed, and how they are led into.

A round one is entered from its middle where the machine says so:

        .-----.         from the middle M half a circle, tangent to the path at C
       /   .-. \
      C   /   M |       asked where that keeps half a kerf off all contours; what lies in the hole
       \_/     /        may be in its way
        `-----'
"""

from collections.abc import Iterator, Sequence
from math import dist, pi

import numpy as np

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Arc
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.tabs import ring_depths
from beamcam.verify.sheets.work import SHOWN, Traced, Work

ROUND, ROUND_DEG = 1e-6, 1e-6  #: mm and degrees that the arcs of a round hole may be apart
ROUND_DOUBT = 2e-3  #: of the way round a hole, by which it may be a small one or not


def hole_faults(work: Work, traced: Sequence[Traced]) -> Iterator[Diagnostic]:
    """Strokes that run as in a small hole elsewhere, or in one as elsewhere."""
    if not any(s.row.slows_holes for s in work.strokes):
        return
    told = 0
    for t in traced:
        expected, found = t.small, t.stroke.in_hole
        if expected is None or found is None or expected == found or not t.stroke.row.slows_holes:
            continue
        told += 1
        if told <= SHOWN:
            share = f"{t.stroke.row.hole_feed_share * 100:g} %"
            contour = work.contour_at(work.path.starts[t.first])
            yield rules.HOLE_FEED.at(
                Source(work.name, t.stroke.line), contour=contour,
                found=share if found else "all", expected=share if expected else "all",
            )  # fmt: skip


def find_small(work: Work, traced: Sequence[Traced]) -> None:
    """Tell each stroke whether it goes round a small hole; None where it is as good as either."""
    if not any(s.row.hole_diameter for s in work.strokes):
        return
    rings = [t for t in traced if t.members or (t.contour is not None and not t.joined)]
    polygons = [t.inside() for t in rings]
    small: dict[int, bool | None] = {}  #: by stroke; None: as good as either
    for t, polygon, depth in zip(rings, polygons, ring_depths(polygons), strict=True):
        row = t.stroke.row
        around = polygon.length if polygon is not None else 0.0
        limit, doubt = pi * row.hole_diameter, ROUND_DOUBT * around + 8 * work.tolerance
        is_small: bool | None = around < limit and depth is not None and depth % 2 == 1
        if depth is None or (depth % 2 == 1 and abs(around - limit) <= doubt):
            is_small = None
        small |= {id(one.stroke): is_small for one in t.members or [t]}
    for t in traced:
        t.small = small.get(id(t.stroke), False)


def middle_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Small round holes that are not entered from their middle, by half a circle."""
    if work.torch.hole_lead != "middle" or not any(t.small for t in traced):
        return []
    import shapely

    points, begins = work.need.outlines(work.fine)
    owner = np.repeat(np.arange(work.need.count), np.diff(begins))
    contours = shapely.STRtree(shapely.linestrings(points, indices=owner))
    said: list[Diagnostic] = []
    for t in traced:
        if not t.small or t.joined:
            continue
        at = work.path.starts[t.first]
        circle = _circle(work, work.need.nearest_to(at)[1])
        if circle is None:
            continue
        middle = np.array(circle.centre) + np.array(work.shift)
        first = int(np.searchsorted(work.of_way, work.of_way[t.first]))
        away = float(np.hypot(*(work.path.starts[first] - middle)))
        # What of a short ring comes before its end again may have been traced as a lead.
        joins = work.path.ends[first]
        on_ring = abs(float(np.hypot(*(joins - middle)) - np.hypot(*(at - middle))))
        smooth = on_ring <= 2 * work.tolerance and _is_half_circle(work, first, middle, joins)
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
        found = f"{away:.3f} mm off its middle"
        if away <= 2 * work.tolerance:
            found = "another way from its middle"
        contour = work.contour_at(at)
        said.append(
            rules.HOLE_LEAD.at(Source(work.name, t.stroke.line), contour=contour, found=found)
        )
    return said[:SHOWN]


def _circle(work: Work, way: int) -> Arc | None:
    """The first arc of a needed contour that is round all about; None of another."""
    need, process = work.asked, work.process
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


def _is_half_circle(work: Work, way: int, middle: Floats, at: Floats) -> bool:
    """Whether a way goes by half a circle from the middle of a hole to a place of its path."""
    half = work.path.point(np.array([way]), np.array([work.path.lengths[way] / 2]))[0]
    radius = float(np.hypot(*(at - middle))) / 2
    return bool(
        abs(float(np.hypot(*(half - (at + middle) / 2))) - radius) <= 2 * work.tolerance
        and abs(float(work.path.lengths[way]) - pi * radius) <= 4 * work.tolerance
    )
