"""`beamcam plan`: the work that makes parts, step by step, with reasons and time; text or data."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import chain, pairwise
from math import dist
from typing import Any

import click

from beamcam.arguments import on_best_machine
from beamcam.commands import options
from beamcam.commands.common import Console, write
from beamcam.commands.common import as_json as json_of
from beamcam.commands.parts import looking_options, read_parts, request_of
from beamcam.commands.settings import files_read, machines_for, settled
from beamcam.commands.value_types import of_kind
from beamcam.machine.coper import A_OF_FACE
from beamcam.model.lengths import total_length
from beamcam.model.part import Part
from beamcam.model.plan import (
    NOT_MADE,
    AnyPlan,
    ContourOp,
    CopeCut,
    CopePlan,
    Plan,
    SheetPlan,
    WorkTime,
)
from beamcam.motion.coping import NAMES
from beamcam.pipeline import begin, remarks_on
from beamcam.plain_text import terminal_text
from beamcam.planning.beam import Trial, try_turns
from beamcam.planning.explain import Explanation, explain
from beamcam.posts import post_of
from beamcam.reports.run import as_message, ledger_of


@click.command("plan", cls=options.Grouped)
@options.inputs
@options.output(
    "A .txt or .json file; standard output if not given.", required=False, kind=of_kind("plan")
)
@options.machine
@options.by
@options.config
@options.bar
@options.order
@options.turn
@looking_options
def command(
    inputs: tuple[str, ...], output: str, as_json: bool, console: Console, **values: Any
) -> None:
    """Explain the work that makes parts, step by step.

    Each operation is listed with its machine X, its tool, its time and a code for each reason: why
    this tool, why merged, why here, and what was rejected. For a sheet, each contour with its
    start, its length and its time. No program is written.

    \b
    beamcam plan M58.nc1
    beamcam plan gasket.dxf --thickness 3 --machine plate-codesys
    beamcam plan M74.nc1 M58.nc1 --machine beamline-pusher --order best --turn
    beamcam plan M58.nc1 --json | jq .time
    """
    as_json = as_json or output.lower().endswith(".json")
    config = settled(values, inputs)
    parts = read_parts(inputs, config, values, console)
    machines = machines_for(config, parts, output)
    request = request_of(parts, config, machines[0], values["quantity"], values)
    (planned,), choice = on_best_machine(request, machines, partial(begin, together=True))
    job, plan, machine = planned.job, planned.plan, planned.job.machine
    console.remark(choice)
    console.messages += remarks_on(plan, machine, config.strict)
    read = files_read(config, inputs)
    lines: Iterable[str]
    if isinstance(plan, Plan):
        turned = dict.fromkeys(job.parts) if values["turn"] else ()  # each once, however often made
        skips = job.request.skips
        trials = [(part, tuple(try_turns(part, machine, skips))) for part in turned]
        console.did(f"planned {len(plan.operations)} operation(s): {ledger_of(plan.outcomes)}")
        explained = explain(plan, machine)
        lines, record = plan_lines(plan, explained, trials), plan_record(plan, explained, trials)
        spent: dict[str, object] = {
            "changes": explained.changes,
            "travel": {"forward": explained.forward, "back": explained.back},
            "time": {
                "manual_changes_s": round(explained.manual_changes_s, 3),
                "total_s": round(explained.total_s, 3),
            },
        }
    else:
        kind = post_of(machine)
        time = kind.time(plan, kind.motion(plan, machine, config.job), machine)
        if isinstance(plan, SheetPlan):
            lines, record = sheet_lines(plan, time), sheet_record(plan, time)
        else:
            lines, record = coping_lines(plan, time), coping_record(plan, time)
        spent = {"time": {"home_s": round(time.home_s, 3), "total_s": round(time.total_s, 3)}}
        what = "sheet" if isinstance(plan, SheetPlan) else "part"
        console.did(f"planned a {what} on {machine.name}")
    if not as_json:
        lines = chain((f"machine {machine.name}: {machine.title}",), lines)
        write(output, "\n".join(map(terminal_text, lines)) + "\n", console, read)
        console.say()
        return
    from beamcam.commands.configuration import used

    messages = [as_message(one) for one in console.messages]
    console.messages.clear()
    features = [
        {"part": o.feature[0], "feature": o.feature[1], "how": o.how, "by": o.by}
        for o in plan.outcomes
    ]
    whole = {
        "machine": machine.name, **record, "features": features, **spent, "messages": messages,
        "settings": used(config, machine),
    }  # fmt: skip
    write(output, json_of(whole) + "\n", console, read)


Trials = list[tuple[Part, tuple[Trial, ...]]]


def plan_lines(plan: Plan, explained: Explanation, trials: Trials) -> Iterator[str]:
    """The account of the bar, where each part lies on it, how else it was tried, and the steps."""
    bar = plan.bar
    yield (
        f"bar {bar.length:.3f} = front trim {bar.front_trim:.3f} + parts {bar.parts:.3f} "
        f"+ kerfs {bar.kerfs:.3f} - nested {bar.nested:.3f} + remnant {bar.remnant:.3f} "
        f"+ end trim {bar.end_trim:.3f}"
    )
    for index, piece in enumerate(plan.pieces, 1):
        yield (
            f"part {index}: {piece.part.mark} from {piece.start:.3f} to {piece.end:.3f}, "
            f"{piece.turn}"
        )
    for part, tried in trials:
        for trial in tried:
            shown = trial.because if trial.seconds is None else f"{trial.seconds:.1f} s"
            yield f"  {part.mark} {trial.turn.name}: {shown}"
    for load in explained.loads:
        into = f"{load.spindle} station {load.station}: {load.tool.name}"
        before = f"change before step {load.before + 1}, {into}"
        yield f"tool {into}" if load.out is None else f"{before} for {load.out.name}"
    width = max(len(step.what) for step in explained.steps)
    place = max(len(step.where) for step in explained.steps)
    for number, step in enumerate(explained.steps, 1):
        codes = ", ".join(code for code, _ in step.reasons)
        yield (
            f"{number:4} X {step.x:10.3f}  {step.what:{width}}  {step.where:{place}} "
            f"{step.seconds:7.1f} s  {codes}"
        )
        for rejected in step.rejected:
            yield f"       not {rejected}"
    codes_used = dict(reason for step in explained.steps for reason in step.reasons)
    for code, text in sorted(codes_used.items()):
        yield f"{code}: {text}"
    yield from not_made_lines(plan)
    yield (
        f"{len(plan.operations)} operations, {explained.changes} changes of spindle or tool, "
        f"bar {explained.forward:.1f} mm forward and {explained.back:.1f} mm back, "
        f"{explained.total_s:.0f} s"
    )


def plan_record(plan: Plan, explained: Explanation, trials: Trials) -> dict[str, object]:
    """The plan as data."""
    bar = plan.bar
    return {
        "bar": {
            "length": bar.length, "front_trim": bar.front_trim, "parts": bar.parts,
            "kerfs": bar.kerfs, "nested": bar.nested, "rest": bar.remnant,
            "end_trim": bar.end_trim,
        },
        "parts": [
            {"mark": p.part.mark, "start": p.start, "end": p.end, "input": p.given, "turn": p.turn}
            for p in plan.pieces
        ],
        "turns": [
            {"mark": p.mark, "turn": t.turn.name, "seconds": t.seconds, "because": t.because}
            for p, tried in trials
            for t in tried
        ],
        "tools": [
            {
                "before": load.before, "spindle": load.spindle, "station": load.station,
                "tool": load.tool.name, "out": None if load.out is None else load.out.name,
            }
            for load in explained.loads
        ],
        "operations": [
            {
                "x": step.x, "what": step.what, "where": step.where,
                "seconds": round(step.seconds, 3), "reasons": dict(step.reasons),
                "rejected": list(step.rejected), "sources": list(step.sources),
            }
            for step in explained.steps
        ],
    }  # fmt: skip


def length_of(op: ContourOp) -> float:
    """Length that the tool follows, leads included, in mm."""
    passes = ((*one.lead_in, *one.curves, *one.lead_out) for one in op.passes)
    return sum(total_length(curves) for curves in passes)


def not_made_lines(plan: AnyPlan) -> Iterator[str]:
    """The features that no operation makes, each with the reason."""
    for outcome in plan.outcomes:
        if outcome.how in NOT_MADE:
            piece, feature = outcome.feature
            source = plan.pieces[piece].part.features[feature].source
            yield f"{NOT_MADE[outcome.how]}: {source} ({outcome.by})"


def sheet_lines(plan: SheetPlan, time: WorkTime) -> Iterator[str]:
    """The plan of a sheet as text."""
    for piece in plan.pieces:
        part, (x, y) = piece.part, piece.place
        yield (
            f"sheet {part.mark} {part.length:.3f} x {part.profile.height:.3f} x "
            f"{plan.thickness:g}, its x 0, y 0 at X {x:.3f} Y {y:.3f}"
        )
    for number, (op, seconds) in enumerate(zip(plan.operations, time.operations, strict=True), 1):
        x, y = op.start
        bridges = f", {len(op.passes)} passes" if len(op.passes) > 1 else ""
        yield (
            f"{number:4} X {x:10.3f} Y {y:10.3f}  {op.row.process:7}{length_of(op):10.1f} mm at "
            f"{op.row.feed_mm_min * op.feed_share:g} mm/min{bridges} {seconds:7.1f} s  {op.source}"
        )
    yield from not_made_lines(plan)
    yield (
        f"{len(plan.operations)} contours, {sum(map(length_of, plan.operations)):.1f} mm, home "
        f"{time.home_s:.1f} s, {time.total_s:.0f} s"
    )


def sheet_record(plan: SheetPlan, time: WorkTime) -> dict[str, object]:
    """The plan of a sheet as data."""
    sheets = [
        {
            "mark": piece.part.mark,
            "length": piece.part.length,
            "width": piece.part.profile.height,
            "thickness": plan.thickness,
            "shift": list(piece.place),
        }
        for piece in plan.pieces
    ]
    return {
        "sheet": sheets[0],
        "others": sheets[1:],  # that share the sheet
        "operations": [
            {
                "process": op.row.process, "start": list(op.start),
                "path": round(length_of(op), 6), "feed_mm_min": op.row.feed_mm_min,
                "passes": len(op.passes), "seconds": round(seconds, 3), "source": str(op.source),
            }
            for op, seconds in zip(plan.operations, time.operations, strict=True)
        ],
    }  # fmt: skip


def cut_length(cut: CopeCut) -> float:
    """Length that the torch follows, its lead included, in mm."""
    return sum(dist(a, b) for a, b in pairwise(cut.path))


def coping_lines(plan: CopePlan, time: WorkTime) -> Iterator[str]:
    """The plan of a coped part as text."""
    (piece,) = plan.pieces
    comes = f"from a bar of {plan.bar:.3f} mm at least"
    if piece.part.made is not None:
        comes = "cut to length by another machine"
    yield (
        f"part {piece.part.mark} of {plan.profile.name}, {piece.part.length:.3f} mm, {comes}, "
        f"its x 0 at X {piece.start:.3f}"
    )
    for number, (cut, seconds) in enumerate(zip(plan.operations, time.operations, strict=True), 1):
        x, y = cut.path[0]
        root = ", root" if cut.root else ", lip" if cut.lip else ""
        if cut.a_off_deg:
            root += f", A {A_OF_FACE[cut.face] + cut.a_off_deg:.3f}"
        root += f", B {cut.b_deg:.3f}" if cut.b_deg else ""
        root += ", turning" if cut.turns else ""
        yield (
            f"{number:4} face {cut.face}  {NAMES[cut.kind]:8} x {x:10.3f} y {y:8.3f} "
            f"{cut_length(cut):9.1f} mm through {cut.thickness:.1f} mm{root} at "
            f"{cut.row.feed_mm_min:g} mm/min {seconds:7.1f} s  {cut.source}"
        )
    yield from not_made_lines(plan)
    yield (
        f"{len(plan.operations)} cuts, {sum(map(cut_length, plan.operations)):.1f} mm, "
        f"{time.total_s:.0f} s"
    )


def coping_record(plan: CopePlan, time: WorkTime) -> dict[str, object]:
    """The plan of a coped part as data."""
    (piece,) = plan.pieces
    return {
        "bar": {"length": plan.bar, "start": piece.start},
        "part": piece.part.mark,
        "operations": [
            {
                "face": cut.face, "kind": cut.kind, "start": list(cut.path[0]),
                "path": round(cut_length(cut), 6), "thickness": round(cut.thickness, 6),
                "root": cut.root, "lip": cut.lip, "tilt_deg": round(cut.b_deg, 6),
                "turn_deg": round(cut.a_off_deg, 6), "turning": bool(cut.turns),
                "feed_mm_min": cut.row.feed_mm_min, "seconds": round(seconds, 3),
                "source": str(cut.source),
            }
            for cut, seconds in zip(plan.operations, time.operations, strict=True)
        ],
    }  # fmt: skip
