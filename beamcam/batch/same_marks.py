"""Marks that two parts of one order have, though they differ."""

from collections.abc import Iterator, Sequence

from beamcam.batch.rules import OTHER_CONTENT
from beamcam.errors import Diagnostic
from beamcam.model.part import Part
from beamcam.model.part_json import part_to_json

#: Keys that say where a part, or something of it, comes from or is listed.
_NO_CONTENT = frozenset({
    "source", "line", "feature", "quantity", "guid", "order", "drawing", "phase", "notes", "info",
    "comments", "file",
})  # fmt: skip

MarkKey = tuple[str, str, str]  #: order, phase and mark


def mark_key(part: Part) -> MarkKey:
    """What stands for one part: its mark, within its order and a phase of it."""
    return part.order, part.phase, part.mark


def other_content(parts: Sequence[Part]) -> Iterator[Diagnostic]:
    """An error for each part whose mark another part of its order has with another content.

    Two that differ under one mark would be mixed up on the floor.
    """
    first: dict[MarkKey, Part] = {}
    for part in parts:
        known = first.setdefault(mark_key(part), part) if part.mark else part
        if known is not part and _content(known) != _content(part):
            where = f" in order {part.order}" if part.order else ""
            yield OTHER_CONTENT.at(part.source, found=part.mark, where=where, other=known.source)


def _content(part: Part) -> object:
    """Content of a part, without its source."""
    return _content_of(part_to_json(part))


def _content_of(value: object) -> object:
    if isinstance(value, dict):
        return {key: _content_of(v) for key, v in value.items() if key not in _NO_CONTENT}
    if isinstance(value, list | tuple):
        return [_content_of(item) for item in value]
    return value
