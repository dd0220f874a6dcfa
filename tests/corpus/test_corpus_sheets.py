"""Real drawings on cutting tables: every one that can be read is posted and read back."""

from pathlib import Path

import pytest

from beamcam.geometry.arc_fitting import fit_chains
from beamcam.geometry.curves import Arc, Bezier
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Contour
from beamcam.pipeline import post, read_file
from tests.conftest import CORPUS

DRAWINGS = sorted([*CORPUS.glob("dxf/*.dxf"), *CORPUS.glob("svg/*.svg")])
#: Real drawings have lines that are no contours; which of them are cut is the question here.
ROOMY = {"length": 1e5, "width": 1e5, "allow_open": True}
TABLES = [
    ("plate-linuxcnc", {"kerf": 0.1, "lead_in": 0.3, "lead_out": 0.1}),
    ("plate-codesys", {"kerf": 0.0, "lead": "none"}),
    ("laser-grbl", {"thickness": 3.0}),
]

pytestmark = pytest.mark.third_party


@pytest.mark.parametrize("path", DRAWINGS, ids=lambda p: p.name)
@pytest.mark.parametrize(("name", "values"), TABLES, ids=[name for name, _ in TABLES])
def test_posted_and_read_back(path: Path, name: str, values: dict[str, object]) -> None:
    reading = read_file(str(path))
    lines = [f for part in reading.parts for f in part.features if isinstance(f, Contour)]
    if reading.refused or not lines:
        return
    everything = {c.colour: "cut" for c in lines if c.colour is not None}
    machine = with_torch(load(name), everything, **ROOMY, **values)  # type: ignore[arg-type]
    posted = post(reading.parts, machine)
    assert not [d for d in posted.remarks if d.code.startswith("verify")]


def test_cubics_of_coreldraw_that_are_circles_come_out_as_arcs() -> None:
    """Those that miss a circle by no more than a kappa cubic does: at least 95 % are one arc."""
    round_ones = arcs = 0
    for path in CORPUS.glob("svg/openrov*.svg"):
        for part in read_file(str(path)).parts:
            for contour in part.contours:
                for curve in contour.curves:
                    if not isinstance(curve, Bezier) or not is_round(curve):
                        continue
                    round_ones += 1
                    (fit,) = fit_chains(((curve,),), 0.01)
                    arcs += len(fit) == 1 and isinstance(fit[0], Arc)
    assert round_ones > 100
    assert arcs >= 0.95 * round_ones


def is_round(curve: Bezier) -> bool:
    """Whether 17 points of a cubic lie on the circle through three of them, by 3e-4 of its radius
    or 5 um."""
    (ax, ay), (bx, by), (cx, cy) = curve.start, curve.point(0.5), curve.end
    d = 2 * ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))
    if abs(d) < 1e-9:
        return False
    b2, c2 = (bx - ax) ** 2 + (by - ay) ** 2, (cx - ax) ** 2 + (cy - ay) ** 2
    x = ax + ((cy - ay) * b2 - (by - ay) * c2) / d
    y = ay + ((bx - ax) * c2 - (cx - ax) * b2) / d
    radius = ((ax - x) ** 2 + (ay - y) ** 2) ** 0.5
    points = (curve.point(k / 16) for k in range(17))
    off = max(abs(((px - x) ** 2 + (py - y) ** 2) ** 0.5 - radius) for px, py in points)
    # What is flatter than the tolerance is a line as well as an arc.
    rise = ((bx - (ax + cx) / 2) ** 2 + (by - (ay + cy) / 2) ** 2) ** 0.5
    return rise > 0.01 and off <= max(0.005, 3e-4 * radius)
