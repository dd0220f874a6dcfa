"""Blocks by the syntax of CODESYS: what is one, what is not, and what counts for nothing."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.controllers import cell_events
from beamcam.controllers.codesys import CodesysBlock, Lexer
from beamcam.machine import load
from tests.conftest import examples

PLAIN = CodesysBlock("G", 1, {"X": 5.0, "Y": -2.5})
CELL = load("beamline")


def said_of(text: str) -> list[str]:
    return [str(d) for d in cell_events(text, CELL, "a")[1]]


@pytest.mark.parametrize("text", [
    "G01 X5 Y-2.5",
    "G1 X5 Y-2.5",
    "g01 x5 y-2.5",
    "N10 G01 X5 Y-2.5 ",
    "N10  G01\tX5   Y-2.5  ",
    "   N00010 G001 X+5. Y-02.50",
    "N7 (bring it on) G01 X5 (M30) Y-2.5",
    "G01 X5 Y-2.5\r",
    "N10 G01 Y-2.5 X5",
])  # fmt: skip
def test_one_block_in_many_forms(text: str) -> None:
    assert Lexer().block(text) == PLAIN


@pytest.mark.parametrize("text", ["", "  \t", "(nothing)", "N10"])
def test_no_block(text: str) -> None:
    assert Lexer().block(text) is None


@pytest.mark.parametrize(
    "text", ["% JOB\nM30", "% JOB\nM30\n%\n", "M30\n%", "\n(a)\n%\nM30\n% A\n\n"]
)
def test_the_name_of_a_program(text: str) -> None:
    assert said_of(text) == []


@pytest.mark.parametrize(("text", "found", "expected"), [
    ("G01X5", "G01X5", "a letter and a number, set off by spaces"),
    ("G01 X", "X", "a letter and a number, set off by spaces"),
    ("G01 X5,2", "X5,2", "a letter and a number, set off by spaces"),
    ("G01 X1e3", "X1E3", "a letter and a number, set off by spaces"),
    ("G01 X٥", "X\N{REPLACEMENT CHARACTER}", "a letter and a number, set off by spaces"),
    (f"G01 X{'9' * 16}", f"X{'9' * 16}", "a letter and a number, set off by spaces"),
    (f"M{'9' * 1400}", f"M{'9' * 1400}", "a letter and a number, set off by spaces"),
    ("G01 X5 S3", "S3", "a word that the controller knows"),
    ("G1.5 X5", "G1.5", "a whole number behind G"),
    ("N1.5 G1", "N1.5", "a whole number behind N"),
    ("M-3", "M-3", "a whole number behind M"),
    ("G01 N5 X5", "N5", "the block number at the beginning"),
    ("G00 G01 X5", "G01", "one command a block, G0 stands there already"),
    ("G01 X5 M05", "M05", "one command a block, G1 stands there already"),
    ("X5 G01", "G01", "the command before the other words"),
    ("G01 X5 X6", "X6", "X once in a block"),
    ("G01 X5 E9 E8", "E8", "E once in a block"),
    ("G01 X5 E-9 E9 E-8", "E-8", "E- once in a block"),
    ("G01 X5 (open", "G01 X5 (open", "a comment that begins and ends on its line, none in another"),
    ("G01 X5 ((a) b)", "G01 X5 ((a) b)",
     "a comment that begins and ends on its line, none in another"),
    ("/G01 X5", "/G01 X5", "a block that always runs; `/` leaves that to a switch"),
    ("; G01 X5", ";", "a letter and a number, set off by spaces"),
])  # fmt: skip
def test_what_is_no_block(text: str, found: str, expected: str) -> None:
    assert said_of("G90\n" + text + "\nM30") == [
        f"a:2: error verify-syntax: found {found!r}; expected {expected}"
    ]


def test_a_name_in_the_middle() -> None:
    assert said_of("% A\nG90\n% B\nM30\n%\n\n") == [
        "a:3: error verify-syntax: found '% B'; expected % on the first or the last line only"
    ]


def test_two_accelerations_are_one_word_of_two_values() -> None:
    words = {"X": 100.0, "Y": 90.0, "E": 100.0, "F": 80.0, "E-": -200.0}
    assert Lexer().block("G01 X100 Y90 E100 F80 E-200") == CodesysBlock("G", 1, words)


def test_more_letters_where_a_machine_has_them() -> None:
    assert Lexer(frozenset("MS")).block("M03 S800") == CodesysBlock("M", 3, {"S": 800.0})


words = st.dictionaries(
    st.sampled_from("XYZFKL"), st.decimals(-9999, 9999, places=3), min_size=1, max_size=6
)
blank = st.sampled_from([" ", "  ", "\t"])


@settings(deadline=None, max_examples=examples(200))
@given(words, blank, st.integers(0, 99), st.booleans(), st.randoms())
def test_order_blanks_and_zeros_count_for_nothing(
    given_words: dict[str, object], gap: str, number: int, zeros: bool, rng: object
) -> None:
    order = list(given_words)
    rng.shuffle(order)  # type: ignore[attr-defined]
    pad = "00" if zeros else ""
    text = gap.join([f"M{pad}{number}", *(f"{w}{given_words[w]}" for w in order)])
    found = {w: float(str(v)) for w, v in given_words.items()}
    assert Lexer().block(text) == CodesysBlock("M", number, found)
