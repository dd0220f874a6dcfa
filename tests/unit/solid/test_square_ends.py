"""Skew ends that are cut square: what of them stays is known by wall, and no more is taken."""

from random import Random

import pytest
from msgspec.structs import replace

from beamcam.errors import errors_in
from beamcam.model.part import Profile
from beamcam.model.plan import CopeCut
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults
from tests.random_copes import CEES, SECTIONS, TEES, random_mitre
from tests.unit.coping.samples import COPER, job_of


def moved(cut: CopeCut, off: float) -> CopeCut:
    return replace(cut, path=tuple((x + off, y) for x, y in cut.path))


@pytest.mark.parametrize("sections", [SECTIONS, TEES, CEES])
@pytest.mark.parametrize("seed", [1, 4])
def test_a_wall_that_is_1_mm_longer_than_told_is_refused(
    seed: int, sections: tuple[Profile, ...]
) -> None:
    """Whatever its end has beyond the plane: the bar's scrap would not show it."""
    part, chance = random_mitre(seed, sections), Random(seed)
    plan = plan_coping((part,), COPER)

    def wrong(cuts: tuple[CopeCut, ...]) -> bool:
        text = coping_faults.program_of(replace(plan, operations=cuts), job_of(part, COPER))
        return bool(errors_in(solid_faults(text, Request((part,), COPER))))

    assert not wrong(plan.operations)
    k = chance.choice([k for k, cut in enumerate(plan.operations) if cut.kind != "inner"])
    cut = plan.operations[k]
    longer = moved(cut, 1.0 if cut.kind == "far" else -1.0)
    assert wrong((*plan.operations[:k], longer, *plan.operations[k + 1 :]))
