"""The rest of a program after a stop in mid bar: what it says, and that it makes what is left."""

import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from beamcam.emitters import gcode
from beamcam.errors import PlanError
from beamcam.machine import Machine, load
from beamcam.model.part import Part
from beamcam.model.plan import Plan
from beamcam.model.program import Comment, Program, StartBar
from beamcam.pipeline import Posted, RefusedProgram, post
from beamcam.readers import read
from beamcam.remainder import rest_of, what_has_to_be_true
from tests.conftest import SAMPLES
from tests.runs import call

CHANNEL, STRUT = SAMPLES / "dstv" / "channel.nc1", SAMPLES / "dstv" / "strut.nc1"
MACHINES = ("beamline", "beamline-annex", "beamline-pusher")
UNITS = ("stamp", "printer")
HALL = str(SAMPLES / "machines" / "hall-drill.toml")


def parts(path: Path, count: int = 1) -> tuple[Part, ...]:
    return read(path.read_bytes(), path.name).parts * count


def whole(path: Path, machine: str, count: int = 1) -> Posted:
    made = parts(path, count)
    posted = post(made, load(machine))
    assert isinstance(posted.plan, Plan)
    return posted


def blocks(text: str) -> list[str]:
    """The blocks of a program without their numbers and comments."""
    found = (re.sub(r"^N\d+ ", "", line) for line in text.splitlines())
    return [line for line in found if not line.startswith(("(", "%"))]


@pytest.mark.parametrize("machine", MACHINES)
def test_each_rest_is_the_end_of_the_whole_and_reads_back(machine: str) -> None:
    posted = whole(CHANNEL, machine, 2)
    assert isinstance(posted.plan, Plan)
    all_blocks = blocks(posted.text)
    header = blocks("\n".join(load(machine).words.header))
    lengths = []
    for first in range(2, len(posted.plan.operations) + 1):
        text = rest_of(posted, first).text
        rest = blocks(text)[len(header) :]
        assert rest == all_blocks[-len(rest) :]
        assert f"REST FROM OPERATION {first} OF {len(posted.plan.operations)}" in text
        lengths.append(len(rest))
    assert lengths == sorted(lengths, reverse=True)
    assert len(set(lengths)) == len(lengths)


MARKED = SAMPLES / "dstv" / "marked.nc1"


@pytest.mark.parametrize(
    "machine",
    ["beamline-pusher", *(str(SAMPLES / f"machines/beamline-{u}.toml") for u in UNITS)],
)
def test_a_rest_that_begins_with_a_text_or_behind_a_scribe(machine: str) -> None:
    """A path ends with its tool drawn back; the bar's move to a text belongs to the text."""
    made = parts(MARKED)
    posted = post(made, load(machine), skips=("mark",))
    assert isinstance(posted.plan, Plan)
    all_blocks = blocks(posted.text)
    header = blocks("\n".join(load(machine).words.header))
    for first in range(2, len(posted.plan.operations) + 1):
        rest = blocks(rest_of(posted, first).text)[len(header) :]  # raises RefusedProgram
        assert rest == all_blocks[-len(rest) :]


def test_on_a_line_of_ones_own() -> None:
    posted = whole(STRUT, HALL)
    assert isinstance(posted.plan, Plan)
    text = rest_of(posted, 2).text
    assert text.startswith("%\n")
    assert text.endswith("M30\n%\n")
    assert "PARTED OFF" not in text


def test_the_head_says_what_has_to_be_true() -> None:
    posted = whole(CHANNEL, "beamline", 2)
    assert isinstance(posted.plan, Plan)
    said = [*what_has_to_be_true(posted.plan, 18, posted.job.machine)]
    assert said[:5] == [
        "REST FROM OPERATION 18 OF 24. START ONLY IF ALL THIS IS TRUE:",
        "- OPERATIONS 1 TO 17 ARE DONE, THE LAST ONE AT X 5002.743: drill 14 ON FACE o AND u",
        "- PARTED OFF: C1",
        "- THE BAR IS CLAMPED AS IT WAS AND STANDS AT X 5002.743 BY THE SAME REFERENCE",
        "- ALL TOOLS ARE DRAWN BACK, SPINDLES AND COOLANT ARE OFF",
    ]
    assert "- web STATION 2 HOLDS drill 14" in said
    early = [*what_has_to_be_true(posted.plan, 2, posted.job.machine)]
    assert early[2] == "- PARTED OFF: NOTHING YET"
    text = rest_of(posted, 18).text
    for line in said:
        assert f"({line})" in text


@pytest.mark.parametrize("first", [1, 0, 99])
def test_an_operation_that_is_none(first: int) -> None:
    posted = whole(STRUT, "beamline")
    assert isinstance(posted.plan, Plan)
    count = len(posted.plan.operations)
    with pytest.raises(PlanError, match=f"plan-operation: found operation {first} to begin with; "
                                        f"expected 2 to {count}, as"):  # fmt: skip
        rest_of(posted, first)


@pytest.mark.parametrize("fault", ["dropped", "doubled", "swapped", "no header"])
def test_a_rest_that_is_not_the_rest_is_refused(
    monkeypatch: pytest.MonkeyPatch, fault: str
) -> None:
    """Whatever goes wrong in parting it: the read-back of both together finds it."""
    posted, emit = whole(CHANNEL, "beamline"), gcode.emit
    assert isinstance(posted.program, Program)
    commands = posted.program.commands

    def broken(program: Program, machine: Machine) -> str:
        begin = next(
            k for k, c in enumerate(program.commands) if not isinstance(c, StartBar | Comment)
        )
        head, rest = program.commands[:begin], program.commands[begin:]
        if fault == "dropped":
            rest = rest[1:]
        elif fault == "doubled":
            rest = (commands[-len(rest) - 1], *rest)
        elif fault == "swapped":
            rest = (rest[-1], *rest[:-1])
        else:
            head = ()
        return emit(replace(program, commands=(*head, *rest)), machine)

    assert rest_of(posted, 8).text
    monkeypatch.setattr(gcode, "emit", broken)
    with pytest.raises(RefusedProgram, match="error verify-"):
        rest_of(posted, 8)


def test_the_command(tmp_path: Path) -> None:
    out = tmp_path / "rest.gcode"
    assert call("post", CHANNEL, "--from-operation", 5, "-o", out).exit_code == 0
    assert "REST FROM OPERATION 5 OF" in out.read_text()
    done = call("post", CHANNEL, "--from-operation", 500, "-o", tmp_path / "x.gcode", status=1)
    assert "error plan-operation" in done.stderr
    assert not (tmp_path / "x.gcode").exists()
    assert call("post", CHANNEL, "--from-operation", 1, "-o", out).exit_code == 2
    sheet = SAMPLES / "dstv" / "gusset.nc1"
    done = call("post", sheet, "--from-operation", 2, "-o", tmp_path / "x.ngc", status=2)
    assert "--from-operation is for the program of one bar." in done.stderr


def test_the_command_that_reads_it_back(tmp_path: Path) -> None:
    rest, job = tmp_path / "rest.gcode", tmp_path / "job.gcode"
    against = ("--against", CHANNEL)
    assert call("post", CHANNEL, "-o", job).exit_code == 0
    assert call("post", CHANNEL, "--from-operation", 5, "-o", rest).exit_code == 0
    assert call("verify", rest, *against).exit_code == 1
    for after in ((), ("--after", job)):
        done = call("verify", rest, "--from-operation", 5, *after, *against)
        assert (done.exit_code, done.stderr) == (0, "")
        assert call("verify", rest, "--from-operation", 6, *after, *against).exit_code == 1
    assert call("simulate", rest, "-o", tmp_path / "rest.csv").exit_code == 0
    differs = call("diff", job, rest, status=1)
    assert set(re.findall(r"only in (\w)", differs.stdout)) == {"A"}
    assert call("diff", rest, rest).exit_code == 0
    assert call("verify", rest, "--from-operation", 5).exit_code == 2
    assert call("verify", rest, "--after", job, *against).exit_code == 2
    sheet = SAMPLES / "dstv" / "gusset.nc1"
    on = ("--machine", "plate-linuxcnc", "--from-operation", 5, "--against", sheet)
    done = call("verify", rest, *on)
    assert "--from-operation is for the program of one bar." in done.stderr


def test_parts_that_lie_turned_and_in_another_order_are_read_back(tmp_path: Path) -> None:
    job, inputs = tmp_path / "job.gcode", (STRUT, STRUT, STRUT)
    assert call("post", *inputs, "--order", "best", "--turn", "-o", job).exit_code == 0
    asked = ("--order", "best", "--turn")
    assert call("verify", job, *asked, "--against", *inputs).exit_code == 0
