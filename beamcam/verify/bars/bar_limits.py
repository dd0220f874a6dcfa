"""What the machine can hold of a bar: its size, both its ends, and the parts that come off it.

| front trim |# part 1 ####|kerf|# part 2 ####|kerf|   remnant   | end trim | dead zone |
bar x 0                                            last cut ends                     length
"""

from collections.abc import Iterator, Sequence
from math import inf

from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Layout, Machine
from beamcam.machine.saw import Saw
from beamcam.model.part import Part
from beamcam.verify import bar_rules as rules
from beamcam.verify.bars.layout import LaidPart

EPSILON = 1e-6


def bar_faults(
    laid: Sequence[LaidPart], machine: Machine, saw: Saw, bar: float | None, name: str
) -> Iterator[Diagnostic]:
    """What of the parts on a bar the machine cannot hold, and the bar needed where it is unknown.

    `bar` is the length of the bar. On a line without a saw the part is the bar.
    """
    layout = machine.layout
    if layout is None or not laid:
        return
    if machine.saw is None:
        yield from _size_faults(laid[0].part.length, layout.min_bar, layout, EPSILON, name)
        return
    # Places of parts are worked out from figures that are rounded.
    slack = machine.format.resolution + EPSILON
    yield from _short_parts([one.part for one in laid], layout)
    first = min(laid, key=lambda one: one.start)
    if first.start < layout.front_trim - slack:
        yield rules.BAR_START.at(
            Source(name), mark=first.part.mark, found=f"{first.start:.3f}",
            expected=f"{layout.front_trim:g}",
        )  # fmt: skip
    trim = layout.end_trim + layout.dead_zone
    ends = max(one.start + one.part.length + one.ends[1].kerf(saw) for one in laid)
    if bar is None:
        yield from _size_faults(ends + trim, 0.0, layout, slack, name)
        if trim:
            yield rules.BAR_NEEDED.at(Source(name), found=f"{ends + trim:.3f}", trim=f"{trim:g}")
        return
    yield from _size_faults(bar, layout.min_bar, layout, EPSILON, name)
    if ends > bar - trim + slack:
        yield rules.BAR_END.at(
            Source(name), found=f"{ends:.3f}", expected=f"{bar - trim:.3f}", trim=f"{trim:g}"
        )
    last = max(laid, key=lambda one: one.start)
    if bar - last.start < layout.min_bar_left - slack:
        yield rules.BAR_LEFT.at(
            Source(name), found=f"{bar - last.start:.3f}", mark=last.part.mark,
            expected=f"{layout.min_bar_left:g}",
        )  # fmt: skip


def _short_parts(parts: Sequence[Part], layout: Layout) -> Iterator[Diagnostic]:
    """Parts that the machine cannot hand out, each once."""
    for part in {id(one): one for one in parts}.values():
        if part.length < layout.min_part - EPSILON:
            yield rules.PART_SHORT.at(
                part.source, mark=part.mark, found=f"{part.length:.3f}",
                expected=f"{layout.min_part:g}",
            )  # fmt: skip


def _size_faults(
    bar: float, least: float, layout: Layout, slack: float, name: str
) -> Iterator[Diagnostic]:
    """A bar that is too short or too long for the machine."""
    greatest = inf if layout.max_bar is None else layout.max_bar
    if not least - slack <= bar <= greatest + slack:
        yield rules.BAR_SIZE.at(
            Source(name), found=f"{bar:.3f}", least=f"{layout.min_bar:g}", greatest=f"{greatest:g}"
        )
