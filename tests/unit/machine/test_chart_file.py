"""Cut charts of QtPlasmaC and SheetCam become rows of a machine's file."""

from pathlib import Path

import pytest

from beamcam.machine import load
from beamcam.machine.chart_file import chart_rows
from beamcam.machine.overlay import with_torch
from tests.conftest import SAMPLES
from tests.runs import call

QTPLASMAC = """#plasmac material file
#[MATERIAL_NUMBER_1]
#NAME               =
[MATERIAL_NUMBER_3]
NAME               = Mild Steel 6mm 45A
KERF_WIDTH         = 1.5
THC                = 1
PIERCE_HEIGHT      = 3.8
PIERCE_DELAY       = 0.5
CUT_HEIGHT         = 1.5
CUT_SPEED          = 2300
CUT_AMPS           = 45
CUT_VOLTS          = 120

[MATERIAL_NUMBER_7]
NAME               = Stainless 1/4 in 65A
KERF_WIDTH         = 1.7
PIERCE_HEIGHT      = 4
PIERCE_DELAY       = 0.7
CUT_HEIGHT         = 1.6
CUT_SPEED          = 1800
"""
SHEETCAM = r"""[Tool0]
Tool\ class=PlasmaTool
Tool\ number=2
Name=MS 3.5 mm 45A FineCut
Feed\ rate=4000
Kerf\ width=1.1
Pierce\ height=3.8
Pierce\ delay=0.2
Cut\ height=1.5
Preset\ current=40
Cut\ current=45
Preset\ volts=105
[Tool1]
Tool\ class=DrillTool
Name=drill 6 mm
[Custom]
Feed\ rate=9
"""


def test_materials_of_qtplasmac() -> None:
    rows, said = chart_rows(QTPLASMAC, "material.cfg")
    assert not said
    assert rows == [
        {"process": "cut", "material": "mild steel", "up_to": 6.0, "feed_mm_min": 2300.0,
         "kerf": 1.5, "pierce_height": 3.8, "pierce_s": 0.5, "cut_height": 1.5, "amps": 45.0,
         "volts": 120.0, "nozzle": "Mild Steel 6mm 45A", "number": 3},
        {"process": "cut", "material": "stainless steel", "up_to": 6.35, "feed_mm_min": 1800.0,
         "kerf": 1.7, "pierce_height": 4.0, "pierce_s": 0.7, "cut_height": 1.6, "amps": 65.0,
         "nozzle": "Stainless 1/4 in 65A", "number": 7},
    ]  # fmt: skip


def test_tools_of_sheetcam() -> None:
    rows, said = chart_rows(SHEETCAM, "shop.tools")
    assert not said
    (row,) = rows
    assert (row["material"], row["up_to"], row["amps"], row["volts"]) == (
        "mild steel", 3.5, 45.0, 105.0,
    )  # fmt: skip
    assert (row["feed_mm_min"], row["kerf"], row["pierce_s"]) == (4000.0, 1.1, 0.2)


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("Mild Steel 6mm 45A", "Mild Steel 45A", "'Mild Steel 45A' without a thickness"),
        ("Mild Steel 6mm 45A", "6mm 45A", "'6mm 45A' without a material"),
        ("CUT_SPEED          = 2300", "CUT_SPEED = fast", "'fast' for feed_mm_min"),
        ("CUT_SPEED          = 2300", "CUT_SPEED = 0", "without feed_mm_min"),
        ("CUT_SPEED          = 2300", "CUT_SPEED = nan", "nan for feed_mm_min"),
        ("PIERCE_DELAY       = 0.5\n", "", "without pierce_s"),
        ("Stainless 1/4 in 65A", "Mild 6 mm 45A", "two rows of mild steel up to 6 mm"),
    ],
)
def test_a_row_that_cannot_be_read_is_refused(old: str, new: str, found: str) -> None:
    assert old in QTPLASMAC
    _, said = chart_rows(QTPLASMAC.replace(old, new, 1), "material.cfg")
    assert [one.code for one in said] == ["machine-chart"]
    assert found in said[0].message
    assert said[0].source.file == "material.cfg"


@pytest.mark.parametrize("text", ["", "x = 1\n", SHEETCAM.replace("Plasma", "Router")])
def test_a_file_without_rows_is_refused(text: str) -> None:
    rows, said = chart_rows(text, "a.txt")
    assert rows == []
    assert "found no row to cut" in said[0].message


def test_new_writes_the_rows_of_a_chart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "material.cfg").write_text(QTPLASMAC)
    call(
        "machines", "new", "mine", "--base", "plate-qtplasmac", "--chart", "material.cfg", status=0
    )
    torch = load(str(tmp_path / "machines" / "mine.toml")).torch
    assert torch is not None
    assert [(row.process, row.material, row.up_to) for row in torch.rows] == [
        ("cut", "mild steel", 6.0), ("cut", "stainless steel", 6.35), ("mark", "*", 32.0),
    ]  # fmt: skip
    sample = str(SAMPLES / "dstv" / "gusset.nc1")
    posted = call("post", sample, "--machine", "mine", "-o", "-", status=0)
    assert "fr=2300" in posted.stdout


def test_a_chart_that_cannot_be_read_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.cfg").write_text(QTPLASMAC.replace("6mm", ""))
    done = call(
        "machines", "new", "mine", "--base", "plate-qtplasmac", "--chart", "bad.cfg", status=1
    )
    assert "bad.cfg:4: error machine-chart: found the row 'Mild Steel  45A'" in done.stderr
    assert not (tmp_path / "machines").exists()
    (tmp_path / "material.cfg").write_text(QTPLASMAC)
    done = call(
        "machines", "new", "mine", "--base", "beamline", "--chart", "material.cfg", status=2
    )
    assert "beamline has no torch" in done.stderr


def test_amperes_choose_among_the_rows(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    row = "{{process = 'cut', up_to = {}, feed_mm_min = {}, amps = {}, nozzle = '{}', kerf = 1.5}}"
    rows = [row.format(6, 2300, 45, "air"), row.format(6, 3900, 65, "air"),
            row.format(6, 3500, 65, "O2")]  # fmt: skip
    rows.append("{process = 'mark', up_to = 10, feed_mm_min = 3000}")
    path.write_text(f'base = "plate-linuxcnc"\n[torch]\nrows = [{", ".join(rows)}]\n')
    sample = str(SAMPLES / "dstv" / "gusset.nc1")
    for words, feed in (
        ((), "F2300"), (("--amps", "65"), "F3900"), (("--nozzle", "o2"), "F3500"),
        (("--amps", "65", "--nozzle", "O2"), "F3500"),
    ):  # fmt: skip
        done = call("post", sample, "--machine", path, "-o", "-", *words, status=0)
        assert f"\n{feed}\n" in done.stdout
    done = call("post", sample, "--machine", path, "-o", "-", "--amps", "85", status=1)
    assert "85 A; the rows of mine are for 45 A air, 65 A O2, 65 A air" in done.stderr


def test_rows_of_another_current_are_not_there() -> None:
    machine = with_torch(load("plate-qtplasmac"), amps=130.0)
    assert machine.torch is not None
    cuts = [row for row in machine.torch.rows if row.process == "cut"]
    assert {row.amps for row in cuts} == {130.0}
    with pytest.raises(ValueError, match="no torch"):
        with_torch(load("beamline"), amps=45.0)
