"""`beamcam post`: parts in, a program out."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import Any

import click
from msgspec.structs import replace

from beamcam.commands import options
from beamcam.commands.common import (
    STANDARD,
    Console,
    is_coded_sheet,
    keep_apart,
    keep_refused,
    outputs,
    program,
    table_style,
    write,
)
from beamcam.commands.parts import drawing_choice, part_options, read_parts, request_of
from beamcam.commands.settings import files_read, machine_asked, machines_for, map_remarks, settled
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, Diagnostic, PlanError, Source
from beamcam.files import REFUSED_SUFFIX, FilesRead, remove_made
from beamcam.machine.machine import Machine
from beamcam.machine.tables import DIALECTS
from beamcam.model.part import Contour, Hole, Slot, TextMark
from beamcam.model.plan import (
    AnyPlan,
    CopePlan,
    SawOp,
    SheetPlan,
    clock,
    left_out_sources,
    manual_work_sources,
)
from beamcam.model.request import Request, are_flats, stock_of
from beamcam.pipeline import (
    NOT_MADE,
    Begun,
    Posted,
    RefusedProgram,
    StrictError,
    begin,
    finished,
    read_file,
    untold,
)

OF_ONE = "--rest is for the programs of one part of a bar, as it was read: without --turn."
NOT_WHOLE = "faces-dxf"  #: the format that holds no more than the faces of a part

rest_option = click.option(
    "--rest", "rest_name", type=options.FILE, metavar="FILE",
    help="Write what the program does not make of its part too, for the next machine.",
)  # fmt: skip


@click.command("post", cls=options.Grouped)
@options.inputs
@options.output("The program's file; - is standard output.", kind=program)
@options.machine
@options.by
@options.config
@options.bar
@options.quantity
@options.job_name
@options.job_date
@options.skips
@options.exit_left_out
@options.order
@options.style
@options.turn
@options.from_operation("Write only the remainder of the program, from operation N of `plan`.")
@click.option(
    "--frame",
    type=options.FILE,
    metavar="FILE",
    help="Write a program too that leads the head round the work, its tool off.",
)
@rest_option
@options.from_contour("Write only the rest of a sheet's program, from contour N of `plan`.")
@part_options
@options.no_verify
@options.strict
@options.json_messages
@options.verbosity
def command(
    inputs: tuple[str, ...], output: str, style: str | None, first: int | None,
    contour: int | None, frame: str | None, rest_name: str | None, no_verify: bool,
    exit_left_out: int | None, as_json: bool, console: Console, **values: Any,
) -> None:  # fmt: skip
    """Turn parts into a machine program.

    Several INPUTs are laid on one bar in the order given; an input named twice is made twice. With
    --quantity each is made as often as its file or the option says, on as many bars as they need
    (first fit), a program each: NAME-1, NAME-2, and so on. Plates lie on a sheet (--sheet) in rows
    by their boxes, in the order given, on as many sheets as they need. Without --machine the first
    machine that makes all parts is taken, with --by time the quickest: for bars beamline, then
    beamline-pusher, and for what neither saws and drills coper-linuxcnc, coper-tilt-linuxcnc and
    tube-linuxcnc; for sheets, by the suffix of the output, plate-linuxcnc, then plate-oxyfuel
    (.ngc), plate-codesys (.gcode), laser-grbl (.nc), plate-mach3 (.tap), table-simotion (.st) or
    laser-stepper (.steps, .csv, .bin, .h), and for flats that none of these cuts the lines. Nothing
    is written unless everything can be made.

    After a stop in mid bar --from-operation writes the rest of the program: its head says in which
    state the machine has to be, and it is read back as the continuation of what was done. So does
    --from-contour for a sheet: what is cut stays cut, marks are left out.

    --rest writes what the program leaves of its part for the next machine, as DSTV or JSON.

    \b
    beamcam post gasket.dxf -o gasket.ngc --map blue=cut --thickness 3
    beamcam post M58.nc1 -o job.gcode
    beamcam post M74.nc1 M58.nc1 M74.nc1 --machine beamline-annex -o job.gcode
    beamcam post M58.nc1 --bar 12000 -o - | less
    beamcam post M74.nc1 M58.nc1 --quantity file --bar 12000 -o job.gcode
    beamcam post model.ifc --mark B12 -o b12.gcode
    beamcam post M58.nc1 --from-operation 7 -o rest.gcode
    beamcam post M58.nc1 --allow-skips cope --rest left.nc1 -o M58.gcode
    beamcam post gasket.dxf --thickness 3 --from-contour 4 -o rest.ngc
    beamcam post gasket.dxf --thickness 3 -o gasket.ngc --frame frame.ngc
    """
    request: Request | None = None
    strict = bool(values["strict"])
    try:
        config = settled(values, inputs)
        strict = config.strict
        parts = read_parts(inputs, config, values, console)
        machines = machines_for(config, parts, output)
        if contour is not None or frame is not None:
            coded = any(map(is_coded_sheet, machines))
            options.refuse_usage(
                (contour is not None and not coded, options.ONE_SHEET),
                (frame == output, "--frame and -o name one file; expected two."),
                (frame and not coded, "--frame is for programs of sheets, in G-code."),
            )
        console.messages += map_remarks(config, parts, machines[0])
        request = request_of(parts, config, machines[0], config.quantity, values)
        request = replace(request, verified=not no_verify, date=values["date"] or "")
        stage = console.did if console.verbose else untold

        def planned(request_of_machine: Request) -> list[Begun]:
            name = _job_name(config, request_of_machine.machine, output)
            form = table_style(request_of_machine.machine, output, style)
            return begin(replace(request_of_machine, name=name, style=form), stage=stage)

        from beamcam.arguments import on_best_machine

        begun, choice = on_best_machine(request, machines, planned)
        console.messages += choice
        names = options.program_names(output, len(begun))
        made = [(n, finished(one, stage)) for n, one in zip(names, begun, strict=True)]
        if first is not None or contour is not None:
            made = [(output, _remainder(made, first, contour))]
        beside = _beside(made, frame, rest_name, console)
    except RefusedProgram as error:
        from beamcam.batch import KEPT

        kept = (*keep_refused(output, error.pieces(), files_read(config, inputs)),)
        is_kept = any(one.code == KEPT.code for one in kept)
        faults = error.named(output + REFUSED_SUFFIX) if is_kept else error.diagnostics
        console.stop((*faults, *kept))
    except StrictError:
        raise
    except PlanError as error:
        way = () if request is None else (_suggestion(request, machines, config, values),)
        console.stop((*error.diagnostics, *way))
    except BeamcamError as error:
        from beamcam.suggestions import reading_suggestions

        ways = tuple(reading_suggestions(error.diagnostics, read_file, strict))
        console.stop((*error.diagnostics, *ways))
    _write(made, beside, files_read(config, inputs), console)
    console.say(dict.fromkeys(one for _, each in made for one in each.remarks))
    for name, each in made if console.for_people else ():
        console.tell(success(name, each, first or contour))
    if exit_left_out is not None and any(
        remark.code in NOT_MADE for _, each in made for remark in each.remarks
    ):
        raise SystemExit(exit_left_out)


def _job_name(config: Config, machine: Machine, output: str) -> str:
    """The name of a job: of a trigger program that was given none that of its file.

    Its units are files and variables of one project, and would be taken for those of another job.
    """
    if machine.controller in DIALECTS and "job" not in config.sources and output != STANDARD:
        return PurePath(output).stem
    return config.job


def _suggestion(
    request: Request, tried: Sequence[Machine], config: Config, options: Mapping[str, Any]
) -> Diagnostic:
    """What could be asked for instead, of the machines that are shipped for such stock."""
    from beamcam.machine import shipped
    from beamcam.suggestions import suggestions

    known = {machine.name for machine in tried}
    others = [machine_asked(name, config) for name in shipped() if name not in known]
    stocks = {tried[0].stock, *(stock_of(request.parts, flat) for flat in (True, False))}
    if are_flats(request.parts):
        stocks.add("beam")
    if "beam" in stocks:
        stocks.add("profile")
    alike = [one for one in others if one is not None and one.stock in stocks]
    how = drawing_choice(options, config)
    read = None if how.get("units") else lambda path, **other: read_file(path, **{**how, **other})
    return suggestions(request, tried, alike, read)


def _remainder(
    made: Sequence[tuple[str, Posted]], first: int | None, contour: int | None
) -> Posted:
    """That of the only program, from an operation of a bar or a contour of a sheet on.

    Raises PlanError and RefusedProgram.
    """
    from beamcam.remainder import rest_of, rest_of_sheet

    (_, posted), *others = made
    options.refuse_usage(
        (None not in (first, contour), "--from-operation and --from-contour exclude each other."),
        (contour is not None and others, options.ONE_SHEET),
        (first is not None and (others or posted.job.machine.stock != "beam"), options.ONE_BAR),
    )
    if first is not None:
        return rest_of(posted, first)
    assert contour is not None
    return rest_of_sheet(posted, contour)


def _beside(
    made: Sequence[tuple[str, Posted]], frame: str | None, rest_name: str | None, console: Console
) -> list[tuple[str, str]]:
    """The frame of each program, and what the only one leaves of its part, by names of files.

    Raises BeamcamError as `frame_of` and `rest_of_part` do, UsageError for what has no rest.
    """
    beside: list[tuple[str, str]] = []
    if frame is not None:
        from beamcam.remainder import frame_of

        frames = options.program_names(frame, len(made))
        beside += ((n, frame_of(one).text) for n, (_, one) in zip(frames, made, strict=True))
    if rest_name is None:
        return beside
    from beamcam.commands.convert import target_of
    from beamcam.rest_part import NO_REST, REST, rest_of_part
    from beamcam.writers import TARGETS

    posted = made[0][1]
    target, request = target_of(rest_name, None), posted.job.request
    forms = ", ".join(s for t in TARGETS if t.name != NOT_WHOLE for s in t.suffixes)
    of_one = len(request.parts) == 1 and not request.turn and request.machine.stock != "sheet"
    options.refuse_usage(
        (target.name == NOT_WHOLE, f"--rest {rest_name!r}: expected a name in {forms}"),
        (not of_one, OF_ONE),
    )
    rest = rest_of_part(posted, target)
    if rest is None:
        console.messages.append(NO_REST.at(Source(rest_name)))
        return beside
    part, text = rest
    console.messages.append(REST.at(Source(rest_name), found=len(part.features)))
    return [*beside, (rest_name, text)]


def _write(
    made: Sequence[tuple[str, Posted]], beside: Sequence[tuple[str, str]], read: FilesRead,
    console: Console,
) -> None:  # fmt: skip
    """Write programs, lists of manual work and what else goes with them by the names of `beside`.

    None is written if one would be written over; an older list is taken away.
    """
    from beamcam.planning.manual_list import LIST_BEGIN, LIST_SUFFIX, as_csv, manual_rows

    files = [
        (name, posted, tuple(outputs(posted, posted.job.machine, name))) for name, posted in made
    ]
    paths = [path for _, _, pieces in files for path, _ in pieces]
    keep_apart((*paths, *(path for path, _ in beside)), read, console)
    for name, posted, pieces in files:
        if console.verbose:
            from beamcam.reports.run import ledger_of

            console.did(f"{posted.job.machine.name}: {ledger_of(posted.plan.outcomes)}")
        # Of a program on standard output the messages alone say what is left for manual work.
        if rows := manual_rows(posted.plan) if name != STANDARD else []:
            write(name + LIST_SUFFIX, as_csv(rows), console, read)
        elif name != STANDARD:
            remove_made(name + LIST_SUFFIX, LIST_BEGIN)
        for path, content in pieces:
            write(path, content, console, read)
    for path, text in beside:
        write(path, text.encode(), console, read)


# --- what is said of a program that is written ----------------------------------------------------

#: What a pass of a torch or laser makes, by its process.
_OF_PROCESS = {"cut": "contour", "mark": "marked line", "engrave": "engraved line", "spot": "spot"}


def success(name: str, posted: Posted, first: int | None = None) -> str:
    """`channel.gcode: 14 holes, 2 cuts, 1 bar of 12000, 33:56 min; read back: the part, exactly`.

    `name` is the program's file. `first` is the operation or contour that a remainder begins with.
    """
    plan, job = posted.plan, posted.job
    count = len(plan.operations)
    made = [*_made(plan, job.machine.saw is None)]
    made.append(clock(posted.time(job.machine).total_s))
    if first is not None:
        steps = "contours" if isinstance(plan, SheetPlan) else "operations"
        made = [f"{steps} {first} to {count} of {count}"]
    shown = "the program" if name == STANDARD else PurePath(name).name
    return f"{shown}: {', '.join(made)}; {_read_back(posted, first is not None)}"


def _made(plan: AnyPlan, comes_cut: bool) -> Iterator[str]:
    """What is made of a bar or a sheet, and which; a part that `comes_cut` is one by itself."""
    if isinstance(plan, SheetPlan):
        passes = Counter(_OF_PROCESS[op.row.process] for op in plan.operations)
        yield from (_counted(passes[kind], kind) for kind in _OF_PROCESS.values() if passes[kind])
        yield f"1 sheet of {plan.thickness:g} mm"
        return
    if isinstance(plan, CopePlan):
        yield _counted(len(plan.operations), "cut")
        begun = plan.pieces[0].part.made is not None
        yield f"1 part of {round(plan.bar, 3):g}" if begun else f"{round(plan.bar, 3):g} mm of bar"
        return
    kinds = Counter[str]()
    for outcome in plan.outcomes:
        if outcome.how in ("made", "merged"):
            piece, index = outcome.feature
            match plan.pieces[piece].part.features[index]:
                case Hole():
                    kinds["hole"] += 1
                case Slot():
                    kinds["slot"] += 1
                case TextMark():
                    kinds["text"] += 1
                case Contour(process="mark" | "engrave"):  # others and planes are made by the cuts
                    kinds["line"] += 1
    kinds["cut"] = sum(isinstance(op, SawOp) for op in plan.operations)
    for kind in ("hole", "slot", "line", "text", "cut"):
        if kinds[kind]:
            yield _counted(kinds[kind], kind)
    yield f"1 {'part' if comes_cut else 'bar'} of {round(plan.bar.length, 3):g}"


def _read_back(posted: Posted, is_rest: bool) -> str:
    """What the read-back found of a program that is not refused."""
    plan = posted.plan
    if not posted.job.request.verified:
        return "NOT read back"
    if is_rest:
        return "read back: the rest of the whole program, exactly"
    pieces = len(plan.pieces)
    parts = "the part" if pieces == 1 else f"the {pieces} parts"
    left_out = sum(1 for _ in left_out_sources(plan))
    manual_work = sum(1 for _ in manual_work_sources(plan))
    but_for = [f"{_counted(left_out, 'feature')} left out"] if left_out else []
    if manual_work:
        but_for.append(f"{_counted(manual_work, 'feature')} left for manual work")
    if isinstance(plan, CopePlan):
        from beamcam.planning.coping.rules import ROUNDED

        rounded = sum(int(one["count"]) for one in plan.remarks if one.code == ROUNDED.code)
        but_for += [f"{_counted(rounded, 'corner')} rounded"] if rounded else []
    return f"read back: {parts}{' but for ' if but_for else ', exactly'}{' and '.join(but_for)}"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
