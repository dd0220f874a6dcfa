"""The part of a program whose torch is tilted along the bar: skew ends, and bevels."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import errors_in
from beamcam.machine import load
from beamcam.model.part import Bevel, Contour, EndCuts, Part
from beamcam.pipeline import post
from beamcam.planning.coping.plan import plan_coping
from beamcam.recovery import KnownStock, recover
from beamcam.solid.kernel import kernel
from beamcam.solid.part_solid import part_solid
from benchmarks import coping_faults
from tests.conftest import examples, sampled
from tests.random_copes import random_bevel, random_mitre, random_prepared_web, random_shaped_bevel
from tests.unit.coping.samples import job_of, part_of, sample

TILT = load("coper-tilt-linuxcnc")


def text_of(part: Part) -> str:
    return post((part,), TILT).text


def recovered(text: str, part: Part) -> Part:
    found = recover(text, TILT, "p.ngc", KnownStock(profile=part.profile))
    assert not errors_in(found.diagnostics), [str(d) for d in found.diagnostics]
    (again,) = found.parts
    return again


def is_squared(part: Part) -> bool:
    """Whether a skew end of a part is cut square, as the torch does not come to it tilted."""
    return any(d.code == "plan-coping-slant" for d in plan_coping((part,), TILT).remarks)


def bevels_of(part: Part) -> list[tuple[str, float, float]]:
    return sorted(
        (c.face, bevel.angle, bevel.land)
        for c in part.features if isinstance(c, Contour) for bevel in c.bevels
    )  # fmt: skip


def test_skew_ends_come_back_as_angles_of_the_header() -> None:
    part = sample("rafter")
    again = recovered(text_of(part), part)
    assert (again.cuts, again.length) == (part.cuts, part.length)
    assert not [*again.contours]


@pytest.mark.parametrize("name", ["splice", "knee"])
def test_bevels_come_back_with_angle_and_land(name: str) -> None:
    part = sample(name)
    again = recovered(text_of(part), part)
    assert bevels_of(again) == bevels_of(part)
    assert len(bevels_of(part)) in (2, 3)


def test_bevels_along_the_bar_and_on_slanted_edges_come_back() -> None:
    for seed in (3, 5, 40):
        part = random_shaped_bevel(seed)
        assert bevels_of(part)
        assert bevels_of(recovered(text_of(part), part)) == bevels_of(part)


@given(
    st.integers(0, 5000),
    st.sampled_from([random_mitre, random_bevel, random_prepared_web]),
)
@settings(max_examples=examples(15), deadline=None)
def test_the_program_of_what_came_back_makes_the_part(
    seed: int, random_part: Callable[[int], Part]
) -> None:
    part = random_part(seed)
    text = text_of(part)
    again = recovered(text, part)
    assert not errors_in(verify_coping(text, (again,), TILT))
    if is_squared(part):  # an end that is cut square comes back as its outlines have it
        return
    assert not errors_in(verify_coping(text_of(again), (part,), TILT))
    assert again.cuts == part.cuts


@pytest.mark.parametrize("seed", sampled(range(8), 3))
def test_its_solid_is_that_of_the_part(seed: int) -> None:
    part = random_mitre(seed)
    if is_squared(part):
        return
    again, m = recovered(text_of(part), part), kernel()
    mine, other = part_solid(part), part_solid(again)
    off = m.Manifold.batch_boolean([mine - other, other - mine], m.OpType.Add)
    assert off.volume() < 60.0


def test_a_tilt_that_makes_neither_is_refused() -> None:
    part = replace(part_of(length=900.0), cuts=EndCuts(web_end=20.0))
    plan = plan_coping((part,), TILT)
    less = replace(plan, operations=plan.operations[:-1])
    text = coping_faults.program_of(less, job_of(part, TILT))
    found = recover(text, TILT, "p.ngc", KnownStock(profile=part.profile))
    assert not found.parts
    assert "recover-tilted" in {d.code for d in errors_in(found.diagnostics)}


def test_an_edge_that_no_pass_runs_along_has_no_bevel() -> None:
    part = sample("splice")
    flange = next(f for f in part.features if isinstance(f, Contour) and f.face == "u")
    one = replace(part, features=tuple(
        replace(f, bevels=()) if f == flange else f for f in part.features
    ))  # fmt: skip
    assert bevels_of(recovered(text_of(one), one)) == [("o", 30.0, 2.0)]
    assert Bevel(1, 30.0, 2.0) in flange.bevels
