"""Outlines with splines."""

from collections.abc import Sequence
from itertools import pairwise
from math import comb

import pytest

from beamcam.geometry.curves import signed_area
from beamcam.readers.ifc import Options, read
from tests.unit.readers.ifc.models import Small

Edge = tuple[tuple[float, float], ...]
CORNERS = ((0.0, 0.0), (600.0, 0.0), (600.0, 300.0), (0.0, 300.0))
CUBIC = ((0.0, 0.0), (200.0, -60.0), (400.0, 80.0), (600.0, 0.0))
HALF = ((0.0, 0.0), (300.0, -200.0), (600.0, 0.0))


def plate(schema: str, kind: str, edge: Edge, rest: str) -> bytes:
    """A plate of 20 mm whose lower edge is a spline, with a hole of 20 mm."""
    m = Small(schema)
    ends = [m.step.point(*p) for p in CORNERS]
    control = [ends[0], *(m.step.point(*p) for p in edge[1:-1]), ends[1]]
    spline = m.add(f"{kind}({len(edge) - 1},({','.join(control)}),.UNSPECIFIED.,.F.,.F.{rest})")
    line = m.add(f"IFCPOLYLINE(({ends[1]},{ends[2]},{ends[3]},{ends[0]}))")
    pieces = [
        m.add(f"IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,{curve})") for curve in (spline, line)
    ]
    curve = m.add(f"IFCCOMPOSITECURVE(({','.join(pieces)}),.F.)")
    profile = m.add(f"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,{curve})")
    hole = m.hole((-5.0, 300.0, 150.0), (1, 0, 0), 20.0, 40.0)
    m.element(m.minus(m.extruded(profile, 20.0), hole), "IFCPLATE")
    return m.data


def drawn(edge: Edge, weights: Sequence[float], t: float) -> tuple[float, float]:
    """A place on a rational Bezier curve."""
    n = len(edge) - 1
    shares = [w * comb(n, k) * t**k * (1 - t) ** (n - k) for k, w in enumerate(weights)]
    x, y = (sum(s * p[i] for s, p in zip(shares, edge, strict=True)) for i in (0, 1))
    return x / sum(shares), y / sum(shares)


@pytest.mark.parametrize(
    ("schema", "kind", "edge", "rest", "weights"),
    [
        ("IFC4", "IFCBSPLINECURVEWITHKNOTS", CUBIC, ",(4,4),(0.,1.),.UNSPECIFIED.", (1, 1, 1, 1)),
        ("IFC4", "IFCRATIONALBSPLINECURVEWITHKNOTS", HALF,
         ",(3,3),(0.,1.),.UNSPECIFIED.,(1.,0.5,1.)", (1, 0.5, 1)),
        ("IFC2X3", "IFCBEZIERCURVE", CUBIC, "", (1, 1, 1, 1)),
        ("IFC2X3", "IFCRATIONALBEZIERCURVE", HALF, ",(1.,0.5,1.)", (1, 0.5, 1)),
    ],
)  # fmt: skip
def test_a_plate_with_a_spline_for_an_edge_has_arcs_along_it(
    schema: str, kind: str, edge: Edge, rest: str,
    weights: Sequence[float],
) -> None:  # fmt: skip
    plain = Options(kernel=len(weights) == 4)  # of one curve of each schema by the kernel too
    found = read(plate(schema, kind, edge, rest), "m.ifc", options=plain)
    assert not found.refused, found.diagnostics
    (part,) = found.parts
    assert part.profile.code == "B"
    assert len([*part.holes]) == 1
    (outline,) = part.contours
    points = [drawn(edge, weights, k / 4000) for k in range(4001)]
    under = sum((b[0] - a[0]) * (a[1] + b[1]) / 2 for a, b in pairwise(points))
    area = 600.0 * 300.0 - under
    assert abs(signed_area(outline.curves)) == pytest.approx(area, abs=0.015 * 650.0)


def test_a_spline_that_is_not_well_formed_refuses_its_plate() -> None:
    data = plate("IFC4", "IFCBSPLINECURVEWITHKNOTS", CUBIC, ",(4,3),(0.,1.),.UNSPECIFIED.")
    found = read(data, "m.ifc")
    assert [d.code for d in found.diagnostics] == ["ifc-geometry", "ifc-ledger"]
    assert "a spline that is not well formed" in found.diagnostics[0].message
