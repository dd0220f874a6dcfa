"""What several planes at one end of a stock leave of it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers.ifc import Options, read
from beamcam.readers.ifc.cutters import HalfSpace, trim
from tests.property.ifc_cuts import Bar, Half, model_of
from tests.property.ifc_kernel import facets
from tests.unit.readers.ifc.models import Small

SLOPES = st.sampled_from((0.0, 0.0, 0.5, -0.5, 1.25)) | st.floats(-2, 2)
CORNERS = ((0.0, 0.0), (0.0, 150.0), (300.0, 0.0), (300.0, 150.0), (10.0, 71.0), (290.0, 71.0))


@st.composite
def planes(draw: st.DrawFn) -> list[HalfSpace]:
    side = draw(st.sampled_from((-1, 1)))
    found = [HalfSpace.at(side, draw(st.floats(-50, 50)))]
    for _ in range(draw(st.integers(0, 3))):
        found.append(HalfSpace.at(side, draw(st.floats(-500, 500)), draw(SLOPES), draw(SLOPES)))
    return found


@given(planes())
def test_what_is_left_lies_before_every_plane(ends: list[HalfSpace]) -> None:
    found = trim(ends[0], ends[1:], CORNERS)
    left = [min(e.side * e.x(y, z) for e in ends) for y, z in CORNERS]
    assert abs(found.least - min(left)) < 1e-9
    assert abs(found.most - max(left)) < 1e-9
    assert found.planes == tuple(ends)


@given(planes())
def test_the_sole_plane_is_the_first_that_no_other_comes_before(ends: list[HalfSpace]) -> None:
    """Within 1e-4 mm at every corner; two planes that cross in the section share the end."""
    first = [
        one
        for one in ends
        if all(
            one.side * one.x(y, z) <= e.side * e.x(y, z) + 1e-4 for y, z in CORNERS for e in ends
        )
    ]
    found = trim(ends[0], ends[1:], CORNERS)
    assert found.sole == (first[0] if first else None)
    reach = max(first[0].side * first[0].x(y, z) for y, z in CORNERS) if first else found.most
    assert abs(found.reach - reach) < 1e-9


TUBE = Bar("M", 2000.0, (200.0, 100.0, 8.0, 8.0, 12.0))
LIPPED = Bar("C", 2000.0, (200.0, 70.0, 3.0, 3.0, 6.0), girth=20.0)


@pytest.mark.parametrize("bar", [TUBE, LIPPED], ids=["tube", "lipped channel"])
@pytest.mark.parametrize("normal", [(1.0, 0.3, 0.2), (1.0, -0.5, 0.4), (-1.0, 0.3, -0.7)])
def test_round_corners_reach_less_far_than_sharp_ones(bar: Bar, normal: tuple[float, ...]) -> None:
    """Mitred both ways, a section with bends is as long as its bends reach."""
    x = 1700.0 if normal[0] > 0 else 300.0
    data = model_of(bar, [Half((x, 100.0, 40.0), normal)])
    found = read(data, "m.ifc", options=Options(kernel=True))
    assert not found.refused, found.diagnostics
    (part,) = found.parts
    points, _ = facets(data)
    xs = [x for x, _, _ in points]
    assert part.length == pytest.approx(max(xs) - min(xs), abs=0.02)


@pytest.mark.parametrize("normal", [(1.0, 0.3, 0.2), (1.0, 0.5, -0.4), (-1.0, -0.3, -0.7)])
def test_round_corners_of_a_special_section_reach_as_they_are_drawn(
    normal: tuple[float, float, float],
) -> None:
    """A trapezium whose upper corners are rounded by 20 mm, against the geometry kernel."""
    m, r = Small(), 20.0
    k = r * (1 - 0.5**0.5)
    points = [(30.0, 0.0), (70.0, 0.0), (100.0, 130.0), (100 - k, 150 - k), (80.0, 150.0),
              (20.0, 150.0), (k, 150 - k), (0.0, 130.0)]  # fmt: skip
    written = ",".join(f"({x},{y})" for x, y in points)
    at = m.add(f"IFCCARTESIANPOINTLIST2D(({written}))")
    sides = (
        "IFCLINEINDEX((1,2,3)),IFCARCINDEX((3,4,5)),IFCLINEINDEX((5,6)),IFCARCINDEX((6,7,8)),"
        "IFCLINEINDEX((8,1))"
    )
    outline = m.add(f"IFCINDEXEDPOLYCURVE({at},({sides}),$)")
    profile = m.add(f"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,{outline})")
    half = m.half((1700.0 if normal[0] > 0 else 300.0, 0.0, 0.0), normal)
    m.element(m.minus(m.extruded(profile, 2000.0), half))
    found = read(m.data, "m.ifc", options=Options(kernel=True))
    assert [part.profile.code for part in found.parts] == ["SO"], found.diagnostics
    xs = [x for x, _, _ in facets(m.data)[0]]
    assert found.parts[0].length == pytest.approx(max(xs) - min(xs), abs=0.05)
