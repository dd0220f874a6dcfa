"""Plates as shops have them: thick ones, bevels, holes for the drill."""

from itertools import pairwise
from math import radians, tan
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely import Polygon

from beamcam.checks.job import head_of
from beamcam.checks.rules import MANUAL_WORK as FOR_MANUAL_WORK
from beamcam.checks.sheets.compare import verify_sheet
from beamcam.checks.sheets.need import need_of
from beamcam.errors import MachineError, PlanError, errors_in
from beamcam.machine import load, shipped
from beamcam.model.part import Bevel, Contour, Feature, Hole, Part, Profile, Slot
from beamcam.model.request import Request
from beamcam.pipeline import Posted, post, read_back
from beamcam.planning.contours import rules
from beamcam.planning.left_out import MANUAL_WORK
from beamcam.planning.manual_list import manual_rows
from beamcam.planning.rules import BEVEL_NOISE
from tests.conftest import examples
from tests.unit.sheets.parts import S, box, plate, table

TORCHES = ("plate-linuxcnc", "plate-codesys", "plate-oxyfuel")


def thick(mm: float, *features: Feature) -> Part:
    profile = Profile("B", f"PL{mm:g}*100", 100.0, 0.0, 0.0, mm)
    return replace(plate(*features), profile=profile)


def bevelled(*bevels: Bevel) -> Contour:
    return Contour("v", "outer", box(0, 0, 200, 100), S, bevels=bevels)


def codes_of(text: str, part: Part, name: str = "plate-linuxcnc", **values: object) -> set[str]:
    return {d.code for d in read_back(text, Request((part,), table(name, **values)))}


def posted(part: Part, name: str = "plate-linuxcnc", **values: object) -> Posted:
    return post([part], table(name, **values))


@pytest.mark.parametrize(("name", "mm"), [*((n, 32.0) for n in TORCHES), ("plate-oxyfuel", 100.0)])
def test_a_plate_is_cut_up_to_what_the_machine_has_rows_for(name: str, mm: float) -> None:
    assert posted(thick(mm), name).remarks == () or mm > 6
    with pytest.raises(PlanError) as caught:
        posted(thick(120.0), name)
    assert "[[torch.more_rows]]" in caught.value.diagnostics[0].message


def test_a_plate_beyond_the_machine_names_those_that_can() -> None:
    for skips in ((), ("all",)):
        with pytest.raises(PlanError) as caught:
            post([thick(40.0)], load("plate-linuxcnc"), skips=skips)
        (said,) = caught.value.diagnostics
        assert said.code == rules.THICKNESS.code
        assert said.message.endswith("; --machine plate-oxyfuel can")
    assert posted(thick(40.0), "plate-oxyfuel").text


@pytest.mark.parametrize("name", TORCHES)
def test_rows_rise_in_thickness(name: str) -> None:
    torch = load(name).torch
    assert torch is not None
    rows = [row for row in torch.rows if row.process == "cut"]
    for thin, thicker in pairwise(rows):
        assert thin.up_to < thicker.up_to
        assert thin.kerf < thicker.kerf
        assert thin.pierce_height <= thicker.pierce_height
    assert all(row.pierce_height > row.cut_height > 0 for row in rows)


def test_heights_are_words_that_are_read_back() -> None:
    machine = load("plate-linuxcnc")
    on = ("M190 P{pierce_height} Q{cut_height}", "G4 P{pierce}", "F{feed}")
    own = replace(machine, words=replace(machine.words, cut_on=on))
    text = post([plate()], own).text
    assert "M190 P3.8 Q1.5" in text
    wrong = read_back(text.replace("M190 P3.8", "M190 P4.8"), Request((plate(),), own))
    assert "error" in {said.severity.value for said in wrong}


def test_bevels_are_cut_square_and_listed_edge_by_edge() -> None:
    part = plate(bevelled(Bevel(0, 45.0, 2.0), Bevel(2, -30.0, 4.0), Bevel(1, 0.4, 0.0)))
    made = posted(part)
    assert [(o.how, o.by, o.left) for o in made.plan.outcomes] == [("made", "cut", "bevel")]
    assert [d.code for d in made.remarks] == [BEVEL_NOISE.code, MANUAL_WORK.code]
    rows = [
        (r["kind"], r["angle"], r["land"], r["length"], r["path"]) for r in manual_rows(made.plan)
    ]
    assert rows == [
        ("bevel", 45.0, 2.0, 200.0, "0 0; 200 0"),
        ("bevel", -30.0, 4.0, 200.0, "200 100; 0 100"),
    ]
    head = head_of(made.text)
    assert head is not None
    assert head.manual_work == 1
    square = posted(plate(bevelled()))
    moves = [[line for line in p.text.split("\n") if line.startswith("G")] for p in (made, square)]
    assert moves[0] == moves[1]
    assert codes_of(made.text, part) == {FOR_MANUAL_WORK.code}
    assert codes_of(made.text, part, bevel="refuse") >= {"verify-sheet-not-made"}


def test_noise_is_told_once_and_cut_square() -> None:
    part = plate(bevelled(Bevel(0, 0.4, 0.0), Bevel(1, -0.9, 6.0)))
    for policy in ("refuse", "square"):
        made = posted(part, bevel=policy)
        assert [d.code for d in made.remarks] == [BEVEL_NOISE.code]
        assert "2 bevel(s) of at most 0.9 degrees" in made.remarks[0].message
        assert [o.how for o in made.plan.outcomes] == ["made"]
        assert codes_of(made.text, part, bevel=policy) == set()
    with pytest.raises(PlanError, match="a bevel of 0"):
        posted(part, bevel="refuse", min_bevel=0.2)


ANGLE = st.floats(1.0, 60.0).flatmap(lambda a: st.sampled_from([a, -a]))


@settings(max_examples=examples(40), deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3), ANGLE, st.floats(0, 6)), max_size=4))
def test_no_steel_of_a_bevelled_plate_lies_outside_of_what_is_cut(
    wanted: list[tuple[int, float, float]],
) -> None:
    """At every depth the finished plate, built from its bevels, lies within the contour cut."""
    part = plate(bevelled(*(Bevel(*one) for one in wanted)))
    machine = table()
    assert machine.torch is not None
    need = need_of(part, machine, machine.torch, ())
    cut = Polygon([curve.start for curve in need.curves["cut"]])
    for depth in (0.0, 1.5, 3.0, 6.0):
        back = [0.0] * 4
        for edge, angle, land in wanted:
            high = 6.0 - land - depth if angle > 0 else depth - land  # of the bevel over its land
            back[edge] = max(back[edge], high * tan(radians(abs(angle))))
        x0, y0, x1, y1 = back[3], back[0], 200 - back[1], 100 - back[2]
        level = Polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        assert cut.buffer(1e-9).covers(level)


ONE_ROW = "[[torch.rows]]\nprocess = 'cut'\nup_to = 3\nfeed_mm_min = 9\n"


def test_keys_that_contradict_each_other(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    for key, value, says in (
        ("bevel", "'head'", "no torch that tilts is known yet"),
        ("cross", "0", "the size of the cross"),
    ):
        path.write_text(f"base = 'plate-linuxcnc'\n[torch]\n{key} = {value}\n")
        with pytest.raises(MachineError, match=says):
            load(str(path))
    path.write_text(f"base = 'plate-linuxcnc'\n{ONE_ROW}[torch.colours]\nblue = 'ignore'\n")
    with pytest.raises(MachineError, match="torch"):
        load(str(path))


DRILLED = (
    (Hole("v", 50, 50, 12.0, S, kind="thread"), [(50, 50)], ("thread", "12")),
    (Hole("v", 50, 50, 12.0, S, kind="countersink"), [(50, 50)], ("countersink", "12")),
    (Hole("v", 50, 50, 12.0, S, depth=3.0), [(50, 50)], ("hole", "12")),
    (Hole("v", 50, 50, 3.0, S), [(50, 50)], ("hole", "3")),
    (Slot("v", 90, 50, 2.0, 9.0, 0.0, 0.0, S), [(85.5, 50), (94.5, 50)], ("slot", "11 x 2")),
    (Slot("v", 90, 50, 2.0, 8.0, 0.0, 90.0, S), [(90, 46), (90, 54)], ("slot", "10 x 2")),
)


@pytest.mark.parametrize(("feature", "places", "row"), DRILLED, ids=lambda v: str(v)[:9])
@pytest.mark.parametrize("name", ["plate-linuxcnc", "plate-codesys"])
def test_holes_for_the_drill_are_marked_and_listed(
    feature: Hole | Slot, places: list[tuple[float, float]], row: tuple[str, str], name: str
) -> None:
    part = plate(feature)
    made = posted(part, name)
    assert [(o.how, o.by) for o in made.plan.outcomes] == [("listed", "drill")]
    assert [(r["kind"], r["size"]) for r in manual_rows(made.plan)] == [row]
    assert [d.code for d in made.remarks] == [MANUAL_WORK.code]
    assert codes_of(made.text, part, name) == {FOR_MANUAL_WORK.code}
    crosses = [op for op in made.plan.operations if op.row.process == "mark"]
    dx, dy = made.plan.shift  # type: ignore[union-attr]
    middles = {
        (round((a + c) / 2 - dx, 6), round((b + d) / 2 - dy, 6))
        for op in crosses for p in op.passes
        for (a, b), (c, d) in ((curve.start, curve.end) for curve in p.curves)
    }  # fmt: skip
    assert middles == {(round(x, 6), round(y, 6)) for x, y in places}
    elsewhere = plate(replace(feature, x=feature.x + 1.0))
    assert "verify-sheet-missing" in codes_of(made.text, elsewhere, name)
    assert "verify-sheet-missing" in codes_of(posted(plate()).text, part)


def test_the_least_hole_grows_with_the_thickness() -> None:
    hole = Hole("v", 100, 50, 14.0, S)
    assert [o.how for o in posted(thick(16.0, hole)).plan.outcomes] == ["made"]
    assert [o.how for o in posted(thick(20.0, hole)).plan.outcomes] == ["listed"]
    with pytest.raises(PlanError, match="expected at least 16 in a sheet of 20 mm"):
        posted(thick(20.0, hole), drilled="refuse")
    cut = posted(thick(20.0, hole), min_hole_share=0.5).text
    assert "verify-sheet-extra" in codes_of(cut, thick(20.0, hole))


def test_every_torch_of_the_trade_says_what_it_leaves_to_the_hand() -> None:
    spotted = {"plate-qtplasmac": "spot"}
    for name in shipped():
        torch = load(name).torch
        if torch is not None:
            assert (torch.drilled, torch.bevel) == (
                (spotted.get(name, "mark"), "square")
                if name.startswith("plate-")
                else ("refuse", "refuse")
            )


def test_a_row_has_its_own_smallest_hole_and_lead(tmp_path: Path) -> None:
    """A hole that the row does not cut is marked for the drill; its lead is as long as it says."""
    path = tmp_path / "mine.toml"
    row = "{{process = 'cut', material = 'mild steel', up_to = {}, feed_mm_min = 900, {}}}"
    rows = [row.format(10, "min_hole = 20, lead_in = 7, kerf = 1.5"),
            row.format(20, "kerf = 1.9")]  # fmt: skip
    rows.append("{process = 'mark', up_to = 20, feed_mm_min = 3000}")
    path.write_text(f'base = "plate-linuxcnc"\n[torch]\nrows = [{", ".join(rows)}]\n')
    machine = load(str(path))
    for mm, how, lead in ((10.0, "listed", 7.0), (16.0, "made", 3.0)):
        part = thick(mm, Hole("v", 60.0, 50.0, 18.0, S))
        made = post([part], machine)
        assert [o.how for o in made.plan.outcomes][-1] == how
        cut = [op for op in made.plan.operations if op.row.process == "cut"][-1]
        first = cut.passes[0].lead_in
        assert sum(curve.length for curve in first) == pytest.approx(lead, rel=0.02)
        assert not errors_in(verify_sheet(made.text, (part,), machine))
        if how == "listed":
            other = replace(
                machine,
                torch=replace(
                    machine.torch, rows=tuple(replace(r, min_hole=0.0) for r in machine.torch.rows)
                ),
            )  # type: ignore[union-attr]
            assert errors_in(verify_sheet(made.text, (part,), other))
