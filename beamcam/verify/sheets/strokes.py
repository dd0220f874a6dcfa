"""What the head does between a start of its tool and the end: the strokes of a program.

The words that start and stop a tool are the machine's own, filled with the figures of a row; a
program that says anything else, or moves as it should not, is told.
"""

from collections.abc import Callable, Iterable, Sequence

from msgspec import Struct, field

from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine, Torch, TorchProcess, TorchRow
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.ability import expected_feed, told_limits
from beamcam.verify.sheets.events import Event, Keep, Leg, Pause, Ramp, Side, Switch

ENDS = (2, 30)
FEED_SLACK = 1e-3
LOWERED_SLACK = 5e-3  #: of a feed that follows from a curve whose numbers are rounded


class Stroke(Struct):
    """One way of the head with its tool on."""

    line: int
    row: TorchRow
    side: Side
    radius: float  #: that the controller keeps off the path
    legs: list[Leg] = field(default_factory=list)

    @property
    def process(self) -> TorchProcess:
        return self.row.process


class _Words(Struct, frozen=True):
    """The M words of one row: what starts its tool and what stops it."""

    row: TorchRow
    on: tuple[Switch, ...]
    off: tuple[Switch, ...]
    pierce_s: float


def strokes_of(
    events: Sequence[Event],
    machine: Machine,
    torch: Torch,
    rows: Iterable[TorchRow],
    parse: Callable[[str], list[Event]],
    name: str,
) -> tuple[list[Stroke], list[Diagnostic]]:
    """The strokes of a program whose sheet is worked with `rows`, and what is wrong between them.

    `parse` gives the events of a few blocks.
    """
    known = [_words_of(row, machine, parse) for row in rows]
    said: list[Diagnostic] = []
    strokes: list[Stroke] = []
    current: Stroke | None = None
    words: _Words | None = None
    pause = 0.0
    side: Side = "on"
    radius = 0.0
    slack = machine.format.resolution / 2
    last = 0

    limits = told_limits(machine)
    ramps: dict[bool, float] = {}

    def wrong_ramp(line: int, found: str, expected: str) -> None:
        said.append(rules.RAMP.at(Source(name, line), found=found, expected=expected))

    def wrong(line: int, found: str, expected: str) -> None:
        said.append(rules.TOOL.at(Source(name, line), found=found, expected=expected))

    for event in events:
        last = event.line
        if type(event) is Leg:
            x, y = event.end
            if not (-slack <= x <= torch.length + slack and -slack <= y <= torch.width + slack):
                said.append(
                    rules.AREA.at(
                        Source(name, event.line), x=f"{x:g}", y=f"{y:g}",
                        length=f"{torch.length:g}", width=f"{torch.width:g}",
                    )
                )  # fmt: skip
            if current is None or words is None:
                if not event.rapid:
                    said.append(rules.IDLE.at(Source(name, event.line), x=f"{x:g}", y=f"{y:g}"))
                continue
            if event.rapid:
                said.append(rules.RAPID.at(Source(name, event.line), x=f"{x:g}", y=f"{y:g}"))
                continue
            if not current.legs and abs(pause - words.pierce_s) > 1e-6:
                wrong(event.line, f"a pause of {pause:g} s", f"{words.pierce_s:g} s to pierce")
            feed = words.row.feed_mm_min
            if limits is not None:
                if not (ramps.keys() >= {False, True}):
                    expected = f"{limits.along_mm_s2:g} mm/s2 to run up and to brake"
                    wrong_ramp(event.line, "no E word before the first move", expected)
                    ramps = {False: 0.0, True: 0.0}  # said once
                feed = expected_feed(event, feed, limits)
            slower = feed < words.row.feed_mm_min
            if abs(event.feed_mm_min - feed) > (LOWERED_SLACK if slower else FEED_SLACK) * feed:
                said.append(
                    rules.FEED.at(
                        Source(name, event.line), found=f"{event.feed_mm_min:g}",
                        process=words.row.process, expected=f"{feed:g}",
                    )
                )  # fmt: skip
            current.legs.append(event)
        elif type(event) is Switch:
            if event.number in ENDS:
                if current is not None:
                    source = Source(name, event.line)
                    said.append(rules.END.at(source, found="the end with the tool on"))
                    current = None
                continue
            starts = next((w for w in known if _same(w.on, event)), None)
            if words is not None and current is not None and _same(words.off, event):
                current = None
            elif starts is not None and current is None:
                words, pause = starts, 0.0
                current = Stroke(event.line, starts.row, side, radius)
                strokes.append(current)
            elif any(_same(w.off, event) for w in known):
                if current is not None:
                    wrong(event.line, str(event), "the word that stops the tool that is on")
            else:
                expected = " or ".join(dict.fromkeys(str(s) for w in known for s in w.on))
                wrong(event.line, str(event), f"{expected} on this sheet, the other tool off")
        elif type(event) is Ramp:
            ramps[event.braking] = event.mm_s2
            allowed = limits.along_mm_s2 if limits is not None else 0.0
            if abs(event.mm_s2 - allowed) > FEED_SLACK * allowed:
                expected = f"{allowed:g} mm/s2" if allowed else "none, the machine has no limit"
                what = "to brake" if event.braking else "to run up"
                wrong_ramp(event.line, f"{event.mm_s2:g} mm/s2 {what}", expected)
        elif type(event) is Pause:
            pause += event.seconds
        elif type(event) is Keep:
            if current is not None:
                wrong(event.line, "compensation with the tool on", "it before")
            side, radius = event.side, event.radius
    if current is not None:
        said.append(rules.END.at(Source(name, last), found="the end with the tool on"))
    for stroke in strokes:
        if not stroke.legs:
            wrong(stroke.line, "a tool that is started and not moved", "a contour")
    return [s for s in strokes if s.legs], said


def _same(words: tuple[Switch, ...], event: Switch) -> bool:
    return any(w.number == event.number and w.words == event.words for w in words)


def _words_of(row: TorchRow, machine: Machine, parse: Callable[[str], list[Event]]) -> _Words:
    """The words of a row, read from the machine's templates by the controller's own rules."""

    def events(template: tuple[str, ...]) -> list[Event]:
        lines = [
            line.format(power=f"{row.power:.6f}", pierce=f"{row.pierce_s:.6f}", feed="1")
            for line in template
        ]
        return parse("\n".join(lines))

    on = events(getattr(machine.words, f"{row.process}_on"))
    off = events(getattr(machine.words, f"{row.process}_off"))
    return _Words(
        row,
        tuple(e for e in on if isinstance(e, Switch)),
        tuple(e for e in off if isinstance(e, Switch)),
        sum(e.seconds for e in on if isinstance(e, Pause)),
    )
