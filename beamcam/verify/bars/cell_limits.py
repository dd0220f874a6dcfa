"""What a machine's file says about its cell, whatever program runs there."""

import re
from collections.abc import Iterator
from math import inf

from msgspec import Struct

from beamcam.caches import PerObject
from beamcam.machine.machine import Machine
from beamcam.verify.bars.stations import limits_of

EPSILON = 1e-6
_DWELL = re.compile(r"(?<![A-Z])G(?:0*4|82)(?![0-9.])")


class CellLimits(Struct, frozen=True):
    """What the machine's file says about its cell whatever the program is."""

    max_pecks: dict[float, float]  #: how deep a drill of each size may be fed at once
    stop: tuple[str, float, float]  #: name, minimum and maximum of the axis along the bar
    never_back: bool  #: whether the bar only goes on
    step: float  #: of written lengths, with some rounding
    per_minute: float  #: makes mm/min of a feed in a template's unit
    tools: dict[str, tuple[float, ...]]  #: the sizes of each kind that the shop has
    dwells: bool  #: whether a word of its own dwells


def _limits(machine: Machine) -> CellLimits:
    form, layout = machine.format, machine.layout
    return CellLimits(
        _max_pecks(machine),
        limits_of(machine, "X"),
        layout is not None and layout.order == "saw-drill",
        form.resolution + EPSILON,
        60.0 if form.feed_unit == "mm/s" else 1.0,
        {
            kind: tuple(sorted({d for t in machine.tools if t.kind == kind for d in t.sizes}))
            for kind in {tools.kind for tools in machine.tools}
        },
        "drill-cycle-dwell" in machine.codes.values()
        or any(_DWELL.search(t) for t in _lines(machine)),
    )


def _lines(machine: Machine) -> Iterator[str]:
    """The lines of all templates of work."""
    for name in machine.words.__struct_fields__:
        template = getattr(machine.words, name)
        yield from template if isinstance(template, tuple) else ()


limits_of_cell = PerObject("verify.cells", _limits)


def _max_pecks(machine: Machine) -> dict[float, float]:
    """How deep a drill of each size may be fed at once, where its size has a limit."""
    found: dict[float, float] = {}
    for tools in machine.tools:
        if tools.kind == "drill":
            for size in tools.sizes:
                found[size] = max(found.get(size, 0.0), tools.max_peck or inf)
    return {size: peck for size, peck in found.items() if peck < inf}
