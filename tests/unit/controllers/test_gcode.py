"""What the controllers of tables have in common, and what each has to say for itself."""

import pytest

from beamcam.controllers.gcode import codesys
from beamcam.controllers.gcode.controller import Controller
from beamcam.controllers.gcode.scan import scan

HEAD = "G90\nG00 X0 Y0\n"
FULL = "M08\n" * 64


def test_a_controller_that_does_not_say_how_it_moves_is_none() -> None:
    plain = scan("G0 X1\n").plain
    with pytest.raises(TypeError, match="abstract"):
        Controller("a", "anything", plain)  # type: ignore[abstract]

    class WithMoves(Controller):
        def _move(self, line: int, motion: int, words: dict[str, float]) -> None:
            self._place = words["X"], words["Y"]

    WithMoves("a", "anything", plain).plain_until(2)


@pytest.mark.parametrize(("blocks", "found"), [
    (FULL, []),
    (FULL + "M08\n", [67]),
    (FULL + "G01 X1 F10\n" + FULL, []),  # taken with other plain moves
    (FULL + "G02 X2 Y0 I1 J0 F10\n" + FULL, []),
    (FULL + "G06 X2 Y0 I1 J1 F10\n" + FULL, []),  # a block that is no plain move
    (FULL + "G40\n" + "M08\n", [68]),  # and one that is no move
    (FULL + "G04 T1\n" + FULL, [67]),  # a dwell waits among them
    (FULL + "G75\n" + FULL, []),
    (FULL + "G01 X1 F10\n" + FULL + "M08\n", [132]),
])  # fmt: skip
def test_a_move_ends_a_row_of_m_words(blocks: str, found: list[int]) -> None:
    _, said = codesys.run(HEAD + blocks + "G01 X9 F10\nM30\n", "a", 1e-3, 60.0)
    assert [d.source.line for d in said] == found
    assert all("65 M words in a row; expected at most 64" in str(d) for d in said)
