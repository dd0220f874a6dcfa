"""C sections with lips, which lie on them below a torch; each lip is cut at its edge."""

import json
import random
from functools import partial
from math import radians, tan
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely.affinity import scale, translate

import beamcam
from beamcam.checks.coping.section import CoperSection
from beamcam.cli import main
from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_section
from beamcam.model.part import Bevel, Contour, EndCuts, Hole, Part, Profile
from beamcam.model.part_json import part_to_json
from beamcam.model.plan import CopeCut
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.coping.walls import laid
from beamcam.planning.manual_list import manual_rows
from beamcam.recovery.copers import recover_coped
from beamcam.recovery.recovered import KnownStock
from beamcam.solid.kernel import outline as outline_of
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults
from tests.conftest import SAMPLES, examples
from tests.random_copes import CEES, random_lipped, random_mitre, random_slant
from tests.unit.coping.samples import AT, COPER, job_of, outline, part_of, program_of, sample
from tests.unit.coping.test_read_back import found

TILT = load("coper-tilt-linuxcnc")
JOIST = sample("joist")
C200 = Profile("C", "C200*75*20*2.5", 200.0, 75.0, 2.5, 2.5, 3.5, 20.0)
BARE = replace(C200, name="C200", lip=None)
HOLE = Hole("v", 300.0, 100.0, 14.0, AT)
mitred = partial(random_mitre, sections=CEES)


def cee(*features: Hole | Contour, profile: Profile = C200, length: float = 600.0) -> Part:
    return part_of(*features, profile=profile, length=length)


def at_lips(part: Part, machine: Machine = COPER) -> list[CopeCut]:
    return [cut for cut in plan_coping((part,), machine).operations if cut.lip]


def refused(part: Part, machine: Machine = COPER) -> set[str]:
    with pytest.raises(PlanError) as caught:
        plan_coping((part,), machine)
    return {d.code for d in caught.value.diagnostics}


def test_it_lies_on_its_lips_with_its_web_up() -> None:
    """Turned 180 degrees about its length: y is 200 - y and z is 75 - z of the file."""
    lying = laid(cee(Hole("v", 100.0, 30.0, 14.0, AT), Hole("o", 200.0, 20.0, 14.0, AT)))
    places = [(f.face, f.x, f.y) for f in lying.features if isinstance(f, Hole)]
    assert places == [("h", 100.0, 170.0), ("u", 200.0, 55.0)]
    plan = plan_coping((cee(HOLE),), COPER)
    assert [d.code for d in plan.remarks] == ["plan-coping-bar", "plan-coping-lips"]
    lines = program_of(cee(HOLE)).splitlines()
    assert "(THE C LIES ON ITS LIPS: FACE O AT Y 0, FACE H UP)" in lines
    # The torch over the web cuts at 75 + 3 and pierces at 75 + 6.
    first = next(k for k, line in enumerate(lines) if line.startswith("M3"))
    assert lines[first - 1].endswith("Z81")
    assert lines[first + 3].endswith("Z78")


def test_a_lip_is_cut_at_its_edge_as_deep_as_it_is_long() -> None:
    """20 + 1 mm by the row up to 22, whose kerf is 3; the flange by that up to 10, with 2.5 + 3.5 +
    1 mm, whose kerf is 2.2. Bend and lip go to z 6; the cuts meet there, and lap 1 mm."""
    cuts = plan_coping((cee(),), COPER).operations
    ends = [cut for cut in cuts if cut.face == "o" and cut.kind == "far"]
    by_lip = {cut.lip: cut for cut in ends}
    lip, flange = by_lip[True], by_lip[False]
    assert (lip.thickness, lip.row.up_to, lip.root) == (21.0, 22.0, False)
    assert (flange.thickness, flange.row.up_to, flange.root) == (7.0, 10.0, True)
    assert {round(x - 600.0, 6) for x, _ in lip.path[1:]} == {1.5}
    assert {round(x - 600.0, 6) for x, _ in flange.path[1:]} == {1.1}
    # Both begin over the flange, beside the cut, and end beyond its round edges.
    assert (lip.path[0][1], lip.path[1][1], round(lip.path[-1][1], 2)) == (7.0, 7.0, -3.47)
    assert (flange.path[0][1], round(flange.path[-1][1], 3)) == (6.0, 78.078)


def test_the_web_is_cut_below_its_bends_and_under_the_lips() -> None:
    """A slot whose edge is 11 mm off the flange lies under a lip of 20 mm, and is cut."""
    assert not found(program_of(JOIST), JOIST)
    web = [cut for cut in plan_coping((JOIST,), COPER).operations if cut.face == "v"]
    ys = [y for cut in web for _, y in cut.path[1:]]
    assert (min(ys), max(ys)) == (6.0, 194.0)
    assert max(y for cut in web if cut.kind == "inner" for _, y in cut.path) == 188.0


def test_a_section_is_a_bent_sheet() -> None:
    for profile in CEES:
        drawn = outline_of(cee(profile=profile))
        turned = translate(scale(drawn, -1, -1, origin=(0, 0)), profile.height, profile.width)
        assert CoperSection(profile).steel.symmetric_difference(turned).area < 1.0


@pytest.mark.parametrize(
    ("name", "features"),
    [
        ("a hole over a lip", [Hole("u", 300.0, 66.0, 14.0, AT)]),
        ("an edge along the lip", [
            outline("u", [(0.0, 0.0), (600.0, 0.0), (600.0, 73.5), (0.0, 73.5)])]),
        ("a notch that ends in the bend", [outline("u", [
            (0.0, 0.0), (600.0, 0.0), (600.0, 75.0), (400.0, 75.0), (400.0, 70.0), (300.0, 70.0),
            (300.0, 75.0), (0.0, 75.0)])]),
        ("a chamfer along the lip", [outline("u", [
            (0.0, 0.0), (600.0, 0.0), (600.0, 62.0), (500.0, 75.0), (0.0, 75.0)])]),
    ],
)  # fmt: skip
def test_what_does_not_go_through_a_lip_is_refused(
    name: str, features: list[Hole | Contour]
) -> None:
    assert refused(cee(*features)) == {"plan-coping-into-lip"}, name


def test_a_section_that_is_no_bent_sheet_is_refused() -> None:
    assert refused(cee(profile=replace(C200, web_thickness=3.0))) == {"plan-section-shape"}
    assert refused(cee(profile=replace(C200, lip=4.0))) == {"plan-coping-lip"}
    assert refused(cee(profile=replace(C200, lip=100.0))) == {"plan-coping-lip"}


def test_a_lip_may_be_cut_off_all_along() -> None:
    part = cee(outline("u", [(0.0, 0.0), (600.0, 0.0), (600.0, 50.0), (0.0, 50.0)]))
    assert {cut.face for cut in at_lips(part)} == {"u"}  # u of the file lies at o
    assert not found(program_of(part), part)


def test_lips_that_are_not_known_are_refused_or_those_of_the_job() -> None:
    bare = cee(HOLE, profile=BARE)
    assert refused(bare) == {"plan-coping-lip"}
    machine = with_section(COPER, None, 20.0)
    plan = plan_coping((bare,), machine)
    assert plan.operations == plan_coping((cee(HOLE),), COPER).operations
    assert plan.remarks[0].code == "plan-coping-given-lip"
    assert "taken as 20 mm" in plan.remarks[0].message
    text = program_of(bare, machine)
    assert {d.code for d in found(text, bare)} == {"verify-coping-lip"}
    # 42 mm need another row than 20 mm.
    assert {d.code for d in found(text, bare, with_section(COPER, None, 42.0))} == {
        "verify-coping-feed"
    }
    # The part's own length goes before that of the machine.
    longer = with_section(COPER, None, 42.0)
    assert plan_coping((cee(HOLE),), longer).operations == plan.operations
    assert refused(bare, with_section(COPER, None, 120.0)) == {"plan-coping-lip"}
    tube = load("tube-surface")
    assert with_section(tube, None, 20.0) is tube


def test_the_option_and_the_configuration(tmp_path: Path) -> None:
    part, program = tmp_path / "c.nc1", tmp_path / "c.ngc"
    text = (SAMPLES / "coping" / "joist.nc1").read_text()
    part.write_text(text.replace("C200*75*20*2.5", "C20025"))

    def run(*words: object) -> tuple[int, str]:
        done = CliRunner().invoke(main, [str(word) for word in words])
        return done.exit_code, done.stderr

    post = ("post", part, "--machine", "coper-linuxcnc", "-o", program)
    assert "plan-coping-lip" in run(*post)[1]
    code, said = run(*post, "--lip", "20")
    assert (code, "plan-coping-given-lip" in said) == (0, True)
    assert run("verify", program, "--against", part, "--lip", "20", "--solid")[0] == 0
    assert "verify-coping-lip" in run("verify", program, "--against", part)[1]
    (tmp_path / "beamcam.toml").write_text("lip = 20\n")
    assert run("verify", program, "--against", part, "--config", tmp_path / "beamcam.toml")[0] == 0
    machine = beamcam.load("coper-linuxcnc", lip=20)
    assert beamcam.post(beamcam.read(part).parts, machine).text == program.read_text()


def test_bevels_of_a_flange_with_a_lip_are_manual_work() -> None:
    """A second pass would go on into the lip behind the flange."""
    flange = outline("u", [(0.0, 0.0), (600.0, 0.0), (600.0, 75.0), (0.0, 75.0)])
    part = cee(replace(flange, bevels=(Bevel(1, 30.0, 0.5),)))
    plan = plan_coping((part,), TILT)
    assert not any(cut.bevel for cut in plan.operations)
    assert len(list(manual_rows(plan))) == 1
    assert not found(program_of(part, TILT), part, TILT)


def test_the_json_form_has_them_where_they_are_known() -> None:
    form = part_to_json(JOIST)
    assert form["profile"]["lip"] == 20.0
    (part,) = beamcam.read(json.dumps(form).encode(), name="joist.json").parts
    assert part.profile == JOIST.profile
    older = {**form, "profile": {k: v for k, v in form["profile"].items() if k != "lip"}}
    (part,) = beamcam.read(json.dumps(older).encode(), name="joist.json").parts
    assert part.profile == replace(JOIST.profile, lip=None)
    assert "lip" not in part_to_json(part)["profile"]


def test_the_part_comes_back() -> None:
    got = recover_coped(program_of(JOIST), COPER, "p.ngc", KnownStock(JOIST.profile))
    (part,) = got.parts
    assert part.profile == JOIST.profile
    assert {(h.face, h.x, h.y, h.diameter) for h in part.holes} == {
        (h.face, h.x, h.y, h.diameter) for h in JOIST.holes
    }
    assert not found(program_of(JOIST), part)


# --- random parts, wrong programs -----------------------------------------------------------------


@given(st.integers(0, 5000), st.sampled_from(["cope", "mitre", "square", "slant"]))
@settings(max_examples=examples(60))
def test_no_random_part_that_is_planned_is_refused(seed: int, kind: str) -> None:
    machine = TILT if kind == "mitre" else COPER
    makes = {"cope": random_lipped, "slant": partial(random_slant, sections=CEES)}
    part = makes.get(kind, mitred)(seed)
    try:
        plan = plan_coping((part,), machine)
    except PlanError:
        return
    assert not found(coping_faults.program_of(plan, job_of(part, machine)), part, machine)


def test_most_random_parts_are_planned() -> None:
    def is_planned(part: Part) -> bool:
        try:
            return bool(plan_coping((part,), TILT).operations)
        except PlanError:
            return False

    assert sum(is_planned(random_lipped(seed)) for seed in range(12)) >= 10
    assert sum(is_planned(mitred(seed)) for seed in range(12)) >= 10


def wrong(part: Part, machine: Machine) -> dict[str, str]:
    return dict(coping_faults.faults(part, machine, random.Random(4)))


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_wrong_programs_are_refused(every: int) -> None:
    for kind, text in [*wrong(JOIST, COPER).items()][::every]:
        assert found(text, JOIST), kind


def codes(said: tuple[Diagnostic, ...]) -> set[str]:
    return {d.code for d in errors_in(said)}


def test_a_lip_as_deep_as_a_row_is_cut_by_that_row() -> None:
    """15 and 1 mm are cut by the row up to 16, and not by the next one, up to 20."""
    part = cee(profile=CEES[2])
    plan = plan_coping((part,), COPER)
    k = next(k for k, cut in enumerate(plan.operations) if cut.lip)
    cut = plan.operations[k]
    assert (cut.thickness, cut.row.up_to) == (16.0, 16.0)
    assert COPER.coper is not None
    deeper = next(row for row in COPER.coper.rows if row.up_to == 20.0)
    operations = (*plan.operations[:k], replace(cut, row=deeper), *plan.operations[k + 1 :])
    text = coping_faults.program_of(replace(plan, operations=operations), job_of(part))
    assert {d.code for d in found(text, part)} == {"verify-coping-feed"}


def test_a_lip_that_holds_is_told() -> None:
    programs = wrong(JOIST, COPER)
    for kind in ("lip left out", "lip too shallow", "shorter lips"):
        assert "verify-coping-feed" in codes(found(programs[kind], JOIST)), kind
    assert "verify-coping-place" in codes(found(programs["along the lip"], JOIST))


def test_the_torch_lies_in_the_plane_of_an_end_all_along_a_lip() -> None:
    """3 degrees are 0.13 mm in a flange of 2.5 mm, and 1 mm over a lip of 20 mm."""
    part = replace(cee(length=1200.0), cuts=EndCuts(web_end=20.0))
    plan = plan_coping((part,), TILT)
    assert not found(coping_faults.program_of(plan, job_of(part, TILT)), part, TILT)
    for by, code in ((3.0, "verify-coping-hurt"), (-3.0, "verify-coping-left")):
        cuts = tuple(
            replace(cut, b_deg=cut.b_deg + by) if cut.lip and cut.face == "u" and cut.b_deg else cut
            for cut in plan.operations
        )
        assert cuts != plan.operations
        text = coping_faults.program_of(replace(plan, operations=cuts), job_of(part, TILT))
        assert code in codes(found(text, part, TILT))


def test_a_flange_that_is_cut_square_at_a_skew_end_is_as_long_as_its_lip() -> None:
    """One lip leans back behind its flange; the other reaches as far as the plane does at 20 mm.

    Over the root its flange goes as far as that does at 10 mm, as deep as the pass there cuts.
    """
    part = replace(cee(length=1200.0), cuts=EndCuts(web_end=30.0))
    plan = plan_coping((part,), COPER)
    assert "plan-coping-slant" in {d.code for d in plan.remarks}
    text = coping_faults.program_of(plan, job_of(part))
    assert not found(text, part)
    far = {(cut.face, cut.lip): cut.path[-1][0] for cut in plan.operations if cut.kind == "far"}
    ahead = [far[face, True] - 1.5 - (far[face, False] - 1.1) for face in "ou"]
    assert ahead[1] == pytest.approx((20.0 - 10.05) * tan(radians(30.0)), abs=0.01)
    assert -0.1 < ahead[0] <= 0.0


@pytest.mark.exhaustive
def test_the_solid_knows_how_far_in_a_lip_of_a_skew_end_may_be_cut() -> None:
    """Planner and read-back go by the sharp corner of the section, 10 mm by 10 mm outside of its
    round bend: a pass farther in by up to 10 (0.127 + 0.737 - 0.748) = 1.16 mm takes nothing."""
    part = mitred(106)
    plan = plan_coping((part,), COPER)
    ends = [k for k, cut in enumerate(plan.operations) if (cut.kind, cut.face) == ("far", "o")]
    (k,) = (k for k in ends if min(y for _, y in plan.operations[k].path) < 0.0)
    cut = plan.operations[k]
    codes = {}
    for off in (-1.0, -3.0, 1.0):
        other = replace(cut, path=tuple((x + off, y) for x, y in cut.path))
        wrong = replace(plan, operations=(*plan.operations[:k], other, *plan.operations[k + 1 :]))
        text = coping_faults.program_of(wrong, job_of(part, COPER))
        said = errors_in(solid_faults(text, Request((part,), COPER)))
        codes[off] = {d.code for d in said} - {"solid-size"}
        assert found(text, part)
    assert codes == {-1.0: set(), -3.0: {"solid-missing"}, 1.0: {"solid-extra"}}
