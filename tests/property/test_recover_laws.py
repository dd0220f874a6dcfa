"""Posting and recovering are the identity on all that the machine makes."""

from random import Random

import shapely
import shapely.affinity
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from beamcam.checks.bars import run
from beamcam.checks.coping import verify_coping
from beamcam.comparison.bars import diff_programs
from beamcam.errors import PlanError, Source, VerifyError, errors_in
from beamcam.machine import Machine, load
from beamcam.model.part import Hole, Part, Profile, Slot
from beamcam.pipeline import post
from beamcam.recovery import KnownStock, recover
from tests.conftest import examples
from tests.property.test_sheet_plan_laws import (
    crosses,
    has_narrow_places,
    part_of,
    polygon,
    sheet_of,
)
from tests.property.test_verify import MACHINES
from tests.property.test_verify import bars as bars_of_all_kinds
from tests.random_copes import random_cope
from tests.random_tubes import random_tube
from tests.strategies import BEAM, bars
from tests.unit.sheets.parts import table

BAR = 15000.0
S = Source("p.nc1", 1)


def posted(parts: tuple[Part, ...], machine: Machine) -> str:
    try:
        return post(parts, machine, bar=BAR, verified=False).text
    except PlanError:
        assume(False)
        raise


def recovered(text: str, machine: Machine, profile: Profile) -> tuple[Part, ...]:
    found = recover(text, machine, "p", KnownStock(profile))
    assert [str(d) for d in found.diagnostics] == []
    return found.parts


def is_one(hole: Hole, other: Hole, near: float) -> bool:
    """Whether a hole that was made is one that was asked for, drilled with a tool that fits it."""
    return (
        (hole.face, hole.kind, hole.depth) == (other.face, other.kind, other.depth)
        and abs(hole.x - other.x) <= near
        and abs(hole.y - other.y) <= near
        and abs(hole.diameter - other.diameter) <= 0.75
    )


@settings(max_examples=examples(25), deadline=None)
@given(st.sampled_from(MACHINES), bars())
def test_the_parts_of_a_bar_come_back(name: str, parts: list[Part]) -> None:
    machine = load(name)
    assert machine.drill is not None
    text = posted(tuple(parts), machine)
    found = recovered(text, machine, parts[0].profile)
    assert len(found) == len(parts)
    step = machine.format.resolution
    for part, made in zip(parts, found, strict=True):
        assert abs(made.length - part.length) <= step + 1e-6
        assert made.cuts == part.cuts
        near = machine.drill.merge_tolerance + step + 1e-6
        assert len(made.features) == len(part.features)
        for hole in part.holes:
            assert sum(is_one(other, hole, near) for other in made.holes) == 1


@settings(max_examples=examples(25), deadline=None)
@given(
    st.sampled_from([m for m in MACHINES if m != "beamline-annex"]).flatmap(
        lambda m: st.tuples(st.just(m), bars_of_all_kinds(m))
    )
)
def test_what_is_recovered_is_the_same_program(case: tuple[str, tuple[Part, ...]]) -> None:
    """Within a last place, where the output is finer than a drawing; slots and threads too."""
    name, parts = case
    machine = load(name)
    text = posted(parts, machine)
    found = recovered(text, machine, parts[0].profile)
    again = post(found, machine, bar=BAR, verified=False).text
    if again != text:
        profile, step = parts[0].profile, 2.2 * machine.format.resolution
        old, new = (run(t, machine, profile).made for t in (text, again))
        assert [d.text for d in diff_programs(old, new, step) if d.what != "order"] == []


slots = st.builds(
    Slot,
    st.just("v"),
    st.integers(4000, 9000).map(lambda n: n / 10),
    st.integers(1300, 1700).map(lambda n: n / 10),
    st.sampled_from((18.0, 22.0, 27.5)),
    st.integers(0, 600).map(lambda n: n / 10),
    st.sampled_from((0.0, 0.0, 12.0, 25.5)),
    st.sampled_from((0.0, 90.0, 30.0, -45.0, 12.5)),
    st.just(S),
    st.sampled_from((None, 3.0)),
)


def steel_left(slot: Slot) -> shapely.Polygon:
    core = shapely.box(-slot.length / 2, -slot.height / 2, slot.length / 2, slot.height / 2)
    turned = shapely.affinity.rotate(core, slot.angle, origin=(0, 0))
    return shapely.affinity.translate(turned, slot.x, slot.y).buffer(slot.diameter / 2, 64)


@settings(max_examples=examples(25), deadline=None)
@given(slots)
@example(Slot("v", 400.0, 130.0, 27.5, 0.0, 0.0, 30.0, S, None))
@example(Slot("v", 400.0, 130.0, 18.0, 0.1, 0.0, 30.0, S, None))
@example(Slot("v", 400.0, 130.0, 27.5, 0.1, 0.0, 30.0, S, None))
def test_a_slot_comes_back(slot: Slot) -> None:
    machine = load("beamline-pusher")
    part = Part("P", BEAM, 1300.0, S, features=(slot,))
    (made,) = recovered(posted((part,), machine), machine, BEAM)
    (found,) = made.features
    assert isinstance(found, Slot)
    assert found.depth == slot.depth
    off = steel_left(found).symmetric_difference(steel_left(slot))
    assert off.buffer(-0.03).is_empty


def coped(machine: Machine, part: Part) -> None:
    """The law of copers: each of two programs makes the part of the other."""
    text = posted((part,), machine)
    found = recover(text, machine, "p", KnownStock(part.profile, part.grade))
    assert not errors_in(found.diagnostics), [str(d) for d in found.diagnostics]
    (made,) = found.parts
    assert abs(made.length - part.length) <= 1e-3
    again = post((made,), machine).text  # read back
    for program, other in ((text, made), (again, part)):
        assert not errors_in(verify_coping(program, (other,), machine))


@settings(max_examples=examples(10), deadline=None)
@given(st.integers(0, 10**6))
@example(15)  # a small window, whose corners have the machine's radius
@example(25)  # two openings in one
def test_the_part_of_a_coper_comes_back(seed: int) -> None:
    coped(load("coper-linuxcnc"), random_cope(seed))


@settings(max_examples=examples(10), deadline=None)
@given(st.integers(0, 10**6))
def test_the_part_that_turned_comes_back(seed: int) -> None:
    coped(load("tube-linuxcnc"), random_cope(seed))


@settings(max_examples=examples(10), deadline=None)
@given(st.integers(0, 10**6))
@example(208)  # arcs end at the seam
@example(254)  # places of an end lie less than a micron apart
def test_the_part_of_a_tube_comes_back(seed: int) -> None:
    coped(load("tube-linuxcnc"), random_tube(seed))


def region(part: Part) -> shapely.Geometry:
    """What is cut of a sheet, in its corner."""
    found = shapely.Polygon()
    for contour in part.contours:
        found = found.symmetric_difference(polygon(contour.curves).buffer(0.0))
    x, y, _, _ = found.bounds
    return shapely.affinity.translate(found, -x, -y)


@settings(
    max_examples=examples(25), deadline=None, suppress_health_check=[HealthCheck.filter_too_much]
)
@given(
    st.integers(0, 10**6),
    st.sampled_from(
        (("plate-linuxcnc", "offset"), ("plate-linuxcnc", "machine"), ("plate-codesys", "offset"),
         ("laser-grbl", "none"))
    ),
)  # fmt: skip
@example(19929, ("plate-linuxcnc", "offset"))  # its first arc is shorter than `gap`
def test_the_contours_of_a_sheet_come_back(seed: int, how: tuple[str, str]) -> None:
    sheet = sheet_of(Random(seed))
    rings = [polygon(curves) for curves in sheet]
    assume(not crosses(rings) and not has_narrow_places(rings, 1.5))
    part = part_of(sheet)
    machine = table(how[0], kerf_by=how[1], thickness=6.0)
    try:
        text = post((part,), machine).text
    except (PlanError, VerifyError):
        assume(False)
    found = recover(text, machine, "p")
    assert [str(d) for d in found.diagnostics] == []
    (made,) = found.parts
    off = region(made).symmetric_difference(region(part))
    assert off.buffer(-0.02).is_empty
