"""The members of a building model, a line each."""

from collections.abc import Iterable, Iterator

from beamcam.errors import Diagnostic, Severity
from beamcam.model.part import Part
from beamcam.report.part_table import Row, aligned

HEAD: Row = ("mark", "profile", "length", "holes", "slots", "guid", "verdict")


def member_table(parts: Iterable[Part], diagnostics: Iterable[Diagnostic]) -> Iterator[str]:
    """The members that were read, then those that were refused with the code of the reason."""
    warned = {d.source.where for d in diagnostics if d.severity is Severity.WARNING}
    rows = [
        (
            part.mark, part.profile.name, f"{part.length:.1f}", str(sum(1 for _ in part.holes)),
            str(sum(1 for _ in part.slots)), part.guid or "",
            "read, see warning" if part.guid in warned else "read",
        )
        for part in parts
    ]  # fmt: skip
    rows += [
        ("", "", "", "", "", d.source.where, f"refused: {d.code}")
        for d in diagnostics
        if d.severity is Severity.ERROR and d.source.where is not None
    ]
    yield from aligned([HEAD, *rows], "  ")
