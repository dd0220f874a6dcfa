"""Laws of a bar: the blade takes waste only, makes every end, and the account adds up."""

from itertools import permutations
from math import hypot, radians, tan

from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.machine import load
from beamcam.machine.machine import Machine, saw_of
from beamcam.model.part import EndCuts, Part, Profile
from beamcam.model.plan import Plan, SawOp
from beamcam.model.section import corners
from beamcam.planning.beam import plan_bar
from beamcam.planning.nesting import best_order, lay_on_bar, pivot_edge
from beamcam.planning.operations.finished_part import ends_of
from tests.conftest import examples

SOURCE = Source("a.nc1", 1)
MACHINES = ("beamline", "beamline-annex", "beamline-pusher")
SECTIONS = (
    Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0),
    Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
)
WEB = st.sampled_from((0.0, 0.0, 15.0, -15.0, 30.0, -30.0, 44.0))
TILT = st.sampled_from((0.0, 0.0, 0.0, 10.0, 30.0))


@st.composite
def bars(draw: st.DrawFn, most: int = 5) -> tuple[str, list[Part]]:
    name, section = draw(st.sampled_from(MACHINES)), draw(st.sampled_from(SECTIONS))
    parts = []
    for index in range(draw(st.integers(1, most))):
        flange = (draw(TILT), draw(TILT)) if name == "beamline-pusher" else (0.0, 0.0)
        cuts = EndCuts(draw(WEB), draw(WEB), *flange)
        length = draw(st.integers(12000, 20000)) / 10
        parts.append(Part(f"P{index}", section, length, SOURCE, cuts=cuts))
    return name, parts


def planned(name: str, parts: list[Part], length: float | None = None) -> tuple[Plan, Machine]:
    machine = load(name)
    return plan_bar(parts, machine, length), machine


def angles_of(cut: SawOp, machine: Machine) -> tuple[float, float]:
    """Slopes of a cut across y and across z, from what the machine is told."""
    assert machine.saw is not None
    web = tan(radians((cut.angle - machine.saw.zero_angle) * machine.saw.angle_sign))
    # The blade leans by the tilt in its own plane, which the turned saw has turned too.
    flange = tan(radians(cut.tilt * machine.saw.tilt_sign)) * hypot(1.0, web)
    return web, flange


def blade(cut: SawOp, machine: Machine, plan: Plan, y: float, z: float) -> tuple[float, float]:
    """Bar x between which the blade takes material at a place of the section."""
    saw = machine.saw
    assert saw is not None
    web, flange = angles_of(cut, machine)
    pivot_y, pivot_z = pivot_edge(saw, plan.profile)
    middle = cut.x - saw.x - (y - pivot_y) * web - (z - pivot_z) * flange
    kerf = saw.kerf * (hypot(1.0, web, flange) if saw.kerf_along == "normal" else 1.0)
    return middle - kerf / 2, middle + kerf / 2


@settings(max_examples=examples(200), deadline=None)
@given(bars())
def test_the_blade_takes_waste_only_and_makes_every_end(bar: tuple[str, list[Part]]) -> None:
    plan, machine = planned(*bar)
    cuts = [op for op in plan.operations if isinstance(op, SawOp)]
    for piece in plan.pieces:
        start, end = ends_of(piece.part, saw_of(machine))[0]
        starts, finishes = set(range(len(cuts))), set(range(len(cuts)))
        for y, z in corners(plan.profile):
            first, last = piece.start + start.x(y, z), piece.start + end.x(y, z)
            assert first < last
            for index, cut in enumerate(cuts):
                low, high = blade(cut, machine, plan, y, z)
                assert high <= first + 1e-6 or low >= last - 1e-6
                if abs(high - first) > 1e-6:
                    starts.discard(index)
                if abs(low - last) > 1e-6:
                    finishes.discard(index)
        assert len(finishes) == 1
        # A trim or a part's end before it gives a square start; behind a mitre it stands off.
        assert len(starts) == 1


@settings(max_examples=examples(200), deadline=None)
@given(bars(), st.one_of(st.none(), st.floats(12000, 15000)))
def test_the_account_adds_up(bar: tuple[str, list[Part]], length: float | None) -> None:
    plan, machine = planned(*bar, length)
    account = plan.bar
    assert abs(account.total - account.length) <= 0.001
    assert account.length == (length or account.length)
    assert machine.layout is not None
    assert account.remnant >= machine.layout.dead_zone - 1e-6
    saw = machine.saw
    assert saw is not None
    ends = [ends_of(p.part, saw)[0] for p in plan.pieces]
    # Where the last cut ends, the rest begins.
    behind = plan.pieces[-1].end + ends[-1][1].kerf
    assert abs(behind + account.remnant + account.end_trim - account.length) <= 0.001


@settings(max_examples=examples(200), deadline=None)
@given(bars())
def test_cuts_that_stand_close_can_be_made_in_order_of_x(bar: tuple[str, list[Part]]) -> None:
    """What ends a part comes before what parts it off, and that before what starts the next."""
    plan, _ = planned(*bar)
    cuts = [op for op in plan.operations if isinstance(op, SawOp)]
    rank = {"trim": 0, "mitre": 1, "common": 3, "parting": 2}
    order = [
        (cut.pieces[0], rank[cut.purpose] if cut.at == "end" or cut.purpose == "trim" else 0)
        for cut in cuts
    ]
    assert order == sorted(order)


@settings(max_examples=examples(60), deadline=None)
@given(bars(most=5))
def test_the_best_order_takes_the_least_bar(bar: tuple[str, list[Part]]) -> None:
    name, parts = bar
    machine = load(name)
    assert machine.layout is not None
    assert machine.saw is not None
    layout = replace(machine.layout, max_bar=None, min_bar=0.0)
    ends = [ends_of(p, machine.saw)[0] for p in parts]

    def used(order: list[int]) -> float:
        """Bar up to the end of the last part, whose own kerf no order changes much."""
        assert machine.saw is not None
        laid = lay_on_bar([parts[i] for i in order], [ends[i] for i in order], layout,
                          machine.saw, None)  # fmt: skip
        return laid[0].bar.nested

    found, _ = best_order(parts, ends, machine.saw)
    best = max(used(list(order)) for order in permutations(range(len(parts))))
    assert sorted(found) == list(range(len(parts)))
    assert abs(used(found) - best) < 1e-6


def test_many_parts_are_ordered_too() -> None:
    section = SECTIONS[0]
    angles = (0.0, 15.0, 30.0)
    parts = [
        Part(f"P{i}", section, 500.0, SOURCE, cuts=EndCuts(angles[i % 3], angles[(i + 1) % 3]))
        for i in range(12)
    ]
    machine = load("beamline")
    assert machine.saw is not None
    ends = [ends_of(p, machine.saw)[0] for p in parts]
    order, said = best_order(parts, ends, machine.saw)
    assert sorted(order) == list(range(12))
    plan = plan_bar(parts, machine, order="best")
    common = [op for op in plan.operations if isinstance(op, SawOp) and op.purpose == "common"]
    # Four parts end at 15, four begin so; four end at 30, four begin so.
    assert len(common) == 8 or not said
