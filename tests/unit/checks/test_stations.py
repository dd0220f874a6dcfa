"""Where a spindle stands: its formulas read backwards, at every y."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.checks.bars.stations import choices_of
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Formula
from beamcam.model.part import Hole, Part
from beamcam.pipeline import post
from tests.conftest import examples
from tests.unit.planning.shop import BEAM, CHANNEL, hole, part

MACHINES = ("beamline", "beamline-pusher")


def askew(name: str, slope: float, *faces: str) -> Machine:
    """The machine with spindles whose strokes all lie deeper by `slope` for each mm of y."""
    machine = load(name)
    lower = f" + {slope} * y"
    spindles = tuple(
        replace(s, stroke=replace(
            s.stroke,
            retract=Formula(s.stroke.retract + lower),
            approach=None if s.stroke.approach is None else Formula(s.stroke.approach + lower),
            bottom=Formula(s.stroke.bottom + lower),
        )) if s.face in faces else s
        for s in machine.spindles
    )  # fmt: skip
    axes = tuple(replace(a, min=None, max=None) for a in machine.axes)
    return replace(machine, spindles=spindles, axes=axes)


@st.composite
def parts(draw: st.DrawFn) -> Part:
    profile = draw(st.sampled_from((BEAM, CHANNEL)))
    features: list[Hole] = []
    for k in range(draw(st.integers(1, 4))):
        face = draw(st.sampled_from("vou"))
        y = round(
            profile.face_width(face)
            * draw(st.sampled_from((0.2, 0.3, 0.7, 0.8) if profile is BEAM else (0.5, 0.6))),
            1,
        )
        depth = draw(st.sampled_from((None, None, 4.0)))
        kind = "through" if depth is None else "blind"
        features.append(hole(300 + 200 * k, y, 14, face, kind=kind, depth=depth))
        if face == "o" and draw(st.booleans()):
            features.append(replace(features[-1], face="u"))
    return part(*features, profile=profile)


@settings(deadline=None, max_examples=examples(100))
@given(
    parts(), st.sampled_from(MACHINES), st.sampled_from((-0.5, -0.08, 0.0, 0.14, 0.6)),
    st.sampled_from(("ou", "v", "vou")),
)  # fmt: skip
def test_a_stroke_that_follows_y_is_read_at_its_y(
    made: Part, name: str, slope: float, faces: str
) -> None:
    machine = askew(name, slope, *faces)
    text = post((made,), machine, bar=6000.0).text
    assert verify(text, (made,), machine, bar=6000.0) == ()


@settings(deadline=None, max_examples=examples(100))
@given(
    st.sampled_from("vou"), st.floats(0, 100), st.floats(0.5, 60), st.floats(-1, 1),
    st.sampled_from(MACHINES),
)  # fmt: skip
def test_depth_is_what_the_formulas_say_backwards(
    face: str, y: float, depth: float, slope: float, name: str
) -> None:
    machine = askew(name, slope, face)
    spindle = next(s for s in machine.spindles if s.face == face)
    (station,) = choices_of(machine, BEAM)[spindle.number].stations
    values = {"y": y, "depth": depth, "tip": 3.0, "height": 300.0, "clearance": 5.0,
              "face_depth": BEAM.face_depth(face)}  # fmt: skip
    bottom = spindle.stroke.bottom(values)
    across = spindle.across.position(values)
    at_work = station.tip(across, bottom)
    assert (at_work.y, at_work.depth) == pytest.approx((y, depth + 3.0), abs=1e-9)
    free = station.tip(across, spindle.stroke.retract(values))
    assert free.beside == pytest.approx(-5.0, abs=1e-9)


def test_a_hole_drilled_as_deep_as_at_another_y_is_caught() -> None:
    """Known passages of another hole do not speak for this one either."""
    machine = askew("beamline", 0.5, "o")
    made = part(hole(500, 40, 14, "o"), hole(900, 45, 14, "o"))
    text = post((made,), machine).text
    shallow, deep = re.findall(r"G01 X\S+ (Y\S+)", text)[:2]
    assert float(deep[1:]) == pytest.approx(float(shallow[1:]) + 2.5)
    said = verify(text.replace(deep, shallow), (made,), machine)
    assert {d.code for d in said} >= {"verify-depth"}


def test_strokes_of_one_depth_for_all_may_follow_y_too() -> None:
    machine = load("beamline-annex")
    spindles = tuple(
        replace(s, stroke=replace(s.stroke, bottom=Formula("60 + 0.1 * y")))
        if s.face in "ou"
        else s
        for s in machine.spindles
    )
    machine = replace(machine, spindles=spindles)
    made = part(hole(500, 40, 14, "o"), hole(500, 40, 14, "u"), hole(900, 60, 14, "u"))
    text = post((made,), machine).text
    assert " Y64 " in text
    assert " Y66 " in text
