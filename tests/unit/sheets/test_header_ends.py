"""Plates whose ends only the header says: cut so, or refused where they are skew in depth."""

from itertools import pairwise
from math import radians, tan
from typing import Literal

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.checks.sheets.plates import header_outline, with_skew_edges
from beamcam.errors import PlanError, Severity, Source
from beamcam.geometry.curves import Line, signed_area
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Bevel, EndCuts, Hole, Part, Profile
from beamcam.pipeline import post
from beamcam.planning.contours.outline import outline_of
from beamcam.planning.contours.plate_edges import with_bevels
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.part_solid import part_solid
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


OUTLINED = replace(FLAT, features=(
    *FLAT.features, contour([Line(a, b) for a, b in pairwise(
        [(0.0, 0.0), (300.0, 0.0), (300.0, 50.0), (0.0, 50.0), (0.0, 0.0)])]),
))  # fmt: skip


@pytest.mark.parametrize("end", ["start", "end"])
@pytest.mark.parametrize("given", [FLAT, OUTLINED], ids=["header", "outline"])
def test_what_is_skew_through_the_thickness_is_cut_square_and_listed(
    end: Literal["start", "end"], given: Part
) -> None:
    cuts = EndCuts(flange_start=45.0) if end == "start" else EndCuts(flange_end=45.0)
    posted = post((replace(given, cuts=cuts),), TABLE)
    (row,) = manual_rows(posted.plan)
    x, angle = {"start": (0.0, -45.0), "end": (300.0, 45.0)}[end]
    assert (row["kind"], row["face"], row["length"], row["land"]) == ("bevel", "v", 50.0, 0.0)
    assert (row["x"], row["angle"]) == (x, pytest.approx(angle))
    assert [d.code for d in posted.remarks if d.severity is Severity.WARNING] == ["plan-by-hand"]
    square = post((given,), TABLE).text.splitlines()
    assert [line for line in posted.text.splitlines() if "HAND" not in line] == square


angles = st.sampled_from([0.0, 12.0, -30.0, 45.0])


@given(angles, angles, angles, angles)
def test_the_bevels_are_those_of_the_solid(a: float, b: float, c: float, d: float) -> None:
    """The plate between the planes of its header is that of its outline with bevels."""
    part = with_ends(web_start=a, flange_start=b, web_end=c, flange_end=d)
    body = part_solid(part)
    assert TABLE.torch is not None
    for (drawn,) in (with_bevels([part], TABLE.torch), [with_skew_edges(part, TABLE.torch)]):
        assert (drawn is part) == (not (b or d))
        other = part_solid(replace(drawn, cuts=EndCuts(a, c) if drawn is part else EndCuts()))
        assert (body - other).volume() + (other - body).volume() < 1e-3


def test_a_plate_of_a_model_has_its_volume() -> None:
    """1000 x 200 x 20, an end at 45 degrees: 3960 cm3, of which a square cut leaves 40 more."""
    plate = replace(FLAT, length=1000.0, features=(), cuts=EndCuts(flange_end=45.0),
                    profile=Profile("B", "PL20*200", 200.0, 0.0, 0.0, 20.0))  # fmt: skip
    assert TABLE.torch is not None
    (drawn,) = with_bevels([plate], TABLE.torch)
    assert part_solid(replace(drawn, cuts=EndCuts())).volume() == pytest.approx(3960e3)
    (outline,) = drawn.contours
    assert abs(signed_area(outline.curves)) * 20.0 == pytest.approx(4000e3)


def test_an_outline_that_ends_elsewhere_is_refused() -> None:
    short = contour([Line(a, b) for a, b in pairwise(
        [(0.0, 0.0), (295.0, 0.0), (295.0, 50.0), (0.0, 50.0), (0.0, 0.0)])])  # fmt: skip
    part = replace(FLAT, features=(*FLAT.features, short), cuts=EndCuts(flange_end=45.0))
    with pytest.raises(PlanError, match="plan-sheet-end"):
        post((part,), TABLE)
    codes = [d.code for d in verify_sheet(post((FLAT,), TABLE).text, (part,), TABLE)]
    assert "verify-sheet-end-skew" in codes


@pytest.mark.parametrize(("machine", "code"), [
    ("plate-linuxcnc", "plan-sheet-layout"), ("table-simotion", "plan-sheet-layout"),
    ("laser-stepper", "plan-bevel"),
])  # fmt: skip
def test_they_are_bevels_to_every_policy(machine: str, code: str) -> None:
    """Not turned on the table, and refused where bevels are."""
    turned = {"rotate": 90.0} if code == "plan-sheet-layout" else {}
    table = with_torch(load(machine), thickness=3.0, **turned)
    thin = replace(OUTLINED, profile=replace(PROFILE, height=50.0, web_thickness=3.0))
    skew = replace(thin, mark="F2", cuts=EndCuts(flange_end=30.0))
    with pytest.raises(PlanError) as refused:
        post((skew,), table)
    assert [d.code for d in refused.value.diagnostics] == [code]


def test_noise_and_bevels_of_an_outline_are_not() -> None:
    post((replace(OUTLINED, cuts=EndCuts(flange_end=0.4)),), TABLE)
    bevelled = replace(OUTLINED.features[-1], bevels=(Bevel(1, 30.0, 0.0),))
    skew = EndCuts(flange_end=30.0)
    post((replace(OUTLINED, cuts=skew, features=(*FLAT.features, bevelled)),), TABLE)


def test_a_plate_whose_file_has_no_width_has_no_such_ends() -> None:
    flat = replace(with_ends(flange_start=30.0), profile=replace(PROFILE, height=0.0))
    torch = TABLE.needed(TABLE.torch, "torch")
    assert with_skew_edges(flat, torch) is flat
    assert with_bevels((flat,), torch) == (flat,)


def test_beside_others_on_a_sheet() -> None:
    skew = replace(OUTLINED, mark="F2", cuts=EndCuts(flange_end=30.0))
    plan = post((OUTLINED, skew, FLAT, skew), TABLE).plan
    (row,) = manual_rows(plan)
    assert (row["mark"], row["pieces"], row["angle"]) == ("F2", 2, pytest.approx(30.0))
