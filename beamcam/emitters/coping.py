"""Programs of copers: the machine's word templates, filled in."""

from collections.abc import Iterator, Mapping

from beamcam.emitters.gcode import number
from beamcam.machine.machine import Machine
from beamcam.model.description import PART_DATA
from beamcam.model.program import (
    Command,
    Comment,
    Program,
    StartProfile,
    ToolOff,
    ToolOn,
    TorchRound,
    TorchTo,
    TurnTorch,
)
from beamcam.plain_text import comment_text

INVERSE_DECIMALS = 4  #: of a time's inverse, 1/min


def emit(program: Program, machine: Machine) -> str:
    """The text of a program, with a newline at its end."""
    about = {name: comment_text(program.about.get(name, "")) for name in PART_DATA}
    lines = [
        block for command in program.commands for block in _blocks(command, program, machine, about)
    ]
    return "\n".join([*lines, *machine.words.footer]) + "\n"


def _blocks(
    command: Command, program: Program, machine: Machine, about: Mapping[str, str]
) -> Iterator[str]:
    words, places = machine.words, machine.format.length_decimals
    degrees = machine.format.angle_decimals
    template: tuple[str, ...] = ()
    values: Mapping[str, str] = about
    if isinstance(command, TorchRound | TorchTo | TurnTorch):
        values = {axis: number(getattr(command, axis), places) for axis in "xyz"}
    match command:
        case TorchRound(a_deg=a_deg, b_deg=b_deg):
            template = words.feed if b_deg is None else words.feed_turning
            turned = number(a_deg, degrees), "0" if b_deg is None else number(b_deg, degrees)
            inverse = number(command.per_minute, INVERSE_DECIMALS)
            values = {**values, "a": turned[0], "b": turned[1], "inverse": inverse}
        case TorchTo(rapid=rapid):
            template = words.traverse if rapid else words.feed
        case TurnTorch(a_deg=a_deg, b_deg=b_deg):
            template = words.turn
            values = {**values, "a": number(a_deg, degrees), "b": number(b_deg, degrees)}
        case ToolOn():
            template = words.cut_on
            values = {
                **about,
                "feed": number(command.feed_mm_min, 3), "power": number(command.power, 3),
                "pierce": number(command.pierce_s, 3),
                "pierce_height": number(command.pierce_height, 3),
                "cut_height": number(command.cut_height, 3),
            }  # fmt: skip
        case ToolOff():
            template = words.cut_off
        case Comment():
            template = (words.comment,)
            values = {"text": comment_text(command.text)}
        case StartProfile():
            template = (*words.header, *words.measured_height, *words.measured_width)
            values = {
                **about, "job": comment_text(program.job), "height": number(command.height, 3),
                "width": number(command.width, 3),
            }  # fmt: skip
        case _:
            raise TypeError(f"a coper has no command {type(command).__name__}")
    for line in template:
        yield line.format_map(values)
