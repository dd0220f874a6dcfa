"""A part with odd marks posts, and neither its program nor what is printed of it obeys them."""

import json
import re
from pathlib import Path

import pytest

from tests.conftest import SAMPLES
from tests.rs274 import INI, interpreted, needs_rs274
from tests.runs import call, part

ODD = "M\x1b[2J\x9b\u202e\u2028G0 X9)\x85(MSG,%;\x0b\x0c"
#: What a line of a program of each machine may hold.
PLAIN = re.compile(r"[\x20-\x7e]*")


def odd_json(tmp_path: Path, sample: str, mark: str = ODD) -> Path:
    """The JSON form of a sample, with odd text wherever there is text but a name of a layer."""
    path = tmp_path / "odd.json"
    source = SAMPLES / sample
    assert call("convert", source, "-o", path).exit_code == 0
    value = json.loads(path.read_text(encoding="utf-8"))
    value |= {"mark": mark, "order": mark, "drawing": mark, "phase": mark, "notes": [mark]}
    value["profile"]["name"] = mark
    path.write_text(json.dumps(value), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("sample", "machine", "suffix"),
    [
        ("dstv/channel.nc1", "beamline", ".gcode"),
        ("dstv/channel.nc1", "beamline-annex", ".gcode"),
        ("dstv/gusset.nc1", "plate-linuxcnc", ".ngc"),
        ("dstv/gusset.nc1", "plate-codesys", ".gcode"),
    ],
)
def test_an_odd_mark_posts(tmp_path: Path, sample: str, machine: str, suffix: str) -> None:
    source, out = odd_json(tmp_path, sample), tmp_path / f"o{suffix}"
    asked = ["post", str(source), "--machine", machine, "-o", str(out), "--job", "Träger (5) %;"]
    call(*asked, status=0)
    lines = out.read_text(encoding="utf-8").split("\n")
    assert all(PLAIN.fullmatch(line) for line in lines)
    call("post", SAMPLES / sample, "--machine", machine, "-o", tmp_path / "p.x", status=0)
    # Comments apart the program is that of the plain part.
    assert _blocks(lines) == _blocks((tmp_path / "p.x").read_text().split("\n"))


def _blocks(lines: list[str]) -> list[str]:
    return [line for line in lines if not line.startswith(("(", "%"))]


@needs_rs274
@pytest.mark.parametrize("job", ["LOGOPEN,gone", "  m s g, hello", "PROBEOPEN gone", "x" * 200])
def test_no_comment_is_a_command(tmp_path: Path, job: str) -> None:
    out = tmp_path / "o.ngc"
    source = str(SAMPLES / "dstv/gusset.nc1")
    asked = ["post", source, "--machine", "plate-linuxcnc", "--job", job, "-o", str(out)]
    assert call(*asked).exit_code == 0
    run = interpreted(out, ini=INI, folder=tmp_path)
    assert run.returncode == 0, run.stderr
    assert "MESSAGE(" not in run.stdout
    assert not (tmp_path / "gone").exists()


@pytest.mark.parametrize(
    "words",
    [
        ["inspect"],
        ["inspect", "--json"],
        ["plan"],
        ["plan", "--json"],
        ["post", "-o", "-", "-v"],
        ["convert", "-o", "-", "--to", "part-json"],
    ],
)
def test_nothing_that_is_printed_steers_the_terminal(tmp_path: Path, words: list[str]) -> None:
    source = odd_json(tmp_path, "dstv/channel.nc1", ODD + "\ud800")
    result = call(words[0], source, *words[1:])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    for line in (result.stdout + result.stderr).split("\n"):
        assert line.isprintable(), line


def test_nothing_of_a_batch_steers_the_terminal(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "a\x1b[2J\u202e.nc1").write_text(part("M\x1b[2J"), encoding="utf-8")
    for report in ("-", "r.html", "r.csv"):
        path = report if report == "-" else str(tmp_path / report)
        result = call("batch", folder, "-o", tmp_path / "out", "-v", "--report", path, status=0)
        text = result.stdout + result.stderr
        if report != "-":
            text += Path(path).read_text(encoding="utf-8")
        for line in text.split("\n"):
            assert line.isprintable(), line


@pytest.mark.parametrize("words", [["check"], ["batch", "-o", "x", "--name"], ["post", "-o", "x"]])
def test_wrong_usage_is_told_in_plain_text(tmp_path: Path, words: list[str]) -> None:
    folder = tmp_path / "a\x1b[2J\u202e"
    folder.mkdir()
    result = call(words[0], *words[1:], folder)
    assert result.exit_code in (1, 2)
    assert "\\x1b[2J\\u202e" in result.stderr
    for line in result.stderr.split("\n"):
        assert line.isprintable(), line
