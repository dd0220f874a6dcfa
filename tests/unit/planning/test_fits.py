"""Holes in inches go by the fits of the machine, and noise of a writer is no cut."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.model.part import EndCuts
from beamcam.pipeline import post, read_back
from beamcam.planning import rules
from beamcam.planning.operations.saw_cut import SAW_ANGLE
from beamcam.posts import Request
from tests.unit.planning.shop import hole, part

IMPERIAL = (11.11, 14.29, 14.68, 17.46, 20.64)


@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "beamline-pusher"])
def test_holes_in_inches_are_drilled_within_the_fit(name: str) -> None:
    machine = load(name)
    holes = [hole(500 + 100 * k, diameter=d) for k, d in enumerate(IMPERIAL)]
    one = part(*holes)
    made = post([one], machine)
    assert [o.how for o in made.plan.outcomes] == ["made"] * len(IMPERIAL)
    assert machine.drill is not None
    for op in made.plan.operations:
        for _, index in getattr(op, "features", ()):
            wanted = one.features[index].diameter  # type: ignore[union-attr]
            fit = next(f for f in machine.drill.fits if wanted <= f.up_to)
            assert -fit.minus <= op.tool.diameter - wanted <= fit.plus  # type: ignore[union-attr]


def test_a_refusal_gives_the_limits_of_the_fit() -> None:
    with pytest.raises(
        PlanError, match=r"expected a drill of 4\.7 to 5\.4 \(drill\.fits\); the near"
    ):
        post([part(hole(500, diameter=5.0))], load("beamline"))


NOISE = st.floats(-0.199, 0.199).filter(lambda a: abs(a) > 1e-6)


@settings(max_examples=25, deadline=None)
@given(st.tuples(NOISE, NOISE, NOISE, NOISE))
def test_a_noise_angle_is_sawn_square_and_told(angles: tuple[float, ...]) -> None:
    machine, cuts = load("beamline"), EndCuts(*angles)
    noisy, square = part(hole(500), cuts=cuts), part(hole(500))
    made = post([noisy], machine)
    assert [d.code for d in made.remarks] == [rules.CUT_NOISE.code] * 4
    assert made.text == post([square], machine).text
    assert read_back(made.text, Request((noisy,), machine)) == ()


@pytest.mark.parametrize("angle", [-85.0, 85.0])
@pytest.mark.parametrize("name", ["beamline", "beamline-pusher"])
def test_angles_in_messages_are_those_of_the_file(name: str, angle: float) -> None:
    with pytest.raises(PlanError) as caught:
        post([part(cuts=EndCuts(web_end=angle))], load(name))
    (said,) = (d for d in caught.value.diagnostics if d.code == SAW_ANGLE.code)
    assert f"found a cut of {angle:g} degrees at the end" in said.message
    least, greatest = map(float, said.message.split("from ")[1].split(",")[0].split(" to "))
    assert not least <= angle <= greatest
    for limit in (least, greatest):
        post([part(cuts=EndCuts(web_end=limit))], load(name))
