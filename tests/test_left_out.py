"""What a program does not make is told, in every command that writes one."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from msgspec.structs import replace

from beamcam import pipeline
from beamcam.errors import Diagnostic, PlanError, Severity, Source
from beamcam.machine import load
from beamcam.model.description import description
from beamcam.model.part import Camber, Contour, EndPlane, Feature, TextMark
from beamcam.model.plan import Outcome
from beamcam.model.request import Job
from beamcam.pipeline import RefusedProgram, parts_of, post, read_file
from beamcam.planning.left_out import IDLE, LEFT_OUT, NOT_CUT, UNMATCHED
from beamcam.planning.manual_list import manual_rows
from beamcam.posts import post_of
from tests.conftest import SAMPLES
from tests.runs import batch, call, counts, report
from tests.unit.sheets.parts import S

SLOT = str(SAMPLES / "bad" / "slot.nc1")
COPE = str(SAMPLES / "bad" / "cope.nc1")
PLATE = str(SAMPLES / "dxf" / "plate.dxf")


def said(result: Result) -> list[tuple[str, int | None, str]]:
    """Code, line and severity of each message of a call with --json."""
    return [(m["code"], m["line"], m["severity"]) for m in json.loads(result.stderr)]


@pytest.mark.parametrize(("sample", "kind"), [(SLOT, "slot"), (COPE, "cope")])
def test_a_feature_that_is_left_out_is_a_warning_at_its_line(
    sample: str, kind: str, tmp_path: Path
) -> None:
    target = tmp_path / "a.gcode"
    words = ("post", sample, "--machine", "beamline", "-o", target, "--json")
    refused = call(*words)
    wanted = [line for code, line, _ in said(refused) if code == f"plan-{kind}"]
    assert refused.exit_code == 1
    assert wanted
    assert not target.exists()
    done = call(*words, "--allow-skips", kind, status=0)
    assert target.exists()
    left = [(line, weight) for code, line, weight in said(done) if code == LEFT_OUT.code]
    assert left == [(line, "warning") for line in wanted]


def test_what_is_left_out_has_an_exit_status_if_asked_for(tmp_path: Path) -> None:
    words = ("--machine", "beamline", "--allow-skips", "slot", "--exit-left-out", 3)
    assert call("post", SLOT, "-o", tmp_path / "a.gcode", *words).exit_code == 3
    call("post", SAMPLES / "dstv/channel.nc1", "-o", tmp_path / "b.gcode", *words, status=0)
    for status in (0, 126):
        call("post", SLOT, "-o", tmp_path / "c.gcode", "--exit-left-out", status, status=2)
    done = batch(SLOT, "-o", tmp_path / "out", *words)
    assert (done.exit_code, counts(done)) == (3, (1, 0, 0, 0))
    assert "plan-left-out" in done.stderr
    assert done.stderr.endswith("0 failed, 1 left out\n")
    again = batch(SLOT, "-o", tmp_path / "out", *words)
    assert (again.exit_code, counts(again)) == (3, (0, 1, 0, 0))
    batch(SLOT, COPE, "-o", tmp_path / "out", *words, status=1)


def test_strict_takes_what_is_allowed_by_name(tmp_path: Path) -> None:
    words = ("--machine", "beamline", "--allow-skips", "slot", "--strict")
    done = call("post", SLOT, "-o", tmp_path / "a", *words, status=0)
    assert LEFT_OUT.code in done.stderr


def test_a_part_that_lies_on_the_bar_twice_is_told_of_once(tmp_path: Path) -> None:
    words = ("--machine", "beamline", "--allow-skips", "slot", "--bar", 12000)
    done = call("post", SLOT, SLOT, "-o", tmp_path / "a", *words, status=0)
    assert done.stderr.count(LEFT_OUT.code) == 1


def test_curves_that_the_map_does_not_cut_are_a_note_with_their_number(tmp_path: Path) -> None:
    how = ("--thickness", 3, "--map", "ETCH=ignore", "--map", "red=mark")
    done = call("post", PLATE, "-o", tmp_path / "a.ngc", *how, status=0)
    told = [line for line in done.stderr.splitlines() if NOT_CUT.code in line]
    assert [line.split("found ")[1] for line in told] == [
        "16 curve(s) of colour red on layer 'CUT'; the map has them marked, not cut",
        "1 curve(s) of colour blue on layer 'ETCH'; the map has them ignored, not cut",
    ]


def test_a_key_of_the_map_that_no_curve_has_is_refused(tmp_path: Path) -> None:
    target = tmp_path / "a.ngc"
    done = call("post", PLATE, "-o", target, "--thickness", 3, "--map", "gren=cut", status=1)
    assert not target.exists()
    assert f"{UNMATCHED.code}: found --map gren=cut" in done.stderr
    assert "ETCH" in done.stderr


def test_a_configured_key_that_no_curve_has_is_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("beamcam.toml").write_text('[map]\ngren = "cut"\nETCH = "mark"\n')
    Path("plate.dxf").write_bytes(Path(PLATE).read_bytes())
    Path("gasket.dxf").write_bytes(Path(PLATE).read_bytes())
    done = call("post", "plate.dxf", "-o", "a.ngc", "--thickness", 3, status=0)
    assert done.stderr.count(IDLE.code) == 1
    assert "gren" in done.stderr
    run = batch("plate.dxf", "gasket.dxf", "-o", "out", "--thickness", 3, "--report", "r.json")
    assert run.stderr.count(IDLE.code) == 1
    assert counts(run) == (2, 0, 0, 0)
    (row, _) = report(Path("r.json"))["files"]
    assert row["parts"][0]["mapped"]["ETCH"] == 2  # a curve and a text


def test_a_refused_program_is_kept_beside_its_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sample = SAMPLES / "dstv/channel.nc1"
    fault = Diagnostic(Source("JOB", 3), Severity.ERROR, "verify-no-feed", "found none")
    row = replace(post_of(load("beamline")), verify=lambda *_: (fault,))
    monkeypatch.setattr(pipeline, "post_of", lambda machine: row)
    target = tmp_path / "a.gcode"
    done = call("post", sample, "-o", target, status=1)
    assert not target.exists()
    assert "% JOB" in (tmp_path / "a.gcode.refused").read_text()
    assert f"kept in {target}.refused" in done.stderr
    assert f"{target}.refused:3: error verify-no-feed: found none" in done.stderr.splitlines()
    to_nowhere = call("post", sample, "-o", "-")
    assert (to_nowhere.stdout, "JOB:3: error verify-no-feed" in to_nowhere.stderr) == ("", True)
    said = call("batch", sample, "-o", tmp_path / "out").stderr
    assert "channel.gcode.refused:3: error verify-no-feed: found none" in said.splitlines()
    assert "JOB" not in said
    assert sorted(p.name for p in (tmp_path / "out").glob("*gcode*")) == ["channel.gcode.refused"]


@pytest.mark.parametrize(
    ("feature", "words"),
    [
        (TextMark("v", 10, 20, 0, 15, "A1", S), "text 'A1' on face v at x 10, y 20"),
        (EndPlane((0, 0, 0), (-1, 0, 0), S), "end plane"),
        (Camber("v", 5, 0, S), "camber on face v at x 5, y 0"),
        (Contour("v", "inner", (), S, "punch"), "line to punch of 0 curve(s) on face v"),
    ],
)
def test_a_feature_in_words(feature: Feature, words: str) -> None:
    assert description(feature) == words


def lying(change: Callable[[Outcome], Outcome]) -> Any:
    """`post_of` of a machine whose planner says otherwise what became of each feature."""
    row = post_of(load("beamline"))

    def plan(job: Job) -> Any:
        made = row.plan(job)
        return replace(made, outcomes=tuple(map(change, made.outcomes)))

    return lambda machine: replace(row, plan=plan)


@pytest.mark.parametrize(
    ("sample", "change"),
    [
        (SLOT, lambda o: replace(o, how="made", by="mill") if o.how == "skipped" else o),
        (SAMPLES / "dstv/channel.nc1", lambda o: replace(o, how="skipped", by="plan-slot")),
    ],
)
def test_a_plan_that_says_otherwise_what_is_left_out_is_refused(
    sample: Path, change: Callable[[Outcome], Outcome], monkeypatch: pytest.MonkeyPatch
) -> None:
    parts, _ = parts_of([read_file(str(sample))])
    monkeypatch.setattr(pipeline, "post_of", lying(change))
    with pytest.raises(RefusedProgram, match=r" verify-ledger: found \d feature"):
        post(parts, load("beamline"), skips=("slot",))


@pytest.mark.parametrize("name", ["beamline", "beamline-pusher", "coper-linuxcnc"])
def test_a_beam_with_camber_is_made_straight_and_the_camber_listed(name: str) -> None:
    """DSTV, 7th edition, page 15: all other coordinates are without camber."""
    (flat,) = read_file(str(SAMPLES / "coping" / "coped.nc1")).parts
    flat = replace(flat, features=()) if name.startswith("beamline") else flat
    part = replace(flat, features=(*flat.features, Camber("v", 600.0, 8.0, S)))
    plain, posted = (post((one,), load(name)) for one in (flat, part))
    head = "LEFT TO THE HAND"
    assert [x for x in posted.text.splitlines() if head not in x and "PROGRAM" not in x] == [
        x for x in plain.text.splitlines() if "PROGRAM" not in x
    ]
    (row,) = manual_rows(posted.plan)
    assert (row["kind"], row["x"], row["y"]) == ("camber", 600.0, 8.0)
    strict = replace(load(name), marks=replace(load(name).marks, cambers="refuse"))
    with pytest.raises(PlanError, match="plan-other: found a"):
        post((part,), strict)
