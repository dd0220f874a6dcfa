"""Numbers formatted in bulk are those that are formatted one by one."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from beamcam.emitters import number
from beamcam.emitters.columns import lines
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.program import ArcFeed, Feed, Program, ToolOn, Traverse
from tests.unit.sheets.parts import NESTED, table

values = st.one_of(
    st.floats(-1e4, 1e4),
    st.floats(-2e8, 2e8),
    st.integers(-(10**7), 10**7).map(lambda k: k / 1000),
    st.integers(-(10**6), 10**6).map(lambda k: k / 2000),  # middles between two steps
    st.sampled_from([0.0, -0.0, -0.0004, 9999.9999, 10000.0, 99999999.0, 1e-9, 0.0005, 2.5]),
)


@given(st.lists(st.tuples(values, values), min_size=1, max_size=30), st.integers(0, 6))
@example([(99999999.99996, -1.0)], 4)
def test_lines_are_those_of_each_number(rows: list[tuple[float, float]], decimals: int) -> None:
    columns = dict(zip("xy", np.array(rows).T, strict=True))
    expected = [f"G1 X{number(x, decimals)} Y{number(y, decimals)}\n" for x, y in rows]
    assert lines("G1 X{x} Y{y}", columns, decimals) == "".join(expected)


@pytest.mark.parametrize("template", ["{y}", "é {x}{y} {x}", "A{x}{{B}}"])
def test_any_template(template: str) -> None:
    columns = {"x": np.array([1.5, -2.0]), "y": np.array([0.25, 12345.678])}
    rows = [("1.5", "0.25"), ("-2", "12345.678")]
    expected = "".join(template.format(x=x, y=y) + "\n" for x, y in rows)
    assert lines(template, columns, 3) == expected


def test_no_rows() -> None:
    assert lines("X{x}", {"x": np.zeros(0)}, 3) == ""


def machine_with(**words: tuple[str, ...]) -> Machine:
    from msgspec.structs import replace

    machine = load("plate-linuxcnc")
    return replace(machine, words=replace(machine.words, **words))


def test_templates_of_several_blocks_with_a_feed() -> None:
    """The feed that holds stands in every block that asks for it."""
    from beamcam.emitters.cutting import emit

    machine = machine_with(
        feed=("F{feed}", "G1 X{x} Y{y}"), arc_ccw=("G3 X{x} Y{y} I{i} J{j} F{feed}",), footer=()
    )
    on = [ToolOn("cut", feed, 1.0, 0.5, NESTED.source) for feed in (600.0, 900.0)]
    program = Program(
        "A",
        (Traverse(1, 2), on[0], Feed(3, 4), Feed(5, 6), on[1], Feed(7, 8),
         ArcFeed(9, 8, 1, 0, False)),
    )  # fmt: skip
    assert emit(program, machine).split("\n") == [
        "G0 X1 Y2", "M3 S1", "G4 P0.5", "F600", "F600", "G1 X3 Y4", "F600", "G1 X5 Y6",
        "M3 S1", "G4 P0.5", "F900", "F900", "G1 X7 Y8", "G3 X9 Y8 I1 J0 F900", "",
    ]  # fmt: skip


def test_blocks_are_numbered_one_by_one() -> None:
    from beamcam.pipeline import post

    text = post((NESTED,), table("plate-codesys")).text
    blocks = [line for line in text.splitlines() if not line.startswith(("%", "("))]
    assert [line.split()[0] for line in blocks] == [f"N{k}" for k in range(1, len(blocks) + 1)]
