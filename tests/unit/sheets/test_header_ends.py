"""Plates whose ends only the header says: cut so, or refused where they are skew in depth."""

from itertools import pairwise
from math import radians, tan

import pytest
import shapely
from msgspec.structs import replace

from beamcam.checks.sheets.asked_sheet import header_outline
from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import PlanError, Source
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Bevel, EndCuts, Hole, Part, Profile
from beamcam.pipeline import post
from beamcam.planning.contours.outline import outline_of
from tests.unit.sheets.parts import contour

SOURCE = Source("flat.nc1", 1)
PROFILE = Profile("B", "FL50*5", 50.0, 0.0, 0.0, 5.0)
FLAT = Part("F1", PROFILE, 300.0, SOURCE, features=(Hole("v", 150.0, 25.0, 14.0, SOURCE),))
TABLE = load("plate-linuxcnc")


def with_ends(**angles: float) -> Part:
    return replace(FLAT, cuts=EndCuts(**angles))


@pytest.mark.parametrize(
    ("angles", "corners"),
    [
        ({}, [(0, 0), (300, 0), (300, 50), (0, 50)]),
        ({"web_start": 45.0}, [(50, 0), (300, 0), (300, 50), (0, 50)]),
        ({"web_start": -45.0}, [(0, 0), (300, 0), (300, 50), (50, 50)]),
        ({"web_end": 45.0}, [(0, 0), (300, 0), (250, 50), (0, 50)]),
        ({"web_end": -45.0}, [(0, 0), (250, 0), (300, 50), (0, 50)]),
        ({"web_start": 45.0, "web_end": 45.0}, [(50, 0), (300, 0), (250, 50), (0, 50)]),
    ],
)
def test_the_longest_edge_is_the_length(
    angles: dict[str, float], corners: list[tuple[float, float]]
) -> None:
    """By the sentence of the format: positive at the start when the top edge is the longest."""
    expected = shapely.Polygon(corners)
    for outline in (outline_of(with_ends(**angles)), header_outline(with_ends(**angles))):
        found = shapely.Polygon([line.start for line in outline])
        assert found.symmetric_difference(expected).area < 1e-6


def test_a_rectangle_is_not_that_plate() -> None:
    part = with_ends(web_start=30.0)
    square, own = post((FLAT,), TABLE), post((part,), TABLE)
    assert own.text != square.text
    assert not [d for d in verify_sheet(own.text, (part,), TABLE) if d.severity.value == "error"]
    codes = {d.code for d in verify_sheet(square.text, (part,), TABLE)}
    assert codes & {"verify-sheet-missing", "verify-sheet-extra", "verify-sheet-band",
                    "verify-sheet-side"}  # fmt: skip
    waste = 50.0 * 50.0 * tan(radians(30.0)) / 2
    found = shapely.Polygon([line.start for line in outline_of(part)]).area
    assert found == pytest.approx(300.0 * 50.0 - waste)


@pytest.mark.parametrize("end", ["start", "end"])
def test_what_is_skew_through_the_thickness_is_refused(end: str) -> None:
    part = with_ends(**{f"flange_{end}": 45.0})
    with pytest.raises(PlanError) as refused:
        post((part,), TABLE)
    assert [d.code for d in refused.value.diagnostics] == ["plan-sheet-end"]
    codes = [d.code for d in verify_sheet(post((FLAT,), TABLE).text, (part,), TABLE)]
    assert "verify-sheet-end-skew" in codes


OUTLINED = replace(FLAT, features=(
    *FLAT.features, contour([Line(a, b) for a, b in pairwise(
        [(0.0, 0.0), (300.0, 0.0), (300.0, 50.0), (0.0, 50.0), (0.0, 0.0)])]),
))  # fmt: skip


@pytest.mark.parametrize("machine", ["plate-linuxcnc", "table-simotion", "laser-stepper"])
def test_they_are_refused_wherever_they_stand(machine: str) -> None:
    """Beside an outline, turned on the table."""
    table = with_torch(load(machine), thickness=3.0, rotate=90.0)
    thin = replace(OUTLINED, profile=replace(PROFILE, height=50.0, web_thickness=3.0))
    skew = replace(thin, mark="F2", cuts=EndCuts(flange_end=30.0))
    with pytest.raises(PlanError) as refused:
        post((skew,), table)
    assert [d.code for d in refused.value.diagnostics] == ["plan-sheet-end"]


def test_noise_and_bevels_of_an_outline_are_not() -> None:
    post((replace(OUTLINED, cuts=EndCuts(flange_end=0.4)),), TABLE)
    bevelled = replace(OUTLINED.features[-1], bevels=(Bevel(1, 30.0, 0.0),))
    skew = EndCuts(flange_end=30.0)
    post((replace(OUTLINED, cuts=skew, features=(*FLAT.features, bevelled)),), TABLE)
    with pytest.raises(PlanError, match="plan-sheet-end"):
        post((OUTLINED, replace(OUTLINED, mark="F2", cuts=skew)), TABLE)
