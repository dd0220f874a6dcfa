"""A plate with bends: its flat is cut, and each bend stands on the list of manual work; planes that
take nothing of it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.model.part import Bend, EndPlane
from beamcam.pipeline import post
from beamcam.planning.manual_list import manual_rows
from tests.unit.sheets.parts import S, box, contour, drawing, plate

PLATE = load("plate-linuxcnc")
OUTLINE = contour(box(0, 0, 200, 100), line=1)
SHIPPED = ("plate-linuxcnc", "plate-codesys", "plate-oxyfuel", "plate-mach3", "plate-qtplasmac",
           "laser-grbl", "laser-stepper", "table-simotion", "table-plcopen")  # fmt: skip


def bend(x: float, angle: float) -> Bend:
    return Bend((x, 0.0), (x, 100.0), angle, 9.0, S)


@given(st.lists(st.tuples(st.floats(5, 195), st.sampled_from([-90.0, 30.0, 90.0])), max_size=4))
def test_bends_change_nothing_but_the_head_and_the_list(bends: list[tuple[float, float]]) -> None:
    flat = drawing(OUTLINE)
    bent = replace(flat, features=(*flat.features, *(bend(x, a) for x, a in bends)))
    plain, posted = post((flat,), PLATE), post((bent,), PLATE)
    head = f"(LEFT TO THE HAND: {len(bends)})"
    assert [line for line in posted.text.splitlines() if line != head] == plain.text.splitlines()
    assert (head in posted.text) == bool(bends)
    rows = [row for row in manual_rows(posted.plan) if row["kind"] == "bend"]
    assert [(row["x"], row["angle"]) for row in rows] == bends
    listed = [d.code for d in verify_sheet(posted.text, (bent,), PLATE)]
    assert listed == ["verify-by-hand"] * len(bends)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_machines_for_plates_list_bends(name: str) -> None:
    assert load(name).marks.bends == "list"


def test_a_machine_that_lists_no_bends_refuses_them_by_name() -> None:
    strict = replace(PLATE, marks=replace(PLATE.marks, bends="refuse"))
    part = drawing(OUTLINE)
    part = replace(part, features=(*part.features, bend(50.0, 90.0)))
    with pytest.raises(PlanError) as refused:
        post((part,), strict)
    assert [d.code for d in refused.value.diagnostics] == ["plan-other"]
    listed = post((part,), PLATE).text
    assert "verify-sheet-not-made" in {d.code for d in verify_sheet(listed, (part,), strict)}


@given(st.tuples(*3 * [st.integers(-3, 3)]).filter(any), st.floats(-0.05, 30), st.floats(0.2, 5))
def test_a_plane_that_takes_nothing_is_no_work_and_any_other_is_refused(
    normal: tuple[int, int, int], off: float, deep: float
) -> None:
    bare = plate(OUTLINE)
    plain, long = post((bare,), PLATE), sum(n * n for n in normal) ** 0.5
    # The place of the plate that lies farthest along the normal, and places from there along it.
    x, y, z = (size * (n > 0) for n, size in zip(normal, (200.0, 100.0, 6.0), strict=True))
    beside, inside = (
        replace(bare, features=(OUTLINE, EndPlane(
            (x + by * normal[0], y + by * normal[1], z + by * normal[2]), normal, S)))
        for by in (off / long, -deep / long)
    )  # fmt: skip
    assert post((beside,), PLATE).text == plain.text
    with pytest.raises(PlanError) as refused:
        post((inside,), PLATE)
    assert [d.code for d in refused.value.diagnostics] == ["plan-other"]
    assert [d.code for d in verify_sheet(plain.text, (inside,), PLATE)] == ["verify-sheet-not-made"]
