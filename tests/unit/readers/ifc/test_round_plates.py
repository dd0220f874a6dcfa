"""Plates whose ends are round: discs, rings, cleats with a half circle for an end."""

from math import pi

import pytest

from beamcam.errors import Severity
from beamcam.geometry.curves import signed_area
from beamcam.model.part import Contour, Hole
from beamcam.readers.ifc import Options, read
from tests.unit.readers.ifc.models import Small

UP = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)


def plate(m: Small, profile: str, thickness: float = 12.0) -> bytes:
    m.element(m.extruded(profile, thickness, m.step.axes(*UP)), "IFCPLATE")
    return m.data


def round_ended(length: float, width: float, ends: int) -> bytes:
    """A flat bar with a half circle at one end or at both."""
    m = Small()
    r = width / 2
    corners = [(0.0, -r), (length, -r), (length + r, 0.0), (length, r), (0.0, r), (-r, 0.0)]
    used = corners if ends == 2 else corners[:5]
    points = ",".join(f"({x},{y})" for x, y in used)
    last = "IFCLINEINDEX((4,5)),IFCARCINDEX((5,6,1))" if ends == 2 else "IFCLINEINDEX((4,5,1))"
    listed = m.add(f"IFCCARTESIANPOINTLIST2D(({points}))")
    line = f"IFCLINEINDEX((1,2)),IFCARCINDEX((2,3,4)),{last}"
    curve = m.add(f"IFCINDEXEDPOLYCURVE({listed},({line}),.F.)")
    return plate(m, m.add(f"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,{curve})"))


@pytest.mark.parametrize("ends", [1, 2])
@pytest.mark.parametrize("width", [20.0, 200.0])
def test_a_round_end_is_a_contour_of_the_whole_length(ends: int, width: float) -> None:
    found = read(round_ended(400.0, width, ends), "m.ifc", options=Options(kernel=True))
    assert not [d for d in found.diagnostics if d.severity is not Severity.NOTE]
    (part,) = found.parts
    (outline,) = part.features
    assert isinstance(outline, Contour)
    assert part.length == pytest.approx(400.0 + ends * width / 2)
    area = 400.0 * width + ends * pi * width * width / 8
    assert abs(signed_area(outline.curves)) == pytest.approx(area, rel=1e-9)


def test_a_disc_and_a_ring_are_plates() -> None:
    m = Small()
    disc = read(plate(m, m.circle(200.0)), "m.ifc", options=Options(kernel=True))
    m = Small()
    profile = m.add(f"IFCCIRCLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},100.,30.)")
    ring = read(plate(m, profile), "m.ifc", options=Options(kernel=True))
    for found in (disc, ring):
        (part,) = found.parts
        assert (part.profile.code, part.length, part.profile.height) == ("B", 200.0, 200.0)
        (outline,) = part.contours
        assert abs(signed_area(outline.curves)) == pytest.approx(pi * 100**2, rel=1e-9)
    (hole,) = [f for f in ring.parts[0].features if isinstance(f, Hole)]
    assert (hole.x, hole.y, hole.diameter) == pytest.approx((100.0, 100.0, 140.0))


def test_a_long_ring_is_a_tube() -> None:
    m = Small()
    profile = m.add(f"IFCCIRCLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},100.,30.)")
    (part,) = read(plate(m, profile, 31.0), "m.ifc").parts
    assert part.profile.code == "RO"


def test_an_asymmetric_beam_may_be_without_fillets() -> None:
    m = Small()
    flanges = "100.,200.,8.,10.,$,150.,14.,$,$,$,$,$"
    profile = m.add(f"IFCASYMMETRICISHAPEPROFILEDEF(.AREA.,$,{m.flat},{flanges})")
    m.element(m.extruded(profile, 2000.0))
    found = read(m.data, "m.ifc", options=Options(kernel=True))
    (part,) = found.parts
    assert (part.profile.code, part.profile.height, part.profile.width) == ("SO", 200.0, 150.0)
    assert not [d for d in found.diagnostics if d.severity is not Severity.NOTE]
