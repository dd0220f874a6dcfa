"""Hatches: filled inside their contours only, read back by polygons; tabs in inner contours."""

import re
from pathlib import Path

import pytest
import shapely
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.cli import main
from beamcam.errors import PlanError
from beamcam.machine import Machine
from beamcam.machine import load as load_machine
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import LookSettings
from beamcam.model.hatch import hatched
from beamcam.pipeline import post, read_back
from beamcam.posts import Request
from beamcam.verify.sheets import verify_sheet
from tests.conftest import SAMPLES
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


def asked(machine: Machine = GRBL, distance: float = 1.0, angle: float = 0.0) -> Machine:
    own = {"black": LookSettings(hatch=distance, hatch_angle=angle)}
    return with_torch(machine, {"black": "engrave"}, settings=own, thickness=3.0)


@settings(max_examples=12, deadline=None)
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


def test_a_line_less_or_elsewhere_is_refused() -> None:
    machine = asked()
    text = post((PART,), machine).text
    first = STROKE.search(text)
    assert first is not None
    for other in ("", first[0].replace(f"X{first[3]}", f"X{float(first[3]) + 3:g}")):
        said = read_back(text.replace(first[0], other, 1), Request((PART,), machine))
        assert {one.code for one in said} & {"verify-sheet-missing", "verify-sheet-extra"}


@pytest.mark.parametrize("fault", ["outside", "empty"])
def test_a_hatch_that_is_wrong_is_found_by_polygons(fault: str) -> None:
    """The lines of a wrong hatch, planned and programmed as they are."""
    machine = asked()
    assert machine.torch is not None
    whole = hatched(PART, machine.torch)
    own, fill = whole.features[:3], whole.features[3:]
    if fault == "outside":
        line = replace(fill[0], curves=lines((5, 5), (50, 5), closed=False))  # type: ignore[call-arg]
        fill = (line, *fill)
    else:
        fill = fill[:10] + fill[20:]
    wrong = replace(whole, features=(*own, *fill))
    plain = with_torch(machine, {"black": "engrave"})
    text = post((wrong,), plain).text
    codes = {one.code for one in verify_sheet(text, (wrong,), machine)}
    assert codes == {"verify-sheet-hatch"}


def test_what_cannot_be_filled_is_refused() -> None:
    loose = drawing(
        contour(box(0, 0, 80, 60)), contour(lines((5, 5), (9, 5), closed=False), BLACK),
        thickness=3.0,
    )  # fmt: skip
    with pytest.raises(PlanError, match=r"plan-map-hatch.*no closed contour"):
        post((loose,), asked())
    with pytest.raises(PlanError, match=r"plan-map-hatch.*what is cut out"):
        post((PART,), with_torch(asked(), {"black": "cut"}, settings={
            "black": LookSettings(hatch=1.0)
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
