"""Units of several trigger programs in one folder, and sheets whose thickness is said twice."""

import json
import shutil
from pathlib import Path

import pytest

from beamcam.machine.torch import MILD_STEEL, material_of
from tests.conftest import SAMPLES
from tests.runs import call

CAM = SAMPLES / "json" / "cam.json"


def run(*args: object) -> tuple[int, str]:
    done = call(*args)
    return done.exit_code, done.output


def test_units_of_two_jobs_lie_beside_each_other_and_are_known_again(tmp_path: Path) -> None:
    golden, samples = tmp_path / "table-simotion", tmp_path / "samples"
    golden.mkdir()
    samples.mkdir()
    for name in ("one", "two"):
        shutil.copy(CAM, samples / f"{name}.json")
        how = ("--machine", "table-simotion", "--style", "table")
        assert run("post", samples / f"{name}.json", "-o", tmp_path / f"{name}.st", *how)[0] == 0
    units = sorted(p.name for p in tmp_path.glob("*.st"))
    assert units == ["one.st", "two.st", "unit_one_1.st", "unit_two_1.st"]
    assert (tmp_path / "one.st").read_text().startswith("(* ===== UNIT unit_one =")
    how = ("--machine", "table-simotion")
    assert run("post", samples / "one.json", "-o", golden / "one.st", *how)[0] == 0
    code, said = run("check", golden, "--samples", samples)
    assert code == 0, said
    assert "1 of 1" in said


def test_a_name_that_is_given_is_kept(tmp_path: Path) -> None:
    how = ("--machine", "table-simotion", "--job", "K7")
    assert run("post", CAM, "-o", tmp_path / "a.st", *how)[0] == 0
    assert "UNIT unit_K7 =" in (tmp_path / "a.st").read_text()


@pytest.mark.parametrize(
    ("source", "how", "said"),
    [
        ("json/cam.json", "--thickness 9", "found --thickness 9; expected 6, as the part"),
        ("dxf/plate.dxf", "--thickness 0", "found a sheet of 0 mm mild steel to cut; expected"),
        ("dxf/plate.dxf", "--thickness -2", "above 0 and at most 32 mm of mild steel"),
    ],
)
def test_thicknesses_that_cannot_be(source: str, how: str, said: str, tmp_path: Path) -> None:
    code, output = run("post", SAMPLES / source, "-o", tmp_path / "a.ngc", *how.split())
    assert code == 1
    assert said in output
    assert not (tmp_path / "a.ngc").exists()


@pytest.mark.parametrize(
    ("grade", "material", "denied"),
    [
        ("S235JR", "mild steel", False), ("S355J2+N", "Steel", False), ("St37-2", "steel", False),
        ("A36", "mild steel", False), ("acrylic", "Acrylic", False), ("", "wood", False),
        ("S235JR", "aluminium", True), ("S235JR", "stainless", True), ("wood", "acrylic", True),
        ("1.4301", "mild steel", True), ("AW-5754", "steel", True), ("acrylic", "acryl", True),
    ],
)  # fmt: skip
def test_a_material_that_the_part_denies(
    grade: str, material: str, denied: bool, tmp_path: Path
) -> None:
    part = json.loads(CAM.read_text())
    part["grade"] = grade
    (tmp_path / "a.json").write_text(json.dumps(part))
    code, said = run("plan", tmp_path / "a.json", "--machine", "plate-linuxcnc", "--lead", "none",
                     "--material", material)  # fmt: skip
    expected = f"found --material {material}; expected {grade}, as the part itself says"
    assert (expected in said) is denied
    is_steel = material_of(material) == MILD_STEEL  # the only one that the table has a row for
    assert (code == 1) is (denied or not is_steel), said


def test_a_material_of_a_configuration_denies_nothing(tmp_path: Path) -> None:
    """It is meant for the drawings among the parts of a folder, which say none."""
    (tmp_path / "beamcam.toml").write_text('[sheet]\nmaterial = "wood"\n')
    part = json.loads(CAM.read_text()) | {"grade": "acrylic"}
    (tmp_path / "a.json").write_text(json.dumps(part))
    code, said = run("plan", tmp_path / "a.json", "--machine", "laser-grbl", "--config",
                     tmp_path / "beamcam.toml")  # fmt: skip
    assert "--material" not in said
    assert code == 0, said
