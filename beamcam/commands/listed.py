"""The parts of files and folders as lists and labels take them, each with its quantity."""

from collections.abc import Callable, Mapping, Sequence
from itertools import compress
from typing import Any

from beamcam.batch.find import FoundInputs, find_inputs
from beamcam.batch.names import other_content
from beamcam.budget import refused_pieces
from beamcam.commands.common import Voice, read_all
from beamcam.commands.parts import member_choice
from beamcam.commands.rules import MISSING_EXTRA
from beamcam.commands.settings import machines_of_stock, with_thickness
from beamcam.commands.sheets import drawing_choice
from beamcam.config.values import Config, Stock
from beamcam.errors import BeamcamError, Diagnostic, ReadError, Source
from beamcam.machine.machine import Machine
from beamcam.model.description import marked
from beamcam.model.part import Part
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
