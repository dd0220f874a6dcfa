"""What goes wrong around a batch: odd files, dying processes, a full disk, a killed run."""

import errno
import itertools
import os
import pty
import random
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import cast

import pytest

from beamcam import pipeline
from beamcam.batch import pool, work
from beamcam.batch.find import Input, find_inputs, read_input
from beamcam.batch.record import RECORD_NAME
from beamcam.batch.work import BatchSettings, FileResult, Task
from beamcam.errors import Diagnostic, Source
from beamcam.machine import load
from beamcam.model.plan import AnyPlan
from beamcam.model.request import Job, Request
from beamcam.pipeline import Posted
from tests.conftest import ROOT
from tests.runs import BAD, HANG_S, batch, counts, fill, part, programs, report, wait_until


def made_of(task: Task, shop: BatchSettings) -> FileResult:
    """What comes of one file by itself."""
    (made,) = work.make_all((task,), shop)
    return made


def test_odd_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Spaces, umlauts, a leading dash, a new line, bytes that are no text: all are just names."""
    folder = tmp_path / "in"
    folder.mkdir()
    names = ["two words.nc1", "Träger ß.nc1", "-o.nc1", "a\nb.nc1", "[x]*.nc1", "%s{}.nc1"]
    for name in names:
        (folder / name).write_text(part("A"))
    with open(os.fsencode(folder) + b"/latin-\xe4.nc1", "w") as file:
        file.write(BAD)
    said = tmp_path / "r.json"
    result = batch(folder, "-o", tmp_path / "out", "--report", said, "--jobs", 2)
    assert counts(result) == (6, 0, 1, 0)
    assert sorted(programs(tmp_path / "out")) == sorted(n.replace("nc1", "gcode") for n in names)
    assert "plan-tool" in result.stderr
    (bad,) = (row for row in report(said)["files"] if row["status"] == "refused")
    assert os.fsencode(bad["file"]).endswith(b"latin-\xe4.nc1")
    for kind in ("csv", "html"):
        assert batch(folder, "-o", tmp_path / "out", "--report", f"{said}.{kind}").exit_code == 1
    # Named one by one, a pattern's letters in a name that exists are letters.
    monkeypatch.chdir(folder)
    args = ("-o", tmp_path / "one", "--", "-o.nc1", "[x]*.nc1", "Träger ß.nc1")
    assert counts(batch(*args)) == (3, 0, 0, 0)


def test_loops_of_links_end(tmp_path: Path) -> None:
    fill(tmp_path / "in" / "A", 2)
    (tmp_path / "in" / "A" / "up").symlink_to(tmp_path / "in")
    (tmp_path / "in" / "self.nc1").symlink_to(tmp_path / "in" / "self.nc1")
    (tmp_path / "in" / "gone.nc1").symlink_to(tmp_path / "nowhere.nc1")
    (tmp_path / "in" / "link").symlink_to(tmp_path / "other")
    fill(tmp_path / "other", 1)
    result = batch(tmp_path / "in", "-o", tmp_path / "out", status=1)
    assert counts(result) == (3, 0, 1, 0)
    assert sorted(programs(tmp_path / "out")) == ["A/P000.gcode", "A/P001.gcode",
                                                  "link/P000.gcode"]  # fmt: skip
    up = tmp_path / "in" / "A" / "up"
    assert f"{up}: warning batch-loop: found a link back to {tmp_path / 'in'}" in result.stderr
    assert "self.nc1: error read-file: found no file that can be read (Too many" in result.stderr
    assert "gone.nc1: error read-file: found no file that can be read (No such" in result.stderr


def test_files_that_are_none(tmp_path: Path) -> None:
    """An empty one, one of zeros, a folder, a pipe: a message each, and the good one is posted."""
    folder = tmp_path / "in"
    fill(folder, 1)
    (folder / "empty.nc1").touch()
    with open(folder / "zeros.nc1", "wb") as file:
        file.truncate(200 * 1024 * 1024)
    (folder / "folder.nc1").mkdir()
    os.mkfifo(folder / "pipe.nc1")
    (folder / "text.nc1").write_text("Dear customer,\n")
    result = batch(folder, folder / "none.nc1", "-o", tmp_path / "out")
    assert counts(result) == (1, 0, 5, 0)
    for said in (
        "empty.nc1: error read-empty: found an empty file",
        "zeros.nc1: error read-zeros: found 209 715 200 bytes that are all zero",
        "pipe.nc1: error read-not-a-file: found a pipe or a device; expected a plain file",
        "none.nc1: error read-file: found no file that can be read (No such file",
        "text.nc1:1: error dstv-not-dstv",
    ):
        assert said in result.stderr
    assert list(programs(tmp_path / "out")) == ["P000.gcode"]


def test_zeros_with_something_behind_them_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.nc1"
    data = bytes(3 << 20) + b"ST\n"
    path.write_bytes(data)
    assert read_input(str(path)) == data
    path.write_bytes(bytes(100))
    zeros = read_input(str(path))
    assert isinstance(zeros, Diagnostic)
    assert "found 100 bytes that are all zero" in zeros.message
    path.write_bytes(bytes(100) + b"x")
    assert read_input(str(path)) == bytes(100) + b"x"
    path.write_bytes(b"x" * (5 << 20))
    assert read_input(str(path)) == b"x" * (5 << 20)
    said = read_input(str(tmp_path))
    assert isinstance(said, Diagnostic)
    assert said.code == "read-folder"


def test_a_file_that_a_server_has_a_lease_on_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.nc1"
    path.write_bytes(b"ST\n")
    real, asked = os.open, []

    def leased(path: str, how: int) -> int:
        asked.append(bool(how & os.O_NONBLOCK))
        if asked[-1]:
            raise BlockingIOError(errno.EWOULDBLOCK, os.strerror(errno.EWOULDBLOCK))
        return real(path, how)

    monkeypatch.setattr(os, "open", leased)
    assert read_input(str(path)) == b"ST\n"
    assert asked == [True, False]


def test_a_file_that_grows_while_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of it is read, though the system said that there is less."""
    path = tmp_path / "a.nc1"
    path.write_bytes(b"ST" * 1000)
    real = os.fstat

    def smaller(file: int) -> os.stat_result:
        values = list(real(file))
        values[stat.ST_SIZE] = 5
        return os.stat_result(values)

    monkeypatch.setattr(os, "fstat", smaller)
    assert read_input(str(path)) == b"ST" * 1000


def test_unreadable_files_and_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fill(tmp_path / "in", 2)
    fill(tmp_path / "in" / "locked", 1)
    real_open, real_scan = os.open, os.scandir

    def refuse_file(path: str | Path, *how: int) -> int:
        if os.fspath(path).endswith("P001.nc1"):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return real_open(path, *how)

    def refuse_folder(path: str | Path) -> object:
        if os.fspath(path).endswith("locked"):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return real_scan(path)

    # Modes do not hold back the superuser, who may well run the tests.
    monkeypatch.setattr(os, "open", refuse_file)
    monkeypatch.setattr(os, "scandir", refuse_folder)
    result = batch(tmp_path / "in", "-o", tmp_path / "out")
    assert counts(result) == (1, 0, 1, 0)
    assert "P001.nc1: error read-file: found no file that can be read (Permission" in result.stderr
    assert "locked: error batch-folder: found a folder that cannot be listed" in result.stderr
    assert result.exit_code == 1


def test_nothing_to_do(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for name in (tmp_path / "empty", tmp_path / "*.nc1"):
        result = batch(name, "-o", tmp_path / "out", status=1)
        assert f"error batch-nothing: found no input for '{name}'" in result.stderr


def test_a_drawing_without_a_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from beamcam.readers import Reading

    monkeypatch.setattr(work, "read", lambda data, name: Reading("dxf", ()))
    made = made_of(Task(0, "a.dxf", b"x"), BatchSettings(Request((), load("beamline"))))
    assert [m["code"] for m in made.row["messages"]] == ["batch-no-part"]
    assert made.row["status"] == "refused"


def test_several_parts_in_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is posted by itself; one that is refused refuses the file and no other part."""
    from beamcam.readers import Reading, read

    texts = (part("M 1"), BAD, part("M_1", 2500.0), part("M2"), part("M2", 2500.0))
    parts = tuple(read(text.encode(), f"{k}.nc1").parts[0] for k, text in enumerate(texts))
    monkeypatch.setattr(work, "read", lambda data, name: Reading("ifc", parts))
    shop = BatchSettings(Request((), load("beamline")))
    made = made_of(Task(0, "in/model.ifc", b"x"), shop)
    names = [name for name, _ in made.outputs]
    assert names == ["model_M_1.gcode", "model_M_1-2.gcode", "model_M2.gcode"]
    assert made.row["status"] == "refused"
    assert [p["output"] for p in made.row["parts"]] == names
    shop = BatchSettings(Request((), load("beamline")), name="{mark}.gcode")
    made = made_of(Task(0, "in/model.ifc", b"x"), shop)
    assert [name for name, _ in made.outputs] == ["M_1.gcode", "M2.gcode"]
    codes = [m["code"] for m in made.row["messages"] if m["severity"] == "error"]
    assert codes == ["list-mark-twice", "plan-tool", "batch-same-name"]


def test_members_that_cannot_be_read_stop_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """The members of a model are parts of their own; of any other file an error refuses all."""
    from beamcam.readers import EMPTY, Reading, read

    (good,) = read(part("M1").encode(), "1.nc1").parts
    said = EMPTY.at(Source("model.ifc", None, "GUID"))
    for name, outputs in (("ifc", 1), ("dstv", 0)):
        reading = Reading(name, (good,), (said,))
        monkeypatch.setattr(work, "read", lambda data, file, reading=reading: reading)
        made = made_of(Task(0, "in/model.ifc", b"x"), BatchSettings(Request((), load("beamline"))))
        assert made.row["status"] == "refused"
        assert [m["code"] for m in made.row["messages"] if m["severity"] == "error"] == [
            "read-empty"
        ]
        assert len(made.outputs) == len(made.row["parts"]) == outputs


def test_the_files_of_a_chunk_go_from_stage_to_stage_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One that is refused drops out, and the time of each is its own."""
    told: list[tuple[str, str]] = []
    real = pipeline.posting

    def posting(asked: Job, plan: AnyPlan) -> Generator[str, None, Posted]:
        stages = real(asked, plan)
        while True:
            try:
                stage = next(stages)
            except StopIteration as end:
                return cast(Posted, end.value)
            told.append((stage.split()[0], asked.parts[0].mark))
            yield stage

    monkeypatch.setattr(pipeline, "posting", posting)
    texts = (part("A"), BAD, part("B", 3000.0))
    tasks = [Task(k, f"{k}.nc1", text.encode()) for k, text in enumerate(texts)]
    shop = BatchSettings(Request((), load("beamline")), clock=itertools.count().__next__)
    made = work.make_all(tasks, shop)
    stages = ("put", "printed", "read")  # behind the plan
    assert told == [(stage, mark) for stage in stages for mark in "AB"]
    assert [one.row["status"] for one in made] == ["posted", "refused", "posted"]
    # Between two looks at the clock is one stage: reading, four here, and the account of it all.
    assert [one.row["seconds"] for one in made] == [6, 2, 6]
    monkeypatch.undo()
    alone = [work.make_all([task], shop)[0] for task in tasks]
    assert [(one.row, one.outputs) for one in made] == [(one.row, one.outputs) for one in alone]


def test_a_fault_of_the_program_is_one_of_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 3)
    real = pipeline.posting

    def posting(asked: Job, plan: AnyPlan) -> Generator[str, None, Posted]:
        yield "begun"
        if asked.parts[0].mark == "P1":
            raise AssertionError("the ledger does not balance")
        return (yield from real(asked, plan))

    monkeypatch.setattr(pipeline, "posting", posting)
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--jobs", 1)
    assert counts(result) == (2, 0, 0, 1)
    assert (
        "P001.nc1: error batch-internal: found a fault of beamcam: AssertionError" in result.stderr
    )
    assert "the ledger does not balance" in result.stderr


def test_a_worker_that_dies_is_told_for_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 40)

    def make_all(tasks: tuple[Task, ...], shop: BatchSettings) -> list[FileResult]:
        if any(task.name.endswith("P013.nc1") for task in tasks):
            os.kill(os.getpid(), signal.SIGKILL)
        return work.make_all(tasks, shop)

    monkeypatch.setattr(pool, "make_all", make_all)  # which the workers are forked with
    said = tmp_path / "r.json"
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--jobs", 2, "--report", said)
    assert counts(result) == (39, 0, 0, 1)
    assert (
        "P013.nc1: error batch-worker: found the worker process dead at this file" in result.stderr
    )
    assert len(programs(tmp_path / "out")) == 39
    monkeypatch.undo()
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out", "--jobs", 2)) == (1, 39, 0, 0)


def test_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each file that finds no room says so, nothing is written in part, and the rest is done."""
    fill(tmp_path / "in", 4)
    out = tmp_path / "out"
    batch(tmp_path / "in", "-o", out)
    before = programs(out)
    (tmp_path / "in" / "P001.nc1").write_text(part("P1", 3000.0))
    real = os.write

    def write(file: int, data: bytes) -> int:
        if bytes(data).startswith(b"% FULL"):
            real(file, data[:100])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(file, data)

    monkeypatch.setattr(os, "write", write)
    result = batch(tmp_path / "in", "-o", out, "--job", "FULL")
    assert counts(result) == (0, 0, 0, 4)
    assert result.stderr.count("error batch-write") == 4
    assert "'P001.gcode' cannot be written (No space left on device)" in result.stderr
    assert programs(out) == before
    monkeypatch.undo()
    assert counts(batch(tmp_path / "in", "-o", out, "--job", "FULL")) == (4, 0, 0, 0)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 256 KiB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=256k", "none", str(folder)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"this process may not mount a small disk: {error}")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_disk_that_is_full(tmp_path: Path, small_disk: Path) -> None:
    fill(tmp_path / "in", 100)
    batch(tmp_path / "in", "-o", tmp_path / "right")
    right = programs(tmp_path / "right")
    result = batch(tmp_path / "in", "-o", small_disk)
    posted, unchanged, refused, failed = counts(result)
    assert (unchanged, refused) == (0, 0)
    assert posted + failed == 100
    assert failed > 0
    made = programs(small_disk)
    assert len(made) == posted
    assert all(right[name] == text for name, text in made.items())
    assert "No space left on device" in result.stderr
    subprocess.run(["mount", "-o", "remount,size=8m", str(small_disk)], check=True)
    batch(tmp_path / "in", "-o", small_disk, status=0)
    assert programs(small_disk) == right


def test_a_record_that_cannot_be_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fill(tmp_path / "in", 3)
    real = os.write

    def write(file: int, data: bytes) -> int:
        if bytes(data).lstrip().startswith((b'{"key":', b'{"recipe":')):
            return real(file, data[:20])
        return real(file, data)

    monkeypatch.setattr(os, "write", write)
    result = batch(tmp_path / "in", "-o", tmp_path / "out")
    assert counts(result) == (3, 0, 0, 0)
    assert result.stderr.count("warning batch-record: the record of the batch cannot be kept") == 1
    monkeypatch.undo()
    # The torn line is none, and does not spoil the next.
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out")) == (3, 0, 0, 0)
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out")) == (0, 3, 0, 0)


def test_a_record_that_was_spoilt(tmp_path: Path) -> None:
    fill(tmp_path / "in", 3)
    batch(tmp_path / "in", "-o", tmp_path / "out")
    record = tmp_path / "out" / RECORD_NAME
    lines = record.read_bytes().splitlines(keepends=True)
    recipe, *lines = lines
    record.write_bytes(b"\xff\x00\n" + recipe + lines[0]
                       + lines[1].replace(b'"sha256"', b'"sha"')
                       + b'{"key":"zz\n' + lines[2][:-40])  # fmt: skip
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out")) == (2, 1, 0, 0)
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out")) == (0, 3, 0, 0)


def test_the_record_does_not_grow_without_end(tmp_path: Path) -> None:
    fill(tmp_path / "in", 3)
    record = tmp_path / "out" / RECORD_NAME
    sizes = []
    for job in range(30):
        assert (
            counts(batch(tmp_path / "in", "-o", tmp_path / "out", "--job", f"J{job}", "--jobs", 1))[
                0
            ]
            == 3
        )
        sizes.append(len(record.read_bytes().splitlines()))
    assert max(sizes) <= 2 * 3 + 16 + 3 + 1
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "out", "--job", "J29")) == (0, 3, 0, 0)


def test_an_output_folder_that_is_a_file(tmp_path: Path) -> None:
    fill(tmp_path / "in", 1)
    (tmp_path / "out").write_text("mine")
    result = batch(tmp_path / "in", "-o", tmp_path / "out", status=1)
    assert "out: error batch-write: " in result.stderr
    assert (tmp_path / "out").read_text() == "mine"


def test_a_report_that_cannot_be_written(tmp_path: Path) -> None:
    fill(tmp_path / "in", 1)
    result = batch(
        tmp_path / "in", "-o", tmp_path / "out", "--report", tmp_path / "no" / "r.json", status=1
    )
    assert counts(result) == (1, 0, 0, 0)
    assert "r.json' cannot be written (No such file or directory)" in result.stderr


def start(*args: object, **options: object) -> "subprocess.Popen[bytes]":
    """A batch in a process and a group of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "beamcam", "batch", *map(str, args)], cwd=ROOT,
        start_new_session=True, stderr=subprocess.PIPE, **options,  # type: ignore[call-overload]
    )  # fmt: skip


def wait_for_outputs(
    folder: Path, count: int, process: "subprocess.Popen[bytes] | None" = None
) -> None:
    wait_until(lambda: len(list(folder.glob("*.gcode"))) >= count, process)


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_run_that_is_killed_is_finished_by_the_next(tmp_path: Path, jobs: int) -> None:
    fill(tmp_path / "in", 40)
    batch(tmp_path / "in", "-o", tmp_path / "right")
    right, out = programs(tmp_path / "right"), tmp_path / "out"
    chance = random.Random(jobs)
    for least in (1, 20):
        process = start(tmp_path / "in", "-o", out, "--jobs", jobs)
        wait_for_outputs(out, least)
        time.sleep(chance.random() * 0.03)
        os.kill(process.pid, signal.SIGKILL)
        process.communicate(timeout=HANG_S)
        made = programs(out)
        assert all(right.get(name) == text for name, text in made.items())
    posted, unchanged, refused, failed = counts(batch(tmp_path / "in", "-o", out))
    assert (refused, failed) == (0, 0)
    # All that stood is known but for the one whose line had not been written yet.
    assert unchanged >= len(made) - 1
    assert posted + unchanged == 40
    assert programs(out) == right


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_whole_files(tmp_path: Path, how: signal.Signals) -> None:
    fill(tmp_path / "in", 1500)
    process = start(tmp_path / "in", "-o", tmp_path / "out", "--jobs", 2)
    wait_for_outputs(tmp_path / "out", 5)
    os.killpg(process.pid, how)  # as a terminal does: the workers get it too
    stderr = process.communicate(timeout=HANG_S)[1].decode()
    made = programs(tmp_path / "out")
    if process.returncode == 0:
        pytest.fail("the batch was over before it could be interrupted")
    assert process.returncode == 130
    assert stderr.splitlines()[-1].endswith("(interrupted)")
    assert "Traceback" not in stderr
    assert len(made) == int(stderr.splitlines()[-1].split()[0])
    assert all(text.endswith(b"M30\n%\n") for text in made.values())


def test_workers_do_not_outlive_the_batch(tmp_path: Path) -> None:
    fill(tmp_path / "in", 400)
    process = start(tmp_path / "in", "-o", tmp_path / "out", "--jobs", 3)
    wait_for_outputs(tmp_path / "out", 5)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate(timeout=HANG_S)
    wait_until(lambda: not group_lives(process.pid))


def group_lives(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_a_bar_on_a_terminal(tmp_path: Path) -> None:
    fill(tmp_path / "in", 30, bad=7)
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "beamcam", "batch", str(tmp_path / "in"), "-o",
               str(tmp_path / "out")]  # fmt: skip
    process = subprocess.Popen(command, cwd=ROOT, stderr=theirs)
    os.close(theirs)
    shown = b""
    while True:
        try:
            piece = os.read(ours, 4096)
        except OSError:  # the other end is closed
            break
        if not piece:
            break
        shown += piece
    os.close(ours)
    assert process.wait() == 1
    assert b"/30" in shown
    assert b"[" in shown
    assert shown.rstrip().endswith(b"29 posted, 0 unchanged, 1 refused, 0 failed")


def test_inputs_below_the_folder_they_share(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    fill(Path("jobs/A"), 1)
    fill(Path("jobs/B/deep"), 1)
    Path("jobs/A/.hidden.nc1").write_text("x")
    a, b = "jobs/A/P000.nc1", "jobs/B/deep/P000.nc1"
    for names in (("jobs",), ("jobs/**/*.nc1",), ("jobs/A", "jobs/B"), ("jobs/*",)):
        found = find_inputs(names)
        assert found.inputs == (Input(a, "A/P000.nc1"), Input(b, "B/deep/P000.nc1")), names
        assert found.diagnostics == ()
    assert find_inputs((b, a)).inputs == (
        Input(b, "B/deep/P000.nc1"), Input(a, "A/P000.nc1"),
    )  # fmt: skip
    assert find_inputs((a,)).inputs == (Input(a, "P000.nc1"),)
    assert find_inputs(("jobs",), leave_out=("jobs/B",)).inputs == (Input(a, "A/P000.nc1"),)
    assert find_inputs(("jobs/B",), leave_out=("jobs/B",)).inputs == (Input(b, "deep/P000.nc1"),)
