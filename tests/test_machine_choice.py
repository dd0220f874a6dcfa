"""Which machine takes a part where none is named: the first of its shop that makes all of it."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from beamcam.cli import main
from beamcam.errors import PlanError, Source
from beamcam.machine import load
from beamcam.machine_choice import RULES, first_that_makes
from beamcam.model.request import Request
from beamcam.planning.rules import BAR_FULL
from tests.conftest import ROOT

BAD, GOOD = ROOT / "samples" / "bad", ROOT / "samples" / "dstv"
MACHINES = tuple(map(load, ("beamline", "beamline-pusher", "beamline-annex")))
HERE = Source("part")
REQUEST = Request((), MACHINES[0])


def run(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


@given(st.lists(st.booleans(), min_size=3, max_size=3))
def test_the_first_that_makes_it_takes_it(can: list[bool]) -> None:
    able = dict(zip((machine.name for machine in MACHINES), can, strict=True))
    tried: list[str] = []

    def attempt(request: Request) -> str:
        name = request.machine.name
        tried.append(name)
        if not able[name]:
            raise PlanError(BAR_FULL.at(HERE, found=1, expected=2))
        return name

    if not any(can):
        with pytest.raises(PlanError) as caught:
            first_that_makes(REQUEST, MACHINES, attempt)
        *first, last = caught.value.diagnostics
        assert ([d.code for d in first], last.code) == (["plan-bar-full"], "plan-no-machine")
        assert all(machine.name in last.message for machine in MACHINES)
        return
    made, said = first_that_makes(REQUEST, MACHINES, attempt)
    assert made == next(name for name, able_ in able.items() if able_)
    assert tried == list(able)[: list(able).index(made) + 1]
    assert [d.code for d in said] == (["plan-machine"] if len(tried) > 1 else [])
    assert {rule.code for rule in RULES} == {"plan-machine", "plan-no-machine"}


def test_one_machine_alone_says_what_it_always_said() -> None:
    def refused(request: Request) -> None:
        raise PlanError(BAR_FULL.at(HERE, found=1, expected=2))

    with pytest.raises(PlanError) as caught:
        first_that_makes(REQUEST, MACHINES[:1], refused)
    assert [d.code for d in caught.value.diagnostics] == ["plan-bar-full"]


def test_a_slot_goes_to_the_machine_with_a_mill_and_is_read_back_there(tmp_path: Path) -> None:
    job = tmp_path / "slot.gcode"
    done = run("post", BAD / "slot.nc1", "-o", job)
    assert done.exit_code == 0, done.stderr
    assert "note plan-machine: made on beamline-pusher; beamline cannot: plan-slot" in done.stderr
    assert "MACHINE beamline-pusher" in job.read_text("ascii")
    for words in (("verify", job, "--against", BAD / "slot.nc1"), ("verify", job),
                  ("diff", job, job)):  # fmt: skip
        again = run(*words)
        assert again.exit_code == 0, again.stdout + again.stderr
    plan = run("plan", BAD / "slot.nc1", "--json")
    assert json.loads(plan.stdout)["machine"] == "beamline-pusher"


def test_what_nobody_makes_says_why_of_each() -> None:
    done = run("post", BAD / "cope.nc1", "-o", "-")
    assert (done.exit_code, done.stdout) == (1, "")
    assert "error plan-no-machine" in done.stderr
    assert "beamline: plan-" in done.stderr
    assert "beamline-pusher: plan-" in done.stderr


def test_the_configuration_names_several(tmp_path: Path) -> None:
    config = tmp_path / "beamcam.toml"
    config.write_text('[machines]\nbeam = ["beamline-annex", "beamline-pusher"]\n')
    job = tmp_path / "job.gcode"
    done = run("post", GOOD / "tie.nc1", "-o", job, "--config", config)
    assert (done.exit_code, "MACHINE beamline-annex" in job.read_text("ascii")) == (0, True)
    done = run("post", BAD / "slot.nc1", "-o", job, "--config", config)
    assert (done.exit_code, "MACHINE beamline-pusher" in job.read_text("ascii")) == (0, True)
    done = run("post", BAD / "slot.nc1", "-o", job, "--config", config, "--machine", "beamline")
    assert done.exit_code == 1
    assert "plan-no-machine" not in done.stderr
    config.write_text('[machines]\nbeam = ["beamline", "no-such"]\n')
    done = run("post", GOOD / "tie.nc1", "-o", job, "--config", config)
    assert (done.exit_code, "no-such" in done.stderr) == (1, True)


def test_a_batch_spreads_its_parts_and_checks_them(tmp_path: Path) -> None:
    out = tmp_path / "out"
    inputs = (GOOD / "tie.nc1", BAD / "slot.nc1", BAD / "saw-angle-out-of-range.nc1")
    done = run("batch", *inputs, "-o", out, "--jobs", "1", "--json")
    assert done.exit_code == 0, done.stderr
    rows = [part for row in json.loads(done.stdout)["files"] for part in row["parts"]]
    assert [part["machine"] for part in rows] == ["beamline", "beamline-pusher", "beamline-pusher"]
    checked = run("check", out)
    assert checked.exit_code == 0, checked.stdout + checked.stderr


SLOT = str(BAD / "slot.nc1")


@pytest.mark.parametrize("command", ["post", "plan", "batch", "report"])
def test_a_machine_that_makes_all_of_it_goes_before_one_that_leaves_something_out(
    command: str, tmp_path: Path
) -> None:
    """The beamline has no mill and could leave the slot out, as is allowed; the pusher mills it."""
    out = {"post": "job.gcode", "plan": "plan.json", "batch": "programs", "report": "sheet.html"}
    words = (command, SLOT, "--allow-skips", "slot", "-o", tmp_path / out[command])
    done = run(*words)
    assert done.exit_code == 0, done.stderr
    told = "made on beamline-pusher; beamline cannot: plan-slot" in done.stderr
    assert told == (command != "batch")  # whose notes stand in its report
    assert "plan-left-out" not in done.stderr
    written = b"".join(p.read_bytes() for p in tmp_path.rglob("*") if p.is_file())
    assert b"beamline-pusher" in written


def test_where_no_machine_makes_all_of_it_the_first_leaves_out_what_is_allowed(
    tmp_path: Path,
) -> None:
    job = tmp_path / "job.gcode"
    done = run("post", BAD / "cope.nc1", "--allow-skips", "cope", "-o", job)
    assert done.exit_code == 0, done.stderr
    assert "MACHINE beamline " in job.read_text("ascii")


OF_SAMPLES = {
    "beamline-annex": ("tie.nc1",), "beamline-pusher": ("tie.nc1",),
    "plate-codesys": ("gusset.nc1",), "plate-oxyfuel": ("gusset.nc1",),
    "laser-grbl": ("../svg/corel-x6.svg", "--thickness", "3"),
}  # fmt: skip


@pytest.mark.parametrize("machine", OF_SAMPLES)
def test_a_program_is_read_on_the_machine_that_its_head_names(machine: str, tmp_path: Path) -> None:
    name, *words = OF_SAMPLES[machine]
    job = tmp_path / "job.txt"
    made = run("post", GOOD / name, "--machine", machine, *words, "-o", job)
    assert made.exit_code == 0, made.stderr
    for asked in (
        ("verify", job), ("verify", job, "--against", GOOD / name, *words), ("diff", job, job),
        ("simulate", job, "-o", tmp_path / "t.csv"),
    ):  # fmt: skip
        done = run(*asked)
        assert done.exit_code == 0, (asked, done.output)


def test_a_head_names_no_file(tmp_path: Path) -> None:
    """A program that names a machine file is judged by a machine that is known here."""
    lax, job = tmp_path / "lax.toml", tmp_path / "job.gcode"
    lax.write_text('base = "beamline"\nname = "lax"\n\n[limits]\n', encoding="ascii")
    assert run("post", GOOD / "tie.nc1", "-o", job).exit_code == 0
    text = job.read_text(encoding="ascii").replace("MACHINE beamline", f"MACHINE {lax}")
    job.write_text(text, encoding="ascii")
    done = run("simulate", job, "-o", tmp_path / "t.json")
    assert done.exit_code == 0, done.output
    assert json.loads((tmp_path / "t.json").read_text(encoding="utf-8"))["machine"] == "beamline"
