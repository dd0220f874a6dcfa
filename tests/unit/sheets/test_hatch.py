"""Hatches: filled inside their contours only, read back by polygons; tabs in inner contours."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
import shapely
from click.testing import CliRunner
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.marks import hatch_faults
from beamcam.checks.sheets.need import need_of
from beamcam.cli import main
from beamcam.errors import PlanError
from beamcam.machine import Machine
from beamcam.machine import load as load_machine
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import LayerSettings
from beamcam.model.hatch import hatched
from beamcam.model.part import Contour, Part
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from tests.conftest import SAMPLES, examples, sampled
from tests.test_grbl_rules import faults
from tests.unit.sheets.parts import box, circle, contour, drawing, lines

GRBL = load_machine("laser-grbl")
BLACK = "#000000"
PART = drawing(
    contour(box(0, 0, 80, 60)),
    contour(box(10, 10, 60, 40), BLACK),
    contour(circle(30, 30, 20), BLACK),
    thickness=3.0,
)
INSIDE = shapely.box(10, 10, 70, 50) - shapely.Point(30, 30).buffer(10, quad_segs=64)
STROKE = re.compile(r"G0 X(\S+) Y(\S+)\nM4 S300 F3500\nG1 X(\S+) Y(\S+)\nM5\n")


def asked(
    machine: Machine = GRBL, distance: float = 1.0, angle: float = 0.0, *,
    one_way: bool = False, outline: bool = True,
) -> Machine:  # fmt: skip
    own = {
        "black": LayerSettings(
            hatch=distance, hatch_angle=angle, hatch_one_way=one_way, hatch_outline=outline
        )
    }
    return with_torch(machine, {"black": "engrave"}, settings=own, thickness=3.0)


@settings(max_examples=examples(12), deadline=None)
@given(distance=st.floats(0.7, 4), angle=st.floats(-180, 180))
def test_lines_lie_inside_and_fill(distance: float, angle: float) -> None:
    machine = asked(distance=distance, angle=angle)
    text = post((PART,), machine).text
    found = [
        shapely.LineString([(float(a) - 2, float(b) - 2), (float(c) - 2, float(d) - 2)])
        for a, b, c, d in STROKE.findall(text)
    ]
    assert found
    assert all(INSIDE.buffer(0.01).covers(line) for line in found)
    near = shapely.union_all([line.buffer(1.5 * distance) for line in found])
    assert (INSIDE.buffer(-1.5 * distance) - near).area < 1e-6


def test_strokes_run_both_ways() -> None:
    found = STROKE.findall(post((PART,), asked()).text)
    forwards = sum(float(c) > float(a) for a, _, c, _ in found)
    assert 0.3 * len(found) < forwards < 0.7 * len(found)


Line = tuple[float, float, float, float]


def stroke(line: Line) -> str:
    a, b, c, d = (f"{v:g}" for v in line)
    return f"G0 X{a} Y{b}\nM4 S300 F3500\nG1 X{c} Y{d}\nM5\n"


#: What is done to a line of a hatch in the program.
LINES: dict[str, tuple[Callable[[Line], list[Line]], str]] = {
    "missing": (lambda ln: [], "verify-sheet-missing"),
    "twice": (lambda ln: [ln, ln], "verify-sheet-twice"),
    "another between": (
        lambda ln: [ln, (ln[0], ln[1] + 0.4, ln[2], ln[3] + 0.4)], "verify-sheet-extra"
    ),
    "out of its contour": (lambda ln: [(ln[0], ln[1], ln[2] + 4, ln[3])], "verify-sheet-extra"),
    "shorter": (lambda ln: [(ln[0], ln[1], ln[0] + (ln[2] - ln[0]) * 0.8, ln[3])],
                "verify-sheet-missing"),
    "at another distance": (lambda ln: [(ln[0], ln[1] + 0.1, ln[2], ln[3] + 0.1)],
                            "verify-sheet-extra"),
    "at another angle": (lambda ln: [(ln[0], ln[1], ln[2], ln[3] + 0.3)], "verify-sheet-extra"),
}  # fmt: skip


@pytest.mark.parametrize("one_way", [False, True])
@pytest.mark.parametrize("fault", sampled(LINES, 2))
def test_a_line_that_is_none_of_the_hatch_is_refused(fault: str, one_way: bool) -> None:
    machine = asked(one_way=one_way)
    text = post((PART,), machine).text
    change, code = LINES[fault]
    found = STROKE.search(text)
    assert found is not None
    a, b, c, d = map(float, found.groups())
    lines = change((a, b, c, d) if c > a else (c, d, a, b))
    other = text.replace(found[0], "".join(map(stroke, lines)), 1)
    said = read_back(other, Request((PART,), machine))
    assert code in {one.code for one in said}


def test_a_line_that_runs_backwards_is_refused_where_all_run_one_way() -> None:
    both, one = asked(), asked(one_way=True)
    text = post((PART,), one).text
    found = [tuple(map(float, groups)) for groups in STROKE.findall(text)]
    assert all(c > a for a, _, c, _ in found)
    assert not read_back(text, Request((PART,), both))
    a, b, c, d = found[3]
    other = text.replace(stroke((a, b, c, d)), stroke((c, d, a, b)))
    assert other != text
    assert {said.code for said in read_back(other, Request((PART,), one))} == {
        "verify-sheet-hatch-way"
    }
    assert not read_back(other, Request((PART,), both))


@pytest.mark.parametrize("angle", [0.0, 37.0, 90.0, -120.0])
def test_the_outline_may_be_left_out(angle: float) -> None:
    """Filled, not followed; a loose line of the colour is followed all the same."""
    loose = contour(lines((2, 2), (8, 2), closed=False), BLACK, line=5)
    part = replace(PART, features=(*PART.features, loose))
    filled, followed = asked(angle=angle, outline=False), asked(angle=angle)
    posted = post((part,), filled)
    assert [o.how for o in posted.plan.outcomes] == ["made"] * len(posted.plan.outcomes)
    strokes = posted.text.count("M4 S300")
    assert strokes == len(STROKE.findall(posted.text))
    assert post((part,), followed).text.count("M4 S300") == strokes + 2
    said = {one.code for one in read_back(posted.text, Request((part,), followed))}
    assert said == {"verify-sheet-missing"}
    said = {one.code for one in read_back(post((part,), followed).text, Request((part,), filled))}
    assert said == {"verify-sheet-extra"}


#: A plan that hatches otherwise than asked, told by polygons alone.
WRONG: dict[str, Callable[[list[Contour]], list[Contour]]] = {
    "a line outside": lambda fill: [moved(fill[0], (5, 5), (50, 5)), *fill[1:]],
    "lines missing": lambda fill: fill[:10] + fill[20:],
    "one line missing": lambda fill: fill[:10] + fill[11:],
    "one twice": lambda fill: [*fill, fill[3]],
    "one between": lambda fill: [*fill, moved(fill[3], (12, 12.0), (60, 12.0))],
    "one longer": lambda fill: [moved(fill[0], (10.5, 10.5), (69.9, 10.5)), *fill[1:]],
    "one shorter": lambda fill: [moved(fill[0], (10.5, 10.5), (68, 10.5)), *fill[1:]],
    "one slanted": lambda fill: [moved(fill[0], (10.5, 10.5), (69.5, 10.6)), *fill[1:]],
    "none": lambda fill: [],
}  # fmt: skip


def moved(line: Contour, a: tuple[float, float], b: tuple[float, float]) -> Contour:
    return replace(line, curves=lines(a, b, closed=False))


@pytest.mark.parametrize("outline", [True, False])
@pytest.mark.parametrize("fault", WRONG)
def test_a_hatch_that_is_wrong_is_found_by_polygons(fault: str, outline: bool) -> None:
    """The lines of a wrong hatch, planned and programmed as they are."""
    machine = asked(outline=outline)
    assert machine.torch is not None
    whole = hatched(PART, machine.torch)
    own, fill = whole.features[:3], list(whole.features[3:])
    wrong = replace(whole, features=(*own, *WRONG[fault](fill)))  # type: ignore[arg-type]
    assert not _hatch_codes(whole, machine)
    assert _hatch_codes(wrong, machine) == {"verify-sheet-hatch"}


def _hatch_codes(part: Part, machine: Machine) -> set[str]:
    assert machine.torch is not None
    need = need_of(part, machine, machine.torch, ())
    return {one.code for one in hatch_faults(need, machine.torch, "t")}


@settings(max_examples=examples(25), deadline=None)
@given(
    distance=st.floats(0.3, 6), angle=st.floats(-180, 180), outline=st.booleans(),
    size=st.floats(3, 60), hole=st.floats(1, 30),
    name=st.sampled_from(["laser-grbl", "plate-codesys"]),
)  # fmt: skip
@example(0.3, 11.25, False, 3.0, 1.0, "laser-grbl")  # a line grazes the hole
def test_whatever_is_hatched_is_found_right(
    distance: float, angle: float, outline: bool, size: float, hole: float, name: str
) -> None:
    """A rounded shape with holes in it, and one beside it."""
    part = drawing(
        contour(box(0, 0, 90, 70)), contour(circle(40, 35, size), BLACK),
        contour(circle(41, 34, hole), BLACK, line=2), contour(box(2, 2, 4, 4), BLACK, line=3),
        thickness=3.0,
    )  # fmt: skip
    machine = asked(load_machine(name), distance, angle, outline=outline)
    if name == "plate-codesys":
        machine = with_torch(machine, {"black": "mark"}, settings=machine.torch.settings)  # type: ignore[union-attr]
    assert post((part,), machine).plan.operations


def test_what_cannot_be_filled_is_refused() -> None:
    loose = drawing(
        contour(box(0, 0, 80, 60)), contour(lines((5, 5), (9, 5), closed=False), BLACK),
        thickness=3.0,
    )  # fmt: skip
    with pytest.raises(PlanError, match=r"plan-map-hatch.*no closed contour"):
        post((loose,), asked())
    with pytest.raises(PlanError, match=r"plan-map-hatch.*what is cut out"):
        post((PART,), with_torch(asked(), {"black": "cut"}, settings={
            "black": LayerSettings(hatch=1.0)
        }))  # fmt: skip


def test_a_stepper_table_fills_too() -> None:
    assert post((PART,), asked(load_machine("laser-stepper"), 5.0)).plan.operations


def test_tabs_of_inner_contours() -> None:
    part = drawing(contour(box(0, 0, 80, 60)), contour(circle(30, 30, 20)), thickness=3.0)
    outer = with_torch(GRBL, thickness=3.0, tabs=2)
    both = with_torch(outer, inner_tabs=True)
    assert post((part,), outer).text.count("M4") == 1 + 3
    assert post((part,), both).text.count("M4") == 3 + 3


def test_the_sign_of_the_page_is_marked_filled_and_cut(tmp_path: Path) -> None:
    program = str(tmp_path / "sign.nc")
    given = [
        str(SAMPLES / "svg" / "sign.svg"), "--config", str(SAMPLES / "svg" / "sign.toml"),
        "--machine", "laser-grbl",
    ]  # fmt: skip
    made = CliRunner().invoke(main, ["post", *given, "-o", program])
    assert made.exit_code == 0, made.stderr
    read = CliRunner().invoke(main, ["verify", program, "--against", *given])
    assert read.exit_code == 0, read.stderr
    text = Path(program).read_text()
    assert text.count("M4 S150 F2400") == 1
    assert text.count("M4 S900 F900") == 3 * 3 * 2  # contours, strokes between bridges, passes
    assert text.count("M4 S300 F3500") > 30
    assert text.rindex("F2400") < text.index("F3500") < text.rindex("F3500") < text.index("F900")
    assert list(faults(text)) == []


@pytest.mark.parametrize("angle", [0.0, 90.0, 180.0, -90.0, 45.0])
@pytest.mark.parametrize("turned", [0.0, 90.0])
def test_an_edge_may_lie_on_a_line_of_the_hatch(angle: float, turned: float) -> None:
    """A step and an island whose edges, and an outline whose far side, lie on lines 2 mm apart."""
    step = lines((0, 0), (31, 0), (31, 15), (20, 15), (20, 25), (0, 25))
    island = box(5, 5, 10, 10)
    part = drawing(
        contour(step, "#0000ff"), contour(island, "#0000ff", line=2), thickness=3.0
    )  # fmt: skip
    own = {"blue": LayerSettings(hatch=2.0, hatch_angle=angle)}
    machine = with_torch(load_machine("laser-grbl"), {"blue": "mark"}, settings=own, rotate=turned)
    assert post((part,), machine).text.count("M4") > 12
