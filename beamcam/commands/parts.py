"""Shared by the commands that take parts: their options, and reading the parts."""

import re
from collections.abc import Iterable, Mapping
from typing import Any, get_args

import click

from beamcam.commands import options
from beamcam.commands.common import Console, read_all
from beamcam.commands.value_types import Number, parsed
from beamcam.config.values import Config, Origin
from beamcam.errors import Diagnostic, ReadError
from beamcam.machine.machine import Machine
from beamcam.machine.overlay import MEANINGS, Meaning
from beamcam.model.part import Part
from beamcam.model.plan import named_skips
from beamcam.model.request import Options, Quantity, Request, Selection, marked
from beamcam.pipeline import counted, parts_of
from beamcam.readers import content
from beamcam.system import cores

_DRAWING_NAMES = ("units", "width", "layers", "fit", "encoding", "wrap", "ends")


def _map(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> dict[str, Meaning] | None:
    """ "red=cut" as {"red": "cut"}; None if there is none."""
    table: dict[str, Meaning] = {}
    for value in values:
        key, _, process = value.rpartition("=")
        meaning = next((m for m in MEANINGS if m == process.strip()), None)
        if not key.strip() or meaning is None:
            from beamcam.planning.contours import rules

            raise click.BadParameter(rules.MAP.message.format(found=value))
        table[key.strip()] = meaning
    return table or None


def _fit(text: str) -> str:
    """The layer of "newton=LAYER"; "" of "newton", which the reader answers with their names."""
    method, _, layer = text.partition("=")
    if method.strip() != "newton":
        raise ValueError(text)
    return layer.strip()


def _copies(text: str) -> tuple[int, int]:
    columns, _, rows = text.partition("x")
    if not (columns.isdecimal() and rows.isdecimal() and int(columns) and int(rows)):
        raise ValueError(text)
    return int(columns), int(rows)


def _tube(text: str) -> str:
    from beamcam.readers.drawing import tube_of

    if tube_of(text) is None:
        raise ValueError(text)
    return text


def _encoding(text: str) -> str:
    "a".encode(text)  # raises LookupError too of what is no encoding of text
    return text


def _size(text: str) -> tuple[float, float]:
    match = _SIZE.fullmatch(text.strip().lower())
    if match is None or not all(float(side) > 0 for side in match.groups()):
        raise ValueError(text)
    return float(match[1]), float(match[2])


_SIZE = re.compile(r"(\d{1,6}(?:\.\d+)?)x(\d{1,6}(?:\.\d+)?)")

#: Reading options: `units`, `width`, `layers`, `fit` and `wrap` of a drawing, `encoding` and `ends`
#: of DSTV.
drawing_options = options.group(
    click.option("--units", help="Unit of a drawing's numbers: mm, in, cm, ..."),
    click.option("--width", help="Width of an SVG's page, as 600mm."),
    click.option("--layers", multiple=True, help="Read this layer only; may be repeated."),
    click.option("--fit", multiple=True, metavar="newton=LAYER",
                 callback=parsed(_fit, "newton=LAYER"),
                 help="Polylines of this layer become polynomials through their vertices."),
    click.option("--wrap", metavar="RO168.3x8",
                 callback=parsed(_tube, "diameter x wall, as RO168.3x8"),
                 help="A drawing is the unrolled surface of this round tube: diameter x wall."),
    click.option("--encoding", metavar="NAME",
                 callback=parsed(_encoding, "one such as cp1251, cp850"),
                 help="Encoding of a DSTV file, such as cp1251; detected by default."),
    click.option("--ends", type=click.Choice(["contour", "header"]),
                 help="What counts where header and contour of a DSTV file have different ends."),
)  # fmt: skip

#: The thickness of a drawing's sheet, which no drawing says.
thickness = click.option("--thickness", type=Number(), help="Thickness of a drawing's sheet, mm.")

#: Settings of a sheet and its cuts, which override the machine file; what files do not say of
#: sections.
torch_options = options.group(
    click.option("--corner", type=Number(above=0), metavar="RADIUS",
                 help="Outer corner radius of a rectangular tube, if the file has none."),
    click.option("--lip", type=Number(above=0), metavar="LENGTH",
                 help="Length of the lips of a C, if file and machine have none."),
    click.option("--map", "colours", multiple=True, callback=_map, metavar="KEY=PROCESS",
                 help="Process of a colour, a layer or all others (*): cut, mark, engrave, ignore"),
    thickness,
    click.option("--material", help="Material of the sheet, as named in the machine file."),
    click.option("--amps", type=Number(above=0), help="Rows of the cut chart for this current, A."),
    click.option("--nozzle", help="Rows of the cut chart for this nozzle or gas."),
    click.option("--kerf", type=Number(least=0), help="Width of the cut, mm."),
    click.option("--kerf-by", type=click.Choice(["none", "offset", "machine"]),
                 help="Kerf compensation: none, by offset, or by the machine."),
    click.option("--lead", type=click.Choice(["none", "line", "arc"]),
                 help="Lead-in from the pierce point to the contour."),
    click.option("--lead-in", type=Number(least=0), help="Length of a lead-in, mm."),
    click.option("--lead-out", type=Number(least=0), help="Length of a lead-out, mm."),
    click.option("--tabs", type=click.IntRange(min=0), help="Bridges in each outer contour."),
    click.option("--tab-width", type=Number(above=0), help="Width of a bridge, mm."),
    click.option("--inner-tabs/--no-inner-tabs", default=None,
                 help="As many bridges in inner contours."),
    click.option("--overcut", type=Number(least=0),
                 help="How far a closed cut goes on beyond its start, mm."),
    click.option("--gap", type=Number(above=0),
                 help="Join ends of a drawing that are as near as this, mm."),
    click.option("--allow-open/--no-allow-open", default=None,
                 help="Cut open lines, though kerf is compensated."),
    click.option("--place", type=click.Choice(["corner", "drawn"]),
                 help="Move a sheet to the corner of the table, or leave it as drawn."),
    click.option("--origin", type=click.Choice(get_args(Origin)),
                 help="Where X 0, Y 0 is: at the table's corner, or at a point of the work."),
    click.option("--mirror", type=click.Choice(["none", "x", "y"]),
                 help="x: left for right; y: top for bottom."),
    click.option("--rotate", type=click.FloatRange(-360, 360), metavar="DEGREES",
                 help="Turn the part about its middle."),
    click.option("--copies", metavar="NxM",
                 callback=parsed(_copies, "two counts such as 3x2"),
                 help="Lay out N copies side by side, in M rows."),
    click.option("--spacing", type=Number(least=0), help="Between two copies, mm."),
    click.option("--common-cuts/--no-common-cuts", default=None,
                 help="Lay parts a kerf apart and cut shared straight edges once."),
    click.option("--chain-cuts", type=Number(least=0), metavar="MM",
                 help="Longest way from one part to the next with the torch on; 0 pierces each."),
    click.option("--skeleton-cuts/--no-skeleton-cuts", default=None,
                 help="Cut what is left of the sheet between the rows of parts."),
    click.option("--sheet", "sheet_size", metavar="LxW",
                 callback=parsed(_size, "length x width in mm, as 3000x1500"),
                 help="Size of the sheet that the parts lie on, as 3000x1500; the whole table if "
                 "absent."),
    click.option("--unrolled", is_flag=True, default=None,
                 help="Cut pipes that are written as plates (PIPE...) flat."),
)  # fmt: skip


def drawing_choice(values: Mapping[str, Any], config: Config | None = None) -> dict[str, object]:
    """The options of a reader of drawings and DSTV: those of `drawing_options` that were given, or
    stand in the configuration.

    By the job's map texts on layers that are marked or engraved are lettered.
    """
    chosen = {name: values[name] for name in _DRAWING_NAMES if values[name] not in (None, ())}
    if config is not None and config.ends is not None:
        chosen.setdefault("ends", config.ends)
    colours = {} if config is None else config.map
    processes = {key: getattr(how, "process", how) for key, how in colours.items()}
    letters = tuple(key for key, how in processes.items() if how in ("mark", "engrave"))
    return chosen | {"letters": letters} if letters else chosen


# --- members --------------------------------------------------------------------------------------

# Options of the commands that take building models: which members, how far they are trusted.


#: Which members of a model are meant: `marks`, `guids`, `classes` and `assemblies`.
selection_options = options.group(
    click.option("--mark", "marks", multiple=True, help="Members of a model with this mark."),
    click.option("--guid", "guids", multiple=True, help="The member with this GlobalId."),
    click.option("--class", "classes", multiple=True, help="Members of this IFC class."),
    click.option("--assembly", "assemblies", multiple=True, help="Members of this assembly."),
)
letter = click.option(
    "--letter", type=click.Choice(["mark"]), help="Letter the members of a model with their marks."
)
#: The same, and `force`: whether they are trusted where their data contradict each other.
member_options = options.group(
    selection_options,
    click.option("--force", is_flag=True, help="Accept members with contradictory data."),
    letter,
)


def member_choice(
    values: Mapping[str, Any], kernel: bool, workers: int | None = None
) -> dict[str, object]:
    """The options of a reader of models; `kernel` has every member checked by a second route.

    So many `workers` read the members of a large model, or as many as there are cores. Two at
    least: while the kernel builds in another process, this one hears of an interrupt.
    """
    names = ("marks", "guids", "classes", "assemblies")
    return {
        "selection": Selection(*(frozenset(values[name]) for name in names)),
        "options": Options(
            values.get("force", False), kernel, letter=values.get("letter") == "mark",
            workers=workers or max(cores(), 2), apart=True,
        ),
    }  # fmt: skip


#: Which parts are meant, and how drawings and sheets are taken.
part_options = options.group(member_options, options.mark_from, drawing_options, torch_options)
#: The parts of a shop's lists and labels, and how they are laid.
list_options = options.group(
    options.skips, options.order, options.turn, options.mark_from, member_options, drawing_options,
    torch_options, options.strict, options.as_json, options.verbosity,
)  # fmt: skip
#: What a job is posted by, for commands that show what comes of it.
job_options = options.group(
    options.by, options.skips, options.order, options.turn, part_options, options.strict,
    options.json_messages,
)  # fmt: skip
#: Of a command that only looks at the work which parts are: `plan` and `verify`.
looking_options = options.group(
    options.quantity,
    options.skips,
    part_options,
    options.strict,
    options.as_json,
    options.verbosity,
)


# --- parts ----------------------------------------------------------------------------------------


def read_parts(
    inputs: Iterable[str], config: Config, options: Mapping[str, Any], console: Console
) -> tuple[Part, ...]:
    """All parts of the inputs; what is said of them is among the messages of the console.

    `options` holds the values of `part_options`. Raises ReadError.
    """
    how = drawing_choice(options, config) | member_choice(options, kernel=True)
    parts, diagnostics = parts_of(read_all(inputs, config.strict, how, console), counted)
    console.messages += diagnostics
    return marked(parts, options["mark_from"])


def request_of(
    parts: tuple[Part, ...], config: Config, machine: Machine, quantity: Quantity,
    options: Mapping[str, Any],
) -> Request:  # fmt: skip
    """What is asked for by options, of which there may be `order` and `turn`, and configuration."""
    return Request(
        parts, machine, named_skips(config.allow_skips), config.job,
        options.get("order", "given"), options.get("turn", False),
        config.stock_lengths, quantity=quantity, strict=config.strict, by=config.by,
    )  # fmt: skip


# --- programs, for the commands that read them ----------------------------------------------------


def input_bytes(path: str) -> bytes:
    """Content of a file, `-` for standard input. Raises ReadError."""
    data = content(path)
    if isinstance(data, Diagnostic):
        raise ReadError(data)
    return data


def program_text(path: str) -> str:
    """The text of a program; bytes that are no text become `\\ufffd`. Raises ReadError."""
    return input_bytes(path).decode("utf-8", "replace")
