"""`batch --machines`: the parts of a folder on several machines, each part as `split` makes it."""

import csv
import json
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from beamcam import files as files_module
from beamcam.batch.names import stage_names
from beamcam.batch.record import RECORD_NAME
from beamcam.emitters import coping
from beamcam.files import write_together
from beamcam.machine import load
from beamcam.pipeline import read_file
from beamcam.planning.manual_list import LIST_SUFFIX
from beamcam.system import replace_file
from tests.conftest import SAMPLES
from tests.runs import BAD, batch, counts, programs

MACHINES = "beamline,coper-linuxcnc,tube-linuxcnc,plate-linuxcnc"
TWO = "beamline,coper-linuxcnc"
HEADER, TIE = SAMPLES / "coping" / "header.nc1", SAMPLES / "dstv" / "tie.nc1"
CHAIN = {
    "header-1-beamline.gcode", "header-1-rest.nc1", "header-2-coper-linuxcnc.ngc",
    f"header-2-coper-linuxcnc.ngc{LIST_SUFFIX}",
}  # fmt: skip
PARTS = [p for folder in ("coping", "dstv") for p in sorted((SAMPLES / folder).glob("*.nc1"))]


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A header, which takes two machines, and a tie, which takes one, with their outputs."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "in").mkdir()
    for path in (HEADER, TIE):
        (folder / "in" / path.name).write_bytes(path.read_bytes())
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert counts(again(Path("out"))) == (2, 0, 0, 0)
    return folder


@pytest.fixture
def made(once: Path, tmp_path: Path) -> Iterator[Path]:
    """The outputs of both, a copy for each test: inputs are recorded by their names from here."""
    shutil.copytree(once, tmp_path, dirs_exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        yield Path("out")


def again(made: Path, *more: object) -> Any:
    return batch(made.parent / "in", "-o", made, "--machines", TWO, "--jobs", 1, *more)


def rows(result: Any) -> dict[str, list[dict[str, Any]]]:
    files = json.loads(result.stdout)["files"]
    return {Path(row["file"]).stem: row["parts"] for row in files}


# --- as split does --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "parts",
    [[HEADER, *PARTS[::6]], pytest.param(PARTS, marks=pytest.mark.exhaustive)], ids=len,
)  # fmt: skip
def test_samples_have_what_split_makes_of_each(parts: list[Path], tmp_path: Path) -> None:
    """Byte for byte, programs, rests and lists; and what split refuses is refused."""
    words = ("--machines", MACHINES, "--mark-from", "file")
    out = tmp_path / "all"
    of_file = rows(batch(*parts, "-o", out, *words, "--flat", "--jobs", 2, "--json"))
    here = programs(out)
    chains = 0
    for path in parts:
        split = batch(path, *words, "-o", tmp_path / path.stem, command="split")
        found = of_file[path.stem]
        assert (split.exit_code == 0) == bool(found), path
        its = programs(tmp_path / path.stem) if found else {}
        if len(found) == 1:  # called as by any batch
            own = f"-1-{found[0]['machine']}."
            its = {name.replace(own, "."): content for name, content in its.items()}
        chains += len(found) > 1
        assert {name: here.pop(name) for name in its} == its
    assert here == {}
    assert chains == 1
    assert len(parts) / 4 < sum(map(bool, of_file.values()))


def test_the_programs_of_a_part_lie_side_by_side(made: Path) -> None:
    assert programs(made).keys() == CHAIN | {"tie.gcode"}


def test_what_the_account_says(made: Path) -> None:
    """Each program is a row; what the next machine gets does not count as left out."""
    of_file = rows(again(made, "--force", "--json"))
    (tie,), (first, second) = of_file["tie"], of_file["header"]
    assert (tie["rest"], tie["ledger"]["passed_on"]) == (None, 0)
    assert first["rest"]["output"] == "header-1-rest.nc1"
    assert (
        first["rest"]["features"] == first["ledger"]["passed_on"] == second["ledger"]["read"] == 4
    )
    for part in (tie, first, second):
        ledger = part["ledger"]
        assert ledger["read"] == sum(v for k, v in ledger.items() if k != "read")
    assert (first["by_hand"], first["skipped_by"], second["rest"]) == ([], {}, None)
    assert [row["kind"] for row in second["by_hand"]] == ["text"]
    # The bar is the first machine's; the piece that comes cut takes none.
    assert (first["bar"] > first["length"], second["bar"]) == (True, 0.0)
    done = again(made, "--force", "-v", "--exit-left-out", 7)
    assert done.exit_code == 7
    assert "14 read = 10 made + 4 passed on" in done.stderr
    assert done.stderr.splitlines()[-1].endswith("1 left for manual work")


def test_the_reports(made: Path) -> None:
    table = made.parent / "run.csv"
    assert again(made, "--report", table).exit_code == 0
    found = list(csv.DictReader(table.read_text().splitlines()))
    assert [(row["machine"], row["rest"], row["passed_on"]) for row in found] == [
        ("beamline", "header-1-rest.nc1", "4"), ("coper-linuxcnc", "", "0"), ("beamline", "", "0"),
    ]  # fmt: skip
    assert all(row["machine_time_s"] for row in found)
    page = made.parent / "run.html"
    assert again(made, "--report", page).exit_code == 0
    sheets = programs(made.parent / "run.sheets")
    assert sheets.keys() == {f"{part}.html" for part in programs(made) if ".hand" not in part} - {
        "header-1-rest.nc1.html"
    }
    totals = page.read_text().split("Totals</h2>")[1].split("</table>")[0]
    assert '<tr><td>all<td class="n">' in totals
    # Two ties and a header, which two machines have in hand.
    assert re.findall(r'<td class="n">3<td class="n">(\d+)<', totals.split("<td>all")[1]) == ["3"]


# --- what a batch promises ------------------------------------------------------------------------


def test_only_what_changed_is_made_again(made: Path) -> None:
    before = programs(made)
    assert counts(again(made)) == (0, 2, 0, 0)
    (made / "header-1-rest.nc1").unlink()
    assert counts(again(made)) == (1, 1, 0, 0)
    assert programs(made) == before
    assert counts(again(made, "--rest-as", "json")) == (2, 0, 0, 0)
    other = "beamline-pusher,coper-linuxcnc"
    assert counts(batch(made.parent / "in", "-o", made, "--machines", other)) == (2, 0, 0, 0)


@pytest.mark.parametrize("name", sorted(CHAIN))
def test_what_somebody_edited_stays_and_nothing_of_the_part_is_written(
    name: str, made: Path
) -> None:
    (made / name).write_bytes((made / name).read_bytes() + b"\n")
    before = programs(made)
    text = (made.parent / "in" / "header.nc1").read_text().replace("80.00   22.00", "81.00   22.00")
    (made.parent / "in" / "header.nc1").write_text(text)
    done = again(made)
    if name.endswith(LIST_SUFFIX):  # known by its first line, as every list
        assert done.exit_code == 0
        return
    assert (counts(done), "batch-not-ours" in done.stderr) == ((0, 1, 1, 0), True)
    assert programs(made) == before
    assert counts(again(made, "--force")) == (2, 0, 0, 0)


def test_no_two_have_a_name(tmp_path: Path) -> None:
    """An input that is called as a rest or a program of another is the one that comes later."""
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "header.nc1").write_bytes(HEADER.read_bytes())
    (tmp_path / "in" / "header-1-beamline.nc1").write_bytes(TIE.read_bytes())
    done = batch(tmp_path / "in", "-o", tmp_path / "out", "--machines", TWO, "--jobs", 1)
    assert (counts(done), "batch-same-name" in done.stderr) == ((1, 0, 1, 0), True)
    # All of the header is refused: its first program has no name.
    assert programs(tmp_path / "out").keys() == {"header-1-beamline.gcode"}
    done = batch(HEADER, "-o", tmp_path / "two", "--machines", TWO, "--name", "{mark}{suffix}")
    assert programs(tmp_path / "two").keys() == {
        "C6-1.gcode", "C6-1-rest.nc1", "C6-2.ngc", f"C6-2.ngc{LIST_SUFFIX}",
    }  # fmt: skip
    assert done.exit_code == 0


def test_names_by_templates() -> None:
    (part,) = read_file(str(HEADER)).parts
    names = {
        None: ("a.b-1-beamline.gcode", "a.b-1-rest.json"),
        "{profile}/{mark}{suffix}": ("HEB300/C6-1.gcode", "HEB300/C6-1-rest.json"),
        "{mark}_{machine}.nc": ("C6_beamline-1.nc", "C6_beamline-1-rest.json"),
        "{mark}": ("C6-1", "C6-1-rest.json"),
    }
    for template, expected in names.items():
        assert (
            stage_names(template, "a.b", part, 1, False, load("beamline"), 1, ".json") == expected
        )
    assert stage_names(None, "a", part, 1, True, load("beamline"), 0, ".nc1") == ("a_C6.gcode", "")


@pytest.mark.parametrize("jobs", [1, 2])
def test_where_the_second_program_fails_neither_is_written(jobs: int, tmp_path: Path) -> None:
    """A hole that no machine makes is left to the second, which refuses it."""
    text = HEADER.read_text().replace("80.00   22.00", "80.00    3.00")
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "header.nc1").write_text(text)
    (tmp_path / "in" / "tie.nc1").write_bytes(TIE.read_bytes())
    (tmp_path / "in" / "bad.nc1").write_text(BAD)
    out = tmp_path / "out"
    done = batch(tmp_path / "in", "-o", out, "--machines", TWO, "--jobs", jobs)
    assert (counts(done), "plan-no-machine" in done.stderr) == ((1, 0, 2, 0), True)
    assert programs(out).keys() == {"tie.gcode"}


def test_a_program_that_the_read_back_refuses_is_kept_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = coping.emit

    def wrong(*asked: Any) -> Any:
        return real(*asked).replace("M3 ", "M4 ", 1)

    monkeypatch.setattr(coping, "emit", wrong)
    done = batch(HEADER, TIE, "-o", tmp_path, "--machines", TWO, "--flat", "--jobs", 1)
    assert counts(done) == (1, 0, 1, 0)
    assert programs(tmp_path).keys() == {"tie.gcode", "header-2-coper-linuxcnc.ngc.refused"}
    assert "\nheader-2-coper-linuxcnc.ngc.refused:" in done.stderr
    assert "JOB" not in done.stderr


def test_a_full_disk_leaves_nothing_of_a_part(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = programs(made)
    real, wrote = os.replace, list[str]()

    def full(part: str, target: str) -> None:
        if wrote and "header" in target:
            raise OSError(28, "No space left on device")
        wrote.append(target)
        real(part, target)

    monkeypatch.setattr("beamcam.files.replace_file", full)
    done = again(made, "--force")
    assert counts(done) == (1, 0, 0, 1)
    assert "batch-write" in done.stderr
    left = programs(made)
    assert wrote
    assert left.keys() == before.keys() - {Path(wrote[0]).name}
    monkeypatch.undo()
    assert counts(again(made)) == (1, 1, 0, 0)
    assert programs(made) == before


@pytest.mark.parametrize("fails", range(6))
def test_files_that_go_together_are_all_there_or_none(
    fails: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever of the three writes or three renames fails."""
    files = {str(tmp_path / name): name.encode() * 9 for name in "abc"}
    calls = 0

    def counted(real: Any) -> Any:
        def call(*args: Any) -> Any:
            nonlocal calls
            calls += 1
            if calls == fails + 1:
                raise OSError(28, "No space left on device")
            return real(*args)

        return call

    monkeypatch.setattr(files_module, "_write", counted(files_module._write))
    monkeypatch.setattr(files_module, "replace_file", counted(replace_file))
    with pytest.raises(OSError, match="No space"):
        write_together(files)
    assert [*tmp_path.iterdir()] == []
    monkeypatch.undo()
    for _ in range(2):  # over what is there too
        write_together(files, durable=False)
        assert programs(tmp_path) == {name: name.encode() * 9 for name in "abc"}
    (tmp_path / "d").mkdir()
    with pytest.raises(OSError, match="no plain file"):
        write_together({str(tmp_path / "a"): b"new", str(tmp_path / "d"): b"new"})
    assert programs(tmp_path)["a"] == b"a" * 9


def test_a_run_that_was_ended_is_finished(made: Path) -> None:
    """Behind a line of the record that is torn, and files of which none says anything."""
    record = made / RECORD_NAME
    record.write_bytes(record.read_bytes()[:-40])
    (made / "header-2-coper-linuxcnc.ngc").unlink()
    done = again(made)
    assert (counts(done)[2:], done.exit_code) == ((0, 0), 0)
    assert programs(made).keys() == CHAIN | {"tie.gcode"}
    record.unlink()
    text = (made.parent / "in" / "header.nc1").read_text().replace("80.00   22.00", "81.00   22.00")
    (made.parent / "in" / "header.nc1").write_text(text)
    assert counts(again(made)) == (2, 0, 0, 0)  # programs and rests are known by their own words


def test_rests_among_the_inputs_are_none(tmp_path: Path) -> None:
    (tmp_path / "header.nc1").write_bytes(HEADER.read_bytes())
    words = (tmp_path, "-o", tmp_path, "--machines", TWO, "--jobs", 1)
    assert counts(batch(*words)) == (1, 0, 0, 0)
    done = batch(*words, "-v")
    assert (counts(done), "note batch-own-rest" in done.stderr) == ((0, 2, 0, 0), True)


def test_programs_of_other_machines_that_still_stand_are_named(made: Path) -> None:
    done = batch(made.parent / "in", "-o", made, "--machines", "beamline-pusher,coper-linuxcnc")
    assert "batch-stale: 'header-1-beamline.gcode' still stands" in done.stderr
    (made.parent / "in" / "header.nc1").write_text(BAD)
    done = again(made)
    assert "batch-stale: 'header-1-beamline.gcode' still stands" in done.stderr


def test_what_is_made_is_checked(made: Path) -> None:
    folder = str(made)
    assert batch(folder, command="check").exit_code == 0
    rest = made / "header-1-rest.nc1"
    before = rest.read_bytes()
    for change in (before.replace(b"C6", b"C7"), None):
        rest.unlink() if change is None else rest.write_bytes(change)
        done = batch(folder, command="check")
        assert (done.exit_code, "header-1-rest.nc1" in done.stdout + done.stderr) == (1, True)
        assert batch(folder, "--update", command="check").exit_code == 0
        assert rest.read_bytes() == before
    # On other machines there is another rest, or none.
    done = batch(folder, "--machine", "beamline", command="check", status=1)


def test_machine_files_of_ones_own_are_known_by_their_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("machines").mkdir()
    Path("machines/mine.toml").write_text('base = "beamline"\n')
    Path("in").mkdir()
    Path("in/header.nc1").write_bytes(HEADER.read_bytes())
    names = "mine,machines/../other.toml"
    Path("other.toml").write_text('base = "coper-linuxcnc"\n')
    assert batch("in", "-o", "out", "--machines", names).exit_code == 0
    assert "header-1-mine.gcode" in programs(Path("out"))
    assert batch("out", command="check").exit_code == 0
    assert batch("in", "-o", "machines/mine.toml", "--machines", names).exit_code == 1
    done = batch("in/header.nc1", "--machines", "mine,nothing", "-o", "two", command="split")
    assert (done.exit_code, "machine-unknown" in done.stderr) == (1, True)


def test_the_configuration_names_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("jobs").mkdir()
    Path("jobs/header.nc1").write_bytes(HEADER.read_bytes())
    config = Path("beamcam.toml")
    config.write_text('split = ["beamline", "coper-linuxcnc"]\n')
    assert batch("jobs", "-o", "out").exit_code == 0
    assert programs(Path("out")).keys() == CHAIN
    assert batch("out", command="check").exit_code == 0
    assert batch("jobs/header.nc1", "-o", "two", command="split").exit_code == 0
    assert [*programs(Path("two")).values()].sort() == [*programs(Path("out")).values()].sort()
    # A machine that is named for all is that of a batch too.
    done = batch("jobs", "-o", "three", "--machine", "beamline")
    assert (done.exit_code, "plan-cope" in done.stderr) == (1, True)
    config.write_text('split = ["beamline", "no-such"]\n')
    done = batch("jobs", "-o", "four")
    assert "beamcam.toml:1: error config-value: found 'no-such' for 'split'" in done.stderr
    # What lies beside the parts names no machines.
    config.rename("jobs/beamcam.toml")
    done = batch("jobs", "-o", "five", "--machine", "beamline")
    assert "config-trust: found 'split'" in done.stderr


@pytest.mark.parametrize("words", [
    ("--machine", "beamline"), ("--quantity", "2"), ("--turn",), ("--no-verify",),
    ("--bar", "12000"), ("--machines", ","),
])  # fmt: skip
def test_what_excludes_it(words: tuple[str, ...], tmp_path: Path) -> None:
    given = () if words[0] == "--machines" else ("--machines", TWO)
    done = batch(HEADER, "-o", tmp_path / "out", *given, *words)
    assert (done.exit_code, "machines" in done.stderr) == (2, True)
    assert not (tmp_path / "out").exists()


def test_a_dry_run_says_the_programs_and_what_is_between(tmp_path: Path) -> None:
    done = batch(HEADER, "-o", tmp_path / "out", "--machines", TWO, "--dry-run")
    shown = [line.rpartition(os.sep)[2] for line in done.stdout.splitlines()]
    assert shown == [
        "header-1-beamline.gcode, beamline", "header-1-rest.nc1, for the next machine",
        "header-2-coper-linuxcnc.ngc, coper-linuxcnc",
    ]  # fmt: skip
    assert not (tmp_path / "out").exists()


def test_watch_does_so_too(made: Path) -> None:
    out = made.parent / "watched"
    words = (made.parent / "in", "-o", out, "--machines", TWO, "--once", "--settle", 0)
    assert batch(*words, command="watch").exit_code == 0
    assert programs(out) == programs(made)
