"""`beamcam plan`: the work that makes parts, step by step, with the reasons and the time."""

import json
from collections.abc import Iterator

import click

from beamcam.commands.common import as_record, say, stop, write
from beamcam.errors import BeamcamError, Diagnostic
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import Plan, ToolLoad
from beamcam.pipeline import DEFAULT_MACHINE, parts_of, read_file
from beamcam.planning import SKIP_NAMES, plan_bar
from beamcam.planning.choose import Trial, try_turns
from beamcam.planning.explain import Explanation, explain


@click.command("plan")
@click.argument("inputs", nargs=-1, required=True, metavar="INPUT...")
@click.option("-o", "--output", default="-", help="A file; standard output if not given.")
@click.option("--machine", default=DEFAULT_MACHINE, show_default=True, help="Name or TOML file.")
@click.option("--bar", type=click.FloatRange(min=0, min_open=True), help="Length of the bar, mm.")
@click.option(
    "--order",
    type=click.Choice(["given", "best"]),
    default="given",
    show_default=True,
    help="Whether parts lie as named, or so that mitres nest.",
)
@click.option("--turn", is_flag=True, help="Let parts be turned, and list all eight ways.")
@click.option(
    "--allow-skips",
    "skips",
    multiple=True,
    type=click.Choice(SKIP_NAMES),
    help="Leave out what the machine cannot make, of this kind only; may be repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the plan and messages as JSON.")
def command(
    inputs: tuple[str, ...],
    output: str,
    machine: str,
    bar: float | None,
    order: str,
    turn: bool,
    skips: tuple[str, ...],
    as_json: bool,
) -> None:
    """Explain the work that makes parts, step by step.

    Each operation stands with its machine X, its tool, its time and a code for each reason: why
    this tool, why merged, why here, and what was rejected. No program is written.

    \b
    beamcam plan M58.nc1
    beamcam plan M74.nc1 M58.nc1 --machine beamline-pusher --order best --turn
    beamcam plan M58.nc1 --json | jq .time
    """
    try:
        loaded = load(machine)
        if loaded.saw is None or loaded.drill is None or loaded.layout is None:
            raise click.UsageError(f"{machine} has no saw and drill, whose work could be planned")
        parts, said = parts_of(read_file(path) for path in inputs)
        plan = plan_bar(parts, loaded, bar, skips, "best" if order == "best" else "given", turn)
        trials = [(part, try_turns(part, loaded, skips)) for part in _each(parts)] if turn else []
    except BeamcamError as error:
        stop(error.diagnostics, as_json)
    explained = explain(plan, loaded)
    if as_json:
        record = plan_record(plan, explained, loaded, trials, (*said, *plan.remarks))
        write(output, json.dumps(record, ensure_ascii=False, indent=1) + "\n")
    else:
        write(output, "\n".join(plan_lines(plan, explained, loaded, trials)) + "\n")
        say((*said, *plan.remarks))


Trials = list[tuple[Part, tuple[Trial, ...]]]


def _each(parts: tuple[Part, ...]) -> list[Part]:
    """Every part once, however often it is made."""
    seen: list[Part] = []
    for part in parts:
        if part not in seen:
            seen.append(part)
    return seen


def plan_lines(
    plan: Plan, explained: Explanation, machine: Machine, trials: Trials
) -> Iterator[str]:
    """The plan as text."""
    bar = plan.bar
    yield f"machine {machine.name}: {machine.title}"
    yield (
        f"bar {bar.length:.3f} = front trim {bar.front_trim:.3f} + parts {bar.parts:.3f} "
        f"+ kerfs {bar.kerfs:.3f} - nested {bar.nested:.3f} + rest {bar.rest:.3f} "
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
    for loaded in explained.loads:
        yield _load_line(loaded)
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
    made = [outcome for outcome in plan.outcomes if outcome.how == "skipped"]
    for outcome in made:
        p, f = outcome.feature
        yield f"left out: {plan.pieces[p].part.features[f].source} ({outcome.by})"
    yield (
        f"{len(plan.operations)} operations, {explained.changes} changes of spindle or tool, "
        f"bar {explained.forward:.1f} mm forward and {explained.back:.1f} mm back, "
        f"{explained.total_s:.0f} s"
    )


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
            "length": bar.length,
            "front_trim": bar.front_trim,
            "parts": bar.parts,
            "kerfs": bar.kerfs,
            "nested": bar.nested,
            "rest": bar.rest,
            "end_trim": bar.end_trim,
        },
        "parts": [
            {
                "mark": piece.part.mark,
                "start": piece.start,
                "end": piece.end,
                "input": piece.given,
                "turn": piece.turn,
            }
            for piece in plan.pieces
        ],
        "turns": [
            {"mark": p.mark, "turn": t.turn.name, "seconds": t.seconds, "because": t.because}
            for p, tried in trials
            for t in tried
        ],
        "tools": [
            {
                "before": loaded.before,
                "spindle": loaded.spindle,
                "station": loaded.station,
                "tool": loaded.tool.name,
                "out": None if loaded.out is None else loaded.out.name,
            }
            for loaded in explained.loads
        ],
        "operations": [
            {
                "x": step.x,
                "what": step.what,
                "where": step.where,
                "seconds": round(step.seconds, 3),
                "reasons": dict(step.reasons),
                "rejected": list(step.rejected),
                "sources": list(step.sources),
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
            "reloads_s": round(explained.reloads_s, 3),
            "total_s": round(explained.total_s, 3),
        },
        "messages": [as_record(d) for d in said],
    }
