"""Files are written whole or not at all."""

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from beamcam import files
from beamcam.files import write_new, write_whole


@pytest.fixture(params=["unnamed", "unnamed without links", "named"], autouse=True)
def system(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Each test runs on a system with unnamed files, on one that cannot name them, and without."""
    if request.param == "named":
        monkeypatch.setattr(files, "_UNNAMED", 0)
    elif not files._UNNAMED:
        pytest.skip("this system has no unnamed files")
    elif request.param == "unnamed without links":
        monkeypatch.setattr(files, "_link", lambda *_: False)
    return str(request.param)


def test_writes_and_replaces(tmp_path: Path) -> None:
    path = tmp_path / "a b ü.gcode"
    write_whole(path, "N1\n")
    write_whole(path, b"N2\n")
    assert path.read_bytes() == b"N2\n"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_failure_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.gcode"
    write_whole(path, "old")

    def fail(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_whole(path, "new")
    monkeypatch.undo()
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.gcode"]


def test_no_folder(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        write_whole(tmp_path / "none" / "a.gcode", "x")


def test_mode_follows_the_umask_and_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.gcode"
    mask = os.umask(0o027)
    try:
        write_whole(path, "x")
    finally:
        os.umask(mask)
    assert path.stat().st_mode & 0o777 == 0o640
    path.chmod(0o600)
    write_whole(path, "y")
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_link_is_written_through(tmp_path: Path) -> None:
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("old")
    link.symlink_to(target)
    write_whole(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"


@pytest.mark.parametrize("durable", [True, False])
def test_pieces_are_joined(tmp_path: Path, durable: bool) -> None:
    path = tmp_path / "a.gcode"
    write_whole(path, (b"N%d\n" % n for n in range(3)), durable=durable)
    assert path.read_bytes() == b"N0\nN1\nN2\n"


def test_a_failure_in_a_piece_leaves_nothing(tmp_path: Path) -> None:
    def pieces() -> Iterator[bytes]:
        yield b"N1\n"
        raise ValueError("no more")

    with pytest.raises(ValueError, match="no more"):
        write_whole(tmp_path / "a.gcode", pieces())
    assert list(tmp_path.iterdir()) == []


def test_a_new_file_is_written_where_none_is(tmp_path: Path, system: str) -> None:
    """Only a system with unnamed files can do so at once; any other leaves it to write_whole."""
    at_once = system == "unnamed"
    assert write_new(str(tmp_path), "a", b"N1\n") == at_once
    assert [p.read_bytes() for p in tmp_path.iterdir()] == ([b"N1\n"] if at_once else [])


def test_a_new_file_leaves_what_is_there(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    (tmp_path / "folder").mkdir()
    for name in ("a", "link", "folder"):
        assert not write_new(str(tmp_path), name, b"new")
    assert not write_new(str(tmp_path / "none"), "a", b"new")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "folder", "link"]
    assert (tmp_path / "a").read_text() == "old"


def test_a_new_file_that_finds_no_room_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, system: str
) -> None:
    def full(file: int, data: bytes) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "write", full)
    if system != "named":
        with pytest.raises(OSError, match="No space left"):
            write_new(str(tmp_path), "a", b"N1\n")
    assert list(tmp_path.iterdir()) == []


def test_only_a_durable_file_waits_for_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, system: str
) -> None:
    waited: list[int] = []
    monkeypatch.setattr(os, "fsync", waited.append)
    write_whole(tmp_path / "a", "x", durable=False)
    assert waited == []
    write_whole(tmp_path / "a", "x")
    assert len(waited) == (2 if system == "unnamed without links" else 1)


def test_the_system_may_take_a_piece_in_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = os.write
    monkeypatch.setattr(os, "write", lambda file, data: real(file, bytes(data[:3])))
    write_whole(tmp_path / "a", "0123456789")
    monkeypatch.undo()
    assert (tmp_path / "a").read_text() == "0123456789"


def test_a_part_left_by_a_dead_process_is_replaced(tmp_path: Path) -> None:
    (tmp_path / f".a.{os.getpid()}.part").write_text("half")
    (tmp_path / "a").write_text("old")
    write_whole(tmp_path / "a", "whole")
    assert [p.name for p in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_text() == "whole"


def test_a_dangling_link_gets_its_target(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "target").read_text() == "new"


def test_a_process_that_is_killed_leaves_nothing(tmp_path: Path, system: str) -> None:
    if system != "unnamed":
        return  # a temporary name stays behind where there are no unnamed files
    code = (
        "import os, signal, sys\n"
        "from beamcam.files import write_whole\n"
        "def pieces():\n"
        "    yield b'half'\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
        "write_whole(sys.argv[1], pieces())\n"
    )
    path = tmp_path / "a.gcode"
    for old in (None, "old"):
        if old:
            path.write_text(old)
        done = subprocess.run([sys.executable, "-c", code, str(path)], check=False)
        assert done.returncode == -signal.SIGKILL
        assert [p.read_text() for p in tmp_path.iterdir()] == ([old] if old else [])


@pytest.mark.parametrize("linked", [False, True])
def test_a_pipe_is_written_to_and_stays_one(tmp_path: Path, linked: bool) -> None:
    """As a shell's redirection does: -o /dev/null has to leave the device where it is."""
    pipe = target = tmp_path / "pipe"
    os.mkfifo(pipe)
    if linked:
        target = tmp_path / "link"
        target.symlink_to(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_whole(target, [b"a", b"b"])
        assert os.read(reader, 10) == b"ab"
    finally:
        os.close(reader)
    assert pipe.is_fifo()
    assert {path.name for path in tmp_path.iterdir()} == {"pipe", target.name}
