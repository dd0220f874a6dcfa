"""Sources, rules and diagnostics.

A `Rule` is one thing that can be wrong: its stable code, its severity and the text of its
message. `rule.at(source, found=..., expected=...)` gives a `Diagnostic`, which is a value and keeps
those that its message shows: nothing is decided by the message. What cannot be posted raises a
`BeamcamError` that carries its diagnostics.
"""

from collections.abc import Iterable, Iterator
from enum import Enum
from typing import Any

from msgspec import Struct

from beamcam.plain_text import terminal_text


class Severity(Enum):
    """Severity of a diagnostic; an `ERROR` refuses the part."""

    NOTE = "note"
    WARNING = "warning"
    ERROR = "error"


class Source(Struct, frozen=True, gc=False):
    """The place in an input that a feature, an operation or a message comes from."""

    file: str
    line: int | None = None  #: counted from 1; None where the format has no lines
    where: str | None = None  #: DXF handle, IFC GlobalId, SVG element id, TOML key

    def __str__(self) -> str:
        place = [self.file]
        if self.line is not None:
            place.append(str(self.line))
        if self.where is not None:
            place.append(self.where)
        return ":".join(place)


Value = str | int | float  #: what a message shows


class Diagnostic(Struct, frozen=True):
    """A message about a place in an input; `said["found"]` is the value that it shows as found."""

    source: Source
    severity: Severity
    code: str
    message: str  #: for people; what is decided, is decided by the values
    values: tuple[tuple[str, Value], ...] = ()  #: by the names of the rule's template

    def __getitem__(self, name: str) -> Value:
        """A value that the message shows. Raises KeyError if it shows none of that name."""
        return dict(self.values)[name]

    def __str__(self) -> str:
        return terminal_text(f"{self.source}: {self.severity.value} {self.code}: {self.message}")


#: Characters of a value that a message shows; a list of all keys of a machine has 900.
MAX_SHOWN = 1500
#: Messages of one code that are shown one by one.
MAX_OF_A_PROGRAM = 5  #: messages of one code about a program that is followed row by row
MAX_OF_A_KIND = 20


class Rule(Struct, frozen=True):
    """One thing that can be wrong with an input.

    `message` is a `str.format` template whose names are the keywords of `at`.
    """

    code: str  #: stable; scripts build on it
    severity: Severity
    message: str
    reason: str  #: why it matters and what to do, for the list of codes

    def at(self, source: Source, **values: object) -> Diagnostic:
        """The diagnostic for this rule at `source`. Raises KeyError if a value is missing."""
        shown = {
            name: f"{value[:MAX_SHOWN]}... ({len(value) - MAX_SHOWN} more characters)"
            if isinstance(value, str) and len(value) > MAX_SHOWN
            else value
            for name, value in values.items()
        }
        kept = tuple(
            (name, value if isinstance(value, str | int | float) else str(value))
            for name, value in shown.items()
        )
        return Diagnostic(source, self.severity, self.code, self.message.format_map(shown), kept)


#: Characters of a value that a message shows; a list of all keys of a machine has 900.
def first_of_each_kind(diagnostics: Iterable[Diagnostic]) -> Iterator[Diagnostic]:
    """The first `MAX_OF_A_KIND` of each code, and at the end how many more there are of it."""
    counts: dict[str, int] = {}
    for diagnostic in diagnostics:
        counts[diagnostic.code] = counts.get(diagnostic.code, 0) + 1
        if counts[diagnostic.code] <= MAX_OF_A_KIND:
            yield diagnostic
    for code, count in counts.items():
        if count > MAX_OF_A_KIND:
            yield MORE.at(Source("beamcam"), found=count - MAX_OF_A_KIND, code=code, of=count)


def add_few(diagnostics: list[Diagnostic], one: Diagnostic) -> None:
    """Add a message to those of a program, unless `MAX_OF_A_PROGRAM` of its code are there."""
    if sum(d.code == one.code for d in diagnostics) < MAX_OF_A_PROGRAM:
        diagnostics.append(one)


def error(code: str, message: str, reason: str) -> Rule:
    """A rule whose diagnostics refuse the job."""
    return Rule(code, Severity.ERROR, message, reason)


def warning(code: str, message: str, reason: str) -> Rule:
    """A rule whose diagnostics do not stop the job, unless it is strict."""
    return Rule(code, Severity.WARNING, message, reason)


def note(code: str, message: str, reason: str) -> Rule:
    """A rule whose diagnostics are worth knowing and never stop a job."""
    return Rule(code, Severity.NOTE, message, reason)


MORE = note("more-messages",
    "found {found} more messages {code}, {of} in all; `inspect --json` and the report of a batch "
    "hold each",
    "A fault of an exporter often repeats in each line; the first twenty messages show "
    "it.")  # fmt: skip


class BeamcamError(Exception):
    """A job that cannot be posted, with one diagnostic or more that say why."""

    def __init__(self, diagnostics: Diagnostic | Iterable[Diagnostic]) -> None:
        if isinstance(diagnostics, Diagnostic):
            diagnostics = (diagnostics,)
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__("\n".join(map(str, self.diagnostics)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled by its diagnostics; an exception would be by its text."""
        return type(self), (self.diagnostics,)


class ReadError(BeamcamError):
    """An input that cannot be read."""


class MachineError(BeamcamError):
    """A machine file that cannot be used."""


class PlanError(BeamcamError):
    """A part that the machine cannot make."""


class VerifyError(BeamcamError):
    """A program that does not make the part."""


class PictureError(BeamcamError):
    """A picture or a page that cannot be made."""


def errors_in(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Those of `diagnostics` that refuse a part."""
    return tuple(d for d in diagnostics if d.severity is Severity.ERROR)
