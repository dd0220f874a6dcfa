"""What a machine can hold of a bar: the read-back refuses what the planner would, by itself."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam import pipeline
from beamcam.checks.bars import verify
from beamcam.errors import PlanError, VerifyError
from beamcam.machine import Machine, load
from beamcam.machine.machine import Layout
from beamcam.model.part import EndCuts, Hole, Part
from beamcam.pipeline import post
from beamcam.planning.beam import plan_bar
from beamcam.posts import post_of
from benchmarks.liars import PROFILES, SOURCE, told, unheld
from benchmarks.mutation import MACHINES
from tests.conftest import ROOT, examples
from tests.runs import call

PUSHER = load("beamline-pusher")
SAME = {
    "plan-part-short": "verify-part-short", "plan-bar-full": "verify-bar-end",
    "plan-bar-left": "verify-bar-left", "plan-bar-short": "verify-bar-size",
    "plan-bar-long": "verify-bar-size",
}  # fmt: skip


def with_layout(machine: Machine, **values: float | None) -> Machine:
    assert machine.layout is not None
    return replace(machine, layout=replace(machine.layout, **values))  # type: ignore[arg-type]


def part(length: float, cuts: tuple[float, float] = (0.0, 0.0)) -> Part:
    return Part("A", PROFILES[0], length, SOURCE, cuts=EndCuts(*cuts))


def codes(text: str, parts: list[Part], machine: Machine, bar: float | None) -> set[str]:
    return {said.code for said in verify(text, parts, machine, bar=bar)}


lengths = st.sampled_from((100.0, 145.0, 400.0, 1000.0, 2500.0))
parts_of_bars = st.lists(
    st.builds(part, lengths, st.tuples(*[st.sampled_from((0.0, 0.0, 10.0))] * 2)),
    min_size=1, max_size=3,
)  # fmt: skip
limits = st.fixed_dictionaries({
    "min_part": st.sampled_from((0.0, 100.0, 145.0, 146.0)),
    "dead_zone": st.sampled_from((0.0, 280.0)),
    "end_trim": st.sampled_from((0.0, 30.0)),
    "min_bar_left": st.sampled_from((0.0, 700.0, 1200.0)),
    "min_bar": st.sampled_from((0.0, 1200.0)),
    "max_bar": st.sampled_from((None, 3000.0, 15000.0)),
})  # fmt: skip


@settings(deadline=None, max_examples=examples(80))
@given(parts_of_bars, limits, st.integers(0, 900), st.sampled_from(("beamline", "beamline-pusher")))
def test_a_bar_that_the_planner_refuses_the_read_back_refuses(
    parts: list[Part], values: dict[str, float | None], more: int, name: str
) -> None:
    """Of a program that was planned for a machine without any limit, on a bar of any length."""
    free = with_layout(load(name), **{key: None if key == "max_bar" else 0.0 for key in values})
    bar = plan_bar(parts, free).bar.length + more + 0.5
    text = post(parts, free, bar=bar).text
    assert codes(text, parts, free, bar) == set()
    machine = with_layout(free, **values)
    found = codes(text, parts, machine, bar)
    refused: set[str] = set()
    try:
        plan_bar(parts, machine, bar)
    except PlanError as error:
        refused = {SAME[said.code] for said in error.diagnostics}
    assert refused <= found
    assert bool(refused) == bool(found)


@settings(deadline=None, max_examples=examples(40))
@given(parts_of_bars, limits, st.sampled_from((1, 3)))
def test_a_bar_that_is_just_enough_is_enough(
    parts: list[Part], values: dict[str, float | None], decimals: int
) -> None:
    """Whatever the numbers are rounded to; and so is that which the planner takes unasked."""
    machine = with_layout(PUSHER, **{**values, "max_bar": None, "min_part": 0.0})
    machine = replace(machine, format=replace(machine.format, length_decimals=decimals))
    unasked = post(parts, machine)
    assert not [said for said in unasked.remarks if said.code.startswith("verify-bar")]
    bar = plan_bar(parts, machine).bar.length
    text = post(parts, machine, bar=bar).text
    assert codes(text, parts, machine, bar) == set()
    needed = codes(text, parts, machine, None)
    assert needed == ({"verify-bar-needed"} if values["dead_zone"] or values["end_trim"] else set())


def test_every_bar_that_a_machine_cannot_hold_is_refused() -> None:
    lies = told(MACHINES, every=10**9)
    assert lies.missed == []
    assert set(lies.made) == {
        *(f"without {key}" for key in (
            "min_part", "front_trim", "dead_zone", "end_trim", "min_bar_left", "max_bar",
            "saw.max_width", "saw.max_height", "saw.max_sections", "drill.max_height", "tools",
            "layout.profiles",
        )),
        "without dead_zone, bar not given", "without end_trim, bar not given",
    }  # fmt: skip


def test_each_limit_has_a_message_of_its_own() -> None:
    parts = [part(1000.0), part(145.0)]
    layout = Layout("drill-saw", front_trim=15.0)
    free = replace(PUSHER, layout=layout)
    text = post(parts, free, bar=1600.0).text
    for values, bar, message in (
        ({"min_part": 145.0}, 1600.0, ""),
        ({"min_part": 146.0}, 1600.0,
         "error verify-part-short: found the part A, 145.000 mm long; expected at least 146 mm"),
        ({"front_trim": 15.5}, 1600.0,
         "error verify-bar-start: found the part A to start 15.000 mm behind the front of the "
         "bar; expected at least 15.5 mm"),
        ({"dead_zone": 280.0, "end_trim": 10.0}, 1450.0,
         "error verify-bar-end: found the last cut to end 1163.200 mm from the front of the bar; "
         "expected at most 1160.000 mm, that is 290 mm from its end"),
        ({"dead_zone": 280.0}, 1443.2, ""),
        ({"min_bar": 1700.0, "max_bar": 1800.0}, 1600.0,
         "error verify-bar-size: found a bar of 1600.000 mm; expected 1700 to 1800 mm"),
        ({"max_bar": 1400.0, "dead_zone": 280.0}, None,
         "error verify-bar-size: found a bar of 1443.200 mm; expected 0 to 1400 mm"),
        ({"min_bar_left": 600.0}, 1600.0,
         "error verify-bar-left: found 583.400 mm of bar from the start of A on; expected at "
         "least 600 mm"),
        ({"dead_zone": 280.0}, None,
         "note verify-bar-needed: the length of the bar is not in the program; 1443.200 mm are "
         "needed, of which its end takes 280 mm; whether the bar is as long was not checked, "
         "give it by --bar"),
        ({"min_bar_left": 600.0}, None, ""),
    ):  # fmt: skip
        machine = replace(PUSHER, layout=replace(layout, **values))  # type: ignore[arg-type]
        first, *_ = [*map(str, verify(text, parts, machine, bar=bar)), ""]
        assert first.partition(": ")[2] == message


def test_the_plan_tells_of_a_bar_as_long_as_its_program_needs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    said = {lie: (job, plan) for lie, job, plan in unheld(PUSHER, PROFILES[0])}
    job, plan = said["without dead_zone, bar not given"]
    row = replace(post_of(job.machine), plan=lambda _: plan)
    monkeypatch.setattr(pipeline, "post_of", lambda _: row)
    with pytest.raises(VerifyError) as refused:
        post(job.parts, job.machine)
    assert [str(one) for one in refused.value.diagnostics] == [
        "JOB: error verify-bar-told: found a program that needs a bar of 5328.200 mm; expected "
        "at most the 5048.200 mm of the plan"
    ]


def test_a_part_that_comes_cut_is_the_bar() -> None:
    free = replace(with_layout(PUSHER, min_bar=0.0, max_bar=None), saw=None)
    hole = Hole("v", 300.0, 150.0, 22.0, SOURCE)
    square = replace(part(1000.0), features=(hole,))
    text = post([square], free).text
    assert codes(text, [square], free, None) == set()
    for values in ({"min_bar": 1001.0}, {"max_bar": 999.0}):
        machine = with_layout(free, **values)
        assert codes(text, [square], machine, None) == {"verify-bar-size"}
    # It is neither sawn off nor held by the end of a bar.
    other = with_layout(free, min_part=1001.0, dead_zone=280.0, front_trim=15.0)
    assert codes(text, [square], other, None) == set()


def test_pieces_of_145_mm_come_off_the_line_of_the_annex() -> None:
    short, annex = part(145.0), load("beamline-annex")
    parts = [short, part(2500.0)]
    text = post(parts, annex).text
    assert codes(text, parts, annex, None) == set()
    assert codes(text, parts, with_layout(annex, min_part=145.1), None) == {"verify-part-short"}


def test_verify_says_once_that_it_knows_no_bar(tmp_path: Path) -> None:
    sample, target = str(ROOT / "samples/dstv/beam.nc1"), tmp_path / "job.gcode"

    def run(*args: str) -> tuple[int, list[str]]:
        done = call(*args, "--machine", "beamline-pusher")
        return done.exit_code, done.stderr.splitlines()

    assert "verify-bar-needed" not in "".join(run("post", sample, "-o", str(target))[1])
    assert run("verify", str(target), "--against", sample) == (0, [])  # its head names the bar
    bare = [line for line in target.read_text().splitlines() if not line.startswith("(")]
    target.write_text("\n".join(bare) + "\n")
    status, said = run("verify", str(target), "--against", sample)
    assert status == 0
    assert ["verify-bar-needed" in line for line in said] == [True]
    assert run("verify", str(target), "--against", sample, "--bar", "9000") == (0, [])
    status, said = run("verify", str(target), "--against", sample, "--bar", "4400")
    assert status == 1
    assert ["error verify-bar-end" in line for line in said] == [True]
