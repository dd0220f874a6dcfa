"""A program that really ran: M74, M58 and M74 on one bar, against the figures of its blocks.

The parts come from another export of the model than the program did, so the figures agree to the
tolerances named here. Operations less than 5 mm apart in X may stand in either order.
"""

from collections import Counter
from pathlib import Path

import pytest

from beamcam.machine import load
from beamcam.pipeline import parts_of, post, read_file
from tests.conftest import BEAM_CELL
from tests.runs import call

PARTS = BEAM_CELL

#: Blocks of the program that ran, by their first word.
BLOCKS = {"G90": 1, "M44": 1, "M43": 1, "G01": 82, "M41": 7, "M40": 25, "M04": 25, "M08": 25,
          "M09": 25, "M05": 25, "M30": 1}  # fmt: skip

#: Its operations in order: cuts as (X, angle), strokes as (X, spindle, diameter, Y, Z of approach).
CUT, STROKE = 2, 5
OPERATIONS: tuple[tuple[float, ...], ...] = (
    (69.1, 15.0), (215.4, 5.03), (217.3, 0),
    (960.3, 2, 22, 18, 0), (960.3, 2, 22, -52, 0), (960.3, 2, 22, -122, 0),
    (1040.7, 2, 22, -77.8, 0), (1046.8, 2, 22, -8, 0), (1052.9, 2, 22, 61.7, 0),
    (3632.7, 2, 24, 100.1, 0), (3632.7, 2, 24, -99.9, 0),
    (3772.7, 2, 24, 100.1, 0), (3772.7, 2, 24, -99.9, 0),
    (4022.7, 2, 24, -9.8, 0), (4522.7, 2, 24, -9.8, 0),
    (5022.7, 2, 24, -9.8, 0), (5522.7, 2, 24, -9.8, 0),
    (6103.4, 2, 14, -9.9, 0), (6103.4, 13, 14, 0, 138.6),
    (6703.4, 13, 14, 0, 138.6), (6703.4, 2, 14, -9.9, 0),
    (7303.4, 13, 14, 0, 138.6), (7303.4, 2, 14, -9.9, 0),
    (7457.9, 5.03), (7493.1, 0), (7495.9, 15.01), (7644.1, 0),
    (7903.4, 13, 14, 0, 138.6), (7903.4, 2, 14, -9.9, 0),
    (8387.1, 2, 22, 18, 0), (8387.1, 2, 22, -52, 0), (8387.1, 2, 22, -122, 0),
)  # fmt: skip
#: M74's mitres and holes are exact; its parting cuts are as far off as its printed length.
EXACT_X = (69.1, 960.3, 7495.9, 8387.1)
PARTING_X = (217.3, 7644.1)

pytestmark = pytest.mark.third_party


def program(*names: str) -> str:
    parts, _ = parts_of(read_file(str(PARTS / f"{n}.nc1")) for n in names)
    return post(parts, load("beamline-annex")).text


def words(block: str) -> list[str]:
    return [w for w in block.split() if not w.startswith("N")]


def blocks_of(text: str) -> list[str]:
    """The lines of a program that are no comments; the real one had none."""
    return [line for line in text.splitlines() if not line.startswith("(")]


def operations(text: str) -> list[tuple[float, ...]]:
    """The operations of a program in the annex's dialect, in order."""
    found: list[tuple[float, ...]] = []
    x = 0.0
    spindle: tuple[float, float] | None = None
    for block in blocks_of(text):
        first, *rest = words(block) or [""]
        value = {w[0]: float(w[1:]) for w in rest if first != "%"}
        if first == "G01":
            x = value["X"]
            if spindle is not None:
                found.append((x, *spindle, value["Y"], value["Z"]))
                spindle = None
        elif first == "M41":
            found.append((x, value["K"]))
        elif first == "M40":
            spindle = value["K"], value["L"]
    return found


def test_same_blocks_of_each_word() -> None:
    blocks = [b for b in blocks_of(program("M74", "M58", "M74")) if not b.startswith("%")]
    assert len(blocks) == 218
    assert [b.split()[0] for b in blocks] == [f"N{i}" for i in range(1, 219)]
    assert Counter(words(b)[0] for b in blocks) == BLOCKS
    assert [" ".join(words(b)) for b in blocks[1:3]] == ["M44 K380 L380", "M43 K3"]


def tolerance(expected: tuple[float, ...]) -> float:
    if expected[0] in EXACT_X:
        return 0.1
    return 1.3 if expected[0] in PARTING_X else 5.0


def agrees(made: tuple[float, ...], expected: tuple[float, ...]) -> bool:
    """Whether an operation is the expected one, within the tolerances."""
    if len(made) != len(expected) or abs(made[0] - expected[0]) > tolerance(expected) + 1e-9:
        return False
    if len(made) == CUT:
        return abs(made[1] - expected[1]) <= 0.1
    near_y, near_z = abs(made[3] - expected[3]), abs(made[4] - expected[4])
    return made[1:3] == expected[1:3] and near_y <= 0.25 and near_z <= 0.1 + 1e-9


def test_same_operations_in_the_same_order() -> None:
    made = operations(program("M74", "M58", "M74"))
    assert len(made) == len(OPERATIONS)
    left = list(OPERATIONS)
    for operation in made:
        # The next expected one, or one that stands less than 5 mm behind it.
        window = [e for e in left if e[0] - left[0][0] < 5.0]
        match = next((e for e in window if agrees(operation, e)), None)
        assert match is not None, f"{operation} is none of {window}"
        left.remove(match)
    assert left == []


def test_the_comparison_sees_a_wrong_operation() -> None:
    expected = OPERATIONS[3]
    assert agrees(expected, expected)
    for i, delta in ((0, 0.2), (1, 1.0), (2, 2.0), (3, 0.3), (4, 0.2)):
        wrong = list(expected)
        wrong[i] += delta
        assert not agrees(tuple(wrong), expected)


def test_the_program_as_a_file(tmp_path: Path) -> None:

    inputs = [str(PARTS / f"{n}.nc1") for n in ("M74", "M58", "M74")]
    target = tmp_path / "job.gcode"
    call("post", *inputs, "--machine", "beamline-annex", "-o", target, status=0)
    assert target.read_text() == program("M74", "M58", "M74")
    assert [p.name for p in tmp_path.iterdir()] == ["job.gcode"]
