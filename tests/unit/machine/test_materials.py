"""Grades and what they are made of, and which rows of a cut chart are for them."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.checks.sheets.asked_sheet import rows_on
from beamcam.errors import MachineError, PlanError
from beamcam.machine import load, shipped
from beamcam.machine.keys import settings
from beamcam.machine.toml import with_more_rows
from beamcam.machine.torch import TorchRow, is_row_for, material_of, material_said
from beamcam.model.part import Part
from beamcam.pipeline import post
from tests.conftest import sampled
from tests.unit.sheets.parts import box, circle, contour, drawing, table

MILD = ("S235JR", "S355J2+N", "S 355", "s275", "S460M", "ST 37-2", "RSt37-2", "Fe 360", "A36",
        "A992", "ASTM A992", "MS", "Metal - Steel - 345 MPa", "A572-50",
        "1.0038", "1.0577", "Q235B", "SS400", "DC01", "steel",
        "C255", "C355-5", "С345-3", "Ст3сп5", "A588", "A709-50W", "G40.21-350W", "44W", "E250 BR",
        "IS 2062", "AS3678-250", "C350L0", "300PLUS", "SN400B", "STKR400", "SM355A", "43A",
        "mild steel")  # fmt: skip
STAINLESS = ("1.4301", "1.4571", "X5CrNi18-10", "304", "316L", "AISI 304", "stainless steel", "V2A")
ALUMINIUM = ("EN AW-5754", "AlMg3", "6082-T6", "5083", "3.3535", "aluminium", "aluminum", "alu")
OTHERS = (
    "wood", "acrylic", "copper", "HARDOX 400", "S690QL", "42CrMo4", "1.2379", "C45", "E335", "C60",
)  # fmt: skip


@pytest.mark.parametrize(
    ("grades", "material"),
    [(MILD, "mild steel"), (STAINLESS, "stainless steel"), (ALUMINIUM, "aluminium")],
)
def test_grades_and_their_material(grades: tuple[str, ...], material: str) -> None:
    assert {material_of(grade) for grade in grades} == {material}
    for grade in grades:
        assert is_row_for(material, grade)
        assert is_row_for("*", grade)
        assert not is_row_for("wood", grade)


def test_other_grades_are_materials_of_their_own() -> None:
    for grade in OTHERS:
        assert material_of(grade) == grade.casefold()
        assert is_row_for(grade.upper(), grade)
        assert not is_row_for("mild steel", grade)
    assert is_row_for("S690*", "S690QL")
    assert is_row_for("mild steel", "")


def test_what_names_no_grade_is_no_material() -> None:
    """Real parts of three offices have NA, and one has an unnamed material."""
    for grade in ("", "NA", "N/A", "n.a.", "none", "Unknown", "<Unnamed>", "-", "?", "xxx"):
        assert material_said(grade, "wood") == "wood"
        assert post((plate(grade),), table("plate-linuxcnc")).text
    assert material_said("S355", "wood") == "S355"


def plate(grade: str) -> Part:
    return drawing(contour(box(0, 0, 60, 40)), contour(circle(30, 20, 20)), grade=grade)


@pytest.mark.parametrize("name", sampled(["plate-linuxcnc", "plate-codesys", "plate-oxyfuel"], 3))
@pytest.mark.parametrize("grade", ["", *MILD, *STAINLESS[:3], *ALUMINIUM[:3], *OTHERS])
def test_a_torch_cuts_what_its_rows_name(name: str, grade: str) -> None:
    """Stainless steel, aluminium or wood is not cut by the data of mild steel."""
    machine = table(name)
    assert machine.torch is not None
    known = {row.process for row in rows_on(plate(grade), machine.torch)}
    if grade in ("", *MILD):
        assert known == {"cut", "mark"}
        assert post((plate(grade),), machine).text
    else:
        assert known == {"mark"}
        with pytest.raises(PlanError, match="mm of mild steel") as caught:
            post((plate(grade),), machine)
        assert caught.value.diagnostics[0].code == "plan-thickness"


def test_every_row_to_cut_of_a_shipped_table_names_its_material() -> None:
    for machine in map(load, shipped()):
        for row in machine.torch.rows if machine.torch else ():
            assert row.process != "cut" or row.material != "*", machine.name


@pytest.mark.parametrize("up_to", [6, 40])
def test_a_row_of_ones_own_that_names_no_material_is_of_that_of_its_base(
    up_to: int, tmp_path: Path
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        'base = "plate-linuxcnc"\n[[torch.more_rows]]\nprocess = "cut"\nkerf = 2\n'
        f"up_to = {up_to}\nfeed_mm_min = 777\n"
    )
    torch = load(str(path)).torch
    assert torch is not None
    (row,) = [row for row in torch.rows if row.feed_mm_min == 777]
    assert row.material == "mild steel"
    thick = drawing(*plate("S235").features, thickness=float(up_to), grade="S235")
    assert next(r for r in rows_on(thick, torch) if r.process == "cut") == row


# --- rows added to those of the base --------------------------------------------------------------


ROW = "[[torch.more_rows]]\nprocess = 'cut'\nup_to = {up_to}\nfeed_mm_min = {feed}\n"


def rows(path: Path) -> list[tuple[str, float, float]]:
    torch = load(str(path)).torch
    assert torch is not None
    assert torch.more_rows == ()
    return [(row.process, row.up_to, row.feed_mm_min) for row in torch.rows]


def test_a_row_more_needs_none_of_the_others(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("base = 'plate-linuxcnc'\n" + ROW.format(up_to=40, feed=260))
    base = load("plate-linuxcnc").torch
    assert base is not None
    before = [(row.process, row.up_to, row.feed_mm_min) for row in base.rows]
    assert sorted(rows(path)) == sorted([*before, ("cut", 40.0, 260.0)])
    assert {s.value for s in settings(str(path)) if s.key.endswith("up_to")} >= {32.0, 40.0}


def test_a_row_takes_the_place_of_one_for_the_same_sheet(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("base = 'plate-linuxcnc'\n" + ROW.format(up_to=6, feed=2000))
    assert [feed for process, up_to, feed in rows(path) if (process, up_to) == ("cut", 6.0)] == [
        2000.0
    ]


def test_rows_are_added_over_several_bases(tmp_path: Path) -> None:
    (tmp_path / "first.toml").write_text(
        "base = 'plate-linuxcnc'\n" + ROW.format(up_to=40, feed=260)
    )
    (tmp_path / "second.toml").write_text("base = 'first'\n" + ROW.format(up_to=50, feed=180))
    greatest = [up_to for process, up_to, _ in rows(tmp_path / "second.toml") if process == "cut"]
    assert greatest[-2:] == [40.0, 50.0]
    own = "base = 'first'\n[[torch.rows]]\nprocess = 'cut'\nup_to = 5\nfeed_mm_min = 9\n"
    (tmp_path / "third.toml").write_text(own + "[torch.colours]\nblue = 'ignore'\n")
    (tmp_path / "third.toml").write_text(
        own + "[[torch.rows]]\nprocess = 'mark'\nup_to = 9\nfeed_mm_min = 9\n"
    )
    assert rows(tmp_path / "third.toml") == [("cut", 5.0, 9.0), ("mark", 9.0, 9.0)]


@pytest.mark.parametrize(
    ("line", "code"), [("feed = 3", "machine-key"), ("kerf = '3'", "machine-value")]
)
def test_a_wrong_row_is_told_by_its_own_key(tmp_path: Path, line: str, code: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f"base = 'plate-linuxcnc'\n{ROW.format(up_to=40, feed=260)}{line}\n")
    with pytest.raises(MachineError, match=r"torch\.more_rows\.0") as caught:
        load(str(path))
    (said,) = caught.value.diagnostics
    assert (said.code, said.source.line) == (code, 6)


MATERIALS = st.sampled_from(["*", "acrylic", "S*"])
UP_TO = st.sampled_from([3.0, 6.0, 12.0, 40.0])
ROWS = st.lists(st.tuples(MATERIALS, UP_TO), max_size=6, unique=True)


@given(ROWS, ROWS)
def test_each_added_row_is_found_for_its_own_sheet(
    rows: list[tuple[str, float]], more: list[tuple[str, float]]
) -> None:
    """The first row that fits a sheet of an added row's material and thickness is that row."""

    def table(some: list[tuple[str, float]], feed: int) -> list[dict[str, object]]:
        return [{"process": "cut", "material": m, "up_to": u, "feed_mm_min": feed} for m, u in some]

    chart = sorted(rows, key=lambda row: (row[0] == "*", row[1]))  # as a chart has to be written
    found = with_more_rows({"torch": {"rows": table(chart, 1), "more_rows": table(more, 2)}})
    merged = [TorchRow(**row) for row in found["torch"]["rows"]]
    for material, up_to in more:
        first = next(r for r in merged if r.material == material and up_to <= r.up_to)
        assert (first.up_to, first.feed_mm_min) == (up_to, 2)
    if more:
        order = [row.material == "*" for row in merged]
        assert order == sorted(order)
