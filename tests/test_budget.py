"""Amounts: what a small file may ask for, refused by name where it multiplies, or made in time."""

import io
import json
import os
import struct
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import ezdxf
import pypdfium2
import pytest

from beamcam import api
from beamcam.budget import MAX_DEPTH, InForce, LimitError, Limits
from beamcam.errors import PlanError
from beamcam.readers import read
from beamcam.system import is_windows
from tests.conftest import ROOT
from tests.runs import call

TIE = (ROOT / "samples" / "dstv" / "tie.nc1").read_text("ascii")
TOO_MANY = 999_999_999


def tie(mark: str = "T1", quantity: int = 2) -> str:
    """The sample with another mark and quantity."""
    text = TIE.replace("\n  T1\n", f"\n  {mark}\n").replace("\n  2\n", f"\n  {quantity}\n", 1)
    assert text != TIE or (mark, quantity) == ("T1", 2)
    return text


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, "ascii")
    return path


@pytest.fixture(autouse=True)
def _limits_of_others() -> object:
    """The limits are those of the process; no test leaves its own behind."""
    yield
    InForce.limits = Limits()


# --- pieces ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("words", [
    ("list",), ("labels", "-o", "l.pdf"), ("labels", "-o", "l.zpl"),
])  # fmt: skip
def test_of_too_many_pieces_the_other_parts_are_listed(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    jobs = tmp_path / "jobs"
    jobs.mkdir()
    written(jobs, "bad.nc1", tie("BAD", TOO_MANY))
    written(jobs, "good.nc1", tie("GOOD", 3))
    done = call(words[0], "jobs", *words[1:], status=1)
    assert f"bad.nc1:1: error limit-pieces: found {TOO_MANY} pieces; expected" in done.stderr
    made = done.stdout
    if len(words) > 1:
        data = (tmp_path / words[2]).read_bytes()
        made = data.decode() if words[2] == "l.zpl" else "\n".join(
            page.get_textpage().get_text_range() for page in pypdfium2.PdfDocument(data)
        )  # fmt: skip
    assert "GOOD" in made
    assert "BAD" not in made


@pytest.mark.parametrize("words", [
    ("post", "-o", "x.gcode", "--bar", "12000"), ("post", "-o", "x.gcode"),
    ("plan",), ("report", "-o", "x.html"),
    ("batch", "-o", "out"),
])  # fmt: skip
def test_a_job_of_too_many_pieces_is_refused_by_name(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, "bad.nc1", tie("BAD", TOO_MANY))
    done = call(words[0], path, *words[1:], "--quantity", "file", status=1)
    assert f"bad.nc1:1: error limit-pieces: found {TOO_MANY} pieces; expected" in done.stderr
    assert "plan-ways-out" not in done.stderr
    assert not list(tmp_path.glob("x.*"))


def test_a_program_is_not_compared_with_too_many_pieces(tmp_path: Path) -> None:
    path = written(tmp_path, "bad.nc1", tie("BAD", TOO_MANY))
    program = tmp_path / "tie.gcode"
    assert call("post", ROOT / "samples/dstv/tie.nc1", "-o", program).exit_code == 0
    done = call("verify", program, "--against", path, "--quantity", "file")
    assert (done.exit_code, "limit-pieces" in done.stderr) == (1, True)


def test_parts_share_the_pieces_of_a_run(tmp_path: Path) -> None:
    """None has too many by itself; the one that goes beyond is named, those before are made."""
    written(tmp_path, "beamcam.toml", "[limits]\npieces = 1000\n")
    for number in range(3):
        written(tmp_path, f"p{number}.nc1", tie(f"T{number}", 400))
    done = call("list", tmp_path, "--trust", tmp_path)
    assert "p2.nc1:1: error limit-pieces: found 400 pieces beside 800 of other" in done.stderr
    assert done.stderr.count("limit-pieces") == 1


def test_the_configuration_has_other_limits(tmp_path: Path) -> None:
    path = written(tmp_path, "p.nc1", tie("T7", 30))
    assert call("list", path).exit_code == 0
    written(tmp_path, "beamcam.toml", "[limits]\npieces = 20\n")
    assert call("list", path).exit_code == 0  # they are the shop's to say
    done = call("list", path, "--trust", tmp_path)
    assert (done.exit_code, "expected at most 20, or another `limits.pieces`" in done.stderr) == (
        1, True,
    )  # fmt: skip
    assert InForce.limits == Limits(pieces=20)
    (tmp_path / "beamcam.toml").unlink()
    assert call("list", path).exit_code == 0


@pytest.mark.parametrize("row", ["pieces = 0", "member_s = 0", "depth = 9999", "blocks = 3"])
def test_limits_are_checked_like_other_keys(row: str, tmp_path: Path) -> None:
    written(tmp_path, "beamcam.toml", f"[limits]\n{row}\n")
    done = call("list", written(tmp_path, "p.nc1", tie()), status=1)
    assert f"beamcam.toml:2: error config-{'key' if 'blocks' in row else 'value'}" in done.stderr


def test_a_batch_in_other_processes_has_the_limits_too(tmp_path: Path) -> None:
    jobs = tmp_path / "jobs"
    jobs.mkdir()
    for number in range(3):
        written(jobs, f"p{number}.nc1", tie(f"T{number}", 30))
    written(jobs, "beamcam.toml", "[limits]\npieces = 20\n")
    done = call("batch", jobs, "-o", tmp_path / "out", "--quantity", "file", "--jobs", "2",
               "--trust", jobs)  # fmt: skip
    assert done.stderr.count("error limit-pieces") == 3


def test_python_is_refused_too() -> None:
    parts = api.read(ROOT / "samples/dstv/tie.nc1").parts
    for ask in (api.lists, api.labels):
        with pytest.raises(LimitError) as told:
            ask(parts, quantity=TOO_MANY)
        assert [one.code for one in told.value.diagnostics] == ["limit-pieces"]


def test_ten_thousand_pieces_are_listed_one_by_one(tmp_path: Path) -> None:
    for kind in range(10):
        written(tmp_path, f"p{kind}.nc1", tie(f"T{kind}", 1000))
    output = tmp_path / "list.json"
    assert call("list", tmp_path, "--bar", "12000", "-o", output).exit_code == 0
    found = json.loads(output.read_text("utf-8"))
    assert len(found["cutting_list"]) == 10_000
    assert sum(row["pieces"] for row in found["bars"]) == 10_000


# --- labels ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("code", ["qr", "datamatrix"])
@pytest.mark.parametrize("suffix", ["pdf", "zpl"])
def test_one_label_that_cannot_be_made_is_one_message(
    code: str, suffix: str, tmp_path: Path
) -> None:
    jobs = tmp_path / "jobs"
    jobs.mkdir()
    written(jobs, "long.nc1", tie("M" * 2400, 5))
    written(jobs, "short.nc1", tie("SHORT", 4))
    output = tmp_path / f"l.{suffix}"
    done = call("labels", jobs, "-o", output, "--code", code, status=1)
    assert done.stderr.count("error label-code: found 24") == 1
    data = output.read_bytes()
    made = len(pypdfium2.PdfDocument(data)) if suffix == "pdf" else data.count(b"^XA")
    assert made == 4


@pytest.mark.parametrize(("code", "most"), [("qr", 2331), ("datamatrix", 1553)])
def test_the_longest_code_can_be_made(code: str, most: int) -> None:
    """Its length is a constant of the standard; the libraries say whether it is right."""
    (part,) = api.read(ROOT / "samples/dstv/tie.nc1").parts
    for sign in ("m", "ö"):
        text = sign * ((most - len("T1\n")) // len(sign.encode()))
        assert api.labels(part, quantity=1, code=code, programs=[text])  # type: ignore[arg-type]
    with pytest.raises(PlanError) as told:
        api.labels(part, quantity=1, code=code, programs=["m" * most])  # type: ignore[arg-type]
    assert "label-code" in str(told.value)


def test_the_labels_of_a_part_share_the_drawing_of_their_code(tmp_path: Path) -> None:
    """Drawing a code takes ten times as long as the rest of a label."""
    sizes = []
    for quantity in (1, 101):
        output = tmp_path / f"{quantity}.pdf"
        path = written(tmp_path, f"p{quantity}.nc1", tie("T5", quantity))
        assert call("labels", path, "-o", output).exit_code == 0
        sizes.append(output.stat().st_size)
    assert (sizes[1] - sizes[0]) / 100 < 1000


# --- bytes ----------------------------------------------------------------------------------------


DOORS: tuple[tuple[str, ...], ...] = (
    ("inspect",), ("convert", "-o", "x.json"), ("post", "-o", "x.gcode"), ("plan",),
    ("verify",), ("recover", "-o", "x.nc1"), ("plot", "-o", "x.svg"), ("report", "-o", "x.html"),
    ("list",), ("labels", "-o", "x.zpl"), ("simulate", "-o", "x.csv"), ("batch", "-o", "out"),
)  # fmt: skip


@pytest.mark.skipif(is_windows(), reason="has no pipes in folders, and no devices")
@pytest.mark.parametrize("door", DOORS, ids=lambda door: door[0])
def test_a_pipe_and_a_device_are_refused_and_not_waited_for(
    door: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.nc1")
    Path("endless.nc1").symlink_to("/dev/zero")
    for name in ("pipe.nc1", "endless.nc1"):
        done = call(door[0], name, *door[1:], status=1)
        assert f"{name}: error read-not-a-file: found a pipe or a device" in done.stderr


@pytest.mark.skipif(is_windows(), reason="has no pipes in folders, and no devices")
@pytest.mark.parametrize("option", ["--config", "--machine"])
def test_settings_are_no_pipes_either(
    option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.toml")
    Path("endless.toml").symlink_to("/dev/zero")
    for name in ("pipe.toml", "endless.toml"):
        done = call("post", ROOT / "samples/dstv/tie.nc1", "-o", "x.gcode", option, name)
        assert done.exit_code in (1, 2)
        assert name in done.stderr


def test_an_input_of_too_many_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path, "beamcam.toml", "[limits]\nbytes = 500\n")
    path = written(tmp_path, "p.nc1", tie())
    done = call("inspect", path)
    found = f"p.nc1: error limit-bytes: found {len(tie())} bytes; expected at most 500"
    assert (done.exit_code, found in done.stderr) == (1, True)
    done = call("inspect", "-", "--config", tmp_path / "beamcam.toml", stdin=tie())
    assert (done.exit_code, "stdin: error limit-bytes: found" in done.stderr) == (1, True)


def test_an_archive_whose_directory_lies_about_its_size() -> None:
    """200 kB that unpack to 200 MB: unpacked in pieces, and only as far as the directory says."""
    data = lying_archive(200, 1_000_000)
    assert len(data) < 400_000
    tracemalloc.start()
    try:
        reading = read(data, "lie.ifczip")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert [said.code for said in reading.diagnostics] == ["ifc-syntax"]
    assert peak < 100_000_000


def test_an_archive_unpacks_to_no_more_than_the_limit() -> None:
    text = (ROOT / "samples/ifc/beam_brep.ifc").read_bytes()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("m.ifc", text)
    assert not read(packed.getvalue(), "m.ifczip").refused
    InForce.limits = Limits(bytes=len(text) - 1)
    (said,) = read(packed.getvalue(), "m.ifczip").diagnostics
    assert f"an archive that unpacks to more than {len(text) - 1} bytes" in said.message


def lying_archive(pieces: int, size: int) -> bytes:
    """A deflated file of `pieces` times `size` blanks, of which the directory says 1,000 bytes."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    blank = b" " * size
    packed = b"".join([*(packer.compress(blank) for _ in range(pieces)), packer.flush()])
    name, crc, told = b"m.ifc", zlib.crc32(b" " * 1000), 1000
    local = struct.pack("<4s5H3I2H", b"PK\3\4", 20, 0, 8, 0, 33, crc, len(packed), told, 5, 0)
    central = struct.pack(
        "<4s6H3I5H2I", b"PK\1\2", 20, 20, 0, 8, 0, 33, crc, len(packed), told, 5, 0, 0, 0, 0, 0, 0
    )
    at = len(local) + len(name) + len(packed)
    end = struct.pack("<4s4H2IH", b"PK\5\6", 0, 0, 1, 1, len(central) + len(name), at, 0)
    return local + name + packed + central + name + end


# --- depth ----------------------------------------------------------------------------------------


def nested_blocks(count: int, path: Path) -> Path:
    """A triangle in a block in a block, and so on."""
    document = ezdxf.new(units=4)
    corners = [(0, 0), (50, 0), (50, 50)]
    for number in range(count):
        block = document.blocks.new(f"B{number}")
        if number:
            block.add_blockref(f"B{number - 1}", (0, 0))
        else:
            block.add_lwpolyline(corners, close=True)
    document.modelspace().add_blockref(f"B{count - 1}", (0, 0))
    document.saveas(path)
    return path


def test_blocks_in_blocks(tmp_path: Path) -> None:
    assert call("inspect", nested_blocks(100, tmp_path / "a.dxf")).exit_code == 0
    for count in (101, 1000):
        done = call("inspect", nested_blocks(count, tmp_path / f"{count}.dxf"), status=1)
        assert "error limit-depth: found the block 'B" in done.stderr
        assert "expected at most 100, or another `limits.depth` in beamcam.toml" in done.stderr


def test_the_deepest_limit_is_one_that_can_be_walked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path, "beamcam.toml", f"[limits]\ndepth = {MAX_DEPTH}\n")
    assert call("inspect", nested_blocks(MAX_DEPTH, tmp_path / "a.dxf")).exit_code == 0


# --- programs -------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["", "\n", "% EMPTY\n", "(nothing)\n"])
@pytest.mark.parametrize("suffix", ["pdf", "html"])
def test_a_sheet_for_a_program_that_does_nothing(text: str, suffix: str, tmp_path: Path) -> None:
    program = written(tmp_path, "empty.gcode", text)
    output = tmp_path / f"x.{suffix}"
    done = call("report", program, "-o", output)
    assert done.exit_code in (0, 1)
    assert done.exit_code == 1 or output.read_bytes()


# --- members of models ----------------------------------------------------------------------------


def test_a_member_has_its_time_and_no_more() -> None:
    """The others are read, and the ledger has all of them."""
    data = (ROOT / "samples/ifc/beam_brep.ifc").read_bytes()
    assert not read(data, "m.ifc").refused
    InForce.limits = Limits(member_s=1e-9)
    reading = read(data, "m.ifc")
    told = [said for said in reading.diagnostics if said.code == "limit-member-s"]
    assert told
    assert all("expected at most 1e-09 s of the processor" in said.message for said in told)
    assert all(said.source.where for said in told)
    assert not reading.parts
    InForce.limits = Limits()
    assert not read(data, "m.ifc").refused
