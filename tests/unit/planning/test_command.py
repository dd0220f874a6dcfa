"""`beamcam plan`: what it prints as text and as data."""

import json
from pathlib import Path

import pytest

from tests.runs import call

PART = """ST
  A
  D
  1
  B1
  S235JR
  1
  IPE300
  I
  3000.00
  300.00
  150.00
  10.70
  7.10
  15.00
  42.2
  1.16
  0.000
  {end}
  0.000
  0.000





BO
  v 500.00u 100.00 18.00
  v 500.00u 200.00 18.00
  o 900.00s 40.00 14.00
  u 900.00s 40.00 14.00
  o 1200.00s 40.00 14.00
  u 1200.50s 40.00 14.00
EN
"""


@pytest.fixture
def path(tmp_path: Path) -> str:
    file = tmp_path / "b1.nc1"
    file.write_text(PART.format(end="0.000"))
    return str(file)


def run(*words: str) -> tuple[int, str, str]:
    found = call("plan", *words)
    return found.exit_code, found.stdout, found.stderr


def test_every_operation_has_its_line(path: str) -> None:
    status, text, said = run(path)
    assert (status, said) == (0, "")
    lines = text.splitlines()
    assert lines[0].startswith("machine beamline: ")
    assert lines[1] == (
        "bar 3024.040 = front trim 20.000 + parts 3000.000 + kerfs 4.040 - nested 0.000 "
        "+ remnant 0.000 + end trim 0.000"
    )
    assert lines[2] == "part 1: B1 from 20.000 to 3020.000, as given"
    assert "tool web station 1: drill 18" in lines
    steps = [line.split() for line in lines if line.strip()[:1].isdigit() and " X " in line]
    assert [step[0] for step in steps] == [str(n) for n in range(1, len(steps) + 1)]
    assert [float(step[2]) for step in steps] == sorted(float(step[2]) for step in steps)
    assert "merge-pair" in text
    assert "not both flanges at once" in text
    assert "x 1200 and 1200.5" in text
    assert lines[-1].startswith("7 operations, ")


def test_the_same_as_data(path: str) -> None:
    status, text, _ = run(path, "--json", "--machine", "beamline-pusher", "--bar", "6000")
    assert status == 0
    record = json.loads(text)
    bar = record["bar"]
    total = sum(bar[k] for k in ("front_trim", "parts", "kerfs", "rest", "end_trim"))
    assert total - bar["nested"] == pytest.approx(bar["length"], abs=1e-3)
    assert [f["how"] for f in record["features"]] == ["made"] * 3 + ["merged"] + ["made"] * 2
    assert record["time"]["total_s"] == pytest.approx(
        sum(op["seconds"] for op in record["operations"]), abs=0.01
    )
    assert record["operations"][0]["reasons"]["drill-exact"] == "a drill of exactly the diameter"
    assert record["messages"][0]["code"] == "plan-remnant"
    assert record["travel"]["back"] == 0
    assert record["turns"] == []


def test_the_eight_ways_are_listed(tmp_path: Path) -> None:
    file = tmp_path / "skew.nc1"
    file.write_text(PART.format(end="-50.000"))
    status, text, said = run(str(file), "--machine", "beamline", "--turn", "--order", "best")
    assert status == 0
    assert text.count("  B1 ") == 8
    assert "plan-saw-angle" in text
    assert "note plan-turned" in said
    refused, nothing, why = run(str(file), "--machine", "beamline")
    assert (refused, nothing) == (1, "")
    assert "error plan-saw-angle" in why
    assert "note plan-turn-helps" in why


def test_what_is_left_out_is_listed(tmp_path: Path) -> None:
    file = tmp_path / "big.nc1"
    file.write_text(PART.format(end="0.000").replace("100.00 18.00", "100.00 88.00"))
    words = (str(file), "--machine", "beamline")
    status, text, _ = run(*words, "--allow-skips", "tool", "-o", str(tmp_path / "plan.txt"))
    assert (status, text) == (0, "")
    written = (tmp_path / "plan.txt").read_text()
    assert f"left out: {file}:" in written
    assert "(plan-tool)" in written
    assert run(*words)[0] == 1


def test_tools_to_change_are_listed(tmp_path: Path) -> None:
    rows = "\n".join(f"  v {550 + 100 * i}.00u 100.00 {12 + i}.00" for i in range(7))
    file = tmp_path / "many.nc1"
    file.write_text(PART.format(end="0.000").replace("EN\n", f"BO\n{rows}\nEN\n"))
    status, text, said = run(str(file))
    assert status == 0
    assert text.count("change before step") == 2
    assert "warning plan-reload" in said


def test_a_machine_without_a_saw_is_refused(path: str, tmp_path: Path) -> None:
    file = tmp_path / "saw.toml"
    file.write_text(
        'title = "t"\ncontroller = "codesys"\nstock = "beam"\n[format]\n[words]\n'
        '[layout]\norder = "saw-drill"\n'
    )
    status, _, said = run(path, "--machine", str(file))
    assert status == 1
    assert "error machine-missing" in said
    assert "saw" in said


CAM = str(Path(__file__).resolve().parents[3] / "samples" / "json" / "cam.json")


def test_a_sheet_has_a_line_for_each_contour() -> None:
    status, out, _ = run(CAM, "--machine", "plate-linuxcnc")
    assert status == 0
    lines = out.splitlines()
    assert lines[0] == "machine plate-linuxcnc: plasma table on LinuxCNC"
    assert lines[1].startswith("sheet CAM 110.000 x 100.000 x 6, its x 0, y 0 at X 8.000 Y ")
    assert [line.split()[5] for line in lines[2:5]] == ["mark", "cut", "cut"]
    assert lines[2].endswith("cam.json:contours[2]")
    assert lines[-1].startswith("3 contours, ")
    seconds = [float(line.split(" s  ")[0].split()[-1]) for line in lines[2:5]]
    assert sum(seconds) == pytest.approx(float(lines[-1].split()[-2]), abs=1.0)


def test_a_sheet_as_data() -> None:
    status, out, _ = run(CAM, "--machine", "plate-codesys", "--json")
    assert status == 0
    record = json.loads(out)
    assert [o["process"] for o in record["operations"]] == ["mark", "cut", "cut"]
    assert record["sheet"]["thickness"] == 6
    total = sum(o["seconds"] for o in record["operations"]) + record["time"]["home_s"]
    assert record["time"]["total_s"] == pytest.approx(total, abs=0.01)
    assert [f["how"] for f in record["features"]] == ["made"] * 3
    thin = json.loads(run(CAM, "--machine", "plate-codesys", "--json", "--tabs", "2")[1])
    assert thin["operations"][-1]["passes"] > 1
    assert thin["time"]["total_s"] > record["time"]["total_s"]


def test_what_is_left_out_of_a_sheet_is_said(tmp_path: Path) -> None:
    plate, mine = CAM.replace("json/cam.json", "dstv/plate.nc1"), tmp_path / "mine.toml"
    policies = "[torch]\nbevel = 'refuse'\ndrilled = 'refuse'\n"
    mine.write_text(f"base = 'plate-codesys'\n{policies}")
    skips = [word for name in ("bevel", "tool", "mark") for word in ("--allow-skips", name)]
    status, out, said = run(plate, "--machine", str(mine), *skips)
    assert status == 0
    assert "left out: " in out
    assert run(plate, "--machine", str(mine))[0] == 1
    assert run(plate, "--machine", str(mine), "--strict", *skips)[0] == 1
    assert "warning" in said
