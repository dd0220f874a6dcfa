"""Options that commands share, each written once, and the help that lists them in groups.

    @options.machine     is the option --machine
    @options.job         is a group of them: how a program is made

What they give comes to the command under the names that stand here; `settings.settled` lays it over
the configuration. An option that a configuration can set is None where it is not given.
"""

from collections.abc import Callable, Mapping, Sequence
from datetime import date
from functools import wraps
from pathlib import PurePath
from typing import Any

import click

from beamcam.commands import MORE_BARS, OUTPUT_FORMAT, value_types
from beamcam.commands.common import STANDARD, Console
from beamcam.commands.value_types import Callback, Number, SkipNames, parsed
from beamcam.errors import BeamcamError, PlanError, Source
from beamcam.model.plan import ALL_SKIPS, SKIP_NAMES, named_skips
from beamcam.model.request import MARKS_FROM, numbered, remnant_of

Function = Callable[..., Any]
Decorator = Callable[[Function], Function]

NO_SKIPS = "none"
#: Its reader or writer reports its failure, with a code.
FILE = click.Path(readable=False)


def group(*options: Decorator) -> Decorator:
    """The options as one, in this order."""

    def with_options(function: Function) -> Function:
        for option in reversed(options):
            function = option(function)
        return function

    return with_options


def _once(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    if values.count(STANDARD) > 1:
        raise click.BadParameter("found - twice; expected it once, standard input is read once.")
    return values


def _skips(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> tuple[str, ...] | None:
    """The names in order; None if none was given, () for `none`."""
    if not values:
        return None
    return named_skips({name for value in values for name in value.split(",")} - {NO_SKIPS})


def machine_names(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    from beamcam.config.values import own_files
    from beamcam.machine import shipped
    from beamcam.machine.load import own_machines

    own = own_machines(own_files())
    return [name for name in (*shipped(), *own) if name.startswith(incomplete)]


config = group(
    click.option(
        "--config", "config_file", type=FILE, metavar="FILE",
        help="Configuration, instead of each beamcam.toml beside the job, here and above.",
    ),
    click.option(
        "--trust", multiple=True, type=FILE, metavar="FOLDER",
        help="Follow a configuration in FOLDER, or below it, in full.",
    ),
)  # fmt: skip
inputs = click.argument(
    "inputs", nargs=-1, required=True, metavar="INPUT...", callback=_once, type=FILE
)
machine = click.option(
    "--machine", shell_complete=machine_names, metavar="NAME",
    help="Name or TOML file; chosen to suit the job by default.",
)  # fmt: skip
by = click.option(
    "--by", type=click.Choice(["order", "time"]),
    help="Of several machines take the first that makes a part, or the quickest; else order.",
)  # fmt: skip


def _names(text: str) -> tuple[str, ...]:
    """The names in a list that commas set off, each once."""
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise ValueError(text)
    return names


machines = click.option(
    "--machines", callback=parsed(_names, "names of machines."), metavar="NAMES",
    help="Machines that make parts one after the other: names or TOML files, set off by commas.",
)  # fmt: skip
rest_as = click.option(
    "--rest-as", type=click.Choice(["nc1", "json"]), default="nc1", show_default=True,
    help="Form of the files of what one machine leaves to the next.",
)  # fmt: skip


def _bar(default: str) -> Decorator:
    text = f"Length of the bar; by default {default}."
    return click.option("--bar", type=Number(above=0), metavar="MM", help=text)


bar = _bar("the shortest in stock, or what the parts need")
bar_of_program = _bar("as the head of PROGRAM says")


def _remnant(text: str) -> str:
    remnant_of(text)
    return text


remnants = click.option(
    "--remnant", "remnants", multiple=True, metavar="[SECTION[/GRADE]=]MM",
    callback=parsed(_remnant, "a length above 0, or with its section and grade, such as "
                    "UPN200=4300 or UPN200/S235JR=4300"),
    help="A bar that is there once, used before others; may be repeated.",
)  # fmt: skip
job_name = click.option("--job", metavar="NAME", help="In the program's first line; else JOB.")


def _day(text: str) -> str:
    """A day as 2024-02-29; today's by the clock, which is looked at for nothing else."""
    return (date.today() if text == "today" else date.fromisoformat(text)).isoformat()


job_date = click.option(
    "--date",
    callback=parsed(_day, "today or a day as 2024-02-29"),
    metavar="DAY",
    help="For {date} in the machine's words: today, or as 2024-02-29; else empty.",
)
order = click.option(
    "--order", type=click.Choice(["given", "best"]), default="given", show_default=True,
    help="Lay parts in the order given, or so that mitres nest.",
)  # fmt: skip
style = click.option(
    "--style",
    type=click.Choice(["chain", "table"]),
    help="Form of a trigger program; by default set by the machine and the length.",
)
turn = click.option("--turn", is_flag=True, help="Allow parts to be turned on the rollers.")
mark_from = click.option(
    "--mark-from", type=click.Choice(MARKS_FROM), default="mark", show_default=True,
    help="Where a part's mark stands: position is the third line of a DSTV header.",
)  # fmt: skip
skips = click.option(
    "--allow-skips", "skips", multiple=True, callback=_skips,
    type=SkipNames([*SKIP_NAMES, ALL_SKIPS, NO_SKIPS]),
    help="Leave out features of these kinds that the machine cannot make; several with commas.",
)  # fmt: skip
exit_left_out = click.option(
    "--exit-left-out",
    type=click.IntRange(1, 125),
    metavar="STATUS",
    help="Exit status if a feature is left out or left for manual work; otherwise 0.",
)
strict = click.option("--strict/--no-strict", default=None, help="Treat warnings as errors.")
no_verify = click.option(
    "--no-verify", is_flag=True, help="Do not read programs back; a comment in them says so."
)
as_json = click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
json_messages = click.option("--json", "as_json", is_flag=True, help="Print messages as JSON.")


def output(help: str, required: bool = True, kind: Callback | None = None) -> Decorator:
    """-o, by default standard output if it is not required; `kind` checks its suffix."""
    otherwise: dict[str, Any] = {} if required else {"default": STANDARD}
    return click.option(
        "-o", "--output", required=required, type=FILE, help=help, callback=kind, **otherwise
    )


def to(formats: Sequence[str]) -> Decorator:
    """--to, by default the suffix of the output."""
    return click.option(
        "--to", type=click.Choice(formats), help="Form of the output; by default by its suffix."
    )


def form_of(
    output: str, to: str | None, as_json: bool, formats: Sequence[str], otherwise: str | None = None
) -> str:
    """The form of an output: as --json or --to ask for, or by its suffix.

    On standard output it is `otherwise`. Raises BeamcamError for another suffix.
    """
    if as_json and to not in (None, "json"):
        raise click.UsageError(f"--json and --to {to} exclude each other.")
    if as_json or to:
        return to or "json"
    suffix = PurePath(output).suffix.lower().removeprefix(".")
    if output == STANDARD and otherwise is not None:
        return otherwise
    if suffix in formats:
        return suffix
    expected = ", ".join(f".{form}" for form in formats)
    raise BeamcamError(
        (OUTPUT_FORMAT.at(Source(output), found=PurePath(output).suffix, expected=expected),)
    )


def verbosity(function: Function) -> Function:
    """Adds --quiet and --verbose, which come to the command as `console`; `as_json` counts too.

    A BeamcamError of the command is said, behind the console's messages, and refuses.
    """

    @click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
    @click.option(
        "-v", "--verbose", is_flag=True, help="Print what is done, and the time it takes."
    )
    @wraps(function)
    def with_console(*args: Any, quiet: bool, verbose: bool, **values: Any) -> Any:
        if quiet and verbose:
            raise click.UsageError("--quiet and --verbose exclude each other.")
        console = Console(quiet, verbose, values.get("as_json", False))
        click.get_current_context().meta[Console.__name__] = console
        try:
            return function(*args, console=console, **values)
        except BeamcamError as error:
            console.stop(error.diagnostics)
        finally:
            console.end()

    return with_console


quantity = click.option(
    "--quantity", metavar="file|N",
    callback=parsed(value_types.quantity, f"file, or 1 to {value_types.MAX_QUANTITY}"),
    help="Pieces of each part: as many as its file says, or N.",
)  # fmt: skip


def refuse_usage(*faults: tuple[object, str]) -> None:
    """Raises UsageError with the text of the first fault that is there."""
    for is_there, text in faults:
        if is_there:
            raise click.UsageError(text)


def program_names(output: str, count: int) -> tuple[str, ...]:
    """The names of `count` programs. Raises PlanError for several on standard output."""
    if output == STANDARD and count > 1:
        raise PlanError(MORE_BARS.at(Source("beamcam"), found=count))
    return numbered(output, count)


ONE_BAR = "--from-operation is for the program of one bar."
ONE_SHEET = "--from-contour is for the program of one sheet, in G-code."


def _begins_with(option: str, name: str) -> Callable[[str], Decorator]:
    kind = click.IntRange(min=2)
    return lambda text: click.option(option, name, type=kind, metavar="N", help=text)


from_operation = _begins_with("--from-operation", "first")
from_contour = _begins_with("--from-contour", "contour")


# --- help: a command whose options stand in groups in its help ------------------------------------

MESSAGES = "What is said"
OTHER = "Other"
#: Heading -> the options below it, by the names of their values, in this order.
GROUPS: Mapping[str, tuple[str, ...]] = {
    "Job": (
        "output", "folder", "machine", "by", "machines", "config_file", "trust", "job", "bar",
        "bars", "remnants", "nest", "order", "turn", "style", "corner", "lip",
        "show", "to", "table", "quantity", "against", "mark_from", "first", "contour", "after",
        "date", "frame", "rest_name", "rest_as", "size", "code", "profile", "solid",
    ),
    "Names and folders": ("name", "flat", "done", "refused", "samples"),
    "What may be left out": ("skips", "exit_left_out", "strict", "no_verify"),
    "Members of a building model": (
        "marks", "guids", "classes", "assemblies", "force", "letter", "check"
    ),
    "How files are read": ("units", "width", "layers", "fit", "wrap", "encoding", "ends"),
    "How sheets are cut": (
        "colours", "thickness", "material", "amps", "nozzle", "kerf", "kerf_by", "lead",
        "lead_in", "lead_out", "tabs", "tab_width",
        "inner_tabs", "overcut", "gap", "allow_open", "place", "origin", "mirror", "rotate",
        "copies", "spacing", "common_cuts", "chain_cuts", "skeleton_cuts", "sheet_size", "unrolled",
    ),
    "How the work is done": (
        "jobs", "scheduler", "redo", "dry", "settle", "end_wait", "every", "encoder", "modbus",
        "serve", "pace", "once", "update",
    ),
    MESSAGES: ("as_json", "report", "unit", "paper", "quiet", "verbose", "schema"),
}  # fmt: skip
#: What matters most, in the order of use; `--help` of a command with many options shows these.
FIRST = (
    "output", "to", "machine", "machines", "folder", "against", "bar", "bars", "quantity",
    "sheet_size", "marks", "thickness", "colours", "skips", "as_json",
)  # fmt: skip
MOST_SHOWN = 20  #: options of a command whose help shows all of them


class Grouped(click.Command):
    """A command that prints its options by `GROUPS`; those of no group come last.

    Of many options `--help` shows those of `FIRST`, and `--help-all` all.
    """

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """The parameters, with --help-all where there are many."""
        params = super().get_params(ctx)
        if sum(isinstance(p, click.Option) for p in params) > MOST_SHOWN:
            text = "Show all options, in groups, and exit."
            more = click.Option(["--help-all"], is_flag=True, expose_value=False, is_eager=True,
                                help=text, callback=_show_all)  # fmt: skip
            params.append(more)
        return params

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write each group of options under its heading, or the first of them."""
        params = [p for p in self.get_params(ctx) if isinstance(p, click.Option)]
        helps = [p for p in params if {"--help", "--help-all"} & {*p.opts}]
        headings: dict[str, list[click.Option]] = {heading: [] for heading in (*GROUPS, OTHER)}
        if len(helps) == 2 and not ctx.meta.get(ALL):
            first = [p for p in params if p.name in FIRST]
            headings = {
                "Options": [*sorted(first, key=lambda p: FIRST.index(p.name or "")), *helps]
            }
        else:
            for param in params:
                headings[MESSAGES if param in helps else heading_of(param.name or "")].append(param)
        for heading, listed in headings.items():
            records = [r for r in (p.get_help_record(ctx) for p in listed) if r is not None]
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records)


ALL = "beamcam: all options"


def _show_all(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        ctx.meta[ALL] = True
        click.echo(ctx.get_help(), color=ctx.color)
        ctx.exit()


def heading_of(name: str) -> str:
    """The heading of an option, by the name of its value."""
    return next((heading for heading, names in GROUPS.items() if name in names), OTHER)
