"""The command line: what is printed where, what is written, and the exit status."""

import json
import os
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from beamcam import __version__
from beamcam.cli import COMMANDS, main
from tests.conftest import ROOT, SAMPLES

CHANNEL = str(SAMPLES / "dstv" / "channel.nc1")
TIE = str(SAMPLES / "dstv" / "tie.nc1")
BAD = str(SAMPLES / "bad" / "hole-without-tool.nc1")


def run(*args: str, stdin: bytes | None = None) -> Result:
    return CliRunner().invoke(main, list(args), input=stdin)


def test_post_writes_the_program_and_nothing_else(tmp_path: Path) -> None:
    target = tmp_path / "job.gcode"
    result = run("post", CHANNEL, "-o", str(target))
    assert result.exit_code == 0
    assert result.output == ""
    assert target.read_text().startswith("% JOB\nN1 ")
    assert target.read_text().endswith("M30\n%\n")
    assert os.listdir(tmp_path) == ["job.gcode"]


def test_post_to_standard_output_is_the_same(tmp_path: Path) -> None:
    target = tmp_path / "job.gcode"
    run("post", CHANNEL, "-o", str(target))
    assert run("post", CHANNEL, "-o", "-").stdout == target.read_text()


def test_post_from_standard_input() -> None:
    data = Path(CHANNEL).read_bytes()
    assert run("post", "-", "-o", "-", stdin=data).stdout == run("post", CHANNEL, "-o", "-").stdout


def test_a_refused_part_leaves_no_file(tmp_path: Path) -> None:
    target = tmp_path / "job.gcode"
    result = run("post", BAD, "-o", str(target))
    assert result.exit_code == 1
    assert result.stdout == ""
    assert f"{BAD}:28: error plan-tool: found a through hole of diameter 65" in result.stderr
    assert not target.exists()
    assert os.listdir(tmp_path) == []


def test_a_refused_part_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "job.gcode"
    target.write_text("old")
    assert run("post", BAD, "-o", str(target)).exit_code == 1
    assert target.read_text() == "old"


def test_one_bad_part_refuses_the_bar(tmp_path: Path) -> None:
    target = tmp_path / "job.gcode"
    assert run("post", CHANNEL, BAD, "-o", str(target)).exit_code == 1
    assert not target.exists()


def test_messages_as_json() -> None:
    result = run("post", BAD, "-o", "-", "--json")
    (said,) = json.loads(result.stderr)
    assert said["code"] == "plan-tool"
    assert said["severity"] == "error"
    assert said["line"] == 28
    assert said["file"] == BAD


def test_a_skip_has_to_be_named() -> None:
    result = run("post", BAD, "-o", "-", "--allow-skips", "tool")
    assert result.exit_code == 0
    assert result.stdout.count("M40") == 1
    assert run("post", BAD, "-o", "-", "--allow-skips", "slot").exit_code == 1
    assert run("post", BAD, "-o", "-", "--allow-skips", "nothing").exit_code == 2


def test_the_quantity_is_said() -> None:
    result = run("post", TIE, "--bar", "6000", "-o", "-")
    assert result.exit_code == 0
    assert "note plan-quantity: found a quantity of 2; this program makes 1" in result.stderr
    result = run("post", TIE, TIE, "--bar", "6000", "-o", "-")
    assert "plan-quantity" not in result.stderr


@pytest.mark.parametrize(
    ("bar", "code"), [("300", "plan-bar-full"), ("1000", "plan-bar-short"), ("1200", None)]
)
def test_the_bar(bar: str, code: str | None) -> None:
    result = run("post", TIE, "--bar", bar, "-o", "-")
    assert result.exit_code == (1 if code else 0)
    assert code is None or code in result.stderr


def test_parts_of_different_sections_do_not_share_a_bar() -> None:
    result = run("post", CHANNEL, str(SAMPLES / "dstv" / "beam.nc1"), "-o", "-")
    assert result.exit_code == 1
    assert "plan-mixed-profiles: found profile IPE300; expected UPN200" in result.stderr


def test_strict_makes_a_warning_refuse(tmp_path: Path) -> None:
    text = Path(CHANNEL).read_text().replace("     15.000\n", "      0.000\n", 1)
    bent = tmp_path / "bent.nc1"
    bent.write_text(text)
    plain = run("post", str(bent), "-o", "-")
    assert plain.exit_code == 0
    assert "warning plan-cut-from-contour" in plain.stderr
    strict = run("post", str(bent), "-o", "-", "--strict")
    assert strict.exit_code == 1
    assert strict.stdout == ""


def test_missing_input_and_unwritable_output(tmp_path: Path) -> None:
    result = run("post", str(tmp_path / "none.nc1"), "-o", "-")
    assert result.exit_code == 1
    assert "read-file: found no file that can be read (No such file or directory)" in result.stderr
    result = run("post", CHANNEL, "-o", str(tmp_path / "none" / "job.gcode"))
    assert result.exit_code == 1
    assert "cannot be written" in result.stderr


@pytest.mark.parametrize(
    "args",
    [(), ("post",), ("post", CHANNEL), ("post", "-o", "-"), ("machines", "show"), ("psot",),
     ("post", CHANNEL, "-o", "-", "--bar", "-3"), ("post", CHANNEL, "-o", "-", "--no-such")],
)  # fmt: skip
def test_wrong_usage(args: tuple[str, ...]) -> None:
    assert run(*args).exit_code == 2


def test_a_misspelt_command_is_suggested() -> None:
    assert "Did you mean 'post'?" in run("psot").stderr


def test_machines() -> None:
    listed = run("machines", "list")
    assert listed.exit_code == 0
    assert "beamline-annex" in listed.stdout
    names = [m["name"] for m in json.loads(run("machines", "list", "--json").stdout)]
    assert names == sorted(names)
    shown = run("machines", "show", "beamline-annex").stdout
    assert "saw.kerf_along" in shown
    assert "# beamline-annex.toml:" in shown
    assert "# beamline.toml:" in shown
    assert "# default" in shown
    record = json.loads(run("machines", "show", "beamline", "--json").stdout)
    assert record["saw.least_mitre"] == {"value": 0.1, "source": None}
    missing = run("machines", "show", "beamlime")
    assert missing.exit_code == 1
    assert "machine-unknown: found no machine 'beamlime'; expected 'beamline'" in missing.stderr


def test_codes_stand_in_the_documentation() -> None:
    page = run("codes", "--markdown").stdout
    assert page == (ROOT / "docs" / "codes.md").read_text(encoding="utf-8")
    assert "plan-tool" in run("codes").stdout
    assert {"code", "severity", "message", "why"} == set(
        json.loads(run("codes", "--json").stdout)[0]
    )


def test_version() -> None:
    assert __version__ in run("--version").stdout


def leaves(group: click.Command, path: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Every command below a group, as the words that call it."""
    if not isinstance(group, click.Group):
        return [path]
    context = click.Context(group)
    found = []
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        found += leaves(command, (*path, name))
    return found


@pytest.mark.parametrize("words", leaves(main, ()), ids=" ".join)
def test_every_command_has_help_and_stands_in_the_readme(words: tuple[str, ...]) -> None:
    result = run(*words, "--help")
    assert result.exit_code == 0
    assert len(result.stdout.splitlines()) > 5
    if len(words) == 1:
        assert COMMANDS[words[0]][1] in run("--help").stdout
    assert f"beamcam {' '.join(words)}" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_a_broken_pipe_is_no_crash() -> None:
    command = f"{sys.executable} -m beamcam machines show beamline | head -1"
    result = subprocess.run(command, shell=True, capture_output=True, text=True, cwd=ROOT)
    assert result.stdout.startswith("name")
    assert "Traceback" not in result.stderr
