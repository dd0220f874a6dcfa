"""Which machine takes a part where none is named: the one that leaves out fewest features."""

import json
import re
from collections.abc import Sequence
from contextlib import suppress
from itertools import permutations
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam import arguments
from beamcam.api import lists
from beamcam.arguments import AskError, none_makes_it, on_best_machine
from beamcam.errors import Diagnostic, PlanError, Severity, Source
from beamcam.machine import load
from beamcam.machine.machine import default_machines
from beamcam.model.plan import Outcome, clock
from beamcam.model.request import ChosenBy, Job, Request, stock_of
from beamcam.pipeline import plans_of, post, read_file
from beamcam.planning.rules import BAR_FULL
from beamcam.posts import Planned
from tests.conftest import ROOT, rules_of
from tests.runs import call

BAD, GOOD = ROOT / "samples" / "bad", ROOT / "samples" / "dstv"
MACHINES = tuple(map(load, ("beamline", "beamline-pusher", "beamline-annex")))
HERE = Source("part")
REQUEST = Request((), MACHINES[0])


class Attempts:
    """Plans of no part, with so many outcomes that are left out by each machine; None refuses."""

    def __init__(self, left_out: Sequence[int | None]) -> None:
        self._left_out = dict(zip((machine.name for machine in MACHINES), left_out, strict=True))
        self.tried: list[str] = []

    def __call__(self, request: Request) -> list[Planned]:
        name = request.machine.name
        self.tried.append(name)
        count = self._left_out[name]
        if count is None or (count and not request.skips):
            raise PlanError(BAR_FULL.at(HERE, found=1, expected=2))
        outcomes = tuple(Outcome((0, k), "skipped", "plan-slot") for k in range(count))
        return [Planned(Job(request, ()), replace(NOTHING, outcomes=outcomes))]


NOTHING = plans_of(Request(read_file(str(GOOD / "tie.nc1")).parts, MACHINES[0]))[0].plan
LEFT = st.lists(st.none() | st.integers(0, 3), min_size=3, max_size=3)


@given(st.lists(st.booleans(), min_size=3, max_size=3))
def test_the_first_that_makes_it_takes_it(can: list[bool]) -> None:
    attempt = Attempts([0 if able else None for able in can])
    if not any(can):
        with pytest.raises(PlanError) as caught:
            on_best_machine(REQUEST, MACHINES, attempt)
        *first, last = caught.value.diagnostics
        assert ([d.code for d in first], last.code) == (["plan-bar-full"], "plan-no-machine")
        assert all(machine.name in last.message for machine in MACHINES)
        return
    (made,), said = on_best_machine(REQUEST, MACHINES, attempt)
    assert made.job.machine is MACHINES[can.index(True)]
    # Nothing behind it is planned.
    assert attempt.tried == [machine.name for machine in MACHINES[: can.index(True) + 1]]
    assert [d.code for d in said] == (["plan-machine"] if can.index(True) else [])
    assert {rule.code for rule in rules_of(arguments)} >= {"plan-machine", "plan-no-machine"}


@given(
    LEFT, st.lists(st.integers(1, 3), min_size=3, max_size=3), st.sampled_from(["order", "time"])
)
def test_the_machine_with_the_least_rank_takes_it(
    left: list[int | None], times: list[int], by: ChosenBy
) -> None:
    """Fewest features left out, then the least time if asked for, then the order."""
    seconds = dict(zip((machine.name for machine in MACHINES), times, strict=True))
    request = replace(REQUEST, skips=("slot",), by=by)
    attempt = Attempts(left)
    ranks = [
        (count, seconds[machine.name] if by == "time" else 0, k)
        for k, (machine, count) in enumerate(zip(MACHINES, left, strict=True))
        if count is not None
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(arguments, "plan_seconds", lambda _, job: float(seconds[job.machine.name]))
        if not ranks:
            with pytest.raises(PlanError):
                on_best_machine(request, MACHINES, attempt)
            return
        (made,), said = on_best_machine(request, MACHINES, attempt)
    best = min(ranks)
    assert made.job.machine is MACHINES[best[2]]
    assert made.job.request.skips == ("slot",)
    assert said or (by, best[2]) == ("order", 0)
    for one in said:
        assert one.message.startswith(f"made on {MACHINES[best[2]].name}")
        others = [m.name for k, m in enumerate(MACHINES) if k != best[2]]
        assert by == "order" or all(name in one.message for name in others)


def test_one_machine_alone_says_what_it_always_said() -> None:
    def refused(request: Request) -> list[Planned]:
        raise PlanError(BAR_FULL.at(HERE, found=1, expected=2))

    with pytest.raises(PlanError) as caught:
        on_best_machine(REQUEST, MACHINES[:1], refused)
    assert [d.code for d in caught.value.diagnostics] == ["plan-bar-full"]


def test_a_slot_goes_to_the_machine_with_a_mill_and_is_read_back_there(tmp_path: Path) -> None:
    job = tmp_path / "slot.gcode"
    done = call("post", BAD / "slot.nc1", "-o", job, status=0)
    assert "note plan-machine: made on beamline-pusher; beamline cannot: plan-slot" in done.stderr
    assert "MACHINE beamline-pusher" in job.read_text("ascii")
    for words in (("verify", job, "--against", BAD / "slot.nc1"), ("verify", job),
                  ("diff", job, job)):  # fmt: skip
        call(*words, status=0)
    plan = call("plan", BAD / "slot.nc1", "--json")
    assert json.loads(plan.stdout)["machine"] == "beamline-pusher"


def test_the_quickest_takes_it_where_time_is_asked_for(tmp_path: Path) -> None:
    """The order names the slower one first; both make it. What is said are the times of `post`."""
    config = tmp_path / "beamcam.toml"
    config.write_text('[machines]\nbeam = ["beamline-pusher", "beamline"]\n')
    words = (GOOD / "tie.nc1", "--config", config, "-o")
    job = tmp_path / "job.gcode"
    done = call("post", *words, job)
    assert ("MACHINE beamline-pusher" in job.read_text("ascii"), "plan-machine" in done.stderr) == (
        True, False,
    )  # fmt: skip
    slow = clock(
        post(read_file(str(GOOD / "tie.nc1")).parts, MACHINES[1]).time(MACHINES[1]).total_s
    )
    done = call("post", *words, job, "--by", "time")
    assert "MACHINE beamline " in job.read_text("ascii")
    (quick,) = re.findall(r"job.gcode: .*, ([0-9:]+ (?:min|s)); read back", done.stderr)
    said = f"note plan-machine: made on beamline ({quick}); beamline-pusher ({slow})"
    assert said in done.stderr
    for command in ("plan", "batch", "report"):
        end = {"plan": "-", "batch": tmp_path / "out", "report": tmp_path / "sheet.html"}[command]
        done = call(command, *words, end, "--by", "time", "-v")
        assert said in done.stderr, (command, done.stderr)
    config.write_text(f'by = "time"\n{config.read_text()}')
    assert call("post", *words, job).exit_code == 0
    assert "MACHINE beamline " in job.read_text("ascii")
    assert call("post", *words, job, "--by", "order").exit_code == 0
    assert "MACHINE beamline-pusher" in job.read_text("ascii")
    table = call("list", *words[:3], "--json")
    assert '"beamline"' in table.stdout
    parts = read_file(str(GOOD / "tie.nc1")).parts
    assert [lists(parts, by=by).parts.rows[0] for by in ("order", "time")] == [
        lists(parts, "beamline").parts.rows[0]
    ] * 2
    with pytest.raises(AskError):
        lists(parts, by="speed")  # type: ignore[arg-type]


def test_time_counts_all_programs_of_a_quantity(tmp_path: Path) -> None:
    job = tmp_path / "job.gcode"
    words = ("post", GOOD / "tie.nc1", "-o", job, "--by", "time", "--quantity", "8")
    said = call(*words, "--bar", "1500").stderr
    times = re.findall(r"job-\d.gcode: .*, (\d+):(\d+) min; read back", said)
    (told,) = re.findall(r"made on beamline \((\d+):(\d+) min\)", said)
    assert len(times) > 1
    assert abs(sum(60 * int(m) + int(s) for m, s in times) - 60 * int(told[0]) - int(told[1])) <= 2


def test_where_none_makes_all_the_one_that_leaves_least_takes_it(tmp_path: Path) -> None:
    """Of the slot and the cope the pusher makes the slot; the beamline, first in order, neither."""
    part = read_file(str(BAD / "cope.nc1")).parts[0]
    slot = read_file(str(BAD / "slot.nc1")).parts[0].features[0]
    request = Request(
        (replace(part, features=(*part.features, slot)),), MACHINES[0], ("cope", "slot")
    )
    (made,), (said,) = on_best_machine(request, MACHINES[:2], plans_of)
    assert made.job.machine.name == "beamline-pusher"
    assert said.message == "made on beamline-pusher (leaves out 1); beamline (leaves out 2)"


def test_the_shipped_lists_have_the_quicker_machine_first() -> None:
    """So that their order, which costs one plan, is that of time."""
    compared = 0
    for path in sorted(GOOD.glob("*.nc1")):
        (part,) = read_file(str(path)).parts
        machines = [load(name) for name in default_machines(stock_of((part,)))]
        with suppress(PlanError):
            request = Request((part,), machines[0])
            (first, *_), _ = on_best_machine(request, machines, plans_of)
            (quickest, *_), _ = on_best_machine(replace(request, by="time"), machines, plans_of)
            assert first.job.machine is quickest.job.machine, path
            compared += 1
    assert compared >= 8


def test_the_messages_are_those_of_what_stands_in_the_way() -> None:
    """A saw that does not take the section, and one that cannot cope, say nothing of a bad cope."""
    tube, saw, coper = (
        tuple(Diagnostic(HERE, Severity.ERROR, code, "found ...") for code in codes)
        for codes in (["plan-section"], ["plan-cope"], ["plan-coping-root", "plan-coping-root"])
    )
    for refused in permutations(zip(MACHINES, (tube, saw, coper), strict=True)):
        *first, last = none_makes_it(refused, HERE)
        assert (tuple(first), last.code) == (coper, "plan-no-machine")


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("coping/coped.nc1", "coper-linuxcnc"), ("coping/girder.nc1", "coper-linuxcnc"),
        ("coping/brace.nc1", "tube-linuxcnc"), ("coping/stub.nc1", "tube-linuxcnc"),
        ("dstv/tube.nc1", "tube-linuxcnc"), ("dstv/channel.nc1", "beamline"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("by", ["order", "time"])
def test_a_torch_takes_what_no_line_makes(path: str, name: str, by: str, tmp_path: Path) -> None:
    """Profiles, tubes, and a pipe that is written as a plate; however quick it is."""
    job = tmp_path / "job.gcode"
    call("post", ROOT / "samples" / path, "-o", job, "--by", by, status=0)
    (found,) = re.findall(r"MACHINE (\S+)", job.read_text("ascii"))
    assert found == name if by == "order" else load(found).stock == load(name).stock


def test_what_nobody_makes_says_why_of_each() -> None:
    done = call("post", BAD / "cope.nc1", "-o", "-")
    assert (done.exit_code, done.stdout) == (1, "")
    assert "error plan-no-machine" in done.stderr
    assert "beamline: plan-" in done.stderr
    assert "beamline-pusher: plan-" in done.stderr


def test_the_configuration_names_several(tmp_path: Path) -> None:
    config = tmp_path / "beamcam.toml"
    config.write_text('[machines]\nbeam = ["beamline-annex", "beamline-pusher"]\n')
    job = tmp_path / "job.gcode"
    done = call("post", GOOD / "tie.nc1", "-o", job, "--config", config)
    assert (done.exit_code, "MACHINE beamline-annex" in job.read_text("ascii")) == (0, True)
    done = call("post", BAD / "slot.nc1", "-o", job, "--config", config)
    assert (done.exit_code, "MACHINE beamline-pusher" in job.read_text("ascii")) == (0, True)
    done = call(
        "post", BAD / "slot.nc1", "-o", job, "--config", config, "--machine", "beamline", status=1
    )
    assert "plan-no-machine" not in done.stderr
    config.write_text('[machines]\nbeam = ["beamline", "no-such"]\n')
    done = call("post", GOOD / "tie.nc1", "-o", job, "--config", config)
    assert (done.exit_code, "no-such" in done.stderr) == (1, True)


def test_a_batch_spreads_its_parts_and_checks_them(tmp_path: Path) -> None:
    out = tmp_path / "out"
    inputs = (GOOD / "tie.nc1", BAD / "slot.nc1", BAD / "saw-angle-out-of-range.nc1")
    done = call("batch", *inputs, "-o", out, "--jobs", "1", "--json", status=0)
    rows = [part for row in json.loads(done.stdout)["files"] for part in row["parts"]]
    assert [part["machine"] for part in rows] == ["beamline", "beamline-pusher", "beamline-pusher"]
    call("check", out, status=0)


SLOT = str(BAD / "slot.nc1")


@pytest.mark.parametrize("command", ["post", "plan", "batch", "report"])
def test_a_machine_that_makes_all_of_it_goes_before_one_that_leaves_something_out(
    command: str, tmp_path: Path
) -> None:
    """The beamline has no mill and could leave the slot out, as is allowed; the pusher mills it."""
    out = {"post": "job.gcode", "plan": "plan.json", "batch": "programs", "report": "sheet.html"}
    words = (command, SLOT, "--allow-skips", "slot", "-o", tmp_path / out[command])
    done = call(*words, status=0)
    told = "made on beamline-pusher; beamline cannot: plan-slot" in done.stderr
    assert told == (command != "batch")  # whose notes stand in its report
    assert "plan-left-out" not in done.stderr
    written = b"".join(p.read_bytes() for p in tmp_path.rglob("*") if p.is_file())
    assert b"beamline-pusher" in written


def test_where_no_machine_makes_all_of_it_the_first_leaves_out_what_is_allowed(
    tmp_path: Path,
) -> None:
    job = tmp_path / "job.gcode"
    call("post", BAD / "cope.nc1", "--allow-skips", "cope", "-o", job, status=0)
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
    call("post", GOOD / name, "--machine", machine, *words, "-o", job, status=0)
    for asked in (
        ("verify", job), ("verify", job, "--against", GOOD / name, *words), ("diff", job, job),
        ("simulate", job, "-o", tmp_path / "t.csv"),
    ):  # fmt: skip
        call(*asked, status=0)


def test_a_head_names_no_file(tmp_path: Path) -> None:
    """A program that names a machine file is judged by a machine that is known here."""
    lax, job = tmp_path / "lax.toml", tmp_path / "job.gcode"
    lax.write_text('base = "beamline"\nname = "lax"\n\n[limits]\n', encoding="ascii")
    assert call("post", GOOD / "tie.nc1", "-o", job).exit_code == 0
    text = job.read_text(encoding="ascii").replace("MACHINE beamline", f"MACHINE {lax}")
    job.write_text(text, encoding="ascii")
    call("simulate", job, "-o", tmp_path / "t.json", status=0)
    assert json.loads((tmp_path / "t.json").read_text(encoding="utf-8"))["machine"] == "beamline"
