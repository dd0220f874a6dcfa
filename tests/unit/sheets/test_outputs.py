"""Gases, outputs and what else a program switches: in order, and at the end as before."""

from pathlib import Path

import pytest

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.controllers import table_events
from beamcam.controllers.events import Output
from beamcam.machine import Machine, load
from beamcam.pipeline import post
from tests.unit.sheets.parts import NESTED, circle, contour, drawing, table

START = "M64 P0\nG4 P2.5\nM3 S1\nG4 P0.5\n"
#: What stands in a sound program of the oxyfuel table, another in its place, and what is said.
MUTANTS = [
    (START, "G4 P2.5\nM3 S1\nG4 P0.5\n", "cutting oxygen without the preheat; expected 2.5 s"),
    (START, "M64 P0\nM3 S1\nG4 P0.5\n", "cutting oxygen after 0 s of preheat; expected 2.5 s"),
    (START, "M64 P0\nG4 P1\nM3 S1\nG4 P0.5\n", "cutting oxygen after 1 s of preheat"),
    (START, "G4 P2.5\nM64 P0\nM3 S1\nG4 P0.5\n", "cutting oxygen after 0 s of preheat"),
    (START, "M3 S1\nM64 P0\nG4 P2.5\nG4 P0.5\n", "cutting oxygen without the preheat"),
    (START, "M64 P0\nG4 P2.5\nM3 S1\nM65 P0\nG4 P0.5\n", "the preheat off with the cutting oxygen"),
    (START, "M64 P0\nM65 P0\nM64 P0\nG4 P2.5\nM3 S1\nG4 P0.5\n", ""),
    (START, "M62 P0\nG4 P2.5\nM3 S1\nG4 P0.5\n", "M62 P0"),
    ("M5\nM65 P0\n", "M65 P0\nM5\n", "the preheat off with the cutting oxygen on"),
    (START, "M64 P0\nG4 P2\nG4 P0.5\nM3 S1\nG4 P0.5\n", ""),
]  # fmt: skip


def changed(machine: Machine, old: str, new: str, last: bool = False) -> list[str]:
    """What is said of a program with other blocks in it; nothing of the program as it is."""
    text = post((NESTED,), machine).text
    assert isinstance(text, str)
    assert not verify_sheet(text, (NESTED,), machine)
    begins = text.rindex(old) if last else text.index(old)
    broken = text[:begins] + new + text[begins + len(old) :]
    return [f"{d.code}: {d.message}" for d in verify_sheet(broken, (NESTED,), machine)]


@pytest.mark.parametrize(("old", "new", "said"), MUTANTS)
def test_the_order_of_gases(old: str, new: str, said: str) -> None:
    found = changed(table("plate-oxyfuel"), old, new)
    assert any(said in one for one in found) if said else not found, found


def test_the_flame_is_off_at_the_end() -> None:
    (said, *_) = changed(table("plate-oxyfuel"), "M65 P0\n", "", last=True)
    assert said.startswith("verify-sheet-output: found the end with preheat on; expected it off")


def test_the_flame_heats_where_the_torch_stands() -> None:
    """A flame that was lit on the way here has heated another place."""
    machine = table("plate-oxyfuel")
    text = post((NESTED,), machine).text
    assert isinstance(text, str)
    traverse = text[text.rindex("G0 X", 0, text.index(START)) : text.index(START)]
    found = changed(machine, traverse + START, f"M64 P0\nG4 P2.5\n{traverse}M3 S1\nG4 P0.5\n")
    assert any("cutting oxygen after 0 s of preheat" in one for one in found)


def own(tmp_path: Path, more: str, base: str = "plate-linuxcnc") -> Machine:
    path = tmp_path / "mine.toml"
    path.write_text(f'base = "{base}"\n{more}')
    return load(str(path))


FUME = """
[codes]
M64P7 = "output on"
M65P7 = "output off"
M63P7 = "output off"
[words]
header = ["({job})", "G21 G17 G90 G91.1 G40 G94", "G64 P0.01", "M64 P7"]
footer = ["G0 X0 Y0", "M65 P7", "M2"]
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("M65 P7\n", "", "the end with output 7 on; expected it off"),
        ("G0 X0 Y0\nM65 P7\n", "G0 X0 Y0\nM63 P7\n", "output 7 switched with a move that does not"),
        ("G0 X0 Y0\nM65 P7\n", "M63 P7\nG0 X0 Y0\n", ""),
        ("M64 P7\n", "", ""),
        ("M65 P7\n", "M65 P8\n", "codes.M65P8 in the machine file"),
    ],
)
def test_outputs_are_off_at_the_end(old: str, new: str, said: str, tmp_path: Path) -> None:
    found = changed(own(tmp_path, FUME), old, new)
    assert any(said in one for one in found) if said else not found, found


def test_an_output_is_known_by_its_number(tmp_path: Path) -> None:
    events, _ = table_events("M64 P7\nM63 P7\nM2", own(tmp_path, FUME))
    assert [event for event in events if isinstance(event, Output)] == [
        Output(1, "output 7", True), Output(2, "output 7", False, True),
    ]  # fmt: skip


def test_nothing_is_switched_on_the_way_beside_the_contour(tmp_path: Path) -> None:
    """THC words and shares of the feed are not allowed while the controller compensates."""
    machine = own(tmp_path, """
[codes]
M62P2 = "thc off"
M63P2 = "thc on"
M67E3 = "feed share"
[torch]
kerf_by = "machine"
lead = "line"
""")  # fmt: skip
    for word, said in (("M63 P2", "the height control switched"), ("M67 E3 Q0", "a share of the")):
        found = changed(machine, "M3 S1\n", f"M3 S1\n{word}\n")
        assert any(said in one and "with compensation on" in one for one in found), found
        assert not changed(machine, "G40\n", f"G40\n{word}\n", last=True)


def test_air_may_come_before_or_behind_the_beam(tmp_path: Path) -> None:
    """grbl: M8 blows while M4 burns; the trace shows the beam on all along the contour."""
    from beamcam.simulation.program import simulate_program

    path = tmp_path / "mine.toml"
    for on, off in (
        ('"M8", "M4 S{power} F{feed}"', '"M5", "M9"'), ('"M4 S{power} F{feed}", "M7"', '"M9", "M5"')
    ):  # fmt: skip
        path.write_text(
            f'base = "laser-grbl"\n[torch]\nmaterial = "wood"\nthickness = 3\n'
            f"[words]\ncut_on = [{on}]\ncut_off = [{off}]\n"
        )
        machine = load(str(path))
        part = drawing(contour(circle(30, 30, 40)), thickness=3.0)
        text = post((part,), machine).text
        assert isinstance(text, str)
        trace = simulate_program(text, machine, parts=(part,)).trace
        moved = abs(trace.positions[1:] - trace.positions[:-1]).max(axis=1) > 0
        cutting = [trace.states[k].process == "cut" for k in trace.state.tolist()]
        assert sum(cutting) == sum(m and c for m, c in zip(moved, cutting, strict=True)) > 3
