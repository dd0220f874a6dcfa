"""What differs from system to system: each other way is taken here, by patching what is asked."""

import errno
import io
import json
import multiprocessing
import ntpath
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from beamcam import processes, readers, system
from beamcam.batch import find
from beamcam.batch.names import template_fault
from beamcam.cli import main
from beamcam.commands.common import Console, stop_without_output, write
from beamcam.config.load import load as load_config
from beamcam.files import FilesRead, write_whole
from beamcam.machine import load
from beamcam.system import asked_to_end
from tests.conftest import ROOT, SAMPLES
from tests.runs import HANG_S, batch, counts, fill, part, programs

TEXTS = sorted(
    path
    for folder in ("dstv", "dxf", "svg", "json", "ifc")
    for path in (SAMPLES / folder).iterdir()
    if not path.read_bytes().startswith((b"AutoCAD Binary", b"\xff\xfe"))
)


# -- files -----------------------------------------------------------------------------------


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "is_windows", lambda: True)


def refusing(monkeypatch: pytest.MonkeyPatch, times: int) -> list[float]:
    """`os.replace` refuses so many times; the waits between."""
    waits: list[float] = []
    really, left = os.replace, [times]

    def replace(part: str, target: str) -> None:
        if left[0]:
            left[0] -= 1
            raise PermissionError(13, "Permission denied")
        really(part, target)

    monkeypatch.setattr(os, "replace", replace)
    monkeypatch.setattr(system.time, "sleep", waits.append)
    return waits


def test_an_output_that_is_read_is_tried_again(
    tmp_path: Path, windows: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a").write_text("old")
    waits = refusing(monkeypatch, 3)
    write_whole(tmp_path / "a", "new")
    assert (tmp_path / "a").read_text() == "new"
    assert waits == [system.REPLACE_WAIT_S] * 3


def test_an_output_that_stays_open_is_refused(
    tmp_path: Path, windows: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a").write_text("old")
    waits = refusing(monkeypatch, 1000)
    with pytest.raises(PermissionError):
        write_whole(tmp_path / "a", "new")
    assert [p.name for p in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_text() == "old"
    assert 0.5 <= sum(waits) <= 2.0


def test_other_systems_do_not_wait(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_text("old")
    waits = refusing(monkeypatch, 1)
    with pytest.raises(PermissionError):
        write_whole(tmp_path / "a", "new")
    assert waits == []


def test_each_output_reaches_the_disk_where_not_all_can_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[int] = []
    monkeypatch.setattr(os, "fsync", synced.append)
    fill(tmp_path / "in", 3)
    batch(tmp_path / "in", "-o", tmp_path / "a", "--jobs", 1)
    assert synced == []
    monkeypatch.delattr(os, "sync")
    monkeypatch.setattr(
        sys.modules["beamcam.batch.outputs"], "write_new", lambda *_: False
    )  # no files without a name
    batch(tmp_path / "in", "-o", tmp_path / "b", "--jobs", 1)
    assert len(synced) == 3
    assert programs(tmp_path / "a") == programs(tmp_path / "b")


# -- processes -------------------------------------------------------------------------------


def test_workers_that_start_afresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[str] = []

    def context(method: str) -> multiprocessing.context.BaseContext:
        begun.append(method)
        return multiprocessing.get_context(method)

    fill(tmp_path / "in", 6, bad=2)
    monkeypatch.setattr(processes, "get_context", context)
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "fork", "--jobs", 2)) == (5, 0, 1, 0)
    monkeypatch.setattr(processes, "start_method", lambda: "spawn")
    assert counts(batch(tmp_path / "in", "-o", tmp_path / "spawn", "--jobs", 2)) == (5, 0, 1, 0)
    assert begun == ["fork", "spawn"]
    assert programs(tmp_path / "fork") == programs(tmp_path / "spawn")


@pytest.mark.parametrize(
    ("platform", "method"), [("linux", "fork"), ("darwin", "spawn"), ("win32", "spawn")]
)
def test_how_workers_start(platform: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    assert system.start_method() == method


def test_windows_waits_for_no_more_than_it_can(windows: None) -> None:
    assert system.max_workers(200) == 60
    assert system.max_workers(8) == 8


def test_other_systems_have_as_many_workers_as_are_wanted() -> None:
    assert system.max_workers(200) == 200


def test_cores_where_a_process_cannot_be_bound_to_some(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 7)
    assert system.cores() == 7
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert system.cores() == 1


def test_ctrl_break_ends_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the number of another signal in the place of the one that only Windows has."""
    monkeypatch.setattr(signal, "SIGBREAK", signal.SIGUSR2, raising=False)
    before = signal.getsignal(signal.SIGUSR2)
    with asked_to_end() as asked:
        assert not asked
        signal.raise_signal(signal.SIGUSR2)
        assert asked
    assert signal.getsignal(signal.SIGUSR2) == before


# -- names and paths -------------------------------------------------------------------------


def test_no_output_is_a_device_of_windows(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    for stem, mark in (("a", "AUX"), ("b", "com1"), ("Nul", "x"), ("console", "CONSOLE")):
        (tmp_path / "in" / f"{stem}.nc1").write_text(part(mark))
    batch(tmp_path / "in", "-o", tmp_path / "a")
    assert set(programs(tmp_path / "a")) == {
        "a.gcode", "b.gcode", "Nul_.gcode", "console.gcode"
    }  # fmt: skip
    batch(tmp_path / "in", "-o", tmp_path / "b", "--name", "{mark}/{mark}.x{suffix}")
    assert set(programs(tmp_path / "b")) == {
        "AUX_/AUX_.x.gcode", "com1_/com1_.x.gcode", "x/x.x.gcode", "CONSOLE/CONSOLE.x.gcode"
    }  # fmt: skip


@pytest.mark.parametrize(
    "template",
    [
        "{mark}?",
        "a:{mark}",
        "x/a:{mark}",
        "{mark}.",
        "{mark} /x",
        "a|b",
        "{mark:>999999999}",
        "\\a",
    ],
)
def test_names_that_windows_cannot_have(template: str) -> None:
    assert template_fault(template) is not None
    assert template_fault("{mark}_{quantity}.gcode") is None


def test_paths_of_a_record_are_the_same_on_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "path", ntpath)
    monkeypatch.setattr(os, "sep", "\\")
    places = [("C:\\jobs\\A\\in\\M1.nc1", "C:\\jobs\\A"), ("C:\\jobs\\B\\M1.nc1", "C:\\jobs\\B")]
    made = list(find._inputs(places))
    monkeypatch.undo()
    assert [one.tree for one in made] == ["A/in/M1.nc1", "B/M1.nc1"]


def test_either_slash_in_configuration_machines_and_lists(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "shop" / "halls").mkdir(parents=True)
    (tmp_path / "shop" / "base.toml").write_text('base = "beamline"\nsuffix = ".tap"\n')
    mine = tmp_path / "shop" / "halls" / "mine.toml"
    mine.write_text('base = "..\\\\base.toml"\n')
    (tmp_path / "beamcam.toml").write_text('machine = "shop\\\\halls\\\\mine.toml"\n')
    config = load_config(tmp_path / "beamcam.toml")
    assert config.machine
    assert load(config.machine).suffix == ".tap"
    monkeypatch.chdir(tmp_path)
    assert load("shop\\halls\\mine.toml").suffix == ".tap"
    fill(tmp_path / "in", 2)
    result = batch("-", "-o", "out", stdin="\ufeffin\\P000.nc1\r\nin/P001.nc1\r\n")
    assert counts(result) == (2, 0, 0, 0)
    assert set(programs(tmp_path / "out")) == {"P000.tap", "P001.tap"}


def test_windows_keeps_its_own_slash(windows: None) -> None:
    assert system.portable_path("in\\P000.nc1") == "in\\P000.nc1"


# -- text ------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.name)
def test_line_ends_and_byte_order_marks(path: Path) -> None:
    data = path.read_bytes().replace(b"\r\n", b"\n")
    found = readers.read(data, path.name).parts
    assert readers.read(data.replace(b"\n", b"\r\n"), path.name).parts == found
    assert readers.read(b"\xef\xbb\xbf" + data, path.name).parts == found


def test_a_program_keeps_its_line_ends_on_standard_output(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="cp1252", newline="\r\n"))
    write("-", "G0 X1\n(Ж)\n", Console(), FilesRead(()))
    sys.stdout.flush()
    assert raw.getvalue() == "G0 X1\n(Ж)\n".encode()


#: Input, suffix of the program, and whether its rows are found by their place in the file.
PROGRAMS = [
    ("dstv/channel.nc1", ".gcode", False), ("dxf/plate.dxf", ".ngc", False),
    ("json/shield-small.json", ".st", False), ("json/shield-small.json", ".csv", False),
    ("json/shield-small.json", ".steps", True), ("json/shield-small.json", ".h", True),
]  # fmt: skip


@pytest.mark.parametrize(("source", "suffix", "by_place"), PROGRAMS)
def test_a_program_with_the_line_ends_of_windows(
    tmp_path: Path, source: str, suffix: str, by_place: bool
) -> None:
    program, thickness = tmp_path / f"a{suffix}", ("--thickness", "3") * (".dxf" in source)

    def call(*words: object) -> int:
        return CliRunner().invoke(main, [*map(str, words), *thickness]).exit_code

    assert call("post", SAMPLES / source, "-o", program) == 0
    program.write_bytes(program.read_bytes().replace(b"\n", b"\r\n"))
    assert call("verify", program, "--against", SAMPLES / source) == (1 if by_place else 0)


def test_a_reader_that_has_gone_is_no_fault(
    windows: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(os, "dup2", lambda *_: None)
    with pytest.raises(SystemExit) as end:
        stop_without_output(OSError(errno.EINVAL, "Invalid argument"))
    assert end.value.code == 1
    assert capsys.readouterr().err == ""
    with pytest.raises(SystemExit):
        stop_without_output(OSError(errno.ENOSPC, "No space left on device"))
    assert "error write-file" in capsys.readouterr().err


def test_a_stream_that_is_not_unicode(tmp_path: Path) -> None:
    (tmp_path / "Ж.nc1").write_text(part("A"))
    environment = {**os.environ, "PYTHONIOENCODING": "cp1252:strict", "PYTHONPATH": str(ROOT)}

    def inspect(*options: str) -> bytes:
        call = [sys.executable, "-m", "beamcam", "inspect", "Ж.nc1", *options]
        done = subprocess.run(
            call, cwd=tmp_path, env=environment, capture_output=True, timeout=HANG_S
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    record = json.loads(inspect("--json").decode("ascii"))
    assert "Ж.nc1" in json.dumps(record, ensure_ascii=False)
    assert b"\\u0416.nc1" in inspect()


# -- PowerShell ------------------------------------------------------------------------------

_WORD = re.compile(r"""'[^']*'|"[^"]*"|[^\s|;]+|[|;]""")
_PAGES = [
    page
    for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))
    if "```powershell" in page.read_text(encoding="utf-8")
]


def powershell(page: Path) -> list[str]:
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```powershell\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return [line for block in blocks for line in block.splitlines()]


@pytest.mark.parametrize("page", _PAGES, ids=lambda page: page.name)
def test_lines_for_powershell(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each line has no word of another shell, and what it calls runs with its paths turned."""
    shutil.copytree(SAMPLES, tmp_path / "samples")
    monkeypatch.chdir(tmp_path)
    called = 0
    for line in powershell(page):
        code, _, status = line.partition("  # exit ")
        words = _WORD.findall(code)
        assert not {"&&", "||", "export", "source"} & set(words), line
        assert not code.rstrip().endswith("\\"), line
        assert "/" not in re.sub(r"https?://\S+", "", code), line
        names = [word.rpartition("\\")[2] for word in words]
        if "beamcam" not in names:
            continue
        arguments = [word.strip("'\"").replace("\\", "/") for word in words]
        arguments = arguments[names.index("beamcam") + 1 :]
        listed = "".join(f"{p}\n" for p in sorted(Path("samples/dstv").glob("c*.nc1")))
        done = CliRunner().invoke(main, arguments, input=listed)
        assert done.exit_code == int(status or 0), f"{line}\n{done.output}"
        called += 1
    assert called
