"""What a machine's file says of marks: made, left for manual work with a list, or refused."""

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import pytest
from msgspec.structs import replace

from beamcam import pipeline
from beamcam.checks.job import head_of
from beamcam.checks.rules import MANUAL_WORK as FOR_MANUAL_WORK
from beamcam.commands.value_types import SkipNames
from beamcam.errors import PlanError
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Marks, Policy
from beamcam.model.part import Contour, Feature, Hole, Part, TextMark
from beamcam.model.plan import SKIP_NAMES, Outcome
from beamcam.model.request import MarkKind, Request, mark_kind
from beamcam.pipeline import Posted, RefusedProgram, post, read_back
from beamcam.planning.left_out import MANUAL_WORK
from beamcam.planning.manual_list import HEAD, LIST_SUFFIX, as_csv, manual_rows
from tests.conftest import SAMPLES
from tests.runs import batch, call, counts, part, report
from tests.unit.planning.shop import part as beam
from tests.unit.sheets.parts import S, plate

MARK_KINDS = {*get_args(MarkKind)}

TEXT = TextMark("v", 100.0, 50.0, 0.0, 10.0, "X10", S)
POINT = Hole("v", 150.0, 60.0, 0.0, S, kind="mark")
LINE = Contour("v", "open", (Line((20.0, 20.0), (80.0, 20.0)),), S, "punch", False)
MARKED: dict[str, Feature] = {"text": TEXT, "points": POINT, "contours": LINE}
LETTERED = "SI\n  v 100.00u 50.00 0.00 10 =X10\n  v 400.00u 50.00 90.00 12 B,2\nEN\n"


def lettered(mark: str = "P1") -> str:
    return part(mark).replace("EN\n", LETTERED)


def with_policy(name: str, **policies: Policy) -> Machine:
    return replace(load(name), marks=Marks(**policies))  # type: ignore[arg-type]


def listed(posted: Posted) -> list[int]:
    return [o.feature[1] for o in posted.plan.outcomes if o.how == "listed"]


def test_every_kind_of_mark_has_its_policy() -> None:
    assert {mark_kind(feature) for feature in MARKED.values()} == MARK_KINDS
    assert {*MARKED} == MARK_KINDS == {*Marks.__struct_fields__} & MARK_KINDS
    assert mark_kind(Hole("v", 1.0, 1.0, 9.0, S)) is None
    assert mark_kind(replace(LINE, process="cut")) is None
    assert mark_kind(replace(LINE, colour="#0000ff")) is None  # the map of colours decides


@pytest.mark.parametrize("kind", sorted(MARK_KINDS))
@pytest.mark.parametrize(("name", "made"), [("beamline-pusher", beam), ("plate-linuxcnc", plate)])
def test_a_policy_of_list_leaves_a_mark_to_the_hand(name: str, made: Any, kind: str) -> None:
    one: Part = made(MARKED[kind])
    machine = with_policy(name, **{kind: "list"})
    posted = post([one], machine)
    assert listed(posted) == [0]
    assert [said.code for said in posted.remarks] == [MANUAL_WORK.code]
    assert "LEFT TO THE HAND: 1" in posted.text
    found = read_back(posted.text, Request((one,), machine), 12000.0)
    assert [said.code for said in found] == [FOR_MANUAL_WORK.code]
    assert "MARKED" not in posted.text


@pytest.mark.parametrize("kind", sorted(MARK_KINDS))
@pytest.mark.parametrize(("name", "made"), [("beamline-pusher", beam), ("plate-linuxcnc", plate)])
def test_a_policy_of_refuse_refuses_what_the_machine_could_make(
    name: str, made: Any, kind: str
) -> None:
    one: Part = made(MARKED[kind])
    machine = with_policy(name, **{kind: "refuse"})
    with pytest.raises(PlanError, match=f"marks.{kind} of the machine file is"):
        post([one], machine)
    posted = post([one], machine, skips=("mark",))
    assert [o.by for o in posted.plan.outcomes] == ["plan-mark"]
    found = read_back(posted.text, Request((one,), machine), 12000.0)
    code = "verify-not-made" if machine.torch is None else "verify-sheet-not-made"
    assert [(said.code, said.severity.value) for said in found] == [(code, "error")]


@pytest.mark.parametrize("kind", ["points", "contours"])
def test_a_mark_that_is_made_all_the_same_is_refused(kind: str) -> None:
    one = beam(MARKED[kind])
    text = post([one], load("beamline-pusher")).text
    found = read_back(text, Request((one,), with_policy("beamline-pusher", **{kind: "list"})))
    assert "error" in {said.severity.value for said in found}


def test_pieces_of_one_part_share_their_rows() -> None:
    one = beam(TEXT)
    posted = post([one, one, replace(one, mark="P2")], load("beamline"))
    rows = manual_rows(posted.plan)
    assert [(row["mark"], row["pieces"]) for row in rows] == [("P1", 2), ("P2", 1)]
    head = head_of(posted.text)
    assert head is not None
    assert head.manual_work == 3
    assert [said.code for said in posted.remarks].count(MANUAL_WORK.code) == 1


def test_the_list_says_what_and_where() -> None:
    machine = with_policy("beamline", points="list", contours="list")
    posted = post([beam(TEXT, POINT, LINE)], machine)
    first, *rows = csv.reader(as_csv(manual_rows(posted.plan)).splitlines())
    assert tuple(first) == HEAD
    line = dict(zip(HEAD, rows[2], strict=True))
    assert [row[3:11] for row in rows] == [
        ["text", "X10", "v", "100", "50", "0", "10", ""],
        ["point", "", "v", "150", "60", "0", "0", ""],
        ["line", "", "v", "20", "20", "0", "0", "20 20; 80 20"],
    ]
    assert line["source"] == "p.nc1:7"


def test_what_allow_skips_leaves_out_stands_on_the_list(tmp_path: Path) -> None:
    source, target = SAMPLES / "coping" / "coped.nc1", tmp_path / "p.gcode"
    skips = "cope,cutout,slot,tool"
    call("post", source, "-o", target, "--machine", "beamline", "--allow-skips", skips, status=0)
    rows = list(csv.DictReader(Path(f"{target}{LIST_SUFFIX}").read_text().splitlines()))
    assert [(row["kind"], row["face"], row["why"], row["size"]) for row in rows] == [
        ("outline", "v", "plan-cope", ""), ("outline", "o", "plan-cope", ""),
        ("cut-out", "v", "plan-cutout", ""), ("hole", "v", "plan-tool", "60"),
        ("slot", "o", "plan-slot", "58 x 18"), ("slot", "o", "plan-slot", "58 x 18"),
    ]  # fmt: skip
    assert "(LEFT OUT: 2 cope, 1 cutout, 2 slot, 1 tool)" in target.read_text()


def test_the_list_stands_beside_the_program(tmp_path: Path) -> None:
    source, target = tmp_path / "p.nc1", tmp_path / "p.gcode"
    source.write_text(lettered())
    done = call("post", source, "-o", target, "--json", status=0)
    assert [m["line"] for m in json.loads(done.stderr) if m["code"] == MANUAL_WORK.code] == [30, 31]
    beside = Path(f"{target}{LIST_SUFFIX}")
    rows = list(csv.DictReader(beside.read_text().splitlines()))
    assert [row["text"] for row in rows] == ["'=X10", "B,2"]  # no formula for a spreadsheet
    call("verify", target, "--against", source)
    assert call("post", source, "-o", target, "--strict", "--exit-left-out", 3).exit_code == 3
    assert call("verify", target, "--against", source, "--exit-left-out", 3).exit_code == 3
    source.write_text(part("P1"))
    call("post", source, "-o", target)
    assert not beside.exists()
    beside.write_text("somebody's own\n")
    call("post", source, "-o", target)
    assert beside.read_text() == "somebody's own\n"


def test_a_list_is_not_written_over_an_input(tmp_path: Path) -> None:
    source = tmp_path / f"p.gcode{LIST_SUFFIX}"
    source.write_text(lettered())
    call("post", source, "-o", tmp_path / "p.gcode", status=1)
    assert source.read_text() == lettered()


def test_a_batch_writes_the_lists_and_counts_them(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.nc1").write_text(lettered("A"))
    (tmp_path / "in" / "b.nc1").write_text(part("B"))
    words = (tmp_path / "in", "-o", tmp_path / "out", "--report", tmp_path / "r.json")
    done = batch(*words, "--exit-left-out", 3)
    assert (done.exit_code, counts(done)) == (3, (2, 0, 0, 0))
    assert done.stderr.endswith("0 failed, 2 left for manual work\n")
    beside = tmp_path / "out" / f"a.gcode{LIST_SUFFIX}"
    first, second = (row["parts"][0] for row in report(tmp_path / "r.json")["files"])
    assert [row["text"] for row in first["by_hand"]] == ["=X10", "B,2"]
    assert (first["ledger"]["listed"], second["by_hand"]) == (2, [])
    whole = beside.read_bytes()
    assert counts(batch(*words)) == (0, 2, 0, 0)
    beside.unlink()  # an output that is missing is made again
    assert counts(batch(*words)) == (1, 1, 0, 0)
    assert beside.read_bytes() == whole
    assert not (tmp_path / "out" / f"b.gcode{LIST_SUFFIX}").exists()


def test_check_compares_the_lists(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.nc1").write_text(lettered("A"))
    golden = tmp_path / "golden" / "beamline"
    batch(tmp_path / "in", "-o", golden)
    words = ("check", tmp_path / "golden", "--samples", tmp_path / "in")
    assert call(*words).exit_code == 0
    (golden / f"a.gcode{LIST_SUFFIX}").unlink()
    done = call(*words, status=1)
    assert "found 0 mark(s) of manual work, now 2" in done.stdout


def test_diff_and_recover_know_what_a_head_leaves_for_manual_work(tmp_path: Path) -> None:
    source, a, b = tmp_path / "p.nc1", tmp_path / "a.gcode", tmp_path / "b.gcode"
    source.write_text(lettered())
    call("post", source, "-o", a)
    source.write_text(part("P1"))
    call("post", source, "-o", b)
    done = call("diff", a, b)
    assert (done.exit_code, done.stdout) == (1, "marks left for manual work: 2 in A, 0 in B\n")
    assert call("diff", a, a).exit_code == 0
    done = call("recover", a, "--profile", "UPN200", "-o", tmp_path / "again.nc1", status=0)
    assert "warning recover-by-hand: found 2 mark(s) left for manual work" in done.stderr


def changed(how: str) -> Any:
    """`post_of` of a machine whose planner says otherwise what became of the texts."""
    row = pipeline.post_of(load("beamline"))

    def as_told(o: Outcome) -> Outcome:
        return replace(o, how=how, by="plan-mark") if o.how == "listed" else o

    def plan(job: Any) -> Any:
        made = row.plan(job)
        return replace(made, outcomes=tuple(map(as_told, made.outcomes)))

    return lambda machine: replace(row, plan=plan)


@pytest.mark.parametrize("how", ["made", "skipped"])
def test_a_plan_that_hides_what_is_left_to_the_hand_is_refused(
    how: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipeline, "post_of", changed(how))
    with pytest.raises(RefusedProgram, match="verify-ledger"):
        post([beam(TEXT)], load("beamline"))


@pytest.mark.parametrize(
    ("value", "names"),
    [
        ("slot,cope", ["cope", "slot"]),
        (" slot , cope", ["cope", "slot"]),
        ("all", sorted(SKIP_NAMES)),
        ("all,none", sorted(SKIP_NAMES)),
    ],
)
def test_skips_are_several_with_commas_or_all(
    value: str, names: Sequence[str], tmp_path: Path
) -> None:
    source, target = tmp_path / "p.nc1", tmp_path / "p.gcode"
    source.write_text(part("P1"))
    assert call("post", source, "-o", target, "--allow-skips", value).exit_code == 0
    head = head_of(target.read_text())
    assert head is not None
    assert [*head.allowed] == [*names]
    assert call("verify", target, "--against", source).exit_code == 0


def test_a_name_among_several_that_is_none_is_wrong_usage(tmp_path: Path) -> None:
    done = call("post", "x", "-o", "y", "--allow-skips", "slot,cop", status=2)
    assert "'cop' is not one of" in done.stderr
    assert SkipNames(["a"]).convert("a, a", None, None) == "a,a"


def test_all_is_never_a_size_an_angle_or_a_thickness(tmp_path: Path) -> None:
    source = tmp_path / "p.nc1"
    for text in (part("P1", 50.0), part("P1").replace("200.00\n", "1200.00\n", 1)):
        source.write_text(text)
        assert call("post", source, "-o", tmp_path / "p", "--allow-skips", "all").exit_code == 1
    assert not {*SKIP_NAMES} & {"saw-angle", "section", "thickness", "part-short", "bar-long"}


def test_a_configuration_and_a_caller_may_say_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("beamcam.toml").write_text('allow_skips = ["all"]\n')
    Path("p.nc1").write_text(part("P1"))
    assert call("post", "p.nc1", "-o", "p.gcode").exit_code == 0
    head = head_of(Path("p.gcode").read_text())
    assert head is not None
    assert [*head.allowed] == sorted(SKIP_NAMES)
    slot = replace(POINT, kind="thread", diameter=3.0)
    posted = post([beam(slot)], load("beamline"), skips=("all",))
    assert [o.by for o in posted.plan.outcomes] == ["plan-tool"]
