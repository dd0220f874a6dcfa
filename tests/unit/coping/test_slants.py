"""Cuts that cross a root on a slant: web and flange are cut square there, and that is told."""

from collections.abc import Callable
from math import radians, tan
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import PlanError, errors_in
from beamcam.machine import load
from beamcam.model.part import Contour, EndCuts, Hole, Part
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.manual_list import manual_rows
from beamcam.rest_part import chain_of
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from tests.conftest import examples
from tests.random_copes import random_slant
from tests.rs274 import needs_rs274
from tests.unit.coping.samples import (
    AT,
    COPER,
    UPN200,
    outline,
    part_of,
    program_of,
    sample,
)
from tests.unit.coping.test_rs274 import burns, pieces, thicker, written

TILT = load("coper-tilt-linuxcnc")


def leaning(degrees: float, off: float = 0.0) -> Part:
    """An I with its upper flange coped back at the far end, and the lower one leaning over it.

    The web ends `off` mm from the middle of what the flange does below it.
    """
    rise = tan(radians(degrees)) * 150.0
    low, high = 900.0 - max(rise, 0.0), 900.0 - max(-rise, 0.0)
    end = (low + high) / 2 + off
    return part_of(
        outline("u", [(0, 0), (low, 0), (high, 150), (0, 150)]),
        outline("o", [(0, 0), (end - 80, 0), (end - 80, 150), (0, 150)]),
        outline("v", [(0, 0), (end, 0), (end, 240), (end - 80, 240), (end - 80, 300), (0, 300)]),
        length=900.0,
    )  # fmt: skip


def end_of(part: Part) -> float:
    """Where the web of such a part ends."""
    return max(
        x for c in part.contours if c.face == "v" for x, _ in [one.start for one in c.curves]
    )


def faults(text: str, part: Part) -> set[str]:
    return {d.code for d in errors_in(verify_coping(text, (part,), COPER, (), "JOB"))}


def test_the_step_reaches_as_far_as_either_wall_and_is_told() -> None:
    plan = plan_coping((leaning(-15.0),), COPER)
    (told,) = [d for d in plan.remarks if d.code == "plan-coping-step"]
    # The flange leans from 859.8 to 900 mm; web and fillets end 93.55 mm over its 150 mm.
    x = 900.0 - tan(radians(15.0)) * (150.0 - 93.6)
    assert (told["face"], float(told["x"])) == ("u", pytest.approx(x, abs=0.01))
    assert float(told["found"]) == pytest.approx(tan(radians(15.0)) * 37.2, abs=0.1)
    rows = [(row["kind"], row["face"], row["why"]) for row in manual_rows(plan)]
    assert rows == [("outline", "u", "root"), ("outline", "v", "root")]
    for cut in plan.operations:
        if cut.root and cut.kind == "far":  # square to the bar over the web
            assert len({round(px, 3) for px, pz in cut.path if 60.0 < pz < 90.0}) <= 1


@pytest.mark.parametrize("part", [leaning(31.0), leaning(15.0, off=9.0), leaning(-15.0, off=-9.0)])
def test_what_is_too_steep_or_apart_is_refused(part: Part) -> None:
    with pytest.raises(PlanError) as caught:
        plan_coping((part,), COPER)
    assert {d.code for d in caught.value.diagnostics} == {"plan-coping-root"}


def test_a_square_cut_is_no_step() -> None:
    for name in ("coped", "hanger", "girder"):
        codes = {d.code for d in plan_coping((sample(name),), COPER).remarks}
        assert "plan-coping-step" not in codes


def test_a_flange_that_is_coped_back_does_not_deny_the_header() -> None:
    drawn = leaning(-15.0)
    part = replace(drawn, cuts=EndCuts(flange_end=15.0))
    codes = [d.code for d in plan_coping((part,), COPER).remarks]
    assert "plan-coping-slant" in codes
    assert "plan-coping-step" not in codes
    assert faults(program_of(part), part) == set()
    assert faults(program_of(leaning(-12.0)), part)
    other = replace(drawn, cuts=EndCuts(flange_end=12.0))
    with pytest.raises(PlanError) as caught:
        plan_coping((other,), COPER)
    assert "plan-cut-denied" in {d.code for d in caught.value.diagnostics}


@given(st.integers(0, 5000), st.sampled_from([COPER, TILT]))
@settings(max_examples=examples(12), deadline=None)
def test_random_slants_are_read_back_and_their_solid_is_the_part(
    seed: int, machine: object
) -> None:
    part = random_slant(seed)
    text = program_of(part, machine)  # type: ignore[arg-type]
    assert not errors_in(solid_faults(text, Request((part,), machine), None))  # type: ignore[arg-type]


@pytest.mark.parametrize("change", [
    lambda part: part_of(*part.features[1:], length=end_of(part)),
    lambda part: leaning(-13.0),
    lambda part: leaning(15.0),
    lambda part: leaning(-15.0, off=0.5),
])  # fmt: skip
def test_a_program_of_another_slant_is_refused(change: Callable[[Part], Part]) -> None:
    part = leaning(-15.0)
    assert faults(program_of(part), part) == set()
    assert faults(program_of(change(part)), part)


@needs_rs274
@pytest.mark.parametrize("seed", [1, 4, 6])
def test_no_steel_is_missing_and_what_is_too_much_lies_at_the_roots(
    seed: int, tmp_path: Path
) -> None:
    part = random_slant(seed)
    piece, wanted = pieces(part, burns(written(part, tmp_path)))[0], part_solid(part)
    assert thicker(wanted - piece).volume() < 1.0
    size = part.profile
    web = size.web_thickness or 0.0
    back = (size.width - web) / 2 if size.code == "I" else 0.0
    deep = max(row.up_to for row in COPER.coper.rows if COPER.coper) if COPER.coper else 0.0
    for lump in thicker(piece - wanted).decompose():
        _, y0, z0, _, y1, z1 = lump.bounding_box()
        if lump.volume() > 200.0 * web:  # no corner's
            assert min(y0, size.height - y1) < deep
            assert z0 > back - size.radius - 3.0
            assert z1 < back + web + size.radius + 3.0


def test_small_holes_are_the_drill_lines_and_the_slants_the_copers() -> None:
    part = leaning(-15.0)
    part = replace(part, features=(*part.features, Hole("u", 300.0, 30.0, 8.0, AT)))
    line = load("beamline-pusher")
    links = chain_of(Request((part,), COPER), (line, COPER))
    assert [link.machine.name for link in links] == ["beamline-pusher", "coper-linuxcnc"]
    assert all(isinstance(f, Contour) for f in links[1].part.features)


def test_a_channel_too() -> None:
    high = 900.0 - tan(radians(10.0)) * 75.0
    part = part_of(
        outline("u", [(0, 0), (900, 0), (high, 75), (0, 75)]),
        outline("o", [(0, 0), (800, 0), (800, 75), (0, 75)]),
        outline("v", [(0, 0), (900, 0), (900, 140), (800, 140), (800, 200), (0, 200)]),
        profile=UPN200, length=900.0,
    )  # fmt: skip
    assert "plan-coping-step" in {d.code for d in plan_coping((part,), COPER).remarks}
    assert faults(program_of(part), part) == set()
