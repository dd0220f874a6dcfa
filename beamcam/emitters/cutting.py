"""Programs of cutting tables: the machine's word templates, filled in."""

from collections.abc import Iterator, Mapping
from itertools import chain
from string import Formatter
from typing import Any

import numpy as np
from msgspec.structs import astuple
from numpy.typing import NDArray

from beamcam.caches import cached
from beamcam.emitters.gcode import comment_room, number, numbered
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow
from beamcam.model.description import PART_DATA
from beamcam.model.program import (
    ArcFeed,
    ChooseMaterial,
    ChooseTool,
    CloseCut,
    Command,
    Comment,
    Compensate,
    EllipseFeed,
    Feed,
    OfPart,
    ParabolaFeed,
    Power,
    Program,
    SetFeed,
    StartSheet,
    ToolOff,
    ToolOn,
    Traverse,
)
from beamcam.plain_text import comment_text, outside_text

SECONDS_PER_MINUTE = 60
RATIO_DECIMALS = 6
FEED = "\1"  #: placeholder for the feed, filled in when it is known
BETWEEN = "\2"  #: separator of the blocks of one move

Row = Traverse | Feed | ArcFeed


def emit(program: Program, machine: Machine) -> str:
    """The text of a program, with a newline at its end."""
    text = "\n".join(_Writer(program, machine).blocks()) + "\n"
    return numbered(text) if machine.format.number_blocks else text


class _Writer:
    """The blocks of a program, and what has been said of those words that go on."""

    def __init__(self, program: Program, machine: Machine) -> None:
        self._program, self._words, self._form = program, machine.words, machine.format
        per_minute = machine.format.feed_unit != "mm/s"
        self._per_unit = 1 if per_minute else SECONDS_PER_MINUTE
        self._acceleration = number(machine.torch.acceleration if machine.torch else 0.0, 3)
        self._room = comment_room(machine)
        self._dwells = 1000 if machine.format.dwell_unit == "ms" else 1  #: a second of G4
        torch = machine.torch
        self._of_torch = {
            "clearance": number(torch.clearance if torch else 0.0, 3),
            "touch_height": number(torch.touch_height if torch else 0.0, 3),
        }
        self._feed = "0"
        self._row_feed, self._slow = 0.0, False  #: of the row, and whether the tool is slower
        self._carried: tuple[str, ...] = ()  #: words of `modal` as they were written last
        self._next_words: tuple[str, ...] = ()
        self._of_part = _texts(program.about)

    def blocks(self) -> list[str]:
        """All of them; what stands for one command may be several, with newlines between."""
        blocks: list[str] = []
        traverses, feeds, clockwise, others = self._plain_moves()
        for command in self._program.commands:
            kind = type(command)
            if kind is Feed:
                blocks.append(self._move(next(feeds)))
            elif isinstance(command, ArcFeed):
                blocks.append(self._move(next(clockwise if command.clockwise else others)))
            elif kind is Traverse:
                blocks.append(next(traverses))
            else:
                blocks += self._other(command)
        return [*blocks, *self._words.footer]

    def _plain_moves(self) -> list[Iterator[str]]:
        """The blocks of all traverses, lines and arcs (clockwise, the others), kind by kind."""
        words = self._words
        moves: dict[type, list[Any]] = {Traverse: [], Feed: [], ArcFeed: []}
        for command in self._program.commands:
            if (own := moves.get(type(command))) is not None:
                own.append(command)
        arcs: list[ArcFeed] = moves[ArcFeed]
        kinds: list[tuple[tuple[str, ...], str, list[Row]]] = [
            (words.traverse, "xy", moves[Traverse]),
            (words.feed, "xy", moves[Feed]),
            (words.arc_cw, "xyijc", [c for c in arcs if c.clockwise]),
            (words.arc_ccw, "xyijc", [c for c in arcs if not c.clockwise]),
        ]
        blocks = []
        for template, names, rows in kinds:
            numbers = chain.from_iterable(map(astuple, rows))
            table = np.fromiter(numbers, dtype=np.float64, count=len(rows) * len(names))
            columns = dict(zip(names, table.reshape(-1, len(names)).T, strict=True))
            text = BETWEEN.join(template).replace("{feed}", FEED)
            formatted = lines(text, columns, self._form.length_decimals).split("\n")
            if len(template) > 1:
                formatted = [record.replace(BETWEEN, "\n") for record in formatted]
            blocks.append(iter(formatted))
        return blocks

    def _move(self, block: str) -> str:
        """The block of a move, with the feed and the words that are new."""
        if FEED in block:
            block = block.replace(FEED, self._feed)
        if self._next_words is not self._carried:
            new = [word for word in self._next_words if word not in self._carried]
            block = " ".join((block, *new))
            self._carried = self._next_words
        return block

    def _want(self, feed_mm_min: float) -> None:
        """The feed of the next move, and what that one has to have said."""
        self._feed = number(feed_mm_min / self._per_unit, 3)
        values = {"feed": self._feed, "acceleration": self._acceleration}
        words = tuple(word.format_map(values) for word in self._words.modal)
        self._next_words = self._carried if words == self._carried else words

    def _other(self, command: Command) -> list[str]:
        words = self._words
        match command:
            case ToolOn():
                self._carried = ()  # written again for every contour, where operators may start
                self._want(command.feed_mm_min)
                self._row_feed = command.feed_mm_min
                return _filled(
                    getattr(words, f"{command.process}_on"), feed=self._feed,
                    **self._of_row(command), **self._of_torch, **self._of_part,
                )  # fmt: skip
            case SetFeed(feed_mm_min):
                self._want(feed_mm_min)
                if not words.slow or not self._row_feed:
                    return _filled(words.pace, feed=self._feed)
                self._slow = feed_mm_min < self._row_feed
                share = number(100.0 * feed_mm_min / self._row_feed, 3)
                return _filled(
                    words.slow if self._slow else words.full, feed=self._feed, share=share
                )
            case Power(power):
                return _filled(words.power, power=number(power, 3))
            case CloseCut():
                return list(words.close)
            case ToolOff():
                off = getattr(words, f"{command.process}_off")
                full = _filled(words.full, feed=self._feed) if self._slow else []
                self._slow = False
                return [*full, *_filled(off, **self._of_torch, **self._of_part)]
            case ChooseTool(process):
                return list(getattr(words, f"choose_{process}"))
            case ChooseMaterial(row):
                return _filled(
                    words.material, feed=number(row.feed_mm_min / self._per_unit, 3),
                    kerf=number(row.kerf, 4), thickness=number(command.thickness, 3),
                    material_name=comment_text(row.material), nozzle=comment_text(row.nozzle),
                    **self._of_row(row),
                )  # fmt: skip
            case ParabolaFeed() | EllipseFeed():
                return [self._move("\n".join(self._curve(command)))]
            case Compensate():
                template = {"left": words.left, "right": words.right, "on": words.straight}
                return _filled(
                    template[command.side],
                    kerf=number(command.kerf, 4), half_kerf=number(command.kerf / 2, 4),
                )  # fmt: skip
            case Comment():
                text = comment_text(command.text)[: self._room]
                return [words.comment.format(text=text)]
            case StartSheet():
                job = outside_text(self._program.job)[: self._room]
                return _filled(words.header, job=job, **self._of_part)
            case OfPart():
                self._of_part = _texts({**self._program.about, **command.about})
        return []

    def _of_row(self, of: ToolOn | TorchRow) -> dict[str, str]:
        """The figures of a row that words of the torch may carry, but its feed."""
        return {
            "power": number(of.power, 3), "number": str(of.number),
            "pierce": number(of.pierce_s * self._dwells, 3),
            "preheat": number(of.preheat_s * self._dwells, 3),
            "pierce_height": number(of.pierce_height, 3), "cut_height": number(of.cut_height, 3),
            "amps": number(of.amps, 3), "volts": number(of.volts, 3),
        }  # fmt: skip

    def _curve(self, command: ParabolaFeed | EllipseFeed) -> list[str]:
        words, form = self._words, self._form
        values = {name: number(getattr(command, name), form.length_decimals) for name in "xyij"}
        if isinstance(command, ParabolaFeed):
            return _filled(words.parabola, feed=self._feed, **values)
        return _filled(
            words.ellipse_cw if command.clockwise else words.ellipse_ccw, feed=self._feed,
            angle=number(command.angle, form.angle_decimals),
            ratio=number(command.ratio, RATIO_DECIMALS), **values,
        )  # fmt: skip


def _texts(about: Mapping[str, str]) -> dict[str, str]:
    """What is known of a part, and nothing for what is not."""
    known = {name: outside_text(text) for name, text in about.items()}
    return {**dict.fromkeys(PART_DATA, ""), **known}


def _filled(template: tuple[str, ...], **values: str) -> list[str]:
    return [line.format_map(values) for line in template]


# --- numbers in bulk ------------------------------------------------------------------------------

# Lines of a program from arrays.
#
#     "G1 X{x} Y{y}", x and y    ->    G1 X123.456 Y-78.9
#
# Each line is a record of fixed width, filled from tables of all groups of four digits. What a
# number does not need of its field is a zero byte, and all of those are taken out at the end.


Groups = NDArray[np.void]

GROUP = 10_000  #: of four digits
MOST_DECIMALS = 4  #: more are formatted one by one, and so are wholes of more than two groups
#: Beyond this share of a step beside the middle of two the nearest one is sure.
DOUBT = 1e-6

_PLACES = np.arange(GROUP)[:, None] // (1000, 100, 10, 1)
_TEXTS = (_PLACES % 10 + ord("0")).astype(np.uint8)
#: Without zeros before the first digit: none at all for 0, or, in the last group, one.
_SHOWN = np.where(_PLACES > 0, _TEXTS, 0).astype(np.uint8)
DIGITS, _HEAD = (texts.view("V4").reshape(-1) for texts in (_TEXTS, _SHOWN))
_LAST: Groups = np.concatenate((np.frombuffer(b"\0\0\0" + b"0", dtype="V4"), _HEAD[1:]))
_SIGNS: Groups = np.frombuffer(b"\0-", dtype="V1")


def lines(template: str, columns: Mapping[str, Floats], decimals: int) -> str:
    """A line for each row of the columns, with a newline at its end.

    Numbers have at most `decimals` places, as `emitters.number` writes them. `template` has
    a name in braces for each column that it shows; it holds no zero byte.
    """
    parts: list[tuple[str, bytes | Groups]] = []
    for text, name, _, _ in Formatter().parse(template + "\n"):
        if text:
            parts.append((f"V{len(text.encode())}", text.encode()))
        if name is not None:
            parts += [(f.dtype.str, f) for f in _fields(columns[name], decimals)]
    count = len(next(iter(columns.values())))
    record: Any = [(f"f{k}", kind) for k, (kind, _) in enumerate(parts)]
    rows = np.empty(count, dtype=record)
    for k, (kind, part) in enumerate(parts):
        rows[f"f{k}"] = np.frombuffer(part, dtype=kind)[0] if isinstance(part, bytes) else part
    return rows.tobytes().translate(None, b"\0").decode()


def _fields(values: Floats, decimals: int) -> list[Groups]:
    """Numbers as columns of bytes that are put side by side."""
    steps = _steps(values, decimals) if decimals <= MOST_DECIMALS else None
    if steps is None:
        texts = [number(value, decimals).encode() for value in values.tolist()]
        longest = max(map(len, texts), default=1)
        return [np.array(texts, dtype=f"S{longest}").view(f"V{longest}")]
    size = np.abs(steps)
    whole = size // 10**decimals
    fields = [_SIGNS.take(steps < 0)]
    high = whole // GROUP
    if high.any():
        low = whole - high * GROUP
        last = np.where(high > 0, DIGITS.take(low), _LAST.take(low))
        fields += [_HEAD.take(high), last]
    else:
        fields.append(_LAST.take(whole))
    if decimals:
        fields.append(_places(decimals).take(size - whole * 10**decimals))
    return fields


def _steps(values: Floats, decimals: int) -> Counts | None:
    """Numbers in steps of their last place, rounded as Python does; None if one is too large."""
    scaled = values * 10.0**decimals
    largest = float(np.abs(scaled).max(initial=0.0))
    if not largest < GROUP * GROUP * 10**decimals - 1:
        return None
    steps: Counts = np.rint(scaled).astype(np.int64)
    middle = np.abs(scaled - np.floor(scaled) - 0.5) < DOUBT
    for k in np.flatnonzero(middle).tolist():
        steps[k] = int(f"{values[k]:.{decimals}f}".replace(".", ""))
    return steps


@cached("numbers.places")
def _places(decimals: int) -> Groups:
    """The point and the places behind it, without zeros at the end; nothing for 0."""
    texts = [f".{k:0{decimals}d}".rstrip("0") for k in range(10**decimals)]
    texts[0] = ""
    width = decimals + 1
    return np.frombuffer(b"".join(t.encode().ljust(width, b"\0") for t in texts), dtype=f"V{width}")
