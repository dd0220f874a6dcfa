"""Holes in inches go by the fits of the machine, and noise of a writer is no cut."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.model.part import Bevel, Contour, EndCuts
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from beamcam.planning import rules
from beamcam.planning.operations.saw_cut import SAW_ANGLE
from tests.conftest import examples
from tests.unit.planning.shop import SOURCE, hole, part

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


def sizes(text: str, remarks: tuple[Diagnostic, ...]) -> list[str]:
    assert text
    return [d.message for d in remarks if d.code == rules.DRILL_SIZE.code]


@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "beamline-pusher"])
def test_each_diameter_that_is_not_drilled_exactly_is_told_once_with_both_sizes(name: str) -> None:
    machine = load(name)
    wanted = (18.3, 18.3, 17.8, 18.0, 20.64)
    made = post([part(*(hole(500 + 100 * k, diameter=d) for k, d in enumerate(wanted)))], machine)
    assert isinstance(made.text, str)
    assert sizes(made.text, made.remarks) == [
        "holes of diameter 18.3 are drilled with 18, 0.3 mm under",
        "holes of diameter 17.8 are drilled with 18, 0.2 mm over",
    ]


def test_a_shop_may_never_drill_under() -> None:
    machine = load("beamline")
    assert machine.drill is not None
    strict = replace(machine, drill=replace(machine.drill, never_under=True))
    twins = part(hole(500, diameter=20.65), hole(600, diameter=17.8))
    made = post([twins], strict)
    assert isinstance(made.text, str)
    assert sizes(made.text, made.remarks) == [
        "holes of diameter 17.8 are drilled with 18, 0.2 mm over"
    ]
    under = part(hole(500, diameter=18.3))
    with pytest.raises(PlanError, match=r"expected a drill of 18\.28 to 18\.7 \(drill\.fits\)"):
        post([under], strict)
    loose = post([under], machine).text
    assert read_back(loose, Request((under,), machine)) == ()
    assert {d.code for d in read_back(loose, Request((under,), strict))} == {
        "verify-not-made", "verify-hole-extra",
    }  # fmt: skip


@pytest.mark.parametrize("angle", [0.06, -0.11])
@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "beamline-pusher"])
def test_a_bevel_that_is_noise_is_left_square_and_told(name: str, angle: float) -> None:
    """As two HEA240 of a real file had them, which were refused for a weld preparation."""
    machine = load(name)
    corners = [(0.0, 0.0), (3000.0, 0.0), (3000.0, 150.0), (0.0, 150.0)]
    sides = tuple(map(Line, corners, [*corners[1:], corners[0]]))

    def flange(*bevels: Bevel) -> Contour:
        return Contour("u", "outer", sides, SOURCE, bevels=bevels)

    noisy = part(hole(500), flange(Bevel(1, angle, 0.0)))
    made = post([noisy], machine)
    assert [d.message for d in made.remarks if d.code == rules.BEVEL_NOISE.code] == [
        f"found 1 bevel(s) of at most {abs(angle):g} degrees; below 0.2 degrees an edge is cut "
        "square"
    ]
    assert made.text == post([part(hole(500), flange())], machine).text
    assert errors_in(read_back(made.text, Request((noisy,), machine))) == ()
    with pytest.raises(PlanError, match="plan-bevel"):
        post([part(hole(500), flange(Bevel(1, 0.3, 0.0)))], machine)


NOISE = st.floats(-0.199, 0.199).filter(lambda a: abs(a) > 1e-6)


@settings(max_examples=examples(25), deadline=None)
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
