"""Grades and what they are made of, and which rows of a cut chart are for them."""

from pathlib import Path

import pytest

from beamcam.checks.sheets.chart_rows import rows_on
from beamcam.errors import PlanError
from beamcam.machine import load, shipped
from beamcam.machine.torch import is_row_for, material_of, material_said
from beamcam.model.part import Part
from beamcam.pipeline import post
from tests.unit.sheets.parts import box, circle, contour, drawing, table

MILD = ("S235JR", "S355J2+N", "S 355", "s275", "S460M", "ST 37-2", "RSt37-2", "Fe 360", "A36",
        "A992", "ASTM A992", "MS", "Metal - Steel - 345 MPa", "A572-50",
        "1.0038", "1.0577", "Q235B", "SS400", "DC01", "steel",
        "mild steel")  # fmt: skip
STAINLESS = ("1.4301", "1.4571", "X5CrNi18-10", "304", "316L", "AISI 304", "stainless steel", "V2A")
ALUMINIUM = ("EN AW-5754", "AlMg3", "6082-T6", "5083", "3.3535", "aluminium", "aluminum", "alu")
OTHERS = ("wood", "acrylic", "copper", "HARDOX 400", "S690QL", "42CrMo4", "1.2379", "C45")


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


@pytest.mark.parametrize("name", ["plate-linuxcnc", "plate-codesys", "plate-oxyfuel"])
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
