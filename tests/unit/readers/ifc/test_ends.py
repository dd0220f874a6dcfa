"""What several planes at one end of a stock leave of it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers.ifc import Options, read
from beamcam.readers.ifc.ends import End, trim
from tests.property.ifc_cuts import Bar, Half, model_of
from tests.property.ifc_kernel import facets

SLOPES = st.sampled_from((0.0, 0.0, 0.5, -0.5, 1.25)) | st.floats(-2, 2)
CORNERS = ((0.0, 0.0), (0.0, 150.0), (300.0, 0.0), (300.0, 150.0), (10.0, 71.0), (290.0, 71.0))


@st.composite
def planes(draw: st.DrawFn) -> list[End]:
    side = draw(st.sampled_from((-1, 1)))
    found = [End(side, 0.0, 0.0, draw(st.floats(-50, 50)))]
    for _ in range(draw(st.integers(0, 3))):
        found.append(End(side, draw(SLOPES), draw(SLOPES), draw(st.floats(-500, 500))))
    return found


@given(planes())
def test_what_is_left_lies_before_every_plane(ends: list[End]) -> None:
    found = trim(ends[0], ends[1:], CORNERS)
    left = [min(e.side * e.x(y, z) for e in ends) for y, z in CORNERS]
    assert abs(found.least - min(left)) < 1e-9
    assert abs(found.most - max(left)) < 1e-9
    assert found.planes == tuple(ends)


@given(planes())
def test_the_sole_plane_is_the_first_that_no_other_comes_before(ends: list[End]) -> None:
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
