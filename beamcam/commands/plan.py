"""`beamcam plan`: the work that makes parts, step by step, with the reasons and the time."""

from collections.abc import Iterable, Iterator
from typing import Any

import click

from beamcam.commands import options
from beamcam.commands.common import Console, Grouped, write
from beamcam.commands.common import as_json as json_of
from beamcam.commands.outputs import of_kind
from beamcam.commands.parts import looking_options, read_parts, request_of
from beamcam.commands.plan_output import (
    coping_lines,
    coping_record,
    not_made_lines,
    sheet_lines,
    sheet_record,
)
from beamcam.commands.settings import files_read, machines_for, settled
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, Diagnostic
from beamcam.files import FilesRead
from beamcam.machine.machine import Machine
from beamcam.machine_choice import on_best_machine
from beamcam.model.part import Part
from beamcam.model.plan import (
    Order,
    Plan,
    SheetPlan,
    ToolLoad,
)
from beamcam.model.request import Request
from beamcam.pipeline import Planned, remarks_on, whole_job
from beamcam.plain_text import terminal_text
from beamcam.planning.beam import Trial, try_turns
from beamcam.planning.explain import Explanation, explain
from beamcam.planning.stock import from_store
from beamcam.posts import post_of
from beamcam.reports.run import as_message, ledger_of


@click.command("plan", cls=Grouped)
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
    inputs: tuple[str, ...],
    output: str,
    order: Order,
    turn: bool,
    as_json: bool,
    console: Console,
    **asked: Any,
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
    said: tuple[Diagnostic, ...] = ()
    as_json = as_json or output.lower().endswith(".json")
    try:
        config = settled(asked, inputs)
        parts, said = read_parts(inputs, config, asked, console)
        machines = machines_for(config, parts, output)
        request = request_of(parts, config, machines[0], asked["quantity"], order, turn)
        (planned,), choice = on_best_machine(request, machines, _planned)
        job, plan, machine = planned.job, planned.plan, planned.job.machine
        console.remark(choice)
        remarks = (*said, *remarks_on(plan, machine, config.strict))
        read = files_read(config, inputs)
        if not isinstance(plan, Plan):
            kind = post_of(machine)
            time = kind.time(plan, kind.motion(plan, machine, config.job), machine)
            if isinstance(plan, SheetPlan):
                lines, record = (
                    sheet_lines(plan, time, machine), sheet_record(plan, time, machine, remarks)
                )  # fmt: skip
                console.did(f"planned a sheet on {machine.name}")
            else:
                lines, record = (
                    coping_lines(plan, time, machine), coping_record(plan, time, machine, remarks)
                )  # fmt: skip
                console.did(f"planned a part on {machine.name}")
            _print(output, read, console, as_json, lines, record, remarks, config, machine)
            return
        turned = dict.fromkeys(job.parts) if turn else ()  # each once, however often it is made
        skips = job.request.skips
        trials = [(part, tuple(try_turns(part, machine, skips))) for part in turned]
    except BeamcamError as error:
        console.stop((*said, *error.diagnostics))
    console.did(f"planned {len(plan.operations)} operation(s): {ledger_of(plan.outcomes)}")
    explained = explain(plan, machine)
    record = plan_record(plan, explained, machine, trials, remarks)
    lines = plan_lines(plan, explained, machine, trials)
    _print(output, read, console, as_json, lines, record, remarks, config, machine)


def _planned(request: Request) -> list[Planned]:
    """All that is asked for on one bar or sheet. Raises PlanError."""

    def planned(bar: float | None) -> Planned:
        job = whole_job(request, bar)
        return Planned(job, post_of(request.machine).plan(job))

    longest = max((part.length for part in request.parts), default=0.0)
    return [from_store(planned, request.stock, longest)]


def _print(
    output: str,
    read: FilesRead,
    console: Console,
    as_json: bool,
    lines: Iterable[str],
    record: dict[str, object],
    said: tuple[Diagnostic, ...],
    config: Config,
    machine: Machine,
) -> None:
    if as_json:
        from beamcam.commands.configuration import used

        record["settings"] = used(config, machine)
        write(output, json_of(record) + "\n", console, read)
    else:
        write(output, "\n".join(map(terminal_text, lines)) + "\n", console, read)
        console.say(said)


Trials = list[tuple[Part, tuple[Trial, ...]]]


def plan_lines(
    plan: Plan, explained: Explanation, machine: Machine, trials: Trials
) -> Iterator[str]:
    """The plan as text."""
    yield f"machine {machine.name}: {machine.title}"
    yield from _bar_lines(plan, trials)
    for loaded in explained.loads:
        yield _load_line(loaded)
    yield from _step_lines(explained)
    yield from not_made_lines(plan)
    yield (
        f"{len(plan.operations)} operations, {explained.changes} changes of spindle or tool, "
        f"bar {explained.forward:.1f} mm forward and {explained.back:.1f} mm back, "
        f"{explained.total_s:.0f} s"
    )


def _bar_lines(plan: Plan, trials: Trials) -> Iterator[str]:
    """The account of the bar, where each part lies on it, and how else it was tried."""
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


def _step_lines(explained: Explanation) -> Iterator[str]:
    """The operations with the codes of their reasons, and what the codes mean."""
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


def _load_line(loaded: ToolLoad) -> str:
    into = f"{loaded.spindle} station {loaded.station}: {loaded.tool.name}"
    if loaded.out is None:
        return f"tool {into}"
    return f"change before step {loaded.before + 1}, {into} for {loaded.out.name}"


def plan_record(
    plan: Plan,
    explained: Explanation,
    machine: Machine,
    trials: Trials,
    said: tuple[Diagnostic, ...],
) -> dict[str, object]:
    """The plan as data."""
    bar = plan.bar
    return {
        "machine": machine.name,
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
        "features": [
            {"part": o.feature[0], "feature": o.feature[1], "how": o.how, "by": o.by}
            for o in plan.outcomes
        ],
        "changes": explained.changes,
        "travel": {"forward": explained.forward, "back": explained.back},
        "time": {
            "manual_changes_s": round(explained.manual_changes_s, 3),
            "total_s": round(explained.total_s, 3),
        },
        "messages": [as_message(d) for d in said],
    }  # fmt: skip
