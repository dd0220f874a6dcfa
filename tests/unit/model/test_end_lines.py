"""Where the header's end cuts meet each face, held against the solid of the part."""

import pytest

from beamcam.errors import Source
from beamcam.model.description import end_lines
from beamcam.model.part import EndCuts, Face, Part, Profile
from beamcam.solid.kernel import kernel
from beamcam.solid.part_solid import part_solid

SOURCE = Source("p.nc1", 1)
IN = 0.01  #: mm below a face, where its steel is looked at
#: A section, and z of the surfaces of v and h, by hand.
SECTIONS = {
    "I": (Profile("I", "", 200.0, 100.0, 8.5, 5.6, 12.0), 52.8, 47.2),
    "U": (Profile("U", "", 200.0, 75.0, 11.5, 8.5, 11.5), 8.5, 0.0),
    "L": (Profile("L", "", 120.0, 80.0, 10.0, 10.0, 11.0), 10.0, 0.0),
    "M": (Profile("M", "", 120.0, 80.0, 5.0, 5.0, 7.5), 80.0, 0.0),
    "B": (Profile("B", "", 60.0, 0.0, 0.0, 5.0), None, None),
}  # fmt: skip


def reach(part: Part, y: float, z: float) -> tuple[float, float]:
    """x of the steel on a line along the bar."""
    m, fine = kernel(), 1e-3
    needle = m.Manifold.cube([part.length + 2000.0, fine, fine]).translate(
        [-1000.0, y - fine / 2, z - fine / 2]
    )
    box = (part_solid(part) ^ needle).bounding_box()
    return box[0], box[3]


@pytest.mark.parametrize("cuts", [
    EndCuts(30.0, -20.0), EndCuts(-15.0, 40.0), EndCuts(0.0, 0.0, 45.0, -30.0),
    EndCuts(25.0, -10.0, -20.0, 35.0),
])  # fmt: skip
@pytest.mark.parametrize("code", sorted(SECTIONS))
def test_they_are_where_the_solid_ends(code: str, cuts: EndCuts) -> None:
    profile, v, h = SECTIONS[code]
    if code == "B" and (cuts.flange_start or cuts.flange_end):
        cuts = EndCuts(cuts.web_start, cuts.web_end)  # a plate's line is that of its front
    part = Part("P", profile, 1500.0, SOURCE, cuts=cuts)
    middles: dict[Face, tuple[float, float]] = {}
    rise = profile.height / 3
    middles["v"] = rise, (2.5 if v is None else v - IN)
    if h is not None:
        middles["h"] = rise, h + IN
        across = profile.width / 3
        middles["u"] = IN, across
        if code != "L":
            middles["o"] = profile.height - IN, across
    for face, (y, z) in middles.items():
        at = rise if face in "vh" else z
        found = []
        for (xa, ya), (xb, yb) in end_lines(part, face):
            found.append(xa + (xb - xa) * (at - ya) / (yb - ya))
        assert reach(part, y, z) == pytest.approx(found, abs=0.05), face
