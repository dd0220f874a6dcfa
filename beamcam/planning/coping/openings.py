"""Holes and cut-outs of a web near to a flange: how near the torch comes, and why no nearer."""

from collections.abc import Sequence

from beamcam.errors import Diagnostic
from beamcam.machine.coper import Coper
from beamcam.model.part import Contour, Part
from beamcam.planning.coping import rules
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.regions import Cut, Shape, WallRegion, curves_of, shape_of
from beamcam.planning.coping.walls import EDGE, Root


def without_openings(
    web: WallRegion, part: Part, features: Sequence[int], chart: Chart, coper: Coper
) -> tuple[WallRegion, list[Diagnostic]]:
    """A web without its openings near to a flange, and an error of each that is too near.

    `features` are those of the part that lie on the web. Openings that go on beyond an end or meet
    another cut there stay.
    """
    from shapely import box

    shape, said = web.shape, list[Diagnostic]()
    row, widest = chart.row(web.wall.thickness), max(row.kerf for row in coper.rows)
    half = row.kerf / 2 if row else 0.0
    for feature in map(part.features.__getitem__, features):
        is_outer = isinstance(feature, Contour) and feature.kind != "inner"
        if is_outer or not isinstance(feature, Cut):
            continue
        gone: Shape = shape_of(curves_of(feature))
        x0, y0, x1, y1 = gone.bounds
        for root in web.wall.roots:
            low = root.low == 0.0
            off = y0 if low else web.wall.width - y1
            thick, high, round_to = _from_outside(root, web.wall.width, part.profile.radius)
            if off >= chart.depth(high + coper.root_over) + EDGE:
                continue
            band = (0.0, off + half + high) if low else (y0 - half - high, web.wall.width)
            filled = web.shape.union(gone)
            if not filled.covers(box(x0 - widest, max(band[0], 0.0), x1 + widest, band[1])):
                continue
            shape, least = shape.union(gone), max(high, round_to) - half
            if off < least:
                what = "a cut-out" if isinstance(feature, Contour) else "a hole"
                how = f"that reaches {thick - max(off, 0.0):.1f} mm into" if off < thick else (
                    f"{off - thick:.1f} mm beside the inner surface of")  # fmt: skip
                said.append(rules.ROOT.at(
                    feature.source, what=f"{what} {how} face {root.face}", x=f"{x0:.1f}",
                    face=web.wall.face,
                    expected=f"one {least:.1f} mm off the outside of face {root.face} at least, "
                    "where the torch over the web comes",
                ))  # fmt: skip
    return WallRegion(web.wall, shape, web.rounded), said


def _from_outside(root: Root, width: float, radius: float) -> tuple[float, float, float]:
    """How far off the outside of its flange a root has the flange's inner surface, the place that
    the torch comes to, and the end of its fillet."""
    if root.low == 0.0:
        return root.inner, root.high, root.inner + radius
    return width - root.inner, width - root.low, width - root.inner + radius
