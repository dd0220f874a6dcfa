"""Names that are too long, numbers without end, and characters that turn the writing round."""

import json
from pathlib import Path

import pytest

from beamcam import system
from beamcam.arguments import AskError, check_arguments
from beamcam.readers import read
from beamcam.setup_sheet.playback import as_script
from tests.conftest import SAMPLES
from tests.runs import call, fill, part

PYTHON = ("Exceeds the limit", "recursion", "sys.set_int")


@pytest.mark.parametrize("command", ["post", "batch", "watch"])
def test_a_job_longer_than_a_line_is_refused(tmp_path: Path, command: str) -> None:
    fill(tmp_path / "in", 1)
    source = str(tmp_path / "in" / "P000.nc1") if command == "post" else str(tmp_path / "in")
    out = str(tmp_path / ("a.gcode" if command == "post" else "out"))
    more = ["--once", "--settle", "0"] if command == "watch" else []
    words = [command, source, "-o", out, *more]
    done = call(*words, "--job", "J" * 201, status=1)
    assert "error ask-job: found the job name 'JJJ" in done.stderr
    assert "expected 200 characters at most" in done.stderr
    assert len(done.stderr) < 500
    assert not list(tmp_path.rglob("*.gcode"))
    assert call(*words, "--job", "J" * 200).exit_code == 0
    assert "J" * 200 + "\n" in next(tmp_path.rglob("*.gcode")).read_text()


def test_a_job_of_a_configuration_or_a_caller_too(tmp_path: Path) -> None:
    (tmp_path / "beamcam.toml").write_text(f'job = "{"J" * 201}"\n')
    done = call("config", tmp_path)
    assert "for 'job'; expected 200 characters at most" in done.stderr
    with pytest.raises(AskError, match="expected 200 characters at most"):
        check_arguments("J" * 201)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.json", '{"mark": ' + "9" * 5000 + "}"), ("a.json", "[" * 100_000),
        ("a.json", '{"mark": ' * 50_000),
    ],
)  # fmt: skip
def test_parts_are_refused_in_our_words(name: str, text: str) -> None:
    reading = read(text.encode(), name)
    said = " ".join(str(d) for d in reading.diagnostics)
    assert "error " in said
    assert not any(word in said for word in PYTHON), said
    assert "digits than any has" in said or "too deep inside one another" in said


@pytest.mark.parametrize("text", ["x = " + "9" * 5000, "job = 1\nx = -" + "1" * 4400])
def test_tables_are_refused_in_our_words(tmp_path: Path, text: str) -> None:
    (tmp_path / "m.toml").write_text(text)
    for words in (["machines", "show", str(tmp_path / "m.toml")],
                  ["config", "--config", str(tmp_path / "m.toml")]):  # fmt: skip
        done = call(*words, status=1)
        assert "a number of more digits than any has" in done.stderr or "characters" in done.stderr
        assert not any(word in done.stderr for word in PYTHON)


@pytest.mark.parametrize("sign", ["\u202e", "\u0085", "\u2028", "\u200f", "\x1b", "\u2066"])
def test_data_of_pages_spell_out_what_turns_the_writing(sign: str) -> None:
    data = {"mark": f"A{sign}B", "unit": "Ø<"}
    text = as_script(data)
    assert sign not in text
    assert "<" not in text
    assert "Ø" in text
    assert json.loads(text) == data


def test_a_setup_sheet_holds_none(tmp_path: Path) -> None:
    program = tmp_path / "p.gcode"
    source = tmp_path / "A.nc1"
    source.write_text(part("A\u202eB"), encoding="utf-8")
    assert call("post", source, "-o", program).exit_code == 0
    program.write_text(program.read_text() + "(\u202ereverse\u0085)\n", encoding="utf-8")
    sheet = tmp_path / "s.html"
    call("report", program, source, "-o", sheet)
    call("report", source, "-o", tmp_path / "t.html")
    for page in (sheet, tmp_path / "t.html"):
        if page.exists():
            text = page.read_text(encoding="utf-8")
            assert "\u202e" not in text
            assert "\u0085" not in text
    assert (tmp_path / "t.html").exists()


@pytest.mark.skipif(system.is_windows(), reason="links need a right there")
def test_a_link_to_a_folder_above_brings_none_of_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "jobs" / "today", 1)
    (tmp_path / "jobs" / "secret.nc1").write_text((SAMPLES / "dstv" / "tie.nc1").read_text())
    (tmp_path / "jobs" / "today" / "up").symlink_to(tmp_path / "jobs")
    (tmp_path / "jobs" / "today" / "root").symlink_to("/")
    (tmp_path / "beside").mkdir()
    fill(tmp_path / "beside", 2)
    (tmp_path / "jobs" / "today" / "beside").symlink_to(tmp_path / "beside")
    monkeypatch.chdir(tmp_path)
    for words in (["jobs/today"], ["jobs/tod*"]):
        done = call("batch", *words, "-o", "out", "--dry-run", status=0)
        assert "secret" not in done.output
        assert done.stderr.count("warning batch-loop") == 2
        assert f"found a link back to {tmp_path / 'jobs'}, which is not followed" in done.stderr
        assert done.stdout.count(" -> ") == 3
