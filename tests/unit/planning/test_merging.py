"""Flange holes that are one stroke, holes that are written twice, and what may not be merged."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError
from beamcam.machine import Machine, load
from beamcam.model.part import Part
from beamcam.model.plan import DrillOp
from beamcam.pipeline import post
from beamcam.planning.beam import plan_bar
from beamcam.planning.explain import unmerged_because
from beamcam.planning.operations.hole import drop_duplicates, merge_pairs
from beamcam.planning.operations.part_planner import refuse_too_near
from tests.conftest import examples
from tests.unit.planning.shop import hole, part, plan


def spindles(*features: Any) -> list[int]:
    found = plan(part(*features), machine="beamline")
    return sorted(op.spindle for op in found.operations if isinstance(op, DrillOp))


TOP = hole(500, 40, 18, "o")


@pytest.mark.parametrize(
    ("change", "merged"),
    [
        ({}, True),
        ({"x": 500.1}, True),
        ({"y": 39.95}, True),
        ({"x": 500.11}, False),
        ({"y": 40.2}, False),
        ({"diameter": 18.02}, True),
        ({"diameter": 18.1}, False),
        ({"diameter": 22.0}, False),
        ({"depth": 5.0, "kind": "blind"}, False),
    ],
)
def test_a_pair(change: dict[str, Any], merged: bool) -> None:
    other = replace(TOP, face="u", **change)
    assert spindles(TOP, other) == ([13] if merged else [1, 3])


def test_a_merged_stroke_stands_between_its_holes() -> None:
    found = plan(part(TOP, replace(TOP, face="u", x=500.1, y=39.9)), machine="beamline")
    (op,) = (op for op in found.operations if isinstance(op, DrillOp))
    assert op.x == pytest.approx(778.56 + 20 + 500.05)
    assert op.y == pytest.approx(39.95)
    assert op.reasons == ("drill-exact", "merge-pair")
    assert [o.how for o in found.outcomes] == ["made", "merged"]


def test_one_flange_alone_is_not_merged() -> None:
    assert spindles(TOP) == [1]
    assert spindles(TOP, replace(TOP, x=600)) == [1, 1]


def test_a_machine_without_the_pair_drills_one_by_one() -> None:
    machine = replace(load("beamline"), pairs=())
    found = plan_bar([part(TOP, replace(TOP, face="u"))], machine)
    assert sorted(op.spindle for op in found.operations if isinstance(op, DrillOp)) == [1, 3]


def test_each_hole_finds_the_nearest_partner() -> None:
    drill = load("beamline").drill
    assert drill is not None
    near, far = replace(TOP, face="u", x=500.02), replace(TOP, face="u", x=500.09)
    groups = merge_pairs(((500.0, 0, TOP), (500.02, 2, near), (500.09, 1, far)), PAIRED, drill)
    assert [[f for _, f, _ in group] for group in groups] == [[0, 2], [1]]


def test_holes_of_different_parts_are_never_merged() -> None:
    bar = plan(part(TOP), part(replace(TOP, face="u")), machine="beamline")
    assert sorted(op.spindle for op in bar.operations if isinstance(op, DrillOp)) == [1, 3]


@pytest.mark.parametrize(
    ("change", "how"),
    [
        ({}, "duplicate"),
        ({"x": 500.01}, "duplicate"),
        ({"x": 530.0}, "made"),
        ({"diameter": 26.0, "kind": "blind", "depth": 4.0}, "made"),  # a stepped hole
    ],
)
def test_a_hole_that_is_written_twice(change: dict[str, Any], how: str) -> None:
    found = plan(part(TOP, replace(TOP, **change)), machine="beamline")
    assert [o.how for o in found.outcomes] == ["made", how]


def test_a_repeat_of_a_hole_that_cannot_be_made_cannot_be_made() -> None:
    large = hole(500, diameter=60)
    found = plan(part(large, large, large), machine="beamline", skips=("tool",))
    assert [o.by for o in found.outcomes] == ["plan-tool"] * 3


PAIRED: dict[str, str] = {"o": "u", "u": "o"}
SITES = st.tuples(
    st.sampled_from("ouv"), st.sampled_from((500.0, 500.05, 500.12, 501.0)),
    st.sampled_from((40.0, 40.06)), st.sampled_from((18.0, 18.01, 22.0)),
)  # fmt: skip


@settings(max_examples=examples(300), deadline=None)
@given(st.lists(SITES, max_size=9))
def test_every_hole_is_in_one_group(sites: list[tuple[str, float, float, float]]) -> None:
    machine = load("beamline")
    assert machine.drill is not None
    each = ((x, i, hole(x, y, d, face)) for i, (face, x, y, d) in enumerate(sites))
    holes = tuple(sorted(each))
    kept, repeats = drop_duplicates(holes, machine.drill.duplicate_tolerance)
    assert {f for _, f, _ in kept} | set(repeats) == set(range(len(sites)))
    assert all(first in kept and first[1] < f for f, first in repeats.items())
    groups = list(merge_pairs(kept, PAIRED, machine.drill))
    assert sorted(p for group in groups for p in group) == list(kept)
    assert {len(group) for group in groups} <= {1, 2}
    # Nothing that could be a pair is left apart.
    alone = [group[0][2] for group in groups if len(group) == 1]
    for a in alone:
        for b in alone:
            if a.face == "o" and b.face == "u":
                assert unmerged_because(a, b, machine.drill) is not None


@pytest.mark.parametrize(
    ("change", "because"),
    [
        ({"x": 501.0}, "x 500 and 501"),
        ({"y": 42.0}, "y 40 and 42"),
        ({"kind": "blind", "depth": 4.0}, "kind through and blind"),
        ({"depth": 4.0}, "depth through and 4"),
        ({"diameter": 22.0}, "diameter 18 and 22"),
        ({"x": 700.0}, None),
        ({}, None),
    ],
)
def test_why_two_holes_are_not_one_stroke(change: dict[str, Any], because: str | None) -> None:
    drill = load("beamline").drill
    assert drill is not None
    assert unmerged_because(TOP, replace(TOP, face="u", **change), drill) == because


@settings(deadline=None, max_examples=examples(150))
@given(
    st.sampled_from(("beamline", "beamline-annex", "beamline-pusher")),
    st.lists(
        st.tuples(
            st.sampled_from("vvou"), st.integers(0, 35), st.integers(0, 35),
            st.sampled_from((14.0, 14.0, 18.0)),
        ),
        min_size=2, max_size=4,
    ),
)  # fmt: skip
def test_holes_beside_one_another_are_made_or_refused_by_the_planner(
    name: str, places: list[tuple[str, int, int, float]]
) -> None:
    """Never only when the program is read back, whose numbers may not tell them apart."""
    made = part(
        *(
            hole(500 + dx / 100, (150 if face == "v" else 40) + dy / 100, diameter, face)
            for face, dx, dy, diameter in places
        )
    )
    machine = load(name)
    codes = [said.code for said in refusals(made, machine)]
    if codes:
        assert set(codes) <= {"plan-too-near", "plan-hole-overlap"}
    else:
        assert post((made,), machine).text


def refusals(made: Part, machine: Machine) -> tuple[Diagnostic, ...]:
    try:
        plan_bar((made,), machine)
    except PlanError as error:
        return error.diagnostics
    return ()


@pytest.mark.parametrize(("other", "refused"), [
    ({"x": 500.2}, True),
    ({"x": 500.21}, False),
    ({"y": 40.02}, True),
    ({"x": 499.9, "y": 39.9}, True),
    ({"x": 500.1, "diameter": 22.0}, False),  # told apart by their tools
    ({"x": 500.1, "face": "u"}, False),
    ({"x": 500.005}, False),  # one hole that was written twice
])  # fmt: skip
def test_what_the_program_cannot_tell_apart(other: dict[str, Any], refused: bool) -> None:
    machine, first, again = load("beamline-annex"), TOP, replace(TOP, **other)
    assert machine.drill
    for features in ((first, again), (again, first)):
        codes = [said.code for _, said in refuse_too_near(
            drop_duplicates(tuple((h.x, f, h) for f, h in sorted(
                enumerate(features), key=lambda item: item[1].x)), 0.01)[0],
            machine.format.resolution, machine.drill,
        )]  # fmt: skip
        assert codes == ["plan-too-near"] * refused


def test_each_hole_too_near_an_earlier_one_is_named() -> None:
    row = [hole(500 + dx, 150, 14) for dx in (0.3, 0.0, 0.15, 0.45)]
    with pytest.raises(PlanError) as caught:
        plan_bar((part(*row),), load("beamline-annex"))
    said = [d.message for d in caught.value.diagnostics]
    near = [m for m in said if "expected the same place" in m]
    assert [m.split(" at ")[1].split(",")[0] for m in near] == ["x 500.15", "x 500.45"]
