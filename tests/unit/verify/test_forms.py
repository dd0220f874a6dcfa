"""Texts of passages with room for numbers."""

import pytest

from beamcam.verify.forms import MOST_FORMS, Forms, body_of

STROKE = ["N6 M40 K2 L18", "N7 G00 X893.56 Y15 Z-5", "N8 G01 X893.56 Y15 Z107.4 F1.65"]
CUT = ["G00 X17.98", "M42 K0 F41.667"]


def text(lines: list[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def test_a_passage_is_known_at_other_places_and_by_its_words() -> None:
    forms = Forms()
    said = forms.learn(STROKE, "Y")
    assert said is not None
    form, words = said
    assert words == ("893.56", "15", "2", "18", "-5", "107.4", "1.65")
    moved = text(STROKE).replace("893.56", "7").replace("Y15", "Y-3.5").replace("N8", "N4711")
    assert forms.said(moved) == (form, ("7", "-3.5", *words[2:]))
    assert forms.said(text(STROKE).replace("Z107.4", "Z99")) == (
        form, (*words[:5], "99", words[6]),
    )  # fmt: skip


@pytest.mark.parametrize(("old", "new"), [
    ("N8 G01 X893.56", "N8 G01 X893.57"), ("N8 G01 X893.56 Y15", "N8 G01 X893.56 Y15.0"),
    ("N7 ", ""), ("G00", "G01"), ("Y15 Z-5", "Z-5 Y15"), (" F1.65", ""), ("K2 ", "K2  "),
    ("Z-5", "Z1234567890.123456"),
])  # fmt: skip
def test_another_text_is_another_form(old: str, new: str) -> None:
    forms = Forms()
    assert forms.learn(STROKE, "Y") is not None
    assert forms.said(text(STROKE)) is not None
    assert old in text(STROKE)
    assert forms.said(text(STROKE).replace(old, new)) is None


def test_a_form_is_learned_once() -> None:
    forms = Forms()
    first, cut = forms.learn(STROKE, "Y"), forms.learn(CUT, "")
    assert cut is not None
    assert cut[1] == ("17.98", "17.98", "0", "41.667")
    assert forms.learn(STROKE, "Y") == first
    assert forms.learn(CUT, "") == cut
    assert len(forms.groups) == 2


def test_two_places_are_no_passage() -> None:
    assert Forms().learn([*STROKE, "N9 G00 X5 Y15 Z-5"], "Y") is None
    assert Forms().learn([*STROKE, "N9 G00 X893.56 Y16 Z-5"], "Y") is None
    assert Forms().learn(STROKE, "Z") is None


def test_as_many_forms_as_there_is_room_for() -> None:
    forms = Forms()
    said = [forms.learn([f"M{n} K1", *STROKE], "Y") for n in range(MOST_FORMS)]
    assert None not in said
    assert forms.is_full
    assert forms.learn([f"M{MOST_FORMS} K1", *STROKE], "Y") is None
    assert [forms.said(text([f"M{n} K1", *STROKE])) for n in range(MOST_FORMS)] == said


def test_lines_without_their_numbers() -> None:
    assert [body_of(line) for line in ("N6 M05", "M05", "N M05", "(N6 M05)")] == [
        "M05", "M05", "N M05", "(N6 M05)",
    ]  # fmt: skip
