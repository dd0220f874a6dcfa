"""Edges of plates at which a header has an end skew through the thickness: required square."""

from collections.abc import Iterator, Sequence
from math import atan2, degrees, hypot, radians, tan

from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.model.part import PLATE_FACES, Bevel, Contour, Part

SKEW_DEG = 1.0  #: of an angle in a header; less is noise of who wrote the file
ON_EDGE = 1.0  #: mm that the edge of an outline may lie off the end that it is

Edge = tuple[Point, Point, float]  #: its ends, and degrees that it leans under face v


def skew_ends(parts: Sequence[Part], machine: Machine) -> Iterator[Diagnostic]:
    """Ends that a header has skew through the thickness, where no bevel of an outline says more."""
    least = max(SKEW_DEG, machine.torch.min_bevel if machine.torch is not None else 0.0)
    for part in parts:
        if not any(isinstance(f, Contour) and f.bevels for f in part.features):
            for end, angle in (("start", part.cuts.flange_start), ("end", part.cuts.flange_end)):
                if abs(angle) >= least:
                    yield rules.SKEW_END.at(part.source, end=end, found=f"{angle:g}")


def with_skew_edges(part: Part, torch: Torch) -> Part:
    """A plate with its skew ends as bevels of its outline, if all of them are edges of that."""
    outer = [
        (k, f) for k, f in enumerate(part.features)
        if isinstance(f, Contour) and f.kind == "outer" and f.process == "cut"
        and f.face in PLATE_FACES
    ]  # fmt: skip
    bevelled = any(isinstance(f, Contour) and f.bevels for f in part.features)
    is_plate = part.profile.code == "B" and part.measures is None and part.profile.height > 0.0
    if bevelled or not is_plate:
        return part
    start, end = _edge(part, 0), _edge(part, 1)
    skew = [e for e, deg in ((start, part.cuts.flange_start), (end, part.cuts.flange_end))
            if abs(deg) >= max(SKEW_DEG, torch.min_bevel)]  # fmt: skip
    features = list(part.features)
    if not outer:
        ring = (start[0], end[0], end[1], start[1], start[0])
        sides = tuple(map(Line, ring[:-1], ring[1:]))
        outer = [(len(features), Contour("v", "outer", sides, part.source))]
        features += [outer[0][1]] if skew else []
    met: set[Edge] = set()
    for k, outline in outer:
        bevels = []
        for c, side in enumerate(outline.curves):
            for edge in skew:
                if isinstance(side, Line) and _off(side.start, edge) + _off(side.end, edge) == 0.0:
                    bevels.append(Bevel(c, edge[2], 0.0))
                    met.add(edge)
        if bevels:
            features[k] = replace(outline, bevels=tuple(bevels))
    return replace(part, features=tuple(features)) if skew and len(met) == len(skew) else part


def _edge(part: Part, at_end: int) -> Edge:
    """The edge of an end of a plate where it is longest, of its corners on both faces."""
    cuts = part.cuts
    pair = (cuts.web_end, cuts.flange_end) if at_end else (cuts.web_start, cuts.flange_start)
    by_y, by_z = (tan(radians(deg)) for deg in pair)
    high, thick = part.profile.height, part.profile.web_thickness or 0.0
    lean = {(y, z): -y * by_y - z * by_z for y in (0.0, high) for z in (0.0, thick)}
    # The outermost corner lies at x 0, or at the length.
    shift = part.length - max(lean.values()) if at_end else -min(lean.values())
    outermost = max if at_end else min
    low, top = (shift + outermost(lean[y, 0.0], lean[y, thick]) for y in (0.0, high))
    shorter = (lean[0.0, 0.0] - lean[0.0, thick]) * (1.0 if at_end else -1.0)  # v than h, along x
    across = shorter * high / hypot(high, top - low)
    return (low, 0.0), (top, high), degrees(atan2(across, thick))


def _off(place: Point, edge: Edge) -> float:
    """mm that a place lies off the line of an edge along x, 0 for as much as may be."""
    (x0, _), (x1, high), _ = edge
    off = abs(place[0] - x0 - (x1 - x0) * place[1] / high)
    return off if off > ON_EDGE else 0.0
