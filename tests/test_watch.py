"""A hot folder: what is complete, what is left, where files go."""

import os
import signal
import subprocess
import sys
import time
from itertools import count
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.batch.find import SUFFIXES, Input
from beamcam.commands.watch import AGAIN_S, HotFolder, Stamp, file_away, look
from beamcam.readers import has_end
from tests.conftest import ROOT, SAMPLES, examples
from tests.runs import BAD, HANG_S, batch, counts, fill, part, programs, wait_until

A, B = Input("hot/a.nc1", "a.nc1"), Input("hot/b.nc1", "b.nc1")


def stamp(size: int) -> Stamp:
    return size, 1, 1


def test_a_file_is_taken_when_it_stays_the_same() -> None:
    hot = HotFolder(2.0, ends=lambda path: True)
    assert hot.take({A: stamp(1)}, 0.0) == ()
    assert hot.take({A: stamp(2)}, 1.5) == ()  # it grew
    assert hot.take({A: stamp(2), B: stamp(1)}, 3.0) == ()
    assert hot.is_waiting
    assert hot.take({A: stamp(2), B: stamp(1)}, 3.5) == (A,)
    assert hot.take({A: stamp(2), B: stamp(1)}, 5.0) == (B,)
    assert not hot.is_waiting
    assert hot.take({A: stamp(2), B: stamp(1)}, 99.0) == ()
    assert hot.take({B: stamp(1)}, 100.0) == ()
    assert hot.take({A: stamp(2), B: stamp(9)}, 101.0) == ()  # both are new
    assert hot.take({A: stamp(2), B: stamp(9)}, 103.0) == (A, B)


def test_what_failed_is_tried_again_later() -> None:
    hot = HotFolder(1.0)
    hot.take({A: stamp(1)}, 0.0)
    assert hot.take({A: stamp(1)}, 1.0) == (A,)
    hot.again(A, 1.0)
    assert hot.take({A: stamp(1)}, AGAIN_S + 1.9) == ()
    assert hot.take({A: stamp(1)}, AGAIN_S + 2.0) == (A,)


@settings(max_examples=examples(200), deadline=None)
@given(st.lists(st.tuples(st.floats(0.01, 5), st.integers(0, 2)), min_size=1, max_size=30))
def test_nothing_is_taken_early_twice_or_never(looks: list[tuple[float, int]]) -> None:
    """A size is taken only after it stood for the time to settle, once, and in the end always."""
    hot, now, since, last, taken = HotFolder(2.0, ends=lambda path: True), 0.0, 0.0, -1, False
    for step, size in looks:
        now += step
        if size != last:
            since, last, taken = now, size, False
        ready = hot.take({A: stamp(size)}, now)
        assert ready == ((A,) if now - since >= 2.0 and not taken else ())
        taken = taken or bool(ready)
    assert taken or hot.take({A: stamp(last)}, now + 2.5) == (A,)


IFC = "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=IFCPERSON($);\nENDSEC;\nEND-ISO-10303-21;\n"
DXF = "  0\nSECTION\n  1\nTEXT EOF\n  1\n  0\n  0\nENDSEC\n  0\nEOF\n"
BINARY_DXF = b"AutoCAD Binary DXF\r\n\x1a\0\0\0SECTION\0\1\0EOF\0x\0\0\0ENDSEC\0\0\0EOF\0"
SVG = "<svg>\n<!-- </svg> -->\n<g><svg><path/></svg>\n</g></svg>\n"
JSON = '{"parts": [{"mark": "A }"}, {"mark": "B"}]}\n'


@pytest.mark.parametrize(
    ("name", "data", "whole"),
    [
        ("a.nc1", part("A").encode(), len(part("A").rstrip())),
        ("a.nc", part("A").replace("\n", "\r").encode() + b"\x1a", len(part("A").rstrip())),
        ("a.NC1", part("A").encode("utf-16-le"), 2 * len(part("A").rstrip()) - 1),
        ("a.ifc", IFC.encode(), len(IFC.rstrip())),
        ("a.json", JSON.encode(), len(JSON.rstrip())),
        ("a.dxf", DXF.encode(), len(DXF.rstrip())),
        ("a.dxf", DXF.replace("\n", "\r\n").encode(), len(DXF.replace("\n", "\r\n").rstrip())),
        ("a.dxf", BINARY_DXF, len(BINARY_DXF)),
        ("a.svg", SVG.encode(), len(SVG.rstrip())),
        ("a.svg", b"<?xml?><s:svg><s:svg/></s:svg>\n", 30),
        ("a.svg", b"<svg width='9'/>", 16),
    ],
)
def test_no_part_of_a_file_has_its_end(tmp_path: Path, name: str, data: bytes, whole: int) -> None:
    path = tmp_path / name
    for size in range(1, len(data) + 1):
        path.write_bytes(data[:size])
        assert has_end(str(path)) == (size >= whole), data[:size]


def test_every_sample_has_its_end() -> None:
    samples = [
        path for path in SAMPLES.rglob("*") if path.suffix in SUFFIXES and "bad" not in path.parts
    ]
    assert len(samples) > 20
    assert [path for path in samples if not has_end(str(path))] == []
    assert has_end("gone.nc1")  # its reader says what is wrong


@settings(max_examples=examples(100), deadline=None)
@given(st.integers(1, 20), st.floats(3, 50), st.floats(0.3, 2.5))
def test_a_writer_that_pauses(written: int, pause: float, every: float) -> None:
    """A file whose writer pauses is handed over once, whole, and not before."""
    ends: set[str] = set()
    hot = HotFolder(2.0, 60.0, ends.__contains__)
    now, until = 0.0, pause
    while now < until:
        assert hot.take({A: stamp(written)}, now) == ()
        now += every
    ends.add(A.path)
    assert hot.take({A: stamp(written + 1)}, now) == ()
    assert hot.take({A: stamp(written + 1)}, now + 2.1) == (A,)
    assert hot.endless == ()


def test_a_file_that_never_ends_is_told_once() -> None:
    hot = HotFolder(2.0, 60.0, lambda path: False)
    assert hot.take({A: stamp(1)}, 0.0) == hot.take({A: stamp(1)}, 59.9) == ()
    assert hot.is_waiting
    assert hot.take({A: stamp(1)}, 60.0) == hot.endless == (A,)
    hot.again(A, 60.0)  # the disk was full
    assert hot.take({A: stamp(1)}, 62.0 + AGAIN_S) == (A,)
    assert hot.endless == ()


def test_the_end_that_is_missing_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A whole run on a clock that goes on by itself: torn at first, then written on."""
    fill(tmp_path / "hot", 1)
    torn = tmp_path / "hot" / "torn.nc1"
    torn.write_text(part("T").removesuffix("EN\n"))
    monkeypatch.setattr(time, "monotonic", count(0, 1).__next__)
    slept: list[float] = []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) == 50:
            torn.write_text(part("T"))

    monkeypatch.setattr(time, "sleep", sleep)
    result = batch(tmp_path / "hot", "-o", tmp_path / "out", "--once", command="watch")
    assert counts(result) == (2, 0, 0, 0)
    assert "batch-no-end" not in result.stderr
    torn.write_text(part("T").removesuffix("EN\n"))
    result = batch(tmp_path / "hot", "-o", tmp_path / "out", "--once", "--end-wait", 20,
                   command="watch")  # fmt: skip
    assert (
        result.stderr.count("torn.nc1: warning batch-no-end: found no end of the file for 20 s")
        == 1
    )
    assert counts(result)[1] == 1


def test_looking_at_what_has_gone(tmp_path: Path) -> None:
    (tmp_path / "a.nc1").write_text("x")
    here = Input(str(tmp_path / "a.nc1"), "a.nc1")
    stamps = look((here, Input(str(tmp_path / "gone.nc1"), "gone.nc1")))
    assert list(stamps) == [here]
    assert stamps[here][0] == 1  # byte


def test_filing_away_writes_over_nothing(tmp_path: Path) -> None:
    for text in ("first", "second", "third"):
        (tmp_path / "a.nc1").write_text(text)
        file_away(Input(str(tmp_path / "a.nc1"), "sub/a.nc1"), str(tmp_path / "done"))
    assert {name: text.decode() for name, text in programs(tmp_path / "done").items()} == {
        "sub/a.nc1": "first", "sub/a-2.nc1": "second", "sub/a-3.nc1": "third",
    }  # fmt: skip


def test_once(tmp_path: Path) -> None:
    fill(tmp_path / "hot", 3, bad=1)
    result = batch(tmp_path / "hot", "-o", tmp_path / "out", "--once", "--settle", 0,
                   command="watch", status=1)  # fmt: skip
    assert counts(result) == (2, 0, 1, 0)
    assert sorted(programs(tmp_path / "out")) == ["P000.gcode", "P002.gcode"]
    result = batch(tmp_path / "hot", "-o", tmp_path / "out", "--once", "--settle", 0,
                   command="watch")  # fmt: skip
    assert counts(result) == (0, 2, 1, 0)


def test_files_go_to_their_folders(tmp_path: Path) -> None:
    hot = tmp_path / "hot"
    fill(hot / "sub", 3, bad=1)
    batch(hot, "-o", hot / "out", "--done", hot / "done", "--refused", hot / "refused", "--once",
          "--settle", 0, command="watch")  # fmt: skip
    assert sorted(programs(hot)) == [
        "done/sub/P000.nc1", "done/sub/P002.nc1", "out/sub/P000.gcode", "out/sub/P002.gcode",
        "refused/sub/P001.nc1", "refused/sub/P001.nc1.txt",
    ]  # fmt: skip
    said = (hot / "refused" / "sub" / "P001.nc1.txt").read_text()
    assert f"{hot}/sub/P001.nc1:28: error plan-tool: " in said


def test_an_empty_folder_is_nothing_wrong(tmp_path: Path) -> None:
    (tmp_path / "hot").mkdir()
    result = batch(tmp_path / "hot", "-o", tmp_path / "out", "--once", command="watch", status=0)
    assert result.stderr == (
        f"watching {tmp_path / 'hot'} every 1 s, programs go to {tmp_path / 'out'}\n"
        "0 posted, 0 unchanged, 0 refused, 0 failed\n"
    )


def test_no_folder(tmp_path: Path) -> None:
    result = batch(tmp_path / "none", "-o", tmp_path / "out", command="watch", status=2)
    (tmp_path / "hot").mkdir()
    (tmp_path / "file").write_text("")
    result = batch(tmp_path / "hot", "-o", tmp_path / "file", command="watch", status=1)
    assert "batch-write" in result.stderr


def test_a_file_that_is_still_being_written_is_left(tmp_path: Path) -> None:
    """A whole run: a file grows, is posted when it is complete, and the command ends when asked."""
    hot, out = tmp_path / "hot", tmp_path / "out"
    hot.mkdir()
    command = [sys.executable, "-m", "beamcam", "watch", str(hot), "-o", str(out),
               "--settle", "0", "--every", "0.02", "-v"]  # fmt: skip
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE)
    text = part("SLOW")
    with open(hot / "slow.nc1", "w") as file:
        for k in range(4):
            file.write(text[k * len(text) // 4 : (k + 1) * len(text) // 4])
            file.flush()
            os.fsync(file.fileno())
            if k < 3:
                # Where a file that came later is posted, the folder was looked at meanwhile.
                (hot / f"later{k}.nc1").write_text(part(f"L{k}"))
                wait_until((out / f"later{k}.gcode").exists, process)
                assert not (out / "slow.gcode").exists()
    wait_until((out / "slow.gcode").exists, process)
    (hot / "bad.nc1").write_text(BAD)
    (hot / "last.nc1").write_text(part("LAST"))
    wait_until((out / "last.gcode").exists, process)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=HANG_S)[1].decode()
    assert process.returncode == 130
    # Had the half of it been read, it would have been refused at first.
    assert said.count("slow.nc1: refused") == 0
    assert said.count("slow.nc1: posted") == 1
    assert said.splitlines()[-1].startswith("5 posted, 0 unchanged, ")
    assert "Traceback" not in said
    assert (out / "slow.gcode").read_bytes().endswith(b"M30\n%\n")
