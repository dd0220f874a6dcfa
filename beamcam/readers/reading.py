"""The result of every reader."""

from msgspec import Struct

from beamcam.errors import Diagnostic, errors_in
from beamcam.model.part import Part


class Reading(Struct, frozen=True):
    """The parts of one file, as far as they could be read, and remarks on it.

    Where a diagnostic is an error no part may be posted; `parts` then still holds what was read.
    """

    format: str
    parts: tuple[Part, ...]
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def refused(self) -> bool:
        return bool(errors_in(self.diagnostics))
