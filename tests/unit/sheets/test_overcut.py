"""Overcuts: planned with bridges, leads and kerf compensation by offset and machine; read back."""

import re
from collections.abc import Sequence
from itertools import accumulate, pairwise
from math import dist

import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import LayerSettings
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from beamcam.readers import read
from tests.conftest import examples, sampled
from tests.unit.sheets.parts import box, circle, contour, drawing, lines
from tests.unit.sheets.test_tabs import PART, STROKE, WORD

GRBL = load("laser-grbl")
G_CODE = ("laser-grbl", "plate-linuxcnc", "plate-codesys")
TABLES = ("laser-stepper", "table-simotion")
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


@settings(max_examples=examples(25), deadline=None)
@given(
    overcut=st.floats(0.1, 15), tabs=st.integers(0, 3), inner=st.booleans(),
    kerf_by=st.sampled_from(["none", "offset", "machine"]),
    lead=st.sampled_from(["none", "line", "arc"]),
    name=st.sampled_from([*G_CODE, *TABLES]), style=st.sampled_from([".steps", ".csv"]),
)  # fmt: skip
@example(3.0, 1, True, "none", "none", "laser-stepper", ".steps")
def test_whatever_is_planned_is_found_right(
    overcut: float, tabs: int, inner: bool, kerf_by: str, lead: str, name: str, style: str
) -> None:
    if kerf_by == "machine" and name not in ("plate-linuxcnc", "plate-codesys"):
        kerf_by = "offset"
    if kerf_by == "machine":
        tabs, lead = 0, "line"
    kerf = {"kerf": 0.2} if name in TABLES and kerf_by != "none" else {}
    machine = asked(
        load(name), **kerf, overcut=overcut, tabs=tabs, inner_tabs=inner, kerf_by=kerf_by,
        lead=lead, lead_in=2.0, lead_out=1.0, margin=10.0, place="corner",
    )  # fmt: skip
    part = replace(PART, features=(*PART.features[:3], contour(circle(70, 10, 4), line=4)))
    assert post((part,), machine, style=style if "stepper" in name else None).plan.operations


@pytest.mark.parametrize(("name", "values"), [
    ("laser-grbl", {}), ("laser-grbl", {"tabs": 2}),
    ("laser-grbl", {"kerf_by": "offset", "lead": "arc", "lead_in": 2.0, "lead_out": 1.0}),
    ("plate-linuxcnc", {"kerf_by": "offset"}), ("plate-codesys", {}),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}),
    ("laser-stepper", {"tabs": 2}),
    ("laser-stepper", {
        "place": "corner", "kerf": 0.2, "lead": "arc", "lead_in": 2.0, "lead_out": 1.0,
    }),
    ("table-simotion", {}),
    ("table-simotion", {
        "place": "corner", "kerf": 0.4, "lead": "line", "lead_in": 2.0, "lead_out": 1.0, "tabs": 1,
    }),
])  # fmt: skip
@pytest.mark.parametrize(
    ("made", "wanted"), sampled([(0.0, 2.0), (2.0, 0.0), (4.0, 2.0), (2.0, 4.0)], 2)
)
def test_another_overcut_is_refused(
    name: str, values: dict[str, object], made: float, wanted: float
) -> None:
    machine = asked(load(name), margin=10.0, **values)
    text = post((PLATE,), asked(machine, overcut=made)).text
    said = read_back(text, Request((PLATE,), asked(machine, overcut=wanted)))
    assert said
    assert {one.code for one in said} <= {
        "verify-sheet-overcut", "verify-sheet-open", "verify-sheet-twice", "verify-sheet-missing",
        "verify-sheet-tabs", "verify-sheet-edge",
    }  # fmt: skip
    if made < wanted:
        assert {one.code for one in said} == {"verify-sheet-overcut"}


def test_a_colour_has_its_own() -> None:
    part = replace(PART, features=(*PART.features, contour(box(5, 5, 6, 6), BLUE, line=9)))
    own = {"blue": LayerSettings(overcut=1.0), "red": LayerSettings(overcut=0.5)}
    machine = with_torch(asked(overcut=3.0), {"blue": "cut", "red": "cut"}, settings=own)
    text = post((part,), machine).text
    assert text.count("M4") == 5
    for other in (0.0, 2.0):
        wrong = with_torch(machine, {"blue": "cut", "red": "cut"}, settings={
            **own, "blue": LayerSettings(overcut=other)
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
    own = {"blue": LayerSettings(overcut=1.0)}
    with pytest.raises(PlanError, match=r"plan-map-overcut: found map\.blue\.overcut"):
        post((part,), with_torch(GRBL, {"blue": "mark"}, settings=own))


def overcut_of(points: Sequence[tuple[float, float]]) -> float:
    """How far a path goes on after it came back to its start, by its points alone."""
    reached = list(accumulate((dist(a, b) for a, b in pairwise(points)), initial=0.0))
    middle = reached[-1] / 2
    back = min(
        (dist(point, points[0]), along)
        for point, along in zip(points, reached, strict=True) if along > middle
    )  # fmt: skip
    return reached[-1] - back[1]


def test_tables_of_points_go_on_by_as_much() -> None:
    """By the rows of a velocity table, and by the operations of a trigger program, alone."""
    rows = post((PLATE,), asked(load("laser-stepper"), overcut=1.5), style=".csv").text.split("\n")
    cuts: list[list[tuple[float, float]]] = []
    before = (0.0, 0.0, False)
    for row in (row for row in rows if re.match(r"\d", row)):
        x, y, _, _, laser, *_ = row.split(",")
        if laser == "1":
            if not before[2]:
                cuts.append([before[:2]])
            cuts[-1].append((float(x), float(y)))
        before = float(x), float(y), laser == "1"
    assert [overcut_of(cut) for cut in cuts] == pytest.approx([1.5, 1.5], abs=0.01)

    text = post((PLATE,), asked(load("table-simotion"), overcut=1.5), style="chain").text
    place = r"kind := USINT#(\d), x := LREAL#([\d.]+), y := LREAL#([\d.]+)"
    cuts, tool = [], "off"
    for kind, x, y in re.findall(place, text):
        tool = {"1": "on", "2": "off"}.get(kind, tool)
        if kind == "1":
            cuts.append([])
        if tool == "on":
            cuts[-1].append((float(x), float(y)))
    assert [overcut_of(cut) for cut in cuts] == pytest.approx([1.5, 1.5], abs=0.01)


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
    machine = with_torch(load("plate-linuxcnc"), {"red": "cut"}, thickness=3.0, allow_open=True)
    posted = post(parts, machine)
    assert "plan-open-cut" in {d.code for d in posted.remarks}
    assert posted.text.count("M3 S1") == 1


@pytest.mark.parametrize("tabs", [0, 2])
@pytest.mark.parametrize("gap", [0.011, 0.02, 0.04])
@pytest.mark.parametrize("name", ["laser-stepper", "laser-grbl"])
def test_no_overcut_is_asked_of_a_contour_with_a_gap(name: str, gap: float, tabs: int) -> None:
    """A gap wider than the machine closes, and narrower than what its paths may be off."""
    points = [(0.0, 0.0), (20.0, 0.0), (20.0, 40.0 - gap)]
    curves = (
        *lines(*points, closed=False),
        *lines((20.0, 40.0), (0.0, 40.0), (0.0, 0.0), closed=False),
    )
    part = drawing(*(contour((one,), line=k + 1) for k, one in enumerate(curves)), thickness=3.0)
    machine = with_torch(
        load(name), thickness=3.0, overcut=1.0, tabs=tabs, allow_open=True, gap=0.01
    )
    posted = post((part,), machine)
    assert not any(op.closed for op in posted.plan.operations)


@pytest.mark.parametrize("gap", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("name", ["laser-stepper", "laser-grbl", "table-simotion"])
def test_a_gap_that_is_closed_moves_the_path(name: str, gap: float) -> None:
    """Both ends may move by half of it; what the steps do there is no fault."""
    curves = (
        *lines((0.0, 0.0), (20.0, 0.0), (20.0, 40.0), closed=False),
        *lines((20.0 - gap, 40.0), (0.0, 40.0), (0.0, 0.0), closed=False),
    )
    part = drawing(*(contour((one,), line=k + 1) for k, one in enumerate(curves)), thickness=3.0)
    machine = with_torch(load(name), thickness=3.0, gap=1.01 * gap)
    posted = post((part,), machine)
    assert all(op.closed for op in posted.plan.operations)
