"""Laws of the plan over ten thousand random parts, against figures found the slow way.

The parts are drawn by a seeded generator, so that each run sees the same ones.
"""

from collections import Counter
from collections.abc import Iterator
from math import hypot, isclose
from random import Random

import pytest
from msgspec.structs import replace

from beamcam.errors import PlanError, Severity, Source
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import EndCuts, Feature, Hole, Part, Profile, Slot
from beamcam.model.plan import SKIP_NAMES, DrillOp, PathOp, Plan, SawOp
from beamcam.planning.beam import plan_bar
from tests.conftest import sampled

BEAM = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
ANGLE = Profile("L", "L150*100*12", 150.0, 100.0, 12.0, 12.0, 12.0)
DIAMETERS = (
    8, 9.0, 13, 14, 17.46, 18, 20.6375, 20.64, 22, 23.8, 26.98, 26.9875, 26.99, 27, 27.1, 30.15,
    5, 7.5, 52, 70, 19.95, 20.05,
)  # fmt: skip
SHIFTS = (0.0, 0.0, 0.05, 0.1, 0.11, 0.3, 2.0)  #: of a twin on the other flange
BATCHES = 25
PARTS = 400  #: in each batch


def random_holes(random: Random, profile: Profile, length: float, file: str) -> Iterator[Feature]:
    """Holes, twins on the other flange that are the same or nearly so, and repeats."""
    line = 24
    for place in range(random.randrange(9)):
        face = random.choice("vvouh")
        width = profile.face_width(face)
        # Clear of mitres, of walls and of each other; a few are beyond their face.
        x, y = 420.0 + 80 * place + round(random.uniform(0, 5), 1), 40.0
        if face in "vh":
            y = random.choice((40.0, round(random.uniform(60, width - 60), 2)))
        if random.random() < 0.05:
            x, y = random.choice(((-5.0, y), (x, -3.0), (x, width + 3)))
        kind = random.choice(("through", "through", "through", "blind", "thread", "mark"))
        sizes = DIAMETERS if face in "vh" else tuple(d for d in DIAMETERS if d < 50)
        diameter = float(random.choice((8, 10, 12, 16) if kind == "thread" else sizes))
        if diameter > 50:
            y = width / 2
        depth = 6.0 if kind == "blind" else None
        line += 1
        hole = Hole(face, x, y, diameter, Source(file, line), depth, kind)  # type: ignore[arg-type]
        yield hole
        if face in "ou" and profile.code != "L" and random.random() < 0.6:
            other = replace(
                hole,
                face="u" if face == "o" else "o",
                x=x + random.choice(SHIFTS),
                y=y - random.choice(SHIFTS),
                source=Source(file, line + 100),
            )
            if random.random() < 0.2:
                other = replace(other, diameter=diameter + random.choice((0.005, 0.05, 1.0)))
            if random.random() < 0.1:
                other = replace(other, depth=5.0, kind="blind")
            yield other
        if random.random() < 0.1:
            yield replace(hole, x=x + random.choice((0.0, 0.005)))
        if random.random() < 0.1 and kind == "through":
            cone = random.choice((90.0, None))
            yield replace(hole, kind="countersink", diameter=20.0, depth=3.0, angle=cone)
    if random.random() < 0.2:
        x, y = random.uniform(420, length - 420), profile.height / 2
        angle = random.choice((0.0, 90.0, 30.0))
        yield Slot("v", x, y, 22.0, random.choice((20.0, 40.0)), 0.0, angle, Source(file, line + 1))


def random_part(random: Random, number: int) -> Part:
    profile = random.choice((BEAM, CHANNEL, ANGLE))
    length = round(random.uniform(1500, 6000), 1)
    angles = (0.0, 0.0, 0.0, 20.0, -30.0, 44.0)
    file = f"random-{number}.nc1"
    return Part(
        f"R{number}",
        profile,
        length,
        Source(file, 1),
        cuts=EndCuts(random.choice(angles), random.choice(angles)),
        features=tuple(random_holes(random, profile, length, file)),
    )


def shop(number: int) -> Machine:
    return load("beamline" if number % 2 else "beamline-pusher")


def planned(part: Part, machine: Machine, skips: tuple[str, ...]) -> tuple[Plan | None, list[str]]:
    """The plan of a part, or the codes of all that refuses it."""
    try:
        return plan_bar([part], machine, skips=skips), []
    except PlanError as error:
        return None, [d.code for d in error.diagnostics if d.severity is Severity.ERROR]


def is_within_tolerance(tool: float, hole: float, machine: Machine) -> bool:
    """Whether the machine's file lets this drill make this hole, row by row."""
    assert machine.drill is not None
    for fit in machine.drill.fits:
        if hole <= fit.up_to:
            return -fit.minus - 1e-9 <= tool - hole <= fit.plus + 1e-9
    return False


def fitting_drills(hole: float, machine: Machine) -> list[float]:
    """Every drill of the file that may make the hole."""
    return [
        size
        for tools in machine.tools
        if tools.kind == "drill"
        for size in tools.sizes
        if is_within_tolerance(size, hole, machine)
    ]


def made_holes(plan: Plan, machine: Machine) -> Iterator[tuple[tuple[int, int], DrillOp | PathOp]]:
    for op in plan.operations:
        if not isinstance(op, SawOp):
            for ref in op.features:
                yield ref, op


def check_cylinders(plan: Plan, machine: Machine) -> None:
    """What is made is what the part asks for: no hole missing, none twice, none elsewhere."""
    assert machine.drill is not None
    tolerance = machine.drill.merge_tolerance / 2 + 1e-9
    made = Counter(ref for ref, op in made_holes(plan, machine))
    how = {o.feature: o.how for o in plan.outcomes}
    for ref, op in made_holes(plan, machine):
        p, f = ref
        feature = plan.pieces[p].part.features[f]
        if isinstance(feature, Slot):
            continue
        assert isinstance(feature, Hole)
        assert how[ref] in ("made", "merged")
        assert made[ref] == (2 if feature.kind == "thread" else 1)
        x = op.x - machine.drill.x - plan.pieces[p].start
        slack = tolerance if len(op.features) == 2 else 1e-6
        if feature.kind == "countersink":  # it stands on its hole, which a merge may have moved
            slack = 3 * tolerance
        y = op.y
        if isinstance(op, PathOp):
            xs, ys = zip(*op.path, strict=True)
            lowest, highest = min(ys), max(ys)
            ring = (highest - lowest) + op.tool.diameter
            assert abs(ring - feature.diameter) <= 0.05
            x = (min(xs) + max(xs)) / 2 - machine.drill.x - plan.pieces[p].start
            y, slack = (lowest + highest) / 2, 0.03
        assert abs(x - feature.x) <= slack
        assert abs(y - feature.y) <= slack
        plates = {"h": "v", "o": "u"} if plan.profile.code == "L" else {"h": "v"}
        behind = plates.get(feature.face, feature.face)
        assert {feature.face, behind} & set(op.faces)
        if feature.kind in ("through", "blind") and op.tool.kind == "drill":
            assert op.depth == feature.depth
            assert is_within_tolerance(op.tool.diameter, feature.diameter, machine)
            nearest = min(
                abs(size - feature.diameter) for size in fitting_drills(feature.diameter, machine)
            )
            off = abs(op.tool.diameter - feature.diameter)
            pair = 0.02 if len(op.features) == 2 else 0.0
            assert off <= nearest + machine.drill.same_tool_tolerance + pair + 1e-9
    for ref, outcome in how.items():
        if outcome in ("skipped", "duplicate"):
            assert made[ref] == 0


def check_refusals(plan: Plan, machine: Machine) -> None:
    """A hole is left out for want of a drill only where there is none."""
    for outcome in plan.outcomes:
        p, f = outcome.feature
        hole = plan.pieces[p].part.features[f]
        if outcome.by == "plan-tool" and isinstance(hole, Hole) and hole.kind == "through":
            assert not fitting_drills(hole.diameter, machine)


def check_duplicates(plan: Plan) -> None:
    """What is called a duplicate has a hole beside it that is made and is the same, or larger."""
    how = {o.feature: o.how for o in plan.outcomes}
    by = {o.feature: o.by for o in plan.outcomes}
    for (p, f), outcome in how.items():
        if outcome != "duplicate":
            continue
        hole = plan.pieces[p].part.features[f]
        assert isinstance(hole, Hole)
        if by[p, f] == "plan-within":
            assert any(
                isinstance(other, Hole | Slot) and other.face == hole.face
                and hypot(other.x - hole.x, other.y - hole.y) + hole.diameter / 2
                <= other.diameter / 2 + getattr(other, "length", 0.0) / 2 + 0.06
                for g, other in enumerate(plan.pieces[p].part.features) if g != f
            )  # fmt: skip
            continue
        assert any(
            isinstance(other, Hole)
            and how[p, g] in ("made", "merged")
            and other.kind == hole.kind
            and abs(other.x - hole.x) <= 0.0101
            and abs(other.y - hole.y) <= 0.0101
            and abs(other.diameter - hole.diameter) <= 0.0101
            for g, other in enumerate(plan.pieces[p].part.features)
            if g != f
        )


def check_merges(plan: Plan) -> None:
    """Both spindles at once only for two holes of one piece that are the same on both flanges."""
    for op in plan.operations:
        if isinstance(op, SawOp) or len(op.features) == 1:
            continue
        (p, f), (q, g) = op.features
        a, b = plan.pieces[p].part.features[f], plan.pieces[q].part.features[g]
        assert isinstance(a, Hole)
        assert isinstance(b, Hole)
        assert p == q
        assert {a.face, b.face} == {"o", "u"}
        assert a.kind == b.kind
        assert (a.depth, a.angle) == (b.depth, b.angle)
        assert abs(a.x - b.x) <= 0.1 + 1e-9
        assert abs(a.y - b.y) <= 0.1 + 1e-9
        assert abs(a.diameter - b.diameter) <= 0.02 + 1e-9


def check_order(plan: Plan, machine: Machine) -> None:
    resolution = machine.format.resolution
    places = [round(op.x / resolution) for op in plan.operations]
    assert places == sorted(places)
    assert machine.layout is not None
    if machine.layout.order == "drill-saw":
        parted = set()
        for op in plan.operations:
            if isinstance(op, SawOp):
                assert parted.isdisjoint(op.pieces[:1]) or op.at == "start"
                if op.purpose in ("parting", "common"):
                    parted.add(op.pieces[0])
            else:
                assert parted.isdisjoint(p for p, _ in op.features)


def check_ledger(plan: Plan) -> None:
    features = [
        (p, f) for p, piece in enumerate(plan.pieces) for f in range(len(piece.part.features))
    ]
    assert [o.feature for o in plan.outcomes] == features
    bar = plan.bar
    sums = bar.front_trim + bar.parts + bar.kerfs - bar.nested + bar.remnant + bar.end_trim
    assert abs(sums - bar.length) <= 0.001
    assert isclose(bar.parts, sum(piece.part.length for piece in plan.pieces))
    assert bar.remnant >= 0


@pytest.mark.parametrize("batch", sampled(range(BATCHES), 14))
def test_laws_of_the_plan(batch: int) -> None:
    random = Random(batch)
    refused = 0
    for number in range(PARTS):
        machine = shop(number)
        part = random_part(random, batch * PARTS + number)
        plan, codes = planned(part, machine, SKIP_NAMES)
        if plan is None:
            # All features may be left out, so only the ends can refuse a part.
            assert set(codes) == {"plan-saw-angle"}
            refused += 1
            continue
        check_cylinders(plan, machine)
        check_refusals(plan, machine)
        check_duplicates(plan)
        check_merges(plan)
        check_order(plan, machine)
        check_ledger(plan)
        assert plan_bar([part], machine, skips=SKIP_NAMES) == plan
    assert refused < PARTS // 10


def test_several_parts_on_a_bar_keep_the_laws() -> None:
    random = Random(99)
    for number in range(100):
        machine = shop(number)
        assert machine.layout is not None
        machine = replace(machine, layout=replace(machine.layout, max_bar=None))
        one = [random_part(random, number * 10 + i) for i in range(3)]
        parts = [p for p in one if p.profile == one[0].profile] * random.choice((1, 2))
        order = random.choice(("given", "best"))
        plan = plan_bar(parts, machine, 80000.0 if number % 2 else None, SKIP_NAMES, order)  # type: ignore[arg-type]
        assert sorted(piece.given for piece in plan.pieces) == list(range(len(parts)))
        check_cylinders(plan, machine)
        check_merges(plan)
        check_order(plan, machine)
        check_ledger(plan)


def test_parts_that_are_refused_say_why_for_each_feature() -> None:
    random = Random(7)
    seen = Counter[str]()
    for number in range(300):
        part = random_part(random, number)
        plan, codes = planned(part, load("beamline"), ())
        left_out, _ = planned(part, load("beamline"), SKIP_NAMES)
        assert left_out is not None
        skipped = [o.by for o in left_out.outcomes if o.how == "skipped"]
        assert Counter(skipped) == Counter(codes)
        assert (plan is None) == bool(codes)
        seen.update(codes)
    assert {"plan-tool", "plan-face", "plan-off-face", "plan-mark", "plan-slot"} <= set(seen)
