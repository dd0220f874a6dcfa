"""No command writes over a file that it reads, by any name of that file."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from beamcam.files import FilesRead
from tests.conftest import SAMPLES
from tests.runs import batch, call, part


def same(path: Path) -> str:
    return str(path)


def relative(path: Path) -> str:
    return f"{path.parent}/../{path.parent.name}/./{path.name}"


def hard(path: Path) -> str:
    os.link(path, path.parent / f"hard{path.suffix}")
    return str(path.parent / f"hard{path.suffix}")


def symbolic(path: Path) -> str:
    (path.parent / f"soft{path.suffix}").symlink_to(path)
    return str(path.parent / f"soft{path.suffix}")


def below_a_link(path: Path) -> str:
    (path.parent / "folder").symlink_to(path.parent, target_is_directory=True)
    return str(path.parent / "folder" / path.name)


NAMES = [same, relative, hard, symbolic, below_a_link]


@pytest.fixture
def work(tmp_path: Path) -> Path:
    """A folder with a part, a sheet, a program, a configuration and a machine on another one."""
    folder = tmp_path / "work"
    folder.mkdir()
    for name in ("M.nc1", "M.txt"):  # the second has a name that an output may have too
        (folder / name).write_text(part("M"))
    shutil.copy(SAMPLES / "dstv" / "gusset.nc1", folder / "gusset.nc1")
    (folder / "job.toml").write_text('job = "A"\n')
    (folder / "base.toml").write_text('base = "beamline"\n')
    (folder / "mine.toml").write_text('base = "base.toml"\n')
    call("post", folder / "M.nc1", "-o", folder / "M.gcode", status=0)
    return folder


class Tried(NamedTuple):
    """What came of a command whose output is one of its inputs."""

    status: int
    is_told: bool  #: that the output is an input
    changed: list[str]  #: files of the folder that are not what they were


REFUSED = Tried(1, True, [])


def tried(folder: Path, output: str, *words: str) -> Tried:
    before = {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}
    result = call(*words, "-o", output)
    after = {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}
    changed = [name for name in sorted({*before, *after}) if before.get(name) != after.get(name)]
    is_told = "error write-over-input: found the output" in result.stderr
    return Tried(result.exit_code, is_told, changed)


@pytest.mark.parametrize("name", NAMES)
def test_post(work: Path, name: Callable[[Path], str]) -> None:
    assert tried(work, name(work / "M.txt"), "post", str(work / "M.txt")) == REFUSED


@pytest.mark.parametrize("file", ["job.toml", "mine.toml", "base.toml"])
@pytest.mark.parametrize("command", ["post", "plan"])
def test_configuration_and_machine(work: Path, command: str, file: str) -> None:
    asked = ("--config", str(work / "job.toml"), "--machine", str(work / "mine.toml"))
    os.link(work / file, work / "hard.txt")
    assert tried(work, str(work / "hard.txt"), command, str(work / "M.nc1"), *asked) == REFUSED


def test_the_configuration_that_was_found(work: Path) -> None:
    shutil.copy(work / "job.toml", work / "beamcam.toml")
    os.link(work / "beamcam.toml", work / "hard.txt")
    assert tried(work, str(work / "hard.txt"), "post", str(work / "M.nc1")) == REFUSED


def test_the_second_input(work: Path) -> None:
    shutil.copy(work / "M.nc1", work / "N.txt")
    assert (
        tried(work, str(work / "N.txt"), "post", str(work / "M.nc1"), str(work / "N.txt"))
        == REFUSED
    )


@pytest.mark.parametrize("file", ["M.nc1", "mine.toml"])
@pytest.mark.parametrize("command", ["post", "plan"])
def test_what_is_called_as_no_output_is(work: Path, command: str, file: str) -> None:
    """It is refused before anything is read, by its name alone."""
    before = (work / file).read_bytes()
    words = [command, str(work / "M.nc1"), "--machine", str(work / "mine.toml")]
    call(*words, "-o", work / file, status=2)
    assert (work / file).read_bytes() == before


@pytest.mark.parametrize("name", NAMES)
def test_the_other_commands(work: Path, name: Callable[[Path], str]) -> None:
    program = work / "M.gcode"
    assert tried(work, name(work / "M.txt"), "plan", str(work / "M.txt")) == REFUSED
    assert tried(work, str(work / "M.nc1"), "convert", str(work / "M.nc1")) == REFUSED
    os.link(program, work / "trace.csv")
    assert tried(work, str(work / "trace.csv"), "simulate", str(program)) == REFUSED


@pytest.mark.parametrize("link", [os.link, os.symlink])
@pytest.mark.parametrize(
    ("command", "source", "suffix"),
    [
        ("post", "M.nc1", ".ngc"), ("plan", "M.nc1", ".txt"), ("convert", "M.nc1", ".dxf"),
        ("convert", "M.nc1", ".json"), ("plot", "M.nc1", ".png"), ("report", "M.nc1", ".html"),
        ("list", "M.nc1", ".csv"), ("labels", "M.nc1", ".pdf"), ("simulate", "M.gcode", ".csv"),
        ("recover", "M.gcode", ".nc1"),
    ],
)  # fmt: skip
def test_each_command(
    work: Path, command: str, source: str, suffix: str, link: Callable[[Path, Path], None]
) -> None:
    """The output is the input by another name, with the suffix of what the command writes."""
    output = work / f"out{suffix}"
    link(work / source, output)
    more = ("--profile", "UPN200") if command == "recover" else ()
    assert tried(work, str(output), command, str(work / source), *more) == REFUSED


def test_a_unit_beside_the_program(work: Path) -> None:
    """A trigger program of several units is refused before the first of them is written."""
    source = work / "unit_x_1.st"
    shutil.copy(work / "gusset.nc1", source)
    asked = ("post", str(source), "--machine", "table-simotion", "--style", "table", "--job", "x")
    assert tried(work, str(work / "x.st"), *asked) == REFUSED
    assert not (work / "x.st").exists()


def test_batch_and_its_report(work: Path) -> None:
    link = hard(work / "job.toml")
    out = work / "out"
    out.mkdir()
    os.link(work / "M.nc1", out / "M.gcode")
    before = (work / "M.nc1").read_bytes()
    result = batch(work / "M.nc1", "-o", out, "--config", work / "job.toml", "--force", status=1)
    assert "batch-over-input" in result.stderr
    (work / "job.json").symlink_to(link)
    report = ("--report", work / "job.json", "--config", work / "job.toml")
    result = batch(work / "M.nc1", "-o", work / "out2", *report, status=1)
    assert "write-over-input" in result.stderr
    assert (work / "M.nc1").read_bytes() == before
    assert (work / "job.toml").read_text() == 'job = "A"\n'


def test_another_file_and_a_device_may_be_written(work: Path) -> None:
    read = FilesRead([str(work / "M.nc1"), "/dev/null", str(work / "none")])
    assert read.written_over_by(str(work / "M.gcode")) is None
    assert read.written_over_by(str(work / "new")) is None
    assert read.written_over_by(os.devnull) is None
    assert read.written_over_by("a\0b") is None


def test_where_the_system_numbers_no_files(work: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Some file systems give each file the number 0; then the real path tells."""
    real = os.stat

    def unnumbered(path: str) -> os.stat_result:
        return os.stat_result((real(path).st_mode, 0, *real(path)[2:]))

    monkeypatch.setattr("beamcam.files.os.stat", unnumbered)
    read = FilesRead([str(work / "M.nc1")])
    assert read.written_over_by(relative(work / "M.nc1")) == str(work / "M.nc1")
    assert read.written_over_by(str(work / "gusset.nc1")) is None
