"""`beamcam check` on what a batch wrote: what is missing, what has changed, what is accepted."""

import json
import shutil
from pathlib import Path

import pytest

from beamcam.batch.record import noted_in
from tests.conftest import SAMPLES
from tests.runs import BAD, batch, call, fill, part


def check(*words: object) -> tuple[int, str, str]:
    done = call("check", *words)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    # Its machine is a file of the test's folder.
    said = [line for line in done.stderr.splitlines(True) if "note machine-elsewhere: " not in line]
    return done.exit_code, done.stdout, "".join(said)


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three parts, a machine of their own, and the golden programs of both."""
    folder = tmp_path_factory.mktemp("shop")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        fill(folder / "in", 3)
        machine("780")
        assert batch("in", "-o", "golden", "--machine", "mine.toml").exit_code == 0
    return folder


@pytest.fixture
def shop(once: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(shutil.copytree(once, tmp_path, dirs_exist_ok=True))
    return tmp_path


def machine(drill_x: str, more: str = "") -> None:
    """Write the machine anew, with its drill at that X."""
    Path("mine.toml").write_text(f'base = "beamline"\n{more}\n[drill]\nx = {drill_x}\n')


def test_a_change_of_the_machine_is_one_line_and_update_accepts_it(shop: Path) -> None:
    machine("781.44")
    status, said, _ = check("golden")
    assert status == 1
    first, second = said.splitlines()
    assert first == "3 programs: all holes X +1.440 ({}, {}, {})".format(
        *(Path("golden", f"P00{k}.gcode") for k in range(3))
    )
    assert second == "0 of 3 programs are the same"
    status, said, _ = check("golden", "--update")
    assert status == 0
    assert said.splitlines()[-1] == "3 programs written"
    assert check("golden") == (0, "3 of 3 programs are the same\n", "")


def test_what_reads_the_same_is_one_line_too(shop: Path) -> None:
    machine("780", 'title = "renamed"')
    status, said, _ = check("golden")
    assert status == 1
    assert said.startswith("3 programs: another text that means the same (")


def test_a_missing_sample_is_one_line(shop: Path) -> None:
    Path("in", "P001.nc1").unlink()
    status, said, err = check("golden")
    assert (status, said) == (1, "2 of 3 programs are the same\n")
    assert err == (
        f"{Path('golden/P001.gcode')}: error check-sample: found no sample 'P001.nc1' for "
        "P001.gcode; expected one file of that name in samples, or --samples\n"
    )
    assert check("golden", "--update")[0] == 1  # there is nothing that could be accepted


def test_samples_that_were_moved(shop: Path) -> None:
    Path("elsewhere").mkdir()
    Path("in").rename("elsewhere/deep")
    assert check("golden")[0] == 1
    assert check("golden", "--samples", "elsewhere")[:2] == (0, "3 of 3 programs are the same\n")
    Path("elsewhere/twice").mkdir()
    Path("elsewhere/twice/P000.nc1").write_text(part("P0"))
    status, _, err = check("golden", "--samples", "elsewhere")
    assert status == 1
    assert "expected one file of that name in elsewhere (found elsewhere" in err.replace("\\", "/")


def test_programs_that_are_called_otherwise_now(shop: Path) -> None:
    machine("780", 'suffix = ".tap"')
    status, _, err = check("golden")
    assert status == 1
    assert err.count("error check-gone: found no program 'P00") == 3
    assert err.count("error check-new: found a new program 'P00") == 3
    check("golden", "--update")
    assert sorted(p.name for p in Path("golden").glob("P*")) == [f"P00{k}.tap" for k in range(3)]
    assert check("golden") == (0, "3 of 3 programs are the same\n", "")


def test_a_program_that_was_taken_away_is_written_again(shop: Path) -> None:
    Path("golden/P002.gcode").unlink()
    status, said, err = check("golden")
    assert status == 1
    assert f"{Path('golden/P002.gcode')}: not in the folder\n" in said
    assert "error check-new: found a new program 'P002.gcode'; expected it" in err
    assert check("golden", "--update")[0] == 0
    assert check("golden")[0] == 0


def test_a_part_that_is_refused_now(shop: Path) -> None:
    Path("in/P000.nc1").write_text(BAD)
    status, said, err = check("golden")
    assert (status, said) == (1, "2 of 3 programs are the same\n")
    assert "error plan-tool" in err
    data = json.loads(check("golden", "--json")[1])
    assert [r["result"] for r in data] == ["refused", "same", "same"]


def test_a_machine_that_is_gone_is_told_once(shop: Path) -> None:
    Path("mine.toml").unlink()
    status, _, err = check("golden")
    assert status == 1
    assert err.count("error machine-") == 1


def test_a_file_that_was_posted_in_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The programs of it are known to the record, though the file is done again each time."""
    monkeypatch.chdir(tmp_path)
    model = SAMPLES / "ifc" / "beam_openings.ifc"
    for _ in range(2):  # one member is longer than the bar
        assert batch(model, "-o", "golden", "--bar", 4000, "--each").exit_code == 1
    assert [n.outputs for n in noted_in("golden")] == [("beam_openings_D4.gcode",)]
    assert check("golden")[:2] == (0, "1 of 1 programs are the same\n")


def test_programs_of_which_nothing_is_known_are_named(shop: Path) -> None:
    Path("golden", "old").mkdir()
    Path("golden", "old", "one.gcode").write_text("%\n")
    status, said, err = check("golden")
    assert (status, said) == (1, "3 of 4 programs are the same\n")
    assert "golden: error check-unknown: found 1 program(s) that no record names" in err
    assert "one.gcode" in err
    assert check("golden", "--update")[0] == 1  # there is nothing that could be accepted
    for pattern in ("old/*", "old/one.gcode", "*.gcode"):
        status, said, err = check("golden", "--stray", pattern)
        assert (status, said, err) == (0, "3 of 3 programs are the same, 1 left out\n", "")
    assert check("golden", "--stray", "new/*")[0] == 1


def test_a_program_with_a_part_is_no_stray(shop: Path) -> None:
    Path("golden", "P001.gcode").write_text("%\n")
    status, said, _ = check("golden", "--stray", "*")
    assert status == 1
    assert said.endswith("2 of 3 programs are the same\n")


def nothing(folder: str) -> str:
    return (f"{folder}: error check-nothing: found no program to compare; expected what `batch` "
            "wrote, or a folder with the name of a machine\n")  # fmt: skip


def test_a_folder_of_which_nothing_can_be_compared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("new").mkdir()
    assert check("new") == (1, "", nothing("new"))
    Path("new", "a.gcode").write_text("%\n")
    status, said, err = check("new")
    assert (status, said) == (1, "")
    assert err.startswith("new: error check-unknown: found 1 program(s)")
    assert err.count("\n") == 1
    assert check("new", "--stray", "a.gcode") == (1, "", nothing("new"))


def test_what_cannot_be_compared_is_data_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("new").mkdir()
    Path("new", "a.gcode").write_text("%\n")
    for words, code in (((), "check-unknown"), (("--stray", "*"), "check-nothing")):
        status, said, err = check("new", "--json", *words)
        assert (status, err) == (1, "")
        (one,) = json.loads(said)
        assert (one["file"], one["result"]) == ("new", "unknown")
        assert [m["code"] for m in one["messages"]] == [code]


def test_a_folder_below_one_with_a_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    fill(Path("in/A"), 2)
    fill(Path("in/B"), 3)
    batch("in", "-o", "golden")
    assert check("golden/A")[1] == "2 of 2 programs are the same\n"
    assert check("golden")[1] == "5 of 5 programs are the same\n"


def test_a_sheet_and_a_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All that a batch takes: a drawing with a map, a model of which some members are meant."""
    monkeypatch.chdir(tmp_path)
    drawing, model = SAMPLES / "dxf" / "plate.dxf", SAMPLES / "ifc" / "beam_openings.ifc"
    assert batch(drawing, "-o", "a", "--thickness", 3, "--map", "ETCH=ignore").exit_code == 0
    assert check("a")[:2] == (0, "1 of 1 programs are the same\n")
    assert batch(model, "-o", "b", "--mark", "B1").exit_code == 0
    assert check("b")[:2] == (0, "1 of 1 programs are the same\n")


def test_a_feed_of_a_table_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("table.toml").write_text('base = "plate-linuxcnc"\n')
    batch(SAMPLES / "dxf" / "plate.dxf", "-o", "a", "--thickness", 3, "--machine", "table.toml")
    golden = Path("a/plate.ngc")
    golden.write_text(golden.read_text().replace("F5200", "F5000"))
    said = check("a")[1].splitlines()
    assert len(said) == 2
    assert said[0].endswith(": at 5000 to 5200")


def diff(*words: object) -> tuple[int, str]:
    done = call("diff", *words)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, done.stdout


def test_two_folders_are_compared_file_by_file(shop: Path) -> None:
    machine("781.44")
    assert batch("in", "-o", "new", "--machine", "mine.toml").exit_code == 0
    assert diff("golden", "golden") == (0, "3 of 3 files mean the same\n")
    status, said = diff("golden", "new")
    assert status == 1
    assert said.startswith("3 programs: all holes X +1.440 (")
    Path("new/P002.gcode").unlink()
    Path("new/P003.gcode").write_text("%\n")
    status, said = diff("golden", "new")
    assert status == 1
    assert said.splitlines()[-3:] == [
        f"{Path('golden/P002.gcode')}: only in A",
        f"{Path('new/P003.gcode')}: only in B",
        "0 of 4 files mean the same",
    ]
    rows = json.loads(diff("golden", "new", "--json")[1])
    assert [row["result"] for row in rows] == ["differs", "differs", "only in A", "only in B"]


def test_folders_of_parts_are_compared_too(shop: Path) -> None:
    fill(shop / "other", 2)
    Path("other/P000.nc1").write_text(part("P0", 1501.0))
    status, said = diff("in", "other")
    assert status == 1
    assert f"{Path('other/P000.nc1')}: length 1500 to 1501\n" in said
    assert said.endswith("1 of 3 files mean the same\n")


def test_a_folder_and_a_file_are_not_compared(shop: Path) -> None:
    done = call("diff", "in", "in/P000.nc1", status=2)
    assert "A and B have to be two files or two folders." in done.stderr


def test_a_folder_alone_is_told_what_compares_it(tmp_path: Path) -> None:
    done = call("diff", tmp_path, status=2)
    assert f"`beamcam check {tmp_path}` posts its programs again" in done.stderr
    done = call("diff", tmp_path / "a.gcode")
    assert "Missing argument 'B'." in done.stderr
