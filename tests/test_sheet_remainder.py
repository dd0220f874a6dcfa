"""The rest of a sheet's program after a stop: it makes what is left, and says so."""

import re
from functools import cache
from pathlib import Path

import pytest

from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.plan import SheetPlan
from beamcam.pipeline import Posted, post
from beamcam.remainder import faults_of_sheet_rest, rest_of_sheet
from tests.conftest import SAMPLES, sampled
from tests.runs import call
from tests.unit.sheets.parts import box, circle, contour, drawing, lines

GASKET = SAMPLES / "dxf" / "gasket-inch.dxf"
TABLES = ("plate-linuxcnc", "plate-oxyfuel", "plate-codesys", "laser-grbl")
PART = drawing(
    contour(lines((20, 20), (60, 20), closed=False), colour="#0000ff"),
    contour(box(0, 0, 120, 80), line=2), contour(circle(40, 40, 20), line=3),
    contour(box(140, 0, 60, 60), line=4), contour(circle(90, 40, 30), line=5), thickness=3.0,
)  # fmt: skip
FIRST_CUT = 2  #: the line to mark is contour 1


def whole(name: str = "plate-linuxcnc", **torch: object) -> Posted:
    return post((PART,), with_torch(load(name), thickness=3.0, **torch))  # type: ignore[arg-type]


@cache
def plain() -> Posted:
    return whole()


def blocks(text: str) -> list[str]:
    """The blocks of a program without their numbers and comments."""
    found = (re.sub(r"^N\d+ ", "", line) for line in text.splitlines())
    return [line for line in found if line and not line.startswith(("(", "%"))]


@pytest.mark.parametrize("torch", [{}, {"tabs": 2}, {"overcut": 1.0}], ids=str)
@pytest.mark.parametrize("name", sampled(TABLES, 2))
def test_each_rest_is_the_end_of_the_whole(name: str, torch: dict[str, object]) -> None:
    posted = whole(name, **torch)
    assert isinstance(posted.plan, SheetPlan)
    count = len(posted.plan.operations)
    every, head = blocks(posted.text), len(blocks("\n".join(load(name).words.header)))
    for first in range(FIRST_CUT, count + 1):
        text = rest_of_sheet(posted, first).text
        rest = blocks(text)[head:]
        assert rest == every[-len(rest) :]
        x, y = posted.plan.operations[first - 1].start
        assert [float(v) for v in re.findall(r"[XY](-?[\d.]+)", rest[0])] == pytest.approx(
            [x, y], abs=0.001
        )
        assert f"REST FROM CONTOUR {first} OF {count}." in text
        assert "1 OF THEM ARE MARKS" in text
        assert len(re.findall(r"^\(.*FREE OF THE SHEET", text, re.M)) == 1
        assert not faults_of_sheet_rest(text, posted.text, first, posted.job)


WRONG = [
    ("a stroke too few", lambda t: re.sub(r"G0 X\S+ Y\S+\nM3 S1\n(?:.*\n)*?M5\n", "", t, count=1)),
    ("elsewhere", lambda t: t.replace("G1 X", "G1 X1", 1)),
    ("another feed", lambda t: t.replace("F5200", "F5100", 1)),
    ("not said", lambda t: t.replace("REST FROM CONTOUR 4", "REST FROM CONTOUR 3")),
    ("a mark again", lambda t: t.replace(
        "M5\nG0 X0 Y0", "M5\nG0 X20 Y20\nM3 $1 S1\nF3000\nG1 X60 Y20\nM5 $1\nG0 X0 Y0")),
    ("tool left on", lambda t: t.replace("M5\nG0 X0 Y0", "G0 X0 Y0")),
    ("other units", lambda t: t.replace("G21", "G20")),
]  # fmt: skip


@pytest.mark.parametrize(("what", "change"), WRONG, ids=[what for what, _ in WRONG])
def test_another_rest_is_refused(what: str, change) -> None:  # type: ignore[no-untyped-def]
    posted = plain()
    rest = rest_of_sheet(posted, 4).text
    wrong = change(rest)
    assert wrong != rest
    assert faults_of_sheet_rest(wrong, posted.text, 4, posted.job), what


@pytest.mark.parametrize("first", [3, 5])
def test_the_rest_of_another_contour_is_refused(first: int) -> None:
    posted = whole()
    rest = rest_of_sheet(posted, 4).text
    (said,) = faults_of_sheet_rest(rest, posted.text, first, posted.job)
    assert said.code == "verify-sheet-rest"
    (said,) = faults_of_sheet_rest(rest, posted.text, 99, posted.job)
    assert said.code == "verify-sheet-contour"


def test_a_whole_that_does_not_make_the_part_is_told_of() -> None:
    posted = whole()
    rest = rest_of_sheet(posted, 4).text
    spoilt = posted.text.replace("F3000", "F300")
    codes = {d.code for d in faults_of_sheet_rest(rest, spoilt, 4, posted.job)}
    assert codes == {"verify-sheet-feed"}


@pytest.mark.parametrize("first", [1, 6, 99])
def test_a_rest_begins_with_a_contour_to_cut(first: int) -> None:
    with pytest.raises(PlanError, match="plan-contour"):
        rest_of_sheet(whole(), first)


def test_parts_that_are_free_are_named() -> None:
    from beamcam.readers import read

    path = SAMPLES / "dstv" / "gusset.nc1"
    parts = read(path.read_bytes(), path.name).parts * 2
    posted = post(parts, load("plate-linuxcnc"))
    assert isinstance(posted.plan, SheetPlan)
    last = len(posted.plan.operations)
    assert f"FREE OF THE SHEET: {parts[0].mark})" in rest_of_sheet(posted, last).text


def test_on_the_command_line(tmp_path: Path) -> None:
    rest, all_of_it = tmp_path / "rest.ngc", tmp_path / "whole.ngc"
    asked = ("--thickness", 3, "--machine", "plate-linuxcnc")
    assert call("post", GASKET, *asked, "-o", all_of_it).exit_code == 0
    assert call("post", GASKET, *asked, "--from-contour", 4, "-o", rest).exit_code == 0
    against = ("--against", GASKET, "--thickness", 3)
    for after in ((), ("--after", all_of_it)):
        assert call("verify", rest, "--from-contour", 4, *after, *against).exit_code == 0
        assert call("verify", rest, "--from-contour", 3, *after, *against).exit_code == 1
    assert call("verify", rest, *against).exit_code == 1
    done = call("post", GASKET, *asked, "--from-contour", 40, "-o", tmp_path / "x.ngc")
    assert "error plan-contour" in done.stderr


@pytest.mark.parametrize("words", [
    ("post", SAMPLES / "dstv" / "channel.nc1", "--from-contour", 2, "-o", "-"),
    ("post", GASKET, "--machine", "laser-stepper", "--map", "*=cut", "--thickness", 2,
     "--from-contour", 2, "-o", "a.steps"),
    ("post", GASKET, "--thickness", 3, "--from-contour", 2, "--from-operation", 2, "-o", "-"),
    ("verify", GASKET, "--from-contour", 2),
    ("verify", GASKET, "--from-contour", 2, "--from-operation", 2, "--against", GASKET),
])  # fmt: skip
def test_what_has_no_contours_is_told(words: tuple[object, ...]) -> None:
    done = call(*words, status=2)
    assert "--from-contour" in done.stderr
