"""The head of a program: what it says, and that nobody believes what was not asked for."""

import re
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from beamcam import pipeline
from beamcam.checks.job import VERSION, head_of
from beamcam.emitters.gcode import FORM
from beamcam.machine import load, shipped
from beamcam.model.request import Job
from beamcam.pipeline import RefusedProgram, parts_of, post, read_file
from beamcam.posts import Post, post_of
from benchmarks.heads import CHANGES, counted
from benchmarks.heads import SAMPLES as SHIPPED
from tests.conftest import GOLDEN, SAMPLES
from tests.runs import call

SLOT = str(SAMPLES / "bad" / "slot.nc1")
CHANNEL = str(SAMPLES / "dstv" / "channel.nc1")


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_machine_has_its_head_in_every_golden_program(name: str) -> None:
    machine = load(name)
    programs = [p for p in (GOLDEN / name).iterdir() if p.suffix != ".bin"]
    assert programs
    for path in programs:
        head = head_of(path.read_text(encoding="utf-8"))
        assert head is not None, path
        assert (head.version, head.machine, head.checksum) == (FORM, name, machine.checksum)
        assert not head.allowed
        assert head.parts
        assert head.stock
        assert all(part.at and part.size for part in head.parts)
        assert (head.bar is not None) == (machine.stock == "beam")
        of_samples = {"bevelled": 1, "stub": 1, "header-rest": 1, "leg": 2, "hip": 1, "stringer": 3}
        manual_work = of_samples.get(path.stem, 0)  # bevels, a text
        if name == "coper-linuxcnc":  # skew ends that are cut square, ledges
            manual_work = {"rafter": 3, "girder": 1, "valley": 3}.get(path.stem, manual_work)
        assert head.manual_work == manual_work, path
    assert FORM == VERSION


def test_the_head_names_the_kinds_that_were_allowed() -> None:
    parts, _ = parts_of([read_file(SLOT)])
    kinds = ("slot", "cope", "mark", "bevel", "other", "axis")
    text = post(parts, load("beamline"), skips=kinds, verified=False).text
    assert re.findall(r"\((.*LEFT OUT:.*|NOT VERIFIED.*)\)", text) == [
        "ALLOWED TO BE LEFT OUT: axis, bevel, cope, mark",
        "ALLOWED TO BE LEFT OUT: other, slot",
        "LEFT OUT: 1 slot",
        "NOT VERIFIED: THIS PROGRAM WAS NOT READ BACK",
    ]
    head = head_of(text)
    assert head is not None
    assert head.allowed == tuple(sorted(kinds))
    assert head.left_out == 1


def test_the_checksum_is_of_what_the_file_says(tmp_path: Path) -> None:
    """Comments and order change nothing; a value does, also one of the base."""
    texts = {
        "plain": 'base = "beamline"\n[saw]\nkerf = 3.0\nx = 1\n',
        "other": '# another order\nbase = "beamline"\n[saw]\nx = 1\nkerf = 3.0\n',
        "value": 'base = "beamline"\n[saw]\nx = 1\nkerf = 3.1\n',
    }
    sums = {}
    for name, text in texts.items():
        folder = tmp_path / name
        folder.mkdir()
        (folder / "mine.toml").write_text(text)
        sums[name] = load(str(folder / "mine.toml")).checksum
    assert sums["plain"] == sums["other"] != sums["value"]
    assert sums["plain"] != load("beamline").checksum


def tampering(change: Any) -> Any:
    """`post_of` whose emitter's text is changed before it is read back."""
    row = post_of(load("beamline"))

    def emit(program: Any, job: Job) -> str:
        text = row.emit(program, job)
        assert isinstance(text, str)
        changed = change(text)
        assert changed != text
        return str(changed)

    found: Post = replace(row, emit=emit)
    return lambda machine: found


def without_head(text: str) -> str:
    return "".join(line for line in text.splitlines(True) if "BEAMCAM" not in line)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (
            lambda text: text.replace("(SECTION", "(ALLOWED TO BE LEFT OUT: cope)\n(SECTION"),
            "allows cope",
        ),
        (without_head, "found no head"),
        (lambda text: text.replace(f"BEAMCAM {FORM}", "BEAMCAM 7"), "the form 7"),
        (lambda text: text.replace(load("beamline").checksum, "00000000"), "checksum 00000000"),
    ],
)
def test_post_refuses_a_head_that_says_otherwise(
    change: Any, found: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts, _ = parts_of([read_file(CHANNEL)])
    monkeypatch.setattr(pipeline, "post_of", tampering(change))
    with pytest.raises(RefusedProgram, match="verify-head") as refused:
        post(parts, load("beamline"))
    assert found in str(refused.value)


def test_verify_believes_the_head_unless_told_otherwise(tmp_path: Path) -> None:
    program = tmp_path / "a.gcode"
    assert (
        call(
            "post", SLOT, "-o", program, "--machine", "beamline", "--allow-skips", "slot"
        ).exit_code
        == 0
    )
    against = ("verify", program, "--against", SLOT)
    for words in ((), ("--allow-skips", "slot")):
        done = call(*against, *words, status=0)
        assert done.stderr.count("verify-left-out: found nothing that makes the slot 62 x 22") == 1
        assert call(*against, *words, "--exit-left-out", 3).exit_code == 3
    for doubt in (("--strict",), ("--allow-skips", "none"), ("--allow-skips", "cope")):
        assert call(*against, *doubt).exit_code == 1, doubt
    program.write_text(without_head(program.read_text()))
    assert call(*against).exit_code == 1


def test_verify_warns_of_a_machine_that_has_changed_since(tmp_path: Path) -> None:
    machine, program = tmp_path / "mine.toml", tmp_path / "a.gcode"
    machine.write_text('base = "beamline"\n[times]\nsaw_s = 7.0\n')
    assert call("post", CHANNEL, "-o", program, "--machine", machine).exit_code == 0
    against = ("verify", program, "--against", CHANNEL)
    said = call(*against, "--machine", machine).stderr
    assert re.findall(r": (?:error|warning|note) (\S+):", said) == ["machine-elsewhere"]
    done = call(*against, "--machine", "beamline", status=0)
    assert "verify-machine-changed" in done.stderr
    program.write_text(program.read_text().replace(f"BEAMCAM {FORM}", f"BEAMCAM {VERSION + 1}"))
    assert "verify-head-newer" in call(*against, "--machine", machine).stderr


def test_a_program_written_by_hand_needs_no_head() -> None:
    assert head_of("% 1\nN1 G90\nN2 M30\n") is None


def test_every_machine_refuses_every_head_that_says_otherwise() -> None:
    made, caught = counted()
    assert made == caught == dict.fromkeys((change.__name__ for change in CHANGES), len(SHIPPED))
