"""A planner of sheets that lies: contours dropped, moved, doubled and altered in the plan.

The parts have every kind of feature that a cutting table makes, and what it leaves out: a layer
that is mapped away, a line that is drawn twice, lettering. Each operation of their plans is dropped
under every reason that there is, moved by a millimetre and by twice the tolerance, doubled, cut
short, bridged and cut again otherwise, and made by another process or with other settings than
asked for; the work is put elsewhere and in another order, and driven along arcs that the controller
does not take. Drawings of many lines at equal distances get the plan of one that has a ring or a
line across them too, and broken lines that of a line; and the other way round. The program of each
goes through the pipeline as any other, and all have to be refused.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from unittest.mock import patch

from msgspec.structs import replace

from beamcam import pipeline
from beamcam.errors import PlanError, Source, VerifyError
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.machine.tables import TABLE_CONTROLLERS
from beamcam.machine.torch import LayerSettings, Torch
from beamcam.model.part import Contour, Hole, Measures, Part, Process, Profile, Slot, TextMark
from beamcam.model.plan import SKIP_NAMES, ContourOp, Outcome, Pass, SheetPlan
from beamcam.model.request import Job, Request
from beamcam.planning.contours.outline import stretch
from beamcam.posts import Written, post_of
from benchmarks.liars import REASONS, Lies

SOURCE = Source("liar.dxf", 1)
#: Every machine of sheets, with its options: who keeps the kerf, and how it is led in.
MACHINES: tuple[tuple[str, dict[str, object]], ...] = (
    ("plate-linuxcnc", {}),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}),
    ("plate-linuxcnc", {"tabs": 2}),
    ("plate-codesys", {}),
    ("laser-grbl", {"material": "wood"}),
    ("laser-grbl", {"material": "wood", "tabs": 2, "inner_tabs": True, "overcut": 2.0}),
    (
        "laser-grbl",
        {
            "material": "wood",
            "kerf_by": "offset",
            "lead": "arc",
            "lead_in": 2.0,
            "lead_out": 1.0,
            "overcut": 1.5,
            "margin": 5.0,
            "settings": {
                "red": LayerSettings(passes=2, power=800.0),
                "blue": LayerSettings(passes=3),
            },
        },
    ),
    ("table-simotion", {}),
    ("table-plcopen", {}),
    ("laser-stepper", {"material": "wood"}),
    *(
        (name, {
            **values, "tabs": 2, "inner_tabs": True, "overcut": 1.5, "copies": (2, 1),
            "rotate": 30.0, "place": "corner", "margin": 5.0,
            "settings": {
                "red": LayerSettings(speed=400.0, passes=2, order=2, overcut=2.0),
                "magenta": LayerSettings(order=1),
                "blue": LayerSettings(hatch=3.0, hatch_one_way=True),
            },
        })
        for name, values in (
            ("laser-grbl", {"material": "wood"}), ("laser-stepper", {"material": "wood"}),
            ("plate-linuxcnc", {"kerf_by": "none", "lead": "none"}), ("table-simotion", {}),
        )
    ),
)  # fmt: skip
COLOURS = {"red": "cut", "magenta": "cut", "blue": "mark", "notes": "ignore"}
Point = tuple[float, float]


def lines(*points: Point, closed: bool = True) -> tuple[Curve, ...]:
    """Lines from point to point, and back to the first."""
    ends = [*points[1:], points[0]] if closed else points[1:]
    return tuple(Line(a, b) for a, b in zip(points, ends, strict=False))


def contour(
    curves: tuple[Curve, ...], colour: str, layer: str = "", process: Process = "cut"
) -> Contour:
    closed = curves[0].start == curves[-1].end
    kind = "outer" if closed else "open"
    return Contour(
        "v", kind, curves, SOURCE, process, closed, layer=layer or None, colour=colour
    )  # fmt: skip


def drawing() -> Part:
    """Two parts, one in a hole of the other, lines, what is drawn twice and what is mapped away."""
    outline = lines((0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0))
    features = (
        contour(outline, "#ff0000"),
        contour((Arc((22.0, 20.0), 15.0, 0.0, 360.0),), "#ff0000"),
        contour(lines((17.0, 16.0), (27.0, 16.0), (27.0, 24.0), (17.0, 24.0)), "#ff0000"),
        contour(lines((45.0, 8.0), (55.0, 12.0), closed=False), "#ff0000"),
        contour(lines((45.0, 28.0), (55.0, 32.0), closed=False), "#0000ff"),
        contour(lines((10.0, 0.0), (30.0, 0.0), closed=False), "#ff0000"),
        contour(lines((5.0, 5.0), (50.0, 36.0), closed=False), "#00ff00", "notes"),
    )
    return part_of(features, Measures())


def filled() -> Part:
    """A plate with holes of two colours, and what is filled beside them."""
    outline = lines((0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0))
    features = (
        contour(outline, "#ff0000"),
        contour((Arc((16.0, 24.0), 8.0, 0.0, 360.0),), "#ff0000"),
        contour((Arc((44.0, 28.0), 5.0, 0.0, 360.0),), "#ff00ff"),
        contour(lines((32.0, 5.0), (52.0, 5.0), (48.0, 16.0), (32.0, 16.0)), "#0000ff"),
    )
    return part_of(features, Measures())


def plate() -> Part:
    """A plate of DSTV: holes, a slot, a centre, a punched line and lettering."""
    features = (
        Hole("v", 12.0, 12.0, 8.0, SOURCE),
        Slot("v", 32.0, 26.0, 8.0, 10.0, 0.0, 0.0, SOURCE),
        Hole("v", 48.0, 10.0, 0.0, SOURCE, kind="mark"),
        replace(contour(lines((6.0, 34.0), (20.0, 34.0), closed=False), "", process="punch"),
                colour=None),
        TextMark("v", 6.0, 6.0, 0.0, 5.0, "P1", SOURCE),
    )  # fmt: skip
    return part_of(features, None)


def across() -> Iterator[tuple[str, Part, Part]]:
    """Drawings of lines at equal distances, and others that have more on places of theirs."""
    blue = "#0000ff"
    outline = contour(lines((0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)), "#ff0000")
    grid = [
        contour(lines((20.0 + k, 6.0), (20.0 + k, 34.0), closed=False), blue) for k in range(13)
    ]
    ring = contour(lines((20.0, 20.0), (26.0, 26.0), (32.0, 20.0), (26.0, 14.0)), blue)
    line = contour(lines((20.0, 20.0), (32.0, 20.0), closed=False), blue)
    dashes = [
        contour(lines((10.0 + 4 * k, 20.0), (12.0 + 4 * k, 20.0), closed=False), blue)
        for k in range(7)
    ]
    whole = contour(lines((10.0, 20.0), (36.0, 20.0), closed=False), blue)
    for name, few, many in (
        ("a ring across lines", grid, [*grid, ring]),
        ("a line across lines", grid, [*grid, line]),
        ("a broken line joined", dashes, [whole]),
    ):
        yield name, part_of((outline, *few), Measures()), part_of((outline, *many), Measures())


def part_of(features: Sequence[object], measures: Measures | None) -> Part:
    profile = Profile("B", "", 40.0, 0.0, 0.0, 3.0)
    return Part("P1", profile, 60.0, SOURCE, features=tuple(features), measures=measures)  # type: ignore[arg-type]


def lies(plan: SheetPlan, torch: Torch) -> Iterator[tuple[str, SheetPlan]]:
    """Plans that are not true, each with what it is."""
    for at, op in enumerate(plan.operations):
        before, after = plan.operations[:at], plan.operations[at + 1 :]
        kind = op.row.process
        dropped = replace(plan, operations=(*before, *after))
        for how, by in (*REASONS, ("skipped", "plan-tiny"), ("duplicate", "plan-overlap")):
            yield f"{kind} dropped", _excused(dropped, op, how, by)
        yield f"{kind} doubled", replace(plan, operations=(*before, op, op, *after))
        for name, other in _altered(op, torch):
            yield f"{kind} {name}", replace(plan, operations=(*before, other, *after))
    backwards = replace(plan, operations=tuple(reversed(plan.operations)))
    yield "sheet in another order", backwards
    away = tuple(_moved(op, 1.0) for op in plan.operations)
    yield "sheet moved", replace(plan, operations=away)


def _excused(plan: SheetPlan, op: ContourOp, how: str, by: str) -> SheetPlan:
    """The plan that says of an operation's features that they are not there, and why."""
    outcomes = tuple(
        Outcome(o.feature, how, by) if o.feature in op.features else o  # type: ignore[arg-type]
        for o in plan.outcomes
    )
    return replace(plan, outcomes=outcomes)


def _altered(op: ContourOp, torch: Torch) -> Iterator[tuple[str, ContourOp]]:
    """An operation made otherwise."""
    tolerance, tab_width, overcut = torch.tolerance, torch.tab_width, torch.overcut
    yield "moved", _moved(op, 1.0)
    yield "moved by twice the tolerance", _moved(op, 2 * tolerance)
    last = op.passes[-1]
    if len(last.curves) > 1:
        short = Pass(last.lead_in, last.curves[:-1], ())
        yield "cut short", replace(op, passes=(*op.passes[:-1], short))

    yield from _settled_otherwise(op)
    if len(op.passes) > 1 and op.row.passes == 1:
        yield from _bridged_otherwise(op, tab_width)
    if overcut and op.closed and op.row.process == "cut" and op.side == "on":
        own = torch.settings.get("red")
        over = overcut if own is None or own.overcut is None else own.overcut
        for name, by in (
            ("without overcut", -over), ("overcut too short", -over / 2), ("overcut too long", 1.0),
        ):  # fmt: skip
            yield name, _cut_again(op, by)
        yield "overcut off the contour", _cut_aside(op, over / 2)


def _settled_otherwise(op: ContourOp) -> Iterator[tuple[str, ContourOp]]:
    """An operation with a pass less or more, another speed, another power."""
    if op.row.passes > 1:
        yield "a pass missing", replace(op, passes=op.passes[:-1])
        yield "a pass too many", replace(op, passes=(*op.passes, op.passes[-1]))
    yield "slower", replace(op, row=replace(op.row, feed_mm_min=op.row.feed_mm_min * 0.9))
    yield "at less power", replace(op, row=replace(op.row, power=op.row.power * 0.9))


def _bridged_otherwise(op: ContourOp, width: float) -> Iterator[tuple[str, ContourOp]]:
    """An operation whose bridges are cut through, wider, narrower, or one more."""
    first, second, *more = op.passes
    (ax, ay), (bx, by) = first.curves[-1].end, second.curves[0].start
    half = (ax + bx) / 2, (ay + by) / 2
    through = (*first.curves, Line((ax, ay), (bx, by)), *second.curves)
    yield "bridge cut through", replace(op, passes=(replace(second, curves=through), *more))
    into = replace(first, curves=(*first.curves, Line((ax, ay), half)))
    yield "bridge narrower", replace(op, passes=(into, second, *more))
    lengths = [curve.length for curve in second.curves]
    total = sum(lengths)
    later = replace(second, curves=stretch(second.curves, lengths, 0.4 * width, total))
    yield "bridge wider", replace(op, passes=(first, later, *more))
    parts = [
        replace(second, curves=stretch(second.curves, lengths, a, b))
        for a, b in ((0.0, (total - width) / 2), ((total + width) / 2, total))
    ]
    yield "bridge more", replace(op, passes=(first, *parts, *more))


def _cut_again(op: ContourOp, by: float) -> ContourOp:
    """An operation that goes on along its contour by more or less."""
    *others, last = op.passes
    lengths = [curve.length for curve in last.curves]
    if by < 0.0:
        curves = stretch(last.curves, lengths, 0.0, sum(lengths) + by)
    else:
        (x, y), (tx, ty) = last.curves[-1].end, last.curves[-1].tangent(1.0)
        curves = (*last.curves, Line((x, y), (x + by * tx, y + by * ty)))
    return replace(op, passes=(*others, Pass(last.lead_in, curves, ())))


def _cut_aside(op: ContourOp, by: float) -> ContourOp:
    """An operation whose overcut leaves its contour."""
    *others, last = op.passes
    lengths = [curve.length for curve in last.curves]
    (x, y), (tx, ty) = last.curves[-1].end, last.curves[-1].tangent(1.0)
    curves = stretch(last.curves, lengths, 0.0, sum(lengths) - by)
    aside = Line(curves[-1].end, (x - by * ty, y + by * tx))
    return replace(op, passes=(*others, Pass(last.lead_in, (*curves, aside), ())))


def _moved(op: ContourOp, by: float) -> ContourOp:
    passes = tuple(
        Pass(
            *(
                tuple(_shifted(c, by) for c in curves)
                for curves in (p.lead_in, p.curves, p.lead_out)
            )
        )
        for p in op.passes
    )
    return replace(op, passes=passes)


def _shifted(curve: Curve, by: float) -> Curve:
    """A curve farther along x and y."""
    return curve.transformed(((1.0, 0.0, by), (0.0, 1.0, by)))


def told(machines: Sequence[tuple[str, dict[str, object]]] = MACHINES, every: int = 1) -> Lies:
    """Every lie (or each `every`-th) about sheets of all machines, posted through the pipeline."""
    result = Lies(Counter(), Counter(), [])
    count = 0

    def tell(machine: str, lie: str, caught: bool) -> None:
        result.made[lie] += 1
        result.caught[lie] += caught
        if not caught:
            result.missed.append((machine, lie))

    for name, values in machines:
        shown = _shown(name, values)
        machine = with_torch(load(name), colours=COLOURS, allow_open=True, **values)  # type: ignore[arg-type]
        assert machine.torch is not None
        is_filled = any(own.hatch for own in machine.torch.settings.values())
        for part in (filled(),) if is_filled else (drawing(), plate()):
            job, plan = _planned(part, machine)
            truth = _text(plan, job)
            if machine.controller not in TABLE_CONTROLLERS:
                for lie, caught in _out_of_radius(job):
                    tell(shown, lie, caught)
            for lie, false in lies(plan, machine.torch):
                if lie.endswith("slower") and machine.controller in TABLE_CONTROLLERS:
                    continue  # a chord may take as long as the cycles of the controller need
                count += 1
                if count % every == 0 and _text(false, job) != truth:
                    tell(shown, lie, _is_refused(false, job))
        for lie, job, false in () if is_filled else _drawn_otherwise(machine):
            count += 1
            if count % every == 0:
                tell(shown, lie, _is_refused(false, job))
    return result


def _planned(part: Part, machine: Machine) -> tuple[Job, SheetPlan]:
    """The job of a part and its plan."""
    job = pipeline.whole_job(Request((part,), machine, SKIP_NAMES))
    plan = post_of(machine).plan(job)
    assert isinstance(plan, SheetPlan)
    return job, plan


def _drawn_otherwise(machine: Machine) -> Iterator[tuple[str, Job, SheetPlan]]:
    """Jobs whose plan has the operations of another drawing."""
    for name, few, many in across():
        (less, less_plan), (more, more_plan) = _planned(few, machine), _planned(many, machine)
        yield name, less, replace(less_plan, operations=more_plan.operations)
        yield f"{name}: not made", more, replace(more_plan, operations=less_plan.operations)


def _out_of_radius(job: Job) -> Iterator[tuple[str, bool]]:
    """Arcs below the least radius and above the greatest, driven all the same; whether refused."""
    machine, true = job.machine, post_of(job.machine)
    torch = machine.needed(machine.torch, "torch")
    for name, key, radius in (("tight", "min_radius", 50.0), ("wide", "max_radius", 2.0)):
        strict = replace(machine, torch=replace(torch, **{key: radius}))
        row = replace(true, motion=lambda plan, _, name: true.motion(plan, machine, name))
        with patch.object(pipeline, "post_of", lambda _, row=row: row):
            try:
                pipeline.post(job.parts, strict, skips=job.request.skips)
            except VerifyError as error:
                yield (
                    f"arc too {name}",
                    "verify-sheet-radius" in {d.code for d in error.diagnostics},
                )
            else:
                yield f"arc too {name}", False


def _shown(name: str, values: dict[str, object]) -> str:
    return " ".join([name, *(f"{key}={value}" for key, value in values.items())])


def _text(plan: SheetPlan, job: Job) -> str | bytes:
    """What stands in the file of a plan."""
    row = post_of(job.machine)
    written: Written = row.emit(row.motion(plan, job.machine, job.request.name), job)
    return written if isinstance(written, str) else b"".join(written())


def _is_refused(false: SheetPlan, job: Job) -> bool:
    """Whether the pipeline refuses what a planner makes up for a job."""
    row = replace(post_of(job.machine), plan=lambda _: false)
    with patch.object(pipeline, "post_of", lambda _: row):
        try:
            pipeline.post(job.parts, job.machine, skips=job.request.skips)
        except VerifyError:
            return True
        except PlanError as error:
            raise AssertionError("a lie that the planner refuses") from error
    return False
