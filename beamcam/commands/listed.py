"""The parts of files and folders as lists and labels take them, each with its quantity."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import compress
from typing import Any

from beamcam.batch.find import FoundInputs, find_inputs
from beamcam.budget import refused_pieces
from beamcam.commands.common import Voice, read_all
from beamcam.commands.members import member_choice
from beamcam.commands.rules import MISSING_EXTRA, OTHER_CONTENT
from beamcam.commands.settings import machines_of_stock, with_thickness
from beamcam.commands.sheets import drawing_choice
from beamcam.config.values import Config, Stock
from beamcam.errors import BeamcamError, Diagnostic, ReadError, Source
from beamcam.machine.machine import Machine
from beamcam.model.description import marked
from beamcam.model.part import Part
from beamcam.model.part_json import part_to_json
from beamcam.pipeline import counted, sound, stock_of
from beamcam.planning.jobs import number_of
from beamcam.report.part_list import PartCount


def counted_parts(
    names: Sequence[str], config: Config, asked: Mapping[str, Any], voice: Voice
) -> tuple[tuple[PartCount, ...], tuple[Diagnostic, ...]]:
    """The parts in order with their quantities, and everything that was said of their files.

    The quantities are those of the files where the job does not say. A part that an error is said
    of is left out, as are files that hold none and parts of which there are too many. Raises
    ReadError for two parts that differ under one mark of an order: nothing is listed then.
    """
    found: FoundInputs = find_inputs(names)
    said: list[Diagnostic] = [*found.diagnostics]
    parts: list[Part] = []
    how = drawing_choice(asked, config.map) | member_choice(asked, kernel=False)
    for reading in read_all((i.path for i in found.inputs), config.strict, how, voice):
        reading = with_thickness(reading, config)
        said += reading.diagnostics
        parts += marked(counted(sound(reading)), asked["mark_from"])
    if mixed := tuple(other_content(parts)):
        raise ReadError((*said, *mixed))
    counts = [PartCount(part, number_of(part, config.quantity)) for part in parts]
    refused = list(refused_pieces((one.part.source, one.quantity) for one in counts))
    said += [one for one in refused if one is not None]
    return tuple(compress(counts, (one is None for one in refused))), tuple(said)


def other_content(parts: Sequence[Part]) -> Iterator[Diagnostic]:
    """An error for each part whose mark another part of its order has with another content.

    A mark stands for one part of an order, and of a phase of it: two that differ would be mixed up
    on the floor.
    """
    first: dict[tuple[str, str, str], Part] = {}
    for part in parts:
        key = part.order, part.phase, part.mark
        known = first.setdefault(key, part) if part.mark else part
        if known is not part and _content(known) != _content(part):
            where = f" in order {part.order}" if part.order else ""
            yield OTHER_CONTENT.at(part.source, found=part.mark, where=where, other=known.source)


def _content(part: Part) -> object:
    """Content of a part, without its source."""
    return _content_of(part_to_json(part))


#: Keys that say where a part, or something of it, comes from or is listed.
_NO_CONTENT = frozenset({
    "source", "line", "feature", "quantity", "guid", "order", "drawing", "phase", "notes", "info",
    "comments", "file",
})  # fmt: skip


def _content_of(value: object) -> object:
    if isinstance(value, dict):
        return {key: _content_of(v) for key, v in value.items() if key not in _NO_CONTENT}
    if isinstance(value, list | tuple):
        return [_content_of(item) for item in value]
    return value


def machines_in_shop(config: Config, name: str) -> Callable[[Part], Sequence[Machine]]:
    """The machines that may make a part, as a batch whose programs are called `name` tries them."""
    of_stock: dict[Stock, Sequence[Machine]] = {}

    def machines_for(part: Part) -> Sequence[Machine]:
        stock = stock_of((part,))
        if stock not in of_stock:
            of_stock[stock] = machines_of_stock(config, stock, name, is_one_of_two=True)
        return of_stock[stock]

    return machines_for


def refuse_missing(error: ImportError, extra: str) -> BeamcamError:
    """The message where a library of an extra is not installed."""
    said = MISSING_EXTRA.at(Source("beamcam"), found=error.name or str(error), extra=extra)
    return ReadError((said,))
