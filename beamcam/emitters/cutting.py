"""Programs of cutting tables: the machine's word templates, filled in."""

from collections.abc import Iterable, Iterator

from beamcam.emitters.numbers import number
from beamcam.machine.machine import Machine
from beamcam.model.program import (
    ArcFeed,
    Comment,
    Compensate,
    EllipseFeed,
    Feed,
    Pace,
    ParabolaFeed,
    Program,
    StartSheet,
    ToolOff,
    ToolOn,
    Traverse,
)

SECONDS_PER_MINUTE = 60
RATIO_DECIMALS = 6


def emit(program: Program, machine: Machine) -> str:
    """The text of a program, with a newline at its end."""
    blocks: Iterable[str] = _blocks(program, machine)
    if machine.format.number_blocks:
        blocks = _numbered(blocks)
    return "\n".join(blocks) + "\n"


def _numbered(blocks: Iterable[str]) -> Iterator[str]:
    """Blocks with N1, N2, ... but for the lines that are not blocks (`%`) and comments."""
    count = 0
    for block in blocks:
        if block.startswith(("%", "(")):
            yield block
        else:
            count += 1
            yield f"N{count} {block}"


def _blocks(program: Program, machine: Machine) -> Iterator[str]:
    words, form = machine.words, machine.format
    places = form.length_decimals
    per_unit = SECONDS_PER_MINUTE if form.feed_unit == "mm/s" else 1
    feed = "0"
    acceleration = number(machine.torch.acceleration if machine.torch else 0.0, 3)
    carried: tuple[str, ...] = ()  # words of `modal` as they were written last
    wanted: tuple[str, ...] = ()

    def filled(template: tuple[str, ...], **values: str) -> list[str]:
        return [line.format_map(values) for line in template]

    def move(template: tuple[str, ...], **values: str) -> list[str]:
        nonlocal carried
        lines = filled(template, feed=feed, **values)
        if wanted is not carried:
            lines[-1] = " ".join((lines[-1], *(w for w in wanted if w not in carried)))
            carried = wanted
        return lines

    def modal() -> tuple[str, ...]:
        now = tuple(w.format_map({"feed": feed, "acceleration": acceleration}) for w in words.modal)
        return carried if now == carried else now

    for command in program.commands:
        match command:
            case Feed(x, y):
                yield from move(words.feed, x=number(x, places), y=number(y, places))
            case ArcFeed(x, y, i, j, clockwise):
                yield from move(
                    words.arc_cw if clockwise else words.arc_ccw,
                    x=number(x, places), y=number(y, places),
                    i=number(i, places), j=number(j, places),
                )  # fmt: skip
            case Traverse(x, y):
                yield from filled(words.traverse, x=number(x, places), y=number(y, places))
            case ToolOn():
                feed = number(command.feed_mm_min / per_unit, 3)
                carried = ()  # said again for every contour, where an operator may start anew
                wanted = modal()
                yield from filled(
                    getattr(words, f"{command.process}_on"),
                    power=number(command.power, 3), pierce=number(command.pierce_s, 3), feed=feed,
                )  # fmt: skip
            case Pace(feed_mm_min):
                feed = number(feed_mm_min / per_unit, 3)
                wanted = modal()
            case ToolOff():
                yield from filled(getattr(words, f"{command.process}_off"))
            case ParabolaFeed(x, y, i, j):
                yield from move(
                    words.parabola, x=number(x, places), y=number(y, places),
                    i=number(i, places), j=number(j, places),
                )  # fmt: skip
            case EllipseFeed():
                yield from move(
                    words.ellipse_cw if command.clockwise else words.ellipse_ccw,
                    x=number(command.x, places), y=number(command.y, places),
                    i=number(command.i, places), j=number(command.j, places),
                    angle=number(command.angle, form.angle_decimals),
                    ratio=number(command.ratio, RATIO_DECIMALS),
                )  # fmt: skip
            case Compensate():
                template = {"left": words.left, "right": words.right, "on": words.straight}
                yield from filled(
                    template[command.side],
                    kerf=number(command.kerf, 4), half_kerf=number(command.kerf / 2, 4),
                )  # fmt: skip
            case Comment():
                yield words.comment.format(text=_plain(command.text))
            case StartSheet():
                yield from filled(words.header, job=_plain(program.job))
    yield from words.footer


def _plain(text: str) -> str:
    """A text as a comment may hold it: ASCII, and no parentheses, which do not nest."""
    ascii_text = text.encode("ascii", "replace").decode("ascii")
    return ascii_text.translate(str.maketrans("()", "[]"))
