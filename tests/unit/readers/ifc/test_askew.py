"""Meshes of mitred members with roundings, whose facets run askew from one end to the other."""

from math import cos, radians, sin

import pytest

from beamcam.readers.ifc import Options, read
from tests.conftest import sampled
from tests.property.ifc_cuts import Bar, Box, Half, model_of
from tests.property.ifc_kernel import meshed

BARS = {
    "RO": Bar("RO", 1500.0, (168.3, 168.3, 6.3, 6.3, 0.0)),
    "RU": Bar("RU", 1500.0, (60.0, 60.0, 0.0, 60.0, 0.0)),
    "M": Bar("M", 1500.0, (150.0, 100.0, 6.0, 6.0, 12.0)),
    "C": Bar("C", 1500.0, (200.0, 75.0, 2.5, 2.5, 4.0), 20.0),
}
ENDS = {"web": (45.0, 0.0), "flange": (0.0, 30.0), "both": (30.0, 20.0)}


def mitre(bar: Bar, end: str, side: int = 1) -> Half:
    turn, lean = map(radians, ENDS[end])
    h, b = bar.sizes[:2]
    normal = (side * cos(turn) * cos(lean), sin(turn) * cos(lean), sin(lean))
    return Half((bar.length - 150.0 if side > 0 else 150.0, h / 2, b / 2), normal)


@pytest.mark.parametrize(
    ("code", "ends"),
    sampled(
        [
            *((code, (end,)) for code in BARS for end in ENDS),
            *((code, ("web", "flange")) for code in ("RU", "M", "C")),
        ],
        8,
    ),
)
def test_a_mesh_is_read_as_what_it_stands_for(code: str, ends: tuple[str, ...]) -> None:
    """Round ones that are mitred twice have no edge along their axis."""
    bar = BARS[code]
    cuts = [mitre(bar, end, side) for end, side in zip(ends, (1, -1), strict=False)]
    data = model_of(bar, cuts)
    (part,), (mesh, *others) = read(data, "m.ifc").parts, read(meshed(data), "m.ifc").parts
    assert others == []
    sizes, read_back = (
        (p.profile.code, p.profile.height, p.profile.width, p.profile.web_thickness, p.length)
        for p in (part, mesh)
    )
    assert read_back[0] == sizes[0]
    assert read_back[1:] == pytest.approx(sizes[1:], abs=0.01)
    assert mesh.profile.radius == pytest.approx(part.profile.radius, abs=0.01)
    assert mesh.weight == pytest.approx(part.weight, rel=2e-3)


@pytest.mark.parametrize("code", ["RO", "M", "C"])
def test_a_cut_that_no_feature_holds_is_seen_between_such_facets(code: str) -> None:
    """A groove 3 mm deep round the middle of the member."""
    bar = BARS[code]
    h = bar.sizes[0]
    groove = Box((700.0, -9.0, -9.0), (720.0, h + 9.0, min(3.0, bar.sizes[3] * 0.6)))
    data = meshed(model_of(bar, [mitre(bar, "web"), groove]))
    found = read(data, "m.ifc", options=Options(kernel=True))
    assert found.parts == ()
