"""The read-back of a coper: sound programs pass, and each of its codes comes where it should."""

import random
import re
from collections.abc import Callable
from itertools import pairwise
from math import cos, dist, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely import MultiPolygon, box

from beamcam.checks.coping import verify_coping
from beamcam.checks.coping.left import WallPieces, holding_faults
from beamcam.checks.coping.rules import RULES
from beamcam.checks.coping.section import CoperSection
from beamcam.errors import Diagnostic, PlanError
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.machine import Machine
from beamcam.model.part import Contour, Hole, Part, Profile, TextMark
from beamcam.planning.coping.plan import plan_coping
from benchmarks import coping_faults, coping_plans
from tests.conftest import examples
from tests.random_copes import random_cope, random_tee
from tests.unit.coping.samples import (
    AT,
    COPER,
    IPE300,
    NAMES,
    faults,
    job_of,
    outline,
    part_of,
    program_of,
    sample,
    with_keys,
)

COPED = sample("coped")
PROGRAM = program_of(COPED)


def found(text: str, part: Part = COPED, machine: Machine = COPER) -> tuple[Diagnostic, ...]:
    return faults(text, part, machine)


@given(st.integers(0, 5000), st.sampled_from([random_cope, random_tee]))
@settings(max_examples=examples(60))
def test_no_random_part_that_is_planned_is_refused(
    seed: int, random_part: Callable[[int], Part]
) -> None:
    part = random_part(seed)
    try:
        plan = plan_coping((part,), COPER)
    except PlanError:
        return
    assert not found(coping_faults.program_of(plan, job_of(part)), part)


@pytest.mark.parametrize("random_part", [random_cope, random_tee])
def test_most_random_parts_are_planned(random_part: Callable[[int], Part]) -> None:
    def is_planned(seed: int) -> bool:
        try:
            return bool(plan_coping((random_part(seed),), COPER).operations)
        except PlanError:
            return False

    assert sum(map(is_planned, range(20))) >= 18


def round_flange(*corner: Curve) -> Part:
    """An IPE300 whose upper flange, 150 wide, has a corner of its own from (600, 105) on."""
    last = corner[-1].end
    sides = [Line((0.0, 0.0), (600.0, 0.0)), Line((600.0, 0.0), (600.0, 105.0)), *corner,
             Line(last, (0.0, 150.0)), Line((0.0, 150.0), (0.0, 0.0))]  # fmt: skip
    return part_of(Contour("o", "outer", tuple(sides), AT))


def test_an_arc_that_runs_into_an_edge_is_not_flattened_by_it() -> None:
    """Within 1 mm of the edge, too, the cut is half a kerf off a corner of 45 about (555, 105)."""
    part = round_flange(Arc((555.0, 105.0), 45.0, 0.0, 90.0))
    (cut,) = [c for c in plan_coping((part,), COPER).operations if (c.kind, c.face) == ("far", "o")]
    near = [dist((555.0, 105.0), p) for p in cut.path if p[0] > 560.0 and 105.0 < p[1] < 149.95]
    assert len([p for p in cut.path if 149.0 < p[1] < 149.95 and p[0] > 560.0]) > 0
    assert near == pytest.approx([45.0 + cut.row.kerf / 2] * len(near), abs=0.03)
    program_of(part)  # passes
    ends = [k * pi / 30 for k in range(14)]  # to 78 degrees, 1 mm below the edge, then straight up
    chords = [(555.0 + 45.0 * cos(t), 105.0 + 45.0 * sin(t)) for t in ends]
    flat = [Line(a, b) for a, b in pairwise([*chords, (chords[-1][0], 150.0)])]
    assert found(program_of(round_flange(*flat)), part)


def test_a_side_beside_an_edge_is_that_edge() -> None:
    """Real outlines are up to 0.7 mm narrower than their header, and mean its width."""
    part = part_of(outline("o", [(0.0, 0.4), (600.0, 0.0), (600.0, 149.4), (0.0, 149.3)]))
    cuts = plan_coping((part,), COPER).operations
    assert {c.kind for c in cuts} == {"near", "far"}
    assert not found(program_of(part), part)


@pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize("name", NAMES)
def test_wrong_programs_are_refused(name: str, every: int) -> None:
    part, chance = sample(name), random.Random(5)
    for kind, text in [*coping_faults.faults(part, COPER, chance)][::every]:
        assert found(text, part), kind


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", [0, 4, 8])
def test_no_wrong_program_of_random_parts_is_taken(first: int) -> None:
    tried, taken, refused = coping_faults.survivors(4, first)
    assert tried.total() > 1500
    assert not taken
    assert not refused


def swapped(pattern: str, other: str, count: int = 1) -> str:
    """The program of the sample with something of its text replaced."""
    text, changed = re.subn(pattern, other, PROGRAM, count=count, flags=re.MULTILINE)
    assert changed
    return text


def without(kind: str, face: str) -> str:
    """The program of the sample without some cuts."""
    plan = plan_coping((COPED,), COPER)
    rest = [cut for cut in plan.operations if (cut.kind, cut.face) != (kind, face)]
    return coping_faults.program_of(replace(plan, operations=tuple(rest)), job_of(COPED))


def moved(kind: str, face: str, up: float, first: int, machine: Machine = COPER) -> str:
    """The program of the sample with the first places of some cuts at another y."""
    plan = plan_coping((COPED,), COPER)
    operations = [
        replace(cut, path=tuple((x, y + up * (k < first)) for k, (x, y) in enumerate(cut.path)))
        if (cut.kind, cut.face) == (kind, face)
        else cut
        for cut in plan.operations
    ]
    return coping_faults.program_of(
        replace(plan, operations=tuple(operations)), job_of(COPED, machine)
    )


SHS = Profile("M", "SHS100*6", 100.0, 100.0, 6.0, 6.0, 10.0)
THIN = outline("o", [(0.0, 60.0), (9.0, 60.0), (9.0, 60.05), (0.0, 60.05)])
SLIM = with_keys(play=0.0001, torch_width=0.1, head_width=0.1)  # that strikes nothing

WRONG = [
    ("verify-coping-section", PROGRAM, part_of(profile=SHS)),
    ("verify-coping-torch", swapped("^M5$", "M3 S1"), COPED),
    ("verify-coping-torch", swapped("^M5\n", "M7\nM5\n"), COPED),
    ("verify-coping-torch", swapped("^M3 S1", "G4 P99\nM3 S1"), COPED),
    ("verify-coping-torch", swapped("^(G1 .*\nG1 .*)", r"\1\nG4 P1"), COPED),
    ("verify-coping-torch", swapped("^M3 S1\n(G4.*)\n(F.*)\n(?:G1.*\n)+M5", "M3 S1\nM5"), COPED),
    ("verify-coping-torch", swapped("^G0 X", "G1 X"), COPED),
    ("verify-coping-torch", swapped("^G1 X", "G0 X"), COPED),
    ("verify-coping-torch", swapped("G64 P0.02", "G64"), COPED),
    ("verify-coping-torch", swapped("^M3 S1", "G41.1 D2\nM3 S1"), COPED),
    ("verify-coping-torch", swapped(r"^(G1 (X\S+ Y\S+) Z\S+)", r"\1\nG3 \2 I3 J0"), COPED),
    ("verify-coping-angle", swapped("^G1 X.*", r"\g<0> A-88"), COPED),
    ("verify-coping-angle", swapped("^G0 A-90", "G0 A-80"), COPED),
    ("verify-coping-height", PROGRAM.replace(" Y303", " Y304"), COPED),
    ("verify-coping-feed", swapped("^F2550", "F2600"), COPED),
    ("verify-coping-feed", swapped("^G4 P0.5\nF2550", "G4 P0.6\nF2200"), COPED),
    ("verify-coping-pierce", swapped("^G4 P0.5", "G4 P0.1"), COPED),
    ("verify-coping-air", moved("far", "o", 3.0, 1), COPED),
    ("verify-coping-strikes", swapped("^G0 X(.*) Y320 Z.*", r"G0 X\1 Y200 Z75"), COPED),
    ("verify-coping-limit", swapped(r"^G0 X\S+", "G0 X99999"), COPED),
    ("verify-coping-place", moved("near", "v", 22.0, 2, SLIM), COPED),
    ("verify-coping-hurt", PROGRAM, replace(COPED, features=COPED.features[:4])),
    ("verify-coping-left", without("near", "o"), COPED),
    ("verify-coping-gone", program_of(part_of()), part_of(THIN)),
    ("verify-coping-extra", PROGRAM, replace(COPED, features=COPED.features[:5])),
    ("verify-coping-order", None, COPED),
]  # fmt: skip


@pytest.mark.parametrize(("code", "text", "part"), WRONG)
def test_each_code_comes(code: str, text: str | None, part: Part) -> None:
    if text is None:
        plan = coping_plans.reordered(plan_coping((part,), COPER), random.Random(1))
        assert plan is not None
        text = coping_faults.program_of(plan, job_of(part))
    said = found(text, part, SLIM if "place" in code else COPER)
    assert code in {d.code for d in said}, [str(d) for d in said]


def test_two_parts_are_not_one_program() -> None:
    said = verify_coping(PROGRAM, (COPED, COPED), COPER, (), "JOB")
    assert [d.code for d in said] == ["verify-coping-parts"]


def test_scrap_that_a_flange_holds() -> None:
    whole = MultiPolygon([box(0.0, 0.0, 600.0, 150.0)])
    web = WallPieces(
        MultiPolygon([box(50.0, 10.7, 600.0, 289.3)]), MultiPolygon([box(0, 200, 40, 289.3)])
    )
    flange = WallPieces(whole, MultiPolygon())
    said = list(holding_faults("o", web, flange, CoperSection(IPE300), 75.0, 0.2, "JOB"))
    assert [d.code for d in said] == ["verify-coping-holds"]
    assert said[0]["found"] == "40.00"
    assert not list(holding_faults("u", web, flange, CoperSection(IPE300), 75.0, 0.2, "JOB"))


def test_a_cope_whose_round_ends_by_a_chord_of_its_step_is_not_hurt() -> None:
    """Offset inwards, the step at the root and the round that is 0.02 mm off it have slivers."""
    beam = Profile("I", "W12X30", 314.32, 165.1, 11.11, 6.35, 17.46)
    x, end, deep, r = 5371.31, 5453.86, 31.75, 12.7
    web = [(0.0, 0.0), (x, 0.0), (x, deep - r), (x + r, deep), (end, deep), (end, 314.32),
           (0.0, 314.32)]  # fmt: skip
    cope = outline("v", web)
    turn = Arc((x + r, deep - r), r, 180.0, -90.0)
    cope = replace(cope, curves=(*cope.curves[:2], turn, *cope.curves[3:]))
    flange = outline("u", [(0.0, 0.0), (x, 0.0), (x, 165.1), (0.0, 165.1)])
    assert program_of(part_of(cope, flange, profile=beam, length=end))


def test_every_rule_has_a_case() -> None:
    tested = {code for code, *_ in WRONG} | {"verify-coping-parts", "verify-coping-holds"}
    tested |= {"verify-coping-short", "verify-coping-zone"}  # in test_pieces.py, test_zones.py
    tested |= {"verify-coping-plane"}  # in property/test_end_planes.py
    tested |= {"verify-coping-tilt", "verify-coping-passes"}  # in test_skew.py, test_bevels.py
    tested |= {"verify-coping-measured"}  # in test_measured.py
    tested |= {"verify-coping-lip"}  # in test_lips.py
    of_boxes = ("square", "corner", "radius")  # in test_box_tubes.py
    tested |= {f"verify-coping-{name}" for name in of_boxes}
    assert {rule.code for rule in RULES} == tested


def test_what_is_not_made_is_told_as_it_is_allowed() -> None:
    part = part_of(Hole("v", 300.0, 100.0, 9.0, AT), TextMark("v", 9.0, 9.0, 0.0, 9.0, "A", AT))
    plan = plan_coping((part,), COPER, skips=("tool",))
    text = coping_faults.program_of(plan, job_of(part))
    said = verify_coping(text, (part,), COPER, ("tool",), "JOB")
    assert [d.code for d in said] == ["verify-by-hand", "verify-left-out"]
    missing = verify_coping(text, (part,), COPER, (), "JOB")
    assert "verify-coping-left" in {d.code for d in missing}


def test_a_machine_whose_places_are_those_of_its_pivot() -> None:
    words = replace(COPER.words, turn=("G0 Y{y} Z{z} A{a}",))
    pivoted = replace(with_keys(tcp=False, pivot=250.0), words=words)
    limits = [replace(a, min=-2000.0, max=20000.0) if a.moves != "A" else a for a in COPER.axes]
    pivoted = replace(pivoted, axes=tuple(limits))
    text = program_of(COPED, pivoted)
    assert text != PROGRAM
    assert not found(text, COPED, pivoted)
    assert found(text, COPED, COPER)
