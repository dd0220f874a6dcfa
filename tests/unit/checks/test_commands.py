"""verify, diff, check and simulate on the command line."""

import json
import shutil
from pathlib import Path

import pytest
from click.testing import Result

from tests.conftest import SAMPLES
from tests.runs import call

STRUT = str(SAMPLES / "dstv" / "strut.nc1")


@pytest.fixture
def job(tmp_path: Path) -> Path:
    path = tmp_path / "job.gcode"
    call("post", STRUT, "-o", path, status=0)
    return path


def broken(job: Path) -> Path:
    """The job with its first hole 2 mm further on."""
    text = job.read_text("utf-8")
    line = next(x for x in text.splitlines() if "G00 X" in x and " Y" in x)
    x = line.split(" X")[1].split(" ")[0]
    path = job.with_name("broken.gcode")
    path.write_text(text.replace(f"X{x} ", f"X{float(x) + 2:g} "), "utf-8")
    return path


def test_verify_says_nothing_of_a_right_program(job: Path) -> None:
    done = call("verify", job, "--against", STRUT)
    assert (done.exit_code, done.output) == (0, "")


def test_verify_by_itself(job: Path) -> None:
    assert call("verify", job).exit_code == 0
    job.write_text(job.read_text("utf-8").replace("M30", ""), "utf-8")
    done = call("verify", job, status=1)
    assert "verify-end" in done.stderr


def test_verify_lists_what_differs_as_json(job: Path) -> None:
    done = call("verify", broken(job), "--against", STRUT, "--json", status=1)
    (found,) = json.loads(done.stdout)
    assert found["code"] == "verify-hole-place"
    assert found["severity"] == "error"
    assert found["file"].endswith("broken.gcode")
    assert found["line"] == 17


def test_verify_of_another_part_and_of_two(job: Path) -> None:
    assert call("verify", job, "--against", SAMPLES / "dstv" / "beam.nc1").exit_code == 1
    done = call("verify", job, "--against", STRUT, STRUT, status=1)
    assert "verify-cut-missing" in done.stderr


def test_verify_reads_standard_input(job: Path) -> None:
    text = job.read_text("utf-8")
    call("verify", "-", "--against", STRUT, stdin=text, status=0)


@pytest.mark.parametrize("words", [("--against",), (STRUT,)])
def test_verify_used_wrongly(job: Path, words: tuple[str, ...]) -> None:
    assert call("verify", job, *words).exit_code == 2


@pytest.mark.parametrize("command", ["verify", "simulate"])
def test_no_such_program(command: str) -> None:
    done = call(command, "nowhere.gcode", *(["-o", "-"] if command == "simulate" else []), status=1)
    assert "nowhere.gcode: error read-file: found no file that can be read (No such" in done.stderr


def test_what_is_left_out_by_name(tmp_path: Path) -> None:
    slotted = SAMPLES / "bad" / "slot.nc1"
    path = tmp_path / "a.gcode"
    call("post", slotted, "--machine", "beamline", "--allow-skips", "slot", "-o", path, status=0)
    for doubt in ("mark", "none"):
        assert call("verify", path, "--against", slotted, "--allow-skips", doubt).exit_code == 1
    assert call("verify", path, "--against", slotted, "--allow-skips", "slot").exit_code == 0


def test_diff_of_programs(job: Path) -> None:
    assert call("diff", job, job).exit_code == 0
    done = call("diff", job, broken(job), status=1)
    assert done.stdout.startswith("hole v at x 918.6 moved by 2.0 mm\n")
    (record,) = json.loads(call("diff", job, broken(job), "--json").stdout)
    assert record == {
        "what": "hole", "how": "changed", "text": "hole v at x 918.6 moved by 2.0 mm"
    }  # fmt: skip


@pytest.mark.parametrize("gone", [" M03", " M08", " M09", " M05", " M30", "retract"])
def test_diff_with_a_program_that_would_be_refused(job: Path, tmp_path: Path, gone: str) -> None:
    lines = job.read_text().split("\n")
    mark = " G01 " if gone == "retract" else gone
    at = next(i for i, line in enumerate(lines) if mark in line) + (gone == "retract")
    bad = tmp_path / "bad.gcode"
    bad.write_text("\n".join(lines[:at] + lines[at + 1 :]))
    for first, second in ((job, bad), (bad, job), (bad, bad)):
        done = call("diff", first, second, status=1)
        assert "error verify-" in done.stderr


def test_diff_of_parts(tmp_path: Path) -> None:
    text = Path(STRUT).read_text("utf-8")
    other = tmp_path / "other.nc1"
    other.write_text(text.replace("** ", "** another comment: "), "utf-8")
    assert call("diff", STRUT, other).exit_code == 0
    other.write_text(text.replace("120.00u     80.00     18.00", "122.00u     80.00     22.00"))
    done = call("diff", STRUT, other, status=1)
    assert done.stdout == "hole v at x 120.0 moved by 2.0 mm, diameter 18 to 22\n"


def test_diff_of_what_cannot_be_compared(job: Path, tmp_path: Path) -> None:
    assert call("diff", job, STRUT).exit_code == 2
    odd = tmp_path / "odd.gcode"
    odd.write_text("G01 X5\nG99X\n")
    done = call("diff", job, odd, status=1)
    assert "odd.gcode:2: error verify-syntax" in done.stderr


@pytest.fixture
def golden(job: Path) -> Path:
    folder = job.parent / "golden" / "beamline"
    folder.mkdir(parents=True)
    shutil.copy(job, folder / "strut.gcode")
    return folder.parent


def check(golden: Path, *words: str) -> Result:
    return call("check", golden, "--samples", SAMPLES, *words)


def test_check_of_what_is_the_same(golden: Path) -> None:
    done = check(golden)
    assert (done.exit_code, done.stdout) == (0, "1 of 1 programs are the same\n")
    assert check(golden / "beamline").exit_code == 0


def test_check_by_meaning_and_by_bytes(golden: Path) -> None:
    path = golden / "beamline" / "strut.gcode"
    text = path.read_text("utf-8")
    path.write_text(text.replace("M30", "M30 (done)"), "utf-8")
    done = check(golden)
    assert done.exit_code == 1
    assert "strut.gcode: another text that means the same" in done.stdout
    shutil.copy(broken(path), path)
    path.with_name("broken.gcode").unlink()
    done = check(golden, "--json")
    assert done.exit_code == 1
    (record,) = json.loads(done.stdout)
    assert record["result"] == "differs"
    assert record["differences"][0]["text"] == "hole v at x 920.6 moved by 2.0 mm"


@pytest.mark.parametrize(
    ("machine", "sample", "name"),
    [
        ("plate-linuxcnc", "dstv/gusset.nc1", "gusset.ngc"),
        ("plate-codesys", "dstv/gusset.nc1", "gusset.gcode"),
        ("laser-grbl", "json/curves.json", "curves.nc"),
        ("laser-stepper", "json/shield-small.json", "shield-small.csv"),
        ("beamline", "dstv/strut.nc1", "strut.gcode"),
    ],
)
def test_check_takes_the_name_of_the_job_from_the_program(
    tmp_path: Path, machine: str, sample: str, name: str
) -> None:
    folder = tmp_path / machine
    folder.mkdir()
    path = folder / name
    words = ("--machine", machine, "--job", "JOB-7", "-o", path)
    assert call("post", SAMPLES / sample, *words).exit_code == 0
    assert "JOB-7" in path.read_text("utf-8")
    assert check(tmp_path).stdout == "1 of 1 programs are the same\n"
    path.write_text(path.read_text("utf-8").replace("JOB-7", "JOB-8"), "utf-8")
    assert check(tmp_path).stdout == "1 of 1 programs are the same\n"


def test_check_of_a_part_that_is_refused(golden: Path) -> None:
    (golden / "beamline" / "strut.gcode").rename(golden / "beamline" / "gusset.gcode")
    done = check(golden)
    assert done.exit_code == 1
    assert "gusset.nc1:1: error plan-stock" in done.stderr


def test_check_of_nothing(tmp_path: Path) -> None:
    assert check(tmp_path).exit_code == 1
    (tmp_path / "beamline").mkdir()
    (tmp_path / "beamline" / "nobody.gcode").write_text("M30\n")
    done = check(tmp_path)
    assert done.exit_code == 1
    assert "error check-sample: found no sample 'nobody' for nobody.gcode" in done.stderr


def test_simulate(job: Path, tmp_path: Path) -> None:
    out = tmp_path / "trace.csv"
    assert call("simulate", job, "-o", out).exit_code == 0
    events = out.read_text("utf-8").splitlines()
    done = call("simulate", job, "-o", "-", "--every", "500ms")
    sampled = done.stdout.splitlines()
    assert sampled[0] == events[0]
    assert [line.split(",")[0] for line in sampled[1:4]] == ["0.0000", "0.5000", "1.0000"]
    assert sampled[-1].split(",")[1:10] == events[-1].split(",")[1:10]


@pytest.mark.parametrize("words", [
    (), ("-o", "-", "--every", "10"), ("-o", "-", "--every", "0ms"), ("--modbus", "localhost"),
    ("--modbus", "localhost:99999"),
])  # fmt: skip
def test_simulate_used_wrongly(job: Path, words: tuple[str, ...]) -> None:
    assert call("simulate", job, *words).exit_code == 2


def test_simulate_refuses_what_would_break(job: Path) -> None:
    job.write_text(job.read_text("utf-8").replace("M03", "M05"), "utf-8")
    done = call("simulate", job, "-o", "-", status=1)
    assert "verify-spindle-off" in done.stderr
