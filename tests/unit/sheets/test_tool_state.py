"""State of tool and controller in programs of tables: what holds that was not asked for."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from beamcam.arguments import load_tested
from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import MachineError, VerifyError
from beamcam.model.part import Part
from beamcam.pipeline import post
from tests.conftest import ROOT, sampled
from tests.unit.sheets.parts import NESTED, box, circle, contour, drawing, lines, table

PLAIN = {"kerf_by": "none", "lead": "none"}
WOOD = {"material": "wood"}
SET_UPS: list[tuple[str, dict[str, object]]] = [
    ("plate-linuxcnc", {}), ("plate-linuxcnc", PLAIN), ("plate-linuxcnc", {"tabs": 2}),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}),
    ("plate-linuxcnc", {"overcut": 3.0}), ("plate-oxyfuel", {}),
    ("plate-codesys", {}), ("plate-codesys", PLAIN), ("laser-grbl", WOOD),
    ("laser-grbl", {**WOOD, "direction": "climb"}),
    ("laser-grbl", {**WOOD, "tabs": 2, "inner_tabs": True}),
    ("laser-grbl", {**WOOD, "direction": "conventional", "kerf_by": "offset"}),
]  # fmt: skip
CUT = re.compile(r"^(N\d+ )?(M0?3(?: S1)?|M4 S\d+ F\d+)$")
STOP = re.compile(r"^(N\d+ )?M0?5$")
MOVE = re.compile(r"^(N\d+ )?G0?[123] X")


def cuts(lines_: list[str]) -> Iterator[tuple[int, int, int]]:
    """The lines of each cut: where the tool starts, its first move, where it stops."""
    k = 0
    while k < len(lines_):
        if CUT.match(lines_[k]):
            first = next(i for i in range(k, len(lines_)) if MOVE.match(lines_[i]))
            end = next(i for i in range(first, len(lines_)) if STOP.match(lines_[i]))
            yield k, first, end
            k = end
        k += 1


def codes(text: str, part: Part, values: tuple[str, dict[str, object]]) -> set[str]:
    name, more = values
    return {said.code for said in verify_sheet(text, (part,), table(name, **more))}


@pytest.mark.parametrize("set_up", sampled(((one,) for one in SET_UPS), 2))
def test_a_dwell_with_the_tool_on_in_mid_contour_is_refused(
    set_up: tuple[str, dict[str, object]],
) -> None:
    name, values = set_up
    text = post((NESTED,), table(name, **values)).text
    before = text.split("\n")
    dwell = "G04 T1" if name == "plate-codesys" else "G4 P1"
    count = 0
    for _, first, end in cuts(before):
        for k in range(first + 1, end + 1):
            changed = "\n".join([*before[:k], dwell, *before[k:]])
            assert codes(changed, NESTED, set_up) == {"verify-sheet-tool"}
            count += 1
    assert count >= 6


@pytest.mark.parametrize("set_up", sampled(((one,) for one in SET_UPS), 2))
def test_a_tool_that_stops_and_starts_in_mid_contour_is_refused(
    set_up: tuple[str, dict[str, object]],
) -> None:
    name, values = set_up
    text = post((NESTED,), table(name, **values)).text
    before = text.split("\n")
    count = 0
    for start, first, end in cuts(before):
        for k in range(first + 1, end):
            again = [before[end], *before[start:first]]
            changed = "\n".join([*before[:k], *again, *before[k:]])
            assert codes(changed, NESTED, set_up), (before[k - 1], before[k])
            count += 1
    assert count >= 6


@pytest.mark.parametrize(("name", "values"), sampled(SET_UPS, 2))
@pytest.mark.parametrize("way", sampled(["climb", "drawn", "conventional"], 2))
def test_a_contour_that_is_cut_in_another_direction_is_refused(
    name: str, values: dict[str, object], way: str
) -> None:
    """NESTED is drawn counter-clockwise throughout: two outlines and two holes."""
    asked = table(name, **{**values, "direction": way})
    for other in {"drawn", "climb", "conventional"} - {way}:
        text = post((NESTED,), table(name, **{**values, "direction": other})).text
        said = [s for s in verify_sheet(text, (NESTED,), asked) if s.code != "verify-sheet-side"]
        assert {s.code for s in said} == {"verify-sheet-direction"}
        assert len(said) == (4 if "drawn" not in (way, other) else 2)


CORNERS = [
    ("G64 P0.01", "G64 P5"), ("G64 P0.01", "G64"), ("G64 P0.01", "G64 P0"), ("G64 P0.01\n", ""),
    ("G64 P0.01", "G64 P0.01 Q1"), ("G64 P0.01", "G61.1"), ("G64 P0.01", "G61"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new"), CORNERS)
def test_a_controller_that_may_leave_the_path_at_corners_is_refused(old: str, new: str) -> None:
    machine = table()
    text = post((NESTED,), machine).text
    assert text.count(old) == 1
    said = verify_sheet(text.replace(old, new), (NESTED,), machine)
    assert [s.code for s in said] == ["verify-sheet-corner"]
    before_the_last = text.replace("G0 X0 Y0", "G64 P5\nG0 X0 Y0")
    assert codes(before_the_last, NESTED, ("plate-linuxcnc", {})) == {"verify-sheet-corner"}


def test_a_machine_that_stops_in_corners_says_so() -> None:
    machine = table(corner=0.0)
    with pytest.raises(VerifyError, match=r"expected G61, as torch\.corner is 0"):
        post((NESTED,), machine)
    header = tuple("G61" if line.startswith("G64") else line for line in machine.words.header)
    machine = replace(machine, words=replace(machine.words, header=header))
    assert post((NESTED,), machine).text.count("\nG61\n") == 1


def test_a_machine_file_whose_header_lets_corners_go_is_refused(tmp_path: Path) -> None:
    text = (ROOT / "beamcam" / "machines" / "plate-linuxcnc.toml").read_text(encoding="utf-8")
    file = tmp_path / "mine.toml"
    for header in ("G64 P5", "G64"):
        file.write_text(text.replace("G64 P0.01", header), encoding="utf-8")
        with pytest.raises(MachineError, match="passes corners at"):
            load_tested(str(file))


#: Kerf compensation that nothing asks for, by its words.
BESIDE = {"plate-linuxcnc": ("G42.1 D2", "G40"), "plate-codesys": ("G41 D3", "G40")}


@pytest.mark.parametrize("name", BESIDE)
@pytest.mark.parametrize("values", [{}, PLAIN, {"lead": "none"}])
def test_compensation_that_is_not_asked_for_is_refused(
    name: str, values: dict[str, object]
) -> None:
    beside, off = BESIDE[name]
    before = post((NESTED,), table(name, **values)).text.split("\n")
    for start, _, end in cuts(before):
        changed = "\n".join(
            [*before[:start], beside, *before[start : end + 1], off, *before[end + 1 :]]
        )
        assert "verify-sheet-tool" in codes(changed, NESTED, (name, values))


LEFT_OPEN = {
    "two that cross": (box(0, 0, 100, 100), box(0.2, 0.2, 100, 100)),
    "one across the edge of another": (box(0, 0, 100, 60), circle(105, 30, 40)),
    "drawn twice, there and back": (box(0, 0, 80, 50), lines((0, 0), (0, 50), (80, 50), (80, 0))),
    "two that share an edge": (box(0, 0, 40, 40), box(40, 0, 40, 40)),
    "lines drawn one by one": (
        lines((0, 0), (50, 0), closed=False), lines((50, 0), (50, 40), closed=False),
        lines((50, 40), (0, 40), closed=False), lines((0, 40), (0, 0), closed=False),
        lines((50, 10), (70, 10), closed=False), lines((70, 10), (70, 30), closed=False),
        lines((70, 30), (50, 30), closed=False),
    ),
}  # fmt: skip


@pytest.mark.parametrize("drawn", LEFT_OPEN)
@pytest.mark.parametrize("way", ["drawn", "climb", "conventional"])
def test_where_the_drawing_leaves_the_direction_open_either_is_right(drawn: str, way: str) -> None:
    part = drawing(*(contour(curves) for curves in LEFT_OPEN[drawn]))
    for name, values in (("laser-grbl", WOOD), ("plate-linuxcnc", PLAIN), ("plate-codesys", PLAIN)):
        assert post((part,), table(name, **{**values, "direction": way})).text


STANDING = {
    "on twice": lambda text: text.replace("G41.1", "G41.1 D1.5\nG41.1", 1),
    "on in a traverse": lambda text: re.sub(r"(G0 X.*)\n(G41.1 .*)\n(M3 S1)", r"\2\n\1\n\3", text),
    "off after a traverse": lambda text: re.sub(r"(G40)\n(G0 X.*)\n(M3|G41)", r"\2\n\1\n\3", text),
    "on at the end": lambda text: re.sub(r"G40\n(?=G0 X0 Y0)", "", text),
}


@pytest.mark.parametrize("fault", STANDING)
def test_compensation_holds_from_where_a_stroke_begins_to_where_it_ends(fault: str) -> None:
    set_up = ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"})
    text = post((NESTED,), table(set_up[0], **set_up[1])).text
    changed = STANDING[fault](text)
    assert changed != text
    assert codes(changed, NESTED, set_up) == {"verify-sheet-tool"}
