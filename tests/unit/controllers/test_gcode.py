"""What the controllers of tables have in common."""

import pytest

from beamcam.controllers import table_run
from beamcam.machine import load

HEAD = "G90\nG00 X0 Y0\n"
FULL = "M08\n" * 64


@pytest.mark.parametrize(("blocks", "found"), [
    (FULL, []),
    (FULL + "M08\n", [67]),
    (FULL + "G01 X1 F10\n" + FULL, []),
    (FULL + "G02 X2 Y0 I1 J0 F10\n" + FULL, []),  # taken with other plain moves
    (FULL + "G06 X2 Y0 I1 J1 F10\n" + FULL, []),  # a block that is no plain move
    (FULL + "G40\n" + "M08\n", [68]),  # and one that is no move
    (FULL + "G04 T1\n" + FULL, [67]),  # a dwell waits among them
    (FULL + "G75\n" + FULL, []),
    (FULL + "G01 X1 F10\n" + FULL + "M08\n", [132]),
])  # fmt: skip
def test_a_move_ends_a_row_of_m_words(blocks: str, found: list[int]) -> None:
    _, said = table_run(HEAD + blocks + "G01 X9 F10\nM30\n", load("plate-codesys"), "a")
    assert [d.source.line for d in said] == found
    assert all("65 M words in a row; expected at most 64" in str(d) for d in said)


@pytest.mark.parametrize("name", ["plate-codesys", "plate-linuxcnc", "laser-grbl"])
def test_nothing_counts_behind_the_end(name: str) -> None:
    """However many blocks follow, plain moves among them, it is said once."""
    head = {"plate-codesys": "G90\nG99"}.get(name, "G21 G17 G90 G91.1 G40 G94")
    head = head.replace(" G91.1 G40", "") if name == "laser-grbl" else head
    text = f"{head}\nG0 X0 Y0\nG1 X5 Y5 F9\nM30\n" + "G1 X6 Y6\nG1 X7 Y7 \nM5\n" * 3
    done, said = table_run(text, load(name), "a")
    assert done.moves.end.tolist() == [[0.0, 0.0], [5.0, 5.0]]
    (fault,) = said
    assert "found a block behind the end of the program" in str(fault)
    assert fault.source.line == head.count("\n") + 5
