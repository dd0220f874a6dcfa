"""Words of the machine file that say the measured height and width of a bar to the machine."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.arguments import load_machine
from beamcam.checks.coping import verify_coping
from beamcam.errors import MachineError, errors_in
from tests.conftest import examples, sampled
from tests.unit.coping.samples import COPER, NAMES, program_of, sample

MEASURING = replace(COPER, words=replace(
    COPER.words, measured_height=("M144 P{height}",), measured_width=("M145 Q{width}",),
))  # fmt: skip


def codes(text: str, name: str) -> list[str]:
    return [d.code for d in errors_in(verify_coping(text, (sample(name),), MEASURING))]


@pytest.mark.parametrize("name", sampled(NAMES, 2))
def test_the_figures_stand_once_in_the_head_and_change_nothing_else(name: str) -> None:
    part, text = sample(name), program_of(sample(name), MEASURING)
    high, wide = part.profile.height, part.profile.width
    said = [f"M144 P{high:g}", f"M145 Q{wide:g}"]
    assert [line for line in text.splitlines() if line[:4] in ("M144", "M145")] == said
    assert text.index(said[1]) < text.index("M3")
    plain = program_of(part, COPER).splitlines()
    assert [line for line in text.splitlines() if line not in said] == plain


TEXT = program_of(sample("coped"), MEASURING)


@given(st.floats(280, 320).map(lambda mm: round(mm, 3)))
@settings(max_examples=examples(50))
def test_a_measured_figure_is_read_back_by_what_bars_are_rolled_to(mm: float) -> None:
    found = codes(TEXT.replace("M144 P300\n", f"M144 P{mm}\n"), "coped")
    assert found == ([] if abs(mm - 300.0) <= 5.0 else ["verify-coping-measured"])


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("M144 P300\n", "", "verify-coping-measured"),
        ("M144 P300\n", "M144 P300\nM144 P301\n", "verify-coping-measured"),
        ("M5\n", "M5\nM145 Q150\n", "verify-coping-torch"),
        ("M144 P300\nM145 Q150\n", "M144 P150\nM145 Q300\n", "verify-coping-measured"),
        ("M144 P300\n", "M144 Q300\n", "verify-word"),
        ("M144 P300\n", "M144 P300\nM146 P1\n", "verify-word"),
    ],
)
def test_figures_elsewhere_or_of_nothing_are_refused(old: str, new: str, expected: str) -> None:
    assert old in TEXT
    assert expected in codes(TEXT.replace(old, new, 1), "coped")


@pytest.mark.parametrize(
    "words",
    ['measured_height = ["M144 P{width}"]', 'measured_height = ["M144 P1"]',
     'measured_width = ["(WIDTH {width})"]', 'measured_width = ["M144 P{width} Q{width}"]'],
)  # fmt: skip
def test_a_word_without_its_figure_is_a_fault_of_the_file(words: str, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(f'base = "coper-linuxcnc"\n[words]\n{words}\n')
    with pytest.raises(MachineError, match=r"measured_"):
        load_machine(str(path))
