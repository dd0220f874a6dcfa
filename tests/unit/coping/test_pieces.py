"""Pieces that come cut: what one machine leaves, the next one gets; both programs make the part."""

from collections.abc import Callable
from contextlib import suppress
from math import dist, radians, tan
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam import api, rest_part
from beamcam.arguments import AskError, InTurn
from beamcam.checks.coping import verify_coping
from beamcam.checks.coping.section import CoperSection
from beamcam.checks.coping.stock import stock_of
from beamcam.checks.rest import rest_faults
from beamcam.cli import main
from beamcam.controllers import cell_events
from beamcam.errors import BeamcamError, PlanError, Severity, errors_in
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, EndCuts, Hole, Part, Profile, Slot
from beamcam.model.request import Request
from beamcam.pipeline import Posted, post, read_back, read_file
from beamcam.planning import begun as begun_rules
from beamcam.planning.coping.ends import ends_on
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.coping.walls import EndLine
from beamcam.readers import read
from beamcam.readers.dstv import MADE
from beamcam.rest_part import Stage, chain_for, chain_of, rest_of_part, stages_of
from beamcam.solid.bar_solid import bar_pieces, work_of
from beamcam.writers import TARGETS
from tests.conftest import SAMPLES, examples, rules_of, sampled
from tests.random_copes import random_cope, random_tee
from tests.rs274 import needs_rs274
from tests.unit.coping.samples import (
    AT,
    COPER,
    IPE300,
    job_of,
    outline,
    part_of,
    program_of,
    sample,
)
from tests.unit.coping.test_rs274 import burns, compare, pieces


def call(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


SAW = load("beamline-pusher")
LEFT = ("cope", "cutout")
HEADER = sample("header")
COPE = [(0.0, 0.0), (600.0, 0.0), (600.0, 240.0), (520.0, 240.0), (520.0, 300.0), (0.0, 300.0)]
#: A coped end of a piece whose other end is a mitre: x 0 at y 300, 30 degrees.
MITRED = [(173.2051, 0.0), *COPE[1:5], (0.0, 300.0)]


def split_part(request: Request, machines: tuple[Machine, ...]) -> list[Stage]:
    chain, said = chain_for(request, machines)
    assert [d.code for d in said] == ["plan-split"]
    return [*stages_of(request, chain, TARGETS[0])]


def sawn(part: Part) -> Posted:
    return post((part,), SAW, skips=LEFT)


def rest_after(posted: Posted, target: int = 0) -> Part:
    found = rest_of_part(posted, TARGETS[target])
    assert found is not None
    return found[0]


def begun(*features: Any, cuts: EndCuts | None = None) -> Part:
    part = replace(part_of(*features), made=())
    return part if cuts is None else replace(part, cuts=cuts)


# --- the file -------------------------------------------------------------------------------------


def test_the_rest_has_what_is_not_made_and_what_is_there_as_made() -> None:
    rest = rest_after(sawn(HEADER))
    assert [type(f).__name__ + getattr(f, "face", "") for f in rest.features] == [
        "Contourv", "Contouro", "Contourv",
    ]  # fmt: skip
    assert rest.made is not None
    assert len(rest.made) == len(HEADER.features) - 3
    assert [f.source for f in rest.features] == [f.source for f in HEADER.features[10:13]]


@pytest.mark.parametrize("target", [0, 1])
def test_the_file_is_the_same_part_again(target: int, tmp_path: Path) -> None:
    posted = sawn(HEADER)
    found = rest_of_part(posted, TARGETS[target])
    assert found is not None
    path = tmp_path / f"rest{TARGETS[target].suffixes[0]}"
    path.write_text(found[1])
    reading = read_file(str(path))
    assert not reading.diagnostics
    assert TARGETS[target].write(reading.parts[0]) == found[1]


def test_another_reader_sees_only_what_is_to_be_made() -> None:
    """Blocks of DSTV that are no comments hold nothing that is there."""
    found = rest_of_part(sawn(HEADER), TARGETS[0])
    assert found is not None
    rows = [line for line in found[1].splitlines() if not line.startswith("**")]
    assert not any(line.strip() == "BO" for line in rows)
    assert sum(line.startswith("**BEAMCAM MADE   ") for line in found[1].splitlines()) == 11


def test_faults_of_what_is_there_are_told_in_its_line(tmp_path: Path) -> None:
    found = rest_of_part(sawn(HEADER), TARGETS[0])
    assert found is not None
    lines = found[1].splitlines()
    k = next(i for i, line in enumerate(lines) if line.startswith("**BEAMCAM MADE   v"))
    lines[k] = "**BEAMCAM MADE   v      60.00u      80.00      22.00  x  y"
    path = tmp_path / "rest.nc1"
    path.write_text("\n".join(lines))
    (said,) = errors_in(read_file(str(path)).diagnostics)
    assert (said.source.line, said.code) == (k + 1, "dstv-hole-fields")


def test_comments_go_with_what_they_stand_before(tmp_path: Path) -> None:
    text = (SAMPLES / "coping" / "header.nc1").read_text()
    text = text.replace("  o    400.00u     70.00", "**drilled\n  o    400.00u     70.00")
    path = tmp_path / "a.nc1"
    path.write_text(text.replace("AK\n  o ", "**coped\nAK\n  o "))
    rest = rest_after(sawn(read_file(str(path)).parts[0]))
    assert [(c.text, c.before) for c in rest.comments] == [("coped", "block:feature:1")]


def test_a_rest_that_is_not_what_is_left_is_refused() -> None:
    rest = rest_after(sawn(HEADER))
    missing = {10, 11, 12}
    assert not list(rest_faults(HEADER, rest, missing))
    wrong = (
        replace(rest, features=rest.features[1:]),  # never made
        replace(rest, features=(*rest.features, HEADER.features[0])),  # made twice
        replace(rest, made=rest.made[1:]), replace(rest, made=None), replace(rest, length=1601.0),
        replace(rest, features=(replace(rest.features[0], face="h"), *rest.features[1:])),
    )  # fmt: skip
    for one in wrong:
        assert {said.code for said in rest_faults(HEADER, one, missing)} == {"verify-rest"}


# --- the machines ---------------------------------------------------------------------------------


def test_machines_that_make_the_ends_refuse_it() -> None:
    rest = rest_after(sawn(HEADER))
    for name in ("beamline", "beamline-annex", "plate-linuxcnc"):
        with pytest.raises(PlanError) as refused:
            post((rest,), load(name))
        assert [d.code for d in errors_in(refused.value.diagnostics)] == ["plan-begun"]
    assert {rule.code for rule in rules_of(begun_rules)} == {"plan-begun"}


def test_only_what_is_left_is_cut_and_nothing_is_parted() -> None:
    plan = plan_coping((rest_after(sawn(HEADER)),), COPER)
    assert [(c.kind, c.face) for c in plan.operations] == [
        ("inner", "v"), ("near", "o"), ("near", "v"), ("far", "v"), ("far", "o"),
    ]  # fmt: skip
    assert plan.bar == 1600.0
    assert "plan-coping-piece" in {d.code for d in plan.remarks}


def test_the_program_says_how_the_piece_lies() -> None:
    text = program_of(rest_after(sawn(HEADER)))
    assert "(COMES CUT: ITS X 0 END AT X 30, FACE V UP, FACE U AT Y 0)" in text


def test_ends_of_walls_worked_by_hand() -> None:
    """A web cut of 30 degrees at the start, a flange cut of 20 at the end of an IPE300 of 600 mm:
    x = 300 tan 30 - y tan 30, and x = 600 - z tan 20. The flange u is 10.7 thick, o begins at
    289.3; the web stands from z 71.45 to 78.55."""
    part = begun(cuts=EndCuts(web_start=30.0, flange_end=20.0))
    near, far = ends_on("v", part)
    assert near == EndLine(pytest.approx(173.2051), pytest.approx(-0.57735), 0.0)
    assert far.x(0.0) == far.x(300.0) == pytest.approx(600.0 - 71.45 * 0.36397, abs=1e-3)
    near, far = ends_on("u", part)
    assert near.x(0.0) == near.x(150.0) == pytest.approx(173.2051 - 10.7 * 0.57735, abs=1e-3)
    assert (far.at, far.slope) == (pytest.approx(600.0), pytest.approx(-0.36397, abs=1e-5))
    near, _ = ends_on("o", part)
    assert near.at == pytest.approx(0.0, abs=1e-9)
    assert near.play == pytest.approx(10.7 * 0.57735, abs=1e-3)


@given(st.floats(-40.0, 40.0), st.floats(-40.0, 40.0), st.floats(-40.0, 40.0))
@settings(max_examples=examples(50))
def test_planner_and_read_back_see_the_same_ends(web: float, flange: float, third: float) -> None:
    part = begun(cuts=EndCuts(web, third, flange, -flange))
    assert COPER.coper is not None
    stock = stock_of(part, CoperSection(IPE300), COPER.coper)
    for face in ("v", "o", "u"):
        for mine, other in zip(ends_on(face, part), stock.ends[face], strict=True):
            assert mine.x(0.0) == pytest.approx(other.x(0.0), abs=1e-6)
            assert mine.x(1.0) == pytest.approx(other.x(1.0), abs=1e-6)
            assert mine.play == pytest.approx(other.apart, abs=1e-6)


def test_a_cope_at_a_mitred_piece() -> None:
    flange = [(0.0, 0.0), (520.0, 0.0), (520.0, 150.0), (0.0, 150.0)]
    part = begun(
        outline("v", MITRED), outline("o", flange), cuts=EndCuts(web_start=30.0)
    )  # fmt: skip
    plan = plan_coping((part,), COPER)
    assert [(c.kind, c.face) for c in plan.operations] == [("far", "v"), ("far", "o")]
    program_of(part)


def test_a_cope_that_is_missing_or_too_deep_is_found() -> None:
    part = begun(outline("v", COPE), outline("o", [(0, 0), (520, 0), (520, 150), (0, 150)]))
    text = program_of(part)
    whole = replace(part, features=())
    deeper = begun(
        outline("v", [(x, 230.0 if y == 240.0 else y) for x, y in COPE]), part.features[1]
    )  # fmt: skip

    def codes(of: Part) -> set[str]:
        return {d.code for d in errors_in(verify_coping(text, (of,), COPER, (), "JOB"))}

    assert not codes(part)
    assert "verify-coping-hurt" in codes(whole)
    assert "verify-coping-left" in codes(deeper)
    assert codes(replace(part, made=None))  # from a bar there would be ends to cut
    assert codes(replace(part, cuts=EndCuts(web_end=-20.0)))


def test_a_piece_that_is_too_short_for_its_outline_is_found() -> None:
    """The file that the program is held against asks for more steel than came."""
    flange = outline("o", [(0, 0), (520, 0), (520, 150), (0, 150)])
    text = program_of(begun(outline("v", COPE), flange))
    longer = begun(outline("v", [(x + 4.0 * (x > 520.0), y) for x, y in COPE]), flange)
    said = errors_in(verify_coping(text, (longer,), COPER, (), "JOB"))
    assert ("verify-coping-short", "4.00") in {(d.code, d["found"]) for d in said if "found" in
                                               dict(d.values)}  # fmt: skip


def test_a_piece_without_work_for_the_torch_is_refused() -> None:
    with pytest.raises(PlanError) as refused:
        post((begun(),), COPER)
    assert [d.code for d in refused.value.diagnostics] == ["plan-no-work"]


WINDOW = outline("v", [(250.0, 100.0), (350.0, 100.0), (350.0, 200.0), (250.0, 200.0)], "inner")


def codes_after(program_part: Part, part: Part) -> set[str]:
    """What the read-back says of the program of one part, held against another."""
    said = verify_coping(program_of(program_part), (part,), COPER, (), "JOB")
    return {one.code for one in errors_in(said)}


def test_no_arc_starts_over_a_hole_that_is_there() -> None:
    plain = begun(WINDOW)
    x, y = plan_coping((plain,), COPER).operations[0].path[0]
    part = replace(plain, made=(Hole("v", x, y, 14.0, AT),))
    assert codes_after(plain, part) == {"verify-coping-air"}
    (cut,) = plan_coping((part,), COPER).operations
    assert dist(cut.path[0], (x, y)) > 14.0 / 2
    program_of(part)
    # The other side of the web, and a hole that does not go through, leave the place as it is.
    assert codes_after(plain, replace(plain, made=(Hole("h", x, y, 14.0, AT),)))
    for there in (Hole("o", x, y, 14.0, AT), Hole("v", x, y, 14.0, AT, 3.0, "blind")):
        assert not codes_after(plain, replace(plain, made=(there,)))


def test_holes_that_are_there_lie_as_a_tee_does() -> None:
    """Its stem, seen from u, is its web under the torch; a hole through it is the same from o."""
    tee = Profile("T", "1/2 IPE300", 150.0, 120.0, 7.1, 10.7, 15.0)
    window = [(250.0, 60.0), (350.0, 60.0), (350.0, 100.0), (250.0, 100.0)]
    plain = replace(part_of(outline("u", window, "inner"), profile=tee), made=())
    x, across = plan_coping((plain,), COPER).operations[0].path[0]
    found = set()
    for face in ("u", "o"):
        for y in (across, 120.0 - across):
            part = replace(plain, made=(Hole(face, x, y, 14.0, AT),))  # type: ignore[arg-type]
            if codes_after(plain, part):
                assert codes_after(plain, part) == {"verify-coping-air"}
                program_of(part)
                found.add((face, y))
    assert {face for face, _ in found} == {"u", "o"}
    assert len({y for _, y in found}) == 1


@pytest.mark.parametrize("there", [
    Hole("v", 250.0, 150.0, 20.0, AT), Slot("v", 300.0, 100.0, 20.0, 30.0, 0.0, 0.0, AT),
    outline("v", [(340.0, 140.0), (360.0, 140.0), (360.0, 160.0), (340.0, 160.0)], "inner"),
])  # fmt: skip
def test_a_hole_that_is_there_across_a_cut_is_told(there: Any) -> None:
    plain = begun(WINDOW)
    part = replace(plain, made=(there,))
    told = {one.code: one for one in plan_coping((part,), COPER).remarks}
    assert told["plan-coping-open"].severity is Severity.WARNING
    assert not codes_after(part, part)
    beside = replace(plain, made=(Hole("v", 300.0, 150.0, 20.0, AT),))
    assert "plan-coping-open" not in {one.code for one in plan_coping((beside,), COPER).remarks}


@given(st.lists(st.tuples(st.floats(0.0, 600.0), st.floats(0.0, 300.0), st.floats(3.0, 40.0)),
                max_size=4), st.sampled_from("vou"))  # fmt: skip
@settings(max_examples=examples(60))
def test_what_is_planned_beside_holes_is_read_back(
    holes: list[tuple[float, float, float]], face: str
) -> None:
    there = tuple(Hole(face, x, y, wide, AT) for x, y, wide in holes)  # type: ignore[arg-type]
    flange = outline("o", [(0, 0), (520, 0), (520, 150), (0, 150)])
    part = replace(begun(outline("v", COPE), flange, WINDOW), made=there)
    try:
        plan = post((part,), COPER).plan
    except PlanError:
        return
    starts = [cut.path[0] for cut in plan.operations if cut.face == face]  # type: ignore[union-attr]
    assert all(dist(start, (x, y)) >= wide / 2 for start in starts for x, y, wide in holes)


@pytest.mark.parametrize("web_deg", [20.0, -20.0])
def test_a_cut_may_begin_on_a_skew_end(web_deg: float) -> None:
    """Where x of the end and of the path differ by rounding alone."""
    angle = Profile("L", "L120*150", 120.0, 150.0, 10.0, 8.0, 10.0)
    slope = tan(radians(web_deg))
    low, high = (600.0, 600.0 - 70.0 * slope) if slope > 0 else (
        600.0 + 120.0 * slope, 600.0 + 50.0 * slope)  # fmt: skip
    cope = [(0.0, 0.0), (low, 0.0), (high, 70.0), (480.0, 70.0), (480.0, 120.0), (0.0, 120.0)]
    piece = replace(
        part_of(outline("v", cope), profile=angle), cuts=EndCuts(web_end=web_deg), made=()
    )
    assert len(plan_coping((piece,), COPER).operations) == 1


# --- both together --------------------------------------------------------------------------------


def after_the_saw(posted: Posted, part: Part) -> Any:
    """The piece as the saw line's program leaves it, its x 0 at 0."""
    events, said = cell_events(posted.text, SAW, "JOB")
    assert not errors_in(said)
    found = bar_pieces(work_of(events, SAW, part), part, SAW)
    piece = max(found, key=lambda one: one.volume() * (one.bounding_box()[3] < 5000.0))
    return piece.translate((-piece.bounding_box()[0], 0.0, 0.0))


@needs_rs274
@pytest.mark.parametrize("name", sampled(["coped", "header", "trimmer", "hanger"], 4))
def test_the_part_falls_out_of_what_both_programs_cut(name: str, tmp_path: Path) -> None:
    """The kernel machines the bar by the saw line's events, then cuts by what rs274 prints."""
    part = sample(name)
    posted = sawn(part)
    path = tmp_path / "second.ngc"
    path.write_text(program_of(rest_after(posted)))
    strokes, sawed = burns(path), after_the_saw(posted, part)
    compare(part, pieces(part, strokes, sawed)[0])
    with pytest.raises(AssertionError):  # a cope that is missing is seen
        compare(part, pieces(part, strokes[:-1], sawed)[0])


@needs_rs274
def test_a_tee_with_skew_ends_falls_out_of_what_both_programs_cut(tmp_path: Path) -> None:
    """Its stem is coped at a mitred end, whose plane is skew to the flange too."""
    tee = Profile("T", "1/2 IPE300", 150.0, 120.0, 7.1, 10.7, 15.0)
    cuts = EndCuts(web_start=-12.0, flange_end=20.0)
    # The near end is at x = y tan 12, the stem at y 75; the far end at x = 600 - z tan 20.
    near, far = 75.0 * tan(radians(12.0)), 600.0 - 70.0 * tan(radians(20.0))
    stem = [
        (near, 0.0), (600.0, 0.0), (far, 70.0), (480.0, 70.0), (480.0, 120.0), (near, 120.0)
    ]  # fmt: skip
    window = [(200.0, 50.0), (260.0, 50.0), (260.0, 90.0), (200.0, 90.0)]
    part = part_of(outline("u", stem), outline("o", window, "inner"), profile=tee)
    part = replace(part, cuts=cuts)
    posted = sawn(part)
    path = tmp_path / "second.ngc"
    path.write_text(program_of(rest_after(posted)))
    compare(part, pieces(part, burns(path), after_the_saw(posted, part))[0])


@given(st.integers(0, 3000), st.sampled_from([random_cope, random_tee]))
@settings(max_examples=examples(25))
def test_what_a_saw_leaves_of_a_random_part_is_made_by_the_torch(
    seed: int, random_part: Callable[[int], Part]
) -> None:
    part = random_part(seed)
    try:
        posted = post((part,), SAW, skips=("all",))
        plan_coping((part,), COPER)
    except PlanError:
        return
    rest = rest_of_part(posted, TARGETS[0])
    if rest is None:
        return
    with suppress(PlanError):  # a program that is planned is read back
        post((rest[0],), COPER)


def test_a_chain_makes_every_feature_once() -> None:
    request = Request((HEADER,), SAW)
    chain = chain_of(request, (SAW, COPER))
    assert [(s.machine.name, s.skips) for s in chain] == [
        ("beamline-pusher", LEFT), ("coper-linuxcnc", ()),
    ]  # fmt: skip
    stages = split_part(request, (SAW, COPER))
    made = [sum(o.how == "made" for o in s.posted.plan.outcomes) for s in stages]
    assert made == [11, 3]
    assert stages[0].posted.job.parts[0].features[10:13] == HEADER.features[10:13]
    again = read_back(stages[1].posted.text, stages[1].posted.job.request)
    assert not errors_in(again)


def test_a_part_that_one_machine_makes_is_not_split() -> None:
    stages = split_part(Request((sample("coped"),), SAW), (SAW, COPER))
    assert [(s.posted.job.machine.name, s.rest) for s in stages] == [("coper-linuxcnc", "")]


def test_the_first_that_leaves_nothing_ends_the_search_unless_time_is_asked_for() -> None:
    (tie,) = read_file(str(SAMPLES / "dstv" / "tie.nc1")).parts
    line = load("beamline")

    def loaded(name: str) -> Machine:
        assert name == SAW.name, "a machine behind it is looked at"
        return SAW

    (link,) = chain_of(Request((tie,), SAW), InTurn((SAW.name, line.name), loaded))
    assert link.machine is SAW
    (link,) = chain_of(Request((tie,), SAW, by="time"), (SAW, line))
    assert link.machine is line
    # The pusher scribes the text: what is left goes before time.
    first, second = chain_of(Request((HEADER,), SAW, by="time"), (line, COPER, SAW))
    assert (first.machine, second.machine) == (SAW, COPER)


def test_what_no_chain_makes_is_refused() -> None:
    part = replace(HEADER, features=(*HEADER.features, Hole("v", 300.0, 150.0, 3.0, AT)))
    with pytest.raises(PlanError) as refused:
        split_part(Request((part,), SAW), (SAW, COPER))
    assert "plan-no-machine" in {d.code for d in refused.value.diagnostics}
    stages = split_part(Request((part,), SAW, ("tool",)), (SAW, COPER))
    left = [o.by for o in stages[0].posted.plan.outcomes if o.how == "skipped"]
    assert (len(stages), left) == (1, ["plan-tool"] * 7)


# --- the commands ---------------------------------------------------------------------------------


def test_post_writes_the_rest(tmp_path: Path) -> None:
    path, rest = SAMPLES / "coping" / "header.nc1", tmp_path / "rest.nc1"
    words = ("post", path, "--machine", "beamline", "-o", tmp_path / "a.gcode", "--rest", rest)
    done = call(*words, "--allow-skips", "cope,cutout")
    assert done.exit_code == 0
    assert rest.read_text() == (SAMPLES / "coping" / "header-rest.nc1").read_text()
    assert "note plan-rest: the rest of the part, 4 feature(s)" in done.stderr
    assert (
        call("post", rest, "-o", tmp_path / "b.ngc", "--machine", "coper-linuxcnc").exit_code == 0
    )
    checked = call("verify", tmp_path / "b.ngc", "--against", rest)
    assert checked.exit_code == 0
    coped = SAMPLES / "coping" / "coped.nc1"
    none = tmp_path / "none.nc1"
    done = call("post", coped, "--machine", "coper-linuxcnc", "-o", tmp_path / "c.ngc",
                "--rest", none)  # fmt: skip
    assert "plan-no-rest" in done.stderr
    assert not none.exists()
    assert {rule.code for rule in rules_of(rest_part)} == {
        "plan-rest",
        "plan-no-rest",
        "plan-split",
    }


def test_a_rest_is_shown_as_one() -> None:
    path = SAMPLES / "coping" / "header-rest.nc1"
    assert (
        "  made      its ends and 10 feature(s), by another machine" in call("inspect", path).stdout
    )
    planned = call("plan", path, "--machine", "coper-linuxcnc")
    assert "1600.000 mm, cut to length by another machine, its x 0 at X 30.000" in planned.stdout


def test_the_program_of_a_piece_is_drawn_though_a_face_has_no_cut(tmp_path: Path) -> None:
    path, program = SAMPLES / "coping" / "header-rest.nc1", tmp_path / "a.ngc"
    program.write_text(program_of(rest_after(sawn(HEADER))))
    assert call("plot", program, "-o", tmp_path / "a.svg").exit_code == 0
    page = call("report", program, "--against", path, "-o", tmp_path / "a.html")
    assert page.exit_code == 0, page.stderr


@pytest.mark.parametrize("words", [
    ("--rest", "rest.dxf"), ("--rest", "rest.nc1", "--turn"),
])  # fmt: skip
def test_where_no_rest_can_be_written(words: tuple[str, ...], tmp_path: Path) -> None:
    path = SAMPLES / "coping" / "header.nc1"
    done = call("post", path, "-o", tmp_path / "a.gcode", "--allow-skips", "cope,cutout", *words)
    assert done.exit_code in (1, 2)
    assert not (tmp_path / "a.gcode").exists()


def test_split_writes_all_or_nothing(tmp_path: Path) -> None:
    path, out = SAMPLES / "coping" / "header.nc1", tmp_path / "out"
    words = ("split", path, "--machines", "beamline,coper-linuxcnc", "-o", out)
    assert call(*words).exit_code == 0
    names = [
        "C6-1-beamline.gcode", "C6-1-rest.nc1", "C6-2-coper-linuxcnc.ngc",
        "C6-2-coper-linuxcnc.ngc.hand.csv",
    ]  # fmt: skip
    assert sorted(p.name for p in out.iterdir()) == names
    before = [p.read_bytes() for p in sorted(out.iterdir())]
    assert call(*words).exit_code == 0
    assert [p.read_bytes() for p in sorted(out.iterdir())] == before
    bad = SAMPLES / "bad" / "section-too-large.nc1"
    done = call("split", path, bad, "--machines", "beamline,coper-linuxcnc", "-o", tmp_path / "no")
    assert done.exit_code == 1
    assert not (tmp_path / "no").exists()
    assert call("split", path, "--machines", "nothing", "-o", out).exit_code != 0


def test_the_rest_from_python() -> None:
    posted = api.post(HEADER, "beamline", skips=LEFT)
    text = api.rest(posted)
    assert text is not None
    assert text.count("**BEAMCAM MADE ENDS") == 1
    assert api.rest(api.post(sample("coped"), "coper-linuxcnc")) is None
    with pytest.raises(AskError):
        api.rest(posted, "faces-dxf")
    with pytest.raises(BeamcamError):
        api.rest(api.post(HEADER, "beamline", skips=LEFT, turn=True))


def test_every_contour_of_the_header_is_left_by_the_saw() -> None:
    left = [f for f in rest_after(sawn(HEADER)).features if isinstance(f, Contour)]
    assert len(left) == 3
    assert job_of(HEADER).parts == (HEADER,)


def test_comments_of_what_is_made_hold_no_others() -> None:
    """In the header, or one in the other: such a line says nothing."""
    lines = (SAMPLES / "coping" / "header-rest.nc1").read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith(MADE))
    nested = [*lines[:4], MADE + "BO", *lines[4:at], MADE + lines[at], *lines[at:]]
    before, after = (read("\n".join(some).encode(), "a.nc1") for some in (lines, nested))
    assert [len(p.made or ()) for p in before.parts] == [len(p.made or ()) for p in after.parts]
