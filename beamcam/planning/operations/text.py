"""A text on a face: no line can write one yet."""

from beamcam.errors import Diagnostic
from beamcam.model.part import TextMark
from beamcam.planning.operations.bench import Bench
from beamcam.planning.operations.kind import Kind
from beamcam.planning.operations.mark import can_scribe
from beamcam.planning.rules import MARK, no_unit


def _is_text(feature: object) -> bool:
    return isinstance(feature, TextMark)


def _needs(text: TextMark, bench: Bench) -> Diagnostic | None:
    """The tool that is missing for a text; a scribe alone writes none."""
    why = no_unit("stamp" if can_scribe(text.face, bench) else "scribe")
    return MARK.at(text.source, found=f"the text {text.text!r}", face=text.face, why=why)


TEXT = Kind("text", _is_text, _needs)
