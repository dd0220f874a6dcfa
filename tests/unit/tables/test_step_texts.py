"""Texts in tables for stepping motors: engraved where the part has them, or left to the hand."""

import pytest
from msgspec.structs import replace

from beamcam.checks.steps import verify_table
from beamcam.errors import Source, errors_in
from beamcam.machine import load
from beamcam.model.part import Hole, Part, Profile, TextMark
from beamcam.pipeline import post

LASER = load("laser-stepper")
SOURCE = Source("p.nc1", 7)
TEXT = TextMark("v", 8.0, 8.0, 0.0, 4.0, "A3e", SOURCE)
SHEET = Part("P1", Profile("B", "PL3", 20.0, 0.0, 0.0, 3.0), 40.0, SOURCE, grade="acrylic")


def plate(*features: Hole | TextMark) -> Part:
    return replace(SHEET, features=features)


def codes(one: Part, asked: Part, form: str) -> set[str]:
    """Errors where the table of one part is held against another."""
    pieces = list(post([one], LASER, style=form).pieces())
    return {said.code for said in errors_in(verify_table(form, pieces, [asked], LASER))}


@pytest.mark.parametrize("form", [".steps", ".csv"])
def test_a_text_is_engraved_and_read_back(form: str) -> None:
    posted = post([plate(TEXT)], LASER, style=form)
    assert [(o.how, o.by) for o in posted.plan.outcomes] == [("made", "engrave")]
    assert codes(plate(TEXT), plate(TEXT), form) == set()
    assert codes(plate(), plate(TEXT), form)


@pytest.mark.parametrize("wrong", [
    replace(TEXT, text="A8e"), replace(TEXT, text="A3"), replace(TEXT, x=8.1),
    replace(TEXT, height=4.1), replace(TEXT, x=18.0, y=12.0, angle=180.0),
])  # fmt: skip
def test_another_text_is_refused(wrong: TextMark) -> None:
    assert codes(plate(wrong), plate(TEXT), ".csv")


def test_a_text_that_is_not_clear_is_left_to_the_hand() -> None:
    over = plate(Hole("v", 12.0, 10.0, 3.0, SOURCE), TEXT)
    posted = post([over], LASER, style=".csv")
    assert [(o.how, o.by) for o in posted.plan.outcomes][1] == ("listed", "not-moved")
    assert "plan-by-hand" in {said.code for said in posted.remarks}
    twice = post([plate(TEXT, TEXT)], LASER, style=".csv")
    assert [o.how for o in twice.plan.outcomes] == ["made", "listed"]
    assert codes(plate(TEXT), over, ".csv")
