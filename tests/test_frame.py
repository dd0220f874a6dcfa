"""The frame of a job: once round all of its work, slowly, the tool off."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.checks.sheets.remainder import frame_faults
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch_faults import torch_faults
from beamcam.pipeline import Posted, post
from beamcam.remainder import frame_of
from tests.conftest import SAMPLES, examples
from tests.runs import call
from tests.unit.sheets.parts import box, circle, contour, drawing

GASKET = SAMPLES / "dxf" / "gasket-inch.dxf"
TABLES = (
    "plate-linuxcnc", "plate-oxyfuel", "plate-codesys", "laser-grbl", "plate-qtplasmac",
    "plate-mach3",
)  # fmt: skip
ON = re.compile(r"\bM0?[346]\b|\bM1[0-9]\b")


def whole(name: str = "plate-linuxcnc", width: float = 120.0, **torch: object) -> Posted:
    part = drawing(
        contour(box(5, 7, width, 80)), contour(circle(50, 40, 20), line=2), thickness=3.0
    )
    return post((part,), with_torch(load(name), thickness=3.0, **torch))  # type: ignore[arg-type]


def places(text: str) -> list[tuple[float, float]]:
    found = re.findall(r"G0?[0123] X(-?[\d.]+) Y(-?[\d.]+)", text)
    return [(float(x), float(y)) for x, y in found]


@pytest.mark.parametrize("name", TABLES)
@settings(max_examples=examples(10), deadline=None)
@given(width=st.floats(70, 900), origin=st.sampled_from(["table", "centre", "lower-left"]))
def test_it_goes_round_all_that_the_tool_does(name: str, width: float, origin: str) -> None:
    """Every place of the job lies in the frame, which is no larger; nothing is switched on."""
    posted = whole(name, width, origin=origin)
    text = frame_of(posted).text
    assert not ON.search(re.sub(r"\(.*\)", "", text))
    frame, job = places(text), places(posted.text)[:-1]  # the last goes home
    corners = frame[:-1] if frame[-1] == (0.0, 0.0) else frame
    (x0, y0), (x1, y1) = min(corners), max(corners)
    assert corners[:5] == [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]
    assert min(x for x, _ in job) == pytest.approx(x0, abs=0.02)
    assert max(x for x, _ in job) == pytest.approx(x1, abs=0.02)
    assert min(y for _, y in job) == pytest.approx(y0, abs=0.02)
    assert max(y for _, y in job) == pytest.approx(y1, abs=0.02)
    assert "(FRAME OF THE JOB, THE TOOL OFF)" in text


WRONG: list[tuple[str, Callable[[str], str]]] = [
    ("tool on", lambda t: t.replace("F6000", "M3 S1\nF6000")),
    ("smaller", lambda t: t.replace("G1 X130.6 Y92.5099", "G1 X120.6 Y92.5099")),
    ("corner left out", lambda t: t.replace("G1 X130.6 Y92.5099\n", "")),
    ("another order", lambda t: re.sub(r"(G1 .*\n)(G1 .*\n)", r"\2\1", t, count=1)),
    ("fast", lambda t: t.replace("F6000", "F9000")),
    ("rapid", lambda t: t.replace("G1 ", "G0 ")),
    ("not said", lambda t: t.replace("FRAME OF THE JOB", "JOB")),
]  # fmt: skip


@pytest.mark.parametrize(("what", "change"), WRONG, ids=[what for what, _ in WRONG])
def test_another_frame_is_refused(what: str, change: Callable[[str], str]) -> None:
    posted = whole()
    text = frame_of(posted).text
    wrong = change(text)
    assert wrong != text
    machine = posted.job.machine
    assert not frame_faults(text, posted.text, machine)
    codes = {d.code for d in frame_faults(wrong, posted.text, machine)}
    assert codes == {"verify-sheet-frame"}, what


def test_on_the_command_line(tmp_path: Path) -> None:
    job, frame = tmp_path / "job.ngc", tmp_path / "frame.ngc"
    asked = ("post", GASKET, "--thickness", 3, "--machine", "plate-linuxcnc", "-o", job)
    assert call(*asked, "--frame", frame).exit_code == 0
    assert "FRAME" in frame.read_text()
    assert "FRAME" not in job.read_text()
    assert call(*asked, "--frame", job).exit_code == 2
    bar = SAMPLES / "dstv" / "channel.nc1"
    done = call("post", bar, "-o", tmp_path / "a.gcode", "--frame", frame, status=2)
    assert "--frame is for programs of sheets" in done.stderr


def low_powered(power: float = 10.0) -> Posted:
    return whole("laser-grbl", material="acrylic", laser_mode=True, frame_power=power)


def test_a_laser_may_show_its_spot() -> None:
    """M4 S10 round the work: below the 120 of the weakest row; grbl dims it where it is slow."""
    posted = low_powered()
    text = frame_of(posted).text
    assert isinstance(text, str)
    assert re.findall(r"S(\d+)", text) == ["10"]
    assert text.index("G0 X") < text.index("M4 S10 F6000") < text.index("G1 X")
    assert text.rindex("M5") > text.rindex("G1 X")
    assert "(FRAME OF THE JOB, AT LOW POWER)" in text
    machine = posted.job.machine
    for old, new in (("S10", "S120"), ("M4 S10 F6000", "M4 F6000"), ("AT LOW", "AT HIGH")):
        said = frame_faults(text.replace(old, new), posted.text, machine)
        assert "verify-sheet-frame" in {d.code for d in said}, new
    off = frame_of(whole("laser-grbl", material="acrylic", laser_mode=True)).text
    assert frame_faults(text, posted.text, with_torch(machine, frame_power=0.0))
    assert "M4" not in str(off)


def test_the_power_of_frames_marks_nothing() -> None:
    machine = load("laser-grbl")
    for power, mode in ((120.0, True), (10.0, False)):
        other = with_torch(machine, frame_power=power, laser_mode=mode)
        assert "torch.frame_power" in {key for key, _ in torch_faults(other)}
