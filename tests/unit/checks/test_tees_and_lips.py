"""Sections T and C on a saw and drilling line: the stem over a flange, the lips before a web."""

import re
from collections import Counter

import pytest
from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.model.part import Feature, Hole, Part, Profile, Slot, TextMark
from beamcam.model.plan import DrillOp
from beamcam.model.request import Request
from beamcam.pipeline import post
from beamcam.solid.opinion import solid_faults
from tests.unit.checks.programs import skippable
from tests.unit.planning.shop import SOURCE, part
from tests.unit.planning.test_rules import LINE

PUSHER = load("beamline-pusher")
T100 = Profile("T", "T100", 100.0, 100.0, 11.0, 9.0, 11.0)
C200 = Profile("C", "C200*70*20*2", 200.0, 70.0, 2.0, 2.0, 3.0)
#: kg/m with lips of 20: web 200 - 10, flanges 2 (70 - 10), lips 2 (20 - 5), four bends of 2 pi.
C200_KG = (190.0 + 120.0 + 30.0 + 8 * 3.14159265) * 2.0 * 7.85e-3


def tee(*features: Feature) -> Part:
    return part(*features, profile=T100)


def lipped(*features: Feature, weight: float = C200_KG) -> Part:
    return replace(part(*features, profile=C200), weight=weight)


def drill(face: str, x: float, y: float, diameter: float = 18.0) -> Hole:
    return Hole(face, x, y, diameter, SOURCE)


def found(text: str, made: Part) -> list[str]:
    return sorted({d.code for d in errors_in(verify(text, (made,), PUSHER))})


def refused(made: Part) -> tuple[Diagnostic, ...]:
    with pytest.raises(PlanError) as refusal:
        post((made,), PUSHER)
    return errors_in(refusal.value.diagnostics)


def test_the_stem_of_a_tee_is_drilled_over_its_flange() -> None:
    """Face o lies (100 - 11) / 2 = 44.5 behind the flange's edge, and the stem is 11 thick.

    A drill of 18 has a tip of 9 / tan 59 = 5.408 and goes 2 beyond: 44.5 + 11 + 2 + 5.408.
    """
    text = post((tee(drill("o", 300.0, 60.0), drill("u", 500.0, 60.0)),), PUSHER).text
    strokes = re.findall(
        r"M40 K(\d) .*\n.*\n.* Y([-\d.]+) Z([-\d.]+)\n(?:.*\n){2}.* Y([\d.]+) Z", text
    )
    assert strokes == [("1", "39.5", "128.6", "62.908"), ("3", "39.5", "128.6", "62.908")]


def test_two_spindles_never_meet_in_a_stem() -> None:
    both = tee(drill("o", 300.0, 60.0), drill("u", 300.0, 60.0))
    posted = post((both,), PUSHER)
    assert all(len(op.faces) == 1 for op in posted.plan.operations if isinstance(op, DrillOp))
    one = tee(drill("o", 300.0, 60.0))
    text = post((one,), PUSHER).text
    assert "verify-word" in found(text.replace("M40 K1 ", "M40 K13 "), one)


@pytest.mark.parametrize(("code", "feature"), [
    ("plan-reach", drill("o", 300.0, 15.0)),  # its edge at 6, the flange reaches to 9
    ("plan-fillet", drill("u", 300.0, 20.0)),
    ("plan-off-part", drill("o", 300.0, 95.0)),
    ("plan-wall", drill("v", 300.0, 50.0)),  # in the stem
    ("plan-off-face", drill("o", 300.0, 105.0)),
    ("plan-off-part", drill("o", 5.0, 60.0)),
    ("plan-reach", replace(LINE, face="o", curves=tuple(
        c.transformed(((1.0, 0.0, 0.0), (0.0, 0.0, 5.0))) for c in LINE.curves
    ))),
])  # fmt: skip
def test_what_no_tool_comes_to_on_a_tee_is_refused(code: str, feature: Feature) -> None:
    assert code in [d.code for d in refused(tee(feature))]


@pytest.mark.parametrize(("low", "high", "wall"), [
    (10.0, 44.5, ""), (55.5, 90.0, ""), (10.0, 45.0, "stem"), (55.0, 90.0, "stem"),
    (10.0, 90.0, "stem"), (48.0, 52.0, "stem"),
])  # fmt: skip
def test_a_line_on_a_flange_keeps_off_the_stem(low: float, high: float, wall: str) -> None:
    """The stem reaches from (100 - 11) / 2 to 55.5; the checker knows that by itself."""
    line = replace(LINE, curves=(Line((400.0, low), (500.0, high)),))
    if not wall:
        assert not found(post((tee(line),), PUSHER).text, tee(line))
        return
    (said,) = refused(tee(line))
    assert (said.code, str(said["wall"])) == ("plan-reach", wall)
    assert skippable((tee(line),), PUSHER, ("reach",)) == {(0, 0)}
    wider = replace(T100, height=110.0)  # whose stem begins at 49.5; Y is 55 - y there, not 50 - y
    beside = replace(LINE, curves=(Line((400.0, 10.0), (500.0, 49.0)),))
    text = post((part(beside, profile=wider),), PUSHER).text.replace(" L110", " L100")
    text = text.replace("Y45 ", "Y40 ").replace("Y6 ", "Y1 ")
    assert found(text, tee(beside)) == ["verify-hole-steel"]


FULL = tee(
    drill("o", 300.0, 60.0), drill("u", 500.0, 70.0), drill("v", 300.0, 20.0),
    Hole("o", 700.0, 60.0, 14.0, SOURCE, depth=5.0),
    Hole("u", 800.0, 60.0, 16.0, SOURCE, kind="thread"),
    Slot("o", 1000.0, 60.0, 18.0, 30.0, 0.0, 0.0, SOURCE),
    TextMark("u", 1200.0, 60.0, 0.0, 10.0, "T1", SOURCE),
)  # fmt: skip


def test_all_kinds_of_work_on_a_stem_are_read_back_and_proved() -> None:
    posted = post((FULL,), PUSHER)
    assert Counter(o.how for o in posted.plan.outcomes) == {"made": 7}
    assert not found(posted.text, FULL)
    assert not errors_in(solid_faults(posted.text, Request((FULL,), PUSHER)))


@pytest.mark.parametrize(("code", "pattern", "other"), [
    ("verify-depth", r"Y62\.908", "Y58.9"),
    ("verify-hole-place", r"Z128\.6", "Z118.6"),
    ("verify-rapid", r"Y39\.5", "Y50"),
])  # fmt: skip
def test_a_wrong_stroke_into_a_stem_is_refused(code: str, pattern: str, other: str) -> None:
    one = tee(drill("o", 300.0, 60.0))
    text = post((one,), PUSHER).text
    assert not found(text, one)
    assert code in found(re.sub(pattern, other, text), one)


# --- lips -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("y", "weight", "least"), [
    (26.9, C200_KG, "27"), (173.1, C200_KG, "27"),  # the hole's edge at 19.9
    (48.9, 0.0, "49"),  # without a weight the lips may be 0.6 * 70 = 42 long
    (48.9, 5.0, "49"),  # which is that of a section without lips
])  # fmt: skip
def test_a_hole_behind_a_lip_is_refused(y: float, weight: float, least: str) -> None:
    (said,) = refused(lipped(drill("v", 300.0, y, 14.0), weight=weight))
    assert said.code == "plan-reach"
    assert said.message.endswith("the lip is in the tool's way")
    assert float(str(said["least"])) == pytest.approx(float(least), abs=1e-4)


def test_a_hole_beside_the_lips_is_made() -> None:
    made = lipped(drill("v", 300.0, 27.1, 14.0), drill("o", 300.0, 35.0, 14.0))
    assert not found(post((made,), PUSHER).text, made)


def test_a_flange_ends_at_its_lip() -> None:
    """The lip is 2 thick and has a bend of 3 inside: from 70 - 5 on."""
    assert [d.code for d in refused(lipped(drill("o", 300.0, 62.0, 14.0)))] == ["plan-wall"]


@pytest.mark.parametrize(("y", "codes"), [
    (30.0, []), (26.0, ["verify-hole-steel"]), (19.0, ["verify-hole-steel", "verify-rapid"]),
])  # fmt: skip
def test_a_program_that_drills_through_a_lip_is_refused(y: float, codes: list[str]) -> None:
    """It was written for a channel; the checker works the lips out by itself."""
    channel = replace(C200, code="U")
    text = post((part(drill("v", 300.0, y, 14.0), profile=channel),), PUSHER).text
    text = text.replace("M43 K2", "M43 K5")
    sound = lipped(drill("v", 300.0, y, 14.0))
    assert found(text, sound) == codes
    assert found(text, replace(sound, weight=0.0)) == ["verify-hole-steel", "verify-rapid"]
