r"""The plane ends of tubes on their unrolled surface.

  x |   /\            A plane through a tube meets the outside of its wall along one line and the
____|_ /  \ _____     inside along another: of a round tube sines of u, the inner one as much lower
    | /    \          as its radius is smaller. The torch cuts square to the surface where the wall
    |/      \__       reaches farthest, outside on one half of the way round and inside on the
                      other, so that no steel is missing.
"""

from collections.abc import Iterable, Sequence
from math import atan2, ceil, hypot, pi, radians, sqrt, tan
from typing import Literal

import numpy as np
from shapely import Polygon, union_all
from shapely.affinity import translate

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Point
from beamcam.model.part import EndPlane, Part
from beamcam.model.surface import Around
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping.ends import SectionEnd
from beamcam.planning.coping.regions import CHORD, Shape

OVERLAP = 1e-4  #: mm by which patches overlap, so that they are one shape
SKEW_DEG = 0.2  #: of an end; less is noise of a header


def own_planes(part: Part, features: Iterable[int]) -> list[SectionEnd]:
    """The planes among some of a part's features that end it, each on its side."""
    cuts = [f for f in map(part.features.__getitem__, features) if isinstance(f, EndPlane)]
    return [
        SectionEnd(1 if a > 0.0 else -1, one.x(0.0, 0.0), b / a, c / a)
        for one in cuts for a, b, c in (one.normal,)
    ]  # fmt: skip


def line_of(plane: SectionEnd, way: Around) -> Floats:
    """Rows of (x, s) once round the surface, along which the end of a plane is cut: outside or
    inside, where the wall reaches farthest."""
    rows: list[Point] = []
    pick = min if plane.side < 0 else max
    first = atan2(plane.by_y, plane.by_z)  # where outside and inside are at one x, and half on
    for leg in way.legs:
        patch, r = leg.patch, leg.patch.radius
        us = {patch.low, patch.high}
        if r:
            lean = r * hypot(plane.by_y, plane.by_z)
            count = ceil((patch.high - patch.low) / r / sqrt(4 * CHORD / lean)) if lean else 1
            us |= {*np.linspace(patch.low, patch.high, max(count, 8) + 1).tolist()}
            turns = ((first - patch.first_rad + k * pi) % (2 * pi) for k in (0, 1))
            us |= {r * turn for turn in turns if r * turn < patch.high}
        for u in sorted(us, reverse=leg.way < 0):
            (_, y, z), (ny, nz), wall = patch.point(0.0, u), patch.normal(u), patch.thickness
            outside, inside = plane.x(y, z), plane.x(y - wall * ny, z - wall * nz)
            rows.append((pick(outside, inside), leg.s(u)))
    return np.array(rows)


def within(shape: Shape, planes: Sequence[SectionEnd], way: Around) -> Shape:
    """What stays of a surface on one turn between its ends."""
    for plane in planes:
        xs, ss = line_of(plane, way).T
        x0, _, x1, _ = shape.bounds if not shape.is_empty else (0.0,) * 4
        far = min(x0, xs.min()) - 1.0 if plane.side > 0 else max(x1, xs.max()) + 1.0
        ends = ss[0] - OVERLAP, ss[-1] + OVERLAP
        rows = [*zip(xs.tolist(), ss.tolist(), strict=True)]
        rows = [(xs[0], ends[0]), *rows, (xs[-1], ends[1])]
        shape = shape.intersection(Polygon([(far, ends[0]), *rows, (far, ends[1])]))
    return shape


def header_slopes(part: Part, side: int) -> tuple[float, float]:
    """tan of the angles that the header has for an end, of the web and of the flange; 0 for noise,
    and where a plane of the part says the same."""
    cuts = part.cuts
    both = (cuts.web_start, cuts.flange_start) if side < 0 else (cuts.web_end, cuts.flange_end)
    web, flange = (tan(radians(deg)) if abs(deg) > SKEW_DEG else 0.0 for deg in both)
    near = tan(radians(SKEW_DEG))
    for one in own_planes(part, range(len(part.features))):
        if one.side == side and max(abs(one.by_y - web), abs(one.by_z - flange)) <= near * (
            1.0 + web**2 + flange**2
        ):
            return 0.0, 0.0
    return web, flange


def denied(part: Part, plane: tuple[int, float]) -> Diagnostic:
    """The error of an end that the header has otherwise than the outlines, by its side and its
    slope along the web."""
    at: Literal["start", "end"] = "start" if plane[0] < 0 else "end"
    kind: Literal["web", "flange"] = "web" if plane[1] else "flange"
    return bar_rules.CUT_DENIED.at(
        part.cut_source(kind, at), kind=kind, found=f"{getattr(part.cuts, f'{kind}_{at}'):g}",
        end=at, expected="another line",
    )  # fmt: skip


def several(once: Shape, turn: float, which: Iterable[int]) -> Shape:
    """What lies on one turn of the surface, on several."""
    return union_all([translate(once, 0.0, k * turn) for k in which])
