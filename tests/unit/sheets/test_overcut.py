"""Overcuts: planned with bridges, leads and kerf compensation by offset and machine; read back."""

import re
from math import dist

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import MachineError, PlanError
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import LookSettings
from beamcam.pipeline import post, read_back
from beamcam.posts import Request
from beamcam.readers import read
from beamcam.verify.sheets import verify_sheet
from tests.unit.sheets.parts import box, circle, contour, drawing
from tests.unit.sheets.test_tabs import PART, STROKE, WORD

GRBL = load("laser-grbl")
BLUE = "#0000ff"
PLATE = drawing(
    contour(box(0, 0, 80, 60)), contour(circle(20, 30, 20), line=2), thickness=3.0
)  # fmt: skip


def asked(machine: Machine = GRBL, **values: object) -> Machine:
    return with_torch(machine, thickness=3.0, **values)  # type: ignore[arg-type]


def test_the_program_goes_on_by_as_much() -> None:
    """By the lines of the program alone: the square ends 1.5 mm along its first side."""
    text = post((PLATE,), asked(overcut=1.5)).text
    x, y, moves = STROKE.findall(text)[-1]
    places = [(float(x), float(y)), *((float(a), float(b)) for a, b in WORD.findall(moves))]
    assert places[0] == places[-2]
    assert dist(places[-2], places[-1]) == pytest.approx(1.5)
    first = shapely.LineString(places[:2])
    assert shapely.distance(first, shapely.Point(places[-1])) < 1e-9


@settings(max_examples=25, deadline=None)
@given(
    overcut=st.floats(0.1, 15), tabs=st.integers(0, 3), inner=st.booleans(),
    kerf_by=st.sampled_from(["none", "offset", "machine"]),
    lead=st.sampled_from(["none", "line", "arc"]),
    name=st.sampled_from(["laser-grbl", "plate-linuxcnc", "plate-codesys"]),
)  # fmt: skip
def test_whatever_is_planned_is_found_right(
    overcut: float, tabs: int, inner: bool, kerf_by: str, lead: str, name: str
) -> None:
    if kerf_by == "machine" and name == "laser-grbl":
        kerf_by = "offset"
    if kerf_by == "machine":
        tabs, lead = 0, "line"
    machine = asked(
        load(name), overcut=overcut, tabs=tabs, inner_tabs=inner, kerf_by=kerf_by, lead=lead,
        lead_in=2.0, lead_out=1.0, margin=10.0,
    )  # fmt: skip
    part = replace(PART, features=(*PART.features[:3], contour(circle(70, 10, 4), line=4)))
    assert post((part,), machine).plan.operations


@pytest.mark.parametrize(("name", "values"), [
    ("laser-grbl", {}), ("laser-grbl", {"tabs": 2}),
    ("laser-grbl", {"kerf_by": "offset", "lead": "arc", "lead_in": 2.0, "lead_out": 1.0}),
    ("plate-linuxcnc", {"kerf_by": "offset"}), ("plate-codesys", {}),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}),
])  # fmt: skip
@pytest.mark.parametrize(("made", "wanted"), [(0.0, 2.0), (2.0, 0.0), (2.0, 4.0), (4.0, 2.0)])
def test_another_overcut_is_refused(
    name: str, values: dict[str, object], made: float, wanted: float
) -> None:
    machine = asked(load(name), margin=10.0, **values)
    text = post((PLATE,), asked(machine, overcut=made)).text
    said = verify_sheet(text, (PLATE,), asked(machine, overcut=wanted))
    assert said
    assert {one.code for one in said} <= {
        "verify-sheet-overcut", "verify-sheet-open", "verify-sheet-twice", "verify-sheet-missing",
    }  # fmt: skip
    if made < wanted:
        assert {one.code for one in said} == {"verify-sheet-overcut"}


def test_a_colour_has_its_own() -> None:
    part = replace(PART, features=(*PART.features, contour(box(5, 5, 6, 6), BLUE, line=9)))
    own = {"blue": LookSettings(overcut=1.0), "red": LookSettings(overcut=0.5)}
    machine = with_torch(asked(overcut=3.0), {"blue": "cut", "red": "cut"}, settings=own)
    text = post((part,), machine).text
    assert text.count("M4") == 5
    for other in (0.0, 2.0):
        wrong = with_torch(machine, {"blue": "cut", "red": "cut"}, settings={
            **own, "blue": LookSettings(overcut=other)
        })  # fmt: skip
        said = read_back(text, Request((part,), wrong))
        assert {one.code for one in said} <= {"verify-sheet-overcut"}
        assert any("sheet.dxf:9" in one.message for one in said)


def test_short_contours_get_half_of_their_way_and_are_told() -> None:
    posted = post((PART,), asked(overcut=12.0))
    said = [one for one in posted.remarks if one.code == "plan-overcut"]
    assert [one.message.split(";")[0] for one in said] == [
        "found 1 contours too short for an overcut of 12 mm"
    ]
    assert said[0].source.line == 4


def test_what_is_not_cut_has_none() -> None:
    part = drawing(contour(box(0, 0, 20, 20)), contour(box(5, 5, 6, 6), BLUE), thickness=3.0)
    text = post((part,), with_torch(asked(overcut=2.0), {"blue": "mark"})).text
    assert [len(WORD.findall(moves)) for _, _, moves in STROKE.findall(text)] == [4, 5]
    own = {"blue": LookSettings(overcut=1.0)}
    with pytest.raises(PlanError, match=r"plan-map-overcut: found map\.blue\.overcut"):
        post((part,), with_torch(GRBL, {"blue": "mark"}, settings=own))


@pytest.mark.parametrize("name", ["laser-stepper", "table-simotion"])
def test_tables_without_g_code_refuse_it(name: str) -> None:
    with pytest.raises(ValueError, match="leave overcut out"):
        asked(load(name), overcut=1.0)
    own = {"red": LookSettings(overcut=1.0)}
    with pytest.raises(PlanError, match=r"map\.red\.overcut = 1"):
        post((PLATE,), with_torch(load(name), {"red": "cut"}, settings=own))


def test_the_machine_file_of_such_a_table_refuses_it(tmp_path: object) -> None:
    path = f"{tmp_path}/own.toml"
    with open(path, "w", encoding="utf-8") as file:
        file.write('base = "laser-stepper"\n[torch]\novercut = 1\n')
    with pytest.raises(MachineError, match=r"torch\.overcut"):
        load(path)


def test_a_line_there_and_back_again_has_none() -> None:
    from tests.unit.sheets.parts import lines

    part = drawing(
        contour(box(0, 0, 40, 40)), contour(lines((5, 5), (30, 5), (5, 5), closed=False), line=2),
        thickness=3.0,
    )  # fmt: skip
    assert re.search("M4", post((part,), asked(overcut=2.0)).text)


def test_a_path_that_comes_by_its_start_is_no_overcut() -> None:
    """An open curve whose ends lie on itself, alike from either end."""
    loops = "M10 40 a10 10 0 0 1 20 0 v5 a10 10 0 0 1 -20 0 v-20 a30 30 0 0 1 60 0 v20 "
    drawn = f'<path d="{loops}a10 10 0 0 1 -20 0 v-5 a10 10 0 0 1 20 0"/>'
    text = f"""<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="80mm"
    viewBox="0 0 80 80"><g fill="none" stroke="red">{drawn}</g></svg>"""
    parts = read(text.encode(), "t.svg").parts
    machine = with_torch(load("plate-linuxcnc"), {"red": "cut"}, thickness=3.0)
    posted = post(parts, machine)
    assert "plan-open-cut" in {d.code for d in posted.remarks}
    assert posted.text.count("M3 S1") == 1
