"""Where the torch pierces: as far from the part as the hole that it burns is wide, if it can.

Asked of programs that keep the kerf off and lead in by themselves: a controller's own compensation
has a rule of its own for its entry, and stairs of steps do not tell how a path begins. There is
room where the machine's lead, in all its length, would keep half a kerf off every contour where the
program joins this one, and its far end the radius of that hole.

          S   line: square to the path          .-  arc: a quarter circle, tangent to it
          |                                    S
        --C--->  path                        --C--->
"""

from collections.abc import Sequence
from math import pi

import numpy as np
import shapely

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.work import SHOWN, Traced, Work

ALONG = 33  #: corners of the line that stands for a lead


def pierce_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Strokes round a contour that pierce too near to one although there is room for a lead."""
    row = work.asked.rows.get(work.process)
    rings = [t for t in traced if t.half_kerf and t.ring and not t.joined and t.bridge_to is None]
    if row is None or not rings or not row.pierce_radius:
        return []
    points, begins = work.need.outlines(work.fine)
    owner = np.repeat(np.arange(work.need.count), np.diff(begins))
    contours = shapely.STRtree(shapely.linestrings(points, indices=owner))
    firsts = [int(np.searchsorted(work.of_way, work.of_way[t.first])) for t in rings]
    pierced = work.path.starts[firsts]
    away, nearest = _distances(contours, pierced)
    said: list[Diagnostic] = []
    near = row.pierce_radius - work.slack[nearest] - 2 * work.fine
    for k in np.flatnonzero(away < near).tolist():
        lead = _whole_lead(work, rings[k], contours)
        # A planner keeps off by a hair less; where that decides, either may be right.
        kept = work.half_kerf - work.fine
        blocked = contours.query(shapely.LineString(lead), "dwithin", distance=kept)
        far = row.pierce_radius + work.tolerance
        if len(blocked) or _distances(contours, lead[-1:])[0][0] < far:
            continue
        x, y = pierced[k].tolist()
        said.append(
            rules.PIERCE.at(
                Source(work.name, rings[k].stroke.line), x=f"{x:.3f}", y=f"{y:.3f}",
                found=f"{away[k]:.3f}", contour=work.contour(int(nearest[k])),
                expected=f"{row.pierce_radius:g}", lead=f"{work.torch.lead_in:g}",
            )
        )  # fmt: skip
    return said[:SHOWN]


def edge_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Open strokes beside a contour that begin on no path that was cut before.

    They are what is left of contours whose other edges are cut with those of another part.
    """
    said: list[Diagnostic] = []
    firsts = np.searchsorted(work.of_way, np.arange(len(work.strokes)))
    for t in traced:
        if not t.half_kerf or t.members or t.joined or t.closed:
            continue
        number = int(work.of_way[t.first])
        begin = work.path.starts[firsts[number]].reshape(1, 2)
        near = work.path.near(begin, 2 * work.tolerance)
        if (work.of_way[work.path.owner[near.element]] < number).any():
            continue
        x, y = begin[0].tolist()
        contour = work.contour_at(begin[0])
        source = Source(work.name, t.stroke.line)
        said.append(rules.EDGE.at(source, contour=contour, x=f"{x:.3f}", y=f"{y:.3f}"))
    return said[:SHOWN]


def _distances(contours: shapely.STRtree, points: Floats) -> tuple[Floats, Floats]:
    """How far each point is from the nearest contour, and which one that is."""
    places = shapely.points(points)
    nearest = contours.nearest(places)
    return shapely.distance(places, contours.geometries[nearest]), nearest


def _whole_lead(work: Work, t: Traced, contours: shapely.STRtree) -> Floats:
    """Places of the machine's lead from where a stroke joins its contour to its far end, (n, 2)."""
    at, (tx, ty) = work.path.starts[t.first], work.heading(t, at_end=False)
    place = shapely.Point(at)
    nearest = contours.geometries[contours.nearest(place)]
    foot = shapely.get_coordinates(shapely.shortest_line(place, nearest))[1]
    normal = np.array((-ty, tx))
    if np.dot(normal, at - foot) < 0.0:  # the waste is where the path keeps off to
        normal = -normal
    share = np.linspace(0.0, 1.0, ALONG)[:, None]
    length = work.torch.lead_in
    if work.torch.lead == "line":
        found: Floats = at + share * length * normal
        return found
    radius, turn = length / (pi / 2), share * pi / 2
    back = np.array((-tx, -ty))
    found = at + radius * ((1.0 - np.cos(turn)) * normal + np.sin(turn) * back)
    return found
