"""Options that commands share, each written once.

    @options.machine     is the option --machine
    @options.job         is a group of them: how a program is made

What they give comes to the command under the names that stand here; `settings.settled` lays it over
the configuration. An option that a configuration can set is None where it is not given.
"""

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from datetime import date
from functools import wraps
from math import inf, isfinite, nan
from pathlib import PurePath
from typing import Any

import click

from beamcam.commands import MORE_BARS, OUTPUT_FORMAT
from beamcam.commands.common import STANDARD, Console
from beamcam.commands.outputs import Callback
from beamcam.errors import BeamcamError, PlanError, Source
from beamcam.model.plan import ALL_SKIPS, SKIP_NAMES, named_skips
from beamcam.model.request import MARKS_FROM, numbered, remnant_of

Function = Callable[..., Any]
Decorator = Callable[[Function], Function]

NO_SKIPS = "none"
#: Whoever reads or writes it reports its failure, with a code.
FILE = click.Path(readable=False)


class Number(click.ParamType):  # type: ignore[type-arg]  # older versions take none
    """A number within limits; infinity and nan, which Python takes for numbers, are refused."""

    name = "number"

    def __init__(self, least: float = -inf, above: float = -inf, most: float = inf) -> None:
        self._least, self._above, self._most = least, above, most

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        number = nan
        with suppress(ValueError):
            number = float(value)
        if isfinite(number) and self._above < number and self._least <= number <= self._most:
            return number
        self.fail(f"found {value!r}; expected {self._expected}{_hint(str(value))}.", param, ctx)

    @property
    def _expected(self) -> str:
        limits = [f"above {self._above:g}"] if isfinite(self._above) else []
        limits += [f"{self._least:g} or more"] if isfinite(self._least) else []
        limits += [f"at most {self._most:g}"] if isfinite(self._most) else []
        return " ".join(["a number", ", ".join(limits)]).strip()


#: A number as people write it, with commas or a unit.
_WITH_UNIT = re.compile(r"([+-]?\d[\d.,]*)\s*(mm|cm|m|in|inch|ft|\"|')?")
_MM = {
    "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "inch": 25.4, "ft": 304.8,
    '"': 25.4, "'": 304.8,
}  # fmt: skip


def _hint(text: str) -> str:
    """How a number with a unit or a comma is to be written; empty for any other text."""
    match = _WITH_UNIT.fullmatch(text.strip())
    if match is None:
        return ""
    digits, unit = match.groups()
    if unit is None and "," not in digits and digits.count(".") < 2:
        return ""
    if re.fullmatch(r"[+-]?\d{1,3}(,\d{3})+(\.\d+)?", digits):
        return f", without commas: {digits.replace(',', '')}"
    number = digits.replace(",", ".")
    if number.count(".") > 1:
        return ", without signs between the digits"
    if unit is None:
        return f", with a point: {number}"
    return f", without a unit: {float(number) * _MM[unit]:g} (mm)"


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


class SkipNames(click.Choice):  # type: ignore[type-arg]  # older versions take none
    """Names of kinds of features, set off by commas."""

    name = "names"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        convert = super().convert
        return ",".join(convert(name.strip(), param, ctx) for name in str(value).split(","))


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


def _names(ctx: click.Context, param: click.Parameter, value: str | None) -> tuple[str, ...] | None:
    """The names in a list that commas set off, each once; None where there is no list."""
    if value is None:
        return None
    names = tuple(dict.fromkeys(name.strip() for name in value.split(",") if name.strip()))
    if not names:
        raise click.BadParameter(f"found {value!r}; expected names of machines.")
    return names


machines = click.option(
    "--machines", callback=_names, metavar="NAMES",
    help="Machines that make parts one after the other: names or TOML files, set off by commas.",
)  # fmt: skip
rest_as = click.option(
    "--rest-as", type=click.Choice(["nc1", "json"]), default="nc1", show_default=True,
    help="Form of the files of what one machine leaves to the next.",
)  # fmt: skip
bar = click.option(
    "--bar", type=Number(above=0), metavar="MM",
    help="Length of the bar; by default the shortest in stock, or what the parts need.",
)  # fmt: skip


bar_of_program = click.option(
    "--bar", type=Number(above=0), metavar="MM",
    help="Length of the bar; by default as the head of PROGRAM says.",
)  # fmt: skip


def _remnants(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> tuple[str, ...]:
    for value in values:
        try:
            remnant_of(value)
        except ValueError:
            raise click.BadParameter(
                f"found {value!r}; expected a length above 0, or with its section and grade, such "
                "as UPN200=4300 or UPN200/S235JR=4300"
            ) from None
    return values


remnants = click.option(
    "--remnant", "remnants", multiple=True, callback=_remnants, metavar="[SECTION[/GRADE]=]MM",
    help="A bar that is there once, used before others; may be repeated.",
)  # fmt: skip
job_name = click.option("--job", metavar="NAME", help="In the program's first line; else JOB.")


def _day(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    """A day as 2024-02-29; today's by the clock, which is looked at for nothing else."""
    if value is None:
        return None
    if value == "today":
        return date.today().isoformat()
    try:
        return date.fromisoformat(value).isoformat()
    except ValueError:
        raise click.BadParameter(
            f"found {value!r}; expected today or a day as 2024-02-29"
        ) from None


job_date = click.option(
    "--date",
    callback=_day,
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
    """Adds --quiet and --verbose, which come to the command as `console`; `as_json` counts too."""

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
        finally:
            console.end()

    return with_console


MODBUS_PORT = 502  #: of Modbus TCP, by the standard


class Address(click.ParamType):  # type: ignore[type-arg]  # older versions take none
    """HOST:PORT; the port may be left out where there is one by default."""

    name = "host:port"

    def __init__(self, port: int | None = None) -> None:
        self._port = port

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, int]:
        text = str(value)
        if self._port is not None and ":" not in text.rpartition("]")[2]:
            text = f"{text}:{self._port}"
        host, colon, port = text.rpartition(":")
        if not (colon and host and port.isdigit() and 0 < int(port) < 65536):
            self.fail(f"found {value!r}; expected HOST:PORT such as localhost:502", param, ctx)
        return host.strip("[]"), int(port)


FROM_FILE = "file"


class QuantityType(click.ParamType):  # type: ignore[type-arg]
    """`file`, or a number of pieces."""

    name = "quantity"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | int:
        if value == FROM_FILE or isinstance(value, int):
            return value  # type: ignore[no-any-return]
        if value.isascii() and value.isdigit() and 0 < int(value[:9]) <= MAX_QUANTITY:
            return int(value)
        self.fail(f"found {value!r}; expected file, or 1 to {MAX_QUANTITY}", param, ctx)


MAX_QUANTITY = 100_000
quantity = click.option(
    "--quantity", type=QuantityType(), metavar="file|N",
    help="Pieces of each part: as many as its file says, or N.",
)  # fmt: skip


def program_names(output: str, count: int) -> tuple[str, ...]:
    """The names of `count` programs. Raises PlanError for several on standard output."""
    if output == STANDARD and count > 1:
        raise PlanError(MORE_BARS.at(Source("beamcam"), found=count))
    return numbered(output, count)


ONE_BAR = "--from-operation is for the program of one bar."
ONE_SHEET = "--from-contour is for the program of one sheet, in G-code."


def from_operation(help_text: str) -> Decorator:
    """The option --from-operation."""
    return click.option(
        "--from-operation", "first", type=click.IntRange(min=2), metavar="N", help=help_text
    )


def from_contour(help_text: str) -> Decorator:
    """The option --from-contour."""
    return click.option(
        "--from-contour", "contour", type=click.IntRange(min=2), metavar="N", help=help_text
    )
