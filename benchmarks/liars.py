"""A planner that lies: features dropped, moved, doubled and altered in the plan, and posted.

The parts have every kind of feature that some bar machine makes. Each operation of their plans is
dropped under every reason that there is, moved, doubled or made otherwise, the pieces are laid
otherwise than the plan says, and where the machine cannot hold them; the program of each goes
through the pipeline as any other. All have to be refused, whatever the plan says of them and
whatever kinds the user allowed to be missing.
"""

from collections import Counter
from collections.abc import Iterator
from unittest.mock import patch

from msgspec import Struct
from msgspec.structs import replace

from beamcam import pipeline
from beamcam.errors import PlanError, Source, VerifyError
from beamcam.geometry.curves import Line
from beamcam.machine import Machine, load
from beamcam.machine.stations import SawSection
from beamcam.model.part import Contour, EndCuts, Feature, Hole, Part, Profile, Slot
from beamcam.model.plan import SKIP_NAMES, DrillOp, Operation, Outcome, PathOp, Plan, SawOp
from beamcam.model.request import Job, Request
from beamcam.posts import post_of

SOURCE = Source("liar.nc1", 1)
PROFILES = (
    Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0),
    Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
)
REASONS: tuple[tuple[str, str], ...] = (
    ("made", "drill"), ("merged", "drill"), ("duplicate", "plan-duplicate"),
    ("skipped", "map-ignore"), *(("skipped", f"plan-{name}") for name in SKIP_NAMES),
)  # fmt: skip


class Lies(Struct):
    """What became of them."""

    made: Counter[str]
    caught: Counter[str]
    missed: list[tuple[str, str]]  #: machine and lie


def parts(machine: str, profile: Profile) -> tuple[Part, ...]:
    """Two parts with every kind of feature that the machine makes."""
    web, flange = profile.height / 2, profile.width / 2 + (30.0 if profile.code == "I" else 10.0)
    features: list[Feature] = [
        Hole("v", 300.0, web, 22.0, SOURCE),
        Hole("v", 380.0, web - 20.0, 14.0, SOURCE),
        Hole("o", 500.0, flange, 14.0, SOURCE),
        Hole("u", 500.0, flange, 14.0, SOURCE),
        Hole("u", 650.0, flange, 18.0, SOURCE),
    ]
    if machine != "beamline-annex":
        features.append(Hole("v", 800.0, web, 14.0, SOURCE, 4.0, "blind"))
    if machine == "beamline-pusher":
        features += [
            Hole("v", 900.0, web, 12.0, SOURCE, None, "thread"),
            Hole("v", 1000.0, web, 14.0, SOURCE),
            Hole("v", 1000.0, web, 20.0, SOURCE, None, "countersink", 90.0),
            Hole("v", 1100.0, web, 0.0, SOURCE, None, "mark"),
            Slot("v", 1200.0, web, 18.0, 30.0, 0.0, 0.0, SOURCE),
            Contour("v", "open", (Line((1300.0, web), (1400.0, web + 20)),), SOURCE, "mark", False),
        ]
    skew = Part("A", profile, 2000.0, SOURCE, cuts=EndCuts(0.0, 15.0), features=tuple(features))
    square = Part("B", profile, 1500.0, SOURCE, features=tuple(features[:3]))
    return skew, square


def lies(plan: Plan) -> Iterator[tuple[str, Plan]]:
    """Plans that are not true, each with what it is."""
    for at, op in enumerate(plan.operations):
        before, after = plan.operations[:at], plan.operations[at + 1 :]
        kind = op.tool.kind if isinstance(op, DrillOp | PathOp) else "cut"
        dropped = replace(plan, operations=(*before, *after))
        for how, by in REASONS:
            yield f"{kind} dropped", _excused(dropped, op, how, by)
        yield f"{kind} doubled", replace(plan, operations=(*before, op, op, *after))
        for name, other in _altered(op):
            yield f"{kind} {name}", replace(plan, operations=(*before, other, *after))
    yield from _laid_otherwise(plan)


def _excused(plan: Plan, op: Operation, how: str, by: str) -> Plan:
    """The plan that says of an operation's features that they are not there, and why."""
    refs = set() if isinstance(op, SawOp) else set(op.features)
    outcomes = tuple(
        Outcome(o.feature, how, by) if o.feature in refs else o  # type: ignore[arg-type]
        for o in plan.outcomes
    )
    return replace(plan, outcomes=outcomes)


def _altered(op: Operation) -> Iterator[tuple[str, Operation]]:
    """An operation made otherwise."""
    yield "moved", replace(op, x=op.x + 1.0)
    if isinstance(op, SawOp):
        yield "turned", replace(op, angle=op.angle + 5.0)
        return
    yield "of another depth", replace(op, depth=1.0)
    if isinstance(op, PathOp):
        moved = tuple((x + 1.0, y) for x, y in op.path)
        yield "led elsewhere", replace(op, x=op.x + 1.0, path=moved)
        yield "cut short", replace(op, path=op.path[: max(2, len(op.path) // 2)])
        return
    yield "moved across", replace(op, y=op.y + 1.0)
    other = replace(op.tool, diameter=op.tool.diameter + 4.0)
    yield "with another tool", replace(op, tool=other)


def _laid_otherwise(plan: Plan) -> Iterator[tuple[str, Plan]]:
    """The pieces elsewhere, turned, exchanged, or without their features, and the work as planned.

    Where the work does not change, nothing is wrong with the program, and no lie is counted.
    """
    for at, piece in enumerate(plan.pieces):
        bare = replace(piece, part=replace(piece.part, features=()))
        short = replace(piece, part=replace(piece.part, length=piece.part.length - 5))
        for name, other in (
            ("piece moved", replace(piece, start=piece.start + 5.0)),
            ("piece bare", bare),
            ("piece shorter", short),
            ("piece of another part", replace(piece, given=1 - piece.given)),
        ):
            pieces = (*plan.pieces[:at], other, *plan.pieces[at + 1 :])
            own = [o for o in plan.operations if _of_piece(o, at)]
            yield name, replace(plan, pieces=pieces)
            if name == "piece bare":
                kept = tuple(o for o in plan.operations if o not in own)
                yield name, replace(plan, pieces=pieces, operations=kept)


def unheld(machine: Machine, profile: Profile) -> Iterator[tuple[str, Job, Plan]]:
    """Bars and parts that a machine cannot hold, planned as if it could: each with its job.

    The planner knows nothing of one key of the machine file.
    """
    layout = replace(machine.needed(machine.layout, "bar"), end_trim=30.0)
    machine = replace(machine, layout=layout)
    long = Part("A", profile, 2500.0, SOURCE)
    brief = replace(long, length=400.0)
    short = replace(long, length=0.9 * layout.min_part)
    plan_of = post_of(machine).plan
    for key, parts in (
        ("min_part", (short, long)), ("front_trim", (long, long)), ("dead_zone", (long, long)),
        ("end_trim", (long, long)), ("min_bar_left", (long, brief)), ("max_bar", (long,)),
    ):  # fmt: skip
        too_long = (layout.max_bar or 0.0) + 100.0 if key == "max_bar" else None
        # A trim cut in front of the bar is beyond the stop.
        value = {"max_bar": None, "front_trim": layout.front_trim / 2}.get(key, 0.0)
        loose = replace(layout, **{key: value})  # type: ignore[arg-type]
        request = Request(parts, machine)
        blind = replace(request, machine=replace(machine, layout=loose))
        plan = plan_of(pipeline.whole_job(blind, too_long))
        assert isinstance(plan, Plan)
        if not getattr(layout, key):
            continue
        yield f"without {key}", pipeline.whole_job(request, plan.bar.length), plan
        if key in ("dead_zone", "end_trim"):
            yield f"without {key}, bar not given", pipeline.whole_job(request), plan


def unmade(machine: Machine, profile: Profile) -> Iterator[tuple[str, Job, Plan]]:
    """Parts that a machine's file rules out, planned as if it did not: each with its job.

    The planner knows a machine that takes what this one does not.
    """
    request = Request(parts(machine.name, profile), machine)
    plan = post_of(machine).plan(pipeline.whole_job(request, 6000.0))
    assert isinstance(plan, Plan)
    saw, drill = machine.needed(machine.saw, "bar"), machine.needed(machine.drill, "bar")
    layout = machine.needed(machine.layout, "bar")
    low, narrow = profile.height - 1.0, profile.width - 1.0
    reach = SawSection(max_angle=90.0, max_height=low, max_width=profile.width)
    others = tuple(code for code in layout.profiles if code != profile.code)
    tools = tuple(
        replace(t, diameters=tuple(d for d in t.diameters if d != 22.0)) if t.kind == "drill" else t
        for t in machine.tools
    )
    for lie, strict in (
        ("without saw.max_height", replace(machine, saw=replace(saw, max_height=low))),
        ("without saw.max_width", replace(machine, saw=replace(saw, max_width=narrow))),
        ("without saw.max_sections", replace(machine, saw=replace(saw, max_sections=(reach,)))),
        ("without drill.max_height", replace(machine, drill=replace(drill, max_height=low))),
        ("without layout.profiles", replace(machine, layout=replace(layout, profiles=others))),
        ("without tools", replace(machine, tools=tools)),
    ):
        yield lie, pipeline.whole_job(replace(request, machine=strict), 6000.0), plan


def _of_piece(op: Operation, piece: int) -> bool:
    return not isinstance(op, SawOp) and any(p == piece for p, _ in op.features)


def told(machines: tuple[str, ...], every: int = 1) -> Lies:
    """Every lie (or each `every`-th) about bars of all machines, posted through the pipeline."""
    result = Lies(Counter(), Counter(), [])
    count = 0
    for name in machines:
        machine = load(name)
        row = post_of(machine)
        for profile in PROFILES:
            for lie, job, false in (*unheld(machine, profile), *unmade(machine, profile)):
                result.made[lie] += 1
                if _is_refused(false, job):
                    result.caught[lie] += 1
                else:
                    result.missed.append((name, lie))
            for skips in ((), SKIP_NAMES):
                request = Request(parts(name, profile), machine, tuple(skips))
                job = pipeline.whole_job(request, 6000.0)
                plan = row.plan(job)
                assert isinstance(plan, Plan)
                truth = pipeline.post(job.parts, machine, bar=job.bar, skips=job.request.skips).text
                known: dict[str, bool] = {}
                for lie, false in lies(plan):
                    count += 1
                    if count % every == 0:
                        _tell(lie, false, job, truth, known, result)
    return result


def _tell(
    lie: str, false: Plan, job: Job, truth: str, known: dict[str, bool], result: Lies
) -> None:
    """Post a false plan; what is known of a text already is not asked again."""
    row = post_of(job.machine)
    program = row.motion(false, job.machine, job.request.name)
    text = row.emit(program, job)
    assert isinstance(text, str)
    if _bare(text) == _bare(truth):
        return
    if text not in known:
        known[text] = _is_refused(false, job)
    result.made[lie] += 1
    result.caught[lie] += known[text]
    if not known[text]:
        result.missed.append((job.machine.name, lie))


def _bare(text: str) -> list[str]:
    """The blocks of a program without their numbers and without comments."""
    return [line.split(" ", 1)[-1] for line in text.splitlines() if not line.startswith(("(", "%"))]


def _is_refused(false: Plan, job: Job) -> bool:
    """Whether the pipeline refuses what a planner makes up for a job."""
    row = replace(post_of(job.machine), plan=lambda _: false)
    with patch.object(pipeline, "post_of", lambda _: row):
        try:
            pipeline.post(job.parts, job.machine, bar=job.bar, skips=job.request.skips)
        except VerifyError:
            return True
        except PlanError as error:
            raise AssertionError("a lie that the planner refuses") from error
    return False
