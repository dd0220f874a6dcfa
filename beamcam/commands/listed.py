"""The parts of files and folders as lists and labels take them, each with its quantity."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import compress
from typing import Any

from beamcam.batch.find import FoundInputs, find_inputs
from beamcam.budget import refused_pieces
from beamcam.commands.common import Voice, read_all
from beamcam.commands.members import member_choice
from beamcam.commands.rules import MISSING_EXTRA, OTHER_CONTENT
from beamcam.commands.sheets import drawing_choice
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, Diagnostic, ReadError, Source
from beamcam.model.part import Part
from beamcam.model.part_json import part_to_json
from beamcam.pipeline import counted, sound
from beamcam.planning.jobs import number_of
from beamcam.report.part_list import PartCount


def counted_parts(
    names: Sequence[str], config: Config, asked: Mapping[str, Any], voice: Voice
) -> tuple[tuple[PartCount, ...], tuple[Diagnostic, ...]]:
    """The parts in order with their quantities, and everything that was said of their files.

    The quantities are those of the files where the job does not say. A part that an error is said
    of is left out, as are files that hold none and parts of which there are too many.
    """
    found: FoundInputs = find_inputs(names)
    said: list[Diagnostic] = [*found.diagnostics]
    parts: list[Part] = []
    how = drawing_choice(asked) | member_choice(asked, kernel=False)
    for reading in read_all((i.path for i in found.inputs), config.strict, how, voice):
        said += reading.diagnostics
        parts += counted(sound(reading))
    said += other_content(parts)
    counts = [PartCount(part, number_of(part, config.quantity)) for part in parts]
    refused = list(refused_pieces((one.part.source, one.quantity) for one in counts))
    said += [one for one in refused if one is not None]
    return tuple(compress(counts, (one is None for one in refused))), tuple(said)


def other_content(parts: Sequence[Part]) -> Iterator[Diagnostic]:
    """An error for each part whose mark another part of a file has with another content.

    A mark stands for one part: two that differ would be mixed up on the floor.
    """
    first: dict[str, Part] = {}
    for part in parts:
        known = first.setdefault(part.mark, part) if part.mark else part
        if known is not part and _content(known) != _content(part):
            yield OTHER_CONTENT.at(part.source, found=part.mark, other=known.source)


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


def refuse_missing(error: ImportError, extra: str) -> BeamcamError:
    """The message where a library of an extra is not installed."""
    said = MISSING_EXTRA.at(Source("beamcam"), found=error.name or str(error), extra=extra)
    return ReadError((said,))
