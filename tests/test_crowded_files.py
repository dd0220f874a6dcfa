"""Files that say the same a thousand times, or what no machine can do: each command ends."""

import json
import re
from pathlib import Path

import pytest

from tests.conftest import SAMPLES, sampled
from tests.runs import call


def crowded(name: str, block: str, times: int) -> str:
    """A sample whose last block of that name is there many times."""
    text = (SAMPLES / "dstv" / f"{name}.nc1").read_text()
    found = re.findall(rf"(?ms)^{block}$.*?(?=^[A-Z][A-Z]$)", text)[-1]
    return text.replace("EN\n", found * times + "EN\n")


@pytest.mark.parametrize(
    ("name", "block"), sampled([("gusset", "BO"), ("beam", "BO"), ("channel", "AK")], 2)
)
def test_what_is_there_many_times_weighs_as_once(tmp_path: Path, name: str, block: str) -> None:
    one, many = tmp_path / "one.nc1", tmp_path / "many.nc1"
    one.write_text(crowded(name, block, 1))
    many.write_text(crowded(name, block, 100))
    rows = [
        json.loads(call("list", path, "--to", "json").stdout)["part_list"][0]
        for path in (one, many)
    ]
    assert rows[0]["weight_kg"] == pytest.approx(rows[1]["weight_kg"])
    assert call("plot", many, "-o", tmp_path / "p.svg").exit_code == 0
    # A letter stands at each hole once, however many holes are there.
    texts = [(tmp_path / "p.svg").read_text().count("figure letter")]
    call("plot", one, "-o", tmp_path / "p.svg")
    assert texts == [(tmp_path / "p.svg").read_text().count("figure letter")]


def test_a_feature_beyond_all_measure_is_drawn(tmp_path: Path) -> None:
    text = (SAMPLES / "dstv" / "channel.nc1").read_text()
    path = tmp_path / "far.nc1"
    path.write_text(re.sub(r"(?m)^(  v +\S+ +\S+ +)\S+", r"\g<1>9e8", text, count=1))
    assert call("plot", path, "-o", tmp_path / "p.svg").exit_code in (0, 1)


@pytest.mark.parametrize("feed", ["F-2.5", "F0", "F1e999"])
def test_a_feed_at_which_nothing_moves_is_none(tmp_path: Path, feed: str) -> None:
    """The read-back refuses it; a trace takes the feed of the tool's data, as without one."""
    program = tmp_path / "a.gcode"
    call("post", SAMPLES / "dstv" / "channel.nc1", "-o", program)
    text = program.read_text()
    wrong = re.sub(r"F[\d.]+", feed, text, count=1)
    program.write_text(wrong)
    assert call("verify", program).exit_code == 1
    for name in ("t.csv", "t.json"):
        call("simulate", program, "-o", tmp_path / name)
    call("report", program, "-o", tmp_path / "r.html")


def test_a_path_that_runs_round_many_times(tmp_path: Path) -> None:
    """A ring 300 times, each a little aside: an area of it would take gigabytes."""
    program = tmp_path / "a.ngc"
    plate = SAMPLES / "dstv" / "gusset.nc1"
    call("post", plate, "--machine", "plate-linuxcnc", "-o", program)
    lines = program.read_text().splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if line.startswith(("G2 ", "G3 ")))
    turn = "G3 X{x:.3f} Y60 I10 J0.01\n"
    spiral = [turn.format(x=100 + 0.001 * k) for k in range(300)]
    program.write_text("".join([*lines[:at], "G1 X100 Y60\n", *spiral, *lines[at:]]))
    assert call("verify", program, "--against", plate).exit_code == 1
    assert call("report", program, "-o", tmp_path / "r.html").exit_code in (0, 1)


def test_a_stroke_that_is_there_many_times_is_machined_once(tmp_path: Path) -> None:
    program, part = tmp_path / "a.gcode", SAMPLES / "dstv" / "channel.nc1"
    call("post", part, "-o", program)
    lines = program.read_text().splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if "G01" in line)
    stroke = [re.sub(r"^N\d+ ", "", line) for line in lines[at : at + 2]]
    program.write_text("".join([*lines[: at + 2], *stroke * 300, *lines[at + 2 :]]))
    call("report", program, part, "-o", tmp_path / "r.html")
    assert "solid" in (tmp_path / "r.html").read_text()


def test_a_picture_of_no_part_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "none.ifc"
    text = (SAMPLES / "ifc" / "beam_openings.ifc").read_text()
    path.write_text(re.sub(r"IFC(BEAM|COLUMN|MEMBER|PLATE)\(", "IFCFURNITURE(", text))
    done = call("plot", path, "-o", tmp_path / "p.pdf")
    assert done.exit_code != 0
    assert not (tmp_path / "p.pdf").exists()
